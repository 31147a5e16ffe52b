//! Codes that change how coordinates are read: planes, units, coordinate systems, G92, tool offsets.

use units::{Axis, PerAxis, Plane};

use crate::action::{Action, Corner};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::kept_modes::come_back_to_modes;
use crate::meaning::{extruders, tool_table};
use crate::parameters;
use crate::state::modal::COORDINATE_SYSTEMS;
use gcode::{Dialect, ExtruderFollows};

/// G17, G18, G19: selects the plane.
pub(crate) fn plane<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.plane = match context.words.code().number {
        17 => Plane::Xy,
        18 => Plane::Xz,
        _ => Plane::Yz,
    };
    NOTHING
}

/// G20, G21: selects inches or millimetres.
pub(crate) fn length_unit<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.inches = context.words.code().number == 20;
    NOTHING
}

/// G7, G8: selects diameters or radii for X.
pub(crate) fn diameter_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.diameters = context.words.code().number == 7;
    NOTHING
}

/// G90, G91: selects absolute or relative coordinates.
pub(crate) fn distance_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let modal = &mut program.modal;
    modal.absolute = context.words.code().number == 90;
    modal.e_absolute = match context.dialect.extruder_follows() {
        ExtruderFollows::Nothing => modal.e_absolute,
        ExtruderFollows::TheLast => modal.absolute,
        ExtruderFollows::Both => modal.absolute && modal.e_places,
    };
    NOTHING
}

/// G90.1, G91.1: selects absolute or relative arc centres.
pub(crate) fn arc_distance_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.arc_absolute = context.words.code().number == 90;
    NOTHING
}

/// G17.1 to G19.1, G41 and G42: refuses the code, naming the missing feature.
pub(crate) fn missing<'b>(_: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    let what = if code.number < 20 { "axes U, V and W" } else { "cutter compensation" };
    Err(Problem::Needs(code, what).refused(context.words.column()))
}

/// M82, M83: selects absolute or relative E.
pub(crate) fn extruder_distance_mode<'b>(
    program: &mut Interpreter,
    context: &Context<'b>,
) -> Result<Meaning<'b>, Fault> {
    let modal = &mut program.modal;
    modal.e_places = context.words.code().number == 82;
    let is_both = context.dialect.extruder_follows() == ExtruderFollows::Both;
    modal.e_absolute = modal.e_places && (modal.absolute || !is_both);
    NOTHING
}

/// G54 to G59.3: selects the coordinate system.
pub(crate) fn coordinate_system<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let code = context.words.code();
    program.modal.system = usize::from(code.number.saturating_sub(54)) + usize::from(code.subcode);
    NOTHING
}

/// G61, G61.1, G64: sets the corner mode; P is the tolerance of rounding.
pub(crate) fn path_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let code = words.code();
    program.modal.corner = match (code.number, code.subcode) {
        (61, 0) => Corner::Sharp,
        (61, _) => Corner::Stop,
        _ => {
            let tolerance = words.get('P');
            if tolerance.is_some_and(|mm| !(mm.is_finite() && mm >= 0.0)) {
                return Err(Problem::CornerTolerance.refused(words.column_of('P')));
            }
            Corner::Rounded(tolerance)
        }
    };
    if (code.number, words.has('Q')) == (64, true) {
        return Ok(Meaning::Action(Action::Note("// NOTE: Q is not needed, short lines are kept")));
    }
    NOTHING
}

/// G10 L0, L1, L2, L10, L11 and L20: sets offsets; G10 without L retracts filament.
pub(crate) fn set_offsets<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let here = match words.get('L') {
        None if !words.has('L') => {
            // G10 with words of RepRapFirmware's tools is no retraction.
            let other = words.other_than("S");
            return match other {
                Some(letter) => Err(Problem::NotTaken(words.code(), letter).refused(words.column_of(letter))),
                None => extruders::retract(program),
            };
        }
        Some(1.0) if program.tools.has_extruders() => return extruders::set_tool_offset(program, words),
        Some(0.0) => return tool_table::reload(program, words),
        Some(1.0 | 10.0 | 11.0) => return tool_table::set_tool(program, words),
        Some(2.0) => false,
        Some(20.0) => true,
        _ => return Err(Problem::OffsetKind.refused(words.column_of('L'))),
    };
    let in_force = program.modal.system;
    let system = match words.get('P') {
        Some(0.0) => in_force,
        Some(p) if p >= 1.0 && p <= COORDINATE_SYSTEMS as f64 => p as usize - 1,
        None if context.dialect.is_other_printers() => in_force,
        // A default for P would silently move the wrong coordinate system.
        None => return Err(Problem::MustSupply('P').refused(words.column())),
        Some(_) => return Err(Problem::CoordinateSystem.refused(words.column_of('P'))),
    };
    let replaces = program.modal.absolute || context.dialect.replaces_offsets();
    if let Some(degrees) = words.as_written('R') {
        if here {
            return Err(Problem::RotationHere.refused(words.column_of('R')));
        }
        program.modal.rotations.set(system, degrees);
    }
    if here {
        program.modal.set_system_here(system, Axis::PRIMARY.map(|axis| words.axis(axis)), &program.position);
    }
    for axis in Axis::PRIMARY.into_iter().filter(|_| !here) {
        let Some(mm) = words.axis(axis) else { continue };
        if let Some(offset) = program.modal.systems.get_mut(system).and_then(|all| all.get_mut(axis as usize)) {
            *offset = if replaces { mm } else { *offset + mm };
        }
    }
    parameters::offsets_changed(program);
    if program.setup.keeps_offsets { Ok(Meaning::Action(Action::Keep)) } else { NOTHING }
}

/// G92: makes the position read as given; without words, and G92.1, G92.2: as the coordinate system says.
pub(crate) fn g92<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let subcode = words.code().subcode;
    if subcode == 0 && !words.is_bare() {
        return set_work_position(program, context);
    }
    match context.dialect {
        Dialect::Marlin | Dialect::RepRapFirmware if subcode == 0 => return NOTHING,
        Dialect::Klipper if subcode == 0 => return zero_here(program),
        _ => {}
    }
    let is_set = program.modal.g92 != [0.0; 3];
    if subcode != 2 || is_set {
        program.modal.g92_kept = if subcode == 2 { program.modal.g92 } else { [0.0; 3] };
    }
    program.modal.g92 = [0.0; 3];
    program.modal.g92_is_on = false;
    if let Some(tool) = program.tools.active_mut().filter(|_| subcode == 0) {
        tool.e = 0.0;
    }
    NOTHING
}

fn set_work_position<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if let Some(e) = extruders::e_word(program, context) {
        let tool = program.tools.active_mut().ok_or(Problem::NoExtruder.refused(words.column_of('E')))?;
        tool.e = e;
    }
    program.modal.g92_kept = [0.0; 3];
    program.modal.g92_is_on = true;
    for axis in Axis::PRIMARY {
        if let Some(mm) = words.axis(axis) {
            program.modal.set_g92(axis, mm, &program.position);
        }
    }
    let auxiliary = PerAxis(Axis::ALL.map(|axis| words.axis(axis).filter(|_| !axis.is_primary())));
    if auxiliary.0.iter().any(Option::is_some) {
        return Ok(Meaning::Action(Action::SetPosition { to: auxiliary, homed: false }));
    }
    NOTHING
}

/// Makes all axes read 0, as Klipper's G92 without words does.
fn zero_here<'b>(program: &mut Interpreter) -> Result<Meaning<'b>, Fault> {
    program.modal.g92_kept = [0.0; 3];
    program.modal.g92_is_on = true;
    Axis::PRIMARY.into_iter().for_each(|axis| program.modal.set_g92(axis, 0.0, &program.position));
    if let Some(tool) = program.tools.active_mut() {
        tool.e = 0.0;
    }
    NOTHING
}

/// G52: puts the origin at this position of every coordinate system. G52 and G92 share an offset, as in
/// LinuxCNC, so each replaces the other.
pub(crate) fn local_origin<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    for (axis, offset) in Axis::PRIMARY.into_iter().zip(&mut program.modal.g92) {
        // G92's offset is subtracted, so the sign of the position is reversed.
        *offset = context.words.axis(axis).map_or(*offset, |mm| -mm);
    }
    NOTHING
}

/// G92.3: sets the offset itself, mm, zero for axes that are not named; without words, restores the offset
/// suspended by G92.2, if any.
pub(crate) fn g92_offset<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let modal = &mut program.modal;
    modal.g92_is_on = true;
    if !context.words.is_bare() {
        modal.g92 = Axis::PRIMARY.map(|axis| context.words.axis(axis).unwrap_or(0.0));
    } else if modal.g92_kept != [0.0; 3] {
        modal.g92 = modal.g92_kept;
    }
    NOTHING
}

/// G92.4 and G28.3: declares the machine's position. G28.3 counts as homing, and without words sets all axes
/// to zero; with P the tool stands at the probe's contact. G92.4 without words is G92.1.
pub(crate) fn declare_position<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let homed = words.code().number == 28;
    if !homed && words.is_bare() {
        return g92(program, context);
    }
    let named = if homed && words.is_bare() { units::AxisSet::ALL } else { words.axes() };
    let mut to = PerAxis(Axis::ALL.map(|axis| {
        let place = words.axis(axis).or(homed.then_some(0.0));
        place.filter(|_| named.has(axis))
    }));
    if homed && words.has('P') {
        to[Axis::Z] = Some(context.facts.probe_height);
    }
    Ok(Meaning::Action(Action::SetPosition { to, homed }))
}

/// M120 saves units, distance modes, rates and the coordinate system; M121 restores them.
pub(crate) fn save_or_restore<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let column = context.words.column();
    if context.words.code().number == 120 {
        let saved = program.modal.save();
        program.saved.push(saved).map_err(|_| Problem::SavedTooOften.refused(column))?;
    } else {
        let saved = program.saved.pop().ok_or(Problem::NothingSaved.refused(column))?;
        come_back_to_modes(program, &saved);
    }
    NOTHING
}
