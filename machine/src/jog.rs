//! `$J`: moves by hand.

use motion::Mode;
use units::{Actuator, Axis, MmPerSecond, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::motion_config::slowest_rate;
use crate::ports::Ports;
use crate::state::State;

/// Least length of one piece of a continuous jog, mm.
const LEAST_PIECE: f64 = 1.0 / 3.0;

/// A jog as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Request {
    /// Distance along each axis, mm.
    by: PerAxis<f64>,
    /// Rate asked for.
    rate: Rate,
    continuous: bool,
    /// Answer with ok although it is not continuous.
    replies: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Rate {
    /// Share of the slowest motor's top rate.
    Scale(f64),
    /// mm/s.
    Absolute(f64),
}

/// Reads `-c -r X10 Y-1 S0.5 F600`. `e_axis` is the axis that E stands for.
fn parse(text: &str, e_axis: Option<Axis>) -> Result<Request, Failure> {
    let mut request =
        Request { by: PerAxis([0.0; units::MAX_AXES]), rate: Rate::Scale(1.0), continuous: false, replies: false };
    let refuse = |what: &str, word: &str| Failure::Refused(message(format_args!("{what} {word}")));
    let mut any = false;
    for word in text.split(';').next().unwrap_or("").split_ascii_whitespace() {
        match word {
            "-c" => request.continuous = true,
            "-r" => request.replies = true,
            option if option.starts_with('-') => return Err(refuse("illegal option", option.trim_start_matches('-'))),
            _ => {
                let mut characters = word.chars();
                let letter = characters.next().unwrap_or(' ').to_ascii_uppercase();
                let number = characters.as_str().parse::<f64>().ok().filter(|number| number.is_finite());
                let number = number.ok_or_else(|| refuse("no number after", word))?;
                match letter {
                    'S' => request.rate = Rate::Scale(number),
                    'F' => request.rate = Rate::Absolute(number / 60.0),
                    letter => {
                        let axis = if letter == 'E' { e_axis } else { Axis::from_letter(letter) };
                        let axis = axis.ok_or_else(|| refuse("bad axis", word))?;
                        request.by[axis] = number;
                        any |= number != 0.0;
                    }
                }
            }
        }
    }
    if any { Ok(request) } else { Err(Failure::refused("no delta jog specified")) }
}

impl<P: Ports> Controller<P> {
    /// `$J [-c] [-r] words`
    pub(crate) async fn jog_command(&mut self, text: &str) -> Outcome {
        if self.state == State::Halt || self.crippled {
            return Err(Failure::Halted);
        }
        let e_axis = self.tools.active().map(|tool| tool.axis);
        let request = parse(text, e_axis)?;
        let moved = || Axis::ALL.into_iter().filter(|axis| request.by[*axis] != 0.0);
        for axis in moved() {
            if !self.config.actuators.0.get(axis as usize).is_some_and(|motor| motor.present) {
                return Err(Failure::Refused(message(format_args!("axis out of range {}", axis.letter()))));
            }
        }
        if self.config.motion.must_be_homed && !self.all_homed() {
            return Err(Failure::alarm("Must be homed before moving"));
        }
        let motors = moved().filter_map(|axis| Actuator::from_index(axis as usize));
        let top = slowest_rate(&self.config, motors).0;
        let rate = match request.rate {
            Rate::Scale(scale) => top * scale,
            Rate::Absolute(rate) => rate,
        };
        if rate <= 0.0 {
            return Err(Failure::refused("the jog rate must be above zero"));
        }
        let rate = if rate > top { top } else { rate };
        if request.continuous {
            return self.jog_continuously(&request.by, rate).await;
        }
        let mut target = self.position;
        moved().for_each(|axis| target[axis] += request.by[axis]);
        self.go(target, MmPerSecond(rate), Mode::Rapid).await?;
        self.ports.motion(motion::Motion::flush);
        Ok(if request.replies { Answer::Ok } else { Answer::Said })
    }

    /// Runs until Ctrl-Y, then brakes. Pieces are queued only as far ahead as braking needs.
    async fn jog_continuously(&mut self, by: &PerAxis<f64>, rate: f64) -> Outcome {
        if !self.is_from_a_console() {
            return Err(Failure::refused("unable to set continuous jog mode"));
        }
        self.wait_idle().await?;
        let braking =
            self.ports.motion(|motion| motion.config().map_or(0.0, |config| config.limits.braking_length(rate)));
        let piece = if braking > LEAST_PIECE { braking } else { LEAST_PIECE };
        self.jog_pieces(by, piece, rate).await?;
        self.ports.motion(motion::Motion::stop);
        self.wait_idle().await?;
        self.resync();
        Ok(Answer::Ok)
    }

    async fn jog_pieces(&mut self, by: &PerAxis<f64>, piece: f64, rate: f64) -> Result<(), Failure> {
        while !self.stop_requested() {
            // Two pieces wait beside the one under way: enough to keep the speed, little enough to stop soon.
            if self.ports.motion(|motion| motion.queue_level().0) >= 2 {
                self.pause().await?;
                continue;
            }
            let mut target = self.position;
            for axis in Axis::ALL.into_iter().filter(|axis| by[*axis] != 0.0) {
                target[axis] += if by[axis] > 0.0 { piece } else { -piece };
            }
            self.go(target, MmPerSecond(rate), Mode::Rapid).await?;
            self.ports.motion(motion::Motion::flush);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        match parse(text, None) {
            Err(Failure::Refused(text)) => text.as_str().into(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn words_options_and_rates_are_read() {
        let request = parse(" -c X10 y-2.5 F600 ; comment", None).unwrap();
        assert_eq!((request.by[Axis::X], request.by[Axis::Y]), (10.0, -2.5));
        assert_eq!((request.continuous, request.replies, request.rate), (true, false, Rate::Absolute(10.0)));
        assert_eq!(parse("E5 F60 S0.5", Some(Axis::A)).unwrap().rate, Rate::Scale(0.5));
        assert_eq!(parse("E5", Some(Axis::A)).unwrap().by[Axis::A], 5.0);
    }

    #[test]
    fn what_is_wrong_with_a_jog_is_said() {
        assert_eq!(refusal("-q X1"), "illegal option q");
        assert_eq!(refusal("Q1"), "bad axis Q1");
        assert_eq!(refusal("E1"), "bad axis E1");
        assert_eq!(refusal("X"), "no number after X");
        assert_eq!(refusal("F100"), "no delta jog specified");
    }
}
