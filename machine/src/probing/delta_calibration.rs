//! G32 on a linear delta: trims of the switches and radius of the arms from seven touches of the bed.

use gcode::Block;
use units::{Axis, Mm};

use super::delta_fit::{Belief, fit, spread};
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;

/// Touches of a round.
const POINTS: usize = 7;
/// Rounds at most. The second one measures what is left; more are only for machines that do not repeat themselves.
const ROUNDS: u32 = 5;
/// X, Y and Z.
const TOWERS: u8 = 0b111;

/// The middle; then the three towers, each followed by the place opposite to it, as cosine and sine.
const PLACES: [[f64; 2]; POINTS] = {
    const C: f64 = 0.866_025_403_784_438_6;
    [[0.0, 0.0], [-C, -0.5], [C, 0.5], [C, -0.5], [-C, 0.5], [0.0, 1.0], [0.0, -1.0]]
};

impl<P: Ports> Controller<P> {
    /// G29: how the bed lies at the seven points.
    pub(super) async fn measure_delta(&mut self, block: &Block<'_>) -> Outcome {
        let radius = self.calibration_radius(block)?;
        let (belief, touches) = self.touch_delta(radius).await?;
        self.say(format_args!("Spread: {:.4}\n", spread(&belief, &touches)));
        Ok(Answer::Ok)
    }

    /// G32: R leaves the trims as they are, E the radius; I is the spread to reach, J the circle's radius. K is Smoothieware's for
    /// starting from the present trims, which is always so: what is found does not depend on them.
    pub(super) async fn calibrate_delta(&mut self, block: &Block<'_>) -> Outcome {
        let (trims, radius) = (!block.has('R'), !block.has('E'));
        if !trims && !radius {
            return Err(Failure::refused("G32: R leaves out the trims and E the radius, so nothing is left"));
        }
        let tolerance = block.get('I').map_or(self.config.delta_calibration.tolerance.0, |word| self.modal.to_mm(word));
        let circle = self.calibration_radius(block)?;
        // It belongs to the geometry that is about to change.
        self.recompensate(motion::Motion::level_off).await?;
        let (arms, trim) = (self.motion_config()?.kinematics, self.config.homing.trim);
        let calibrated = self.calibration_rounds(circle, tolerance, trims, radius).await;
        if calibrated.is_err() {
            // As if nothing had been.
            self.config.homing.trim = trim;
            self.come_to_rest().await;
            let now = self.motion_config()?;
            self.change_arms(now, arms)?;
        }
        calibrated
    }

    async fn calibration_rounds(&mut self, circle: f64, tolerance: f64, trims: bool, radius: bool) -> Outcome {
        let mut reached = 0.0;
        for round in 1..=ROUNDS {
            let (belief, touches) = self.touch_delta(circle).await?;
            reached = spread(&belief, &touches);
            self.say(format_args!("Spread: {reached:.4}\n"));
            if reached <= tolerance {
                self.say(format_args!("Calibrated. M500 saves it\n"));
                return Ok(Answer::Ok);
            }
            if round == ROUNDS {
                break;
            }
            let found = fit(&belief, &touches, trims, radius)
                .ok_or_else(|| Failure::refused("calibration: the heights of the points make no sense"))?;
            let now = self.motion_config()?;
            self.change_arms(now, found.kinematics)?;
            self.config.homing.trim = found.trim.map(Mm);
            let [x, y, z] = found.trim;
            self.say(format_args!("Trim: X:{x:.4} Y:{y:.4} Z:{z:.4} Radius: {:.4}\n", found.radius()));
            self.drain().await;
        }
        let text = format_args!(
            "calibration: a spread of {reached:.4} mm is left, more than {tolerance:.4}; nothing was changed"
        );
        Err(Failure::Refused(message(text)))
    }

    fn calibration_radius(&self, block: &Block<'_>) -> Result<f64, Failure> {
        let radius = block.get('J').map_or(self.config.delta_calibration.radius.0, |word| self.modal.to_mm(word));
        if radius > 0.0 { Ok(radius) } else { Err(Failure::refused("J is a radius, above zero")) }
    }

    /// Homes, finds the bed and touches it at every place. The ways of the carriages from their switches.
    async fn touch_delta(&mut self, circle: f64) -> Result<(Belief, [[f64; 3]; POINTS]), Failure> {
        self.home(TOWERS).await?;
        let belief = self.belief()?;
        let bed = self.find_bed([0.0; 2], self.config.delta_calibration.initial_height.0).await?;
        let height = self.clear_of(bed[Axis::Z]);
        let mut touches = [[0.0; 3]; POINTS];
        for (touch, [cosine, sine]) in touches.iter_mut().zip(PLACES) {
            let at = [circle * cosine, circle * sine];
            let contact = self.probe_point(at, height).await?;
            *touch = belief.ways_to(&contact);
            self.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", at[0], at[1], contact[Axis::Z]));
            self.drain().await;
        }
        Ok((belief, touches))
    }

    fn belief(&mut self) -> Result<Belief, Failure> {
        let kinematics = self.motion_config()?.kinematics;
        let trim = self.config.homing.trim.map(|trim| trim.0);
        Ok(Belief { kinematics, trim, home: self.delta_home() })
    }
}
