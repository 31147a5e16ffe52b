//! Reading and writing of parameters: the program's memory, and the interpreter's state (NIST RS-274/NGC,
//! table 2; LinuxCNC's G-code overview, "Numbered parameters" and "Predefined named parameters").

use gcode::{Parameter, Parameters, Problem};
use units::{Axis, PerAxis};

use crate::interpreter::Interpreter;
use crate::named_parameters::predefined;
use crate::state::modal::Modal;

/// Distance between the parameters of two coordinate systems.
const SYSTEM_STRIDE: u16 = 20;
/// Number of X of G54, `#5221`.
const FIRST_SYSTEM: u16 = 5_221;
/// Distance from X of a system to its rotation.
const ROTATION: u16 = 9;

/// Parameter that is a field of the program's state, and can be written.
enum Field {
    Value(f64),
    /// Number of the coordinate system in force, 1 for G54.
    System,
}

/// Returns the index 0 to 2 of a number among the three for X Y Z.
fn of_axis(first: u16, number: u16) -> Option<usize> {
    number.checked_sub(first).filter(|axis| *axis < 3).map(usize::from)
}

fn system_and_axis(number: u16) -> Option<(usize, usize)> {
    let from = number.checked_sub(FIRST_SYSTEM)?;
    let (system, axis) = (from / SYSTEM_STRIDE, from % SYSTEM_STRIDE);
    (axis < 3).then_some((usize::from(system), usize::from(axis)))
}

/// Returns the coordinate system whose rotation has this number: `#5230` is that of G54.
fn turned_system(number: u16) -> Option<usize> {
    let from = number.checked_sub(FIRST_SYSTEM + ROTATION)?;
    let system = usize::from(from / SYSTEM_STRIDE);
    (from % SYSTEM_STRIDE == 0 && system < crate::COORDINATE_SYSTEMS).then_some(system)
}

fn field(modal: &Modal, number: u16) -> Option<Field> {
    if number == 5_220 {
        return Some(Field::System);
    }
    // LinuxCNC and GRBL add this offset to a coordinate, but `g92` is subtracted.
    let g92 = of_axis(5_211, number).and_then(|axis| Some(0.0 - modal.g92.get(axis)?));
    let system = || {
        let (system, axis) = system_and_axis(number)?;
        modal.systems.get(system)?.get(axis).copied()
    };
    let rotation = || turned_system(number).map(|system| modal.rotations.of(system));
    g92.or_else(system).or_else(rotation).map(Field::Value)
}

/// Returns the axis in a table of nine axes, as far as the machine has it.
fn axis_at(first: u16, number: u16) -> Option<Axis> {
    Axis::ALL.get(usize::from(number.checked_sub(first)?)).copied()
}

impl Parameters for Interpreter {
    fn get(&self, parameter: &Parameter) -> Option<f64> {
        match parameter {
            Parameter::Numbered(number @ 1..=5_000) => self.memory.get(&Parameter::Numbered(*number)),
            Parameter::Numbered(number) => system(self, *number),
            Parameter::Named(name) => predefined(self, name).or_else(|| self.memory.get(parameter)),
        }
    }

    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), Problem> {
        let can_be_written = match &parameter {
            Parameter::Numbered(number @ 1..=5_000) => *number > 0,
            Parameter::Numbered(5_070 | 5_599) => true,
            Parameter::Numbered(5_220) => value >= 1.0 && value <= crate::COORDINATE_SYSTEMS as f64,
            Parameter::Numbered(number) => field(&self.modal, *number).is_some(),
            Parameter::Named(name) => predefined(self, name).is_none(),
        };
        if !can_be_written {
            return Err(Problem::ReadOnly);
        }
        self.memory.set_later(parameter, value)
    }
}

/// Carries out the assignments of a line that has been read.
///
/// # Errors
/// When there is no room for a parameter.
pub(crate) fn settle(program: &mut Interpreter) -> Result<(), Problem> {
    while let Some((parameter, value)) = program.memory.take_waiting() {
        match parameter {
            Parameter::Numbered(5_070) => program.last_probe.1 = value != 0.0,
            Parameter::Numbered(5_599) => program.debugs = value != 0.0,
            Parameter::Numbered(5_220) => program.modal.system = value as usize - 1,
            Parameter::Numbered(number) if number > 5_000 => {
                if let Some(place) = of_axis(5_211, number).and_then(|axis| program.modal.g92.get_mut(axis)) {
                    *place = 0.0 - value;
                } else {
                    set_offset(program, number, value);
                }
            }
            parameter => program.memory.set(&parameter, value)?,
        }
    }
    Ok(())
}

/// Sets the offset of a coordinate system; returns false when the number belongs to none.
fn set_offset(program: &mut Interpreter, number: u16, value: f64) -> bool {
    if let Some(system) = turned_system(number) {
        program.modal.rotations.set(system, value);
        offsets_changed(program);
        return true;
    }
    let place = system_and_axis(number)
        .and_then(|(system, axis)| program.modal.systems.get_mut(system).and_then(|offsets| offsets.get_mut(axis)));
    let Some(place) = place else { return false };
    *place = value;
    offsets_changed(program);
    true
}

/// Notes that a coordinate system or the park position has changed.
pub(crate) const fn offsets_changed(program: &mut Interpreter) {
    if program.setup.keeps_offsets {
        program.memory.changed();
    }
}

/// Number of the first parameter of G28's park position: X, Y, and Z if it takes part.
const PARK: u16 = 5_161;
/// Number of the first parameter of G30's park position.
const SECOND_PARK: u16 = 5_181;
/// Number of further persistent offsets: the park positions, and X Y Z and rotation of each system.
const KEPT_OFFSETS: usize = 6 + 4 * crate::COORDINATE_SYSTEMS;

/// Returns the persistent parameter at this index, counting only those that are not 0.
pub(crate) fn kept_at(program: &Interpreter, place: usize) -> Option<(u16, f64)> {
    let own = program.memory.at(place);
    if own.is_some() || !program.setup.keeps_offsets {
        return own;
    }
    let offset = |place: usize| match (place, place.checked_sub(6)) {
        (_, Some(place)) => {
            let of = [0, 1, 2, ROTATION][place % 4];
            FIRST_SYSTEM + SYSTEM_STRIDE * (place / 4) as u16 + of
        }
        (0..3, None) => PARK + place as u16,
        (_, None) => SECOND_PARK + place as u16 - 3,
    };
    let offsets = (0..KEPT_OFFSETS).filter_map(|place| {
        let number = offset(place);
        let value = match (of_axis(PARK, number), of_axis(SECOND_PARK, number)) {
            // A Z of 0 that takes part differs from no Z, and a park position of G30 at the origin from none.
            (Some(2), _) => program.park.z,
            (_, Some(2)) => program.second_park?.z,
            (_, Some(0)) => Some(program.second_park?.x),
            _ => system(program, number).filter(|mm| *mm != 0.0),
        };
        Some((number, value?))
    });
    let mut rest = offsets.skip(place - program.memory.kept());
    rest.next()
}

/// Restores a persistent parameter after a power cycle. Returns false for an unknown number, or without room.
pub(crate) fn restore(program: &mut Interpreter, number: u16, value: f64) -> bool {
    if number <= 5_000 {
        return program.memory.set(&Parameter::Numbered(number), value).is_ok();
    }
    if !program.setup.keeps_offsets {
        // The value is from another machine, or older than a change of dialect, so ignore it.
        return true;
    }
    let (park, axis) = match (of_axis(PARK, number), of_axis(SECOND_PARK, number)) {
        (Some(axis), _) => (&mut program.park, axis),
        (None, Some(axis)) => (program.second_park.get_or_insert_default(), axis),
        (None, None) => return set_offset(program, number, value),
    };
    match axis {
        0 => park.x = value,
        1 => park.y = value,
        _ => park.z = Some(value),
    }
    true
}

fn system(program: &Interpreter, number: u16) -> Option<f64> {
    let modal = &program.modal;
    let written = |mm: f64| modal.in_program_units(mm);
    let (probe, found) = program.last_probe;
    if let Some(axis) = of_axis(5_061, number).and_then(|axis| Axis::PRIMARY.get(axis)) {
        let mut contact = program.position;
        contact.0.iter_mut().zip(probe).for_each(|(place, mm)| *place = mm);
        return Some(written(modal.work(&contact)[*axis]));
    }
    if let Some(axis) = of_axis(5_081, number) {
        return modal.tool_offset.get(axis).copied().map(written);
    }
    if let Some(axis) = axis_at(5_021, number) {
        return Some(coordinate(modal, axis, &program.position));
    }
    if let Some(axis) = axis_at(5_420, number) {
        return Some(coordinate(modal, axis, &modal.work(&program.position)));
    }
    match (number, field(modal, number)) {
        (_, Some(Field::Value(value))) => Some(value),
        (_, Some(Field::System)) => Some((modal.system + 1) as f64),
        (5_070, _) => Some(f64::from(u8::from(found))),
        (5_161, _) => Some(program.park.x),
        (5_162, _) => Some(program.park.y),
        (5_163, _) => Some(program.park.z.unwrap_or(0.0)),
        (5_181..=5_183, _) => {
            let place = program.second_park.unwrap_or_default();
            Some([place.x, place.y, place.z.unwrap_or(0.0)].get(usize::from(number - 5_181)).copied().unwrap_or(0.0))
        }
        (5_210, _) => Some(f64::from(u8::from(modal.g92_is_on || modal.g92 != [0.0; 3]))),
        (5_599, _) => Some(f64::from(u8::from(program.debugs))),
        (5_399, _) => Some(program.input_result),
        (5_400, _) => Some(f64::from(program.tools.number())),
        (5_401..=5_413, _) => Some(of_tool(program, number)),
        // Further axes and offsets of LinuxCNC's parameter file, which are always 0 here.
        (5_021..=5_602, _) => Some(0.0),
        _ => None,
    }
}

/// Returns a value from the entry of the tool in the spindle, in mm as in the file; for an extruder, its
/// offset.
fn of_tool(program: &Interpreter, number: u16) -> f64 {
    let axis = usize::from(number - 5_401);
    let Some(tool) = program.tools.spindle_entry() else {
        let extruder = program.tools.active().map(|tool| tool.settings.offset).unwrap_or_default();
        return extruder.get(axis).copied().unwrap_or(0.0);
    };
    match number {
        5_401..=5_403 => tool.offset.get(axis).copied().unwrap_or(0.0),
        5_404..=5_406 => tool.rotary.get(axis - 3).map_or(0.0, |degrees| f64::from(*degrees)),
        5_410 => tool.diameter,
        5_411 => f64::from(tool.angles[0]),
        5_412 => f64::from(tool.angles[1]),
        5_413 => f64::from(tool.orientation),
        _ => 0.0,
    }
}

/// Returns a coordinate in the program's units.
pub(crate) fn coordinate(modal: &Modal, axis: Axis, place: &PerAxis<f64>) -> f64 {
    if axis.is_primary() { modal.in_program_units(place[axis]) } else { place[axis] }
}
