//! Trials of new firmware that fails, and the return to the previous firmware.

use update::{Arrival, Ended, Entry, Origin, TRIALS};

use super::cuts::SHORT;
use super::small::{Came, Small, after, application, card, flash, known, log, state};
use super::{Row, tests};

pub const ROWS: &[Row] = &[
    Row {
        name: "new_firmware_that_hangs",
        what: "it hangs: the watchdog resets the board, three starts long",
        does: "the previous firmware is put back, from firmware.previous",
        run: |_| hangs(),
    },
    Row {
        name: "the_previous_one_is_broken",
        what: "the same, and firmware.previous is broken, the same, or not there",
        does: "the new firmware goes on being started",
        run: |_| broken_previous(),
    },
    Row {
        name: "a_probe_flashes_meanwhile",
        what: "a debug probe puts another image in its place",
        does: "that one is on no trial, and stays",
        run: |_| probe(),
    },
];

tests! {
    new_firmware_that_hangs
    the_previous_one_is_broken
    a_probe_flashes_meanwhile
}

/// Time for the watchdog, and a start.
const PATIENCE_MS: u64 = 20_000;

/// The new firmware sleeps, and nobody feeds the watchdog, which the boot stage has started with ten seconds.
fn hangs() -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut content = flash(&old);
    log(&mut content, Entry::Requested(Origin::File, known(&new)));
    let mut board = Small::on(&content, Some(&card(&[("flashme.bin", &new), ("firmware.previous", &old)])));
    for start in 1..=TRIALS {
        assert_eq!(board.settle(PATIENCE_MS), Came::Runs(2));
        let operations = board.operations();
        let then = state(&mut after(&content, &operations));
        assert_eq!(then.arrival(known(&new)), Arrival::Trial(Origin::File, start));
        board.forget_mark();
    }
    assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1));
    let operations = board.operations();
    let then = state(&mut after(&content, &operations));
    assert_eq!(then.arrival(known(&old)), Arrival::FellBack(Ended::Watchdog));
    1
}

fn on_trial(files: &[(&str, &[u8])]) -> Small {
    let new = application(2, SHORT, None);
    let mut content = flash(&new);
    log(&mut content, Entry::Installed(Origin::File, known(&new)));
    (0..TRIALS).for_each(|_| log(&mut content, Entry::Tried));
    Small::on(&content, Some(&card(files)))
}

fn broken_previous() -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut broken = old.clone();
    broken[SHORT - 1] ^= 1;
    let cases: [&[(&str, &[u8])]; 4] = [
        &[("firmware.previous", &broken)],
        &[("firmware.previous", &old[..1000])],
        &[("firmware.previous", &new)],
        &[],
    ];
    for files in cases {
        assert_eq!(on_trial(files).settle(PATIENCE_MS), Came::Runs(2));
    }
    // The copy that was being made when the power failed is as good, if it is whole.
    assert_eq!(on_trial(&[("firmware.previous", &broken), ("firmware.tmp", &old)]).settle(PATIENCE_MS), Came::Runs(1));
    cases.len() + 1
}

fn probe() -> usize {
    let (old, new, flashed) = (application(1, SHORT, None), application(2, SHORT, None), application(3, SHORT, None));
    let mut content = flash(&flashed);
    log(&mut content, Entry::Installed(Origin::File, known(&new)));
    (0..TRIALS).for_each(|_| log(&mut content, Entry::Tried));
    let mut board = Small::on(&content, Some(&card(&[("flashme.bin", &new), ("firmware.previous", &old)])));
    assert_eq!(board.settle(PATIENCE_MS), Came::Runs(3));
    assert_eq!(board.operations(), [], "its starts are not counted");
    1
}
