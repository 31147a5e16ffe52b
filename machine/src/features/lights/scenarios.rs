//! Strips of lights: M150 and SET_LED, and what a strip shows by itself.

use scenarios::{Bench, CARTESIAN, Plan};

/// Five lights, as on the board: green comes first.
fn strip(lines: &[&str]) -> Plan {
    let plan = Plan::new(CARTESIAN)
        .set("[led strip] case.enable = true")
        .set("[led strip] case.pin = PWM2_1")
        .set("[led strip] case.chain_count = 5");
    lines.iter().fold(plan, |plan, line| plan.set(line))
}

/// Returns the colours of a strip's lights, as red, green and blue.
fn shows(bench: &mut Bench, place: usize) -> Vec<[u8; 3]> {
    bench.hear(0.1);
    let bytes = bench.world(|world| world.strip_shows(place));
    bytes.chunks(3).map(|light| [light[1], light[0], light[2]]).collect()
}

const DARK: [u8; 3] = [0; 3];
const RED: [u8; 3] = [255, 0, 0];

#[test]
fn m150_is_marlins() {
    let mut bench = strip(&["[led strip] case.initial_blue = 0.5"]).start();
    assert_eq!(shows(&mut bench, 0), [[0, 0, 128]; 5], "from the start");
    for (line, expected) in [
        ("M150 R", [RED; 5]),
        ("M150 R255 U127 B1", [[255, 127, 1]; 5]),
        ("M150 K B9", [[255, 127, 9]; 5]),
        ("M150 R255 U100 P128", [[128, 50, 0]; 5]),
        ("M150 I1 U5", [[128, 50, 0], [0, 5, 0], [128, 50, 0], [128, 50, 0], [128, 50, 0]]),
        ("M150 S0 R1", [[1, 0, 0]; 5]),
        ("M150", [DARK; 5]),
    ] {
        assert_eq!(bench.say(line), "ok\n", "{line}");
        assert_eq!(shows(&mut bench, 0), expected, "{line}");
    }
    for (line, words) in [
        ("M150 I5 R", "the strip has 5 lights, from 0 on, column 6"),
        ("M150 S1 R", "no strip has number 1 in [led strip], column 6"),
        ("M150 R256", "M150: R is 255 at most, column 6"),
    ] {
        let said = bench.say(line);
        assert!(said.contains(words), "{line}: {said}");
    }
    assert_eq!(shows(&mut bench, 0), [DARK; 5]);
}

#[test]
fn colours_change_where_the_path_has_come_to_them_and_nothing_stops() {
    let mut bench = strip(&[]).start();
    bench.say("G28.3 X0");
    bench.type_in("G1 X20 F600\nM150 R255\nG1 X40\nM150 I0 U255 Q0\n");
    bench.hear(1.0);
    // The last line acts at once.
    assert_eq!(shows(&mut bench, 0), [[0, 255, 0], DARK, DARK, DARK, DARK]);
    bench.hear(1.5);
    assert_eq!(shows(&mut bench, 0), [RED; 5], "the second move has begun");
    assert!(bench.moves());
}

#[test]
fn klipper_names_strips_and_counts_lights_from_one() {
    let mut bench = strip(&[
        "[led strip] nozzle.enable = true",
        "[led strip] nozzle.pin = PWM2_2",
        "[led strip] nozzle.chain_count = 2",
        "[general] dialect = klipper",
    ])
    .start();
    for (line, expected) in [
        ("SET_LED LED=nozzle RED=1 GREEN=0.5", [[255, 128, 0]; 2]),
        ("SET_LED LED=nozzle BLUE=1 INDEX=2", [[255, 128, 0], [0, 0, 255]]),
        ("SET_LED LED=nozzle RED=1 INDEX=1 TRANSMIT=0", [[255, 128, 0], [0, 0, 255]]),
        ("SET_LED LED=nozzle RED=1 INDEX=2", [RED; 2]),
        ("SET_LED LED=Nozzle SYNC=0", [DARK; 2]),
    ] {
        bench.say(line);
        assert_eq!(shows(&mut bench, 1), expected, "{line}");
        assert_eq!(shows(&mut bench, 0), [DARK; 5], "{line}: the other strip");
    }
    assert!(bench.say("SET_LED LED=bed RED=1").contains("names no strip of this machine"));
    assert!(bench.say("SET_LED LED=nozzle INDEX=3 RED=1").contains("the strip has 2 lights"));
}

#[test]
fn reprapfirmware_sets_one_light_after_the_other() {
    let mut bench = strip(&["[general] dialect = reprapfirmware"]).start();
    for line in ["M150 R255 S2 F1", "M150 B255 S1 F1", "M150 U255 S9 F0"] {
        bench.say(line);
    }
    assert_eq!(shows(&mut bench, 0), [RED, RED, [0, 0, 255], [0, 255, 0], [0, 255, 0]]);
    bench.say("M150 E0 R255 P51 S1");
    assert_eq!(shows(&mut bench, 0)[0], [51, 0, 0]);
}

#[test]
fn white_has_its_own_byte_and_brightness_its_bound() {
    let mut bench = strip(&["[led strip] case.color_order = GRBW", "[led strip] case.brightness = 50"]).start();
    bench.say("M150 R100 U200 W255");
    bench.hear(0.1);
    let bytes = bench.world(|world| world.strip_shows(0));
    assert_eq!(bytes.chunks(4).next(), Some(&[100, 50, 0, 128][..]));
}

#[test]
fn a_strip_shows_how_the_machine_is() {
    let job = format!("G28.3 X0 Y0 Z0\n{}", "G1 X40 F6000\nG1 X0\n".repeat(40));
    let mut bench =
        strip(&["[led strip] case.shows = state", "[led strip] case.initial_red = 1"]).file("job.g", &job).start();
    assert_eq!(shows(&mut bench, 0), [RED; 5], "what codes say, when there is nothing to see");
    bench.say("M104 S200");
    assert_eq!(shows(&mut bench, 0)[0], [255, 60, 0], "a first light of the bar");
    assert_eq!(shows(&mut bench, 0)[4], [0, 0, 40], "the rest is cold");
    bench.hear(90.0);
    assert_eq!(shows(&mut bench, 0), [RED; 5], "warm: {}", bench.say("M105"));
    bench.type_in("play /sd/job.g\n");
    bench.hear(15.0);
    let shown = shows(&mut bench, 0);
    assert_eq!((shown[0], shown[4]), ([0, 200, 0], [20, 20, 20]), "part of the file");
    bench.say("suspend");
    bench.hear(2.0);
    assert_eq!(shows(&mut bench, 0), [[255, 160, 0]; 5], "somebody is to do something");
    bench.say("M112");
    let (one, other) = (shows(&mut bench, 0), {
        bench.hear(0.4);
        shows(&mut bench, 0)
    });
    assert!([one.clone(), other.clone()].contains(&vec![RED; 5]) && one != other, "{one:?} {other:?}");
    bench.say("M999");
    bench.hear(1.0);
    assert_eq!(shows(&mut bench, 0), [RED; 5]);
}

/// A light whose colours are outputs has as much of each colour as its switch has power.
#[test]
fn a_light_may_be_made_of_switches() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[pwm1] frequency = 1000")
        .set("[switch] lamp_red.enable = true")
        .set("[switch] lamp_red.output_pin = PWM1_1")
        .set("[switch] lamp_red.output_type = hwpwm")
        .set("[switch] lamp_white.enable = true")
        .set("[switch] lamp_white.output_pin = PWM1_2")
        .set("[switch] lamp_white.output_type = hwpwm")
        .set("[led strip] lamp.enable = true")
        .set("[led strip] lamp.red_switch = lamp_red")
        .set("[led strip] lamp.white_switch = lamp_white")
        .set("[led strip] lamp.brightness = 50")
        .start();
    let shows = |bench: &mut Bench| {
        bench.hear(0.2);
        bench.world(|world| [world.pwm_duty(0, 0), world.pwm_duty(0, 1)]).map(|duty| (duty * 255.0).round())
    };
    assert_eq!(bench.say("M150 R255 W100"), "ok\n", "{}", bench.greeting());
    assert_eq!(shows(&mut bench), [128.0, 50.0]);
    bench.say("M112");
    assert_eq!(shows(&mut bench), [0.0, 0.0]);
    bench.say("M999");
    assert_eq!(shows(&mut bench), [128.0, 50.0], "as before the halt");
}

#[test]
fn without_strips_a_colour_is_passed_over() {
    let mut bench = Plan::new(CARTESIAN).set("[general] dialect = klipper").start();
    assert_eq!(bench.say("M150 R255"), "ok\n");
    assert_eq!(bench.say("SET_LED LED=any RED=1"), "ok\n");
}
