//! Settings of the section `[led strip]`.

use super::See::{Board, Boot, Look, Say};
use super::{Bench, Row, row};

const STRIP: &[&str] =
    &["[led strip] case.enable = true", "[led strip] case.pin = PWM2_1", "[led strip] case.chain_count = 3"];
/// A light of four switches.
const LAMP: &[&str] = &[
    "[switch] one.enable = true",
    "[switch] one.output_pin = PI11",
    "[switch] one.output_type = sigmadeltapwm",
    "[switch] two.enable = true",
    "[switch] two.output_pin = PB8",
    "[switch] two.output_type = sigmadeltapwm",
    "[led strip] lamp.enable = true",
    "[led strip] lamp.red_switch = one",
];
const SWITCHES: &[&str] = &["M150 R10 U20 B30 W40", "G4 P200", "switch one", "switch two"];

pub const ROWS: &[Row] = &[
    row("[led strip] case.enable", "true", "false", Look(lights)).with(STRIP),
    row("[led strip] case.pin", "PWM2_1", "nc", Boot).with(STRIP),
    row("[led strip] case.pin", "PWM2_1", "PWM1_3", Board("led_strips.rs")).with(STRIP),
    row("[led strip] case.chain_count", "3", "5", Say(&["M150 I4 R"])).with(STRIP),
    row("[led strip] case.color_order", "GRB", "RGB", Look(lights)).with(STRIP),
    row("[led strip] case.number", "0", "4", Say(&["M150 S4 R"])).with(STRIP),
    row("[led strip] case.brightness", "100", "40", Look(lights)).with(STRIP),
    row("[led strip] case.initial_red", "0", "0.5", Look(at_start)).with(STRIP),
    row("[led strip] case.initial_green", "0", "0.5", Look(at_start)).with(STRIP),
    row("[led strip] case.initial_blue", "0", "0.5", Look(at_start)).with(STRIP),
    row("[led strip] case.initial_white", "0", "0.5", Look(at_start)).with(&[
        "[led strip] case.enable = true",
        "[led strip] case.pin = PWM2_1",
        "[led strip] case.color_order = GRBW",
    ]),
    row("[led strip] case.shows", "codes", "state", Look(halted)).with(STRIP),
    row("[led strip] lamp.red_switch", "one", "two", Say(SWITCHES)).with(LAMP),
    row("[led strip] lamp.green_switch", "", "two", Say(SWITCHES)).with(LAMP),
    row("[led strip] lamp.blue_switch", "", "two", Say(SWITCHES)).with(LAMP),
    row("[led strip] lamp.white_switch", "", "two", Say(SWITCHES)).with(LAMP),
];

fn shown(bench: &mut Bench) -> String {
    bench.hear(0.2);
    format!("{:?}", bench.world(|world| world.strip_shows(0)))
}

fn at_start(bench: &mut Bench) -> String {
    shown(bench)
}

fn lights(bench: &mut Bench) -> String {
    bench.say("M150 R10 U200 B30");
    shown(bench)
}

fn halted(bench: &mut Bench) -> String {
    bench.say("M112");
    shown(bench) + &shown(bench) + &shown(bench) + &shown(bench)
}
