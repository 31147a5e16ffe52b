//! `$J=`: a jog of GRBL 1.1 (Grbl v1.1 Jogging): one straight move with its own units and distance mode,
//! which changes nothing of the program's.

use base::failure::{Failure, Texts};
use base::hands::Hands;
use base::ports::Wake;
use base::reason::Reason;
use base::safety::Event;
use gcode::Blocks;
use motion::Mode;
use motion::laser::Power;
use program::{Modal, State};
use units::{Actuator, Axis, MmPerSecond, PerAxis};

/// Millimetres in an inch.
const MM_PER_INCH: f64 = 25.4;

/// Parsed request for a jog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jog {
    /// Words of the axes, mm.
    words: PerAxis<Option<f64>>,
    /// Feed rate in mm/s.
    rate: MmPerSecond,
    /// Whether the words are places, not distances.
    absolute: bool,
    /// Whether the words are machine coordinates.
    machine: bool,
}

fn bad(texts: &Texts, what: &str) -> Failure {
    texts.because(what).with_reason(Reason::BadJog)
}

/// Parses the text behind `$J=`. Units and distance mode are the program's where the jog has none of its own.
///
/// # Errors
/// When the text is no jog: without axis or feed rate, or with a code that no jog takes.
pub(crate) fn read(texts: &Texts, text: &str, modal: &Modal) -> Result<Jog, Failure> {
    let (mut inches, mut absolute, mut machine) = (modal.inches, modal.absolute, false);
    let mut words = PerAxis([None; units::MAX_AXES]);
    let mut feed = None;
    for block in Blocks::new(text.as_bytes()) {
        let block = block.map_err(|error| {
            let number = Reason::of_refusal(&gcode::Refusal::Syntax(error));
            texts.refused(format_args!("{error}")).with_reason(number)
        })?;
        match block.code.map(|code| (code.letter, code.number, code.subcode)) {
            None => {}
            Some((gcode::Letter::G, 20, 0)) => inches = true,
            Some((gcode::Letter::G, 21, 0)) => inches = false,
            Some((gcode::Letter::G, 90, 0)) => absolute = true,
            Some((gcode::Letter::G, 91, 0)) => absolute = false,
            Some((gcode::Letter::G, 53, 0)) => machine = true,
            Some(_) => return Err(bad(texts, "a jog takes G20 G21 G90 G91 G53, axes and F alone")),
        }
        for (letter, value) in block.words() {
            let value =
                value.ok_or_else(|| Failure::refused(&"a word of a jog has no number").with_reason(Reason::Number))?;
            match (letter, Axis::from_letter(letter)) {
                (_, Some(axis)) => words[axis] = Some(value),
                ('F', _) => feed = Some(value),
                ('N', _) => {}
                _ => return Err(bad(texts, "a jog takes G20 G21 G90 G91 G53, axes and F alone")),
            }
        }
    }
    let unit = if inches { MM_PER_INCH } else { 1.0 };
    if words.0.iter().all(Option::is_none) {
        return Err(Failure::refused(&"a jog names an axis").with_reason(Reason::NoAxes));
    }
    let rate =
        feed.ok_or_else(|| Failure::refused(&"a jog has its own F").with_reason(Reason::FeedRate))? * unit / 60.0;
    if rate <= 0.0 {
        return Err(Failure::refused(&"F of a jog is above zero").with_reason(Reason::FeedRate));
    }
    let words = PerAxis(words.0.map(|word| word.map(|value| value * unit)));
    Ok(Jog { words, rate: MmPerSecond(rate), absolute, machine })
}

impl Jog {
    /// Returns the target of the jog, machine position in mm.
    fn target(&self, from: &PerAxis<f64>, modal: &Modal) -> PerAxis<f64> {
        let mut target = *from;
        for axis in Axis::ALL {
            let Some(word) = self.words[axis] else { continue };
            target[axis] = if self.machine || self.absolute { word } else { from[axis] + word };
        }
        if self.machine {
            return target;
        }
        let (xy, now) = ([self.words[Axis::X], self.words[Axis::Y]], [from[Axis::X], from[Axis::Y]]);
        let [x, y] = if self.absolute {
            target[Axis::Z] = self.words[Axis::Z].map_or(from[Axis::Z], |z| z + modal.offset(Axis::Z));
            modal.place_xy(xy, now)
        } else {
            let [x, y] = modal.way_xy(xy.map(Option::unwrap_or_default));
            [now[0] + x, now[1] + y]
        };
        (target[Axis::X], target[Axis::Y]) = (x, y);
        target
    }
}

/// Makes a jog, behind other jogs: returns when it is planned. A jog that is cancelled while it waits for
/// room is not made. `s` is that of a laser's constant power, 0 without.
///
/// # Errors
/// When something else moves, the target is out of the travel, or the machine halts.
pub(crate) fn jog<'c>(hands: &mut impl Hands<'c>, jog: &Jog, modal: &Modal, s: f32) -> Result<(), Failure> {
    let config = hands.config();
    let has_motor =
        |axis: Axis| Actuator::from_index(axis as usize).is_some_and(|motor| config.actuators[motor].present);
    if let Some(axis) = Axis::ALL.into_iter().find(|axis| jog.words[*axis].is_some() && !has_motor(*axis)) {
        return Err(hands.texts().refused(format_args!("{} has no motor", axis.letter())).with_reason(Reason::BadJog));
    }
    if config.motion.must_be_homed && !hands.all_homed() {
        return Err(Failure::refused(&"Must be homed before moving").with_reason(Reason::NeedsHoming));
    }
    // An earlier request to stop is not meant for this jog.
    let _before = hands.stop_requested();
    loop {
        if !matches!(hands.state(), State::Idle | State::Suspended | State::Jog) {
            return Err(
                Failure::refused(&"a jog begins from standstill, or behind another one").with_reason(Reason::NotIdle)
            );
        }
        let is_free = hands.motion(|motion| {
            let (used, size) = motion.queue_level();
            used < size && motion.state() == motion::State::Running
        });
        if hands.stop_requested() {
            return Ok(());
        }
        if is_free {
            break;
        }
        hands.wait(Wake::Any).unless_halted()?;
    }
    let (from, homed) = (hands.position(), hands.axes().homed());
    let target = jog.target(&from, modal);
    if let Err(out) = hands.travel().check(&from, &target, homed) {
        return Err(hands.texts().refused(format_args!("{out}")).with_reason(Reason::JogTravel));
    }
    if target == from {
        return Ok(());
    }
    let begins = hands.apply(Event::JogBegins);
    let power = hands.tuning().laser.of_jog(s, config);
    let mode = if power == Power::OFF { Mode::Rapid } else { Mode::Feed };
    let went = hands.submit(motion::Move { target, feed_rate: jog.rate, mode, power, ..motion::Move::default() });
    if begins && went.is_err() && hands.motion(|motion| motion.is_idle()) {
        hands.apply(Event::Drained);
    }
    went?;
    hands.motion(motion::Motion::flush);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn modal() -> Modal {
        let mut modal = Modal::new(MmPerSecond(1.0), MmPerSecond(1.0));
        modal.systems[0] = [10.0, 20.0, 30.0];
        modal
    }

    fn number(text: &str) -> Reason {
        match read(&Texts::new(), text, &modal()) {
            Err(text) if text.is_refusal() => text.reason,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn what_is_no_jog_is_refused_by_number() {
        for (text, error) in [
            ("X1", Reason::FeedRate),
            ("X1F0", Reason::FeedRate),
            ("F100", Reason::NoAxes),
            ("", Reason::NoAxes),
            ("G1X1F100", Reason::BadJog),
            ("M3X1F100", Reason::BadJog),
            ("X1F100S5", Reason::BadJog),
            ("X1 F100 P", Reason::Number),
            ("X1F", Reason::Number),
            ("X1 F1 &", Reason::Letter),
        ] {
            assert_eq!(number(text), error, "{text}");
        }
    }

    proptest! {
        /// Spaced or not, in any order: the same place, in work coordinates, as a distance, or in machine
        /// coordinates.
        #[test]
        fn units_and_distance_mode_are_its_own(
            x in -100.0..100.0_f64, from in -50.0..50.0_f64, inches: bool, mode in 0..3_usize, spaced: bool, last: bool,
        ) {
            let blank = if spaced { " " } else { "" };
            let codes = [if inches { "G20" } else { "G21" }, ["G90", "G91", "G53"][mode]].join(blank);
            let words = format!("X{x:.3}{blank}F600");
            let text = if last { format!("{words}{blank}{codes}") } else { format!("{codes}{blank}{words}") };
            let mut modal = modal();
            modal.absolute = mode == 1;
            let place = PerAxis([from, 1.0, 2.0, 0.0, 0.0, 0.0]);
            let jog = read(&Texts::new(), &text, &modal).unwrap();
            let unit = if inches { 25.4 } else { 1.0 };
            let word = format!("{x:.3}").parse::<f64>().unwrap() * unit;
            let expected = [word + 10.0, from + word, word][mode];
            let target = jog.target(&place, &modal);
            prop_assert!((target[Axis::X] - expected).abs() < 1e-9, "{text}: {target:?}");
            prop_assert_eq!((target[Axis::Y], target[Axis::Z]), (1.0, 2.0));
            prop_assert!((jog.rate.0 - 10.0 * unit).abs() < 1e-9);
        }
    }
}
