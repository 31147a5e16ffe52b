//! Files as CAM programs write them, run end to end: the tool goes where they say, it waits for a person
//! where they say, and nothing is passed over without a word.
//!
//! The programs are written in each CAM system's style for a mill that speaks GRBL, and are in data/cam.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{self, Alpha, Beta, Gamma};

/// A mill with spindle and coolant; the program's zero is where it stands when it is switched on.
fn mill() -> Plan {
    let plan =
        Plan::new(CARTESIAN).with("grbl_mode = false", "grbl_mode = true").set("[extruder] hotend.enable = false");
    let output = |plan: Plan, name: &str, on: &str, off: &str, pin: &str| {
        plan.set(&format!("[switch] {name}.enable = true"))
            .set(&format!("[switch] {name}.input_on_command = {on}"))
            .set(&format!("[switch] {name}.input_off_command = {off}"))
            .set(&format!("[switch] {name}.output_pin = {pin}"))
            .set(&format!("[switch] {name}.output_type = digital"))
    };
    output(output(plan, "spindle", "M3", "M5", "PI4"), "coolant", "M8", "M9", "PB7")
}

/// A run of a file: the machine after it, its carriages before it, and everything that was said.
struct Played {
    bench: Bench,
    zero: [f64; 3],
    heard: String,
    /// Number of waits for the operator.
    waits: usize,
}

impl Played {
    fn begin(plan: Plan, text: &str) -> Self {
        let mut bench = plan.file("part.nc", text).start();
        let zero = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
        let heard = bench.say("M23 part.nc");
        let mut played = Self { bench, zero, heard, waits: 0 };
        played.heard.push_str(&played.bench.say("M24"));
        played
    }

    /// Runs the file to its end; the operator goes on wherever the program waits.
    #[track_caller]
    fn to_its_end(plan: Plan, text: &str) -> Self {
        let mut played = Self::begin(plan, text);
        let mut from = 0;
        while !played.heard.contains("Done printing file") {
            assert!(!played.heard.contains("paused"), "{}", played.heard);
            if let Some(at) = played.heard[from..].find("goes on") {
                from += at + 1;
                played.waits += 1;
                played.bench.type_in("~");
            }
            let more = played.bench.hear(0.5);
            played.heard.push_str(&more);
            assert!(played.bench.now_s() < 2_000.0, "it does not end: {}", played.heard);
        }
        played.bench.hear(5.0);
        assert!(played.bench.status().starts_with("<Idle|"));
        let heard = &played.heard;
        assert!(!heard.contains("error") && !heard.contains("ALARM") && !heard.contains("not carried out"), "{heard}");
        played
    }

    /// Asserts how far an axis went, from the program's zero.
    #[track_caller]
    fn assert_reached(&self, motor: Actuator, least: f64, most: f64) {
        let zero = self.zero[motor as usize];
        let reached = self.bench.world(|world| world.reached_mm(motor)).expect("a motor").map(|at| at - zero);
        let near = |at: f64, wanted: f64| (at - wanted).abs() < 0.03;
        assert!(
            near(reached[0], least) && near(reached[1], most),
            "{motor:?} went from {} to {}",
            reached[0],
            reached[1]
        );
    }

    #[track_caller]
    fn assert_ends_at(&self, place: [f64; 3]) {
        let at = [Alpha, Beta, Gamma].map(|motor| self.bench.carriage(motor) - self.zero[motor as usize]);
        let near = at.iter().zip(place).all(|(at, wanted)| (at - wanted).abs() < 0.013);
        assert!(near, "it ends at {at:?}, not at {place:?}");
    }
}

#[test]
fn fusion_360() {
    let played = Played::to_its_end(mill(), include_str!("data/cam/fusion360.nc"));
    // Two tools and an optional stop.
    assert_eq!(played.waits, 3, "{}", played.heard);
    played.assert_reached(Alpha, 0.0, 38.6);
    played.assert_reached(Beta, 0.0, 43.0);
    played.assert_reached(Gamma, -6.0, 15.0);
    played.assert_ends_at([0.0; 3]);
}

#[test]
fn freecad() {
    let played = Played::to_its_end(mill(), include_str!("data/cam/freecad.nc"));
    assert_eq!(played.waits, 0, "{}", played.heard);
    played.assert_reached(Alpha, 0.0, 43.0);
    played.assert_reached(Beta, 0.0, 43.0);
    played.assert_reached(Gamma, -3.0, 11.0);
    played.assert_ends_at([20.0, 35.0, 5.0]);
}

#[test]
fn vectric() {
    let played = Played::to_its_end(mill(), include_str!("data/cam/vectric.gcode"));
    played.assert_reached(Alpha, 0.0, 45.0);
    played.assert_reached(Beta, 0.0, 35.0);
    played.assert_reached(Gamma, -4.0, 20.32);
    played.assert_ends_at([0.0, 0.0, 20.32]);
}

#[test]
fn estlcam() {
    let played = Played::to_its_end(mill(), include_str!("data/cam/estlcam.nc"));
    played.assert_reached(Alpha, 0.0, 40.0);
    played.assert_reached(Beta, 0.0, 45.0);
    played.assert_reached(Gamma, -1.5, 5.0);
    played.assert_ends_at([0.0, 0.0, 5.0]);
}

const LIGHTBURN: &str = include_str!("data/cam/lightburn.gc");

#[test]
fn lightburn() {
    let plan = mill().set("[switch] spindle.input_on_command = M4");
    let played = Played::to_its_end(plan, LIGHTBURN);
    played.assert_reached(Alpha, 0.0, 40.0);
    played.assert_reached(Beta, 0.0, 30.0);
    played.assert_ends_at([0.0; 3]);
}

/// A laser's job would cut nothing without an output that M4 turns on.
#[test]
fn m4_of_a_laser_on_a_spindle_that_has_none_stops_the_job_before_it_moves() {
    let mut played = Played::begin(mill(), LIGHTBURN);
    let more = played.bench.hear(1.0);
    played.heard.push_str(&more);
    let heard = &played.heard;
    assert!(heard.contains("this spindle has no M4") && heard.contains("paused, line 6 "), "{heard}");
    played.assert_reached(Alpha, 0.0, 0.0);
}
