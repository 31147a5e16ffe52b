//! Abort of a job: `abort` and M524.

use base::Ports;
use base::failure::{Answer, Outcome};
use base::ports::MotionPort as _;
use base::safety::Event;
use base::sessions::Recipient;
use thermal::HeatControl;

use crate::machine::moments::{Features, Moments as _};
use crate::machine::program_io::OverrideHands as _;
use crate::machine::work_hands::JobHands;
use crate::machine::{Machine, ignored_codes, program_io, program_logs, suspend};

/// The machine for work that drops what is under way.
pub(crate) trait AbortHands<'c>: JobHands<'c> {
    /// Closes the logs of the program, and lets overrides count again that it has put aside.
    fn end_program(&mut self);

    /// Has features act as the job ends before its time.
    fn job_ends(&mut self);

    /// Drops changes of outputs and lights that wait for their place on the path.
    fn drop_changes(&mut self);
}

impl<'c, P: Ports> AbortHands<'c> for Machine<'c, P> {
    fn end_program(&mut self) {
        program_logs::close(&mut self.logs, &mut self.world);
        program_io::overrides_count_again(self.overrides());
        self.program.end_program();
    }

    fn job_ends(&mut self) {
        Features::<P>::job_ends(self, false, Recipient::Nobody);
    }

    fn drop_changes(&mut self) {
        self.outputs.changes_were_dropped();
        self.world.ports.heat(HeatControl::drop_effects);
        Features::<P>::drop_effects(self);
    }
}

/// Aborts the job (`abort`, M524): brakes, drops queued moves, closes the file. Heaters are left alone.
pub(crate) fn abort<'c>(hands: &mut impl AbortHands<'c>, to: Recipient) -> Outcome {
    hands.apply(Event::Unsuspend);
    let suspended = hands.jobs().cancel_suspend();
    if suspended || hands.jobs().is_open() {
        hands.world().sessions.tell_hosts("cancel", to);
    }
    if suspended {
        hands.say(to, format_args!("Suspend cleared\n"));
    }
    let (jobs, world) = hands.jobs_in_world();
    ignored_codes::say(jobs, world.sessions);
    if hands.jobs().is_open() {
        hands.end_program();
    }
    hands.job_ends();
    let (jobs, world) = hands.jobs_in_world();
    if !jobs.close(&mut world.ports) {
        if !suspended {
            hands.say(to, format_args!("Not currently playing\n"));
        }
        return Ok(Answer::Ok);
    }
    program::objects::leave_out(hands.program(), false);
    program::objects::stand_here(hands.program());
    // A drilling cycle of the aborted file must not apply to words typed from now on.
    hands.program().end_cycles();
    hands.say(to, format_args!("Please wait for abort to complete. Turn any heaters off manually\n"));
    drop_queued(hands);
    // A halt meanwhile has dropped everything too.
    let _ = hands.standstill();
    hands.resynchronise();
    if !hands.is_halted() {
        let script = &hands.world().config.player.after_abort_gcode;
        suspend::start_unless_empty(hands.frames(), script);
    }
    Ok(Answer::Ok)
}

/// Brakes the motors, and drops all that is queued.
pub(crate) fn drop_queued<'c>(hands: &mut impl AbortHands<'c>) {
    hands.world().ports.motion(motion::Motion::stop);
    hands.drop_changes();
}
