//! Settings of the sections `[fan]` and `[temperature switch]`.

use super::See::{Boot, Look, Say};
use super::{Bench, Row, row};

/// A fan on the second MOSFET, controlled by the hot end.
const SECOND: &[&str] = &[
    "[switch] cooling.enable = true",
    "[switch] cooling.output_pin = PI11",
    "[switch] cooling.output_type = sigmadeltapwm",
    "[fan] cooling.enable = true",
    "[fan] cooling.follows = heaters",
    "[fan] cooling.sensors = hotend",
    "[fan] cooling.temperature = 70",
];
/// A fan on the second MOSFET, controlled by the motors.
const CABINET: &[&str] = &[
    "[switch] cooling.enable = true",
    "[switch] cooling.output_pin = PI11",
    "[switch] cooling.output_type = sigmadeltapwm",
    "[fan] cooling.enable = true",
    "[fan] cooling.follows = electronics",
];
/// A fan on the second MOSFET that keeps the hot end at 60 C with as much power as needed.
const KEEPER: &[&str] = &[
    "[switch] cooling.enable = true",
    "[switch] cooling.output_pin = PI11",
    "[switch] cooling.output_type = sigmadeltapwm",
    "[fan] cooling.enable = true",
    "[fan] cooling.follows = temperature",
    "[fan] cooling.sensors = hotend",
    "[fan] cooling.temperature = 60",
    "[fan] cooling.control = pid",
    "[fan] cooling.p_factor = 1",
    "[fan] cooling.i_factor = 0.1",
    "[fan] cooling.d_factor = 5",
];
/// The part fan, with a tachometer.
const PART: &[&str] = &["[fan] fan.enable = true", "[fan] fan.tachometer_pin = PD12^"];
const KICKED: &[&str] = &["[fan] fan.enable = true", "[fan] fan.kick_start_time = 1"];
const HOT: &[&str] = &["M104 S80", "G4 S20", "M123", "M104 S0", "G4 S100", "M123"];
const FIVE: &[&str] = &["M106 S13", "M123", "M106 S128", "M123", "M106 S255", "M123", "G4 S4", "M123"];
const MOTORS: &[&str] = &["M17", "G4 S1", "M123", "M18", "G4 S1", "M123", "G4 S40", "M123"];

const RULE: &[&str] = &[
    "[temperature switch] hot.enable = true",
    "[temperature switch] hot.designator = T",
    "[temperature switch] hot.switch = fan",
    "[temperature switch] hot.heatup_poll = 1",
    "[temperature switch] hot.cooldown_poll = 1",
];
const ARMED: &[&str] = &[
    "[temperature switch] hot.enable = true",
    "[temperature switch] hot.designator = T",
    "[temperature switch] hot.switch = fan",
    "[temperature switch] hot.heatup_poll = 1",
    "[temperature switch] hot.cooldown_poll = 1",
    "[temperature switch] hot.arm_mcode = 801",
];

pub const ROWS: &[Row] = &[
    row("[fan] fan.enable", "true", "false", Say(&["M123"])),
    row("[fan] cooling.follows", "heaters", "temperature", Look(course)).with(SECOND),
    row("[fan] cooling.sensors", "hotend", "bed", Say(HOT)).with(SECOND),
    row("[fan] cooling.temperature", "70", "76", Look(course)).with(SECOND),
    row("[fan] cooling.hysteresis", "2", "15", Look(course)).with(SECOND),
    row("[fan] cooling.speed", "100", "60", Say(HOT)).with(SECOND),
    row("[fan] cooling.idle_speed", "100", "60", Say(MOTORS)).with(CABINET),
    row("[fan] cooling.linger", "30", "50", Say(MOTORS)).with(CABINET),
    row("[fan] cooling.control", "pid", "bang-bang", Look(kept)).with(KEEPER),
    row("[fan] cooling.p_factor", "1", "2", Look(kept)).with(KEEPER),
    row("[fan] cooling.i_factor", "0.1", "0", Look(kept)).with(KEEPER),
    row("[fan] cooling.d_factor", "5", "0", Look(kept)).with(KEEPER),
    row("[fan] fan.off_below", "0", "10", Say(FIVE)).with(PART),
    row("[fan] fan.min_power", "0", "10", Say(FIVE)).with(PART),
    row("[fan] fan.max_power", "100", "90", Say(FIVE)).with(PART),
    row("[fan] fan.kick_start_time", "0", "1", Say(FIVE)).with(PART),
    row("[fan] fan.kick_start_step", "50", "30", Look(steps)).with(KICKED),
    row("[fan] fan.tachometer_pin", "PD12^", "nc", Say(FIVE)).with(PART),
    row("[fan] fan.tachometer_pin", "PD12^", "PE0", Boot).with(PART),
    row("[fan] fan.pulses_per_turn", "2", "4", Say(FIVE)).with(PART),
    row("[fan] fan.min_rpm", "100", "0", Look(stopped)).with(PART),
    row("[fan] fan.stopped_after", "5", "15", Look(stopped)).with(PART),
    row("[fan] fan.when_stopped", "tell", "halt", Look(stopped)).with(PART),
    row("[temperature switch] hot.enable", "true", "false", Look(course)).with(RULE),
    row("[temperature switch] hot.designator", "T", "B", Look(course)).with(RULE),
    row("[temperature switch] hot.switch", "fan", "pump", Boot).with(RULE),
    row("[temperature switch] hot.inverted", "false", "true", Look(course)).with(RULE),
    row("[temperature switch] hot.trigger", "level", "rising", Look(course)).with(RULE),
    row("[temperature switch] hot.arm_mcode", "0", "801", Look(course)).with(RULE),
    row("[temperature switch] hot.start_armed", "false", "true", Look(course)).with(ARMED),
    row("[temperature switch] hot.threshold_temp", "50", "60", Look(course)).with(RULE),
    row("[temperature switch] hot.heatup_poll", "1", "20", Look(course)).with(RULE),
    row("[temperature switch] hot.cooldown_poll", "1", "45", Look(course)).with(RULE),
];

/// Returns the fans' speeds each second while the hot end becomes warm and cold again.
fn course(bench: &mut Bench) -> String {
    let mut said = String::new();
    for line in ["M104 S80", "M104 S0"] {
        bench.say(line);
        for _ in 0..90 {
            bench.hear(1.0);
            said += &bench.world(|world| {
                (0..world.config().fans.len()).map(|fan| format!("{:.1} ", world.fan_speed(fan))).collect::<String>()
            });
        }
    }
    said
}

/// Returns the fan's power while the hot end warms.
fn kept(bench: &mut Bench) -> String {
    bench.say("M104 S90");
    let mut said = String::new();
    for _ in 0..40 {
        bench.hear(1.0);
        said += &bench.say("M123");
    }
    said
}

/// Sets the fan to 30 % and then to 70 %, with a kick start.
fn steps(bench: &mut Bench) -> String {
    let mut said = String::new();
    for line in ["M106 S77", "M106 S178"] {
        bench.say(line);
        bench.hear(0.2);
        said += &bench.say("M123");
        bench.hear(3.0);
    }
    said
}

/// Stops a fan and returns the messages.
fn stopped(bench: &mut Bench) -> String {
    bench.world(|world| world.inject(&sim::world::Fault::FanStopped("fan".into()))).expect("a fan of this machine");
    bench.say("M106 S255");
    bench.hear(12.0)
}
