//! Tachometer: a fan's speed, and detection of a stopped fan.

use config::TachometerConfig;
use units::Micros;

/// Time over which pulses are counted: at 1,000 turns a minute and two pulses a turn a single pulse is 3 %.
const GATE: Micros = Micros::from_millis(1_000);

/// News of a look at a tachometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// The fan's state is unchanged.
    Nothing,
    /// The fan has stopped, or turns too slowly.
    Stopped,
    /// The fan turns again.
    Turns,
}

/// Tachometer of a single fan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tachometer {
    /// Start of the count under way: time and number of pulses.
    began: Option<(Micros, u16)>,
    rpm: f32,
    /// Time since which the fan has been driven and too slow.
    slow_since: Option<Micros>,
    /// Whether the stop has been reported.
    stopped: bool,
}

impl Tachometer {
    /// Returns the revolutions per minute over the last second.
    #[must_use]
    pub const fn rpm(&self) -> f32 {
        self.rpm
    }

    /// Returns whether the fan was driven and did not turn.
    #[must_use]
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Counts pulses and returns the news; looks may be any time apart. `pulses` are those since boot,
    /// counted modulo 2^16, and `driven` says whether the fan has power.
    pub fn look(&mut self, settings: &TachometerConfig, now: Micros, pulses: u16, driven: bool) -> Found {
        let (since, first) = *self.began.get_or_insert((now, pulses));
        let passed = now.since(since);
        if passed < GATE {
            return Found::Nothing;
        }
        let turns = f32::from(pulses.wrapping_sub(first)) / settings.pulses_per_turn.max(f32::MIN_POSITIVE);
        self.rpm = turns * 60.0 / passed.seconds() as f32;
        self.began = Some((now, pulses));
        self.judge(settings, now, driven)
    }

    fn judge(&mut self, settings: &TachometerConfig, now: Micros, driven: bool) -> Found {
        if !driven || settings.min_rpm <= 0.0 {
            // A fan without power may stand, so its speed says nothing.
            self.slow_since = None;
            return Found::Nothing;
        }
        if self.rpm >= settings.min_rpm {
            self.slow_since = None;
            return if core::mem::take(&mut self.stopped) { Found::Turns } else { Found::Nothing };
        }
        let since = *self.slow_since.get_or_insert(now);
        if self.stopped || now.since(since) < settings.stopped_after {
            return Found::Nothing;
        }
        self.stopped = true;
        Found::Stopped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: TachometerConfig = TachometerConfig {
        pin: None,
        pulses_per_turn: 2.0,
        min_rpm: 300.0,
        stopped_after: Micros::from_seconds(5),
        when_stopped: config::StoppedFan::Tell,
    };

    /// Looks ten times a second while the fan turns at `rpm`; returns the news and their times.
    fn turn(
        tachometer: &mut Tachometer,
        (from_s, to_s): (u64, u64),
        rpm: f64,
        driven: bool,
    ) -> std::vec::Vec<(u64, Found)> {
        let look = |tenth: u64| {
            // The count wraps around several times at 6,000 turns a minute.
            let pulses = (rpm / 60.0 * 2.0 * tenth as f64 / 10.0) as u64 as u16;
            (tenth / 10, tachometer.look(&SETTINGS, Micros::from_millis(tenth * 100), pulses, driven))
        };
        (from_s * 10..to_s * 10).map(look).filter(|(_, found)| *found != Found::Nothing).collect()
    }

    #[test]
    fn turns_are_counted_within_a_pulse_a_second() {
        for rpm in [0.0, 90.0, 1_000.0, 6_000.0, 24_000.0] {
            let mut tachometer = Tachometer::default();
            turn(&mut tachometer, (0, 400), rpm, true);
            assert!((f64::from(tachometer.rpm()) - rpm).abs() <= 30.5, "{rpm}: {}", tachometer.rpm());
        }
    }

    #[test]
    fn a_fan_that_stops_is_said_once_and_so_is_that_it_turns_again() {
        let mut tachometer = Tachometer::default();
        assert_eq!(turn(&mut tachometer, (0, 20), 3_000.0, true), []);
        // The count begins anew with another speed: its first second would mix both speeds.
        tachometer.began = None;
        assert_eq!(turn(&mut tachometer, (20, 60), 0.0, true), [(26, Found::Stopped)]);
        assert!(tachometer.is_stopped());
        tachometer.began = None;
        assert_eq!(turn(&mut tachometer, (60, 80), 3_000.0, true), [(61, Found::Turns)]);
    }

    #[test]
    fn a_fan_without_power_or_on_its_way_up_is_no_stopped_fan() {
        let mut tachometer = Tachometer::default();
        assert_eq!(turn(&mut tachometer, (0, 100), 0.0, false), []);
        assert_eq!(turn(&mut tachometer, (100, 104), 0.0, true), []);
        tachometer.began = None;
        assert_eq!(turn(&mut tachometer, (104, 140), 3_000.0, true), []);
    }
}
