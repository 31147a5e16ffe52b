//! Motion while the network is busy: the same steps as while it is quiet.

use virtual_prime::net_desk::frames;
use virtual_prime::net_desk::impairment::Impairment;
use virtual_prime::net_desk::peer::Connection;

use super::{Net, plan};
use crate::common::velvet::{Plan, SECOND};
use crate::schedule::{Motion, motions};

const CONSOLE: &str = "[network] password_required = false";
/// Job with lines, arcs and extrusion, and two stops.
pub(super) const JOB: &str = "G28.3 X30 Y30 Z30
G92 E0
G1 X40 Y30 E0.5 F9000
G1 X50 Y38 E1
G2 X56 Y44 I6 J0 E1.6
G1 X60 Y44 E1.8
G4 P300
G3 X70 Y40 I5 J-2 E2.4
G1 X70 Y60 E5 F12000
G0 X31 Y31
G4 P300
G1 X60 Y60 E6 F3000
";
/// Greatest distance of an edge from its place, ns: events this close together are played one after the
/// other.
const TOLERANCE_NS: u64 = 250;
/// The same while homing: some hundredths of the time between two steps there.
const HOMING_TOLERANCE_NS: u64 = 5_000;

/// Time in which a job must be done, ms: the one above, and a print of some minutes.
pub(super) const PATIENCE_MS: u64 = 60 * SECOND;
pub(super) const PATIENCE_OF_A_PRINT_MS: u64 = 1_800 * SECOND;

/// Plays `job.g` of the card while `disturb` is called each millisecond. Returns its motions.
pub(super) fn played(plan: Plan, patience_ms: u64, mut disturb: impl FnMut(&mut Net, u64)) -> Vec<Motion> {
    let mut net = Net::with_address(plan);
    net.ask("M23 job.g");
    let before = net.velvet.said().len();
    net.velvet.type_in("M24");
    let began = net.velvet.now_ms();
    while !net.velvet.said()[before..].contains("Done printing file") {
        let now = net.velvet.now_ms() - began;
        assert!(now < patience_ms, "the job is not done: {}", &net.velvet.said()[before..]);
        disturb(&mut net, now);
        net.run(1);
    }
    let said = net.ask("get steps");
    assert!(said.contains("late: 0 (") && said.contains("delayed: 0\n"), "{said}");
    motions(&net.velvet.world(|world| world.trace_mut().take()))
}

fn with_job(job: &str) -> Plan {
    plan(&[CONSOLE]).file("job.g", job)
}

/// Compares motions edge by edge. The first one may be of homing: there each move begins, and the brake at
/// the switch, at a run of the step feed, whose phase is another in each start; such a motion is held to
/// [`HOMING_TOLERANCE_NS`].
#[track_caller]
pub(super) fn assert_same(quiet: &[Motion], busy: &[Motion], homes: bool) {
    assert_eq!(quiet.len(), busy.len(), "motions");
    for (number, (quiet, busy)) in quiet.iter().zip(busy).enumerate() {
        assert_eq!(quiet.len(), busy.len(), "edges");
        let tolerance_ns = if homes && number == 0 { HOMING_TOLERANCE_NS } else { TOLERANCE_NS };
        for (one, other) in quiet.iter().zip(busy) {
            assert_eq!((one.1, one.2), (other.1, other.2), "motor and direction at {} ns", one.0);
            assert!(one.0.abs_diff(other.0) <= tolerance_ns, "motion {number}: {} and {} ns", one.0, other.0);
        }
    }
}

/// Says how far edges of a busy run are from their places: how many are not exactly there, how many are
/// farther away than [`TOLERANCE_NS`], and the greatest distance.
pub(super) fn distances(quiet: &Motion, busy: &Motion) -> String {
    let away: Vec<u64> =
        quiet.iter().zip(busy).map(|(one, other)| one.0.abs_diff(other.0)).filter(|&distance| distance > 0).collect();
    let far = away.iter().filter(|&&distance| distance > TOLERANCE_NS).count();
    let worst = away.iter().max().unwrap_or(&0);
    format!(
        "{} edges not at the same nanosecond, {far} beyond {TOLERANCE_NS} ns, the farthest {worst} ns away",
        away.len()
    )
}

/// Pings of every length, and a storm of questions to everybody.
fn flood(net: &mut Net, now: u64) {
    let (own, board) = (net.peer.own_end(), net.peer.board_end().expect("a board that has sent"));
    let length = now as usize * 37 % 1_400;
    for number in 0..3 {
        net.peer.put(&frames::ping(own, board, 1, number, &vec![0x55; length]));
    }
    for _ in 0..3 {
        net.peer.put(&frames::arp(own, frames::End { hardware: [0xFF; 6], address: own.address }, false));
    }
}

/// A line that loses and doubles, a visitor who asks all the time, and a cable that is out for 50 ms of each
/// second.
#[derive(Default)]
struct BadLine {
    visitor: Option<Connection>,
}

impl BadLine {
    fn disturb(&mut self, net: &mut Net, now: u64) {
        let impairment =
            Impairment { doubling: 50, reordering: 50, overtaken_ns: 3_000_000, ..Impairment::losing(200) };
        net.peer.impair(&impairment);
        match now % 1_000 {
            10 => self.visitor = net.peer.connect(23),
            900 => net.peer.unplug(&mut net.velvet.bench.vm),
            950 => net.peer.plug(&mut net.velvet.bench.vm),
            _ => {}
        }
        if let Some(visitor) = self.visitor {
            let _sent = net.peer.send(visitor, b"M105\n?");
            net.peer.receive(visitor);
        }
    }
}

#[test]
fn floods_storms_and_a_bad_cable_leave_every_step_where_it_is() {
    let played = |disturb: &mut dyn FnMut(&mut Net, u64)| played(with_job(JOB), PATIENCE_MS, disturb);
    let quiet = played(&mut |_, _| {});
    assert!(quiet.iter().map(Vec::len).sum::<usize>() > 5_000, "a job that moves");
    assert_same(&quiet, &played(&mut flood), false);
    let mut bad = BadLine::default();
    assert_same(&quiet, &played(&mut |net, now| bad.disturb(net, now)), false);
}

/// A print of some minutes, `demo/part.gcode` or the file that VELVET_GCODE names, three times.
#[test]
#[ignore = "three times the length of a print: make net"]
fn a_whole_print_is_stepped_alike() {
    let file = std::env::var("VELVET_GCODE")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../demo/part.gcode").into());
    let job = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{file}: {error}"));
    let played = |disturb: &mut dyn FnMut(&mut Net, u64)| played(with_job(&job), PATIENCE_OF_A_PRINT_MS, disturb);
    let homes = job.lines().any(|line| line.starts_with("G28"));
    let quiet = played(&mut |_, _| {});
    println!("{} edges", quiet.iter().map(Vec::len).sum::<usize>());
    let mut bad = BadLine::default();
    let compare = |name: &str, disturb: &mut dyn FnMut(&mut Net, u64)| {
        let busy = played(disturb);
        for (number, (quiet, busy)) in quiet.iter().zip(&busy).enumerate() {
            println!("{name}, motion {number}, {} edges: {}", quiet.len(), distances(quiet, busy));
        }
        assert_same(&quiet, &busy, homes);
    };
    compare("flood", &mut flood);
    compare("bad line", &mut |net, now| bad.disturb(net, now));
}
