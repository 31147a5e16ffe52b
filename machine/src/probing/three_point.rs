//! Three point leveling: the plane through three touches.

use motion::Motion;
use motion::compensation::Bed;
use units::Axis;

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::Ports;

/// Corners of a triangle narrower than this, mm^2, tell no plane.
const LEAST_AREA: f64 = 1.0;
/// X and Y.
const XY: u8 = 0b11;

impl<P: Ports> Controller<P> {
    /// G29: touches the three points and says where.
    pub(super) async fn measure_three_points(&mut self) -> Outcome {
        self.check_homed()?;
        let height = self.position[Axis::Z];
        self.touch_three_points(height).await?;
        Ok(Answer::Ok)
    }

    /// G31: what is in force.
    pub(super) fn show_plane(&mut self) -> Outcome {
        match self.ports.motion(|motion| motion.compensation().bed()) {
            Bed::Plane(plane) => {
                self.say(format_args!("Plane: Z = {:.6} X + {:.6} Y + {:.4}\n", plane.x, plane.y, plane.z))
            }
            Bed::Grid => self.say(format_args!("Plane: none, a grid levels the bed\n")),
            Bed::Flat => self.say(format_args!("Plane: none\n")),
        }
        self.say(format_args!("Probe: {}\n", u8::from(self.probe_touches())));
        Ok(Answer::Ok)
    }

    /// G32: the first touch says where Z is; the plane through all three levels the bed.
    pub(super) async fn level_by_three_points(&mut self) -> Outcome {
        // Before anything moves.
        self.plane_through([0.0; 3])?;
        self.recompensate(Motion::level_off).await?;
        if self.config.leveling.home_first {
            self.home(XY).await?;
        }
        let first = self.find_bed(self.nozzle_over(self.levelling.points[0]), self.position[Axis::Z]).await?;
        // The height of the probe's contact is known, so that of the machine is.
        let offset = self.levelling.probe_offsets[2];
        let mut position = self.position;
        position[Axis::Z] += offset - first[Axis::Z];
        self.set_machine_position(position)?;
        self.homed |= 1 << Axis::Z as u8;
        let touches = self.touch_three_points(self.clear_of(offset)).await?;
        let heights = touches.map(|touch| touch[2] - offset);
        if spread(heights) <= self.config.leveling.tolerance.0 {
            self.say(format_args!("The bed is flat, nothing to level\n"));
            return Ok(Answer::Ok);
        }
        let plane = self.plane_through(heights)?;
        self.adopt_plane(plane).await?;
        self.show_plane()
    }

    /// Touches the points; X and Y of the points, Z of the contacts.
    async fn touch_three_points(&mut self, height: f64) -> Result<[[f64; 3]; 3], Failure> {
        let mut touches = [[0.0; 3]; 3];
        for (touch, point) in touches.iter_mut().zip(self.levelling.points) {
            let contact = self.probe_point(self.nozzle_over(point), height).await?;
            *touch = [point[0], point[1], contact[Axis::Z]];
            self.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", touch[0], touch[1], touch[2]));
            self.drain().await;
        }
        self.say(format_args!("max delta: {:.4}\n", spread(touches.map(|touch| touch[2]))));
        Ok(touches)
    }

    /// The plane that has these heights at the points to probe. An error when those stand in a row.
    fn plane_through(&self, [za, zb, zc]: [f64; 3]) -> Result<motion::Plane, Failure> {
        let [a, b, c] = self.levelling.points;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if libm::fabs(area) < LEAST_AREA {
            return Err(Failure::refused("the three points stand in a row: set point1 to point3, or M557"));
        }
        let x = ((zb - za) * (c[1] - a[1]) - (zc - za) * (b[1] - a[1])) / area;
        let y = ((zc - za) * (b[0] - a[0]) - (zb - za) * (c[0] - a[0])) / area;
        Ok(motion::Plane { x, y, z: za - x * a[0] - y * a[1] })
    }
}

fn spread(heights: [f64; 3]) -> f64 {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for height in heights {
        least = if height < least { height } else { least };
        most = if height > most { height } else { most };
    }
    most - least
}
