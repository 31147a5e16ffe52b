//! Jobs that begin in the middle of their file: as if the machine had come there, or not at all.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use units::Actuator::{Alpha, Beta, Delta, Gamma};

use crate::job_control::{layers, suspended};

/// Returns the places where the extruder makes steps that push.
fn pushes(bench: &mut Bench, seconds: f64) -> Vec<[i64; 3]> {
    let mut places = Vec::new();
    let mut pushed = bench.carriage(Delta);
    for _ in 0..(seconds * 200.0) as u32 {
        bench.hear(0.005);
        let now = bench.carriage(Delta);
        if now > pushed {
            places.push([Alpha, Beta, Gamma].map(|motor| (bench.carriage(motor) * 10.0).round() as i64));
        }
        pushed = now;
    }
    places
}

#[test]
fn a_job_begins_in_the_middle_as_if_it_had_come_there() {
    let file = format!("M106 S255\nM140 S40\n{}", layers(";LAYER_CHANGE"));
    // Five lines, then fifteen a layer: its mark, Z, ten that print.
    let byte = file.lines().take(41).map(|line| line.len() + 1).sum::<usize>();
    for (from, lines) in [("layer 3", 10), ("line 42", 6), (&format!("byte {byte}")[..], 6)] {
        let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
        bench.run(&["G28", "G92 E0"]);
        let before = bench.carriage(Delta);
        bench.type_in(&format!("play part.gcode -t --from {from}\n"));
        let said = bench.hear_until("// the job begins with line", 5.0);
        assert!(said.contains("the file is read up to there"), "{from}: {said}");
        bench.hear_until("Done printing file", 200.0);
        let pushed = bench.carriage(Delta) - before;
        assert!((pushed - 0.5 * f64::from(lines)).abs() < 0.02, "{from}: {pushed} mm were printed");
        assert!(bench.celsius("bed") > 38.0, "{from}: the bed was heated first");
        assert!(bench.world(|world| world.fan_speed(0)) > 0.5, "{from}: the fan is as the file had set it");
        assert!((bench.carriage(Gamma) - 0.6).abs() < 0.02);
    }
}

#[test]
fn what_is_printed_from_the_middle_is_where_it_belongs() {
    let mut whole = Plan::new(CARTESIAN).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    whole.run(&["G28"]);
    whole.type_in("play part.gcode\n");
    let all = pushes(&mut whole, 20.0);
    let mut rest = Plan::new(CARTESIAN).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    rest.run(&["G28"]);
    rest.type_in("play part.gcode --from layer 2\n");
    let some = pushes(&mut rest, 20.0);
    assert!(some.len() > 50 && some.len() < all.len());
    let heights: std::collections::BTreeSet<_> = some.iter().map(|place| place[2]).collect();
    assert_eq!(heights.into_iter().collect::<Vec<_>>(), [4, 6]);
    // Places are sampled every 5 ms, at 100 mm/s.
    let is_near = |one: &[i64; 3], other: &[i64; 3]| one.iter().zip(other).all(|(a, b)| (a - b).abs() <= 6);
    for place in some {
        assert!(all.iter().any(|other| is_near(&place, other)), "{place:?}");
    }
}

/// At its highest, where it is after homing, a delta goes nowhere else.
#[test]
fn a_delta_begins_in_the_middle_without_leaving_its_towers() {
    let mut bench = Plan::new(DELTA).file("part.gcode", &layers(";LAYER_CHANGE")).start();
    bench.run(&["G28"]);
    bench.type_in("play part.gcode -t --from layer 2\n");
    bench.hear_until("Done printing file", 200.0);
    for tower in [Alpha, Beta, Gamma] {
        assert!(bench.world(|world| world.lost_mm(tower)) < 1e-9, "not beyond the tower's end");
    }
}

/// A pause that the file asks for is one where its place is still to come, and nothing where it is not.
#[test]
fn pauses_of_the_part_that_is_read_over_come_where_they_belong() {
    let mark = ";LAYER_CHANGE\nSET_PAUSE_NEXT_LAYER";
    let file = layers(";LAYER_CHANGE").replacen(";LAYER_CHANGE", mark, 2);
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28", "G92 E0"]);
    // The first layer asks for the second, where the job begins; the second asks for the third.
    let line = file.lines().position(|line| line == "G1 Z0.4").expect("a second layer") + 3;
    bench.type_in(&format!("play part.gcode -t --from line {line}\n"));
    let said = suspended(&mut bench);
    assert!(said.contains("the job pauses at layer 3") && !said.contains("at layer 2"), "{said}");
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 60.0);
}

#[test]
fn a_job_that_cannot_begin_there_is_closed() {
    let probing = "G28\nG38.2 Z-5 F60\nG1 X5\nG1 X6\n";
    let plan = Plan::new(CARTESIAN).file("part.gcode", &layers(";x")).file("probe.ngc", probing);
    let mut bench = plan.set("[zprobe] enable = true").set("[zprobe] probe_pin = PB10^").start();
    let refused = |bench: &mut Bench, from: &str, why: &str| {
        bench.type_in(&format!("play {from}\n"));
        let said = bench.hear(2.0);
        assert!(said.contains(why), "{from}: {said}");
        assert!(bench.say("progress").contains("Not currently playing"), "{from}");
        assert!(!bench.moves() && bench.say("get mode").contains("idle"), "{from}");
    };
    refused(&mut bench, "part.gcode --from line 9", "home first");
    bench.run(&["G28"]);
    refused(&mut bench, "part.gcode --from line 900", "the file ends before this place, or marks no layers");
    refused(&mut bench, "part.gcode --from layer 2", "the file ends before this place, or marks no layers");
    refused(&mut bench, "part.gcode --from noon 2", "play takes: file --from line N, layer N or byte N");
    refused(&mut bench, "probe.ngc --from line 4", "the file probes or reads inputs before");
    bench.run(&["G1 X5 F3000", "M400"]);
    bench.say("M23 part.gcode");
    assert!(bench.say("M26 S100").contains("play file --from byte N"));
    bench.run(&["M26 S0"]);
}

/// Limits set by a file are in force for its job, and for no other one.
#[test]
fn limits_of_a_job_that_cannot_begin_there_are_put_back() {
    let file = format!("M204 S1234\nM205 X0.31\nM203 X77\nM201 X1111\nM900 K0.3\n{}", layers(";x"));
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28"]);
    let before = bench.say("M503");
    bench.type_in("play part.gcode --from line 900\n");
    bench.hear_until("the file ends before this place", 5.0);
    assert_eq!(bench.say("M503"), before);
    bench.type_in("play part.gcode -t --from line 30\n");
    bench.hear_until("Done printing file", 60.0);
    let said = bench.say("M503");
    assert!(said.contains("1234") && said.contains("0.31"), "{said}");
}

#[test]
fn nothing_is_left_heating_by_a_job_that_cannot_begin_there() {
    let file = format!("M140 S60\n{}", layers(";LAYER_CHANGE"));
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", &file).start();
    bench.run(&["G28"]);
    bench.world(|world| world.inject(&sim::world::Fault::MotorSupply(0.0))).expect("a supply");
    bench.hear(1.0);
    bench.run(&["G28.3"]);
    bench.type_in("play part.gcode --from layer 2\n");
    bench.hear_until("motor supply is off", 5.0);
    assert!(!bench.hear(3.0).contains("heats to"));
    assert!(bench.say("M105").contains("B:22.0 /0.0 "), "{}", bench.say("M105"));
}

/// A halt in any step of such a beginning (reading over, heating, rising, going there, going down) drops it.
#[test]
fn a_halt_in_any_step_of_a_beginning_in_the_middle_drops_it() {
    let file = format!("M106 S255\nM140 S40\n{}", layers(";LAYER_CHANGE"));
    let plan = || Plan::new(CARTESIAN).file("part.gcode", &file);
    let (mut bench, mut took) = (plan().start(), 0.0);
    bench.run(&["G28", "G1 X80 Y60 F6000", "M400"]);
    bench.type_in("play part.gcode --from layer 2\n");
    while !bench.moves() {
        bench.hear(0.01);
        took += 0.01;
    }
    for delay in [0.0, 0.002, 0.5, took - 0.05, took + 0.1, took + 0.4, took + 0.8, took + 1.2] {
        let mut bench = plan().start();
        bench.run(&["G28", "G1 X80 Y60 F6000", "M400"]);
        bench.type_in("play part.gcode --from layer 2\n");
        bench.hear(delay);
        bench.type_in("M112\n");
        bench.hear_until("ALARM", 1.0);
        bench.assert_safe();
        assert!(bench.say("progress").contains("Not currently playing"), "{delay}");
        bench.say("M999");
        assert!(bench.say("get mode").contains("idle"), "{delay}");
        bench.run(&["G28", "G1 X5 F3000", "M400"]);
        assert!((bench.carriage(Alpha) - 5.0).abs() < 0.05, "{delay}: the program is where the machine is");
    }
}
