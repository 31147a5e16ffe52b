//! Modal state of a program: units, plane, distance mode, offsets, rates.
//!
//! Order of offsets: machine = work + coordinate system - G92 + tool offset. A coordinate system may be
//! rotated: then work and G92 are along its own axes, X and Y of the other offsets along the machine's. All
//! values are in mm and mm/s; reading a word converts inches and minutes.

use gcode::Code;
use units::{Axis, MmPerSecond, PerAxis, Plane};

use crate::action::Corner;
use crate::state::auxiliary::Auxiliary;
use crate::state::cycle::{Cycle, Retract};
use crate::state::rotation::{Rotations, Turn};
use crate::words::{Lengths, MM_PER_INCH};

/// Number of coordinate systems, G54 to G59.3.
pub const COORDINATE_SYSTEMS: usize = 9;

/// The modal motion code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionMode {
    /// Rapid move by G0.
    #[default]
    Rapid,
    /// Linear move by G1.
    Linear,
    /// Clockwise arc by G2.
    ArcClockwise,
    /// Counter-clockwise arc by G3.
    ArcCounterClockwise,
    /// Cubic Bezier by G5.
    Cubic,
    /// Quadratic Bezier by G5.1.
    Quadratic,
    /// Control points of a NURBS (G5.2).
    Nurbs,
    /// Canned cycle, G73, G74, G81 to G89; see [`Modal::cycle`].
    Cycle,
    /// Spindle-synchronised move by G33.
    Synchronised,
    /// Threading cycle by G76.
    Threading,
    /// Probing by G38 with this subcode, in GRBL's dialect.
    Search(u8),
    /// No motion code, after G80.
    Cancelled,
}

impl MotionMode {
    /// Returns the mode for the number and subcode of a G-code.
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

/// Feed mode, the meaning of F.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedMode {
    /// G93, inverse time: number of such moves in a minute.
    InverseTime,
    /// G94, units per minute.
    #[default]
    PerMinute,
    /// G95, units per revolution of the spindle.
    PerRevolution,
}

impl FeedMode {
    /// Returns the G-code that selects the mode.
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
    /// Returns the G-code that selects the mode.
    #[must_use]
    pub const fn code(self) -> Code {
        match self {
            Self::Sharp => Code::g(61),
            Self::Stop => Code::g(61).sub(1),
            Self::Rounded(_) => Code::g(64),
        }
    }
}

/// Modes that M120 saves and M121 restores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saved {
    feed_rate: MmPerSecond,
    seek_rate: MmPerSecond,
    absolute: bool,
    e_absolute: bool,
    inches: bool,
    system: usize,
}

/// Modal state of a program.
#[derive(Clone, Debug)]
pub struct Modal {
    /// Motion code in force.
    pub motion: MotionMode,
    /// Canned cycle, if the motion code is one.
    pub cycle: Cycle,
    /// Plane of arcs and cycles.
    pub plane: Plane,
    /// Treatment of corners (G61, G61.1, G64).
    pub corner: Corner,
    /// Feed mode (G93, G94, G95).
    pub feed_mode: FeedMode,
    /// Height to which cycles leave a hole (G98, G99).
    pub retract: Retract,
    /// Whether I, J and K are positions (G90.1) instead of distances.
    pub arc_absolute: bool,
    /// Whether lengths are in inches (G20).
    pub inches: bool,
    /// Whether coordinates are absolute (G90).
    pub absolute: bool,
    /// Whether E is absolute: M82, and G90 and G91 as far as the dialect says.
    pub e_absolute: bool,
    /// Whether M82 came after the last M83.
    pub e_places: bool,
    /// Feed rate of G1 to G5.
    pub feed_rate: MmPerSecond,
    /// Feed per revolution, F after G95, mm.
    pub feed_per_turn: f64,
    /// Rapid rate of G0.
    pub seek_rate: MmPerSecond,
    /// Factor of the rates of later moves (M220).
    pub speed_factor: f64,
    /// Factor saved by the last M220 B, which M220 R restores; 1 before any.
    pub kept_speed_factor: f64,
    /// S word of laser and spindle.
    pub power: f32,
    /// Active coordinate system; 0 is G54.
    pub system: usize,
    /// Offsets of the coordinate systems, X Y Z in mm.
    pub systems: [[f64; 3]; COORDINATE_SYSTEMS],
    /// Rotations of the coordinate systems.
    pub rotations: Rotations<COORDINATE_SYSTEMS>,
    /// G92 offset, X Y Z in mm.
    pub g92: [f64; 3],
    /// G92 offset that G92.2 has suspended, and G92.3 restores.
    pub(crate) g92_kept: [f64; 3],
    /// Whether G92 or G92.3 is in force, even with an offset of zero: `#5210`.
    pub(crate) g92_is_on: bool,
    /// Sum of tool offset, shift and thermal compensation, X Y Z in mm.
    pub tool_offset: [f64; 3],
    /// Shift of everything (M290), X Y Z in mm.
    pub shift: [f64; 3],
    /// Compensation of the frame's thermal expansion, Z in mm.
    pub(crate) thermal_z: f64,
    /// Whether G43, G43.1 or G43.2 is in force, rather than G49.
    pub has_tool_length: bool,
    /// Whether words of X are diameters (G7).
    pub diameters: bool,
    /// State of spindle, coolant and the operator's overrides.
    pub auxiliary: Auxiliary,
    /// Whether the next motion code is in machine coordinates (G53).
    pub machine_next: bool,
}

impl Modal {
    /// Creates the state at boot: G0 G17 G21 G54 G61 G90 G91.1 G94 G98 M82.
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
            speed_factor: 1.0,
            kept_speed_factor: 1.0,
            feed_per_turn: 0.0,
            seek_rate,
            power: 0.0,
            system: 0,
            systems: [[0.0; 3]; COORDINATE_SYSTEMS],
            rotations: Rotations::NONE,
            g92: [0.0; 3],
            g92_kept: [0.0; 3],
            g92_is_on: false,
            tool_offset: [0.0; 3],
            shift: [0.0; 3],
            thermal_z: 0.0,
            has_tool_length: false,
            diameters: false,
            auxiliary: Auxiliary::START,
            machine_next: false,
        }
    }

    /// Returns the G-code of the motion code in force.
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
            MotionMode::Search(subcode) => Code::g(38).sub(subcode),
            MotionMode::Cancelled => Code::g(80),
        }
    }

    /// Returns the units of lengths in words.
    #[inline]
    pub(crate) const fn lengths(&self) -> Lengths {
        Lengths { inches: self.inches, diameters: self.diameters }
    }

    /// Converts a length to the program's units.
    #[must_use]
    pub fn in_program_units(&self, mm: f64) -> f64 {
        if self.inches { mm / MM_PER_INCH } else { mm }
    }

    /// Copies all offsets from another state, and no mode.
    pub(crate) const fn take_offsets_of(&mut self, other: &Self) {
        (self.systems, self.rotations) = (other.systems, other.rotations);
        (self.g92, self.g92_kept, self.g92_is_on) = (other.g92, other.g92_kept, other.g92_is_on);
        (self.tool_offset, self.has_tool_length) = (other.tool_offset, other.has_tool_length);
        (self.shift, self.thermal_z) = (other.shift, other.thermal_z);
    }

    /// Returns the sum of all offsets of X, Y or Z, mm: machine = work + offset, unless the system is
    /// rotated.
    #[must_use]
    pub fn offset(&self, axis: Axis) -> f64 {
        let index = axis as usize;
        let pick = |offsets: &[f64; 3]| offsets.get(index).copied().unwrap_or(0.0);
        self.systems.get(self.system).map_or(0.0, pick) - pick(&self.g92) + pick(&self.tool_offset)
    }

    /// Sets the tool offset; shifts stay as they are.
    pub fn set_tool_offset(&mut self, offset: [f64; 3]) {
        self.tool_offset = offset;
        let added = self.added();
        self.tool_offset.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
    }

    /// Returns the tool offset without shifts.
    #[must_use]
    pub(crate) fn own_tool_offset(&self) -> [f64; 3] {
        let mut offset = self.tool_offset;
        offset.iter_mut().zip(self.added()).for_each(|(offset, added)| *offset -= added);
        offset
    }

    /// Returns the shifts that `tool_offset` includes.
    pub(crate) fn added(&self) -> [f64; 3] {
        let [x, y, z] = self.shift;
        [x, y, z + self.thermal_z]
    }

    /// Sets the thermal compensation of Z, mm, from the next move on that names Z.
    pub fn set_thermal_z(&mut self, mm: f64) {
        let [.., z] = &mut self.tool_offset;
        *z += mm - self.thermal_z;
        self.thermal_z = mm;
    }

    /// Shifts an axis for everything that follows.
    pub fn add_shift(&mut self, axis: Axis, mm: f64) {
        for offset in [&mut self.shift, &mut self.tool_offset] {
            if let Some(offset) = offset.get_mut(axis as usize) {
                *offset += mm;
            }
        }
    }

    /// Returns the rotation of the coordinate system in force; `None` without rotation.
    pub(crate) fn turn(&self) -> Option<Turn> {
        if self.rotations.any() { self.rotations.turn(self.system) } else { None }
    }

    /// Converts a machine position to work coordinates, mm.
    #[must_use]
    pub fn work(&self, machine: &PerAxis<f64>) -> PerAxis<f64> {
        let mut work = *machine;
        for axis in Axis::PRIMARY {
            work[axis] -= self.offset(axis);
        }
        if let Some(turn) = self.turn() {
            let [g92_x, g92_y, _] = self.g92;
            let [x, y] = turn.back([work[Axis::X] - g92_x, work[Axis::Y] - g92_y]);
            (work[Axis::X], work[Axis::Y]) = (x + g92_x, y + g92_y);
        }
        work
    }

    /// Converts X and Y from work to machine coordinates, mm.
    #[must_use]
    pub fn machine_xy(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let offsets = [self.offset(Axis::X), self.offset(Axis::Y)];
        let [g92_x, g92_y, _] = self.g92;
        let [x, y] = match self.turn() {
            Some(turn) => {
                let [x, y] = turn.forward([x - g92_x, y - g92_y]);
                [x + g92_x, y + g92_y]
            }
            None => [x, y],
        };
        [x + offsets[0], y + offsets[1]]
    }

    /// Rotates a distance along X and Y to the machine's axes.
    #[must_use]
    pub fn way_xy(&self, way: [f64; 2]) -> [f64; 2] {
        self.turn().filter(|_| !self.machine_next).map_or(way, |turn| turn.forward(way))
    }

    /// Returns X and Y of the machine for words, mm, from a machine position. A missing word keeps the
    /// coordinate, in the directions of the words.
    #[must_use]
    pub fn target_xy(&self, [x, y]: [Option<f64>; 2], now: [f64; 2]) -> [f64; 2] {
        if self.machine_next {
            return [x.unwrap_or(now[0]), y.unwrap_or(now[1])];
        }
        if !self.absolute {
            let [x, y] = self.way_xy([x.unwrap_or(0.0), y.unwrap_or(0.0)]);
            return [now[0] + x, now[1] + y];
        }
        self.place_xy([x, y], now)
    }

    /// Returns the same for words that are positions whatever the distance mode.
    #[must_use]
    pub fn place_xy(&self, [x, y]: [Option<f64>; 2], now: [f64; 2]) -> [f64; 2] {
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        (place[Axis::X], place[Axis::Y]) = (now[0], now[1]);
        let work = self.work(&place);
        let to = self.machine_xy([x.unwrap_or(work[Axis::X]), y.unwrap_or(work[Axis::Y])]);
        // A coordinate without a word stays exactly the same, unless rotation lets one word move both.
        let stays = self.turn().is_none();
        [if stays && x.is_none() { now[0] } else { to[0] }, if stays && y.is_none() { now[1] } else { to[1] }]
    }

    /// Returns the machine coordinate for a word on X Y Z, mm, from the axis' position; for X and Y only
    /// without rotation.
    #[must_use]
    pub(crate) fn machine(&self, axis: Axis, mm: f64, now: f64) -> f64 {
        match (self.machine_next, self.absolute) {
            (true, _) => mm,
            (false, true) => mm + self.offset(axis),
            (false, false) => now + mm,
        }
    }

    /// Returns the machine coordinate for a word on X Y Z that is a position whatever the distance mode, mm;
    /// for X and Y only without rotation.
    #[must_use]
    pub(crate) fn place(&self, axis: Axis, mm: f64) -> f64 {
        if self.machine_next { mm } else { mm + self.offset(axis) }
    }

    /// G92: makes the work coordinate of an axis read `mm` at the machine's position.
    pub fn set_g92(&mut self, axis: Axis, mm: f64, machine: &PerAxis<f64>) {
        let work = self.work(machine)[axis];
        if let Some(g92) = self.g92.get_mut(axis as usize) {
            *g92 += mm - work;
        }
    }

    /// G10 L20: moves coordinate system `system` so that the work coordinates of axes with a word read as the
    /// word says, and the others stay.
    pub fn set_system_here(&mut self, system: usize, words: [Option<f64>; 3], machine: &PerAxis<f64>) {
        let in_force = core::mem::replace(&mut self.system, system);
        let work = self.work(machine);
        let turn = self.turn();
        self.system = in_force;
        let [mut x, mut y, z] = Axis::PRIMARY.map(|axis| {
            let index = axis as usize;
            let reads = words.get(index).copied().flatten().unwrap_or(work[axis]);
            reads - self.g92.get(index).copied().unwrap_or(0.0)
        });
        if let Some(turn) = turn {
            [x, y] = turn.forward([x, y]);
        }
        for (axis, from_origin) in Axis::PRIMARY.into_iter().zip([x, y, z]) {
            let index = axis as usize;
            let has_moved = words.get(index).is_some_and(Option::is_some) || turn.is_some();
            let tool = self.tool_offset.get(index).copied().unwrap_or(0.0);
            let offset = self.systems.get_mut(system).and_then(|offsets| offsets.get_mut(index));
            if let Some(offset) = offset.filter(|_| has_moved) {
                *offset = machine[axis] - tool - from_origin;
            }
        }
    }

    /// M120: returns the modes to save.
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

    /// M121: restores saved modes.
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
mod tests;
