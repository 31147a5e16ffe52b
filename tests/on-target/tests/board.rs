//! The board package on the board: clocks, pins, converters, motor bus, card, step pulses.
//!
//! Needs a card in the slot and the motor supply on.
#![no_std]
#![no_main]

use on_target as _;

#[defmt_test::tests]
mod tests {
    use bsp_prime::pins::{PinError, PinName, PinSpec, Pull, table};
    use bsp_prime::step_engine::{self, MotorLines, STATISTICS};
    use bsp_prime::trigger::{self, WatchError};
    use bsp_prime::{adc, memory, time};
    use motion::queue::StepEvent;
    use on_target::{Bench, LATCH, bench, sleep_ms};
    use tmc::{Chip, Driver};
    use units::{Actuator, Direction};

    #[init]
    fn init() -> Bench {
        bench()
    }

    #[test]
    fn the_board_is_the_one_we_know(bench: &mut Bench) {
        defmt::assert_eq!(bench.identity.device.0, 0x450, "an STM32H745 or H747");
        defmt::assert!(bench.identity.board <= 1, "identity resistors read {}", bench.identity.board);
    }

    #[test]
    fn the_two_clocks_and_the_core_agree() {
        let (micros, ticks, cycles) = (time::now(), time::now_ticks(), cortex_m::peripheral::DWT::cycle_count());
        bsp_prime::wait::pause(10_000);
        let micros = time::now().since(micros).0;
        let ticks = time::now_ticks().since(ticks).0;
        let cycles = cortex_m::peripheral::DWT::cycle_count().wrapping_sub(cycles);
        defmt::assert!((10_000..10_200).contains(&micros), "{} us for 10 ms", micros);
        defmt::assert!(ticks.abs_diff(micros * 200) < 2_000, "{} ticks in {} us", ticks, micros);
        defmt::assert!(u64::from(cycles).abs_diff(micros * 400) < 4_000, "{} cycles in {} us", cycles, micros);
    }

    /// Each poll accesses a bus that others use: without pauses there would be tens of thousands of them.
    #[test]
    fn a_wait_ends_in_time_and_looks_ever_more_rarely() {
        let (start, mut looks) = (time::now(), 0_u32);
        let ended = bsp_prime::wait::until(2_000, || {
            looks += 1;
            false
        });
        let took = time::now().since(start).0;
        defmt::assert!(ended.is_err() && (2_000..2_020).contains(&took), "it ended after {} us", took);
        defmt::assert!((100..1_500).contains(&looks), "{} looks in 2 ms", looks);
        let start = time::now();
        let ended = bsp_prime::wait::until(2_000, || time::now().since(start).0 >= 1_000);
        let took = time::now().since(start).0;
        defmt::assert!(ended.is_ok() && (1_000..1_015).contains(&took), "seen after {} us", took);
    }

    #[test]
    fn the_statics_leave_the_stack_room() {
        defmt::assert!(memory::stack_room_bytes() > 16 * 1024, "{} bytes", memory::stack_room_bytes());
    }

    /// ARMv7-M ARM B3.5: RASR is XN 28, AP 26 to 24, TEX 21 to 19, S 18, C 17, B 16, SIZE 5 to 1 (2^(SIZE
    /// + 1) bytes), ENABLE 0. The regions repeat the default map with what it does not say; two lie where
    /// the linker has put the stacks.
    #[test]
    fn the_mpu_has_the_regions_of_its_table() {
        const REGIONS: [(u32, u32, &str); 6] = [
            (0x0000_0000, 0x0302_001F, "ITCM, 64 KiB: full access, write-through, executable"),
            (0x0800_0000, 0x0702_0029, "flash, 2 MiB: read-only, write-through, executable"),
            (0x2000_0000, 0x130B_0021, "DTCM, 128 KiB: full access, write-back, never executed"),
            (0x2400_0000, 0x130B_0025, "AXI SRAM, 512 KiB: full access, write-back, never executed"),
            (0x2406_C000, 0x130C_001B, "DMA arena, 16 KiB: full access, never cached, never executed"),
            (0x2407_0000, 0x130C_001F, "DMA arena, 64 KiB more: full access, never cached, never executed"),
        ];
        for (number, (base, attributes, what)) in REGIONS.into_iter().enumerate() {
            defmt::assert_eq!(memory::protection(number as u8), (base, attributes), "{=str}", what);
        }
        for guard in [6, 7] {
            let (base, attributes) = memory::protection(guard);
            defmt::assert!(
                base != 0 && attributes & 0x1700_0001 == 0x1000_0001,
                "guard {}: {:#010x}",
                guard,
                attributes
            );
        }
        let d2 = (0x3000_0000, 0x130B_0023);
        defmt::assert_eq!(memory::protection(8), d2, "SRAM1 and 2, 256 KiB: write-back, never executed");
        let kept = (0x3800_0000, 0x130C_001F);
        defmt::assert_eq!(memory::protection(9), kept, "SRAM4, 64 KiB: never cached, never executed");
        let log = (0x081E_0000, 0x1302_0021);
        defmt::assert_eq!(memory::protection(10), log, "the log's sector, 128 KiB: full access, never executed");
        let d2_dma = (0x3004_0000, 0x130C_001D);
        defmt::assert_eq!(memory::protection(11), d2_dma, "SRAM3, 32 KiB: full access, never cached, never executed");
        let itcm_data = (0x0000_0000, 0x1302_011F);
        defmt::assert_eq!(memory::protection(12), itcm_data, "ITCM, 56 of 64 KiB: full access, never executed");
        for unused in 13..16 {
            defmt::assert_eq!(memory::protection(unused).1 & 1, 0, "region {} is on", unused);
        }
        // PRIVDEFENA and ENABLE; not HFNMIENA: a hard fault's handler may touch everything.
        defmt::assert_eq!(memory::protection_control(), 0b101);
    }

    #[test]
    fn pin_names_with_modifiers_are_read() {
        let spec = PinSpec::parse("PE1!^");
        defmt::assert!(spec.is_some_and(|spec| spec.pin == PinName::new('E', 1) && spec.inverted));
        for wrong in ["E1", "PL1", "PE16", "PE", "PE1x", ""] {
            defmt::assert!(PinSpec::parse(wrong).is_none(), "{=str} must be refused", wrong);
        }
    }

    #[test]
    fn a_pin_has_one_owner_and_the_second_is_told_who_it_is(bench: &mut Bench) {
        let pin = PinName::new('J', 6);
        defmt::assert!(bench.pins.claim(pin, "kill button.pin").is_ok());
        match bench.pins.claim(pin, "switch.fan.output_pin") {
            Err(PinError::Taken { owner, wanted_by, .. }) => {
                defmt::assert_eq!(owner.as_str(), "kill button.pin");
                defmt::assert_eq!(wanted_by.as_str(), "switch.fan.output_pin");
            }
            _ => defmt::panic!("the second claim must fail"),
        }
        bench.pins.release("kill button.pin");
        defmt::assert!(bench.pins.claim(pin, "switch.fan.output_pin").is_ok());
        bench.pins.release("switch.fan.output_pin");
    }

    #[test]
    fn pins_of_the_card_and_the_guards_are_not_to_be_had(bench: &mut Bench) {
        let reserved = bench.pins.claim(PinName::new('C', 8), "x");
        defmt::assert!(matches!(reserved, Err(PinError::Reserved { usage: "the SD card", .. })));
        defmt::assert!(matches!(bench.pins.claim(table::MOTORS_ENABLE.pin, "x"), Err(PinError::Taken { .. })));
    }

    #[test]
    fn outputs_come_up_off(bench: &mut Bench) {
        for guard in [&bench.guards.motors, &bench.guards.fets, &bench.guards.fets_power] {
            defmt::assert!(!guard.is_on(), "{} is on", defmt::Display2Format(&guard.pin()));
        }
    }

    #[test]
    fn the_thermistor_scan_runs_on_by_itself(bench: &mut Bench) {
        let channels = table::THERMISTORS.map(|input| input.channel);
        defmt::assert!(bench.thermistors.average(0).is_err(), "nothing has been scanned yet");
        defmt::assert!(bench.thermistors.start(&channels).is_ok());
        defmt::assert!(bench.thermistors.average(0).is_err(), "the first round is not over");
        for _ in 0..3 {
            let before = bench.thermistors.samples_to_wrap();
            sleep_ms(2);
            let after = bench.thermistors.samples_to_wrap();
            defmt::assert!(before != after, "no sample in 2 ms, {} to wrap", after);
        }
        sleep_ms(40);
        defmt::assert!(bench.thermistors.is_running());
        for position in 0..channels.len() {
            let average = bench.thermistors.average(position);
            defmt::assert!(average.is_ok());
            defmt::info!("{=str}: {}", table::THERMISTORS[position].name, average.ok());
        }
        defmt::assert!(bench.thermistors.average(channels.len()).is_err());
    }

    #[test]
    fn supplies_and_the_chip_itself_are_measured(bench: &mut Bench) {
        let inputs = [table::VMOTOR, table::VFET, table::CHIP_TEMPERATURE, table::VREF];
        defmt::assert!(bench.supplies.start(&inputs).is_ok());
        for _ in 0..6 {
            sleep_ms(2);
            bench.supplies.poll();
        }
        let volts = bench.supplies.reading(table::VMOTOR).map(|counts| adc::pin_volts(counts) * table::SUPPLY_DIVIDER);
        defmt::assert!(volts.is_some_and(|volts| (10.0..36.0).contains(&volts)), "motor supply {} V", volts);
        let reference = bench.supplies.reading(table::VREF).map(adc::pin_volts);
        defmt::assert!(reference.is_some_and(|volts| (1.1..1.3).contains(&volts)), "reference {} V", reference);
        let reading = bench.supplies.reading(table::CHIP_TEMPERATURE);
        defmt::assert!(reading.is_some_and(|counts| counts > 0), "temperature sensor {}", reading);
        // `None` for a chip without calibration words, which the emulated one is.
        let celsius = reading.and_then(adc::chip_celsius);
        defmt::assert!(celsius.is_none_or(|celsius| (0.0..90.0).contains(&celsius)), "chip at {} C", celsius);
    }

    #[test]
    fn the_newest_reading_is_near_the_average_and_comes_at_any_pace(bench: &mut Bench) {
        for position in 0..table::THERMISTORS.len() {
            let (newest, average) = (bench.thermistors.latest(position), bench.thermistors.average(position));
            let (Ok(newest), Ok(average)) = (newest, average) else { defmt::panic!("input {}", position) };
            defmt::assert!(newest.abs_diff(average) < 1_000, "input {}: {} for {}", position, newest, average);
        }
        defmt::assert!(bench.thermistors.latest(table::THERMISTORS.len()).is_err());
        let average = bench.supplies.reading(table::VREF);
        for _ in 0..20 {
            let newest = bench.supplies.latest(table::VREF);
            defmt::assert!(newest.zip(average).is_some_and(|(newest, average)| newest.abs_diff(average) < 1_000));
            bsp_prime::wait::pause(50);
        }
    }

    #[test]
    fn all_four_motor_drivers_answer(bench: &mut Bench) {
        let chip = if bench.identity.board == 1 { Chip::Tmc2660 } else { Chip::Tmc2590 };
        for (motor, pins) in table::MOTORS.iter().enumerate() {
            let Ok(select) = bench.pins.output(PinSpec::inverted(pins.select), "test") else {
                defmt::panic!("select pin of motor {}", motor)
            };
            let Ok(mut driver) = Driver::new(bench.spi.motor_driver(select), chip, chip.default_sense_resistor())
            else {
                defmt::panic!("the default sense resistor is one the driver takes")
            };
            let status = driver.start();
            defmt::assert!(status.is_ok(), "motor {}: {}", motor, defmt::Debug2Format(&status.err()));
        }
        bench.pins.release("test");
    }

    #[test]
    fn the_card_is_identified_and_its_blocks_are_read(bench: &mut Bench) {
        let card = bench.sd.identify();
        defmt::assert!(card.is_ok(), "{}", defmt::Debug2Format(&card.err()));
        let mut block = [0; 512];
        for number in 0..3 {
            defmt::assert!(bench.sd.read(2 - number, &mut block).is_ok());
        }
        defmt::assert_eq!(block.get(510..), Some(&[0x55, 0xAA][..]), "signature of the first block");
        let beyond = bench.sd.blocks().unwrap_or(u32::MAX);
        defmt::assert!(bench.sd.read(beyond, &mut block).is_err(), "a block beyond the end must be refused");
        bench.watchdog.feed();
    }

    #[test]
    fn steps_are_played_in_time(bench: &mut Bench) {
        let mut lines = [MotorLines::NONE; units::MAX_ACTUATORS];
        for (line, pins) in lines.iter_mut().zip(&table::MOTORS) {
            let step = bench.pins.fast_output(PinSpec::plain(pins.step), "test");
            let direction = bench.pins.fast_output(PinSpec::plain(pins.direction), "test");
            let (Ok(step), Ok(direction)) = (step, direction) else {
                defmt::panic!("step and direction pins are free")
            };
            *line = MotorLines { step, direction, double_edge: true, ..MotorLines::NONE };
        }
        step_engine::configure(&lines, 1);
        STATISTICS.reset_worst();
        let start = time::step_ticks().wrapping_add(200_000);
        defmt::assert!(step_engine::queue().push(StepEvent::turn(start, Actuator::Beta, Direction::Forward)));
        for step in 1..=100 {
            let at = start.wrapping_add(step * 2_000);
            for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
                defmt::assert!(step_engine::queue().push(StepEvent::step(at, motor)));
            }
        }
        step_engine::wake();
        sleep_ms(3);
        defmt::assert!(step_engine::queue().is_empty(), "{} events are left", step_engine::queue().len());
        defmt::info!("worst lateness {} ticks of 5 ns", STATISTICS.worst_ticks());
        // Zero says: none was more than 250 ns late.
        defmt::assert!(STATISTICS.worst_ticks() == 0, "{} ticks late", STATISTICS.worst_ticks());
        bench.pins.release("test");
    }

    #[test]
    fn an_external_driver_gets_pulses_that_end_low(bench: &mut Bench) {
        let Ok(step) = bench.pins.fast_output(PinSpec::plain(PinName::new('G', 0)), "test") else {
            defmt::panic!("PG0 is free")
        };
        let mut lines = [MotorLines::NONE; units::MAX_ACTUATORS];
        if let Some(zeta) = lines.last_mut() {
            *zeta = MotorLines { step, double_edge: false, ..MotorLines::NONE };
        }
        step_engine::configure(&lines, 5);
        // An odd number: were these edges rather than pulses, the pin would stay high.
        let start = time::step_ticks().wrapping_add(20_000);
        for pulse in 0..9 {
            defmt::assert!(
                step_engine::queue().push(StepEvent::step(start.wrapping_add(pulse * 4_000), Actuator::Zeta))
            );
        }
        step_engine::wake();
        let mut seen_high = false;
        while !step_engine::queue().is_empty() && time::step_ticks().wrapping_sub(start) as i32 <= 400_000 {
            seen_high |= step.is_high();
        }
        sleep_ms(2);
        defmt::assert!(step_engine::queue().is_empty() && seen_high && !step.is_high());
        bench.pins.release("test");
    }

    #[test]
    fn an_edge_is_stamped_with_the_step_clock(bench: &mut Bench) {
        // Nothing is connected to header pin GA-3: the chip's own resistor moves it.
        let pin = PinSpec { pull: Pull::Down, ..PinSpec::plain(PinName::new('J', 6)) };
        defmt::assert!(bench.pins.input(pin, "test").is_ok());
        sleep_ms(1);
        defmt::assert!(trigger::watch(pin, 3).is_ok());
        LATCH.arm(1 << 3);
        bench.pins.release("test");
        let before = time::step_ticks();
        defmt::assert!(bench.pins.input(PinSpec { pull: Pull::Up, ..pin }, "test").is_ok());
        sleep_ms(1);
        let fired = LATCH.fired();
        defmt::assert!(fired.is_some_and(|fired| fired.input == 3 && fired.at.wrapping_sub(before) < 200_000));
        trigger::unwatch(3);
        bench.pins.release("test");
    }

    #[test]
    fn two_pins_of_one_number_cannot_both_have_the_edge_detector() {
        let [x_min, .., z_min, _] = table::ENDSTOPS;
        defmt::assert!(trigger::watch(PinSpec::plain(x_min), 0).is_ok());
        defmt::assert!(trigger::watch(PinSpec::plain(z_min), 4) == Err(WatchError::LineTaken(x_min)));
        trigger::unwatch(0);
        defmt::assert!(trigger::watch(PinSpec::plain(z_min), 4).is_ok());
        trigger::unwatch(4);
    }
}
