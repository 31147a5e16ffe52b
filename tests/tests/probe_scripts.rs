//! Probes that are brought out and put away: a servo, a dock, an input that tells, and everything that fails
//! on the way.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::{Beta, Gamma};

fn plan() -> Plan {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
}

/// A probe in a dock at X10 Y190: over to it, a pull, and back the same way.
fn docked() -> Plan {
    plan()
        .set("[zprobe] deploy_gcode = G53 G0 Z25 G53 G0 X10 Y150 G53 G0 Y190 G53 G0 Y150")
        .set("[zprobe] stow_gcode = G53 G0 Z25 G53 G0 X10 Y190 G53 G0 X40 G53 G0 Y150")
}

/// A switch that stands for a servo.
fn servo() -> Plan {
    plan()
        .set("[switch] servofan.enable = true")
        .set("[switch] servofan.input_on_command = M280")
        .set("[switch] servofan.input_off_command = M281")
        .set("[switch] servofan.output_pin = PJ10")
        .set("[switch] servofan.output_type = digital")
        .set("[zprobe] deploy_gcode = M280 G4 P300")
        .set("[zprobe] stow_gcode = M281 G4 P300")
}

fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start_homed();
    bench.run(&["G1 X50 Y60 Z20 F6000", "M400"]);
    let surface = Surface { bed: Some(Bed::level(1.5)), ..Surface::default() };
    bench.lay(surface);
    bench
}

/// Returns the farthest place of Y since the last call.
fn farthest_y(bench: &Bench) -> f64 {
    let [_, most] = bench.world(|world| world.reached_mm(Beta)).expect("a motor");
    let (at_ns, here) = ((bench.now_s() * 1e9) as u64, bench.carriage(Beta));
    bench.world(|world| world.place_carriage(at_ns, Beta, here));
    most
}

fn is_out(bench: &mut Bench) -> bool {
    bench.say("switch servofan").contains("is 1")
}

fn press(bench: &mut Bench, out: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, "probe deployed", out)).expect("such a switch");
    bench.hear(0.05);
}

#[test]
fn the_probe_is_fetched_before_it_searches_and_brought_back_after() {
    let mut bench = homed(docked());
    farthest_y(&bench);
    bench.type_in("G91 F120 G30\n");
    let answer = bench.hear_until("ok\n", 60.0);
    let down: f64 = answer.lines().find_map(|line| line.strip_prefix("Z:")).and_then(|z| z.parse().ok()).expect("Z");
    assert!((down - 18.5).abs() < 0.003, "{answer}");
    assert!((farthest_y(&bench) - 190.0).abs() < 0.01);
    // Stowed: it stands where the script has left it, and modes are the program's own.
    let status = bench.status();
    assert!(status.contains("MPos:40.0000,150.0000,25.0000"), "{status}");
    bench.run(&["G1 X10", "M400"]);
    assert!(bench.status().contains("MPos:50.0000,150.0000,25.0000"), "G91 and F are as they were");
    bench.run(&["G90", "G1 X50 Y60 Z20 F6000", "M400"]);
    // A command of many searches fetches it once.
    let edges = bench.world(|world| world.trace().total());
    let answer = bench.say("M48 P3");
    assert_eq!(answer.matches("Z:18.5").count(), 3, "{answer}");
    assert!(bench.world(|world| world.trace().total()) > edges);
}

#[test]
fn m401_deploys_until_m402() {
    let mut bench = homed(servo());
    assert!(!is_out(&mut bench));
    bench.run(&["M401"]);
    assert!(is_out(&mut bench));
    assert!(bench.say("G30").starts_with("Z:18.5"));
    assert!(is_out(&mut bench), "G30 leaves what M401 has deployed");
    bench.run(&["M402"]);
    assert!(!is_out(&mut bench));
    bench.type_in("G30\n");
    bench.hear(0.5);
    bench.hear_until("ok\n", 20.0);
    assert!(!is_out(&mut bench), "what G30 deploys it stows");
    // A G38 search leaves the tool and the probe where the search ended, as its user counts on that place.
    let answer = bench.say("G38.2 Z-30 F300");
    assert!(
        answer.contains("[PRB:50.000,60.000,1.5") && answer.contains("// NOTE the probe is still deployed"),
        "{answer}"
    );
    assert!(is_out(&mut bench) && (bench.carriage(Gamma) - 1.5).abs() < 0.003);
    bench.run(&["G1 Z20 F600", "M402"]);
    // Other machines answer and do nothing.
    assert!(homed(plan()).say("M401").starts_with("ok"));
}

#[test]
fn a_probe_that_does_not_come_out_probes_nothing() {
    let mut bench = homed(servo().set("[zprobe] deployed_pin = PE1^").set("[switch] fan.enable = false"));
    let answer = bench.say("G30");
    assert_eq!(answer, "error:the probe is not deployed: look at it, and at deployed_pin; nothing was probed\n");
    assert!((bench.carriage(Gamma) - 20.0).abs() < 1e-9, "it searched");
    assert!(bench.status().starts_with("<Idle"));
    press(&mut bench, true);
    let answer = bench.say("G30");
    assert!(answer.starts_with("Z:18.5"), "{answer}");
    assert_eq!(bench.say("M401"), "the probe is deployed already\nok\n");
    // The probe is stuck.
    assert!(bench.say("M402").starts_with("error:the probe is still deployed: look at it"));
    press(&mut bench, false);
    bench.run(&["M402"]);
}

#[test]
fn a_probe_that_comes_off_is_noticed() {
    let mut bench = homed(servo().set("[zprobe] deployed_pin = PE1^").set("[switch] fan.enable = false"));
    press(&mut bench, true);
    bench.run(&["G4 P100"]);
    bench.say("M401");
    press(&mut bench, false);
    let answer = bench.say("G30");
    assert!(answer.starts_with("error:the probe was deployed and is not any more: has it come off?"), "{answer}");
    assert!((bench.carriage(Gamma) - 20.0).abs() < 1e-9, "it searched");
}

/// A magnetic probe reads triggered while it hangs in its dock.
#[test]
fn its_contact_may_tell_whether_it_is_out() {
    let mut bench = homed(docked().set("[zprobe] stowed_reads_triggered = true").fault("switch-always:probe@0.1"));
    let answer = bench.say("G30");
    assert!(answer.starts_with("error:the probe is not deployed"), "{answer}");
    assert!((farthest_y(&bench) - 190.0).abs() < 0.01, "it was not fetched");
}

#[test]
fn a_contact_that_is_to_open_is_no_probe_in_its_dock() {
    let mut bench = homed(docked().set("[zprobe] stowed_reads_triggered = true"));
    assert!(bench.say("G38.2 Z-30 F300").contains(":1]"));
    bench.run(&["G91", "G1 Z-0.5 F60", "G90", "M400"]);
    farthest_y(&bench);
    assert!(bench.say("G38.4 Z5 F60").contains("[PRB:50.000,60.000,1.5"));
    assert!(farthest_y(&bench) < 61.0, "it was fetched again");
}

#[test]
fn one_that_reads_triggered_too_early_is_told_with_what_to_look_at() {
    let mut bench = homed(servo().fault("switch-always:probe@0.1"));
    let answer = bench.say("G30");
    assert!(
        answer.starts_with("error:the probe reads triggered before it touches: is it out, is its wire whole?"),
        "{answer}"
    );
    assert!((bench.carriage(Gamma) - 20.0).abs() < 1e-9, "it searched");
    assert!(!is_out(&mut bench), "it is stowed all the same");
}

#[test]
fn what_no_script_may_do_is_refused() {
    for (script, says) in [
        ("G28", "error:[zprobe] deploy_gcode: G28 is none of moves, waits, modes and switches\n"),
        ("M104 S200", "error:[zprobe] deploy_gcode: M104 heats: a probe's script does not\n"),
        ("M9999", "error:[zprobe] deploy_gcode: M9999 is not known here\n"),
        ("G0 X900", "X 900"),
    ] {
        let plan = servo().set(&format!("[zprobe] deploy_gcode = {script}")).set("[soft endstop] enable = true");
        let mut bench = homed(plan);
        let answer = bench.say("G30");
        assert!(answer.contains(says), "{script}: {answer}");
        assert!((bench.carriage(Gamma) - 20.0).abs() < 1e-9, "{script}: it searched");
    }
    let bench = plan().set("[zprobe] deploy_gcode = M280").start();
    assert!(
        bench.greeting().contains("deploy_gcode moves the probe, and nothing moves it back"),
        "{}",
        bench.greeting()
    );
}

#[test]
fn after_a_halt_anywhere_nothing_moves_and_m402_stows() {
    // In deploying, in the search, in stowing.
    for (seconds, is_known) in [(0.1, false), (1.5, true), (5.2, true)] {
        let mut bench = homed(servo());
        bench.type_in("G30\n");
        bench.hear(seconds);
        bench.type_in("\x18");
        let said = bench.hear(1.0);
        assert_eq!(said.contains("the probe is still deployed: M402 stows it"), is_known, "{seconds}: {said}");
        let is_open = said.contains("deploy_gcode has not come to its end: look whether the probe is out");
        assert_eq!(is_open, !is_known, "{seconds}: {said}");
        let edges = bench.world(|world| world.trace().total());
        bench.hear(1.0);
        assert_eq!(bench.world(|world| world.trace().total()), edges);
        bench.say("M999");
        bench.run(&["G28"]);
        if is_open {
            assert!(bench.say("G30").contains("whether the probe is out is not known: look at it, then M401 or M402"));
        }
        bench.run(&["M402", "G1 Z20 F600", "M400"]);
        assert!(!is_out(&mut bench));
        assert!(bench.say("G30").starts_with("Z:18.5"));
    }
}

#[test]
fn m851_is_m565_as_marlin_counts_it() {
    let mut bench = homed(plan());
    assert_eq!(bench.say("M851 X-22 Y3.5 Z-1.25"), "M851 X-22.0000 Y3.5000 Z-1.2500\nok\n");
    assert_eq!(bench.say("M565"), "Probe offsets: X:-22.0000 Y:3.5000 Z:1.2500\nok\n");
    assert!(bench.say("M503").contains("M565 X-22.00000 Y3.50000 Z1.25000\n"));
}
