//! The account of a run's time as the page's data.

use serde::Serialize;

use super::super::Report;
use super::super::marks::Label;
use super::super::slow::{SlowPlace, Starved};
use super::super::times::Times;

/// Greatest number of stops listed; the page tells their full number.
const MOST_STARVED: usize = 50;

/// The page's data about the run's time.
#[derive(Serialize)]
pub struct AccountData<'a> {
    times: &'a Times,
    slow: &'a [SlowPlace],
    /// Stops that nothing asks for; none if the run could not be laid along its program.
    starved: Option<StarvedData<'a>>,
    /// Number of times the runner itself saw the planner starve; none if it could not look.
    counted: Option<usize>,
    /// Changes of layer, feature or object: seconds, layer, feature, object, concatenated.
    labels: Vec<f64>,
}

#[derive(Serialize)]
struct StarvedData<'a> {
    count: usize,
    seconds: f64,
    first: &'a [Starved],
}

/// Returns the account of a run as data.
pub fn data(report: &Report) -> AccountData<'_> {
    let account = &report.account;
    let starved = account.starved.as_deref().map(|starved| StarvedData {
        count: starved.len(),
        seconds: starved.iter().map(|each| each.stood).sum(),
        first: &starved[..starved.len().min(MOST_STARVED)],
    });
    let mut labels = Vec::new();
    let mut last = None;
    for span in &account.spans {
        let Label { layer, feature, object } = span.label;
        if last != Some(span.label) {
            let begins = (span.from_s * 1e4).round() / 1e4;
            labels.extend([begins, f64::from(layer), f64::from(feature), f64::from(object)]);
        }
        last = Some(span.label);
    }
    let counted = report.run.summary.starved_at_s.as_ref().map(Vec::len);
    AccountData { times: &account.times, slow: &account.slow, starved, counted, labels }
}
