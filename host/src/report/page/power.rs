//! The power of a laser as the page's data: along the path, and over time.

use serde::Serialize;

use super::super::path::{Corner, Kind, Samples};
use super::super::power::{Change, slots, thinned};

/// Greatest number of changes of power drawn on the path.
const MOST_CHANGES: usize = 40_000;

/// Power over time, percent of full power.
#[derive(Serialize)]
pub struct PowerData {
    time: Vec<f64>,
    mean: Vec<f64>,
    highest: Vec<f64>,
    /// Time for which the laser burned, seconds.
    on_seconds: f64,
}

/// Returns the power of a run of so many seconds over time, in so many points at most; none for a run
/// without.
pub fn data(changes: &[Change], seconds: f64, at_most: usize) -> Option<PowerData> {
    let slot_ns = ((seconds / at_most as f64).max(1e-3) * 1e9) as u64;
    let slots = slots(changes, slot_ns, (seconds * 1e9) as usize / slot_ns as usize + 1);
    let percent = |share: f64| (1e3 * share).round() / 10.0;
    let on_ns = changes.windows(2).filter(|pair| pair[0].duty > 0.0).map(|pair| pair[1].time_ns - pair[0].time_ns);
    (!changes.is_empty()).then(|| PowerData {
        time: (0..slots.len()).map(|index| (index as f64 * slot_ns as f64 * 1e-5).round() / 1e4).collect(),
        mean: slots.iter().map(|slot| percent(slot.mean)).collect(),
        highest: slots.iter().map(|slot| percent(slot.highest)).collect(),
        on_seconds: on_ns.sum::<u64>() as f64 * 1e-9,
    })
}

/// Returns the corners with one more at each change of power between two, and the power on the way to each:
/// work is what burns.
pub fn along(corners: &[Corner], samples: &Samples, changes: &[Change]) -> (Vec<Corner>, Vec<f64>) {
    let changes = thinned(changes, MOST_CHANGES);
    let mut next = changes.iter().peekable();
    let (mut along, mut powers, mut power) = (Vec::new(), Vec::new(), 0.0);
    let mut push = |corner: Corner, power: f64| {
        along.push(Corner { kind: if power > 0.0 { Kind::Work } else { Kind::Travel }, ..corner });
        powers.push(power);
    };
    let mut before: Option<&Corner> = None;
    for corner in corners {
        while let Some(change) = next.next_if(|change| change.time_ns as f64 * 1e-9 <= corner.time_s) {
            let time_s = change.time_ns as f64 * 1e-9;
            if let Some(before) = before.filter(|before| before.time_s < time_s && time_s < corner.time_s) {
                let share = (time_s - before.time_s) / (corner.time_s - before.time_s);
                let speed = before.speed + share * (corner.speed - before.speed);
                push(Corner { time_s, at: samples.at(time_s), speed, ..*corner }, power);
            }
            power = change.duty;
        }
        push(*corner, if before.is_some() { power } else { 0.0 });
        before = Some(corner);
    }
    (along, powers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_is_cut_where_the_power_changes() {
        let points = (0..=1_000).map(|n| [0.01 * f64::from(n), 0.0, 0.0, 0.0]).collect();
        let samples = Samples { period_s: 0.001, points };
        let corner =
            |time_s: f64| Corner { time_s, at: [10.0 * time_s, 0.0, 0.0], speed: 10.0, fed: 0.0, kind: Kind::Work };
        let change = |ms: u64, duty| Change { time_ns: ms * 1_000_000, duty };
        let changes = [change(0, 0.0), change(200, 0.5), change(250, 1.0), change(700, 0.0)];
        let (cut, powers) = along(&[corner(0.0), corner(0.5), corner(1.0)], &samples, &changes);
        let places: Vec<_> = cut.iter().map(|corner| (corner.at[0] * 1e3).round() / 1e3).collect();
        assert_eq!(places, [0.0, 2.0, 2.5, 5.0, 7.0, 10.0]);
        assert_eq!(powers, [0.0, 0.0, 0.5, 1.0, 1.0, 0.0]);
        let burns: Vec<_> = cut.iter().map(|corner| corner.kind == Kind::Work).collect();
        assert_eq!(burns, [false, false, true, true, true, false]);
    }
}
