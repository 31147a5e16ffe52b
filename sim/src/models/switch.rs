//! A limit switch or probe that a carriage operates.

use super::surface::TouchNoise;

/// On which side of its position the switch is operated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Operated at and below the position.
    Below,
    /// Operated at and above the position.
    Above,
}

/// What is wrong with the switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    #[default]
    Sound,
    /// Never operates.
    NeverOperates,
    /// Always reads as operated.
    AlwaysOperated,
    /// Its contact opens again twice, for [`BOUNCES_NS`], when it is operated.
    Bounces,
}

/// When a bouncing contact changes, nanoseconds after it first closes: open, closed, open, closed for good.
pub const BOUNCES_NS: [u64; 4] = [300_000, 700_000, 1_300_000, 2_200_000];

/// The switch.
#[derive(Clone, Copy, Debug)]
pub struct Switch {
    /// Where it operates, millimetres.
    pub position_mm: f64,
    /// Which way.
    pub side: Side,
    /// What is wrong with it.
    pub fault: Fault,
    /// Standard deviation of where it operates, from time to time, millimetres.
    pub noise_mm: f64,
    /// Of the next time.
    pub noise: TouchNoise,
}

impl Switch {
    /// Whether it is operated with the carriage here.
    #[must_use]
    pub fn operated(&self, carriage_mm: f64) -> bool {
        let position_mm = self.position_mm + self.noise.now_mm();
        match (self.fault, self.side) {
            (Fault::NeverOperates, _) => false,
            (Fault::AlwaysOperated, _) => true,
            (Fault::Sound | Fault::Bounces, Side::Below) => carriage_mm <= position_mm,
            (Fault::Sound | Fault::Bounces, Side::Above) => carriage_mm >= position_mm,
        }
    }
}
