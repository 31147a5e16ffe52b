//! Motors: `[actuator]`, `[tmc2590]`, `[tmc2660]`, `[current control]`, `[extruder]`. External drivers with a
//! register interface are in [`super::stealth_drivers`].

use super::{Name, ToolId};
use crate::pin::Pin;
use units::{Actuator, Amps, Celsius, Micros, Mm, MmPerSecond, MmPerSecond2, Ohms, PerActuator};

/// Kind of stepper driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum DriverKind {
    #[default]
    Tmc2590,
    Tmc2660,
    External,
    Tmc2130,
    Tmc5160,
    Tmc2240,
    Tmc2208,
    Tmc2209,
    Tmc2226,
}

impl DriverKind {
    /// External driver chips that Velvet configures over SPI or UART.
    pub const OUTSIDE: [Self; 6] =
        [Self::Tmc2130, Self::Tmc5160, Self::Tmc2240, Self::Tmc2208, Self::Tmc2209, Self::Tmc2226];

    /// Returns whether the driver chip is on an auxiliary UART.
    #[must_use]
    pub const fn is_on_uart(self) -> bool {
        matches!(self, Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226)
    }

    /// Returns whether the chip is soldered on the board: such a chip steps on every edge of STEP, and the
    /// board supplies its motor voltage. External drivers take pulses.
    #[must_use]
    pub const fn is_on_board(self) -> bool {
        matches!(self, Self::Tmc2590 | Self::Tmc2660)
    }

    /// Returns whether the chip has registers that Velvet sets up and reads, on the board or outside.
    #[must_use]
    pub const fn is_spoken_with(self) -> bool {
        !matches!(self, Self::External)
    }

    /// Returns the word for this driver, which is also the name of its section.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tmc2590 => "tmc2590",
            Self::Tmc2660 => "tmc2660",
            Self::External => "external",
            Self::Tmc2130 => "tmc2130",
            Self::Tmc5160 => "tmc5160",
            Self::Tmc2240 => "tmc2240",
            Self::Tmc2208 => "tmc2208",
            Self::Tmc2209 => "tmc2209",
            Self::Tmc2226 => "tmc2226",
        }
    }
}

/// Settings of one motor.
#[derive(Clone, Copy, Debug, Default)]
pub struct ActuatorConfig {
    /// Whether the file describes this motor; otherwise the other fields mean nothing.
    pub present: bool,
    /// Steps (microsteps) per mm, or per degree for a rotary axis.
    pub steps_per_mm: f64,
    /// Top speed of the motor.
    pub max_rate: MmPerSecond,
    /// Acceleration limit of the motor; none: `default_acceleration`.
    pub acceleration: Option<MmPerSecond2>,
    /// Pin of the STEP output.
    pub step_pin: Option<Pin>,
    /// Pin of the DIR output.
    pub dir_pin: Option<Pin>,
    /// Enable output of an external driver; high enables.
    pub en_pin: Option<Pin>,
    /// Microsteps per full step, 1 to 256, a power of two.
    pub microsteps: u16,
    /// Whether the motor turns the other way.
    pub reversed: bool,
    /// Kind of the stepper driver.
    pub driver: DriverKind,
    /// The motor whose steps this one copies.
    pub slaved_to: Option<Slave>,
    /// Peak coil current; none: not set.
    pub current: Option<Amps>,
    /// Time from a direction change to the next step, nanoseconds.
    pub dir_setup_ns: u32,
    /// Coil data from the motor's data sheet.
    pub coil: CoilConfig,
    /// Response to a stall of the motor; none: as `halt_on_stall` says.
    pub on_stall: Option<OnStall>,
}

/// Coil data from a motor's data sheet, where written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoilConfig {
    /// Resistance of one coil.
    pub resistance: Option<Ohms>,
    /// Inductance of one coil, henry.
    pub henries: Option<f32>,
}

/// Response when a monitored motor stalls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnStall {
    /// The stall is reported, and the axis counts as not homed any more.
    Tell,
    /// The job stops at the stall and is suspended.
    Pause,
    /// The machine halts at once.
    #[default]
    Halt,
    /// The job stops at the stall, homes the axes that lost position, and resumes.
    Recover,
}

impl OnStall {
    /// Words in the file, in the order of [`Self::ALL`].
    pub const WORDS: &'static [&'static str] = &["tell", "pause", "halt", "recover"];
    /// All responses, in the order of [`Self::WORDS`].
    pub const ALL: [Self; 4] = [Self::Tell, Self::Pause, Self::Halt, Self::Recover];

    /// Returns whether the job stops at the stall and can be resumed.
    #[must_use]
    pub const fn keeps_job(self) -> bool {
        matches!(self, Self::Pause | Self::Recover)
    }
}

/// Master motor of a slaved motor.
pub type Slave = Actuator;

impl ActuatorConfig {
    /// Returns whether counting up makes the direction pin high instead of low: `reversed` and `!` on the pin
    /// each say so, and do not cancel.
    #[must_use]
    pub fn direction_inverted(&self) -> bool {
        self.reversed || self.dir_pin.is_some_and(|pin| pin.inverted)
    }
}

/// Settings `stall_*` under `[actuator] common`.
#[derive(Clone, Copy, Debug, Default)]
pub struct StallRecoveryConfig {
    /// Recoveries within `time` after which the job pauses.
    pub most: u8,
    /// Time within which recoveries are counted.
    pub time: Micros,
    /// Height by which Z rises before an axis homes.
    pub lift: Mm,
}

/// Settings under `[actuator] common`.
#[derive(Clone, Copy, Debug, Default)]
pub struct MotorsCommon {
    /// Whether the driver chips are polled for faults once a second.
    pub check_driver_errors: bool,
    /// Whether a driver's fatal fault halts the machine.
    pub halt_on_driver_alarm: bool,
    /// Whether a motor's stall halts the machine.
    pub halt_on_stall: bool,
    /// Settings for recovery of a job from a stall.
    pub stall: StallRecoveryConfig,
    /// Shared not-enable line of the on-board drivers.
    pub motors_enable_pin: Option<Pin>,
}

/// Settings of one on-board driver chip.
#[derive(Clone, Copy, Debug, Default)]
pub struct TmcConfig {
    /// Whether the file has an entry for this chip, or the board is taken to have the chip.
    pub present: bool,
    /// Whether the file has no entry for this chip.
    pub is_assumed: bool,
    /// Chip select, active low.
    pub spi_cs_pin: Option<Pin>,
    /// Sense resistor of the driver.
    pub sense_resistor: Ohms,
    /// Ceiling of any requested current.
    pub max_current: Amps,
    /// Whether steps are interpolated to 256 microsteps.
    pub step_interpolation: bool,
    /// Current when standing still; none: no reduction.
    pub standstill_current: Option<Amps>,
    /// Whether passive fast decay is used.
    pub passive_fast_decay: bool,
    /// Drive strength of the MOSFETs' gates, 0 the gentlest; none: as the raw registers say, or the driver's
    /// default.
    pub gate_drive: Option<u8>,
    /// Short-circuit detection on the bridges' low side; none: as the raw registers say, or on.
    pub short_to_supply_detection: Option<bool>,
    /// StallGuard threshold `SGT`; none: as the raw registers say, or 10.
    pub stall_threshold: Option<i8>,
    /// StallGuard filter `SFILT`; none: as the raw registers say, or on.
    pub stall_filter: Option<bool>,
    /// Whether stalls are monitored while the motor moves.
    pub stall_watch: bool,
    /// Least speed at which the motor's load can be measured.
    pub stall_least_speed: MmPerSecond,
    /// Settings of the load-dependent current.
    pub cool_step: CoolStepConfig,
    /// Raw registers loaded first: DRVCTRL, CHOPCONF, SMARTEN, SGCSCONF, DRVCONF.
    pub registers: Option<[u32; 5]>,
}

/// Settings of coolStep, by which the driver adapts the current to the measured load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoolStepConfig {
    /// StallGuard reading below which the current rises; 0: as the raw registers say, or off.
    pub lower: u16,
    /// StallGuard reading from which on the current falls; none: 64 above `lower`.
    pub upper: Option<u16>,
    /// `SEUP`: 0 to 3 for 1, 2, 4, 8 steps up at a time.
    pub up: u8,
    /// `SEDN`: 0 to 3 for 32, 8, 2, 1 readings for one step down.
    pub down: u8,
    /// Whether the current falls to a quarter at least rather than half.
    pub quarter: bool,
}

impl CoolStepConfig {
    /// Readings for one step of the thresholds.
    pub const STEP: u16 = 32;

    /// Returns the reading from which on the current falls.
    #[must_use]
    pub fn falls_from(&self) -> u16 {
        self.upper.unwrap_or(self.lower + 2 * Self::STEP)
    }
}

/// Settings that all driver chips of one kind share, and those of each chip.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriverFamily {
    /// 0: SPI1; 1: SPI4, where the on-board chips are.
    pub spi_channel: u8,
    /// Reset line of an external driver board.
    pub reset_pin: Option<Pin>,
    /// Idle time before the standstill current.
    pub standstill_time: Micros,
    /// Settings of each chip, by motor.
    pub axes: PerActuator<TmcConfig>,
}

/// Settings of one extruder.
#[derive(Clone, Debug, Default)]
pub struct ExtruderConfig {
    /// Name of the extruder in the file.
    pub name: Name,
    /// Whether the extruder is in use.
    pub enable: bool,
    /// Tool number, 0 to 2: motors delta, epsilon, zeta.
    pub tool_id: ToolId,
    /// Tool offset in X, Y and Z.
    pub offset: [Mm; 3],
    /// Filament diameter, with E in cubic millimetres; none: E in millimetres of filament.
    pub filament_diameter: Option<Mm>,
    /// Filament length that G10 retracts.
    pub retract_length: Mm,
    /// Retraction speed of G10.
    pub retract_rate: MmPerSecond,
    /// Extra filament on G11; may be negative.
    pub recover_length: Mm,
    /// Recovery speed of G11.
    pub recover_rate: MmPerSecond,
    /// Z hop on retraction; zero for none.
    pub z_lift: Mm,
    /// Speed of the Z hop.
    pub z_lift_rate: MmPerSecond,
    /// Temperature below which the extruder does not turn; zero: no limit.
    pub min_extrude_temp: Celsius,
    /// Pressure advance, seconds of the extruder's own speed; zero: none.
    pub pressure_advance_s: f64,
    /// Width of the window that smooths pressure advance, in seconds.
    pub pressure_advance_smooth_time_s: f64,
}

impl ExtruderConfig {
    /// Returns the motor of the extruder: delta for tool 0, epsilon for 1, zeta for 2.
    #[must_use]
    pub const fn actuator(&self) -> Option<Actuator> {
        Actuator::from_index(3 + self.tool_id.0 as usize)
    }
}
