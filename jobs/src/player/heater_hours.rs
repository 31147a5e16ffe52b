//! Times that heaters were on, and times at full power for the same heat.

use core::fmt::Write as _;

use base::ports::MAX_HEATERS;
use config::Name;
use heapless::{String, Vec};
use thermal::Work;

/// Time on after which the hours are saved, s, also while heaters stay on.
const SAVED_EACH_S: f64 = 3_600.0;
/// Bytes of a line of the file: a name, a key and a figure.
pub const LINE: usize = 64;

/// Work of one heater.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaterTime {
    /// Name of the heater in the configuration.
    pub name: Name,
    /// Time with a target, s.
    pub on_s: f64,
    /// Time at full power that gives the same heat, s.
    pub full_s: f64,
}

/// Work of all heaters. Heaters that the configuration knows no more are kept as long as there is room.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeaterHours {
    kept: Vec<HeaterTime, { 2 * MAX_HEATERS }>,
    unsaved_s: f64,
    heats: bool,
}

impl HeaterHours {
    /// Returns the work of each heater.
    pub const fn all(&self) -> &Vec<HeaterTime, { 2 * MAX_HEATERS }> {
        &self.kept
    }

    /// Adds a heater's work since it was asked last.
    pub fn add(&mut self, name: &str, work: Work) {
        if work == Work::NONE {
            return;
        }
        let on_s = work.on.0 as f64 / 1e6;
        self.unsaved_s += on_s;
        if let Some(time) = self.entry(name) {
            time.on_s += on_s;
            time.full_s += f64::from(work.full_s);
        }
    }

    /// Sets whether some heater is on now.
    pub const fn heats(&mut self, heats: bool) {
        self.heats = heats;
    }

    /// Whether the hours are worth a write: heating has ended, or has gone on for an hour. Asked once.
    pub fn take_unsaved(&mut self) -> bool {
        let worth_it = self.unsaved_s > if self.heats { SAVED_EACH_S } else { 0.0 };
        if worth_it {
            self.unsaved_s = 0.0;
        }
        worth_it
    }

    /// Reads a line of the file; false when the key is not a heater's.
    pub fn read(&mut self, key: &str, value: f64) -> bool {
        let Some(key) = key.strip_prefix("heater_") else { return false };
        let (name, is_full) = match (key.strip_suffix("_on_s"), key.strip_suffix("_full_s")) {
            (Some(name), _) => (name, false),
            (None, Some(name)) => (name, true),
            (None, None) => return false,
        };
        let Some(time) = self.entry(name) else { return false };
        *(if is_full { &mut time.full_s } else { &mut time.on_s }) = value;
        true
    }

    /// Returns the lines of the file.
    pub fn lines(&self) -> impl Iterator<Item = String<{ 2 * LINE }>> {
        self.kept.iter().map(|HeaterTime { name, on_s, full_s }| {
            let mut text = String::new();
            // The text of two lines holds a name of 24 and figures of a hundred years.
            let _ = writeln!(text, "heater_{name}_on_s = {on_s:.0}\nheater_{name}_full_s = {full_s:.0}");
            text
        })
    }

    fn entry(&mut self, name: &str) -> Option<&mut HeaterTime> {
        let place = match self.kept.iter().position(|time| time.name == name) {
            Some(place) => place,
            None => {
                let name = Name::try_from(name).ok().filter(|name| !name.is_empty())?;
                self.kept.push(HeaterTime { name, on_s: 0.0, full_s: 0.0 }).ok()?;
                self.kept.len() - 1
            }
        };
        self.kept.get_mut(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::Micros;

    fn second(full_s: f32) -> Work {
        Work { on: Micros::from_seconds(1), full_s }
    }

    #[test]
    fn work_is_added_up_by_name() {
        let mut hours = HeaterHours::default();
        (0..10).for_each(|_| hours.add("hotend", second(0.25)));
        hours.add("bed", second(1.0));
        hours.add("chamber", Work::NONE);
        let told: std::vec::Vec<_> =
            hours.all().iter().map(|time| (time.name.as_str(), time.on_s, time.full_s)).collect();
        assert_eq!(told, [("hotend", 10.0, 2.5), ("bed", 1.0, 1.0)]);
    }

    #[test]
    fn it_is_saved_when_heating_ends_and_every_hour() {
        let mut hours = HeaterHours::default();
        assert!(!hours.take_unsaved(), "nothing was done");
        hours.heats(true);
        hours.add("bed", second(1.0));
        assert!(!hours.take_unsaved());
        hours.heats(false);
        assert!(hours.take_unsaved() && !hours.take_unsaved());
        hours.heats(true);
        (0..=3_600).for_each(|_| hours.add("bed", second(1.0)));
        assert!(hours.take_unsaved() && !hours.take_unsaved());
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            times in proptest::collection::vec(("[a-z_][a-z0-9_]{0,22}", 0..9_999_999_999_u64, 0..9_999_999_999_u64), 0..4),
        ) {
            let mut hours = HeaterHours::default();
            for (name, on, full) in &times {
                let keys = [std::format!("heater_{name}_on_s"), std::format!("heater_{name}_full_s")];
                prop_assert!(hours.read(&keys[0], *on as f64) && hours.read(&keys[1], *full as f64));
            }
            let mut again = HeaterHours::default();
            for line in hours.lines().flat_map(|text| text.lines().map(std::string::String::from).collect::<std::vec::Vec<_>>()) {
                let (key, value) = line.split_once(" = ").expect("a line");
                prop_assert!(again.read(key, value.parse().expect("a figure")));
            }
            prop_assert_eq!(again, hours);
        }
    }
}
