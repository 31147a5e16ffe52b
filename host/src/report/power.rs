//! Power of a run's laser over time, from `power.csv`.

use std::path::Path;

use anyhow::{Context, Result};

/// File of the changes of power in a run's folder.
pub const FILE: &str = "power.csv";

/// Duty from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Time of the change, nanoseconds.
    pub time_ns: u64,
    /// Share of full power.
    pub duty: f64,
}

/// Power within a slot of time, shares of full power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slot {
    /// Mean power.
    pub mean: f64,
    /// Highest power.
    pub highest: f64,
}

/// Reads a run's changes of power; none if the run had no laser that burned.
pub fn read(out: &Path) -> Result<Vec<Change>> {
    let path = out.join(FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    parse(&text).with_context(|| path.display().to_string())
}

/// Reads a text; see [`read`].
pub fn parse(text: &str) -> Result<Vec<Change>> {
    let rows = text.lines().enumerate().skip(1);
    let parsed = rows.map(|(index, row)| {
        let change = row.split_once(',').and_then(|(time, duty)| {
            let duty = f64::from(duty.parse::<u16>().ok()?) / 65_535.0;
            Some(Change { time_ns: time.parse().ok()?, duty })
        });
        change.with_context(|| format!("line {} is not time_ns,duty: {row}", index + 1))
    });
    parsed.collect()
}

/// Returns mean and highest power in each of so many slots of time, from the beginning on.
pub fn slots(changes: &[Change], slot_ns: u64, count: usize) -> Vec<Slot> {
    let mut slots = vec![Slot::default(); count];
    let end_ns = slot_ns * count as u64;
    for (place, Change { time_ns, duty }) in changes.iter().enumerate() {
        let until_ns = changes.get(place + 1).map_or(end_ns, |next| next.time_ns).min(end_ns);
        let mut from_ns = *time_ns;
        while from_ns < until_ns {
            let index = from_ns / slot_ns;
            let to_ns = until_ns.min((index + 1) * slot_ns);
            let slot = &mut slots[index as usize];
            slot.mean += duty * (to_ns - from_ns) as f64 / slot_ns as f64;
            slot.highest = slot.highest.max(*duty);
            from_ns = to_ns;
        }
    }
    slots
}

/// Returns the changes, or means over even times if there are more than so many.
pub fn thinned(changes: &[Change], most: usize) -> Vec<Change> {
    let (Some(last), true) = (changes.last(), changes.len() > most) else { return changes.to_vec() };
    let slot_ns = last.time_ns.div_ceil(most as u64).max(1);
    let means = slots(changes, slot_ns, most).into_iter().enumerate();
    let mut thinned: Vec<Change> =
        means.map(|(index, slot)| Change { time_ns: index as u64 * slot_ns, duty: slot.mean }).collect();
    thinned.dedup_by_key(|change| change.duty);
    // The last slot is a whole one too.
    thinned.push(Change { time_ns: slot_ns * most as u64, ..*last });
    thinned
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rows_that_are_none_are_named() {
        assert_eq!(parse("time_ns,duty\n5,65535\n").expect("a row"), [Change { time_ns: 5, duty: 1.0 }]);
        let error = parse("time_ns,duty\n5,65535\nx,1\n").expect_err("no row");
        assert_eq!(error.to_string(), "line 3 is not time_ns,duty: x,1");
    }

    #[test]
    fn a_slot_has_the_mean_and_the_highest() {
        let change = |time_ns, duty| Change { time_ns, duty };
        let slots = slots(&[change(50, 1.0), change(75, 0.5), change(150, 0.0)], 100, 3);
        let pairs: Vec<_> = slots.iter().map(|slot| (slot.mean, slot.highest)).collect();
        assert_eq!(pairs, [(0.375, 1.0), (0.25, 0.5), (0.0, 0.0)]);
    }

    /// Time times power of changes that end dark.
    fn energy(changes: &[Change]) -> f64 {
        changes.windows(2).map(|pair| pair[0].duty * (pair[1].time_ns - pair[0].time_ns) as f64).sum()
    }

    proptest! {
        #[test]
        fn thinning_keeps_the_energy(lengths in prop::collection::vec((1_u64..5_000, 0_u8..3), 1..300), most in 5_usize..400) {
            let mut time_ns = 0;
            let mut changes = Vec::new();
            for (length, duty) in &lengths {
                changes.push(Change { time_ns, duty: f64::from(*duty) / 2.0 });
                time_ns += length;
            }
            changes.push(Change { time_ns, duty: 0.0 });
            let thinned = thinned(&changes, most);
            prop_assert!(thinned.len() <= most + 1);
            prop_assert!((energy(&thinned) - energy(&changes)).abs() <= 1e-6 * time_ns as f64);
            prop_assert!(thinned.windows(2).all(|pair| pair[0].time_ns <= pair[1].time_ns));
        }
    }
}
