//! Brown-out: the supply of motors or heaters falls while the machine works. Heaters go off first, which leaves
//! what there is to the motors; these brake along their path and are held as long as it lasts. A journal notes
//! the job; without one the card keeps what has happened, and the next start tells it.

use core::fmt::{Arguments, Write as _};

use program::State;
use units::{Micros, Volts};

use super::{Machine, journal};
use crate::failure::Message;
use crate::falling_supply::{FallingSupply, OFF};
use crate::grbl::numbers::Alarm;
use crate::ports::{DateTime, FileHandle, OpenMode, Ports, Storage, StorageError};
use crate::supervisor::Supervisor;

/// Each of the two supplies is looked at so often, in turns.
const PERIOD: Micros = Micros::from_millis(3);
/// What has happened, in words: a block that is made beforehand and written in place, so that neither allocation
/// table nor directory is touched while the power goes.
const PATH: &str = "/sd/brown-out.txt";
const BLOCK: usize = 512;
/// How it begins: nobody has been told yet, or somebody has.
const NEWS: &str = "new: ";
const TOLD: &str = "told: ";

/// The two supplies.
#[derive(Debug, Default)]
pub(super) struct BrownOut {
    due: Micros,
    heaters_turn: bool,
    motors: FallingSupply,
    heaters: FallingSupply,
    /// It is to be kept once the motors stand.
    to_keep: Option<Message>,
    /// The file of what is kept: to close it takes writes of its own, which have to wait until the power is there.
    file: Option<FileHandle>,
}

/// Looks at one of the supplies.
pub(super) fn watch<P: Ports>(machine: &mut Machine<'_, P>) {
    let now = machine.ports.now();
    if now < machine.brown_out.due || machine.config.voltages.is_empty() {
        return;
    }
    machine.brown_out.due = now.plus(Micros(PERIOD.0 / 2));
    let of_heaters = machine.brown_out.heaters_turn;
    machine.brown_out.heaters_turn = !of_heaters;
    let name = if of_heaters { "vfet" } else { "vmotor" };
    let Some(volts) = machine.ports.voltage_now(name) else { return };
    let least = least(machine, of_heaters);
    let supply = if of_heaters { &mut machine.brown_out.heaters } else { &mut machine.brown_out.motors };
    let (falls_now, usual) = (supply.look(volts, least), supply.usual());
    if falls_now && is_at_work(machine) {
        falls(machine, of_heaters, volts, usual);
    }
    if machine.brown_out.file.is_some() && machine.brown_out.is_over() {
        close(machine);
    }
}

impl BrownOut {
    /// Both supplies are as usual.
    const fn is_over(&self) -> bool {
        !self.motors.is_low() && !self.heaters.is_low()
    }
}

/// Below what the supply falls; none: below a share of what it usually has.
fn least<P: Ports>(machine: &Machine<'_, P>, of_heaters: bool) -> Option<Volts> {
    let noted = machine.config.player.power_loss.motor_volts;
    if noted > 0.0 && !of_heaters && machine.journal.is_noting() {
        return Some(Volts(noted));
    }
    machine.config.system.brown_out_volts
}

/// There is something that the fall is to end: heat, or motion, or a job that waits.
fn is_at_work<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let state = machine.safety.state();
    if machine.safety.is_halted() || state == State::Check {
        return false;
    }
    let moves = !machine.ports.motion(|motion| motion.is_idle());
    moves || machine.jobs.is_open() || machine.ports.heat(|heat| heat.any_on())
}

fn falls<P: Ports>(machine: &mut Machine<'_, P>, of_heaters: bool, volts: Volts, usual: Volts) {
    if volts < OFF {
        return gone(machine, of_heaters);
    }
    let whose = if of_heaters { "heaters" } else { "motors" };
    let text =
        text(format_args!("the {whose}' supply has fallen to {:.1} V, and has {:.1} V usually", volts.0, usual.0));
    let event = event(machine, &text);
    machine.halt_holding(
        Alarm::Abort,
        format_args!("ERROR: {text}: heaters are off, motors are held as long as it lasts\n"),
    );
    // Files that grow are not to be written by what is left of it.
    let _unsaved = machine.jobs.statistics.take_unsaved();
    if machine.journal.is_noting() {
        machine.brown_out.to_keep = Some(event);
    } else {
        keep(machine, &event);
    }
}

/// It is not there any more, as when somebody pulls its plug.
fn gone<P: Ports>(machine: &mut Machine<'_, P>, of_heaters: bool) {
    let is_told = |supervisor: &mut Supervisor| {
        if of_heaters { !supervisor.fet_supply_on() } else { !supervisor.motor_supply_on() }
    };
    if machine.ports.supervisor(is_told) {
        return;
    }
    if of_heaters {
        machine.ports.supervisor(Supervisor::fet_supply_is_lost);
        machine.fet_supply_lost();
    } else {
        machine.ports.supervisor(Supervisor::motor_supply_is_lost);
        machine.motor_supply_lost();
    }
}

fn text(what: Arguments<'_>) -> Message {
    let mut text = Message::new();
    // What does not fit is cut.
    let _ = text.write_fmt(what);
    text
}

/// What has happened, for the next start.
fn event<P: Ports>(machine: &Machine<'_, P>, what: &str) -> Message {
    let mut event = Message::new();
    let date = machine.ports.date();
    // What does not fit is cut. A clock that nobody has set says nothing.
    let _ = if date.year > DateTime::UNSET.year { write!(event, "{date}: {what}") } else { write!(event, "{what}") };
    if let Some(path) = machine.jobs.path() {
        let _ = write!(event, ", in line {} of {path}", machine.jobs.line_now());
    }
    event
}

/// The halted machine stands: what was left until then.
pub(super) fn stands<P: Ports>(machine: &mut Machine<'_, P>) {
    journal::stands(machine);
    if let Some(event) = machine.brown_out.to_keep.take() {
        keep(machine, &event);
    }
}

/// Writes it over the block, if there is one.
fn keep<P: Ports>(machine: &mut Machine<'_, P>, event: &str) {
    close(machine);
    let opened = machine.ports.open(PATH, OpenMode::Append);
    machine.brown_out.file = opened.ok();
    let written = opened.and_then(|file| put(&mut machine.ports, file, NEWS, event));
    if let Err(error) = written
        && !matches!(error, StorageError::NotFound | StorageError::NoCard)
    {
        machine.announce(format_args!("WARNING: {PATH} was not written: {}\n", error.text()));
    }
}

fn put<P: Ports>(ports: &mut P, file: FileHandle, state: &str, event: &str) -> Result<(), StorageError> {
    let mut block = [b' '; BLOCK];
    let text = state.bytes().chain(event.bytes()).chain([b'\n']);
    block.iter_mut().zip(text).for_each(|(to, byte)| *to = byte);
    ports.seek(file, 0).and_then(|()| Storage::write(ports, file, &block))
}

fn close<P: Ports>(machine: &mut Machine<'_, P>) {
    if let Some(file) = machine.brown_out.file.take() {
        // Its block has been written.
        let _ = machine.ports.close(file);
    }
}

/// A job begins: makes the block, where there is none. A job with a journal has its own.
pub(super) fn prepare<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.journal.is_on || machine.config.voltages.is_empty() {
        return;
    }
    if machine.config.system.brown_out_volts == Some(Volts(0.0)) {
        return;
    }
    let ports = &mut machine.ports;
    if let Ok(file) = ports.open(PATH, OpenMode::Read) {
        let size = ports.size(file);
        // It was only read.
        let _ = ports.close(file);
        if size == Ok(BLOCK as u32) {
            return;
        }
    }
    // On a card that takes no writes nothing is kept.
    let _ = ports.open(PATH, OpenMode::Write).and_then(|file| {
        let written = Storage::write(ports, file, &[b' '; BLOCK]);
        written.and(ports.close(file))
    });
}

/// At boot: what nobody has been told yet.
pub(super) fn tell<P: Ports>(machine: &mut Machine<'_, P>) {
    let Ok(file) = machine.ports.open(PATH, OpenMode::Read) else { return };
    let mut block = [0; BLOCK];
    let read = machine.ports.read(file, &mut block);
    // It was only read.
    let _ = machine.ports.close(file);
    let Some(bytes) = read.ok().and_then(|count| block.get(..count)) else { return };
    let text = core::str::from_utf8(bytes).unwrap_or_default();
    let Some(event) = text.strip_prefix(NEWS).map(|rest| rest.lines().next().unwrap_or_default().trim()) else {
        return;
    };
    machine.announce(format_args!("WARNING: when the machine was on last: {event}\n"));
    let ports = &mut machine.ports;
    let told = ports.open(PATH, OpenMode::Append).and_then(|file| put(ports, file, TOLD, event).and(ports.close(file)));
    if let Err(error) = told {
        machine.announce(format_args!("WARNING: {PATH} was not written: {}\n", error.text()));
    }
}
