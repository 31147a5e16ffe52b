//! Law of power over speed: what holds on a stretch of the path.

/// Dependence of power on speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// The same at every speed (M3).
    #[default]
    Constant,
    /// In proportion to the speed (M4).
    BySpeed,
    /// Constant power that fades with the speed, as the machine comes to rest for a hold or speeds up again.
    Fading,
}

/// Power on a stretch of the path, before any override of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Law {
    /// Share of full power, in 1/65535.
    pub level: u16,
    /// Dependence on the speed.
    pub kind: Kind,
    /// The speed counts every axis, not only X, Y and Z.
    pub all_axes: bool,
    /// Speed at which the power is `level`, mm/s. Means nothing for constant power.
    pub reference: f32,
}

impl Law {
    /// No power at any speed.
    pub const OFF: Self = Self { level: 0, kind: Kind::Constant, all_axes: false, reference: 0.0 };

    /// Returns the power at this speed, mm/s: 1 is full power, and there may be more.
    #[must_use]
    pub fn power(&self, speed: f64) -> f32 {
        let level = f32::from(self.level) * (1.0 / 65_535.0);
        let share = if self.reference > 0.0 { speed as f32 / self.reference } else { 1.0 };
        match self.kind {
            Kind::Constant => level,
            Kind::BySpeed => level * share,
            Kind::Fading if share < 1.0 => level * share,
            Kind::Fading => level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_follows_the_speed_as_its_law_says() {
        let at = |kind, speed: f64| Law { level: 32_768, kind, all_axes: false, reference: 100.0 }.power(speed);
        let about = |power: f32, wanted: f32| (power - wanted).abs() < 1e-4;
        assert!(about(at(Kind::Constant, 10.0), 0.5) && about(at(Kind::Constant, 400.0), 0.5));
        assert!(about(at(Kind::BySpeed, 10.0), 0.05) && about(at(Kind::BySpeed, 400.0), 2.0));
        assert!(about(at(Kind::Fading, 10.0), 0.05) && about(at(Kind::Fading, 400.0), 0.5));
        assert_eq!(Law::OFF.power(100.0), 0.0);
    }
}
