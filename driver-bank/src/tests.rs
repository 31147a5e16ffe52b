//! Tests with models of the chips at their ports: frames of 20 bits in 24 (TMC2590), datagrams of 40 bits
//! (TMC5160).

extern crate std;

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use std::rc::Rc;
use std::string::String;

use base::ports::{Coil, Description, DriverFault, MotorDrivers, StallSearch};
use config::{BoardId, MachineConfig};
use embedded_hal::digital::{ErrorType as PinError, OutputPin};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use units::Actuator::{Alpha, Beta, Delta, Gamma};
use units::{Amps, Ohms, Volts};

use super::*;

/// Registers of a chip, and what it answers.
struct Model {
    /// By the address of the register.
    words: [u32; 128],
    /// Bits 0 to 19 of each answer of a TMC2590, but for the reading.
    flags: u32,
    /// Reading of a TMC2590 other than its detectors.
    reading: u32,
    asked: usize,
    is_dead: bool,
}

impl Default for Model {
    fn default() -> Self {
        Self { words: [0; 128], flags: 0, reading: 0, asked: 0, is_dead: false }
    }
}

/// A chip select with a chip behind it.
#[derive(Clone, Default)]
struct Select(Rc<RefCell<Model>>);

impl ErrorType for Select {
    type Error = Infallible;
}

impl SpiDevice for Select {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut model = self.0.borrow_mut();
        for operation in operations {
            let Operation::TransferInPlace(bytes) = operation else { panic!("another operation") };
            match &mut **bytes {
                bytes if model.is_dead => bytes.fill(0),
                [a, b, c] => {
                    let sent = u32::from_be_bytes([0, *a & 0xF, *b, *c]);
                    let reading = if model.words[7] >> 4 & 3 == 3 { 3 << 8 } else { model.reading << 10 };
                    // The frame's first four bits pass through the chip.
                    let answer = (reading | model.flags) << 4 | u32::from(*a >> 4);
                    [_, *a, *b, *c] = answer.to_be_bytes();
                    // DRVCTRL is addressed by two bits only.
                    let address = if sent >> 18 == 0 { 0 } else { sent >> 17 };
                    model.words[address as usize] = sent & 0x1_FFFF;
                }
                [address, data @ ..] => {
                    let (place, is_write) = (usize::from(*address & 0x7F), *address & 0x80 != 0);
                    let sent = u32::from_be_bytes((&*data).try_into().expect("40 bits"));
                    data.copy_from_slice(&model.words[model.asked].to_be_bytes());
                    *address = 0;
                    match place {
                        1 => model.words[1] &= !sent,
                        place if is_write => model.words[place] = sent,
                        _ => {}
                    }
                    model.asked = place;
                }
                [] => {}
            }
        }
        Ok(())
    }
}

impl Select {
    fn word(&self, address: usize) -> u32 {
        self.0.borrow().words[address]
    }
}

/// A UART that no chip of these tests is on.
#[derive(Debug)]
enum NoLine {}

impl SingleWire for NoLine {
    type Error = Infallible;

    fn exchange(&mut self, _: &[u8], _: &mut [u8]) -> Result<(), WireFault<Infallible>> {
        match *self {}
    }
}

/// An enable output.
#[derive(Clone, Default)]
struct Pin(Rc<Cell<bool>>);

impl PinError for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

const CHOPCONF: usize = 4;
const SGCSCONF: usize = 6;
/// Registers of a TMC5160.
const OUTSIDE_VERSION: usize = 0x04;
const OUTSIDE_CHOPCONF: usize = 0x6C;

const MACHINE: &str = "
[actuator]
alpha.steps_per_mm = 80
alpha.microsteps = 16
beta.steps_per_mm = 80
gamma.steps_per_mm = 400
delta.steps_per_mm = 160
delta.microsteps = 16
delta.driver = tmc5160
delta.step_pin = PJ5
delta.dir_pin = PJ1
[tmc2590]
alpha.sense_resistor = 50
alpha.max_current = 2000
[tmc5160]
delta.spi_cs_pin = PJ9
delta.sense_resistor = 75
delta.max_current = 2500
[current control]
alpha.current = 1.2
delta.current = 2
";

fn machine() -> MachineConfig {
    config::parse(MACHINE.as_bytes(), BoardId::Prime2590, &mut ()).0
}

/// A chip on the board (Alpha), a driver with an enable pin (Gamma), one with a chip (Delta), and none
/// (Beta); set up and initialised.
struct Bench {
    bank: DriverBank<Select, NoLine, Pin>,
    chip: Select,
    outside: Select,
    gamma: Pin,
    delta: Pin,
}

impl Bench {
    fn new() -> Self {
        let (config, mut bank) = (machine(), DriverBank::default());
        let (chip, outside) = (Select::default(), Select::default());
        let (gamma, delta) = (Pin::default(), Pin::default());
        outside.0.borrow_mut().words[OUTSIDE_VERSION] = 0x30 << 24;
        let settings = config.driver(Alpha).expect("a chip on the board");
        bank.0[Alpha] = set_up(chip.clone(), &config.actuators[Alpha], settings).expect("settings of the chip");
        bank.0[Gamma] = MotorDriver::External(gamma.clone());
        let bus = OutsideBus::Spi(SpiRegisters(outside.clone()));
        bank.0[Delta] = set_up_outside(bus, Some(delta.clone()), &config, Delta).expect("settings of the chip");
        bank.initialise(Alpha).expect("a chip that answers");
        bank.initialise(Delta).expect("a chip that answers");
        Self { bank, chip, outside, gamma, delta }
    }

    fn described(&mut self, motor: Actuator) -> String {
        let mut text = String::new();
        self.bank.describe(motor, Description::Everything, &mut text).expect("room");
        text
    }
}

fn is_near(current: Option<Amps>, wanted: f32) -> bool {
    current.is_some_and(|current| (current.0 / wanted - 1.0).abs() < 0.05)
}

#[test]
fn settings_reach_both_kinds_of_chips_with_the_bridges_off() {
    let bench = Bench::new();
    assert_eq!(bench.chip.word(0) & 0x30F, 0x104, "double edges, 16 microsteps");
    assert_eq!(bench.chip.word(CHOPCONF) & 15, 0);
    assert_eq!(bench.outside.word(OUTSIDE_CHOPCONF) >> 24 & 15, 4, "16 microsteps");
    assert_eq!(bench.outside.word(OUTSIDE_CHOPCONF) & 15, 0);
    assert!(is_near(bench.bank.current(Alpha), 1.2) && is_near(bench.bank.current(Delta), 2.0));
    assert!(!bench.delta.0.get());
}

#[test]
fn bridges_and_enable_outputs_are_switched() {
    let mut bench = Bench::new();
    for motor in [Alpha, Gamma, Delta] {
        bench.bank.set_enabled(motor, true).expect("a driver");
    }
    assert!(bench.chip.word(CHOPCONF) & 15 != 0 && bench.outside.word(OUTSIDE_CHOPCONF) & 15 != 0);
    assert!(bench.gamma.0.get() && bench.delta.0.get());
    for motor in [Alpha, Gamma, Delta] {
        bench.bank.set_enabled(motor, false).expect("a driver");
    }
    assert!(bench.chip.word(CHOPCONF) & 15 == 0 && bench.outside.word(OUTSIDE_CHOPCONF) & 15 == 0);
    assert!(!bench.gamma.0.get() && !bench.delta.0.get());
}

#[test]
fn a_driver_without_a_chip_has_nothing_to_set_or_read() {
    let mut bench = Bench::new();
    assert_eq!(bench.bank.set_enabled(Beta, true), Err(DriverFault::External), "no driver, no pin");
    for motor in [Beta, Gamma] {
        assert_eq!(bench.bank.initialise(motor), Err(DriverFault::External));
        assert_eq!(bench.bank.set_current(motor, Amps(1.0)), Err(DriverFault::External));
        assert_eq!(bench.bank.current(motor), None);
        assert!(matches!(bench.bank.status(motor), Err(DriverFault::External)));
        assert_eq!(bench.bank.reserve(motor), Err(DriverFault::External));
        assert_eq!(bench.bank.set_option(motor, 4, &|_| Some(1.0)), Err(DriverFault::External));
        assert_eq!(bench.described(motor), "external driver\n");
    }
}

#[test]
fn a_current_above_the_ceiling_is_the_ceiling() {
    let mut bench = Bench::new();
    assert!(is_near(bench.bank.set_current(Alpha, Amps(1.0)).ok(), 1.0));
    assert!(is_near(bench.bank.set_current(Alpha, Amps(9.0)).ok(), 2.0));
    assert!(is_near(bench.bank.set_current(Delta, Amps(9.0)).ok(), 2.5));
    let search = StallSearch { current: Some(Amps(9.0)), threshold: 3 };
    bench.bank.begin_stall_search(Alpha, search).expect("a chip");
    assert!(is_near(bench.bank.current(Alpha), 2.0));
}

#[test]
fn a_chip_without_supply_is_silent_and_its_enable_output_stays_off() {
    let mut bench = Bench::new();
    bench.chip.0.borrow_mut().is_dead = true;
    bench.outside.0.borrow_mut().is_dead = true;
    for motor in [Alpha, Delta] {
        assert_eq!(bench.bank.set_enabled(motor, true), Err(DriverFault::Silent));
        assert_eq!(bench.bank.status(motor).map(drop), Err(DriverFault::Silent));
    }
    assert!(!bench.delta.0.get());
}

#[test]
fn faults_and_standstill_are_in_the_status() {
    let mut bench = Bench::new();
    for (flags, wanted) in [
        (1 << 7, DriverStatus { standstill: true, ..DriverStatus::default() }),
        (1 << 1, DriverStatus { over_temperature: true, ..DriverStatus::default() }),
        (1 << 2, DriverStatus { over_temperature_warning: true, ..DriverStatus::default() }),
        (1 << 3, DriverStatus { short_a: true, ..DriverStatus::default() }),
        (1 << 4 | 1 << 17, DriverStatus { supply_short_b: true, ..DriverStatus::default() }),
        (1 << 5 | 1 << 6, DriverStatus { open_a: true, open_b: true, ..DriverStatus::default() }),
    ] {
        bench.chip.0.borrow_mut().flags = flags;
        assert_eq!(bench.bank.status(Alpha), Ok(wanted), "{flags:x}");
    }
}

#[test]
fn the_place_in_the_electrical_cycle_comes_with_its_microsteps() {
    let mut bench = Bench::new();
    bench.chip.0.borrow_mut().reading = 321;
    assert_eq!(bench.bank.phase(Alpha), Ok(ElectricalPhase { place: 321, microsteps: 16 }));
    bench.outside.0.borrow_mut().words[0x6A] = 77;
    assert_eq!(bench.bank.phase(Delta), Ok(ElectricalPhase { place: 77, microsteps: 16 }));
    assert_eq!(bench.bank.set_microsteps(Alpha, 64), Ok(16));
    assert_eq!(bench.bank.set_microsteps(Delta, 32), Ok(16));
    assert_eq!(bench.bank.set_microsteps(Alpha, 3), Err(DriverFault::BadSetting));
    assert_eq!(bench.bank.phase(Alpha).map(|phase| phase.microsteps), Ok(64));
}

#[test]
fn a_search_has_its_own_threshold_and_current_and_ends_with_the_former() {
    let mut bench = Bench::new();
    let before = bench.chip.word(SGCSCONF);
    let search = |threshold| StallSearch { current: Some(Amps(0.65)), threshold };
    assert_eq!(bench.bank.begin_stall_search(Alpha, search(200)), Err(DriverFault::BadSetting));
    bench.bank.begin_stall_search(Alpha, search(-3)).expect("a chip");
    assert_eq!(bench.chip.word(SGCSCONF) >> 8 & 0x1FF, 0x7D, "-3, without a filter");
    assert!(is_near(bench.bank.current(Alpha), 0.65));
    bench.chip.0.borrow_mut().reading = 500;
    assert_eq!(bench.bank.reserve(Alpha), Ok(500));
    bench.bank.end_stall_search(Alpha).expect("a chip");
    assert_eq!(bench.chip.word(SGCSCONF), before);
}

#[test]
fn registers_are_written_raw_but_for_double_edges() {
    let mut bench = Bench::new();
    bench.bank.write_register(Alpha, 1, 0x5).expect("a register");
    assert_eq!(bench.chip.word(0), 0x105);
    for (number, value) in [(0, 0), (6, 0), (1, 1 << 20)] {
        assert_eq!(bench.bank.write_register(Alpha, number, value), Err(DriverFault::BadSetting));
    }
    assert_eq!(bench.bank.write_register(Delta, 1, 0), Err(DriverFault::BadSetting));
}

#[test]
fn groups_of_settings_are_set_by_number() {
    let mut bench = Bench::new();
    let spread_cycle = |letter| "UVWXY".find(letter).map(|place| [5.0, 36.0, 4.0, 1.0, 0.0][place]);
    for motor in [Alpha, Delta] {
        bench.bank.set_option(motor, 1, &spread_cycle).expect("a chopper");
        let mut text = String::new();
        bench.bank.describe(motor, Description::Chopper, &mut text).expect("room");
        assert_eq!(text, "0,5,36,4,1,0\n");
        bench.bank.set_option(motor, 4, &|letter| (letter == 'Z').then_some(0.0)).expect("interpolation");
        assert!(bench.described(motor).contains("Step interpolation is off"));
        assert_eq!(bench.bank.set_option(motor, 3, &|_| Some(1.0)), Err(DriverFault::BadSetting), "double edges");
        assert_eq!(bench.bank.set_option(motor, 4, &|_| None), Err(DriverFault::BadSetting));
    }
}

#[test]
fn a_coil_gives_a_chopper_that_is_set() {
    let mut bench = Bench::new();
    let coil = Coil { resistance: Ohms(1.6), henries: 3e-3 };
    for motor in [Alpha, Delta] {
        let fit = bench.bank.fit_chopper(motor, coil, Volts(24.0)).expect("a chip").expect("an ordinary coil");
        let mut text = String::new();
        bench.bank.describe(motor, Description::Chopper, &mut text).expect("room");
        let wanted = std::format!("0,{},", fit.off_time);
        assert!(text.starts_with(&wanted), "{text}");
        assert!(fit.rise.0 > 0.0 && fit.fall.0 > 0.0);
    }
}

#[test]
fn what_a_chip_cannot_take_is_named() {
    let mut config = machine();
    config.actuators[Alpha].microsteps = 48;
    let settings = config.driver(Alpha).expect("a chip on the board");
    let error = set_up::<_, NoLine, Pin>(Select::default(), &config.actuators[Alpha], settings).map(drop);
    let Err(error @ NotSetUp::Microsteps(48)) = error else { panic!("48 is no power of two") };
    assert_eq!(std::format!("{error}"), "microsteps must be a power of two up to 256, not 48");
}

#[test]
fn a_chip_that_no_motor_has_is_switched_off() {
    let chip = Select::default();
    chip.0.borrow_mut().words[CHOPCONF] = 5;
    switch_off(chip.clone()).expect("a chip that answers");
    assert_eq!(chip.word(CHOPCONF) & 15, 0);
}
