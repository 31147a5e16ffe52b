//! Delta calibration: a machine whose switches and radius are not what its configuration says.

use scenarios::{Bench, DELTA, Plan};
use sim::models::surface::Bed;
use units::Actuator::{Alpha, Beta, Gamma};

use super::{assert_near, homed_delta, lay_bed, numbers};

/// Built with switches that are off by these and a wrong radius, of which the configuration knows nothing.
fn wrong() -> Plan {
    plan(DELTA)
        .set("[endstops] common.alpha_trim_mm = 0.6")
        .set("[endstops] common.beta_trim_mm = -0.35")
        .set("[linear delta] arm_radius = 124.8")
        .built()
        .set("[endstops] common.alpha_trim_mm = 0")
        .set("[endstops] common.beta_trim_mm = 0")
        .set("[linear delta] arm_radius = 124")
}

fn plan(config: &str) -> Plan {
    super::plan(config)
        .set("[zprobe] fast_feedrate = 150")
        .set("[zprobe] calibration = delta")
        .set("[delta calibration strategy] radius = 70")
}

/// Greatest difference of the tool's height over the bed at many places, all at one programmed height.
fn unevenness(bench: &mut Bench) -> f64 {
    let mut heights = Vec::new();
    for (x, y) in [(0, 0), (60, 0), (-60, 0), (0, 60), (0, -60), (40, 45), (-45, 40), (-30, -50), (50, -35)] {
        bench.run(&[&format!("G0 X{x} Y{y} Z10 F9000"), "M400"]);
        heights.push(bench.world(|world| world.tool_mm())[2]);
    }
    heights.iter().fold(f64::MIN, |most, z| most.max(*z)) - heights.iter().fold(f64::MAX, |least, z| least.min(*z))
}

#[test]
fn g32_finds_the_trims_and_the_radius() {
    let mut bench = homed_delta(wrong());
    let before = unevenness(&mut bench);
    assert!(before > 0.4, "{before}");
    let answer = bench.say("G32");
    assert!(answer.ends_with("Calibrated. M500 saves it\nok\n"), "{answer}");
    // The first round finds the trims, the second one shows that nothing is left.
    assert_eq!(answer.matches("Spread:").count(), 2, "{answer}");
    assert_eq!(answer.matches("X:").count(), 2 * 7 + 1, "{answer}");
    let found = answer.lines().find_map(|line| line.strip_prefix("Trim: ")).expect("what it found");
    let found: Vec<f64> = found.split([' ', ':']).filter_map(|word| word.parse().ok()).collect();
    assert_near(found[0] - found[2], 0.6, 0.04);
    assert_near(found[1] - found[2], -0.35, 0.04);
    assert_near(found[3], 124.8, 0.15);
    let after = unevenness(&mut bench);
    assert!(after < 0.05, "{after} of {before} is left");
    let saved = bench.say("M503");
    let word = |line: &str, letter: char| {
        let words = saved.lines().find_map(|saved| saved.strip_prefix(line)).expect("it is saved").split(' ');
        words.filter_map(|word| word.strip_prefix(letter)).find_map(|value| value.parse::<f64>().ok()).expect("a value")
    };
    assert_near(word("M665", 'R'), found[3], 0.006);
    assert_near(word("M666", 'X'), found[0], 0.0006);
    for tower in [Alpha, Beta, Gamma] {
        assert!(bench.world(|world| world.lost_mm(tower)) < 1e-9, "a carriage was pushed against the frame");
    }
}

#[test]
fn r_and_e_leave_trims_or_radius_alone() {
    let mut bench = homed_delta(wrong());
    let answer = bench.say("G32 R I0.9");
    assert!(answer.contains("Trim: X:0.0000 Y:0.0000 Z:0.0000 Radius: ") || answer.contains("Calibrated"), "{answer}");
    let mut bench = homed_delta(wrong());
    let answer = bench.say("G32 E I0.3");
    assert!(answer.contains(" Radius: 124.0000\n") && answer.contains("Calibrated"), "{answer}");
    assert_eq!(bench.say("G32 R E"), "error:G32: R leaves out the trims and E the radius, so nothing is left\n");
    assert_eq!(bench.say("G32 J0"), "error:J is a radius, above zero\n");
}

#[test]
fn g29_measures_and_changes_nothing() {
    let mut bench = homed_delta(plan(DELTA));
    lay_bed(&bench, Bed::level(0.4));
    let answer = bench.say("G29 J50");
    assert_eq!(answer.matches("X:").count(), 7, "{answer}");
    assert!(answer.contains("X:43.3013 Y:-25.0000 Z:0.39"), "{answer}");
    assert_near(numbers(&answer, "Spread:").first().copied().unwrap_or(9.0), 0.0, 0.03);
    assert_eq!(bench.say("G29 P0"), "error:No strategy found to handle G29\n");
    assert!(bench.say("G29 P1").contains("Spread:"));
    assert_eq!(bench.say("G31"), "error:No strategy found to handle G31\n");
    assert!(bench.say("M503").contains("M666 X0.00000 Y0.00000 Z0.00000\n"));
}

#[test]
fn what_cannot_be_calibrated_away_changes_nothing() {
    let mut bench = homed_delta(plan(DELTA));
    lay_bed(&bench, Bed::level(0.0).wavy(0.5, 90.0));
    let answer = bench.say("G32");
    assert!(answer.contains("error:calibration: a spread of 0.") && answer.contains("nothing was changed"), "{answer}");
    assert!(bench.say("M503").contains("M666 X0.00000 Y0.00000 Z0.00000\n"));
    assert!(bench.say("M665").contains("R: 124.0000"));
    assert!(bench.status().starts_with("<Idle"));
}

#[test]
fn a_halt_or_a_miss_in_the_middle_changes_nothing() {
    let mut bench = homed_delta(wrong());
    bench.type_in("G32\n");
    bench.hear_until("Trim:", 200.0);
    bench.hear(3.0);
    bench.type_in("\x18");
    bench.hear_until("ALARM: Abort", 1.0);
    bench.say("M999");
    assert!(bench.say("M665").contains("R: 124.0000"));
    assert!(bench.say("M666").starts_with("X: 0.0000 Y: 0.0000 Z: 0.0000"));
    let mut bench = homed_delta(plan(DELTA).set("[zprobe] max_travel = 15"));
    let answer = bench.say("G32");
    assert!(answer.starts_with("error:ZProbe not triggered at X0.000 Y0.000 on 15 mm of way\n"), "{answer}");
    assert!(bench.status().starts_with("<Idle"));
}

/// Returns the height of the tool where Z reads 10, mm.
fn height_at_z10(bench: &mut Bench) -> f64 {
    bench.run(&["G0 X0 Y0 Z10 F9000", "M400"]);
    bench.world(|world| world.tool_mm())[2]
}

#[test]
fn z_is_where_it_was_after_a_calibration_that_failed() {
    let mut bench = homed_delta(plan(DELTA));
    assert_near(height_at_z10(&mut bench), 10.0, 0.02);
    // The fourth round finds another bed: trims and radius have been changed by then.
    lay_bed(&bench, Bed::tilted(0.0, [0.01, 0.004]).bent([0.0; 2], [1.5, 1.2], 0.0));
    bench.type_in("G32\n");
    let said = bench.hear_until("Trim:", 200.0);
    assert!(said.contains("Spread:"), "{said}");
    // Beside the tool's way down: the next touch misses.
    lay_bed(&bench, Bed::level(-500.0));
    let said = bench.hear_until("error:", 200.0);
    assert!(said.contains("ZProbe not triggered"), "{said}");
    bench.hear(0.5);
    assert!(bench.say("M666").starts_with("X: 0.0000 Y: 0.0000 Z: 0.0000"));
    assert_near(height_at_z10(&mut bench), 10.0, 0.02);
}

#[test]
fn only_a_linear_delta_can_be_asked_for_it() {
    let plan = super::plan(scenarios::CARTESIAN).set("[zprobe] calibration = delta");
    let bench = plan.start();
    assert!(bench.greeting().contains("only a linear delta can be calibrated"), "{}", bench.greeting());
}
