//! A fan: a rotor with inertia, and a tachometer.
//!
//! The speed follows the mean drive with a single time constant; below a tenth of full drive the fan does
//! not start, and below half of that it stops. The tachometer is a contact that is closed for half of each
//! pulse.

/// Constants of a fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Speed at full drive, turns a minute.
    pub rpm: f64,
    /// Time constant of the speed, seconds.
    pub time_constant_s: f64,
    /// Pulses of the tachometer in a turn.
    pub pulses_per_turn: f64,
}

impl Plant {
    /// Constants of a 40 mm fan.
    pub const SMALL: Self = Self { rpm: 6_000.0, time_constant_s: 0.4, pulses_per_turn: 2.0 };
}

/// Time over which pulses of modulation are averaged.
const SMOOTHED_OVER_S: f64 = 0.05;
/// Least drive from which a fan starts.
const STARTS: f64 = 0.1;
/// Share of its speed that a fan with dry bearings reaches.
const SLOW: f64 = 0.04;

/// Condition of a fan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// Fan without a fault.
    #[default]
    Sound,
    /// Fan whose rotor is held.
    Stopped,
    /// Fan that turns slowly at any drive.
    Slow,
}

/// State of a fan.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    plant: Plant,
    /// Mean drive: windings do not feel single pulses.
    drive: f64,
    /// Share of full speed.
    speed: f64,
    /// Tachometer pulses since power-on.
    pulses: f64,
    /// Fault of the fan, if any.
    pub condition: Condition,
}

impl Fan {
    /// Makes a fan that stands.
    #[must_use]
    pub const fn new(plant: Plant) -> Self {
        Self { plant, drive: 0.0, speed: 0.0, pulses: 0.0, condition: Condition::Sound }
    }

    /// Lets `seconds` pass with this mean drive.
    pub fn pass(&mut self, seconds: f64, drive: f64) {
        self.drive += (drive - self.drive) * (seconds / SMOOTHED_OVER_S).min(1.0);
        let drive = self.drive;
        let stands = self.speed < STARTS / 2.0;
        let turns = drive >= if stands { STARTS } else { STARTS / 2.0 };
        let reaches = match self.condition {
            Condition::Stopped => 0.0,
            _ if !turns => 0.0,
            Condition::Slow => drive * SLOW,
            Condition::Sound => drive,
        };
        self.speed += (reaches - self.speed) * (seconds / self.plant.time_constant_s).min(1.0);
        self.pulses += self.rpm() / 60.0 * self.plant.pulses_per_turn * seconds;
    }

    /// Returns the speed, turns a minute.
    #[must_use]
    pub fn rpm(&self) -> f64 {
        self.speed * self.plant.rpm
    }

    /// Returns whether the tachometer's contact is closed.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.pulses.fract() < 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(fan: &mut Fan, seconds: u32, drive: f64) -> u32 {
        let (mut pulses, mut closed) = (0, fan.is_closed());
        for _ in 0..seconds * 2_000 {
            fan.pass(0.000_5, drive);
            pulses += u32::from(fan.is_closed() && !closed);
            closed = fan.is_closed();
        }
        pulses
    }

    #[test]
    fn it_comes_to_its_speed_and_its_tachometer_says_so() {
        let mut fan = Fan::new(Plant::SMALL);
        turned(&mut fan, 3, 0.5);
        assert!((fan.rpm() - 3_000.0).abs() < 10.0, "{}", fan.rpm());
        assert!((99..=101).contains(&turned(&mut fan, 1, 0.5)));
        turned(&mut fan, 5, 0.0);
        assert!(fan.rpm() < 10.0);
    }

    #[test]
    fn it_needs_more_to_start_than_to_go_on() {
        let mut fan = Fan::new(Plant::SMALL);
        turned(&mut fan, 3, 0.07);
        assert!(fan.rpm() < 1.0);
        turned(&mut fan, 3, 1.0);
        turned(&mut fan, 5, 0.07);
        assert!(fan.rpm() > 400.0);
    }

    #[test]
    fn what_holds_it_stops_it() {
        let mut fan = Fan::new(Plant::SMALL);
        fan.condition = Condition::Slow;
        turned(&mut fan, 3, 1.0);
        assert!((100.0..300.0).contains(&fan.rpm()), "{}", fan.rpm());
        fan.condition = Condition::Stopped;
        turned(&mut fan, 5, 1.0);
        assert!(fan.rpm() < 1.0);
    }
}
