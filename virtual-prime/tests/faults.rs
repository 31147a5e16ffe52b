//! Velvet's image and everything that goes wrong with a machine: each fault gives one clear message and a
//! safe state.

use crate::common::velvet::{CONFIG, PROMPT, Plan, SECOND, Velvet};
use sim::world::Fault;
use units::Actuator;

/// What a machine that cannot be set up says after its reason, and answers to whoever wants it to move.
const LOCKED: &str = "error:the configuration has errors: mend config.ini and reset";

/// A machine without a usable configuration: this reason, once; nothing moves or heats, and the console
/// works.
#[track_caller]
fn stays_off(plan: Plan, reason: &str) -> Velvet {
    let mut velvet = plan.start();
    velvet.hear(2 * SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.said().matches(reason).count(), 1, "{reason:?} in: {}", velvet.said());
    assert_eq!(velvet.said().matches("There was a fatal error in the config.ini").count(), 1, "{}", velvet.said());
    let answer = velvet.ask("G28", SECOND);
    assert!(answer.contains(LOCKED), "{answer}");
    assert_eq!(velvet.world(|world| world.trace().total()), 0);
    velvet
}

#[test]
fn the_machine_listens_within_two_seconds_of_power_on() {
    let velvet = Plan::new().start();
    assert!(velvet.now_ms() < 2 * SECOND, "{} ms", velvet.now_ms());
}

#[test]
fn without_a_card_it_asks_for_one() {
    stays_off(
        Plan::new().without_card(),
        "ERROR: cannot read /sd/config.ini: no SD card found: insert a card and reset\n",
    );
}

#[test]
fn a_card_without_a_file_system_is_to_be_formatted() {
    let blank = |mut card: Vec<u8>| {
        card.fill(0);
        card
    };
    stays_off(
        Plan::new().with_card(blank),
        "ERROR: cannot read /sd/config.ini: the SD card has no FAT file system: format it as FAT32\n",
    );
}

#[test]
fn a_card_without_configuration_is_named() {
    let other = |_| virtual_prime::sd_image::build(None, &[("part.g".into(), b"G28\n".to_vec())]).expect("a volume");
    let mut velvet = stays_off(Plan::new().with_card(other), "ERROR: cannot read /sd/config.ini: no such file\n");
    velvet.assert_card_listed("part.g");
}

/// Has the directory say that config.ini begins at this cluster.
fn misplace_config(card: &mut [u8], cluster: u32) {
    let entry = card.chunks(32).position(|entry| entry.starts_with(b"CONFIG  INI")).expect("a directory entry") * 32;
    let [a, b, c, d] = cluster.to_le_bytes();
    // The first cluster's number: high half at 20, low half at 26.
    card[entry + 20..entry + 22].copy_from_slice(&[c, d]);
    card[entry + 26..entry + 28].copy_from_slice(&[a, b]);
}

#[test]
fn a_damaged_file_system_is_told() {
    let misplaced = |mut card: Vec<u8>| {
        // The volume has no such cluster.
        misplace_config(&mut card, 0x00F0_0000);
        card
    };
    let mut velvet = stays_off(
        Plan::new().with_card(misplaced),
        "ERROR: cannot read /sd/config.ini: the SD card's file system is damaged: check the card on a computer\n",
    );
    velvet.assert_card_listed("config.ini");
}

/// A card with fewer blocks than its volume, and config.ini in the missing ones: reading it is an error of
/// the card.
fn cut_off_config(mut card: Vec<u8>) -> Vec<u8> {
    const FIRST: u32 = 100_000;
    misplace_config(&mut card, FIRST);
    // Reserved blocks; blocks of a table at 36, of which there are two.
    let reserved = usize::from(u16::from_le_bytes([card[14], card[15]]));
    let table = u32::from_le_bytes([card[36], card[37], card[38], card[39]]) as usize;
    // A cluster is a block. The chain is longer than the file.
    assert_eq!(card[13], 1);
    for (cluster, next) in (FIRST..FIRST + 32).map(|cluster| (cluster as usize, cluster + 1)) {
        for copy in [reserved, reserved + table] {
            card[copy * 512 + cluster * 4..][..4].copy_from_slice(&next.to_le_bytes());
        }
    }
    for copy in [reserved, reserved + table] {
        card[copy * 512 + (FIRST as usize + 32) * 4..][..4].copy_from_slice(&0x0FFF_FFFF_u32.to_le_bytes());
    }
    card.truncate(32 << 20);
    card
}

#[test]
fn a_configuration_that_cannot_be_read_is_told() {
    let mut velvet = stays_off(
        Plan::new().with_card(cut_off_config),
        "ERROR: cannot read /sd/config.ini: the SD card reports a read or write error\n",
    );
    velvet.assert_card_listed("config.ini");
}

#[test]
fn a_second_core_that_is_set_to_start_is_told_with_what_to_do() {
    const TOLD: &str = "set the option byte BCM4 to 0";
    let mut velvet = Plan::new().with_second_core().start();
    assert!(velvet.said().contains(TOLD), "{}", velvet.said());
    // The machine works all the same.
    assert!(velvet.ask("M119", SECOND).contains("ok"));
    let without = Plan::new().start();
    assert!(!without.said().contains(TOLD), "{}", without.said());
}

#[test]
fn an_unknown_key_is_located() {
    let plan = Plan::new().with("alpha.max_rate = 18000", "alpha.max_rat = 18000");
    let line = 1 + CONFIG.lines().position(|line| line.starts_with("alpha.max_rate")).expect("the sample has it");
    let told = format!("config.ini: line {line}, column 1: fatal: alpha.max_rat: [actuator] has no setting 'max_rat'");
    let mut velvet = stays_off(plan, &told);
    velvet.assert_card_listed("config.ini");
}

#[test]
fn an_impossible_value_is_located() {
    let plan = Plan::new().with("alpha.steps_per_mm = 80 ", "alpha.steps_per_mm = eighty ");
    let mut velvet = stays_off(plan, "config.ini: line ");
    assert!(velvet.said().contains("alpha.steps_per_mm"), "{}", velvet.said());
    velvet.assert_card_listed("config.ini");
}

/// A fault of the hot end's or the bed's sensor, before heating or while it goes on.
#[track_caller]
fn sensor_fault(fault: Fault, heat: &str, before: bool, told: &str) {
    let mut velvet = Plan::new().start();
    if before {
        velvet.inject(&fault);
    }
    velvet.ask(heat, SECOND);
    if !before {
        velvet.hear(2 * SECOND);
        velvet.inject(&fault);
    }
    velvet.hear_until(told, 3 * SECOND);
    velvet.assert_safe();
    velvet.assert_told_once(told);
    velvet.assert_card_listed("config.ini");
}

const NO_HOT_END: &str = "ERROR: MINTEMP or MAXTEMP triggered on T";
const NO_BED: &str = "ERROR: MINTEMP or MAXTEMP triggered on B";

#[test]
fn a_thermistor_open_before_heating_keeps_the_heater_off() {
    sensor_fault(Fault::ThermistorOpen("hotend".into()), "M104 S200", true, NO_HOT_END);
}

#[test]
fn a_thermistor_shorted_before_heating_keeps_the_heater_off() {
    sensor_fault(Fault::ThermistorShort("bed".into()), "M140 S60", true, NO_BED);
}

#[test]
fn a_thermistor_that_opens_while_heating_halts() {
    sensor_fault(Fault::ThermistorOpen("bed".into()), "M140 S60", false, NO_BED);
}

#[test]
fn a_thermistor_that_shorts_while_heating_halts() {
    sensor_fault(Fault::ThermistorShort("hotend".into()), "M104 S200", false, NO_HOT_END);
}

#[test]
fn a_thermistor_that_opens_during_m109_ends_the_job_there() {
    let mut velvet = Plan::new().file("last.g", "M109 S200\n").start();
    velvet.ask("M23 last.g", SECOND);
    velvet.type_in("M24");
    velvet.hear(2 * SECOND);
    velvet.inject(&Fault::ThermistorOpen("hotend".into()));
    velvet.hear_until(NO_HOT_END, 3 * SECOND);
    velvet.assert_safe();
    assert!(!velvet.said().contains("Done printing"), "{}", velvet.said());
    velvet.assert_told_once(NO_HOT_END);
}

#[test]
fn a_driver_silent_from_power_on_is_named_and_nothing_moves() {
    let mut velvet = Plan::new().fault("driver-silent:beta").start();
    velvet.hear(3 * SECOND);
    velvet.assert_told_once("ERROR: motor driver beta does not answer, check its supply and SPI wiring\n");
    velvet.type_in("G1 X10 Y10 F600");
    velvet.hear_until("Error: motor driver beta does not answer", SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.world(|world| world.trace().total()), 0);
    velvet.assert_card_listed("config.ini");
}

#[test]
fn a_driver_that_falls_silent_while_moving_halts() {
    let mut velvet = Plan::new().start();
    velvet.type_in("G1 X100 F600");
    velvet.hear(500);
    velvet.inject(&Fault::DriverSilent(Actuator::Alpha));
    let told = "ERROR: motor driver X: driver does not answer, check its supply and SPI wiring";
    velvet.hear_until(told, 4 * SECOND);
    velvet.assert_safe();
    velvet.assert_told_once(told);
}

#[test]
fn an_end_switch_that_never_closes_ends_the_search() {
    // Short travels, so that the search is short: the switch is 30 mm away, and the frame 3 mm behind it.
    let plan = Plan::new().with("minx.max_travel = 220 ", "minx.max_travel = 32 ");
    let mut velvet = plan.fault("switch-never:minx").start();
    velvet.type_in("G28 X0");
    let told = "endstop was not reached within its travel";
    velvet.hear_until(told, 5 * SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.said().matches(told).count(), 1, "{}", velvet.said());
    velvet.assert_card_listed("config.ini");
}

#[test]
fn an_end_switch_that_is_stuck_is_noticed() {
    let mut velvet = Plan::new().fault("switch-always:minx").start();
    velvet.type_in("G28 X0");
    let told = "endstop does not open when backed off: stuck, or wired inverted";
    velvet.hear_until(told, 5 * SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.said().matches(told).count(), 1, "{}", velvet.said());
    assert_eq!(velvet.world(|world| world.lost_mm(Actuator::Alpha)), 0.0, "the carriage was pushed against its stop");
}

#[test]
fn missing_motor_supply_is_told_and_nothing_moves() {
    let mut velvet = Plan::new().fault("motor-supply:0").start();
    velvet.hear(3 * SECOND);
    velvet.assert_told_once("WARNING: motor supply is off (vmotor below 6 V)");
    velvet.type_in("G28");
    velvet.hear_until("Error: motor supply is off (vmotor below 6 V): switch it on, then M999", SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.world(|world| world.trace().total()), 0);
    velvet.assert_card_listed("config.ini");
}

#[test]
fn motor_supply_lost_while_moving_halts() {
    let mut velvet = Plan::new().start();
    velvet.type_in("G1 X100 F600");
    velvet.hear(500);
    velvet.inject(&Fault::MotorSupply(0.5));
    let told = "ERROR: motor supply lost while moving";
    velvet.hear_until(told, 3 * SECOND);
    velvet.assert_safe();
    velvet.assert_told_once(told);
}

#[test]
fn missing_heater_supply_is_told_and_nothing_heats() {
    let mut velvet = Plan::new().fault("fet-supply:0").start();
    velvet.hear(4 * SECOND);
    velvet.assert_told_once("WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing\n");
    velvet.type_in("M104 S200");
    velvet.hear_until("Error: heater supply is off (vfet below 6 V): switch it on, then M999", SECOND);
    velvet.assert_safe();
    velvet.assert_card_listed("config.ini");
}

#[test]
fn heater_supply_lost_while_heating_halts() {
    let mut velvet = Plan::new().start();
    velvet.ask("M104 S200", SECOND);
    velvet.hear(SECOND);
    velvet.inject(&Fault::FetSupply(0.0));
    let told = "ERROR: heater supply lost while heating (vfet below 6 V)";
    velvet.hear_until(told, 4 * SECOND);
    velvet.assert_safe();
    velvet.assert_told_once(told);
}

#[test]
fn a_heater_that_is_on_by_itself_loses_its_supply() {
    let mut velvet = Plan::new().start();
    velvet.inject(&Fault::HeaterStuckOn("hotend".into()));
    let told = "ERROR: T is switched off and has warmed by ";
    velvet.hear_until(told, 12 * SECOND);
    assert_eq!(velvet.world(|world| world.vfet_v()), 0.0, "the heaters' supply is on");
    velvet.assert_safe();
    velvet.assert_told_once(told);
}

#[test]
fn the_watchdog_ends_a_firmware_that_hangs_and_the_machine_comes_back_cold() {
    let elf = crate::common::hang::image_that_hangs_in("report_status");
    let mut velvet = Plan::new().image(elf.clone()).start();
    // It is in the board's flash now.
    let _ = std::fs::remove_file(elf);
    velvet.ask("M104 S200", SECOND);
    velvet.hear(SECOND);
    let heater = velvet.world(|world| world.heater_index("hotend")).expect("the sample has one");
    assert!(velvet.world(|world| world.heater_mean_duty(heater)) > 0.3, "the heater is not on");
    let greeted = velvet.said().len();
    velvet.bench.console.send(b"?");
    velvet.hear_until(PROMPT, 7 * SECOND);
    let said = velvet.said()[greeted..].to_owned();
    let told = "WARNING: the watchdog reset the board: the firmware had stopped answering\n";
    assert_eq!(said.matches(told).count(), 1, "{said}");
    // The duty's mean forgets within seconds; the target is gone for good.
    velvet.hear(5 * SECOND);
    assert!(velvet.world(|world| world.heater_mean_duty(heater)) < 0.01, "the heater is on again");
    velvet.type_in("M105");
    let answer = velvet.hear_until("T:", SECOND) + &velvet.hear(100);
    assert!(answer.contains("/0.0 @0"), "{answer}");
}

/// The interrupts that run the planner and the watch over drivers and supplies: what they would do is not
/// done, and everything else goes on.
#[test]
fn the_watchdog_misses_the_planner_and_the_slow_watch_too() {
    for interrupt in ["LPTIM1", "LPTIM2"] {
        let elf = crate::common::hang::image_that_skips(interrupt);
        let mut velvet = Plan::new().image(elf.clone()).start();
        // It is in the board's flash now.
        let _ = std::fs::remove_file(elf);
        velvet.hear_until("WARNING: the watchdog reset the board: the firmware had stopped answering\n", 6 * SECOND);
    }
}

/// A machine on its way along X, 122 us from step to step, that keeps all interrupts off for twice so many
/// instructions whenever it is asked for its status.
fn masking(loops: u16) -> Velvet {
    let elf = crate::common::hang::image_that_masks_interrupts_in("report_status", loops);
    let mut velvet = Plan::new().image(elf.clone()).start();
    // It is in the board's flash now.
    let _ = std::fs::remove_file(elf);
    velvet.ask("G28.3 X30 Y30 Z30", SECOND);
    velvet.type_in("G1 X130 F6131");
    velvet.hear(300);
    velvet
}

fn x_mm(velvet: &mut Velvet) -> f64 {
    velvet.world(|world| world.carriage_mm(units::Actuator::Alpha)).expect("a motor")
}

#[test]
fn steps_that_come_late_are_told_and_all_made() {
    // 60 us: a step in two is caught by it, and the next is on time.
    let mut velvet = masking(12_000);
    for _ in 0..10 {
        velvet.bench.console.send(b"?");
        velvet.hear(30);
    }
    let said = velvet.ask("get steps", SECOND);
    assert!(velvet.said().contains("WARNING: 1 steps came late, by up to "), "{}", velvet.said());
    assert!(said.contains("delayed: 0\n"), "{said}");
    velvet.hear(2 * SECOND);
    assert!((x_mm(&mut velvet) - 130.0).abs() < 1e-6);
}

#[test]
fn steps_that_come_too_late_for_the_driver_halt_and_none_is_lost() {
    // 250 us: several steps of the motor are due at once.
    let mut velvet = masking(50_000);
    velvet.bench.console.send(b"?");
    let said = velvet.hear(500);
    let told = "had to be delayed for their driver";
    assert_eq!(said.matches(told).count(), 1, "{said}");
    velvet.assert_told_once(told);
    velvet.assert_safe();
    velvet.type_in("M114.2");
    let (real, said) = (x_mm(&mut velvet), velvet.hear(100));
    let x = said.split("X:").nth(1).and_then(|rest| rest.split(' ').next()).and_then(|x| x.parse::<f64>().ok());
    assert!(x.is_some_and(|x| (x - real).abs() < 0.01 && x < 125.0), "{said}, but it is at {real} mm");
    let closest = velvet.world(|world| {
        let edges: Vec<_> = world.trace().edges().iter().map(|edge| edge.time_ns).collect();
        edges.windows(2).map(|pair| pair[1] - pair[0]).min()
    });
    assert!(closest.is_some_and(|ns| ns >= 100), "two edges of one motor {closest:?} ns apart");
}
