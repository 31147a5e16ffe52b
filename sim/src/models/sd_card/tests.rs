//! The card as a host sees it.

use super::*;

const ADDRESSED: u32 = (ADDRESS as u32) << 16;
const R1_TRANSFER: u32 = 4 << 9 | READY_FOR_DATA;

fn identified() -> SdCard {
    let mut card = SdCard::new((0..=255).cycle().take(1 << 20).collect());
    assert_eq!(card.command(0, 0, 0), (Reply::None, Transfer::None));
    assert_eq!(card.command(0, 8, 0x1AA), (Reply::Short(0x1AA), Transfer::None));
    let mut now_ns = 0;
    loop {
        card.command(now_ns, 55, 0);
        match card.command(now_ns, 41, 0x4010_0000) {
            (Reply::Unchecked(ocr), _) if ocr & OCR_POWER_UP_DONE != 0 => break,
            (Reply::Unchecked(_), _) => now_ns += 100_000,
            other => panic!("{other:?}"),
        }
    }
    assert!(now_ns >= POWER_UP_NS);
    assert_eq!(card.command(0, 2, 0).0, Reply::Long(registers::CID));
    assert!(matches!(card.command(0, 3, 0).0, Reply::Short(r6) if r6 >> 16 == u32::from(ADDRESS)));
    card.command(0, 7, ADDRESSED);
    card
}

#[test]
fn a_card_is_identified_and_states_its_size() {
    let mut card = identified();
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER));
    card.command(0, 7, 0);
    let Reply::Long(csd) = card.command(0, 9, ADDRESSED).0 else { panic!("no CSD") };
    let size = (csd[1] & 0x3F) << 16 | csd[2] >> 16;
    assert_eq!((size as usize + 1) * 512 * 1024, card.content().len());
}

#[test]
fn blocks_written_are_blocks_read_and_the_card_programs_meanwhile() {
    let mut card = identified();
    assert_eq!(card.command(0, 24, 7).1, Transfer::Write);
    assert!(card.write(1_000, &[0xA5; BLOCK]));
    assert_eq!(card.command(1_000, 13, ADDRESSED).0, Reply::Short((State::Program as u32) << 9));
    let later = 1_000 + Traits::default().programming_ns;
    assert_eq!(card.command(later, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER));
    assert_eq!(card.command(later, 17, 7).1, Transfer::Read);
    assert_eq!(card.read(BLOCK).as_deref(), Some(&[0xA5; BLOCK][..]));
    card.block_sent();
    assert_eq!(card.read(BLOCK), None);
}

#[test]
fn an_endless_read_goes_on_until_it_is_stopped() {
    let mut card = identified();
    card.command(0, 18, 0);
    for _ in 0..5 {
        assert_eq!(card.read(BLOCK).map(|bytes| bytes[1]), Some(1));
        card.block_sent();
    }
    assert_eq!(card.command(0, 12, 0).0, Reply::Short((State::Data as u32) << 9 | READY_FOR_DATA));
    assert_eq!(card.read(BLOCK), None);
}

#[test]
fn a_card_fresh_in_its_slot_gives_no_status() {
    let mut card = SdCard::new(vec![0; BLOCK]);
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::None);
}

#[test]
fn a_single_block_can_be_stopped_until_it_is_sent() {
    let mut card = identified();
    card.command(0, 17, 0);
    card.read(BLOCK);
    assert_eq!(card.command(0, 12, 0).0, Reply::Short((State::Data as u32) << 9 | READY_FOR_DATA));
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER));
    card.command(0, 17, 0);
    card.read(BLOCK);
    card.block_sent();
    assert_eq!(card.command(0, 12, 0).0, Reply::None);
}

#[test]
fn an_illegal_command_gets_no_reply_and_the_next_status_says_so() {
    let mut card = identified();
    assert_eq!(card.command(0, 41, 0), (Reply::None, Transfer::None));
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER | ILLEGAL_COMMAND));
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER));
}

#[test]
fn an_address_beyond_the_end_is_refused() {
    let mut card = identified();
    assert_eq!(card.command(0, 17, 1 << 20), (Reply::Short(R1_TRANSFER | OUT_OF_RANGE), Transfer::None));
}

/// A card of its own make, up to its operating conditions: what it answers.
fn conditions(traits: Traits) -> Option<u32> {
    let mut card = SdCard::new(vec![0; 1 << 20]).with(traits);
    card.command(0, 0, 0);
    card.command(0, 55, 0);
    card.command(0, 41, 0x4010_0000);
    card.command(0, 55, 0);
    match card.command(POWER_UP_NS, 41, 0x4010_0000) {
        (Reply::Unchecked(ocr), _) => Some(ocr),
        _ => None,
    }
}

#[test]
fn cards_of_standard_capacity_count_bytes_and_others_blocks() {
    assert_eq!(conditions(Traits::default()), Some(0xC0FF_8000));
    assert_eq!(conditions(Traits { make: Make::Standard, ..Traits::default() }), Some(0x80FF_8000));
    assert_eq!(conditions(Traits { make: Make::Mmc, ..Traits::default() }), None);
    let mut card = identified().with(Traits { make: Make::Standard, ..Traits::default() });
    card.command(0, 17, 3 * 512);
    card.content[3 * 512] = 77;
    assert_eq!(card.read(BLOCK).map(|bytes| bytes[0]), Some(77));
}

#[test]
fn a_multimedia_card_knows_its_own_command_alone() {
    let mut card = SdCard::new(vec![0; 1 << 20]).with(Traits { make: Make::Mmc, ..Traits::default() });
    for (index, argument) in [(8, 0x1AA), (55, 0), (41, 0)] {
        assert_eq!(card.command(0, index, argument).0, Reply::None);
    }
    assert!(matches!(card.command(0, 1, 0).0, Reply::Unchecked(_)));
}

#[test]
fn high_speed_raises_the_clock_that_it_may_have() {
    let mut card = identified();
    assert_eq!(card.highest_hz(), 25_000_000);
    card.command(0, 6, 0x80FF_FFF1);
    assert_eq!(card.read(64).map(|bytes| bytes[16]), Some(1));
    card.block_sent();
    assert!(card.is_clean_at(50_000_000) && !card.is_clean_at(60_000_000));
    let mut slow = identified().with(Traits { is_fast: false, ..Traits::default() });
    assert_eq!(slow.command(0, 6, 0x80FF_FFF1).0, Reply::None);
}

#[test]
fn a_card_that_claims_too_much_wraps_or_loses() {
    for (fake, block, expected) in [(Fake::Wraps, 5_u32, 9), (Fake::Loses, 5 + 2048, 0)] {
        let mut card = identified().with(Traits { claims: Some((4, fake)), ..Traits::default() });
        card.command(0, 24, 5 + 2048);
        assert!(card.write(0, &[9; BLOCK]));
        let later = Traits::default().programming_ns;
        card.command(later, 17, block);
        assert_eq!(card.read(BLOCK).map(|bytes| bytes[0]), Some(expected));
    }
}

#[test]
fn what_goes_wrong_does_so_as_often_as_it_is_told() {
    let mut card = identified();
    *card.trouble() = Trouble { damaged_answers: 1, damaged_writes: 1, unreadable: vec![7], ..Trouble::default() };
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Damaged);
    assert_eq!(card.command(0, 13, ADDRESSED).0, Reply::Short(R1_TRANSFER));
    card.command(0, 24, 3);
    assert!(!card.write(0, &[1; BLOCK]));
    card.command(0, 12, 0);
    card.command(0, 17, 7);
    assert_eq!(card.read(BLOCK), None);
    card.command(0, 12, 0);
    assert!(matches!(card.command(0, 13, ADDRESSED).0, Reply::Short(status) if status & CARD_ECC_FAILED == 0));
    *card.trouble() = Trouble { slow_reads: (250_000_000, 1), ..Trouble::default() };
    assert_eq!([card.access_ns(), card.access_ns()], [250_200_000, 200_000]);
}
