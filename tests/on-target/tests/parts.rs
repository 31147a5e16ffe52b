//! Parts of the board package that need nothing but the chip: rings, names and claims of pins, levels, memory
//! for DMA, texts that outlive a reset, the calendar, channels of PWM.
#![no_std]
#![no_main]

use on_target::{Bench, sleep_ms};

/// Sleeps for longer than the watchdog waits.
fn sleep_fed(bench: &mut Bench, milliseconds: u64) {
    for _ in 0..milliseconds / 100 {
        sleep_ms(100);
        bench.watchdog.feed();
    }
}

#[defmt_test::tests]
mod tests {
    use core::fmt::Write;

    use bsp_prime::byte_ring::ByteRing;
    use bsp_prime::identity::mac_address;
    use bsp_prime::last_words::{self, Text};
    use bsp_prime::pins::{PinError, PinName, PinSpec, Pull, table};
    use bsp_prime::rtc;
    use bsp_prime::{adc, dma_buffer, factory, fpu};
    use events::DateTime;
    use on_target::{Bench, bench, sleep_ms};

    use super::sleep_fed;

    dma_buffer!(static WORDS: [u32; 4]);
    dma_buffer!(in D2, static HALVES: [u16; 3]);

    #[init]
    fn init() -> Bench {
        bench()
    }

    // --- rings ---

    #[test]
    fn a_full_ring_refuses_and_counts() {
        let ring = ByteRing::<4>::new();
        for byte in 0..4 {
            defmt::assert!(ring.push(byte));
        }
        defmt::assert!(!ring.push(4) && !ring.push(5));
        defmt::assert_eq!((ring.len(), ring.room(), ring.refused()), (4, 0, 2));
        defmt::assert_eq!(ring.pop(), Some(0), "the oldest byte is whole");
        defmt::assert!(ring.push(6) && ring.refused() == 2);
    }

    #[test]
    fn a_ring_keeps_the_order_round_and_round() {
        let ring = ByteRing::<8>::new();
        let (mut sent, mut read) = (0_u8, 0_u8);
        for turn in 0..100 {
            for _ in 0..=turn % 8 {
                if ring.push(sent) {
                    sent = sent.wrapping_add(1);
                }
            }
            for _ in 0..=turn % 5 {
                if let Some(byte) = ring.pop() {
                    defmt::assert_eq!(byte, read, "turn {}", turn);
                    read = read.wrapping_add(1);
                }
            }
        }
        defmt::assert_eq!(usize::from(sent.wrapping_sub(read)), ring.len());
    }

    #[test]
    fn what_does_not_fit_stays_with_the_caller() {
        let ring = ByteRing::<4>::new();
        defmt::assert_eq!(ring.push_some(b"abcdef"), 4);
        defmt::assert_eq!(ring.push_some(b"ef"), 0);
        defmt::assert_eq!(ring.refused(), 0, "the caller still has it");
        let mut read = [0; 3];
        defmt::assert_eq!(ring.pop_into(&mut read), 3);
        defmt::assert_eq!(&read, b"abc");
        defmt::assert_eq!(ring.push_some(b"ef"), 2);
        defmt::assert_eq!((ring.pop_into(&mut read), &read), (3, b"def"));
    }

    #[test]
    fn a_cleared_ring_is_empty_and_goes_on() {
        let ring = ByteRing::<4>::new();
        ring.push_some(b"abc");
        ring.clear();
        defmt::assert!(ring.is_empty() && ring.room() == 4 && ring.pop().is_none());
        defmt::assert_eq!(ring.push_some(b"wxyz"), 4);
        defmt::assert_eq!(ring.pop(), Some(b'w'));
    }

    // --- identity ---

    #[test]
    fn each_chip_has_its_own_address_of_those_free_to_use() {
        let mut seen = [[0; 6]; 96];
        for bit in 0..96_usize {
            // Chips of one wafer: ids that differ in a single bit.
            let mut id = [0x0036_0027, 0x3039_510B, 0x3332_3436];
            id[bit / 32] ^= 1 << (bit % 32);
            let address = mac_address(id);
            defmt::assert_eq!(address[0] & 0b11, 0b10, "for one station, locally administered");
            defmt::assert!(!seen.contains(&address), "bit {}", bit);
            seen[bit] = address;
        }
    }

    #[test]
    fn an_address_stays_the_same_for_ever(bench: &mut Bench) {
        // Users have it in their routers: another calculation is another address.
        defmt::assert_eq!(mac_address([0x0036_0027, 0x3039_510B, 0x3332_3436]), [0xCE, 0x0D, 0xDB, 0x87, 0xEF, 0x7C]);
        defmt::assert_eq!(bench.identity.mac_address(), mac_address(bench.identity.unique_id));
    }

    // --- pins ---

    #[test]
    fn each_spelling_is_the_same_pin() {
        let pin = PinName::new('D', 3);
        for text in ["PD3", "pd3", "PD_3", "PD.3", "Pd03"] {
            defmt::assert!(PinName::parse(text) == Some(pin), "{=str}", text);
        }
        for text in ["PD", "D3", "PD+3", "PD-3", "PD16", "PL0", "P\u{e9}3", "PD3x"] {
            defmt::assert!(PinName::parse(text).is_none(), "{=str}", text);
        }
        defmt::assert_eq!((pin.port(), pin.number(), pin.bit()), (3, 3, 8));
        defmt::assert!(PinName::new('L', 0) == PinName::new('K', 15), "a pin that leads nowhere");
    }

    #[test]
    fn modifiers_come_in_any_order_and_the_last_resistor_counts() {
        let spec = |text| match PinSpec::parse(text) {
            Some(PinSpec { inverted, open_drain, pull, .. }) => (inverted, open_drain, pull),
            None => defmt::panic!("{=str} is a pin", text),
        };
        defmt::assert!(spec("PE1") == (false, false, Pull::Up));
        defmt::assert!(spec("PE1!ov") == (true, true, Pull::Down));
        defmt::assert!(spec("PE1vo!") == (true, true, Pull::Down));
        defmt::assert!(spec("PE1^-") == (false, false, Pull::Floating));
    }

    #[test]
    fn a_pin_is_given_back_by_its_owner_alone(bench: &mut Bench) {
        let pin = PinName::new('J', 6);
        defmt::assert!(bench.pins.analog(pin, "probe").is_ok());
        bench.pins.give_back(pin, "somebody");
        defmt::assert_eq!(bench.pins.owner(pin), Some("probe"));
        bench.pins.give_back(pin, "probe");
        defmt::assert_eq!(bench.pins.owner(pin), None);
    }

    #[test]
    fn a_long_owner_is_cut_and_still_told(bench: &mut Bench) {
        let pin = PinName::new('J', 6);
        let long = "a setting whose name is longer than forty letters";
        defmt::assert!(bench.pins.claim(pin, long).is_ok());
        defmt::assert_eq!(bench.pins.owner(pin), long.get(..40));
        bench.pins.give_back(pin, long.get(..40).unwrap_or_default());
        defmt::assert_eq!(bench.pins.owner(pin), None);
    }

    #[test]
    fn every_reserved_pin_is_refused_with_its_use(bench: &mut Bench) {
        for (pin, fixed) in table::RESERVED {
            match bench.pins.claim(*pin, "x") {
                Err(PinError::Reserved { usage, .. }) => defmt::assert_eq!(usage, *fixed),
                _ => defmt::panic!("{} must be refused", defmt::Display2Format(pin)),
            }
        }
    }

    #[test]
    fn no_two_roles_share_a_pin() {
        let motors = table::MOTORS.iter().flat_map(|pins| [pins.step, pins.direction, pins.select, pins.stall]);
        let guards = [table::MOTORS_ENABLE, table::FETS_ENABLE, table::FETS_POWER_ENABLE, table::USB_HOST_POWER];
        let outputs = guards.into_iter().chain(table::MOSFETS).chain(table::RELAYS).map(|spec| spec.pin);
        let inputs = table::ENDSTOPS.into_iter().chain([table::PROBE, table::MSC_LED]);
        let roles = || motors.clone().chain(outputs.clone()).chain(inputs.clone()).chain(table::LEDS);
        for (place, pin) in roles().enumerate() {
            let twin = roles().skip(place + 1).any(|other| other == pin);
            defmt::assert!(!twin, "{} has two roles", defmt::Display2Format(&pin));
        }
    }

    #[test]
    fn an_inverted_output_is_off_while_high(bench: &mut Bench) {
        let pin = PinName::new('G', 0);
        for (spec, off_is_high) in [(PinSpec::plain(pin), false), (PinSpec::inverted(pin), true)] {
            let Ok(fast) = bench.pins.fast_output(spec, "test") else { defmt::panic!("PG0 is free") };
            defmt::assert_eq!(fast.is_high(), off_is_high, "off at once");
            defmt::assert_eq!(fast.on_word(), fast.off_word().rotate_left(16));
            bench.pins.release("test");
            let Ok(mut output) = bench.pins.output(spec, "test") else { defmt::panic!("PG0 is free") };
            for on in [true, false, true] {
                output.set(on);
                defmt::assert_eq!((output.is_on(), fast.is_high()), (on, on != off_is_high));
            }
            bench.pins.release("test");
        }
    }

    #[test]
    fn an_input_follows_its_resistor(bench: &mut Bench) {
        for (pull, is_on) in [(Pull::Up, true), (Pull::Down, false)] {
            let spec = PinSpec { pull, ..PinSpec::plain(PinName::new('G', 1)) };
            let Ok(input) = bench.pins.input(spec, "test") else { defmt::panic!("PG1 is free") };
            sleep_ms(1);
            defmt::assert_eq!((input.is_on(), input.opposite().is_on()), (is_on, !is_on));
            bench.pins.release("test");
        }
    }

    #[test]
    fn each_channel_of_pwm_has_one_pin(bench: &mut Bench) {
        for timer in 0..2 {
            for channel in 0..4 {
                let (_, pin) = table::PWM[4 * timer + channel];
                defmt::assert!(bench.pwm.attach(timer, channel, bench.pins, "laser").is_ok());
                defmt::assert_eq!(bench.pins.owner(pin), Some("laser"));
                defmt::assert!(bench.pwm.attach(timer, channel, bench.pins, "spindle").is_err());
            }
        }
        bench.pins.release("laser");
    }

    // --- memory and numbers ---

    #[test]
    fn memory_for_dma_is_where_no_cache_is_and_ends_where_it_ends() {
        defmt::assert!(WORDS.address().is_some_and(|address| address % 32 == 0));
        defmt::assert!(HALVES.address().is_some());
        defmt::assert!(HALVES.write(2, 0xBEEF) && !HALVES.write(3, 1));
        defmt::assert_eq!((HALVES.read(2), HALVES.read(3)), (Some(0xBEEF), None));
    }

    #[test]
    fn words_for_dma_are_bytes_low_end_first() {
        defmt::assert!(WORDS.store(1, &[1, 2, 3, 4, 5, 6, 7, 8]));
        defmt::assert_eq!((WORDS.read(1), WORDS.read(2)), (Some(0x0403_0201), Some(0x0807_0605)));
        let mut bytes = [0; 8];
        defmt::assert!(WORDS.load(1, &mut bytes) && bytes == [1, 2, 3, 4, 5, 6, 7, 8]);
        defmt::assert!(!WORDS.store(3, &[0; 8]) && !WORDS.load(3, &mut bytes), "there is a word less");
    }

    #[test]
    fn roots_are_rounded_correctly() {
        for (square, root) in [(0.0, 0.0), (2.0, core::f64::consts::SQRT_2), (1e300, 1e150), (0.0625, 0.25)] {
            let found = (fpu::SQUARE_ROOT)(core::hint::black_box(square));
            defmt::assert!(found.to_bits() == f64::to_bits(root), "{} of {}", found, square);
        }
        defmt::assert!((fpu::SQUARE_ROOT)(core::hint::black_box(-1.0)).is_nan());
    }

    #[test]
    fn a_full_reading_is_the_reference() {
        let near = |volts: f32, wanted: f32| volts - wanted < 1e-3 && wanted - volts < 1e-3;
        defmt::assert!(adc::pin_volts(0) == 0.0 && near(adc::pin_volts(u16::MAX), 3.3));
        defmt::assert!(near(adc::pin_volts(1 << 15), 1.65));
    }

    #[test]
    fn a_pin_is_found_by_its_number() {
        for (number, name) in [(0, "PA0"), (17, "PB1"), (121, "PH9"), (175, "PK15")] {
            defmt::assert!(PinName::numbered(number) == PinName::parse(name), "{}", number);
        }
        defmt::assert!(PinName::numbered(176).is_none() && PinName::numbered(u32::MAX).is_none());
    }

    #[test]
    fn only_words_from_the_factory_are_read(bench: &mut Bench) {
        for (word, place) in bench.identity.unique_id.into_iter().zip((0x1FF1_E800..).step_by(4)) {
            defmt::assert_eq!(factory::read(4, place), Some(word));
            defmt::assert_eq!(factory::read(2, place + 2), Some(word >> 16));
            defmt::assert_eq!(factory::read(1, place + 1), Some(word >> 8 & 0xFF));
        }
        defmt::assert!(factory::read(2, 0x1FF1_E880).is_some_and(|kib| kib == 2048), "the flash has 2 MiB");
        for (bytes, address) in
            [(4, 0x1FF1_E802), (3, 0x1FF1_E800), (0, 0x1FF1_E800), (4, 0x1FF1_E7FC), (1, 0x1FF1_E884)]
        {
            defmt::assert_eq!(factory::read(bytes, address), None, "{} at {}", bytes, address);
        }
        defmt::assert_eq!(factory::read(4, u32::MAX), None);
    }

    // --- what outlives a reset ---

    #[test]
    fn a_text_that_is_too_long_loses_its_end_and_no_half_letter_stays() {
        let mut text = Text::new();
        for _ in 0..last_words::LENGTH - 1 {
            let _ = text.write_str("x");
        }
        let _ = text.write_str("\u{e9}and more");
        defmt::assert_eq!(text.as_str().len(), last_words::LENGTH - 1, "the two bytes of the accent do not fit");
        let mut exact = Text::new();
        for _ in 0..last_words::LENGTH {
            let _ = exact.write_char('y');
        }
        defmt::assert_eq!(exact.as_str().len(), last_words::LENGTH);
    }

    #[test]
    fn the_calendar_goes_on_from_where_it_is_set(bench: &mut Bench) {
        // The crystal may take two seconds to start.
        let leap = DateTime { year: 2028, month: 2, day: 28, hour: 23, minute: 59, second: 58 };
        sleep_fed(bench, 2_100);
        defmt::assert!(bench.rtc.set(leap), "the crystal runs");
        defmt::assert!(rtc::now() == leap || rtc::now().second == 59);
        sleep_fed(bench, 2_500);
        let DateTime { year, month, day, hour, minute, second } = rtc::now();
        defmt::assert_eq!((year, month, day), (2028, 2, 29), "a leap year");
        defmt::assert!(hour == 0 && minute == 0 && second <= 1, "{}:{}:{}", hour, minute, second);
    }
}
