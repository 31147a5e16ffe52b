//! `card`: prints data of the card, the speed of its bus, its statistics, and its free space.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::ports::{CardFacts, FreeSpace, Storage, Wake};
use heapless::String;

/// Bytes of a megabyte, as cards are sold.
const MB: u64 = 1_000_000;

/// `card`: prints the data of the card.
pub fn card<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let Some(facts) = hands.storage().card_facts() else { return Err(Failure::refused(&"no SD card")) };
    let CardFacts { kind, name, maker, blocks, bus_khz, is_protected, .. } = facts;
    let name = core::str::from_utf8(&name).unwrap_or("?");
    let mut size = String::<16>::new();
    // The number fits: seven digits at most.
    let _ = write!(size, "{}", u64::from(blocks) * 512 / MB);
    hands.say(format_args!(
        "{kind} {name} of maker {maker}: {size} MB, {}.{} MHz, 4 bits",
        bus_khz / 1_000,
        bus_khz % 1_000 / 100
    ));
    hands.say(format_args!("{}\n", if is_protected { ", write-protected" } else { "" }));
    let done = facts.counters;
    hands.say(format_args!(
        "blocks read {}, written {}; transfers repeated {}, damaged {}; the slowest read {} ms, write {} ms\n",
        done.reads,
        done.writes,
        done.repeated,
        done.damaged,
        done.slowest_read_us / 1_000,
        done.slowest_write_us / 1_000
    ));
    let mut free = FreeSpace::default();
    loop {
        hands.card_at_rest();
        match hands.storage().count_free(&mut free) {
            Ok(true) => break,
            Ok(false) => hands.wait(Wake::Any).whatever_happens(),
            Err(error) => {
                hands.say(format_args!("how much is free is not known: {}\n", error.text()));
                return Ok(Answer::Ok);
            }
        }
        if hands.stop_requested() {
            return Ok(Answer::Ok);
        }
    }
    let (left, all) = (free.bytes / MB, free.total_bytes / MB);
    hands.say(format_args!("{left} MB free of {all} MB\n"));
    Ok(Answer::Ok)
}
