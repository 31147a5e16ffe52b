//! Planned moves of an object that has been left out by now: the machine brakes on their way, drops them, and
//! goes on with the moves planned behind them, or with the lines read next.
//!
//! Every waiting point serves it, so that moves are dropped at once, whatever the executor waits for.

use base::World;
use base::failure::Failure;
use base::ports::{MotionPort as _, Wake};
use base::sessions::{Recipient, Reply};
use motion::{State as Motion, Waiting};
use program::State;
use program::objects::TakenOut;
use units::{Axis, PerAxis};

use crate::features::objects::ObjectHands;

/// Looks at the moves that the machine makes. Seldom: only while such moves may wait.
#[cold]
pub(crate) fn serve<'c>(hands: &mut impl ObjectHands<'c>) {
    let (part, state, stands) =
        hands.world().ports.motion(|motion| (motion.part_now(), motion.state(), motion.is_held_still()));
    let is_cut = part.is_some_and(|part| hands.jobs().objects.is_cut(part));
    match state {
        Motion::Running if is_cut && hands.may_brake() => {
            hands.world().ports.motion(motion::Motion::hold);
            hands.cut().brakes = true;
        }
        // Somebody lets the machine go on, or has stopped it all.
        Motion::Running => {
            hands.cut().brakes = false;
            if part.is_none() {
                find_rest(hands);
            }
        }
        Motion::Held if stands && is_cut => drop_moves(hands),
        Motion::Held if stands && hands.cut().brakes => go_on(hands),
        _ => {}
    }
}

/// Finds moves still waiting that are to be left out.
pub(crate) fn find_rest<'c>(hands: &mut impl ObjectHands<'c>) {
    let (jobs, World { ports, .. }) = hands.jobs_in_world();
    ports.motion(|motion| jobs.objects.has_cut_but(motion.waiting().map(|waiting| waiting.request.part)));
}

/// Waits until the moves are dropped.
///
/// # Errors
/// When the machine halts.
#[cold]
pub(crate) fn wait<'c>(hands: &mut impl ObjectHands<'c>) -> Result<(), Failure> {
    while hands.cut().brakes {
        hands.wait(Wake::Any).unless_halted()?;
    }
    Ok(())
}

fn go_on<'c>(hands: &mut impl ObjectHands<'c>) {
    find_rest(hands);
    let is_held = matches!(hands.state(), State::Hold | State::Door);
    let brakes = core::mem::take(&mut hands.cut().brakes);
    hands.world().ports.motion(|motion| match motion.state() {
        Motion::Held if brakes && !is_held => motion.resume(),
        // The operator holds the hands.
        Motion::Running if is_held => motion.hold(),
        _ => {}
    });
}

/// Drops the moves left out on whose way the machine stands, up to a move that is not left out.
fn drop_moves<'c>(hands: &mut impl ObjectHands<'c>) {
    let (jobs, program, World { ports, .. }) = hands.planned();
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
            hands.world().ports.motion(motion::Motion::stop);
            program::objects::stay(hands.program(), taken_out);
        }
        Some(next) => go_round(hands, &taken_out, dropped, &next, here),
    }
    go_on(hands);
}

/// Goes from here to the moves planned behind.
fn go_round<'c>(
    hands: &mut impl ObjectHands<'c>,
    taken_out: &TakenOut,
    mut dropped: usize,
    next: &Waiting,
    here: PerAxis<f64>,
) {
    let way = program::objects::way_round(hands.program(), taken_out, (&next.request.target, next.is_straight));
    let (way, from) = way.counted_anew(&here);
    let mut moves = heapless::Vec::<motion::Move, 6>::new();
    for step in &way.moves {
        // There is room: a way has five moves at most.
        let request = hands.in_motions_terms(step);
        let _ = moves.push(motion::Move { tag: next.request.tag, part: 0, ..request });
    }
    if !way.arrives {
        let _ = moves.push(next.request);
        dropped += 1;
    }
    hands.extruders_count_anew();
    leaves_for_heights(hands, moves.iter().map(|step| step.target[Axis::Z]));
    if let Err(refusal) = hands.world().ports.motion(|motion| motion.go_round(dropped, from, &moves)) {
        hands.announce(format_args!("error:the way round the object that is left out: {refusal}\n"));
        hands.resynchronise();
        let (jobs, World { sessions, .. }) = hands.jobs_in_world();
        jobs.pause_at_this_line("comes behind moves that were dropped", &mut Reply::new(sessions, Recipient::All));
    }
}

/// Says to which heights the machine goes that the file does not name.
pub(crate) fn leaves_for_heights<'c>(hands: &mut impl ObjectHands<'c>, heights: impl Iterator<Item = f64>) {
    let range = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], z| [least.min(z), most.max(z)]);
    if range[0] <= range[1] {
        hands.leaves_for_heights(range);
    }
}
