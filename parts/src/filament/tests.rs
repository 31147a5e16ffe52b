use super::*;
use config::FilamentDetectorConfig;
use proptest::prelude::*;
use std::vec::Vec;

const SECOND: u64 = 1_000_000;

fn detector(wheel: bool) -> (MachineConfig, Tuning) {
    let pin = config::parse_pin("PB7").ok().flatten().and_then(config::PinName::digital);
    let filament = FilamentDetectorConfig {
        enable: true,
        encoder_pin: pin.filter(|_| wheel),
        detector_pin: pin.filter(|_| !wheel),
        check_every: Micros(2 * SECOND),
        pulses_per_mm: 1.0,
        suspends: true,
        ..FilamentDetectorConfig::default()
    };
    let config = MachineConfig { filament_detector: filament, ..MachineConfig::default() };
    let tuning = Tuning::new(&config);
    (config, tuning)
}

fn level(out: bool) -> InputLevels {
    if out { InputLevels::default().with(Input::Filament) } else { InputLevels::default() }
}

/// News of looks 10 ms apart: for each, whether filament is missing and what the machine does.
fn news(looks: &[(bool, Use)]) -> Vec<(usize, News)> {
    let (config, tuning) = detector(false);
    let mut filament = Filament::default();
    let mut all = Vec::new();
    for (place, (out, using)) in looks.iter().enumerate() {
        let now = Micros((place as u64 + 1) * 10_000);
        if let Some(news) = filament.look(level(*out), &config, &tuning, *using, || None, now) {
            all.push((place, news));
        }
    }
    all
}

fn looks(parts: &[(usize, bool, Use)]) -> Vec<(bool, Use)> {
    parts.iter().flat_map(|(count, out, using)| std::iter::repeat_n((*out, *using), *count)).collect()
}

#[test]
fn it_runs_out_once_in_each_state() {
    use News::{Noted, Suspends};
    use Trouble::RunOut;
    let of = |parts: &[(usize, bool, Use)]| news(&looks(parts)).into_iter().map(|(_, news)| news).collect::<Vec<_>>();
    assert_eq!(of(&[(20, false, Use::Plays)]), []);
    assert_eq!(of(&[(20, false, Use::Plays), (50, true, Use::Plays)]), [Suspends(RunOut)]);
    assert_eq!(of(&[(20, false, Use::Moves), (50, true, Use::Moves)]), [Suspends(RunOut)]);
    assert_eq!(of(&[(20, false, Use::Rests), (50, true, Use::Rests)]), [Noted(RunOut)]);
    assert_eq!(of(&[(20, false, Use::Idle), (50, true, Use::Idle)]), [Noted(RunOut)]);
    let begun_without = [(50, true, Use::Idle), (50, true, Use::Plays)];
    assert_eq!(of(&begun_without), [Noted(RunOut), Suspends(RunOut)], "a file is not begun without filament");
    let loaded = [(50, true, Use::Idle), (50, true, Use::Moves)];
    assert_eq!(of(&loaded), [Noted(RunOut)], "a person loads filament");
    let resumed = [(50, true, Use::Plays), (50, true, Use::Rests), (50, false, Use::Rests), (50, false, Use::Plays)];
    assert_eq!(of(&resumed), [Suspends(RunOut)]);
    let again = [&resumed[..], &[(50, true, Use::Plays)]].concat();
    assert_eq!(of(&again), [Suspends(RunOut), Suspends(RunOut)]);
    let went_on_without = [(50, true, Use::Plays), (50, true, Use::Rests), (50, true, Use::Plays)];
    assert_eq!(of(&went_on_without), [Suspends(RunOut), Suspends(RunOut)]);
}

#[test]
fn a_short_change_is_noise() {
    assert_eq!(news(&looks(&[(20, false, Use::Plays), (4, true, Use::Plays), (20, false, Use::Plays)])), []);
}

/// Returns whether a wheel of one pulse a millimetre finds stuck filament while the extruder moves by `ways`,
/// mm a second each, and filament follows by the share `follows`.
fn finds(ways: &[f64], follows: impl Fn(f64) -> f64) -> bool {
    let (config, tuning) = detector(true);
    let mut filament = Filament::default();
    let (mut place, mut now) = (0.0, Micros(0));
    let mut found = false;
    for way in ways {
        for _ in 0..100 {
            place += way / 100.0;
            now = now.plus(Micros(10_000));
            let high = follows(place).rem_euclid(1.0) < 0.5;
            let levels = if high { InputLevels::default().with(Input::FilamentWheel) } else { InputLevels::default() };
            filament.count(levels);
            let extruder = || Some((Axis::A, place));
            let news = filament.look(levels, &config, &tuning, Use::Plays, extruder, now);
            found |= news == Some(News::Suspends(Trouble::Stuck));
        }
    }
    found
}

#[test]
fn filament_that_stops_is_found_and_retractions_are_not() {
    assert!(finds(&[1.0; 20], |place| place.min(6.0)));
    assert!(finds(&[0.2; 60], |place| place.min(4.0)), "slowly too");
    let retracting: Vec<_> = [3.0, 2.0, -4.0, 4.0].repeat(10);
    assert!(!finds(&retracting, |place| place));
}

proptest! {
    /// Filament that follows its extruder never counts as stuck.
    #[test]
    fn filament_that_follows_is_never_stuck(ways in proptest::collection::vec(-8.0..8.0_f64, 1..60)) {
        prop_assert!(!finds(&ways, |place| place));
    }

    /// Filament that stands is found, once the extruder has pushed enough.
    #[test]
    fn filament_that_stands_is_found(ways in proptest::collection::vec(0.5..8.0_f64, 12..40)) {
        prop_assert!(finds(&ways, |_| 0.2));
    }
}

#[test]
fn the_command_of_a_missing_filament_waits_until_it_is_taken_once() {
    let (config, tuning) = detector(false);
    let mut filament = Filament::default();
    assert!(filament.line(&config).is_none() && filament.take_line(&config, &tuning).is_none());
    for look in 1..60 {
        filament.look(level(true), &config, &tuning, Use::Plays, || None, Micros(look * 10_000));
    }
    assert_eq!(filament.line(&config), Some("M600"));
    let command = filament.take_line(&config, &tuning).expect("a command");
    assert_eq!(command, if tuning.filament.leave_heaters_on { "M600.1" } else { "M600" });
    assert!(filament.line(&config).is_none());
}
