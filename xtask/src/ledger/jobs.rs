//! The jobs the ledger is measured with.

use std::fmt::Write;

/// Lines of the shorter line job.
pub const FEW: usize = 100;
/// Lines of the longer one, over the same path at the same speed.
pub const MANY: usize = 4_000;
/// Length of the path of both line jobs, millimetres.
const PATH_MM: f64 = 100.0;

/// Where each axis goes in a stroke. Unequal, so that motors step at moments of their own, as they do in real jobs.
const STROKE: [(&str, u32); 4] = [("X", 100), ("Y", 97), ("Z", 93), ("E", 89)];

/// Long strokes of this many motors at once: X, then Y and Z, then the extruder. Nearly all the work is steps.
pub fn steps(motors: usize) -> String {
    let mut job = String::from("M82\n");
    for stroke in 0..6 {
        let word = |&(axis, far): &(&str, u32)| format!("{axis}{}", if stroke % 2 == 0 { far } else { 0 });
        let words: Vec<String> = STROKE.iter().take(motors).map(word).collect();
        line(&mut job, &format!("G1 {} F18000", words.join(" ")));
    }
    job
}

/// A straight path cut into this many lines: two such jobs differ in lines and in nothing else.
pub fn lines(count: usize) -> String {
    let mut job = String::from("G1 F1200\n");
    for index in 1..=count {
        line(&mut job, &format!("G1 X{:.4}", PATH_MM * index as f64 / count as f64));
    }
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
        assert!(lines(FEW).ends_with("G1 X100.0000\n"));
        assert!(lines(MANY).ends_with("G1 X100.0000\n"));
        assert_eq!(lines(MANY).lines().count() - lines(FEW).lines().count(), MANY - FEW);
    }

    #[test]
    fn strokes_move_as_many_motors_as_asked() {
        assert!(steps(1).contains("G1 X100 F") && steps(4).contains("G1 X100 Y97 Z93 E89 F"));
    }
}
