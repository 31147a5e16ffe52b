//! Answers to `?` within 10 ms, in every state of the machine: from the arrival of its byte to the arrival of
//! the answer's first byte.

use sim::models::surface::{Bed, Surface};

use crate::common::MS;
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet};

const PROMISED_NS: u64 = 10 * MS;
/// Pause between an answer and the next question: ever other times, or they would fall into step with the
/// answers.
fn pause_ns(number: usize) -> u64 {
    20 * MS + number as u64 * 3_141_593 % (15 * MS)
}

/// Asks once, on the console with all other traffic. Returns the time at which the answer began.
#[track_caller]
fn ask(velvet: &mut Velvet) -> u64 {
    let asked_ns = velvet.send_through(b"?");
    for _ in 0..200 {
        let heard = velvet.hear_for(MS / 2);
        if let Some(first) = heard.iter().find(|arrived| arrived.byte == b'<' && arrived.at_ns > asked_ns) {
            return first.at_ns - asked_ns;
        }
    }
    panic!("no answer; it said: {}", velvet.said());
}

/// Asks this many times; each answer comes soon, and shows this state.
#[track_caller]
fn assert_answered(velvet: &mut Velvet, what: &str, count: usize, state: &str) {
    let before = velvet.said().len();
    let mut worst_ns = 0;
    for number in 0..count {
        worst_ns = worst_ns.max(ask(velvet));
        velvet.hear_for(pause_ns(number));
    }
    println!("{what}: {worst_ns} ns at worst");
    assert!(worst_ns <= PROMISED_NS, "{what}: {worst_ns} ns");
    let shown = velvet.said()[before..].matches(&format!("<{state}|")).count();
    // The last question may have come after the end of the state.
    assert!(shown + 1 >= count, "{what}: {shown} of {count} answers show {state}: {}", &velvet.said()[before..]);
}

fn lay(velvet: &mut Velvet, surface: Surface) {
    let at_ns = velvet.bench.vm.now_ns();
    velvet.world(|world| world.lay(at_ns, surface));
    velvet.hear(5);
}

#[test]
fn in_homing() {
    let mut velvet = Plan::new().start();
    velvet.type_in("G28");
    velvet.hear(20);
    assert_answered(&mut velvet, "homing", 25, "Home");
}

#[test]
fn while_waiting_for_heat() {
    let mut velvet = Plan::new().start();
    velvet.type_in("M109 S200");
    velvet.hear(20);
    assert_answered(&mut velvet, "M109", 30, "Idle");
}

fn with_probe() -> Plan {
    ["enable = true", "probe_pin = PB10^", "max_travel = 15", "leveling = cartesian grid", "probe_height = 2"]
        .iter()
        .fold(Plan::new(), |plan, line| plan.set(&format!("[zprobe] {line}")))
}

#[test]
fn in_probing() {
    let mut velvet = with_probe().start();
    velvet.type_in("G38.3 Z-8 F240");
    velvet.hear(20);
    assert_answered(&mut velvet, "probing", 15, "Run");
}

#[test]
fn in_probing_a_mesh() {
    let grid = ["only_by_two_corners = true", "grid_x_size = 3", "grid_y_size = 2", "initial_height = -6"];
    let plan =
        grid.iter().fold(with_probe(), |plan, line| plan.set(&format!("[cartesian grid leveling strategy] {line}")));
    let mut velvet = plan.start();
    lay(&mut velvet, Surface { bed: Some(Bed::tilted(0.5, [0.01, 0.02])), ..Surface::default() });
    velvet.type_in("G32 X0 Y0 A10 B10");
    velvet.hear(20);
    assert_answered(&mut velvet, "mesh probe", 80, "Run");
    assert!(velvet.said().contains("DEBUG: X"), "no point was probed: {}", velvet.said());
}

/// A file has more lines a second than the machine can take, so that it does nothing but take lines.
#[test]
fn in_a_file_at_full_line_rate() {
    const LINES: usize = 50_000;
    let lines =
        (0..LINES).map(|n| format!("G1 X{:.2} Y{:.2}\n", 20.0 + n as f64 * 0.001, 20.0 + (n % 2) as f64 * 0.001));
    let file = format!("G90\nG1 X20 Y20 F18000\n{}", lines.collect::<String>());
    // The file begins at once, as its check runs beside.
    let mut velvet = Plan::new().set("[player] preflight_wait = 0").file("short.g", &file).held();
    velvet.hear_until(PROMPT, 2 * SECOND);
    velvet.ask("M23 short.g", SECOND);
    velvet.ask("M24", SECOND);
    velvet.hear(500);
    let began = played(&mut velvet);
    let began_ms = velvet.now_ms();
    assert_answered(&mut velvet, "file", 15, "Run");
    let lines = (played(&mut velvet) - began) / (file.len() / LINES) as u64;
    let rate = lines * SECOND / (velvet.now_ms() - began_ms);
    println!("{rate} lines a second");
    assert!(rate > 5_000, "only {rate} lines a second");
}

/// Returns the bytes of the file that have been played.
#[track_caller]
fn played(velvet: &mut Velvet) -> u64 {
    let said = velvet.ask("M27", SECOND);
    let bytes = said.split("SD printing byte ").nth(1).and_then(|rest| rest.split('/').next());
    bytes.and_then(|bytes| bytes.parse().ok()).unwrap_or_else(|| panic!("{said}"))
}
