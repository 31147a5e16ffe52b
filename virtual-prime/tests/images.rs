//! Other people's images run too: each of the small images in `images/` tests one part of the board from
//! inside.

use crate::common::{Bench, MS, boot, boot_on};
use sim::world::WorldConfig;
use units::Actuator;
use virtual_prime::board::PrimeBoard;
use virtual_prime::net_desk;
use virtual_prime::peripherals::ethernet::{Partner, Wire};
use virtual_prime::sd_image;
use virtual_prime::vm::Span;

#[test]
fn an_image_greets_and_echoes_on_the_debug_console() {
    let mut bench = boot("hello");
    assert_eq!(bench.vm.run_for(10 * MS), Span::Reached);
    assert_eq!(String::from_utf8_lossy(&bench.console.receive()), "hello from 0x20036450\n");
    bench.console.send(b"abc.");
    assert_eq!(bench.expect_pass(10), "ABC");
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn blocks_cross_the_sd_bus_by_fifo_and_by_dma() {
    let files = [("hello.txt".to_owned(), b"from the host".to_vec())];
    let mut board = PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right");
    board.insert_card(Some(sd_image::build(None, &files).expect("a volume")));
    boot_on("sd", board).expect_pass(1_000);
}

#[test]
fn a_motor_turns_by_both_edges_until_its_switch_closes() {
    let mut bench = boot("drivers");
    let world = bench.world();
    bench.expect_pass(1_000);
    let world = world.lock();
    assert_eq!(world.carriage_mm(Actuator::Alpha), Some(0.0));
    assert_eq!(world.trace().tally(Actuator::Alpha).net_steps, -30 * 80);
    assert_eq!(world.driver(0).microsteps(), 16);
    assert!(world.driver(0).double_edge() && world.driver(0).drives());
    assert_eq!(world.timing_faults(), 0);
}

#[test]
fn voltages_reach_the_converters_and_outputs_reach_the_heater() {
    let mut bench = boot("analog");
    let world = bench.world();
    bench.expect_pass(1_000);
    let hotend = world.lock().heater_c(0);
    // The heater has 40 W for 20 ms into 12 J/K.
    assert!((hotend - 22.0 - 40.0 * 0.020 / 12.0).abs() < 0.005, "{hotend}");
    assert_eq!(world.lock().pwm_duty(0, 0), 0.25);
}

#[test]
fn the_watchdog_bites_when_it_is_not_fed_and_says_so_after_the_reset() {
    let mut bench = boot("watchdog");
    assert_eq!(bench.expect_pass(1_000), "fed\nbitten\n");
    let resets: Vec<_> = bench.vm.complaints().into_iter().filter(|line| line.starts_with("reset")).collect();
    assert_eq!(resets.len(), 1, "{resets:?}");
}

#[test]
fn a_run_is_the_same_however_it_is_cut_into_spans() {
    let hash = |span_ns: u64| {
        let mut bench = boot("drivers");
        let world = bench.world();
        while bench.vm.run_for(span_ns) == Span::Reached {}
        world.lock().trace().edge_hash()
    };
    assert_eq!(hash(777_777), hash(100 * MS));
}

#[test]
fn the_clock_runs_into_a_new_year() {
    boot("clock").expect_pass(5_000);
}

fn board_with(content: Vec<u8>) -> PrimeBoard {
    let mut board = PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right");
    board.insert_card(Some(content));
    board
}

#[test]
fn blocks_cross_the_fifo_by_polling_in_every_way_and_at_its_own_pace() {
    let mut bench = boot_on("sd_polled", board_with(vec![0; 64 << 20]));
    bench.expect_pass(2_000);
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn a_card_can_be_pulled_out_and_another_one_put_in() {
    let card = |word: u32| {
        let mut content = vec![0; 1 << 20];
        content[5 * 512..][..4].copy_from_slice(&word.to_le_bytes());
        content
    };
    let mut bench = boot_on("card_change", board_with(card(0x1111_0001)));
    let mut change = |content: Option<Vec<u8>>| {
        assert_eq!(bench.vm.run_for(50 * MS), Span::Reached);
        bench.vm.with(|stopped| stopped.session.board_mut().insert_card(content));
    };
    change(None);
    change(Some(card(0x2222_0002)));
    // The card is exchanged for another without a pause: the new card does not know the old card's address.
    change(Some(card(0x3333_0003)));
    change(None);
    let said = bench.expect_pass(100);
    assert_eq!(said, "0x11110001\ngone\n0x22220002\ngone\n0x33330003\ngone\n");
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

/// Types a line and waits for its echo.
#[track_caller]
fn expect_echo(bench: &mut Bench, typed: &str) {
    bench.console.send(typed.as_bytes());
    let mut said = Vec::new();
    for _ in 0..20 {
        let span = bench.vm.run_for(MS);
        said.extend(bench.console.receive());
        assert_eq!(span, Span::Reached, "{}", bench.words(&said));
    }
    assert_eq!(String::from_utf8_lossy(&said), typed.to_uppercase());
}

#[test]
fn a_serial_port_works_polled_by_interrupt_and_by_dma_to_the_idle_line() {
    let mut bench = boot("serial");
    assert_eq!(bench.vm.run_for(10 * MS), Span::Reached);
    bench.console.send(b"12");
    assert_eq!(bench.vm.run_for(10 * MS), Span::Reached);
    expect_echo(&mut bench, "polled\n");
    expect_echo(&mut bench, "by interrupts, asleep in between\n");
    // Messages end where the line falls idle, not at a character.
    expect_echo(&mut bench, "a message by dma");
    bench.console.send(b"more");
    assert_eq!(bench.expect_pass(20), "MORE16 4\n");
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn an_image_with_one_mpu_region_polls_at_speed_and_is_guarded() {
    let mut bench = boot("mpu");
    bench.expect_pass(200);
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn the_ethernet_reset_ends_with_the_clock_of_the_phy_which_answers() {
    let mut bench = boot("ethernet");
    assert_eq!(bench.expect_pass(200), "reset\nphy 0007 c0f1\nstatus 7809\n");
    // A reset without the PHY's clock is a complaint.
    let complaints = bench.vm.complaints();
    assert_eq!(complaints.len(), 1, "{complaints:?}");
    assert!(complaints[0].contains("SWR"), "{complaints:?}");
}

/// A frame of the partner's with a command for the image `ethernet_frames`.
fn command(to: [u8; 6], command: u8, length: usize) -> Vec<u8> {
    let mut frame = [&to[..], &[0x02, 0xAA, 0xBB, 0xCC, 0xDD, 0xEE, 0x88, 0xB5, command]].concat();
    frame.extend((frame.len()..length).map(|place| (place * 7 + length) as u8));
    frame
}

/// Sends frames to the board and runs for so long. Returns the payloads that came back.
fn exchange(bench: &mut Bench, frames: Vec<Vec<u8>>, duration_ns: u64) -> Vec<Vec<u8>> {
    net_desk::wire(&mut bench.vm, move |wire| frames.iter().for_each(|frame| wire.put(frame)));
    bench.vm.run_for(duration_ns);
    let sent = net_desk::wire(&mut bench.vm, Wire::take_all).expect("the image runs");
    sent.into_iter().map(|frame| frame.bytes[12..].to_vec()).collect()
}

#[test]
fn frames_cross_the_ethernet_rings_both_ways_through_the_filter_and_after_a_flood() {
    const BOARD: [u8; 6] = [0x02, 0x11, 0x22, 0x33, 0x44, 0x55];
    let mut bench = boot("ethernet_frames");
    net_desk::wire(&mut bench.vm, |wire| wire.plug(Partner::default()));
    while !String::from_utf8_lossy(&bench.console.receive()).contains("link 1058\n") {
        assert_eq!(bench.vm.run_for(10 * MS), Span::Reached, "{}", bench.words(&[]));
        assert!(bench.vm.now_ns() < 4_000 * MS, "no link");
    }
    // Every length from the shortest to the longest, so both rings wrap many times.
    for length in (60..=1_514).step_by(97).chain([1_514]) {
        let frame = command(BOARD, b'E', length);
        assert_eq!(exchange(&mut bench, vec![frame.clone()], 2 * MS), [&frame[12..]], "length {length}");
    }
    let everybody = command([0xFF; 6], b'E', 60);
    let group = command([0x01, 0x00, 0x5E, 0x00, 0x00, 0xFB], b'E', 61);
    let strangers = [[0x01, 0x00, 0x5E, 0x00, 0x00, 0x01], [0x02, 0x11, 0x22, 0x33, 0x44, 0x56]];
    let unheard = strangers.map(|to| command(to, b'E', 62));
    let frames = [vec![everybody.clone(), group.clone()], unheard.to_vec()].concat();
    assert_eq!(exchange(&mut bench, frames, 5 * MS), [&everybody[12..], &group[12..]]);
    // While the image looks away, five descriptors and the queue are used up, and the rest is lost.
    let flood: Vec<Vec<u8>> = (0..40).map(|round| command(BOARD, b'E', 400 + round)).collect();
    exchange(&mut bench, vec![command(BOARD, b'W', 60)], MS / 2);
    let answered = exchange(&mut bench, flood.clone(), 40 * MS);
    assert!((5..12).contains(&answered.len()), "{}", answered.len());
    assert!(answered.iter().zip(&flood).all(|(answer, frame)| answer == &frame[12..]));
    let counters = net_desk::wire(&mut bench.vm, |wire| wire.counters()).expect("the image runs");
    assert_eq!(counters.overflowed as usize, flood.len() - answered.len());
    assert_eq!((counters.filtered, counters.damaged, counters.at_wrong_speed), (2, 0, 0));
    let again = command(BOARD, b'E', 333);
    assert_eq!(exchange(&mut bench, vec![again.clone()], 2 * MS), [&again[12..]]);
    exchange(&mut bench, vec![command(BOARD, b'Q', 60)], 0);
    assert_eq!(bench.expect_pass(100), "done\n");
    assert_eq!(bench.vm.complaints(), Vec::<String>::new());
}
