//! The laser: which moves have power, what locks it, and its beam at rest.

use program::Spindle;
use scenarios::{Bench, CARTESIAN, Plan};

use crate::operation::press;

const LASER: &str = "\n[laser]\nenable = true\npwm_pin = PWM2_1\nmaximum_s_value = 1000\ninterlock_switches = lid\n";
const LID: [&str; 2] = ["[switch] lid.enable = true", "[switch] lid.input_pin = PB7^"];

fn plan() -> Plan {
    let grbl = ["[general] grbl_mode = true", "[general] config-override = true"];
    grbl.iter().chain(&LID).fold(Plan::new(CARTESIAN).adding(LASER), |plan, line| plan.set(line))
}

fn duty(bench: &mut Bench) -> u16 {
    bench.world(|world| world.laser().duty())
}

#[test]
fn fire_lights_the_beam_at_rest_and_ends_by_itself() {
    let mut bench = plan().start();
    assert!(bench.say("fire 5 200").contains("laser 5.0 %"));
    bench.hear(0.1);
    assert_eq!(duty(&mut bench), 3_277);
    assert!(bench.say("fire status").contains("laser 0.0 %"), "a line ends it");
    assert_eq!(duty(&mut bench), 0);
    bench.say("fire 50 200");
    bench.hear(0.19);
    assert_eq!(duty(&mut bench), 32_768);
    bench.hear(0.05);
    assert_eq!(duty(&mut bench), 0);
    bench.say("fire 100 60000");
    bench.type_in("!");
    bench.hear(0.01);
    assert_eq!(duty(&mut bench), 0, "a hold ends it");
    assert!(bench.say("fire 200").contains("fire takes percent"));
    bench.say("fire 100 60000");
    bench.say("M112");
    assert_eq!(duty(&mut bench), 0, "a halt ends it");
}

#[test]
fn laser_mode_and_its_scale_are_settings_of_grbl() {
    let mut bench = plan().start();
    let listed = bench.say("$$");
    for line in ["$30=1000\n", "$31=0\n", "$32=1\n"] {
        assert!(listed.contains(line), "{line} of {listed}");
    }
    for line in ["$30=255", "$31=5", "$32=0"] {
        assert_eq!(bench.say(line), "ok\n");
    }
    let listed = bench.say("$$");
    for line in ["$30=255\n", "$31=5\n", "$32=0\n"] {
        assert!(listed.contains(line), "{line} of {listed}");
    }
    assert!(bench.say("M452").contains("Laser mode off, full power at S255, least power at S5"));
    // S is the power at rest now, for a minute at most, and no move's.
    bench.say("M3 S51");
    bench.hear(0.05);
    assert!((i32::from(duty(&mut bench)) - 13_107).abs() < 2, "{}", duty(&mut bench));
    bench.type_in("G1 X10 F600\n");
    bench.hear(0.3);
    assert_eq!(duty(&mut bench), 0);
    bench.hear(2.0);
    assert!(duty(&mut bench) > 0, "it rests again");
    bench.say("$32=1");
    bench.hear(0.05);
    assert_eq!(duty(&mut bench), 0);
}

#[test]
fn an_open_interlock_locks_the_beam_and_lets_the_machine_be_placed() {
    let mut bench = plan().start();
    press(&mut bench, "lid", true);
    let said = bench.hear(0.2);
    assert!(said.contains("the laser's interlock lid is open"), "{said}");
    assert!(bench.say("fire 5").contains("the laser is locked"));
    assert_eq!(bench.say("G0 X10"), "ok\n");
    bench.hear(2.0);
    press(&mut bench, "lid", false);
    bench.hear(0.1);
    assert!(bench.say("fire 5").contains("laser 5.0 %"));
    // A machine that moves holds.
    bench.say("M3 S500");
    bench.type_in("G1 X100 F600\n");
    bench.hear(1.0);
    press(&mut bench, "lid", true);
    bench.hear(0.2);
    assert!(bench.status().starts_with("<Hold"), "{}", bench.status());
    assert_eq!(duty(&mut bench), 0);
    bench.type_in("~");
    bench.hear(0.2);
    assert!(bench.status().starts_with("<Hold"), "{}", bench.status());
    press(&mut bench, "lid", false);
    bench.hear(0.1);
    bench.type_in("~");
    bench.hear(0.2);
    assert!(bench.status().starts_with("<Run"), "{}", bench.status());
}

#[test]
fn status_reports_tell_the_power() {
    let mut bench = plan().start();
    bench.say("M4 S250");
    let status = bench.status();
    assert!(status.contains("|FS:0,250"), "{status}");
    assert!((0..30).any(|_| bench.status().contains("|A:C")), "M4 is C");
    bench.say("M5");
    assert!(bench.status().contains("|FS:0,0"));
}

/// Power that left the output since the last look: times in seconds, and duties.
fn changes(bench: &mut Bench) -> Vec<(f64, u16)> {
    let changes = bench.world(|world| world.trace_mut().take_power());
    changes.iter().map(|change| (change.time_ns as f64 * 1e-9, change.duty)).collect()
}

/// Starts a machine at X50 that may home, probe and jog.
fn placed() -> Bench {
    placed_with("[laser] hold = off")
}

fn placed_with(line: &str) -> Bench {
    let mut bench = plan().adding("\n[safety door]\nenable = true\npin = PJ6^\n").set(line).start();
    bench.run(&["G28.3 X50 Y50 Z10"]);
    bench
}

#[test]
fn moves_that_cut_have_power_and_nothing_else_has() {
    let mut bench = placed();
    bench.run(&["M3 S500", "G1 X60 F1200", "G4 P0"]);
    let made = changes(&mut bench);
    assert_eq!(made.iter().map(|(_, duty)| *duty).collect::<Vec<_>>(), [32_768, 0], "on along the move, off at rest");
    // Half a second at 20 mm/s, and its ramps.
    let lasted = made[1].0 - made[0].0;
    assert!((0.5..0.8).contains(&lasted), "{lasted}");
    for dark in ["G0 X70", "$J=G91 X5 F1200", "G1 X60 S0 F1200", "$H"] {
        let edges = bench.world(|world| world.trace().total());
        bench.say(dark);
        bench.hear(3.0);
        assert!(bench.world(|world| world.trace().total()) > edges, "{dark} moves");
        assert_eq!(changes(&mut bench), [], "{dark}");
    }
    // S stays over M5 and M3, and alone on a line it is the next move's.
    bench.run(&["G0 X50 Y50", "M5", "G1 X55 F1200", "G4 P0"]);
    assert_eq!(changes(&mut bench), []);
    bench.run(&["M3 S500", "S250", "G1 X60", "G4 P0"]);
    assert_eq!(changes(&mut bench).first().map(|(_, duty)| *duty), Some(16_384));
    // A run of pixels, alone on its line and among others.
    bench.run(&["S0", "G1 X65 S500@7", "G1 X70 S250@3:0@2", "G4 P0"]);
    assert_eq!(changes(&mut bench).iter().map(|(_, duty)| *duty).collect::<Vec<_>>(), [32_768, 16_384, 0]);
    // M4 follows the speed: from nothing, up in small steps, down to nothing.
    bench.run(&["M4 S1000", "G1 X90 F3000", "G4 P0"]);
    let duties: Vec<u16> = changes(&mut bench).into_iter().map(|(_, duty)| duty).collect();
    assert!(duties.len() > 50 && duties.iter().max() == Some(&65_535) && duties.last() == Some(&0), "{duties:?}");
    assert!(duties.windows(2).all(|pair| pair[0].abs_diff(pair[1]) <= 1_500), "steps of 2 % at most: {duties:?}");
}

#[test]
fn a_jog_shows_the_place_with_no_more_than_the_power_for_framing() {
    let mut bench = plan().set("[laser] framing_power = 0.02").start();
    bench.run(&["G28.3 X50 Y50 Z10"]);
    for (s, duty) in [("M3 S500", 1_310), ("M3 S10", 655), ("M4 S500", 0), ("M5 S500", 0)] {
        assert_eq!(bench.say(s), "ok\n");
        bench.say("$J=G91 X2 F1200");
        bench.hear(1.0);
        let most = changes(&mut bench).into_iter().map(|(_, duty)| duty).max().unwrap_or(0);
        assert_eq!(most, duty, "{s}");
        assert_eq!(bench.world(|world| world.laser().duty()), 0, "{s}: it rests");
    }
}

#[test]
fn viewers_see_the_power_that_comes_out_and_the_interlocks_that_are_open() {
    let look = |bench: &mut Bench| {
        bench.network(|network| (network.is_viewed, network.shown) = (true, None));
        bench.hear(0.05);
        let laser = bench.network(|network| network.shown.take()).and_then(|shown| shown.laser).expect("a laser");
        ((laser.power * 1_000.0).round(), laser.mode, laser.is_test, laser.is_framing, laser.open.to_string())
    };
    let mut bench = plan().set("[laser] framing_power = 0.02").start();
    bench.run(&["G28.3 X50 Y50 Z10"]);
    assert_eq!(look(&mut bench), (0.0, Spindle::Stopped, false, false, String::new()));
    bench.say("fire 5 200");
    assert_eq!(look(&mut bench), (50.0, Spindle::Stopped, true, false, String::new()));
    bench.hear(0.3);
    assert_eq!(look(&mut bench), (0.0, Spindle::Stopped, false, false, String::new()));
    bench.say("M3 S500");
    bench.say("$J=G91 X10 F1200");
    assert_eq!(look(&mut bench), (20.0, Spindle::Clockwise, false, true, String::new()));
    bench.hear(1.0);
    bench.type_in("G1 X150 S250 F3000\n");
    bench.hear(0.3);
    assert_eq!(look(&mut bench), (250.0, Spindle::Clockwise, false, false, String::new()));
    press(&mut bench, "lid", true);
    assert_eq!(look(&mut bench), (0.0, Spindle::Clockwise, false, false, "lid,".to_owned()));
}

#[test]
fn a_machine_without_a_laser_shows_none() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.network(|network| network.is_viewed = true);
    bench.hear(0.05);
    assert_eq!(bench.network(|network| network.shown.take()).expect("a machine that is looked at").laser, None);
}

#[test]
fn a_hold_that_fades_takes_the_power_down_with_the_speed_and_brings_it_back() {
    let mut bench = placed_with("[laser] hold = fade");
    bench.run(&["M3 S500"]);
    bench.type_in("G1 X190 F3000\n");
    bench.hear(1.0);
    changes(&mut bench);
    let held_s = bench.now_s();
    bench.type_in("!");
    bench.hear(1.0);
    let made = changes(&mut bench);
    assert!(bench.status().starts_with("<Hold:0"), "{}", bench.status());
    assert!(made[0].0 - held_s < 0.003, "it begins with the brake: {}", made[0].0 - held_s);
    assert!(made.windows(2).all(|pair| pair[1].1 < pair[0].1) && made.last().is_some_and(|last| last.1 == 0));
    bench.type_in("~");
    bench.hear(1.0);
    assert_eq!(changes(&mut bench).last().map(|(_, duty)| *duty), Some(32_768), "the same S goes on");
}

/// Power around a hold of a burning move, and the steps of all of it.
struct Held {
    /// Time from the hold to the last light, seconds.
    dark_after_s: f64,
    /// Time from going on to the first light, seconds.
    back_after_s: f64,
    steps: (u64, u64),
}

/// Holds a move with half of full power after so many milliseconds, and goes on, once at rest and once on the
/// way to it.
fn held(law: &str, hold: &str, after_ms: f64) -> Held {
    let mut bench = placed_with(hold);
    bench.run(&[law]);
    bench.type_in("G1 X190 F3000\n");
    bench.hear(after_ms / 1e3);
    assert_eq!(duty(&mut bench), 32_768, "{law}");
    changes(&mut bench);
    let held_s = bench.now_s();
    bench.type_in("!");
    bench.hear(0.5);
    assert!(bench.status().starts_with("<Hold:0"), "{}", bench.status());
    let made = changes(&mut bench);
    let (dark_s, last) = *made.last().expect("it goes off");
    assert_eq!((last, duty(&mut bench)), (0, 0), "{law}");
    let resumed_s = bench.now_s();
    bench.type_in("~");
    bench.hear(0.2);
    let back_s = changes(&mut bench).iter().find(|(_, duty)| *duty > 0).expect("the beam comes back").0;
    assert_eq!(duty(&mut bench), 32_768, "{law}: the same S goes on");
    bench.type_in("!");
    bench.hear(0.002);
    bench.type_in("~");
    bench.hear(0.2);
    assert_eq!(duty(&mut bench), 32_768, "{law}: the hold was taken back before the machine stood");
    bench.hear(4.0);
    assert_eq!(duty(&mut bench), 0, "{law}: it rests");
    let steps = bench.world(|world| (world.trace().total(), world.trace().edge_hash()));
    Held { dark_after_s: dark_s - held_s, back_after_s: back_s - resumed_s, steps }
}

#[test]
fn a_hold_ends_the_power_at_once_and_moves_no_step_otherwise() {
    let mut worst_s = 0.0_f64;
    for law in ["M3 S500", "M4 S500"] {
        for phase in 0..8 {
            let after_ms = 500.0 + 0.13 * f64::from(phase);
            let [off, fade] = ["[laser] hold = off", "[laser] hold = fade"].map(|hold| held(law, hold, after_ms));
            assert!(fade.dark_after_s > 0.01, "{law} fades with the brake: {}", fade.dark_after_s);
            for Held { back_after_s, .. } in [&off, &fade] {
                assert!((0.0..0.003).contains(back_after_s), "{law} comes back with the motors: {back_after_s}");
            }
            assert_eq!(off.steps, fade.steps, "{law}: the same steps");
            worst_s = worst_s.max(off.dark_after_s);
        }
    }
    println!("dark {:.0} us after the hold at most", worst_s * 1e6);
    assert!(worst_s <= 0.000_8, "{worst_s} s");
}

#[test]
fn a_hold_is_dark_without_laser_mode_too() {
    for hold in ["[laser] hold = off", "[laser] hold = fade"] {
        let mut bench = placed_with(hold);
        bench.run(&["$32=0", "M3 S500"]);
        bench.hear(0.1);
        assert_eq!(duty(&mut bench), 32_768, "S is the power at rest");
        bench.type_in("G1 X190 F3000\n");
        bench.hear(0.5);
        bench.type_in("!");
        bench.hear(0.5);
        assert!(bench.status().starts_with("<Hold:0"), "{}", bench.status());
        assert_eq!(duty(&mut bench), 0, "{hold}");
    }
}

#[test]
fn whatever_stops_the_machine_takes_the_power_off_at_once() {
    type Cause = (&'static str, fn(&mut Bench));
    const CAUSES: [Cause; 5] = [
        ("M112", |bench| bench.type_in("M112\n")),
        ("Ctrl-X", |bench| bench.type_in("\u{18}")),
        ("the door", |bench| press(bench, "door", true)),
        ("the door, by a byte", |bench| bench.send(&[0x84])),
        ("an interlock", |bench| press(bench, "lid", true)),
    ];
    for (name, cause) in CAUSES {
        let mut bench = placed();
        bench.run(&["M3 S500"]);
        bench.type_in("G1 X190 F3000\n");
        bench.hear(1.0);
        assert_eq!(duty(&mut bench), 32_768, "{name}");
        changes(&mut bench);
        let began_s = bench.now_s();
        cause(&mut bench);
        bench.hear(0.05);
        let made = changes(&mut bench);
        let (off_s, last) = *made.last().expect("a change");
        assert_eq!((last, duty(&mut bench)), (0, 0), "{name}: {made:?}");
        println!("{name}: off after {:.0} us", (off_s - began_s) * 1e6);
        assert!(off_s - began_s <= 0.000_8, "{name}: {} s", off_s - began_s);
    }
}

#[test]
fn power_that_is_not_renewed_goes_off_and_the_machine_holds() {
    let mut bench = placed();
    bench.run(&["M3 S500"]);
    bench.type_in("G1 X190 F3000\n");
    bench.hear(1.0);
    let now_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.let_laser_lapse(now_ns));
    let said = bench.hear(0.5);
    assert!(said.contains("WARNING: the laser went off, as the firmware was late"), "{said}");
    assert!(bench.status().starts_with("<Hold:0"), "{}", bench.status());
    assert_eq!(duty(&mut bench), 0);
    bench.type_in("~");
    bench.hear(1.0);
    assert_eq!(duty(&mut bench), 32_768, "it goes on as it was");
    // At rest nothing holds, and the next beam burns.
    bench.hear(10.0);
    bench.say("fire 5 1000");
    let now_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.let_laser_lapse(now_ns));
    assert!(bench.hear(0.1).contains("the laser went off"));
    assert_eq!(duty(&mut bench), 0);
    assert!(bench.say("fire 5 1000").contains("laser 5.0 %"));
}
