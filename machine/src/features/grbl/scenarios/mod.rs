//! GRBL 1.1 as its senders see it: what they send, byte for byte, and every line that they get.

mod jog;
mod lines;
mod overrides;
mod parking;
mod probing;
mod reports;
mod settings;
mod stream;

use scenarios::{Bench, CARTESIAN, Plan};

const BANNER: &str = "Grbl 1.1f ['$' for help]\n";
const LOCKED: &str = "[MSG:'$H'|'$X' to unlock]\n";

fn plan() -> Plan {
    // In the GRBL mode saved settings are read again by default.
    Plan::new(CARTESIAN).with("grbl_mode = false", "grbl_mode = true").set("[general] config-override")
}

fn start() -> Bench {
    plan().start()
}

/// The answer to a line: its messages, and the one line that answers.
#[track_caller]
fn refused(bench: &mut Bench, line: &str, number: u8) -> String {
    let said = bench.say(line);
    let (messages, answers): (Vec<&str>, Vec<&str>) = said.lines().partition(|line| line.starts_with("[MSG:"));
    assert_eq!(answers, [format!("error:{number}")], "{line}: {said}");
    assert!(!messages.is_empty(), "{line} is refused without a reason");
    messages.join("\n")
}

trait Wait {
    fn hear_until_idle(&mut self);
}

impl Wait for Bench {
    fn hear_until_idle(&mut self) {
        let end = self.now_s() + 60.0;
        while self.moves() || !self.status().starts_with("<Idle") {
            assert!(self.now_s() < end, "it never rests: {}", self.status());
            self.hear(0.02);
        }
    }
}
