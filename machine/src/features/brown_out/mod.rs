//! Brown-out: the supply of motors or heaters falls while the machine works. Heaters go off first, which
//! leaves the remaining supply to the motors; these brake along their path and are held as long as it lasts.
//! A journal notes the job; without one the card keeps a note of the event, and the next start tells it.

use core::fmt::{self, Write as _};

use base::axes::Axes;
use base::brown_out::{BrownOut, PATH, news, told};
use base::failure::{ShortText, short};
use base::falling_supply::OFF;
use base::ports::{Calendar as _, DateTime, StorageError};
use base::reason::Alarm;
use base::safety::Safety;
use base::{Ports, World};
use config::MachineConfig;
use jobs::player::Jobs;
use procedures::endstop_phase::EndstopPhases;
use program::State;
use units::{Micros, Volts};

use crate::features::state::States;
use crate::machine::moments::Moments;
use crate::machine::work_hands::HaltHands;
use crate::machine::{Machine, supplies};

/// Period of the looks, at each of the two supplies in turns.
const PERIOD: Micros = Micros::from_millis(3);

/// Supplies, and what depends on them.
pub(crate) struct Supplied<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    jobs: &'m mut Jobs,
    axes: &'m mut Axes,
    phases: &'m mut EndstopPhases,
    safety: &'m Safety,
    brown_out: &'m mut BrownOut,
    /// A journal notes the job.
    is_noted: bool,
}

/// The machine for falling supplies.
pub(crate) trait SupplyHands<'c>: HaltHands<'c> {
    /// Returns the supplies.
    fn supplied(&mut self) -> Supplied<'_, 'c, Self::Ports>;

    /// Halts, but lets standing motors keep their current.
    fn halt_holding(&mut self, alarm: Alarm, why: fmt::Arguments<'_>);
}

impl<'c, P: Ports> SupplyHands<'c> for Machine<'c, P> {
    fn supplied(&mut self) -> Supplied<'_, 'c, P> {
        let Self { world, jobs, axes, phases, safety, features: States { brown_out, journal, .. }, .. } = self;
        Supplied { world, jobs, axes, phases, safety, brown_out, is_noted: journal.is_noting() }
    }

    fn halt_holding(&mut self, alarm: Alarm, why: fmt::Arguments<'_>) {
        self.halt_holding(alarm, why);
    }
}

/// Falling supplies at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: SupplyHands<'c>> Moments<M> for Feature {
    /// Tells at boot of a brown-out that nobody has been told of yet.
    fn started(hands: &mut M, is_usable: bool) {
        let world = hands.world();
        let Some(event) = is_usable.then(|| news(&mut world.ports)).flatten() else { return };
        world.announce(format_args!("WARNING: when the machine was on last: {event}\n"));
        let written = told(&mut world.ports, event.as_str());
        not_written(world, written);
    }

    fn each_250_us(hands: &mut M, now: Micros) {
        let Supplied { world, jobs, axes, phases, safety, brown_out, is_noted } = hands.supplied();
        let Some(fall) = look(world, brown_out, is_noted, now) else { return };
        if !is_at_work(&mut world.ports, safety, jobs) {
            return;
        }
        if fall.volts < OFF {
            if let Some(why) = gone(world, axes, phases, safety, fall.of_heaters) {
                hands.halt(Alarm::Abort, format_args!("{why}"));
            }
            return;
        }
        let text = fall.text();
        let event = event(world.ports.date(), jobs, text.as_str());
        hands.halt_holding(
            Alarm::Abort,
            format_args!("ERROR: {text}: heaters are off, motors are held as long as it lasts\n"),
        );
        let Supplied { world, jobs, brown_out, is_noted, .. } = hands.supplied();
        // The remaining supply must not be spent on files that grow.
        let _unsaved = jobs.statistics.take_unsaved();
        if is_noted {
            brown_out.to_keep = Some(event);
        } else {
            let written = brown_out.keep(&mut world.ports, event.as_str());
            not_written(world, written);
        }
    }

    fn rests(hands: &mut M) {
        let Supplied { world, brown_out, .. } = hands.supplied();
        let written = brown_out.stands(&mut world.ports);
        not_written(world, written);
    }
}

/// A supply that falls.
struct Fall {
    of_heaters: bool,
    volts: Volts,
    usual: Volts,
}

impl Fall {
    fn text(&self) -> ShortText {
        let whose = if self.of_heaters { "heaters" } else { "motors" };
        let (Volts(now), Volts(usual)) = (self.volts, self.usual);
        short(format_args!("the {whose}' supply has fallen to {now:.1} V, and has {usual:.1} V usually"))
    }
}

/// Looks at one of the supplies, when that is due; `notes`: a journal notes the job.
fn look<P: Ports>(world: &mut World<'_, P>, brown_out: &mut BrownOut, notes: bool, now: Micros) -> Option<Fall> {
    if now < brown_out.due || world.config.voltages.is_empty() {
        return None;
    }
    brown_out.due = now.plus(Micros(PERIOD.0 / 2));
    let of_heaters = brown_out.heaters_turn;
    brown_out.heaters_turn = !of_heaters;
    let volts = world.ports.voltage_now(if of_heaters { "vfet" } else { "vmotor" })?;
    let least = least(world.config, notes && !of_heaters);
    let supply = if of_heaters { &mut brown_out.heaters } else { &mut brown_out.motors };
    let (falls, usual) = (supply.look(volts, least), supply.usual());
    brown_out.look_after_note(&mut world.ports);
    falls.then_some(Fall { of_heaters, volts, usual })
}

/// Returns the voltage below which the supply falls; none: a share of its usual voltage counts. `of_noted`:
/// the supply is that of the motors of a job that a journal notes.
fn least(config: &MachineConfig, of_noted: bool) -> Option<Volts> {
    let noted = config.player.power_loss.motor_volts;
    if noted > 0.0 && of_noted { Some(Volts(noted)) } else { config.system.brown_out_volts }
}

/// Whether there is something that the fall is to end: heat, or motion, or a job that waits.
fn is_at_work<P: Ports>(ports: &mut P, safety: &Safety, jobs: &Jobs) -> bool {
    if safety.is_halted() || safety.state() == State::Check {
        return false;
    }
    let moves = !ports.motion(|motion| motion.is_idle());
    moves || jobs.is_open() || ports.heat(|heat| heat.any_on())
}

/// Handles a supply that is absent altogether, as when somebody pulls its plug. The text is that of a halt.
fn gone<P: Ports>(
    world: &mut World<'_, P>,
    axes: &mut Axes,
    phases: &mut EndstopPhases,
    safety: &Safety,
    of_heaters: bool,
) -> Option<&'static str> {
    let is_news = world.ports.supervisor(|supervisor| {
        let is_on = if of_heaters { supervisor.fet_supply_on() } else { supervisor.motor_supply_on() };
        match (is_on, of_heaters) {
            (false, _) => {}
            (true, true) => supervisor.fet_supply_is_lost(),
            (true, false) => supervisor.motor_supply_is_lost(),
        }
        is_on
    });
    match (is_news, of_heaters) {
        (false, _) => None,
        (true, true) => supplies::fet_supply_lost(world),
        (true, false) => supplies::motor_supply_lost(world, axes, phases, safety),
    }
}

/// Returns the text of a brown-out that the next start tells.
fn event(date: DateTime, jobs: &Jobs, what: &str) -> ShortText {
    let mut event = ShortText::NONE;
    // Text that does not fit is cut. A clock that nobody has set gives no date.
    let _ = if date.is_set() { write!(event, "{date}: {what}") } else { write!(event, "{what}") };
    if let Some(path) = jobs.path() {
        let _ = write!(event, ", in line {} of {path}", jobs.line_now());
    }
    event
}

fn not_written<P: Ports>(world: &mut World<'_, P>, written: Result<(), StorageError>) {
    if let Err(error) = written {
        world.announce(format_args!("WARNING: {PATH} was not written: {}\n", error.text()));
    }
}
