//! Events that the watch over drivers and supplies reports.

use events::{Event, Text};
use units::{Actuator, Axis};

use super::DriverTrouble;

/// Event for the executor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SupervisorEvent {
    /// A driver reported trouble twice.
    Driver(Actuator, DriverTrouble),
    /// Motor supply went below [`super::MOTOR_SUPPLY_OFF`].
    MotorSupplyLost,
    /// Motor supply came back; drivers have been initialised again.
    MotorSupplyReturned,
    /// The supply of heaters and fans is below [`super::FET_SUPPLY_OFF`] though its switch is on.
    FetSupplyLost,
    /// The supply of heaters and fans came back.
    FetSupplyReturned,
}

impl SupervisorEvent {
    /// Returns the same event for the ring of events.
    pub(super) fn told(self) -> Event {
        match self {
            Self::Driver(motor, trouble) => {
                let motor = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
                Event::Driver { motor, trouble: Text::from(trouble.text()) }
            }
            Self::MotorSupplyLost => Event::MotorSupply { on: false },
            Self::MotorSupplyReturned => Event::MotorSupply { on: true },
            Self::FetSupplyLost => Event::HeaterSupply { on: false },
            Self::FetSupplyReturned => Event::HeaterSupply { on: true },
        }
    }
}
