//! Records of events in the ring that survives a reset; and `events`, which tells them.
//!
//! An event with one place in the code is recorded there, by [`Machine::record`]. Values that many places
//! change (the state, heaters' targets, homed axes) are looked at every few milliseconds, and differences
//! from the last look are recorded: [`follow`].

pub(crate) mod recorded;

use base::failure::{Answer, Failure, Outcome};
use base::ports::EventLog as _;
use base::safety::Safety;
use base::sessions::{Listing, Recipient, Reply};
use base::{Ports, World};
use events::{Event, Text};
use program::State;
use units::{Axis, AxisSet, MAX_HEATERS, Micros};

use self::recorded::Recorded;
use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;
use crate::machine::{Machine, long_answers};

/// Number of entries that `events` tells, unless it is asked for more.
const TOLD: u32 = 40;
/// Number of entries that `break` tells.
const TOLD_AT_A_BREAK: u32 = 8;

/// Values whose changes are recorded, and their last record.
pub(crate) struct Watched<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    recorded: &'m mut Recorded,
    state: State,
    homed: AxisSet,
}

/// The machine for records of events.
pub(crate) trait RecordHands<'c>: WorldHands<'c> {
    /// Returns the values whose changes are recorded.
    fn watched(&mut self) -> Watched<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> RecordHands<'c> for Machine<'c, P> {
    fn watched(&mut self) -> Watched<'_, 'c, P> {
        let (state, homed) = (self.safety.state(), self.axes.homed());
        Watched { world: &mut self.world, recorded: &mut self.features.recorded, state, homed }
    }
}

/// The ring of events at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: RecordHands<'c>> Moments<M> for Feature {
    fn each_10_ms(hands: &mut M, _now: Micros) {
        follow(hands.watched());
    }

    fn long_answer(hands: &mut M, listing: &mut Listing, to: Recipient) -> Option<Result<bool, Failure>> {
        let Listing::Events { next, end } = listing else { return None };
        let World { ports, sessions, .. } = hands.world();
        Some(Ok(piece(ports, next, *end, &mut Reply::new(sessions, to))))
    }
}

/// Records what has changed since the last look.
fn follow<P: Ports>(Watched { world, recorded, state, homed }: Watched<'_, '_, P>) {
    if state != recorded.state {
        recorded.state = state;
        if let Some(name) = told(state) {
            world.record(&Event::State(Text::from(name)));
        }
    }
    if homed != recorded.homed {
        recorded.homed = homed;
        let axes = Axis::ALL.into_iter().filter(|axis| homed.has(*axis)).fold(0, |bits, axis| bits | 1 << axis as u8);
        world.record(&Event::Homed { axes });
    }
    follow_targets(world, &mut recorded.targets);
}

fn follow_targets<P: Ports>(world: &mut World<'_, P>, recorded: &mut [i16; MAX_HEATERS]) {
    let mut targets = [0; MAX_HEATERS];
    world.ports.heat(|heat| {
        targets.iter_mut().zip(heat.heaters()).for_each(|(target, (_, heater))| *target = heater.target().0 as i16);
    });
    for ((target, recorded), controller) in targets.iter().zip(&*recorded).zip(&world.config.temperatures) {
        if target != recorded {
            let heater = Text::from(controller.name.as_str());
            world.record(&Event::Target { heater, celsius: f32::from(*target) });
        }
    }
    *recorded = targets;
}

/// Returns the name of a state that is worth an entry. Moving and standing alternate with every line that a
/// person types, and halts have an entry of their own.
const fn told(state: State) -> Option<&'static str> {
    match state {
        State::Idle | State::Run | State::Jog | State::Alarm | State::Invalid => None,
        State::Hold => Some("hold"),
        State::Homing => Some("homing"),
        State::Probing => Some("probing"),
        State::Suspended => Some("suspended"),
        State::Check => Some("check mode"),
        State::Door => Some("door open"),
        State::Sleep => Some("sleep"),
    }
}

/// Tells recorded events: `events [count | all]`.
pub(crate) fn tell<'c>(hands: &mut impl RecordHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let count = match arguments {
        "" => TOLD,
        "all" => u32::MAX,
        count => count.parse().map_err(|_| Failure::refused(&"events takes a number, or all"))?,
    };
    follow(hands.watched());
    let entries = hands.world().ports.events().last(count);
    let (next, end) = entries.span();
    long_answers::begin(hands.world(), Listing::Events { next, end }, to)
}

/// Tells the next line of the answer. True while there are more.
pub(crate) fn piece<P: Ports>(ports: &P, next: &mut u32, end: u32, reply: &mut Reply<'_>) -> bool {
    let mut entries = ports.events().between(*next, end);
    match entries.next() {
        Some(entry) => {
            reply.say(format_args!("{entry}\n"));
            *next = entry.number.wrapping_add(1);
            true
        }
        None => false,
    }
}

/// Stops for a debugger; without one nothing would go on, so the last events are told.
pub(crate) fn stop_for_debugger<P: Ports>(world: &mut World<'_, P>, safety: &Safety, to: Recipient) -> Outcome {
    if safety.state() != State::Idle && !safety.is_halted() {
        return Err(Failure::refused(&"the machine moves: stop it first"));
    }
    let World { ports, sessions, .. } = world;
    if ports.stop_for_debugger() {
        return Ok(Answer::Ok);
    }
    let reply = &mut Reply::new(sessions, to);
    reply.say(format_args!("no debugger is attached\n"));
    for entry in ports.events().last(TOLD_AT_A_BREAK) {
        reply.say(format_args!("{entry}\n"));
    }
    Ok(Answer::Ok)
}
