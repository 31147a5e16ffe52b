//! Calibrating deltas whose frames are not as written: what is left afterwards, over the bed and in printed
//! parts. `cargo test -p scenarios delta_calibration:: -- --nocapture` prints the table of
//! docs/leveling.md.

use scenarios::{Bench, DELTA, Plan};
use sim::models::surface::{Bed, Surface};
use sim::world::Linkage;
use units::PerAxis;

/// Deviations of the real machine from its configuration.
const TRIMS: &[&str] = &["[endstops] common.alpha_trim_mm = 0.6", "[endstops] common.beta_trim_mm = -0.35"];
const RADIUS: &[&str] = &["[linear delta] arm_radius = 125.1"];
const ANGLES: &[&str] = &["[linear delta] delta_tower1_angle = 0.5", "[linear delta] delta_tower2_angle = -0.35"];
const TOWERS: &[&str] = &["[linear delta] delta_tower1_offset = 0.5", "[linear delta] delta_tower3_offset = -0.4"];
const LONG_ARMS: &[&str] = &["[linear delta] arm_length = 251.2"];
const UNEQUAL_ARMS: &[&str] = &[
    "[linear delta] delta_arm1_offset = 0.4",
    "[linear delta] delta_arm2_offset = -0.3",
    "[linear delta] arm_length = 250.5",
];

/// Returns a machine built so, with a configuration that knows nothing of the errors.
fn wrong(errors: &[&[&str]]) -> Plan {
    let plan = Plan::new(DELTA)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] fast_feedrate = 150")
        .set("[zprobe] max_travel = 60")
        .set("[zprobe] calibration = delta")
        .set("[delta calibration strategy] radius = 80");
    let settings = || errors.iter().flat_map(|error| error.iter());
    let built = settings().fold(plan, |plan, line| plan.set(line)).built();
    settings().fold(built, |plan, line| {
        let key = line.split(" = ").next().expect("a key");
        // The configuration gets the values of the sample again.
        match key {
            "[linear delta] arm_radius" => plan.set("[linear delta] arm_radius = 124"),
            "[linear delta] arm_length" => plan.set("[linear delta] arm_length = 250"),
            _ => plan.set(&format!("{key} = 0")),
        }
    })
}

fn start(plan: Plan, noise_mm: f64) -> Bench {
    let mut bench = plan.start();
    assert!(!bench.greeting().contains("ERROR") && !bench.greeting().contains("WARNING"), "{}", bench.greeting());
    let surface = Surface { bed: Some(Bed::level(0.0)), noise_mm, ..Surface::default() };
    bench.lay(surface);
    bench.run(&["G28", "G1 Z30 F9000", "M400"]);
    bench
}

/// Places over the bed, mm.
const PLACES: [[f64; 2]; 13] = [
    [0.0, 0.0],
    [75.0, 0.0],
    [-75.0, 0.0],
    [0.0, 75.0],
    [0.0, -75.0],
    [53.0, 53.0],
    [-53.0, 53.0],
    [-53.0, -53.0],
    [53.0, -53.0],
    [35.0, 10.0],
    [-20.0, 30.0],
    [10.0, -40.0],
    [-30.0, -20.0],
];
/// Distances measured on a part, by the indices of their ends.
const EDGES: [[usize; 2]; 6] = [[1, 2], [3, 4], [5, 7], [6, 8], [0, 1], [0, 3]];

/// Returns the true places of the tool with the program at each of these places, 10 mm high.
fn tools(bench: &mut Bench, places: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let mut found = Vec::new();
    for [x, y] in places {
        bench.run(&[&format!("G0 X{x} Y{y} Z10 F9000"), "M400"]);
        found.push(bench.world(|world| world.tool_mm()));
    }
    found
}

/// Returns the greatest difference of heights, and the greatest error of a distance on a printed part, mm.
fn errors(bench: &mut Bench) -> [f64; 2] {
    let tools = tools(bench, &PLACES);
    let heights = || tools.iter().map(|tool| tool[2]);
    let spread = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let off = |[from, to]: [usize; 2]| {
        let real = apart([tools[from][0], tools[from][1]], [tools[to][0], tools[to][1]]);
        (real - apart(PLACES[from], PLACES[to])).abs()
    };
    [spread, EDGES.into_iter().map(off).fold(0.0, f64::max)]
}

/// Prints a part and measures it with calipers that show hundredths; returns the lines that enter the
/// results.
fn measured_part(bench: &mut Bench) -> Vec<String> {
    let ring: Vec<[f64; 2]> = (0..6)
        .map(|n| (f64::from(n) * 60.0_f64 + 30.0).to_radians())
        .map(|a| [65.0 * a.cos(), 65.0 * a.sin()])
        .collect();
    let middle = [0.0, 0.0];
    let pairs = ring.iter().map(|end| [middle, *end]).chain((0..6).map(|n| [ring[n], ring[(n + 1) % 6]]));
    pairs
        .map(|[from, to]| {
            let ends = tools(bench, &[from, to]);
            let real = (ends[0][0] - ends[1][0]).hypot(ends[0][1] - ends[1][1]);
            let read = (real * 100.0).round() / 100.0;
            format!("M665.1 X{:.4} Y{:.4} I{:.4} J{:.4} S{read:.2}", from[0], from[1], to[0], to[1])
        })
        .collect()
}

/// A machine's name and errors, what is asked for, the probe's noise, and what may be left on bed and parts,
/// mm.
type Row = (&'static str, &'static [&'static [&'static str]], &'static str, f64, f64, f64);

#[test]
fn what_is_wrong_is_found_and_little_is_left() {
    println!("| machine | asked for | bed before, mm | bed after, mm | parts before, mm | parts after, mm |");
    println!("|---|---|--:|--:|--:|--:|");
    let rows: [Row; 9] = [
        ("trims off by 0.6 and -0.35 mm", &[TRIMS], "G32", 0.0, 0.05, 0.06),
        ("trims, and a radius 1.1 mm too small", &[TRIMS, RADIUS], "G32", 0.0, 0.05, 0.06),
        ("trims, radius, towers 0.5 and -0.35 degrees off", &[TRIMS, RADIUS, ANGLES], "G32 S6", 0.0, 0.05, 0.08),
        ("the same, probe with 0.02 mm of noise", &[TRIMS, RADIUS, ANGLES], "G32 S6", 0.02, 0.09, 0.15),
        ("tower radii 0.5 and -0.4 mm off", &[TRIMS, TOWERS], "G32 S6", 0.0, 0.05, 0.08),
        ("arms 1.2 mm too long", &[TRIMS, LONG_ARMS], "G32 S7", 0.0, 0.05, 0.5),
        ("arms 0.9, 0.2 and 0.5 mm too long", &[TRIMS, RADIUS, ANGLES, UNEQUAL_ARMS], "G32 S6, parts", 0.0, 0.05, 0.08),
        (
            "the same, probe with 0.02 mm of noise",
            &[TRIMS, RADIUS, ANGLES, UNEQUAL_ARMS],
            "G32 S6, parts",
            0.02,
            0.1,
            0.12,
        ),
        (
            "the same, and a second part measured",
            &[TRIMS, RADIUS, ANGLES, UNEQUAL_ARMS],
            "G32 S6, parts, parts",
            0.02,
            0.1,
            0.12,
        ),
    ];
    for (name, wrongs, asked, noise, bed, part) in rows {
        let mut bench = start(wrong(wrongs), noise);
        let [bed_before, part_before] = errors(&mut bench);
        let code = asked.split(',').next().expect("a code");
        let answer = bench.say(code);
        assert!(answer.ends_with("Calibrated. M500 saves it\nok\n"), "{name}: {answer}");
        for print in 1..=asked.matches("parts").count() {
            for line in measured_part(&mut bench) {
                assert!(bench.say(&line).contains("mm measured\nok\n"), "{line}");
            }
            let answer = bench.say("M665.2");
            assert!(
                answer.contains(&format!("{} distances: ", 12 * print)) && answer.ends_with("M500 saves it\nok\n"),
                "{answer}"
            );
            bench.run(&["G28", "G1 Z30 F9000"]);
            assert!(bench.say("G32 S6").ends_with("Calibrated. M500 saves it\nok\n"));
        }
        let [bed_after, part_after] = errors(&mut bench);
        println!("| {name} | {asked} | {bed_before:.3} | {bed_after:.3} | {part_before:.3} | {part_after:.3} |");
        assert!(bed_after < bed && part_after < part, "{name}: {bed_after} {part_after}");
    }
}

/// The simulated frame is not what the kinematics make of the same figures by one formula: both hold a tool
/// where the other does.
#[test]
fn the_simulated_frame_and_the_kinematics_agree() {
    let bench = wrong(&[RADIUS, ANGLES, TOWERS, UNEQUAL_ARMS]).start();
    let Linkage::LinearDelta(frame) = bench.world(|world| world.config().linkage) else { panic!("a delta") };
    let geometry = motion::kinematics::LinearDeltaGeometry {
        arm_length: 250.5,
        arm_offset: [0.4, -0.3, 0.0],
        arm_radius: 125.1,
        tower_offset: [0.5, 0.0, -0.4],
        tower_angle: [0.5, -0.35, 0.0],
    };
    let kinematics = motion::Kinematics::LinearDelta(motion::kinematics::LinearDelta::new(geometry));
    for [x, y] in PLACES {
        let motors = kinematics.actuators(&PerAxis([x, y, 12.5, 0.0, 0.0, 0.0]));
        let tool = frame.tool([motors.0[0], motors.0[1], motors.0[2]]);
        for (is, shall) in tool.into_iter().zip([x, y, 12.5]) {
            assert!((is - shall).abs() < 1e-9, "{tool:?} for {x} {y}");
        }
    }
}

#[test]
fn what_is_found_is_saved_and_comes_back() {
    let mut bench = start(wrong(&[TRIMS, RADIUS, ANGLES]), 0.0);
    let answer = bench.say("G32 S6");
    assert!(
        answer.contains("Towers X and Y stand 0.") && answer.contains("degrees from where they should\n"),
        "{answer}"
    );
    let saved = bench.say("M503");
    let line = saved.lines().find(|line| line.starts_with("M665 L250.00000 R125.")).expect("it is saved").to_string();
    assert!(!line.contains('I'), "arms are as written: {line}");
    bench.say("M665 I0.25");
    assert!(bench.say("M503").contains(" I0.25000 J0.00000 K0.00000\n"));
    bench.say("M665 D0 E0 R124 I0");
    bench.say(&line);
    assert!(bench.say("M503").contains(&line));
}

#[test]
fn what_was_measured_wrongly_is_refused_and_nothing_changes() {
    let mut bench = start(wrong(&[]), 0.0);
    for (line, answer) in [
        ("M665.1 X0 Y0 I50 J0", "error:M665.1 needs X Y I J, the places of both ends, and S, the measured distance\n"),
        ("M665.1 X0 Y0 I50 J0 S90", "error:50.000 mm are meant there and 90.000 mm were measured: check both\n"),
        ("M665.1", "no distances are kept: M665.1 X Y I J S\nok\n"),
        ("M665.2", "error:M665.2 needs three distances at least, in different directions, and has 0\n"),
        (
            "M665.2 S5",
            "error:S is 3 (trims), 4 (and radius), 6 (and angles), 7 (and the arms' length) or 9 (each arm's)\n",
        ),
    ] {
        assert_eq!(bench.say(line), answer, "{line}");
    }
    assert_eq!(bench.say("M665.1 X0 Y0 I50 J0 S50.1"), "distance 1: 50.000 mm meant, +0.100 mm measured\nok\n");
    assert!(bench.say("M665.1").starts_with("distance 1: 50.000 mm meant, +0.100 mm measured\n"));
    assert_eq!(bench.say("M665.3"), "no distances are kept now\nok\n");
    assert!(bench.say("M665.2").contains("and has 0"));
    assert!(Plan::new(scenarios::CARTESIAN).start().say("M665.1").starts_with("error:only a linear delta"));
}

/// Nobody has touched the bed: then it is taken for flat, and the size alone is mended.
#[test]
fn parts_alone_mend_the_size() {
    let mut bench = start(wrong(&[LONG_ARMS]), 0.0);
    let [_, before] = errors(&mut bench);
    for line in measured_part(&mut bench) {
        bench.say(&line);
    }
    let answer = bench.say("M665.2 S7");
    assert!(answer.starts_with("The bed was not touched since the start"), "{answer}");
    assert!(answer.contains("Arms: X:25"), "{answer}");
    assert!(bench.say("G28.6").starts_with("X:0 Y:0 Z:0"), "it must be homed again");
    bench.run(&["G28", "G1 Z30 F9000"]);
    let [_, after] = errors(&mut bench);
    assert!(before > 0.25 && after < 0.1, "{before} {after}");
}

#[test]
fn a_halt_in_any_round_changes_nothing() {
    for (heard, seconds) in [("X:0.0000", 0.2), ("Spread:", 1.0), ("Trim:", 6.0)] {
        let mut bench = start(wrong(&[TRIMS, RADIUS, ANGLES]), 0.0);
        bench.type_in("G32 S6\n");
        bench.hear_until(heard, 300.0);
        bench.hear(seconds);
        bench.type_in("\x18");
        bench.hear_until("ALARM: Abort", 1.0);
        bench.say("M999");
        assert!(bench.say("M503").contains("M665 L250.00000 R124.00000 A0.00000 B0.00000 C0.00000 D0.00000 E0.00000"));
        assert!(bench.say("M666").starts_with("X: 0.0000 Y: 0.0000 Z: 0.0000"));
    }
}

/// Klipper's command, with what calipers read on Klipper's part: six pillars around one, 65 mm away, and over
/// them lengths that have the width of a pillar in them.
#[test]
fn klippers_part_is_measured_by_klippers_command() {
    let mut bench = start(wrong(&[TRIMS, RADIUS, ANGLES, UNEQUAL_ARMS]), 0.0);
    assert!(bench.say("G32 S6").ends_with("Calibrated. M500 saves it\nok\n"));
    let [_, before] = errors(&mut bench);
    let at = |pillar: usize, way: f64| {
        let angle = (210.0 + 60.0 * pillar as f64).to_radians();
        [way * angle.cos(), way * angle.sin()]
    };
    let mut read = |ends: [[f64; 2]; 2], width: f64| {
        let tools = tools(&mut bench, &ends);
        format!("{:.2}", (tools[0][0] - tools[1][0]).hypot(tools[0][1] - tools[1][1]) + width)
    };
    let centre: Vec<String> =
        (0..6).map(|n| read([at(n, 4.5), at(n, 69.5)], [9.31, 9.35, 9.28][[0, 2, 1][n % 3]])).collect();
    let beside = |n: usize, way: f64| [at(n, 65.0)[0] + at(n + 2, way)[0], at(n, 65.0)[1] + at(n + 2, way)[1]];
    let outer: Vec<String> = (0..6).map(|n| read([beside(n, 4.5), beside(n, 69.5)], 9.4 + 0.01 * n as f64)).collect();
    bench.run(&[&format!("DELTA_ANALYZE CENTER_DISTS={}", centre.join(","))]);
    bench.run(&["DELTA_ANALYZE CENTER_PILLAR_WIDTHS=9.31,9.35,9.28", "DELTA_ANALYZE SCALE=1"]);
    assert!(bench.say("DELTA_ANALYZE CALIBRATE=extended").contains("of the part OUTER_DISTS (P1) is missing"));
    let widths = "OUTER_PILLAR_WIDTHS=9.40,9.41,9.42,9.43,9.44,9.45";
    let answer = bench.say(&format!("DELTA_ANALYZE OUTER_DISTS={} {widths} CALIBRATE=extended", outer.join(",")));
    assert!(answer.contains("12 distances: ") && answer.ends_with("M500 saves it\nok\n"), "{answer}");
    bench.run(&["G28", "G1 Z30 F9000"]);
    assert!(bench.say("G32 S6").ends_with("Calibrated. M500 saves it\nok\n"));
    let [bed, after] = errors(&mut bench);
    println!("parts {before:.3} mm off before, {after:.3} after, the bed {bed:.3}");
    assert!(before > 0.2 && after < 0.08 && bed < 0.05, "{before} {after} {bed}");
    for (line, why) in [
        ("DELTA_ANALYZE CENTER_DISTS=1,2,3", "needs 6 lengths for CENTER_DISTS="),
        ("DELTA_ANALYZE CENTER_PILLAR_WIDTHS=9,x,9", "needs a number for CENTER_PILLAR_WIDTHS="),
        ("DELTA_ANALYZE CALIBRATE=yes", "CALIBRATE is extended"),
        ("DELTA_ANALYZE", "needs CENTER_DISTS="),
        ("M665.4 P0 A1 B2", "six lengths"),
    ] {
        let answer = bench.say(line);
        assert!(answer.contains(why), "{line}: {answer}");
    }
}
