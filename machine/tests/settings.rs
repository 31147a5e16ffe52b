//! Settings that outlive a reset: M500 to M504, and the configuration file changed over a console.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

const SAVED: &str = "config-override";
const PREVIOUS: &str = "previous-config-override";

/// Everything that M500 can save is set to something of its own.
const CHANGES: [&str; 13] = [
    "M92 X81 E400",
    "M203 X120 Y130 Z14 P200",
    "M203.1 Z13",
    "M204 S1500 X900",
    "M205 X0.03 Z0.01 S2",
    "M207 S4 F1200 Z0.5 Q300",
    "M208 S0.25 F600",
    "M200 D1.75",
    "M900 K0.04",
    "M301 S254 P22 I1.5 D90 X120 Y200",
    "M307 S0 P40 C12 K0.1 F0.02 D1.5 H0.0021",
    "M143 S254 P110",
    "M206 X0.5 Y-0.25 Z1",
];

fn lines(bench: &mut Bench) -> Vec<String> {
    let shown = bench.say("M503");
    // Temporary settings are shown and not saved.
    let is_saved = |line: &&str| !["//", ";Not saved", "M665 S"].iter().any(|start| line.starts_with(start));
    shown.lines().filter(is_saved).map(str::to_owned).collect()
}

#[test]
fn what_m500_saves_is_what_m503_shows_and_what_the_next_boot_has() {
    let mut bench = Plan::new(CARTESIAN).with("config-override = false", "config-override = true").start();
    let factory = lines(&mut bench);
    for line in CHANGES {
        bench.say(line);
    }
    let changed = lines(&mut bench);
    assert!(changed.iter().zip(&factory).filter(|(a, b)| a != b).count() >= CHANGES.len() - 1, "{changed:#?}");
    assert_eq!(bench.say("M500"), "Settings Stored to /sd/config-override\nok\n");
    let saved = bench.read_card(SAVED).unwrap();
    assert_eq!(saved.lines().collect::<Vec<_>>(), changed[..changed.len() - 1], "all but the ok");
    assert_eq!(bench.read_card(PREVIOUS), None);
    let mut next =
        Plan::new(CARTESIAN).with("config-override = false", "config-override = true").file(SAVED, &saved).start();
    assert_eq!(lines(&mut next), changed);
    assert!(next.say("M503").starts_with("// NOTE: config override loaded\n"));
    let start = next.carriage(Alpha);
    next.run(&["G91", "G1 X80 F3000", "M400"]);
    let steps = (next.carriage(Alpha) - start) * 80.0;
    assert!((steps - 80.0 * 81.0).abs() < 1.5, "{steps} steps at 81 steps/mm");
}

#[test]
fn saved_settings_wait_for_m501_unless_the_configuration_wants_them_at_boot() {
    let mut bench = Plan::new(CARTESIAN).file(SAVED, ";Steps per unit:\nM92 X90\nM500\nM9999\nfan on\n").start();
    assert!(bench.say("M503").starts_with("// NOTE: No config override loaded\n"));
    assert!(bench.say("M92").starts_with("X:80.000000 "));
    let said = bench.say("M501");
    assert!(said.contains("// WARNING: nobody knows the saved setting: M9999\n"), "{said}");
    assert!(said.contains("// WARNING: not a saved setting, left out: fan on\n"), "{said}");
    assert!(said.ends_with("configuration override /sd/config-override loaded\nok\n"), "{said}");
    assert!(bench.say("M92").starts_with("X:90.000000 "));
    assert!(bench.read_card(SAVED).unwrap().contains("M9999"), "a saved M500 saves nothing");
    let warned = bench.say("M500");
    assert!(warned.starts_with("WARNING: override will NOT be loaded on boot\n"), "{warned}");
    assert_eq!(bench.say("M502"), "configuration override file deleted\nok\n");
    assert_eq!(bench.read_card(SAVED), None);
    assert!(bench.say("M92").starts_with("X:90.000000 "), "what runs stays until the reset");
    let said = bench.say("M501");
    assert!(said.starts_with("failed to load configuration override /sd/config-override: no such file\n"), "{said}");
}

/// As in Smoothieware v2, whose saved settings may hold any line.
#[test]
fn saved_settings_neither_save_nor_load_themselves() {
    for line in ["M500", "M501", "M502", "M503"] {
        let plan = Plan::new(CARTESIAN).with("config-override = false", "config-override = true");
        let content = format!("{line}\nM92 X100\n");
        let mut bench = plan.file(SAVED, &content).start();
        assert!(bench.say("M92").starts_with("X:100.0"), "{line}");
        assert_eq!(bench.read_card(SAVED), Some(content));
    }
}

#[test]
fn inches_are_no_trap_for_saved_settings() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["G20", "M500", "M501"] {
        bench.say(line);
    }
    assert!(bench.say("$G").contains(" G20 "));
    assert!(bench.say("M92").starts_with("X:80.000000 "));
}

#[test]
fn sets_of_settings_have_names() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M92 X70", "M504 pla", "M92 X75", "M504 abs"] {
        bench.say(line);
    }
    assert!(bench.read_card("config-override.pla").unwrap().contains("M92 X70.0"));
    bench.say("M501 pla");
    assert!(bench.say("M92").starts_with("X:70.000000 "));
    for line in ["M92 X65", "M504 petg with a 0.6 mm nozzle", "M92 X60", "M504 petg with a 0.8 mm nozzle"] {
        bench.say(line);
    }
    bench.say("M501 PETG with a 0.6 mm nozzle");
    assert!(bench.say("M92").starts_with("X:65.000000 "), "they differ late, and case is none");
    // Periods at the end do not count: it would be the file of M500. And sets are files, not paths.
    for name in [".", "pla.", "a/b", "a|b", &"x".repeat(240)] {
        let said = bench.say(&format!("M504 {name}"));
        assert!(said.contains("no file can") || said.contains("too long"), "{name}: {said}");
    }
    assert!(bench.read_card("config-override.pla").unwrap().contains("M92 X70.0"));
    assert_eq!(bench.read_card(SAVED), None);
}

#[test]
fn work_offsets_are_saved_when_the_configuration_says_so() {
    let config = |plan: Plan| {
        plan.with("must_be_homed = false", "save_wcs = true\nsave_g92 = true\nmust_be_homed = false")
            .with("config-override = false", "config-override = true")
    };
    let mut bench = config(Plan::new(CARTESIAN)).start();
    for line in ["G10 L2 P2 X10 Y20 Z-3 R30", "G55", "G92.3 X1.5", "M500"] {
        bench.say(line);
    }
    assert!(bench.read_card(SAVED).unwrap().contains("G10 L2 P2 X10.000000 Y20.000000 Z-3.000000 R30.000000 ; G55\n"));
    let mut next = config(Plan::new(CARTESIAN)).file(SAVED, &bench.read_card(SAVED).unwrap()).start();
    assert_eq!(next.say("$#"), bench.say("$#"));
    assert_eq!(next.say("M114"), bench.say("M114"));
}

/// Changes decided by `M500` before a power cut are finished at the next boot.
#[test]
fn a_change_that_a_power_cut_stopped_is_finished_at_boot() {
    let mut bench = Plan::new(CARTESIAN).start();
    for line in ["M92 X85", "M500"] {
        bench.say(line);
    }
    let content = bench.read_card(SAVED).unwrap();
    let on = |plan: Plan| plan.with("config-override = false", "config-override = true");
    let on_card = [("new-config-override", content.as_str()), (SAVED, "M92 X8\n"), (PREVIOUS, "M92 X7\n")];
    // The power went before the old file had its new name, and after.
    for left in [&on_card[..], &[on_card[0], (PREVIOUS, "M92 X8\n")]] {
        let mut next = left.iter().fold(on(Plan::new(CARTESIAN)), |plan, (name, text)| plan.file(name, text)).start();
        assert!(next.say("M92").starts_with("X:85.000000 "), "{left:?}");
        assert_eq!(next.read_card(SAVED).as_deref(), Some(content.as_str()));
        assert_eq!(next.read_card(PREVIOUS).as_deref(), Some("M92 X8\n"));
        assert_eq!(next.read_card("new-config-override"), None);
    }
    // A draft is nothing yet.
    let mut next = on(Plan::new(CARTESIAN)).file("draft-config-override", &content).start();
    assert!(next.say("M92").starts_with("X:80.000000 "));
}

#[test]
fn config_set_changes_one_line_and_keeps_the_rest() {
    let mut bench = Plan::new(CARTESIAN).start();
    let said = bench.ask("config-set \"motion control\" default_feed_rate = 2500");
    assert_eq!(said, "set config: [motion control] default_feed_rate = 2500\n");
    let changed =
        CARTESIAN.replace("default_feed_rate = 3000               # mm/min", "default_feed_rate = 2500  # mm/min");
    assert_eq!(bench.read_card("config.ini").as_deref(), Some(changed.as_str()));
    assert_eq!(bench.read_card("previous-config.ini").as_deref(), Some(CARTESIAN));
    assert_eq!(bench.read_card("draft-config.ini"), None);
    bench.ask("config-set conveyor queue_delay_time_ms");
    bench.ask("config-set planner z_junction_deviation 0.01");
    bench.ask("config-set \"kill button\" enable false");
    let expected = [
        ("conveyor", "queue_delay_time_ms", None),
        ("planner", "z_junction_deviation", Some("0.01")),
        ("kill button", "enable", Some("false")),
    ]
    .into_iter()
    .fold(changed, |text, (section, key, value)| {
        config::edit::apply(&text, config::edit::Edit { section, key, value })
    });
    assert_eq!(bench.read_card("config.ini"), Some(expected));
    let listed = bench.ask("config-get \"motion control\"");
    assert!(listed.starts_with("arm_solution = cartesian\ndefault_feed_rate = 2500\n"), "{listed}");
    assert!(!listed.contains('#') && !listed.contains("queue"), "{listed}");
}

#[test]
fn config_set_refuses_what_the_next_boot_would() {
    let mut bench = Plan::new(CARTESIAN).start();
    for (line, says) in [
        ("config-set planner junction_devation 0.1", "did you mean junction_deviation?"),
        ("config-set planer junction_deviation 0.1", "did you mean [planner]?"),
        ("config-set planner planner_queue_size many", "'many' is not a whole number"),
    ] {
        let said = bench.ask(line);
        assert!(said.starts_with("error:") && said.contains(says), "{line}: {said}");
        let checked = bench.ask(&line.replace("config-set", "config-set --check"));
        assert_eq!(checked, said, "{line}");
    }
    assert_eq!(bench.ask("config-set --check planner planner_queue_size 48"), "");
    assert_eq!(bench.ask("config-set planner"), "Usage: config-set section key [value]\n");
    assert_eq!(bench.read_card("config.ini").as_deref(), Some(CARTESIAN));
}

/// The file can be mended over the console that told what is wrong with it.
#[test]
fn a_machine_that_cannot_start_takes_config_set() {
    let mut bench = Plan::new(CARTESIAN).with("planner_queue_size = 32 ", "planner_queue_size = few ").start();
    assert!(bench.say("G28").contains("mend config.ini"));
    bench.ask("config-set planner planner_queue_size 32");
    let mended = bench.read_card("config.ini").unwrap();
    let mut next = Plan::new(&mended).start();
    assert_eq!(next.say("G28"), "ok\n");
}
