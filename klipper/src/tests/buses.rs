//! Chips on buses, serial lines of drivers, strips of lights.

use crate::desk::{Bench, LineAnswer};
use crate::{Command, Reason, Response};

fn i2c(address: u32) -> Bench {
    let mut bench = Bench::with_oids(1);
    bench.tell(Command::ConfigI2c, &[0]);
    bench.tell(Command::I2cSetSwBus, &[0, 1, 2, 1000, address]);
    bench.finalize();
    bench
}

/// Makes a transfer, and returns its status and bytes.
fn transfer(bench: &mut Bench, write: &[u8], read_length: u32) -> (u32, Vec<u8>) {
    let mut content = Bench::message(Command::I2cTransfer, &[0], Some(write));
    content.push(read_length as u8);
    let said = bench.block(&content);
    let (_, words, bytes) = said.into_iter().find(|(kind, ..)| *kind == Response::I2cOutcome).expect("an answer");
    (words[1], bytes)
}

#[test]
fn a_chip_on_two_wires_is_written_and_read() {
    let mut bench = i2c(0x42);
    assert_eq!(transfer(&mut bench, &[7, 8, 0xA5], 0), (0, vec![]));
    assert_eq!(bench.wires.chip.borrow().received, [7, 8, 0xA5]);
    assert_eq!(transfer(&mut bench, &[9], 3), (0, vec![1, 2, 3]));
    assert_eq!(bench.wires.chip.borrow().received, [7, 8, 0xA5, 9]);
    assert_eq!(bench.wires.chip.borrow().stops, 2);
}

#[test]
fn a_chip_that_is_not_there_is_no_shutdown() {
    let mut bench = i2c(0x41);
    assert_eq!(transfer(&mut bench, &[7], 0), (3, vec![]));
    assert_eq!(transfer(&mut bench, &[], 2), (4, vec![]));
    assert_eq!(bench.tell(Command::GetClock, &[]).len(), 1);
}

/// Bits of a byte on a serial line.
fn framed(byte: u8) -> impl Iterator<Item = bool> {
    let data = (0..8).map(move |bit| byte >> bit & 1 != 0);
    std::iter::once(false).chain(data).chain(std::iter::once(true))
}

fn packed(bits: &[bool]) -> Vec<u8> {
    bits.chunks(8).map(|chunk| chunk.iter().rev().fold(0, |byte, bit| byte << 1 | u8::from(*bit))).collect()
}

/// A driver's answer, whose clock is off by so many per mille, as the host gets it.
fn answered(off_by: i32) -> (Vec<u8>, Vec<u8>) {
    const BIT: u32 = 5000;
    let mut bench = Bench::with_oids(1);
    bench.tell(Command::ConfigTmcuart, &[0, 40, 1, 40, BIT]);
    bench.finalize();
    let request: Vec<_> = [0x05, 0x00, 0x06, 0x6F].into_iter().flat_map(framed).collect();
    let answer: Vec<_> = [0x05, 0xFF, 0x06, 0x20, 0x00, 0x00, 0x01, 0x3C].into_iter().flat_map(framed).collect();
    let begin = bench.now();
    let mut content = Bench::message(Command::TmcuartSend, &[0], Some(&packed(&request)));
    content.push(10);
    bench.block(&content);
    // 200 us, 40 bits, and some more.
    let answers_at = begin.wrapping_add(40_000 + 40 * BIT + 9 * BIT + 1234);
    let bit_ticks = (BIT as i32 + BIT as i32 * off_by / 1000) as u32;
    *bench.wires.answer.borrow_mut() = Some(LineAnswer { pin: 40, begin: answers_at, bit_ticks, bits: answer.clone() });
    bench.pass(40_000 + 150 * BIT);
    let said = bench.heard();
    let (_, _, bits) = said.into_iter().find(|(kind, ..)| *kind == Response::TmcuartAnswer).expect("an answer");
    // The bits that were written, by the edges of the line.
    let mut level = true;
    let mut edges = bench
        .wires
        .written
        .borrow()
        .iter()
        .map(|(at, _, high)| (*at, *high))
        .collect::<Vec<_>>()
        .into_iter()
        .peekable();
    let written: Vec<_> = (0..request.len() as u32)
        .map(|place| {
            let middle = begin.wrapping_add(40_000 + place * BIT + BIT / 2);
            while edges.peek().is_some_and(|(at, _)| (at.wrapping_sub(middle) as i32) < 0) {
                level = edges.next().expect("an edge").1;
            }
            level
        })
        .collect();
    assert_eq!(written, request);
    (bits, packed(&answer))
}

#[test]
fn a_driver_s_answer_is_read_though_its_clock_is_off() {
    for off_by in [-30, -10, 0, 10, 30] {
        let (read, answer) = answered(off_by);
        assert_eq!(read, answer, "{off_by} per mille");
    }
}

#[test]
fn a_driver_that_does_not_answer_costs_an_empty_answer() {
    let mut bench = Bench::with_oids(1);
    bench.tell(Command::ConfigTmcuart, &[0, 40, 1, 41, 5000]);
    bench.finalize();
    let mut content = Bench::message(Command::TmcuartSend, &[0], Some(&[0x55; 5]));
    content.push(10);
    bench.block(&content);
    bench.pass(2_000_000);
    assert!(bench.heard().contains(&(Response::TmcuartAnswer, vec![0], vec![])));
}

#[test]
fn lights_get_their_colours_or_the_host_is_told() {
    let mut bench = Bench::with_oids(2);
    bench.tell(Command::ConfigNeopixel, &[0, 73, 6, 800, 10_000]);
    bench.finalize();
    bench.tell_bytes(Command::NeopixelUpdate, &[0, 3], &[7, 8, 9]);
    assert_eq!(bench.tell(Command::NeopixelSend, &[0])[0], (Response::NeopixelResult, vec![0, 1], vec![]));
    assert_eq!(*bench.wires.strips.borrow(), [vec![0, 0, 0, 7, 8, 9]]);
    bench.wires.strip_is_busy.set(true);
    assert_eq!(bench.tell(Command::NeopixelSend, &[0])[0].1, [0, 0]);
    let said = bench.tell_bytes(Command::NeopixelUpdate, &[0, 4], &[7, 8, 9]);
    let reason = u32::from(Reason::LightsUpdate.number());
    assert!(matches!(&said[..], [(Response::Shutdown, words, _)] if words[1] == reason), "{said:?}");
}

#[test]
fn a_chip_at_three_pins_is_clocked_in_each_mode() {
    for mode in 0..4 {
        let mut bench = Bench::with_oids(1);
        bench.tell(Command::ConfigSpi, &[0, 20, 0]);
        bench.tell(Command::SpiSetSwBus, &[0, 21, 22, 23, mode, 100]);
        bench.finalize();
        bench.wires.levels.borrow_mut().insert(21, true);
        let said = bench.tell_bytes(Command::SpiTransfer, &[0], &[0xA6]);
        assert_eq!(said[0].2, [0xFF]);
        // The chip takes a bit at each rising edge in modes 0 and 3, at each falling one in 1 and 2.
        let rises = mode == 0 || mode == 3;
        let (mut data, mut byte, mut selected) = (false, 0_u8, false);
        for (_, pin, high) in bench.wires.changes.borrow().iter() {
            match pin {
                20 => selected = !high,
                22 => data = *high,
                23 if *high == rises && selected => byte = byte << 1 | u8::from(data),
                _ => {}
            }
        }
        assert_eq!(byte, 0xA6, "mode {mode}");
    }
}

#[test]
fn a_chip_answers_in_turn_and_has_the_last_word() {
    let mut bench = Bench::with_oids(2);
    bench.tell(Command::ConfigSpi, &[0, 9 * 16 + 13, 0]);
    // Before its bus is set, a chip gets nothing.
    assert!(bench.tell_bytes(Command::SpiTransfer, &[0], &[1]).is_empty());
    bench.tell(Command::SpiSetBus, &[0, 1, 3, 4_000_000]);
    bench.tell_bytes(Command::ConfigSpiShutdown, &[1, 0], &[0xE]);
    bench.finalize();
    let mut content = Bench::message(Command::SpiTransfer, &[0], Some(&[1, 2, 3]));
    content.extend(Bench::message(Command::SpiSend, &[0], Some(&[4, 5])));
    content.extend(Bench::message(Command::GetClock, &[], None));
    let kinds: Vec<_> = bench.block(&content).into_iter().map(|(kind, _, bytes)| (kind, bytes)).collect();
    assert_eq!(kinds, [(Response::SpiTransferred, vec![3, 2, 1]), (Response::Clock, vec![])]);
    bench.tell(Command::EmergencyStop, &[]);
    let select = Some(9 * 16 + 13);
    assert_eq!(*bench.wires.spi.borrow(), [(select, vec![1, 2, 3]), (select, vec![4, 5]), (select, vec![0xE])]);
}
