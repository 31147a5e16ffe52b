//! Tools in a spindle: their table on the card, read at boot, written by G10, in force by G43.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Gamma;

const TABLE: &str = "; my tools\nT1 P1 Z12.5 D6.0 ;end mill\nT2 Zlong\nT3 P3 Z-2 ;ball\n";

/// A mill with these tools.
fn mill(table: &str) -> Plan {
    Plan::new(CARTESIAN)
        .set("[extruder] hotend.enable = false")
        .with("grbl_mode = false", "grbl_mode = true")
        .file("tool.tbl", table)
}

/// Returns the travel of Z from its start.
fn z(bench: &Bench, begun: f64) -> f64 {
    bench.carriage(Gamma) - begun
}

#[test]
fn the_table_is_read_at_boot_and_its_flaws_are_named() {
    let mut bench = mill(TABLE).start();
    let greeting = bench.greeting();
    assert!(
        greeting.contains("/sd/tool.tbl, line 3 is left out: Z is not read here, or has a wrong value"),
        "{greeting}"
    );
    let begun = bench.carriage(Gamma);
    bench.run(&["M61 Q1", "G43", "G1 Z-10 F600", "G4 P0"]);
    assert!((z(&bench, begun) - 2.5).abs() < 0.02, "{}", z(&bench, begun));
    bench.run(&["G49", "G1 Z0", "G4 P0"]);
    assert!(z(&bench, begun).abs() < 0.02);
    let refused = bench.say("G43 H2");
    assert!(refused.contains("tool 2 is not in tool.tbl"), "{refused}");
}

#[test]
fn g10_writes_the_table_and_leaves_the_rest_as_it_is() {
    let mut bench = mill(TABLE).start();
    bench.run(&["G10 L1 P3 Z4.5 R2", "G10 L1 P7 X1"]);
    let written = bench.read_card("tool.tbl").unwrap();
    assert_eq!(written, TABLE.replace("T3 P3 Z-2 ;ball", "T3 P3 Z4.5 D4 ;ball") + "T7 X1\n");
    // Another hand has written it meanwhile.
    bench.write_card("tool.tbl", b"T9 Z1\n");
    bench.run(&["G10 L0", "G43 H9"]);
    assert!(bench.say("G43 H1").contains("tool 1 is not in tool.tbl"));
}

#[test]
fn a_job_writes_the_table_at_its_end() {
    let job = "G10 L1 P1 Z20\nG4 P0.5\nG43 H1\nG1 Z-19 F600\nM2\n";
    let mut bench = mill(TABLE).file("a.nc", job).start();
    let begun = bench.carriage(Gamma);
    bench.type_in("M32 a.nc\n");
    bench.hear(0.3);
    assert_eq!(bench.read_card("tool.tbl").as_deref(), Some(TABLE), "not while it is played");
    bench.hear_until("Done printing file", 10.0);
    assert!((z(&bench, begun) - 1.0).abs() < 0.02, "{}", z(&bench, begun));
    assert!(bench.read_card("tool.tbl").unwrap().contains("T1 P1 Z20 D6 ;end mill\n"));
}

#[test]
fn offsets_of_grbl_s_dialect_outlast_a_power_cycle() {
    let mut bench = mill(TABLE).start();
    bench.run(&["G10 L2 P2 X10 Y-5", "G10 L20 P1 Z7", "G28.1 X3 Y4", "G30.1 X0 Y0", "G10 L2 P3 R30"]);
    let kept = bench.read_card("parameters.var").unwrap();
    let mut again = mill(TABLE).file("parameters.var", &kept).start();
    let offsets = again.say("$#");
    assert!(offsets.contains("[G54:0.000,0.000,-7.000]") && offsets.contains("[G55:10.000,-5.000,0.000]"), "{offsets}");
    assert!(offsets.contains("[G28:3.000,4.000,"), "{offsets}");
    // A place of G30 at the origin is one, not none.
    assert!(kept.contains("\n5181\t0\n"), "{kept}");
    again.run(&["G28.3 X0 Y0 Z0", "$10=2", "G56", "G1 X10 F3000", "M400"]);
    assert!(again.status().contains("|WPos:10.000,0.000,"), "{}", again.status());
    again.run(&["$10=3"]);
    assert!(again.status().contains("|MPos:8.660,5.000,"), "{}", again.status());
    // Smoothieware's keeps them by M500.
    let mut other = Plan::new(CARTESIAN).file("parameters.var", &kept).start();
    let offsets = other.say("$#");
    assert!(offsets.contains("[G54:0."), "{offsets}");
    other.run(&["G10 L2 P2 X10"]);
    assert_eq!(other.read_card("parameters.var").unwrap(), kept);
}
