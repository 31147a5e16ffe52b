//! The parts of a simulated machine.

use units::Actuator;

use super::delta::DeltaFrame;
use crate::models::converter::Kind;
use crate::models::gantry::Gantry;
use crate::models::heater::Plant;
use crate::models::surface::Surface;
use crate::models::switch::Side;
use crate::models::thermistor::Curve;
use crate::models::tmc_stealth::StealthKind;
use crate::models::tmc26x::Chip;

/// Step of the thermal physics, nanoseconds.
pub const GRID_NS: u64 = 1_000_000;

/// A pin of the microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pin {
    /// Port: 0 is A, 10 is K.
    pub port: u8,
    /// Number in the port, 0 to 15.
    pub number: u8,
}

impl Pin {
    /// Returns the pin with this name (`PD3`), ignoring modifiers after it; `None` when it is no pin's
    /// name.
    #[must_use]
    pub const fn parse(name: &str) -> Option<Self> {
        let bytes = name.as_bytes();
        if bytes.len() < 3 || bytes[0] != b'P' || bytes[1] < b'A' || bytes[1] > b'K' {
            return None;
        }
        let mut number = 0;
        let mut at = 2;
        while at < bytes.len() && bytes[at].is_ascii_digit() && at < 4 {
            number = number * 10 + (bytes[at] - b'0');
            at += 1;
        }
        if at == 2 || number > 15 {
            return None;
        }
        Some(Self { port: bytes[1] - b'A', number })
    }
}

impl std::fmt::Display for Pin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "P{}{}", char::from(b'A' + self.port), self.number)
    }
}

/// An analog input: converter 1 or 3, channel by its INP number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AnalogInput {
    /// 1 for ADC1, 3 for ADC3.
    pub converter: u8,
    /// Channel by its INP number.
    pub channel: u8,
}

impl AnalogInput {
    /// Returns the input to which the board leads a signal.
    #[must_use]
    pub const fn of(input: &board_facts::wiring::AnalogInput) -> Self {
        Self { converter: input.converter, channel: input.channel }
    }
}

/// Drive of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriverConfig {
    /// Driver on the board, in the order of the four chip selects (alpha is 0).
    OnBoard,
    /// A driver on a header: a rising STEP edge is a step, `enable_high` the level that energises it.
    External {
        /// Least time for STEP to be low and high, nanoseconds: a shorter pulse may miss a step and counts
        /// as a timing fault.
        pulse_ns: u64,
        /// Microsteps per full step set by its switches.
        microsteps: u32,
        /// Level of the enable pin that energises the motor; `None` when it is always on.
        enable_high: Option<bool>,
    },
    /// A driver on a header with a chip that is set up.
    Outside {
        /// Model of the driver's chip.
        kind: StealthKind,
        /// Level of the enable pin that lets the chip drive; `None` if that input is tied so.
        enable_high: Option<bool>,
        /// Connection to the chip.
        port: OutsidePort,
    },
}

/// Connection of the chip of a driver on a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutsidePort {
    /// SPI1 (0) or SPI4 (1), and its select.
    Spi {
        /// Index of the bus.
        channel: u8,
        /// Select pin, low during a transfer.
        select: Option<Pin>,
    },
    /// USART3 (0) or UART4 (1): one wire, on which TX is over a resistor.
    Uart {
        /// Index of the port.
        channel: u8,
        /// Levels of MS1 and MS2.
        address: u8,
    },
}

/// A motor and what it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorConfig {
    /// Motor that is configured.
    pub actuator: Actuator,
    /// Driver of the motor.
    pub driver: DriverConfig,
    /// Travel per full step, millimetres (degrees for rotary axes).
    pub mm_per_full_step: f64,
    /// Level of DIR that moves towards higher positions: how the motor is wired.
    pub forward_high: bool,
    /// STEP, DIR and enable pin of an external driver; on-board ones are copper.
    pub step_pin: Option<Pin>,
    /// Direction pin, see `step_pin`.
    pub direction_pin: Option<Pin>,
    /// Enable pin, see `step_pin`.
    pub enable_pin: Option<Pin>,
    /// Resistor that sets the current of a driver with a chip outside, ohms.
    pub sense_ohms: f64,
    /// Position of the carriage at power-on, millimetres.
    pub start_mm: f64,
    /// Hard stops of the carriage, millimetres.
    pub limits_mm: [f64; 2],
    /// Rotor of the motor and its load, for stallGuard; `None`: it follows its field stiffly, and a stop
    /// takes the rest.
    pub rotor: Option<crate::models::rotor::Plant>,
}

/// Operator of a switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// The carriage of one motor (Cartesian axes, delta towers).
    Carriage(Actuator),
    /// A Cartesian coordinate of the tool, 0 to 2 for X to Z, through [`Linkage`].
    Tool(usize),
    /// Surface under or beside the tool, see [`WorldConfig::surface`]: a probe.
    Surface,
    /// The stallGuard output of a motor's driver, with the place 0 and [`Side::Below`].
    Stall(Actuator),
}

/// A switch on an input.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchConfig {
    /// Name in reports and faults (`minx`, `probe`, `kill`).
    pub name: String,
    /// Pin of the switch's input.
    pub pin: Pin,
    /// Level on the pin while operated.
    pub operated_high: bool,
    /// Operator of the switch; `None` for buttons, which only faults and tests press.
    pub operator: Option<(Operator, f64, Side)>,
}

/// A converter chip on an SPI bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConverterConfig {
    /// Model of the chip, and the sensor connected to it.
    pub kind: Kind,
    /// The bus: 0 is SPI1, 1 is SPI4.
    pub channel: u8,
    /// Select pin, active low.
    pub select: Pin,
}

/// A heater with its sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaterConfig {
    /// Name in reports and faults (`hotend`, `bed`).
    pub name: String,
    /// Output that heats it; `None` for a sensor alone.
    pub pin: Option<Pin>,
    /// Level that heats (before the board's buffer and switches).
    pub on_high: bool,
    /// Analog input of the sensor; `None` when the sensor is not analog.
    pub sensor: Option<AnalogInput>,
    /// The chip that reads the sensor; `None` if the converter of the board does, or nothing.
    pub converter: Option<ConverterConfig>,
    /// Curve of the sensor.
    pub curve: Curve,
    /// Thermal constants of the heater.
    pub plant: Plant,
}

/// A fan on an output.
#[derive(Clone, Debug, PartialEq)]
pub struct FanConfig {
    /// Name of the fan in reports.
    pub name: String,
    /// Output pin of the fan.
    pub pin: Pin,
    /// Level that runs it.
    pub on_high: bool,
    /// Index in [`WorldConfig::heaters`] of the heater that the fan cools.
    pub cools: Option<usize>,
    /// Pin of the tachometer's contact to ground, if the fan has one.
    pub tachometer: Option<Pin>,
}

/// A strip of lights with a chip each, on a timer's output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StripConfig {
    /// Timer (0: PWM1) and channel (0: PWM1_1) of the strip.
    pub output: (usize, usize),
    /// Number of lights in the strip.
    pub lights: usize,
    /// Bytes that each light takes.
    pub bytes_each: usize,
}

/// A laser on a timer's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaserConfig {
    /// Timer (0: PWM1) and channel (0: PWM1_1) of the laser.
    pub output: (usize, usize),
    /// Level at which the laser burns.
    pub on_high: bool,
}

/// A sensor of the width of filament, in front of an extruder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilamentSensorConfig {
    /// Inputs of the sensor, which read the same.
    pub inputs: [Option<AnalogInput>; 2],
    /// Motor that pulls the filament through the sensor.
    pub motor: Actuator,
    /// Filament from the sensor to the nozzle, millimetres.
    pub to_nozzle_mm: f64,
    /// Volts of each input for filament of no thickness, and for each millimetre more.
    pub volts: [f64; 2],
}

/// Relation of motors to the tool's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Linkage {
    /// Motor n moves axis n.
    Direct,
    /// X = (alpha + beta) / 2, Y = (alpha - beta) / 2, Z = gamma.
    CoreXy,
    /// Linear delta with three towers.
    LinearDelta(DeltaFrame),
}

/// Configuration of the whole machine.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldConfig {
    /// Model of the board's driver chips.
    pub chip: Chip,
    /// Motors, at most one entry per actuator.
    pub actuators: Vec<ActuatorConfig>,
    /// Relation of motors to the tool's motion.
    pub linkage: Linkage,
    /// Switches and buttons of the machine.
    pub switches: Vec<SwitchConfig>,
    /// Motors of Z that carry the gantry or the bed at places of their own; empty: gamma does it alone.
    pub gantry: Gantry,
    /// Surface that a probe can touch.
    pub surface: Surface,
    /// Heaters and sensors of the machine.
    pub heaters: Vec<HeaterConfig>,
    /// Fans of the machine.
    pub fans: Vec<FanConfig>,
    /// Strips of lights, in the order of the machine's description.
    pub strips: Vec<StripConfig>,
    /// Laser of the machine.
    pub laser: Option<LaserConfig>,
    /// Sensor of the width of filament.
    pub filament_sensor: Option<FilamentSensorConfig>,
    /// Temperature of the air, degrees Celsius.
    pub air_c: f64,
    /// Voltage of the motor supply, volts.
    pub vmotor_v: f64,
    /// Supply of the heater and fan switches, volts; heater power is given for 24 V.
    pub vfet_v: f64,
}

impl Default for WorldConfig {
    /// A Cartesian printer: 200 x 200 x 200 mm, four on-board drivers, hot end, bed, part fan, minimum
    /// switches and a probe, on the Prime's standard pins.
    fn default() -> Self {
        let axis = |actuator, steps_per_mm: f64, start_mm, limits_mm| ActuatorConfig {
            actuator,
            driver: DriverConfig::OnBoard,
            mm_per_full_step: 16.0 / steps_per_mm,
            forward_high: false,
            step_pin: None,
            direction_pin: None,
            enable_pin: None,
            sense_ohms: 0.0,
            start_mm,
            limits_mm,
            rotor: None,
        };
        Self {
            chip: Chip::Tmc2590,
            actuators: vec![
                axis(Actuator::Alpha, 80.0, 30.0, [-3.0, 205.0]),
                axis(Actuator::Beta, 80.0, 40.0, [-3.0, 205.0]),
                axis(Actuator::Gamma, 400.0, 10.0, [-3.0, 205.0]),
                axis(Actuator::Delta, 140.0, 0.0, [f64::NEG_INFINITY, f64::INFINITY]),
            ],
            linkage: Linkage::Direct,
            switches: usual_switches(),
            gantry: Gantry::default(),
            surface: Surface::default(),
            heaters: usual_heaters(),
            fans: vec![FanConfig {
                name: "fan".into(),
                pin: pin_named("PE1"),
                on_high: true,
                cools: Some(0),
                tachometer: None,
            }],
            strips: Vec::new(),
            laser: None,
            filament_sensor: None,
            air_c: 22.0,
            vmotor_v: 24.0,
            vfet_v: 24.0,
        }
    }
}

/// Minimum switches of X, Y and Z, and a probe.
fn usual_switches() -> Vec<SwitchConfig> {
    let switch = |name: &str, pin, operator| SwitchConfig {
        name: name.into(),
        pin: pin_named(pin),
        operated_high: true,
        operator: Some((operator, 0.0, Side::Below)),
    };
    vec![
        switch("minx", "PD0", Operator::Carriage(Actuator::Alpha)),
        switch("miny", "PI1", Operator::Carriage(Actuator::Beta)),
        switch("minz", "PI0", Operator::Carriage(Actuator::Gamma)),
        switch("probe", "PB10", Operator::Surface),
    ]
}

/// A hot end and a bed.
fn usual_heaters() -> Vec<HeaterConfig> {
    let heater = |name: &str, pin, channel, plant| HeaterConfig {
        name: name.into(),
        pin: Some(pin_named(pin)),
        on_high: true,
        sensor: Some(AnalogInput { converter: 1, channel }),
        converter: None,
        curve: Curve::of_part("EPCOS100K").expect("a known part"),
        plant,
    };
    vec![heater("hotend", "PE0", 2, Plant::HOT_END), heater("bed", "PE3", 9, Plant::BED)]
}

fn pin_named(name: &str) -> Pin {
    Pin::parse(name).expect("a pin of the board")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_are_read_as_they_are_written_without_what_follows() {
        for port in 0..11 {
            for number in 0..16 {
                let pin = Pin { port, number };
                assert_eq!(Pin::parse(&pin.to_string()), Some(pin));
                assert_eq!(Pin::parse(&format!("{pin}!^")), Some(pin));
            }
        }
        for name in ["nc", "P", "PA", "PAx", "PL1", "PA16", "pa1", "QA1"] {
            assert_eq!(Pin::parse(name), None, "{name}");
        }
    }
}
