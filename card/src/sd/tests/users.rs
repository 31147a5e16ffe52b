//! Tests of a user that has the card lent.

use super::card::{OUTSIDE, flush, identified, read, run, stretch, write};
use crate::sd::{Direction, Lent, SdError};

#[test]
fn the_card_is_lent_moved_from_and_taken_back() {
    let mut service = identified();
    write(&mut service, 3, 7).unwrap();
    assert_eq!(service.lend(), Ok(false), "something waits to be written");
    flush(&mut service).unwrap();
    assert_eq!(service.lend(), Ok(true));
    assert_eq!(read(&mut service, 3), Err(SdError::Lent));
    service.host().outside[..1024].fill(9);
    service.begin(Direction::ToCard, stretch(4, 2), OUTSIDE).unwrap();
    assert_eq!(service.begin(Direction::ToCard, stretch(4, 2), OUTSIDE), Err(SdError::Lent));
    assert_eq!(service.lent(), Lent::Busy);
    run(&mut service, 2_000);
    assert_eq!((service.lent(), service.lent()), (Lent::Done, Lent::Idle));
    service.begin(Direction::FromCard, stretch(3, 3), OUTSIDE + 4_096).unwrap();
    run(&mut service, 2_000);
    assert_eq!(service.lent(), Lent::Done);
    let fills: Vec<u8> = (0..3).map(|block| service.host().outside[4_096 + block * 512]).collect();
    assert_eq!(fills, [7, 9, 9]);
    assert_eq!(service.begin(Direction::FromCard, stretch(2_047, 2), OUTSIDE), Err(SdError::OutOfRange));
    service.take_back();
    assert_eq!(read(&mut service, 5), Ok(9));
}

#[test]
fn a_card_pulled_out_while_it_is_lent_fails_the_transfer() {
    let mut service = identified();
    assert_eq!(service.lend(), Ok(true));
    service.host().is_there = false;
    service.begin(Direction::FromCard, stretch(3, 3), OUTSIDE).unwrap();
    run(&mut service, 10_000);
    assert!(matches!(service.lent(), Lent::Failed(_)));
    assert!(service.begin(Direction::FromCard, stretch(3, 3), OUTSIDE).is_err());
}
