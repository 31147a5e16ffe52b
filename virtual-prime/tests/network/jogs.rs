//! Jogs while a button is held, on the real image: by step times, the machine stands soon after the button
//! was let go, however that came about.

use virtual_prime::net_desk::peer::Connection;

use super::page::{OPEN, PAGE, call, socket};
use super::{Net, plan};
use crate::common::MS;
use crate::common::velvet::SECOND;

/// Time between two beats of a browser, milliseconds.
const BEAT_MS: u64 = 50;
/// Time without a beat after which a jog ends (docs/api.md), milliseconds.
const SILENCE_MS: u64 = 100;
/// Speed and acceleration of the jog, mm/s and mm/s^2: X of the sample printer, which also takes that time to
/// brake.
const SPEED: u64 = 200;
const ACCELERATION: u64 = 2_000;
const BRAKING_MS: u64 = SPEED * 1_000 / ACCELERATION;
/// What the board's look at the network may add: each 10 ms, and the round of the computer.
const ALLOWANCE_MS: u64 = 12;

/// End of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    LetGo,
    Silence,
    CableOut,
    Closed,
    Reset,
}

fn start(net: &mut Net, visitor: Connection, direction: i8) {
    let speed = SPEED * 60;
    call(net, visitor, "velvet.jog.start", &format!(r#""axis":"x","direction":{direction},"mm_per_min":{speed}"#), 1);
    net.expect(visitor, r#""result":{"id":"#, SECOND);
}

/// Holds the button of a jog for so long. Returns the time of the last beat, ns.
fn hold(net: &mut Net, visitor: Connection, id: u32, ms: u64) -> u64 {
    let mut last_ns = 0;
    for _ in 0..ms / BEAT_MS {
        net.run(BEAT_MS);
        net.peer.receive(visitor);
        last_ns = net.velvet.bench.vm.now_ns();
        call(net, visitor, "velvet.jog.beat", &format!(r#""id":{id}"#), 1);
        net.peer.serve(&mut net.velvet.bench.vm);
    }
    last_ns
}

/// Takes the times of the steps so far.
fn steps(net: &mut Net) -> Vec<u64> {
    net.velvet.world(|world| world.trace_mut().take()).iter().map(|edge| edge.time_ns).collect()
}

#[test]
fn a_jog_at_200_mm_per_second_stands_soon_after_its_last_beat() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    let ends = [End::LetGo, End::Silence, End::Closed, End::Reset, End::CableOut];
    for (number, end) in ends.into_iter().enumerate() {
        let visitor = socket(&mut net);
        steps(&mut net);
        let id = number as u32 + 1;
        start(&mut net, visitor, if number % 2 == 0 { 1 } else { -1 });
        let last_ns = hold(&mut net, visitor, id, 8 * BEAT_MS);
        let before = steps(&mut net);
        // 80 steps a millimetre, less the time of the ramp.
        assert!(before.len() as u64 > SPEED * 80 / 5, "{end:?}: it moves: {} steps", before.len());
        match end {
            End::LetGo => call(&mut net, visitor, "velvet.jog.stop", &format!(r#""id":{id}"#), 2),
            End::Silence => {}
            End::Closed => net.peer.close(visitor),
            End::Reset => net.peer.abort(visitor),
            End::CableOut => net.peer.unplug(&mut net.velvet.bench.vm),
        }
        net.run(600);
        let after = steps(&mut net);
        let stood_ms = (after.last().expect("it brakes") - last_ns) / MS;
        let silence = if matches!(end, End::Silence | End::CableOut) { SILENCE_MS } else { 0 };
        let most = silence + BRAKING_MS + ALLOWANCE_MS;
        println!("{end:?}: the last step comes {stood_ms} ms behind the last beat, {most} allowed");
        assert!(stood_ms <= most, "{end:?}: {stood_ms} ms, {most} allowed");
        assert!(stood_ms >= silence, "{end:?}: it ends too soon: {stood_ms} ms");
    }
    // Nothing is lost of the machine: it knows where it is, and takes lines.
    assert!(net.ask("get steps").contains("late: 0 ("));
    net.peer.plug(&mut net.velvet.bench.vm);
    net.hear_until("// network: 10.0.2.15 (from DHCP)", 15 * SECOND);
    let visitor = socket(&mut net);
    call(&mut net, visitor, "printer.gcode.script", r#""script":"M114""#, 2);
    net.expect(visitor, r#""result":"ok","id":2"#, 2 * SECOND);
}

#[test]
fn a_click_moves_little_and_a_jog_ends_at_the_travel_of_an_axis_that_is_homed() {
    let mut net = Net::with_address(plan(&[OPEN, PAGE]));
    net.ask("G28.3 X190 Y10 Z10");
    let visitor = socket(&mut net);
    steps(&mut net);
    // Start and stop in one packet: the stop overtakes the line.
    let speed = SPEED * 60;
    call(&mut net, visitor, "velvet.jog.start", &format!(r#""axis":"x","direction":-1,"mm_per_min":{speed}"#), 1);
    call(&mut net, visitor, "velvet.jog.stop", r#""id":1"#, 2);
    net.run(300);
    net.peer.receive(visitor);
    assert_eq!(steps(&mut net).len(), 0, "it was let go before it began");
    // One after the other, as fast as fingers can be: each stop is of its own jog.
    for id in 2..12 {
        start(&mut net, visitor, -1);
        net.run(10);
        call(&mut net, visitor, "velvet.jog.stop", &format!(r#""id":{id}"#), 2);
        net.run(5);
    }
    net.run(300);
    let clicks = steps(&mut net).len();
    assert!(clicks < 80 * 20, "ten clicks move less than 20 mm: {clicks} steps");
    net.peer.receive(visitor);
    net.ask("G28.3 X190 Y10 Z10");
    // To the end of travel at 220 mm, and no step beyond.
    start(&mut net, visitor, 1);
    hold(&mut net, visitor, 12, 10 * BEAT_MS);
    assert_eq!(steps(&mut net).len(), 80 * 30);
    net.run(300);
    call(&mut net, visitor, "printer.gcode.script", r#""script":"M105""#, 3);
    net.expect(visitor, r#""result":"ok","id":3"#, 2 * SECOND);
}
