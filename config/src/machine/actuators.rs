//! Motors: `[actuator]`, `[tmc2590]`, `[tmc2660]`, `[current control]`, `[extruder]`. Drivers outside that
//! are spoken with are in [`super::stealth_drivers`].

use super::{Name, ToolId};
use crate::pin::Pin;
use units::{Actuator, Amps, Celsius, Micros, Mm, MmPerSecond, MmPerSecond2, Ohms, PerActuator};

/// What drives a motor's coils.
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
    /// Those outside the board that are set up by us.
    pub const OUTSIDE: [Self; 6] =
        [Self::Tmc2130, Self::Tmc5160, Self::Tmc2240, Self::Tmc2208, Self::Tmc2209, Self::Tmc2226];

    /// Its chip is on an auxiliary UART.
    #[must_use]
    pub const fn is_on_uart(self) -> bool {
        matches!(self, Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226)
    }

    /// A chip of the board: it takes every edge of STEP as a step, and its supply is the board's. Others are
    /// outside and take pulses.
    #[must_use]
    pub const fn is_on_board(self) -> bool {
        matches!(self, Self::Tmc2590 | Self::Tmc2660)
    }

    /// A chip that is set up and asked for its state, on the board or outside.
    #[must_use]
    pub const fn is_spoken_with(self) -> bool {
        !matches!(self, Self::External)
    }

    /// The word that stands for it, which is the name of its section.
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

/// One motor.
#[derive(Clone, Copy, Debug, Default)]
pub struct ActuatorConfig {
    /// The file describes this motor; otherwise the rest means nothing.
    pub present: bool,
    /// Steps (microsteps) per mm, or per degree for a rotary axis.
    pub steps_per_mm: f64,
    /// Top speed.
    pub max_rate: MmPerSecond,
    /// Acceleration limit of its own; none: `default_acceleration`.
    pub acceleration: Option<MmPerSecond2>,
    /// Step output.
    pub step_pin: Option<Pin>,
    /// Direction output.
    pub dir_pin: Option<Pin>,
    /// Enable output of an external driver; high enables.
    pub en_pin: Option<Pin>,
    /// Microsteps per full step, 1 to 256, a power of two.
    pub microsteps: u16,
    /// Turn the other way.
    pub reversed: bool,
    /// Driver.
    pub driver: DriverKind,
    /// The motor whose steps this one copies.
    pub slaved_to: Option<Slave>,
    /// Peak coil current; none: not set.
    pub current: Option<Amps>,
    /// Time from a direction change to the next step, nanoseconds.
    pub dir_setup_ns: u32,
    /// What its data sheet says of its coils.
    pub coil: CoilConfig,
    /// What a stall of it leads to; none: as `halt_on_stall` says.
    pub on_stall: Option<OnStall>,
}

/// What a motor's data sheet says of one of its coils, where somebody has written it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoilConfig {
    /// Resistance.
    pub resistance: Option<Ohms>,
    /// Inductance, henry.
    pub henries: Option<f32>,
}

/// What follows when a motor that is watched stalls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnStall {
    /// It is told, and its axis is not homed any more.
    Tell,
    /// The job stops there and is suspended.
    Pause,
    /// The machine halts.
    #[default]
    Halt,
    /// The job stops there, homes what has lost its place, and goes on.
    Recover,
}

impl OnStall {
    /// As they are written.
    pub const WORDS: &'static [&'static str] = &["tell", "pause", "halt", "recover"];
    /// In the order of [`Self::WORDS`].
    pub const ALL: [Self; 4] = [Self::Tell, Self::Pause, Self::Halt, Self::Recover];

    /// The job is stopped where it is, and can be gone on with.
    #[must_use]
    pub const fn keeps_job(self) -> bool {
        matches!(self, Self::Pause | Self::Recover)
    }
}

/// A motor that follows another.
pub type Slave = Actuator;

impl ActuatorConfig {
    /// Whether counting up makes the direction pin high, where it is low otherwise: `reversed` and `!` on the
    /// pin each say so, and do not cancel.
    #[must_use]
    pub fn direction_inverted(&self) -> bool {
        self.reversed || self.dir_pin.is_some_and(|pin| pin.inverted)
    }
}

/// `[actuator]` `common.stall_*`
#[derive(Clone, Copy, Debug, Default)]
pub struct StallRecoveryConfig {
    /// So often within `time`, then the job pauses.
    pub most: u8,
    /// Within which recoveries are counted.
    pub time: Micros,
    /// How far Z rises before an axis homes.
    pub lift: Mm,
}

/// `[actuator]` `common.*`
#[derive(Clone, Copy, Debug, Default)]
pub struct MotorsCommon {
    /// Poll the driver chips for faults once a second.
    pub check_driver_errors: bool,
    /// Halt on a driver's fatal fault.
    pub halt_on_driver_alarm: bool,
    /// Halt when a motor stalls.
    pub halt_on_stall: bool,
    /// How a job gets over a stall.
    pub stall: StallRecoveryConfig,
    /// Shared not-enable line of the on-board drivers.
    pub motors_enable_pin: Option<Pin>,
}

/// One driver chip.
#[derive(Clone, Copy, Debug, Default)]
pub struct TmcConfig {
    /// The file has an entry for this chip, or the board is taken to have it.
    pub present: bool,
    /// The file has none.
    pub is_assumed: bool,
    /// Chip select, active low.
    pub spi_cs_pin: Option<Pin>,
    /// Sense resistor.
    pub sense_resistor: Ohms,
    /// Ceiling of any requested current.
    pub max_current: Amps,
    /// Interpolate to 256 microsteps.
    pub step_interpolation: bool,
    /// Current when standing still; none: no reduction.
    pub standstill_current: Option<Amps>,
    /// Passive fast decay.
    pub passive_fast_decay: bool,
    /// How hard the MOSFETs' gates are driven, 0 the gentlest; none: as the raw registers say, or the
    /// driver's default.
    pub gate_drive: Option<u8>,
    /// The detector on the bridges' low side; none: as the raw registers say, or on.
    pub short_to_supply_detection: Option<bool>,
    /// `SGT`; none: as the raw registers say, or 10.
    pub stall_threshold: Option<i8>,
    /// `SFILT`; none: as the raw registers say, or on.
    pub stall_filter: Option<bool>,
    /// Its stalls are watched for while it moves.
    pub stall_watch: bool,
    /// Speed from which on its load can be measured.
    pub stall_least_speed: MmPerSecond,
    /// Current by load.
    pub cool_step: CoolStepConfig,
    /// Raw registers loaded first: DRVCTRL, CHOPCONF, SMARTEN, SGCSCONF, DRVCONF.
    pub registers: Option<[u32; 5]>,
}

/// Current that the driver changes by itself, by the load it measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoolStepConfig {
    /// Below this reading the current rises; 0: as the raw registers say, or off.
    pub lower: u16,
    /// From this one on it falls; none: 64 above.
    pub upper: Option<u16>,
    /// `SEUP`: 0 to 3 for 1, 2, 4, 8 steps up at a time.
    pub up: u8,
    /// `SEDN`: 0 to 3 for 32, 8, 2, 1 readings for one step down.
    pub down: u8,
    /// Down to a quarter rather than half.
    pub quarter: bool,
}

impl CoolStepConfig {
    /// What one step of the thresholds is, in readings.
    pub const STEP: u16 = 32;

    /// The reading from which on the current falls.
    #[must_use]
    pub fn falls_from(&self) -> u16 {
        self.upper.unwrap_or(self.lower + 2 * Self::STEP)
    }
}

/// What all driver chips of one kind share, and each of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriverFamily {
    /// 0: SPI1; 1: SPI4, where the on-board chips are.
    pub spi_channel: u8,
    /// Reset line of an external driver board.
    pub reset_pin: Option<Pin>,
    /// Idle time before the standstill current.
    pub standstill_time: Micros,
    /// By motor.
    pub axes: PerActuator<TmcConfig>,
}

/// One extruder.
#[derive(Clone, Debug, Default)]
pub struct ExtruderConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// Tool number, 0 to 2: motors delta, epsilon, zeta.
    pub tool_id: ToolId,
    /// Tool offset X Y Z.
    pub offset: [Mm; 3],
    /// E counts cubic millimetres of filament this thick; none: millimetres of filament.
    pub filament_diameter: Option<Mm>,
    /// G10.
    pub retract_length: Mm,
    /// G10.
    pub retract_rate: MmPerSecond,
    /// Extra filament on G11; may be negative.
    pub recover_length: Mm,
    /// G11.
    pub recover_rate: MmPerSecond,
    /// Z hop; zero for none.
    pub z_lift: Mm,
    /// Speed of the hop.
    pub z_lift_rate: MmPerSecond,
    /// Colder than this it does not turn; zero: whatever the temperature.
    pub min_extrude_temp: Celsius,
    /// Seconds of its own speed that filament runs ahead; zero: none.
    pub pressure_advance_s: f64,
    /// Width of the window that smooths pressure advance, in seconds.
    pub pressure_advance_smooth_time_s: f64,
}

impl ExtruderConfig {
    /// The motor it turns: delta for tool 0, epsilon for 1, zeta for 2.
    #[must_use]
    pub const fn actuator(&self) -> Option<Actuator> {
        Actuator::from_index(3 + self.tool_id.0 as usize)
    }
}
