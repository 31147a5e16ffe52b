//! The sensor of the filament's width: M404 to M407, Klipper's commands of it, and the flow that it corrects.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta};

/// Two Hall sensors, 20 mm from the nozzle.
const SENSOR: &str = "\n[filament width sensor]\nenable = true\nadc_pin = ADC1_4\nsecond_adc_pin = ADC1_5\n\
                      measurement_delay = 20\nmax_diameter = 2\nmeasured_at_once = true\n";

/// A print of 60 mm of filament, in moves of half a millimetre of it.
fn job() -> String {
    let line = |n: u32| format!("G1 X{} Y20 E{:.1}\n", 20 + n % 2 * 10, f64::from(n) / 2.0);
    format!("G28\nG92 E0\nG1 F3000\n{}M400\n", (1..=120).map(line).collect::<String>())
}

/// Filament that is nominal, thinner and thicker, from these millimetres of it on: the filament between
/// sensor and nozzle at first is as thick as the first that is measured.
const PIECES: [(f64, f64); 4] = [(0.0, 1.75), (21.0, 1.64), (35.0, 1.86), (49.0, 1.66)];

fn printing(plan: Plan, pieces: &[(f64, f64)]) -> Bench {
    let mut bench = plan.file("part.gcode", &job()).start();
    bench.world(|world| world.thread_filament(pieces));
    bench.hear(0.5);
    bench.say("play /sd/part.gcode");
    bench
}

fn wait_for_the_print(bench: &mut Bench) {
    let end = bench.now_s() + 60.0;
    while bench.carriage(Delta) < 1.0 {
        assert!(bench.now_s() < end, "nothing is printed");
        bench.hear(0.005);
    }
}

/// Volume that comes out along the path in all, and the most that a centimetre of nominal filament is off,
/// relative to what it ought to be. The nozzle is the world's, so is the filament.
fn printed(bench: &mut Bench) -> (f64, f64) {
    let area = |diameter: f64| std::f64::consts::FRAC_PI_4 * diameter * diameter;
    wait_for_the_print(bench);
    let mut at = bench.carriage(Delta);
    let mut volume = at * area(bench.world(|world| world.filament_mm(0.0)));
    let (mut way, mut x) = (0.0, bench.carriage(Alpha));
    // A move of the part is 10 mm of way and half a millimetre of filament.
    let (mut pieces, mut last) = (Vec::new(), (0.0, volume));
    let mut rest = 0;
    while rest < 20 {
        bench.hear(0.005);
        let (now, x_now) = (bench.carriage(Delta), bench.carriage(Alpha));
        volume += area(bench.world(|world| world.filament_mm((at + now) / 2.0))) * (now - at);
        way += (x_now - x).abs();
        rest = if now == at && x == x_now { rest + 1 } else { 0 };
        (at, x) = (now, x_now);
        if way - last.0 >= 100.0 {
            pieces.push((volume - last.1) / ((way - last.0) / 10.0 * 0.5 * area(1.75)));
            last = (way, volume);
        }
    }
    let worst = pieces.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
    (volume / (60.0 * area(1.75)), worst)
}

#[test]
fn the_volume_is_as_meant_whatever_the_filament_and_is_not_without_the_correction() {
    let mut bench = printing(Plan::new(CARTESIAN).adding(SENSOR), &PIECES);
    let (whole, worst) = printed(&mut bench);
    println!("corrected: {whole:.4} of the volume, the worst 5 mm {worst:.4} off");
    assert!((whole - 1.0).abs() < 0.01, "{whole}");
    assert!(worst < 0.04, "{worst}");
    let mut without = printing(Plan::new(CARTESIAN).adding(SENSOR).adding("correct_flow = false\n"), &PIECES);
    let (_, worst) = printed(&mut without);
    println!("not corrected: the worst 5 mm {worst:.4} off");
    assert!(worst > 0.1, "{worst}");
}

/// All of it is thin: the sum of what comes out says it at once.
#[test]
fn thin_filament_is_fed_faster_and_m405_ends_that() {
    for (code, by_volume, whole_is) in [("M406", false, 1.0), ("M406", true, 1.0), ("M405", false, 0.88)] {
        let mut plan = Plan::new(CARTESIAN).adding(SENSOR);
        if by_volume {
            plan = plan.set("[extruder] hotend.filament_diameter = 1.75");
        }
        let mut bench = plan.file("part.gcode", &job()).start();
        bench.world(|world| world.thread_filament(&[(-100.0, 1.642)]));
        bench.say(code);
        if by_volume {
            bench.say("M221 S240.53");
        }
        bench.say("play /sd/part.gcode");
        let (whole, _) = printed(&mut bench);
        assert!((whole - whole_is).abs() < 0.01, "{code}, by volume {by_volume}: {whole}");
    }
}

#[test]
fn what_is_drawn_back_comes_back_and_a_push_in_place_is_a_length() {
    let mut bench = Plan::new(CARTESIAN).adding(SENSOR).start_homed();
    bench.world(|world| world.thread_filament(&[(-100.0, 1.6)]));
    bench.hear(3.0);
    bench.run(&["M83", "G1 E10 F300", "G1 X5 E-2 F3000", "G1 E2", "M400"]);
    assert!((bench.carriage(Delta) - 10.0).abs() < 0.02, "{}", bench.carriage(Delta));
    bench.run(&["G1 X15 E1", "M400"]);
    let fed = bench.carriage(Delta) - 10.0;
    assert!((fed - (1.75_f64 / 1.6).powi(2)).abs() < 0.01, "{fed}");
    bench.run(&["M405.1", "G1 X5 E1", "M400"]);
    assert!((bench.carriage(Delta) - 11.0 - fed).abs() < 0.01);
}

#[test]
fn a_piece_that_is_too_thin_or_too_thick_suspends_the_job() {
    for (diameter, text) in
        [(0.9, "the filament is too thin: its end, or a break"), (2.1, "the filament is too thick: it would jam")]
    {
        let mut bench = printing(Plan::new(CARTESIAN).adding(SENSOR), &[(0.0, 1.75), (40.0, diameter)]);
        let said = bench.hear_until("// Print Suspended", 60.0);
        assert!(said.contains(&format!("// Filament Detector: {text}: the job is being suspended")), "{said}");
        // The fault is found before that piece is at the nozzle.
        assert!(bench.carriage(Delta) < 40.6, "{}", bench.carriage(Delta));
        let said = bench.say("resume");
        assert!(said.contains(&format!("{text}: see to it, or M405 has it passed over")), "{said}");
        bench.world(|world| world.thread_filament(&[]));
        bench.hear(0.2);
        bench.type_in("resume\n");
        bench.hear_until("// Resuming print", 20.0);
        bench.run(&["M400"]);
        bench.hear(20.0);
        assert!((bench.carriage(Delta) - 60.0).abs() < 0.1, "all of it is printed: {}", bench.carriage(Delta));
    }
}

#[test]
fn a_sensor_without_a_signal_is_told_by_its_input_and_changes_no_flow() {
    let mut bench = printing(Plan::new(CARTESIAN).adding(SENSOR), &[]);
    wait_for_the_print(&mut bench);
    bench.world(|world| world.plug_filament_sensor(false));
    let said = bench.hear_until("the flow is not corrected", 1.0);
    assert!(said.contains("ERROR: filament width sensor: ADC1_4 gives no signal (10000 of 10000)"), "{said}");
    assert!(bench.say("QUERY_FILAMENT_WIDTH").contains("Filament dia: ADC1_4 gives no signal, 10000\n"));
    let (_, worst) = printed(&mut bench);
    assert!(worst < 0.04, "{worst}");
    assert!((bench.carriage(Delta) - 60.0).abs() < 0.05, "nothing was corrected, nor suspended");
    bench.world(|world| world.plug_filament_sensor(true));
    assert!(bench.hear(1.0).contains("// NOTE the filament width sensor is back"));
}

#[test]
fn it_says_what_it_measures_and_what_it_reads() {
    let mut bench = Plan::new(CARTESIAN).adding(SENSOR).start_homed();
    bench.world(|world| world.thread_filament(&[(-100.0, 1.8)]));
    bench.hear(0.2);
    let told = "Filament dia (measured mm): 1.800\nFilament width sensor is enabled, and corrects the flow\nok\n";
    assert_eq!(bench.say("M407"), told);
    assert_eq!(bench.say("QUERY_RAW_FILAMENT_WIDTH"), "ADC1_4=5050 ADC1_5=5050 RAW=10100\nok\n");
    bench.run(&["DISABLE_FILAMENT_WIDTH_SENSOR"]);
    assert!(bench.say("M407").contains("Filament width sensor is disabled"));
    bench.run(&["ENABLE_FILAMENT_WIDTH_SENSOR", "M406 D7"]);
    assert_eq!(bench.say("M404 W1.8"), "// Filament dia (nominal mm): 1.800, 70 mm from the nozzle\nok\n");
    assert!(bench.say("M404 P5").contains("there is no [filament detector]"));
    bench.say("ENABLE_FILAMENT_WIDTH_LOG");
    bench.run(&["M83"]);
    let said = bench.say("G1 E35 F600") + &bench.say("M400");
    assert!((3..=5).contains(&said.matches("// Filament width: 1.800 mm").count()), "{said}");
    bench.say("DISABLE_FILAMENT_WIDTH_LOG");
    bench.run(&["G1 E35 F600", "M400"]);
    assert!(!bench.hear(0.5).contains("Filament width"));
    assert_eq!(bench.say("M407.2 S1"), "// The filament's width is said\nok\n");
    assert_eq!(bench.say("M407.2 S0"), "// The filament's width is not said\nok\n");
    assert_eq!(bench.say("M404.1"), bench.say("RESET_FILAMENT_WIDTH_SENSOR"));
    let saved = bench.say("M503");
    assert!(saved.contains("M404 W1.8") && saved.contains("M406 D7"), "{saved}");
}

/// Until so much has passed, what lies between sensor and nozzle is nominal; or as thick as the first piece.
#[test]
fn the_first_piece_counts_when_it_is_at_the_nozzle() {
    for (at_once, first) in [("true", (1.75_f64 / 1.7).powi(2)), ("false", 1.0)] {
        let sensor = SENSOR.replace("measured_at_once = true", &format!("measured_at_once = {at_once}"));
        let mut bench = Plan::new(CARTESIAN).adding(&sensor).start_homed();
        bench.world(|world| world.thread_filament(&[(-100.0, 1.7)]));
        bench.say("RESET_FILAMENT_WIDTH_SENSOR");
        bench.hear(0.2);
        bench.run(&["M83", "G1 F3000", "G1 X10 E5", "M400"]);
        let fed = bench.carriage(Delta);
        assert!((fed - 5.0 * first).abs() < 0.02, "{at_once}: {fed}");
        bench.run(&["G1 X20 E17", "M400"]);
        let before = bench.carriage(Delta);
        bench.run(&["G1 X30 E5", "M400"]);
        let fed = bench.carriage(Delta) - before;
        assert!((fed - 5.0 * (1.75_f64 / 1.7).powi(2)).abs() < 0.02, "{at_once}: {fed}");
    }
}

#[test]
fn a_machine_without_one_says_so() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M405.1", "M406.1", "M407.1", "QUERY_RAW_FILAMENT_WIDTH", "RESET_FILAMENT_WIDTH_SENSOR"] {
        assert!(bench.say(line).contains("there is no sensor of the filament's width"), "{line}");
    }
}
