//! Outputs that change in the middle of a print: each at the boundary of its own block, within a millisecond
//! by the step edges.

use units::Actuator;

use crate::common::MS;
use crate::common::machine::{changes, everything, pin, watch};
use crate::common::velvet::SECOND;

const PROMISED_NS: i64 = MS as i64;
/// Sample interval of a heater, whose first duty comes with its next sample: `readings_per_second = 20`.
const SAMPLE_NS: i64 = 50 * MS as i64;
const HOTEND: &str = "PE0";
const BED: &str = "PE3";
const FAN: &str = "PE1";
/// TIM1 channel 1 (RM0399 section 42.4): `PWM1_1`, 10 kHz, whose compare value counts from the next period
/// on.
const SPINDLE: u64 = 0x4001_0034;
const PWM_PERIOD_NS: u64 = 100_000;
const STEPS_PER_MM: usize = 80;

/// A file with one stroke of X at 95 mm/s, so that boundaries meet the periods of the machine's tasks at ever
/// other phases; every 10 mm an output changes.
const FILE: &str = "G90\nM83\nG1 X10 E1 F5700\n\
    M106 S255\nG1 X20 E1\n\
    M107\nG1 X30 E1\n\
    M104 S0\nG1 X40 E1\n\
    M140 S0\nG1 X50 E1\n\
    M3 S50\nG1 X60 E1\n\
    M3 S80\nG1 X70 E1\n\
    M221 S50\nG1 X80 E1\n\
    M5\nG1 X90 E1\n\
    M140 S60\nG1 X100 E1\n\
    M104 S200\nG1 X110 E1\n";

#[test]
fn outputs_change_at_the_boundaries_of_their_blocks() {
    let mut velvet = everything().watching(SPINDLE..SPINDLE + 4).file("part.g", FILE).start();
    velvet.ask("M104 S200", SECOND);
    velvet.ask("M140 S60", SECOND);
    // Both heaters are cold, and so fully on.
    velvet.hear(500);
    watch(&mut velvet, &[HOTEND, BED, FAN]);
    velvet.bench.writes.take();
    velvet.ask("M23 part.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", 10 * SECOND);
    let edges = velvet.world(|world| world.trace_mut().take());
    let of = |motor| -> Vec<u64> { edges.iter().filter(|e| e.actuator == motor).map(|e| e.time_ns).collect() };
    let (x, e) = (of(Actuator::Alpha), of(Actuator::Delta));
    assert_eq!(x.len(), 110 * STEPS_PER_MM);
    // No output slows the motion down: 7600 steps/s all the way.
    let cruise = &x[5 * STEPS_PER_MM..105 * STEPS_PER_MM];
    assert!(cruise.windows(2).all(|pair| (131_450..131_700).contains(&(pair[1] - pair[0]))), "the speed changes");
    // The boundary is in the middle between the last step before it and the first step behind it.
    let boundary = |mm: usize| (x[mm * STEPS_PER_MM - 1] + x[mm * STEPS_PER_MM]) / 2;
    let pins = changes(&mut velvet);
    let writes = velvet.bench.writes.take();
    let level = |name: &'static str, high: bool, mm: usize| {
        let wanted = pin(name);
        let change =
            pins.iter().find(|change| change.pin == wanted && change.high == high && change.at_ns + MS > boundary(mm));
        change.map(|change| change.at_ns)
    };
    let duty = |permille: u64, mm: usize| {
        let write = writes.iter().find(|write| write.value == permille && write.at_ns + MS > boundary(mm));
        write.map(|write| write.at_ns + PWM_PERIOD_NS)
    };
    // Command, millimetre of X, instant of the change, and greatest delay.
    let rows = [
        ("M106", 10, level(FAN, true, 10), PROMISED_NS),
        ("M107", 20, level(FAN, false, 20), PROMISED_NS),
        ("M104 S0", 30, level(HOTEND, false, 30), PROMISED_NS),
        ("M140 S0", 40, level(BED, false, 40), PROMISED_NS),
        ("M3 S50", 50, duty(500, 50), PROMISED_NS),
        ("M3 S80", 60, duty(800, 60), PROMISED_NS),
        ("M5", 80, duty(0, 80), PROMISED_NS),
        ("M140 S60", 90, level(BED, true, 90), SAMPLE_NS),
        ("M104 S200", 100, level(HOTEND, true, 100), SAMPLE_NS),
    ];
    for (what, mm, at_ns, promised_ns) in rows {
        let at_ns = at_ns.unwrap_or_else(|| panic!("{what} does nothing"));
        let late_ns = at_ns as i64 - boundary(mm) as i64;
        println!("{what}: {late_ns} ns behind its boundary");
        assert!((0..=promised_ns).contains(&late_ns), "{what}: {late_ns} ns behind its boundary");
    }
    // At 415 steps a millimetre there are 41.5 to a millimetre of X, and half of that from the boundary on.
    let before = |mm: usize| e.iter().filter(|at| **at < boundary(mm)).count();
    for (from, expected) in [(68, 41.5), (69, 41.5), (70, 20.75), (71, 20.75)] {
        let steps = before(from + 1) - before(from);
        assert!((steps as f64 - expected).abs() <= 1.0, "M221: {steps} steps of E behind {from} mm");
    }
}
