//! Jobs that go on after a power cut: the journal of a job, and the way back from it.

pub(crate) mod job_recovery;
pub(crate) mod journal;
pub(crate) mod standing;

use base::Ports;
use base::sessions::Recipient;
use units::Micros;

use crate::machine::Machine;
use crate::machine::moments::{JobBegins, Moments};

/// The journal and the way back from it, at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn started(machine: &mut Machine<'_, P>, is_usable: bool) {
        if is_usable {
            job_recovery::say_offer(machine);
        }
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        journal::tick(machine, now);
    }

    fn session_line_begins(machine: &mut Machine<'_, P>) {
        journal::before_session(machine);
    }

    fn session_line_ends(machine: &mut Machine<'_, P>) {
        journal::after_session(machine);
    }

    fn job_begins(machine: &mut Machine<'_, P>, from: JobBegins) {
        match from {
            JobBegins::Whole => journal::begin(machine),
            // A journal that began in the middle of the file would lead nowhere.
            JobBegins::FurtherOn | JobBegins::Again => {}
            JobBegins::Elsewhere => journal::give_up_offer(machine),
        }
    }

    fn job_is_unreadable(machine: &mut Machine<'_, P>) {
        machine.features.journal.lose();
    }

    fn job_ends(machine: &mut Machine<'_, P>, _is_done: bool, _to: Recipient) {
        journal::end(machine);
    }

    fn leaves_for_heights(machine: &mut Machine<'_, P>, heights: [f64; 2]) {
        journal::leaves_height(machine, heights);
    }

    fn keeps_thermal_z(machine: &Machine<'_, P>) -> bool {
        machine.features.recovery.is_some()
    }

    fn objects_change(machine: &mut Machine<'_, P>) {
        journal::objects_change(machine);
    }

    fn job_is_dropped(machine: &mut Machine<'_, P>) {
        journal::halts(machine);
    }

    fn rests(machine: &mut Machine<'_, P>) {
        journal::stands(machine);
    }

    fn work_was_ended(machine: &mut Machine<'_, P>) {
        if machine.features.recovery.is_some() {
            job_recovery::give_up(machine);
        }
    }
}
