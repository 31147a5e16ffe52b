//! The card as the computer's disk: its owner, and its fate when card or computer goes.

use usb_host::transfer::Request;
use virtual_prime::usb_desk::bulk_only::{BulkOnly, Data};
use virtual_prime::usb_desk::scsi::{Disk, Sense};

use super::velvet::{Plugged, plug};
use crate::common::MS;
use crate::common::machine::{changes, watch};
use crate::common::velvet::{Plan, SECOND};

/// Greatest number of blocks that Linux asks for in a command: 240.
const COMMAND_BLOCKS: u16 = 240;
const LENT: &str = "The computer has the SD card";
const BACK: &str = "// NOTICE the computer has given the SD card back";
const GONE: &str = "// NOTICE the computer has gone: the machine has the SD card again";
const NOT_HERE: &str = "a computer uses the SD card over USB: eject it there first";
/// Sense data: medium not present; not ready to ready, the medium may have changed.
const EMPTY: Sense = Sense { key: 2, code: 0x3A, qualifier: 0 };
const CHANGED: Sense = Sense { key: 6, code: 0x28, qualifier: 0 };

pub fn with_reader() -> Plan {
    Plan::new().set("[system] msc_enable = true")
}

impl Plugged {
    /// Returns the board's card reader.
    pub fn disk(&self) -> Disk {
        Disk { transport: BulkOnly::of(&self.device).expect("a card reader"), lun: 0 }
    }

    /// Lends the card to the computer.
    #[track_caller]
    pub fn lend(&mut self) -> Disk {
        let said = self.velvet.ask("msc", SECOND);
        assert!(said.contains(LENT), "{said}");
        let mut disk = self.disk();
        assert_eq!(disk.ready(&mut self.desk()), Ok(Err(CHANGED)));
        assert_eq!(disk.ready(&mut self.desk()), Ok(Ok(())));
        disk
    }

    fn content(&mut self) -> Vec<u8> {
        self.velvet.card(|card| card.content().to_vec())
    }
}

#[test]
fn the_reader_is_empty_until_msc_and_after_the_card_was_ejected() {
    let mut plugged = plug(with_reader().file("part.g", "G4 P1\n"));
    let mut disk = plugged.disk();
    assert_eq!(disk.transport.max_lun(&mut plugged.desk()), Ok(0));
    let inquiry = disk.inquiry(&mut plugged.desk()).unwrap();
    assert_eq!((inquiry.kind, inquiry.removable, inquiry.vendor.as_str()), (0, true, "Velvet"));
    assert_eq!(disk.ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    let mut disk = plugged.lend();
    let content = plugged.content();
    let blocks = content.len() / 512;
    assert_eq!(disk.capacity(&mut plugged.desk()), Ok((blocks as u64, 512)));
    assert_eq!(disk.is_protected(&mut plugged.desk()), Ok(false));
    assert_eq!(disk.read(&mut plugged.desk(), 0, 1).unwrap(), content[..512]);
    // A command that needs files is answered with the reason; and no second loan begins.
    for line in ["M20", "play part.g", "cat part.g", "M500", "M21", "M28 b.g", "M29"] {
        plugged.velvet.type_in(line);
        let said = plugged.velvet.hear(300);
        assert!(line == "M29" || said.contains(NOT_HERE), "{line}: {said}");
    }
    let said = plugged.velvet.ask("msc", SECOND);
    assert!(said.contains("a computer has the SD card already"), "{said}");
    disk.synchronize(&mut plugged.desk()).unwrap();
    disk.prevent_removal(&mut plugged.desk(), true).unwrap();
    assert!(disk.load(&mut plugged.desk(), false).is_err(), "what may not be removed is not ejected");
    disk.prevent_removal(&mut plugged.desk(), false).unwrap();
    disk.load(&mut plugged.desk(), false).unwrap();
    plugged.velvet.hear_until(BACK, SECOND);
    assert_eq!(disk.ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    let said = plugged.velvet.ask("ls -1", SECOND);
    assert!(said.to_lowercase().contains("part.g"), "{said}");
    // The card can be lent again.
    plugged.lend();
    assert!(plugged.velvet.ask("msc off", SECOND).contains("ok"));
    plugged.velvet.hear_until(BACK, SECOND);
    assert_eq!(disk.ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    plugged.assert_clean();
}

/// Files from the computer reach the machine, and back, at the required speed.
#[test]
fn files_go_both_ways_with_700_kilobytes_a_second_and_more() {
    let mut plugged = plug(with_reader().file("large.g", &"G1 X1 ; a line\n".repeat(30_000)));
    let mut disk = plugged.lend();
    let content = plugged.content();
    let run = u32::from(COMMAND_BLOCKS);
    let blocks = (content.len() / 512) as u32 / run * run;
    let began = plugged.velvet.bench.vm.now_ns();
    let commands = (blocks / run).min(5);
    for command in 0..commands {
        let read = disk.read(&mut plugged.desk(), command * run, COMMAND_BLOCKS).unwrap();
        let from = (command * run) as usize * 512;
        assert!(read == content[from..from + read.len()], "the blocks of the card");
    }
    let read_ns = plugged.velvet.bench.vm.now_ns() - began;
    // The blocks lie behind the files, so that the volume stays whole.
    let end = (content.len() / 512) as u32 - commands * run;
    let data: Vec<u8> = (0..commands * run * 512).map(|at| (at * 31 >> 5) as u8).collect();
    let began = plugged.velvet.bench.vm.now_ns();
    for (command, bytes) in (0..).zip(data.chunks(run as usize * 512)) {
        disk.write(&mut plugged.desk(), end + command * run, bytes).unwrap();
    }
    let write_ns = plugged.velvet.bench.vm.now_ns() - began;
    assert!(plugged.content()[end as usize * 512..] == data, "it is on the card when the status says so");
    let rate = |ns: u64| data.len() as u64 * 1_000_000 / ns;
    println!("{} kB/s from the card, {} kB/s to it, {} bytes", rate(read_ns), rate(write_ns), data.len());
    assert!(rate(read_ns) >= 700 && rate(write_ns) >= 700, "{} and {} kB/s", rate(read_ns), rate(write_ns));
    disk.load(&mut plugged.desk(), false).unwrap();
    plugged.velvet.hear_until(BACK, SECOND);
    let said = plugged.velvet.ask("card", 5 * SECOND);
    assert!(said.contains("MB free of") && said.contains("damaged 0"), "{said}");
    plugged.assert_clean();
}

#[test]
fn what_uses_the_card_keeps_it() {
    let mut plugged = plug(with_reader().file("long.g", &"G4 P100\n".repeat(40)));
    plugged.velvet.ask("M28 new.g", SECOND);
    // Lines typed now go into the file, so another console asks.
    plugged.open(0);
    assert!(plugged.say(0, "M105").contains("ok"));
    let port = plugged.ports[0];
    port.write(&mut plugged.desk(), b"msc\n").unwrap();
    let said = plugged.hear_until(0, "\n");
    assert!(said.contains("files are open"), "{said}");
    plugged.velvet.ask("M29", SECOND);
    plugged.velvet.type_in("play long.g");
    plugged.velvet.hear(300);
    let said = plugged.velvet.ask("msc", SECOND);
    assert!(said.contains("a file is played: wait for its end, or abort it"), "{said}");
    let mut disk = plugged.disk();
    assert_eq!(disk.ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    plugged.assert_clean();
}

/// The reader exists only with `msc_enable`.
#[test]
fn without_the_setting_there_is_no_reader() {
    let mut plugged = plug(Plan::new());
    assert!(BulkOnly::of(&plugged.device).is_none());
    let said = plugged.velvet.ask("msc", SECOND);
    assert!(said.contains("MSC is disabled: [system] msc_enable"), "{said}");
    plugged.assert_clean();
}

/// The lamp `msc_led` blinks while the computer has the card.
#[test]
fn a_lamp_says_who_has_the_card() {
    let mut plugged = plug(with_reader());
    assert!(!plugged.velvet.level("PF13"));
    let mut disk = plugged.lend();
    watch(&mut plugged.velvet, &["PF13"]);
    plugged.velvet.hear(2 * SECOND);
    let blinks = changes(&mut plugged.velvet).len();
    assert!((5..=8).contains(&blinks), "{blinks} changes in two seconds");
    disk.load(&mut plugged.desk(), false).unwrap();
    plugged.velvet.hear_until(BACK, SECOND);
    plugged.velvet.hear(200);
    assert!(!plugged.velvet.level("PF13"));
    plugged.assert_clean();
}

/// The cable is pulled out while blocks go both ways. After some seconds the machine has its card again, with
/// all acknowledged blocks on it.
#[test]
fn a_computer_that_goes_leaves_the_card() {
    let mut plugged = plug(with_reader().file("part.g", "G4 P1\n"));
    for writes in [false, true] {
        let mut disk = plugged.lend();
        let first = (plugged.content().len() / 512) as u32 - 200;
        let data = vec![if writes { 0x5A } else { 0xA5 }; 8 * 512];
        disk.write(&mut plugged.desk(), first, &data).unwrap();
        let mut command = [if writes { 0x2A } else { 0x28 }, 0, 0, 0, 0, 0, 0, 0, 199, 0];
        command[2..6].copy_from_slice(&(first + 1).to_be_bytes());
        let bytes = vec![0x33; 199 * 512];
        let expects = if writes { Data::Out(&bytes) } else { Data::In(bytes.len()) };
        let wrapper = BulkOnly::wrapper(77, 0, &command, expects);
        let mut desk = plugged.desk();
        desk.write(disk.transport.output, &wrapper).unwrap();
        let (endpoint, request) = if writes {
            (disk.transport.output, Request::Out { data: bytes.clone(), zero: false })
        } else {
            (disk.transport.input, Request::In(bytes.len()))
        };
        desk.submit(endpoint, request);
        desk.pass_ms(37).unwrap();
        desk.unplug();
        assert_eq!(plugged.velvet.ask("M20", SECOND).matches(NOT_HERE).count(), 1, "not at once: it may be a hub");
        plugged.velvet.hear_until(GONE, 6 * SECOND);
        let listed = plugged.velvet.ask("ls -1", SECOND);
        assert!(listed.to_lowercase().contains("part.g"), "{listed}");
        let place = first as usize * 512;
        let content = plugged.content();
        assert_eq!(content[place..place + 512], data[..512], "what was acknowledged");
        let mut desk = plugged.desk();
        desk.plug();
        plugged.device = plugged.desk().enumerate().unwrap();
        assert_eq!(plugged.disk().ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    }
    plugged.assert_clean();
}

/// A cable that is put in anew soon, and a bus that is reset, leave the card with the same computer.
#[test]
fn a_cable_put_in_anew_finds_the_card() {
    let mut plugged = plug(with_reader());
    plugged.lend();
    plugged.desk().unplug();
    plugged.desk().pass_ms(900).unwrap();
    plugged.desk().plug();
    plugged.device = plugged.desk().enumerate().unwrap();
    assert_eq!(plugged.disk().ready(&mut plugged.desk()), Ok(Ok(())));
    let mut disk = plugged.disk();
    disk.load(&mut plugged.desk(), false).unwrap();
    plugged.velvet.hear_until(BACK, SECOND);
    plugged.desk().unplug();
    plugged.velvet.hear(100);
    let said = plugged.velvet.ask("msc", SECOND);
    assert!(said.contains("no computer is at the USB socket"), "{said}");
    plugged.assert_clean();
}

/// The card is taken out of the slot while the computer has it.
#[test]
fn a_card_taken_out_is_gone_for_the_computer_too() {
    let mut plugged = plug(with_reader());
    let mut disk = plugged.lend();
    let content = plugged.content();
    plugged.velvet.bench.vm.with(|stopped| stopped.session.board_mut().insert_card(None));
    assert!(disk.read(&mut plugged.desk(), 0, 8).is_err());
    plugged.velvet.hear_until("// NOTICE the SD card was taken out", 3 * SECOND);
    plugged.velvet.hear(100);
    assert!(plugged.velvet.said().contains(BACK));
    assert_eq!(disk.ready(&mut plugged.desk()), Ok(Err(EMPTY)));
    plugged.velvet.bench.vm.with(move |stopped| stopped.session.board_mut().insert_card(Some(content)));
    plugged.velvet.hear_until("// NOTICE an SD card was put in", 4 * SECOND);
    plugged.lend();
    assert!(plugged.velvet.bench.vm.now_ns() > 5 * MS);
    plugged.assert_clean();
}
