//! A small oven with a thermistor that tests can break.

use super::*;
use crate::PidGains;
use crate::io::{heater_bit, switch_bit};
use crate::safety::{CourseLimits, ResponseLimits, TimeLimits};
use drivers::thermistor::{Curve, Divider, Thermistor};
use units::Ohms;

fn thermistor() -> Thermistor {
    let r0 = Ohms(100_000.0);
    Thermistor::new(Curve::from_beta(r0, Celsius(25.0), 4_066.0).unwrap(), Divider::PRIME, r0)
}

fn settings() -> HeaterSettings {
    let gains = PidGains {
        p: 10.0,
        i: 0.3,
        d: 200.0,
        i_max: 255.0,
        d_filter_s: 0.5,
        on_measurement: false,
        conditional_integral: true,
    };
    HeaterSettings {
        heats: true,
        sensor: Sensor::Thermistor(thermistor()),
        law: LawSettings::Pid(gains),
        max_duty: Duty::FULL,
        cycle: Micros(0),
        min: Celsius(0.0),
        max: Celsius(260.0),
        change_per_s: [30.0, 15.0],
        response: ResponseLimits {
            band: Celsius(5.0),
            gain: Celsius(2.0),
            within: Micros::from_seconds(20),
            sinking: 120.0,
        },
        time: TimeLimits::default(),
        course: CourseLimits {
            range: Celsius(20.0),
            heating_timeout: Micros::from_seconds(120),
            cooling_timeout: Micros::from_seconds(120),
            reached_within: Celsius(1.0),
        },
        period: Micros::from_millis(50),
        filter_s: 0.0,
        fan: None,
        melts_for: None,
    }
}

/// Counts of the thermistor at a temperature, from the beta equation solved for resistance.
fn counts(celsius: f64) -> SensorReading {
    let ohms = 100_000.0 * (4_066.0 * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp();
    SensorReading::Counts((65_535.0 * ohms / (ohms + 4_700.0)).round() as u16)
}

struct Oven {
    control: HeatControl,
    block: HeaterId,
    celsius: f64,
    /// Temperature at the thermistor: the block's, 3 s late.
    felt: f64,
    now: Micros,
    executor_lives: bool,
}

impl Oven {
    fn new() -> Self {
        let mut control = HeatControl::new();
        let block = control.add(settings()).unwrap();
        control.enable_outputs();
        Self { control, block, celsius: 22.0, felt: 22.0, now: Micros(0), executor_lives: true }
    }

    /// Runs 10 ms: one control tick, twenty modulation ticks; `sensor` says what the thermistor shows.
    fn step(&mut self, sensor: impl Fn(f64) -> SensorReading) -> u32 {
        self.now = self.now.plus(Micros::from_millis(10));
        if self.executor_lives {
            self.control.executor_alive(self.now);
        }
        let mut readings = SensorReadings::default();
        readings[0] = sensor(self.felt);
        self.control.tick(self.now, &readings);
        let on = (0..20).filter(|_| self.is_heating()).count() as u32;
        self.celsius += (f64::from(on) / 20.0 * 4.0 - (self.celsius - 22.0) / 120.0) * 0.01;
        self.felt += (self.celsius - self.felt) / 3.0 * 0.01;
        on
    }

    fn is_heating(&mut self) -> bool {
        let levels = self.control.modulation_tick();
        levels.fets_enabled && levels.on & heater_bit(0) != 0
    }

    fn run(&mut self, seconds: f64, sensor: impl Fn(f64) -> SensorReading) {
        for _ in 0..(seconds * 100.0) as u32 {
            self.step(&sensor);
        }
    }
}

#[test]
fn a_sound_heater_reaches_and_holds_its_target() {
    let mut oven = Oven::new();
    assert_eq!(oven.control.set_target(oven.block, Celsius(200.0)), Ok(()));
    oven.run(900.0, counts);
    assert_eq!(oven.control.take_fault(), None);
    assert!((oven.celsius - 200.0).abs() < 1.5, "{}", oven.celsius);
}

#[test]
fn an_unbelievable_reading_turns_the_heater_off_with_that_very_sample() {
    for broken in [SensorReading::Counts(65_535), SensorReading::Counts(0), SensorReading::Missing, counts(300.0)] {
        let mut oven = Oven::new();
        oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
        oven.run(5.0, counts);
        assert!(oven.step(counts) > 0);
        oven.run(0.05, |_| broken);
        assert_eq!(oven.step(|_| broken), 0, "{broken:?}");
        oven.run(1.0, |_| broken);
        assert!(oven.control.take_fault().is_some(), "{broken:?} must halt within a second");
        assert!(oven.control.is_halted());
    }
}

#[test]
fn one_disturbed_sample_costs_a_sample_of_heat_but_no_halt() {
    let mut oven = Oven::new();
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    oven.run(5.0, counts);
    oven.run(0.05, |_| SensorReading::Missing);
    oven.run(300.0, counts);
    assert_eq!(oven.control.take_fault(), None);
}

#[test]
fn a_dead_executor_cools_the_machine() {
    let mut oven = Oven::new();
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    oven.run(20.0, counts);
    oven.executor_lives = false;
    oven.run(9.0, counts);
    assert_eq!(oven.control.take_fault(), None);
    oven.run(2.0, counts);
    let cause = HeatCause::ExecutorSilent;
    assert_eq!(oven.control.take_fault(), Some(HeatFault { heater: oven.block, cause }));
    assert_eq!(oven.step(counts), 0);
}

#[test]
fn a_stalled_control_tick_switches_heaters_off_but_leaves_fans_turning() {
    let mut oven = Oven::new();
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    oven.control.set_switch(2, Duty::FULL);
    oven.run(5.0, counts);
    for _ in 0..=STALE_MODULATION_TICKS {
        oven.control.modulation_tick();
    }
    let levels = oven.control.modulation_tick();
    assert_eq!(levels.on, switch_bit(2));
}

#[test]
fn a_halt_closes_the_output_stage_and_refuses_targets_until_released() {
    let mut oven = Oven::new();
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    oven.run(5.0, counts);
    oven.control.halt();
    assert_eq!(oven.control.modulation_tick(), OutputLevels { on: 0, fets_enabled: false });
    oven.control.set_target(oven.block, Celsius(100.0)).unwrap();
    assert!(!oven.control.any_on());
    oven.control.release();
    oven.run(5.0, counts);
    assert!(!oven.control.any_on(), "a released machine does not heat by itself");
    assert!(oven.control.modulation_tick().fets_enabled);
}

#[test]
fn a_target_above_the_maximum_is_refused_and_changes_nothing() {
    let mut oven = Oven::new();
    let target = |oven: &Oven| oven.control.heater(oven.block).map(Heater::target);
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    let refused = Err(TargetRefused::AboveMaximum(Celsius(260.0)));
    assert_eq!(oven.control.set_target(oven.block, Celsius(261.0)), refused);
    assert_eq!(target(&oven), Some(Celsius(200.0)));
    for nothing in [f32::NAN, -5.0, 2.0] {
        assert_eq!(oven.control.set_target(oven.block, Celsius(nothing)), Ok(()));
        assert_eq!(target(&oven), Some(Celsius(0.0)));
    }
}

#[test]
fn a_sensor_without_a_heater_cannot_be_asked_to_heat() {
    let mut oven = Oven::new();
    let sensor = oven.control.add(HeaterSettings { heats: false, ..settings() }).unwrap();
    assert_eq!(oven.control.set_target(sensor, Celsius(50.0)), Err(TargetRefused::HasNoHeater));
    assert_eq!(oven.control.set_target(sensor, Celsius(0.0)), Ok(()));
}

/// A shorted MOSFET: the oven is heated whatever the output says, as long as the supply is on.
fn short_circuited(oven: &mut Oven, seconds: u32) -> Option<(u32, HeatFault)> {
    (0..seconds * 100).find_map(|tick| {
        oven.step(counts);
        let supplied = oven.control.modulation_tick().fets_enabled;
        oven.celsius += if supplied { 0.04 } else { 0.0 };
        oven.control.take_fault().map(|fault| (tick / 100, fault))
    })
}

#[test]
fn a_heater_that_is_stuck_on_is_cut_off_idle_and_after_use() {
    // An oven that was never used, and an oven switched off at its target.
    for target in [0.0, 150.0] {
        let mut oven = Oven::new();
        oven.control.set_target(oven.block, Celsius(target)).unwrap();
        oven.run(400.0, counts);
        oven.control.set_target(oven.block, Celsius(0.0)).unwrap();
        let (second, fault) = short_circuited(&mut oven, 120).expect("it must be seen");
        assert!(
            matches!(fault, HeatFault { heater, cause: HeatCause::StuckOn(_) } if heater == oven.block),
            "{fault:?}"
        );
        assert!(second <= 30, "after {target} C only at {second} s");
        assert!(oven.control.is_halted() && !oven.control.modulation_tick().fets_enabled, "the supply must be cut");
    }
}

#[test]
fn a_heater_that_is_stuck_on_while_it_holds_a_target_is_cut_off() {
    let mut oven = Oven::new();
    oven.control.set_target(oven.block, Celsius(150.0)).unwrap();
    oven.run(400.0, counts);
    let (second, fault) = short_circuited(&mut oven, 120).expect("it must be seen");
    assert!(matches!(fault.cause, HeatCause::StuckOn(_) | HeatCause::Runaway(_)), "{fault:?}");
    assert!(second <= 30, "{second} s");
}

#[test]
fn a_halted_machine_goes_on_watching() {
    let mut oven = Oven::new();
    oven.control.halt();
    oven.run(10.0, counts);
    // The supply switch is shorted too.
    for _ in 0..60 * 100 {
        oven.celsius += 0.04;
        oven.step(counts);
    }
    assert!(matches!(oven.control.take_fault(), Some(HeatFault { cause: HeatCause::StuckOn(_), .. })));
}

#[test]
fn a_new_maximum_holds_at_once_and_only_for_a_heater_that_there_is() {
    let mut oven = Oven::new();
    assert!(!oven.control.set_maximum(HeaterId::all().nth(3).unwrap(), Celsius(90.0)));
    assert!(oven.control.set_maximum(oven.block, Celsius(90.0)));
    assert!(oven.control.set_target(oven.block, Celsius(91.0)).is_err());
    assert_eq!(oven.control.set_target(oven.block, Celsius(80.0)), Ok(()));
    oven.run(2.0, |_| counts(95.0));
    assert!(matches!(oven.control.take_fault().map(|fault| fault.cause), Some(HeatCause::AboveMaximum(_))));
}

#[test]
fn a_switch_gives_what_it_was_set_to() {
    let mut control = HeatControl::new();
    control.enable_outputs();
    assert_eq!((control.given(0), control.given(1)), (0.0, 0.0));
    control.set_switch(1, Duty(51));
    assert!((control.given(1) - 0.2).abs() < 1e-6 && control.given(0) == 0.0);
    control.set_pwm(0, 0.75);
    assert_eq!((control.given(0), control.take_pwm_change()), (0.75, Some((0, 0.75))));
    assert_eq!(control.take_pwm_change(), None);
}

#[test]
fn a_surplus_is_known_only_at_the_target_of_a_heater_with_a_model() {
    let model = crate::ModelSettings {
        power_w: 40.0,
        capacity: 10.0,
        loss: 10.0 / 120.0,
        fan_loss: 0.0,
        late_s: 3.0,
        filament_heat: 0.0,
    };
    let mut oven = Oven::new();
    oven.control = HeatControl::new();
    let settings = HeaterSettings { law: LawSettings::Model(model), ..settings() };
    oven.block = oven.control.add(settings).unwrap();
    oven.control.enable_outputs();
    let surplus = |oven: &Oven| oven.control.heater(oven.block).unwrap().surplus();
    assert_eq!(surplus(&oven), None, "off");
    oven.control.set_target(oven.block, Celsius(200.0)).unwrap();
    oven.run(20.0, counts);
    assert_eq!(surplus(&oven), None, "on its way");
    oven.run(400.0, counts);
    let found = surplus(&oven).expect("at its target");
    // The model's air is three degrees warmer than the oven's.
    assert!(found > 0.0 && found < 0.05, "{found}");
    oven.control.set_target(oven.block, Celsius(0.0)).unwrap();
    assert_eq!(surplus(&oven), None, "off again");
}
