//! Leveling by a grid of touches: rectangular, and round on a delta.

use gcode::Block;
use motion::{GridShape, Motion};
use units::Axis;

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::levelling::grid;
use crate::ports::Ports;

/// Points along a side of a G29 scan at least, and of a grid.
const LEAST_SCAN: f64 = 5.0;
/// Touches of a spiral without I, and at most.
const SPIRAL: f64 = 50.0;
const MOST_SPIRAL: f64 = 1_000.0;
/// Turn from one touch of a spiral to the next, radians: the golden angle, which spreads them evenly.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// A grid to touch.
#[derive(Clone, Copy, Debug)]
struct Plan {
    shape: GridShape,
    /// Only points within this distance of the middle, mm.
    radius: Option<f64>,
    /// Heights are told from that of the bed here.
    reference: [f64; 2],
    /// Height from which the bed is searched for.
    from: f64,
}

impl<P: Ports> Controller<P> {
    /// G31 and G32 with a cartesian grid.
    pub(super) async fn level_by_cartesian_grid(&mut self, block: &Block<'_>) -> Outcome {
        let settings = self.config.leveling.grid;
        let here = block.get('R') == Some(1.0);
        let two_corners = settings.two_corners && block.get('R') != Some(0.0);
        if settings.home && !here && !two_corners {
            self.home(0).await?;
        }
        self.wait_idle().await?;
        self.check_homed()?;
        let shape = self.cartesian_shape(block, here, two_corners)?;
        self.run_probe_gcode(0).await?;
        let plan = Plan { shape, radius: None, reference: shape.place(0), from: settings.initial_height.0 };
        let leveled = self.level_by_grid(&plan).await;
        self.run_probe_gcode(1).await?;
        leveled
    }

    /// G29 with a cartesian grid: the same from where the tool is, of which nothing remains.
    pub(super) async fn scan_cartesian(&mut self, block: &Block<'_>) -> Outcome {
        self.wait_idle().await?;
        self.check_homed()?;
        let (Some(_), Some(_)) = (block.get('X'), block.get('Y')) else {
            return Err(Failure::refused("G29 takes the size X and Y of the area to scan"));
        };
        let shape = self.cartesian_shape(block, true, false)?;
        if shape.count.iter().any(|count| (*count as f64) < LEAST_SCAN) {
            return Err(Failure::refused("G29 scans at least 5 x 5 points: I and J"));
        }
        let height = self.position[Axis::Z];
        let plan = Plan { shape, radius: None, reference: shape.place(0), from: height };
        self.touch_grid(&plan).await?;
        self.say_draft(&shape).await;
        Ok(Answer::Ok)
    }

    /// The area and its points: from the configuration, or as the words say.
    fn cartesian_shape(&self, block: &Block<'_>, here: bool, two_corners: bool) -> Result<GridShape, Failure> {
        let settings = self.config.leveling.grid;
        let word = |letter| block.get(letter).map(|value| self.modal.to_mm(value));
        let (origin, size) = if two_corners && !here {
            let (Some(x), Some(y), Some(a), Some(b)) = (word('X'), word('Y'), word('A'), word('B')) else {
                return Err(Failure::refused("two corners: X and Y are the start, A and B the size of the area"));
            };
            ([x, y], [a, b])
        } else {
            let start = if here { self.probed_by_nozzle_here() } else { [0.0; 2] };
            let [x, y] = settings.size.map(|size| size.0);
            (start, [word('X').unwrap_or(x), word('Y').unwrap_or(y)])
        };
        let [nx, ny] = settings.count.map(f64::from);
        let counts = [block.get('I').unwrap_or(nx), block.get('J').unwrap_or(ny)];
        let is_count = |count: &f64| *count >= 2.0 && libm::floor(*count) == *count;
        if !counts.iter().all(is_count) || counts[0] * counts[1] > nx * ny {
            let text = format_args!("I and J are points along X and Y, 2 or more, together at most {}", nx * ny);
            return Err(Failure::Refused(message(text)));
        }
        if size.contains(&0.0) {
            return Err(Failure::refused("the area to probe has no size: x_size and y_size, or X and Y"));
        }
        let step = [size[0] / (counts[0] - 1.0), size[1] / (counts[1] - 1.0)];
        Ok(GridShape { origin, step, count: counts.map(|count| count as usize) })
    }

    /// G31 with a delta grid.
    pub(super) async fn level_by_delta_grid(&mut self, block: &Block<'_>) -> Outcome {
        let settings = self.config.leveling.delta;
        let radius = self.grid_radius(block)?;
        if settings.home {
            self.home(0).await?;
        }
        self.wait_idle().await?;
        self.check_homed()?;
        let shape = grid::around(radius, settings.count);
        // A hair more, for rounding.
        let within = Some(radius + 1e-6);
        let plan = Plan { shape, radius: within, reference: [0.0; 2], from: settings.initial_height.0 };
        self.level_by_grid(&plan).await
    }

    /// G29 with a delta grid: a map of I points along each side; G29.1: I points along a spiral. Nothing of it remains.
    pub(super) async fn scan_delta(&mut self, block: &Block<'_>, spiral: bool) -> Outcome {
        let settings = self.config.leveling.delta;
        let radius = self.grid_radius(block)?;
        let usual = if spiral { SPIRAL } else { f64::from(settings.count) };
        let (count, most) = (block.get('I').unwrap_or(usual), if spiral { MOST_SPIRAL } else { 50.0 });
        if !(2.0..=most).contains(&count) {
            return Err(Failure::Refused(message(format_args!("I is the number of points, 2 to {most}"))));
        }
        self.wait_idle().await?;
        self.check_homed()?;
        if !spiral {
            let shape = grid::around(radius, count as u8);
            let within = Some(radius + 1e-6);
            let from = settings.initial_height.0;
            self.touch_grid(&Plan { shape, radius: within, reference: [0.0; 2], from }).await?;
            self.say_draft(&shape).await;
            return Ok(Answer::Ok);
        }
        let bed = self.find_bed(self.nozzle_over([0.0; 2]), settings.initial_height.0).await?[Axis::Z];
        for n in 0..count as u32 {
            let (distance, angle) = (radius * libm::sqrt(f64::from(n) / (count - 1.0)), GOLDEN * f64::from(n));
            let at = [distance * libm::cos(angle), distance * libm::sin(angle)];
            let contact = self.probe_point(self.nozzle_over(at), self.clear_of(bed)).await?;
            self.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", at[0], at[1], contact[Axis::Z] - bed));
            self.drain().await;
        }
        Ok(Answer::Ok)
    }

    fn grid_radius(&self, block: &Block<'_>) -> Result<f64, Failure> {
        let radius = block.get('J').map_or(self.config.leveling.delta.radius.0, |word| self.modal.to_mm(word));
        if radius >= 1.0 { Ok(radius) } else { Err(Failure::refused("J is a radius, 1 mm or more")) }
    }

    /// Touches the bed at every point of a grid and levels by what is found.
    async fn level_by_grid(&mut self, plan: &Plan) -> Outcome {
        self.recompensate(Motion::level_off).await?;
        self.touch_grid(plan).await?;
        let shape = plan.shape;
        if plan.radius.is_some() {
            self.ports.motion(|motion| grid::extrapolate(&shape, motion.draft()));
        }
        self.adopt_grid(&shape).await?;
        self.show_grid().await
    }

    /// Heights of the bed over that at the reference, into the draft; not a number where nothing is to be touched.
    async fn touch_grid(&mut self, plan: &Plan) -> Result<(), Failure> {
        let bed = self.find_bed(self.nozzle_over(plan.reference), plan.from).await?[Axis::Z];
        let height = self.clear_of(bed);
        let [nx, ny] = plan.shape.count;
        for row in 0..ny {
            for step in 0..nx {
                // There and back, so that no way is made twice.
                let column = if row % 2 == 0 { step } else { nx - 1 - step };
                let index = row * nx + column;
                let [x, y] = plan.shape.place(index);
                let found = if plan.radius.is_some_and(|radius| x * x + y * y > radius * radius) {
                    f64::NAN
                } else {
                    let contact = self.probe_point(self.nozzle_over([x, y]), height).await?;
                    self.say(format_args!("DEBUG: X{x:.3}, Y{y:.3}, Z{:.3}\n", contact[Axis::Z] - bed));
                    self.drain().await;
                    contact[Axis::Z] - bed
                };
                self.ports.motion(|motion| {
                    if let Some(slot) = motion.draft().get_mut(index) {
                        *slot = found as f32;
                    }
                });
            }
        }
        Ok(())
    }

    /// The draft, a line for each row.
    async fn say_draft(&mut self, shape: &GridShape) {
        let [nx, ny] = shape.count;
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in 0..ny {
            for column in 0..nx {
                let height = self.ports.motion(|motion| motion.draft().get(row * nx + column).copied());
                let height = height.unwrap_or(f32::NAN);
                if height.is_finite() {
                    least = if height < least { height } else { least };
                    most = if height > most { height } else { most };
                    self.say(format_args!("{height:7.4} "));
                } else {
                    self.say(format_args!("      - "));
                }
            }
            self.say(format_args!("\n"));
            self.drain().await;
        }
        self.say(format_args!("Maximum delta: {:.4}\n", most - least));
    }

    async fn run_probe_gcode(&mut self, which: usize) -> Result<(), Failure> {
        let line = self.config.probe_gcode.get(which).cloned().unwrap_or_default();
        self.run_configured(&line).await?;
        self.wait_idle().await
    }
}
