//! Realtime bytes that override speeds, spindle and coolant.

use scenarios::Bench;
use units::Actuator::Alpha;

use super::{Wait, plan, start};

/// A mill with a spindle on a timer and both coolants.
fn mill() -> Bench {
    plan()
        .set("[pwm1] frequency = 5000")
        .set("[switch] tool.enable = true")
        .set("[switch] tool.input_on_command = M3")
        .set("[switch] tool.input_off_command = M5")
        .set("[switch] tool.output_pin = PWM1_1")
        .set("[switch] tool.output_type = hwpwm")
        .set("[switch] tool.startup_value = 0")
        .set("[switch] flood.enable = true")
        .set("[switch] flood.input_on_command = M8")
        .set("[switch] flood.input_off_command = M9")
        .set("[switch] flood.output_pin = PI4")
        .start()
}

/// Returns the duty of the spindle's output.
fn spindle(bench: &Bench) -> f64 {
    bench.world(|world| world.pwm_duty(0, 0))
}

/// The next report that has overrides.
fn overrides(bench: &mut Bench) -> String {
    let reports = (0..40).map(|_| bench.status()).find(|report| report.contains("|Ov:"));
    let report = reports.expect("a report with overrides");
    report.split_once("|Ov:").map_or("", |(_, rest)| rest).trim_end_matches(">\n").into()
}

#[test]
fn feed_overrides_change_feeds_and_rapid_overrides_rapids() {
    let mut bench = mill();
    bench.send(&[0x91, 0x93]);
    bench.hear(0.05);
    assert_eq!(overrides(&mut bench), "111,100,100");
    // bCNC and CNCjs write such bytes as letters of UTF-8.
    bench.send("\u{96}".as_bytes());
    bench.hear(0.05);
    assert_eq!(overrides(&mut bench), "111,50,100");
    let speed = |bench: &mut Bench, line: &str| {
        bench.run(&["G91"]);
        bench.run(&[line]);
        bench.hear(0.4);
        let status = bench.status();
        bench.hear_until_idle();
        let (_, rest) = status.split_once("|FS:").expect("a rate");
        rest.split(',').next().and_then(|rate| rate.parse::<f64>().ok()).expect("a number")
    };
    assert_eq!(speed(&mut bench, "G1 X20 F1000"), 1110.0);
    let rapid = speed(&mut bench, "G0 X-100");
    bench.send(&[0x90, 0x95]);
    bench.hear(0.05);
    assert_eq!(speed(&mut bench, "G1 X20 F1000"), 1000.0);
    assert_eq!(speed(&mut bench, "G0 X-100"), 2.0 * rapid);
    for _ in 0..15 {
        bench.send(&[0x92]);
        bench.hear(0.01);
    }
    assert_eq!(overrides(&mut bench), "10,100,100");
    bench.run(&["M2"]);
    assert_eq!(overrides(&mut bench), "100,100,100");
}

#[test]
fn spindle_and_coolant_follow_the_operator() {
    let mut bench = mill();
    bench.run(&["M3 S40"]);
    bench.hear(0.05);
    bench.send(&[0x9A]);
    bench.hear(0.05);
    assert!((spindle(&bench) - 0.44).abs() < 1e-6, "{}", spindle(&bench));
    assert_eq!(overrides(&mut bench), "100,100,110|A:S");
    bench.send(&[0xA0]);
    bench.hear(0.05);
    assert_eq!(overrides(&mut bench), "100,100,110|A:SF");
    bench.run(&["G91 G1 X20 F600"]);
    bench.send(&[0x9E]);
    bench.hear(0.1);
    assert!(spindle(&bench) > 0.4, "it stops in a hold alone");
    bench.send(b"!");
    bench.hear(0.5);
    bench.send(&[0x9E]);
    bench.hear(0.1);
    assert_eq!(spindle(&bench), 0.0);
    bench.type_in("~");
    bench.hear(0.1);
    assert!((spindle(&bench) - 0.44).abs() < 1e-6);
    bench.hear_until_idle();
    bench.send(&[0xA0, 0x99]);
    bench.hear(0.05);
    assert_eq!(overrides(&mut bench), "100,100,100|A:S");
    assert!((spindle(&bench) - 0.4).abs() < 1e-6);
}

#[test]
fn bytes_that_mean_nothing_here_are_passed_over() {
    let mut bench = start();
    let from = bench.carriage(Alpha);
    bench.send(b"G9\x991 G\x9E1 X\x801\xA02\xBF F600\n");
    assert_eq!(bench.hear(0.1), "ok\n");
    bench.hear_until_idle();
    assert!((bench.carriage(Alpha) - from - 12.0).abs() < 0.02);
    assert_eq!(overrides(&mut bench), "100,100,100");
}
