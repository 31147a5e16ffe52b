//! Errors of a chip as the machine is told of them.

use base::ports::DriverFault;
use tmc::Error;

/// Converts the error of a chip.
pub(crate) fn fault<E>(error: Error<E>) -> DriverFault {
    match error {
        Error::Bus(_) | Error::Absent | Error::NoEcho => DriverFault::Silent,
        Error::WrongAnswer(_) => DriverFault::BadAnswer,
        Error::Reset => DriverFault::Reset,
        Error::Setting(_) => DriverFault::BadSetting,
    }
}
