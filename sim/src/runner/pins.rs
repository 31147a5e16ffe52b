//! The pins of the machine on the host: those that a configuration names, as the board's table of claims.

use config::{MachineConfig, OutputPin, Pin};

/// Returns the user of a pin.
pub fn user_of(config: &MachineConfig, pin: Pin) -> Option<String> {
    let users = motors(config).chain(inputs(config)).chain(outputs(config));
    users.into_iter().find(|(used, _)| used.is_some_and(|used| used.is_same_pad(pin))).map(|(_, user)| user)
}

type Used = (Option<Pin>, String);

fn motors(config: &MachineConfig) -> impl Iterator<Item = Used> {
    let motors = config.actuators().flat_map(|(actuator, motor)| {
        let on_board = config.driver(actuator).and_then(|driver| driver.spi_cs_pin);
        let select = on_board.or_else(|| config.stealth_driver(actuator)?.spi_cs_pin);
        let pins = [
            ("step_pin", motor.step_pin),
            ("dir_pin", motor.dir_pin),
            ("en_pin", motor.en_pin),
            ("spi_cs_pin", select),
        ];
        pins.map(|(key, pin)| (pin, format!("actuator.{}.{key}", actuator.name())))
    });
    motors.chain([(config.motors.motors_enable_pin, "actuator.motors_enable_pin".to_owned())])
}

fn inputs(config: &MachineConfig) -> impl Iterator<Item = Used> {
    let stops = config.endstops.iter().filter(|stop| stop.enable);
    let stops = stops.map(|stop| (stop.pin, format!("endstops.{}", stop.name)));
    let probe = config.probe.pin.filter(|_| config.probe.enable);
    let kill = config.kill_button.pin.filter(|_| config.kill_button.enable);
    let door = config.safety_door.pin.filter(|_| config.safety_door.enable);
    let switches = config.switches.iter().map(|switch| (switch.input_pin, format!("switch.{}", switch.name)));
    let buttons = config.buttons.iter().map(|button| (button.pin, format!("button box.{}.pin", button.name)));
    let filament = &config.filament_detector;
    let parts = [
        (probe, "zprobe"),
        (config.probe.deployed_pin.filter(|_| config.probe.enable), "zprobe.deployed_pin"),
        (kill, "kill button"),
        (door, "safety door"),
        (filament.level_pin(), "filament detector"),
        (filament.wheel_pin(), "filament detector.encoder_pin"),
    ];
    let fans = config.fans.iter().map(|fan| (fan.tachometer.pin, format!("fan.{}.tachometer_pin", fan.name)));
    stops.chain(switches).chain(fans).chain(buttons).chain(parts.map(|(pin, user)| (pin, user.to_owned())))
}

fn outputs(config: &MachineConfig) -> impl Iterator<Item = Used> {
    let heaters = config.temperatures.iter().filter(|heater| heater.enable);
    let heaters = heaters.map(|heater| (heater.heater_pin, format!("temperature control.{}.heater_pin", heater.name)));
    let switches = config.switches.iter().map(|switch| {
        let pin = switch.output_pin.and_then(|pin| match pin {
            OutputPin::Digital(pin) => Some(pin),
            OutputPin::Pwm(_) => None,
        });
        (pin, format!("switch.{}", switch.name))
    });
    let fets = [config.system.fets_enable_pin, config.system.fets_power_enable_pin];
    heaters.chain(switches).chain(fets.map(|pin| (pin, "system".to_owned())))
}
