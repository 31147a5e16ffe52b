//! Tests of an offer to resume that nobody takes: the machine is moved meanwhile, or plays another file.

use std::collections::BTreeSet;
use std::fs;

use super::{Card, Machine, SECOND, interrupted, part};

/// A move beside the job after a power cut is tracked as long as the power stays; after the next cut the
/// machine asks for Z.
#[test]
fn z_that_was_moved_after_the_cut_is_asked_for_after_the_next_one() {
    let jog = |machine: &mut Machine| {
        machine.send("G91");
        machine.send("G1 Z5 F600");
        machine.send("G90");
        machine.run(4 * SECOND);
    };
    let job = |machine: &mut Machine, card: &Card| {
        fs::write(card.0.join("up.g"), "G91\nG1 Z5 F600\nG90\n").unwrap();
        machine.send("M413 S0");
        machine.send("play /sd/up.g -t");
        assert!(machine.until("/sd/job.g is not gone on with any more"), "{}", machine.said);
        assert!(machine.until("Done printing file"));
        machine.run(SECOND);
    };
    // First case: the move is in the same session.
    let card = Card::new(&part(false));
    let (mut second, _) = interrupted(&card);
    jog(&mut second);
    second.send("M1000");
    assert!(second.until("the job goes on") && second.until("Done printing file"), "{}", second.said);
    let heights: BTreeSet<i64> = second.laid.iter().map(|[_, _, z]| (z * 100.0).round() as i64).collect();
    assert_eq!(heights, [60, 90].into());
    // Second case: the move is in the next session.
    let card = Card::new(&part(false));
    let (mut second, carriages) = interrupted(&card);
    second.send("G28 X");
    second.run(10 * SECOND);
    jog(&mut second);
    assert!((second.carriages()[2] - carriages[2] - 5.0).abs() < 0.02);
    let mut third = Machine::start(&card, &second.carriages(), None);
    third.send("M1000");
    assert!(third.until("Z was moved after the job: measure it, then M1000 Z"), "{}", third.said);
    third.send(&format!("M1000 Z{:.3}", third.carriages()[2]));
    assert!(third.until("the job goes on") && third.until("Done printing file"), "{}", third.said);
    let heights: BTreeSet<i64> = third.laid.iter().map(|[_, _, z]| (z * 100.0).round() as i64).collect();
    assert_eq!(heights, [60, 90].into());
    // Another job without a journal gives it up.
    let card = Card::new(&part(false));
    let (mut second, _) = interrupted(&card);
    job(&mut second, &card);
    let third = Machine::start(&card, &second.carriages(), None);
    assert!(!third.said.contains("interrupted"), "{}", third.said);
}

/// X and Y are homed anyway.
#[test]
fn x_that_was_moved_after_the_cut_asks_for_nothing() {
    let card = Card::new(&part(false));
    let (mut second, _) = interrupted(&card);
    second.send("G28 X");
    second.run(10 * SECOND);
    let mut third = Machine::start(&card, &second.carriages(), None);
    third.send("M1000");
    assert!(third.until("the job goes on") && third.until("Done printing file"), "{}", third.said);
}

/// A halt leaves an offer; what is moved then is none of it either.
#[test]
fn z_that_was_moved_after_a_halt_is_asked_for_after_a_power_cut() {
    let card = Card::new(&part(false));
    let mut first = Machine::start(&card, &[], None);
    first.send("play /sd/job.g");
    while !first.laid.last().is_some_and(|[_, _, z]| (0.59..0.61).contains(z)) {
        first.step();
    }
    first.send("M112");
    first.run(3 * SECOND);
    first.send("M999");
    first.send("G91");
    first.send("G1 Z5 F600");
    first.run(4 * SECOND);
    let mut second = Machine::start(&card, &first.carriages(), None);
    assert!(second.said.contains("a job was interrupted"), "{}", second.said);
    second.send("M1000");
    assert!(second.until("Z was moved after the job: measure it, then M1000 Z"), "{}", second.said);
}

#[test]
fn a_job_that_begins_in_the_middle_gives_the_one_before_up() {
    let card = Card::new(&part(false));
    let (mut second, carriages) = interrupted(&card);
    // Z homes onto the bed: somebody has cleared it.
    second.send("G28");
    second.run(60 * SECOND);
    second.send("play /sd/job.g -t --from line 900");
    assert!(second.until("the file ends before this place"), "{}", second.said);
    second.send("M1000 S");
    assert!(second.until("M1000 goes on with it"), "a refused one gives nothing up: {}", second.said);
    second.send("play /sd/job.g -t --from line 20");
    assert!(second.until("/sd/job.g is not gone on with any more"), "{}", second.said);
    let third = Machine::start(&card, &carriages, None);
    assert!(!third.said.contains("interrupted"), "{}", third.said);
}
