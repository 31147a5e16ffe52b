//! Settings of the sections `[switch]`, `[pwm1]` and `[pwm2]`.

use super::See::{Board, Boot, Look, Say};
use super::{Bench, Row, row};

/// A button that runs lines.
const BUTTON: &[&str] = &[
    "[switch] button.enable = true",
    "[switch] button.input_pin = PB7^",
    "[switch] button.output_on_command = M106",
    "[switch] button.output_off_command = M107",
];
const DIGITAL: &[&str] = &["[switch] fan.output_type = digital"];
/// A spindle on a timer.
const SPINDLE: &[&str] = &[
    "[pwm1] frequency = 10000",
    "[switch] spindle.enable = true",
    "[switch] spindle.output_pin = PWM1_1",
    "[switch] spindle.output_type = hwpwm",
    "[switch] spindle.input_on_command = M3",
    "[switch] spindle.input_off_command = M5",
];
/// A spindle on a timer, with a speed scale.
const RPM: &[&str] = &[
    "[pwm1] frequency = 10000",
    "[switch] spindle.enable = true",
    "[switch] spindle.output_pin = PWM1_1",
    "[switch] spindle.output_type = hwpwm",
    "[switch] spindle.input_on_command = M3",
    "[switch] spindle.input_off_command = M5",
    "[switch] spindle.max_rpm = 24000",
];
/// A servo on a timer.
const SERVO: &[&str] = &[
    "[pwm1] frequency = 50",
    "[switch] spindle.enable = true",
    "[switch] spindle.output_pin = PWM1_1",
    "[switch] spindle.output_type = hwpwm",
    "[switch] spindle.input_on_command = M280",
    "[switch] spindle.servo_max_angle = 180",
];
/// A button of the button box.
const BOX: &[&str] = &["[button box] one.pin = PB7^", "[button box] one.press = M106"];
const LONG: &[&str] =
    &["[button box] one.pin = PB7^", "[button box] one.press = M106", "[button box] one.long_press = M107"];
const STATE: &[&str] = &["M106", "switch fan", "M107", "switch fan"];

pub const ROWS: &[Row] = &[
    row("[switch] fan.enable", "true", "false", Say(&["switch"])),
    row("[switch] button.input_pin", "PB7^", "nc", Look(pressed)).with(BUTTON),
    row("[switch] button.input_pin", "PB7^", "PB8^", Board("settings.rs")),
    row("[switch] button.input_pin_behavior", "momentary", "toggle", Look(pressed)).with(BUTTON),
    row("[switch] button.output_on_command", "M106", "M107", Look(pressed)).with(BUTTON),
    row("[switch] button.output_off_command", "M107", "M106", Look(pressed)).with(BUTTON),
    row("[switch] fan.input_on_command", "M106", "M126", Say(STATE)),
    row("[switch] fan.input_off_command", "M107", "M127", Say(STATE)),
    row("[switch] fan.subcode", "0", "1", Say(STATE)),
    row("[switch] fan.io_number", "-1", "5", Say(&["M62 P5", "switch fan"])),
    row("[switch] fan.output_pin", "PE1", "PE3", Boot),
    row("[switch] fan.output_pin", "PE1", "PB9", Board("settings.rs")),
    row("[switch] fan.output_type", "sigmadeltapwm", "digital", Look(half)),
    row("[switch] fan.max_pwm", "255", "100", Look(half)),
    row("[switch] fan.cycle_time", "0", "1", Look(in_turns)),
    row("[switch] fan.startup_state", "false", "true", Look(fan)),
    row("[switch] fan.startup_value", "255", "100", Look(full)),
    row("[switch] spindle.default_on_value", "0", "60", Say(&["M3", "switch spindle"])).with(SPINDLE),
    row("[switch] spindle.input_reverse_command", "", "M4", Say(&["M4 S50", "switch spindle"])).with(SPINDLE),
    row("[switch] spindle.max_rpm", "0", "24000", Look(speeds)).with(SPINDLE),
    row("[switch] spindle.min_rpm", "0", "6000", Look(speeds)).with(RPM),
    row("[switch] fan.on_delay", "0", "2", Look(on_takes)),
    row("[switch] fan.off_delay", "0", "2", Look(on_takes)),
    row("[switch] spindle.servo_max_angle", "0", "90", Look(turned)).with(SERVO),
    row("[switch] spindle.servo_min_us", "1000", "500", Look(turned)).with(SERVO),
    row("[switch] spindle.servo_max_us", "2000", "2500", Look(turned)).with(SERVO),
    row("[switch] fan.halt_set_to", "false", "true", Say(&["M106", "M112", "switch fan"])).with(DIGITAL),
    row("[switch] fan.ignore_on_halt", "false", "true", Say(&["M106", "M112", "switch fan"])).with(DIGITAL),
    row("[button box] one.enable", "true", "false", Look(held)).with(BOX),
    row("[button box] one.pin", "PB7^", "nc", Look(held)).with(BOX),
    row("[button box] one.pin", "PB7^", "PE1", Boot).with(BOX),
    row("[button box] one.press", "M106", "M107", Look(held)).with(BOX),
    row("[button box] one.release", "", "M107", Look(held)).with(BOX),
    row("[button box] one.long_press", "", "M107", Look(held)).with(BOX),
    row("[button box] one.long_press_time", "1", "5", Look(held)).with(LONG),
    row("[button box] common.poll_frequency_hz", "20", "1", Look(held)).with(BOX),
    row("[pwm1] frequency", "10000", "500", Board("settings.rs")),
    row("[pwm2] frequency", "10000", "500", Board("settings.rs")),
];

fn pressed(bench: &mut Bench) -> String {
    let mut said = String::new();
    for down in [true, false, true, false] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        // Without a pin there is no button to press.
        let _ = bench.world(|world| world.press(at_ns, "button", down));
        bench.hear(0.2);
        said += &bench.say("switch fan");
    }
    said
}

/// Holds a button for two seconds, after half a second.
fn held(bench: &mut Bench) -> String {
    let mut said = String::new();
    bench.hear(0.5);
    for down in [true, false] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        let _ = bench.world(|world| world.press(at_ns, "one", down));
        for _ in 0..10 {
            bench.hear(0.2);
            said += &bench.say("switch fan");
        }
    }
    said
}

/// Returns the times that lines turning the fan on and off take.
fn on_takes(bench: &mut Bench) -> String {
    let mut takes = |line: &str| {
        let before = bench.now_s();
        bench.say(line);
        format!("{:.1} ", bench.now_s() - before)
    };
    takes("M106") + &takes("M107")
}

/// Returns the duty of the spindle's output for several S words.
fn speeds(bench: &mut Bench) -> String {
    let mut said = String::new();
    for line in ["M3 S20", "S2000", "S12000"] {
        bench.say(line);
        bench.hear(0.02);
        said += &bench.world(|world| format!("{:.4} ", world.pwm_duty(0, 0)));
    }
    said
}

/// Returns the pulses of a servo.
fn turned(bench: &mut Bench) -> String {
    let mut said = String::new();
    for line in ["M280 S0", "M280 S45", "M280 S180"] {
        bench.say(line);
        said += &bench.world(|world| format!("{:.4} ", world.pwm_duty(0, 0)));
    }
    said
}

/// Returns the mean drive of the fan.
fn fan(bench: &mut Bench) -> String {
    bench.hear(5.0);
    bench.world(|world| format!("{:.2}", world.fan_speed(0)))
}

fn half(bench: &mut Bench) -> String {
    bench.say("M106 S128");
    fan(bench)
}

/// Returns samples of the fan's drive at half power, 0.1 s apart.
fn in_turns(bench: &mut Bench) -> String {
    bench.say("M106 S128");
    let moment = |bench: &mut Bench| {
        bench.hear(0.1);
        bench.world(|world| format!("{:.1} ", world.fan_speed(0)))
    };
    (0..20).map(|_| moment(bench)).collect()
}

fn full(bench: &mut Bench) -> String {
    bench.say("M106");
    fan(bench)
}
