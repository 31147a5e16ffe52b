//! G28 and its subcodes: homing, and the park position.

use units::{Axis, AxisSet, PerAxis};

use crate::action::Action;
use crate::context::{Context, Meaning};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::moves;
use crate::meaning::probing;
use crate::state::park::ParkPosition;
use gcode::Dialect;

/// Homes or parks (G28, G28.2); the dialect says which of the two codes homes.
pub(crate) fn home_or_park<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if context.dialect.parks(words.code().subcode) {
        let place = program.park;
        return go_to_park(program, context, place);
    }
    if let Some(letter) = words.other_than(context.dialect.homing_words()) {
        return Err(Problem::NotHomable(letter).refused(words.column_of(letter)));
    }
    Ok(Meaning::Action(Action::Home(words.axes())))
}

/// G30: probes the bed, or parks at the second position if so configured; with P the code always probes.
pub(crate) fn probe_or_park<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    if program.setup.g30_parks && context.dialect == Dialect::Grbl && !context.words.has('P') {
        let Some(place) = program.second_park else { return Err(Problem::NoSecondPark.refused(0)) };
        return go_to_park(program, context, place);
    }
    probing::probe_down(program, context)
}

/// G28.1 and G30.1: stores the machine's position, or the position given by X and Y (and Z).
pub(crate) fn store_park<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let (words, homes_z) = (&context.words, context.facts.can_home.has(Axis::Z));
    if words.is_bare() {
        if !context.facts.all_homed() {
            return Err(Problem::NotHomed.refused(0));
        }
        let z = homes_z.then_some(program.position[Axis::Z]);
        let here = ParkPosition { x: program.position[Axis::X], y: program.position[Axis::Y], z };
        program.store_park(words.code().number, here);
        keep_park(program);
        return Ok(Meaning::Action(Action::Note("position saved, use M500 to make permanent")));
    }
    let x = words.axis(Axis::X).ok_or(Problem::MustSupply('X').refused(0))?;
    let y = words.axis(Axis::Y).ok_or(Problem::MustSupply('Y').refused(0))?;
    // Without a Z word the stored Z stays: moving the place aside must not lower the parking height.
    let z = words.axis(Axis::Z).or(program.parked_z(words.code().number)).filter(|_| homes_z);
    program.store_park(words.code().number, ParkPosition { x, y, z });
    keep_park(program);
    if words.has('Z') && z.is_none() {
        return Ok(Meaning::Action(Action::Note("warning:cannot save Z as the z axis cannot be homed")));
    }
    Ok(program.next_action().map_or(Meaning::Nothing, Meaning::Action))
}

/// Queues writing the park position to the card, if parameters keep offsets there.
fn keep_park(program: &mut Interpreter) {
    crate::parameters::offsets_changed(program);
    if program.setup.keeps_offsets {
        program.then(Action::Keep);
    }
}

/// Moves to the park position: first by the words, which are distances, except in GRBL's dialect, where G90
/// and G91 apply; then Z, then X and Y. With words only the named axes take part.
fn go_to_park<'b>(program: &mut Interpreter, context: &Context<'b>, place: ParkPosition) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if let Some(letter) = words.other_than("XYZ") {
        return Err(Problem::NotParkable(letter).refused(words.column_of(letter)));
    }
    if !context.facts.all_homed() {
        return Err(Problem::ParkUnknown.refused(0));
    }
    let mut by = program.position;
    for axis in Axis::PRIMARY {
        let Some(mm) = words.axis(axis) else { continue };
        let there = program.modal.machine(axis, mm, program.position[axis]);
        by[axis] = if context.dialect.parks_by_a_place() { there } else { by[axis] + mm };
    }
    if context.dialect.parks_by_a_place() && program.modal.rotations.any() {
        moves::turned(program, words, &mut by);
    }
    let bare = words.is_bare();
    if place.z.is_none() && words.has('Z') {
        // A rapid move follows, and without the retraction it could collide.
        return Err(Problem::NoParkZ(words.code().number).refused(words.column_of('Z')));
    }
    let parked = |mut target: PerAxis<f64>, axes: &[Axis]| {
        for axis in axes.iter().filter(|axis| bare || words.has(axis.letter())) {
            target[*axis] = place.of(*axis).unwrap_or(target[*axis]);
        }
        target
    };
    let lifted = parked(by, &[Axis::Z]);
    for target in [by, lifted, parked(lifted, &[Axis::X, Axis::Y])] {
        if target != program.position {
            let rapid = program.rapid_to(target);
            program.then(rapid);
        }
    }
    Ok(program.next_action().map_or(Meaning::Nothing, Meaning::Action))
}

/// G28.5: forgets that axes are homed.
pub(crate) fn forget_homing<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let axes = if words.is_bare() { AxisSet::ALL } else { words.axes() };
    Ok(Meaning::Action(Action::ForgetHoming(axes)))
}
