//! Tests of the contents and the order of writes.

use proptest::prelude::*;

use super::card::{BLOCKS, Turn, flush, identified, read, run, stretch, write};
use crate::sd::{Event, SdError};

#[derive(Clone, Debug)]
enum Step {
    Write(u32, u8),
    Read(u32),
    Follow(u32, u32),
    Wait(u64),
    Hold(bool),
}

fn step() -> impl Strategy<Value = Step> {
    let number = || prop_oneof![0..24_u32, 100..130_u32];
    prop_oneof![
        6 => (number(), any::<u8>()).prop_map(|(number, fill)| Step::Write(number, fill)),
        4 => number().prop_map(Step::Read),
        1 => (number(), 1..40_u32).prop_map(|(first, count)| Step::Follow(first, count)),
        3 => (0..2_000_u64).prop_map(Step::Wait),
        1 => any::<bool>().prop_map(Step::Hold),
    ]
}

proptest! {
    /// A reader gets the last write; the card gets the writes in order, except for blocks that were replaced
    /// while they were the last to wait.
    #[test]
    fn reads_see_writes_and_writes_keep_their_order(steps in proptest::collection::vec(step(), 1..200)) {
        let mut service = identified();
        let (mut model, mut written) = (std::collections::BTreeMap::new(), Vec::new());
        for step in steps {
            match step {
                Step::Write(number, fill) => {
                    service.hold(false);
                    write(&mut service, number, fill).unwrap();
                    model.insert(number, fill);
                    written.push((number, fill));
                }
                Step::Read(number) => {
                    let wanted = model.get(&number).copied().unwrap_or(number as u8 ^ 0x5A);
                    prop_assert_eq!(read(&mut service, number), Ok(wanted));
                }
                Step::Follow(first, count) => {
                    service.unfollow();
                    service.follow(stretch(first, count));
                }
                Step::Wait(us) => run(&mut service, us),
                Step::Hold(is_held) => service.hold(is_held),
            }
        }
        service.hold(false);
        flush(&mut service).unwrap();
        for (number, fill) in &model {
            prop_assert_eq!(service.host().fill_of(*number), *fill);
        }
        let arrived = std::mem::take(&mut service.host().written);
        let mut expected = written.iter();
        for block in &arrived {
            prop_assert!(expected.any(|written| written == block), "{arrived:?} of {written:?}");
        }
        prop_assert!(arrived.len() <= written.len());
    }

    /// After any lasting failure, the card holds all writes up to some moment.
    #[test]
    fn a_failed_write_is_the_last_one(count in 1..60_usize, at in 0..60_usize) {
        let mut service = identified();
        service.host().turns.extend(std::iter::repeat_n(Turn::Good, at));
        service.host().turns.extend([Turn::Silent; 4]);
        let mut error = None;
        for number in 0..count {
            // The blocks are not adjacent, so that each has a command of its own.
            match write(&mut service, number as u32 * 3, number as u8) {
                Ok(_) => {}
                Err(refused) => {
                    error = Some(refused);
                    break;
                }
            }
        }
        let kept = flush(&mut service);
        run(&mut service, 100_000);
        let written: Vec<_> = service.host().written.iter().map(|(number, _)| *number).collect();
        let all: Vec<_> = (0..written.len() as u32).map(|number| number * 3).collect();
        prop_assert_eq!(&written, &all);
        if kept.is_err() {
            prop_assert!(matches!(service.take_event(), Some(Event::WriteFailed(SdError::StaysBusy(_)))));
            prop_assert_eq!(service.write(7, &[0; 512]), Err(SdError::WriteFailed));
            service.forgive();
            service.host().turns.clear();
            write(&mut service, 7, 1).unwrap();
            prop_assert_eq!(flush(&mut service), Ok(()));
        } else {
            prop_assert!(error.is_none() && written.len() == count);
        }
    }
}

#[test]
fn the_last_block_of_the_queue_is_replaced_and_no_other() {
    let mut service = identified();
    service.hold(true);
    for fill in 0..50 {
        assert_eq!(write(&mut service, 5, fill), Ok(0));
    }
    write(&mut service, 6, 1).unwrap();
    write(&mut service, 5, 99).unwrap();
    assert_eq!(read(&mut service, 5), Ok(99));
    service.hold(false);
    flush(&mut service).unwrap();
    assert_eq!(service.host().written, [(5, 49), (6, 1), (5, 99)]);
}

#[test]
fn a_full_queue_makes_its_writer_wait_and_loses_nothing() {
    let mut service = identified();
    service.host().write_us = 250_000;
    let waits: Vec<u64> = (0..60).map(|number| write(&mut service, number * 2, 1).unwrap()).collect();
    assert!(waits[..32].iter().all(|us| *us == 0) && waits[32] > 100_000, "{waits:?}");
    flush(&mut service).unwrap();
    assert_eq!(service.host().written.len(), 60);
}

#[test]
fn a_card_that_loses_what_is_written_is_found_out() {
    let mut service = identified();
    service.host().keeps_below = 1_000;
    write(&mut service, 999, 1).unwrap();
    flush(&mut service).unwrap();
    write(&mut service, 1_000, 1).unwrap();
    assert_eq!(flush(&mut service), Err(SdError::NotKept));
    assert_eq!(service.take_event(), Some(Event::WriteFailed(SdError::NotKept)));
}

#[test]
fn a_block_beyond_the_end_is_refused() {
    let mut service = identified();
    assert_eq!(service.write(BLOCKS, &[0; 512]), Err(SdError::OutOfRange));
    assert_eq!(read(&mut service, BLOCKS), Err(SdError::OutOfRange));
}
