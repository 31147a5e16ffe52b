//! Rate of reading the card, and effect of a card that stalls: nobody has to wait.

use crate::common::MS;
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet, image};
use rigless::soc::Width;
use sim::models::sd_card::{Traits, Trouble};
use virtual_prime::image::Symbols;

/// Longest time that the executor may be held by a card that writes; its reads meanwhile count too.
const HELD_NS: u64 = 5 * MS;
/// Longest time that a card may take to write a block (SD PL 6.00, section 4.6.2.2).
const SLOWEST_NS: u64 = 250 * MS;

/// Changes the faults of the card in the slot.
fn trouble(velvet: &mut Velvet, change: impl FnOnce(&mut Trouble) + Send + 'static) {
    let changed = velvet.bench.vm.with(|stopped| {
        let card = stopped.session.board_mut().mcu.sdmmc.card_mut();
        card.map(|card| change(card.trouble()))
    });
    changed.flatten().expect("a card in the slot");
}

/// Reads a file of a megabyte, through the file system and up to its sum: clusters of one block, so that the
/// table is asked for each.
#[test]
fn a_file_is_read_with_eight_megabytes_a_second_and_more() {
    let line = "G1 X123.456 Y123.456 E1.23456 ; a line\n";
    let text = line.repeat((1 << 20) / line.len());
    let mut velvet = Plan::new().file("large.g", &text).start();
    // The command's letters take a millisecond and a half.
    velvet.ask("card", SECOND);
    let before = velvet.bench.vm.now_ns();
    velvet.type_in("md5sum large.g");
    while !velvet.said().contains(" large.g\n") {
        velvet.hear_for(MS / 4);
    }
    let took_ns = velvet.bench.vm.now_ns() - before;
    let said = velvet.ask("card", SECOND);
    println!(
        "{} bytes in {:.1} ms: {:.2} MB/s; {said}",
        text.len(),
        took_ns as f64 / 1e6,
        text.len() as f64 * 1e3 / took_ns as f64
    );
    assert!(said.contains("50.0 MHz") && said.contains("repeated 0, damaged 0"), "{said}");
    assert!(text.len() as u64 * 1_000 > 8 * took_ns, "{took_ns} ns");
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

/// Watch on the executor's count of turns, four times a millisecond.
struct Watch {
    address: u64,
    turns: u64,
    /// Time since the count last changed, and the longest such time.
    still_ns: u64,
    longest_ns: u64,
}

impl Watch {
    const STEP_NS: u64 = MS / 4;

    fn new() -> Self {
        let address =
            Symbols::read(&image()).expect("an ELF file").object("executor5TURNS").expect("the count").address;
        Self { address, turns: 0, still_ns: 0, longest_ns: 0 }
    }

    /// Runs the board until this is said.
    #[track_caller]
    fn until(&mut self, velvet: &mut Velvet, words: &str, patience_ms: u64) {
        let before = velvet.said().len();
        let end = velvet.now_ms() + patience_ms;
        while !velvet.said()[before..].contains(words) {
            assert!(velvet.now_ms() < end, "no {words:?}: {}", &velvet.said()[before..]);
            self.step(velvet);
        }
    }

    fn step(&mut self, velvet: &mut Velvet) {
        velvet.hear_for(Self::STEP_NS);
        let address = self.address;
        let turns = velvet.bench.vm.with(move |stopped| stopped.host.read(address, Width::W32).ok());
        let turns = turns.flatten().expect("memory");
        self.still_ns = if turns == self.turns { self.still_ns + Self::STEP_NS } else { 0 };
        self.turns = turns;
        self.longest_ns = self.longest_ns.max(self.still_ns);
    }

    /// Types a line, and waits for its answer.
    #[track_caller]
    fn ask(&mut self, velvet: &mut Velvet, line: &str, words: &str) {
        velvet.type_in(line);
        self.until(velvet, words, 120 * SECOND);
    }

    /// Returns the longest time without a turn since the last call, plus a step that was not seen.
    fn take(&mut self, what: &str) -> u64 {
        let longest_ns = std::mem::take(&mut self.longest_ns) + Self::STEP_NS;
        println!("{what}: no turn of the executor for {:.1} ms at most", longest_ns as f64 / 1e6);
        longest_ns
    }
}

#[test]
fn no_write_holds_the_executor_however_slow_the_card() {
    let traits = Traits { programming_ns: SLOWEST_NS, ..Traits::default() };
    let mut plan = Plan::new().set("[general] config-override = true").set("[player] power_loss = true");
    plan = plan.set("[player] power_loss_period = 1").file("old.g", &"G4 P1\n".repeat(700));
    let part = "G28.3 X4 Y4 Z2\nM83\nG1 Z0.3 F600\n".to_owned() + &"G1 X14 E0.2 F600\nG1 X4 E0.2\n".repeat(3);
    let mut velvet = plan.file("part.g", &part).with_traits(traits).held();
    // The journal's file is made at this first boot, before anybody is served.
    velvet.hear_until(PROMPT, 60 * SECOND);
    velvet.hear(10 * SECOND);
    let (velvet, mut watch, mut worst) = (&mut velvet, Watch::new(), Vec::new());
    watch.step(velvet);
    watch.take("nothing");
    for round in 0..2 {
        watch.ask(velvet, &format!("M92 X8{round}"), "ok\n");
        watch.ask(velvet, "M500", "Settings Stored");
    }
    worst.push(watch.take("M500"));
    watch.ask(velvet, "M28 up.g", "Writing to file");
    for line in 0..25 {
        watch.ask(velvet, &format!("G1 X{line} Y{line} ; a line of the file that is sent"), "ok\n");
    }
    watch.ask(velvet, "M29", "Done saving file.");
    worst.push(watch.take("an upload"));
    watch.ask(velvet, "cp old.g new.g", "ok\n");
    worst.push(watch.take("cp"));
    watch.ask(velvet, "rm old.g", "deleted old.g");
    watch.ask(velvet, "mkdir folder", "ok\n");
    watch.ask(velvet, "mv new.g folder/new.g", "ok\n");
    worst.push(watch.take("rm, mkdir, mv"));
    watch.ask(velvet, "play /sd/part.g -t", "Done printing file");
    worst.push(watch.take("a job with a journal"));
    let entries = velvet.card(|card| card.content().chunks(512).filter(|block| block.starts_with(b"VPLJ")).count());
    assert!(entries > 3, "{entries} blocks of the journal");
    assert!(worst.iter().all(|gap_ns| *gap_ns <= HELD_NS), "{worst:?}");
}

/// Returns lines of 0.02 mm at 100 mm/s: 5,000 a second, of 28 bytes.
fn short_lines() -> String {
    let lines: String = (0..10_000)
        .map(|n| format!("G1 X{:.3} Y{:.3} E0.00010\n", 20.0 + f64::from(n) * 0.012, 20.0 + f64::from(n) * 0.016))
        .collect();
    format!("G90\nM83\nG28.3 X20 Y20 Z2 E0\nG1 F6000\n{lines}")
}

/// Four reads of the card stall for 250 ms each, while 5,000 lines a second are played: every step is at its
/// time without stalls.
#[test]
fn a_card_that_stalls_starves_no_motion_at_5000_lines_a_second() {
    let run = |stalls: u32| {
        let mut plan = Plan::new().set("[motion control] default_acceleration = 15000").set("[player] preflight = off");
        for motor in ["alpha", "beta", "delta"] {
            plan = plan.set(&format!("[actuator] {motor}.acceleration = 15000"));
        }
        let mut velvet = plan.file("short.g", &short_lines()).carriages(&[20.0, 20.0, 2.0, 0.0]).start();
        velvet.type_in("play /sd/short.g -t");
        velvet.hear(300);
        for _ in 0..stalls {
            trouble(&mut velvet, |trouble| trouble.slow_reads = (SLOWEST_NS, 1));
            velvet.hear(400);
        }
        let left = velvet
            .bench
            .vm
            .with(|stopped| stopped.session.board_mut().mcu.sdmmc.card_mut().map(|card| card.trouble().slow_reads.1));
        assert_eq!(left.flatten(), Some(0), "a stall was not had");
        velvet.hear_until("Done printing file", 60 * SECOND);
        let edges = velvet.world(|world| world.trace_mut().take());
        let began = edges.first().expect("it moves").time_ns;
        let took_ns = edges.last().expect("it moves").time_ns - began;
        println!("{:.0} lines a second", 10_000e9 / took_ns as f64);
        edges.iter().map(|edge| (edge.time_ns - began, edge.actuator, edge.direction)).collect::<Vec<_>>()
    };
    let (quiet, stalled) = (run(0), run(4));
    assert_eq!(quiet.len(), stalled.len());
    assert!(quiet.last().expect("steps").0 < 2_100 * MS, "fewer than 5,000 lines a second");
    let worst = quiet.iter().zip(&stalled).map(|(a, b)| a.0.abs_diff(b.0)).max();
    println!("the farthest edge is {worst:?} ns away");
    assert!(worst.is_some_and(|ns| ns < 1_000), "{worst:?}");
}
