//! State of the laser in the motion object.

use super::{LaserConfig, PowerStore};
use crate::elsewhere::Elsewhere;

/// A laser, if the machine has one.
#[derive(Debug)]
pub(crate) struct Laser {
    pub config: Option<LaserConfig>,
    /// Factor on every level, less one: at the start all bits are zero.
    pub factor_less_one: f32,
    /// Place of the levels along blocks and of the changes to come. A motion object that makes no steps has
    /// none.
    pub store: Option<Elsewhere<PowerStore>>,
}

impl Laser {
    /// No laser.
    pub const NONE: Self = Self { config: None, factor_less_one: 0.0, store: None };

    /// Factor on every level.
    pub const fn factor(&self) -> f32 {
        1.0 + self.factor_less_one
    }
}
