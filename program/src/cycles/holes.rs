//! Actions of a block of holes, one at a time. A block may ask for thousands of moves, so they are not
//! stored: [`Holes`] computes the next action from the current stage.

use heapless::Vec;
use units::{Axis, Micros, PerAxis, PowerLaw};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::state::auxiliary::{Auxiliary, Spindle};
use crate::state::cycle::Cycle;

/// Height at which a rapid return stops above the previous depth, and by which G73 draws the drill back, mm:
/// 0.01 inch, as in LinuxCNC.
const CLEARANCE: f64 = 0.254;

/// Holes that a block drills. Positions are machine positions, mm.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub cycle: Cycle,
    /// Axis along which the holes are drilled.
    pub along: Axis,
    /// Position over the first hole, at the height of the program's position.
    pub first: PerAxis<f64>,
    /// Distance from hole to hole.
    pub step: PerAxis<f64>,
    /// Polar alternative to the step: holes about a centre, after G91.
    pub turn: Option<Turn>,
    /// Number of holes, at least one.
    pub count: u32,
    /// Height of the R plane.
    pub retract: f64,
    /// Height of a hole's bottom, not above R.
    pub bottom: f64,
    /// Height to which a hole is left, not below R.
    pub clear: f64,
    /// Depth of a peck, mm.
    pub peck: f64,
    /// Number of pecks for each hole, at least one.
    pub pecks: u32,
    /// Dwell at the bottom.
    pub dwell: Option<Micros>,
    pub rates: Rates,
    /// Spindle and overrides before the first hole and behind every hole.
    pub auxiliary: Auxiliary,
}

/// Holes about a centre, mm and radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// X and Y of the centre.
    pub centre: [f64; 2],
    /// Distance and angle of the first hole.
    pub first: [f64; 2],
    /// Change of distance and angle from hole to hole.
    pub step: [f64; 2],
}

impl Turn {
    fn hole(&self, number: u32) -> [f64; 2] {
        let [distance, angle] = [0, 1].map(|of| self.first[of] + self.step[of] * f64::from(number));
        [self.centre[0] + distance * libm::cos(angle), self.centre[1] + distance * libm::sin(angle)]
    }
}

/// Properties common to all moves of the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub rapid: Rate,
    pub feed: Rate,
    pub power: f32,
    pub corner: Corner,
}

impl Plan {
    /// Returns the position over a hole, counted from 0, at a height.
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

    /// Returns the depth of a peck that is not the last, counted from 1.
    fn depth(&self, peck: u32) -> f64 {
        self.retract - self.peck * f64::from(peck)
    }

    /// Returns the height just above a peck's bottom, but not above R.
    fn above(&self, peck: u32) -> f64 {
        let above = self.depth(peck) + CLEARANCE;
        if above < self.retract { above } else { self.retract }
    }

    /// Whether all positions of the plan are finite numbers.
    pub(crate) fn is_finite(&self) -> bool {
        let last = self.hole(self.count, self.bottom);
        let heights = [self.retract, self.bottom, self.clear];
        self.first.0.into_iter().chain(last.0).chain(heights).all(f64::is_finite)
    }
}

/// Next stage of a hole; pecks count from 1.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// Lift to R from below, before the first hole only.
    Lift,
    /// Move over the hole.
    Over,
    /// Move down to R.
    Approach,
    /// Disable the operator's overrides, because speeds must not change while a thread is cut.
    Secure,
    /// Cut to the bottom of this peck.
    Cut(u32),
    /// Draw back after this peck, as far as the cycle says.
    Out(u32),
    /// Go down again to just above this peck's bottom.
    Back(u32),
    /// Reverse the spindle's direction.
    Reverse,
    /// Dwell at the bottom.
    Dwell,
    /// Stop the spindle's rotation.
    Stop,
    /// Have the operator draw the tool out.
    ByHand,
    /// Complete the way out that the operator has begun.
    DrawnOut,
    /// Leave the bottom of the hole.
    Leave,
    /// Move up to the height to which the hole is left.
    Clear,
    /// Restore the spindle's direction.
    Restore,
    /// Restore the operator's overrides.
    Release,
}

/// Effect of a stage.
enum Step {
    Rapid(PerAxis<f64>),
    Feed(PerAxis<f64>),
    Do(Next),
    Nothing,
}

/// Next step of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// Action for the machine.
    Action(Action<'static>),
    /// Change of the spindle's direction, by switching the outputs that listen to its codes.
    Turn(Spindle),
}

/// Holes of a block, and the progress of drilling them.
#[derive(Clone, Debug)]
pub(crate) struct Holes {
    plan: Plan,
    /// End position of the last action.
    at: PerAxis<f64>,
    /// Number of finished holes.
    done: u32,
    stage: Stage,
}

impl Holes {
    /// Starts with the first hole, from the machine's position.
    pub(crate) const fn new(plan: Plan, here: PerAxis<f64>) -> Self {
        Self { plan, at: here, done: 0, stage: Stage::Lift }
    }

    /// Goes on from the position to which the operator has drawn the tool out of this hole.
    pub(crate) const fn drawn_out(&mut self, here: PerAxis<f64>) {
        self.at = here;
        self.stage = Stage::DrawnOut;
    }

    /// Returns the next step. Moves of no length are left out.
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
            return Some(Next::Action(Action::Move(Move {
                target,
                shape,
                rate,
                power,
                power_law: PowerLaw::Off,
                corner,
            })));
        }
        None
    }

    /// Returns the way off the bottom of the hole, where the cycle has one at the feed rate.
    fn leave(&self) -> Step {
        let to = |height: f64| Step::Feed(self.plan.hole(self.done, height));
        match self.plan.cycle {
            Cycle::Bore => to(self.plan.retract),
            Cycle::BoreAndDwell | Cycle::Tap | Cycle::TapLeft => to(self.plan.clear),
            _ => Step::Nothing,
        }
    }

    /// Returns the effect of the current stage and advances to the next stage.
    fn step(&mut self) -> Step {
        let plan = &self.plan;
        let height = self.at[plan.along];
        let to = |height: f64| plan.hole(self.done, height);
        let straight_up = |height: f64| {
            let mut up = self.at;
            up[plan.along] = height;
            Step::Rapid(up)
        };
        let turn = |spindle: Spindle| Step::Do(Next::Turn(spindle));
        let (next, step) = match self.stage {
            Stage::Lift if height < plan.retract => (Stage::Over, straight_up(plan.retract)),
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
            // From the operator's position and never down, because the tool may be over a clamp.
            Stage::DrawnOut => (Stage::Restore, straight_up(height.max(plan.clear))),
            Stage::Leave => (Stage::Clear, self.leave()),
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

    /// Returns positions, in order, whose path bounds all remaining motion: holes are on a straight line, and
    /// motion stays between the bottom and the height to which a hole is left.
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

    /// Returns the corners of the box around holes about a centre, for the same purpose.
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
