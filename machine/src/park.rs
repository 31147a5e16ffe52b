//! The park position: G28.1 stores it, G28 in GRBL mode and G28.2 otherwise go there.

use gcode::Block;
use motion::Mode;
use units::{Axis, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::Ports;

/// A place in machine coordinates, mm. Z takes part only where it was stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ParkPosition {
    pub x: f64,
    pub y: f64,
    pub z: Option<f64>,
}

impl ParkPosition {
    /// What was stored for an axis.
    fn of(&self, axis: Axis) -> Option<f64> {
        match axis {
            Axis::X => Some(self.x),
            Axis::Y => Some(self.y),
            Axis::Z => self.z,
            _ => None,
        }
    }
}

impl<P: Ports> Controller<P> {
    /// G28.1: stores where the machine is, or with X and Y (and Z) that place.
    pub(crate) fn store_park_position(&mut self, block: &Block<'_>) -> Outcome {
        let homes_z = self.config.homing_endstop(Axis::Z).is_some();
        if block.is_bare() {
            if !self.all_homed() {
                return Err(Failure::refused("Cannot set predefined position unless axis are homed"));
            }
            let z = homes_z.then_some(self.position[Axis::Z]);
            self.park_position = ParkPosition { x: self.position[Axis::X], y: self.position[Axis::Y], z };
            self.say(format_args!("position saved, use M500 to make permanent\n"));
            return Ok(Answer::Ok);
        }
        let x = block.get('X').ok_or_else(|| Failure::refused("Must supply X"))?;
        let y = block.get('Y').ok_or_else(|| Failure::refused("Must supply Y"))?;
        let z = block.get('Z').filter(|_| homes_z);
        self.park_position = ParkPosition { x, y, z };
        if block.has('Z') && z.is_none() {
            self.say(format_args!("warning:cannot save Z as the z axis cannot be homed\n"));
        }
        Ok(Answer::Ok)
    }

    /// Goes to the park position: first by the words, which are distances whatever the distance mode; then Z, then X and Y. With
    /// words only the axes they name take part.
    pub(crate) async fn park(&mut self, block: &Block<'_>) -> Outcome {
        if let Some((letter, _)) = block.words().find(|(letter, _)| !matches!(letter, 'X' | 'Y' | 'Z')) {
            return Err(Failure::Refused(crate::failure::message(format_args!("{letter} has no park position"))));
        }
        if !self.all_homed() {
            return Err(Failure::refused(
                "cannot move to predefined position as axis are not homed and MCS is unknown",
            ));
        }
        let rate = self.modal.seek_rate;
        let mut by = self.position;
        for axis in Axis::PRIMARY {
            by[axis] += self.modal.to_mm(block.get(axis.letter()).unwrap_or(0.0));
        }
        if by != self.position {
            self.go(by, rate, Mode::Rapid).await?;
        }
        let (place, bare) = (self.park_position, block.is_bare());
        let parked = |mut target: PerAxis<f64>, axes: &[Axis]| {
            for axis in axes.iter().filter(|axis| bare || block.has(axis.letter())) {
                target[*axis] = place.of(*axis).unwrap_or(target[*axis]);
            }
            target
        };
        for axes in [&[Axis::Z][..], &[Axis::X, Axis::Y]] {
            let target = parked(self.position, axes);
            if target != self.position {
                self.go(target, rate, Mode::Rapid).await?;
            }
        }
        Ok(Answer::Ok)
    }

    /// The line M500 saves of it.
    pub(crate) fn write_park_position(&self, text: &mut impl core::fmt::Write) -> core::fmt::Result {
        use crate::overrides_text::Value;
        let ParkPosition { x, y, z } = self.park_position;
        if self.park_position == ParkPosition::default() {
            return Ok(());
        }
        write!(text, ";Park position:\nG28.1 X{} Y{}", Value(x, 4), Value(y, 4))?;
        if let Some(z) = z {
            write!(text, " Z{}", Value(z, 4))?;
        }
        writeln!(text)
    }
}
