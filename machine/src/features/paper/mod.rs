//! The paper test: Z is set by hand, with a sheet of paper under the nozzle. The test itself is
//! [`procedures::paper`].

use base::Ports;
use procedures::paper::{Paper, PaperHands};

use crate::machine::Machine;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;

/// The paper test at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn halts(machine: &mut Machine<'_, P>) {
        if machine.features.paper.end() {
            machine.announce(format_args!("// NOTE the paper test has ended, nothing was changed\n"));
        }
    }
}

impl<'c, P: Ports> PaperHands<'c> for MachineHands<'_, 'c, P> {
    fn paper(&mut self) -> &mut Paper {
        &mut self.machine.features.paper
    }
}
