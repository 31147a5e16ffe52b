//! The machine a configuration describes: missing facts are filled in with those of a well-built printer.

use board_facts::wiring;
use config::{
    ArmSolution, DriverKind, EndstopConfig, HomingDirection, MachineConfig, OutputPin, SensorKind, TemperatureConfig,
};
use units::{Actuator, Axis, PerActuator};

use super::delta::DeltaFrame;
use super::{
    ActuatorConfig, AnalogInput, ConverterConfig, DriverConfig, FanConfig, FilamentSensorConfig, HeaterConfig,
    LaserConfig, Linkage, Operator, OutsidePort, Pin, StripConfig, SwitchConfig, WorldConfig,
};
use crate::models::converter::{Kind, Thermocouple};
use crate::models::gantry::Gantry;
use crate::models::heater::Plant;
use crate::models::rotor;
use crate::models::surface::{Bed, Surface};
use crate::models::switch::Side;
use crate::models::thermistor::{Curve, REFERENCE_VOLTS};
use crate::models::tmc_stealth::StealthKind;
use crate::models::tmc26x::Chip;

/// Travel of a carriage beyond a switch before it hits the frame, millimetres.
const OVERTRAVEL_MM: f64 = 3.0;
/// Height of a bed above the tool, millimetres.
const OVERHEAD_MM: f64 = 30.0;
/// Distance from their homing switches at which X, Y and Z stand at power-on, millimetres.
const START_MM: [f64; 3] = [30.0, 40.0, 10.0];

impl WorldConfig {
    /// Makes the machine of this configuration, on a board with these driver chips.
    #[must_use]
    pub fn of(machine: &MachineConfig, chip: Chip) -> Self {
        let linkage = match machine.motion.arm_solution {
            ArmSolution::CoreXy => Linkage::CoreXy,
            ArmSolution::LinearDelta => Linkage::LinearDelta(DeltaFrame::of(&machine.motion.arms.linear_delta)),
            _ => Linkage::Direct,
        };
        Self {
            chip,
            actuators: machine.actuators().map(|(actuator, _)| motor(machine, actuator, linkage)).collect(),
            linkage,
            switches: switches(machine, linkage),
            gantry: gantry(machine),
            surface: surface(machine),
            heaters: machine.temperatures.iter().map(heater).collect(),
            fans: fans(machine),
            strips: strips(machine),
            laser: laser(machine),
            filament_sensor: filament_sensor(machine),
            ..Self::default()
        }
    }
}

const fn pin(pin: config::Pin) -> Pin {
    Pin { port: pin.port, number: pin.number }
}

/// Returns the coordinate range an axis's homing switch implies: switch position, other end, and the
/// position at power-on.
fn range(stop: &EndstopConfig, axis: usize) -> ([f64; 2], f64) {
    let (at, travel) = (stop.homing_position.0, stop.max_travel.0.max(1.0));
    let away = START_MM.get(axis).copied().unwrap_or(20.0).min(travel / 2.0);
    // Without a switch the frame itself is the end.
    let beyond = if stop.stall.homing { 0.0 } else { OVERTRAVEL_MM };
    match stop.homing_direction {
        HomingDirection::ToMax => ([at - travel - OVERTRAVEL_MM, at + beyond], at - away),
        _ => ([at - beyond, at + travel + OVERTRAVEL_MM], at + away),
    }
}

/// Returns a rotor if the machine looks at its load: rotors cost time.
fn rotor(machine: &MachineConfig, actuator: Actuator) -> Option<rotor::Plant> {
    let config = &machine.actuators[actuator];
    if !config.driver.is_spoken_with() || !machine.looks_at_stalls() {
        return None;
    }
    let rated_amps = config.current.map_or(rotor::Plant::PRINTER.rated_amps, |current| f64::from(current.0));
    Some(rotor::Plant { rated_amps, ..rotor::Plant::PRINTER })
}

fn outside(machine: &MachineConfig, actuator: Actuator) -> DriverConfig {
    let motor = &machine.actuators[actuator];
    let kind = match motor.driver {
        DriverKind::Tmc2130 => StealthKind::Tmc2130,
        DriverKind::Tmc5160 => StealthKind::Tmc5160,
        DriverKind::Tmc2208 => StealthKind::Tmc2208,
        DriverKind::Tmc2209 | DriverKind::Tmc2226 => StealthKind::Tmc2209,
        _ => StealthKind::Tmc2240,
    };
    let settings = machine.stealth_driver(actuator);
    let port = match (machine.driver_uart(actuator), settings) {
        (Some(channel), settings) => {
            OutsidePort::Uart { channel, address: settings.map_or(0, |settings| settings.uart_address) }
        }
        (None, settings) => OutsidePort::Spi {
            channel: machine.stealth_family(motor.driver).map_or(1, |family| family.channel),
            select: settings.and_then(|settings| settings.spi_cs_pin).map(pin),
        },
    };
    DriverConfig::Outside { kind, enable_high: motor.en_pin.map(|pin| !pin.inverted), port }
}

fn motor(machine: &MachineConfig, actuator: Actuator, linkage: Linkage) -> ActuatorConfig {
    let config = &machine.actuators[actuator];
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let axis = Axis::ALL[actuator as usize];
    // A slave stands beside its master.
    let leader = config.slaved_to.unwrap_or(actuator);
    let homing = machine.homing_endstop(Axis::ALL[leader as usize]);
    let (limits_mm, start_mm) = match (linkage, homing) {
        (Linkage::CoreXy, _) if axis != Axis::Z => (free, belt_start(machine, axis)),
        (_, Some(stop)) => range(&placed(machine, stop, linkage), leader as usize),
        (_, None) => (free, 0.0),
    };
    ActuatorConfig {
        actuator,
        driver: match config.driver {
            DriverKind::External => DriverConfig::External {
                pulse_ns: u64::from(machine.system.step_pulse_us) * 1_000,
                microsteps: u32::from(config.microsteps.max(1)),
                enable_high: config.en_pin.map(|pin| !pin.inverted),
            },
            DriverKind::Tmc2590 | DriverKind::Tmc2660 => DriverConfig::OnBoard,
            _ => outside(machine, actuator),
        },
        sense_ohms: machine.stealth_driver(actuator).and_then(|chip| chip.resistor).map_or(0.0, |r| f64::from(r.0)),
        mm_per_full_step: f64::from(config.microsteps.max(1)) / config.steps_per_mm,
        // The wiring is that of a working machine; `!` says that this motor's is the other way round.
        forward_high: config.direction_inverted() != wiring::UP_IS_HIGH,
        step_pin: config.step_pin.map(pin),
        direction_pin: config.dir_pin.map(pin),
        enable_pin: config.en_pin.map(pin),
        start_mm,
        limits_mm,
        rotor: rotor(machine, actuator),
    }
}

/// Returns a switch at its true position. A tower's is at the height the carriage has with the tool at its
/// homing position, less the trim.
fn placed(machine: &MachineConfig, stop: &EndstopConfig, linkage: Linkage) -> EndstopConfig {
    let mut placed = stop.clone();
    let master = stop.axis.and_then(|axis| machine.actuators.0.get(axis as usize)).and_then(|motor| motor.slaved_to);
    if let Some(homing) = master.and_then(|master| machine.homing_endstop(Axis::ALL[master as usize])) {
        // A slave's switch is at its end of the same gantry.
        placed.homing_direction = homing.homing_direction;
        placed.homing_position = homing.homing_position;
        return placed;
    }
    if let (Linkage::LinearDelta(frame), Some(axis)) = (linkage, stop.axis)
        && let Some(trim) = machine.homing.trim.get(axis as usize)
    {
        let tool = machine.homing_endstop(Axis::Z).map_or(0.0, |stop| stop.homing_position.0);
        placed.homing_position.0 = tool + frame.rise(axis as usize) - trim.0;
    }
    placed
}

/// Returns the position of a CoreXY belt with the tool at its power-on place.
fn belt_start(machine: &MachineConfig, axis: Axis) -> f64 {
    let tool = |axis: Axis| machine.homing_endstop(axis).map_or(0.0, |stop| range(stop, axis as usize).1);
    match axis {
        Axis::X => tool(Axis::X) + tool(Axis::Y),
        Axis::Y => tool(Axis::X) - tool(Axis::Y),
        _ => 0.0,
    }
}

fn switches(machine: &MachineConfig, linkage: Linkage) -> Vec<SwitchConfig> {
    let drivers = PerActuator(machine.actuators.0.map(|motor| motor.driver));
    let endstops =
        machine.endstops.iter().filter_map(|stop| endstop(&placed(machine, stop, linkage), linkage, &drivers));
    let probe = machine.probe.enable.then_some(machine.probe.pin).flatten().map(|input| SwitchConfig {
        name: "probe".into(),
        pin: pin(input),
        operated_high: !input.inverted,
        operator: Some((Operator::Surface, 0.0, Side::Below)),
    });
    let button = |name: &str, input: config::Pin, operated_high| SwitchConfig {
        name: name.into(),
        pin: pin(input),
        operated_high,
        operator: None,
    };
    let kill = machine.kill_button.enable.then_some(machine.kill_button.pin).flatten();
    // A pressed button is low, whatever else the pin's name says.
    let kill = kill.map(|input| button("kill", input, input.inverted));
    let door = machine.safety_door.pin.filter(|_| machine.safety_door.enable);
    let door = door.map(|input| button("door", input, !input.inverted));
    let inputs =
        machine.switches.iter().filter_map(|switch| switch.input_pin.map(|p| button(&switch.name, p, !p.inverted)));
    let detector = &machine.filament_detector;
    let filament = detector.level_pin().map(|input| button("filament", input, !input.inverted));
    let deployed = machine.probe.deployed_pin.filter(|_| machine.probe.enable);
    let deployed = deployed.map(|input| button("probe deployed", input, !input.inverted));
    let wheel = detector.wheel_pin().map(|input| button("filament wheel", input, !input.inverted));
    let buttons = machine.buttons.iter().filter_map(|of| of.pin.map(|input| button(&of.name, input, !input.inverted)));
    let stalls = machine.watched_for_stalls().filter(|(_, input)| machine.endstop_of_pin(*input).is_none());
    let stalls = stalls.map(|(motor, input)| {
        let is_outside = DriverKind::OUTSIDE.contains(&machine.actuators[motor].driver);
        SwitchConfig {
            name: format!("stall {}", motor.name()),
            pin: pin(input),
            operated_high: !is_low_for_stall(machine.actuators[motor].driver),
            operator: is_outside
                .then_some(motor)
                .or_else(|| stall_output(input))
                .map(|motor| (Operator::Stall(motor), 0.0, Side::Below)),
        }
    });
    endstops
        .chain(stalls)
        .chain(probe)
        .chain(kill)
        .chain(door)
        .chain(inputs)
        .chain(buttons)
        .chain(filament)
        .chain(wheel)
        .chain(deployed)
        .collect()
}

/// Returns as many motors as places are written, gamma and its slaves in their order.
fn gantry(machine: &MachineConfig) -> Gantry {
    let of_z = |(motor, config): &(Actuator, &config::ActuatorConfig)| {
        *motor == Actuator::Gamma || config.slaved_to == Some(Actuator::Gamma)
    };
    let motors = machine.actuators().filter(of_z).map(|(motor, _)| motor);
    Gantry { pivots: motors.zip(machine.z_alignment.motors.iter().copied()).collect() }
}

/// Returns a level bed at zero; for a probe that searches upwards, a bed above the tool.
fn surface(machine: &MachineConfig) -> Surface {
    let overhead = machine.probe.reverse_z;
    Surface { overhead, bed: Some(Bed::level(if overhead { OVERHEAD_MM } else { 0.0 })), ..Surface::default() }
}

/// Returns the motor whose driver's stallGuard output the board leads to this pin.
fn stall_output(input: config::Pin) -> Option<Actuator> {
    let socket = wiring::DRIVERS.iter().position(|socket| Pin::parse(socket.stall) == Some(pin(input)))?;
    Actuator::from_index(socket)
}

/// Returns whether the stall output is low for a stall: those of chips on SPI are, and the board's pull-ups
/// make them high.
const fn is_low_for_stall(driver: DriverKind) -> bool {
    matches!(driver, DriverKind::Tmc2130 | DriverKind::Tmc5160 | DriverKind::Tmc2240)
}

fn endstop(stop: &EndstopConfig, linkage: Linkage, drivers: &PerActuator<DriverKind>) -> Option<SwitchConfig> {
    let (input, axis) = (stop.pin?, stop.axis?);
    if stop.stall.homing {
        let motor = Actuator::from_index(axis as usize)?;
        let outside = (DriverKind::OUTSIDE.contains(&drivers[motor])).then_some(motor);
        return Some(SwitchConfig {
            name: stop.name.as_str().into(),
            pin: pin(input),
            operated_high: if outside.is_some() { !is_low_for_stall(drivers[motor]) } else { !input.inverted },
            operator: outside.or_else(|| stall_output(input)).map(|motor| (Operator::Stall(motor), 0.0, Side::Below)),
        });
    }
    let operator = match (linkage, axis) {
        (Linkage::CoreXy, Axis::X | Axis::Y | Axis::Z) => Operator::Tool(axis as usize),
        _ => Operator::Carriage(Actuator::ALL[axis as usize]),
    };
    // A switch that is only a limit stands at the far end: maximum switches at the end of the travel.
    let (position_mm, side) = match stop.homing_direction {
        HomingDirection::ToMin => (stop.homing_position.0, Side::Below),
        HomingDirection::ToMax => (stop.homing_position.0, Side::Above),
        HomingDirection::None if stop.name.contains("max") => (stop.homing_position.0 + stop.max_travel.0, Side::Above),
        HomingDirection::None => (stop.homing_position.0 - 1.0, Side::Below),
    };
    Some(SwitchConfig {
        name: stop.name.as_str().into(),
        pin: pin(input),
        operated_high: !input.inverted,
        operator: Some((operator, position_mm, side)),
    })
}

fn heater(controller: &TemperatureConfig) -> HeaterConfig {
    let bed = controller.name.contains("bed") || controller.designator.starts_with('B');
    let thermistor = controller.sensor.thermistor;
    let input = thermistor.input.filter(|_| controller.sensor.kind.is_analog());
    let sensor = input.and_then(|input| wiring::THERMISTORS.get(usize::from(input.0)).map(AnalogInput::of));
    HeaterConfig {
        name: controller.name.as_str().into(),
        pin: controller.heater_pin.map(pin),
        on_high: controller.heater_pin.is_none_or(|pin| !pin.inverted),
        sensor,
        converter: converter(&controller.sensor),
        curve: fitted(&controller.sensor),
        plant: if bed { Plant::BED } else { Plant::HOT_END },
    }
}

/// Returns the converter chip that the configuration says is fitted, with the connected sensor.
fn converter(sensor: &config::SensorConfig) -> Option<ConverterConfig> {
    let spi = &sensor.spi;
    let kind = match sensor.kind {
        SensorKind::Max31855 => Kind::Max31855,
        SensorKind::Max31856 => Kind::Max31856 { thermocouple: thermocouple(spi.thermocouple) },
        SensorKind::Max31865 => Kind::Max31865 {
            sensor: Curve::Platinum { r0_ohms: f64::from(spi.rtd_nominal.0) },
            reference_ohms: f64::from(spi.rtd_reference.0),
        },
        _ => return None,
    };
    Some(ConverterConfig { kind, channel: spi.channel?, select: pin(spi.select_pin?) })
}

const fn thermocouple(kind: units::Thermocouple) -> Thermocouple {
    use units::Thermocouple::{B, E, J, K, N, R, S, T};
    match kind {
        B => Thermocouple::B,
        E => Thermocouple::E,
        J => Thermocouple::J,
        K => Thermocouple::K,
        N => Thermocouple::N,
        R => Thermocouple::R,
        S => Thermocouple::S,
        T => Thermocouple::T,
    }
}

/// Returns the filament sensor as calibrated, with the reading shared equally by two inputs if there are two.
fn filament_sensor(machine: &MachineConfig) -> Option<FilamentSensorConfig> {
    let sensor = &machine.filament_width;
    let mut inputs = [None; 2];
    for (place, input) in sensor.live_inputs() {
        inputs[place] = wiring::THERMISTORS.get(usize::from(input.0)).map(AnalogInput::of);
    }
    let count = inputs.iter().flatten().count() as f64;
    let motor = machine.extruders.iter().find(|extruder| extruder.tool.id == sensor.tool)?.actuator()?;
    let volts = if sensor.mm_per_volt > 0.0 {
        [0.0, 1.0 / sensor.mm_per_volt]
    } else {
        let [one, other] = sensor.gauges;
        let per_mm = (other.raw - one.raw) / (other.diameter.0 - one.diameter.0);
        [one.raw - per_mm * one.diameter.0, per_mm].map(|raw| raw / 10_000.0 * REFERENCE_VOLTS / count)
    };
    (count > 0.0).then_some(FilamentSensorConfig { inputs, motor, to_nozzle_mm: sensor.delay.0, volts })
}

/// Returns the sensor that the configuration says is fitted.
fn fitted(sensor: &config::SensorConfig) -> Curve {
    match sensor.kind {
        SensorKind::Pt100 => Curve::Platinum { r0_ohms: 100.0 },
        SensorKind::Pt1000 => Curve::Platinum { r0_ohms: 1_000.0 },
        SensorKind::Ad849x => Curve::Amplifier { at_zero: f64::from(sensor.amplifier_offset.0), per_k: 0.005 },
        SensorKind::Voltage => match sensor.voltage_points {
            // The curve is a straight line through the first two points.
            [Some([one, volts]), Some([other, other_volts]), ..] if one != other => {
                let per_k = (other_volts - volts) / (other - one);
                Curve::Amplifier { at_zero: volts - per_k * one, per_k }
            }
            _ => curve(&sensor.thermistor),
        },
        _ => curve(&sensor.thermistor),
    }
}

/// Returns the fitted thermistor: the maker's points for known parts, otherwise the configuration's curve.
fn curve(thermistor: &config::ThermistorConfig) -> Curve {
    if let Some(points) = thermistor.rt_curve {
        return Curve::through(points);
    }
    if let Some(coefficients) = thermistor.coefficients {
        return Curve::SteinhartHart { coefficients };
    }
    let part = thermistor.table.and_then(|name| {
        Curve::of_part(name).or_else(|| {
            let built_in = drivers::thermistor::BUILT_IN.iter().find(|entry| entry.name == name)?;
            let curve = built_in.curve();
            let point = |celsius: f32| (f64::from(celsius), f64::from(curve.ohms(units::Celsius(celsius)).0));
            Some(Curve::through([point(25.0), point(150.0), point(250.0)]))
        })
    });
    part.unwrap_or(Curve::Beta {
        r25_ohms: f64::from(thermistor.r0.0).max(1.0),
        t25_c: f64::from(thermistor.t0.0),
        beta_k: thermistor.beta_k.max(1.0),
    })
}

/// Returns the strips of lights; strips that are switches have no chips.
fn strips(machine: &MachineConfig) -> Vec<StripConfig> {
    let strip = |strip: &config::LedStripConfig| {
        let output =
            strip.pin.map_or((usize::MAX, 0), |pin| (usize::from(pin.timer) - 1, usize::from(pin.channel) - 1));
        let bytes_each = strip.order.unwrap_or_default().bytes_each();
        StripConfig { output, lights: usize::from(strip.lights()), bytes_each }
    };
    machine.led_strips.iter().map(strip).collect()
}

fn laser(machine: &MachineConfig) -> Option<LaserConfig> {
    let pin = machine.laser.pwm_pin.filter(|_| machine.laser.enable)?;
    let output = (usize::from(pin.timer) - 1, usize::from(pin.channel) - 1);
    Some(LaserConfig { output, on_high: !machine.laser.inverted })
}

fn fans(machine: &MachineConfig) -> Vec<FanConfig> {
    let hot_end = machine.temperatures.iter().position(TemperatureConfig::is_hot_end);
    let fan = |switch: &config::SwitchConfig| {
        let Some(OutputPin::Digital(output)) = switch.output_pin else { return None };
        let described = machine.fans.iter().find(|fan| fan.name == switch.name);
        let is_fan = switch.name.contains("fan") || described.is_some();
        is_fan.then(|| FanConfig {
            name: switch.name.as_str().into(),
            pin: pin(output),
            on_high: !output.inverted,
            // The fan of the plain name "fan" blows at the part, and at the nozzle with it.
            cools: if switch.name == "fan" { hot_end } else { None },
            tachometer: described.and_then(|fan| fan.tachometer.pin).map(pin),
        })
    };
    machine.switches.iter().filter_map(fan).collect()
}
