//! A machine that uses every signal of the table, and access to its pins.

use sim::world::Pin;
use virtual_prime::board::PinChange;
use virtual_prime::pin_state::PinState;

use super::velvet::{Plan, Velvet};

/// Settings beyond the sample printer's: a second hot end, all end stops, probe and kill button, fans and
/// relays on every output, both PWM timers, and an external driver on header GF.
const EXTRAS: &[&str] = &[
    "[actuator] epsilon.steps_per_mm = 100",
    "[actuator] epsilon.max_rate = 6000",
    "[actuator] epsilon.driver = external",
    "[actuator] epsilon.step_pin = PG0",
    "[actuator] epsilon.dir_pin = PG1",
    "[actuator] epsilon.en_pin = PJ2!",
    "[system] step_pulse_us = 5",
    "[temperature control] hotend2.enable = true",
    "[temperature control] hotend2.tool_id = 1",
    "[temperature control] hotend2.designator = T2",
    "[temperature control] hotend2.thermistor_pin = ADC1_2",
    "[temperature control] hotend2.thermistor = Semitec-104NT4",
    "[temperature control] hotend2.heater_pin = PB8",
    "[switch] fan2.enable = true",
    "[switch] fan2.output_pin = PI11",
    "[switch] fan2.output_type = digital",
    "[switch] fan2.input_on_command = M42",
    "[switch] fan2.input_off_command = M43",
    "[switch] ssr1.enable = true",
    "[switch] ssr1.output_pin = PI4!",
    "[switch] ssr1.output_type = digital",
    "[switch] ssr1.input_on_command = M80",
    "[switch] ssr1.input_off_command = M81",
    "[switch] ssr2.enable = true",
    "[switch] ssr2.output_pin = PB7!",
    "[switch] ssr2.output_type = digital",
    "[switch] ssr2.input_on_command = M64",
    "[switch] ssr2.input_off_command = M65",
    "[switch] spindle.enable = true",
    "[switch] spindle.output_pin = PWM1_1",
    "[switch] spindle.output_type = hwpwm",
    "[switch] spindle.input_on_command = M3",
    "[switch] spindle.input_off_command = M5",
    "[switch] laser.enable = true",
    "[switch] laser.output_pin = PWM2_2",
    "[switch] laser.output_type = hwpwm",
    "[switch] laser.input_on_command = M66",
    "[switch] laser.input_off_command = M67",
    "[pwm1] frequency = 10000",
    "[pwm2] frequency = 4000",
    "[endstops] maxx.enable = true",
    "[endstops] maxx.pin = PI3^",
    "[endstops] maxx.axis = X",
    "[endstops] maxx.homing_direction = none",
    "[endstops] maxy.enable = true",
    "[endstops] maxy.pin = PA9^",
    "[endstops] maxy.axis = Y",
    "[endstops] maxy.homing_direction = none",
    "[endstops] maxz.enable = true",
    "[endstops] maxz.pin = PH15^",
    "[endstops] maxz.axis = Z",
    "[endstops] maxz.homing_direction = none",
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[kill button] enable = true",
    "[kill button] pin = PJ6^",
];

/// Returns the plan of such a machine.
pub fn everything() -> Plan {
    EXTRAS.iter().fold(Plan::new(), |plan, line| plan.set(line))
}

/// Returns a pin by its name.
pub fn pin(name: &'static str) -> Pin {
    virtual_prime::pins::pin(name)
}

/// Returns the present state of a pin.
pub fn state(velvet: &mut Velvet, name: &'static str) -> PinState {
    let pin = pin(name);
    velvet.bench.vm.with(move |stopped| stopped.session.board().mcu.pin_state(pin)).expect("the run goes on")
}

/// Keeps the changes of these pins from now on.
pub fn watch(velvet: &mut Velvet, names: &[&'static str]) {
    let pins: Vec<Pin> = names.iter().map(|name| pin(name)).collect();
    let watch = move |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        pins.iter().for_each(|pin| stopped.session.board_mut().mcu.watch_pin(*pin));
    };
    velvet.bench.vm.with(watch).expect("the run goes on");
}

/// Takes the changes of watched pins since the last call.
pub fn changes(velvet: &mut Velvet) -> Vec<PinChange> {
    velvet.bench.vm.with(|stopped| stopped.session.board_mut().mcu.take_pin_changes()).expect("the run goes on")
}

/// Drives a pin from outside.
pub fn drive(velvet: &mut Velvet, name: &'static str, high: bool) {
    let pin = pin(name);
    let drive = move |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        let at = stopped.stop.at;
        stopped.session.board_mut().drive(at, pin, high);
    };
    velvet.bench.vm.with(drive).expect("the run goes on");
}
