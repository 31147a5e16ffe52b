//! Tests of blocks at hand, and of a card that stalls or errs.

use super::card::{identified, read, run, stretch, write};
use crate::sd::{AHEAD_BLOCKS, Event, SdError, State};

#[test]
fn a_reader_that_is_followed_finds_its_blocks_along_scattered_stretches() {
    let mut service = identified();
    let runs = [stretch(100, 8), stretch(900, 3), stretch(40, 20), stretch(41, 1), stretch(500, 100)];
    assert!(runs.iter().all(|run| service.follow(*run)));
    run(&mut service, 20_000);
    let order: Vec<u32> = runs.iter().flat_map(|run| run.first..run.first + run.count).collect();
    let at_hand = order.iter().take(AHEAD_BLOCKS).filter(|number| service.is_at_hand(**number)).count();
    assert_eq!(at_hand, AHEAD_BLOCKS);
    for number in order {
        assert_eq!(read(&mut service, number), Ok(number as u8 ^ 0x5A));
        run(&mut service, 100);
    }
}

/// The card stalls for 250 ms in each write; the reader takes a block every 3 ms, and never waits.
#[test]
fn a_followed_reader_never_waits_for_slow_writes() {
    let mut service = identified();
    service.host().write_us = 250_000;
    // 160 kB/s, and all of it in one stretch.
    assert!(service.follow(stretch(0, 1_000)));
    run(&mut service, 20_000);
    let mut writes = 0;
    for number in 0..800 {
        assert!(service.is_at_hand(number), "block {number} is late");
        assert_eq!(read(&mut service, number), Ok(number as u8 ^ 0x5A));
        if service.room() > 0 && number % 3 == 0 {
            write(&mut service, 1_100 + writes, 1).unwrap();
            writes += 1;
        }
        run(&mut service, 3_000);
    }
    assert!(service.host().written.len() > 8, "{} writes", service.host().written.len());
}

#[test]
fn who_asks_for_a_quiet_card_gets_it_behind_one_write() {
    let mut service = identified();
    service.host().write_us = 250_000;
    for number in 0..10 {
        write(&mut service, number * 2, 1).unwrap();
    }
    run(&mut service, 10_000);
    let since_us = service.host().now_us;
    while !service.is_ready(4) {
        run(&mut service, 500);
    }
    assert!(service.host().now_us - since_us < 260_000);
    assert_eq!(service.host().written.len(), 1);
    // Even with reading ahead, a read takes no longer than on an idle card.
    let since_us = service.host().now_us;
    read(&mut service, 700).unwrap();
    assert!(service.host().now_us - since_us < 1_000);
    run(&mut service, 3_000_000);
    assert_eq!(service.host().written.len(), 10);
}

/// A waiting reader asks many times for a block that is on its way, yet the block is read once, and the other
/// group stays: a table and a directory by turns are at hand.
#[test]
fn two_groups_by_turns_are_read_once_each() {
    let mut service = identified();
    let before = service.counters().reads;
    for number in (8..16).zip(800..808).flat_map(|(table, directory)| [table, directory]) {
        assert_eq!(read(&mut service, number), Ok(number as u8 ^ 0x5A));
    }
    assert_eq!(service.counters().reads - before, 16);
}

#[test]
fn one_block_that_cannot_be_read_is_told_and_its_neighbours_are_read() {
    let mut service = identified();
    service.host().unreadable = vec![13];
    assert_eq!(read(&mut service, 11), Ok(11 ^ 0x5A));
    assert_eq!(read(&mut service, 13), Err(SdError::Unreadable));
    assert_eq!(read(&mut service, 14), Ok(14 ^ 0x5A));
    // The same holds for a reader that is followed.
    service.follow(stretch(8, 8));
    assert_eq!(read(&mut service, 12), Ok(12 ^ 0x5A));
    assert_eq!(read(&mut service, 13), Err(SdError::Unreadable));
    assert_eq!(read(&mut service, 15), Ok(15 ^ 0x5A));
}

#[test]
fn a_bus_that_is_too_fast_becomes_slower_and_nothing_is_lost() {
    let mut service = identified();
    assert_eq!(service.bus_hz(), 50_000_000);
    service.host().damages_above_hz = 20_000_000;
    assert_eq!(read(&mut service, 3), Ok(3 ^ 0x5A));
    assert_eq!((service.bus_hz(), service.host().bus_hz), (12_500_000, 12_500_000));
    assert_eq!(service.take_event(), Some(Event::Slower(12_500_000)));
    assert!(service.counters().damaged >= 2);
}

#[test]
fn a_card_that_is_pulled_out_is_missed_and_one_that_is_put_in_is_found() {
    let mut service = identified();
    service.look_by_itself();
    write(&mut service, 3, 7).unwrap();
    service.host().is_there = false;
    assert!(read(&mut service, 700).is_err());
    assert!(matches!(service.state(), State::Absent(_)));
    assert!(matches!(service.take_event(), Some(Event::Removed(_, true))));
    run(&mut service, 5_000_000);
    assert_eq!(service.take_event(), None, "told once");
    service.host().is_there = true;
    run(&mut service, 3_000_000);
    assert_eq!(service.take_event(), Some(Event::Inserted));
    // The removal of an unused card is noticed too.
    service.host().is_there = false;
    run(&mut service, 2_000_000);
    assert!(matches!(service.take_event(), Some(Event::Removed(SdError::NotResponding(13), false))));
}

#[test]
fn an_empty_slot_is_told_within_milliseconds() {
    let mut service = crate::sd::Service::new(super::card::Fake::new());
    service.host().is_there = false;
    service.identify();
    run(&mut service, 5_000);
    assert_eq!(service.state(), State::Absent(SdError::NoCard));
}

/// Every place has a block before the wanted one, which so never comes by itself.
#[test]
fn a_followed_reader_that_leaps_gets_its_block() {
    let mut service = identified();
    assert!(service.follow(stretch(0, 1_000)));
    run(&mut service, 20_000);
    assert_eq!(read(&mut service, 500), Ok(500_u32 as u8 ^ 0x5A));
    assert!(service.is_at_hand(0), "and loses nothing for it");
}

/// Reads directories while a file is played, as M21 does.
#[test]
fn after_another_identification_blocks_are_read_ahead_again() {
    for us in 0..300 {
        let mut service = identified();
        assert!(service.follow(stretch(0, 100)));
        run(&mut service, us);
        service.identify();
        run(&mut service, 3_000_000);
        assert!(service.follow(stretch(200, 8)));
        run(&mut service, 20_000);
        assert!(service.is_at_hand(207), "after {us} us");
    }
}
