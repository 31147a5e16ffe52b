//! M48, and Klipper's PROBE_ACCURACY: repeatability of the probe.

use base::failure::{Answer, Failure, Outcome};
use base::spread::Spread;
use base::touches::{MOST, Touches};
use program::Words;
use units::{Axis, MmPerSecond};

use super::search::{Search, check_homed, search};
use crate::probing::ProbeHands;

/// Greatest travel of M48, mm: the search begins just above the bed.
const REPEAT_TRAVEL: f64 = 20.0;
/// Number of probes of M48 without P.
const REPEATS: f64 = 10.0;

/// M48: probes P times at the same place, with F at that rate; reports the differences. Unknown without a
/// probe.
pub fn repeatability<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    if !hands.config().probe.enable {
        return Ok(Answer::Unknown);
    }
    check_homed(hands)?;
    let probe = hands.tuning().probe;
    let rate = words.get('F').map_or(probe.slow_rate, MmPerSecond);
    let repeats = words.get('P').unwrap_or(REPEATS);
    hands.standstill()?;
    let start = hands.position();
    let mut seen = Spread::default();
    let mut first = Touches::default();
    for _ in 0..repeats as u32 {
        let found = search(hands, &Search::down(start, rate, REPEAT_TRAVEL, probe.reverse_z))?;
        hands.go_there(start, probe.return_rate)?;
        let Some(contact) = found else {
            return Err(Failure::refused(&"ZProbe not triggered within 20 mm"));
        };
        let distance = start[Axis::Z] - contact[Axis::Z];
        seen.add(distance);
        first.add(distance);
        hands.say(format_args!("Z:{distance:.4}\n"));
        hands.drain();
    }
    let (mean, deviation) = (seen.mean(), seen.deviation());
    let ([least, most], median) = (seen.ends(), first.median());
    let of = if repeats > MOST as f64 { " of the first 50" } else { "" };
    hands.say(format_args!("Minimum: {least:.4} Maximum: {most:.4} Median{of}: {median:.4}\n"));
    hands.say(format_args!("Delta: {:.4}\nMean: {mean:.4} Standard deviation: {deviation:.4}\n", seen.range()));
    Ok(Answer::Ok)
}
