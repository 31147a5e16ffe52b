//! Suspending a job and going on with it, replaying saved settings, and running what they start: the frames.

use gcode::LineBuffer;
use heapless::Vec;
use program::Part;
use units::{Celsius, HeaterId};

use super::frames::{Frame, Replay, Then};
use super::{Hands, Machine};
use crate::failure::{Answer, Failure, Outcome};
use crate::files::{Path, safe_file};
use crate::heat_codes;
use crate::jobs::Suspended;
use crate::needs::needs;
use crate::ports::{OpenMode, Ports, StorageError};
use crate::safety::Event;
use crate::sessions::Recipient;

/// M600 and `suspend`: pauses the job, so that a person can work at the machine.
pub(super) async fn suspend<P: Ports>(machine: &mut Machine<'_, P>, heaters_stay: bool, to: Recipient) -> Outcome {
    if machine.jobs.is_suspended() {
        machine.say(to, format_args!("Already suspended\n"));
        return Ok(Answer::Ok);
    }
    needs(machine.config, Part::Player, machine.jobs.is_playing())?;
    machine.announce(format_args!("// Suspending print, waiting for queue to empty...\n"));
    if !machine.jobs.set_paused(true) {
        machine.announce(format_args!("// action:pause\n"));
    }
    // Its sender stops when he has his answer, and the file has stopped already.
    machine.say(to, format_args!("ok\n"));
    machine.announce(format_args!("// Waiting for queue to empty (Host must stop sending)...\n"));
    machine.standstill().await?;
    machine.announce(format_args!("// Saving current state...\n"));
    let targets = machine.ports.heat(|heat| {
        let mut targets = [Celsius(0.0); units::MAX_HEATERS];
        targets.iter_mut().zip(heat.heaters()).for_each(|(target, (_, heater))| *target = heater.target());
        targets
    });
    let position = machine.ports.motion(|motion| motion.commanded_position());
    let kept = machine.program.keep();
    machine.jobs.suspend(Suspended { position, kept, targets });
    machine.safety.apply(Event::Suspend);
    let player = &machine.config.player;
    if !(heaters_stay || player.leave_heaters_on_suspend) {
        let now = machine.ports.now();
        // Off is never refused.
        for id in HeaterId::all() {
            let _ = machine.ports.heat(|heat| heat.set_target(id, Celsius(0.0), now));
        }
    }
    start_script(machine, player.after_suspend_gcode.as_str(), Then::Suspended).map(|_| Answer::Said)
}

/// M601 and `resume`: heats up again, then goes back and goes on.
pub(super) async fn resume<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    let Some(targets) = machine.jobs.suspended().map(|suspended| suspended.targets) else {
        machine.say(to, format_args!("Not suspended\n"));
        return Ok(Answer::Ok);
    };
    needs(machine.config, Part::Player, machine.jobs.is_playing())?;
    machine.announce(format_args!("// resuming print...\n"));
    let now = machine.ports.now();
    let heated = || HeaterId::all().zip(targets).filter(|(_, target)| target.0 > 0.0);
    for (id, target) in heated() {
        heat_codes::set_target(&mut machine.ports, machine.config, id, target, now)?;
    }
    if heated().next().is_some() {
        machine.announce(format_args!("// Waiting for heaters...\n"));
    }
    for (id, _) in heated() {
        heat_codes::wait_for_temperature(&mut Hands::new(machine, to), id).await?;
    }
    let script = machine.config.player.before_resume_gcode.as_str();
    if !script.is_empty() {
        machine.announce(format_args!("// Executing before resume gcode...\n"));
    }
    start_script(machine, script, Then::Resumed)
}

/// Runs a line of the configuration, and then what follows it.
pub(super) fn start_script<'c, P: Ports>(machine: &mut Machine<'c, P>, script: &'c str, then: Then) -> Outcome {
    let fits = machine.frames.push(Frame::Then(then)) && machine.frames.push(Frame::Script(script, 0));
    if fits { Ok(Answer::Ok) } else { Err(Failure::refused("scripts start each other without end")) }
}

/// Opens a file of saved settings, which is replayed before anything else is done.
pub(super) fn begin_replay<P: Ports>(
    machine: &mut Machine<'_, P>,
    path: &Path,
    asked: Recipient,
    by_load: bool,
) -> Result<(), StorageError> {
    safe_file::settle(&mut machine.ports, path)?;
    let file = machine.ports.open(path, OpenMode::Read)?;
    let replay = Replay {
        file,
        path: path.clone(),
        asked,
        by_load,
        inches: machine.program.count_in_mm(),
        gathering: LineBuffer::new(),
        chunk: Vec::new(),
        next: 0,
        at_end: false,
    };
    if machine.frames.push(Frame::Replay(replay)) { Ok(()) } else { Err(StorageError::TooManyOpen) }
}
