//! Scale of a laser's power: which S is how much of full power.

use config::MachineConfig;
use motion::laser::{MOST_CURVE_POINTS, Power, PowerCurve};
use program::Move;
use units::{PowerLaw, STEP_CLOCK_HZ, within};

/// Scale of a laser's power, as codes change it (M452, M221, `$30`, `$31`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaserScale {
    /// The S of full power; 0 on a machine without a laser.
    pub most_s: f32,
    /// The S of the least power above zero: less has this power.
    pub least_s: f32,
    /// Factor of M221 on every power, less one.
    factor_less_one: f32,
    /// Levels of full power for an S; 0 without a laser.
    per_s: f32,
}

impl LaserScale {
    /// Takes the scale from the configuration.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let laser = &config.laser;
        if !laser.enable || laser.pwm_pin.is_none() {
            return Self::default();
        }
        let least_s = laser.minimum_power / laser.maximum_power.max(f32::EPSILON) * laser.maximum_s_value;
        let mut scale = Self { least_s, ..Self::default() };
        scale.set_most(laser.maximum_s_value);
        scale
    }

    /// Sets the S of full power.
    pub fn set_most(&mut self, s: f32) {
        self.most_s = s;
        self.settle();
    }

    /// Sets M221's factor on every power.
    pub fn set_factor(&mut self, factor: f32) {
        self.factor_less_one = factor - 1.0;
        self.settle();
    }

    /// Returns M221's factor on every power.
    #[must_use]
    pub fn factor(&self) -> f32 {
        1.0 + self.factor_less_one
    }

    fn settle(&mut self) {
        self.per_s = if self.most_s > 0.0 { f32::from(Power::FULL) * self.factor() / self.most_s } else { 0.0 };
    }

    /// Returns the level of an S, 1/65535 of full power: more than the scale is full power.
    #[must_use]
    #[inline]
    pub fn level(&self, s: f32) -> u16 {
        // Adding a half and cutting the fraction rounds to the nearest level; a cast stays within the range.
        (s * self.per_s + 0.5) as u16
    }

    /// Returns the power of a program's move. A dark one keeps the law of its neighbours: moves with
    /// different laws do not become one block, and a picture is mostly gaps.
    #[must_use]
    #[inline]
    pub fn power(&self, request: &Move) -> Power {
        Power { level: self.level(request.power), law: request.power_law }
    }

    /// Returns the power of a jog while this is the S of constant power: at most what the configuration
    /// allows.
    #[must_use]
    pub fn of_jog(&self, s: f32, config: &MachineConfig) -> Power {
        let most = config.laser.framing_power * f32::from(Power::FULL);
        match self.level(s).min(most as u16) {
            0 => Power::OFF,
            level => Power { level, law: PowerLaw::Constant },
        }
    }

    /// Returns the laser in motion's terms; `None` on a machine without one.
    #[must_use]
    pub fn in_motions_terms(&self, config: &MachineConfig) -> Option<motion::laser::LaserConfig> {
        let laser = &config.laser;
        let most = laser.maximum_power;
        (self.most_s > 0.0).then(|| motion::laser::LaserConfig {
            on_delay: ticks(laser.on_delay_us),
            off_delay: ticks(laser.off_delay_us),
            least: within(self.least_s / self.most_s, 0.0, 1.0) * most,
            most,
            curve: curve(config),
        })
    }
}

fn ticks(us: f64) -> i32 {
    (us * f64::from(STEP_CLOCK_HZ / 1_000_000)) as i32
}

fn curve(config: &MachineConfig) -> PowerCurve {
    const _: () = assert!(config::MAX_POWER_POINTS == MOST_CURVE_POINTS);
    let table = &config.laser.power_table;
    let mut curve = PowerCurve { count: table.len(), ..PowerCurve::default() };
    for (place, [duty, power]) in curve.points.iter_mut().zip(table) {
        *place = (*duty as f32, *power as f32);
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine(most_s: f32) -> MachineConfig {
        let mut config = MachineConfig::default();
        config.laser.enable = true;
        config.laser.pwm_pin = Some(config::PwmOutput { timer: 1, channel: 1 });
        (config.laser.maximum_s_value, config.laser.maximum_power) = (most_s, 0.8);
        config
    }

    #[test]
    fn s_is_a_share_of_the_scale_and_never_more_than_full() {
        let mut scale = LaserScale::new(&machine(1_000.0));
        assert_eq!([0.0, 500.0, 1_000.0, 5_000.0].map(|s| scale.level(s)), [0, 32_768, 65_535, 65_535]);
        scale.set_factor(0.5);
        assert_eq!([500.0, 1_000.0, 4_000.0].map(|s| scale.level(s)), [16_384, 32_768, 65_535]);
        assert_eq!(LaserScale::new(&MachineConfig::default()).level(1_000.0), 0, "there is no laser");
    }

    #[test]
    fn dark_moves_keep_the_law_of_their_neighbours() {
        let scale = LaserScale::new(&machine(1_000.0));
        let mut request = Move {
            target: units::PerAxis([0.0; units::MAX_AXES]),
            shape: program::Shape::Line { names_xy: true },
            rate: program::Rate::Feed(units::MmPerSecond(1.0)),
            power: 0.0,
            power_law: PowerLaw::BySpeed,
            corner: program::Corner::Sharp,
        };
        assert_eq!(scale.power(&request), Power { level: 0, law: PowerLaw::BySpeed });
        request.power = 1_000.0;
        assert_eq!(scale.power(&request), Power { level: Power::FULL, law: PowerLaw::BySpeed });
    }

    #[test]
    fn the_least_power_is_a_duty_of_motion() {
        let mut config = machine(255.0);
        (config.laser.minimum_power, config.laser.on_delay_us) = (0.2, 20.0);
        let of = LaserScale::new(&config).in_motions_terms(&config).expect("a laser");
        assert!((of.least - 0.2).abs() < 1e-6 && of.most == 0.8 && of.is_valid());
        assert_eq!((of.on_delay, of.off_delay), (4_000, 0));
        assert_eq!(LaserScale::default().in_motions_terms(&config), None);
    }
}
