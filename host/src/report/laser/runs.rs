//! Runs of the sample laser on the native runner, held against their programs.

use std::fmt::Write as _;

use sim::models::tmc26x::Chip;
use sim::runner::{self, Job};

use super::{Findings, Sources, look};

/// The sample laser at 500 mm/s and 3000 mm/s^2 that need not be homed, in Smoothieware's dialect, with this
/// added.
fn fast_laser(more: &str) -> String {
    let changes = [
        ("= 12000", "= 30000"),
        ("_acceleration = 1500", "_acceleration = 3000"),
        (".acceleration = 1500", ".acceleration = 3000"),
        ("must_be_homed = true", "must_be_homed = false"),
        ("grbl_mode = true", "grbl_mode = false"),
    ];
    let sample = include_str!("../../../../config/samples/laser.ini").to_owned();
    changes.iter().fold(sample, |text, (piece, instead)| text.replace(piece, instead)) + more
}

/// Runs a job, and looks at its laser.
fn run(name: &str, config: &str, gcode: &str) -> Findings {
    let out = std::env::temp_dir().join(format!("velvet-laser-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&out).expect("a folder");
    let file = |name: &str, text: &str| {
        let path = out.join(name);
        std::fs::write(&path, text).expect("a file");
        path
    };
    let (config, gcode) = (file("config.ini", config), file("job.gcode", gcode));
    let job =
        Job { config, gcode, out: out.clone(), until_ns: None, chip: Chip::Tmc2590, faults: Vec::new(), verify: false };
    let outcome = runner::run(&job, &mut |_| {}).expect("it runs");
    assert_eq!((outcome.errors, outcome.halted), (Vec::new(), None), "{name}");
    let findings = look(&out, &Sources::default()).expect("a run of a laser");
    std::fs::remove_dir_all(out).expect("ours to remove");
    println!("{name}:\n{}", findings.text());
    findings
}

/// Powers of the pixels of a row.
const PIXELS: [u16; 24] =
    [1_000, 0, 150, 150, 0, 400, 0, 0, 1_000, 1_000, 1_000, 0, 30, 0, 30, 0, 700, 700, 0, 0, 0, 250, 0, 1_000];
/// Size of a pixel, mm.
const PIXEL_MM: f64 = 0.1;

/// Rows there and back at 500 mm/s, each line of pixels as `row` writes it.
fn rows(row: impl Fn(f64, f64) -> String) -> String {
    let width = PIXEL_MM * PIXELS.len() as f64;
    let mut job = String::from("G90\nM4 S0\nG1 F30000\n");
    for pair in 0..2 {
        let y = 0.2 * f64::from(pair);
        let _ = write!(job, "G1 X50 Y{y:.1} S0\n{}G1 X110 S0\n", row(50.0, PIXEL_MM));
        let _ = write!(job, "G1 X{:.1} Y{:.1}\n{}G1 X0 S0\n", 50.0 + width, y + 0.1, row(50.0 + width, -PIXEL_MM));
    }
    job + "M5\n"
}

/// A line for each pixel, and lines of pixels: every edge, in both directions.
#[test]
fn edges_of_pictures_at_500_mm_s_are_in_their_places() {
    let plain = rows(|start, way| {
        let line = |(n, s): (usize, &u16)| format!("G1 X{:.3} S{s}\n", start + way * (n + 1) as f64);
        PIXELS.iter().enumerate().map(line).collect()
    });
    let clusters = rows(|start, way| {
        let end = start + way * PIXELS.len() as f64;
        format!("G1 X{end:.3} S{}\n", PIXELS.map(|s| s.to_string()).join(":"))
    });
    for (name, job) in [("plain", plain), ("clusters", clusters)] {
        let findings = run(name, &fast_laser(""), &job);
        assert_eq!(findings.edges, 4 * 18, "{name}");
        assert!(findings.passes() && findings.worst.iter().all(|worst| *worst < 0.001), "{name}: {findings:?}");
    }
}

/// A star and a spiral, by the speed, behind shapers: as much for every millimetre, whatever the override.
#[test]
fn energy_of_stars_and_spirals_is_even_under_any_override() {
    let shapers = "\n[input shaper]\nshaper_freq_x = 45\nshaper_freq_y = 38\n";
    let turn = std::f64::consts::TAU;
    let spike = |n: u32| {
        let (sin, cos) = (turn * f64::from(n) / 7.0).sin_cos();
        format!("G1 X{:.3} Y{:.3}\nG1 X30 Y30\n", 30.0 + 15.0 * cos, 30.0 + 15.0 * sin)
    };
    let star: String = (0..7).map(spike).collect();
    let place = |n: u32| {
        let angle = 0.15 * f64::from(n);
        format!("G1 X{:.3} Y{:.3}\n", 30.0 + 0.4 * angle * angle.cos(), 30.0 + 0.4 * angle * angle.sin())
    };
    let spiral: String = (1..200).map(place).collect();
    for (name, shape) in [("star", star), ("spiral", spiral)] {
        for percent in [10, 100, 200] {
            let job = format!("M220 S{percent}\nG0 X30 Y30\nM4 S400\nG1 F6000\n{shape}M5\n");
            let findings = run(&format!("{name}-{percent}"), &fast_laser(shapers), &job);
            let [least, most] = findings.energy.expect("a path that burns");
            assert!(least > 0.97 && most < 1.03, "{name} at {percent} %: {least} to {most}");
        }
    }
}
