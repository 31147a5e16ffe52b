//! Extrusion flow, from how far the extruder has pushed: an input of the heaters' control.

use units::{Micros, ToolId};

/// Time between two looks.
const PERIOD: Micros = Micros::from_millis(100);
/// Time constant of smoothing, s. Retractions and pressure advance push and pull within a few tenths of a
/// second; what is melted follows their mean.
const SMOOTHED_S: f64 = 0.5;
/// Filament diameter where the configuration does not say, mm.
const USUAL_DIAMETER: f64 = 1.75;

/// Estimate of the extrusion flow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flow {
    due: Micros,
    /// Tool of the last look, its pushed length, mm, and the time.
    before: Option<(ToolId, f64, Micros)>,
    mm3_per_s: f64,
}

impl Flow {
    /// Returns the time of the next look.
    pub const fn due(&self) -> Micros {
        self.due
    }

    /// Looks at how far a tool's extruder has pushed, mm, and returns the flow, mm3/s. Retracted filament is
    /// pushed again and counts as nothing.
    pub fn look(&mut self, now: Micros, (tool, pushed): (ToolId, f64), diameter: Option<f64>) -> f32 {
        self.due = now.plus(PERIOD);
        let before = self.before.replace((tool, pushed, now)).filter(|(before, ..)| *before == tool);
        let Some((_, from, since)) = before else {
            self.mm3_per_s = 0.0;
            return 0.0;
        };
        let seconds = now.since(since).seconds();
        let diameter = diameter.filter(|diameter| *diameter > 0.0).unwrap_or(USUAL_DIAMETER);
        let area = core::f64::consts::PI / 4.0 * diameter * diameter;
        if seconds > 0.0 {
            let flow = (pushed - from) / seconds * area;
            self.mm3_per_s += (flow - self.mm3_per_s) * seconds / (seconds + SMOOTHED_S);
        }
        self.mm3_per_s.max(0.0) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOOL: ToolId = ToolId(0);

    /// Returns the last flow of filament that is pushed by so many mm in each tenth of a second.
    fn flow(pushes: impl Iterator<Item = f64>) -> f32 {
        let (mut flow, mut pushed, mut said) = (Flow::default(), 0.0, 0.0);
        for (look, push) in pushes.enumerate() {
            pushed += push;
            said = flow.look(Micros::from_millis(100 * look as u64), (TOOL, pushed), None);
        }
        said
    }

    #[test]
    fn a_steady_push_is_what_it_is() {
        assert!((flow((0..60).map(|_| 0.4)) - 4.0 * 2.405).abs() < 0.02);
    }

    #[test]
    fn a_retraction_counts_as_nothing() {
        assert_eq!(flow([0.0, 0.0, -1.0].into_iter()), 0.0);
        let printed = (0..60).map(|look| {
            if look % 20 == 10 {
                -0.8
            } else if look % 20 == 11 {
                1.2
            } else {
                0.2
            }
        });
        assert!(flow(printed) < 2.0 * 2.405 * 1.2);
    }

    #[test]
    fn another_tool_begins_anew() {
        let mut flow = Flow::default();
        for look in 0..20 {
            flow.look(Micros::from_millis(100 * look), (TOOL, look as f64), Some(1.75));
        }
        assert_eq!(flow.look(Micros::from_millis(2_100), (ToolId(1), 500.0), Some(1.75)), 0.0);
    }
}
