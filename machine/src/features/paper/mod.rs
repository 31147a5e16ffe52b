//! The paper test: Z is set by hand, with a sheet of paper under the nozzle. The test itself is
//! [`procedures::paper`].

use base::Ports;
use procedures::paper::{Paper, PaperHands};

use crate::machine::Machine;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;

/// The machine for the end of a paper test.
pub(crate) trait PaperEndHands<'c>: WorldHands<'c> {
    /// Returns the paper test that is under way.
    fn test(&mut self) -> &mut Paper;
}

impl<'c, P: Ports> PaperEndHands<'c> for Machine<'c, P> {
    fn test(&mut self) -> &mut Paper {
        &mut self.features.paper
    }
}

/// The paper test at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: PaperEndHands<'c>> Moments<M> for Feature {
    fn halts(hands: &mut M) {
        if hands.test().end() {
            hands.announce(format_args!("// NOTE the paper test has ended, nothing was changed\n"));
        }
    }
}

impl<'c, P: Ports> PaperHands<'c> for MachineHands<'_, 'c, P> {
    fn paper(&mut self) -> &mut Paper {
        &mut self.machine.features.paper
    }
}
