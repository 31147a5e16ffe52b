//! The parameters of a geometry by their letters, as M665 sets and prints them.

use super::{Kinematics, LinearDelta, morgan, rotary_delta};

/// Parameters of a geometry at most.
const MOST: usize = 11;

/// Letters and values, in the order they are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    values: [(char, f64); MOST],
    count: usize,
}

impl Parameters {
    fn of<const N: usize>(given: [(char, f64); N]) -> Self {
        let mut values = [(' ', 0.0); MOST];
        values.iter_mut().zip(given).for_each(|(slot, value)| *slot = value);
        Self { values, count: N.min(MOST) }
    }

    /// Letter and value of each.
    pub fn iter(&self) -> impl Iterator<Item = (char, f64)> {
        self.values.into_iter().take(self.count)
    }

    /// Sets the one with this letter. False when there is none.
    pub fn set(&mut self, letter: char, value: f64) -> bool {
        let slot = self.values.iter_mut().take(self.count).find(|(known, _)| *known == letter);
        slot.map(|slot| slot.1 = value).is_some()
    }
}

impl Kinematics {
    /// Returns the parameters that M665 may change; none for kinematics without such parameters.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        match self {
            Self::LinearDelta(delta) => Parameters::of(delta.parameters()),
            Self::RotaryDelta(delta) => Parameters::of(rotary_delta::parameters(delta)),
            Self::Morgan(arm) => Parameters::of(morgan::parameters(arm)),
            _ => Parameters::default(),
        }
    }

    /// Returns the machine with these values of its [`Self::parameters`].
    #[must_use]
    pub fn with_parameters(&self, parameters: &Parameters) -> Self {
        let all = parameters.values.map(|(_, value)| value);
        let [a, b, c, d, e, f, g, h, ..] = all;
        match self {
            Self::LinearDelta(_) => Self::LinearDelta(LinearDelta::with_parameters(all)),
            Self::RotaryDelta(delta) => Self::RotaryDelta(rotary_delta::with_parameters(*delta, [a, b, c, d, e, f, g])),
            Self::Morgan(_) => Self::Morgan(morgan::with_parameters([a, b, c, d, e, f, g, h])),
            other => *other,
        }
    }
}
