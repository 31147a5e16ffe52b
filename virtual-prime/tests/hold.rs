//! How soon a feed hold is felt: over many moments in several kinds of motion, from the byte on the wire to
//! the last step that is where it would have been without it.

use std::fmt::Write;

use crate::common::MS;
use crate::common::velvet::{Plan, Velvet};
use sim::trace::StepEdge;

/// What the project allows, microseconds.
const ALLOWED_US: u64 = 850;
/// With a limit of jerk the feed writes up to a millisecond ahead (`motion/src/feed_schedule.rs`); and the
/// brake begins so softly, through the shaper, that it takes another to delay a step by [`TOLERANCE_NS`].
const ALLOWED_SMOOTH_US: u64 = 2_300;
/// The ledger's fast machine: 1600 steps/mm, 20 m/s^2.
const FAST: &str = include_str!("../../bench/fast.ini");
/// Moments are so far apart, and so many: over more than the longest segment, which is half a millisecond.
const APART_US: u64 = 90;
const MOMENTS: u64 = 7;
/// An edge this near to its old time is on it: interrupts are late by so much.
const TOLERANCE_NS: u64 = 150;
/// The operator lets go on after so long.
const HELD_MS: u64 = 15;

/// A kind of motion: its file, and when the first hold comes, after the motion began.
struct Scene {
    name: &'static str,
    settings: &'static [&'static str],
    file: String,
    first_us: u64,
}

fn scene(name: &'static str, first_us: u64, file: impl Into<String>) -> Scene {
    Scene { name, settings: &[], file: file.into(), first_us }
}

/// Lines of so many millimetres each along a circle, there and back.
fn pieces(length: f64, count: u32, feed: u32) -> String {
    let mut text = format!("G1 F{feed}\n");
    for number in (1..=count).chain((0..count).rev()) {
        let angle = f64::from(number) * length / 10.0;
        let _ = writeln!(text, "G1 X{:.4} Y{:.4}", 10.0 * angle.sin(), 10.0 - 10.0 * angle.cos());
    }
    text
}

const SMOOTH: &[&str] = &[
    "[planner] jerk = 500000",
    "[input shaper] shaper_type_x = mzv",
    "[input shaper] shaper_freq_x = 50",
    "[input shaper] shaper_type_y = mzv",
    "[input shaper] shaper_freq_y = 40",
    "[extruder] hotend.pressure_advance = 0.02",
];

fn scenes() -> Vec<Scene> {
    let stroke = "G1 X8 F15000\nG1 X0\n";
    let arc = "G2 X3 Y3 I3 J0 F6000\nG3 X0 Y0 I0 J-3\n";
    vec![
        scene("full speed", 20_000, stroke),
        scene("speeding up", 3_000, stroke),
        scene("arcs", 20_000, arc),
        scene("slow", 20_000, "G1 X0.1 F60\nG1 X0\n"),
        scene("short lines", 30_000, pieces(0.05, 80, 6_000)),
        scene("just begun", 600, "G1 X4 F6000\nG1 X0\n"),
        Scene { settings: SMOOTH, ..scene("smooth", 90_000, "G1 X30 F9000\nG1 X0\n") },
        Scene { settings: SMOOTH, ..scene("smooth, arcs", 80_000, "G2 X10 Y10 I10 J0 F6000\nG3 X0 Y0 I0 J-10\n") },
        Scene { settings: SMOOTH, ..scene("smooth, short lines", 80_000, pieces(0.1, 150, 6_000)) },
    ]
}

/// The edges of one execution of the file, held so long after its first edge; and when the byte went.
fn execute(velvet: &mut Velvet, hold_after_ns: Option<u64>) -> (Vec<StepEdge>, u64) {
    velvet.world(|world| world.trace_mut().take());
    let before = velvet.said().len();
    velvet.type_in("play /sd/job.g -t");
    let mut edges = Vec::new();
    let mut sent_ns = 0;
    if let Some(after_ns) = hold_after_ns {
        while edges.is_empty() {
            velvet.hear_for(MS / 2);
            edges = velvet.world(|world| world.trace_mut().take());
        }
        let now_ns = velvet.bench.vm.now_ns();
        velvet.hear_for((edges[0].time_ns + after_ns).saturating_sub(now_ns));
        velvet.bench.console.send(b"!");
        sent_ns = velvet.bench.vm.now_ns();
        velvet.hear(HELD_MS);
        velvet.bench.console.send(b"~");
    }
    while !velvet.said()[before..].contains("Done printing file") {
        velvet.hear(5);
    }
    velvet.hear(30);
    edges.extend(velvet.world(|world| world.trace_mut().take()));
    (edges, sent_ns)
}

/// How many edges are where the reference has them, from the first one on.
fn alike(reference: &[StepEdge], edges: &[StepEdge]) -> usize {
    let since = |edges: &[StepEdge], index: usize| edges[index].time_ns - edges[0].time_ns;
    let differs = |index: &usize| {
        let (a, b) = (&reference[*index], &edges[*index]);
        (a.actuator, a.direction) != (b.actuator, b.direction)
            || since(reference, *index).abs_diff(since(edges, *index)) > TOLERANCE_NS
    };
    let count = reference.len().min(edges.len());
    (0..count).find(differs).unwrap_or(count)
}

fn latencies_us(scene: &Scene) -> Vec<u64> {
    let plan = Plan::new().config(FAST).file("job.g", &scene.file);
    let mut velvet = scene.settings.iter().fold(plan, |plan, setting| plan.set(setting)).start();
    let (reference, _) = execute(&mut velvet, None);
    let (again, _) = execute(&mut velvet, None);
    assert_eq!(alike(&reference, &again), reference.len(), "{}: not held, it is the same twice", scene.name);
    (0..MOMENTS)
        .map(|moment| {
            let (edges, sent_ns) = execute(&mut velvet, Some((scene.first_us + moment * APART_US) * 1_000));
            let on_time = alike(&reference, &edges);
            assert!(on_time > 0 && on_time < reference.len(), "{}: the hold does nothing", scene.name);
            edges[on_time - 1].time_ns.saturating_sub(sent_ns) / 1_000
        })
        .collect()
}

#[test]
fn a_hold_is_felt_within_850_microseconds_whatever_moves() {
    let mut slow = Vec::new();
    for scene in scenes() {
        let mut latencies = latencies_us(&scene);
        latencies.sort_unstable();
        let [least, median, worst] = [0, latencies.len() / 2, latencies.len() - 1].map(|at| latencies[at]);
        println!("{}: {least}, {median}, {worst} us", scene.name);
        let allowed = if scene.settings.is_empty() { ALLOWED_US } else { ALLOWED_SMOOTH_US };
        if worst > allowed {
            slow.push((scene.name, worst));
        }
    }
    assert!(slow.is_empty(), "felt after so many microseconds: {slow:?}");
}
