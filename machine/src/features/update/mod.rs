//! Other firmware: `flash`, `dfu`, the file that is installed at boot, and the running firmware's report on
//! itself.
//!
//! The boot stage installs firmware; here the file is looked at, and the running firmware copied to the card
//! as `firmware.previous`, so that the boot stage can put it back. None of that is hurried: everybody is
//! served meanwhile.

pub(crate) mod watch;

use base::failure::{Answer, Failure, Outcome, about_file};
use base::hands::Hands;
use base::own_frame::apart;
use base::ports::{
    Arrival, Board as _, FileHandle, Firmware, Flaw, OpenMode, Running, Storage, StorageError, Updates as _, Wake,
};
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use events::{Event, Text};
use jobs::files::copying::read_through;
use jobs::player::Jobs;
use parts::reports::{Came, failure};
use units::Micros;

use self::watch::Watch;
use crate::machine::Machine;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;

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

impl<'c, M: UpdateWork<'c>> Moments<M> for Feature {
    fn greet(running: &Running, reply: &mut Reply<'_>) {
        greet(running, reply);
    }

    fn started(hands: &mut M, is_usable: bool) {
        let (update, _, world) = hands.pending();
        begin(world, update, is_usable);
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        let (update, jobs, world) = hands.pending();
        apart(|| watch(world, jobs, update, now));
    }

    /// Does pending work about firmware when nothing else is to be done: true when there was some.
    fn idle(hands: &mut M) -> bool {
        let (watch, ..) = hands.pending();
        if !watch.waits() {
            return false;
        }
        if core::mem::take(&mut watch.is_asked) {
            download_for_host(&mut hands.update_sequence(Recipient::All));
            return true;
        }
        if core::mem::take(&mut watch.at_boot) {
            install_at_boot(&mut hands.update_sequence(Recipient::All));
            return true;
        }
        if watch.is_confirmed && watch.from_file {
            let hands = &mut hands.update_sequence(Recipient::Nobody);
            let rests = is_at_rest(hands).is_ok();
            if rests {
                hands.update().from_file = false;
                put_away(hands);
            }
            return rests;
        }
        false
    }
}

/// The machine for pending work about firmware.
pub(crate) trait UpdateWork<'c>: WorldHands<'c> {
    /// Returns the pending work, the jobs that it waits for, and the world.
    fn pending(&mut self) -> (&mut Watch, &Jobs, &mut World<'c, Self::Ports>);

    /// Returns hands for work about firmware that this recipient hears of.
    fn update_sequence(&mut self, to: Recipient) -> impl UpdateHands<'c>;
}

impl<'c, P: Ports> UpdateWork<'c> for Machine<'c, P> {
    fn pending(&mut self) -> (&mut Watch, &Jobs, &mut World<'c, P>) {
        (&mut self.features.update, &self.jobs, &mut self.world)
    }

    fn update_sequence(&mut self, to: Recipient) -> impl UpdateHands<'c> {
        MachineHands::new(self, to)
    }
}

/// Hands that also reach the pending work about firmware.
pub(crate) trait UpdateHands<'c>: Hands<'c> {
    /// Returns the pending work about firmware.
    fn update(&mut self) -> &mut Watch;

    /// Keeps an event, in the ring that survives a reset.
    fn record(&mut self, event: &Event);
}

impl<'c, P: Ports> UpdateHands<'c> for MachineHands<'_, 'c, P> {
    fn update(&mut self) -> &mut Watch {
        &mut self.machine.features.update
    }

    fn record(&mut self, event: &Event) {
        self.machine.record(event);
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
fn begin<P: Ports>(world: &mut World<'_, P>, update: &mut Watch, is_configured: bool) {
    let running = world.ports.running();
    match running.arrival {
        Arrival::Known | Arrival::Probe => {}
        Arrival::Trial { start, by_usb, .. } => {
            world.record(&Event::FirmwareTried { start });
            update.from_file = !by_usb;
        }
        Arrival::FellBack(by) => world.record(&Event::FirmwareFellBack(Text::from(failure(by)))),
    }
    if let Some(why) = running.refused {
        world.record(&Event::UpdateRefused(Text::from(why)));
    }
    if is_configured {
        let policy = &world.config.update;
        // A policy that nobody can mean unlocks nothing.
        if policy.is_sound()
            && let Err(why) = world.ports.set_policy(policy.key.as_ref(), policy.locked)
        {
            world.announce(format_args!("ERROR: config.ini: [update] key: {why}\n"));
        }
        update.at_boot = world.config.system.flash_on_boot;
    }
}

/// Confirms the firmware, and hears a host's wish for the download; every few milliseconds.
fn watch<P: Ports>(world: &mut World<'_, P>, jobs: &Jobs, update: &mut Watch, now: Micros) {
    if !update.is_confirmed && now >= CONFIRMED_AFTER {
        update.is_confirmed = true;
        let arrival = world.ports.running().arrival;
        world.ports.confirm();
        if matches!(arrival, Arrival::Trial { .. }) {
            world.record(&Event::FirmwareConfirmed);
        }
    }
    let may_leave = world.config.system.dfu_enable && rests(&mut world.ports, jobs.is_open()).is_ok();
    if world.ports.take_download_request(may_leave) {
        update.is_asked = true;
    }
}

/// Has the boot stage wait for firmware, as a host has asked.
fn download_for_host<'c>(hands: &mut impl UpdateHands<'c>) {
    if let Err(why) = download(hands)
        && why.is_refusal()
    {
        let why = hands.texts().of(why);
        hands.announce(format_args!("WARNING: the firmware download that a host asked for: {why}\n"));
    }
}

/// Has the boot stage install the file (`flash`).
pub(crate) fn flash<'c>(hands: &mut impl UpdateHands<'c>) -> Outcome {
    is_at_rest(hands)?;
    hands.say(format_args!("looking at {FILE}\n"));
    let firmware = look_at_file(hands).map_err(|why| hands.texts().refused(format_args!("{why}")))?;
    if firmware.runs {
        return Err(Failure::refused(&"flashme.bin is the firmware that runs"));
    }
    install(hands, &firmware).map(|()| Answer::Ok)
}

/// Has the boot stage wait for firmware over USB (`dfu`).
///
/// # Errors
/// The machine is not at rest, or the card does not take the firmware that runs.
pub(crate) fn download<'c>(hands: &mut impl UpdateHands<'c>) -> Outcome {
    is_at_rest(hands)?;
    // The boot stage has room for one image: without a copy to come back to it takes no other.
    keep_previous(hands).map_err(|error| {
        hands.texts().refused(format_args!(
            "this firmware cannot be kept on the card, so that it could come back: {}",
            error.text()
        ))
    })?;
    is_at_rest(hands)?;
    if !hands.storage().ask_for_download() {
        return Err(Failure::refused(&"this board has no firmware download over USB"));
    }
    hands.record(&Event::UpdateAsked(Text::from("over USB")));
    hands.say(format_args!("the board waits for firmware over USB in a second; RESET starts this one again\n"));
    hands.storage().request_reset();
    Ok(Answer::Ok)
}

/// Refuses unless the machine can be left alone for a while.
fn is_at_rest<'c>(hands: &mut impl UpdateHands<'c>) -> Result<(), Failure> {
    let has_job = hands.has_job();
    rests(hands.storage(), has_job)
}

fn rests<P: Ports>(ports: &mut P, has_job: bool) -> Result<(), Failure> {
    if has_job {
        return Err(Failure::refused(&"a job is under way: abort it first"));
    }
    if !ports.motion(|motion| motion.is_idle()) {
        return Err(Failure::refused(&"the machine moves: stop it first"));
    }
    if ports.heat(|heat| heat.any_on()) {
        return Err(Failure::refused(&"a heater is on: switch heaters off first"));
    }
    Ok(())
}

/// Installs the card's file at boot (`flash_on_boot`), unless it has failed or runs already.
fn install_at_boot<'c>(hands: &mut impl UpdateHands<'c>) {
    let texts = hands.texts();
    match hands.storage().open(FILE, OpenMode::Read) {
        Ok(file) => {
            // The file was only looked for.
            let _ = hands.storage().close(file);
        }
        Err(_) => return,
    }
    if let Err(why) = is_at_rest(hands)
        && why.is_refusal()
    {
        return hands.announce(format_args!("WARNING: {FILE} was not looked at: {}\n", texts.of(why)));
    }
    match look_at_file(hands) {
        Ok(firmware) if firmware.runs => hands.update().from_file = true,
        Ok(firmware) if firmware.has_failed => hands.announce(format_args!(
            "WARNING: {FILE} was tried and failed, it is not installed again; the command flash does it all the same\n"
        )),
        // A second request would be refused again, and so on.
        Ok(firmware) if firmware.was_refused => hands
            .announce(format_args!("WARNING: {FILE} is not asked for again; the command flash does it all the same\n")),
        Ok(firmware) => {
            if let Err(why) = install(hands, &firmware)
                && why.is_refusal()
            {
                hands.announce(format_args!("ERROR: {FILE} was not installed: {}\n", texts.of(why)));
            }
        }
        Err(why) => hands.announce(format_args!("ERROR: {FILE} was not installed: {why}\n")),
    }
}

fn install<'c>(hands: &mut impl UpdateHands<'c>, firmware: &Firmware) -> Result<(), Failure> {
    keep_previous(hands).map_err(|error| hands.texts().about_file(PREVIOUS, error.text()))?;
    // Somebody may have begun something meanwhile.
    is_at_rest(hands)?;
    if !hands.storage().ask_for_install(firmware.id) {
        return Err(Failure::refused(&"the log of updates in flash takes no entry: install it with a debug probe"));
    }
    hands.record(&Event::UpdateAsked(Text::from(firmware.version.as_str())));
    hands.say(format_args!(
        "flashme.bin holds {}: it is installed in a second, which takes some 20 s; leave power on and the card in\n",
        firmware.version
    ));
    hands.storage().request_reset();
    Ok(())
}

/// Looks at the firmware that the file holds.
fn look_at_file<'c>(hands: &mut impl UpdateHands<'c>) -> Result<Firmware, Flaw> {
    look_at(hands, FILE).unwrap_or_else(|error| {
        let mut why = Flaw::new();
        // Text that does not fit is cut.
        let _cut = core::fmt::Write::write_fmt(&mut why, format_args!("{}", about_file(FILE, error.text())));
        Err(why)
    })
}

fn look_at<'c>(hands: &mut impl UpdateHands<'c>, path: &str) -> Result<Result<Firmware, Flaw>, StorageError> {
    hands.card_at_rest();
    let file = hands.storage().open(path, OpenMode::Read)?;
    hands.storage().begin_look();
    let read = read_through(hands, file, u32::MAX, false, |ports, bytes| {
        ports.look(bytes);
        Ok(())
    });
    // The file was only read.
    let _ = hands.storage().close(file);
    match read {
        Ok(true) => Ok(hands.storage().end_look()),
        Ok(false) => Err(StorageError::Unsupported),
        Err(error) => Err(error),
    }
}

/// Copies the running firmware to the card, unless it is there. The boot stage takes a copy by either name,
/// and only a whole one; nothing is asked of it before the copy is kept.
fn keep_previous<'c>(hands: &mut impl UpdateHands<'c>) -> Result<(), StorageError> {
    let length = hands.storage().image_bytes();
    if length == 0 {
        return Ok(());
    }
    // Firmware on trial is not the one to come back to, where another has proved itself.
    let is_on_trial = matches!(hands.storage().running().arrival, Arrival::Trial { .. });
    if let Ok(Ok(previous)) = look_at(hands, PREVIOUS)
        && (previous.runs || is_on_trial && !previous.has_failed)
    {
        return Ok(());
    }
    hands.say(format_args!("keeping the firmware that runs as firmware.previous\n"));
    hands.card_at_rest();
    let file = hands.storage().open(DRAFT, OpenMode::Write)?;
    let copied = copy_image(hands, file, length);
    hands.card_at_rest();
    let closed = hands.storage().close(file);
    copied.and(closed)?;
    hands.card_has_kept()?;
    hands.card_at_rest();
    replace(hands, DRAFT, PREVIOUS)
}

fn copy_image<'c>(hands: &mut impl UpdateHands<'c>, file: FileHandle, length: u32) -> Result<(), StorageError> {
    let mut at = 0;
    while at < length {
        let mut block = [0; BLOCK];
        let piece = block.get_mut(..(length - at).min(BLOCK as u32) as usize).unwrap_or_default();
        if !hands.storage().read_image(at, piece) {
            return Err(StorageError::Device);
        }
        at += piece.len() as u32;
        hands.card_at_rest();
        Storage::write(hands.storage(), file, piece)?;
        hands.wait(Wake::Any).whatever_happens();
    }
    Ok(())
}

/// Gives a file another name, in place of the file that has it.
fn replace<'c>(hands: &mut impl UpdateHands<'c>, from: &str, to: &str) -> Result<(), StorageError> {
    match hands.storage().remove(to) {
        Err(StorageError::NotFound) => {}
        removed => removed?,
    }
    hands.card_at_rest();
    hands.storage().rename(from, to)?;
    hands.card_has_kept()
}

/// Renames the installed file, whose firmware has confirmed itself: it is not to be installed again.
fn put_away<'c>(hands: &mut impl UpdateHands<'c>) {
    let is_that = matches!(look_at(hands, FILE), Ok(Ok(Firmware { runs: true, .. })));
    if !is_that {
        return;
    }
    hands.card_at_rest();
    if let Err(error) = replace(hands, FILE, INSTALLED) {
        hands.announce(format_args!("WARNING: {FILE} could not be renamed to flashme.old: {}\n", error.text()));
    }
}
