//! Everything the machine may ask of the world. The board implements these traits with peripherals, the host runner
//! with models and a folder; the machine cannot tell which.
//!
//! Rules for implementers: no method waits for long. Consoles take what fits and say how much; storage answers within
//! its own bounded time or with [`StorageError::NotResponding`]; locks are held for the closure only.

mod drivers;
mod inbox;
mod io;
mod storage;

use config::MachineConfig;
use motion::{Latch, Motion};
use units::{Micros, Ticks, Volts};

use crate::heat::HeatControl;
use crate::supervisor::Supervisor;
pub use drivers::{DriverFault, DriverStatus, MotorDrivers};
pub use gcode::realtime::Realtime;
pub use inbox::{INBOX_BYTES, Inbox, Received};
pub use io::{
    Input, InputLevels, MAX_HEATERS, MAX_SWITCHES, OutputLevels, SensorReading, SensorReadings, heater_bit, switch_bit,
};
pub use storage::{
    DirectoryEntry, FileAttributes, FileHandle, FileTime, LIST_CHUNK, NAME_BYTES, OpenMode, PATH_BYTES, Storage,
    StorageError,
};

/// Most consoles a board can have: debug UART, two auxiliary UARTs, two USB serial ports, three network sessions.
pub const MAX_CONSOLES: usize = 8;

/// A console, by its number on this board: 0 is the debug UART, which always exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConsoleId(pub u8);

/// Why the board could not be wired as the configuration asks. One line, naming pin or setting.
pub type WiringError = heapless::String<128>;

/// What a board says about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardInfo {
    /// Chip name, for `version`.
    pub mcu: &'static str,
    /// Four strap bits: 0 is the TMC2590 board, 1 the TMC2660 board.
    pub board_id: u8,
    /// Core clock in MHz.
    pub core_mhz: u32,
    /// Firmware version.
    pub version: &'static str,
    /// Build date.
    pub build_date: &'static str,
    /// It starts anew because the watchdog was not fed.
    pub after_watchdog: bool,
    /// The chip is set to start its second core, which nothing tells what to do.
    pub second_core_starts: bool,
}

/// Memory use, for `mem`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryReport {
    /// Statically placed bytes (data and bss).
    pub static_bytes: u32,
    /// Stack bytes never touched since boot, when the board can tell.
    pub stack_unused_bytes: Option<u32>,
}

/// How well the step interrupt kept the times of steps, since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepTimes {
    /// Events played more than 250 ns late.
    pub late: u32,
    /// Late events that had to be delayed further, to more than 10 us: played at once, the motor's driver would have missed a step.
    pub delayed: u32,
    /// The worst lateness.
    pub worst: Ticks,
}

/// The supply voltages the controller decides by; `None` when the reading failed or is not configured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupplyVoltages {
    /// Motor supply, after its divider.
    pub motor: Option<Volts>,
    /// MOSFET (heater) supply, after its divider.
    pub fets: Option<Volts>,
}

/// The world of one machine.
pub trait Ports: Storage {
    /// Driver access type.
    type Drivers: MotorDrivers;

    /// Time since boot.
    fn now(&self) -> Micros;

    /// The planner, locked for the length of `f`.
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R;

    /// The latch that input interrupts report to: bit n of its mask is [`Input::bit`] n.
    fn latch(&self) -> &Latch;

    /// Heaters, fans and switched outputs, locked for the length of `f`.
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R;

    /// The motor drivers' bus, locked for the length of `f` (tens of microseconds a datagram).
    fn drivers<R>(&mut self, f: impl FnOnce(&mut Self::Drivers) -> R) -> R;

    /// Findings of the slow task (driver faults, supply voltages), locked for the length of `f`.
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R;

    /// Binds pins and peripherals as configured. Called once, at the end of boot. Whatever could not be bound is
    /// reported line by line and left inactive; true when everything was bound.
    fn wire(&mut self, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> bool;

    /// How many consoles there are. Ids run from 0.
    fn consoles(&self) -> u8;

    /// Bytes that arrived on a console.
    fn inbox(&self, console: ConsoleId) -> &Inbox;

    /// Sends bytes to a console; returns how many were taken. Takes none while the console's buffer is full. A console
    /// nobody listens to takes everything.
    fn console_write(&mut self, console: ConsoleId, bytes: &[u8]) -> usize;

    /// How many bytes [`Self::console_write`] would take now.
    fn console_room(&mut self, console: ConsoleId) -> usize;

    /// Present logical levels of all inputs (inversion already applied): true is triggered or pressed.
    fn inputs(&self) -> InputLevels;

    /// Sets a hardware PWM switch, by its place in the configuration's switch list. `duty` is 0 to 1.
    fn set_hardware_pwm(&mut self, switch: u8, duty: f32);

    /// Global enable line of the motor drivers.
    fn set_motor_power(&mut self, on: bool);

    /// A named voltage monitor (`vmotor`, `vfet`, `vref`, `vbat` and configured ones); `None` when there is none of that name
    /// or the reading failed.
    fn voltage(&mut self, name: &str) -> Option<Volts>;

    /// Temperature of the chip itself.
    fn chip_celsius(&mut self) -> Option<units::Celsius>;

    /// Board LED `index` (0 to 3).
    fn set_led(&mut self, index: u8, on: bool);

    /// What the board is.
    fn board(&self) -> BoardInfo;

    /// Memory use.
    fn memory(&self) -> MemoryReport;

    /// Whether steps came on time.
    fn step_times(&self) -> StepTimes;

    /// The dispatcher still runs. The watchdog is fed only when all reporters do this.
    fn report_alive(&mut self);

    /// Asks for a reset one second from now, so that replies can leave.
    fn request_reset(&mut self);
}
