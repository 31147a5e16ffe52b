//! The USB socket.

use config::SystemConfig;

/// What the machine has to do with the computer at its USB socket, beside the sessions that it has there. A
/// board without a socket leaves all of it out.
pub trait Usb {
    /// Shows the board to a computer, as what its settings allow. Once, when the configuration has been read,
    /// whatever has become of it.
    ///
    /// # Errors
    /// The socket does not work: what is wrong, and what to do.
    fn connect(&mut self, _system: &SystemConfig) -> Result<(), &'static str> {
        Ok(())
    }
}
