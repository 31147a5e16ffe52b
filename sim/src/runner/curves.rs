//! A job's ideal motion as curves to look at: speed, acceleration and jerk over time, and the sharpest
//! corners.
//!
//! Everything is sampled from the oracle's trajectory, after the filters: the tool's motion, not the
//! commanded one.

use motion::oracle::Ideal;
use motion::trajectory::Piece;
use motion::{FilterConfig, Shaper, ShaperKind};
use units::{Axis, PerAxis};

use super::{Plan, PlannedMotion};

/// Greatest number of samples: a page of more is slow, and a screen shows no more.
const MOST_SAMPLES: f64 = 40_000.0;
/// Least time between samples, seconds: the distance of two knots.
const CLOSEST: f64 = 0.000_25;
/// Number of corners shown, and their least distance, mm.
const CORNERS: usize = 3;
const CORNERS_APART: f64 = 3.0;
/// Time shown of a corner before and after it, seconds.
const CORNER_SECONDS: f64 = 0.05;
/// Points of a corner's path.
const CORNER_POINTS: usize = 400;
/// Cosine above which a change of direction (below 10 degrees) is no corner.
const LEAST_TURN: f64 = 0.985;

/// Curves of the tool over time, with equally many values.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// Times of the samples, seconds from boot. Rests are left out.
    pub time: Vec<f64>,
    /// Speed of X Y Z together, mm/s.
    pub speed: Vec<f64>,
    /// Size of the acceleration, mm/s^2: mean over a sample.
    pub acceleration: Vec<f64>,
    /// Size of the jerk, mm/s^3: mean over a sample. At a jump of the acceleration the value grows with the
    /// density of the samples.
    pub jerk: Vec<f64>,
    /// Distance of the samples, seconds.
    pub period: f64,
}

/// A path in X and Y, mm.
pub type Path = Vec<[f64; 2]>;

/// Corner as planned and after the filters.
#[derive(Clone, Debug)]
pub struct Corner {
    /// Time at which the tool passes the corner, seconds from boot.
    pub time: f64,
    /// Place of the corner, mm.
    pub at: [f64; 2],
    /// Speed through the corner, mm/s.
    pub speed: f64,
    /// Path without the filters.
    pub planned: Path,
    /// Path with the filters.
    pub shaped: Path,
    /// Name of the shaper.
    pub shaper: String,
}

/// Samples the motion of X, Y and Z from one time to another, seconds from boot.
#[must_use]
pub fn curves(plan: &Plan, from: f64, until: f64) -> Curves {
    let spans: Vec<_> = plan.motions().map(|motion| (motion, span(motion))).collect();
    let cut: Vec<_> = spans
        .iter()
        .map(|(motion, (begin, end))| (motion, begin.max(from), end.min(until)))
        .filter(|(_, begin, end)| begin < end)
        .collect();
    let total: f64 = cut.iter().map(|(_, begin, end)| end - begin).sum();
    let mut curves = Curves { period: (total / MOST_SAMPLES).max(CLOSEST), ..Curves::default() };
    for (motion, begin, end) in cut {
        curves.sample(&motion.ideal(), begin, end);
    }
    curves
}

/// Returns the time at which the longest motion without a rest begins, seconds from boot.
#[must_use]
pub fn longest_motion(plan: &Plan) -> f64 {
    let spans = plan.motions().map(span);
    spans.fold((0.0, 0.0), |(begin, length), (b, e)| if e - b > length { (b, e - b) } else { (begin, length) }).0
}

/// Returns the times of the first piece's beginning and of the last one's end, filters drained.
fn span(motion: &PlannedMotion) -> (f64, f64) {
    let end = motion.pieces().last().map_or(0.0, |piece| begin_of(piece) + piece.duration);
    (motion.start * 1e-9, end + 2.0 * motion.filters().latency())
}

fn begin_of(piece: &Piece) -> f64 {
    piece.start.to_num::<f64>() * f64::from(units::TICK_NANOSECONDS) * 1e-9
}

impl Curves {
    fn sample(&mut self, ideal: &Ideal, begin: f64, end: f64) {
        let period = self.period;
        let count = ((end - begin) / period).ceil() as usize + 1;
        let (mut before, mut pull) = ([0.0; 3], [0.0; 3]);
        for index in 0..=count {
            let time = begin + index as f64 * period;
            let velocity = ideal.machine(time * 1e9).map_or([0.0; 3], |(_, velocity)| xyz(&velocity));
            let acceleration: [f64; 3] = core::array::from_fn(|axis| (velocity[axis] - before[axis]) / period);
            let jerk: [f64; 3] = core::array::from_fn(|axis| (acceleration[axis] - pull[axis]) / period);
            self.time.push(time);
            self.speed.push(size(&velocity));
            self.acceleration.push(size(&acceleration));
            self.jerk.push(size(&jerk));
            (before, pull) = (velocity, acceleration);
        }
    }
}

fn xyz(point: &PerAxis<f64>) -> [f64; 3] {
    [point[Axis::X], point[Axis::Y], point[Axis::Z]]
}

fn size(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Returns the corners in the XY plane that are taken hardest, hardest first.
#[must_use]
pub fn corners(plan: &Plan) -> Vec<Corner> {
    let mut found: Vec<(f64, &PlannedMotion, f64, [f64; 2], f64)> = Vec::new();
    for motion in plan.motions() {
        let pieces: Vec<_> = motion.pieces().collect();
        for pair in pieces.windows(2) {
            let (before, after) = (pair[0], pair[1]);
            let (out, into) =
                (xyz(&before.tangent_after(before.distance(before.duration))), xyz(&after.tangent_after(0.0)));
            let along = (out[0] * into[0] + out[1] * into[1]) / (out[0].hypot(out[1]) * into[0].hypot(into[1]));
            // A corner is hard that is approached fast and turned sharply.
            let hardness = before.speed.max(after.speed_at(after.duration)) * (1.0 - along);
            if along < LEAST_TURN && hardness.is_finite() {
                let at = after.point_after(0.0);
                found.push((hardness, motion, begin_of(after), [at[Axis::X], at[Axis::Y]], after.speed));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Corner> = Vec::new();
    for (_, motion, time, at, speed) in found {
        let near = |other: &Corner| (other.at[0] - at[0]).hypot(other.at[1] - at[1]) < CORNERS_APART;
        if chosen.len() < CORNERS && !chosen.iter().any(near) {
            chosen.push(draw(motion, time, at, speed));
        }
    }
    chosen
}

/// Draws a corner with the machine's own shapers, or else with a shaper that many printers use.
fn draw(motion: &PlannedMotion, time: f64, at: [f64; 2], speed: f64) -> Corner {
    let own = motion.filters();
    let (filters, shaper) = if own.shapers.iter().any(Option::is_some) {
        (own, "this machine's input shaper".to_owned())
    } else {
        let mzv = Shaper { kind: ShaperKind::Mzv, frequency: 50.0, damping: 0.1 };
        (
            FilterConfig { shapers: [Some(mzv), Some(mzv), None], ..FilterConfig::NONE },
            "mzv at 50 Hz, which this machine does not have".to_owned(),
        )
    };
    let path = |filters: FilterConfig| -> Path {
        let ideal = motion.ideal_through(Some(filters));
        let from = (time + filters.latency() - CORNER_SECONDS).max(motion.start * 1e-9 + filters.latency());
        let point = |index| {
            let at = from + 2.0 * CORNER_SECONDS * index as f64 / (CORNER_POINTS - 1) as f64;
            ideal.machine(at * 1e9).map(|(point, _)| [point[Axis::X], point[Axis::Y]])
        };
        (0..CORNER_POINTS).filter_map(point).collect()
    };
    Corner { time, at, speed, planned: path(FilterConfig::NONE), shaped: path(filters), shaper }
}
