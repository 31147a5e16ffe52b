//! State of the paper test: its purpose, and its progress.

use base::bed::MOST_TWIST_POINTS;
use heapless::Vec;

use super::heights_tried::Tried;

/// The paper test under way, if any.
#[derive(Clone, Debug, Default)]
pub struct Paper {
    pub(super) test: Option<Test>,
}

#[derive(Clone, Debug)]
pub(super) struct Test {
    pub purpose: Purpose,
    pub tried: Tried,
}

impl Paper {
    /// Ends a test, as a halt does. Returns true when there was one.
    pub fn end(&mut self) -> bool {
        self.test.take().is_some()
    }
}

/// Purpose of a paper test.
#[derive(Clone, Debug)]
pub(super) enum Purpose {
    /// Height of the tool over the bed as the probe's contact closes: the contact closed at this height
    /// without leveling, mm.
    ProbeOffset { contact: f64 },
    /// Position at which Z homes.
    Endstop,
    /// A height, for a report of it.
    Height,
    /// Equal height of the bed over each screw.
    Screws(Walk),
    /// Change of the probe's offset along an axis.
    Twist(Along),
}

/// Screw that is tried, and number of screws in a row that were left as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Walk {
    pub screw: usize,
    pub accepted: usize,
}

impl Walk {
    /// Returns the state after ACCEPT, or ADJUSTED, of the present screw; `None` when every screw was
    /// accepted in a row.
    pub const fn after(self, turned: bool, count: usize) -> Option<Self> {
        // Turning a screw tilts the bed at the others.
        let accepted = if turned { 0 } else { self.accepted + 1 };
        if accepted >= count {
            return None;
        }
        Some(Self { screw: (self.screw + 1) % count, accepted })
    }
}

/// Progress of the measurement along the axis.
#[derive(Clone, Debug)]
pub(super) struct Along {
    /// Height of the tool as the probe touched at the present place, without leveling, mm.
    pub contact: f64,
    /// Offsets of the probe at the places before, mm.
    pub offsets: Vec<f64, MOST_TWIST_POINTS>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_ends_when_every_screw_was_left_in_a_row(turns in proptest::collection::vec(any::<bool>(), 0..40), count in 2..8_usize) {
            let mut walk = Some(Walk { screw: 0, accepted: 0 });
            let mut left = 0;
            for (n, turned) in turns.into_iter().chain([false; 8]).enumerate() {
                let Some(now) = walk else { break };
                prop_assert_eq!(now.screw, n % count);
                left = if turned { 0 } else { left + 1 };
                walk = now.after(turned, count);
                prop_assert_eq!(walk.is_none(), left == count);
            }
            prop_assert!(walk.is_none());
        }
    }
}
