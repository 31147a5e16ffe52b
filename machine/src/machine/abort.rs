//! Abort of a job: `abort` and M524.

use base::Ports;
use base::failure::{Answer, Outcome};
use base::safety::Event;
use base::sessions::Recipient;
use thermal::HeatControl;

use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, ignored_codes, program_io, program_logs, suspend};

/// Aborts the job (`abort`, M524): brakes, drops queued moves, closes the file. Heaters are left alone.
pub(crate) fn abort<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    machine.safety.apply(Event::Unsuspend);
    let suspended = machine.jobs.cancel_suspend();
    if suspended || machine.jobs.is_open() {
        machine.world.sessions.tell_hosts("cancel", to);
    }
    if suspended {
        machine.say(to, format_args!("Suspend cleared\n"));
    }
    ignored_codes::say(&mut machine.jobs, machine.world.sessions);
    if machine.jobs.is_open() {
        program_logs::close(&mut machine.logs, &mut machine.world);
        let Machine { world, program, outputs, hold, feed_waits, .. } = &mut *machine;
        program_io::overrides_count_again(&mut world.ports, program, outputs, hold, feed_waits);
        machine.program.end_program();
    }
    Features::<P>::job_ends(machine, false, Recipient::Nobody);
    if !machine.jobs.close(&mut machine.world.ports) {
        if !suspended {
            machine.say(to, format_args!("Not currently playing\n"));
        }
        return Ok(Answer::Ok);
    }
    program::objects::leave_out(&mut machine.program, false);
    program::objects::stand_here(&mut machine.program);
    // A drilling cycle of the aborted file must not apply to words typed from now on.
    machine.program.end_cycles();
    machine.say(to, format_args!("Please wait for abort to complete. Turn any heaters off manually\n"));
    drop_queued(machine);
    // A halt meanwhile has dropped everything too.
    let _ = machine.standstill();
    machine.resynchronise();
    if !machine.safety.is_halted() {
        suspend::start_unless_empty(&mut machine.frames, &machine.world.config.player.after_abort_gcode);
    }
    Ok(Answer::Ok)
}

/// Brakes the motors, and drops all that is queued.
pub(crate) fn drop_queued<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.outputs.changes_were_dropped();
    machine.world.ports.motion(motion::Motion::stop);
    machine.world.ports.heat(HeatControl::drop_effects);
    Features::<P>::drop_effects(machine);
}
