//! A board whose 25 MHz crystal does not start: there are no clocks to build on, so no application runs, and
//! the boot stage tells it.

use super::cuts::SHORT;
use super::small::{Came, Small, application, flash};
use super::{Row, tests};
use crate::common::MS;

pub const ROWS: &[Row] = &[Row {
    name: "the_crystal_does_not_start",
    what: "the 25 MHz crystal does not start",
    does: "nothing is touched, nothing is on; the board says so every two seconds and tries again, and starts once it does",
    run: |_| silent(),
}];

tests! { the_crystal_does_not_start }

const PATIENCE_MS: u64 = 20_000;
/// Time after which the boot stage has given up. A try takes two seconds at 64 MHz; the virtual core does not
/// slow down with its clock, so here a third of a second.
const A_WHILE_MS: u64 = 1_000;

fn silent() -> usize {
    let mut board = Small::without_crystal(&flash(&application(1, SHORT, None)));
    board.vm.run_for(A_WHILE_MS * MS);
    let tries = board.said().matches("the 25 MHz crystal does not start").count();
    assert!(tries >= 2, "{tries} tries: {}", board.said());
    assert_eq!(board.mark(), None);
    assert_eq!(board.operations(), []);
    board.nothing_was_on();
    board.vm.with(|stopped| stopped.session.board_mut().set_crystal(true)).expect("the run goes on");
    assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1));
    1
}
