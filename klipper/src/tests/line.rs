//! Sequence numbers, damage, shutdown: what goes over the line whatever the board does.

use proptest::prelude::*;

use crate::desk::Bench;
use crate::wire::{BLOCK_BYTES, Framer, Incoming, write_block};
use crate::{Command, Response};

#[test]
fn blocks_out_of_turn_are_refused_by_the_number_that_is_expected() {
    let mut bench = Bench::new(0);
    bench.heard();
    let mut block = [0; BLOCK_BYTES];
    let length = write_block(&Bench::message(Command::GetClock, &[], None), 5, &mut block);
    assert!(bench.bytes(&block[..length]).is_empty());
    assert_eq!(bench.acknowledged, [0]);
    assert_eq!(bench.tell(Command::GetClock, &[]).len(), 1);
    assert_eq!(bench.acknowledged, [0, 1]);
}

#[test]
fn answers_come_before_the_acknowledgement_and_bear_the_new_number() {
    let mut bench = Bench::new(0);
    let mut raw = [0; 64];
    while bench.controller.fetch(&mut raw) > 0 {}
    let mut block = [0; BLOCK_BYTES];
    let length = write_block(&Bench::message(Command::GetClock, &[], None), 0, &mut block);
    let mut framer = Framer::new();
    for byte in &block[..length] {
        if let Some(Incoming::Block(block)) = framer.take(*byte) {
            bench.controller.receive(&block);
        }
    }
    let count = bench.controller.fetch(&mut raw);
    let mut blocks = Vec::new();
    for byte in &raw[..count] {
        if let Some(Incoming::Block(block)) = framer.take(*byte) {
            blocks.push((block.sequence(), block.content().len()));
        }
    }
    assert_eq!(blocks.len(), 2);
    assert!(blocks[0].1 > 0 && blocks[1].1 == 0, "{blocks:?}");
    assert!(blocks.iter().all(|(sequence, _)| *sequence == 1));
}

#[test]
fn a_board_that_takes_long_to_come_up_is_not_shut_down() {
    let mut bench = Bench::new(0);
    bench.wires.clock.set(40_000_000);
    bench.controller.run();
    assert_eq!(bench.tell(Command::GetConfig, &[]).pop().expect("an answer").1, [0, 0, 0, 4096]);
}

#[test]
fn what_an_old_host_sends_first_costs_one_nak() {
    let mut bench = Bench::new(0);
    bench.heard();
    // The leave sequence of an AVR boot loader, which every host sends; then a block, and its repetition.
    let mut bytes = vec![0x1B, 0x01, 0x00, 0x01, 0x0E, 0x11, 0x04];
    let mut block = [0; BLOCK_BYTES];
    let length = write_block(&Bench::message(Command::GetClock, &[], None), 0, &mut block);
    bytes.extend(&block[..length]);
    bytes.push(0x7E);
    bytes.extend(&block[..length]);
    assert_eq!(bench.bytes(&bytes).len(), 1);
    assert_eq!(bench.acknowledged, [0, 1]);
}

#[test]
fn a_stop_is_told_once_and_refuses_what_moves_until_it_is_cleared() {
    let mut bench = Bench::with_oids(1);
    let said = bench.tell(Command::EmergencyStop, &[]);
    assert!(matches!(said[..], [(Response::Shutdown, ..)]), "{said:?}");
    let words = bench.tell(Command::FinalizeConfig, &[1]);
    assert_eq!(words[0].0, Response::IsShutdown);
    let state = bench.tell(Command::GetConfig, &[]);
    assert_eq!(state[0].1, [0, 0, 1, 4096]);
    bench.tell(Command::ClearShutdown, &[]);
    assert_eq!(bench.tell(Command::GetConfig, &[])[0].1, [0, 0, 0, 4096]);
}

#[test]
fn only_the_factory_s_words_are_read() {
    let mut bench = Bench::new(0);
    assert_eq!(bench.tell(Command::DebugRead, &[1, 0x1FF1_E820])[1], (Response::DebugResult, vec![0x1234], vec![]));
    assert_eq!(bench.tell(Command::DebugRead, &[2, 0x4000_0000])[0].0, Response::Shutdown);
}

#[test]
fn a_configuration_is_whole_once() {
    let mut bench = Bench::with_oids(2);
    bench.finalize();
    assert_eq!(bench.tell(Command::GetConfig, &[])[0].1, [1, 7, 0, 4096]);
    let said = bench.tell(Command::ConfigTrsync, &[0]);
    assert_eq!(said[0].0, Response::Shutdown);
}

proptest! {
    #[test]
    fn no_bytes_stop_the_board_from_answering(
        noise in proptest::collection::vec(any::<u8>(), 0..400),
        contents in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..59), 0..8),
    ) {
        let mut bench = Bench::with_oids(40);
        bench.bytes(&noise);
        for content in contents {
            bench.block(&content);
            bench.pass(100_000);
            bench.heard();
        }
        bench.pass(1_000_000);
        bench.heard();
        // A byte of noise may be the beginning of a block: two ends of one make sure that none is open.
        bench.bytes(&[0x7E; BLOCK_BYTES + 2]);
        let said = bench.tell(Command::GetClock, &[]);
        prop_assert!(said.iter().any(|(kind, ..)| *kind == Response::Clock), "{:?}", said);
    }
}
