//! Every sample configuration boots without a finding and does a short job.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

const MINIMAL: &str = include_str!("../../config/samples/minimal.ini");
const CNC_MILL: &str = include_str!("../../config/samples/cnc-mill.ini");
const LASER: &str = include_str!("../../config/samples/laser.ini");
const LATHE: &str = include_str!("../../config/samples/lathe.ini");

fn start(config: &str) -> Bench {
    let bench = Plan::new(config).start();
    assert!(!bench.greeting().contains("config.ini"), "{}", bench.greeting());
    bench
}

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < 0.0126, "{what}: {actual}, not {expected}");
}

#[test]
fn the_minimal_machine_moves_three_motors() {
    let mut bench = start(MINIMAL);
    let [x, y, z] = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
    bench.run(&["G91", "G1 X20 Y10 F6000", "G2 X10 Y10 I10 J0", "G1 Z2 F600", "M400", "M84"]);
    assert_near(bench.carriage(Alpha) - x, 30.0, "x");
    assert_near(bench.carriage(Beta) - y, 20.0, "y");
    assert_near(bench.carriage(Gamma) - z, 2.0, "z");
}

/// Actions of a GRBL sender: home, set the work offset, run a pocket, ask for status.
#[test]
fn the_mill_homes_up_first_and_cuts_a_pocket_for_a_grbl_sender() {
    let mut bench = start(CNC_MILL);
    let refused = bench.say("G1 X10 F600");
    assert!(refused.ends_with("\nerror:20\n") && refused.contains("ALARM:3\n"), "no move before homing: {refused}");
    bench.say("$X");
    assert_eq!(bench.say("$H"), "ok\n");
    let job = [
        "G21 G90 G54",
        "G53 G0 Z-5",
        "G0 X50 Y40",
        "G10 L20 P1 X0 Y0 Z30",
        "G0 Z5",
        "M3",
        "M8",
        "G1 Z-1 F300",
        "G1 X20 F600",
        "G2 X30 Y10 I0 J10",
        "G1 Y30",
        "G0 Z5",
        "M9",
        "M5",
        "M400",
    ];
    for line in job {
        let said = bench.say(line);
        assert_eq!(said, "ok\n", "{line}");
        if line == "M8" {
            assert!(bench.say("switch spindle").starts_with("[MSG:switch spindle is 1]"));
        }
    }
    assert!(bench.say("switch spindle").starts_with("[MSG:switch spindle is 0]"));
    assert_near(bench.carriage(Alpha), 80.0, "machine x");
    assert_near(bench.carriage(Beta), 70.0, "machine y");
    let status = bench.status();
    assert!(status.contains("MPos:80.000,70.000,-30.000") && status.contains("WCO:50.000,40.000,-35.000"), "{status}");
    assert!(bench.say("M30").ends_with("ok\n"), "the program's end, not a file to delete");
}

/// The offset of the part outlives the reset, as `save_wcs` promises.
#[test]
fn the_mill_keeps_its_work_offset() {
    let mut bench = start(CNC_MILL);
    bench.say("$H");
    bench.say("G10 L2 P2 X12 Y34 Z-5.5");
    bench.say("M500");
    let saved = bench.read_card("config-override").unwrap();
    assert!(saved.contains("G10 L2 P2 X12.000000 Y34.000000 Z-5.500000 ; G55"), "{saved}");
}

fn laser_duty(bench: &Bench) -> f64 {
    bench.world(|world| f64::from(world.laser().duty()) / f64::from(u16::MAX))
}

/// Files of senders, in their exact form, run to their end without a message.
#[test]
fn files_of_laser_senders_run_to_their_end() {
    for (name, text) in [
        ("lightburn_cut.gc", include_str!("data/lasers/lightburn_cut.gc")),
        ("lightburn_scan.gc", include_str!("data/lasers/lightburn_scan.gc")),
        ("lightburn_smoothie.gc", include_str!("data/lasers/lightburn_smoothie.gc")),
        ("lightburn_cluster.gc", include_str!("data/lasers/lightburn_cluster.gc")),
        ("lasergrbl.nc", include_str!("data/lasers/lasergrbl.nc")),
        ("rayforge.gcode", include_str!("data/lasers/rayforge.gcode")),
    ] {
        let is_grbl = !name.starts_with("lightburn_smoothie") && !name.starts_with("lightburn_cluster");
        let smoothie = LASER.replace("grbl_mode = true", "grbl_mode = false").replace("= 1000 ", "= 1 ");
        let smoothie = smoothie.replace("= M8", "= M106").replace("= M9", "= M107");
        let mut bench = start(if is_grbl { LASER } else { &smoothie });
        assert_eq!(bench.say(if is_grbl { "$H" } else { "G28" }), "ok\n");
        // Streamed, with an ok for each line.
        for line in text.lines() {
            assert_eq!(bench.say(line), "ok\n", "{name}: {line}");
        }
        bench.hear(20.0);
        assert!(bench.status().starts_with("<Idle"), "{name}: {}", bench.status());
        assert_eq!(laser_duty(&bench), 0.0, "{name}");
        // From the card.
        bench.write_card(name, text.as_bytes());
        let said = bench.say(&format!("play /sd/{name}"));
        assert!(!said.contains("error"), "{name}: {said}");
        let said = bench.hear(30.0);
        assert!(!said.contains("error") && !said.contains("paused"), "{name}: {said}");
        assert!(bench.status().starts_with("<Idle"), "{name}: {}", bench.status());
    }
}

#[test]
fn a_beam_to_focus_with_ends_by_itself_and_by_a_halt() {
    let mut bench = start(LASER);
    bench.say("fire 2");
    bench.hear(0.5);
    assert!((laser_duty(&bench) - 0.02).abs() < 1e-4, "{}", laser_duty(&bench));
    bench.hear(0.6);
    assert_eq!(laser_duty(&bench), 0.0);
    bench.say("M221 S50 P0 R2000");
    assert!(bench.say("M221").contains("Laser power:  50.00 %, disable auto power: 0"));
    bench.say("fire 100 60000");
    bench.say("M112");
    assert_eq!(laser_duty(&bench), 0.0, "a halt is off");
}

/// While the door is open nothing burns, whatever is typed.
#[test]
fn an_open_door_keeps_the_laser_off() {
    let mut bench = start(LASER);
    bench.say("fire 40 60000");
    bench.hear(0.01);
    assert!((laser_duty(&bench) - 0.4).abs() < 1e-4);
    bench.send(&[0x84]);
    bench.hear(0.01);
    assert_eq!(laser_duty(&bench), 0.0);
    assert!(bench.status().starts_with("<Door"), "{}", bench.status());
    bench.type_in("~");
    bench.hear(0.1);
    assert_eq!(laser_duty(&bench), 0.0, "the beam does not come back by itself");
}

#[test]
fn the_lathe_faces_and_turns_a_taper() {
    let mut bench = start(LATHE);
    assert_eq!(bench.say("$H"), "ok\n");
    // Both switches are limits: it stands 2 mm off them.
    for line in
        ["G90 G21 G18", "G10 L20 P1 X58 Z8", "M3", "G0 X12 Z1", "G1 X0 F60", "G0 X12", "G1 X9 Z-20 F60", "M5", "M400"]
    {
        assert_eq!(bench.say(line), "ok\n", "{line}");
    }
    assert_near(bench.carriage(Alpha), 9.0, "x");
    assert_near(bench.carriage(Gamma), -30.0, "z");
    assert_eq!(bench.world(|world| world.trace().tally(Beta).steps), 0, "there is no Y");
    assert!(bench.say("G33 Z-10 K1").contains("G33 needs a spindle encoder"), "no threading yet");
}

/// Edge of a job: time since its first one (nanoseconds), motor, direction.
type Edge = (u64, units::Actuator, units::Direction);

/// Returns the edges of a job that is played from the card, and the number of changes of the laser's power.
fn edges_of(config: &str, before: &[&str], job: &str) -> (Vec<Edge>, usize) {
    let mut bench = start(config);
    before.iter().for_each(|line| assert_eq!(bench.say(line), "ok\n", "{line}"));
    bench.write_card("job.gc", job.as_bytes());
    bench.world(|world| (world.trace_mut().take(), world.trace_mut().take_power()));
    bench.say("play /sd/job.gc");
    let said = bench.hear(120.0);
    assert!(!said.contains("error") && bench.status().starts_with("<Idle"), "{said}{}", bench.status());
    let edges = bench.world(|world| world.trace_mut().take());
    let began = edges.first().map_or(0, |edge| edge.time_ns);
    let edges = edges.into_iter().map(|edge| (edge.time_ns - began, edge.actuator, edge.direction));
    (edges.collect(), bench.world(|world| world.trace_mut().take_power()).len())
}

/// Rows of pixels in both directions, `levels` different powers, with overscan.
fn raster(levels: u32) -> String {
    let mut text = String::from("G90\nM3\nG1 F6000\n");
    for row in 0..6 {
        let y = 10.0 + f64::from(row) * 0.1;
        let place = |pixel: u32| 20.0 + 0.05 * f64::from(if row % 2 == 0 { pixel } else { 200 - pixel });
        text += &format!("G0 X{:.3} Y{y:.3}\n", if row % 2 == 0 { 15.0 } else { 35.0 });
        text += &format!("G1 X{:.3} S0\n", place(0));
        for pixel in 1..=200 {
            text += &format!("X{:.3} S{}\n", place(pixel), (pixel * 7 + row * 13) % levels);
        }
    }
    text + "M5\n"
}

/// Power never moves a step: a picture's steps are those of the same rows in the dark, and a job that knows
/// no laser makes the same steps on a machine with one as without.
#[test]
fn a_laser_moves_no_step() {
    let (dark, changes_in_the_dark) = edges_of(LASER, &["$H"], &raster(1));
    let (picture, changes) = edges_of(LASER, &["$H"], &raster(1_000));
    assert_eq!(changes_in_the_dark, 0);
    assert!(changes > 1_000 && picture.len() > 10_000, "{changes} changes, {} edges", picture.len());
    assert!(dark == picture);
    // Without what waits, which begins anew at a moment of the executor.
    let waits = |line: &&str| ["G28", "M109", "M190"].iter().any(|code| line.starts_with(code));
    let job = include_str!("data/slicers/prusaslicer.gcode");
    let job: String = job.lines().filter(|line| !waits(line)).map(|line| format!("{line}\n")).collect();
    let with = CARTESIAN.to_owned() + "\n[laser]\nenable = true\npwm_pin = PWM2_1\n";
    let before = ["G28.3 X0 Y0 Z0", "M302 P1"];
    let (without, with) = (edges_of(CARTESIAN, &before, &job), edges_of(&with, &before, &job));
    assert!(without.0.len() > 1_000 && without == with, "{} edges", without.0.len());
}
