use super::*;

fn read(chip: &mut TmcStealth, address: u8) -> u32 {
    chip.transfer(0, [address, 0, 0, 0, 0]);
    let [_, data @ ..] = chip.transfer(0, [address, 0, 0, 0, 0]);
    u32::from_be_bytes(data)
}

#[test]
fn the_answer_comes_with_the_next_datagram() {
    let mut chip = TmcStealth::new(StealthKind::Tmc5160, false);
    chip.transfer(0, [0x6C, 0, 0, 0, 0]);
    assert_eq!(chip.transfer(0, [0x04, 0, 0, 0, 0])[1..], [0x10, 0x41, 0x01, 0x50]);
    assert_eq!(chip.transfer(0, [0xEC, 1, 2, 3, 4])[1..], [0x30, 0, 0, 0]);
    assert_eq!(chip.transfer(0, [0, 0, 0, 0, 0])[1..], [1, 2, 3, 4], "what was written");
}

#[test]
fn a_reset_is_flagged_until_it_is_cleared_as_each_chip_wants_it() {
    for kind in [StealthKind::Tmc5160, StealthKind::Tmc2240] {
        let mut chip = TmcStealth::new(kind, false);
        assert_eq!((read(&mut chip, 1), read(&mut chip, 1)), (1, 1));
        chip.transfer(0, [0x81, 0, 0, 0, 1]);
        assert_eq!(read(&mut chip, 1), 0);
    }
    let mut chip = TmcStealth::new(StealthKind::Tmc2130, false);
    chip.transfer(0, [1, 0, 0, 0, 0]);
    assert_eq!(chip.transfer(0, [1, 0, 0, 0, 0])[4], 1);
    assert_eq!(chip.transfer(0, [1, 0, 0, 0, 0])[4], 0, "reading clears");
}

#[test]
fn shorts_and_heat_shut_the_bridges() {
    let mut chip = TmcStealth::new(StealthKind::Tmc5160, false);
    chip.transfer(0, [0xEC, 0, 0, 0, 3]);
    assert!(chip.drives());
    chip.condition.short_to_supply[0] = true;
    assert_eq!(read(&mut chip, 0x6F) & 1 << 12, 1 << 12);
    assert!(!chip.drives());
    chip.condition.short_to_supply[0] = false;
    chip.transfer(0, [0xEC, 0, 0, 0, 0]);
    chip.transfer(0, [0xEC, 0, 0, 0, 3]);
    assert!(chip.drives(), "off and on again");
    chip.condition.temperature_c = 155;
    assert_eq!(read(&mut chip, 0x6F) >> 25 & 0b11, 0b11);
    assert!(!chip.drives());
}

/// TMC2209 datasheet Rev. 1.03, chapter 5: it works as it is, by its pins, until somebody says otherwise.
#[test]
fn a_chip_on_a_uart_drives_from_power_on() {
    let chip = TmcStealth::on_wire(StealthKind::Tmc2209, 1, false);
    assert!(chip.drives());
    assert_eq!((chip.microsteps(), chip.register(0x10)), (32, 0x0001_1F10));
}

#[test]
fn a_stall_is_shown_where_and_how_each_family_does() {
    // stallGuard2: DIAG is enabled, spreadCycle drives, and steps are fast enough.
    let mut chip = TmcStealth::new(StealthKind::Tmc5160, false);
    for datagram in [[0xEC, 4, 0, 0, 3], [0x80, 0, 0, 1, 0x80], [0x94, 0, 0x0F, 0xFF, 0xFF]] {
        chip.transfer(0, datagram);
    }
    chip.load = 0;
    assert!(!chip.stall_output(0), "it stands");
    for step in 1..4_u64 {
        chip.step_edge(step * 1_000_000, true, false);
    }
    assert!(chip.stall_output(3_000_000));
    chip.load = 1;
    assert!(!chip.stall_output(3_000_000));
    chip.transfer(0, [0x80, 0, 0, 1, 0x84]);
    chip.load = 0;
    assert!(!chip.stall_output(3_000_000), "stealthChop drives");
    // stallGuard4: stealthChop drives; up to twice the threshold.
    let mut chip = TmcStealth::on_wire(StealthKind::Tmc2209, 0, false);
    for (register, word) in [(0x00, 0x1C0), (0x14, 0xF_FFFF), (0x40, 30)] {
        chip.write_wire(register, word);
    }
    for step in 1..4_u64 {
        chip.step_edge(step * 1_000_000, true, false);
    }
    for (load, stalls) in [(60, true), (61, false)] {
        chip.load = load;
        assert_eq!(chip.stall_output(3_000_000), stalls);
    }
    chip.write_wire(0x00, 0x1C4);
    chip.load = 0;
    assert!(!chip.stall_output(3_000_000), "spreadCycle drives");
}
