//! Reports by `?`, `$G` and `$#`.

use super::{Wait, plan, refused, start};

#[test]
fn modes_and_offsets_have_grbls_form() {
    let mut bench = start();
    bench.run(&["$H", "G1 X10 Y20 F600", "G10 L20 P1 X3", "G92 Y5", "G4 P0"]);
    assert_eq!(bench.say("$G"), "[GC:G1 G54 G17 G21 G90 G94 M5 M9 T0 F600 S0]\nok\n");
    let said = bench.say("$#");
    assert!(said.starts_with("[G54:7.000,0.000,0.000]\n[G55:0.000,0.000,0.000]\n"), "{said}");
    // Machine = work + G54 + G92, as GRBL counts.
    assert!(said.contains("\n[G92:0.000,15.000,0.000]\n[TLO:0.000]\n[PRB:0.000,0.000,0.000:0]\nok\n"), "{said}");
    let status = bench.status();
    assert!(status.contains("|MPos:10.000,20.000,0.000|"), "{status}");
    assert!(status.contains("|WCO:7.000,15.000,0.000>") || bench.status().contains("|WCO:7.000,15.000,0.000"));
}

#[test]
fn the_status_has_what_the_mask_asks_for_and_seldom_fields_seldom() {
    let mut bench = start();
    let reports: Vec<String> = (0..40).map(|_| bench.status()).collect();
    assert!(reports[0].starts_with("<Idle|MPos:0.000,0.000,0.000|FS:0,0|"), "{}", reports[0]);
    let count = |field: &str| reports.iter().filter(|report| report.contains(field)).count();
    assert_eq!((count("|WCO:"), count("|Ov:100,100,100")), (4, 4));
    assert_eq!((count("|Bf:"), count("|Ln:"), count("|WPos:")), (0, 0, 0));
    assert!(reports.iter().all(|report| !(report.contains("|WCO:") && report.contains("|Ov:"))));
    bench.run(&["$10=2", "G92 X5"]);
    let status = bench.status();
    assert!(status.starts_with("<Idle|WPos:5.000,0.000,0.000|Bf:") && status.contains("|WCO:-5.000,"), "{status}");
    assert!(status.contains(",4095|FS:"), "{status}");
    bench.run(&["$13=1"]);
    assert!(bench.status().starts_with("<Idle|WPos:0.1969,0.0000,0.0000|"));
}

#[test]
fn a_report_names_the_line_that_the_motors_make() {
    let mut bench = start();
    bench.run(&["N10 G1 X10 F1200", "N20 G1 X20", "G1 X30"]);
    bench.hear(0.2);
    assert!(bench.status().contains("|Ln:10|FS:1200,0|"), "{}", bench.status());
    bench.hear(0.5);
    assert!(bench.status().contains("|Ln:20|"), "{}", bench.status());
    bench.hear(0.5);
    assert!(!bench.status().contains("|Ln:"), "{}", bench.status());
}

#[test]
fn holds_and_the_door_say_whether_the_machine_rests() {
    let mut bench = start();
    for (byte, brakes, rests) in [(&b"!"[..], "<Hold:1|", "<Hold:0|"), (b"\x84", "<Door:2|", "<Door:0|")] {
        bench.run(&["G91 G1 X50 F6000", "G1 X-50"]);
        bench.hear(0.3);
        bench.send(byte);
        bench.hear(0.005);
        let status = bench.status();
        assert!(status.starts_with(brakes), "{status}");
        bench.hear(0.5);
        let status = bench.status();
        assert!(status.starts_with(rests), "{status}");
        bench.type_in("~");
        bench.hear_until_idle();
    }
}

/// `[general] grblhal`: fields come when they have changed, and all of them behind 0x87.
#[test]
fn grblhals_senders_find_what_they_look_for() {
    let mut bench = plan().set("[general] grblhal = true").file("part.nc", "G1 X9 F60\n").start();
    assert!(bench.greeting().ends_with("\nGrblHAL 1.1f ['$' for help]\n"), "{}", bench.greeting());
    let first = bench.status();
    assert!(first.contains("|WCS:G54|H:0,0|T:0") && !first.contains("FW:"), "{first}");
    assert!(!bench.status().contains("WCS"), "once");
    bench.run(&["$H", "G55"]);
    assert!(bench.status().contains("|WCS:G55|H:1,7>"), "what has changed");
    bench.send(b"\x87");
    let all = bench.hear(0.05);
    assert!(all.contains("|WCO:") && all.contains("|Ov:100,100,100"), "{all}");
    assert!(all.ends_with("|WCS:G55|H:1,7|T:0|TLR:0|FW:grblHAL>\n"), "{all}");
    let said = bench.say("$I+");
    assert!(said.contains("[AXS:3:XYZ]\n[NEWOPT:ENUMS,HOME,EXPR,TC,SD]\n[FIRMWARE:grblHAL]\n"), "{said}");
    assert!(bench.say("$EA").starts_with("[ALARMCODE:1||a limit switch]\n"));
    let errors = bench.say("$EE");
    assert!(errors.contains("\n[ERRORCODE:22||no feed rate]\n") && errors.ends_with("\nok\n"), "{errors}");
    let settings = bench.say("$ES");
    assert!(settings.contains("\n[SETTING:111|1|greatest rate Y|mm/min|6|#####0.000|||0|0]\n"), "{settings}");
    assert!(settings.ends_with("[SETTING:132|1|travel Z|mm|6|#####0.000|||0|0]\nok\n"), "{settings}");
    assert_eq!(bench.say("$EG"), "[SETTINGGROUP:1|0|Machine]\nok\n");
    assert!(bench.say("play part.nc").ends_with("ok\n"));
    bench.hear(1.0);
    assert!(bench.status().contains("|SD:"), "{}", bench.status());
}

#[test]
fn grbl_itself_says_nothing_of_grblhal() {
    let mut bench = start();
    bench.send(b"\x87");
    let said = bench.hear(0.05);
    assert_eq!(said, "", "a byte that it does not know");
    refused(&mut bench, "$ES", 3);
    refused(&mut bench, "$I+", 3);
}
