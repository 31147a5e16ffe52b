//! Residual errors of a mesh on beds with known errors: the spread of the nozzle's height over a dense grid
//! of places, before and after, under each interpolation. `-- --nocapture` prints the table that
//! docs/leveling.md holds.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::models::surface::{Bed, Surface};

const MIDDLE: [f64; 2] = [80.0, 60.0];
/// Points along X and Y: as many as a polynomial takes.
const SIDE: u32 = 6;
/// Places along X and Y at which the nozzle's height is looked at: none of them is a point.
const DENSE: [u32; 2] = [17, 13];

/// The deviation that the model is given for touches that scatter by 0.02 mm: it draws the height of the next
/// touch while the contact opens, and a high one closes it again, so high ones are rarer.
const MODELLED_MM: f64 = 0.0258;

/// Beds, and what each interpolation may leave of the spread of heights, mm: spline, bilinear, Lagrange.
fn beds() -> [(&'static str, Bed, [f64; 3]); 7] {
    let level = Bed::level(0.3);
    [
        ("tilted by 0.5 mm and 0.3 mm", Bed::tilted(0.3, [0.5 / 160.0, 0.3 / 120.0]), [0.010, 0.010, 0.012]),
        ("twisted by 0.4 mm", level.bent(MIDDLE, [0.0; 2], 0.42), [0.008, 0.008, 0.014]),
        ("a cylinder, 0.3 mm along X", level.bent(MIDDLE, [0.47, 0.0], 0.0), [0.011, 0.018, 0.008]),
        ("domed by 0.4 mm", level.bent(MIDDLE, [0.4, 0.4], 0.0), [0.015, 0.024, 0.010]),
        (
            "hollow by 0.4 mm and tilted",
            Bed::tilted(0.3, [0.002, -0.001]).bent(MIDDLE, [-0.4, -0.4], 0.0),
            [0.015, 0.024, 0.010],
        ),
        ("waves of 0.2 mm, 130 mm long", level.wavy(0.1, 130.0), [0.045, 0.085, 0.055]),
        ("a step of 0.1 mm", level.stepped(90.0, 0.1), [0.12, 0.11, 0.15]),
    ]
}

fn machine(interpolation: &str) -> Bench {
    machine_with(interpolation, "[zprobe] samples = 1")
}

fn machine_with(interpolation: &str, more: &str) -> Bench {
    let plan = Plan::new(CARTESIAN)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 160")
        .set("[cartesian grid leveling strategy] y_size = 120")
        .set(&format!("[cartesian grid leveling strategy] grid_x_size = {SIDE}"))
        .set(&format!("[cartesian grid leveling strategy] grid_y_size = {SIDE}"))
        .set(&format!("[bed mesh] interpolation = {interpolation}"));
    let more: Vec<&str> = more.split('|').collect();
    more.into_iter().fold(plan, |plan, line| plan.set(line)).start_homed()
}

fn lay(bench: &Bench, bed: Bed, noise_mm: f64) {
    bench.lay(Surface { bed: Some(bed), noise_mm, ..Surface::default() });
}

/// Greatest difference and standard deviation of the nozzle's height over the bed, mm.
fn residual(bench: &mut Bench, bed: &Bed) -> [f64; 2] {
    let mut gaps = Vec::new();
    for row in 0..DENSE[1] {
        for step in 0..DENSE[0] {
            let column = if row % 2 == 0 { step } else { DENSE[0] - 1 - step };
            let (x, y) = (2.0 + 9.7 * f64::from(column), 1.5 + 9.7 * f64::from(row));
            bench.run(&[&format!("G1 X{x:.3} Y{y:.3} Z1 F9000"), "M400"]);
            let [x, y, z] = bench.world(|world| world.tool_mm());
            gaps.push(z - bed.height(x, y));
        }
    }
    let count = gaps.len() as f64;
    let mean = gaps.iter().sum::<f64>() / count;
    let deviation = (gaps.iter().map(|gap| (gap - mean).powi(2)).sum::<f64>() / count).sqrt();
    let (least, most) = gaps.iter().fold((f64::MAX, f64::MIN), |(l, m), gap| (l.min(*gap), m.max(*gap)));
    [most - least, deviation]
}

#[test]
fn every_interpolation_takes_its_part_of_every_bed() {
    println!("| bed | before, mm | spline | bilinear | Lagrange |\n|---|--:|--:|--:|--:|");
    let mut machines = ["spline", "bilinear", "lagrange"].map(machine);
    for (name, bed, allowed) in beds() {
        let mut row = format!("| {name} |");
        for (index, (bench, allowed)) in machines.iter_mut().zip(allowed).enumerate() {
            bench.say("M370");
            bench.run(&["G1 Z10 F900", "M400"]);
            lay(bench, bed, 0.0);
            if index == 0 {
                row += &format!(" {:.3} |", residual(bench, &bed)[0]);
            }
            let answer = bench.say("G32");
            assert!(answer.ends_with("ok\n"), "{answer}");
            let [range, deviation] = residual(bench, &bed);
            row += &format!(" {range:.3} ({deviation:.4}) |");
            assert!(range <= allowed, "{name}, {index}: {range} is left");
        }
        println!("{row}");
    }
}

#[test]
fn a_noisy_probe_converges_by_several_touches() {
    println!("| touches, probe of 0.02 mm noise | left, mm | its own word |\n|---|--:|--:|");
    let bed = Bed::tilted(0.3, [0.002, -0.001]).bent(MIDDLE, [0.3, 0.2], 0.0);
    let mut deviations = Vec::new();
    for (name, settings) in [
        ("1", "[zprobe] samples = 1"),
        ("3, average", "[zprobe] samples = 3"),
        ("10, average", "[zprobe] samples = 10"),
        ("10, median", "[zprobe] samples = 10|[zprobe] samples_result = median"),
        ("30, average", "[zprobe] samples = 30|[zprobe] samples_tolerance = 0.2|[zprobe] samples_retract = 0.4"),
    ] {
        let mut bench = machine_with("spline", settings);
        lay(&bench, bed, MODELLED_MM);
        let answer = bench.say("G32");
        assert!(answer.ends_with("ok\n"), "{answer}");
        let [range, deviation] = residual(&mut bench, &bed);
        let told = answer.split("of a point ").nth(1).and_then(|text| text.split(" mm").next()).unwrap_or("-");
        println!("| {name} | {range:.3} ({deviation:.4}) | {told} |");
        if let Ok(told) = told.parse::<f64>() {
            let touches: f64 = name.split(',').next().and_then(|n| n.parse().ok()).expect("a number");
            let wanted = 0.02 / touches.sqrt() * if name.ends_with("median") { 1.253 } else { 1.0 };
            assert!((told - wanted).abs() < 0.2 * wanted, "{told} for {wanted}");
        }
        deviations.push(deviation);
    }
    assert!(deviations[1] < 0.8 * deviations[0] && deviations[2] < 0.6 * deviations[0], "{deviations:?}");
    assert!(deviations[4] < 0.35 * deviations[0] && deviations[4] < 0.006, "{deviations:?}");
}
