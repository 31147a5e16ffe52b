use super::*;
use proptest::prelude::*;

const READY: State = State::Ready { blocks: 1000, is_read_only: false, visit: 1 };

fn unit(medium: State) -> Unit<'static> {
    Unit { medium, sense: Sense::READ_ERROR, is_removal_prevented: false, serial: "0123456789AB" }
}

fn bytes(of: &[u8]) -> [u8; 16] {
    let mut command = [0; 16];
    command[..of.len()].copy_from_slice(of);
    command
}

fn answer(of: &[u8]) -> Vec<u8> {
    match interpret(&bytes(of), &unit(READY)) {
        Ok(Asked::Answer(reply)) => reply.bytes().to_vec(),
        other => panic!("{of:x?}: {other:?}"),
    }
}

#[test]
fn an_answer_is_no_longer_than_was_asked_for() {
    for most in 0..=255 {
        assert!(answer(&[0x12, 0, 0, 0, most, 0]).len() <= usize::from(most));
        assert!(answer(&[0x03, 0, 0, 0, most, 0]).len() <= usize::from(most));
        assert!(answer(&[0x1A, 0, 0x3F, 0, most, 0]).len() <= usize::from(most));
        assert!(answer(&[0x5A, 0, 0x3F, 0, 0, 0, 0, 0, most, 0]).len() <= usize::from(most));
        assert!(answer(&[0x23, 0, 0, 0, 0, 0, 0, 0, most, 0]).len() <= usize::from(most));
    }
}

#[test]
fn lengths_inside_answers_lead_to_their_ends() {
    let inquiry = answer(&[0x12, 0, 0, 0, 255, 0]);
    assert_eq!(inquiry.len(), usize::from(inquiry[4]) + 5);
    let pages = answer(&[0x12, 1, 0, 0, 255, 0]);
    assert_eq!(pages.len(), usize::from(pages[3]) + 4);
    for page in &pages[4..] {
        let data = answer(&[0x12, 1, *page, 0, 255, 0]);
        assert_eq!((data[1], data.len()), (*page, usize::from(data[3]) + 4));
    }
    for page in [0x00, 0x08, 0x3F] {
        let short = answer(&[0x1A, 0, page, 0, 255, 0]);
        assert_eq!(short.len(), usize::from(short[0]) + 1);
        let long = answer(&[0x5A, 0, page, 0, 0, 0, 0, 0, 255, 0]);
        assert_eq!(long.len(), usize::from(u16::from_be_bytes([long[0], long[1]])) + 2);
        assert_eq!(long[8..], short[4..]);
    }
    let sense = answer(&[0x03, 0, 0, 0, 255, 0]);
    assert_eq!((sense.len(), sense[2], sense[12]), (usize::from(sense[7]) + 8, 3, 0x11));
}

#[test]
fn the_largest_card_has_its_capacity() {
    let largest = State::Ready { blocks: u32::MAX, is_read_only: false, visit: 1 };
    let Ok(Asked::Answer(reply)) = interpret(&bytes(&[0x25]), &unit(largest)) else { panic!() };
    assert_eq!(reply.bytes()[..4], (u32::MAX - 1).to_be_bytes());
    let Ok(Asked::Answer(reply)) =
        interpret(&bytes(&[0x9E, 0x10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 32]), &unit(largest))
    else {
        panic!()
    };
    assert_eq!(reply.bytes()[..8], u64::from(u32::MAX - 1).to_be_bytes());
}

proptest! {
    /// Blocks that a command moves are on the medium, for every command.
    #[test]
    fn no_command_reaches_behind_the_end(command in prop::array::uniform16(any::<u8>()), blocks in 0_u32..5_000) {
        let medium = State::Ready { blocks, is_read_only: false, visit: 1 };
        if let Ok(Asked::Read(at) | Asked::Write(at) | Asked::Verify(at)) = interpret(&command, &unit(medium)) {
            prop_assert!(at.first.checked_add(at.count).is_some_and(|end| end <= blocks));
        }
    }

    /// Commands that move blocks are refused exactly when blocks are behind the end.
    #[test]
    fn no_transfer_reaches_behind_the_end(
        operation in prop::sample::select(vec![0x28_u8, 0x2A, 0x2F]),
        first in prop_oneof![0_u32..1_100, any::<u32>()],
        count in prop_oneof![0_u16..1_100, any::<u16>()],
    ) {
        let mut command = [0; 16];
        command[0] = operation;
        command[2..6].copy_from_slice(&first.to_be_bytes());
        command[7..9].copy_from_slice(&count.to_be_bytes());
        let is_within = u64::from(first) + u64::from(count) <= 1000;
        prop_assert_eq!(interpret(&command, &unit(READY)).is_ok(), is_within);
    }
}
