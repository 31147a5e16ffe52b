//! Canned cycles: from words to holes. As in RS-274/NGC (NIST, section 3.5.16), with LinuxCNC's choice where
//! the standard leaves one: the initial height is that before the first hole of a series.

use gcode::Code;
use units::{Axis, Micros, PerAxis};

use crate::action::{Corner, Rate};
use crate::context::{Context, Meaning, NOTHING};
use crate::cycles::Series;
use crate::cycles::holes::{Holes, Plan, Rates, Turn};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::moves;
use crate::state::auxiliary::Spindle;
use crate::state::cycle::{Cycle, Retract, drilling_axis};
use crate::state::modal::{FeedMode, MotionMode};
use crate::words::Words;

/// Limit of pecks; more indicate a mistake in Q.
const MOST_PECKS: f64 = 10_000.0;
/// Limit of holes about a centre; more indicate a mistake.
const MOST_ABOUT: f64 = 360.0;
/// Share of a peck that counts as rounding, so that a Q that divides the depth adds no peck.
const SHARE_OF_PECK: f64 = 1e-6;

/// Drills by G73, G74, G81 to G86, G88, G89, or words without a code behind one of them.
pub(crate) fn cycle<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    match Cycle::from_g(context.words.code().number) {
        Some(cycle) => drill(program, context, cycle),
        None => Ok(Meaning::Unknown),
    }
}

/// Sets the retract mode (G98, G99); words behind the code are those of the motion code in force.
pub(crate) fn retract_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.retract = if context.words.code().number == 98 { Retract::Initial } else { Retract::RPlane };
    by_motion_code(program, context)
}

/// Reads words behind a modal code as those of the motion code in force.
pub(crate) fn by_motion_code<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    match program.modal.motion {
        _ if context.words.is_bare() => NOTHING,
        MotionMode::Cycle => drill(program, context, program.modal.cycle),
        _ => moves::motion_block(program, context),
    }
}

/// Cancels cycles by G80, and reads words behind it. In Smoothieware's dialect a series of G99 ends with a
/// lift.
pub(crate) fn cancel<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let is_series = program.modal.motion == MotionMode::Cycle;
    let Series { initial, plane, .. } = *program.cycles.series();
    program.end_cycles();
    program.modal.motion = MotionMode::Cancelled;
    moves::take_rates(program, context)?;
    if let Some(letter) = "XYZABCE".chars().find(|letter| words.has(*letter)) {
        return Err(Problem::NoMotionCode.refused(words.column_of(letter)));
    }
    let mut up = program.position;
    up[drilling_axis(plane)] = initial;
    let returns = context.dialect.returns_at_g80() && program.modal.retract == Retract::RPlane;
    if is_series && returns && initial > program.position[drilling_axis(plane)] {
        return Ok(Meaning::Action(program.rapid_to(up)));
    }
    NOTHING
}

/// Refuses G87, and G70 to G72, for which the machine lacks something.
pub(crate) fn missing<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    // Words on the next lines belong to the refused cycle, so no earlier cycle may read them.
    program.end_cycles();
    program.modal.motion = MotionMode::Cancelled;
    let code = context.words.code();
    let what = if code.number == 87 { "an oriented spindle stop" } else { "a contour that is read ahead" };
    Err(Problem::Needs(code, what).refused(context.words.column()))
}

/// Drills a block of a cycle.
fn drill<'b>(program: &mut Interpreter, context: &Context<'b>, cycle: Cycle) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let by_words = context.dialect.drills_by_words() && matches!(cycle.g(), 81..=83);
    enter(program, cycle, by_words);
    may_drill(program, words)?;
    may_turn(program, words, cycle)?;
    moves::take_rates(program, context)?;
    if !"XYZ@^".chars().any(|letter| words.has(letter)) {
        // A cycle code without a position only sets the words for later lines.
        let word = "RQPL".chars().find(|letter| words.has(*letter));
        return word.map_or(NOTHING, |letter| Err(Problem::CycleNowhere(cycle.g()).refused(words.column_of(letter))));
    }
    if program.modal.feed_rate.get() <= 0.0 {
        return Err(Problem::NoFeedRate.refused(words.column_of('F')));
    }
    let series = series(program, words, cycle, by_words)?;
    let plan = plan(program, words, cycle, &series)?;
    let first = program.cycles.begin(series, Holes::new(plan, program.position));
    let Some(first) = first else { return NOTHING };
    program.tools.moved(true);
    program.follow(&first);
    Ok(Meaning::Action(first))
}

/// Puts a cycle in force. The words that hold are cleared behind a code that was no cycle and in another
/// plane; Q and P with each new code.
fn enter(program: &mut Interpreter, cycle: Cycle, by_words: bool) {
    let plane = program.modal.plane;
    let series = *program.cycles.series();
    match program.modal.motion {
        MotionMode::Cycle if series.plane == plane => {
            if program.modal.cycle != cycle && !by_words {
                program.cycles.set_series(Series { peck: None, dwell: None, ..series });
            }
        }
        _ => {
            let initial = program.position[drilling_axis(plane)];
            program.cycles.set_series(Series { plane, initial, ..Series::default() });
        }
    }
    (program.modal.motion, program.modal.cycle) = (MotionMode::Cycle, cycle);
}

/// Checks that the current modes permit drilling.
fn may_drill(program: &mut Interpreter, words: &Words<'_>) -> Result<(), Fault> {
    let in_machine_coordinates = core::mem::take(&mut program.modal.machine_next);
    if program.setup.cycles.is_off {
        return Err(Problem::CyclesOff.refused(words.column()));
    }
    if in_machine_coordinates {
        return Err(Problem::CycleInMachineCoordinates.refused(words.column()));
    }
    if program.modal.feed_mode != FeedMode::PerMinute {
        return Err(Problem::NeedsFeedPerMinute.refused(words.column()));
    }
    if let Some(letter) = "ABCE".chars().find(|letter| words.has(*letter)) {
        return Err(Problem::NotInCycle(letter).refused(words.column_of(letter)));
    }
    Ok(())
}

/// Checks that the spindle turns as the cycle needs, and that outputs listen to the spindle codes involved.
fn may_turn(program: &Interpreter, words: &Words<'_>, cycle: Cycle) -> Result<(), Fault> {
    if !(cycle.taps() || cycle.stops_spindle()) {
        return Ok(());
    }
    let turns = program.modal.auxiliary.spindle;
    let refused = |problem: Problem| Err(problem.refused(words.column()));
    match cycle.turning() {
        Some(wanted) if turns != wanted => return refused(Problem::SpindleTurns(cycle.g(), wanted.code())),
        None if turns == Spindle::Stopped => return refused(Problem::SpindleStands),
        _ => {}
    }
    let other = cycle.taps().then_some(turns.reversed());
    let needed = [Some(Spindle::Stopped), Some(turns), other];
    let is_deaf = |spindle: &Spindle| program.setup.claims.of(Code::m(spindle.code())).next().is_none();
    match needed.into_iter().flatten().find(is_deaf) {
        Some(spindle) => refused(Problem::NothingListens(cycle.g(), spindle.code())),
        None => Ok(()),
    }
}

/// Returns the series with this block's words added.
fn series(program: &Interpreter, words: &Words<'_>, cycle: Cycle, by_words: bool) -> Result<Series, Fault> {
    let mut series = *program.cycles.series();
    let along = drilling_axis(series.plane).letter();
    for (letter, takes) in [('Q', cycle.pecks()), ('P', cycle.may_dwell())] {
        if words.has(letter) && !(takes || by_words) {
            return Err(Problem::NotOfCycle(cycle.g(), letter).refused(words.column_of(letter)));
        }
    }
    series.depth = words.get(along).or(series.depth);
    series.retract = words.get('R').or(series.retract);
    series.peck = words.get('Q').or(series.peck);
    if let Some(time) = words.get('P') {
        series.dwell = Some(dwell(program, time).ok_or(Problem::DwellRange.refused(words.column_of('P')))?);
    }
    let needed = [
        (along, series.depth.is_some()),
        ('R', series.retract.is_some()),
        ('Q', series.peck.is_some() || !cycle.pecks()),
        ('P', series.dwell.is_some() || !cycle.dwells()),
    ];
    match needed.into_iter().find(|(_, is_there)| !is_there) {
        Some((letter, _)) => Err(Problem::CycleNeeds(cycle.g(), letter).refused(words.column())),
        None => Ok(series),
    }
}

fn dwell(program: &Interpreter, time: f64) -> Option<Micros> {
    let seconds = if program.setup.cycles.dwell_in_ms { time * 1e-3 } else { time };
    (0.0..=moves::LONGEST_DWELL).contains(&seconds).then_some(Micros((seconds * 1e6) as u64))
}

/// Plans the holes of this block, in machine positions.
fn plan(program: &Interpreter, words: &Words<'_>, cycle: Cycle, series: &Series) -> Result<Plan, Fault> {
    let (modal, here) = (&program.modal, &program.position);
    let along = drilling_axis(series.plane);
    // After G91, R counts from the beginning of the series, as in LinuxCNC, so that repeated lines drill
    // equally deep.
    let retract = modal.machine(along, series.retract.unwrap_or_default(), series.initial);
    let bottom = modal.machine(along, series.depth.unwrap_or_default(), retract);
    if retract < bottom {
        return Err(Problem::RetractBelow(along).refused(words.column_of(if words.has('R') {
            'R'
        } else {
            along.letter()
        })));
    }
    let is_above = modal.retract == Retract::Initial && series.initial > retract;
    let (mut first, mut step) = (*here, PerAxis([0.0; units::MAX_AXES]));
    for axis in Axis::PRIMARY.into_iter().filter(|axis| *axis != along) {
        let Some(mm) = words.get(axis.letter()) else { continue };
        first[axis] = modal.machine(axis, mm, here[axis]);
        step[axis] = if modal.absolute { 0.0 } else { mm };
    }
    if modal.turn().is_some() {
        if along != Axis::Z {
            return Err(Problem::TurnedPlane.refused(words.column()));
        }
        moves::turned(program, words, &mut first);
        [step[Axis::X], step[Axis::Y]] = modal.way_xy([step[Axis::X], step[Axis::Y]]);
    }
    let mut turn = None;
    if words.has_rare_coordinate() {
        moves::polar(program, words, &mut first)?;
        turn = about(program, words, &first)?;
    }
    let plan = Plan {
        // A cycle that drills by its words pecks when Q is given.
        cycle: if cycle == Cycle::BreakChips || series.peck.is_none() { cycle } else { Cycle::Peck },
        along,
        first,
        step,
        turn,
        count: words.get('L').map_or(1, |count| count as u32),
        retract,
        bottom,
        clear: if is_above { series.initial } else { retract },
        peck: series.peck.unwrap_or_default(),
        pecks: pecks(retract - bottom, series.peck).ok_or(Problem::TooManyPecks.refused(words.column_of('Q')))?,
        dwell: series.dwell,
        rates: Rates {
            rapid: Rate::Rapid(modal.seek_rate),
            feed: Rate::Feed(modal.feed_rate),
            power: if program.setup.laser.is_some() { 0.0 } else { modal.power },
            // Cycles follow their path exactly.
            corner: if modal.corner == Corner::Stop { Corner::Stop } else { Corner::Sharp },
        },
        auxiliary: modal.auxiliary,
    };
    if plan.is_finite() { Ok(plan) } else { Err(Problem::NoPlace.refused(words.column())) }
}

/// Returns the polar step after G91: distance and angle add from hole to hole.
fn about(program: &Interpreter, words: &Words<'_>, first: &PerAxis<f64>) -> Result<Option<Turn>, Fault> {
    let modal = &program.modal;
    let count = words.get('L').unwrap_or(1.0);
    if modal.absolute || count <= 1.0 {
        return Ok(None);
    }
    if count > MOST_ABOUT {
        return Err(Problem::TooMuch(words.code(), 'L', MOST_ABOUT).refused(words.column_of('L')));
    }
    let centre = modal.machine_xy([0.0; 2]);
    let (x, y) = (first[Axis::X] - centre[0], first[Axis::Y] - centre[1]);
    let step = [words.length('@').unwrap_or(0.0), words.as_written('^').unwrap_or(0.0).to_radians()];
    Ok(Some(Turn { centre, first: [libm::hypot(x, y), libm::atan2(y, x)], step }))
}

/// Returns the number of pecks for a depth, both in mm.
fn pecks(depth: f64, peck: Option<f64>) -> Option<u32> {
    let Some(peck) = peck else { return Some(1) };
    let count = libm::ceil(depth / peck - SHARE_OF_PECK);
    if count > MOST_PECKS || count.is_nan() { None } else { Some(if count > 1.0 { count as u32 } else { 1 }) }
}

#[cfg(test)]
mod tests;
