//! Settings of the section `[laser]`.

use super::See::{Board, Boot, Look, Say};
use super::{Bench, Row, row};

const LASER: &[&str] = &[
    "[general] grbl_mode = true",
    "[laser] enable = true",
    "[laser] pwm_pin = PWM2_1",
    "[laser] maximum_s_value = 1000",
    "[switch] lid.enable = true",
    "[switch] lid.input_pin = PB7^",
    "[switch] lid.io_number = 3",
    "[switch] air.enable = true",
    "[switch] air.output_pin = PB8",
    "[switch] air.output_type = digital",
    "[switch] air.input_on_command = M8",
];
const FIRE: &[&str] = &["fire 50 60000"];
const SETTINGS: &[&str] = &["$$"];

pub const ROWS: &[Row] = &[
    row("[laser] enable", "true", "false", Say(FIRE)).with(LASER),
    row("[laser] pwm_pin", "PWM2_1", "nc", Boot).with(LASER),
    row("[laser] pwm_pin", "PWM2_1", "PWM1_1", Board("laser.rs")).with(LASER),
    row("[laser] ttl_pin", "nc", "PD9", Board("laser.rs")).with(LASER),
    row("[laser] inverted_pwm", "false", "true", Board("laser.rs")).with(LASER),
    row("[laser] pullup", "true", "false", Board("laser.rs")).with(LASER),
    row("[laser] opendrain", "false", "true", Board("laser.rs")).with(LASER),
    row("[laser] pwm_frequency", "10000", "20000", Board("laser.rs")).with(LASER),
    row("[laser] maximum_power", "1", "0.5", Look(fired)).with(LASER),
    row("[laser] minimum_power", "0", "0.1", Say(SETTINGS)).with(LASER),
    row("[laser] framing_power", "0", "0.1", Look(jogged)).with(LASER),
    row("[laser] maximum_s_value", "1000", "255", Say(SETTINGS)).with(LASER),
    row("[laser] default_power", "0", "200", Say(&["M3", "$G"])).with(LASER),
    row("[laser] proportional_power", "false", "true", Say(&["M452"])).with(LASER),
    row("[laser] on_delay", "0", "50", Say(&["M452"])).with(LASER),
    row("[laser] off_delay", "0", "50", Say(&["M452"])).with(LASER),
    row("[laser] power_table", "", "0,0 0.5,0.2 1,1", Say(&["M452"])).with(LASER),
    row("[laser] hold", "off", "fade", Look(held)).with(LASER),
    row("[laser] interlock_switches", "", "lid", Look(opened)).with(LASER),
    row("[laser] air_switch", "", "air", Say(&["M3", "switch air"])).with(LASER),
];

/// Returns the duty of a beam at rest.
fn fired(bench: &mut Bench) -> String {
    bench.say("fire 50 1000");
    bench.world(|world| world.laser().duty().to_string())
}

/// Returns the greatest power along a jog.
fn jogged(bench: &mut Bench) -> String {
    bench.run(&["G28.3 X50 Y50 Z10", "M3 S500"]);
    bench.say("$J=G91 X2 F1200");
    bench.hear(1.0);
    let changes = bench.world(|world| world.trace_mut().take_power());
    changes.iter().map(|change| change.duty).max().unwrap_or_default().to_string()
}

/// Returns the powers that a hold of a burning move has.
fn held(bench: &mut Bench) -> String {
    bench.run(&["G28.3 X50 Y50 Z10", "M3 S500"]);
    bench.type_in("G1 X150 F3000\n");
    bench.hear(0.5);
    bench.world(|world| world.trace_mut().take_power());
    bench.type_in("!");
    bench.hear(0.5);
    let changes = bench.world(|world| world.trace_mut().take_power());
    changes.iter().map(|change| format!("{} ", change.duty)).collect()
}

/// Returns what is said when the lid opens.
fn opened(bench: &mut Bench) -> String {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, "lid", true)).expect("a switch of this machine");
    bench.hear(0.1)
}
