//! LED strips on the pins of the PWM timers: their signal on the wire, bit by bit.

use sim::models::led_strip::Seen;
use sim::trace::StepEdge;

use crate::common::velvet::{Plan, SECOND, Velvet};

/// Adds a strip of this name on this pin.
fn strip(plan: Plan, name: &str, pin: &str, lights: u16) -> Plan {
    plan.set(&format!("[led strip] {name}.enable = true"))
        .set(&format!("[led strip] {name}.pin = {pin}"))
        .set(&format!("[led strip] {name}.chain_count = {lights}"))
}

/// Returns the colours that a strip shows, as red, green and blue, and the number of frames sent; asserts
/// that all pulses were within the data sheet.
#[track_caller]
fn shows(velvet: &mut Velvet, place: usize) -> (Vec<[u8; 3]>, u64) {
    velvet.hear(100);
    let (bytes, (frames, faults)) = velvet.world(|world| (world.strip_shows(place), world.strip_counters(place)));
    assert_eq!(
        faults,
        0,
        "pulses that a data sheet does not allow: {:?}",
        velvet.world(|world| world.strip_times(place))
    );
    (bytes.chunks(3).map(|light| [light[1], light[0], light[2]]).collect(), frames)
}

/// Pulse times are those of `bsp-prime/src/led_strip.rs`, which suit WS2812B, WS2812B-V5 and SK6812 alike;
/// the emulator's edges are up to 7 ns off.
#[test]
fn bits_on_the_wire_are_as_the_data_sheets_want_them() {
    let mut velvet = strip(Plan::new(), "case", "PWM2_1", 30).set("[led strip] case.initial_green = 1").start();
    assert_eq!(shows(&mut velvet, 0), (vec![[0, 255, 0]; 30], 1));
    velvet.ask("M150 R170 U85 B15", SECOND);
    velvet.ask("M150 I29 W", SECOND);
    let (shown, frames) = shows(&mut velvet, 0);
    assert_eq!((&shown[..29], shown[29], frames), (&[[170, 85, 15]; 29][..], [0; 3], 2));
    let Seen { zero, one } = velvet.world(|world| world.strip_times(0));
    for (what, seen, expected) in
        [("0 high", zero[0], 320), ("0 low", zero[1], 970), ("1 high", one[0], 700), ("1 low", one[1], 590)]
    {
        let (least, most) = seen.expect("there were both");
        assert!(expected - 7 <= least && most <= expected + 7, "{what}: {least} to {most} ns, not {expected}");
    }
    // Nothing is sent when nothing changes.
    velvet.hear(SECOND);
    assert_eq!(shows(&mut velvet, 0).1, frames);
}

/// Lines are independent of each other, on any timer and channel; a quiet line stays low.
#[test]
fn each_strip_has_its_own_line() {
    let pins = [("a", "PWM1_3"), ("b", "PWM1_4"), ("c", "PWM2_2"), ("d", "PWM2_4")];
    let mut velvet = pins.iter().fold(Plan::new(), |plan, (name, pin)| strip(plan, name, pin, 4)).start();
    let before: Vec<u64> = (0..4).map(|place| shows(&mut velvet, place).1).collect();
    assert_eq!(before, [1; 4]);
    for place in 0..4 {
        velvet.ask(&format!("M150 S{place} R{}", 10 + place), SECOND);
    }
    for place in 0..4 {
        assert_eq!(shows(&mut velvet, place), (vec![[10 + place as u8, 0, 0]; 4], 2), "strip {place}");
    }
    // All lines are sent at once: one after the other, each with its pause.
    velvet.ask("M150 B7", SECOND);
    for place in 0..4 {
        assert_eq!(shows(&mut velvet, place), (vec![[0, 0, 7]; 4], 3), "strip {place}");
    }
}

/// Returns the edges of a job, while lights change all the time or do not.
fn edges(lights_change: bool) -> Vec<StepEdge> {
    let job = "G21\nG90\nG28.3 X0 Y0\nG1 X30 F9000\nG1 Y20\nG1 X0 Y0\nG1 X30\n";
    let mut velvet = strip(Plan::new(), "case", "PWM2_1", 200).file("job.g", job).start();
    velvet.hear(200);
    velvet.world(|world| world.trace_mut().take());
    velvet.type_in("play /sd/job.g");
    for round in 0..60 {
        if lights_change {
            velvet.type_in(&format!("M150 R{} B255 Q0", round * 4));
        } else {
            velvet.type_in("M117 so many bytes as well");
        }
        velvet.hear(30);
    }
    let (_, frames) = shows(&mut velvet, 0);
    assert_eq!(frames > 20, lights_change, "{frames} transmissions");
    velvet.world(|world| world.trace_mut().take())
}

#[test]
fn lights_move_no_step() {
    let (with, without) = (edges(true), edges(false));
    assert!(with.len() > 5_000 && with.len() == without.len(), "{} and {} edges", with.len(), without.len());
    let begin = |edges: &[StepEdge]| edges[0].time_ns;
    let worst = with.iter().zip(&without).map(|(one, other)| {
        assert_eq!((one.actuator, one.direction), (other.actuator, other.direction));
        (one.time_ns - begin(&with)).abs_diff(other.time_ns - begin(&without))
    });
    let worst = worst.max().unwrap_or(0);
    println!("with lights that change all the time each edge is within {worst} ns of where it is without");
    assert!(worst <= 100, "{worst} ns");
}
