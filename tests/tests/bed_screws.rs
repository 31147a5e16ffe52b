//! G35 on a bed whose screws are wrong: turning them as it says levels the bed.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::{Alpha, Gamma};

const SCREWS: [[f64; 2]; 4] = [[20.0, 20.0], [180.0, 20.0], [180.0, 180.0], [20.0, 180.0]];

fn plan() -> Plan {
    Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[bed screws] screws = 20,20 180,20 180,180 20,180")
        .set("[bed screws] thread = CW-M4")
}

fn lay(bench: &Bench, bed: Bed, noise_mm: f64) {
    bench.lay(Surface { bed: Some(bed), noise_mm, ..Surface::default() });
}

/// Returns the height, mm, by which turning the screw as told raises the bed.
fn raised(answer: &str, corner: &str, pitch: f64) -> f64 {
    let head = format!("Turn the {corner} screw ");
    let Some(told) = answer.lines().find_map(|line| line.strip_prefix(&head)) else { return 0.0 };
    let clock = told.split(['(', ')']).nth(1).expect("a clock in brackets");
    let (turns, minutes) = clock.split_once(':').expect("turns and minutes");
    let turns = turns.parse::<f64>().expect("a number") + minutes.parse::<f64>().expect("a number") / 60.0;
    pitch * turns * if told.contains("counterclockwise") { -1.0 } else { 1.0 }
}

#[test]
fn who_does_as_told_has_a_level_bed() {
    for (noise, allowed) in [(0.0, 0.015), (0.02, 0.1)] {
        let mut bench = plan().start_homed();
        let mut bed = Bed::tilted(0.3, [0.004, -0.0025]);
        for _ in 0..2 {
            lay(&bench, bed, noise);
            let answer = bench.say("G35");
            assert!(answer.ends_with("ok\n"), "{answer}");
            // The plane through the first screw and its two neighbours, as they stand now.
            let over = |n: usize| bed.height(SCREWS[n][0], SCREWS[n][1]);
            let [first, right, left] =
                [over(0), over(1) + raised(&answer, "front right", 0.7), over(3) + raised(&answer, "rear left", 0.7)];
            let slope = [(right - first) / 160.0, (left - first) / 160.0];
            bed = Bed::tilted(first - 20.0 * (slope[0] + slope[1]), slope);
        }
        let unevenness = (160.0 * bed.slope[0]).abs() + (160.0 * bed.slope[1]).abs();
        println!("screws, noise {noise} mm: {unevenness:.4} mm from corner to corner");
        assert!(unevenness < allowed, "{unevenness}");
    }
}

#[test]
fn it_says_which_screw_how_far_and_which_way() {
    let mut bench = plan().set("[bed screws] thread = CCW-M3").start_homed();
    // Lower by 0.25 mm on the right: half a turn.
    lay(&bench, Bed::tilted(0.5, [-0.25 / 160.0, 0.0]), 0.0);
    let answer = bench.say("SCREWS_TILT_CALCULATE");
    let told = |words: &str| assert!(answer.contains(words), "{answer}");
    told("Turn the front right screw 1/2 turn counterclockwise (00:30): the bed is 0.25");
    told("The rear left screw is right: 0.00");
    told("Leave the front left screw, turn the others, then repeat G35\n");
    lay(&bench, Bed::level(0.5), 0.0);
    assert!(bench.say("G35").contains("The bed is level: no screw is off by more than 0.00"));
}

#[test]
fn the_tool_is_lifted_before_it_goes_over_to_the_first_screw() {
    let mut bench = plan().start_homed();
    lay(&bench, Bed::level(0.0), 0.0);
    bench.run(&["G1 X100 Y100 Z0.2 F6000", "M400"]);
    bench.type_in("G35\n");
    while (bench.carriage(Alpha) - 100.0).abs() < 1.0 {
        bench.hear(0.01);
    }
    assert!(bench.carriage(Gamma) > 9.0, "{}", bench.carriage(Gamma));
}

#[test]
fn a_screw_that_the_probe_cannot_reach_is_not_tried() {
    let mut bench = plan().set("[zprobe] probe_offsets = -50,0,0").start_homed();
    lay(&bench, Bed::level(0.0), 0.0);
    let said = bench.say("G35");
    assert!(said.contains("machine X 230.000 is out of travel"), "{said}");
    assert!(bench.world(|world| world.lost_mm(Alpha)) < 1e-9, "the carriage was pushed against the frame");
}

#[test]
fn without_screws_or_homing_it_says_what_is_missing() {
    assert!(Plan::new(CARTESIAN).start().say("G35").starts_with("error:G35 needs to know where the screws are"));
    assert_eq!(plan().start().say("G35"), "error:G35 touches the bed at places of the machine: home it first\n");
    let mut bench = plan().set("[bed screws] screws = 20,20 100,20 180,20").start();
    assert!(bench.greeting().contains("these screws level nothing"), "{}", bench.greeting());
    assert!(bench.say("G35").contains("config.ini, line "));
}
