//! `$J`: jogs, which are moves by hand.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::motion_config::slowest_rate;
use base::ports::Wake;
use base::safety::Event;
use motion::{Mode, Motion};
use program::State;
use units::{Actuator, Axis, MmPerSecond, PerAxis};

use base::hands::Hands;

/// Least length of one piece of a continuous jog, mm.
const LEAST_PIECE: f64 = 1.0 / 3.0;

/// Parsed request for a jog.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Request {
    /// Distance along each axis, mm.
    by: PerAxis<f64>,
    rate: Rate,
    continuous: bool,
    /// Whether to answer with ok although the jog is not continuous.
    replies: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Rate {
    /// Share of the slowest motor's top rate.
    Scale(f64),
    /// Rate in mm/s.
    Absolute(f64),
}

impl Request {
    /// Returns the axes that the jog moves.
    fn axes(&self) -> impl Iterator<Item = Axis> {
        Axis::ALL.into_iter().filter(|axis| self.by[*axis] != 0.0)
    }
}

/// Parses `-c -r X10 Y-1 S0.5 F600`. `e_axis` is the axis that E stands for.
fn parse(texts: &Texts, text: &str, e_axis: Option<Axis>) -> Result<Request, Failure> {
    let mut request =
        Request { by: PerAxis([0.0; units::MAX_AXES]), rate: Rate::Scale(1.0), continuous: false, replies: false };
    for word in text.split(';').next().unwrap_or("").split_ascii_whitespace() {
        match word {
            "-c" => request.continuous = true,
            "-r" => request.replies = true,
            option if option.starts_with('-') => {
                return Err(refused(texts, "illegal option", option.trim_start_matches('-')));
            }
            _ => parse_word(texts, word, e_axis, &mut request)?,
        }
    }
    if request.axes().next().is_none() {
        return Err(Failure::refused(&"no delta jog specified"));
    }
    Ok(request)
}

fn parse_word(texts: &Texts, word: &str, e_axis: Option<Axis>, request: &mut Request) -> Result<(), Failure> {
    let mut characters = word.chars();
    let letter = characters.next().unwrap_or(' ').to_ascii_uppercase();
    let number = gcode::read_f64(characters.as_str()).filter(|number| number.is_finite());
    let number = number.ok_or_else(|| refused(texts, "no number after", word))?;
    match letter {
        'S' => request.rate = Rate::Scale(number),
        'F' => request.rate = Rate::Absolute(number / 60.0),
        letter => {
            let axis = if letter == 'E' { e_axis } else { Axis::from_letter(letter) };
            request.by[axis.ok_or_else(|| refused(texts, "bad axis", word))?] = number;
        }
    }
    Ok(())
}

fn refused(texts: &Texts, what: &str, word: &str) -> Failure {
    texts.refused(format_args!("{what} {word}"))
}

/// `$J [-c] [-r] words`: moves from where the last move ends, cut to the travel. `e_axis` is the axis of the
/// extruder in use.
///
/// # Errors
/// When the jog is not understood, the machine must be homed first or is halted, or nothing of the jog is
/// within the travel.
pub fn jog<'c>(hands: &mut impl Hands<'c>, text: &str, e_axis: Option<Axis>) -> Outcome {
    if matches!(hands.state(), State::Alarm | State::Sleep | State::Invalid) {
        return Err(Failure::HALTED);
    }
    let request = parse(hands.texts(), text, e_axis)?;
    let config = hands.config();
    if let Some(axis) = request.axes().find(|axis| !config.actuators.0.get(*axis as usize).is_some_and(|m| m.present)) {
        return Err(hands.texts().refused(format_args!("axis out of range {}", axis.letter())));
    }
    if config.motion.must_be_homed && !hands.all_homed() {
        return Err(Failure::alarm(&"Must be homed before moving"));
    }
    let motors = request.axes().filter_map(|axis| Actuator::from_index(axis as usize));
    let rate = rate(request.rate, slowest_rate(config, motors).0)?;
    if hands.state() == State::Check {
        return Ok(if request.replies || request.continuous { Answer::Ok } else { Answer::Said });
    }
    if request.continuous {
        jog_continuously(hands, &request.by, rate)?;
        return Ok(Answer::Ok);
    }
    if !move_by(hands, &request.by, rate)? {
        return Err(out_of_travel(hands, &request.by));
    }
    Ok(if request.replies { Answer::Ok } else { Answer::Said })
}

/// Returns the rate of a jog, at most the slowest motor's own, mm/s.
fn rate(asked: Rate, top: f64) -> Result<f64, Failure> {
    let rate = match asked {
        Rate::Scale(scale) => top * scale,
        Rate::Absolute(rate) => rate,
    };
    if rate <= 0.0 {
        return Err(Failure::refused(&"the jog rate must be above zero"));
    }
    Ok(if rate > top { top } else { rate })
}

fn moved(from: &PerAxis<f64>, by: &PerAxis<f64>) -> PerAxis<f64> {
    PerAxis(Axis::ALL.map(|axis| from[axis] + by[axis]))
}

fn out_of_travel<'c>(hands: &mut impl Hands<'c>, by: &PerAxis<f64>) -> Failure {
    let (from, homed) = (hands.position(), hands.axes().homed());
    match hands.travel().check(&from, &moved(&from, by), homed) {
        Err(out) => hands.texts().refused(format_args!("{out}")),
        Ok(()) => Failure::refused(&"no delta jog specified"),
    }
}

/// Submits one move, cut to the travel. False when nothing is left of it.
fn move_by<'c>(hands: &mut impl Hands<'c>, by: &PerAxis<f64>, rate: f64) -> Result<bool, Failure> {
    let (from, homed) = (hands.position(), hands.axes().homed());
    let target = hands.travel().cut(&from, &moved(&from, by), homed);
    if target == from {
        return Ok(false);
    }
    // A move from standstill is a jog; behind other moves it is one of them.
    let begins = hands.apply(Event::JogBegins);
    let went = hands.go(target, MmPerSecond(rate), Mode::Rapid);
    if begins && went.is_err() && hands.motion(|motion| motion.is_idle()) {
        hands.apply(Event::Drained);
    }
    went?;
    hands.motion(Motion::flush);
    Ok(true)
}

/// Runs until Ctrl-Y, then brakes. Pieces are queued only as far ahead as braking needs.
fn jog_continuously<'c>(hands: &mut impl Hands<'c>, by: &PerAxis<f64>, rate: f64) -> Result<(), Failure> {
    if !hands.can_be_stopped() {
        return Err(Failure::refused(&"unable to set continuous jog mode"));
    }
    // A request to stop that came before this jog's line is not meant for it; one behind the line has dropped
    // the line, or comes during the waits from here on.
    let _before = hands.stop_requested();
    hands.standstill()?;
    let braking = hands.motion(|motion| motion.config().map_or(0.0, |config| config.limits.braking_length(rate)));
    let length = if braking > LEAST_PIECE { braking } else { LEAST_PIECE };
    let piece = PerAxis(by.0.map(|mm| match mm {
        0.0 => 0.0,
        mm => libm::copysign(length, mm),
    }));
    jog_pieces(hands, &piece, rate)?;
    hands.motion(Motion::stop);
    hands.standstill()?;
    hands.apply(Event::Drained);
    Ok(())
}

fn jog_pieces<'c>(hands: &mut impl Hands<'c>, piece: &PerAxis<f64>, rate: f64) -> Result<(), Failure> {
    let mut moves = false;
    while !hands.is_let_go() {
        // Two pieces wait beside the one under way: enough to keep the speed, little enough to stop soon.
        if hands.motion(|motion| motion.queue_level().0) >= 2 {
            hands.wait(Wake::Any).unless_halted()?;
        } else if move_by(hands, piece, rate)? {
            moves = true;
        } else if moves {
            // At the end of the travel: the operator ends the jog.
            hands.wait(Wake::Any).unless_halted()?;
        } else {
            return Err(out_of_travel(hands, piece));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::machine;
    use units::AxisSet;

    fn refusal(text: &str) -> String {
        let texts = Texts::new();
        match parse(&texts, text, None) {
            Err(refused) if refused.is_refusal() => texts.of(refused).to_string(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn words_options_and_rates_are_read() {
        let request = parse(&Texts::new(), " -c X10 y-2.5 F600 ; comment", None).unwrap();
        assert_eq!((request.by[Axis::X], request.by[Axis::Y]), (10.0, -2.5));
        assert_eq!((request.continuous, request.replies, request.rate), (true, false, Rate::Absolute(10.0)));
        assert_eq!(parse(&Texts::new(), "E5 F60 S0.5", Some(Axis::A)).unwrap().rate, Rate::Scale(0.5));
        assert_eq!(parse(&Texts::new(), "E5", Some(Axis::A)).unwrap().by[Axis::A], 5.0);
    }

    #[test]
    fn what_is_wrong_with_a_jog_is_said() {
        assert_eq!(refusal("-q X1"), "illegal option q");
        assert_eq!(refusal("Q1"), "bad axis Q1");
        assert_eq!(refusal("E1"), "bad axis E1");
        assert_eq!(refusal("X"), "no number after X");
        assert_eq!(refusal("F100"), "no delta jog specified");
    }

    #[test]
    fn a_jog_goes_as_far_as_it_says_at_its_share_of_the_top_rate() {
        for (text, x, z, seconds) in [("X10 F1200", 10.0, 0.0, 0.5), ("x-5 z2 S0.5", -5.0, 2.0, 0.36)] {
            let mut bench = machine("", [-90.0; 3]);
            assert_eq!(jog(&mut bench, text, None), Ok(Answer::Said));
            assert_eq!(bench.state(), State::Jog);
            let began = bench.now();
            bench.standstill().unwrap();
            let took = bench.now().since(began).0 as f64 / 1e6;
            assert!((took - seconds).abs() < 0.1, "{text}: {took} s");
            assert_eq!((bench.position()[Axis::X], bench.position()[Axis::Z]), (x, z));
            assert_eq!(bench.state(), State::Idle);
        }
    }

    #[test]
    fn a_jog_ends_at_the_travel_of_what_is_homed_and_goes_nowhere_beyond() {
        let mut bench = machine("", [-90.0; 3]);
        bench.motors.mark_homed(AxisSet::PRIMARY);
        assert_eq!(jog(&mut bench, "-r X500", None), Ok(Answer::Ok));
        bench.standstill().unwrap();
        let end = bench.travel().ends()[1][Axis::X];
        assert!((bench.position()[Axis::X] - end).abs() < 1e-9 && end < 100.0, "{end}");
        let failure = jog(&mut bench, "X1", None).unwrap_err();
        assert!(failure.is_refusal(), "{}", bench.text_of(failure));
        assert!((bench.position()[Axis::X] - end).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_move_is_not_jogged() {
        let mut bench = machine("[motion control]\nmust_be_homed = true\n", [-90.0; 3]);
        let failure = jog(&mut bench, "X1", None).unwrap_err();
        assert!(failure.is_alarm() && bench.text_of(failure).contains("Must be homed"));
        bench.motors.mark_homed(AxisSet::PRIMARY);
        assert_eq!(jog(&mut bench, "X1", None), Ok(Answer::Said));
        let failure = jog(&mut bench, "A1", None).unwrap_err();
        assert_eq!(bench.text_of(failure), "axis out of range A");
        let failure = jog(&mut bench, "X1 F0", None).unwrap_err();
        assert_eq!(bench.text_of(failure), "the jog rate must be above zero");
        bench.standstill().unwrap();
        bench.halt(base::reason::Alarm::Abort, format_args!("ALARM\n"));
        assert_eq!(jog(&mut bench, "X1", None), Err(Failure::HALTED));
        assert_eq!(bench.position()[Axis::X], 1.0, "nothing of the others was made");
    }

    #[test]
    fn a_stop_that_came_before_a_continuous_jog_does_not_end_it() {
        let mut bench = machine("", [-900.0; 3]);
        bench.stops = true;
        bench.later(units::Micros::from_millis(500), |bench| bench.stops = true);
        assert_eq!(jog(&mut bench, "-c X1 F1800", None), Ok(Answer::Ok));
        assert!(bench.position()[Axis::X] > 10.0, "{:?}", bench.position());
    }

    #[test]
    fn a_continuous_jog_goes_on_until_it_is_let_go_and_stops_soon_after() {
        let mut bench = machine("", [-900.0; 3]);
        bench.later(units::Micros::from_millis(800), |bench| bench.stops = true);
        assert_eq!(jog(&mut bench, "-c X1 F1800", None), Ok(Answer::Ok));
        let x = bench.position()[Axis::X];
        // 0.8 s at 30 mm/s, and what braking takes.
        assert!((22.0..26.0).contains(&x), "{x}");
        assert_eq!(bench.state(), State::Idle);
    }
}
