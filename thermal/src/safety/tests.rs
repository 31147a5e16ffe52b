//! Each law on made courses, and what passes to the pins.

use super::*;
use drivers::thermistor::{Curve, Divider, Thermistor};
use units::Ohms;

use crate::io::SensorReading;

fn sensor() -> Sensor {
    let r0 = Ohms(100_000.0);
    Sensor::Thermistor(Thermistor::new(Curve::from_beta(r0, Celsius(25.0), 4_066.0).unwrap(), Divider::PRIME, r0))
}

fn counts(celsius: f64) -> SensorReading {
    let ohms = 100_000.0 * (4_066.0 * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp();
    SensorReading::Counts((65_535.0 * ohms / (ohms + 4_700.0)).round() as u16)
}

fn limits() -> SafetyLimits {
    SafetyLimits {
        heats: true,
        full_share: 1.0,
        reading: ReadingLimits { min: Celsius(5.0), max: Celsius(280.0), rise_per_s: 30.0, fall_per_s: 15.0 },
        response: ResponseLimits {
            band: Celsius(5.0),
            gain: Celsius(2.0),
            within: Micros::from_seconds(20),
            sinking: 120.0,
        },
        course: CourseLimits {
            range: Celsius(20.0),
            heating_timeout: Micros::from_seconds(300),
            cooling_timeout: Micros::from_seconds(300),
            reached_within: Celsius(1.0),
        },
        time: TimeLimits::default(),
    }
}

/// Behaviour of a heater over time, s: its reading, its target, the share of time that its pin is on.
struct Course<'a> {
    reads: &'a dyn Fn(f64) -> SensorReading,
    target: &'a dyn Fn(f64) -> f32,
    driven: &'a dyn Fn(f64) -> f64,
}

/// Runs courses side by side, as control and pins would have them, for this many seconds; returns the first
/// fault and its time, s.
fn first(limits: SafetyLimits, courses: &[Course<'_>], seconds: u32) -> Option<(f64, HeatFault)> {
    let mut safety = HeatSafety::new();
    courses.iter().for_each(|_| assert!(safety.add(sensor(), limits)));
    (0..seconds * 100).find_map(|tick| {
        let second = f64::from(tick) / 100.0;
        for modulation in 0..20 {
            let on =
                courses.iter().enumerate().filter(|(_, course)| f64::from(modulation) < (course.driven)(second) * 20.0);
            let on = on.fold(0, |on, (index, _)| on | heater_bit(index));
            safety.pass(OutputLevels { on, fets_enabled: true });
        }
        let mut readings = SensorReadings::default();
        readings.iter_mut().zip(courses).for_each(|(reading, course)| *reading = (course.reads)(second));
        let now = Micros((second * 1e6) as u64 + 1);
        let target = |index: usize| courses.get(index).map_or(Celsius(0.0), |course| Celsius((course.target)(second)));
        safety.look(now, &readings, target).map(|fault| (second, fault))
    })
}

/// Finds the first fault of a heater, on at 200 C from the first second: fully driven for the minute that it
/// takes, then by a third.
fn heated(reads: impl Fn(f64) -> SensorReading) -> Option<(f64, HeatCause)> {
    held(reads, |_| 0.33)
}

/// The same as [`heated`], with its own share of output from the arrival on.
fn held(reads: impl Fn(f64) -> SensorReading, there: impl Fn(f64) -> f64) -> Option<(f64, HeatCause)> {
    let target = |second: f64| if second < 1.0 { 0.0 } else { 200.0 };
    let driven = |second: f64| match second {
        ..1.0 => 0.0,
        1.0..61.0 => 1.0,
        _ => there(second),
    };
    let found = first(limits(), &[Course { reads: &reads, target: &target, driven: &driven }], 400);
    found.map(|(second, fault)| (second, fault.cause))
}

/// Temperature that has been 200 C since 60 s, and warmed at 3 C/s before.
fn arrives(second: f64) -> f64 {
    (20.0 + 3.0 * (second - 1.0).max(0.0)).min(200.0)
}

#[test]
fn a_sensor_that_was_never_read_has_a_second_and_one_that_was_has_four_looks() {
    let silent = |second: f64| if second < 0.5 { counts(20.0) } else { SensorReading::Missing };
    let found = |reads: &dyn Fn(f64) -> SensorReading| heated(reads).unwrap();
    for (reads, from, to) in [
        (&(|_| SensorReading::Missing) as &dyn Fn(f64) -> SensorReading, 1.9, 2.1),
        (&silent, 1.1, 1.3),
        (&|_| SensorReading::Fault("open"), 1.1, 1.3),
    ] {
        let (second, cause) = found(reads);
        assert!((from..to).contains(&second) && matches!(cause, HeatCause::NoReading(_)), "{second}: {cause:?}");
    }
}

#[test]
fn a_heater_that_arrives_and_holds_is_left_alone() {
    assert_eq!(heated(|second| counts(arrives(second))), None);
}

#[test]
fn a_heater_that_does_not_warm_is_told_after_its_time_at_full_output() {
    let (second, cause) = held(|_| counts(20.0), |_| 1.0).unwrap();
    assert_eq!(cause, HeatCause::NoResponse(Micros::from_seconds(20), Celsius(2.0)));
    assert!((20.9..21.3).contains(&second), "{second}");
}

#[test]
fn half_the_output_is_half_the_effort() {
    let reads = |_: f64| counts(20.0);
    let course = Course { reads: &reads, target: &|_| 200.0, driven: &|_| 0.5 };
    let (second, _) = first(limits(), &[course], 400).unwrap();
    assert!((39.9..40.4).contains(&second), "{second}");
    // Half output is full output for a heater that is given no more.
    let course = Course { reads: &reads, target: &|_| 200.0, driven: &|_| 0.5 };
    let (second, _) = first(SafetyLimits { full_share: 0.5, ..limits() }, &[course], 400).unwrap();
    assert!((19.9..20.4).contains(&second), "{second}");
}

#[test]
fn a_sensor_that_comes_off_is_told_within_two_seconds() {
    // The sensor slips out: from 200 C at 100 s towards the air, 4 s to most of the fall.
    let slips = |second: f64| if second < 100.0 { 200.0 } else { 30.0 + 170.0 * (-(second - 100.0) / 4.0).exp() };
    let (second, cause) = heated(|second| counts(if second < 61.0 { arrives(second) } else { slips(second) })).unwrap();
    assert!(matches!(cause, HeatCause::FallsTooFast(_)), "{cause:?}");
    assert!(second < 102.0, "{second}");
}

#[test]
fn a_heater_that_fails_while_it_holds_is_told_before_it_has_lost_twenty_degrees() {
    let fails = |second: f64| 200.0 - 1.4 * (second - 100.0).max(0.0);
    let reads = |second: f64| counts(if second < 61.0 { arrives(second) } else { fails(second) });
    let driven = |second: f64| if second < 102.0 { 0.33 } else { 1.0 };
    let (second, cause) = held(reads, driven).unwrap();
    assert!(matches!(cause, HeatCause::FallsWhileDriven(_)), "{cause:?}");
    assert!(second < 112.0, "{second}");
    // A control law that does not notice the fault cannot hide it.
    let (second, cause) = heated(reads).unwrap();
    assert!(matches!(cause, HeatCause::Sinking(_)), "{cause:?}");
    assert!(second < 118.0, "{second}");
}

#[test]
fn full_output_in_vain_near_the_target_is_told() {
    // Three degrees below the target, and the reading rises no further.
    let reads = |second: f64| counts(if second < 100.0 { arrives(second) } else { 197.0 });
    let driven = |second: f64| if second < 100.0 { 0.33 } else { 1.0 };
    let (second, cause) = held(reads, driven).unwrap();
    assert_eq!(cause, HeatCause::NoResponse(Micros::from_seconds(20), Celsius(2.0)));
    assert!((119.9..120.4).contains(&second), "{second}");
}

#[test]
fn a_spike_is_forgiven_and_a_loose_contact_is_not() {
    let spike = |second: f64| if (100.0..100.2).contains(&second) { 260.0 } else { arrives(second) };
    assert_eq!(heated(|second| counts(spike(second))), None);
    let loose = |second: f64| {
        let shift = if second > 100.0 && ((second * 2.0) as u64).is_multiple_of(2) { 12.0 } else { 0.0 };
        arrives(second) - shift
    };
    let (second, cause) = heated(|second| counts(loose(second))).unwrap();
    assert_eq!(cause, HeatCause::Erratic);
    assert!(second < 110.0, "{second}");
}

#[test]
fn a_reading_that_leaps_upwards_is_no_temperature() {
    let leaps = |second: f64| if second < 30.0 { arrives(second) } else { (arrives(second) + 80.0).min(250.0) };
    let (second, cause) = heated(|second| counts(leaps(second))).unwrap();
    assert!(matches!(cause, HeatCause::RisesTooFast(_)) && second < 31.0, "{cause:?} at {second}");
}

#[test]
fn plugs_in_each_others_places_are_told_before_anything_is_hot() {
    let target = |second: f64| if second < 1.0 { 0.0 } else { 200.0 };
    let driven = |second: f64| if second < 1.0 { 0.0 } else { 1.0 };
    let cold = |_: f64| counts(20.0);
    let warms = |second: f64| counts(20.0 + 3.0 * (second - 2.0).max(0.0));
    let courses = [
        Course { reads: &cold, target: &target, driven: &driven },
        Course { reads: &warms, target: &|_| 0.0, driven: &|_| 0.0 },
    ];
    let (second, fault) = first(limits(), &courses, 100).unwrap();
    let other = HeaterId::all().nth(1).unwrap();
    assert_eq!(fault.cause, HeatCause::Swapped(other));
    assert!(second < 7.0, "{second}");
}

#[test]
fn a_pin_that_is_on_for_nobody_is_told_and_closed() {
    let reads = |_: f64| counts(20.0);
    let course = Course { reads: &reads, target: &|_| 0.0, driven: &|_| 0.3 };
    let (second, fault) = first(limits(), &[course], 10).unwrap();
    assert_eq!(fault.cause, HeatCause::DrivenWithoutTarget);
    assert!(second < 0.3, "{second}");
}

#[test]
fn time_limits_count_from_the_last_pause_and_from_the_target() {
    let time = TimeLimits { full: Micros::from_seconds(30), hold: Micros::from_seconds(100) };
    let warm = |second: f64| counts(20.0 + second.min(150.0));
    // A pause of a second every twenty seconds.
    let paused = |second: f64| if (second as u64) % 20 == 19 { 0.0 } else { 1.0 };
    let course = Course { reads: &warm, target: &|_| 200.0, driven: &paused };
    let (second, fault) = first(SafetyLimits { time, ..limits() }, &[course], 400).unwrap();
    assert_eq!(fault.cause, HeatCause::HeldTooLong(Micros::from_seconds(100)));
    assert!((100.0..100.2).contains(&second), "{second}");
    let course = Course { reads: &warm, target: &|second| 200.0 + second as f32 / 100.0, driven: &|_| 1.0 };
    let (second, fault) = first(SafetyLimits { time, ..limits() }, &[course], 400).unwrap();
    assert_eq!(fault.cause, HeatCause::FullTooLong(Micros::from_seconds(30)));
    assert!((30.0..30.2).contains(&second), "{second}");
    // Time spent cooling to a target does not count as held there.
    let cools = |second: f64| counts(60.0 - second / 50.0);
    let course = Course { reads: &cools, target: &|_| 30.0, driven: &|_| 0.0 };
    assert_eq!(first(SafetyLimits { time, ..limits() }, &[course], 400), None);
}

#[test]
fn what_was_found_closes_heaters_and_supply_until_it_is_released() {
    let mut safety = HeatSafety::new();
    assert!(safety.add(sensor(), limits()));
    let asked = OutputLevels { on: heater_bit(0) | 1 << 9, fets_enabled: true };
    assert_eq!(safety.pass(asked), asked);
    safety.trip();
    assert_eq!(safety.pass(asked), OutputLevels { on: 1 << 9, fets_enabled: false });
    safety.release();
    assert_eq!(safety.pass(asked), asked);
}

/// Returns the reading of a sensor that is noisy by a twentieth of a degree and stands from this second on.
fn stands_from(second: f64, at: f64, celsius: impl Fn(f64) -> f64) -> SensorReading {
    let noise = 0.05 * ((second * 97.0).sin() + (second * 41.0).cos());
    counts(if second < at { celsius(second) + noise } else { celsius(at) })
}

fn warming(second: f64) -> f64 {
    (22.0 + 3.0 * (second - 1.0).max(0.0)).min(200.0)
}

#[test]
fn a_reading_that_stands_while_the_output_changes_is_nobodys() {
    // Control sees a difference that never goes, and gives more and more output.
    let (second, cause) =
        held(|second| stands_from(second, 100.0, warming), |second| 0.33 + 0.002 * (second - 100.0).max(0.0)).unwrap();
    assert!(matches!(cause, HeatCause::Frozen(_)), "{cause:?}");
    assert!((140.0..170.0).contains(&second), "{second}");
    // Control sees the difference, and gives less and less output.
    let less = held(|second| stands_from(second, 100.0, warming), |second| 0.33 - 0.003 * (second - 100.0).max(0.0));
    assert!(matches!(less, Some((_, HeatCause::Frozen(_)))), "{less:?}");
    // No output at all: a hot heater must cool.
    let off = held(|second| stands_from(second, 100.0, warming), |second| if second < 100.0 { 0.33 } else { 0.0 });
    assert!(matches!(off, Some((_, HeatCause::Frozen(_)))), "{off:?}");
}

#[test]
fn a_reading_may_stand_as_long_as_its_output_does() {
    assert_eq!(held(|second| stands_from(second, 100.0, warming), |_| 0.33), None);
    // A sensor of coarse steps proves nothing.
    let coarse = |second: f64| counts((warming(second) * 4.0).round() / 4.0);
    assert_eq!(held(coarse, |second| if second < 100.0 { 0.33 } else { 0.45 }), None);
}
