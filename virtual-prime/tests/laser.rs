//! The laser at its pins: duty and gate of a beam at rest, how soon a halt forces both off, and the places of
//! a picture's edges.

use std::fmt::Write as _;

use sim::trace::{PowerChange, StepEdge};
use units::Actuator;

use crate::common::MS;
use crate::common::machine::{changes, pin, watch};
use crate::common::velvet::{Plan, SECOND};
use crate::common::writes::Written;

/// TIM8 (RM0399 section 42.4, boundary addresses): mode of channels 1 and 2, enables and polarities, period,
/// compare value of channel 1.
const MODE: u64 = 0x4001_0418;
const ENABLES: u64 = 0x4001_0420;
const PERIOD: u64 = 0x4001_042C;
const COMPARE: u64 = 0x4001_0434;
/// OCxM in the mode register (RM0399 section 42.4.8), no buffered compare value.
const FORCED_INACTIVE: u64 = 0x40;
const PWM_MODE_1: u64 = 0x60;
const GATE: &str = "PD9";

fn plan(lines: &[&str]) -> Plan {
    let usual = ["enable = true", "pwm_pin = PWM2_1", "ttl_pin = PD9", "maximum_s_value = 1000"];
    let plan = usual.iter().chain(lines).fold(Plan::new(), |plan, line| plan.set(&format!("[laser] {line}")));
    [MODE, ENABLES, PERIOD, COMPARE].into_iter().fold(plan, |plan, register| plan.watching(register..register + 4))
}

/// Returns the last value written to a register since the last call, and when.
fn last(writes: &[Written], register: u64) -> Option<(u64, u64)> {
    writes.iter().rev().find(|write| write.address == register).map(|write| (write.value & 0xFFFF, write.at_ns))
}

#[test]
fn fire_drives_duty_and_gate_and_a_halt_forces_both_off() {
    let mut velvet = plan(&["pwm_frequency = 20000"]).start();
    let set_up = velvet.bench.writes.take();
    assert_eq!(last(&set_up, PERIOD).map(|(value, _)| value), Some(9_999), "all counts of 20 kHz");
    assert_eq!(last(&set_up, MODE).map(|(value, _)| value), Some(PWM_MODE_1), "unlocked, without a buffer");
    watch(&mut velvet, &[GATE]);
    velvet.ask("fire 50 5000", SECOND);
    assert_eq!(last(&velvet.bench.writes.take(), COMPARE).map(|(value, _)| value), Some(5_000));
    assert!(changes(&mut velvet).iter().any(|change| change.pin == pin(GATE) && change.high));
    let since = velvet.send_through(b"M112\n");
    velvet.hear(20);
    let writes = velvet.bench.writes.take();
    let forced = last(&writes, MODE).expect("the mode is written");
    let gate = changes(&mut velvet).into_iter().rfind(|change| change.pin == pin(GATE)).expect("the gate goes off");
    println!("forced off after {} us, gate after {} us", (forced.1 - since) / 1_000, (gate.at_ns - since) / 1_000);
    assert_eq!((forced.0, gate.high), (FORCED_INACTIVE, false));
    assert!(forced.1 - since <= MS && gate.at_ns - since <= MS);
    assert_eq!(last(&writes, COMPARE).map(|(value, _)| value), Some(0));
}

#[test]
fn the_output_is_driven_as_it_is_configured() {
    let lines = ["pwm_frequency = 50000", "inverted_pwm = true", "opendrain = true", "pullup = true"];
    let mut velvet = plan(&lines).start();
    let set_up = velvet.bench.writes.take();
    assert_eq!(last(&set_up, PERIOD).map(|(value, _)| value), Some(3_999));
    assert_eq!(last(&set_up, ENABLES).map(|(value, _)| value), Some(0b11), "on, and on is low");
    let state = crate::common::machine::state(&mut velvet, "PI5");
    assert!(state.open_drain && state.pull == 1, "{state:?}");
}

/// The sample's steps for a millimetre of X.
const STEPS_PER_MM: f64 = 80.0;
/// Greatest distance of an edge from its place, mm.
const MOST_OFF_MM: f64 = 0.01;
/// Rows of the picture: width of each pixel in mm, and its S.
const PIXELS: [(f64, u16); 8] =
    [(0.1, 1_000), (0.05, 0), (0.05, 150), (0.3, 0), (1.0, 400), (0.2, 1_000), (0.15, 0), (0.1, 150)];

/// Returns the sample laser at 500 mm/s and 3000 mm/s^2.
pub fn fast_laser() -> Plan {
    let faster = [("= 12000", "= 30000"), ("_acceleration = 1500", "_acceleration = 3000")];
    let faster = faster.iter().chain(&[(".acceleration = 1500", ".acceleration = 3000")]);
    let homed = [("must_be_homed = true", "must_be_homed = false"), ("grbl_mode = true", "grbl_mode = false")];
    let text = include_str!("../../config/samples/laser.ini");
    let text = faster.chain(&homed).fold(text.to_owned(), |text, (piece, instead)| text.replace(piece, instead));
    Plan::new().config(&text)
}

/// Returns a job of a row there and a row back at each of these frequencies, and the X and S of each change
/// of power that it asks for.
fn picture(frequencies: &[u32]) -> (String, Vec<(f64, u16)>) {
    let (mut job, mut asked) = (String::from("M4 S0\nG1 F30000\n"), Vec::new());
    for hertz in frequencies {
        let _ = writeln!(job, "M221 R{hertz}");
        for (first, sign, end) in [(50.0, 1.0, 110.0), (60.0, -1.0, 0.0)] {
            let _ = writeln!(job, "G1 X{first} S0");
            let mut x = first;
            for (width, s) in PIXELS {
                asked.push((x, s));
                x += sign * width;
                let _ = writeln!(job, "G1 X{x:.3} S{s}");
            }
            asked.push((x, 0));
            let _ = writeln!(job, "G1 X{end} S0");
        }
    }
    (job + "M5\n", asked)
}

/// Returns the place of X at a time, mm: a motor passes half way between two steps at the step's edge, and
/// runs evenly between two edges.
fn place(edges: &[(u64, f64)], at_ns: u64) -> f64 {
    let after = edges.partition_point(|(edge_ns, _)| *edge_ns <= at_ns);
    let [(from_ns, from), (to_ns, to)] = [edges[after - 1], edges[after]];
    from + (to - from) * (at_ns - from_ns) as f64 / (to_ns - from_ns) as f64
}

/// Returns the time of each step edge of X, and X there, mm.
fn places(edges: &[StepEdge]) -> Vec<(u64, f64)> {
    let mut steps = 0.0;
    let edges = edges.iter().filter(|edge| edge.actuator == Actuator::Alpha);
    edges
        .map(|edge| {
            let step = f64::from(edge.direction.sign());
            steps += step;
            (edge.time_ns, (steps - 0.5 * step) / STEPS_PER_MM)
        })
        .collect()
}

/// The image, the timer's registers and the pin: each change of power in its place, whatever the frequency.
#[test]
fn a_picture_s_edges_at_the_pin_are_in_their_places() {
    let frequencies = [1_000, 5_000, 20_000, 50_000];
    let (job, asked) = picture(&frequencies);
    let mut velvet = fast_laser().file("picture.g", &job).start();
    velvet.world(|world| world.trace_mut().take_power());
    velvet.ask("M23 picture.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", 30 * SECOND);
    let (edges, changes) = velvet.world(|world| (world.trace_mut().take(), world.trace_mut().take_power()));
    let edges = places(&edges);
    assert_eq!(changes.len(), asked.len(), "{changes:?}");
    let rows = asked.len() / frequencies.len();
    for (hertz, (asked, made)) in frequencies.iter().zip(asked.chunks(rows).zip(changes.chunks(rows))) {
        let mut worst = [0.0_f64; 2];
        for (number, ((x, s), PowerChange { time_ns, duty })) in asked.iter().zip(made).enumerate() {
            let worst = &mut worst[usize::from(number >= rows / 2)];
            *worst = worst.max((place(&edges, *time_ns) - x).abs());
            let share = f64::from(*duty) / f64::from(u16::MAX);
            assert!((share - f64::from(*s) / 1e3).abs() < 1e-3, "{hertz} Hz, X{x}: {share} for S{s}");
        }
        println!("{hertz} Hz: edges off by {:.4} mm at most going up, {:.4} mm going down", worst[0], worst[1]);
        assert!(worst.iter().all(|worst| *worst <= MOST_OFF_MM), "{hertz} Hz: {worst:?} mm");
    }
}

/// Holds a burning move at such a phase of the step feed's and the executor's periods, and goes on. Returns
/// the time from the end of the byte to the last light at the pin, nanoseconds, and every step of X.
fn held(law: &str, hold: &str, phase_us: u64) -> (u64, Vec<StepEdge>) {
    let mut velvet = fast_laser().set(hold).start();
    velvet.ask("G28.3 X10 Y0 Z0", SECOND);
    velvet.ask(law, SECOND);
    velvet.world(|world| world.trace_mut().take());
    velvet.type_in("G1 X290 F6000");
    velvet.hear(600);
    velvet.hear_for(phase_us * 1_000);
    velvet.world(|world| world.trace_mut().take_power());
    let held_ns = velvet.send_through(b"!");
    velvet.hear(300);
    let changes = velvet.world(|world| world.trace_mut().take_power());
    let dark = changes.last().copied().filter(|change| change.duty == 0);
    let dark_ns = dark.unwrap_or_else(|| panic!("{law}: {changes:?}")).time_ns;
    let resumed_ns = velvet.send_through(b"~");
    velvet.hear(300);
    let changes = velvet.world(|world| world.trace_mut().take_power());
    let back = changes.iter().find(|change| change.duty > 0).expect("the beam comes back");
    let share = f64::from(changes.last().map_or(0, |change| change.duty)) / f64::from(u16::MAX);
    assert!((share - 0.5).abs() < 1e-3, "{law}: the same S goes on, not {share}");
    assert!(back.time_ns - resumed_ns < 3 * MS, "{law}: it is back with the motors");
    velvet.hear(3 * SECOND);
    let changes = velvet.world(|world| world.trace_mut().take_power());
    assert_eq!(changes.last().map(|change| change.duty), Some(0), "{law}: off at the end");
    (dark_ns - held_ns, velvet.world(|world| world.trace_mut().take()))
}

#[test]
fn a_hold_ends_the_light_at_the_pin_and_loses_no_step() {
    for law in ["M3 S500", "M4 S500"] {
        let mut worst_ns = 0;
        for phase_us in [0, 61, 122, 183, 244, 305] {
            worst_ns = worst_ns.max(held(law, "[laser] hold = off", phase_us).0);
        }
        println!("{law}: dark {} us after the hold at most", worst_ns / 1_000);
        assert!(worst_ns <= MS, "{law}: {worst_ns} ns");
        let [(_, off), (faded_ns, fade)] = ["off", "fade"].map(|hold| held(law, &format!("[laser] hold = {hold}"), 0));
        assert!(faded_ns > 20 * MS, "{law} fades with the brake: {faded_ns} ns");
        // A brake begins at a run of the step feed, whose phase is another in each start of the board; on the
        // native runner every edge is compared.
        assert!(off.len() > 1_000 && off.len() == fade.len(), "{law}: as many steps");
    }
}

/// Number of pixels that a raster line takes here.
const PIXELS_OF_A_LINE: usize = 30;

/// Rows of pixels there and back at 500 mm/s, each pixel with another S than the one before.
pub struct Noise {
    pub rows: usize,
    /// Pixels of a row, a multiple of [`PIXELS_OF_A_LINE`].
    pub pixels: usize,
    pub pixel_mm: f64,
}

impl Noise {
    /// Returns the job, in raster lines.
    pub fn job(&self) -> String {
        let (mut job, mut random) = (String::from("M4 S0\nG1 F30000\n"), 1_u32);
        let width = self.pixel_mm * self.pixels as f64;
        for row in 0..self.rows {
            let (first, sign, end) = if row % 2 == 0 { (60.0, 1.0, 110.0 + width) } else { (60.0 + width, -1.0, 10.0) };
            let _ = writeln!(job, "G1 X{first} Y{:.2} S0", row as f64 * self.pixel_mm);
            for line in 1..=self.pixels / PIXELS_OF_A_LINE {
                let x = first + sign * self.pixel_mm * (line * PIXELS_OF_A_LINE) as f64;
                let _ = write!(job, "G1 X{x:.2} S");
                for pixel in 0..PIXELS_OF_A_LINE {
                    random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let s = 100 + 400 * (pixel as u32 % 2) + (random >> 16) % 300;
                    let _ = write!(job, "{}{s}", if pixel == 0 { "" } else { ":" });
                }
                job.push('\n');
            }
            let _ = writeln!(job, "G1 X{end} S0");
        }
        job + "M5\n"
    }

    /// Asserts that every pixel was burnt, and every row at its speed.
    #[track_caller]
    pub fn check(&self, changes: &[PowerChange]) {
        let asked = self.rows * (self.pixels + 1);
        assert_eq!(changes.len(), asked, "more: the power of M4 follows a speed that falls");
        for (row, changes) in changes.chunks(self.pixels + 1).enumerate() {
            let lasted = (changes[self.pixels].time_ns - changes[0].time_ns) as f64 / 1e9;
            println!("row {row}: {:.0} pixels a second", self.pixels as f64 / lasted);
            assert!(lasted <= 1.002 * self.pixels as f64 * self.pixel_mm / 500.0, "row {row} took {lasted} s");
        }
    }
}

#[test]
fn twenty_five_thousand_pixels_a_second_burn_from_the_card() {
    let noise = Noise { rows: 6, pixels: 3_000, pixel_mm: 0.02 };
    let mut velvet = fast_laser().file("noise.g", &noise.job()).start();
    velvet.ask("G28.3 X10 Y0 Z0", SECOND);
    velvet.world(|world| world.trace_mut().take_power());
    velvet.ask("M23 noise.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", 60 * SECOND);
    noise.check(&velvet.world(|world| world.trace_mut().take_power()));
}
