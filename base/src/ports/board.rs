//! Access to the board itself.

use config::{MachineConfig, Pin};
use units::{Celsius, Ticks, Volts};

/// Reason why the board could not be wired as the configuration asks: a line that names pin or setting.
pub type WiringError = heapless::String<128>;

/// Reason why a pin is not available: its user.
pub type PinTaken = heapless::String<80, u8>;

/// Message of a firmware that ends itself.
pub type LastWords = heapless::String<76, u8>;

/// Cause of the firmware's start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// Power came, or somebody asked for a reset.
    Asked,
    /// The watchdog was not fed.
    Watchdog,
    /// The board's own supply had sagged.
    BrownOut,
    /// The firmware ended itself: a panic, a fault of the processor, a clock that stopped.
    Ended(LastWords),
}

/// Description of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardInfo {
    /// Chip name, for `version`.
    pub mcu: &'static str,
    /// Four strap bits: 0 is the TMC2590 board, 1 the TMC2660 board.
    pub board_id: u8,
    /// Core clock in MHz.
    pub core_mhz: u32,
    /// Version of the firmware.
    pub version: &'static str,
    /// Build date of the firmware.
    pub build_date: &'static str,
    /// Cause of the present start.
    pub start: Start,
    /// Whether the chip is set to start its second core, which nothing tells what to do.
    pub second_core_starts: bool,
}

/// Memory use, for `mem`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryReport {
    /// Statically placed bytes (data and bss).
    pub static_bytes: u32,
    /// Bytes of the executor's stack never touched since boot, when the board can tell.
    pub stack_unused_bytes: Option<u32>,
    /// Bytes of the interrupts' stack never touched since boot, when the board can tell.
    pub interrupt_stack_unused_bytes: Option<u32>,
}

/// Punctuality of the step interrupt since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepTimes {
    /// Events played more than 250 ns late.
    pub late: u32,
    /// Late events that had to be delayed further, to more than 10 us: played at once, the motor's driver
    /// would have missed a step.
    pub delayed: u32,
    /// Worst lateness of a step.
    pub worst: Ticks,
}

/// Supply voltages by which the machine decides; `None` when the reading failed or is not configured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupplyVoltages {
    /// Motor supply, after its divider.
    pub motor: Option<Volts>,
    /// MOSFET (heater) supply, after its divider.
    pub fets: Option<Volts>,
}

/// Access to pins that nothing uses, to find out what is wired where.
pub trait PinPort {
    /// Takes a pin, as an input, or as an output with this level; returns its level in the sense of the pin's
    /// `!`.
    ///
    /// # Errors
    /// When the pin is in use: its user.
    fn borrow_pin(&mut self, pin: Pin, drive: Option<bool>) -> Result<bool, PinTaken>;

    /// Gives the pin back, in its state after a reset.
    fn return_pin(&mut self, pin: Pin);
}

/// Access to the board's parts.
pub trait Board {
    /// Binds pins and peripherals as configured. Called once, at the end of boot. A part that could not be
    /// bound is reported line by line and left inactive; true when everything was bound.
    fn wire(&mut self, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> bool;

    /// Reads a named voltage monitor (`vmotor`, `vfet`, `vref`, `vbat` and configured ones); `None` when
    /// there is none of that name or the reading failed.
    fn voltage(&mut self, name: &str) -> Option<Volts>;

    /// Returns the voltage as of the last call, for callers that look every few milliseconds, where a board
    /// reads its voltages in turns.
    fn voltage_now(&mut self, name: &str) -> Option<Volts> {
        self.voltage(name)
    }

    /// Reads the temperature of the chip itself.
    fn chip_celsius(&mut self) -> Option<Celsius>;

    /// Switches board LED `index` (0 to 3).
    fn set_led(&mut self, index: u8, on: bool);

    /// Returns the board's description.
    fn board(&self) -> BoardInfo;

    /// Returns the memory use.
    fn memory(&self) -> MemoryReport;

    /// Returns how punctual steps have been.
    fn step_times(&self) -> StepTimes;

    /// Notes that the executor still runs. The watchdog is fed only when all reporters do this.
    fn report_alive(&mut self);

    /// Stops the core for a debugger. False when none is attached.
    fn stop_for_debugger(&mut self) -> bool;

    /// Asks for a reset one second from now, so that replies can leave.
    fn request_reset(&mut self);
}
