//! Rule of a fan that runs by itself: its power from temperatures, heaters and motors.

use config::{FanConfig, FanFollows};
use units::{Celsius, Micros};

/// Present state of what a fan can follow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facts {
    /// Highest reading of the sensors that the fan watches; `None` if any of them gives none.
    pub warmest: Option<Celsius>,
    /// Whether any of the fan's heaters is asked to heat; any heater at all, if the fan watches none.
    pub heats: bool,
    /// Whether motors have current.
    pub motors: bool,
}

/// State of a rule between looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rule {
    on: bool,
    /// Time of the last reason to run.
    busy: Option<Micros>,
    /// Integral of the PID law, as a share of full power; its last reading and that reading's time.
    integral: f32,
    last: Option<(f32, Micros)>,
}

impl Rule {
    /// Returns the fan's share of full power, 0 to 1.
    pub fn share(&mut self, fan: &FanConfig, facts: Facts, now: Micros) -> f32 {
        match fan.follows {
            FanFollows::Codes => 0.0,
            FanFollows::Heaters => {
                // A heater that cannot be measured may be hot.
                let warm = facts.warmest.is_none_or(|reading| self.is_above(fan, reading));
                self.on = facts.heats || warm;
                if self.on { fan.speed } else { 0.0 }
            }
            FanFollows::Electronics => {
                if facts.motors || facts.heats {
                    self.busy = Some(now);
                    return fan.speed;
                }
                let lingers = self.busy.is_some_and(|busy| now.since(busy) < fan.linger);
                if lingers { fan.idle_speed } else { 0.0 }
            }
            FanFollows::Temperature => match facts.warmest {
                None => fan.speed,
                Some(reading) if fan.control.pid => self.controlled(fan, reading, now),
                Some(reading) => {
                    self.on = self.is_above(fan, reading);
                    if self.on { fan.speed } else { fan.idle_speed }
                }
            },
        }
    }

    /// Returns whether the reading is above the threshold, with the former state as the hysteresis' memory.
    fn is_above(&self, fan: &FanConfig, reading: Celsius) -> bool {
        let (at, width) = (fan.temperature.0, fan.hysteresis.0);
        match fan.follows {
            FanFollows::Temperature => reading.0 >= if self.on { at - width } else { at + width },
            _ => reading.0 >= if self.on { at - width } else { at },
        }
    }

    /// Runs the PID law with the derivative of the reading; the integral is gathered only as far as the
    /// output reaches.
    fn controlled(&mut self, fan: &FanConfig, Celsius(reading): Celsius, now: Micros) -> f32 {
        let (least, most) = (fan.idle_speed.min(fan.speed), fan.speed);
        let error = reading - fan.temperature.0;
        let (mut slope, mut passed) = (0.0, 0.0);
        if let Some((last, at)) = self.last {
            passed = now.since(at).seconds() as f32;
            slope = if passed > 0.0 { (reading - last) / passed } else { 0.0 };
        }
        self.last = Some((reading, now));
        self.integral = units::within(self.integral + fan.control.i * error * passed, 0.0, most);
        units::within(fan.control.p * error + self.integral + fan.control.d * slope, least, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Micros = Micros::from_seconds(1);

    fn fan(follows: FanFollows) -> FanConfig {
        FanConfig {
            follows,
            temperature: Celsius(50.0),
            hysteresis: Celsius(2.0),
            speed: 0.8,
            idle_speed: 0.3,
            linger: Micros::from_seconds(30),
            ..FanConfig::default()
        }
    }

    fn reads(celsius: f32) -> Facts {
        Facts { warmest: Some(Celsius(celsius)), ..Facts::default() }
    }

    #[test]
    fn a_heater_s_fan_runs_until_it_is_cold_and_when_nobody_knows() {
        let fan = fan(FanFollows::Heaters);
        let mut rule = Rule::default();
        let course = [20.0, 49.0, 50.0, 200.0, 49.0, 48.5, 47.9, 49.0];
        let shares = course.map(|celsius| rule.share(&fan, reads(celsius), SECOND));
        assert_eq!(shares, [0.0, 0.0, 0.8, 0.8, 0.8, 0.8, 0.0, 0.0]);
        assert_eq!(rule.share(&fan, Facts { heats: true, ..reads(20.0) }, SECOND), 0.8);
        assert_eq!(rule.share(&fan, Facts::default(), SECOND), 0.8);
    }

    #[test]
    fn a_cabinet_s_fan_lingers() {
        let fan = fan(FanFollows::Electronics);
        let mut rule = Rule::default();
        let quiet = Facts::default();
        assert_eq!(rule.share(&fan, quiet, SECOND), 0.0, "nothing was on yet");
        assert_eq!(rule.share(&fan, Facts { motors: true, ..quiet }, SECOND), 0.8);
        assert_eq!(rule.share(&fan, quiet, Micros::from_seconds(30)), 0.3);
        assert_eq!(rule.share(&fan, quiet, Micros::from_seconds(31)), 0.0);
        assert_eq!(rule.share(&fan, Facts { heats: true, ..quiet }, Micros::from_seconds(40)), 0.8);
    }

    #[test]
    fn a_temperature_is_kept_by_on_and_off() {
        let fan = fan(FanFollows::Temperature);
        let mut rule = Rule::default();
        let course = [51.0, 52.0, 49.0, 48.0, 47.9, 51.9];
        assert_eq!(course.map(|c| rule.share(&fan, reads(c), SECOND)), [0.3, 0.8, 0.8, 0.8, 0.3, 0.3]);
        assert_eq!(rule.share(&fan, Facts::default(), SECOND), 0.8, "a sensor that says nothing");
    }

    /// A box with a heat source: the law settles at the temperature, whatever the source's power.
    #[test]
    fn a_temperature_is_kept_by_as_much_as_it_takes() {
        let mut fan = fan(FanFollows::Temperature);
        (fan.control.pid, fan.control.p, fan.control.i) = (true, 0.1, 0.002);
        (fan.speed, fan.idle_speed) = (1.0, 0.1);
        for watts in [20.0_f32, 35.0] {
            let (mut rule, mut celsius) = (Rule::default(), 25.0_f32);
            for second in 0..3_000 {
                let share = rule.share(&fan, reads(celsius), Micros::from_seconds(second));
                assert!((0.1..=1.0).contains(&share));
                celsius += (watts - (0.4 + 1.6 * share) * (celsius - 25.0)) / 100.0;
            }
            assert!((celsius - 50.0).abs() < 0.5, "{watts} W: {celsius}");
        }
    }
}
