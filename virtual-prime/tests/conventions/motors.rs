//! Motor drivers: enable lines, steps, and the bus.

use board_facts::figures::{DRIVER_BUS_HZ, DRIVER_DIRECTION_SETUP_NS, DRIVER_FRAME_BITS};
use board_facts::wiring::{DRIVERS, MOTORS_ENABLE};
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::{rcc, spi1};
use virtual_prime::board::PinChange;
use virtual_prime::pin_state::Drive;

use crate::common::MS;
use crate::common::machine::{changes, everything, pin, state, watch};
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet};

/// SPI4 (RM0399 section 2.3.2, boundary addresses): CR2, and the byte writes to TXDR.
const SPI4_CR2: u64 = 0x4001_3404;
const SPI4_TXDR: u64 = 0x4001_3420;

fn of<'a>(all: &'a [PinChange], name: &'static str) -> impl Iterator<Item = &'a PinChange> {
    let wanted = pin(name);
    all.iter().filter(move |change| change.pin == wanted)
}

/// Moves with relative coordinates, and waits for the end.
#[track_caller]
fn travel(velvet: &mut Velvet, words: &str) {
    assert_eq!(velvet.ask("G91", SECOND), "ok\n");
    assert_eq!(velvet.ask(&format!("G1 {words} F600"), SECOND), "ok\n");
    velvet.ask("M400", 20 * SECOND);
}

#[test]
fn the_drivers_are_enabled_by_a_low_line_and_a_halt_lets_them_go() {
    let mut velvet = everything().held();
    watch(&mut velvet, &[MOTORS_ENABLE]);
    velvet.hear_until(PROMPT, 2 * SECOND);
    let boot = changes(&mut velvet);
    assert_eq!(boot.iter().map(|change| change.high).collect::<Vec<_>>(), [true, false]);
    // The line is high before the clocks are up, some hundred microseconds after reset.
    assert!(boot[0].at_ns < MS, "{boot:?}");
    travel(&mut velvet, "X1");
    assert!(changes(&mut velvet).is_empty());
    velvet.type_in("M112");
    velvet.hear(3 * SECOND);
    assert_eq!(changes(&mut velvet).iter().map(|change| change.high).collect::<Vec<_>>(), [true]);
    velvet.ask("M999", SECOND);
    travel(&mut velvet, "X1");
    assert_eq!(changes(&mut velvet).iter().map(|change| change.high).collect::<Vec<_>>(), [false]);
}

#[test]
fn each_edge_of_an_on_board_step_pin_is_a_step() {
    let mut velvet = everything().start();
    let steps = [("PD3", 80), ("PK2", 160), ("PG3", 400), ("PC6", 415)];
    watch(&mut velvet, &steps.map(|(name, _)| name));
    travel(&mut velvet, "X1 Y2 Z1 E1");
    let all = changes(&mut velvet);
    for (name, count) in steps {
        assert_eq!(of(&all, name).count(), count, "{name}");
    }
}

#[test]
fn each_pulse_of_an_external_step_pin_is_a_step() {
    let mut velvet = everything().start();
    watch(&mut velvet, &["PG0"]);
    travel(&mut velvet, "B1");
    assert_pulses(&changes(&mut velvet), true);
    assert_eq!(state(&mut velvet, "PG0").drive, Drive::Low);
}

#[test]
fn an_inverted_external_step_pin_rests_high() {
    let mut velvet = everything().set("[actuator] epsilon.step_pin = PG0!").start();
    assert_eq!(state(&mut velvet, "PG0").drive, Drive::High);
    watch(&mut velvet, &["PG0"]);
    travel(&mut velvet, "B1");
    assert_pulses(&changes(&mut velvet), false);
    assert_eq!(state(&mut velvet, "PG0").drive, Drive::High);
}

/// Makes 100 steps of 1 mm: pulses of 5 us, and pauses that are longer.
#[track_caller]
fn assert_pulses(edges: &[PinChange], active: bool) {
    assert_eq!(edges.len(), 200);
    for (index, pair) in edges.windows(2).enumerate() {
        let pulse = index % 2 == 0;
        assert_eq!(pair[0].high, pulse == active, "edge {index}");
        let length_ns = pair[1].at_ns - pair[0].at_ns;
        assert!(length_ns >= 5_000 && (!pulse || length_ns < 6_000), "edge {index}: {length_ns} ns");
    }
}

#[test]
fn dir_is_stable_before_each_step() {
    // Default times of a configuration without them: 500 ns on board, 5 us for external drivers.
    let pairs = [("PD3", "PD4", 500), ("PG0", "PG1", 5_000)];
    let mut velvet = everything().start();
    watch(&mut velvet, &["PD3", "PD4", "PG0", "PG1"]);
    for way in ["1", "-1", "0.5", "-0.5"] {
        travel(&mut velvet, &format!("X{way} B{way}"));
    }
    let all = changes(&mut velvet);
    for (step, direction, least_ns) in pairs {
        let turns: Vec<u64> = of(&all, direction).map(|change| change.at_ns).collect();
        assert!(turns.len() >= 3, "{direction} turned {} times", turns.len());
        for turn in turns {
            let next = of(&all, step).find(|change| change.at_ns >= turn).expect("a step after each turn");
            let gap_ns = next.at_ns - turn;
            assert!(gap_ns >= least_ns && gap_ns >= DRIVER_DIRECTION_SETUP_NS, "{step}: {gap_ns} ns after {direction}");
        }
    }
}

#[test]
fn the_drivers_bus_is_mode_3_at_391_khz() {
    let mut velvet = everything().start();
    let registers = velvet.bench.vm.with(|stopped| {
        let bus = stopped.session.board().mcu.bus();
        let bus_of_drivers =
            bus.registers("SPI4").map(|file| [spi1::Register::Cfg1, spi1::Register::Cfg2].map(|r| file.get(r)));
        (bus_of_drivers, bus.registers("RCC").map(|file| file.get(rcc::Register::D2ccip1r)))
    });
    let (Some([cfg1, cfg2]), Some(clocks)) = registers.expect("the image runs") else { panic!("no such block") };
    // RM0399 chapter 9, RCC_D2CCIP1R: SPI45SEL = 0 is the APB2 clock, 100 MHz. Section 53.11.3: MBR; DSIZE =
    // 7 is eight bits.
    assert_eq!(clocks >> 16 & 0b111, 0);
    assert_eq!(100_000_000 >> ((cfg1 >> 28 & 0b111) + 1), DRIVER_BUS_HZ);
    assert_eq!(cfg1 & 0x1F, 7);
    // Section 53.11.4: CPOL, CPHA, MASTER set; LSBFRST clear; pins kept while disabled (AFCNTR).
    let bit = |n: u32| cfg2 >> n & 1 == 1;
    assert!(bit(25) && bit(24) && bit(22) && !bit(23) && bit(31), "{cfg2:#010x}");
}

#[test]
fn each_frame_has_24_clocks_within_one_chip_select() {
    let mut velvet = everything().watching(SPI4_CR2..SPI4_CR2 + 4).watching(SPI4_TXDR..SPI4_TXDR + 4).start();
    let selects = DRIVERS.map(|driver| driver.select);
    velvet.hear(SECOND);
    let frames_before = frames(&mut velvet);
    velvet.bench.writes.take();
    watch(&mut velvet, &selects);
    velvet.ask("M907 X1", SECOND);
    velvet.hear(2 * SECOND);
    let all = changes(&mut velvet);
    let sent: u64 = frames(&mut velvet) - frames_before;
    assert!(sent >= 8, "{sent} frames");
    // A frame's chip select goes low and high again, and no two are low at once.
    assert_eq!(all.len() as u64, 2 * sent);
    for pair in all.chunks(2) {
        assert!(pair[0].pin == pair[1].pin && !pair[0].high && pair[1].high, "{pair:?}");
        let low_ns = pair[1].at_ns - pair[0].at_ns;
        let frame_ns = DRIVER_FRAME_BITS * 1_000_000_000 / DRIVER_BUS_HZ;
        assert!((frame_ns..2 * frame_ns).contains(&low_ns), "{low_ns} ns");
    }
    // Each frame has three bytes.
    let writes = velvet.bench.writes.take();
    let bytes = writes.iter().filter(|write| write.address == SPI4_TXDR).count() as u64;
    let lengths: Vec<u64> = writes.iter().filter(|write| write.address == SPI4_CR2).map(|write| write.value).collect();
    assert_eq!(bytes * 8, sent * DRIVER_FRAME_BITS);
    assert!(
        lengths.len() as u64 == sent && lengths.iter().all(|length| *length * 8 == DRIVER_FRAME_BITS),
        "{lengths:?}"
    );
}

fn frames(velvet: &mut Velvet) -> u64 {
    velvet.world(|world| (0..DRIVERS.len()).map(|index| world.driver(index).frames()).sum())
}

/// The enable line is common to all drivers, and a chip keeps its registers through a reset of the board, so
/// an unused driver has to be switched off.
#[test]
fn a_driver_that_no_motor_uses_is_switched_off() {
    /// CHOPCONF with TOFF 5 (TMC2590 data sheet 7.6).
    const BRIDGES_ON: u32 = 0x9_81C5;
    let plan = Plan::new().built().set("[actuator] delta.driver = external");
    let mut velvet = plan.set("[actuator] delta.step_pin = PG0").set("[actuator] delta.dir_pin = PG1").held();
    for index in 0..DRIVERS.len() {
        let _answer = velvet.world(|world| world.driver_spi(0, index, BRIDGES_ON));
    }
    velvet.hear_until(PROMPT, 2 * SECOND);
    assert_eq!(velvet.ask("M17", SECOND), "ok\n");
    let drives = [0, 1, 2, 3].map(|index| velvet.world(|world| world.driver(index).drives()));
    assert_eq!(drives, [true, true, true, false]);
    assert_eq!(state(&mut velvet, "PG6").drive, Drive::High);
}

#[test]
fn an_external_driver_is_enabled_while_its_motor_is_on() {
    let mut velvet = everything().start();
    for (line, drive) in [("M17", Drive::Low), ("M18", Drive::High), ("M17", Drive::Low), ("M84", Drive::High)] {
        velvet.ask(line, SECOND);
        velvet.hear(100);
        assert_eq!(state(&mut velvet, "PJ2").drive, drive, "{line}");
    }
}
