//! G28: find the endstops, fast and then slowly, and say exactly where the machine is.
//!
//! The position of a switch is that of the motors at the tick its input fired, which the latch keeps; the braking after
//! it costs nothing. A cycle for some axes: approach together at the fast rate, going on with the others when one has
//! hit; back off; approach again slowly; count from the second hit; move onto it. At the end an axis whose switch is a limit too
//! moves off it.
//!
//! Behind a switch there is little way. Where braking would take more than that, the machine stops at once instead: steps that a
//! fast motor may lose in the first approach do not matter, for the second one measures.

mod slaves;

use config::EndstopConfig;
use gcode::Block;
use motion::Mode;
use units::{Axis, MmPerSecond, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::{Input, Ports};
use crate::state::Event;
use crate::stopping;
use slaves::SlavesAhead;

/// Disturbed approaches that are repeated: the input fired but is open when the motors stand.
const RETRIES: u8 = 3;

/// Axes of one cycle, one bit each.
type AxisSet = u8;

const XYZ: AxisSet = 0b111;

const fn bit(axis: Axis) -> AxisSet {
    1 << axis as u8
}

fn axes(set: AxisSet) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(move |axis| set & bit(*axis) != 0)
}

impl<P: Ports> Controller<P> {
    /// G28 and its subcodes.
    pub(crate) async fn home_code(&mut self, subcode: u8, block: &Block<'_>) -> Outcome {
        let parks = matches!((subcode, self.config.general.grbl_mode), (0, true) | (2, false));
        match subcode {
            0 | 2 if parks => self.park(block).await,
            0 | 2 => {
                if let Some((letter, _)) = block.words().find(|(letter, _)| Axis::from_letter(*letter).is_none()) {
                    return Err(Failure::Refused(message(format_args!("G28: {letter} is no axis that can be homed"))));
                }
                self.home(words(block)).await
            }
            1 => self.store_park_position(block),
            3 => {
                let flagged = if block.is_bare() { 0b11_1111 } else { words(block) };
                self.wait_idle().await?;
                let mut position = self.position;
                axes(flagged).for_each(|axis| position[axis] = block.get(axis.letter()).unwrap_or(0.0));
                self.set_machine_position(position)?;
                self.homed |= flagged;
                Ok(Answer::Ok)
            }
            5 => {
                self.homed &= if block.is_bare() { 0 } else { !words(block) };
                Ok(Answer::Ok)
            }
            6 => {
                for axis in Axis::ALL.into_iter().filter(|axis| self.config.homing_endstop(*axis).is_some()) {
                    let homed = u8::from(self.homed & bit(axis) != 0);
                    self.consoles.write(self.target, format_args!("{}:{homed} ", axis.letter()));
                }
                self.say(format_args!("\n"));
                Ok(Answer::Ok)
            }
            _ => Ok(Answer::Unknown),
        }
    }

    /// M206: corrects homing positions from the next homing on.
    pub(crate) fn home_offset_code(&mut self, block: &Block<'_>) -> Outcome {
        for axis in Axis::ALL {
            if let Some(mm) = block.get(axis.letter()) {
                self.home_offset[axis] = mm;
            }
        }
        for axis in Axis::PRIMARY {
            let mm = self.home_offset[axis];
            self.say(format_args!("{}: {mm:5.3} ", axis.letter()));
        }
        self.say(format_args!(" will take effect next home\n"));
        Ok(Answer::Ok)
    }

    /// Homes these axes, or all that can be when none is named.
    pub(crate) async fn home(&mut self, named: AxisSet) -> Outcome {
        let able = Axis::ALL
            .into_iter()
            .filter(|axis| self.homing_endstop(*axis).is_some())
            .fold(0, |set, axis| set | bit(axis));
        let chosen = if named == 0 { able } else { named & able };
        let chosen = if self.by_motor(chosen) { chosen | (able & XYZ) } else { chosen };
        if chosen == 0 {
            return Err(Failure::refused("nothing to home: no endstop with a homing_direction for that"));
        }
        if self.player.cancel_suspend() {
            self.announce(format_args!("//Suspend cancelled due to homing cycle\n"));
        }
        self.wait_idle().await?;
        self.enable_motors()?;
        self.apply(Event::HomingBegins);
        self.suspend_limits();
        // Filters would delay the stop at a switch.
        self.ports.motion(|motion| motion.bypass_filters(true));
        // A switch is at a place of the motors.
        let was_aside = self.compensation_is_aside();
        self.set_compensation_aside()?;
        let homed = self.home_in_order(chosen).await;
        self.ports.motion(|motion| motion.bypass_filters(false));
        self.ports.latch().disarm();
        let homed = self.leave_motor_space().await.and(homed);
        if !was_aside {
            self.put_compensation_back().await;
        }
        self.apply(Event::HomingEnds);
        if let Err(Failure::Alarm(text)) = homed {
            self.homed = 0;
            let word = if self.config.general.grbl_mode { "ALARM: Homing fail" } else { "ERROR: Homing cycle failed" };
            self.announce(format_args!("{word}\n"));
            return Err(Failure::Alarm(text));
        }
        homed?;
        self.move_to_origin(chosen).await?;
        self.leave_limits(chosen).await?;
        Ok(Answer::Ok)
    }

    /// A switch that is a limit cannot guard while it is operated: its axis moves off by `retract`.
    async fn leave_limits(&mut self, chosen: AxisSet) -> Result<(), Failure> {
        let levels = self.ports.inputs();
        let is_on_limit = |axis: Axis| {
            let stop = self.homing_endstop(axis).filter(|(_, stop)| stop.limit_enable);
            stop.is_some_and(|(index, _)| levels.is_active(Input::Endstop(index as u8)))
        };
        let on = axes(chosen).filter(|axis| is_on_limit(*axis)).fold(0, |set, axis| set | bit(axis));
        if on == 0 {
            return Ok(());
        }
        let rate = self.slowest(on, |stop| stop.slow_rate);
        let mut target = self.position;
        for axis in axes(on) {
            let away = self.homing_endstop(axis).map_or(0.0, |(_, stop)| -towards(stop) * stop.retract.0);
            if self.by_motor(bit(axis)) {
                // All towers are left by going down.
                target[Axis::Z] = self.position[Axis::Z] + away;
            } else {
                target[axis] += away;
            }
        }
        self.go(target, rate, Mode::Feed).await?;
        self.wait_idle().await
    }

    fn homing_endstop(&self, axis: Axis) -> Option<(usize, &EndstopConfig)> {
        let stop = self.config.homing_endstop(axis)?;
        let index = self.config.endstops.iter().position(|other| other.name == stop.name)?;
        (stop.pin.is_some() && self.config.actuators.0.get(axis as usize)?.present).then_some((index, stop))
    }

    /// Towers or arms are among these axes.
    fn by_motor(&self, set: AxisSet) -> bool {
        self.homes_by_motor() && set & XYZ != 0
    }

    async fn home_in_order(&mut self, chosen: AxisSet) -> Result<(), Failure> {
        if self.by_motor(chosen) {
            self.enter_motor_space()?;
            self.home_cycle(chosen & XYZ).await?;
            return self.home_auxiliary(chosen).await;
        }
        let order = self.config.homing.order.clone();
        if !order.is_empty() {
            for axis in order.iter().filter(|axis| chosen & bit(**axis) != 0) {
                self.home_cycle(bit(*axis)).await?;
            }
            return Ok(());
        }
        let (xy, z) = (bit(Axis::X) | bit(Axis::Y), bit(Axis::Z));
        let each = self.config.homing.corexy;
        let first = if self.config.homing.z_first { [z, xy] } else { [xy, z] };
        for cycle in first.into_iter().map(|cycle| cycle & chosen).filter(|cycle| *cycle != 0) {
            if each {
                for axis in axes(cycle) {
                    self.home_cycle(bit(axis)).await?;
                }
            } else {
                self.home_cycle(cycle).await?;
            }
        }
        self.home_auxiliary(chosen).await
    }

    /// A, B and C, each alone.
    async fn home_auxiliary(&mut self, chosen: AxisSet) -> Result<(), Failure> {
        for axis in axes(chosen & !XYZ) {
            self.home_cycle(bit(axis)).await?;
        }
        Ok(())
    }

    /// One cycle for the axes of a set.
    async fn home_cycle(&mut self, set: AxisSet) -> Result<(), Failure> {
        let (fast, slow) = (self.slowest(set, |stop| stop.fast_rate), self.slowest(set, |stop| stop.slow_rate));
        self.approach(set, fast, |stop| stop.max_travel.0, true).await?;
        self.back_off(set, slow).await?;
        let hits = self.slow_hits(set, slow).await?;
        self.count_from(set, &hits)?;
        // Onto the switch positions themselves: braking went a little past them.
        let mut target = self.position;
        for axis in axes(set) {
            target[axis] = self.homing_position(axis);
        }
        self.go(target, slow, Mode::Feed).await?;
        self.wait_homing().await
    }

    /// Where each axis is when its switch fires at the slow rate. Each round settles one axis at least.
    async fn slow_hits(&mut self, set: AxisSet, slow: MmPerSecond) -> Result<PerAxis<f64>, Failure> {
        let travel = |stop: &EndstopConfig| 2.0 * stop.retract.0;
        let (mut hits, mut unsure) = self.approach(set, slow, travel, false).await?;
        while unsure != 0 {
            self.back_off(unsure, slow).await?;
            let (again, left) = self.approach(unsure, slow, travel, false).await?;
            axes(unsure & !left).for_each(|axis| hits[axis] = again[axis]);
            unsure = left;
        }
        Ok(hits)
    }

    fn slowest(&self, set: AxisSet, rate: impl Fn(&EndstopConfig) -> MmPerSecond) -> MmPerSecond {
        let rates = axes(set).filter_map(|axis| self.homing_endstop(axis)).map(|(_, stop)| rate(stop).0);
        MmPerSecond(rates.fold(f64::INFINITY, |slowest, rate| if rate < slowest { rate } else { slowest }))
    }

    fn homing_position(&self, axis: Axis) -> f64 {
        if let Some(space) = &self.motor_space {
            return space.home[axis];
        }
        self.homing_endstop(axis).map_or(0.0, |(_, stop)| stop.homing_position.0) + self.home_offset[axis]
    }

    /// Moves towards the switches until all have fired. Returns where each axis was when its own did, and the axes for which that
    /// is not known: a switch that another one's stop ran into has no tick of its own.
    async fn approach(
        &mut self,
        set: AxisSet,
        rate: MmPerSecond,
        travel: impl Fn(&EndstopConfig) -> f64,
        may_be_there: bool,
    ) -> Result<(PerAxis<f64>, AxisSet), Failure> {
        let start = self.position;
        let mut hits = start;
        let (mut missing, mut unsure) = (set, 0);
        let mut disturbed = 0;
        let mut slaves = SlavesAhead::default();
        while missing != 0 {
            let target = slaves.bounded(self.approach_target(missing, &start, &travel), &self.position);
            let inputs = self.mask(missing) | self.slave_mask(missing & !slaves.axes());
            if self.brakes_in_time(rate, missing) {
                self.ports.latch().arm(inputs);
            } else {
                self.ports.latch().arm_hard(inputs);
            }
            // A switch that was operated before arming gives no edge.
            let there = self.operated(missing);
            if there != 0 {
                self.ports.latch().disarm();
                let axis = axes(there).next().unwrap_or(Axis::X);
                if !may_be_there && missing == set {
                    return Err(
                        self.homing_failure(axis, "endstop does not open when backed off: stuck, or wired inverted")
                    );
                }
                unsure |= there;
                missing &= !there;
                continue;
            }
            self.go(target, rate, Mode::Feed).await?;
            let Some(trigger) = self.wait_trigger().await? else {
                let racked = axes(missing & slaves.axes()).next();
                let axis = racked.or(axes(missing).next()).unwrap_or(Axis::X);
                let what = match racked {
                    Some(_) => "the switch of its slave closed first, more than 0.25 mm before: the axis is racked",
                    None => "endstop was not reached within its travel",
                };
                return Err(self.homing_failure(axis, what));
            };
            let fired = axes(missing).find(|axis| self.input(*axis).is_some_and(|input| trigger_is(&trigger, input)));
            let Some(axis) = fired else {
                let slaved = axes(missing).find(|axis| 1_u32 << trigger.input & self.slave_mask(bit(*axis)) != 0);
                let hit = self.ports.motion(|motion| motion.position_of_steps(&trigger.steps));
                if let Some((axis, (_, stop))) = slaved.and_then(|axis| Some((axis, self.homing_endstop(axis)?))) {
                    slaves.closed(axis, hit[axis], towards(stop));
                }
                continue;
            };
            // It counts when it is still operated `debounce_ms` after the motors stand.
            self.wait_for(self.config.homing.debounce).await?;
            if self.operated(bit(axis)) != 0 {
                hits[axis] = self.ports.motion(|motion| motion.position_of_steps(&trigger.steps))[axis];
                missing &= !bit(axis);
            } else if disturbed < RETRIES {
                disturbed += 1;
            } else {
                return Err(self.homing_failure(axis, "endstop fires but does not stay operated: check its wiring"));
            }
        }
        Ok((hits, unsure))
    }

    fn brakes_in_time(&mut self, rate: MmPerSecond, set: AxisSet) -> bool {
        let limits = self.ports.motion(|motion| motion.config().map(|config| config.limits));
        limits.is_some_and(|limits| stopping::brakes_in_time(rate, &limits, axes(set)))
    }

    fn approach_target(
        &self,
        missing: AxisSet,
        start: &PerAxis<f64>,
        travel: impl Fn(&EndstopConfig) -> f64,
    ) -> PerAxis<f64> {
        let mut target = self.position;
        for axis in axes(missing) {
            if let Some((_, stop)) = self.homing_endstop(axis) {
                target[axis] = start[axis] + towards(stop) * travel(stop);
            }
        }
        target
    }

    async fn back_off(&mut self, set: AxisSet, rate: MmPerSecond) -> Result<(), Failure> {
        let mut target = self.position;
        for axis in axes(set) {
            if let Some((_, stop)) = self.homing_endstop(axis) {
                target[axis] -= towards(stop) * stop.retract.0;
            }
        }
        self.go(target, rate, Mode::Feed).await?;
        self.wait_homing().await
    }

    /// The axes stand where their switches fired, plus what braking added.
    fn count_from(&mut self, set: AxisSet, hits: &PerAxis<f64>) -> Result<(), Failure> {
        let mut position = self.position;
        for axis in axes(set) {
            position[axis] += self.homing_position(axis) - hits[axis];
            self.homed |= bit(axis);
        }
        self.set_machine_position(position)
    }

    async fn move_to_origin(&mut self, chosen: AxisSet) -> Result<(), Failure> {
        let xy = bit(Axis::X) | bit(Axis::Y);
        if !self.config.homing.move_to_origin || chosen & xy == 0 || self.homed & xy != xy {
            return Ok(());
        }
        let rate = self.slowest(xy, |stop| stop.fast_rate);
        let mut target = self.position;
        (target[Axis::X], target[Axis::Y]) = (0.0, 0.0);
        if self.config.homing.delta {
            // Down from the switches first of all, or one of them would be operated in the middle.
            target[Axis::Z] -= self.homing_endstop(Axis::Z).map_or(0.0, |(_, stop)| stop.retract.0);
        }
        self.go(target, rate, Mode::Rapid).await?;
        self.wait_idle().await
    }

    /// Waits until the move has ended, by itself or by a trigger.
    pub(crate) async fn wait_trigger(&mut self) -> Result<Option<motion::Trigger>, Failure> {
        self.wait_homing().await?;
        // An input that fires at the very last step is seen by the feed at its next run only.
        while self.ports.latch().fired().is_some() {
            self.pause().await?;
        }
        self.resync();
        Ok(self.ports.motion(motion::Motion::take_trigger))
    }

    /// As `wait_idle`, but homing stays the state between its moves.
    async fn wait_homing(&mut self) -> Result<(), Failure> {
        self.ports.motion(motion::Motion::flush);
        while !self.ports.motion(|motion| motion.is_idle()) {
            self.pause().await?;
        }
        Ok(())
    }

    /// Inputs of the switches of motors slaved to these axes.
    fn slave_mask(&self, set: AxisSet) -> u32 {
        let stops = |axis: Axis| self.config.slave_endstops(axis).filter(|(_, stop)| stop.pin.is_some());
        axes(set).flat_map(stops).fold(0, |mask, (index, _)| mask | Input::Endstop(index as u8).bit())
    }

    fn input(&self, axis: Axis) -> Option<Input> {
        self.homing_endstop(axis).map(|(index, _)| Input::Endstop(index as u8))
    }

    fn mask(&self, set: AxisSet) -> u32 {
        axes(set).filter_map(|axis| self.input(axis)).fold(0, |mask, input| mask | input.bit())
    }

    fn operated(&self, set: AxisSet) -> AxisSet {
        let levels = self.ports.inputs();
        axes(set)
            .filter(|axis| self.input(*axis).is_some_and(|input| levels.is_active(input)))
            .fold(0, |operated, axis| operated | bit(axis))
    }

    fn homing_failure(&self, axis: Axis, what: &str) -> Failure {
        let name = self.homing_endstop(axis).map_or("?", |(_, stop)| stop.name.as_str());
        Failure::Alarm(message(format_args!("{} {name}: {what}", axis.letter())))
    }
}

fn words(block: &Block<'_>) -> AxisSet {
    Axis::ALL.into_iter().filter(|axis| block.has(axis.letter())).fold(0, |set, axis| set | bit(axis))
}

fn trigger_is(trigger: &motion::Trigger, input: Input) -> bool {
    1_u32.checked_shl(u32::from(trigger.input)) == Some(input.bit())
}

fn towards(stop: &EndstopConfig) -> f64 {
    match stop.homing_direction {
        config::HomingDirection::ToMax => 1.0,
        _ => -1.0,
    }
}
