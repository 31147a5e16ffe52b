//! G2 and G3: from words to the shape of an arc.

use units::{Axis, Plane};

use crate::action::{Centre, Shape};
use crate::context::Context;
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::words::Words;
use gcode::Dialect;

/// Upper limit of P: no real program has more turns.
const MOST_TURNS: f64 = 10_000.0;

/// Returns the letter of the centre's distance along an axis.
const fn centre_word(axis: Axis) -> char {
    match axis {
        Axis::X => 'I',
        Axis::Y => 'J',
        _ => 'K',
    }
}

/// Whether words describe an arc, rather than a rate alone.
pub(crate) fn is_drawn_by(words: &Words<'_>) -> bool {
    words.other_than("FS").is_some()
}

/// Returns the centre in a rotated coordinate system.
#[cold]
fn turned(program: &Interpreter, words: &Words<'_>, centre: Centre) -> Centre {
    let (Centre::At(i, j), modal) = (centre, &program.modal) else { return centre };
    if modal.machine_next {
        return centre;
    }
    let [x, y] = if modal.arc_absolute {
        let place = [words.length('I').unwrap_or(0.0), words.length('J').unwrap_or(0.0)];
        let [x, y] = modal.machine_xy(place);
        [x - program.position[Axis::X], y - program.position[Axis::Y]]
    } else {
        modal.way_xy([i, j])
    };
    Centre::At(x, y)
}

/// Builds an arc from I J K (distances from the start, or positions after G90.1) or R, and P.
pub(crate) fn arc(program: &Interpreter, context: &Context<'_>, clockwise: bool) -> Result<Shape, Fault> {
    let words = &context.words;
    let plane = program.modal.plane;
    let (first, second) = plane.axes();
    let (centre, word) = match words.length('R') {
        Some(radius) => (Centre::Radius(radius), 'R'),
        None => {
            let along = |axis: Axis| words.length(centre_word(axis));
            let centre = if program.modal.arc_absolute {
                let both = along(first).zip(along(second));
                let (one, other) = both.ok_or(Problem::CentreAbsolute.alarm(words.column()))?;
                let distance = |axis: Axis, mm: f64| program.modal.place(axis, mm) - program.position[axis];
                Centre::At(distance(first, one), distance(second, other))
            } else {
                Centre::At(along(first).unwrap_or(0.0), along(second).unwrap_or(0.0))
            };
            let centre = if program.modal.rotations.any() { turned(program, words, centre) } else { centre };
            (centre, centre_word(first))
        }
    };
    if plane != Plane::Xy && program.modal.turn().is_some() {
        return Err(Problem::TurnedPlane.alarm(words.column()));
    }
    // P counts full circles before the arc in Marlin; P of RS-274 counts the arc, too.
    let before = if context.dialect == Dialect::Marlin { 1.0 } else { 0.0 };
    let turns = words.number('P').map_or(1.0, |turns| turns + before);
    if !(1.0..=MOST_TURNS).contains(&turns) || libm::floor(turns) != turns {
        return Err(Problem::Turns.alarm(words.column_of('P')));
    }
    // Seen from the positive third axis, Z comes before X in their plane (NIST RS-274/NGC, 3.5.3).
    let clockwise = clockwise != (plane == Plane::Xz);
    Ok(Shape::Arc { plane, centre, clockwise, turns: turns as u32, column: words.column_of(word) })
}
