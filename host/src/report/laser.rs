//! `velvet laser`: places of a laser's edges against the program's, energy along the path, and the picture
//! that the edges make.
//!
//! Places come from the motors' steps: between two steps a motor is taken to move evenly, so a place is good
//! to a small part of a step at speed.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result, bail};
use units::MAX_ACTUATORS;

use super::checks;
use super::edges::{Executed, Track, TrackReader};
use super::machine::Machine;
use super::power::{self, Change};
use super::program::{Program, Vertex};
use super::{Sources, found};

/// Greatest distance of an edge from its place, mm.
const MOST_OFF_MM: f64 = 0.01;
/// Length over which energy is taken, mm.
const WINDOW_MM: f64 = 1.0;
/// Time between places along the path, nanoseconds.
const STEP_NS: u64 = 50_000;
/// Greatest size of the picture's longer side, picture units for a mm.
const SCALE: f64 = 10.0;
/// File of the picture in a run's folder.
const PICTURE: &str = "laser.svg";

/// Edge of the power between nothing and something.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    at: [f64; 3],
    is_on: bool,
}

/// Findings about a run's laser.
#[derive(Debug, Default, PartialEq)]
struct Findings {
    /// Edges that were compared, and distance of the worst of each kind from its place, mm: with X (or else
    /// Y) going up, and going down.
    edges: usize,
    worst: [f64; 2],
    /// Number of edges in the run and in the program.
    counts: [usize; 2],
    /// Least and greatest energy for a millimetre, over its mean; none where nothing burns for a millimetre,
    /// or the program asks for more than one.
    energy: Option<[f64; 2]>,
}

/// Places of the machine over time.
struct Places<'a> {
    readers: Vec<TrackReader<'a>>,
    machine: &'a Machine,
    origin: [f64; MAX_ACTUATORS],
}

impl<'a> Places<'a> {
    fn new(executed: &'a Executed, machine: &'a Machine, origin: [f64; MAX_ACTUATORS]) -> Self {
        Self { readers: executed.tracks.iter().map(Track::reader).collect(), machine, origin }
    }

    /// Returns the place at a time that is not before the last one asked for.
    fn at(&mut self, time_ns: u64) -> [f64; 3] {
        let mut steps = self.origin;
        for (steps, reader) in steps.iter_mut().zip(&mut self.readers) {
            *steps += reader.steps_at(time_ns);
        }
        let [x, y, z, ..] = self.machine.point(steps);
        [x, y, z]
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the edges that the program asks for, each with the way of the path behind it (where the power goes
/// off: before it).
fn asked(path: &[Vertex]) -> Vec<(Edge, [f64; 3])> {
    let mut is_on = false;
    let mut edges = Vec::new();
    for pair in path.windows(2) {
        let way = std::array::from_fn(|axis| pair[1].at[axis] - pair[0].at[axis]);
        if (pair[1].power > 0.0) != is_on {
            is_on = !is_on;
            edges.push((Edge { at: pair[0].at, is_on }, way));
        }
    }
    if let (true, [.., before, last]) = (is_on, path) {
        let way = std::array::from_fn(|axis| last.at[axis] - before.at[axis]);
        edges.push((Edge { at: last.at, is_on: false }, way));
    }
    edges
}

/// Returns the edges of the run.
fn made(changes: &[Change], places: &mut Places<'_>) -> Vec<Edge> {
    let mut is_on = false;
    let mut edges = Vec::new();
    for change in changes.iter().filter(|change| change.duty > 0.0 || change.time_ns > 0) {
        if (change.duty > 0.0) != is_on {
            is_on = !is_on;
            edges.push(Edge { at: places.at(change.time_ns), is_on });
        }
    }
    edges
}

fn compare(asked: &[(Edge, [f64; 3])], made: &[Edge]) -> Findings {
    let mut findings = Findings { counts: [made.len(), asked.len()], ..Findings::default() };
    for ((edge, way), there) in asked.iter().zip(made) {
        let [x, y, _] = *way;
        let backward = if x.abs() > 1e-9 { x < 0.0 } else { y < 0.0 };
        let worst = &mut findings.worst[usize::from(backward)];
        *worst = worst.max(distance(edge.at, there.at));
        findings.edges += 1;
    }
    findings
}

/// Returns the least and greatest energy for a millimetre over their mean, for a program that asks for one
/// energy everywhere.
fn energy(changes: &[Change], places: &mut Places<'_>) -> Option<[f64; 2]> {
    let (mut windows, mut way, mut sum) = (Vec::new(), 0.0, 0.0);
    for pair in changes.windows(2) {
        let [from, to] = [pair[0].time_ns, pair[1].time_ns];
        if pair[0].duty == 0.0 {
            (way, sum) = (0.0, 0.0);
            continue;
        }
        let mut here = places.at(from);
        let mut time = from;
        while time < to {
            let next = (time + STEP_NS).min(to);
            let there = places.at(next);
            way += distance(here, there);
            sum += pair[0].duty * (next - time) as f64 * 1e-9;
            (here, time) = (there, next);
            if way >= WINDOW_MM {
                windows.push(sum / way);
                (way, sum) = (0.0, 0.0);
            }
        }
    }
    let mean = windows.iter().sum::<f64>() / windows.len() as f64;
    let least = windows.iter().copied().reduce(f64::min)?;
    let most = windows.iter().copied().reduce(f64::max)?;
    Some([least / mean, most / mean])
}

/// Returns the picture that the edges make: a line for every stretch of one duty, as dark as the duty.
fn picture(changes: &[Change], places: &mut Places<'_>) -> String {
    let mut lines = Vec::new();
    for pair in changes.windows(2).filter(|pair| pair[0].duty > 0.0) {
        lines.push((places.at(pair[0].time_ns), places.at(pair[1].time_ns), pair[0].duty));
    }
    let ends = || lines.iter().flat_map(|(from, to, _)| [from, to]);
    let bound = |axis: usize, pick: fn(f64, f64) -> f64| ends().map(|at| at[axis]).reduce(pick).unwrap_or(0.0);
    let [left, right] = [bound(0, f64::min) - 1.0, bound(0, f64::max) + 1.0];
    let [bottom, top] = [bound(1, f64::min) - 1.0, bound(1, f64::max) + 1.0];
    let (width, height) = ((right - left) * SCALE, (top - bottom) * SCALE);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" \
         stroke=\"#000\" stroke-width=\"{:.2}\">\n",
        0.1 * SCALE
    );
    for (from, to, duty) in &lines {
        let [x1, x2] = [from[0], to[0]].map(|x| (x - left) * SCALE);
        let [y1, y2] = [from[1], to[1]].map(|y| (top - y) * SCALE);
        let _ = writeln!(svg, "<path d=\"M{x1:.3} {y1:.3}L{x2:.3} {y2:.3}\" stroke-opacity=\"{duty:.3}\"/>");
    }
    svg + "</svg>\n"
}

/// Prints how a run's laser kept to the program and writes the picture it made; returns whether every edge
/// was in its place.
pub fn laser(out: &Path, sources: &Sources) -> Result<bool> {
    let findings = look(out, sources)?;
    print!("{}", findings.text());
    println!("picture: {}", out.join(PICTURE).display());
    Ok(findings.passes())
}

/// Compares a run's laser with the program and writes the picture it made.
fn look(out: &Path, sources: &Sources) -> Result<Findings> {
    let config = sources.config.clone().unwrap_or_else(|| found(out, "config.ini"));
    let gcode = sources.gcode.clone().unwrap_or_else(|| found(out, "job.gcode"));
    let machine = Machine::read(&config)?;
    let program = Program::read(&gcode, machine.beginning)?;
    let changes = power::read(out)?;
    if changes.is_empty() {
        bail!("{} is not there: the run had no power of a laser", out.join(power::FILE).display());
    }
    // Every step is kept.
    let mut executed = Executed::read(&out.join("steps.csv"), 1)?;
    executed.rest_on_steps();
    let Some(anchor) = checks::anchor(&executed, &machine, &program) else { bail!("the program has no path") };
    let origin = anchor.origin(&machine, &program);
    let places = || Places::new(&executed, &machine, origin);
    let mut findings = compare(&asked(program.path()), &made(&changes, &mut places()));
    if asks_for_one_energy(program.path()) {
        findings.energy = energy(&changes, &mut places());
    }
    let file = out.join(PICTURE);
    std::fs::write(&file, picture(&changes, &mut places())).with_context(|| file.display().to_string())?;
    Ok(findings)
}

/// Whether all that burns has the same power and the same speed.
fn asks_for_one_energy(path: &[Vertex]) -> bool {
    let mut burning = path.iter().filter(|vertex| vertex.power > 0.0).map(|vertex| (vertex.power, vertex.asked));
    let first = burning.next();
    burning.all(|each| Some(each) == first)
}

impl Findings {
    fn passes(&self) -> bool {
        self.counts[0] == self.counts[1] && self.worst.iter().all(|worst| *worst <= MOST_OFF_MM)
    }

    fn text(&self) -> String {
        let [made, asked] = self.counts;
        let [forward, backward] = self.worst;
        let mut text = format!("edges: {made} made, {asked} asked for\n");
        let _ = writeln!(
            text,
            "worst edge: {forward:.4} mm from its place going up, {backward:.4} mm going down, {} compared",
            self.edges
        );
        if let Some([least, most]) = self.energy {
            let _ = writeln!(text, "energy for a millimetre: {least:.3} to {most:.3} of its mean");
        }
        text
    }
}

#[cfg(test)]
mod runs;

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of 10 mm at 100 mm/s and back, 80 steps/mm, with power from 2 to 8 mm; `late_ns` shifts power.
    fn run(late_ns: u64) -> (Executed, Vec<Change>) {
        let mut csv = String::from("time_ns,actuator,direction\n");
        let edge = |n: u64| (2 * n + 1) * 62_500;
        for n in 0..800 {
            csv += &format!("{},alpha,1\n", edge(n));
        }
        for n in 0..800 {
            csv += &format!("{},alpha,-1\n", 200_000_000 + edge(n));
        }
        let at = |mm: u64, base: u64| base + mm * 10_000_000 + late_ns;
        let duty = |time_ns, duty| Change { time_ns, duty };
        let changes = vec![
            duty(at(2, 0), 0.5),
            duty(at(8, 0), 0.0),
            duty(at(2, 200_000_000), 0.5),
            duty(at(8, 200_000_000), 0.0),
        ];
        (Executed::parse(csv.as_bytes(), 1).expect("edges"), changes)
    }

    fn findings(late_ns: u64) -> Findings {
        let program =
            Program::parse(b"M3\nG1 X2 F6000 S0\nG1 X8 S500\nG1 X10 S0\nG1 X8\nG1 X2 S500\nG1 X0 S0\n", [Some(0.0); 3]);
        let machine = Machine::printer();
        let (executed, changes) = run(late_ns);
        let places = || Places::new(&executed, &machine, [0.0; MAX_ACTUATORS]);
        let energy = energy(&changes, &mut places());
        let svg = picture(&changes, &mut places());
        assert_eq!(svg.matches("<path").count(), 2, "{svg}");
        Findings { energy, ..compare(&asked(program.path()), &made(&changes, &mut places())) }
    }

    #[test]
    fn edges_in_their_places_pass_and_late_ones_do_not() {
        let right = findings(0);
        assert!(right.passes() && right.edges == 4 && right.worst.iter().all(|worst| *worst < 1e-6), "{right:?}");
        let [least, most] = right.energy.expect("six millimetres");
        assert!(least > 0.999 && most < 1.001, "{least} to {most}");
        let late = findings(500_000);
        assert!(!late.passes() && late.worst.iter().all(|worst| (worst - 0.05).abs() < 1e-6), "{late:?}");
    }
}
