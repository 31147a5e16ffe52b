//! Levelling and skew: M370, M374, M375, M421, M557, M561, M565, M852.
//!
//! What is measured, and how, is `probing`'s matter. Here a plane or a grid of heights becomes the compensation of the motion object, is
//! kept on the card, shown and saved. A height is what must be added to Z for the tool to be as far from the bed there as at height zero:
//! positive where the bed is higher.
//!
//! Coordinates are those of the program throughout. When the compensation changes while the machine knows where it is, they stay and
//! the motors follow: the tool moves by as much as the compensation changed there, slowly. When it does not know, nothing moves.

pub(crate) mod grid;
mod grid_file;
mod table;
#[cfg(test)]
mod tests;

use gcode::{Block, Code};
use motion::compensation::Bed;
use motion::{CompensationError, Fade, GridShape, Mode, Motion, Plane, Skew};
use units::{Axis, Micros, MmPerSecond};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;
use crate::wait::yield_once;

/// The tool follows a change of compensation at this speed at most.
const FOLLOWING: MmPerSecond = MmPerSecond(5.0);
/// Less than this, mm, is no change.
const NOTHING: f64 = 1e-6;
/// After a halt the motors' places are known within a millisecond or two; much more is a fault.
const SETTLING_TIME: Micros = Micros::from_millis(100);
/// Numbers of a plane are kept to as many parts of one, skew factors too: so they are saved exactly.
const PLANE_PARTS: f64 = 1e9;
const SKEW_PARTS: f64 = 1e8;
/// Planes that Smoothieware saved are the bits of single-precision numbers: integers beyond this.
const LEAST_BITS: f64 = 1e6;

/// What probing a bed starts from; set by the configuration, M557 and M565.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levelling {
    /// Three points to probe, X and Y, mm.
    pub points: [[f64; 2]; 3],
    /// Where the probe is, seen from the tool, mm.
    pub probe_offsets: [f64; 3],
}

fn refuse(error: CompensationError) -> Failure {
    Failure::Refused(message(format_args!("{error}")))
}

fn rounded(value: f64, parts: f64) -> f64 {
    libm::floor(value * parts + 0.5) / parts
}

impl<P: Ports> Controller<P> {
    /// At boot, before anything moves.
    pub(crate) fn configure_levelling(&mut self) {
        let leveling = &self.config.leveling;
        let probe_offsets = match leveling.strategy {
            Some(config::Leveling::CartesianGrid) => leveling.grid.offsets,
            Some(config::Leveling::DeltaGrid) => leveling.delta.offsets,
            _ => leveling.plane_offsets,
        };
        self.levelling = Levelling { points: leveling.points, probe_offsets };
        let skew = self.configured_skew();
        if let Err(error) = self.ports.motion(|motion| motion.set_skew(skew)) {
            self.say(format_args!("ERROR: config.ini: [skew correction] {error}\n"));
        }
    }

    fn configured_skew(&self) -> Skew {
        let [xy, xz, yz] = self.config.leveling.skew.map(|skew| match skew.measured {
            Some([ac, bd, ad]) => Skew::from_square(ac, bd, ad).unwrap_or(0.0),
            None => skew.factor,
        });
        let [xy, xz, yz] = [xy, xz, yz].map(|factor| rounded(factor, SKEW_PARTS));
        Skew { xy, xz, yz }
    }

    /// The codes of this module.
    pub(crate) async fn levelling_code(&mut self, code: Code, block: &Block<'_>) -> Outcome {
        match (code.number, code.subcode) {
            (370, 0) => self.recompensate(Motion::level_off).await,
            (374, 0) => self.save_grid().await,
            (374, _) => self.delete_grid(),
            (375, 0) => self.load_grid().await,
            (375, _) => self.show_grid().await,
            (421, _) => self.set_grid_point(block).await,
            (557, _) => self.probe_point_code(block),
            (561, _) => self.plane_code(block).await,
            (565, _) => self.probe_offset_code(block),
            _ => self.skew_code(block).await,
        }
    }

    /// Changes the compensation as said above.
    pub(crate) async fn recompensate(
        &mut self,
        change: impl FnOnce(&mut Motion) -> Result<(), CompensationError>,
    ) -> Outcome {
        self.wait_idle().await?;
        let before = self.position;
        self.ports.motion(change).map_err(refuse)?;
        self.resync();
        let changed = |axis: &Axis| libm::fabs(self.position[*axis] - before[*axis]) > NOTHING;
        let moved: u8 = Axis::PRIMARY.into_iter().filter(changed).fold(0, |set, axis| set | (1 << axis as u8));
        if moved != 0 && self.homed & moved == moved {
            self.go(before, FOLLOWING, Mode::Feed).await?;
            self.wait_idle().await?;
        } else {
            self.set_machine_position(before)?;
        }
        Ok(Answer::Ok)
    }

    /// Sets compensation aside: until [`Self::put_compensation_back`] coordinates are the motors' own. Only while idle.
    pub(crate) fn set_compensation_aside(&mut self) -> Result<(), Failure> {
        self.ports.motion(|motion| motion.suspend_compensation(true)).map_err(refuse)?;
        self.resync();
        Ok(())
    }

    /// Coordinates are the motors' own at the moment.
    pub(crate) fn compensation_is_aside(&mut self) -> bool {
        self.ports.motion(|motion| motion.compensation().is_suspended())
    }

    /// Puts compensation in force again; nothing moves. Waits for the end of a stop or a halt.
    pub(crate) async fn put_compensation_back(&mut self) {
        let since = self.ports.now();
        while self.ports.motion(|motion| motion.suspend_compensation(false)).is_err()
            && self.ports.now().since(since) < SETTLING_TIME
        {
            self.serve();
            yield_once().await;
        }
        self.resync();
    }

    /// Levels by the heights in the motion object's draft.
    pub(crate) async fn adopt_grid(&mut self, shape: &GridShape) -> Outcome {
        let fade = self.fade();
        self.recompensate(|motion| motion.level_by_draft(shape, fade)).await
    }

    /// Levels by a plane.
    pub(crate) async fn adopt_plane(&mut self, plane: Plane) -> Outcome {
        let [x, y, z] = [plane.x, plane.y, plane.z].map(|part| rounded(part, PLANE_PARTS));
        self.recompensate(|motion| motion.level_by_plane(Plane { x, y, z })).await
    }

    fn fade(&self) -> Option<Fade> {
        let grid = &self.config.leveling.grid;
        let is_meant = self.config.leveling.strategy == Some(config::Leveling::CartesianGrid);
        let fade = Fade { start: grid.fade_start.0, end: grid.fade_end.0 };
        (is_meant && fade.end > fade.start).then_some(fade)
    }

    /// M561: no levelling; with A B C D the plane `A X + B Y + C Z + D = 0`.
    async fn plane_code(&mut self, block: &Block<'_>) -> Outcome {
        let words = ['A', 'B', 'C', 'D'].map(|letter| block.get(letter));
        if words.iter().all(Option::is_none) {
            return self.recompensate(Motion::level_off).await;
        }
        let [Some(a), Some(b), Some(c), Some(d)] = words else {
            return Err(Failure::refused("M561 takes A, B, C and D, or none of them"));
        };
        let plane = Plane::from_equation(plane_words([a, b, c, d]));
        let plane = plane.ok_or_else(|| Failure::refused("M561: that plane stands upright"))?;
        self.adopt_plane(plane).await
    }

    /// M852: skew factors I (XY), J (XZ), K (YZ); without words shows them.
    async fn skew_code(&mut self, block: &Block<'_>) -> Outcome {
        let mut skew = self.ports.motion(|motion| motion.compensation().skew());
        let mut any = false;
        for (letter, factor) in [('I', &mut skew.xy), ('J', &mut skew.xz), ('K', &mut skew.yz)] {
            if let Some(word) = block.get(letter) {
                *factor = rounded(word, SKEW_PARTS);
                any = true;
            }
        }
        if any {
            self.recompensate(|motion| motion.set_skew(skew)).await?;
        }
        self.say(format_args!("Skew factors: XY {:.8} XZ {:.8} YZ {:.8}\n", skew.xy, skew.xz, skew.yz));
        Ok(Answer::Ok)
    }

    /// M557: P0 to P2 with X and Y is a point to probe; without words shows all.
    fn probe_point_code(&mut self, block: &Block<'_>) -> Outcome {
        if let Some(number) = block.get('P') {
            let index = [0.0, 1.0, 2.0].iter().position(|known| *known == number);
            let point = index.and_then(|index| self.levelling.points.get_mut(index));
            let [x, y] = point.ok_or_else(|| Failure::refused("M557: P is 0, 1 or 2"))?;
            *x = block.get('X').map_or(*x, |word| self.modal.to_mm(word));
            *y = block.get('Y').map_or(*y, |word| self.modal.to_mm(word));
        }
        for (index, [x, y]) in self.levelling.points.into_iter().enumerate() {
            self.say(format_args!("P{index} X:{x:.4} Y:{y:.4}\n"));
        }
        Ok(Answer::Ok)
    }

    /// M565: where the probe is, seen from the tool.
    fn probe_offset_code(&mut self, block: &Block<'_>) -> Outcome {
        for (letter, offset) in ['X', 'Y', 'Z'].into_iter().zip(&mut self.levelling.probe_offsets) {
            if let Some(word) = block.get(letter) {
                *offset = self.modal.to_mm(word);
            }
        }
        let [x, y, z] = self.levelling.probe_offsets;
        self.say(format_args!("Probe offsets: X:{x:.4} Y:{y:.4} Z:{z:.4}\n"));
        Ok(Answer::Ok)
    }

    /// The lines M500 saves of this.
    pub(crate) fn write_levelling(&mut self, text: &mut impl core::fmt::Write) -> core::fmt::Result {
        let (skew, bed) = self.ports.motion(|motion| (motion.compensation().skew(), motion.compensation().bed()));
        if skew != self.configured_skew() {
            writeln!(text, ";Skew factors XY XZ YZ:\nM852 I{:.8} J{:.8} K{:.8}", skew.xy, skew.xz, skew.yz)?;
        }
        let leveling = &self.config.leveling;
        let Some(strategy) = leveling.strategy else { return Ok(()) };
        if strategy == config::Leveling::ThreePoint {
            writeln!(text, ";Probe points:")?;
            for (index, [x, y]) in self.levelling.points.into_iter().enumerate() {
                writeln!(text, "M557 P{index} X{x:.5} Y{y:.5}")?;
            }
        }
        let [x, y, z] = self.levelling.probe_offsets;
        writeln!(text, ";Probe offsets:\nM565 X{x:.5} Y{y:.5} Z{z:.5}")?;
        let saves_grid = match strategy {
            config::Leveling::CartesianGrid => leveling.grid.save,
            config::Leveling::DeltaGrid => leveling.delta.save,
            config::Leveling::ThreePoint => false,
        };
        match bed {
            Bed::Plane(plane) if leveling.save_plane => {
                writeln!(text, ";Plane A X + B Y + C Z + D = 0:")?;
                writeln!(text, "M561 A{:.9} B{:.9} C1 D{:.9}", -plane.x, -plane.y, -plane.z)
            }
            Bed::Grid if saves_grid => writeln!(text, ";Load the saved grid:\nM375"),
            _ => Ok(()),
        }
    }
}

/// The words of M561: numbers, or what Smoothieware saved, the bits of single-precision numbers.
fn plane_words(words: [f64; 4]) -> [f64; 4] {
    let is_bits = |word: &f64| libm::floor(*word) == *word && libm::fabs(*word) <= f64::from(u32::MAX);
    let is_saved = words.iter().all(is_bits) && words.iter().any(|word| libm::fabs(*word) > LEAST_BITS);
    if is_saved { words.map(|word| f64::from(f32::from_bits(word as i64 as u32))) } else { words }
}
