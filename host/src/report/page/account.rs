//! The account of a run's time as the page's data.

use serde::Serialize;

use super::super::Report;
use super::super::marks::Label;
use super::super::slow::{SlowPlace, Starved};
use super::super::times::Times;

/// Stops listed at most; how many there are is told.
const MOST_STARVED: usize = 50;

/// What the page says of the time.
#[derive(Serialize)]
pub struct AccountData<'a> {
    times: &'a Times,
    slow: &'a [SlowPlace],
    /// None: the run could not be laid along its program.
    starved: Option<StarvedData<'a>>,
    /// How often the runner itself saw the planner starve; none: it could not look.
    counted: Option<usize>,
    /// When what is made changes: seconds, layer, feature, object, one behind the other.
    labels: Vec<f64>,
}

#[derive(Serialize)]
struct StarvedData<'a> {
    count: usize,
    seconds: f64,
    first: &'a [Starved],
}

/// Of a run.
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
