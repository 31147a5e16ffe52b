//! The holes of a block, one thing at a time. A block may ask for thousands of moves; they are not stored:
//! [`Holes`] knows where it is, and what comes next.

use heapless::Vec;
use units::{Axis, Micros, PerAxis};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::auxiliary::{Auxiliary, Spindle};
use crate::cycle::Cycle;

/// A drill goes back to this far above where it has been before it cuts on, and G73 draws it back by as much,
/// mm: 0.01 inch, as in LinuxCNC.
const CLEARANCE: f64 = 0.254;

/// What a block drills. Places are machine positions, mm.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub cycle: Cycle,
    /// The axis that the holes are drilled along.
    pub along: Axis,
    /// Over the first hole, as high as the program is.
    pub first: PerAxis<f64>,
    /// From hole to hole.
    pub step: PerAxis<f64>,
    /// From hole to hole about a centre, instead: polar coordinates after G91.
    pub turn: Option<Turn>,
    /// How many holes, one at least.
    pub count: u32,
    /// R.
    pub retract: f64,
    /// Where a hole ends, not above R.
    pub bottom: f64,
    /// Where a hole is left to, not below R.
    pub clear: f64,
    /// Depth of a peck, mm.
    pub peck: f64,
    /// Pecks of a hole, one at least.
    pub pecks: u32,
    /// The wait at the bottom.
    pub dwell: Option<Micros>,
    pub rates: Rates,
    /// How the spindle turns, and whether overrides count, before the first hole and behind every one.
    pub auxiliary: Auxiliary,
}

/// Holes about a centre, mm and radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// X and Y of the centre.
    pub centre: [f64; 2],
    /// Distance and angle of the first hole.
    pub first: [f64; 2],
    /// From hole to hole.
    pub step: [f64; 2],
}

impl Turn {
    fn hole(&self, number: u32) -> [f64; 2] {
        let [distance, angle] = [0, 1].map(|of| self.first[of] + self.step[of] * f64::from(number));
        [self.centre[0] + distance * libm::cos(angle), self.centre[1] + distance * libm::sin(angle)]
    }
}

/// What the moves have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub rapid: Rate,
    pub feed: Rate,
    pub power: f32,
    pub corner: Corner,
}

impl Plan {
    /// Over a hole, counted from 0, at a height.
    fn hole(&self, number: u32, height: f64) -> PerAxis<f64> {
        let mut place = self.first;
        for axis in Axis::PRIMARY {
            place[axis] += self.step[axis] * f64::from(number);
        }
        if let Some(turn) = self.turn {
            [place[Axis::X], place[Axis::Y]] = turn.hole(number);
        }
        place[self.along] = height;
        place
    }

    /// Where a peck ends that is not the last one, counted from 1.
    fn depth(&self, peck: u32) -> f64 {
        self.retract - self.peck * f64::from(peck)
    }

    /// Just above where a peck ended, and not above R.
    fn above(&self, peck: u32) -> f64 {
        let above = self.depth(peck) + CLEARANCE;
        if above < self.retract { above } else { self.retract }
    }

    /// Every place that is named is one.
    pub(crate) fn is_finite(&self) -> bool {
        let last = self.hole(self.count, self.bottom);
        let heights = [self.retract, self.bottom, self.clear];
        self.first.0.into_iter().chain(last.0).chain(heights).all(f64::is_finite)
    }
}

/// What comes next of a hole. Pecks count from 1.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// Up to R, from below it: before the first hole alone.
    Lift,
    /// Over the hole.
    Over,
    /// Down to R.
    Approach,
    /// What must not change while a thread is cut: the operator's overrides do not count.
    Secure,
    /// Cut to where this peck ends.
    Cut(u32),
    /// Back after this peck, as far as the cycle says.
    Out(u32),
    /// Down again to just above where this peck ended.
    Back(u32),
    /// The spindle turns the other way.
    Reverse,
    /// Wait at the bottom.
    Dwell,
    /// The spindle stops.
    Stop,
    /// The operator draws the tool out.
    ByHand,
    /// What he has left of the way.
    DrawnOut,
    /// Leave the bottom.
    Leave,
    /// Up to where the hole is left to.
    Clear,
    /// The spindle turns as before.
    Restore,
    /// Overrides are as before.
    Release,
}

/// What a stage is.
enum Step {
    Rapid(PerAxis<f64>),
    Feed(PerAxis<f64>),
    Do(Next),
    Nothing,
}

/// What comes next of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// This.
    Action(Action<'static>),
    /// The spindle turns like this: what listens to its codes is switched.
    Turn(Spindle),
}

/// The holes of a block, and what of them is still to be done.
#[derive(Clone, Debug)]
pub(crate) struct Holes {
    plan: Plan,
    /// Where the last action ends.
    at: PerAxis<f64>,
    /// Holes that are done.
    done: u32,
    stage: Stage,
}

impl Holes {
    /// All of them, the machine being here.
    pub(crate) const fn new(plan: Plan, here: PerAxis<f64>) -> Self {
        Self { plan, at: here, done: 0, stage: Stage::Lift }
    }

    /// The tool was drawn out of this hole by hand, and is here now.
    pub(crate) const fn drawn_out(&mut self, here: PerAxis<f64>) {
        self.at = here;
        self.stage = Stage::DrawnOut;
    }

    /// What comes next. Moves of no length are left out.
    pub(crate) fn next(&mut self) -> Option<Next> {
        while self.done < self.plan.count {
            let Rates { rapid, feed, power, corner } = self.plan.rates;
            let (target, rate) = match self.step() {
                Step::Rapid(target) => (target, rapid),
                Step::Feed(target) => (target, feed),
                Step::Do(next) => return Some(next),
                Step::Nothing => continue,
            };
            if target == self.at {
                continue;
            }
            let names_xy = target[Axis::X] != self.at[Axis::X] || target[Axis::Y] != self.at[Axis::Y];
            self.at = target;
            let shape = Shape::Line { names_xy };
            return Some(Next::Action(Action::Move(Move { target, shape, rate, power, corner })));
        }
        None
    }

    /// What this stage is; then it is the next one.
    fn step(&mut self) -> Step {
        let plan = &self.plan;
        let height = self.at[plan.along];
        let to = |height: f64| plan.hole(self.done, height);
        let turn = |spindle: Spindle| Step::Do(Next::Turn(spindle));
        let (next, step) = match self.stage {
            Stage::Lift if height < plan.retract => {
                let mut up = self.at;
                up[plan.along] = plan.retract;
                (Stage::Over, Step::Rapid(up))
            }
            Stage::Lift => (Stage::Over, Step::Nothing),
            Stage::Over => (Stage::Approach, Step::Rapid(to(height))),
            Stage::Approach => (Stage::Secure, Step::Rapid(to(plan.retract))),
            Stage::Secure => {
                let off = Action::Overrides { feed: false, spindle: false, hold: false };
                (Stage::Cut(1), if plan.cycle.taps() { Step::Do(Next::Action(off)) } else { Step::Nothing })
            }
            Stage::Cut(peck) if peck < plan.pecks => (Stage::Out(peck), Step::Feed(to(plan.depth(peck)))),
            Stage::Cut(_) => (Stage::Reverse, Step::Feed(to(plan.bottom))),
            Stage::Out(peck) if plan.cycle == Cycle::BreakChips => {
                (Stage::Cut(peck + 1), Step::Rapid(to(plan.above(peck))))
            }
            Stage::Out(peck) => (Stage::Back(peck), Step::Rapid(to(plan.retract))),
            Stage::Back(peck) => (Stage::Cut(peck + 1), Step::Rapid(to(plan.above(peck)))),
            Stage::Reverse if plan.cycle.taps() => (Stage::Dwell, turn(plan.auxiliary.spindle.reversed())),
            Stage::Reverse => (Stage::Dwell, Step::Nothing),
            Stage::Dwell => {
                let dwell = plan.dwell.map(|time| Step::Do(Next::Action(Action::Dwell(time))));
                (Stage::Stop, dwell.unwrap_or(Step::Nothing))
            }
            Stage::Stop if plan.cycle.stops_spindle() => (Stage::ByHand, turn(Spindle::Stopped)),
            Stage::Stop => (Stage::Leave, Step::Nothing),
            Stage::ByHand if plan.cycle == Cycle::BoreByHand => {
                (Stage::DrawnOut, Step::Do(Next::Action(Action::RetractByHand)))
            }
            Stage::ByHand => (Stage::Leave, Step::Nothing),
            Stage::DrawnOut => {
                // Straight up from wherever he left it, and never down: it may be over a clamp.
                let mut up = self.at;
                up[plan.along] = height.max(plan.clear);
                (Stage::Restore, Step::Rapid(up))
            }
            Stage::Leave => {
                let leave = match plan.cycle {
                    Cycle::Bore => Step::Feed(to(plan.retract)),
                    Cycle::BoreAndDwell | Cycle::Tap | Cycle::TapLeft => Step::Feed(to(plan.clear)),
                    _ => Step::Nothing,
                };
                (Stage::Clear, leave)
            }
            Stage::Clear => (Stage::Restore, Step::Rapid(to(plan.clear))),
            Stage::Restore => {
                let is_other = plan.cycle.taps() || plan.cycle.stops_spindle();
                (Stage::Release, if is_other { turn(plan.auxiliary.spindle) } else { Step::Nothing })
            }
            Stage::Release => {
                let back = Next::Action(plan.auxiliary.overrides());
                (Stage::Over, if plan.cycle.taps() { Step::Do(back) } else { Step::Nothing })
            }
        };
        if matches!(self.stage, Stage::Release) {
            self.done += 1;
        }
        self.stage = next;
        step
    }

    /// Places from where it is on, in order, between which all that is still to be done lies: holes are on a
    /// straight line, and nothing of one is below its bottom or above where it is left to.
    pub(crate) fn reach(&self) -> Vec<PerAxis<f64>, 7> {
        let plan = &self.plan;
        if self.done >= plan.count {
            return Vec::new();
        }
        if plan.turn.is_some() {
            return self.reach_about();
        }
        let (now, last) = (self.done, plan.count - 1);
        let heights = [(now, self.at[plan.along]), (now, plan.bottom), (now, plan.clear), (last, plan.clear)];
        let holes = heights.into_iter().chain([(last, plan.bottom), (last, plan.clear)]);
        [self.at].into_iter().chain(holes.map(|(number, height)| plan.hole(number, height))).collect()
    }

    /// The same of holes about a centre: the corners of the box that they lie in.
    fn reach_about(&self) -> Vec<PerAxis<f64>, 7> {
        let plan = &self.plan;
        let mut corners = [plan.hole(self.done, plan.clear); 2];
        for number in self.done..plan.count {
            let hole = plan.hole(number, plan.clear);
            for axis in [Axis::X, Axis::Y] {
                corners[0][axis] = corners[0][axis].min(hole[axis]);
                corners[1][axis] = corners[1][axis].max(hole[axis]);
            }
        }
        let [mut low, high] = corners;
        low[plan.along] = plan.bottom;
        let (mut left, mut right) = (low, high);
        (left[Axis::Y], right[Axis::Y]) = (high[Axis::Y], low[Axis::Y]);
        [self.at, low, left, high, right].into_iter().collect()
    }
}
