//! Everything the machine may ask of the world. The board implements these traits with peripherals, the host
//! runner with models and a folder; the machine cannot tell them apart. Each trait is a single thing to ask
//! for, so that code that needs it takes only this trait.
//!
//! Rules for implementers: no method waits for long. Sessions take what fits and say how much; storage
//! answers within its own bounded time or with [`StorageError::NotResponding`]; locks are held for the
//! closure only.

mod board;
mod calendar;
mod drivers;
mod events;
mod inputs;
mod laser;
mod network;
mod rest;
mod storage;
mod updates;
mod usb;
mod viewers;
mod workspace;

use core::ops::DerefMut;

use motion::{Latch, Motion};
use units::Micros;

pub use ::events::DateTime;
pub use board::{
    Board, BoardInfo, LastWords, MemoryReport, PinPort, PinTaken, Start, StepTimes, SupplyVoltages, WiringError,
};
pub use calendar::Calendar;
pub use drivers::{
    ChopperFit, Coil, Description, DriverFault, DriverStatus, ElectricalPhase, MotorDrivers, StallSearch,
};
pub use events::EventLog;
pub use gcode::realtime::Realtime;
pub use inputs::{Input, InputLevels};
pub use laser::LaserPort;
pub use network::{
    AddressOrigin, KEYS_RECORD_BYTES, KeysRecord, NETWORK_NAME_BYTES, Network, NetworkAddress, NetworkLink,
    NetworkNews, NetworkReport, NetworkService, NetworkTraffic, PASSWORD_RECORD_BYTES, PasswordRecord,
};
pub use rest::{Rest, Wake};
pub use storage::{
    CardEvent, CardFacts, DirectoryEntry, FileAttributes, FileFacts, FileHandle, FileTime, FilesPort, FreeSpace,
    LIST_CHUNK, NAME_BYTES, OpenMode, PATH_BYTES, Storage, StorageError,
};
use thermal::HeatControl;
pub use thermal::io::{
    DatedReading, MAX_HEATERS, MAX_SWITCHES, OutputLevels, SensorReading, SensorReadings, heater_bit, switch_bit,
};
pub use updates::{Arrival, FailedBy, Firmware, FirmwareId, Flaw, Running, Updates};
pub use usb::{Disk, NotLent, Usb};
pub use viewers::{Factors, Viewers};
pub use workspace::Workspace;

/// Clock of the machine.
pub trait Clock {
    /// Returns the time since boot.
    fn now(&self) -> Micros;
}

/// Access to the motion of motors.
pub trait MotionPort {
    /// Calls `f` with the planner, locked for that long.
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R;

    /// Returns the latch that input interrupts report to: bit n of its mask is [`Input::bit`] n.
    fn latch(&self) -> &Latch;
}

/// Memory for preflight, the look ahead at files.
pub trait Ahead {
    /// Pointer to the workspace.
    type Workspace: DerefMut<Target = Workspace>;

    /// Gives the workspace away, once. `None`: there is no memory for it.
    fn workspace(&mut self) -> Option<Self::Workspace>;
}

/// Heaters, fans and switched outputs.
pub trait HeatPort {
    /// Calls `f` with heat control, locked for that long.
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R;

    /// Has the heat task run now, not at its next period, so that outputs go off at once.
    fn run_heat_now(&mut self);
}

/// Access to LED strips.
pub trait LightPort {
    /// Sends bytes to a strip, by its place in the configuration's list. False, and nothing happens, while
    /// another transmission is on its way or has not taken effect yet: ask again later.
    fn send_to_strip(&mut self, strip: usize, bytes: &[u8]) -> bool;
}

/// Access to the motor drivers.
pub trait DriversPort {
    /// Type of access to the drivers.
    type Drivers: MotorDrivers;

    /// Calls `f` with the motor drivers' bus, locked for that long (tens of microseconds a datagram).
    fn drivers<R>(&mut self, f: impl FnOnce(&mut Self::Drivers) -> R) -> R;

    /// Switches the global enable line of the motor drivers.
    fn set_motor_power(&mut self, on: bool);
}

/// Access to digital inputs.
pub trait Inputs {
    /// Returns the present logical levels of all inputs (inversion already applied): true is triggered or
    /// pressed.
    fn inputs(&self) -> InputLevels;
}
