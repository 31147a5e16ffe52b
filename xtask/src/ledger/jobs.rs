//! The jobs the ledger is measured with, beside those of `machines.rs`.

use std::f64::consts::TAU;
use std::fmt::Write;

/// Lines of the shorter line job.
pub const FEW: usize = 50;
/// Lines of the longer one, over the same path at the same speed.
pub const MANY: usize = 2_000;
/// Ends of the path of both line jobs, millimetres.
const PATH_MM: [f64; 3] = [50.0, 20.0, 2.0];

/// Target of each axis in a stroke. Unequal, so that motors step at moments of their own, as they do in real
/// jobs.
const STROKE: [(&str, f64); 6] = [("X", 40.0), ("Y", 39.0), ("Z", 38.0), ("E", 37.0), ("B", 36.0), ("C", 35.0)];
/// Speed of six motors at once, mm/min: so many, at 200,000 steps/s each, are what the processor can do.
const SIX_F: u32 = 12_700;

/// Strokes there and back of this many motors at once: X, then Y and Z, then the extruder, then pulsed
/// drivers. Nearly all the work is steps. `longer` times as far as is enough for the fast machine.
pub fn steps(motors: usize, longer: f64) -> String {
    let feed = if motors > 4 { SIX_F } else { 40_000 };
    let mut job = String::from("M82\n");
    for stroke in 0..2 {
        let far = |length: f64| if stroke % 2 == 0 { length * longer } else { 0.0 };
        let words: Vec<String> =
            STROKE.iter().take(motors).map(|(axis, length)| format!("{axis}{}", far(*length))).collect();
        line(&mut job, &format!("G1 {} F{feed}", words.join(" ")));
    }
    job
}

/// Strokes there and back of X, Y and Z for longer than three seconds on the printer: the drivers are asked
/// once a second.
pub fn watched() -> String {
    const STROKES: usize = 10;
    (0..STROKES).map(|stroke| if stroke % 2 == 0 { "G1 X100 Y98 Z96 F40000\n" } else { "G1 X0 Y0 Z0\n" }).collect()
}

/// A straight path cut into this many lines: two such jobs differ in lines and in nothing else.
pub fn lines(count: usize) -> String {
    path(count, "")
}

/// A straight row of half circles, to the left and to the right.
pub fn arcs(count: usize) -> String {
    let mut job = String::from("G17\nG1 F6000\n");
    let [along, ..] = PATH_MM;
    for index in 1..=count {
        let [x, radius] = [index as f64, 0.5].map(|of| along * of / count as f64);
        let turn = if index % 2 == 0 { 2 } else { 3 };
        line(&mut job, &format!("G{turn} X{x:.4} Y0 I{radius:.4} J0"));
    }
    job
}

/// The path as CAM programs write it for GRBL: without blanks, and X and Y only.
pub fn lines_of_grbl(count: usize) -> String {
    let mut job = String::from("G21\nG90\nG1F6000\n");
    for index in 1..=count {
        let [x, y, _] = PATH_MM.map(|end| end * index as f64 / count as f64);
        line(&mut job, &format!("G1X{x:.3}Y{y:.3}"));
    }
    job
}

/// The same, and one of each line's numbers has to be worked out.
pub fn lines_with_expressions(count: usize) -> String {
    format!("#1=0\n{}", path(count, "[#1 + 2*"))
}

fn path(count: usize, before: &str) -> String {
    let (before, after) = if before.is_empty() { ("", "") } else { (before, "/2]") };
    let mut job = String::from("M82\nG1 F6000\n");
    for index in 1..=count {
        let [x, y, e] = PATH_MM.map(|end| end * index as f64 / count as f64);
        line(&mut job, &format!("G1 X{before}{x:.3}{after} Y{y:.3} E{e:.5}"));
    }
    job
}

/// The same lines as the body of a subroutine, which is passed over, and then called.
pub fn lines_called(count: usize) -> String {
    format!("o100 sub\n{}o100 endsub\no100 call\n", lines(count))
}

/// A loop of so many turns between two moves, of which each counts one further.
pub fn turns(count: usize) -> String {
    format!("#1=0\nG1 X1 F6000\no100 while [#1 LT {count}]\n#1=[#1 + 1]\no100 endwhile\nG1 X2\n")
}

/// The long stroke of [`loaded`], millimetres, and the acceleration of `bench/fast.ini`, mm/s^2.
const LOADED_MM: [f64; 3] = [80.0, 78.0, 76.0];
const ACCELERATION: f64 = 20_000.0;

/// Length of the stroke, and its speed at this rate of the fastest motor (steps/s, at 1600 steps/mm).
fn loaded_pace(steps_per_s: u32) -> (f64, f64) {
    let [x, y, z] = LOADED_MM;
    let length = f64::sqrt(x * x + y * y + z * z);
    (length, f64::from(steps_per_s) / 1600.0 * length / x)
}

/// A long stroke of three axes, in short lines, with the hot end heating.
pub fn loaded(steps_per_s: u32) -> String {
    const LINES: usize = 120;
    let mut job = format!("M104 S200\nM82\nG1 F{:.0}\n", loaded_pace(steps_per_s).1 * 60.0);
    for index in 1..=LINES {
        let [x, y, z] = LOADED_MM.map(|end| end * index as f64 / LINES as f64);
        line(&mut job, &format!("G1 X{x:.4} Y{y:.4} Z{z:.4}"));
    }
    job
}

/// The time the stroke must take: from rest to rest.
pub fn loaded_seconds(steps_per_s: u32) -> f64 {
    let (length, speed) = loaded_pace(steps_per_s);
    length / speed + speed / ACCELERATION
}

/// A line of filament along X at full speed, long enough to be held in the middle.
pub fn line_of_filament() -> String {
    "M83\nG1 X100 E6 F20000\n".into()
}

/// A stroke of three axes at full speed, long enough to be held in the middle.
pub fn stroke() -> String {
    "G1 X80 Y78 Z76 F40000\n".into()
}

/// Motion that is hard on step times: corners, reversals, arcs, segments of a hundredth of a millimetre,
/// retractions. The segments come at 6000 a second: where lines come faster than they are read, the plan
/// depends on the reading, on the board as elsewhere.
pub fn hard() -> String {
    let mut job = String::from("M83\nG1 X30 Y20 F18000\n");
    for tooth in 0..20 {
        line(&mut job, &format!("G1 X{} Y{} E0.1 F12000", 30 + tooth, if tooth % 2 == 0 { 22 } else { 20 }));
    }
    job += "G1 X10 Y10 F18000\nG1 X60 Y10 E2\nG1 X10 Y10 E2\nG1 E-3 F3000\nG1 E3\nG3 X50 Y10 I20 J0 E3 F9000\nG2 X10 Y10 I-20 J0 E3\n";
    for step in 1..=1_500 {
        let turn = TAU * f64::from(step) / 1_500.0;
        line(&mut job, &format!("G1 X{:.4} Y{:.4} E0.001 F3000", 8.0 + 2.0 * turn.cos(), 10.0 + 2.0 * turn.sin()));
    }
    job += "G1 Z2 F18000\nG1 X40 Y40 Z0\n";
    job
}

fn line(job: &mut String, text: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(job, "{text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_jobs_end_at_the_same_place() {
        assert!(lines(FEW).ends_with("G1 X50.000 Y20.000 E2.00000\n"));
        assert!(lines(MANY).ends_with("G1 X50.000 Y20.000 E2.00000\n"));
        assert_eq!(lines(MANY).lines().count() - lines(FEW).lines().count(), MANY - FEW);
        assert!(lines_with_expressions(FEW).ends_with("G1 X[#1 + 2*50.000/2] Y20.000 E2.00000\n"));
    }

    #[test]
    fn strokes_move_as_many_motors_as_asked() {
        assert!(steps(1, 1.0).contains("G1 X40 F40000") && steps(4, 2.0).contains("G1 X80 Y78 Z76 E74 F40000"));
        assert!(steps(6, 0.5).contains("G1 X20 Y19.5 Z19 E18.5 B18 C17.5 F12700"));
    }

    #[test]
    fn a_loaded_stroke_has_the_rate_it_is_asked_for() {
        // 500 mm/s along X are 800,000 steps/s; the diagonal is 1.69 times as long.
        assert!(loaded(800_000).contains("G1 F506"), "{}", loaded(800_000));
        assert!((loaded_seconds(800_000) - (80.0 / 500.0 + 844.0 / ACCELERATION)).abs() < 1e-3);
    }
}
