//! External drivers, set up and asked by the image: over both SPI buses, and over an auxiliary UART.

use sim::world::Fault;
use units::Actuator::{self, Alpha, Delta, Epsilon, Zeta};

use crate::common::velvet::{Plan, SECOND, Velvet};

/// Adds a motor with such a driver: 10 full steps a millimetre, 16 microsteps.
fn motor(plan: Plan, name: &str, kind: &str, pins: [&str; 2], own: &[&str]) -> Plan {
    let lines = [
        format!("[actuator] {name}.driver = {kind}"),
        format!("[actuator] {name}.steps_per_mm = 160"),
        format!("[actuator] {name}.microsteps = 16"),
        format!("[actuator] {name}.max_rate = 6000"),
        format!("[actuator] {name}.step_pin = {}", pins[0]),
        format!("[actuator] {name}.dir_pin = {}", pins[1]),
    ];
    let own = own.iter().map(|line| format!("[{kind}] {name}.{line}"));
    lines.into_iter().chain(own).fold(plan, |plan, line| plan.set(&line))
}

fn machine() -> Plan {
    Plan::new().set("[extruder] hotend.enable = false").set("[actuator] common.halt_on_driver_alarm = false")
}

fn word(velvet: &mut Velvet, motor: Actuator, register: u8) -> u32 {
    velvet.world(|world| world.outside_driver(motor).expect("a driver outside").register(register))
}

#[track_caller]
fn assert_words(velvet: &mut Velvet, motor: Actuator, words: &[(u8, u32)]) {
    for (register, expected) in words {
        let is = word(velvet, motor, *register);
        assert_eq!(is, *expected, "{} {register:02x} is {is:08x}: {}", motor.name(), velvet.said());
    }
}

#[track_caller]
fn assert_at(velvet: &mut Velvet, motor: Actuator, mm: f64) {
    let place = velvet.world(|world| world.carriage_mm(motor).expect("a carriage"));
    assert!((place - mm).abs() < 0.01, "{}: {place} mm, not {mm}: {}", motor.name(), velvet.said());
}

/// Asserts that the motors are set up and move, that a driver is set up again after a reset, and that a
/// silent driver is reported.
fn work(mut velvet: Velvet, words: [&[(u8, u32)]; 3]) {
    let said = velvet.hear(SECOND);
    assert!(!said.contains("ERROR") && !velvet.said().contains("does not answer"), "{}", velvet.said());
    velvet.ask("G91", SECOND);
    velvet.ask("G1 A5 B3 C2 F600", SECOND);
    velvet.ask("M400", 5 * SECOND);
    for (motor, words) in [Delta, Epsilon, Zeta].into_iter().zip(words) {
        assert_words(&mut velvet, motor, words);
    }
    assert_at(&mut velvet, Delta, 5.0);
    assert_at(&mut velvet, Epsilon, 3.0);
    assert_at(&mut velvet, Zeta, 2.0);
    velvet.inject(&Fault::DriverReset(Delta));
    velvet.hear_until("WARNING: A: the driver was without power", 1_500);
    velvet.ask("G1 A5 F600", SECOND);
    velvet.ask("M400", 5 * SECOND);
    assert_words(&mut velvet, Delta, words[0]);
    assert_at(&mut velvet, Delta, 10.0);
    velvet.inject(&Fault::DriverSilent(Epsilon));
    let said = velvet.hear_until("WARNING: B: driver does not answer, check its supply and wiring", 3 * SECOND);
    assert!(!said.contains("WARNING: A"), "{said}");
    assert_eq!(velvet.world(|world| world.timing_faults()), 0);
    let wrong: Vec<String> = velvet
        .bench
        .vm
        .with(|stopped| stopped.session.board().wrong_modes().cloned().collect())
        .expect("a running board");
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// TMC5160, GLOBALSCALER 256 * 2 A * 0.075 Ohm / 0.325 V = 118.2, IRUN 31; CHOPCONF the datasheet's example
/// with MRES 4 and TPFD 4. TMC2130, 32 * 1.2 A * 0.13 Ohm / 0.18 V - 1 = 26.7, with vsense. TMC2240, 2 A are
/// the smallest range above 1.5 A: GLOBALSCALER 256 * 1.5 / 2 = 192.
#[test]
fn over_either_spi_bus_they_are_set_up_as_their_datasheets_say() {
    let plan = motor(machine(), "delta", "tmc5160", ["PJ5", "PJ1"], &["spi_cs_pin = PJ9", "sense_resistor = 75"]);
    let plan = motor(plan, "epsilon", "tmc2130", ["PJ7", "PJ8"], &["spi_cs_pin = PD10", "sense_resistor = 110"]);
    let plan = motor(plan, "zeta", "tmc2240", ["PG1", "PJ2"], &["spi_cs_pin = PJ10", "reference_resistor = 12000"])
        .set("[tmc2130] common.spi_channel = 0")
        .set("[current control] delta.current = 2")
        .set("[current control] epsilon.current = 1.2")
        .set("[current control] zeta.current = 1.5");
    let of_5160 = [(0x00, 0x08), (0x0B, 118), (0x10, 0x0006_1F1F), (0x6C, 0x0441_00C3), (0x70, 0xC40C_001E)];
    let of_2130 = [(0x00, 0), (0x10, 0x0006_1B1B), (0x6C, 0x0403_00C3), (0x70, 0x0005_0480)];
    let of_2240 = [(0x0A, 1), (0x0B, 192), (0x10, 0x0006_1F1F), (0x6C, 0x0441_00C3), (0x70, 0xC40C_001D)];
    work(plan.start(), [&of_5160, &of_2130, &of_2240]);
}

/// TMC2209, 32 * 0.9 A * 0.13 Ohm / 0.18 V - 1 = 19.8, and for 0.5 A 10.6, with vsense; SENDDELAY 2. The
/// TMC2208 has the other UART for itself.
#[test]
fn over_a_uart_of_one_wire_they_are_set_up_by_their_addresses() {
    let plan = machine().set("[uart console] enable = false");
    let plan = motor(plan, "delta", "tmc2209", ["PJ5", "PJ1"], &["uart_address = 3", "sense_resistor = 110"]);
    let plan = motor(plan, "epsilon", "tmc2209", ["PJ7", "PJ8"], &["uart_address = 0", "sense_resistor = 110"]);
    let plan = motor(plan, "zeta", "tmc2208", ["PG1", "PJ2"], &["sense_resistor = 110"])
        .set("[tmc2209] common.uart_channel = 1")
        .set("[current control] delta.current = 0.9")
        .set("[current control] epsilon.current = 0.5")
        .set("[current control] zeta.current = 0.9");
    let words = |scale: u32| {
        [(0x00, 0x1C4), (0x01, 0), (0x03, 0x200), (0x10, 0x6 << 16 | scale << 8 | scale), (0x6C, 0x0403_00C3)]
    };
    work(plan.start(), [&words(20), &words(11), &words(20)]);
}

/// The driver's DIAG stops the motor, with the current of the search and stealthChop, which its load
/// measurement needs; both are put back.
#[test]
fn x_homes_by_the_stall_output_of_a_driver_on_a_uart() {
    let plan = [
        "[tmc2590] alpha.spi_cs_pin",
        "[tmc2590] alpha.sense_resistor",
        "[tmc2590] alpha.max_current",
        "[tmc2590] alpha.step_interpolation",
        "[actuator] alpha.driver = tmc2209",
        "[actuator] alpha.step_pin = PJ5",
        "[actuator] alpha.dir_pin = PJ1",
        "[tmc2209] common.uart_channel = 1",
        "[tmc2209] alpha.sense_resistor = 110",
        "[endstops] minx.pin = PG0",
        "[endstops] minx.slow_rate",
        "[endstops] minx.stall_homing = true",
        "[endstops] minx.stall_current = 0.8",
        "[endstops] minx.stall_threshold = 30",
    ];
    let mut velvet = plan.iter().fold(Plan::new(), |plan, line| plan.set(line)).start();
    let before = [0x00, 0x10, 0x14, 0x40].map(|register| word(&mut velvet, Alpha, register));
    velvet.ask("G28 X0", 20 * SECOND);
    let place = velvet.world(|world| world.carriage_mm(Alpha).expect("a carriage"));
    assert!((place - 5.0).abs() < 0.4, "{place} mm: {}", velvet.said());
    assert_eq!([0x00, 0x10, 0x14, 0x40].map(|register| word(&mut velvet, Alpha, register)), before);
}

/// Signal DIAG is on the input that `stall_pin` names: high for a stall of a TMC2209, low for a stall of a
/// TMC5160.
#[test]
fn a_crash_of_a_motor_with_a_driver_outside_is_seen() {
    let of_2209 = ["[tmc2209] alpha.sense_resistor = 110", "[tmc2209] alpha.stall_pin = PG0"];
    let more_2209 = ["[tmc2209] alpha.stealthchop_threshold = 300", "[tmc2209] alpha.stall_threshold = 10"];
    let of_5160 = ["[tmc5160] alpha.sense_resistor = 75", "[tmc5160] alpha.stall_pin = PG1!"];
    let more_5160 = ["[tmc5160] alpha.spi_cs_pin = PJ9", "[tmc5160] alpha.stall_threshold = 2"];
    for (kind, own) in [("tmc2209", [of_2209, more_2209]), ("tmc5160", [of_5160, more_5160])] {
        let plan = [
            "[uart console] enable = false",
            "[tmc2590] alpha.spi_cs_pin",
            "[tmc2590] alpha.sense_resistor",
            "[tmc2590] alpha.max_current",
            "[tmc2590] alpha.step_interpolation",
            "[actuator] alpha.step_pin = PJ5",
            "[actuator] alpha.dir_pin = PJ1",
        ];
        let plan = plan.iter().chain(own.iter().flatten()).fold(Plan::new(), |plan, line| plan.set(line));
        let plan = plan.set(&format!("[actuator] alpha.driver = {kind}"));
        let mut velvet = plan.set(&format!("[{kind}] alpha.stall_watch = true")).start();
        velvet.ask("G91", SECOND);
        velvet.ask("G1 X30 F6000", SECOND);
        velvet.ask("M400", 5 * SECOND);
        assert!(!velvet.said().contains("stalls"), "{kind}: it is free: {}", velvet.said());
        let place = velvet.world(|world| world.carriage_mm(Alpha).expect("a carriage"));
        velvet.world(move |world| world.obstruct(Alpha, [place - 100.0, place + 10.0]));
        velvet.type_in("G1 X30 F6000");
        velvet.hear_until("ERROR: motor X stalls", SECOND);
    }
}
