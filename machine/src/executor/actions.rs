//! Carries out what the program says, one action at a time, and waits where it must.

use base::failure::{Answer, Failure, Outcome};
use base::needs::{failure_of, needs};
use base::sessions::Recipient;
use base::{Ports, World};
use gcode::Blocks;
use parts::heat_codes;
use parts::motion_codes;
use program::{Action, Dialect, Fault, Meaning, Part, ProbeAlong, ProbeDown};
use units::Celsius;

use super::program_flow::FlowHands as _;
use super::{bore_retract, dry_run, program_flow, tool_change};
use crate::features::functions;
use crate::machine::hands::MachineHands;
use crate::machine::hold::Hold;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::program_io::OverrideHands as _;
use crate::machine::work_hands::{JobHands, MoveHands};
use crate::machine::{Machine, effects, halt, homing, moves, operator_pauses, program_files, program_io, suspend};
use program::State;

/// Returns the failure of a block that the program refuses; the configuration knows better why a part is off.
pub(crate) fn failed_by<'c>(hands: &mut impl JobHands<'c>, fault: &Fault) -> Failure {
    let (jobs, World { texts, config, .. }) = hands.jobs_in_world();
    failure_of(texts, config, fault, jobs.is_playing())
}

/// Carries out the action of a block, and the actions that follow it.
pub(crate) fn carry_out_all<P: Ports>(machine: &mut Machine<'_, P>, first: &Action<'_>, to: Recipient) -> Outcome {
    let mut answer = carry_out(machine, first, to)?;
    while let Some(action) = machine.program.next_action() {
        match carry_out(machine, &action, to) {
            Ok(now) => answer = now,
            Err(failure) => {
                // A hole that was being tapped does not go on either.
                if machine.hold != Hold::Acts {
                    // A hold that has waited for the tap comes too late.
                    program_io::overrides_count_again(machine.overrides());
                }
                return Err(failure);
            }
        }
    }
    Ok(answer)
}

/// Runs a code that the machine itself has written.
pub(crate) fn run_text<P: Ports>(machine: &mut Machine<'_, P>, text: &str, dialect: Dialect, to: Recipient) -> Outcome {
    let Some(Ok(block)) = Blocks::new(text.as_bytes()).next() else {
        return Err(machine.world.texts.because(text));
    };
    let Some(row) = machine.program.row(&block, dialect) else { return Ok(Answer::Unknown) };
    let facts = machine.facts();
    match machine.program.run(&block, row, facts, dialect) {
        Ok(Meaning::Action(action)) => carry_out_all(machine, &action, to),
        Ok(_) => Ok(Answer::Ok),
        Err(fault) => Err(failed_by(machine, &fault)),
    }
}

/// Carries out the effects and the action that are left at the end of a subroutine (M73).
#[cold]
pub(crate) fn what_returned<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    while let Some(what) = machine.program.next_effect() {
        effects::change(machine, what)?;
    }
    match machine.program.next_action() {
        Some(action) => carry_out_all(machine, &action, to),
        None => Ok(Answer::Ok),
    }
}

fn carry_out<P: Ports>(machine: &mut Machine<'_, P>, action: &Action<'_>, to: Recipient) -> Outcome {
    if machine.safety.state() == State::Check {
        return dry_run::carry_out(machine, action, to);
    }
    match *action {
        Action::Move(ref request) if Features::<P>::leave_move_out(machine, request)? => {}
        Action::Move(ref request) => moves::go_along(machine, request)?,
        Action::Effect(what) => effects::change(machine, what)?,
        Action::Dwell(time) => operator_pauses::dwell(&mut MachineHands::new(machine, to), time)?,
        Action::Finish => machine.standstill()?,
        Action::Halt => halt::emergency_stop(machine),
        Action::Release => halt::clear_halt(machine, to),
        Action::Message(text) => Features::<P>::shows(machine, text),
        Action::SurfaceSpeed(None) => {}
        Action::Acceleration(value) => {
            return motion_codes::acceleration(machine.world.texts, &mut machine.world.ports, value);
        }
        Action::Call { number, times } => return program_flow::call(machine.flow(), (number, times)),
        Action::Return => return program_flow::end_call(machine),
        Action::ReadTools => return program_files::reload_tools(&mut machine.world, &mut machine.program),
        // Motion stops for overrides and goes on from the same place: a drilling cycle in progress stays.
        Action::Overrides { feed, spindle, hold } => program_io::enable_overrides(machine, feed, spindle, hold)?,
        Action::RetractByHand => return bore_retract::retract_by_hand(&mut MachineHands::new(machine, to)),
        Action::Keep => program_files::save_unless_playing(machine),
        Action::Note(text) => machine.say(to, format_args!("{text}\n")),
        // The program refuses these actions by name before: nothing here turns a spindle so.
        Action::Orient { .. } | Action::RigidTap { .. } | Action::SurfaceSpeed(Some(_)) => {
            return Err(Failure::refused(&"this needs a spindle encoder"));
        }
        Action::Home(axes) => return stand(machine, |machine| homing::home(machine, axes, to)),
        Action::SetPosition { to: ref position, homed } => {
            return stand(machine, |machine| homing::set_position(machine, position, homed));
        }
        Action::ForgetHoming(axes) => return stand(machine, |machine| forget_homed(machine, axes)),
        Action::ProbeDown(ref probe) => return stand(machine, |machine| probe_down(machine, probe, to)),
        Action::ProbeAlong(ref probe) => return stand(machine, |machine| probe_along(machine, probe, to)),
        Action::HeatAndWait { heater, target, cools } => {
            return stand(machine, |machine| heat_and_wait(machine, (heater, target, cools), to));
        }
        Action::EndProgram => return stand(machine, program_flow::end_program),
        Action::Pause { why, time, text } => {
            return stand(machine, |machine| {
                operator_pauses::pause(&mut MachineHands::new(machine, to), why, time, text)
            });
        }
        Action::ChangeTool(tool) => {
            return stand(machine, |machine| tool_change::begin(&mut MachineHands::new(machine, to), tool));
        }
        Action::AwaitInput(wait) => {
            return stand(machine, |machine| program_io::await_input(&mut MachineHands::new(machine, to), wait));
        }
        Action::Suspend { heaters_stay, words } => {
            let suspended = |machine: &mut _| Features::<P>::suspend(machine, heaters_stay, &words, to);
            return stand(machine, |machine| suspended(machine).unwrap_or(Ok(Answer::Unknown)));
        }
        Action::Resume => return stand(machine, |machine| suspend::resume(machine, to)),
        Action::Function(function, words) => {
            return stand(machine, |machine| functions::run(machine, function, words, to));
        }
    }
    Ok(Answer::Ok)
}

/// Carries out an action that begins from standstill, or ends somewhere that only the machine knows. Each has
/// a stack frame of its own: much is called from there.
#[inline(never)]
fn stand<'c, H: MoveHands<'c>>(hands: &mut H, carry_out: impl FnOnce(&mut H) -> Outcome) -> Outcome {
    let done = carry_out(hands);
    // Homing, probing and scripts may have ended anywhere.
    hands.resynchronise_if_still();
    done
}

fn forget_homed<'c>(hands: &mut impl MoveHands<'c>, axes: units::AxisSet) -> Outcome {
    hands.axes().forget_homed(axes);
    Ok(Answer::Ok)
}

/// G30: probes downwards.
fn probe_down<'c>(hands: &mut impl MoveHands<'c>, probe: &ProbeDown, to: Recipient) -> Outcome {
    let hands = &mut hands.sequence(to);
    let ended = procedures::probing::probe_down(hands, probe);
    if probe.stays {
        procedures::probing::leave_out(hands);
    }
    procedures::probing::stow_after(hands, ended)
}

/// G38: probes along a line.
fn probe_along<'c>(hands: &mut impl MoveHands<'c>, probe: &ProbeAlong, to: Recipient) -> Outcome {
    let hands = &mut hands.sequence(to);
    let ended = procedures::probing::probe_along(hands, probe);
    procedures::probing::leave_out(hands);
    ended
}

fn heat_and_wait<'c>(
    hands: &mut impl JobHands<'c>,
    (heater, target, cools): (units::HeaterId, Celsius, bool),
    to: Recipient,
) -> Outcome {
    if target > thermal::OFF_BELOW {
        let (jobs, World { texts, config, .. }) = hands.jobs_in_world();
        needs(texts, config, Part::Heater(heater), jobs.is_playing())?;
    }
    hands.jobs().set_heating(true);
    let heated = heat_codes::heat_and_wait(&mut hands.sequence(to), heater, target, cools);
    hands.jobs().set_heating(false);
    heated.map(|()| Answer::Ok)
}
