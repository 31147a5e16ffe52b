//! The laser: which moves have power, what locks it, and its beam at rest.

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
