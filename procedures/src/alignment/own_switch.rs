//! G28.7: how far a slave is from its own switch, and putting it at its place from there.
//!
//! If two motors carry an axis and the slave has a switch, that switch says how the slave stands to its
//! master: G28.7 X0 on an axis that has been aligned by hand says the distance, M666 X keeps that as the
//! trim, and G28.7 X1 after homing goes back by it, whatever the motors did while they had no current.

use base::failure::{Answer, Failure, Outcome};
use base::ports::Input;
use motion::Latch;
use program::Words;
use units::{Actuator, Axis, MmPerSecond};

use super::single_motors::{Apart, axis_of, slaves_of};
use crate::homing::{homing_switch, stops_in_time, wait_trigger};
use crate::probing::ProbeHands;

/// Greatest distance to the switch, mm: on its way the slave twists the part that both motors carry.
const FARTHEST: f64 = 20.0;
const USAGE: &str = "G28.7 requires one axis argument (XYZ)";

/// The slave's search for its own switch.
struct Search {
    axis: Axis,
    slave: Actuator,
    switch: Input,
    /// Direction towards the switch: 1 or -1.
    towards: f64,
    rate: MmPerSecond,
    /// Distance back from the switch, mm; without it, the slave goes back to where it stood.
    trim: Option<f64>,
}

/// G28.7 X, Y or Z: 0 measures, 1 puts the slave at its trim.
pub fn align_slave<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let search = plan(hands, words)?;
    hands.standstill()?;
    hands.enable_motors()?;
    let apart = Apart::begin(hands, &[search.slave])?;
    // Filters would delay the stop at the switch.
    hands.motion(|motion| motion.bypass_filters(true));
    hands.search_begins();
    let searched = search.run(hands);
    hands.latch().disarm();
    hands.search_ends();
    let ended = apart.end(hands);
    hands.motion(|motion| motion.bypass_filters(false));
    searched.and(ended).map(|()| Answer::Ok)
}

fn plan<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Result<Search, Failure> {
    let texts = hands.texts();
    let config = hands.config();
    let axis =
        match Axis::PRIMARY.into_iter().filter(|axis| words.axis(*axis).is_some()).collect::<heapless::Vec<_, 3>>()[..]
        {
            [axis] => axis,
            _ => return Err(Failure::refused(&USAGE)),
        };
    let letter = axis.letter();
    let refused = |text: core::fmt::Arguments<'_>| Err(texts.refused(text));
    let master = Actuator::from_index(axis as usize);
    let slave = master.and_then(|master| slaves_of(config, master).first().copied());
    let Some(slave) = slave else {
        return refused(format_args!("axis {letter} does not have a slaved axis: [actuator] NAME.slaved_to makes one"));
    };
    if !hands.axes().homed().has(axis) {
        return refused(format_args!("The primary axis {letter} has not been homed: G28 {letter}0"));
    }
    let own = axis_of(slave).letter();
    let stop =
        config.endstops.iter().enumerate().find(|(_, stop)| stop.axis == Some(axis_of(slave)) && stop.pin.is_some());
    let (Some((index, stop)), Some((towards, rate))) = (stop, homing_switch(config, axis)) else {
        return refused(format_args!("The slaved axis {own} has no assigned endstop: [endstops] NAME.axis = {own}"));
    };
    let (name, switch) = (stop.name.as_str(), Input::Endstop(index as u8));
    if stop.limit_enable {
        return refused(format_args!("limit must not be enabled for the endstop {name}"));
    }
    if hands.inputs().is_active(switch) {
        return refused(format_args!(
            "endstop {name} is already triggered, please adjust so it is not triggered at the same time as the primary endstop"
        ));
    }
    let adjusts = words.axis(axis).is_some_and(|value| value != 0.0);
    let trim = Some(hands.tuning().trim()[axis as usize]).filter(|trim| adjusts && *trim != 0.0);
    if trim.is_some_and(|trim| !(0.0..=FARTHEST).contains(&trim)) {
        return refused(format_args!("M666 {letter} is how far from its switch the slave stands: 0 to {FARTHEST} mm"));
    }
    Ok(Search { axis, slave, switch, towards, rate, trim })
}

impl Search {
    fn run<'c>(&self, hands: &mut impl ProbeHands<'c>) -> Result<(), Failure> {
        let own = axis_of(self.slave);
        let mut target = hands.position();
        target[own] = self.towards * FARTHEST;
        let limits = hands.motion_config()?.limits;
        let arm = if stops_in_time(self.rate, &limits, own) { Latch::arm } else { Latch::arm_hard };
        arm(hands.latch(), self.switch.bit());
        hands.go(target, self.rate, motion::Mode::Feed)?;
        let found = wait_trigger(hands)?;
        let Some(found) = found else {
            target[own] = 0.0;
            hands.go(target, self.rate, motion::Mode::Feed)?;
            hands.standstill()?;
            return Err(hands.texts().refused(format_args!(
                "endstop of {} was not triggered, please make sure it is within {FARTHEST} mm: it is back where it was",
                own.letter()
            )));
        };
        let at = hands.motion(|motion| motion.position_of_steps(&found.steps))[own];
        let way = at * self.towards;
        hands.say(format_args!("Actuator {}, moved {way:.4} mm to its endstop\n", own.letter()));
        target[own] = 0.0;
        if let Some(trim) = self.trim {
            hands.say(format_args!(
                "Actuator {}, adjusted to {trim:.4} mm from it: {:+.4} mm\n",
                own.letter(),
                way - trim
            ));
            target[own] = at - self.towards * trim;
        } else {
            let letter = self.axis.letter();
            hands.say(format_args!("M666 {letter}{way:.4} keeps that; G28.7 {letter}1 puts it there\n"));
        }
        hands.go(target, self.rate, motion::Mode::Feed)?;
        hands.standstill()?;
        hands.wait_while_held()
    }
}
