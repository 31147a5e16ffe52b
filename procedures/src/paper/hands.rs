//! The machine in the hands of a paper test.

use super::state::Paper;
use crate::probing::ProbeHands;

/// The machine in the hands of a paper test, which may go on with what a probe does.
pub trait PaperHands<'c>: ProbeHands<'c> {
    /// Returns the paper test that is under way.
    fn paper(&mut self) -> &mut Paper;
}
