//! Planned moves of an object that has been left out by now: the machine brakes on their way, drops them, and
//! goes on with the moves planned behind them, or with the lines read next.
//!
//! Every waiting point serves it, so that moves are dropped at once, whatever the executor waits for.

use base::failure::Failure;
use base::ports::Wake;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use motion::{State as Motion, Waiting};
use program::State;
use program::objects::TakenOut;
use units::{Axis, PerAxis};

use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, moves};

/// Looks at the moves that the machine makes. Seldom: only while such moves may wait.
#[cold]
pub(crate) fn serve<P: Ports>(machine: &mut Machine<'_, P>) {
    let (part, state, stands) =
        machine.world.ports.motion(|motion| (motion.part_now(), motion.state(), motion.is_held_still()));
    let is_cut = part.is_some_and(|part| machine.jobs.objects.is_cut(part));
    match state {
        Motion::Running if is_cut && !machine.cut.has_line_behind && machine.hold.acts() => {
            machine.world.ports.motion(motion::Motion::hold);
            machine.cut.brakes = true;
        }
        // Somebody lets the machine go on, or has stopped it all.
        Motion::Running => {
            machine.cut.brakes = false;
            if part.is_none() {
                find_rest(machine);
            }
        }
        Motion::Held if stands && is_cut => drop_moves(machine),
        Motion::Held if stands && machine.cut.brakes => go_on(machine),
        _ => {}
    }
}

/// Finds moves still waiting that are to be left out.
pub(crate) fn find_rest<P: Ports>(machine: &mut Machine<'_, P>) {
    let Machine { jobs, world: World { ports, .. }, .. } = machine;
    ports.motion(|motion| jobs.objects.has_cut_but(motion.waiting().map(|waiting| waiting.request.part)));
}

/// Waits until the moves are dropped.
///
/// # Errors
/// When the machine halts.
#[cold]
pub(crate) fn wait<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    while machine.cut.brakes {
        machine.wait(Wake::Any).unless_halted()?;
    }
    Ok(())
}

fn go_on<P: Ports>(machine: &mut Machine<'_, P>) {
    find_rest(machine);
    let is_held = matches!(machine.safety.state(), State::Hold | State::Door);
    let brakes = core::mem::take(&mut machine.cut.brakes);
    machine.world.ports.motion(|motion| match motion.state() {
        Motion::Held if brakes && !is_held => motion.resume(),
        // The operator holds the machine.
        Motion::Running if is_held => motion.hold(),
        _ => {}
    });
}

/// Drops the moves left out on whose way the machine stands, up to a move that is not left out.
fn drop_moves<P: Ports>(machine: &mut Machine<'_, P>) {
    let Machine { jobs, program, world: World { ports, .. }, .. } = machine;
    let (here, taken_out, dropped, next) = ports.motion(|motion| {
        let here = motion.held_at();
        let (mut taken_out, mut dropped) = (TakenOut::from(here), 0);
        for waiting in motion.waiting() {
            if !jobs.objects.is_cut(waiting.request.part) {
                return (here, taken_out, dropped, Some(waiting));
            }
            taken_out.follow(program, &waiting.request.target);
            dropped += 1;
        }
        (here, taken_out, dropped, None)
    });
    match next {
        None => {
            machine.world.ports.motion(motion::Motion::stop);
            program::objects::stay(&mut machine.program, taken_out);
        }
        Some(next) => go_round(machine, &taken_out, dropped, &next, here),
    }
    go_on(machine);
}

/// Goes from here to the moves planned behind.
fn go_round<P: Ports>(
    machine: &mut Machine<'_, P>,
    taken_out: &TakenOut,
    mut dropped: usize,
    next: &Waiting,
    here: PerAxis<f64>,
) {
    let way = program::objects::way_round(&machine.program, taken_out, (&next.request.target, next.is_straight));
    let (way, from) = way.counted_anew(&here);
    let mut moves = heapless::Vec::<motion::Move, 6>::new();
    for step in &way.moves {
        // There is room: a way has five moves at most.
        let request = moves::in_motions_terms(machine, step);
        let _ = moves.push(motion::Move { tag: next.request.tag, part: 0, ..request });
    }
    if !way.arrives {
        let _ = moves.push(next.request);
        dropped += 1;
    }
    Features::<P>::extruders_count_anew(machine);
    leaves_for_heights(machine, moves.iter().map(|step| step.target[Axis::Z]));
    if let Err(refusal) = machine.world.ports.motion(|motion| motion.go_round(dropped, from, &moves)) {
        machine.announce(format_args!("error:the way round the object that is left out: {refusal}\n"));
        machine.resynchronise();
        let Machine { jobs, world: World { sessions, .. }, .. } = machine;
        jobs.pause_at_this_line("comes behind moves that were dropped", &mut Reply::new(sessions, Recipient::All));
    }
}

/// Says to which heights the machine goes that the file does not name.
pub(crate) fn leaves_for_heights<P: Ports>(machine: &mut Machine<'_, P>, heights: impl Iterator<Item = f64>) {
    let range = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], z| [least.min(z), most.max(z)]);
    if range[0] <= range[1] {
        Features::<P>::leaves_for_heights(machine, range);
    }
}
