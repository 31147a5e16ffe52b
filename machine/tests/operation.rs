//! Tests of the operator's actions: limits, kill button, buttons, suspending, saving.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta, Gamma};

const KILL: &str = "\n[kill button]\nenable = true\npin = PB7^\n";

pub(crate) fn press(bench: &mut Bench, name: &str, pressed: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, name, pressed)).expect("a button of this machine");
}

#[test]
fn a_hard_limit_halts_and_can_be_left() {
    // Soft endstops would refuse the way to the switch.
    let plan = Plan::new(CARTESIAN).set("[endstops] minx.limit_enable = true").set("[soft endstop] enable = false");
    let mut bench = plan.start();
    bench.run(&["G28", "G1 X20 F3000", "M400", "G92 X50"]);
    bench.type_in("G1 X0 F3000\n");
    let said = bench.hear_until("ALARM: Hard limit -X was hit (minx)", 3.0);
    assert!(said.contains("hard limits are disabled until all have been cleared"), "{said}");
    bench.assert_safe();
    let place = bench.carriage(Alpha);
    assert!((-2.5..=0.0).contains(&place), "stopped at {place}");
    bench.say("M999");
    bench.run(&["G91", "G1 X10 F3000"]);
    bench.hear_until("// NOTICE hard limits are now enabled\n", 5.0);
    bench.run(&["M400"]);
    assert!((bench.carriage(Alpha) - place - 10.0).abs() < 0.02);
}

#[test]
fn the_kill_button_halts_and_holding_it_releases() {
    let mut bench = Plan::new(CARTESIAN).adding(KILL).start();
    bench.type_in("G1 X60 F3000\n");
    bench.hear(0.3);
    press(&mut bench, "kill", true);
    bench.hear_until("ALARM: Kill button pressed - reset, $X or M999 to clear HALT", 0.5);
    assert!(!bench.hear(4.0).contains("UnKill"), "the press that halts must not release");
    press(&mut bench, "kill", false);
    bench.assert_safe();
    press(&mut bench, "kill", true);
    bench.hear_until("UnKill button pressed Halt cleared", 3.0);
    press(&mut bench, "kill", false);
    bench.run(&["G1 X1 F600", "M400"]);
}

/// The kill button acts as soon as it is seen, not at the next poll of all inputs.
#[test]
fn the_kill_button_is_as_fast_as_m112() {
    for delay in 0..12 {
        let mut bench = Plan::new(CARTESIAN).adding(KILL).start();
        bench.run(&["M104 S200"]);
        bench.hear(0.1 + 0.001 * f64::from(delay));
        assert!(bench.heats());
        press(&mut bench, "kill", true);
        // The runner shows pins as they are at the end of half a millisecond.
        bench.hear(0.001);
        assert!(!bench.heats(), "{delay} ms after a look");
    }
}

#[test]
fn an_input_switch_runs_its_commands() {
    let switch = "\n[switch]\nlight.enable = true\nlight.input_pin = PB7^\nlight.output_on_command = M106_S255\n\
                  light.output_off_command = M107\n";
    let mut bench = Plan::new(CARTESIAN).adding(switch).start();
    press(&mut bench, "light", true);
    bench.hear(0.1);
    assert_eq!(bench.say("switch fan"), "switch fan is 1\nok\n");
    press(&mut bench, "light", false);
    bench.hear(0.1);
    assert_eq!(bench.say("switch fan"), "switch fan is 0\nok\n");
}

#[test]
fn a_suspended_job_goes_on_where_it_was() {
    let part = "G28\nG90\nG1 X50 Y50 Z5 F6000\nM600\nG1 X60\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", part).start();
    bench.run(&["M104 S150"]);
    bench.say("M23 part.gcode");
    bench.say("M24");
    bench.hear_until("// Print Suspended, enter resume to continue printing", 30.0);
    assert_eq!(bench.say("progress"), "Suspended\nok\n");
    bench.run(&["G1 X0 Y0 F6000", "G92 E0", "M400"]);
    let resumed = bench.say("resume");
    assert!(resumed.ends_with("ok\n"), "{resumed}");
    assert!(bench.celsius("hotend") > 149.0, "resumed at {}", bench.celsius("hotend"));
    bench.hear_until("Done printing file", 30.0);
    assert!((bench.carriage(Alpha) - 60.0).abs() < 0.02);
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.01);
}

#[test]
fn abort_brakes_closes_the_file_and_leaves_a_usable_machine() {
    let part = "G28\nG90\nG1 X100 F1200\nG1 X0\n";
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", part).start();
    bench.say("play /sd/part.gcode");
    bench.hear(8.0);
    let said = bench.say("abort");
    assert!(said.starts_with("Please wait for abort to complete"), "{said}");
    let status = bench.status();
    let said: f64 = status.split("MPos:").nth(1).and_then(|rest| rest.split(',').next()).unwrap().parse().unwrap();
    assert!((bench.carriage(Alpha) - said).abs() < 0.013, "at {}, says {status}", bench.carriage(Alpha));
    bench.run(&["G1 X10 F3000", "M400"]);
    assert!((bench.carriage(Alpha) - 10.0).abs() < 0.013);
}

#[test]
fn moves_before_homing_are_refused_where_the_configuration_says_so() {
    let plan = Plan::new(CARTESIAN).with("must_be_homed = false", "must_be_homed = true");
    let mut bench = plan.start();
    let answer = bench.say("G1 X10 F600");
    assert!(answer.starts_with("Error: Must be homed before moving\nEntering Alarm/Halt state\n"), "{answer}");
    bench.say("M999");
    bench.run(&["G28", "G1 X10 F600"]);
}

#[test]
fn firmware_retraction_lifts_and_comes_back() {
    let plan = Plan::new(CARTESIAN).with("hotend.retract_zlift_length = 0", "hotend.retract_zlift_length = 1.5");
    let mut bench = plan.start();
    bench.run(&["G28", "G1 Z5 F600", "G10", "M400"]);
    assert!((bench.carriage(Gamma) - 6.5).abs() < 0.01 && (bench.carriage(Delta) + 3.0).abs() < 0.01);
    bench.run(&["G10", "G11", "M400"]);
    assert!((bench.carriage(Gamma) - 5.0).abs() < 0.01 && bench.carriage(Delta).abs() < 0.01);
}

#[test]
fn saved_settings_are_there_after_the_next_boot() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["M204 S777", "M203 X55"]);
    assert!(bench.say("M500").ends_with("Settings Stored to /sd/config-override\nok\n"));
    let saved = bench.read_card("config-override").expect("a file");
    assert!(saved.contains("M204 S777.00000") && saved.contains("M203 X55.00000"), "{saved}");
    let plan = Plan::new(CARTESIAN).with("config-override = false", "config-override = true");
    let mut bench = plan.file("config-override", &saved).start();
    bench.hear(0.5);
    assert!(bench.say("M203").starts_with(" X:55.000000 "), "{}", bench.say("M203"));
}

#[test]
fn motors_rest_at_their_standstill_current_and_work_at_full() {
    let current = |bench: &Bench| bench.world(|world| world.driver(Alpha as usize).peak_current_amps(0.05));
    let mut bench = Plan::new(CARTESIAN).adding("\n[tmc2590]\nalpha.standstill_current = 600\n").start();
    bench.run(&["G1 X5 F600", "M400"]);
    assert!((current(&bench) - 1.2).abs() < 0.2, "{}", current(&bench));
    bench.hear(11.0);
    assert!((current(&bench) - 0.6).abs() < 0.2, "{}", current(&bench));
    bench.type_in("G1 X50 F600\n");
    bench.hear(0.5);
    assert!((current(&bench) - 1.2).abs() < 0.2, "{}", current(&bench));
}

/// Pieces that lines are made of; some are nonsense.
const PIECES: [&str; 40] = [
    "G0", "G1", "G2", "G3", "G4", "G10", "G11", "G28", "G28.3", "G53", "G54", "G59.3", "G90", "G91", "G92", "M3",
    "M18", "M104", "M106", "M114", "M120", "M121", "M206", "M221", "M301", "M906", " X10", " Y-5.5", " Z.3", " E1",
    " F3000", " S20", " P1", " I5", " L20", " J", "$J X1", "*", "@", " \u{b5}",
];

/// After any line typed, the machine answers the next question.
#[test]
fn no_line_makes_the_machine_fall_silent() {
    let mut bench = Plan::new(CARTESIAN).start();
    let mut seed = 0x2545_F491_u32;
    let mut roll = |sides: usize| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 16) as usize % sides
    };
    for _ in 0..300 {
        let line: String = (0..1 + roll(5)).map(|_| PIECES[roll(PIECES.len())]).collect();
        // A full inbox drops what does not fit: then it gets half a line.
        bench.try_type(&format!("{line}\n"));
        bench.hear(0.02);
        if roll(10) == 0 {
            bench.try_type(["!", "~", "\x18", "$X\n"][roll(4)]);
        }
    }
    bench.type_in("~\x18");
    // A line still in the inbox is refused, or releases the halt once more and perhaps homes.
    bench.hear(60.0);
    bench.type_in("\n\x18");
    bench.hear(1.0);
    assert!(bench.status().starts_with("<Alarm|"));
    assert!(bench.say("M999").ends_with("ok\n"));
    assert!(bench.say("M105").starts_with("ok "));
}
