//! Motors: `[actuator]` and `[current control]`.

use crate::pin::Pin;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, pin, word};
use crate::setting::declare::{settings, words};
use crate::setting::{ByName, PinRole, Words};
use units::{Actuator, Amps, Micros, Mm, MmPerSecond, MmPerSecond2, Ohms};

words! {
    /// Kind of stepper driver.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[allow(missing_docs, reason = "the names are the meaning")]
    pub enum DriverKind {
        #[default]
        Tmc2590 = "tmc2590",
        Tmc2660 = "tmc2660",
        External = "external",
        Tmc2130 = "tmc2130",
        Tmc5160 = "tmc5160",
        Tmc2240 = "tmc2240",
        Tmc2208 = "tmc2208",
        Tmc2209 = "tmc2209",
        Tmc2226 = "tmc2226",
    }
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

    /// Returns the greatest peak current of such a chip, whatever its resistor; none: its MOSFETs are outside
    /// the chip.
    #[must_use]
    pub const fn most_current(self) -> Option<Amps> {
        match self {
            Self::Tmc2130 => Some(Amps(2.5)),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(2.8)),
            Self::Tmc2240 => Some(Amps(3.0)),
            _ => None,
        }
    }

    /// Returns the peak current that an external driver of this kind can measure with its resistor; none for
    /// others.
    #[must_use]
    pub fn measurable(self, resistor: Ohms) -> Option<Amps> {
        match self {
            // The chip adds 20 mOhm in series with the resistor.
            Self::Tmc2130 => Some(Amps(0.32 / (resistor.get() + 0.02))),
            Self::Tmc2208 | Self::Tmc2209 | Self::Tmc2226 => Some(Amps(0.325 / (resistor.get() + 0.02))),
            Self::Tmc5160 => Some(Amps(0.325 / resistor.get())),
            // The constant is 36 A kOhm in the chip's highest range.
            Self::Tmc2240 => Some(Amps(36_000.0 / resistor.get())),
            _ => None,
        }
    }

    /// Returns the word for this driver, which is also the name of its section.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.word()
    }
}

settings! {
    /// The motors: alpha, beta, gamma, delta, epsilon, zeta for X, Y, Z, A, B, C. A machine has those the
    /// file names, without a gap. Extruders are delta and up.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct ActuatorConfig {
        /// Whether the file describes this motor; otherwise the other fields mean nothing.
        present: bool;
        /// Steps (with microsteps) per millimetre, or per degree of a rotary axis.
        steps_per_mm: f64 = number("80", &(1e-6, 1e6))
            .klipper("[stepper_<axis>] rotation_distance").by_name(&ByName(&[("gamma", "2560")])).unit("steps/mm")
            .typical(&(0.5, 20_000.0)).v1("<axis>_steps_per_mm");
        /// Top speed of the motor. M203.1 changes it.
        max_rate: MmPerSecond = number("30000", POSITIVE)
            .unit("mm/min").typical(&(30.0, 1_000_000.0)).v1("<axis>_max_rate") => MmPerSecond::from_per_minute;
        /// Acceleration limit of the motor; 0 or less: default_acceleration.
        acceleration: Option<MmPerSecond2> = number("-1", ANY)
            .unit("mm/s^2").typical(&(5.0, 100_000.0)).v1("<axis>_acceleration")
            => |v: f64| (v > 1e-4).then_some(MmPerSecond2(v));
        /// Step output.
        step_pin: Option<Pin> = pin("nc", PinRole::Output)
            .klipper("[stepper_<axis>] step_pin")
            .by_name(&ByName(&[("alpha", "PD3"), ("beta", "PK2"), ("gamma", "PG3"), ("delta", "PC6")]))
            .v1("<axis>_step_pin");
        /// Direction output: low while the motor counts up, high with !. Klipper's is the other way round:
        /// there high counts up, so add the ! where it has none and take it away where it has one.
        dir_pin: Option<Pin> = pin("nc", PinRole::Output)
            .klipper("[stepper_<axis>] dir_pin")
            .by_name(&ByName(&[("alpha", "PD4"), ("beta", "PG2"), ("gamma", "PG4"), ("delta", "PG5")]))
            .v1("<axis>_dir_pin");
        /// Enable output of a driver outside the board. On-board drivers are enabled over SPI.
        en_pin: Option<Pin> = pin("nc", PinRole::Output).klipper("[stepper_<axis>] enable_pin").v1("<axis>_en_pin");
        /// Microsteps per full step of a driver that is not external: 1, 2, 4, 8, 16, 32, 64, 128 or 256.
        /// steps_per_mm must fit. M909 changes it.
        microsteps: u16 = integer("32", &(1, 256))
            .klipper("[stepper_<axis>] microsteps").v1("motor_driver_control.<axis>.microsteps");
        /// Turn the other way; the same as ! on dir_pin.
        reversed: bool = bool("false");
        /// What drives the motor. All but external also need their entry in the section of the same name.
        driver: DriverKind = word("tmc2590", DriverKind::WORDS)
            .by_name(&ByName(&[("epsilon", "external"), ("zeta", "external"), ("tmc2660 board", "tmc2660")]))
            .v1("motor_driver_control.<axis>.chip");
        /// Makes delta, epsilon or zeta copy every step of alpha, beta or gamma. Such a motor is no axis of
        /// its own.
        slaved_to: Option<Slave> = word("none", MASTERS) => |v: usize| v.checked_sub(1).and_then(Actuator::from_index);
        /// Time from a change of direction to the next step. On-board drivers need 20 ns, optically isolated
        /// ones some microseconds.
        dir_setup_ns: u32 = integer("500", &(0, 100_000))
            .derived("5000 for external drivers, else 500").unit("ns").velvet();
        /// Coil data from the motor's data sheet.
        coil: CoilConfig;
        /// Resistance of one coil, from the motor's data sheet: tune_driver computes the chopper from it.
        "coil_resistance" coil.resistance = number("0", &(0.01, 1_000.0))
            .derived("not known").unit("Ohm").typical(&(0.3, 100.0)).velvet();
        /// Inductance of one coil, from the motor's data sheet: tune_driver computes the chopper from it.
        "coil_inductance" coil.henries = number("0", &(0.01, 1_000.0))
            .derived("not known").unit("mH").typical(&(0.3, 100.0)).velvet() => |v: f64| Some(v as f32 * 1e-3);
        /// What follows when the motor stalls while it moves; its driver needs stall_watch. tell: a message,
        /// and its axis is not homed any more. halt: the machine halts. pause: the job stops there and is
        /// suspended; resume homes the axis and goes on. recover: the job stops there, Z rises, the axis
        /// homes, and the job goes on by itself. Without a job under way pause and recover halt.
        on_stall: Option<OnStall> = word("halt", OnStall::WORDS)
            .derived("halt, or tell where halt_on_stall is false").velvet();
        /// Peak coil current; none: not set.
        current: Option<Amps>;
    }
}

/// Coil data from a motor's data sheet, where written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoilConfig {
    /// Resistance of one coil.
    pub resistance: Option<Ohms>,
    /// Inductance of one coil, henry.
    pub henries: Option<f32>,
}

words! {
    /// Response when a monitored motor stalls.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum OnStall {
        /// The stall is reported, and the axis counts as not homed any more.
        Tell = "tell",
        /// The job stops at the stall and is suspended.
        Pause = "pause",
        /// The machine halts at once.
        #[default]
        Halt = "halt",
        /// The job stops at the stall, homes the axes that lost position, and resumes.
        Recover = "recover",
    }
}

impl OnStall {
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

settings! {
    /// Settings `stall_*` under `[actuator] common`.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct StallRecoveryConfig {
        /// How often a job gets over stalls by itself (on_stall = recover) within stall_recovery_time. At one
        /// more it pauses.
        "stall_recoveries" most: u8 = integer("3", &(1, 16)).common().velvet();
        /// Time within which such recoveries are counted.
        "stall_recovery_time" time: Micros = number("600", NOT_NEGATIVE).common().unit("s").velvet();
        /// How far Z rises where a motor has stalled in a job, and above all that was printed while the axis
        /// homes.
        "stall_lift" lift: Mm = number("5", NOT_NEGATIVE).common().unit("mm").velvet();
    }
}

settings! {
    /// Settings under `[actuator] common`.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct MotorsCommon {
        /// Once a second, ask the drivers for faults and report them; external ones cannot be asked.
        check_driver_errors: bool = bool("true").common();
        /// Halt when a driver shuts down or finds a short circuit. Needs check_driver_errors.
        halt_on_driver_alarm: bool = bool("false").common().v1("motor_driver_control.<axis>.alarm");
        /// Halt when a motor with stall_watch stalls. Otherwise it is told, and the axis is not homed any
        /// more. on_stall says more for a motor.
        halt_on_stall: bool = bool("true").common().velvet();
        /// Settings for recovery of a job from a stall.
        stall: StallRecoveryConfig;
        rows MotorsEnable:
        /// Enables all on-board drivers; active except in a halt.
        motors_enable_pin: Option<Pin> = pin("PH13!", PinRole::Output).common();
    }
}

settings! {
    /// Motor currents.
    rows CurrentControl of ActuatorConfig {
        /// Peak coil current of a driver that is not external; 0 is the least it can give. A slave takes its
        /// master's. M906 and M907 change it.
        "current" current = number("", &(0.0, 20.0))
            .klipper("[tmc2660 <stepper>] run_current").required().unit("A").typical(&(0.05, 10.0))
            .v1("<axis>_current") => |v: f64| (v > 0.0).then_some(Amps(v as f32));
    }
}

const MASTERS: &Words = &Words(&["none", "alpha", "beta", "gamma"]);
