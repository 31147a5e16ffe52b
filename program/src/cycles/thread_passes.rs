//! Passes of a thread (G76), one action at a time: [`Passes`] computes the next action from the current
//! stage. Words and geometry are LinuxCNC's.

use heapless::Vec;
use units::{Axis, PerAxis, PowerLaw};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::state::auxiliary::Auxiliary;

/// Thread to be cut. Positions are machine positions in mm, depths count from the drive line along X.
#[derive(Clone, Debug)]
pub(crate) struct Thread {
    /// Beginning of the thread on the drive line.
    pub start: PerAxis<f64>,
    /// Z at the end of the thread.
    pub end: f64,
    /// Direction of cutting: 1 towards greater X, an internal thread; else -1.
    pub side: f64,
    /// Travel of a turn, mm.
    pub pitch: f64,
    /// Depth of the thread's crest.
    pub crest: f64,
    /// Depth of the first cut below the crest.
    pub first_cut: f64,
    /// Height of the thread.
    pub height: f64,
    /// Degression of the cuts: pass n is as deep as the first cut times n to the power of 1 / degression.
    pub degression: f64,
    /// Distance that Z moves back for each mm of depth below the crest: the slope of the compound slide, with
    /// the sign of the way along Z.
    pub slope: f64,
    /// Number of passes at full depth.
    pub last_passes: u32,
    /// Length of the tapers along Z, with the sign of the way; begin and end may have tapers.
    pub taper: f64,
    pub taper_in: bool,
    pub taper_out: bool,
    pub rapid: Rate,
    pub power: f32,
    /// State of the operator's overrides behind every pass.
    pub auxiliary: Auxiliary,
}

impl Thread {
    /// Returns the depth of pass n, counted from 1, below the drive line.
    fn depth(&self, pass: u32) -> f64 {
        let below = self.first_cut * libm::pow(f64::from(pass), 1.0 / self.degression);
        self.crest + if below < self.height { below } else { self.height }
    }

    /// Returns the number of passes before those at full depth.
    fn rough_passes(&self) -> u32 {
        // Each pass is deeper than the previous; the caller bounds the degression.
        let passes = libm::pow(self.height / self.first_cut, self.degression);
        let floor = libm::floor(passes);
        if floor >= passes && floor > 0.0 { floor as u32 - 1 } else { floor as u32 }
    }

    /// Returns the number of all passes.
    pub(crate) fn passes(&self) -> u32 {
        self.rough_passes() + self.last_passes
    }

    fn at(&self, depth: f64, z: f64) -> PerAxis<f64> {
        let mut place = self.start;
        place[Axis::X] += self.side * depth;
        place[Axis::Z] = z;
        place
    }

    /// Returns the pitch along a taper that keeps the travel of Z in a turn.
    fn taper_pitch(&self) -> f64 {
        if self.taper == 0.0 {
            self.pitch
        } else {
            self.pitch * libm::hypot(self.taper, self.height) / libm::fabs(self.taper)
        }
    }
}

/// Next stage of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Move over the beginning, clear of the thread.
    Over,
    /// Disable the operator's override of feed rates before the first cut.
    Secure,
    /// Move to the crest before a taper (`In` goes down the taper), or straight down to the depth.
    ToCrest,
    In,
    /// Cut along the thread.
    Cut,
    /// Cut up the taper at the end.
    Out,
    /// Move clear of the thread.
    Clear,
    /// Restore the operator's overrides.
    Release,
}

/// Effect of a stage.
enum Step {
    Go(PerAxis<f64>, Rate),
    Do(Action<'static>),
    Nothing,
}

/// Passes of a thread, and the progress of cutting them.
#[derive(Clone, Debug)]
pub(crate) struct Passes {
    thread: Thread,
    /// End position of the last action.
    at: PerAxis<f64>,
    /// Number of the pass from 1; the number behind the last pass returns to the drive line.
    pass: u32,
    stage: Stage,
    is_done: bool,
}

impl Passes {
    pub(crate) const fn new(thread: Thread) -> Self {
        let at = thread.start;
        Self { thread, at, pass: 1, stage: Stage::Over, is_done: false }
    }

    /// Returns the next action. Moves of no length are left out.
    pub(crate) fn next(&mut self) -> Option<Action<'static>> {
        while !self.is_done {
            let (target, rate) = match self.step() {
                Step::Go(target, rate) if target != self.at => (target, rate),
                Step::Do(action) => return Some(action),
                Step::Go(..) | Step::Nothing => continue,
            };
            self.at = target;
            let (shape, power) = (Shape::Line { names_xy: true }, self.thread.power);
            return Some(Action::Move(Move {
                target,
                shape,
                rate,
                power,
                power_law: PowerLaw::Off,
                corner: Corner::Sharp,
            }));
        }
        None
    }

    /// Returns the effect of the current stage and advances to the next stage.
    fn step(&mut self) -> Step {
        let thread = &self.thread;
        if self.pass > thread.passes() {
            self.is_done = true;
            return Step::Go(thread.at(0.0, thread.end), thread.rapid);
        }
        let depth = thread.depth(self.pass);
        let back = (depth - thread.crest) * thread.slope;
        let end = thread.end + thread.height * thread.slope - back;
        let begin = thread.start[Axis::Z] - back;
        // Position clear of the thread by its full depth.
        let clear = depth - thread.crest - thread.height;
        let along = Rate::PerRevolution(thread.pitch);
        let on_taper = Rate::PerRevolution(thread.taper_pitch());
        let (taper_in, taper_out) = (thread.taper_in, thread.taper_out);
        let (next, step) = match self.stage {
            Stage::Over => {
                let next = if taper_in { Stage::Secure } else { Stage::ToCrest };
                (next, Step::Go(thread.at(clear, begin), thread.rapid))
            }
            Stage::Secure => {
                let off = Action::Overrides { feed: false, spindle: thread.auxiliary.spindle_override, hold: false };
                (if taper_in { Stage::ToCrest } else { Stage::Cut }, Step::Do(off))
            }
            Stage::ToCrest if taper_in => (Stage::In, Step::Go(thread.at(depth - thread.height, begin), on_taper)),
            Stage::ToCrest => (Stage::Secure, Step::Go(thread.at(depth, begin), thread.rapid)),
            Stage::In => (Stage::Cut, Step::Go(thread.at(depth, begin + thread.taper), on_taper)),
            Stage::Cut => {
                let z = if taper_out { end - thread.taper } else { end };
                (Stage::Out, Step::Go(thread.at(depth, z), along))
            }
            Stage::Out if taper_out => (Stage::Clear, Step::Go(thread.at(depth - thread.height, end), on_taper)),
            Stage::Out => (Stage::Clear, Step::Nothing),
            Stage::Clear => (Stage::Release, Step::Go(thread.at(clear, end), thread.rapid)),
            Stage::Release => (Stage::Over, Step::Do(thread.auxiliary.overrides())),
        };
        if self.stage == Stage::Release {
            self.pass += 1;
        }
        self.stage = next;
        step
    }

    /// Returns positions, in order, whose path bounds all remaining motion: the corners of the first and the
    /// deepest pass.
    pub(crate) fn reach(&self) -> Vec<PerAxis<f64>, 7> {
        let thread = &self.thread;
        if self.is_done {
            return Vec::new();
        }
        let most = thread.height * thread.slope;
        let shallowest = thread.depth(self.pass) - thread.crest - thread.height;
        let (deepest, start) = (thread.crest + thread.height, thread.start[Axis::Z]);
        let corners = [
            thread.at(shallowest, start - most),
            thread.at(deepest, start),
            thread.at(deepest, thread.end + most),
            thread.at(shallowest, thread.end),
            thread.at(0.0, thread.end),
        ];
        [self.at].into_iter().chain(corners).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// For every thread, passes become deeper, the last ones are at full depth, motion stays between the
        /// corners, and the end is on the drive line.
        #[test]
        fn passes_become_deeper_and_stay_between_the_corners(
            height in 0.1_f64..3.0, share in 0.1_f64..0.99, degression in 1.0_f64..3.0, crest in 0.1_f64..5.0,
            degrees in 0.0_f64..30.0, side in prop_oneof![Just(1.0), Just(-1.0)], way in prop_oneof![Just(1.0), Just(-1.0)],
            taper in 0.0_f64..5.0, tapers in 0_u8..4, last_passes in 1_u32..4,
        ) {
            let start = PerAxis([10.0, 0.0, 5.0, 0.0, 0.0, 0.0]);
            let thread = Thread {
                start, end: 5.0 + way * 15.0, side, pitch: 1.5, crest, first_cut: height * share, height, degression,
                slope: -way * degrees.to_radians().tan(), last_passes, taper: way * taper,
                taper_in: tapers & 1 != 0 && taper > 0.0, taper_out: tapers & 2 != 0 && taper > 0.0,
                rapid: Rate::Rapid(units::MmPerSecond(50.0)), power: 0.0, auxiliary: Auxiliary::START,
            };
            let mut passes = Passes::new(thread.clone());
            let (mut depths, mut last) = (std::vec::Vec::new(), start);
            loop {
                let reach = passes.reach();
                let request = match passes.next() {
                    Some(Action::Move(request)) => request,
                    Some(_) => continue,
                    None => break,
                };
                for axis in [Axis::X, Axis::Z] {
                    let within = |sign: f64| reach.iter().any(|place| sign * (place[axis] - request.target[axis]) >= -1e-9);
                    prop_assert!(within(1.0) && within(-1.0), "{:?} {request:?}", axis);
                }
                if request.rate == Rate::PerRevolution(1.5) {
                    depths.push((request.target[Axis::X] - 10.0) * side);
                }
                last = request.target;
            }
            let full = crest + height;
            prop_assert!(depths.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "{depths:?}");
            prop_assert_eq!(depths.iter().filter(|depth| (**depth - full).abs() < 1e-9).count(), last_passes as usize);
            prop_assert_eq!(last, PerAxis([10.0, 0.0, thread.end, 0.0, 0.0, 0.0]));
        }
    }
}
