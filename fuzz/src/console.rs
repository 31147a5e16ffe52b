//! A whole machine on the native runner, with random input typed at its consoles.
//!
//! Conditions that every input must meet: nothing panics; every wait has an end; motors stay within the
//! speeds and accelerations that the configuration permits and carriages within their travel ([`guard`]);
//! no heater is asked for more than its `max_temp`; after M112 nothing is on within a millisecond; and a
//! machine that was repaired can be released and answers.
//!
//! An input is typed text, and lines of directions, see [`DIRECTIONS`]. Virtual time is bounded: half a
//! millisecond for each line typed, and [`MOST_WAIT_NS`] for all `@wait` together.

mod guard;
mod machines;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use base::sessions::SessionId;
use sim::runner::{Runner, Setup};
use sim::world::{Fault, TimedFault};

use guard::Guard;
pub use machines::{MACHINES, config};

/// Directions that an input may hold, each on a line of its own; everything else is typed as it stands.
///
/// `@machine` counts in the first line alone. `@home` homes and waits for the end. `@file` puts the lines up
/// to `@end` on the card as `part.g`, before power-on.
pub const DIRECTIONS: &[&str] = &[
    "@machine printer",
    "@machine corners",
    "@machine mill",
    "@machine delta",
    "@machine corexy",
    "@session 0",
    "@session 1",
    "@wait 1",
    "@wait 10",
    "@wait 100",
    "@wait 500",
    "@home",
    "@file",
    "@end",
    "@press kill",
    "@press minx",
    "@press probe",
    "@press light",
    "@release kill",
    "@release minx",
    "@release probe",
    "@release light",
    "@fault thermistor-open:hotend",
    "@fault thermistor-short:bed",
    "@fault driver-short:alpha",
    "@fault driver-silent:beta",
    "@fault motor-supply:0",
    "@fault switch-never:minx",
    "@fault heater-stuck-on:hotend",
    "@fault repaired",
];
/// Longest total wait of an input, nanoseconds.
pub const MOST_WAIT_NS: u64 = 2_000 * MS;
/// Time that passes with each typed line, nanoseconds.
const LINE_NS: u64 = MS / 2;
/// Longest time until `@home` ends, nanoseconds.
const HOMING_NS: u64 = 6_000 * MS;
/// Time after M112 in which motors come to a stand without current: a second for braking, another one for
/// motors that do not brake.
const REST_NS: u64 = 2_200 * MS;
/// Time that YModem waits for the rest of a block.
const BLOCK_NS: u64 = 1_100 * MS;
/// A millisecond in nanoseconds.
const MS: u64 = 1_000_000;
/// Greatest number of an input's lines that count.
const MOST_LINES: usize = 200;
/// Greatest number of restarts of the machine with the same card.
const MOST_RESETS: u32 = 2;
/// Turns of the executor in half a millisecond: few, which stands for a busy board, and quick.
const TURNS: u32 = 3;
/// M112, behind the end of half a line, of an `upload` (Ctrl-D) and of M28, which take everything but that.
const HALT: &[u8] = b"\n\x04\nM29\nM112\n";
const CONSOLE: SessionId = SessionId(0);
const OTHER: SessionId = SessionId(1);

/// Runs an input and checks the conditions of this module.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    let mut bench = Bench::start(bytes);
    let mut in_file = false;
    for line in bytes.split_inclusive(|byte| *byte == b'\n').take(MOST_LINES) {
        let trimmed = line.trim_ascii_end();
        match trimmed {
            b"@file" => in_file = true,
            b"@end" => in_file = false,
            _ if in_file => {}
            _ => bench.line(line, std::str::from_utf8(trimmed).unwrap_or("")),
        }
    }
    bench.emergency_stop();
    bench.comes_back();
}

/// Returns the text between `@file` and `@end`.
fn file_of(bytes: &[u8]) -> Vec<u8> {
    let lines = bytes.split_inclusive(|byte| *byte == b'\n');
    let inside = lines.skip_while(|line| line.trim_ascii_end() != b"@file").skip(1);
    inside.take_while(|line| line.trim_ascii_end() != b"@end").flatten().copied().collect()
}

/// Machine with its card and its guard.
struct Bench {
    runner: Runner,
    card: PathBuf,
    guard: Guard,
    session: SessionId,
    waited_ns: u64,
    resets: u32,
    /// The configuration is unusable for any machine.
    is_unusable: bool,
}

impl Drop for Bench {
    fn drop(&mut self) {
        // A folder left behind harms nobody.
        let _ = fs::remove_dir_all(&self.card);
    }
}

impl Bench {
    fn start(bytes: &[u8]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = bytes.strip_prefix(b"@machine ").unwrap_or(b"printer");
        let name = name.split(|byte| !byte.is_ascii_alphabetic()).next().unwrap_or_default();
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let card = std::env::temp_dir().join(format!("velvet-fuzz-{}-{number}", std::process::id()));
        fs::create_dir_all(card.join("sub")).expect("a temporary folder");
        fs::write(card.join("config.ini"), config(name)).expect("a file in it");
        fs::write(card.join("part.g"), file_of(bytes)).expect("a file in it");
        fs::write(card.join("other.g"), "G91\nG1 X1 F3000\nM106 S200\nG1 X-1\nM107\n").expect("a file in it");
        let mut bench = Self {
            runner: power_on(&card),
            card,
            guard: Guard::default(),
            session: CONSOLE,
            waited_ns: 0,
            resets: 0,
            is_unusable: false,
        };
        bench.boot();
        bench
    }

    fn boot(&mut self) {
        self.pass(20 * MS);
        self.is_unusable = self.heard(CONSOLE).contains("fatal error in the config.ini");
    }

    /// Types a line of the input, or follows its direction.
    fn line(&mut self, line: &[u8], text: &str) {
        if let Some((direction, about)) = text.strip_prefix('@').map(|rest| rest.split_once(' ').unwrap_or((rest, "")))
            && self.direct(direction, about)
        {
            return;
        }
        self.guard.hear_typed(line);
        // Bytes that do not fit are lost, and the machine itself has to report them.
        let _ = self.runner.send_on(self.session, line);
        self.pass(LINE_NS);
        if self.runner.reset_requested() && self.resets < MOST_RESETS {
            self.resets += 1;
            self.runner = power_on(&self.card);
            self.guard = Guard::default();
            self.boot();
        }
    }

    /// Follows a direction. False when no such direction exists: then the line is typed.
    fn direct(&mut self, direction: &str, about: &str) -> bool {
        let now_ns = self.runner.now_ns();
        match direction {
            "machine" => {}
            "session" => self.session = if about == "1" { OTHER } else { CONSOLE },
            "wait" => {
                let wanted_ns = about.parse::<u32>().map_or(MS, |ms| u64::from(ms) * MS);
                let wait_ns = wanted_ns.min(MOST_WAIT_NS - self.waited_ns);
                self.waited_ns += wait_ns;
                self.pass(wait_ns);
            }
            "home" => self.home(),
            "press" | "release" => {
                self.guard.switch_is_pressed();
                // The machine may have no such switch.
                let _ = self.runner.world(|world| world.press(now_ns, about, direction == "press"));
            }
            "fault" => {
                self.guard.something_breaks();
                // The machine may have no such part.
                let fault = TimedFault::parse(about);
                let _ = fault.and_then(|fault| self.runner.world(|world| world.inject(&fault.fault)));
            }
            _ => return false,
        }
        true
    }

    fn home(&mut self) {
        // The text typed so far becomes a line and is answered.
        let _ = self.runner.send_on(self.session, b"\n");
        self.pass(50 * MS);
        let _ = self.heard(self.session);
        let _ = self.runner.send_on(self.session, b"$H\n");
        let end_ns = self.runner.now_ns() + HOMING_NS;
        let mut heard = String::new();
        while !["ok\n", "error", "!!"].iter().any(|answer| heard.contains(answer)) && self.runner.now_ns() < end_ns {
            self.pass(10 * MS);
            heard.push_str(&self.heard(self.session));
        }
        if heard.ends_with("ok\n") && self.runner.motion(|motion| motion.is_idle()) {
            self.guard.is_homed(&self.runner);
        }
    }

    /// Returns the text sent on a session since the last look.
    fn heard(&self, session: SessionId) -> String {
        String::from_utf8_lossy(&self.runner.read_from(session)).into_owned()
    }

    /// Lets time pass, and checks the machine in every slot.
    fn pass(&mut self, ns: u64) {
        let end_ns = self.runner.now_ns() + ns;
        while self.runner.now_ns() < end_ns {
            self.runner.step();
            self.guard.look(&self.runner);
        }
    }

    /// Sends M112, whatever is under way: within a millisecond the machine is halted and nothing is on.
    fn emergency_stop(&mut self) {
        // A line typed already may release the halt at once: then the next halt holds, for that line is
        // gone.
        for attempt in 1..=4_096 {
            if attempt % 256 == 0 {
                self.end_transfer();
            }
            let _ = self.runner.send_on(CONSOLE, HALT);
            for _ in 0..2 {
                self.pass(LINE_NS);
                if self.is_halted() {
                    return self.guard.nothing_is_on(&self.runner);
                }
            }
        }
        panic!("M112 does not halt");
    }

    /// Returns whether the machine is halted, or never works because its configuration is unusable.
    fn is_halted(&self) -> bool {
        self.is_unusable || self.runner.heat(thermal::HeatControl::is_halted)
    }

    /// Checks that the machine, repaired and let go, is released and answers both its consoles.
    fn comes_back(&mut self) {
        let repaired = self.runner.world(|world| world.inject(&Fault::Repaired));
        assert_eq!(repaired, Ok(()), "repair");
        // Waiting lines are answered or release the machine: each release is stopped again.
        for _ in 0..1_000 {
            if !self.is_halted() {
                self.end_transfer();
            }
            let _ = self.runner.send_on(CONSOLE, HALT);
            if self.comes_to_rest() && self.says_that_it_is_halted(CONSOLE) && self.says_that_it_is_halted(OTHER) {
                return self.release();
            }
        }
        panic!("it does not stay halted");
    }

    /// Ends a transfer. The console may have begun to receive by YModem, so that its words are the file's:
    /// two of Ctrl-X end that, behind a block that is given up. Or the console edits a file, which `%c`
    /// ends.
    fn end_transfer(&mut self) {
        self.pass(BLOCK_NS);
        let _ = self.runner.send_on(CONSOLE, b"\n%c\n\x18\x18\x18");
    }

    /// Waits until motors stand and have no current. False when the halt was released meanwhile.
    fn comes_to_rest(&mut self) -> bool {
        let end_ns = self.runner.now_ns() + REST_NS;
        self.pass(5 * MS);
        while self.is_halted() {
            if Guard::rests(&self.runner) {
                return true;
            }
            assert!(self.runner.now_ns() < end_ns, "motors have current long after M112");
            self.pass(LINE_NS);
        }
        false
    }

    /// Returns whether `?` reports a halt, behind the end of a transfer, of an upload, of editing and of
    /// half a line.
    fn says_that_it_is_halted(&mut self, session: SessionId) -> bool {
        for _ in 0..3 {
            // Two of Ctrl-X end YModem, outside a block at once.
            let _ = self.runner.send_on(session, b"\n\x04\nM29\n%c\n\x18\x18\x18");
            self.pass(5 * MS);
            let _ = self.heard(session);
            let _ = self.runner.send_on(session, b"?");
            self.pass(5 * MS);
            let said = self.heard(session);
            if said.contains('<') {
                return said.contains("<Alarm|");
            }
            // A block that does not end is given up.
            self.pass(BLOCK_NS);
        }
        panic!("no answer to ? on {session:?}");
    }

    fn release(&mut self) {
        let mut said = String::new();
        // The wait exceeds the five seconds that `cat -d` waits before it begins.
        for attempt in 0..40 {
            if attempt % 5 == 0 {
                let _ = self.runner.send_on(CONSOLE, b"M999\nM105\n");
            }
            self.pass(10 * attempt * MS);
            said.push_str(&self.heard(CONSOLE));
            // M105 is answered so in a state in which it may answer.
            if ["ok T", "ok B", "[MSG:T", "[MSG:B", "the configuration has errors"]
                .iter()
                .any(|answer| said.contains(answer))
            {
                return;
            }
        }
        panic!("M999 and M105 are not answered: {said:?}");
    }
}

fn power_on(card: &Path) -> Runner {
    let mut runner = Runner::new(&Setup::new(card)).expect("no faults are ordered");
    runner.set_turns(TURNS);
    runner
}
