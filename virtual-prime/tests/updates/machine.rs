//! The machine's part in updates: requests to the boot stage, and the firmware's confirmation. Settings:
//! `[system] flash_on_boot`, `[update] key`, `[update] locked`.

use std::path::PathBuf;

use rigless::soc::Width;
use update::{Entry, MANIFEST_BYTES, Origin, PRIME};
use virtual_prime::sd_image;

use super::cuts::SHORT;
use super::small::{Came, Small, application, flash, known, linked, log};
use super::{Row, Share, tests};
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet, image};

pub const ROWS: &[Row] = &[Row {
    name: "keeping_the_firmware_is_cut",
    what: "at a block that is written to the card while what runs is kept as firmware.previous",
    does: "nothing was asked of the boot stage yet: what runs goes on, and flash begins again",
    run: keeping_is_cut,
}];

tests! { keeping_the_firmware_is_cut }

/// Time to check a file of the size of the image, and to copy the image, on the card.
const COPY_MS: u64 = 60 * SECOND;
/// Size of a block, bytes.
const BLOCK: usize = 512;
/// Time to install the image, with its 14 sectors.
const INSTALL_MS: u64 = 60 * SECOND;

/// Returns the image under test, as it lies in flash from its manifest on.
fn running() -> Vec<u8> {
    let whole = std::fs::read(image().with_file_name("firmware.bin")).expect("make firmware writes it");
    whole[PRIME.image() as usize..].to_vec()
}

/// Returns the image under test with another version in its manifest.
fn other() -> Vec<u8> {
    let mut other = running();
    other[24..64].fill(0);
    other[24..29].copy_from_slice(b"9.9.9");
    update::seal(&mut other, &PRIME, None).expect("an image");
    other
}

/// Writes the image under test, signed, as an ELF file.
fn signed(key: &[u8; 32]) -> PathBuf {
    let mut bytes = running();
    update::seal(&mut bytes, &PRIME, Some(key)).expect("an image");
    let mut elf = std::fs::read(image()).expect("the image");
    let place = {
        let file = object::File::parse(&*elf).expect("an ELF file");
        let section = object::Object::section_by_name(&file, ".manifest").expect("a manifest");
        object::ObjectSection::file_range(&section).expect("it is in the file").0 as usize
    };
    elf[place..place + MANIFEST_BYTES].copy_from_slice(&bytes[..MANIFEST_BYTES]);
    let path = std::env::temp_dir().join(format!("velvet-signed-{}.elf", std::process::id()));
    std::fs::write(&path, elf).expect("a temporary file");
    path
}

fn on_card(velvet: &mut Velvet, name: &'static str) -> Option<Vec<u8>> {
    velvet.card(move |card| sd_image::read(card.content(), name).ok())
}

fn mark(velvet: &mut Velvet) -> u32 {
    let read = |stopped: &mut virtual_prime::vm::Stopped<'_>| stopped.host.read(0x2407_FFF0, Width::W32);
    velvet.bench.vm.with(read).expect("the run goes on").expect("AXI SRAM") as u32
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Tests an update from `flash` to the confirmation, with images of full size.
#[test]
#[ignore = "long: make updates"]
fn firmware_is_installed_from_the_card_and_confirms_itself() {
    let file = [other(), update::trailer(&other()).to_vec()].concat();
    let mut velvet = Plan::new().bytes("flashme.bin", file).set("[system] flash_on_boot = false").start();
    velvet.type_in("version");
    velvet.hear_until("Firmware: put there by a debug probe", SECOND);
    velvet.ask("M104 S50", SECOND);
    assert!(velvet.ask("flash", SECOND).contains("a heater is on"));
    velvet.ask("M104 S0", SECOND);
    velvet.type_in("flash");
    let said = velvet.hear_until("it is installed in a second", COPY_MS);
    assert!(said.contains("keeping the firmware that runs") && said.contains("9.9.9"), "{said}");
    assert_eq!(on_card(&mut velvet, "firmware.previous").as_deref(), Some(running().as_slice()));
    let said = velvet.hear_until(PROMPT, INSTALL_MS);
    assert!(said.contains("NOTICE new firmware, from the card: start 1 of 3"), "{said}");
    velvet.type_in("version");
    velvet.hear_until("Firmware: new firmware, from the card", SECOND);
    velvet.hear(11 * SECOND);
    assert!(velvet.ask("events", 2 * SECOND).contains("the new firmware stays"));
    velvet.type_in("version");
    velvet.hear_until("Firmware: runs as before", SECOND);
    velvet.hear(5 * SECOND);
    assert!(on_card(&mut velvet, "flashme.old").is_some() && on_card(&mut velvet, "flashme.bin").is_none());
    velvet.type_in("reset");
    let said = velvet.hear_until(PROMPT, 4 * SECOND);
    assert!(!said.contains("NOTICE"), "{said}");
}

/// Tests files that `flash` refuses: no firmware, damaged, not sealed, and the running firmware itself.
#[test]
fn a_file_is_looked_at_before_anything_is_asked() {
    let mut flawed = application(2, SHORT, None);
    flawed[SHORT - 1] ^= 1;
    let mut velvet = Plan::new()
        .set("[system] flash_on_boot = false")
        .bytes("a.bin", b"G1 X10\n".repeat(100))
        .bytes("b.bin", flawed)
        .bytes("c.bin", linked(2, SHORT))
        .bytes("d.bin", running())
        .start();
    assert!(velvet.ask("flash", SECOND).contains("flashme.bin: "));
    for (name, words) in [
        ("a", "this is no Velvet firmware"),
        ("b", "SHA-256 does not match"),
        ("c", "linked but not sealed"),
        ("d", "is the firmware that runs"),
    ] {
        velvet.ask(&format!("mv /sd/{name}.bin /sd/flashme.bin"), SECOND);
        let said = velvet.ask("flash", 10 * SECOND);
        assert!(said.contains(words), "{name}: {said}");
        velvet.type_in("rm /sd/flashme.bin");
        velvet.hear_until("deleted", SECOND);
    }
    assert!(on_card(&mut velvet, "firmware.previous").is_none(), "nothing was begun");
}

/// Tests `flash_on_boot`: a file on the card is installed, unless it is no firmware.
#[test]
fn the_file_is_installed_at_boot() {
    let mut velvet =
        Plan::new().set("[system] flash_on_boot = true").bytes("flashme.bin", b"hello".repeat(100)).start();
    velvet.hear(SECOND);
    assert!(velvet.said().contains("was not installed: this is no Velvet firmware"), "{}", velvet.said());
    // A previous firmware from an earlier update is on the card.
    let mut velvet = Plan::new()
        .set("[system] flash_on_boot = true")
        .bytes("flashme.bin", application(2, SHORT, None))
        .bytes("firmware.previous", application(3, SHORT, None))
        .start();
    while !velvet.said().contains("flashme.bin holds small: it is installed") {
        assert!(velvet.now_ms() < COPY_MS, "{}", velvet.said());
        velvet.hear(100);
    }
    velvet.hear(5 * SECOND);
    assert_eq!(mark(&mut velvet), 0x5EED_0002);
    assert_eq!(on_card(&mut velvet, "firmware.previous").as_deref(), Some(running().as_slice()));
}

/// A file that the boot stage could not install is not asked for at every start again.
#[test]
fn a_file_that_was_refused_is_not_asked_for_again() {
    let mut velvet = Plan::new()
        .set("[system] flash_on_boot = true")
        .bytes("flashme.bin", application(2, SHORT, None))
        .bytes("firmware.previous", running())
        .start();
    velvet.hear_until("flashme.bin holds small: it is installed", COPY_MS);
    let take = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        let content = stopped.session.board_mut().mcu.sdmmc.card_mut().expect("a card").content().to_vec();
        stopped.session.board_mut().insert_card(None);
        content
    };
    let content = velvet.bench.vm.with(take).expect("the run goes on");
    velvet.hear_until("flashme.bin was not there any more", 4 * SECOND);
    velvet.hear(SECOND);
    let put = move |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        stopped.session.board_mut().insert_card(Some(content));
    };
    velvet.bench.vm.with(put).expect("the run goes on");
    velvet.hear(4 * SECOND);
    velvet.type_in("reset");
    velvet.hear_until("flashme.bin is not asked for again", 6 * SECOND);
    velvet.type_in("flash");
    velvet.hear_until("it is installed in a second", COPY_MS);
    velvet.hear(5 * SECOND);
    assert_eq!(mark(&mut velvet), 0x5EED_0002);
}

/// Only firmware that has proved itself becomes the previous firmware.
#[test]
fn firmware_on_trial_does_not_take_the_place_of_the_previous_one() {
    let (previous, running) = (application(1, SHORT, None), running());
    let mut content = flash(&running);
    log(&mut content, Entry::Installed(Origin::File, known(&running)));
    let elf = std::env::temp_dir().join(format!("velvet-on-trial-{}.elf", std::process::id()));
    std::fs::write(&elf, content.elf()).expect("a temporary file");
    let mut velvet = Plan::new()
        .image(elf.clone())
        .set("[system] flash_on_boot = false")
        .bytes("flashme.bin", application(2, SHORT, None))
        .bytes("firmware.previous", previous.clone())
        .start();
    let _ = std::fs::remove_file(elf);
    assert!(velvet.said().contains("start 1 of 3"), "{}", velvet.said());
    velvet.type_in("flash");
    velvet.hear_until("it is installed in a second", COPY_MS);
    assert_eq!(on_card(&mut velvet, "firmware.previous"), Some(previous));
}

/// A lock that would shut out the running firmware is not closed; behind a lock, only files that the owner
/// has signed are installed.
#[test]
fn the_owner_locks_the_board() {
    let owner = [7; 32];
    let key = hexadecimal(&update::public_key(&owner));
    let locked = |plan: Plan| {
        plan.set("[system] flash_on_boot = false").set(&format!("[update] key = {key}")).set("[update] locked = true")
    };
    let velvet = locked(Plan::new()).start();
    assert!(velvet.said().contains("the firmware that runs is not signed with it"), "{}", velvet.said());
    let elf = signed(&owner);
    let mut velvet = locked(Plan::new().image(elf.clone()))
        .bytes("flashme.bin", application(2, SHORT, None))
        .bytes("good.bin", application(3, SHORT, Some(&owner)))
        .start();
    let _ = std::fs::remove_file(elf);
    assert!(!velvet.said().contains("ERROR"), "{}", velvet.said());
    let said = velvet.ask("flash", SECOND);
    assert!(said.contains("this board is locked, and the image is not signed"), "{said}");
    velvet.type_in("rm /sd/flashme.bin");
    velvet.hear_until("deleted", SECOND);
    velvet.ask("mv /sd/good.bin /sd/flashme.bin", SECOND);
    velvet.type_in("flash");
    velvet.hear_until("it is installed in a second", COPY_MS);
    velvet.hear(5 * SECOND);
    assert_eq!(mark(&mut velvet), 0x5EED_0003);
}

/// Tests `dfu`, and RESET, which starts the firmware again.
#[test]
fn the_board_waits_for_firmware_over_usb_when_it_is_asked_to() {
    let mut velvet = Plan::new().set("[system] flash_on_boot = false").start();
    velvet.type_in("dfu");
    velvet.hear_until("boot stage: waits for firmware over USB", COPY_MS);
    assert_eq!(on_card(&mut velvet, "firmware.previous").as_deref(), Some(running().as_slice()));
    velvet.hear(SECOND);
    let press = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
        stopped.session.reset_by_pin(stopped.stop.at, stopped.stop.instruction_count, stopped.host);
    };
    velvet.bench.vm.with(press).expect("the run goes on");
    velvet.hear_until(PROMPT, 3 * SECOND);
    // After more than a second a press counts as the first again.
    velvet.hear(2 * SECOND);
    velvet.bench.vm.with(press).expect("the run goes on");
    velvet.hear_until(PROMPT, 3 * SECOND);
    // Two presses come within a second.
    velvet.hear(2 * SECOND);
    velvet.bench.vm.with(press).expect("the run goes on");
    velvet.hear(300);
    velvet.bench.vm.with(press).expect("the run goes on");
    velvet.hear_until("boot stage: waits for firmware over USB", 2 * SECOND);
}

/// Asserts that a download that the boot stage would refuse changes nothing: the machine goes on as it was.
#[test]
fn without_a_card_the_board_does_not_leave_for_the_download() {
    let mut velvet = Plan::new().start();
    velvet.bench.vm.with(|stopped| stopped.session.board_mut().insert(None)).expect("the run goes on");
    velvet.hear_until("the SD card was taken out", 2 * SECOND);
    velvet.type_in("dfu");
    velvet.hear_until("this firmware cannot be kept on the card, so that it could come back", 2 * SECOND);
    velvet.hear(2 * SECOND);
    assert!(!velvet.said().contains("boot stage"), "{}", velvet.said());
    velvet.ask("G28.6", SECOND);
}

/// Cuts the power at block writes while `flash` keeps the running firmware on the card: the block is half
/// new, and earlier ones are kept.
fn keeping_is_cut(share: Share) -> usize {
    let plan = || Plan::new().set("[system] flash_on_boot = false");
    let mut velvet = plan().bytes("flashme.bin", application(2, SHORT, None)).keeping_writes().start();
    let before = velvet.card(|card| card.content().to_vec());
    let earlier = velvet.block_writes().len();
    velvet.type_in("flash");
    velvet.hear_until("it is installed in a second", COPY_MS);
    let writes = velvet.block_writes().split_off(earlier);
    assert!(writes.len() * BLOCK > running().len(), "{} blocks", writes.len());
    let card_at = |cut: usize| {
        let mut card = before.clone();
        for (number, write) in writes[..=cut].iter().enumerate() {
            let bytes = if number == cut { &write.bytes[..BLOCK / 2] } else { &write.bytes[..] };
            let at = write.block as usize * BLOCK;
            card[at..at + bytes.len()].copy_from_slice(bytes);
        }
        card
    };
    let step = writes.len().div_ceil(if share == Share::Quick { 2 } else { 150 });
    let ends = writes.len().saturating_sub(if share == Share::Quick { 1 } else { 40 })..writes.len();
    let cuts: Vec<usize> = (0..writes.len()).step_by(step).chain(ends).collect();
    let mut tried = 0;
    for cut in cuts {
        let card = card_at(cut);
        let mut board = Small::on(&flash(&application(1, SHORT, None)), Some(&card));
        assert_eq!(board.settle(INSTALL_MS), Came::Runs(1), "at {cut} of {}: {}", writes.len(), board.said());
        tried += 1;
    }
    let half = card_at(writes.len() / 2);
    let mut velvet = plan().with_card(move |_| half.clone()).start();
    velvet.type_in("flash");
    velvet.hear_until("it is installed in a second", COPY_MS);
    assert_eq!(on_card(&mut velvet, "firmware.previous").as_deref(), Some(running().as_slice()));
    tried + 1
}
