//! Every sample configuration boots without a finding and does a short job.

use scenarios::{Bench, Plan};
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
    bench.world(|world| world.pwm_duty(0, 0))
}

/// Power is on only between M3 and M5, and a halt takes it away.
#[test]
fn the_laser_cuts_with_the_power_it_is_told() {
    let mut bench = start(LASER);
    assert_eq!(laser_duty(&bench), 0.0);
    assert_eq!(bench.say("$H"), "ok\n");
    for line in ["G90 G21", "G0 X50 Y40", "M8", "M3 S40", "M400"] {
        assert_eq!(bench.say(line), "ok\n", "{line}");
    }
    // M3 rides on the move before it: the output follows its end within a millisecond.
    bench.hear(0.001);
    assert!((laser_duty(&bench) - 0.4).abs() < 1e-6, "{}", laser_duty(&bench));
    for line in ["G1 X70 F1200", "G3 X70 Y60 I0 J10", "G1 X50", "M5", "M400"] {
        assert_eq!(bench.say(line), "ok\n", "{line}");
    }
    bench.hear(0.001);
    assert_eq!(laser_duty(&bench), 0.0);
    assert_near(bench.carriage(Alpha), 50.0, "x");
    assert_near(bench.carriage(Beta), 60.0, "y");
    bench.say("M3 S100");
    bench.say("M112");
    bench.hear(0.001);
    assert_eq!(laser_duty(&bench), 0.0, "a halt is off");
}

/// While the door is open nothing burns, whatever is typed; what was typed is done when it is closed.
#[test]
fn an_open_door_keeps_the_laser_off() {
    let mut bench = start(LASER);
    bench.say("M3 S40");
    bench.hear(0.01);
    assert!((laser_duty(&bench) - 0.4).abs() < 1e-6);
    bench.send(&[0x84]);
    bench.hear(0.01);
    assert_eq!(laser_duty(&bench), 0.0);
    assert!(bench.status().starts_with("<Door"), "{}", bench.status());
    bench.type_in("M3 S60\n");
    assert!(!bench.hear(0.5).contains("ok"));
    assert_eq!(laser_duty(&bench), 0.0, "it burns with an open door");
    bench.type_in("~");
    bench.hear(0.1);
    assert!((laser_duty(&bench) - 0.6).abs() < 1e-6, "{}", laser_duty(&bench));
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
