//! The features of the machine, a folder each, and the list of those that act at moments.
//!
//! A new feature is a folder, a line in `features!`, a field in [`States`] if it has a state, and a variant
//! of [`Step`] if its sequences wait on the frames. The order of the list is the order in which they act.
//! Beside the folders stand the tables that lead codes and console commands to features and to services.

pub(crate) mod automatic_outputs;
pub(crate) mod axis_tests;
pub(crate) mod brown_out;
pub(crate) mod commands;
pub(crate) mod door;
pub(crate) mod editing;
pub(crate) mod event_log;
pub(crate) mod filament;
pub(crate) mod file_commands;
pub(crate) mod file_functions;
pub(crate) mod forecast;
pub(crate) mod functions;
pub(crate) mod grbl;
pub(crate) mod laser;
pub(crate) mod lights;
pub(crate) mod macros;
pub(crate) mod network;
pub(crate) mod objects;
pub(crate) mod paper;
pub(crate) mod periodic_reports;
pub(crate) mod play_from;
pub(crate) mod power_loss;
pub(crate) mod report_functions;
pub(crate) mod setting_functions;
pub(crate) mod stalls;
pub(crate) mod state;
pub(crate) mod statistics;
pub(crate) mod update;
pub(crate) mod usb_disk;
pub(crate) mod viewers;

use base::Ports;
use base::failure::Failure;
use base::own_frame::apart;
use config::MachineConfig;

use printer_cfg::Memory;
use state::{States, Step};

use crate::machine::Machine;
use crate::machine::moments::Featured;

/// Makes the list of features, in the order in which they act.
macro_rules! features {
    ($last:ident $(,)?) => { $last::Feature };
    ($first:ident, $($rest:ident),+ $(,)?) => { ($first::Feature, features![$($rest),+]) };
}

/// All features that act at moments, in their order.
pub(crate) type List = features![
    usb_disk,
    grbl,
    event_log,
    power_loss,
    statistics,
    brown_out,
    laser,
    door,
    stalls,
    paper,
    objects,
    automatic_outputs,
    lights,
    filament,
    macros,
    update,
    forecast,
    periodic_reports,
    editing,
    network,
    viewers,
];

impl<P: Ports> Featured for P {
    type List = List;
    type States<'c> = States<'c>;
    type Step = Step;

    fn states<'c>(config: &MachineConfig, macros: Memory<'c>) -> States<'c> {
        States::new(config, macros)
    }

    fn go_on(machine: &mut Machine<'_, P>, step: Step) -> Result<(), Failure> {
        match step {
            Step::Recover(step, to) => apart(|| power_loss::job_recovery::go_on(machine, step, to)),
            Step::Stalled(step) => apart(|| stalls::recovery::go_on(machine, step)),
            Step::PlayFrom(to) => apart(|| play_from::go_on(machine, to)),
            Step::Macros { above } => macros::calls::go_on(machine, above),
        }
    }

    fn give_up(machine: &mut Machine<'_, P>, step: Step, why: Failure) {
        match step {
            // A recovery cannot go on from where the machine is.
            Step::Recover(..) if why.is_refusal() => power_loss::job_recovery::give_up(machine),
            Step::Macros { above } => apart(|| macros::calls::give_up(machine, above, why)),
            Step::Recover(..) | Step::Stalled(_) | Step::PlayFrom(_) => {}
        }
    }
}
