//! Motion of the machine while a computer sends all it can.

use sim::trace::StepEdge;
use units::{Actuator, Direction};
use usb_host::transfer::{Request, TransferId};

use super::disk::with_reader;
use super::velvet::{Plugged, plug, two_ports};
use crate::common::MS;
use crate::common::velvet::SECOND;
use crate::schedule::motions;

/// Job with lines and arcs, fast and slow, long and short.
const JOB: &str = "G90
G1 X60 Y40 E1 F12000
G1 X30 Y30 E2 F12000
G2 X36 Y36 I6 J0 E2.6 F4000
G1 X36.3 Y36.1 E2.62
G1 X36.6 Y36.1 E2.64
G1 X36.9 Y36.3 E2.66
G1 X60 Y60 Z10.4 E4 F9000
G3 X50 Y50 I-5 J-5 E5
G1 X90 Y80 E7 F15000
G1 X30 Y30 E9
";
/// Time of rest after which all lines are done.
const AT_REST_NS: u64 = 500 * MS;
/// Comment line that asks for nothing, and the number of such lines that the host has on their way at a time.
const WORDS: &str = "(a comment that goes on and on, as long as a line may be so that there are few answers, and then it goes on for some more)\n";
const AT_A_TIME: usize = 40;
/// Greatest difference of step times of two runs, by the interrupt's delay.
const TOLERANCE_NS: u64 = 250;

/// State of a flood.
#[derive(Default)]
struct Flood {
    sending: Option<TransferId>,
    /// Reads on their way, as many as Linux' driver has.
    listening: [[Option<TransferId>; 16]; 2],
    asking: Option<TransferId>,
    sent: u64,
    heard: u64,
}

impl Flood {
    /// Keeps every endpoint of both ports busy.
    fn keep_up(&mut self, plugged: &mut Plugged) {
        let ports = plugged.ports.clone();
        let mut desk = plugged.desk();
        let is_over = |desk: &mut virtual_prime::usb_desk::Desk<'_>, id: Option<TransferId>| match id {
            None => Some(0),
            Some(id) => desk.ended(id).map(|ended| ended.data.len() as u64),
        };
        let bytes = WORDS.repeat(AT_A_TIME).into_bytes();
        if is_over(&mut desk, self.sending).is_some() {
            self.sent += if self.sending.is_some() { bytes.len() as u64 } else { 0 };
            self.sending = desk.submit(ports[0].output, Request::Out { data: bytes, zero: false });
        }
        if is_over(&mut desk, self.asking).is_some() {
            self.asking = desk.submit(ports[1].output, Request::Out { data: b"version\nM105\n".to_vec(), zero: false });
        }
        for (port, listening) in ports.iter().zip(&mut self.listening) {
            for request in listening {
                if let Some(count) = is_over(&mut desk, *request) {
                    self.heard += count;
                    *request = port.listen(&mut desk, 4096);
                }
            }
        }
    }
}

/// Plays the job. Returns its edges, and the traffic meanwhile in both directions, in bytes a millisecond.
fn play(floods: bool) -> (Vec<StepEdge>, u64, u64) {
    let mut plugged = plug(two_ports().file("job.g", &("G28.3 X30 Y30 Z10\nG92 E0\n".to_owned() + JOB)));
    plugged.open(0);
    plugged.open(1);
    let mut flood = Flood::default();
    plugged.velvet.type_in("play /sd/job.g -t");
    let began = plugged.velvet.bench.vm.now_ns();
    while !plugged.velvet.said().contains("Done printing file") {
        plugged.velvet.hear(1);
        if floods {
            flood.keep_up(&mut plugged);
        }
        assert!(plugged.velvet.bench.vm.now_ns() - began < 60_000 * MS, "the job never ends");
    }
    let took_ms = (plugged.velvet.bench.vm.now_ns() - began) / MS;
    plugged.assert_clean();
    let edges = plugged.velvet.world(|world| world.trace_mut().take());
    (edges, flood.sent / took_ms, flood.heard / took_ms)
}

/// Asserts that every step is at its time without the flood.
#[track_caller]
fn assert_same(quiet: &[StepEdge], loud: &[StepEdge]) {
    assert!(quiet.len() > 10_000, "only {} edges", quiet.len());
    let places = |edge: &(u64, Actuator, Direction)| (edge.1, edge.2);
    let (quiet, loud) = (motions(quiet), motions(loud));
    assert_eq!(quiet.len(), loud.len());
    for (quiet, loud) in quiet.iter().zip(&loud) {
        assert_eq!(quiet.len(), loud.len(), "as many steps");
        assert!(quiet.iter().map(places).eq(loud.iter().map(places)), "the same steps");
        let worst = quiet.iter().zip(loud).map(|(one, other)| one.0.abs_diff(other.0)).max();
        assert!(worst.unwrap_or(0) <= TOLERANCE_NS, "a step came {worst:?} ns elsewhere");
    }
}

#[test]
fn a_computer_that_says_all_it_can_moves_no_step() {
    let (quiet, ..) = play(false);
    let (loud, received, sent) = play(true);
    println!("{received} kB/s received, {sent} kB/s sent while the machine moves");
    assert_same(&quiet, &loud);
    assert!(received >= 500, "{received} kB/s");
}

/// Blocks of a command, at most as with Linux, and their place.
const COMMAND_BLOCKS: u16 = 240;
const FIRST_BLOCK: u32 = 4_000;

/// Sends lines by a console, while the computer reads and writes the card as fast as it can. Returns their
/// edges, and the card's rate in bytes a millisecond. As the computer has the card, no job comes from it.
fn stream(floods: bool) -> (Vec<StepEdge>, u64) {
    let mut plugged = plug(with_reader());
    let mut disk = plugged.lend();
    plugged.velvet.ask("G28.3 X30 Y30 Z10", SECOND);
    plugged.velvet.ask("G92 E0", SECOND);
    // All lines wait behind the dwell, so that the motion goes on without gaps.
    plugged.velvet.type_in(&format!("G4 P1000\n{}", JOB.trim_end()));
    plugged.velvet.hear(900);
    let (began, mut moved) = (plugged.velvet.bench.vm.now_ns(), 0);
    let data = vec![0x5A; usize::from(COMMAND_BLOCKS) * 512];
    let mut at = FIRST_BLOCK;
    let (mut steps, mut moved_ns) = (0, began + 500 * MS);
    while plugged.velvet.bench.vm.now_ns() < moved_ns + AT_REST_NS {
        assert!(plugged.velvet.bench.vm.now_ns() - began < 60_000 * MS, "the lines never end");
        if floods {
            let mut desk = plugged.desk();
            disk.write(&mut desk, at, &data).unwrap();
            assert!(disk.read(&mut desk, at, COMMAND_BLOCKS).unwrap() == data);
            moved += 2 * data.len() as u64;
            at = FIRST_BLOCK + (at + 7) % 1_000;
        }
        plugged.velvet.hear(1);
        let total = plugged.velvet.world(|world| world.trace().total());
        if total > steps {
            (steps, moved_ns) = (total, plugged.velvet.bench.vm.now_ns());
        }
    }
    let took_ms = (plugged.velvet.bench.vm.now_ns() - began) / MS;
    plugged.assert_clean();
    (plugged.velvet.world(|world| world.trace_mut().take()), moved / took_ms)
}

#[test]
fn a_card_in_use_by_the_computer_moves_no_step() {
    let (quiet, _) = stream(false);
    let (loud, rate) = stream(true);
    println!("{rate} kB/s to and from the card while the machine moves");
    assert_same(&quiet, &loud);
    assert!(rate >= 700, "{rate} kB/s");
}
