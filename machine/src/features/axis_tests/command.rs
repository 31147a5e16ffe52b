//! `test`: moves back and forth, squares and circles, to see a machine run; and so many steps of one motor,
//! to count them.
//!
//! Figures are lines of codes, so they go the way of every program. Their reach is checked before the first
//! line.

use core::fmt::Write;

use base::failure::{Answer, Failure, Outcome};
use base::ports::Wake;
use heapless::String;
use motion::{Kinematics, Limits, Mode};
use units::{Actuator, Axis, MmPerSecond, MmPerSecond2, PerAxis};

use crate::features::axis_tests;
use crate::features::axis_tests::{APPROACHES, Speed, Sweep, TIMES, TestHands};

/// A line of a figure.
type Line = String<64>;

/// The modes that figures are drawn in: lengths a minute, distances, also of E, in X and Y.
const MODES: [&str; 4] = ["G94", "G91", "M83", "G17"];

/// Figure to be drawn, in the program's units.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Figure {
    shape: Shape,
    size: f64,
    times: u32,
    /// Feed rate a minute; the modal one where none is said.
    feed: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// Back and forth along this axis.
    Line(char),
    Square,
    Circle,
}

/// Steps of one motor to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Steps {
    axis: Axis,
    /// Number of steps, or with `acc` mm.
    count: f64,
    /// Steps, or mm, in a second.
    rate: f64,
    are_mm: bool,
    /// Acceleration of the move, where it is not the machine's.
    acceleration: Option<MmPerSecond2>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Test {
    Figure(Figure),
    Steps(Steps),
    /// Homing accuracy of this axis, in so many approaches.
    Endstop(Axis, u8),
    /// Test for lost steps.
    Speed(Speed),
    /// Search for the frame's resonance.
    Sweep(Sweep),
    /// Backlash of this axis, and the distance of the probe's contact.
    Backlash(Axis, f64),
}

fn parse(arguments: &str) -> Result<Test, &'static str> {
    let mut words = arguments.split_ascii_whitespace();
    let what = words.next().unwrap_or("");
    let usage = match what {
        "jog" => "usage: test jog axis distance times [feed]",
        "square" => "usage: test square size times [feed]",
        "circle" => "usage: test circle radius times [feed]",
        "raw" => "usage: test raw axis steps steps/s [mm/s2]",
        "acc" => "usage: test acc axis mm mm/s [mm/s2]",
        "endstop" => "usage: test endstop axis [approaches]",
        "speed" => "usage: test speed axis mm mm/s [times]",
        "sweep" => "usage: test sweep axis from-Hz to-Hz [seconds a Hz]",
        "backlash" => "usage: test backlash axis distance: towards the probe, negative the other way",
        "pulse" => return Err("test pulse: step pins are the step interrupt's; test raw makes steps"),
        _ => return Err("usage: test jog|square|circle|raw|acc|endstop|speed|sweep|backlash: each says what it takes"),
    };
    let letter = match what {
        "jog" | "raw" | "acc" | "endstop" | "speed" | "sweep" | "backlash" => {
            words.next().and_then(|word| word.chars().next()).ok_or(usage)?.to_ascii_uppercase()
        }
        _ => ' ',
    };
    let mut number = || words.next().map(|word| gcode::read_f64(word).filter(|n| n.is_finite()).ok_or(usage));
    if what == "endstop" {
        let axis = Axis::from_letter(letter).ok_or("axis must be x, y, z, a, b, c")?;
        let count = number().transpose()?.unwrap_or(f64::from(APPROACHES));
        return Ok(Test::Endstop(axis, units::within(count, 2.0, 100.0) as u8));
    }
    if what == "backlash" {
        let axis = Axis::from_letter(letter).ok_or("axis must be x, y, z, a, b, c")?;
        return Ok(Test::Backlash(axis, number().ok_or(usage)??));
    }
    let (size, count) = (number().ok_or(usage)??, number().ok_or(usage)??);
    let feed = number().transpose()?;
    if count <= 0.0 || feed.is_some_and(|feed| feed <= 0.0) {
        return Err("test: times and rates are above zero");
    }
    if what == "sweep" {
        let axis = Axis::from_letter(letter).ok_or("axis must be x, y, z, a, b, c")?;
        if !(1.0..=200.0).contains(&size) || count > 200.0 {
            return Err("test sweep: frequencies are from 1 to 200 Hz");
        }
        return Ok(Test::Sweep(Sweep { axis, from: size, to: count, pace: feed.unwrap_or(1.0) }));
    }
    if what == "speed" {
        let axis = Axis::from_letter(letter).ok_or("axis must be x, y, z, a, b, c")?;
        let times = feed.map_or(TIMES, |times| times as u32).max(1);
        return Ok(Test::Speed(Speed { axis, way: size, rate: MmPerSecond(count), times }));
    }
    if matches!(what, "raw" | "acc") {
        let axis = Axis::from_letter(letter).ok_or("axis must be x, y, z, a, b, c")?;
        let (are_mm, acceleration) = (what == "acc", feed.map(MmPerSecond2));
        return Ok(Test::Steps(Steps { axis, count: size, rate: count, are_mm, acceleration }));
    }
    let shape = match what {
        "jog" if letter == 'E' || Axis::from_letter(letter).is_some() => Shape::Line(letter),
        "jog" => return Err("axis must be x, y, z, a, b, c, e"),
        "square" => Shape::Square,
        _ => Shape::Circle,
    };
    Ok(Test::Figure(Figure { shape, size, times: count as u32, feed }))
}

impl Figure {
    /// Returns the figure's line of this number; none behind its end. The first lines set the modes that it
    /// is drawn in.
    fn line(&self, number: u32) -> Option<Line> {
        let mut line = Line::new();
        if let Some(mode) = MODES.get(number as usize) {
            // The mode fits in a line.
            let _ = line.push_str(mode);
            return Some(line);
        }
        let (size, number) = (self.size, number - MODES.len() as u32);
        // Every code fits in a line.
        let _ = match self.shape {
            Shape::Line(_) if number >= self.times => return None,
            Shape::Line(axis) => write!(line, "G1 {axis}{}", if number.is_multiple_of(2) { size } else { -size }),
            Shape::Square if number / 4 >= self.times => return None,
            Shape::Square => {
                let side = if number % 4 < 2 { size } else { -size };
                write!(line, "G1 {}{side}", if number.is_multiple_of(2) { 'X' } else { 'Y' })
            }
            Shape::Circle if number == 0 => write!(line, "G1 X{}", -size),
            Shape::Circle if number <= self.times => write!(line, "G2 I{size} J0"),
            Shape::Circle if number == self.times + 1 => write!(line, "G1 X{size}"),
            Shape::Circle => return None,
        };
        if let Some(feed) = self.feed {
            let _ = write!(line, " F{feed}");
        }
        Some(line)
    }

    /// Returns the figure's reach along the axes: its greatest coordinates and its least.
    fn reach(&self, mm: f64) -> [PerAxis<f64>; 2] {
        let mut reach = [PerAxis([0.0; units::MAX_AXES]); 2];
        let size = self.size * mm;
        match self.shape {
            Shape::Line(letter) => {
                if let Some(axis) = Axis::from_letter(letter) {
                    reach[0][axis] = size;
                }
            }
            Shape::Square => {
                (reach[0][Axis::X], reach[0][Axis::Y]) = (size, size);
            }
            Shape::Circle => {
                for (end, far) in reach.iter_mut().zip([size, -size]) {
                    (end[Axis::X], end[Axis::Y]) = (far, far);
                }
            }
        }
        reach
    }
}

/// Runs `test ...`: figures, steps, and tests of an axis.
///
/// # Errors
/// When the words are not understood, leave the travel or are refused as the codes are; while a file is
/// played.
pub(crate) fn run<'c>(hands: &mut impl TestHands<'c>, arguments: &str) -> Outcome {
    let test = parse(arguments).map_err(|error| hands.texts().refused(format_args!("{error}")))?;
    if hands.is_playing() {
        return Err(Failure::refused(&"a file is being played: abort it first"));
    }
    hands.standstill()?;
    match test {
        Test::Figure(figure) => {
            let kept = hands.program().keep();
            let drawn = draw(hands, &figure);
            hands.program().come_back_to(kept);
            drawn?;
        }
        Test::Steps(steps) => step(hands, &steps)?,
        Test::Endstop(axis, count) => axis_tests::endstop(hands, axis, count)?,
        Test::Sweep(sweep) => axis_tests::sweep(hands, &sweep)?,
        Test::Backlash(axis, distance) => {
            let measured = procedures::probing::lost_motion(hands, axis, distance).map(|()| Answer::Ok);
            let measured = procedures::probing::stow_after(hands, measured).map(|_| ());
            hands.resynchronise_if_still();
            measured?;
        }
        Test::Speed(speed) => axis_tests::speed(hands, &speed)?,
    }
    Ok(Answer::Ok)
}

/// Draws a figure; Ctrl-Y brakes and ends it.
fn draw<'c>(hands: &mut impl TestHands<'c>, figure: &Figure) -> Result<(), Failure> {
    let mm = 1.0 / hands.program().modal().in_program_units(1.0);
    let from = hands.position();
    for reach in figure.reach(mm) {
        hands.stays_within(&from, &PerAxis(Axis::ALL.map(|axis| from[axis] + reach[axis])))?;
    }
    let (mut number, mut stopped) = (0, false);
    loop {
        if hands.stop_requested() {
            hands.motion(motion::Motion::stop);
            stopped = true;
        }
        match figure.line(number).filter(|_| !stopped) {
            Some(line) => {
                hands.run_line(&line)?;
                number += 1;
            }
            None if hands.motion(|motion| motion.is_idle()) => break,
            None => {
                hands.motion(motion::Motion::flush);
                hands.wait(Wake::Any).unless_halted()?;
            }
        }
    }
    if stopped {
        hands.resynchronise();
    }
    Ok(())
}

/// Makes one motor's steps as a move of its axis.
fn step<'c>(hands: &mut impl TestHands<'c>, steps: &Steps) -> Result<(), Failure> {
    let config = hands.motion_config()?;
    let motor = Actuator::from_index(steps.axis as usize).and_then(|motor| config.actuators[motor]);
    let per_mm = motor.ok_or_else(|| Failure::refused(&"axis is out of range"))?.steps_per_mm;
    if !moves_alone(&config.kinematics, steps.axis) {
        return Err(Failure::refused(&"test raw: on this machine no motor moves one axis alone"));
    }
    let (count, rate) = match steps.are_mm {
        true => (steps.count * per_mm, steps.rate * per_mm),
        false => (steps.count, steps.rate),
    };
    let (count, letter) = (libm::round(count), steps.axis.letter());
    let from = hands.position();
    let mut target = from;
    target[steps.axis] += count / per_mm;
    hands.stays_within(&from, &target)?;
    let (shown, shown_rate) = (libm::fabs(count), libm::round(rate));
    hands.say(format_args!("issuing {shown} steps at a rate of {shown_rate} steps/sec on the {letter} axis\n"));
    let limits = config.limits;
    if let Some(acceleration) = steps.acceleration {
        let own = Limits { acceleration, ..limits };
        hands.motion(|motion| motion.set_limits(own)).map_err(|error| hands.texts().refusal(error))?;
    }
    let went = hands.go(target, MmPerSecond(rate / per_mm), Mode::Rapid);
    let stood = hands.standstill();
    if steps.acceleration.is_some() {
        // The old limits come back, whatever happened.
        let restored = hands.motion(|motion| motion.set_limits(limits));
        debug_assert!(restored.is_ok(), "they were in force before");
    }
    hands.resynchronise();
    went.and(stood)
}

/// Whether an axis has a motor that moves nothing else.
fn moves_alone(kinematics: &Kinematics, axis: Axis) -> bool {
    let own = 1 << axis as usize;
    !Axis::PRIMARY.contains(&axis)
        || kinematics.motors_of(axis) == own
            && Axis::PRIMARY.into_iter().all(|other| other == axis || kinematics.motors_of(other) & own == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(arguments: &str) -> Vec<std::string::String> {
        let Ok(Test::Figure(figure)) = parse(arguments) else { panic!("{arguments} is no figure") };
        (MODES.len() as u32..).map_while(|number| figure.line(number)).map(|line| line.as_str().into()).collect()
    }

    #[test]
    fn figures_end_where_they_began() {
        assert_eq!(lines("jog x 5 3"), ["G1 X5", "G1 X-5", "G1 X5"]);
        assert_eq!(lines("square 2 1 600"), ["G1 X2 F600", "G1 Y2 F600", "G1 X-2 F600", "G1 Y-2 F600"]);
        assert_eq!(lines("circle 2 2"), ["G1 X-2", "G2 I2 J0", "G2 I2 J0", "G1 X2"]);
        assert_eq!(lines("square 2 3").len(), 12);
    }

    #[test]
    fn steps_are_read_and_mistakes_are_said() {
        let raw = Steps { axis: Axis::X, count: -100.0, rate: 1_000.0, are_mm: false, acceleration: None };
        assert_eq!(parse("raw x -100 1000"), Ok(Test::Steps(raw)));
        let gentle = Steps { are_mm: true, acceleration: Some(MmPerSecond2(50.0)), ..raw };
        assert_eq!(parse("acc x -100 1000 50"), Ok(Test::Steps(gentle)));
        for (arguments, part) in [
            ("", "test jog|square"),
            ("nosuch", "test jog|square"),
            ("jog", "test jog axis"),
            ("square 2", "test square size"),
            ("jog x 5", "test jog axis"),
            ("jog x 5 y", "test jog axis"),
            ("jog q 5 5", "axis must be"),
            ("jog x 5 0", "above zero"),
            ("square 2 1 -5", "above zero"),
            ("raw q 10 10", "axis must be"),
            ("pulse x", "test raw"),
        ] {
            let text = parse(arguments).expect_err(arguments);
            assert!(text.contains(part), "{arguments}: {text}");
        }
    }
}
