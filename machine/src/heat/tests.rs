//! A small oven with a thermistor that tests can break.

use super::guard::GuardSettings;
use super::law::PidGains;
use super::sensor::{Curve, Thermistor};
use super::*;
use crate::ports::{heater_bit, switch_bit};
use units::Ohms;

const THERMISTOR: Thermistor = Thermistor {
    curve: Curve::Beta(4_066.0),
    r0: Ohms(100_000.0),
    t0: Celsius(25.0),
    r1_parallel: Ohms(0.0),
    r2_pull_up: Ohms(4_700.0),
};

fn settings() -> HeaterSettings {
    let gains =
        PidGains { p: 10.0, i: 0.3, d: 200.0, i_max: 255.0, on_measurement: false, conditional_integral: false };
    HeaterSettings {
        heats: true,
        sensor: Sensor::Thermistor(THERMISTOR),
        law: LawSettings::Pid(gains),
        max_duty: Duty::FULL,
        min: Celsius(0.0),
        max: Celsius(260.0),
        guard: GuardSettings {
            range: Celsius(20.0),
            heating_timeout: Micros::from_seconds(120),
            cooling_timeout: Micros::from_seconds(120),
            reached_within: Celsius(1.0),
        },
        period: Micros::from_millis(50),
    }
}

/// Counts of the thermistor at a temperature, from the beta equation solved for resistance.
fn counts(celsius: f64) -> SensorReading {
    let ohms = 100_000.0 * (4_066.0 * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp();
    SensorReading::Counts((65_535.0 * ohms / (ohms + 4_700.0)).round() as u16)
}

struct Oven {
    control: HeatControl,
    celsius: f64,
    /// What the thermistor feels: the block, 3 s late.
    felt: f64,
    now: Micros,
    dispatcher_lives: bool,
}

impl Oven {
    fn new() -> Self {
        let mut control = HeatControl::new();
        assert!(control.add(settings()));
        control.enable_outputs();
        Self { control, celsius: 22.0, felt: 22.0, now: Micros(0), dispatcher_lives: true }
    }

    /// Runs 10 ms: one control tick, twenty modulation ticks; `sensor` says what the thermistor shows.
    fn step(&mut self, sensor: impl Fn(f64) -> SensorReading) -> u32 {
        self.now = self.now.plus(Micros::from_millis(10));
        if self.dispatcher_lives {
            self.control.dispatcher_alive(self.now);
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
    assert_eq!(oven.control.set_target(0, Celsius(200.0), oven.now), Some(Celsius(200.0)));
    oven.run(900.0, counts);
    assert_eq!(oven.control.take_fault(), None);
    assert!((oven.celsius - 200.0).abs() < 1.5, "{}", oven.celsius);
}

#[test]
fn an_unbelievable_reading_turns_the_heater_off_with_that_very_sample() {
    for broken in [SensorReading::Counts(65_535), SensorReading::Counts(0), SensorReading::Missing, counts(300.0)] {
        let mut oven = Oven::new();
        oven.control.set_target(0, Celsius(200.0), oven.now);
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
    oven.control.set_target(0, Celsius(200.0), oven.now);
    oven.run(5.0, counts);
    oven.run(0.05, |_| SensorReading::Missing);
    oven.run(300.0, counts);
    assert_eq!(oven.control.take_fault(), None);
}

#[test]
fn a_dead_dispatcher_cools_the_machine() {
    let mut oven = Oven::new();
    oven.control.set_target(0, Celsius(200.0), oven.now);
    oven.run(20.0, counts);
    oven.dispatcher_lives = false;
    oven.run(9.0, counts);
    assert_eq!(oven.control.take_fault(), None);
    oven.run(2.0, counts);
    let cause = HeatCause::DispatcherSilent;
    assert_eq!(oven.control.take_fault(), Some(HeatFault { heater: 0, cause }));
    assert_eq!(oven.step(counts), 0);
}

#[test]
fn a_stalled_control_tick_switches_heaters_off_but_leaves_fans_turning() {
    let mut oven = Oven::new();
    oven.control.set_target(0, Celsius(200.0), oven.now);
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
    oven.control.set_target(0, Celsius(200.0), oven.now);
    oven.run(5.0, counts);
    oven.control.halt();
    assert_eq!(oven.control.modulation_tick(), OutputLevels { on: 0, fets_enabled: false });
    assert_eq!(oven.control.set_target(0, Celsius(100.0), oven.now), Some(Celsius(0.0)));
    oven.control.release();
    oven.run(5.0, counts);
    assert!(!oven.control.any_on(), "a released machine does not heat by itself");
    assert!(oven.control.modulation_tick().fets_enabled);
}

#[test]
fn a_target_above_the_maximum_is_cut_and_said() {
    let mut oven = Oven::new();
    assert_eq!(oven.control.set_target(0, Celsius(500.0), oven.now), Some(Celsius(260.0)));
    assert_eq!(oven.control.set_target(0, Celsius(f32::NAN), oven.now), Some(Celsius(0.0)));
    assert_eq!(oven.control.set_target(0, Celsius(-5.0), oven.now), Some(Celsius(0.0)));
    assert_eq!(oven.control.set_target(7, Celsius(50.0), oven.now), None);
}
