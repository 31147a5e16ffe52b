//! RTT on the real image: a console through a debug probe, and a probe that does not read.

use virtual_prime::rtt::BLOCK_IF_FULL;

use crate::common::velvet::{Plan, SECOND, Velvet};

/// Numbers of the channels, up and down.
const LOG: u64 = 0;
const CONSOLE: u64 = 1;
/// Interval at which the probe reads, ms.
const LOOK_MS: u64 = 2;

/// A person at the console over RTT.
struct Person {
    velvet: Velvet,
    heard: String,
}

impl Person {
    fn at(velvet: Velvet) -> Self {
        Self { velvet, heard: String::new() }
    }

    /// Runs the board for a while, and reads.
    #[track_caller]
    fn hear(&mut self, ms: u64) {
        for _ in 0..ms.div_ceil(LOOK_MS) {
            self.velvet.hear(LOOK_MS);
            let said = self.velvet.probe(|probe, host| probe.read(host, CONSOLE));
            self.heard += &String::from_utf8_lossy(&said);
        }
    }

    /// Types as fast as the board takes it, and reads meanwhile.
    #[track_caller]
    fn type_in(&mut self, channel: u64, text: &str) {
        let mut rest = text.as_bytes().to_vec();
        let end = self.velvet.now_ms() + 20 * SECOND;
        while !rest.is_empty() {
            assert!(self.velvet.now_ms() < end, "{} bytes were not taken", rest.len());
            let bytes = rest.clone();
            let taken = self.velvet.probe(move |probe, host| probe.write(host, channel, &bytes));
            rest.drain(..taken);
            self.hear(LOOK_MS);
        }
    }

    #[track_caller]
    fn hear_until(&mut self, words: &str, patience_ms: u64) {
        let end = self.velvet.now_ms() + patience_ms;
        while !self.heard.contains(words) {
            assert!(self.velvet.now_ms() < end, "no {words:?}; it said: {}", self.heard);
            self.hear(LOOK_MS);
        }
    }
}

/// Starts a move of X for ten seconds, 800 steps a second.
fn moving() -> Velvet {
    let mut velvet = Plan::new().leaving_log().start();
    velvet.ask("G28.3 X30 Y30 Z30", SECOND);
    velvet.type_in("G1 X130 F600");
    velvet.hear(300);
    velvet
}

/// Asserts that X arrived, and every step was on time.
#[track_caller]
fn moved_undisturbed(velvet: &mut Velvet) {
    let end = velvet.now_ms() + 12 * SECOND;
    let x_mm = |velvet: &mut Velvet| velvet.world(|world| world.carriage_mm(units::Actuator::Alpha)).expect("a motor");
    while (x_mm(velvet) - 130.0).abs() > 1e-6 {
        assert!(velvet.now_ms() < end, "it stands at {} mm", x_mm(velvet));
        velvet.hear(100);
    }
    let steps = velvet.ask("get steps", SECOND);
    assert!(steps.contains("late: 0 (") && steps.contains("delayed: 0\n"), "{steps}");
}

#[test]
fn a_console_through_a_probe_is_greeted_and_answered() {
    let mut person = Person::at(Plan::new().start());
    assert_eq!(person.velvet.probe(|probe, host| probe.channels(host)), Some((2, 2)));
    person.hear(50);
    assert_eq!(person.heard, "", "nobody was there");
    person.type_in(CONSOLE, "M115\n");
    person.hear_until("Welcome to Smoothie", 100);
    person.hear_until("FIRMWARE_NAME:", 100);
    // Tools that type into channel 0 reach it too.
    person.type_in(0, "get mode\n");
    person.hear_until("idle", 100);
    let events = person.velvet.ask("events", SECOND);
    assert!(events.contains("somebody came to console 5"), "{events}");
    // Commands that act at once do so over RTT as well.
    person.velvet.type_in("G1 X20 F60");
    person.hear(200);
    person.type_in(CONSOLE, "M112\n");
    person.hear_until("ALARM: Emergency stop (M112)", 20);
}

#[test]
fn a_flood_through_a_probe_loses_no_line_and_no_step() {
    const LINES: usize = 400;
    let mut person = Person::at(moving());
    person.type_in(CONSOLE, &"M114.2\n".repeat(LINES));
    person.hear(500);
    let answers = person.heard.matches("X:").count();
    assert_eq!(answers, LINES, "{}", person.heard);
    moved_undisturbed(&mut person.velvet);
}

/// The probe sets the mode that blocks while a ring is full, as probe-rs does at once, and then reads nothing
/// any more.
#[test]
fn a_probe_that_asks_to_be_waited_for_and_does_not_read_stops_nothing() {
    let mut velvet = moving();
    velvet.probe(|probe, host| {
        probe.set_mode(host, LOG, BLOCK_IF_FULL);
        probe.set_mode(host, CONSOLE, BLOCK_IF_FULL);
    });
    // Answers and events fill the rings many times over.
    for round in 0..40 {
        velvet.probe(|probe, host| probe.write(host, CONSOLE, &b"M115\n".repeat(20)));
        velvet.ask(if round % 2 == 0 { "M104 S40" } else { "M104 S0" }, SECOND);
        velvet.hear(40);
    }
    moved_undisturbed(&mut velvet);
    // A person who does not read for long counts as gone, and comes again with the next byte.
    velvet.hear(10 * SECOND);
    assert!(velvet.ask("events", SECOND).contains("console 5 was left"), "{}", velvet.said());
    let mut person = Person::at(velvet);
    person.hear(20);
    person.heard.clear();
    person.type_in(CONSOLE, "get mode\n");
    person.hear_until("idle", 200);
}
