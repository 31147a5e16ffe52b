//! Motor drivers in a machinist's terms: current, on or off, faults. Registers stay behind the port.

use units::{Actuator, Amps, Volts};
pub use units::{ChopperFit, Coil};

/// Status that a driver reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverStatus {
    /// Whether the motor stands still.
    pub standstill: bool,
    /// Whether the temperature is above the warning level.
    pub over_temperature_warning: bool,
    /// Whether over temperature has shut the driver down.
    pub over_temperature: bool,
    /// Whether coil A is shorted to ground.
    pub short_a: bool,
    /// Whether coil B is shorted to ground.
    pub short_b: bool,
    /// Whether coil A is shorted to the motor supply, or has far too much current.
    pub supply_short_a: bool,
    /// Whether coil B is shorted to the motor supply, or has far too much current.
    pub supply_short_b: bool,
    /// Whether coil A has no load (only meaningful while turning).
    pub open_a: bool,
    /// Whether coil B has no load (only meaningful while turning).
    pub open_b: bool,
    /// Whether the driver was without power since it was initialised: its settings are lost, and its motor is
    /// off.
    pub reset: bool,
}

/// Position of a driver in the electrical cycle of its motor: four full steps, 1024 places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElectricalPhase {
    /// Place in the sine table, 0 to 1023, which rises with DIR low.
    pub place: u16,
    /// Microsteps per full step that are set.
    pub microsteps: u16,
}

/// Settings of a motor while its stall is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StallSearch {
    /// Peak coil current; none: the present one.
    pub current: Option<Amps>,
    /// Threshold `SGT`: lower is more sensitive; for a driver with stallGuard4 `SGTHRS`: higher is.
    pub threshold: i16,
}

/// Reason why talking to a driver failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverFault {
    /// The actuator has an external driver, or none, or one without this function: nothing to set or read.
    External,
    /// All bits of the answer are equal: nobody drives the bus.
    Silent,
    /// The answer is malformed.
    BadAnswer,
    /// The driver was without power since it was initialised: its settings are lost, and its motor is off.
    Reset,
    /// The chip does not support the setting.
    BadSetting,
}

/// Extent of a driver's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Description {
    /// Status, settings and registers.
    Everything,
    /// Current regulation, in one line.
    Chopper,
}

/// Access to the drivers of all actuators.
pub trait MotorDrivers {
    /// Writes the whole configured register set again, disabled. After power-up and after motor power
    /// returned.
    fn initialise(&mut self, motor: Actuator) -> Result<(), DriverFault>;

    /// Lets current flow, or not. For an external driver this is its enable pin.
    fn set_enabled(&mut self, motor: Actuator, enabled: bool) -> Result<(), DriverFault>;

    /// Sets the peak coil current; returns the nearest that the driver's steps allow.
    fn set_current(&mut self, motor: Actuator, peak: Amps) -> Result<Amps, DriverFault>;

    /// Returns the peak coil current that is set.
    fn current(&self, motor: Actuator) -> Option<Amps>;

    /// Reads the driver's status.
    fn status(&mut self, motor: Actuator) -> Result<DriverStatus, DriverFault>;

    /// Reads the driver's position in the electrical cycle. The rotor is held there, so for this motor and
    /// this place of its axis the reading is always the same, after power was off too.
    fn phase(&mut self, motor: Actuator) -> Result<ElectricalPhase, DriverFault>;

    /// Sets current and load measurement for a search, without filter and coolStep, and keeps the former
    /// settings.
    fn begin_stall_search(&mut self, motor: Actuator, search: StallSearch) -> Result<(), DriverFault>;

    /// Reads the load reserve of the motor: 0 for a stall to 1023 (stallGuard2, or stallGuard4 above its
    /// threshold), as measured with the last full step.
    fn reserve(&mut self, motor: Actuator) -> Result<u16, DriverFault>;

    /// Restores the settings from before a search; nothing without a search.
    fn end_stall_search(&mut self, motor: Actuator) -> Result<(), DriverFault>;

    /// Computes spreadCycle for a coil at this supply and the current that is set, and sets it. Returns none,
    /// and sets nothing, where the supply does not drive that current through the coil.
    fn fit_chopper(&mut self, motor: Actuator, coil: Coil, supply: Volts) -> Result<Option<ChopperFit>, DriverFault>;

    /// Prints what a person debugging the driver wants to know (M911), one line per `\n`.
    fn describe(&mut self, motor: Actuator, what: Description, out: &mut dyn core::fmt::Write) -> core::fmt::Result;

    /// Sets the microsteps per full step (M909): a power of two up to 256. Returns the former number.
    fn set_microsteps(&mut self, motor: Actuator, count: u16) -> Result<u16, DriverFault>;

    /// Sets the speed up to which stealthChop drives the motor, full steps a second; none: never. The motor
    /// stands. [`DriverFault::External`] where there is no stealthChop.
    fn set_stealth_threshold(&mut self, motor: Actuator, full_steps_per_s: Option<f32>) -> Result<(), DriverFault>;

    /// Writes one of the chip's registers, counted from 1 (M911.2, `setregs`).
    fn write_register(&mut self, motor: Actuator, number: u8, value: u32) -> Result<(), DriverFault>;

    /// Sets one group of the chip's settings, by its number and words (M911.3).
    fn set_option(
        &mut self,
        motor: Actuator,
        option: u8,
        word: &dyn Fn(char) -> Option<f64>,
    ) -> Result<(), DriverFault>;
}
