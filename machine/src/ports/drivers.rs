//! Motor drivers in a machinist's terms: current, on or off, faults. Registers stay behind the port.

use units::{Actuator, Amps, Ohms, Volts};

/// What a driver reports about itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriverStatus {
    /// The motor stands still.
    pub standstill: bool,
    /// Above the warning temperature.
    pub over_temperature_warning: bool,
    /// Shut down by over temperature.
    pub over_temperature: bool,
    /// Short to ground on coil A.
    pub short_a: bool,
    /// Short to ground on coil B.
    pub short_b: bool,
    /// Coil A shorted to the motor supply, or with far too much current.
    pub supply_short_a: bool,
    /// The same of coil B.
    pub supply_short_b: bool,
    /// No load on coil A (only meaningful while turning).
    pub open_a: bool,
    /// No load on coil B (only meaningful while turning).
    pub open_b: bool,
    /// It was without power since it was initialised: its settings are lost, and its motor is off.
    pub reset: bool,
}

/// Where a driver is in the electrical cycle of its motor: four full steps, 1024 places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElectricalPhase {
    /// Its place in the sine table, 0 to 1023. It rises with DIR low.
    pub place: u16,
    /// Microsteps per full step that it is set to.
    pub microsteps: u16,
}

/// How a motor is driven while its stall is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StallSearch {
    /// Peak coil current; none: the present one.
    pub current: Option<Amps>,
    /// `SGT`: lower is more sensitive; of a driver with stallGuard4 `SGTHRS`: higher is.
    pub threshold: i16,
}

/// What a motor's data sheet says of one of its coils.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coil {
    /// Its resistance.
    pub resistance: Ohms,
    /// Its inductance, henry.
    pub henries: f32,
}

/// How a driver regulates the current of a coil, computed, and why so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChopperFit {
    /// Slow decay phase, as the chip counts it.
    pub off_time: u8,
    /// Blanking time, clocks, as it was.
    pub blank_clocks: u8,
    /// Hysteresis to begin with, above its end.
    pub hysteresis_start: u8,
    /// Hysteresis in the end.
    pub hysteresis_end: i8,
    /// What start and end would have to be together.
    pub needed: f32,
    /// Time of a slow decay, s.
    pub off_s: f32,
    /// Blanking time, s.
    pub blank_s: f32,
    /// By how much the current rises while it is not measured.
    pub rise: Amps,
    /// By how much it falls in the two slow decays of a cycle.
    pub fall: Amps,
}

/// Why a driver could not be talked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverFault {
    /// This actuator has an external driver, or none, or one that has no such thing: nothing to set or read.
    External,
    /// All bits of the answer are equal: nobody drives the bus.
    Silent,
    /// The answer is malformed.
    BadAnswer,
    /// It was without power since it was initialised: its settings are lost, and its motor is off.
    Reset,
    /// The chip cannot be set so.
    BadSetting,
}

/// What of a driver is described.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Description {
    /// What it says, what it is told, and its registers.
    Everything,
    /// How it regulates current, in one line.
    Chopper,
}

/// The drivers of all actuators.
pub trait MotorDrivers {
    /// Writes the whole configured register set again, disabled. After power-up and after motor power
    /// returned.
    fn initialise(&mut self, motor: Actuator) -> Result<(), DriverFault>;

    /// Lets current flow, or not. For an external driver this is its enable pin.
    fn set_enabled(&mut self, motor: Actuator, enabled: bool) -> Result<(), DriverFault>;

    /// Sets the peak coil current; returns what the driver's steps allow.
    fn set_current(&mut self, motor: Actuator, peak: Amps) -> Result<Amps, DriverFault>;

    /// The peak coil current that is set.
    fn current(&self, motor: Actuator) -> Option<Amps>;

    /// Reads the status.
    fn status(&mut self, motor: Actuator) -> Result<DriverStatus, DriverFault>;

    /// Reads where it is in the electrical cycle. The rotor is held there, so for this motor and this place
    /// of its axis it is the same whenever it is read, after power was off too.
    fn phase(&mut self, motor: Actuator) -> Result<ElectricalPhase, DriverFault>;

    /// Sets current and load measurement for a search, without filter and coolStep, and keeps what was set
    /// before.
    fn begin_stall_search(&mut self, motor: Actuator, search: StallSearch) -> Result<(), DriverFault>;

    /// Reads how little load the motor has: 0 for a stall to 1023 (stallGuard2, or stallGuard4 above its
    /// threshold), as measured with the last full step.
    fn reserve(&mut self, motor: Actuator) -> Result<u16, DriverFault>;

    /// Sets again what was set before a search; nothing where there was none.
    fn end_stall_search(&mut self, motor: Actuator) -> Result<(), DriverFault>;

    /// Computes spreadCycle for a coil at this supply and the current that is set, and sets it. None where
    /// the supply does not drive that current through the coil; nothing is set then.
    fn fit_chopper(&mut self, motor: Actuator, coil: Coil, supply: Volts) -> Result<Option<ChopperFit>, DriverFault>;

    /// Prints what a person debugging the driver wants to know (M911), one line per `\n`.
    fn describe(&mut self, motor: Actuator, what: Description, out: &mut dyn core::fmt::Write) -> core::fmt::Result;

    /// Sets the microsteps per full step (M909): a power of two up to 256. Returns what they were.
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
