//! Reaction time of a feed hold: over many moments in several kinds of motion, from the byte on the wire to
//! the point where the motors leave the trajectory they would have gone.
//!
//! With a constant deceleration, the last step on its old time marks that point. With a limit of jerk the
//! brake begins so softly that steps are on their old times for long after; but while the jerk is constant
//! and the speed nearly so, a step's delay grows with the cube of the time since: twice as long after, it is
//! eight times as much. Two such steps tell the instant at which the delay was zero. (Left out is a delay
//! that cannot be avoided: a change of speed whose acceleration is falling already goes on to its end before
//! the brake begins.)

use std::fmt::Write;

use crate::common::MS;
use crate::common::velvet::{Plan, Velvet};
use sim::trace::StepEdge;
use units::Actuator;

/// Greatest reaction time that the project allows, microseconds.
const ALLOWED_US: u64 = 850;
/// Configuration of the ledger's fast machine: 1600 steps/mm, 20 m/s^2.
const FAST: &str = include_str!("../../bench/fast.ini");
/// Interval between the moments of the holds, and their number: together more than the longest segment, which
/// is half a millisecond.
const APART_US: u64 = 90;
const MOMENTS: u64 = 7;
/// Greatest distance of an edge from its old time that counts as on time, as interrupts are late by so much.
const TOLERANCE_NS: u64 = 150;
/// Time after which the operator ends the hold.
const HELD_MS: u64 = 15;

/// A kind of motion: its file, and the time from the motion's start to the first hold.
struct Scene {
    name: &'static str,
    settings: &'static [&'static str],
    file: String,
    first_us: u64,
}

fn scene(name: &'static str, first_us: u64, file: impl Into<String>) -> Scene {
    Scene { name, settings: &[], file: file.into(), first_us }
}

/// Returns lines of so many millimetres each along a circle, there and back.
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
        Scene { settings: SMOOTH, ..scene("smooth, speeding up", 8_000, "G1 X30 F15000\nG1 X0\n") },
        Scene { settings: SMOOTH, ..scene("smooth, arcs", 80_000, "G2 X10 Y10 I10 J0 F6000\nG3 X0 Y0 I0 J-10\n") },
        Scene { settings: SMOOTH, ..scene("smooth, short lines", 80_000, pieces(0.1, 150, 6_000)) },
    ]
}

/// Executes the file once, with a hold so long after its first edge. Returns the edges, and the instant of
/// the byte.
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

/// Returns the instant of the last edge before any motor's edge is more than the tolerance off its time in
/// the reference; both executions are counted from their first edge. `None`: all are as in the reference.
fn last_on_time_ns(reference: &[StepEdge], edges: &[StepEdge], tolerance_ns: u64) -> Option<u64> {
    let [began_before, began] = [reference, edges].map(|edges| edges[0].time_ns);
    // Motors are compared one by one: edges of two motors at the same moment may be recorded in either order.
    let first_off = Actuator::ALL.into_iter().filter_map(|actuator| {
        let [mut before, now] = [reference, edges].map(|edges| edges.iter().filter(move |e| e.actuator == actuator));
        before.by_ref().zip(now).find_map(|(before, now)| {
            let times = [before.time_ns - began_before, now.time_ns - began];
            let is_off = before.direction != now.direction || times[0].abs_diff(times[1]) > tolerance_ns;
            is_off.then_some(began + times[0].min(times[1]))
        })
    });
    let first_off_ns = first_off.min()?;
    edges.iter().map(|edge| edge.time_ns).take_while(|time_ns| *time_ns < first_off_ns).last()
}

/// Returns the instant at which the edges left the reference, within the precision of a step.
fn left_at_ns(scene: &Scene, reference: &[StepEdge], edges: &[StepEdge]) -> u64 {
    let on_time = |tolerance_ns| {
        last_on_time_ns(reference, edges, tolerance_ns)
            .unwrap_or_else(|| panic!("{}: the hold does nothing", scene.name))
    };
    let near = on_time(TOLERANCE_NS);
    if scene.settings.is_empty() { near } else { near - (on_time(8 * TOLERANCE_NS) - near) }
}

fn latencies_us(scene: &Scene) -> Vec<u64> {
    let plan = Plan::new().config(FAST).file("job.g", &scene.file);
    let mut velvet = scene.settings.iter().fold(plan, |plan, setting| plan.set(setting)).start();
    let (reference, _) = execute(&mut velvet, None);
    let (again, _) = execute(&mut velvet, None);
    assert_eq!(
        last_on_time_ns(&reference, &again, TOLERANCE_NS),
        None,
        "{}: not held, it is the same twice",
        scene.name
    );
    (0..MOMENTS)
        .map(|moment| {
            let (edges, sent_ns) = execute(&mut velvet, Some((scene.first_us + moment * APART_US) * 1_000));
            left_at_ns(scene, &reference, &edges).saturating_sub(sent_ns) / 1_000
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
        if worst > ALLOWED_US {
            slow.push((scene.name, worst));
        }
    }
    assert!(slow.is_empty(), "felt after so many microseconds: {slow:?}");
}
