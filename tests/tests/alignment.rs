//! Z alignment (G34) on modelled gantries: motors of Z that stand wrong by known amounts, and what is left.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};
use sim::world::Fault;
use units::Actuator::{self, Delta, Epsilon, Gamma, Zeta};

const SLAVES: [&str; 3] = ["delta", "epsilon", "zeta"];
const PLACES: [&str; 4] = ["-20,0", "220,0", "220,200", "-20,200"];
/// Places for the measurement: far corners of the bed and the middle.
const LOOKED_AT: [[f64; 2]; 5] = [[5.0, 5.0], [195.0, 5.0], [195.0, 195.0], [5.0, 195.0], [100.0, 100.0]];

/// The sample with this many Z motors, at the corners; with three the last is in the middle of the rear, with
/// two they stand left and right.
fn plan(motors: usize) -> Plan {
    let mut plan = Plan::new(CARTESIAN).set("[extruder] hotend.enable = false");
    for slave in &SLAVES[..motors - 1] {
        for line in
            ["steps_per_mm = 400", "max_rate = 900", "acceleration = 200", "microsteps = 16", "slaved_to = gamma"]
        {
            plan = plan.set(&format!("[actuator] {slave}.{line}"));
        }
    }
    // Beyond the four drivers on the board there are two for external ones.
    for (slave, step, dir, enable) in [("epsilon", "PJ1", "PJ5", "PJ4"), ("zeta", "PJ7", "PJ10", "PJ9")] {
        if SLAVES[..motors - 1].contains(&slave) {
            for line in [
                "driver = external".to_string(),
                format!("step_pin = {step}"),
                format!("dir_pin = {dir}"),
                format!("en_pin = {enable}!"),
            ] {
                plan = plan.set(&format!("[actuator] {slave}.{line}"));
            }
        }
    }
    let motors = match motors {
        2 => "-20,100 220,100".to_string(),
        3 => "-20,0 220,0 100,200".to_string(),
        _ => PLACES.join(" "),
    };
    plan.set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] max_travel = 60")
        .set(&format!("[z alignment] motors = {motors}"))
        .set("[z alignment] points = 15,15 185,15 185,185 15,185")
}

fn start(plan: Plan) -> Bench {
    let mut bench = plan.start_homed();
    bench.run(&["G1 X100 Y100 Z20 F6000", "M400"]);
    bench
}

/// Moves a motor's end of the gantry by hand.
fn rack(bench: &Bench, motor: Actuator, by_mm: f64) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    let stands = bench.carriage(motor);
    bench.world(|world| world.place_carriage(at_ns, motor, stands + by_mm));
}

fn lay(bench: &Bench, surface: Surface) {
    bench.lay(surface);
}

/// Returns the spread of the gantry's height over a bed, mm.
fn unevenness(bench: &Bench, bed: &Bed, motors: usize) -> f64 {
    let gantry = bench.world(|world| world.config().gantry.clone());
    assert_eq!(gantry.pivots.len(), motors);
    let heights = LOOKED_AT.map(|[x, y]| {
        // With two motors nothing changes along Y.
        let y = if motors == 2 { 100.0 } else { y };
        gantry.height([x, y], |motor| bench.carriage(motor)) - bed.height(x, y)
    });
    heights.into_iter().fold(f64::MIN, f64::max) - heights.into_iter().fold(f64::MAX, f64::min)
}

#[test]
fn racked_motors_are_brought_level() {
    let racked: [&[(Actuator, f64)]; 3] =
        [&[(Delta, -1.3)], &[(Delta, 0.8), (Epsilon, -1.1)], &[(Delta, 0.9), (Epsilon, -0.7), (Zeta, 1.2)]];
    for (motors, racked) in (2..).zip(racked) {
        let mut bench = start(plan(motors));
        racked.iter().for_each(|(motor, mm)| rack(&bench, *motor, *mm));
        let bed = Bed::level(0.0);
        let before = unevenness(&bench, &bed, motors);
        let gamma = bench.carriage(Gamma);
        let answer = bench.say("G34");
        assert!(answer.ends_with("\nok\n") && answer.contains("they are aligned"), "{answer}");
        let after = unevenness(&bench, &bed, motors);
        println!("{motors} motors: {before:.3} mm before, {after:.4} mm after");
        assert!(before > 0.7 && after < 0.01, "{motors} motors: {after} of {before} is left\n{answer}");
        // Coordinates are the first motor's, which stayed; the tool has not moved.
        bench.run(&["G1 X100 Y100 Z20 F6000", "M400"]);
        assert!((bench.carriage(Gamma) - gamma).abs() < 1e-9);
        // All slaves follow their master again.
        let stood: Vec<f64> =
            SLAVES[..motors - 1].iter().zip([Delta, Epsilon, Zeta]).map(|(_, slave)| bench.carriage(slave)).collect();
        bench.run(&["G1 Z25 F600", "M400"]);
        for (before, slave) in stood.iter().zip([Delta, Epsilon, Zeta]) {
            assert!((bench.carriage(slave) - before - 5.0).abs() < 1e-6);
        }
    }
}

#[test]
fn what_is_off_is_said_in_words() {
    let mut bench = start(plan(3));
    rack(&bench, Delta, -0.5);
    let answer = bench.say("Z_TILT_ADJUST");
    let told = |words: &str| assert!(answer.contains(words), "{answer}");
    told("Z motor delta (front right): 0.5");
    told(" mm too low\n");
    told("Z motor epsilon (rear): ");
    told("home Z, or level, before a job\n");
}

#[test]
fn macros_see_whether_the_motors_are_aligned() {
    let text = "[z_tilt]\n[gcode_macro TELL]\ngcode: RESPOND MSG=\"{printer.z_tilt.applied}\"\n";
    let mut bench = start(plan(3).adding("\n[macros]\nfile = printer.cfg\n").file("printer.cfg", text));
    rack(&bench, Delta, -0.5);
    assert_eq!(bench.say("TELL"), "echo: False\nok\n");
    bench.say("G34");
    bench.run(&["G28 Z"]);
    assert_eq!(bench.say("TELL"), "echo: True\nok\n");
    bench.run(&["M18"]);
    assert_eq!(bench.say("TELL"), "echo: False\nok\n", "a motor without current may have been turned");
}

#[test]
fn a_bed_that_leans_and_a_probe_beside_the_tool_make_no_difference() {
    let bed = Bed::tilted(0.4, [0.004, -0.003]);
    let mut bench =
        start(plan(3).set("[zprobe] probe_offsets = 20,-10,0").set("[z alignment] points = 25,5 200,10 100,170"));
    lay(&bench, Surface { bed: Some(bed), tip_mm: [20.0, -10.0, 0.0], ..Surface::default() });
    rack(&bench, Epsilon, 0.6);
    let answer = bench.say("G34");
    assert!(answer.ends_with("\nok\n"), "{answer}");
    let after = unevenness(&bench, &bed, 3);
    assert!(after < 0.01, "{after}\n{answer}");
}

#[test]
fn a_noisy_probe_converges() {
    let mut bench = start(plan(4));
    lay(&bench, Surface { noise_mm: 0.02, ..Surface::default() });
    rack(&bench, Delta, 0.9);
    rack(&bench, Zeta, -0.8);
    let answer = bench.say("QUAD_GANTRY_LEVEL RETRY_TOLERANCE=0.05 RETRIES=20");
    assert!(answer.ends_with("\nok\n"), "{answer}");
    let after = unevenness(&bench, &Bed::level(0.0), 4);
    println!("four motors, 20 um of noise: {after:.4} mm after");
    assert!(after < 0.15, "{after}\n{answer}");
}

#[test]
fn a_stiff_bed_is_not_twisted() {
    let mut bench = start(plan(4).set("[z alignment] twist = false").set("[z alignment] retries = 1"));
    // A bed bent like a saddle would ask for a twist.
    let saddle = Surface { bed: Some(Bed::level(0.0).wavy(0.3, 800.0)), ..Surface::default() };
    lay(&bench, saddle);
    bench.say("G34");
    let [a, b, c, d] = [Gamma, Delta, Epsilon, Zeta].map(|motor| bench.carriage(motor));
    assert!((a - b + c - d).abs() < 0.006, "{a} {b} {c} {d}");
    assert!((a - b).abs() + (b - c).abs() > 0.05, "{a} {b} {c} {d}");
}

#[test]
fn motors_in_another_order_are_found_out_and_put_back() {
    let mut bench = start(plan(3).built().set("[z alignment] motors = -20,0 100,200 220,0"));
    rack(&bench, Delta, 1.0);
    let stood = [Gamma, Delta, Epsilon].map(|motor| bench.carriage(motor));
    let answer = bench.say("G34");
    assert!(
        answer.contains("They stand as before.") && answer.contains("error:the Z motors do not bring the bed level"),
        "{answer}"
    );
    bench.run(&["G1 X100 Y100 Z20 F6000", "M400"]);
    for (motor, before) in [Gamma, Delta, Epsilon].into_iter().zip(stood) {
        assert!((bench.carriage(motor) - before).abs() < 0.003, "{} {before}", motor.name());
    }
}

#[test]
fn what_cannot_be_aligned_is_refused_and_moves_no_motor() {
    let mut bench = start(plan(2).set("[z alignment] max_adjust = 2"));
    rack(&bench, Delta, -2.7);
    let (gamma, delta) = (bench.carriage(Gamma), bench.carriage(Delta));
    let answer = bench.say("G34");
    assert!(answer.contains("error:a Z motor is off by ") && answer.contains("none was moved"), "{answer}");
    assert!((bench.carriage(Gamma) - gamma - (bench.carriage(Delta) - delta)).abs() < 1e-6);
    assert!(Plan::new(CARTESIAN).start().say("G34").starts_with("error:G34 needs to know where the Z motors are"));
    let mut bench = plan(2).start();
    assert_eq!(bench.say("G34"), "error:G34 touches the bed at places of the machine: home it first\n");
    let mut bench = start(plan(2));
    bench.world(|world| world.inject(&Fault::SwitchNeverOperates("probe".into()))).expect("a probe");
    assert!(bench.say("G34").contains("error:ZProbe not triggered at X"));
    assert!(bench.status().starts_with("<Idle"));
}

#[test]
fn a_halt_while_a_motor_turns_alone_leaves_slaves_slaves() {
    let mut bench = start(plan(2));
    rack(&bench, Delta, -4.0);
    bench.type_in("G34\n");
    bench.hear_until("too low", 60.0);
    bench.hear_until("mend", 60.0);
    bench.hear(0.3);
    bench.type_in("\x18");
    bench.hear_until("ALARM: Abort", 1.0);
    bench.hear(2.0);
    bench.say("M999");
    bench.run(&["G28", "G1 Z20 F600", "M400"]);
    let (gamma, delta) = (bench.carriage(Gamma), bench.carriage(Delta));
    bench.run(&["G1 Z15", "M400"]);
    assert!((bench.carriage(Gamma) - gamma + 5.0).abs() < 1e-6 && (bench.carriage(Delta) - delta + 5.0).abs() < 1e-6);
    assert!(bench.say("G34").contains("they are aligned"));
}

#[test]
fn a_section_that_cannot_be_is_refused_at_boot() {
    for (line, told) in [
        ("motors = -20,0 220,0", "2 places are written, but the motors of Z are 3: gamma delta epsilon"),
        ("motors = -20,0 220,0 100,0", "the motors stand in one line"),
        ("points = 15,15 185,15", "2 points are too few for 3 motors"),
        ("points = 15,15 100,15 185,15", "points in one line do not tell how 3 motors stand"),
        ("points = 15,15 285,15 100,185", "at 285,15 the nozzle would be at X285, and X goes from 0 to 220"),
        ("points = 15,15 185", "has 3 numbers; places are pairs of X and Y"),
    ] {
        let mut bench = plan(3).set(&format!("[z alignment] {line}")).start();
        assert!(bench.greeting().contains(told), "{line}: {}", bench.greeting());
        let answer = bench.say("G34");
        assert!(answer.starts_with("error:") && answer.contains("config.ini, line "), "{line}: {answer}");
    }
}

/// A hold at any time stops the alignment, and a resume continues the same one.
#[test]
fn a_hold_stops_an_alignment_which_goes_on() {
    for seconds in [1.0, 7.0, 16.0, 30.0] {
        let mut bench = start(plan(2));
        rack(&bench, Delta, -2.0);
        bench.type_in("G34\n");
        let mut said = bench.hear(seconds);
        bench.type_in("!");
        said += &bench.hear(2.0);
        let edges = bench.world(|world| world.trace().total());
        said += &bench.hear(5.0);
        assert_eq!(bench.world(|world| world.trace().total()), edges, "{seconds}: {said}");
        bench.type_in("~");
        if !said.contains("they are aligned") {
            said += &bench.hear_until("they are aligned", 200.0);
        }
        assert!(!said.contains("rror"), "{seconds}: {said}");
        let apart = bench.carriage(Gamma) - bench.carriage(Delta);
        assert!(apart.abs() < 0.02, "{seconds}: {apart} mm apart");
    }
}
