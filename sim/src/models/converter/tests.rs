//! The chips as a data sheet's reader would try them.

use super::*;

const SECOND: u64 = 1_000_000_000;
const AT: Terminals = Terminals { sensor_c: 200.0, wiring: Wiring::Sound, leads: Leads::Sound, chip_c: 25.0 };

fn frame(chip: &mut Converter, at_ns: u64, terminals: Terminals, bytes: &[u8]) -> Vec<u8> {
    chip.select(at_ns, &terminals);
    let answer = bytes.iter().map(|byte| chip.transfer(*byte)).collect();
    chip.deselect(at_ns);
    answer
}

#[test]
fn a_max31855_gives_the_examples_of_its_tables() {
    let mut chip = Converter::new(Kind::Max31855, 0);
    assert_eq!(frame(&mut chip, SECOND / 10, AT, &[0; 4]), [0; 4], "before its first conversion");
    // Tables 4 and 5.
    for (sensor_c, chip_c, expected) in [
        (1_600.0, 127.0, 0x6400_7F00_u32),
        (100.75, 25.0, 0x064C_1900),
        (-250.0, -20.0, 0xF060_EC00),
        (-0.25, -0.0625, 0xFFFC_FFF0),
    ] {
        let read = frame(&mut chip, SECOND, Terminals { sensor_c, chip_c, ..AT }, &[0; 4]);
        assert_eq!(u32::from_be_bytes(read.try_into().unwrap()), expected, "{sensor_c}");
    }
    for (wiring, bits) in [(Wiring::Open, 1), (Wiring::Shorted, 2), (Wiring::ToSupply, 4)] {
        let read = frame(&mut chip, SECOND, Terminals { wiring, ..AT }, &[0; 4]);
        assert_eq!((read[1] & 1, read[3] & 7), (1, bits), "{wiring:?}");
    }
    for (data, byte) in [(DataLine::Silent, 0xFF), (DataLine::Low, 0)] {
        chip.data = data;
        assert_eq!(frame(&mut chip, SECOND, AT, &[0; 4]), [byte; 4]);
    }
}

#[test]
fn a_max31856_converts_once_it_is_told_to() {
    let mut chip = Converter::new(Kind::Max31856 { thermocouple: Thermocouple::K }, 0);
    let read =
        |chip: &mut Converter, at_ns, wiring| frame(chip, at_ns, Terminals { wiring, ..AT }, &[0x0C, 0, 0, 0, 0]);
    assert_eq!(read(&mut chip, SECOND, Wiring::Sound)[1..], [0; 4], "it stands");
    frame(&mut chip, SECOND, AT, &[0x80, 0x91, 0x03]);
    assert_eq!(chip.registers()[..3], [0x91, 0x03, 0xFF]);
    assert_eq!(read(&mut chip, SECOND + SECOND / 10, Wiring::Sound)[1..], [0; 4], "169 ms");
    assert_eq!(read(&mut chip, 2 * SECOND, Wiring::Sound)[1..], [0x0C, 0x80, 0x00, 0]);
    assert_eq!(read(&mut chip, 2 * SECOND, Wiring::Open)[4], 1);
    assert_eq!(read(&mut chip, 2 * SECOND, Wiring::ToSupply)[4], 2);
    // The same thermocouple taken for one of type J.
    frame(&mut chip, 2 * SECOND, AT, &[0x81, 0x02]);
    let celsius =
        f64::from(u16::from_be_bytes(read(&mut chip, 3 * SECOND, Wiring::Sound)[1..3].try_into().unwrap())) / 16.0;
    assert!((celsius - (25.0 + 175.0 * 41.276 / 57.953)).abs() < 0.1, "{celsius}");
    chip.reset(3 * SECOND);
    assert_eq!(chip.registers()[..3], [0, 3, 0xFF]);
}

#[test]
fn a_max31865_gives_the_ratio_and_keeps_its_faults() {
    let sensor = Curve::Platinum { r0_ohms: 100.0 };
    let mut chip = Converter::new(Kind::Max31865 { sensor, reference_ohms: 400.0 }, 0);
    let read = |chip: &mut Converter, at_ns, wiring| frame(chip, at_ns, Terminals { wiring, ..AT }, &[0; 9]);
    frame(&mut chip, 0, AT, &[0x83, 0xF0, 0x00, 0x08, 0x00]);
    frame(&mut chip, 0, AT, &[0x80, 0xC1]);
    assert_eq!(read(&mut chip, SECOND / 20, Wiring::Sound)[2..4], [0, 0], "66 ms");
    // Table 9: 200 C is 14406.
    let sound = read(&mut chip, SECOND, Wiring::Sound);
    assert_eq!(u16::from_be_bytes([sound[2], sound[3]]) >> 1, 14_406);
    for (wiring, bit) in [(Wiring::Open, 7), (Wiring::Shorted, 6), (Wiring::ToSupply, 2)] {
        assert_eq!(read(&mut chip, SECOND, wiring)[8], 1 << bit, "{wiring:?}");
        assert_eq!(read(&mut chip, SECOND, Wiring::Sound)[8], 1 << bit, "it is kept");
        frame(&mut chip, SECOND, AT, &[0x80, 0xC3]);
        assert_eq!(read(&mut chip, SECOND, Wiring::Sound)[8], 0, "it is cleared");
    }
}

/// The cycle needs the converter off, and its time; what it finds is kept as other faults are.
#[test]
fn a_max31865_finds_what_is_wrong_with_single_leads_when_it_is_asked() {
    for (leads, status, ratio) in [
        (Leads::Sound, 0, Some(14_406)),
        (Leads::ForceOpen, 1 << 5, Some(14_406)),
        (Leads::MinusToGround, 1 << 4 | 1 << 3, Some(14_406)),
        (Leads::PlusToGround, 1 << 6 | 1 << 3, Some(0)),
    ] {
        let sensor = Curve::Platinum { r0_ohms: 100.0 };
        let mut chip = Converter::new(Kind::Max31865 { sensor, reference_ohms: 400.0 }, 0);
        let read = |chip: &mut Converter, at_ns, leads| frame(chip, at_ns, Terminals { leads, ..AT }, &[0; 9]);
        frame(&mut chip, 0, AT, &[0x83, 0xF0, 0x00, 0x08, 0x00]);
        frame(&mut chip, 0, AT, &[0x80, 0xC1]);
        read(&mut chip, SECOND, Leads::Sound);
        let shown = read(&mut chip, SECOND, leads);
        assert_eq!(Some(u16::from_be_bytes([shown[2], shown[3]]) >> 1), ratio, "{leads:?}");
        assert_eq!(shown[8] & 0b11_1000, 0, "{leads:?}: not by a conversion");
        // Not while it converts.
        frame(&mut chip, SECOND, AT, &[0x80, 0xC5]);
        assert_eq!(read(&mut chip, 2 * SECOND, leads)[1], 0xC1);
        frame(&mut chip, 2 * SECOND, AT, &[0x80, 0x85]);
        assert_eq!(read(&mut chip, 2 * SECOND + 500_000, leads)[1], 0x85, "it runs");
        let found = read(&mut chip, 2 * SECOND + 700_000, leads);
        assert_eq!((found[1], found[8]), (0x81, status), "{leads:?}");
    }
}
