//! Brown-out: the supply of motors or heaters falls while the machine works. Heaters go off first, which
//! leaves the remaining supply to the motors; these brake along their path and are held as long as it lasts.
//! A journal notes the job; without one the card keeps a note of the event, and the next start tells it.

use core::fmt::Write as _;

use base::Ports;
use base::brown_out::{PATH, news, told};
use base::failure::{ShortText, short};
use base::falling_supply::OFF;
use base::ports::{DateTime, StorageError};
use base::reason::Alarm;
use base::supervisor::Supervisor;
use program::State;
use units::{Micros, Volts};

use crate::machine::Machine;
use crate::machine::moments::Moments;
use crate::machine::supplies;

/// Period of the looks, at each of the two supplies in turns.
const PERIOD: Micros = Micros::from_millis(3);

/// Falling supplies at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn started(machine: &mut Machine<'_, P>, is_usable: bool) {
        if is_usable {
            tell(machine);
        }
    }

    fn each_250_us(machine: &mut Machine<'_, P>, now: Micros) {
        watch(machine, now);
    }

    fn rests(machine: &mut Machine<'_, P>) {
        let written = machine.features.brown_out.stands(&mut machine.world.ports);
        not_written(machine, written);
    }
}

/// Looks at one of the supplies.
fn watch<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    if now < machine.features.brown_out.due || machine.world.config.voltages.is_empty() {
        return;
    }
    machine.features.brown_out.due = now.plus(Micros(PERIOD.0 / 2));
    let of_heaters = machine.features.brown_out.heaters_turn;
    machine.features.brown_out.heaters_turn = !of_heaters;
    let name = if of_heaters { "vfet" } else { "vmotor" };
    let Some(volts) = machine.world.ports.voltage_now(name) else { return };
    let least = least(machine, of_heaters);
    let supply =
        if of_heaters { &mut machine.features.brown_out.heaters } else { &mut machine.features.brown_out.motors };
    let (falls_now, usual) = (supply.look(volts, least), supply.usual());
    if falls_now && is_at_work(machine) {
        falls(machine, of_heaters, volts, usual);
    }
    machine.features.brown_out.look_after_note(&mut machine.world.ports);
}

/// Returns the voltage below which the supply falls; none: a share of its usual voltage counts.
fn least<P: Ports>(machine: &Machine<'_, P>, of_heaters: bool) -> Option<Volts> {
    let noted = machine.world.config.player.power_loss.motor_volts;
    if noted > 0.0 && !of_heaters && machine.features.journal.is_noting() {
        return Some(Volts(noted));
    }
    machine.world.config.system.brown_out_volts
}

/// Whether there is something that the fall is to end: heat, or motion, or a job that waits.
fn is_at_work<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let state = machine.safety.state();
    if machine.safety.is_halted() || state == State::Check {
        return false;
    }
    let moves = !machine.world.ports.motion(|motion| motion.is_idle());
    moves || machine.jobs.is_open() || machine.world.ports.heat(|heat| heat.any_on())
}

fn falls<P: Ports>(machine: &mut Machine<'_, P>, of_heaters: bool, volts: Volts, usual: Volts) {
    if volts < OFF {
        return gone(machine, of_heaters);
    }
    let whose = if of_heaters { "heaters" } else { "motors" };
    let text =
        short(format_args!("the {whose}' supply has fallen to {:.1} V, and has {:.1} V usually", volts.0, usual.0));
    let event = event(machine, text.as_str());
    machine.halt_holding(
        Alarm::Abort,
        format_args!("ERROR: {text}: heaters are off, motors are held as long as it lasts\n"),
    );
    // The remaining supply must not be spent on files that grow.
    let _unsaved = machine.jobs.statistics.take_unsaved();
    if machine.features.journal.is_noting() {
        machine.features.brown_out.to_keep = Some(event);
    } else {
        let written = machine.features.brown_out.keep(&mut machine.world.ports, event.as_str());
        not_written(machine, written);
    }
}

/// Handles a supply that is absent altogether, as when somebody pulls its plug.
fn gone<P: Ports>(machine: &mut Machine<'_, P>, of_heaters: bool) {
    let is_told = |supervisor: &mut Supervisor| {
        if of_heaters { !supervisor.fet_supply_on() } else { !supervisor.motor_supply_on() }
    };
    if machine.world.ports.supervisor(is_told) {
        return;
    }
    if of_heaters {
        machine.world.ports.supervisor(Supervisor::fet_supply_is_lost);
        supplies::fet_supply_lost(machine);
    } else {
        machine.world.ports.supervisor(Supervisor::motor_supply_is_lost);
        supplies::motor_supply_lost(machine);
    }
}

/// Returns the text of a brown-out that the next start tells.
fn event<P: Ports>(machine: &Machine<'_, P>, what: &str) -> ShortText {
    let mut event = ShortText::NONE;
    let date = machine.world.ports.date();
    // Text that does not fit is cut. A clock that nobody has set gives no date.
    let _ = if date.year > DateTime::UNSET.year { write!(event, "{date}: {what}") } else { write!(event, "{what}") };
    if let Some(path) = machine.jobs.path() {
        let _ = write!(event, ", in line {} of {path}", machine.jobs.line_now());
    }
    event
}

fn not_written<P: Ports>(machine: &mut Machine<'_, P>, written: Result<(), StorageError>) {
    if let Err(error) = written {
        machine.announce(format_args!("WARNING: {PATH} was not written: {}\n", error.text()));
    }
}

/// Tells at boot of a brown-out that nobody has been told of yet.
pub(crate) fn tell<P: Ports>(machine: &mut Machine<'_, P>) {
    let Some(event) = news(&mut machine.world.ports) else { return };
    machine.announce(format_args!("WARNING: when the machine was on last: {event}\n"));
    let written = told(&mut machine.world.ports, event.as_str());
    not_written(machine, written);
}
