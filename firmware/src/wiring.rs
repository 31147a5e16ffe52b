//! Wiring of the configuration to pins and peripherals, once, at the end of boot.
//!
//! An item that cannot be had (a pin with two owners, a feature the board lacks) is reported as one line and
//! left inactive; the rest goes on, so that one reading of the console shows all that is wrong.

use base::ports::Input as MachineInput;
use bsp_prime::laser::{Drive, Laser};
use bsp_prime::pins::{Input, Output, PinSpec, Pins, table};
use bsp_prime::step_engine::MotorLines;
use bsp_prime::uart::UartPort;
use config::{ActuatorConfig, MachineConfig, OutputPin, Pin, SensorKind, TmcConfig};
use heapless::Vec;
use units::Actuator;

use crate::drivers::{DriverBank, MotorDriver, SensorBank};

mod outside;
mod report;

use outside::{outside, spi, wire};
use report::owner;
pub use report::{Report, spec};

/// Sets up step, direction and enable pins and driver chips.
pub fn motors(
    config: &MachineConfig,
    pins: &mut Pins,
    buses: &mut bsp_prime::spi::SpiBuses,
    uarts: &mut [UartPort; 2],
    report: &mut Report<'_>,
) -> DriverBank {
    let mut lines = [MotorLines::NONE; units::MAX_ACTUATORS];
    let mut bank = DriverBank::default();
    release_reset(config, pins, report);
    // First of all, so that no chip outside, whose select nothing pulls up yet, listens to what others are
    // told. The chips outside are told nothing yet.
    let mut open = [false; 2];
    for (actuator, motor) in config.actuators() {
        if config.stealth_driver(actuator).is_none() {
            continue;
        }
        let enable = enable_pin(actuator, motor, pins, report);
        let bus = match config.driver_uart(actuator) {
            Some(channel) => wire(config, actuator, channel, (uarts, &mut open), pins, report),
            None => spi(config, actuator, pins, buses, report),
        };
        if let Some(bus) = bus {
            bank.0[actuator] = outside(config, actuator, bus, enable, report);
        }
    }
    for (actuator, motor) in config.actuators() {
        if let Some(line) = lines.get_mut(actuator as usize) {
            let timing = base::motion_config::actuator(config, actuator);
            let least_distance = timing.step_interval.max(timing.direction_setup);
            *line = motor_lines(actuator, motor, least_distance, pins, report);
        }
        if let Some(settings) = config.driver(actuator) {
            let channel = config.driver_family(motor.driver).map_or(1, |family| family.spi_channel);
            bank.0[actuator] = chip((actuator, motor), settings, channel, pins, buses, report);
        } else if !motor.driver.is_spoken_with() {
            let enable = enable_pin(actuator, motor, pins, report);
            bank.0[actuator] = enable.map_or(MotorDriver::None, MotorDriver::External);
        }
    }
    unused_chips(pins, buses);
    bsp_prime::step_engine::configure(&lines, config.system.step_pulse_us);
    bank
}

/// Raises the reset line of a driver board, for good: the pin has its owner and no other code writes it.
fn release_reset(config: &MachineConfig, pins: &mut Pins, report: &mut Report<'_>) {
    let Some(pin) = config.tmc2590.reset_pin else { return };
    if let Some(mut line) = report.take(pins.output(spec(pin), "tmc2590.common.reset_pin")) {
        line.set(true);
    }
}

/// Switches off the on-board driver chips that no motor has claimed; see [`driver_bank::switch_off`].
fn unused_chips(pins: &mut Pins, bus: &bsp_prime::spi::SpiBuses) {
    for socket in &table::MOTORS {
        // A select that has an owner belongs to a chip that is set up, or was refused with a message.
        let Ok(select) = pins.output(PinSpec::inverted(socket.select), "an unused motor driver") else { continue };
        // The motor supply of the socket may be off, and then so is the chip.
        let _silent_or_off = driver_bank::switch_off(bus.motor_driver(select));
    }
}

fn motor_lines(
    actuator: Actuator,
    motor: &ActuatorConfig,
    least_distance: u32,
    pins: &mut Pins,
    report: &mut Report<'_>,
) -> MotorLines {
    let double_edge = motor.driver.is_on_board();
    let mut lines = MotorLines { double_edge, least_distance_ticks: least_distance, ..MotorLines::NONE };
    if let Some(pin) = motor.step_pin {
        let claimed = pins.fast_output(spec(pin), &owner("actuator", actuator.name(), "step_pin"));
        lines.step = report.take(claimed).unwrap_or(lines.step);
    }
    if let Some(pin) = motor.dir_pin {
        // A pin that is off, low without `!`, means forward.
        let spec = PinSpec { inverted: motor.direction_inverted(), ..spec(pin) };
        let claimed = pins.fast_output(spec, &owner("actuator", actuator.name(), "dir_pin"));
        lines.direction = report.take(claimed).unwrap_or(lines.direction);
    }
    lines
}

/// Returns the enable output of an external driver, if it has one.
fn enable_pin(actuator: Actuator, motor: &ActuatorConfig, pins: &mut Pins, report: &mut Report<'_>) -> Option<Output> {
    let claimed = pins.output(spec(motor.en_pin?), &owner("actuator", actuator.name(), "en_pin"));
    report.take(claimed)
}

/// A driver chip, with its settings in its copy of the registers. Nothing is expected to answer yet: the
/// motor supply may be off.
fn chip(
    (actuator, motor): (Actuator, &ActuatorConfig),
    settings: &TmcConfig,
    channel: u8,
    pins: &mut Pins,
    buses: &mut bsp_prime::spi::SpiBuses,
    report: &mut Report<'_>,
) -> MotorDriver {
    let socket = table::MOTORS.get(actuator as usize).map(|pins| PinSpec::plain(pins.select));
    let Some(select) = settings.spi_cs_pin.map(spec).or(socket) else {
        report.trouble(format_args!(
            "{}: there is no on-board driver for this motor; set {}.driver = external",
            actuator.name(),
            actuator.name()
        ));
        return MotorDriver::None;
    };
    // The chip selects act low, whether or not the configuration says so.
    let claimed = pins.output(PinSpec { inverted: true, ..select }, &owner("driver", actuator.name(), "spi_cs_pin"));
    let Some(select) = report.take(claimed) else { return MotorDriver::None };
    let chip = if channel == 0 {
        // The chip is on a board of its own, at the other header.
        let owner = owner(motor.driver.name(), "common", "spi_channel");
        report.take(buses.chip(channel, driver_bank::CHIP_CLOCK, Some(select), pins, &owner)).flatten()
    } else {
        Some(buses.motor_driver(select))
    };
    let Some(chip) = chip else { return MotorDriver::None };
    match driver_bank::set_up(chip, motor, settings) {
        Ok(driver) => driver,
        Err(error) => {
            report.trouble(format_args!("driver {}: {error}", actuator.name()));
            MotorDriver::None
        }
    }
}

/// Sets up the chips of temperature sensors, each with its select. No message is sent to them yet.
pub fn sensors(
    config: &MachineConfig,
    pins: &mut Pins,
    buses: &mut bsp_prime::spi::SpiBuses,
    report: &mut Report<'_>,
) -> SensorBank {
    let mut bank = SensorBank::default();
    for (index, controller) in config.temperatures.iter().enumerate() {
        let spi = &controller.sensor.spi;
        let Some(chips) = sensor_bank::Chips::of(controller.sensor.kind) else { continue };
        let (Some(channel), Some(select)) = (spi.channel, spi.select_pin) else { continue };
        // The selects act low, whether or not the configuration says so.
        let select = PinSpec { inverted: true, ..spec(select) };
        let claimed = pins.output(select, &owner("temperature control", &controller.name, "spi_select_pin"));
        let Some(select) = report.take(claimed) else { continue };
        let clock = (chips.mode, chips.most_hz);
        let owner = owner("temperature control", &controller.name, "spi_channel");
        let chip = report.take(buses.chip(channel, clock, Some(select), pins, &owner)).flatten();
        // The bank has room for a chip per controller.
        let _added = chip.is_some_and(|chip| bank.add(index, &controller.sensor, chip));
    }
    bank
}

/// Sets up thermistor inputs, those of the filament width sensor, and heater outputs.
pub fn temperatures(config: &MachineConfig, pins: &mut Pins, io: &mut crate::heat_io::HeatIo, report: &mut Report<'_>) {
    let mut channels = Vec::<u8, { bsp_prime::adc::MAX_INPUTS }>::new();
    for (index, controller) in config.temperatures.iter().enumerate() {
        let name = controller.name.as_str();
        if let Some(pin) = controller.heater_pin {
            let output = report.take(pins.output(spec(pin), &owner("temperature control", name, "heater_pin")));
            if let Some(slot) = io.heaters.get_mut(index) {
                *slot = output;
            }
        }
        if let Some(of_chip) = io.of_chip.get_mut(index) {
            *of_chip = controller.sensor.kind == SensorKind::Chip;
        }
        let input = match (controller.sensor.kind, controller.sensor.thermistor.input) {
            (kind, Some(input)) if kind.is_analog() => table::THERMISTORS.get(usize::from(input.0)),
            _ => None,
        };
        let Some(input) = input else { continue };
        let owner = owner("temperature control", name, "thermistor_pin");
        let place = scanned(input, &owner, pins, &mut channels, report);
        if let Some(sensor) = io.sensors.get_mut(index) {
            *sensor = place;
        }
    }
    for (index, input) in config.filament_width.live_inputs() {
        let key = if index == 0 { "filament width sensor.adc_pin" } else { "filament width sensor.second_adc_pin" };
        let input = table::THERMISTORS.get(usize::from(input.0));
        let place = input.and_then(|input| scanned(input, key, pins, &mut channels, report));
        if let Some(sensor) = io.filament_width.get_mut(index) {
            *sensor = place;
        }
    }
    if !channels.is_empty() && io.thermistors.start(&channels).is_err() {
        report.trouble("the thermistor converter (ADC1) does not start; no heater will work");
    }
}

/// Claims an analog input's pin, adds it to the scan, and returns its place in the scan.
fn scanned(
    input: &table::AnalogInput,
    owner: &str,
    pins: &mut Pins,
    channels: &mut Vec<u8, { bsp_prime::adc::MAX_INPUTS }>,
    report: &mut Report<'_>,
) -> Option<usize> {
    if let Some(pin) = input.pin {
        report.take(pins.analog(pin, owner))?;
    }
    channels.push(input.channel).ok()?;
    Some(channels.len() - 1)
}

/// Sets up the inputs of the fans' tachometers.
pub fn tachometers(config: &MachineConfig, pins: &mut Pins, io: &mut crate::heat_io::HeatIo, report: &mut Report<'_>) {
    for (slot, fan) in io.tachometers.iter_mut().zip(&config.fans) {
        let Some(pin) = fan.tachometer.pin else { continue };
        *slot = report.take(pins.input(spec(pin), &owner("fan", &fan.name, "tachometer_pin")));
    }
}

/// Sets up the pins of the monitored voltages.
pub fn voltages(config: &MachineConfig, pins: &mut Pins, report: &mut Report<'_>) {
    for voltage in &config.voltages {
        let input = table::SUPPLIES.get(usize::from(voltage.input.0));
        if let Some(pin) = input.and_then(|input| input.pin) {
            let _reported = report.take(pins.analog(pin, &owner("voltage monitor", &voltage.name, "pin")));
        }
    }
}

/// Sets up the outputs of switches: pins to the heat task, timer channels to the PWM.
pub fn switch_outputs(
    config: &MachineConfig,
    pins: &mut Pins,
    pwm: &mut bsp_prime::pwm::Pwm,
    mut place: impl FnMut(usize, Output),
    report: &mut Report<'_>,
) {
    for (timer, rate) in config.pwm_frequency_hz.iter().enumerate() {
        let number = timer as u8 + 1;
        if let Some(rate) = rate.filter(|_| !config.timer_sends(number) && !config.timer_burns(number)) {
            pwm.start(timer, rate);
        }
    }
    for (index, switch) in config.switches.iter().enumerate() {
        let owner = owner("switch", &switch.name, "output_pin");
        match switch.output_pin {
            Some(OutputPin::Digital(pin)) => {
                if let Some(output) = report.take(pins.output(spec(pin), &owner)) {
                    place(index, output);
                }
            }
            Some(OutputPin::Pwm(output)) => {
                let (timer, channel) =
                    (usize::from(output.timer).wrapping_sub(1), usize::from(output.channel).wrapping_sub(1));
                let _reported = report.take(pwm.attach(timer, channel, pins, &owner));
            }
            None => {}
        }
    }
}

/// Sets up the laser, off and locked.
pub fn laser(
    config: &MachineConfig,
    pins: &mut Pins,
    pwm: &mut bsp_prime::pwm::Pwm,
    report: &mut Report<'_>,
) -> Option<Laser> {
    let settings = config.laser.enable.then_some(&config.laser)?;
    let output = settings.pwm_pin?;
    let timer = pwm.give_to_laser(usize::from(output.timer).wrapping_sub(1))?;
    let gate = match settings.ttl_pin {
        Some(pin) => Some(report.take(pins.fast_output(spec(pin), "[laser] ttl_pin"))?),
        None => None,
    };
    let drive = Drive {
        frequency_hz: settings.frequency_hz,
        is_inverted: settings.inverted,
        is_open_drain: settings.open_drain,
        is_pulled_up: settings.pullup,
    };
    let channel = usize::from(output.channel).wrapping_sub(1);
    report.take(Laser::set_up(timer, channel, drive, gate, pins, "[laser] pwm_pin"))
}

/// Returns timer and channel of each strip of lights. A timer that sends to strips does nothing else.
pub fn led_strips(
    config: &MachineConfig,
    pins: &mut Pins,
    pwm: &mut bsp_prime::pwm::Pwm,
    sender: &mut bsp_prime::led_strip::LedSender,
    report: &mut Report<'_>,
) -> [Option<(usize, usize)>; config::MAX_STRIPS] {
    let mut places = [None; config::MAX_STRIPS];
    for (place, strip) in places.iter_mut().zip(&config.led_strips) {
        let Some(output) = strip.pin else { continue };
        let (timer, channel) = (usize::from(output.timer).wrapping_sub(1), usize::from(output.channel).wrapping_sub(1));
        // The first strip on a timer has it set up, so that its lines are low before pins follow them.
        if let Some(timer) = pwm.give_away(timer) {
            sender.add(timer);
        }
        let owner = owner("led strip", &strip.name, "pin");
        *place = report.take(pwm.attach(timer, channel, pins, &owner)).map(|()| (timer, channel));
    }
    places
}

/// Lists every input of the machine: calls `place` with its bit's number, its pin, and whether it can stop
/// motion.
pub fn inputs(
    config: &MachineConfig,
    pins: &mut Pins,
    mut place: impl FnMut(u8, PinSpec, Input, bool),
    report: &mut Report<'_>,
) {
    let mut add = |input: MachineInput, pin: Option<Pin>, owner: &str, stops: bool, report: &mut Report<'_>| {
        let Some(pin) = pin else { return };
        if let Some(handle) = report.take(pins.input(spec(pin), owner)) {
            if input == MachineInput::Probe {
                // Searches may also end with the probe's release.
                let spec = PinSpec { inverted: !pin.inverted, ..spec(pin) };
                place(MachineInput::ProbeOpen.number(), spec, handle.opposite(), stops);
            }
            place(input.number(), spec(pin), handle, stops);
        }
    };
    for (index, endstop) in config.endstops.iter().enumerate() {
        let owner = owner("endstops", &endstop.name, "pin");
        add(MachineInput::Endstop(index as u8), endstop.pin, &owner, true, report);
    }
    for (index, switch) in config.switches.iter().enumerate() {
        let owner = owner("switch", &switch.name, "input_pin");
        add(MachineInput::Switch(index as u8), switch.input_pin, &owner, false, report);
    }
    for (index, button) in config.buttons.iter().enumerate() {
        let owner = owner("button box", &button.name, "pin");
        add(MachineInput::Button(index as u8), button.pin, &owner, false, report);
    }
    if config.probe.enable {
        add(MachineInput::Probe, config.probe.pin, "zprobe.probe_pin", true, report);
        add(MachineInput::ProbeDeployed, config.probe.deployed_pin, "zprobe.deployed_pin", false, report);
    }
    if config.kill_button.enable {
        // A pressed button gives a low level.
        let pin = config.kill_button.pin.map(|pin| Pin { inverted: !pin.inverted, ..pin });
        add(MachineInput::Kill, pin, "kill button.pin", false, report);
    }
    if config.safety_door.enable {
        add(MachineInput::Door, config.safety_door.pin, "safety door.pin", false, report);
    }
    for (motor, pin) in config.watched_for_stalls() {
        // An endstop pin is not watched a second time.
        if config.endstop_of_pin(pin).is_none() {
            let owner = owner("actuator", motor.name(), "stall_watch");
            add(MachineInput::Stall(motor as u8), Some(pin), &owner, false, report);
        }
    }
    let filament = &config.filament_detector;
    add(MachineInput::Filament, filament.level_pin(), "filament detector", false, report);
    add(MachineInput::FilamentWheel, filament.wheel_pin(), "filament detector.encoder_pin", false, report);
}

/// The board's own enables cannot be moved: a configuration that names other pins is told so.
pub fn guards(config: &MachineConfig, report: &mut Report<'_>) {
    let named = [
        ("actuator.common.motors_enable_pin", config.motors.motors_enable_pin, table::MOTORS_ENABLE),
        ("system.fets_enable_pin", config.system.fets_enable_pin, table::FETS_ENABLE),
        ("system.fets_power_enable_pin", config.system.fets_power_enable_pin, table::FETS_POWER_ENABLE),
    ];
    for (key, pin, fixed) in named {
        if let Some(pin) = pin
            && spec(pin).pin != fixed.pin
        {
            report.trouble(format_args!("{key} = {pin}: on this board it is {}; leave the setting out", fixed.pin));
        }
    }
}
