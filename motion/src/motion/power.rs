//! Power of a laser along the trajectory.

use super::Motion;
use crate::{config::ConfigError, greatest, laser::LaserConfig, least};

impl Motion {
    /// Gives the machine a laser, or none. Without a laser the power of moves means nothing.
    ///
    /// # Errors
    /// [`ConfigError::Laser`] for what no laser can be like, [`ConfigError::Busy`] while something moves or is
    /// queued; nothing was changed then.
    pub fn configure_laser(&mut self, laser: Option<LaserConfig>) -> Result<(), ConfigError> {
        if !self.is_idle() {
            return Err(ConfigError::Busy);
        }
        if laser.is_some_and(|laser| !laser.is_valid()) {
            return Err(ConfigError::Laser);
        }
        self.laser.config = laser;
        Ok(())
    }

    /// Gives the laser the memory without which no change of power reaches the step queue. A motion object
    /// that makes no steps needs none.
    #[cfg(not(any(test, feature = "oracle")))]
    pub fn give_power_store(&mut self, store: &'static mut crate::laser::PowerStore) {
        self.laser.store = Some(store);
    }

    /// Scales the power of every move from the present place on; 1 is as programmed. What comes to more than
    /// full power is full power. Factors outside 0 to 10 are brought to the nearer of these.
    pub fn set_power_override(&mut self, factor: f32) {
        self.laser.factor_less_one = least(greatest(f64::from(factor), 0.0), 10.0) as f32 - 1.0;
    }

    /// Returns the factor on the power of every move.
    #[must_use]
    pub const fn power_override(&self) -> f32 {
        self.laser.factor()
    }
}
