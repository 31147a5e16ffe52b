//! G0, G1 and G4, and the parts common to all motion codes: from words to machine positions.

use units::{Axis, Micros, MmPerSecond, PerAxis};

use crate::action::{Action, Rate, Shape};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Part, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::{arcs, extruders, feed_modes, spindle, splines};
use crate::state::modal::{FeedMode, MotionMode};
use crate::state::pixels::Pixels;
use crate::words::Words;
use gcode::Dialect;

/// Longest dwell, s: a day.
pub(crate) const LONGEST_DWELL: f64 = 86_400.0;

/// Moves by G0 to G3, G5 to G5.2, or words without a code.
pub(crate) fn motion<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    if let Some(mode) = MotionMode::from_g(code.number, code.subcode) {
        program.modal.motion = mode;
    }
    motion_block(program, context)
}

/// Moves by the motion code in force, which ends the effect of G53.
pub(crate) fn motion_block<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    if program.modal.feed_mode != FeedMode::PerMinute {
        return feed_modes::motion_block(program, context);
    }
    let done = draw_block(program, context);
    program.modal.machine_next = false;
    done
}

fn draw_block<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    take_rates(program, context)?;
    let words = &context.words;
    let mode = program.modal.motion;
    splines::begin_motion(program, mode, words.column())?;
    if mode == MotionMode::Nurbs {
        return splines::control_point(program, words);
    }
    let (target, e) = target_of(program, context)?;
    let shape = match mode {
        MotionMode::Rapid | MotionMode::Linear => Shape::Line { names_xy: words.has('X') || words.has('Y') },
        MotionMode::Cubic => splines::cubic(program, words)?,
        MotionMode::Quadratic => splines::quadratic(program, words)?,
        // A line with a rate alone draws no arc.
        MotionMode::ArcClockwise | MotionMode::ArcCounterClockwise if !arcs::is_drawn_by(words) => return NOTHING,
        MotionMode::ArcClockwise => arcs::arc(program, context, true)?,
        MotionMode::ArcCounterClockwise => arcs::arc(program, context, false)?,
        MotionMode::Nurbs => return NOTHING,
        MotionMode::Cycle => return Err(Problem::CycleInMachineCoordinates.refused(words.column())),
        MotionMode::Cancelled | MotionMode::Synchronised | MotionMode::Threading | MotionMode::Search(_) => {
            return Err(Problem::NoMotionCode.refused(words.column()));
        }
    };
    let stands = matches!(shape, Shape::Line { .. }) && target == program.position;
    let rate = if mode == MotionMode::Rapid { program.modal.seek_rate } else { program.modal.feed_rate };
    if !stands && rate.0 == 0.0 {
        let column = if words.has('F') { words.column_of('F') } else { words.column() };
        let halts = context.dialect == Dialect::Smoothie;
        return Err(Fault { halts, ..Problem::NoFeedRate.refused(column) });
    }
    let mut slowest = None;
    if let (Some(e), Some(tool)) = (e, program.tools.active_mut()) {
        let fed = e - tool.e;
        tool.e = e;
        slowest = tool.settings.flow_limit.filter(|_| mode == MotionMode::Linear).map(|most| (most, fed));
    }
    if stands {
        return NOTHING;
    }
    if let Some(list) = words.text() {
        return pixels(program, words, list, &target);
    }
    if let Some((most, fed)) = slowest {
        return Ok(Meaning::Action(draw_within_flow(program, target, shape, words.has('Z'), (most, fed))));
    }
    Ok(Meaning::Action(program.draw(target, shape, words.has('Z'))))
}

/// Draws a line in pixels, whose powers follow that of S (`S0.8:0:0.5`).
#[cold]
fn pixels<'b>(
    program: &mut Interpreter,
    words: &Words<'_>,
    list: &str,
    target: &PerAxis<f64>,
) -> Result<Meaning<'b>, Fault> {
    let modal = &program.modal;
    let is_feed = modal.motion == MotionMode::Linear && modal.feed_mode == FeedMode::PerMinute;
    let pixels = Pixels::new(modal.power, list, &program.position, target);
    let pixels = pixels.filter(|_| is_feed && program.setup.laser.is_some());
    program.pixels = pixels.ok_or(Problem::Pixels.refused(words.column_of('S')))?;
    let first = program.next_pixel();
    Ok(first.map_or(Meaning::Nothing, Meaning::Action))
}

/// Returns a move that feeds this volume of filament, mm3, with the rate limited so that the flow stays
/// within a limit, mm3/s. E in mm has no known volume.
fn draw_within_flow<'b>(
    program: &mut Interpreter,
    target: PerAxis<f64>,
    shape: Shape,
    names_z: bool,
    (most, fed): (f64, f64),
) -> Action<'b> {
    let is_volume = program.tools.active().is_some_and(|tool| tool.settings.filament_diameter.is_some());
    let way = |axis: Axis| target[axis] - program.position[axis];
    let length = libm::sqrt(Axis::PRIMARY.into_iter().map(|axis| way(axis) * way(axis)).sum());
    let own = program.modal.feed_rate;
    let fastest = if is_volume && fed > 0.0 && length > 0.0 { most * length / fed } else { f64::INFINITY };
    let mut action = program.draw(target, shape, names_z);
    if let Action::Move(request) = &mut action {
        request.rate = Rate::Feed(MmPerSecond(own.0.min(fastest)));
    }
    action
}

/// Reads the S word, power or speed.
#[inline]
fn take_power(program: &mut Interpreter, words: &Words<'_>) -> Result<(), Fault> {
    let Some(power) = words.number('S') else { return Ok(()) };
    if power < 0.0 {
        return Err(Problem::NegativeSpeed.refused(words.column_of('S')));
    }
    spindle::set_speed(program, power as f32);
    Ok(())
}

/// Refuses S1 to S4 of RepRapFirmware's moves, which stop at a switch as H1 to H4 do instead of setting a
/// power. S on its own is the spindle's, as everywhere.
fn is_no_search(context: &Context<'_>) -> Result<(), Fault> {
    let words = &context.words;
    let is_search = context.dialect == Dialect::RepRapFirmware
        && matches!(words.number('S'), Some(1.0 | 2.0 | 3.0 | 4.0))
        && "XYZUVWABC".chars().any(|letter| words.has(letter));
    if is_search {
        return Err(Problem::NotTaken(words.code(), 'S').refused(words.column_of('S')));
    }
    Ok(())
}

/// Reads the F and S words.
#[inline]
pub(crate) fn take_rates(program: &mut Interpreter, context: &Context<'_>) -> Result<(), Fault> {
    is_no_search(context)?;
    take_power(program, &context.words)?;
    if context.words.has('F') { take_feed(program, context) } else { Ok(()) }
}

fn take_feed(program: &mut Interpreter, context: &Context<'_>) -> Result<(), Fault> {
    let words = &context.words;
    let Some(rate) = words.feed('F') else { return Ok(()) };
    if rate <= 0.0 && context.dialect.is_other_printers() {
        // Marlin and RepRapFirmware keep the rate in force.
        let is_refused = context.dialect == Dialect::Klipper;
        let fault = Problem::MustExceed(words.code(), 'F', 0.0).refused(words.column_of('F'));
        return if is_refused { Err(fault) } else { Ok(()) };
    }
    if rate < 0.0 {
        return Err(Problem::NegativeFeedRate.alarm(words.column_of('F')));
    }
    let is_seek = program.modal.motion == MotionMode::Rapid && context.dialect.seeks_by_f();
    let has_one_rate = context.dialect.is_other_printers();
    let sets_seek = (is_seek || has_one_rate) && !program.compliant_seek_rate;
    if sets_seek {
        program.modal.seek_rate = MmPerSecond(rate);
    }
    if has_one_rate || !sets_seek {
        program.modal.feed_rate = MmPerSecond(rate);
    }
    Ok(())
}

/// Returns the end of a motion block as a machine position, and E at the end.
#[inline(always)]
pub(crate) fn target_of(program: &Interpreter, context: &Context<'_>) -> Result<(PerAxis<f64>, Option<f64>), Fault> {
    let words = &context.words;
    let mut target = program.position;
    // One by one, as letters known beforehand are found without a search.
    let xyz = [words.coordinate('X'), words.coordinate('Y'), words.coordinate('Z')];
    for (axis, word) in Axis::PRIMARY.into_iter().zip(xyz) {
        if let Some(mm) = word {
            target[axis] = program.modal.machine(axis, mm, program.position[axis]);
        }
    }
    if program.modal.rotations.any() {
        turned(program, words, &mut target);
    }
    if words.has_rare_coordinate() {
        rare_coordinates(program, words, &mut target)?;
    }
    let Some(word) = extruders::e_word(program, context) else { return Ok((target, None)) };
    let tool = program.tools.active().ok_or_else(|| Problem::NoExtruder.refused(words.column_of('E')))?;
    if tool.settings.is_off {
        return Err(Problem::PartIsOff(Part::Extruder(tool.settings.id)).refused(words.column_of('E')));
    }
    let to = if program.modal.e_absolute { word } else { tool.e + word };
    let mut fed = (to - tool.e) * tool.scale();
    // The width factor scales a volume laid along a path; retraction and recovery in place are lengths.
    if tool.width_factor != 1.0
        && fed > 0.0
        && Axis::PRIMARY.into_iter().any(|axis| target[axis] != program.position[axis])
    {
        fed *= tool.width_factor;
    }
    target[tool.settings.axis] += fed;
    Ok((target, Some(to)))
}

/// Applies a rotated coordinate system to X and Y: a single word moves both axes.
#[cold]
pub(crate) fn turned(program: &Interpreter, words: &Words<'_>, target: &mut PerAxis<f64>) {
    let now = [program.position[Axis::X], program.position[Axis::Y]];
    let xy = [Axis::X, Axis::Y].map(|axis| words.axis(axis));
    if xy != [None; 2] {
        [target[Axis::X], target[Axis::Y]] = program.modal.target_xy(xy, now);
    }
}

/// Reads A, B, C and polar coordinates.
#[cold]
fn rare_coordinates(program: &Interpreter, words: &Words<'_>, target: &mut PerAxis<f64>) -> Result<(), Fault> {
    for axis in [Axis::A, Axis::B, Axis::C] {
        let Some(word) = words.number(axis.letter()) else { continue };
        if program.tools.uses(axis) {
            return Err(Problem::ExtruderAxis(axis).refused(words.column_of(axis.letter())));
        }
        target[axis] = if program.modal.absolute { word } else { target[axis] + word };
    }
    if words.has('@') || words.has('^') { polar(program, words, target) } else { Ok(()) }
}

/// Reads `@` and `^`, distance and angle from the origin of X and Y. An omitted word keeps its value; after
/// G91 both add (LinuxCNC, "Polar Coordinates").
pub(crate) fn polar(program: &Interpreter, words: &Words<'_>, target: &mut PerAxis<f64>) -> Result<(), Fault> {
    let modal = &program.modal;
    if let Some(letter) = ['X', 'Y'].into_iter().find(|letter| words.has(*letter)) {
        return Err(Problem::PolarAndCartesian.refused(words.column_of(letter)));
    }
    let here = if modal.machine_next { program.position } else { modal.work(&program.position) };
    let (x, y) = (here[Axis::X], here[Axis::Y]);
    let (distance, angle) = (words.length('@'), words.number('^').map(f64::to_radians));
    let is_relative = !modal.absolute && !modal.machine_next;
    let (now, direction) = (libm::hypot(x, y), libm::atan2(y, x));
    // At the origin the current direction is undefined.
    if now == 0.0 && (is_relative || angle.is_none()) {
        return Err(Problem::PolarAtOrigin.refused(words.column()));
    }
    let of = |word: Option<f64>, now: f64| word.map_or(now, |word| if is_relative { now + word } else { word });
    let (distance, angle) = (of(distance, now), of(angle, direction));
    let place = [distance * libm::cos(angle), distance * libm::sin(angle)];
    [target[Axis::X], target[Axis::Y]] = if modal.machine_next { place } else { modal.machine_xy(place) };
    Ok(())
}

/// G4: dwells for P in the dialect's unit, or S in seconds.
pub(crate) fn dwell<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let time = time_of(context, context.dialect.dwell_unit())?;
    Ok(Meaning::Action(Action::Dwell(time)))
}

/// Returns the time given by P, in units of so many seconds, plus S. Other printer firmwares take S alone
/// when both are given.
pub(crate) fn time_of(context: &Context<'_>, unit: f64) -> Result<Micros, Fault> {
    let words = &context.words;
    let (p, s) = (words.get('P').map(|p| p * unit), words.get('S'));
    let replaces = context.dialect.is_other_printers() && s.is_some();
    let seconds = p.filter(|_| !replaces).unwrap_or(0.0) + s.unwrap_or(0.0);
    if !(0.0..=LONGEST_DWELL).contains(&seconds) {
        return Err(Problem::DwellRange.refused(words.column()));
    }
    Ok(Micros((seconds * 1e6) as u64))
}

/// G53: puts the next motion code in machine coordinates; words on the line move at once, by the motion code
/// in force.
pub(crate) fn machine_coordinates<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.machine_next = true;
    if context.words.is_bare() {
        return NOTHING;
    }
    motion_block(program, context)
}
