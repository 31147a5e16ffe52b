//! Other firmware: `flash`, `dfu`, the file that is installed at boot, and the running firmware's report on
//! itself.
//!
//! The boot stage installs firmware; here the file is looked at, and the running firmware copied to the card
//! as `firmware.previous`, so that the boot stage can put it back. None of that is hurried: everybody is
//! served meanwhile.

pub(crate) mod watch;

use base::Ports;
use base::failure::{Answer, Failure, Outcome, about_file};
use base::own_frame::apart;
use base::ports::{Arrival, Firmware, Flaw, OpenMode, Running, Storage, StorageError, Wake};
use base::sessions::{Recipient, Reply};
use events::{Event, Text};
use jobs::files::copying::read_through;
use parts::reports::{Came, failure};
use units::Micros;

use crate::machine::Machine;
use crate::machine::card;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;

/// File that the boot stage installs.
const FILE: &str = "/sd/flashme.bin";
/// Name of the file after its installation, as Smoothieware has it.
const INSTALLED: &str = "/sd/flashme.old";
/// Firmware that ran before, and its name while it is not whole.
const PREVIOUS: &str = "/sd/firmware.previous";
const DRAFT: &str = "/sd/firmware.tmp";
/// Time of serving after which the firmware does well.
const CONFIRMED_AFTER: Micros = Micros::from_seconds(10);
/// Bytes copied at a time: a block of the card.
const BLOCK: usize = 512;

/// Other firmware at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn greet(running: &Running, reply: &mut Reply<'_>) {
        greet(running, reply);
    }

    fn started(machine: &mut Machine<'_, P>, is_usable: bool) {
        begin(machine, is_usable);
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        apart(|| watch(machine, now));
    }

    fn idle(machine: &mut Machine<'_, P>) -> bool {
        machine.features.update.waits() && run_next(machine)
    }
}

/// Says how the firmware came to run, where that is worth a word at the start.
pub(crate) fn greet(running: &Running, reply: &mut Reply<'_>) {
    match running.arrival {
        Arrival::Known | Arrival::Probe => {}
        Arrival::Trial { .. } => reply.say(format_args!("// NOTICE {}\n", Came(running))),
        Arrival::FellBack(_) => reply.say(format_args!("WARNING: {}\n", Came(running))),
    }
    if let Some(why) = running.refused {
        reply.say(format_args!("WARNING: the firmware that was asked for was not installed: {why}\n"));
    }
}

/// Records at the start how the firmware came to run, and sets the owner's policy.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, is_configured: bool) {
    let running = machine.world.ports.running();
    match running.arrival {
        Arrival::Known | Arrival::Probe => {}
        Arrival::Trial { start, by_usb, .. } => {
            machine.record(&Event::FirmwareTried { start });
            machine.features.update.from_file = !by_usb;
        }
        Arrival::FellBack(by) => machine.record(&Event::FirmwareFellBack(Text::from(failure(by)))),
    }
    if let Some(why) = running.refused {
        machine.record(&Event::UpdateRefused(Text::from(why)));
    }
    if is_configured {
        let policy = &machine.world.config.update;
        // A policy that nobody can mean unlocks nothing.
        if policy.is_sound()
            && let Err(why) = machine.world.ports.set_policy(policy.key.as_ref(), policy.locked)
        {
            machine.announce(format_args!("ERROR: config.ini: [update] key: {why}\n"));
        }
        machine.features.update.at_boot = machine.world.config.system.flash_on_boot;
    }
}

/// Confirms the firmware, and hears a host's wish for the download; every few milliseconds.
pub(crate) fn watch<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    if !machine.features.update.is_confirmed && now >= CONFIRMED_AFTER {
        machine.features.update.is_confirmed = true;
        let arrival = machine.world.ports.running().arrival;
        machine.world.ports.confirm();
        if matches!(arrival, Arrival::Trial { .. }) {
            machine.record(&Event::FirmwareConfirmed);
        }
    }
    let may_leave = machine.world.config.system.dfu_enable && is_at_rest(machine).is_ok();
    if machine.world.ports.take_download_request(may_leave) {
        machine.features.update.is_asked = true;
    }
}

/// Does pending work about firmware when nothing else is to be done: true when there was some.
pub(crate) fn run_next<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    if machine.features.update.is_asked {
        machine.features.update.is_asked = false;
        if let Err(why) = download(machine, Recipient::All)
            && why.is_refusal()
        {
            machine.announce(format_args!(
                "WARNING: the firmware download that a host asked for: {}\n",
                machine.world.texts.of(why)
            ));
        }
        return true;
    }
    if machine.features.update.at_boot {
        machine.features.update.at_boot = false;
        install_at_boot(machine);
        return true;
    }
    if machine.features.update.is_confirmed && machine.features.update.from_file && is_at_rest(machine).is_ok() {
        machine.features.update.from_file = false;
        put_away(machine);
        return true;
    }
    false
}

/// Has the boot stage install the file (`flash`).
pub(crate) fn flash<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    is_at_rest(machine)?;
    machine.say(to, format_args!("looking at {FILE}\n"));
    let firmware = look_at_file(machine, to).map_err(|why| machine.world.texts.refused(format_args!("{why}")))?;
    if firmware.runs {
        return Err(Failure::refused(&"flashme.bin is the firmware that runs"));
    }
    install(machine, &firmware, to).map(|()| Answer::Ok)
}

/// Has the boot stage wait for firmware over USB (`dfu`).
///
/// # Errors
/// The machine is not at rest, or the card does not take the firmware that runs.
pub(crate) fn download<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    is_at_rest(machine)?;
    // The boot stage has room for one image: without a copy to come back to it takes no other.
    keep_previous(machine, to).map_err(|error| {
        machine.world.texts.refused(format_args!(
            "this firmware cannot be kept on the card, so that it could come back: {}",
            error.text()
        ))
    })?;
    is_at_rest(machine)?;
    if !machine.world.ports.ask_for_download() {
        return Err(Failure::refused(&"this board has no firmware download over USB"));
    }
    machine.record(&Event::UpdateAsked(Text::from("over USB")));
    machine.say(to, format_args!("the board waits for firmware over USB in a second; RESET starts this one again\n"));
    machine.world.ports.request_reset();
    Ok(Answer::Ok)
}

/// Refuses unless the machine can be left alone for a while.
fn is_at_rest<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    if machine.jobs.is_open() {
        return Err(Failure::refused(&"a job is under way: abort it first"));
    }
    if !machine.world.ports.motion(|motion| motion.is_idle()) {
        return Err(Failure::refused(&"the machine moves: stop it first"));
    }
    if machine.world.ports.heat(|heat| heat.any_on()) {
        return Err(Failure::refused(&"a heater is on: switch heaters off first"));
    }
    Ok(())
}

/// Installs the card's file at boot (`flash_on_boot`), unless it has failed or runs already.
fn install_at_boot<P: Ports>(machine: &mut Machine<'_, P>) {
    match machine.world.ports.open(FILE, OpenMode::Read) {
        Ok(file) => {
            // The file was only looked for.
            let _ = machine.world.ports.close(file);
        }
        Err(_) => return,
    }
    if let Err(why) = is_at_rest(machine)
        && why.is_refusal()
    {
        return machine.announce(format_args!("WARNING: {FILE} was not looked at: {}\n", machine.world.texts.of(why)));
    }
    let to = Recipient::All;
    match look_at_file(machine, to) {
        Ok(firmware) if firmware.runs => machine.features.update.from_file = true,
        Ok(firmware) if firmware.has_failed => machine.announce(format_args!(
            "WARNING: {FILE} was tried and failed, it is not installed again; the command flash does it all the same\n"
        )),
        // A second request would be refused again, and so on.
        Ok(firmware) if firmware.was_refused => machine
            .announce(format_args!("WARNING: {FILE} is not asked for again; the command flash does it all the same\n")),
        Ok(firmware) => {
            if let Err(why) = install(machine, &firmware, to)
                && why.is_refusal()
            {
                machine.announce(format_args!("ERROR: {FILE} was not installed: {}\n", machine.world.texts.of(why)));
            }
        }
        Err(why) => machine.announce(format_args!("ERROR: {FILE} was not installed: {why}\n")),
    }
}

fn install<P: Ports>(machine: &mut Machine<'_, P>, firmware: &Firmware, to: Recipient) -> Result<(), Failure> {
    keep_previous(machine, to).map_err(|error| machine.world.texts.about_file(PREVIOUS, error.text()))?;
    // Somebody may have begun something meanwhile.
    is_at_rest(machine)?;
    if !machine.world.ports.ask_for_install(firmware.id) {
        return Err(Failure::refused(&"the log of updates in flash takes no entry: install it with a debug probe"));
    }
    machine.record(&Event::UpdateAsked(Text::from(firmware.version.as_str())));
    machine.say(
        to,
        format_args!(
            "flashme.bin holds {}: it is installed in a second, which takes some 20 s; leave power on and the card in\n",
            firmware.version
        ),
    );
    machine.world.ports.request_reset();
    Ok(())
}

/// Looks at the firmware that the file holds.
fn look_at_file<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<Firmware, Flaw> {
    look_at(machine, FILE, to).unwrap_or_else(|error| {
        let mut why = Flaw::new();
        // Text that does not fit is cut.
        let _cut = core::fmt::Write::write_fmt(&mut why, format_args!("{}", about_file(FILE, error.text())));
        Err(why)
    })
}

fn look_at<P: Ports>(
    machine: &mut Machine<'_, P>,
    path: &str,
    to: Recipient,
) -> Result<Result<Firmware, Flaw>, StorageError> {
    card::at_rest(machine);
    let file = machine.world.ports.open(path, OpenMode::Read)?;
    machine.world.ports.begin_look();
    let read = read_through(&mut MachineHands::new(machine, to), file, u32::MAX, false, |ports, bytes| {
        ports.look(bytes);
        Ok(())
    });
    // The file was only read.
    let _ = machine.world.ports.close(file);
    match read {
        Ok(true) => Ok(machine.world.ports.end_look()),
        Ok(false) => Err(StorageError::Unsupported),
        Err(error) => Err(error),
    }
}

/// Copies the running firmware to the card, unless it is there. The boot stage takes a copy by either name,
/// and only a whole one; nothing is asked of it before the copy is kept.
fn keep_previous<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), StorageError> {
    let length = machine.world.ports.image_bytes();
    if length == 0 {
        return Ok(());
    }
    // Firmware on trial is not the one to come back to, where another has proved itself.
    let is_on_trial = matches!(machine.world.ports.running().arrival, Arrival::Trial { .. });
    if let Ok(Ok(previous)) = look_at(machine, PREVIOUS, to)
        && (previous.runs || is_on_trial && !previous.has_failed)
    {
        return Ok(());
    }
    machine.say(to, format_args!("keeping the firmware that runs as firmware.previous\n"));
    card::at_rest(machine);
    let file = machine.world.ports.open(DRAFT, OpenMode::Write)?;
    let copied = copy_image(machine, file, length);
    card::at_rest(machine);
    let closed = machine.world.ports.close(file);
    copied.and(closed)?;
    card::kept(machine)?;
    card::at_rest(machine);
    replace(machine, DRAFT, PREVIOUS)
}

fn copy_image<P: Ports>(
    machine: &mut Machine<'_, P>,
    file: base::ports::FileHandle,
    length: u32,
) -> Result<(), StorageError> {
    let mut at = 0;
    while at < length {
        let mut block = [0; BLOCK];
        let piece = block.get_mut(..(length - at).min(BLOCK as u32) as usize).unwrap_or_default();
        if !machine.world.ports.read_image(at, piece) {
            return Err(StorageError::Device);
        }
        at += piece.len() as u32;
        card::at_rest(machine);
        Storage::write(&mut machine.world.ports, file, piece)?;
        machine.wait(Wake::Any).whatever_happens();
    }
    Ok(())
}

/// Gives a file another name, in place of the file that has it.
fn replace<P: Ports>(machine: &mut Machine<'_, P>, from: &str, to: &str) -> Result<(), StorageError> {
    match machine.world.ports.remove(to) {
        Err(StorageError::NotFound) => {}
        removed => removed?,
    }
    card::at_rest(machine);
    machine.world.ports.rename(from, to)?;
    card::kept(machine)
}

/// Renames the installed file, whose firmware has confirmed itself: it is not to be installed again.
fn put_away<P: Ports>(machine: &mut Machine<'_, P>) {
    let is_that = matches!(look_at(machine, FILE, Recipient::Nobody), Ok(Ok(Firmware { runs: true, .. })));
    if !is_that {
        return;
    }
    card::at_rest(machine);
    if let Err(error) = replace(machine, FILE, INSTALLED) {
        machine.announce(format_args!("WARNING: {FILE} could not be renamed to flashme.old: {}\n", error.text()));
    }
}
