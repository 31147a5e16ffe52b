//! A limit switch or probe that a carriage operates.

use super::surface::TouchNoise;

/// Side of its position on which a switch is operated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Operated at and below the position.
    Below,
    /// Operated at and above the position.
    Above,
}

/// Fault of a switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// No fault of the switch.
    #[default]
    Sound,
    /// Switch that never operates.
    NeverOperates,
    /// Always reads as operated.
    AlwaysOperated,
    /// The contact opens again twice, for [`BOUNCES_NS`], when the switch is operated.
    Bounces,
}

/// Changes of a bouncing contact, nanoseconds after it first closes: open, closed, open, closed for good.
pub const BOUNCES_NS: [u64; 4] = [300_000, 700_000, 1_300_000, 2_200_000];

/// Switch at a position of a carriage.
#[derive(Clone, Copy, Debug)]
pub struct Switch {
    /// Position at which the switch operates, millimetres.
    pub position_mm: f64,
    /// Side on which the switch operates.
    pub side: Side,
    /// Fault of the switch, if any.
    pub fault: Fault,
    /// Standard deviation of the operating position from time to time, millimetres.
    pub noise_mm: f64,
    /// Deviation of the next operation.
    pub noise: TouchNoise,
}

impl Switch {
    /// Returns whether the switch is operated with the carriage here.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn switch(side: Side, fault: Fault) -> Switch {
        Switch { position_mm: 10.0, side, fault, noise_mm: 0.0, noise: TouchNoise::default() }
    }

    #[test]
    fn a_switch_is_operated_at_its_place_and_beyond_it() {
        for (side, below, above) in [(Side::Below, true, false), (Side::Above, false, true)] {
            let switch = switch(side, Fault::Sound);
            let operated = [9.999, 10.0, 10.001].map(|place| switch.operated(place));
            assert_eq!(operated, [below, true, above], "{side:?}");
        }
    }

    #[test]
    fn a_faulty_contact_does_not_see_the_carriage_and_a_bouncing_one_does() {
        let read = |fault| [0.0, 20.0].map(|place| switch(Side::Above, fault).operated(place));
        assert_eq!(read(Fault::NeverOperates), [false, false]);
        assert_eq!(read(Fault::AlwaysOperated), [true, true]);
        assert_eq!(read(Fault::Bounces), [false, true]);
    }
}
