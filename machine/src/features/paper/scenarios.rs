//! Paper tests: what a person finds by a sheet of paper under the tool, and what becomes of it when he stops
//! halfway.

use scenarios::{Bench, CARTESIAN, DELTA, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::{Alpha, Beta, Gamma};

/// A probe 20 mm beside the tool that touches 1.8 mm lower.
const TIP: [f64; 3] = [20.0, -5.0, -1.8];

fn plan(config: &str) -> Plan {
    Plan::new(config)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
        .set("[zprobe] probe_offsets = 20,-5,0")
}

fn lay(bench: &Bench, bed: Bed) {
    bench.lay(Surface { bed: Some(bed), tip_mm: TIP, ..Surface::default() });
}

fn homed(plan: Plan) -> Bench {
    let mut bench = plan.start_homed();
    bench.run(&["G1 X60 Y70 Z20 F6000", "M400"]);
    bench
}

fn tool(bench: &Bench) -> [f64; 3] {
    bench.world(|world| world.tool_mm())
}

/// A person with a sheet of paper: says too high or too low, until it is within a hundredth.
fn feel(bench: &mut Bench, bed: Bed) {
    for _ in 0..60 {
        let [x, y, z] = tool(bench);
        let gap = z - bed.height(x, y);
        if gap.abs() < 0.004 {
            return;
        }
        let line = match gap {
            gap if gap > 1.0 => "TESTZ Z=-0.9",
            gap if gap > 0.0 => "TESTZ Z=-",
            _ => "TESTZ Z=+",
        };
        let answer = bench.say(line);
        assert!(answer.starts_with("Z: ") && answer.ends_with("ok\n"), "{answer}");
    }
    panic!("the paper was never found: {:?}", tool(bench));
}

#[test]
fn the_probes_offset_is_found_and_saved() {
    let mut bench = homed(plan(CARTESIAN));
    let bed = Bed::tilted(0.4, [0.002, -0.001]);
    lay(&bench, bed);
    let answer = bench.say("PROBE_CALIBRATE");
    assert!(answer.contains("The tool is over that place now") && answer.contains("TESTZ Z=-1"), "{answer}");
    // The tool stands over the place that the probe touched.
    assert!((bench.carriage(Alpha) - 80.0).abs() < 0.01 && (bench.carriage(Beta) - 65.0).abs() < 0.01);
    feel(&mut bench, bed);
    let answer = bench.say("ACCEPT");
    assert!(answer.starts_with("The probe's contact closes with the tool 1.8"), "{answer}");
    let saved = bench.say("M503");
    let line = saved.lines().find(|line| line.starts_with("M565 X20.00000 Y-5.00000 Z1.")).expect("saved");
    let offset: f64 = line.split('Z').nth(1).and_then(|z| z.parse().ok()).expect("a number");
    assert!((offset - 1.8).abs() < 0.012, "{offset}");
    assert!((tool(&bench)[2] - bed.height(80.0, 65.0) - 5.0).abs() < 0.02, "it is lifted");
    assert!(bench.say("ACCEPT").starts_with("error:no paper test is under way"));
}

#[test]
fn leveling_in_force_does_not_count_as_the_probes_offset() {
    let mut bench = homed(plan(CARTESIAN));
    // The leveling plane is steep: under the probe it is 0.2 mm higher than under the tool.
    let bed = Bed::tilted(0.4, [0.01, 0.0]);
    lay(&bench, bed);
    bench.run(&["M561 A-0.01 B0 C1 D0"]);
    bench.say("PROBE_CALIBRATE");
    feel(&mut bench, bed);
    let answer = bench.say("ACCEPT");
    let offset: f64 = answer.split(' ').find_map(|word| word.parse().ok()).expect("a number");
    assert!((offset - 1.8).abs() < 0.012, "{answer}");
}

#[test]
fn where_z_homes_is_found() {
    let mut bench = homed(plan(CARTESIAN));
    // The switch closes 0.73 mm too high over this bed.
    let bed = Bed::level(-0.73);
    lay(&bench, bed);
    bench.run(&["G1 Z2 F600"]);
    bench.say("z_endstop_calibrate");
    feel(&mut bench, bed);
    let answer = bench.say("ACCEPT");
    assert!(answer.contains("is zero there from the next homing on (M206 Z0.7"), "{answer}");
    assert!(bench.say("G28.6").contains("Z:0"));
    bench.run(&["G28", "G1 X60 Y70 Z5 F6000", "M400"]);
    assert!((tool(&bench)[2] - bed.height(60.0, 70.0) - 5.0).abs() < 0.01, "{:?}", tool(&bench));
}

#[test]
fn a_height_is_said_and_changes_nothing() {
    let mut bench = homed(plan(DELTA));
    let bed = Bed::level(0.25);
    lay(&bench, bed);
    bench.run(&["G1 X20 Y10 Z3 F6000", "M400"]);
    let before = bench.say("M503");
    bench.say("MANUAL_PROBE");
    feel(&mut bench, bed);
    assert!(bench.say("M851.3").starts_with("the paper drags at Z 0.2"));
    assert_eq!(bench.say("M503"), before);
}

#[test]
fn steps_are_as_asked_and_from_above() {
    let mut bench = homed(plan(CARTESIAN));
    bench.run(&["G1 Z3 F600"]);
    bench.say("M851.1 P2");
    assert_eq!(bench.say("M851.2 Z-1"), "Z: 2.000 < 3.000\nok\n");
    assert_eq!(bench.say("TESTZ Z=-"), "Z: 1.800 < 2.000\nok\n");
    assert_eq!(bench.say("TESTZ Z=+"), "Z: 1.800 < 1.900 < 2.000\nok\n");
    assert_eq!(bench.say("TESTZ Z=--"), "Z: 1.800 < 1.900\nok\n");
    assert_eq!(bench.say("TESTZ Z=30"), "error:a step of a paper test is 20 mm at most\n");
    assert!(bench.say("M851.2").starts_with("error:M851.2 needs Z"));
    assert!(bench.say("ADJUSTED").starts_with("error:ADJUSTED says that a screw was turned"));
    assert!(bench.say("PROBE_CALIBRATE").starts_with("error:a paper test is under way"));
    // Up to half a millimetre above, then down: backlash is always taken up the same way.
    let [_, most] = bench.world(|world| world.reached_mm(Gamma)).expect("Z");
    let (at_ns, here) = ((bench.now_s() * 1e9) as u64, bench.carriage(Gamma));
    bench.world(|world| world.place_carriage(at_ns, Gamma, here));
    bench.say("TESTZ Z=0.1");
    let [_, reached] = bench.world(|world| world.reached_mm(Gamma)).expect("Z");
    assert!((reached - 2.4).abs() < 0.01 && most > 2.0, "{reached}");
    assert_eq!(bench.say("M851.4"), "the paper test has ended, nothing was changed\nok\n");
    assert!((bench.carriage(Gamma) - 6.9).abs() < 0.01);
}

#[test]
fn screws_are_walked_until_each_was_left_as_it_is() {
    let mut bench = homed(plan(CARTESIAN).set("[bed screws] screws = 20,20 180,20 100,180"));
    let mut said = bench.say("BED_SCREWS_ADJUST");
    let mut visited = Vec::new();
    for answer in ["ACCEPT", "ADJUSTED", "ACCEPT", "ACCEPT"] {
        let words = said.split("Screw ").nth(1).expect("a screw");
        visited.push(words.split(':').next().expect("its name").to_string());
        let [x, y, z] = tool(&bench);
        visited.push(format!("{x:.0},{y:.0},{z:.1}"));
        said = bench.say(answer);
    }
    let walk = ["1 of 3, front left", "20,20,0.0", "2 of 3, front right", "180,20,0.0", "3 of 3, rear", "100,180,0.0"];
    assert_eq!(visited[..6], walk);
    assert_eq!(visited[6..], walk[..2], "after one was turned, the others are tried again");
    assert!(said.contains("Screw 2 of 3"), "{said}");
    let said = bench.say("ACCEPT");
    assert!(said.starts_with("every screw was left as it is: the bed is level\n"), "{said}");
    bench.say("M851.1 P3");
    assert!(bench.say("M851.5").contains("Screw 2 of 3"));
    bench.say("ABORT");
    assert!(plan(CARTESIAN).start().say("BED_SCREWS_ADJUST").contains("home it first"));
}

#[test]
fn screws_are_tried_on_the_bed_as_it_is_and_not_as_a_mesh_follows_it() {
    let mut bench = homed(plan(CARTESIAN).set("[bed screws] screws = 20,20 180,20 100,180"));
    bench.run(&["M561 A-0.002 B0 C1 D0"]);
    bench.say("BED_SCREWS_ADJUST");
    assert!(tool(&bench)[2].abs() < 0.01, "{:?}", tool(&bench));
    bench.say("ACCEPT");
    assert!(tool(&bench)[2].abs() < 0.01, "{:?}", tool(&bench));
}

#[test]
fn a_test_that_cannot_go_on_ends_and_changes_nothing() {
    let plan = plan(CARTESIAN)
        .set("[axis twist compensation] start = 30")
        .set("[axis twist compensation] end = 180")
        .set("[axis twist compensation] line = 100")
        .set("[axis twist compensation] samples = 3");
    let mut bench = homed(plan);
    let bed = Bed::level(0.2);
    lay(&bench, bed);
    bench.say("AXIS_TWIST_COMPENSATION_CALIBRATE");
    feel(&mut bench, bed);
    // The probe has come off its holder.
    lay(&bench, Bed::level(-500.0));
    let said = bench.say("ACCEPT");
    assert!(said.contains("error:ZProbe not triggered"), "{said}");
    lay(&bench, bed);
    let said = bench.say("ACCEPT");
    assert!(said.starts_with("error:no paper test is under way"), "the tool is not at any paper: {said}");
}

/// The probe hangs from a twisted rail: it reads up to 0.3 mm too high.
#[test]
fn a_twisted_axis_is_found_and_taken_off() {
    let plan = plan(CARTESIAN)
        .set("[axis twist compensation] start = 30")
        .set("[axis twist compensation] end = 180")
        .set("[axis twist compensation] line = 100")
        .set("[axis twist compensation] samples = 4")
        .set("[bed screws] screws = 40,60 180,60")
        .set("[bed screws] tolerance = 0.03");
    let mut bench = homed(plan);
    let bed = Bed::level(0.2);
    let twisted = |x: f64| Bed::level(0.2 + 0.002 * (x - 105.0));
    // The touch sees a bed that rises along X; the paper sees the real one.
    let lay_twisted = |bench: &Bench| {
        lay(bench, Bed::tilted(twisted(0.0).height_mm, [0.002, 0.0]));
    };
    bench.run(&["G1 Z20 F600"]);
    lay_twisted(&bench);
    let mut said = bench.say("AXIS_TWIST_COMPENSATION_CALIBRATE");
    for place in 1..=4 {
        assert!(said.contains(&format!("Place {place} of 4: X")), "{said}");
        feel(&mut bench, bed);
        said = bench.say("ACCEPT");
    }
    assert!(said.contains("The axis twists the probe by 0.3") || said.contains("by 0.29"), "{said}");
    let saved = bench.say("M503");
    assert_eq!(saved.matches("M851.6 X").count(), 4, "{saved}");
    // The probe touches the real bed again: as high on the left as on the right.
    let answer = bench.say("G35");
    assert!(answer.contains("The bed is level: no screw is off by more than 0.0"), "{answer}");
    bench.say("M851.6 R");
    let answer = bench.say("G35");
    assert!(answer.contains("the bed is 0.2") && answer.contains("mm too high there"), "{answer}");
}

#[test]
fn a_halt_in_any_state_ends_it_and_changes_nothing() {
    for (begin, step) in
        [("PROBE_CALIBRATE", None), ("PROBE_CALIBRATE", Some("TESTZ Z=-2")), ("BED_SCREWS_ADJUST", Some("ACCEPT"))]
    {
        for seconds in [0.05, 0.6] {
            let mut bench = homed(plan(CARTESIAN).set("[bed screws] screws = 20,20 180,20 100,180"));
            lay(&bench, Bed::level(0.0));
            let before = bench.say("M503");
            if let Some(step) = step {
                bench.say(begin);
                bench.type_in(&format!("{step}\n"));
            } else {
                bench.type_in(&format!("{begin}\n"));
            }
            bench.hear(seconds);
            bench.type_in("\x18");
            let said = bench.hear(1.0);
            assert_eq!(
                said.contains("the paper test has ended, nothing was changed"),
                step.is_some(),
                "{begin}: {said}"
            );
            bench.say("M999");
            assert!(bench.say("ACCEPT").starts_with("error:no paper test is under way"), "{begin} {step:?}");
            assert_eq!(bench.say("M503"), before);
            bench.run(&["G28"]);
        }
    }
}

#[test]
fn it_needs_a_machine_that_knows_where_it_is() {
    let mut bench = plan(CARTESIAN).start();
    for line in ["PROBE_CALIBRATE", "Z_ENDSTOP_CALIBRATE", "MANUAL_PROBE"] {
        assert!(bench.say(line).ends_with("home it first\n"), "{line}");
    }
    assert!(bench.say("TESTZ Z=-").starts_with("error:no paper test is under way"));
    let mut bench = homed(Plan::new(CARTESIAN));
    assert!(bench.say("PROBE_CALIBRATE").starts_with("error:no probe is configured"));
}

#[test]
fn skew_is_told_by_three_lengths() {
    let mut bench = homed(plan(CARTESIAN));
    // A square of 100 mm whose corner A is 89.5 degrees.
    let angle = 89.5_f64.to_radians();
    let [ac, bd] = [1.0, -1.0].map(|sign| 100.0 * (2.0 + sign * 2.0 * angle.cos()).sqrt());
    let said = bench.say(&format!("CALC_MEASURED_SKEW AC={ac:.4} BD={bd:.4} AD=100"));
    assert!(said.starts_with("The corner A is 89.500 degrees, +0.873 mm on 100 mm"), "{said}");
    assert!(bench.say("M852").contains("XY 0.00000000"), "nothing was changed");
    let said = bench.say(&format!("SET_SKEW XY={ac:.4},{bd:.4},100"));
    assert!(said.contains("Skew factors: XY 0.00872"), "{said}");
    assert!(bench.say("M503").contains("M852 I0.00872"));
    assert!(bench.say(&format!("M852 P2 A{ac:.4} B{bd:.4} D100")).contains("YZ 0.00872"));
    assert_eq!(
        bench.say("M852 A100 B300 D5"),
        "error:no nearly square figure has diagonals of 100 and 300 mm and a side of 5 mm\n"
    );
    assert!(bench.say("M852.1 A100").starts_with("error:a square needs A, B and D"));
    assert!(bench.say("SET_SKEW CLEAR=1").contains("XY 0.00000000 XZ 0.00000000 YZ 0.00000000"));
}
