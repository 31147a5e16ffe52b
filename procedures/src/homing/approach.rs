//! A homing cycle: to the switches, back, and to them again slowly.

use base::failure::{Failure, Texts};
use base::reason::Alarm;
use config::{EndstopConfig, MachineConfig};
use motion::{Mode, Trigger};
use units::{Axis, AxisSet, MmPerSecond, PerAxis};

use super::hits::{Hits, alarm, wait_trigger};
use super::overtravel::brakes_in_time;
use super::samples::{Round, Samples, disagree};
use super::slaves::SlavesAhead;
use super::stall;
use super::switches::{inputs_of, operated, slave_inputs_of, slowest, switch_of, towards};
use crate::endstop_phase::PhaseHands;
use crate::endstop_phase::{self, Came, Pass};

/// Number of disturbed approaches that are repeated: the input fired but is open when the motors stand.
const RETRIES: u8 = 3;

/// Homes the axes of a set, which then stand on their switches: each is at its place of `places`, mm.
pub(super) fn cycle<'c>(
    hands: &mut impl PhaseHands<'c>,
    set: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    let Some(axis) = stall::axis_of(hands.config(), set) else { return find(hands, set, places, samples) };
    // A motor that an override makes slow would look stalled.
    let overrides = hands.motion(|motion| motion.overrides());
    hands.motion(|motion| motion.set_overrides(1.0, 1.0));
    let homed = match stall::begin(hands, axis) {
        Ok(()) => find(hands, set, places, samples),
        Err(silent) => Err(silent),
    };
    // The overrides return even if homing has failed.
    hands.motion(|motion| motion.set_overrides(overrides.feed, overrides.rapid));
    homed.and(stall::end(hands, axis))
}

fn find<'c>(
    hands: &mut impl PhaseHands<'c>,
    set: AxisSet,
    places: &PerAxis<f64>,
    samples: &Samples,
) -> Result<(), Failure> {
    let config = hands.config();
    let phased = endstop_phase::checked(config).and(set);
    let (fast, slow) = (slowest(config, set, |stop| stop.fast_rate), slowest(config, set, |stop| stop.slow_rate));
    let far = Approach { set, rate: fast, travel: |stop| stop.max_travel.0, may_be_there: true };
    let were_homed = hands.axes().homed();
    let stalled = stall::axis_of(config, set);
    let first = match stalled {
        Some(axis) => stall::approach(hands, axis, fast, far.travel)?,
        None => far.run(hands)?,
    };
    let was_cut = first.was_cut;
    let (mut hits, mut places) = (agreed_hits(hands, set, slow, samples)?, *places);
    if let Some(axis) = stalled {
        stall::is_at_the_end(hands.texts(), config, axis, first.at[axis], hits[axis])?;
    }
    for axis in phased.axes() {
        let came = Came { was_homed: were_homed.has(axis), was_cut };
        [hits[axis], places[axis]] = endstop_phase::at_switch(hands, axis, hits[axis], places[axis], came)?;
    }
    // The axes stand where their switches closed, plus the braking distance. With phases the position must be
    // right to the very step, so the live one is taken.
    let mut position = if phased.is_empty() { hands.position() } else { hands.motion(|motion| motion.live_position()) };
    let mut off = samples.off.get();
    set.axes().for_each(|axis| off[axis] = hits[axis] - places[axis]);
    samples.off.set(off);
    set.axes().for_each(|axis| position[axis] -= off[axis]);
    hands.mark_homed(set);
    hands.set_position(position)?;
    // The axes go back onto the switch positions: braking went a little past them.
    set.axes().for_each(|axis| position[axis] = places[axis]);
    hands.go(position, slow, Mode::Feed)?;
    hands.standstill()?;
    if stalled.is_some() {
        // The motor would go on pushing against its end.
        back_off(hands, set, slow)?;
    }
    Ok(())
}

/// Returns the position of each axis when its switch closes at the slow rate: the mean of approaches that
/// agree.
fn agreed_hits<'c>(
    hands: &mut impl PhaseHands<'c>,
    set: AxisSet,
    slow: MmPerSecond,
    samples: &Samples,
) -> Result<PerAxis<f64>, Failure> {
    let mut retries = samples.retries;
    loop {
        let mut round = Round::default();
        let hits = loop {
            back_off(hands, set, slow)?;
            let hits = slow_hits(hands, set, slow)?;
            round.add(set, &hits);
            if round.count() >= samples.count {
                break hits;
            }
        };
        if samples.count <= 1 {
            return Ok(hits);
        }
        round.say(hands, set, samples.tells_all);
        match round.worst(set, samples.tolerance) {
            None => return Ok(round.means(set, hits)),
            Some(worst) if retries == 0 => return Err(disagree(hands.texts(), worst, samples)),
            Some(_) => retries -= 1,
        }
    }
}

/// Returns the position of each axis when its switch closes at the slow rate. Each round settles an axis at
/// least.
fn slow_hits<'c>(hands: &mut impl PhaseHands<'c>, set: AxisSet, slow: MmPerSecond) -> Result<PerAxis<f64>, Failure> {
    if let Some(axis) = stall::axis_of(hands.config(), set) {
        return stall::approach(hands, axis, slow, |stop| 2.0 * stop.retract.0).map(|hits| hits.at);
    }
    let near = |set| Approach { set, rate: slow, travel: |stop| 2.0 * stop.retract.0, may_be_there: false };
    let Hits { mut at, mut unsure, .. } = near(set).run(hands)?;
    while !unsure.is_empty() {
        back_off(hands, unsure, slow)?;
        let again = near(unsure).run(hands)?;
        unsure.without(again.unsure).axes().for_each(|axis| at[axis] = again.at[axis]);
        unsure = again.unsure;
    }
    Ok(at)
}

fn back_off<'c>(hands: &mut impl PhaseHands<'c>, set: AxisSet, rate: MmPerSecond) -> Result<(), Failure> {
    let config = hands.config();
    let mut target = hands.position();
    for axis in set.axes() {
        if let Some((_, stop)) = switch_of(config, axis) {
            target[axis] -= towards(stop) * stop.retract.0;
        }
    }
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}

/// A move to the switches of some axes.
#[derive(Clone, Copy, Debug)]
struct Approach {
    set: AxisSet,
    rate: MmPerSecond,
    /// Greatest travel to the switch, mm.
    travel: fn(&EndstopConfig) -> f64,
    /// Whether a switch may be operated before anything moves.
    may_be_there: bool,
}

/// Progress of an approach.
struct Progress {
    hits: Hits,
    missing: AxisSet,
    disturbed: u8,
    slaves: SlavesAhead,
}

impl Approach {
    /// Moves towards the switches until all have closed.
    fn run<'c>(&self, hands: &mut impl PhaseHands<'c>) -> Result<Hits, Failure> {
        let config = hands.config();
        let start = hands.position();
        let hits = Hits { at: start, unsure: AxisSet::NONE, was_cut: false };
        let mut progress = Progress { hits, missing: self.set, disturbed: 0, slaves: SlavesAhead::default() };
        while !progress.missing.is_empty() {
            let here = hands.position();
            let target = progress.slaves.bounded(self.target(config, progress.missing, &start, &here), &here);
            self.arm(hands, &progress)?;
            if self.finds_some_operated(hands, &mut progress)? {
                continue;
            }
            hands.go(target, self.rate, Mode::Feed)?;
            let Some(trigger) = wait_trigger(hands)? else {
                return Err(progress.not_found(hands.texts(), config));
            };
            let own =
                |axis: &Axis| switch_of(config, *axis).is_some_and(|(input, _)| Some(input.bit()) == bit_of(&trigger));
            match progress.missing.axes().find(own) {
                Some(axis) => progress.closed(hands, axis, &trigger, self.pass(&progress))?,
                None => progress.slave_closed(hands, &trigger),
            }
            progress.hits.was_cut |= hands.latch().is_hard();
        }
        Ok(progress.hits)
    }

    const fn pass(&self, progress: &Progress) -> Pass {
        if self.may_be_there { Pass::Fast { was_cut: progress.hits.was_cut } } else { Pass::Slow }
    }

    /// Returns the furthest target of the axes that are still missing.
    fn target(
        &self,
        config: &MachineConfig,
        missing: AxisSet,
        start: &PerAxis<f64>,
        here: &PerAxis<f64>,
    ) -> PerAxis<f64> {
        let mut target = *here;
        for axis in missing.axes() {
            if let Some((_, stop)) = switch_of(config, axis) {
                target[axis] = start[axis] + towards(stop) * (self.travel)(stop);
            }
        }
        target
    }

    fn arm<'c>(&self, hands: &mut impl PhaseHands<'c>, progress: &Progress) -> Result<(), Failure> {
        let (config, missing) = (hands.config(), progress.missing);
        let limits = hands.motion_config()?.limits;
        let inputs = inputs_of(config, missing) | slave_inputs_of(config, missing.without(progress.slaves.axes()));
        if brakes_in_time(self.rate, &limits, missing.axes()) {
            hands.latch().arm(inputs);
        } else {
            // A hard stop may lose steps, so the positions of these axes are unknown until they have been
            // measured.
            hands.axes().forget_homed(missing);
            hands.latch().arm_hard(inputs);
        }
        Ok(())
    }

    /// Checks for switches that are operated already: a switch that was operated before arming gives no edge.
    fn finds_some_operated<'c>(
        &self,
        hands: &mut impl PhaseHands<'c>,
        progress: &mut Progress,
    ) -> Result<bool, Failure> {
        let config = hands.config();
        let there = operated(config, hands.inputs(), progress.missing);
        let Some(axis) = there.axes().next() else { return Ok(false) };
        hands.latch().disarm();
        if !self.may_be_there && progress.missing == self.set {
            return Err(alarm(
                hands.texts(),
                config,
                axis,
                Alarm::HomingPullOff,
                "endstop does not open when backed off: stuck, or wired inverted",
            ));
        }
        progress.hits.unsure = progress.hits.unsure.or(there);
        progress.missing = progress.missing.without(there);
        Ok(true)
    }
}

impl Progress {
    /// Handles the closing of the axis' own switch. The hit counts if the switch is still operated
    /// `debounce_ms` after the motors stand.
    fn closed<'c>(
        &mut self,
        hands: &mut impl PhaseHands<'c>,
        axis: Axis,
        trigger: &Trigger,
        pass: Pass,
    ) -> Result<(), Failure> {
        let config = hands.config();
        hands.wait_for(config.homing.debounce)?;
        if !operated(config, hands.inputs(), AxisSet::of(axis)).is_empty() {
            let hit = hands.motion(|motion| motion.position_of_steps(&trigger.steps))[axis];
            endstop_phase::switch_closed(hands, axis, &trigger.steps, hit, pass)?;
            self.hits.at[axis] = hit;
            self.missing = self.missing.without(AxisSet::of(axis));
        } else if self.disturbed < RETRIES {
            self.disturbed += 1;
        } else {
            return Err(alarm(
                hands.texts(),
                config,
                axis,
                Alarm::HomingSearch,
                "endstop fires but does not stay operated: check its wiring",
            ));
        }
        Ok(())
    }

    /// Handles the closing of a slaved motor's switch.
    fn slave_closed<'c>(&mut self, hands: &mut impl PhaseHands<'c>, trigger: &Trigger) {
        let config = hands.config();
        let bit = bit_of(trigger).unwrap_or(0);
        let slaved = |axis: &Axis| bit & slave_inputs_of(config, AxisSet::of(*axis)) != 0;
        let Some(axis) = self.missing.axes().find(slaved) else { return };
        let Some((_, stop)) = switch_of(config, axis) else { return };
        let hit = hands.motion(|motion| motion.position_of_steps(&trigger.steps));
        self.slaves.closed(axis, hit[axis], towards(stop));
    }

    fn not_found(&self, texts: &Texts, config: &MachineConfig) -> Failure {
        match self.missing.and(self.slaves.axes()).axes().next() {
            Some(axis) => alarm(
                texts,
                config,
                axis,
                Alarm::HomingSearch,
                "the switch of its slave closed first, more than 0.25 mm before: the axis is racked",
            ),
            None => {
                let axis = self.missing.axes().next().unwrap_or(Axis::X);
                alarm(texts, config, axis, Alarm::HomingSearch, "endstop was not reached within its travel")
            }
        }
    }
}

/// Returns the bit of the input that fired.
fn bit_of(trigger: &Trigger) -> Option<u32> {
    1_u32.checked_shl(u32::from(trigger.input))
}
