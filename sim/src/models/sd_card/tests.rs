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
    assert_eq!(card.command(0, 2, 0).0, Reply::Long(CID));
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
    let later = 1_000 + PROGRAMMING_NS;
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
