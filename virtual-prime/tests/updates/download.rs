//! Firmware over USB, by a host that behaves as dfu-util does.

use update::{Arrival, Origin, PRIME};
use virtual_prime::flash_journal::{FlashContent, Operation, Torn};
use virtual_prime::usb_desk::dfu::{Dfu, state};
use virtual_prime::usb_desk::{Device, UsbHost};

use super::cuts::SHORT;
use super::small::{Came, Small, after, application, card, flash, known};
use super::{Row, Share, tests};
use crate::common::MS;

pub const ROWS: &[Row] = &[
    Row {
        name: "a_download_in_every_form",
        what: "nothing: an image comes alone, with the trailer, or for the whole flash",
        does: "it runs, on trial; it can be read back",
        run: forms,
    },
    Row {
        name: "a_download_that_may_not_run",
        what: "the image is for another board, or none",
        does: "the host is told before anything is touched; what ran before runs again",
        run: |_| refused(),
    },
    Row {
        name: "a_download_with_nothing_to_come_back_to",
        what: "there is no card, or no firmware on it that may run",
        does: "the host is told before anything is touched; what ran before runs again",
        run: |_| no_copy(),
    },
    Row {
        name: "a_download_that_is_not_whole",
        what: "the image ends too soon, its SHA-256 is wrong, or the cable is pulled out",
        does: "it is not started; the previous firmware comes back from the card",
        run: not_whole,
    },
    Row {
        name: "a_download_is_cut",
        what: "the power fails at an erase or a word of a download",
        does: "the previous firmware comes back from the card, where the new one is not whole",
        run: cut,
    },
    Row {
        name: "a_download_to_an_empty_board_is_cut",
        what: "the same, and there was no firmware before",
        does: "the board waits for the download to be repeated, and takes it",
        run: empty_is_cut,
    },
];

tests! {
    a_download_in_every_form
    a_download_that_may_not_run
    a_download_with_nothing_to_come_back_to
    a_download_that_is_not_whole
    a_download_is_cut
    a_download_to_an_empty_board_is_cut
}

const PATIENCE_MS: u64 = 20_000;
/// Greatest size of a block in a request, bytes.
const BLOCK: usize = 256;

/// A board that waits for a download, and its host.
struct Plugged {
    board: Small,
    host: UsbHost,
    device: Device,
    dfu: Dfu,
}

#[track_caller]
fn plug(mut board: Small) -> Plugged {
    let mut host = UsbHost::new();
    let mut desk = host.at(&mut board.vm);
    desk.plug();
    let device = desk.enumerate().expect("the boot stage is a USB device");
    let dfu = Dfu::of(&device).expect("with a download");
    Plugged { board, host, device, dfu }
}

impl Plugged {
    /// Sends a file. Returns the interface's final state, and the status.
    #[track_caller]
    fn send(&mut self, file: &[u8]) -> (u8, u8) {
        let (dfu, mut desk) = (self.dfu, self.host.at(&mut self.board.vm));
        let mut number = 0;
        for block in file.chunks(BLOCK) {
            let status = dfu.download(&mut desk, number, block).expect("an answer");
            if status.state != state::DOWNLOAD_IDLE {
                return (status.state, status.status);
            }
            number += 1;
        }
        let mut status = dfu.leave(&mut desk, number).expect("an answer");
        while matches!(status.state, state::MANIFEST | state::MANIFEST_SYNC) {
            desk.pass_ms(u64::from(status.poll_ms.max(1))).expect("it goes on");
            status = dfu.status(&mut desk).expect("an answer");
        }
        (status.state, status.status)
    }

    /// Resets the bus, and unplugs the host.
    fn leave(mut self) -> Small {
        let mut desk = self.host.at(&mut self.board.vm);
        // The board resets as soon as it sees the bus reset.
        let _ = desk.reset();
        desk.unplug();
        self.board
    }
}

/// Presses RESET twice, which asks for a download.
fn asked(mut board: Small) -> Small {
    board.settle(PATIENCE_MS);
    for _ in 0..2 {
        board.forget_mark();
        board.press_reset();
        board.vm.run_for(300 * MS);
    }
    assert!(board.said().contains("waits for firmware over USB"), "{}", board.said());
    board
}

fn forms(share: Share) -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let with_trailer = |mut file: Vec<u8>| {
        file.extend(update::trailer(&file));
        file
    };
    let whole = [flash(&[]).bytes()[..PRIME.image() as usize].to_vec(), new.clone()].concat();
    let files = [with_trailer(whole), with_trailer(new.clone()), new.clone()];
    let files = if share == Share::Quick { &files[..1] } else { &files[..] };
    let with_old = card(&[("firmware.previous", &old)]);
    for file in files {
        let content = flash(&old);
        let mut plugged = plug(asked(Small::on(&content, Some(&with_old))));
        let serial = plugged.device.strings[2].clone().unwrap_or_default();
        assert!(serial.ends_with("-DFU"), "{serial}");
        assert_eq!(plugged.send(file), (state::MANIFEST_WAIT_RESET, 0));
        let mut board = plugged.leave();
        assert_eq!(board.settle(PATIENCE_MS), Came::Runs(2), "{}", board.said());
        let operations = board.operations();
        let then = super::small::state(&mut after(&content, &operations));
        assert_eq!(then.arrival(known(&new)), Arrival::Trial(Origin::Usb, 1));
    }
    // An empty board takes a file as well, and its flash can be read.
    let mut plugged = plug(empty());
    assert_eq!(plugged.send(&new).0, state::MANIFEST_WAIT_RESET);
    assert_eq!(plugged.leave().settle(PATIENCE_MS), Came::Runs(2));
    let mut plugged = plug(asked(Small::on(&flash(&new), None)));
    let (dfu, mut desk) = (plugged.dfu, plugged.host.at(&mut plugged.board.vm));
    let mut read: Vec<u8> = Vec::new();
    for number in 0.. {
        let block = dfu.upload(&mut desk, number, BLOCK as u16).expect("a block");
        read.extend(&block);
        if block.len() < BLOCK {
            break;
        }
    }
    assert_eq!(read, new);
    files.len() + 2
}

fn empty() -> Small {
    let mut board = Small::on(&flash(&[]), None);
    assert_eq!(board.settle(PATIENCE_MS), Came::Waits);
    board
}

fn refused() -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut other_board = new;
    other_board[8] ^= 1;
    // The expected states are errTARGET and errFILE (DFU 1.1 section 6.1.2).
    for (file, status) in [(other_board, 0x01), (vec![0x55; 3000], 0x02)] {
        let mut plugged = plug(asked(Small::on(&flash(&old), None)));
        assert_eq!(plugged.send(&file), (state::ERROR, status));
        assert_eq!(plugged.board.operations(), []);
        let mut board = plugged.board;
        board.press_reset();
        assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1));
    }
    2
}

fn no_copy() -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let cards = [None, Some(card(&[])), Some(card(&[("firmware.previous", &old[..1000])]))];
    for inserted in &cards {
        let mut plugged = plug(asked(Small::on(&flash(&old), inserted.as_deref())));
        // The status is errVENDOR, with its meaning in a string (DFU 1.1 section 6.1.2).
        assert_eq!(plugged.send(&new), (state::ERROR, 0x0B));
        assert_eq!(plugged.board.operations(), []);
        assert!(plugged.board.said().contains("holds no firmware to come back to"), "{}", plugged.board.said());
        let mut board = plugged.board;
        board.press_reset();
        assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1));
    }
    cards.len()
}

fn not_whole(share: Share) -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut spoiled = new.clone();
    spoiled[SHORT - 1] ^= 1;
    let with_old = card(&[("firmware.previous", &old)]);
    let files = [&spoiled, &new[..1000]];
    let files = if share == Share::Quick { &files[..1] } else { &files[..] };
    for file in files {
        let mut plugged = plug(asked(Small::on(&flash(&old), Some(&with_old))));
        assert_eq!(plugged.send(file).0, state::ERROR);
        plugged.board.press_reset();
        assert_eq!(plugged.board.settle(PATIENCE_MS), Came::Runs(1));
        // Or the host sends it again, without a card as well: the image in flash cannot be lost.
        let mut plugged = plug(empty());
        assert_eq!(plugged.send(file).0, state::ERROR);
        let (dfu, mut desk) = (plugged.dfu, plugged.host.at(&mut plugged.board.vm));
        dfu.clear(&mut desk).expect("it is idle again");
        assert_eq!(plugged.send(&new).0, state::MANIFEST_WAIT_RESET);
        assert_eq!(plugged.leave().settle(PATIENCE_MS), Came::Runs(2));
    }
    // The cable is pulled out half way.
    let mut plugged = plug(asked(Small::on(&flash(&old), Some(&with_old))));
    let (dfu, mut desk) = (plugged.dfu, plugged.host.at(&mut plugged.board.vm));
    dfu.download(&mut desk, 0, &new[..BLOCK]).expect("an answer");
    desk.unplug();
    desk.pass_ms(100).expect("it goes on");
    plugged.board.press_reset();
    assert_eq!(plugged.board.settle(PATIENCE_MS), Came::Runs(1));
    2 * files.len() + 1
}

/// Cuts the flash operations of a download at each place in each way. Returns the flash left by each cut. In
/// the quick share at four places, in one way each.
fn cuts(content: &FlashContent, operations: &[Operation], share: Share) -> Vec<(String, FlashContent)> {
    let step = if share == Share::Quick { operations.len().div_ceil(4) } else { 1 };
    let tears = [Torn::NotBegun, Torn::Unreadable, Torn::Between];
    let mut cuts = Vec::new();
    for place in (0..operations.len()).step_by(step) {
        let ways = if share == Share::Quick { &tears[1 + place % 2..][..1] } else { &tears[..] };
        for torn in ways {
            let mut cut = after(content, &operations[..place]);
            cut.tear(&operations[place], *torn);
            cuts.push((format!("{torn:?} at {place}"), cut));
        }
    }
    cuts
}

fn cut(share: Share) -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let content = flash(&old);
    let with_old = card(&[("firmware.previous", &old)]);
    let mut plugged = plug(asked(Small::on(&content, Some(&with_old))));
    plugged.send(&new);
    let cuts = cuts(&content, &plugged.board.operations(), share);
    for (place, cut) in &cuts {
        let came = Small::on(cut, Some(&with_old)).settle(PATIENCE_MS);
        assert!(matches!(came, Came::Runs(1 | 2)), "{place}: {came:?}");
    }
    cuts.len()
}

fn empty_is_cut(share: Share) -> usize {
    let new = application(2, SHORT, None);
    let content = flash(&[]);
    let mut plugged = plug(empty());
    plugged.send(&new);
    let cuts = cuts(&content, &plugged.board.operations(), share);
    for (place, cut) in &cuts {
        let mut board = Small::on(cut, None);
        if board.settle(PATIENCE_MS) == Came::Waits {
            let mut plugged = plug(board);
            assert_eq!(plugged.send(&new).0, state::MANIFEST_WAIT_RESET, "{place}");
            assert_eq!(plugged.leave().settle(PATIENCE_MS), Came::Runs(2));
        }
    }
    cuts.len()
}
