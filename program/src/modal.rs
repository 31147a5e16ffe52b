//! What a program's words mean at this moment: units, plane, distance mode, offsets, rates.
//!
//! Order of offsets: machine = work + coordinate system - G92 + tool offset. Everything here is in mm and
//! mm/s; inches and minutes end where a word is read.

use gcode::Code;
use units::{Axis, MmPerSecond, PerAxis, Plane};

use crate::action::Corner;
use crate::auxiliary::Auxiliary;
use crate::cycle::{Cycle, Retract};
use crate::words::{Lengths, MM_PER_INCH};

/// Coordinate systems G54 to G59.3.
pub const COORDINATE_SYSTEMS: usize = 9;

/// The modal motion code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionMode {
    /// G0.
    #[default]
    Rapid,
    /// G1.
    Linear,
    /// G2.
    ArcClockwise,
    /// G3.
    ArcCounterClockwise,
    /// G5.
    Cubic,
    /// G5.1.
    Quadratic,
    /// G5.2.
    Nurbs,
    /// G73, G74, G81 to G89: [`Modal::cycle`] says which.
    Cycle,
    /// G33.
    Synchronised,
    /// G76.
    Threading,
    /// G80: none is in force.
    Cancelled,
}

impl MotionMode {
    /// From the number and subcode of a G-code.
    #[must_use]
    pub const fn from_g(number: u16, subcode: u8) -> Option<Self> {
        Some(match (number, subcode) {
            (0, 0) => Self::Rapid,
            (1, 0) => Self::Linear,
            (2, 0) => Self::ArcClockwise,
            (3, 0) => Self::ArcCounterClockwise,
            (5, 0) => Self::Cubic,
            (5, 1) => Self::Quadratic,
            (5, 2) => Self::Nurbs,
            _ => return None,
        })
    }
}

/// What F says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedMode {
    /// G93: how many such moves a minute has.
    InverseTime,
    /// G94: length a minute.
    #[default]
    PerMinute,
    /// G95: length a turn of the spindle.
    PerRevolution,
}

impl FeedMode {
    /// Its G-code.
    #[must_use]
    pub const fn code(self) -> Code {
        match self {
            Self::InverseTime => Code::g(93),
            Self::PerMinute => Code::g(94),
            Self::PerRevolution => Code::g(95),
        }
    }
}

impl Corner {
    /// Its G-code.
    #[must_use]
    pub const fn code(self) -> Code {
        match self {
            Self::Sharp => Code::g(61),
            Self::Stop => Code::g(61).sub(1),
            Self::Rounded(_) => Code::g(64),
        }
    }
}

/// What M120 saves and M121 restores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saved {
    feed_rate: MmPerSecond,
    seek_rate: MmPerSecond,
    absolute: bool,
    e_absolute: bool,
    inches: bool,
    system: usize,
}

/// The modal state.
#[derive(Clone, Debug)]
pub struct Modal {
    /// Last motion code.
    pub motion: MotionMode,
    /// The canned cycle, where that is the motion code.
    pub cycle: Cycle,
    /// Plane of arcs and cycles.
    pub plane: Plane,
    /// Corners.
    pub corner: Corner,
    /// What F says.
    pub feed_mode: FeedMode,
    /// Where cycles leave a hole to.
    pub retract: Retract,
    /// G90.1: I, J and K are places.
    pub arc_absolute: bool,
    /// G20.
    pub inches: bool,
    /// G90.
    pub absolute: bool,
    /// Coordinates of the extruder are places: M82, and what the dialect has G90 and G91 say.
    pub e_absolute: bool,
    /// M82 was said, not M83.
    pub e_places: bool,
    /// Rate of G1 to G5.
    pub feed_rate: MmPerSecond,
    /// F after G95, mm.
    pub feed_per_turn: f64,
    /// Rate of G0.
    pub seek_rate: MmPerSecond,
    /// S of laser and spindle.
    pub power: f32,
    /// Active coordinate system, 0 is G54.
    pub system: usize,
    /// Offsets of the coordinate systems, X Y Z in mm.
    pub systems: [[f64; 3]; COORDINATE_SYSTEMS],
    /// G92 offset, X Y Z in mm.
    pub g92: [f64; 3],
    /// What G92.2 has taken away, and G92.3 brings back.
    pub(crate) g92_kept: [f64; 3],
    /// Tool offset and shift together, X Y Z in mm.
    pub tool_offset: [f64; 3],
    /// Shift of everything (M290), X Y Z in mm.
    pub shift: [f64; 3],
    /// G43, G43.1 or G43.2 is in force, not G49.
    pub has_tool_length: bool,
    /// G7: words of X are diameters.
    pub diameters: bool,
    /// What turns and flows, and the operator's overrides.
    pub auxiliary: Auxiliary,
    /// G53: the next motion code is in machine coordinates.
    pub machine_next: bool,
}

impl Modal {
    /// The state at boot: G0 G17 G21 G54 G61 G90 G91.1 G94 G98 M82.
    #[must_use]
    pub const fn new(feed_rate: MmPerSecond, seek_rate: MmPerSecond) -> Self {
        Self {
            motion: MotionMode::Rapid,
            cycle: Cycle::Drill,
            plane: Plane::Xy,
            corner: Corner::Sharp,
            feed_mode: FeedMode::PerMinute,
            retract: Retract::Initial,
            arc_absolute: false,
            inches: false,
            absolute: true,
            e_absolute: true,
            e_places: true,
            feed_rate,
            feed_per_turn: 0.0,
            seek_rate,
            power: 0.0,
            system: 0,
            systems: [[0.0; 3]; COORDINATE_SYSTEMS],
            g92: [0.0; 3],
            g92_kept: [0.0; 3],
            tool_offset: [0.0; 3],
            shift: [0.0; 3],
            has_tool_length: false,
            diameters: false,
            auxiliary: Auxiliary::START,
            machine_next: false,
        }
    }

    /// The G-code of the motion code in force.
    #[must_use]
    pub const fn motion_code(&self) -> Code {
        match self.motion {
            MotionMode::Rapid => Code::g(0),
            MotionMode::Linear => Code::g(1),
            MotionMode::ArcClockwise => Code::g(2),
            MotionMode::ArcCounterClockwise => Code::g(3),
            MotionMode::Cubic => Code::g(5),
            MotionMode::Quadratic => Code::g(5).sub(1),
            MotionMode::Nurbs => Code::g(5).sub(2),
            MotionMode::Cycle => Code::g(self.cycle.g()),
            MotionMode::Synchronised => Code::g(33),
            MotionMode::Threading => Code::g(76),
            MotionMode::Cancelled => Code::g(80),
        }
    }

    /// How lengths are written.
    #[inline]
    pub(crate) const fn lengths(&self) -> Lengths {
        Lengths { inches: self.inches, diameters: self.diameters }
    }

    /// A length in the program's units.
    #[must_use]
    pub fn in_program_units(&self, mm: f64) -> f64 {
        if self.inches { mm / MM_PER_INCH } else { mm }
    }

    /// Sum of all offsets of one of X Y Z, in mm: machine = work + this.
    #[must_use]
    pub fn offset(&self, axis: Axis) -> f64 {
        let index = axis as usize;
        let pick = |offsets: &[f64; 3]| offsets.get(index).copied().unwrap_or(0.0);
        self.systems.get(self.system).map_or(0.0, pick) - pick(&self.g92) + pick(&self.tool_offset)
    }

    /// Another tool offset; what is shifted stays so.
    pub fn set_tool_offset(&mut self, offset: [f64; 3]) {
        self.tool_offset = offset;
        self.tool_offset.iter_mut().zip(self.shift).for_each(|(sum, shift)| *sum += shift);
    }

    /// The tool offset without what is shifted.
    #[must_use]
    pub(crate) fn own_tool_offset(&self) -> [f64; 3] {
        let mut offset = self.tool_offset;
        offset.iter_mut().zip(self.shift).for_each(|(offset, shift)| *offset -= shift);
        offset
    }

    /// Shifts everything that follows.
    pub fn add_shift(&mut self, axis: Axis, mm: f64) {
        for offset in [&mut self.shift, &mut self.tool_offset] {
            if let Some(offset) = offset.get_mut(axis as usize) {
                *offset += mm;
            }
        }
    }

    /// Work position, in mm, of a machine position.
    #[must_use]
    pub fn work(&self, machine: &PerAxis<f64>) -> PerAxis<f64> {
        let mut work = *machine;
        for axis in Axis::PRIMARY {
            work[axis] -= self.offset(axis);
        }
        work
    }

    /// Machine coordinate of a word on X Y Z, in mm, from where the axis is now.
    #[must_use]
    pub fn machine(&self, axis: Axis, mm: f64, now: f64) -> f64 {
        match (self.machine_next, self.absolute) {
            (true, _) => mm,
            (false, true) => mm + self.offset(axis),
            (false, false) => now + mm,
        }
    }

    /// Machine coordinate of a word on X Y Z that is a place whatever the distance mode, in mm.
    #[must_use]
    pub fn place(&self, axis: Axis, mm: f64) -> f64 {
        if self.machine_next { mm } else { mm + self.offset(axis) }
    }

    /// G92: makes the work coordinate of an axis read `mm` where the machine is now.
    pub fn set_g92(&mut self, axis: Axis, mm: f64, machine: f64) {
        let work = machine - self.offset(axis);
        if let Some(g92) = self.g92.get_mut(axis as usize) {
            *g92 += mm - work;
        }
    }

    /// G10 L20: moves coordinate system `system` so that the work coordinate of an axis reads `mm` in it.
    pub fn set_system_here(&mut self, system: usize, axis: Axis, mm: f64, machine: f64) {
        let index = axis as usize;
        let others = self.tool_offset.get(index).copied().unwrap_or(0.0) - self.g92.get(index).copied().unwrap_or(0.0);
        if let Some(offset) = self.systems.get_mut(system).and_then(|offsets| offsets.get_mut(index)) {
            *offset = machine - others - mm;
        }
    }

    /// M120.
    #[must_use]
    pub const fn save(&self) -> Saved {
        Saved {
            feed_rate: self.feed_rate,
            seek_rate: self.seek_rate,
            absolute: self.absolute,
            e_absolute: self.e_absolute,
            inches: self.inches,
            system: self.system,
        }
    }

    /// M121.
    pub const fn restore(&mut self, saved: &Saved) {
        self.feed_rate = saved.feed_rate;
        self.seek_rate = saved.seek_rate;
        self.absolute = saved.absolute;
        self.e_absolute = saved.e_absolute;
        self.inches = saved.inches;
        self.system = saved.system;
    }
}

/// Writes the name of a coordinate system: `G54` to `G59`, `G59.1` to `G59.3`.
pub fn write_system_name(out: &mut impl core::fmt::Write, system: usize) -> core::fmt::Result {
    if system < 6 { write!(out, "G{}", 54 + system) } else { write!(out, "G59.{}", system - 5) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn modal() -> Modal {
        Modal::new(MmPerSecond(50.0), MmPerSecond(100.0))
    }

    proptest! {
        /// Whatever the offsets, a work coordinate goes to the machine and comes back.
        #[test]
        fn work_and_machine_coordinates_are_inverse(
            offsets in proptest::array::uniform3(-500.0..500.0_f64), word in -500.0..500.0_f64,
        ) {
            let mut modal = modal();
            modal.systems[0][0] = offsets[0];
            modal.g92[0] = offsets[1];
            modal.tool_offset[0] = offsets[2];
            let mut machine = PerAxis([0.0; 6]);
            machine[Axis::X] = modal.machine(Axis::X, word, 12.0);
            let back = modal.work(&machine)[Axis::X];
            prop_assert!((back - word).abs() < 1e-9, "{word} came back as {back}");
        }

        /// After G92 and after G10 L20 the position reads as given, wherever the machine is.
        #[test]
        fn g92_and_g10_l20_make_the_position_read_as_given(
            place in -500.0..500.0_f64, reading in -500.0..500.0_f64, before in -500.0..500.0_f64,
        ) {
            for use_g92 in [true, false] {
                let mut modal = modal();
                modal.system = 3;
                modal.systems[3][1] = before;
                modal.g92[1] = before / 2.0;
                if use_g92 {
                    modal.set_g92(Axis::Y, reading, place);
                } else {
                    modal.set_system_here(3, Axis::Y, reading, place);
                }
                let work = modal.work(&PerAxis([0.0, place, 0.0, 0.0, 0.0, 0.0]))[Axis::Y];
                prop_assert!((work - reading).abs() < 1e-9, "{reading} reads {work}");
            }
        }
    }

    #[test]
    fn relative_words_add_to_the_machine_position_and_g53_ignores_offsets() {
        let mut modal = modal();
        modal.systems[0][0] = 10.0;
        assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 15.0);
        modal.absolute = false;
        assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 105.0);
        modal.machine_next = true;
        assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 5.0);
    }

    #[test]
    fn coordinate_systems_are_named_as_programs_name_them() {
        let names: Vec<String> = (0..COORDINATE_SYSTEMS)
            .map(|system| {
                let mut name = String::new();
                write_system_name(&mut name, system).unwrap();
                name
            })
            .collect();
        assert_eq!(names, ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]);
    }
}
