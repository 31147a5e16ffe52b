//! `summary.json`: a run in numbers.

use super::json::{lines, number, object, string, strings};
use crate::world::World;

/// Distances of step edges from the oracle's times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepError {
    /// Largest distance of an edge, nanoseconds.
    pub max_ns: f64,
    /// Root mean square, nanoseconds.
    pub rms_ns: f64,
    /// Edges by distance: below 1, 2, 3, 4, 5, 10, 20, 50, 100, 250 and 1000 ns, and beyond.
    pub bins: [u64; 12],
}

#[cfg(feature = "runner")]
impl From<motion::oracle::StepError> for StepError {
    fn from(error: motion::oracle::StepError) -> Self {
        Self { max_ns: error.max, rms_ns: error.rms(), bins: error.bins }
    }
}

/// Facts that a run's driver knows besides the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Lines of the job.
    pub lines: u64,
    /// Reason of a halt, if the machine halted.
    pub halted: Option<String>,
    /// Errors the firmware reported, or that ended the run.
    pub errors: Vec<String>,
    /// Distances of the edges from the oracle's, with verification.
    pub step_error: Option<StepError>,
    /// Times at which the planner had to release a move with too little look-ahead behind it, nanoseconds;
    /// `None` if nobody could look into the planner.
    pub starved_ns: Option<Vec<u64>>,
    /// The emulated board's complaints; empty for a clean run and for runs without a board.
    pub board: Vec<String>,
}

impl Outcome {
    /// Returns whether the job ended without halt or error.
    #[must_use]
    pub const fn succeeded(&self) -> bool {
        self.halted.is_none() && self.errors.is_empty()
    }
}

/// The member with the distances from the oracle.
const STEP_ERROR: &str = "step_error_ns";

fn distances(error: StepError) -> String {
    object(&[("max", number(error.max_ns, 1)), ("rms", number(error.rms_ns, 2))])
}

/// Returns a summary of [`render`] with the result of a verification that came later; `None` when the text
/// is no such summary.
pub(super) fn with_verification(text: &str, result: &Result<StepError, String>) -> Option<String> {
    let member = format!("  {}: ", string(STEP_ERROR));
    let mut members: Vec<String> =
        text.strip_prefix("{\n")?.strip_suffix("\n}\n")?.lines().map(str::to_owned).collect();
    members.retain(|line| !line.starts_with(&member));
    match result {
        Ok(error) => {
            let last = members.last_mut()?;
            *last = format!("{},", last.trim_end_matches(','));
            members.push(format!("{member}{}", distances(*error)));
        }
        Err(reason) => {
            let errors = members.iter_mut().find(|line| line.starts_with("  \"errors\": ["))?;
            let head = errors.trim_end_matches(',').strip_suffix(']')?;
            let comma = if head.ends_with('[') { "" } else { ", " };
            *errors = format!("{head}{comma}{}],", string(reason));
            let last = members.last_mut()?;
            *last = last.trim_end_matches(',').to_owned();
        }
    }
    Some(format!("{{\n{}\n}}\n", members.join("\n")))
}

/// Returns the summary as JSON text.
pub(super) fn render(world: &World, outcome: &Outcome) -> String {
    let actuators: Vec<(String, String)> = world
        .config()
        .actuators
        .iter()
        .map(|config| {
            let tally = world.trace().tally(config.actuator);
            let members = [
                ("steps", tally.steps.to_string()),
                ("position_mm", number(world.carriage_mm(config.actuator).unwrap_or(f64::NAN), 4)),
                ("max_steps_per_s", number(tally.max_steps_per_s, 1)),
                ("lost_mm", number(world.lost_mm(config.actuator), 4)),
            ];
            (config.actuator.name().to_owned(), object(&members))
        })
        .collect();
    let heaters: Vec<(String, String)> = world
        .config()
        .heaters
        .iter()
        .enumerate()
        .map(|(index, heater)| {
            let members =
                [("final_c", number(world.heater_c(index), 2)), ("max_c", number(world.heater_max_c(index), 2))];
            (heater.name.clone(), object(&members))
        })
        .collect();
    let mut members: Vec<(String, String)> = vec![
        ("virtual_seconds".into(), number(world.now_ns() as f64 * 1e-9, 6)),
        ("lines".into(), outcome.lines.to_string()),
        ("halted".into(), outcome.halted.as_deref().map_or("null".into(), string)),
        ("errors".into(), strings(&outcome.errors)),
        ("actuators".into(), lines(&actuators, "  ")),
        ("heaters".into(), lines(&heaters, "  ")),
        ("edges".into(), world.trace().total().to_string()),
        ("edge_hash".into(), string(&format!("{:016x}", world.trace().edge_hash()))),
        ("timing_faults".into(), world.timing_faults().to_string()),
        ("board".into(), strings(&outcome.board)),
    ];
    if let Some(times) = &outcome.starved_ns {
        let times: Vec<String> = times.iter().map(|time| number(*time as f64 * 1e-9, 4)).collect();
        members.push(("starved_at_s".into(), format!("[{}]", times.join(", "))));
    }
    if let Some(error) = outcome.step_error {
        members.push((STEP_ERROR.into(), distances(error)));
    }
    lines(&members, "") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::WorldConfig;

    fn summary(outcome: &Outcome) -> String {
        render(&World::new(WorldConfig::default()), outcome)
    }

    #[test]
    fn a_summary_is_json_with_what_the_run_knows() {
        let halted = Outcome { lines: 7, halted: Some("it's \"hot\"".into()), ..Outcome::default() };
        let text = summary(&halted);
        assert!(text.contains("\n  \"lines\": 7,") && text.contains("\"halted\": \"it's \\\"hot\\\"\""), "{text}");
        assert!(!text.contains("starved_at_s") && !text.contains(STEP_ERROR), "nobody has looked");
        let looked = Outcome { starved_ns: Some(vec![1_500_000_000]), ..Outcome::default() };
        assert!(summary(&looked).contains("\"starved_at_s\": [1.5000]"));
        assert!(summary(&looked).contains("\"halted\": null"));
        assert!(!halted.succeeded() && looked.succeeded());
    }

    #[test]
    fn a_later_verification_is_as_if_it_had_been_there() {
        let error = StepError { max_ns: 12.25, rms_ns: 1.5, ..StepError::default() };
        let before = summary(&Outcome::default());
        let known = summary(&Outcome { step_error: Some(error), ..Outcome::default() });
        assert_eq!(with_verification(&before, &Ok(error)), Some(known.clone()));
        assert_eq!(with_verification(&known, &Ok(error)), Some(known), "a second one takes its place");
    }

    #[test]
    fn a_verification_that_fails_is_one_of_the_errors() {
        let text = |errors: &[&str]| {
            let errors = errors.iter().map(|error| (*error).to_owned()).collect();
            summary(&Outcome { errors, ..Outcome::default() })
        };
        assert_eq!(with_verification(&text(&[]), &Err("an edge too much".into())), Some(text(&["an edge too much"])));
        assert_eq!(with_verification(&text(&["a"]), &Err("b".into())), Some(text(&["a", "b"])));
        assert_eq!(with_verification("no summary", &Err("b".into())), None);
    }
}
