//! Moves: held against the travel, then given to motion as the machine does, with nobody waiting.

use core::fmt::Arguments;

use base::failure::{TooLong, short};
use base::own_frame::apart;
use config::MachineConfig;
use motion::geometry::LineSettings;
use motion::path::{Bounds, Curve};
use motion::{Block, Mode, Refusal};
use parts::drawing::{self, Draws};
use program::{Interpreter, Move, Rate, Shape};
use units::{Axis, MmPerSecond, PerAxis};

use super::cost::{Costs, Wish};
use super::finding::Kind;
use super::limits::{self, Demand, Limit, Met};
use super::lines::{Reading, Said};
use super::power;

/// Greatest relative difference that is rounding.
const SAME: f64 = 1e-6;

/// Returns `asked` if that is more than `given`, else `given`.
fn greater(asked: f64, given: f64) -> f64 {
    if asked > given * (1.0 + SAME) { asked } else { given }
}

impl Reading<'_, '_> {
    pub(super) async fn movement(&mut self, request: &Move) -> Result<(), Said> {
        let from = self.motion.commanded_position();
        let made = self.draw(request, &from).await;
        if made.is_err() {
            self.preflight.program.take_back();
            return made;
        }
        self.count(&from, request);
        Ok(())
    }

    async fn draw(&mut self, request: &Move, from: &PerAxis<f64>) -> Result<(), Said> {
        self.may_move(request, from)?;
        let limits = || self.motion.config().map(|config| config.limits);
        let deviation = || limits().map_or(0.0, |limits| limits.junction_deviation.get());
        let program = &self.preflight.program;
        let factors =
            if program.modal().auxiliary.feed_override { program::speed_factor::of_moves(program) } else { [1.0; 2] };
        let power = self.preflight.tuning.laser.power(request);
        let own = drawing::in_motions_terms(request, self.preflight.tag(), factors, power, deviation);
        self.preflight.without_flow_limit = self.speed_without_flow_limit(request, from);
        let drawn = apart(|| drawing::draw(self, *from, request, own))?;
        for piece in drawn {
            self.take(&piece).await?;
        }
        Ok(())
    }

    /// Submits one piece to motion.
    async fn take(&mut self, piece: &motion::Move) -> Result<(), Said> {
        let (from, since) = (self.motion.commanded_position(), self.motion.submitted());
        loop {
            match self.motion.submit(piece) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) if self.pass() => self.preflight.turn().await,
                Err(refusal) => {
                    let kind = if refusal == Refusal::Unreachable { Kind::Unreachable } else { Kind::Halts };
                    return Err(self.say(kind, short(format_args!("{refusal}"))));
                }
            }
        }
        self.preflight.moves = true;
        self.hold_against_limits(&from, piece, since);
        if self.preflight.costs.is_full() {
            self.settle_costs(Costs::settle).await;
        }
        Ok(())
    }

    // --- what is wrong with a move ---

    fn may_move(&mut self, request: &Move, from: &PerAxis<f64>) -> Result<(), Said> {
        let preflight = &mut *self.preflight;
        let moves = Axis::PRIMARY.into_iter().any(|axis| request.target[axis] != from[axis]);
        if moves && !preflight.facts().all_homed() {
            if preflight.config.motion.must_be_homed {
                return Err(self.say(Kind::MustHome, short(format_args!("Must be homed before moving"))));
            }
            if !core::mem::replace(&mut preflight.once.not_homed, true) {
                let text = "it moves before it homes: such moves are not held against the travel";
                self.say(Kind::NotHomed, short(format_args!("{text}")));
            }
        }
        self.look_for_length(request, from, !moves);
        self.look_for_cold(request, from);
        if let Some((kind, text)) = power::of_move(self.preflight, request) {
            self.say(kind, text);
        }
        Ok(())
    }

    /// Reports a move of an extruder alone that is longer than it may be.
    fn look_for_length(&mut self, request: &Move, from: &PerAxis<f64>, is_alone: bool) {
        let Some(tool) = self.preflight.program.tools().active() else { return };
        let (axis, id) = (tool.settings.axis, tool.settings.id);
        let fed = request.target[axis] - from[axis];
        let config = self.preflight.config;
        let extruder = config.extruders.iter().find(|extruder| extruder.tool.id == id);
        if let Some(extruder) = extruder.filter(|extruder| extruder.feeds_too_far(fed, is_alone)) {
            self.say(Kind::TooLong, short(format_args!("{}", TooLong(extruder))));
        }
    }

    /// Reports filament that a nozzle pushes while its heater has no target.
    fn look_for_cold(&mut self, request: &Move, from: &PerAxis<f64>) {
        let Some(tool) = self.preflight.program.tools().active() else { return };
        let (axis, id) = (tool.settings.axis, tool.settings.id);
        let is_said = self.preflight.once.cold.get(axis as usize).copied().unwrap_or(true);
        if is_said || self.preflight.may_be_hot || request.target[axis] <= from[axis] {
            return;
        }
        let config = self.preflight.config;
        let Some((heater, settings)) = config.heaters().find(|(_, heater)| heater.tool_id == id) else { return };
        let is_off = self.preflight.targets.get(heater.index()).is_some_and(|t| *t <= thermal::OFF_BELOW);
        if is_off && settings.heater_pin.is_some() {
            if let Some(said) = self.preflight.once.cold.get_mut(axis as usize) {
                *said = true;
            }
            let least = self.preflight.tuning.least_warm.get(usize::from(id.0));
            let is_guarded = least.is_some_and(|[least, _]| *least > 0.0);
            let kind = if is_guarded { Kind::TooCold } else { Kind::Cold };
            self.say(kind, short(format_args!("filament is fed while {} is off", settings.name)));
        }
    }

    // --- what limits cut ---

    /// Returns the speed asked of a move that the program has slowed down for its flow of filament (M203 V).
    fn speed_without_flow_limit(&self, request: &Move, from: &PerAxis<f64>) -> Option<MmPerSecond> {
        let tool = self.preflight.program.tools().active()?;
        tool.settings.flow_limit?;
        let own = self.preflight.program.modal().feed_rate;
        let feeds = request.target[tool.settings.axis] > from[tool.settings.axis];
        let moves = Axis::PRIMARY.into_iter().any(|axis| request.target[axis] != from[axis]);
        let is_line = matches!(request.shape, Shape::Line { .. });
        let slowed = matches!(request.rate, Rate::Feed(speed) if speed.0 < own.0 * (1.0 - SAME));
        (slowed && feeds && moves && is_line).then_some(own)
    }

    /// Compares a submitted piece with what motion made of it: the last block is the piece, a block before it
    /// rounds a corner.
    fn hold_against_limits(&mut self, from: &PerAxis<f64>, piece: &motion::Move, since: u32) {
        let overrides = self.motion.overrides();
        let mut blocks: heapless::Vec<Block, 2> = self.motion.submitted_since(since).copied().collect();
        let Some(block) = blocks.pop() else { return };
        for rounding in blocks {
            self.preflight.costs.push(&Wish::granted(&rounding, rounding.cruise(&overrides)));
        }
        let mut wish = Wish::granted(&block, block.cruise(&overrides));
        // A rapid goes as fast as it may: it asks for a speed where the file has said one.
        let is_feed = block.mode == Mode::Feed;
        if is_feed || self.preflight.asks_of_rapids {
            let asked = self.preflight.without_flow_limit.unwrap_or(piece.feed_rate).get();
            wish.asked = greater(asked * if is_feed { overrides.feed } else { overrides.rapid }, wish.given);
        }
        let moves = Axis::PRIMARY.into_iter().any(|axis| block.target[axis] != from[axis]) || !piece.curve.is_line();
        if let Some(asked) = self.preflight.asked_acceleration.filter(|_| moves) {
            wish.asked_acceleration = greater(asked, wish.given_acceleration);
        }
        if wish.is_cut() {
            self.find_limits(from, &block, piece.curve, &mut wish);
        }
        self.preflight.costs.push(&wish);
    }

    /// Finds the limits that a move meets, and says each of them once.
    fn find_limits(&mut self, from: &PerAxis<f64>, block: &Block, curve: Curve, wish: &mut Wish) {
        let Some(config) = self.motion.config() else { return };
        let (demand, limits) = (Demand::of(config, from, block, curve), config.limits);
        if wish.asked > wish.given {
            let axes = demand.speeds(&limits, wish.asked).filter(|met| matches!(met.limit, Limit::AxisSpeed(_)));
            let by_axes = axes.fold(f64::INFINITY, |least, met| met.allows.min(least));
            for met in demand.speeds(&limits, wish.asked) {
                // A limit of an axis stands for that of its motor.
                let is_the_axis = matches!(met.limit, Limit::MotorRate(motor) if Axis::PRIMARY.len() > motor as usize);
                if !(is_the_axis && by_axes <= met.allows) {
                    self.say_speed(&met);
                }
            }
            let is_flow = block.speed_limit > wish.given && self.preflight.without_flow_limit.is_some();
            wish.cut_by[0] = Some(if is_flow {
                self.say_flow(wish.given / wish.asked);
                Limit::Flow
            } else {
                limits::strictest(demand.speeds(&limits, wish.asked), wish.given)
            });
        }
        let faster = wish.asked_acceleration;
        if faster > wish.given_acceleration {
            demand.accelerations(&limits, faster).for_each(|met| self.say_acceleration(&met, faster));
            let met = demand.accelerations(&limits, faster);
            wish.cut_by[1] = Some(limits::strictest(met, wish.given_acceleration));
        }
    }

    fn is_news(&mut self, limit: Limit) -> bool {
        let said = self.preflight.once.limits.get_mut(limit.index());
        said.is_some_and(|said| !core::mem::replace(said, true))
    }

    fn say_speed(&mut self, met: &Met) {
        if !self.is_news(met.limit) {
            return;
        }
        let Met { limit, asked, most, .. } = *met;
        let text = format_args!("is asked for {asked:.1} mm/s and limited to {most:.1} mm/s");
        let what = match limit {
            Limit::AxisSpeed(axis) => short(format_args!("{} {text}", axis.letter())),
            Limit::MotorRate(motor) => match Axis::ALL.get(motor as usize).filter(|axis| !Axis::PRIMARY.contains(axis))
            {
                Some(axis) => short(format_args!("{} {text}", axis.letter())),
                None => short(format_args!("motor {} {text}", motor.name())),
            },
            _ => short(format_args!("the path {text}")),
        };
        self.say(Kind::Speed, what);
    }

    fn say_flow(&mut self, share: f64) {
        let most = self.preflight.program.tools().active().and_then(|tool| tool.settings.flow_limit);
        if let Some(most) = most.filter(|_| self.is_news(Limit::Flow)) {
            let flow = most / share;
            let text = format_args!("{flow:.1} mm3/s of filament are asked for and limited to {most:.1} mm3/s");
            self.say(Kind::Speed, short(text));
        }
    }

    fn say_acceleration(&mut self, met: &Met, asked: f64) {
        if let (Limit::MotorAcceleration(motor), true) = (met.limit, self.is_news(met.limit)) {
            let (name, most) = (motor.name(), met.most);
            let text = format_args!("{asked:.0} mm/s2 are asked for and motor {name} is limited to {most:.0} mm/s2");
            self.say(Kind::Acceleration, short(text));
        }
    }

    /// Adds the move to the totals.
    fn count(&mut self, from: &PerAxis<f64>, request: &Move) {
        let axis = self.preflight.program.tools().active().map(|tool| tool.settings.axis);
        let totals = &mut self.preflight.totals;
        let fed = axis.map_or(0.0, |axis| request.target[axis] - from[axis]);
        let square = |axis: Axis| (request.target[axis] - from[axis]) * (request.target[axis] - from[axis]);
        let length = libm::sqrt(Axis::PRIMARY.into_iter().map(square).sum());
        totals.filament += fed;
        *if fed > 0.0 { &mut totals.printed } else { &mut totals.travelled } += length;
        if fed > 0.0 && length > 0.0 || axis.is_none() {
            let [least, most] = totals.extents.get_or_insert([*from, *from]);
            for axis in Axis::PRIMARY {
                for place in [from[axis], request.target[axis]] {
                    least[axis] = if place < least[axis] { place } else { least[axis] };
                    most[axis] = if place > most[axis] { place } else { most[axis] };
                }
            }
        }
    }
}

impl Draws for Reading<'_, '_> {
    type Failure = Said;

    fn config(&self) -> &MachineConfig {
        self.preflight.config
    }

    fn program(&self) -> &Interpreter {
        self.preflight.program
    }

    fn line_settings(&self) -> LineSettings {
        self.preflight.tuning.lines
    }

    fn bends(&mut self) -> bool {
        self.motion.config().is_some_and(|config| !config.kinematics.is_linear())
    }

    fn wrong(&mut self, what: Arguments<'_>) -> Said {
        self.say(Kind::Word, short(what))
    }

    fn line_may_be(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Said> {
        let homed = self.preflight.homed;
        let checked = self.preflight.travel().check(from, to, homed);
        checked.map_err(|out| self.say(Kind::OutOfTravel, short(format_args!("{out}"))))
    }

    fn curve_may_be(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Said> {
        let homed = self.preflight.homed;
        let checked = self.preflight.travel().check_bounds(from, bounds, homed);
        checked.map_err(|out| self.say(Kind::OutOfTravel, short(format_args!("{out}"))))
    }
}
