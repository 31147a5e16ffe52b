//! Character counting at full rate: a GRBL sender keeps the receive buffer full at 1 Mbaud. Every line gets
//! its one answer, in order, and the motors never wait for lines.
//!
//! `a_hundred_thousand_lines` takes minutes and runs with `make stream`; the rest of it is the same with
//! fewer lines.

use std::collections::VecDeque;

use crate::common::MS;
use crate::common::velvet::{Plan, SECOND, Velvet};
use units::Actuator;
use virtual_prime::console::Line;

const BAUD: u64 = 1_000_000;
/// Number of lines between two lines that are refused: an answer that is lost or doubled moves the others.
const WRONG_EVERY: usize = 997;
/// Interval between two status queries, ms.
const ASK_EVERY_MS: u64 = 50;
/// Moves in the look-ahead queue.
const QUEUE: usize = 64;
/// Circle of this radius, mm, in pieces of this length, at this rate, mm/min: 750 lines a second.
const RADIUS: f64 = 20.0;
const PIECE: f64 = 0.2;
const FEED: f64 = 9_000.0;
/// Time at either end that is not judged, as long as it takes to stop from full speed: the queue fills at the
/// beginning, and empties at the end.
const RAMP_NS: u64 = 200 * MS;
/// Greatest pause between two steps of a circle at full speed: two hundred steps' time.
const PAUSE_NS: u64 = 5 * MS;

fn line(number: usize) -> String {
    if number % WRONG_EVERY == WRONG_EVERY - 1 {
        return "G1 X1 X2\n".into();
    }
    let angle = number as f64 * PIECE / RADIUS;
    format!("G1X{:.3}Y{:.3}\n", RADIUS * angle.cos(), RADIUS * angle.sin())
}

/// Statistics of a stream.
#[derive(Debug, Default)]
struct Seen {
    /// Number of answers so far, and of refusals among them.
    answers: usize,
    refused: usize,
    /// Fewest blocks in the look-ahead queue by any status.
    fewest_blocks: usize,
    statuses: usize,
    /// First and last step, and the longest pause between two steps, between the ramps.
    steps_ns: Option<(u64, u64)>,
    longest_pause_ns: u64,
}

/// A sender that counts characters, as in GRBL's interface page.
struct Sender {
    wire: Line,
    window: usize,
    /// Lengths of lines that were sent and not answered.
    waiting: VecDeque<usize>,
    sent: usize,
    partial: String,
}

impl Sender {
    fn fill(&mut self, count: usize) {
        while self.sent < count {
            let next = line(self.sent);
            if self.waiting.iter().sum::<usize>() + next.len() > self.window {
                return;
            }
            self.wire.send(next.as_bytes());
            self.waiting.push_back(next.len());
            self.sent += 1;
        }
    }

    #[track_caller]
    fn hear(&mut self, seen: &mut Seen) {
        self.partial.push_str(&String::from_utf8_lossy(&self.wire.receive()));
        let Some(end) = self.partial.rfind('\n') else { return };
        let whole: String = self.partial.drain(..=end).collect();
        for said in whole.lines() {
            if said.starts_with('<') {
                seen.statuses += 1;
                let free = said.split_once("|Bf:").and_then(|(_, rest)| rest.split(',').next()?.parse::<usize>().ok());
                seen.fewest_blocks = seen.fewest_blocks.min(QUEUE - free.expect("Bf").min(QUEUE));
            } else if said == "ok" || said.starts_with("error:") {
                let is_wrong = line(seen.answers) == "G1 X1 X2\n";
                assert_eq!(said != "ok", is_wrong, "the answer to line {}: {said}", seen.answers + 1);
                seen.refused += usize::from(is_wrong);
                seen.answers += 1;
                assert!(self.waiting.pop_front().is_some(), "an answer to nothing: {said}");
            } else {
                assert!(said.starts_with("[MSG:"), "what is this? {said}");
            }
        }
    }
}

/// Takes the steps since the last look; pauses count between the ramps.
fn look(velvet: &mut Velvet, seen: &mut Seen, is_full: bool) {
    for edge in velvet.bench.world().lock().trace_mut().take() {
        let (first, last) = seen.steps_ns.unwrap_or((edge.time_ns, edge.time_ns));
        if is_full && edge.time_ns > first + RAMP_NS {
            seen.longest_pause_ns = seen.longest_pause_ns.max(edge.time_ns - last);
        }
        seen.steps_ns = Some((first, edge.time_ns));
    }
}

/// Returns the number of moves that had to slow down because no others were known behind them.
fn without_look_ahead(velvet: &mut Velvet) -> u32 {
    let times = velvet.ask("get steps", SECOND);
    let count =
        times.split_once("blocks without look-ahead: ").and_then(|(_, rest)| rest.split(',').next()?.parse().ok());
    count.expect("a count")
}

fn stream(count: usize) {
    let plan = Plan::new().set("[general] grbl_mode = true").set(&format!("[uart console] baudrate = {BAUD}"));
    let mut velvet = plan.set(&format!("[planner] planner_queue_size = {QUEUE}")).held();
    velvet.hear(2 * SECOND);
    let wire = velvet.bench.uart.clone();
    let ask = |velvet: &mut Velvet, line: &str| {
        wire.receive();
        wire.send(line.as_bytes());
        velvet.hear(500);
        String::from_utf8_lossy(&wire.receive()).into_owned()
    };
    let built = ask(&mut velvet, "$I\n");
    let options = built.split_once("[OPT:").and_then(|(_, rest)| rest.split_once(']')).expect("options").0;
    let window: usize = options.rsplit(',').next().and_then(|bytes| bytes.parse().ok()).expect("a size");
    ask(&mut velvet, "$10=3\n");
    assert!(ask(&mut velvet, &format!("G21G90G0X{RADIUS}Y0\nG1F{FEED}\n")).ends_with("ok\nok\n"));
    velvet.hear(2 * SECOND);
    let start =
        [Actuator::Alpha, Actuator::Beta].map(|motor| velvet.world(|world| world.carriage_mm(motor).expect("a motor")));
    let mut seen = Seen { fewest_blocks: usize::MAX, ..Seen::default() };
    velvet.bench.world().lock().trace_mut().take();
    let mut sender = Sender { wire: wire.clone(), window, waiting: VecDeque::new(), sent: 0, partial: String::new() };
    let began = velvet.now_ms();
    let mut asked = began + 200;
    let mut starved = Vec::new();
    while seen.answers < count {
        sender.fill(count);
        let is_full = sender.sent < count;
        // The look-ahead is sampled once when the queue is full, and again when no more lines come.
        if starved.is_empty() && velvet.now_ms() >= asked || starved.len() == 1 && !is_full {
            starved.push(without_look_ahead(&mut velvet));
        }
        if velvet.now_ms() >= asked && is_full {
            asked = velvet.now_ms() + ASK_EVERY_MS;
            wire.send(b"?");
        }
        velvet.hear(2);
        sender.hear(&mut seen);
        look(&mut velvet, &mut seen, is_full);
        assert!(velvet.now_ms() - began < 60_000 + count as u64 * 10, "it stands: {seen:?}");
    }
    let (first, last) = seen.steps_ns.expect("steps");
    velvet.hear(2 * SECOND);
    sender.hear(&mut seen);
    assert_eq!((seen.answers, sender.waiting.len()), (count, 0), "answers");
    assert_eq!(seen.refused, count / WRONG_EVERY);
    let angle = (count - 1) as f64 * PIECE / RADIUS;
    let [x, y] = [Actuator::Alpha, Actuator::Beta].map(|motor| velvet.world(|world| world.carriage_mm(motor)));
    let off = [x, y].map(|at| at.expect("a motor")).iter().zip(start).map(|(at, start)| at - start).collect::<Vec<_>>();
    let wanted = [RADIUS * (angle.cos() - 1.0), RADIUS * angle.sin()];
    assert!(
        (off[0] - wanted[0]).abs() < 0.02 && (off[1] - wanted[1]).abs() < 0.02,
        "it went by {off:?}, not {wanted:?}"
    );
    println!(
        "{count} lines in {:.1} s, window {window}, {} refused, {} statuses, at least {} of {QUEUE} blocks planned, longest time \
         between two steps {:.3} ms, {} moves without look-ahead",
        (last - first) as f64 * 1e-9,
        seen.refused,
        seen.statuses,
        seen.fewest_blocks,
        seen.longest_pause_ns as f64 * 1e-6,
        starved[1] - starved[0],
    );
    assert!(seen.statuses > 0 && seen.fewest_blocks > 0, "the planner was empty: {seen:?}");
    assert!(seen.longest_pause_ns < PAUSE_NS, "the motors waited: {seen:?}");
    assert_eq!(starved[1] - starved[0], 0, "moves without look-ahead");
    let times = velvet.ask("get steps", SECOND);
    assert!(times.contains("steps late: 0 ") && times.contains("feed late: 0,"), "{times}");
}

#[test]
fn three_thousand_lines_at_a_million_baud_get_their_answers_and_the_planner_is_never_empty() {
    stream(3_000);
}

#[test]
#[ignore = "takes minutes: make stream"]
fn a_hundred_thousand_lines() {
    stream(100_000);
}
