//! Allowed and forbidden uses of the Prime's pins.

use crate::pin::{Pin, PinName, Pull, VoltageInput};
use units::Actuator;

/// A pad of the chip: port (0 for A) and number.
pub(crate) type Pad = (u8, u8);

/// Pads no configuration may use, by their fixed use. Source: Smoothieboard v2 Prime schematic, proto10.
const RESERVED: &[(&str, &[(char, u8)])] = &[
    ("the QSPI flash", &[('D', 11), ('F', 9), ('E', 2), ('D', 13), ('B', 6), ('B', 2)]),
    ("the SD card", &[('G', 10), ('C', 8), ('C', 9), ('C', 10), ('C', 11), ('C', 12), ('D', 2)]),
    ("Ethernet", &[('A', 1), ('A', 2), ('A', 7), ('G', 11), ('C', 1), ('C', 4), ('C', 5), ('G', 12), ('G', 13)]),
    ("the USB host port", &[('B', 13), ('B', 14), ('B', 15)]),
    ("USB", &[('A', 10), ('A', 11), ('A', 12)]),
    ("the debug probe", &[('A', 13), ('A', 14), ('B', 3)]),
    ("the crystals", &[('H', 0), ('H', 1), ('C', 14), ('C', 15)]),
    ("the debug UART", &[('D', 5), ('D', 6)]),
    ("the board's lamps", &[('H', 9), ('H', 10), ('H', 11), ('H', 12)]),
];

/// Returns the fixed use of a pin on the board, which no configuration can change.
#[must_use]
pub fn reserved_for(pin: Pin) -> Option<&'static str> {
    named(RESERVED, (pin.port, pin.number))
}

/// Whether a pad has this name.
pub(crate) fn is_pad(pad: Pad, port: char, number: u8) -> bool {
    let named = Pin::new(port, number);
    pad == (named.port, named.number)
}

const fn pad(port: char, number: u8) -> Pad {
    let pin = Pin::new(port, number);
    (pin.port, pin.number)
}

/// PA0_C, an analog ball of its own beside PA0. Ports of configurations end with K.
const PA0_C: Pad = (u8::MAX, 0);

/// Pads of `ADC1_0` to `ADC1_6`.
const THERMISTOR_PADS: [Pad; 7] =
    [PA0_C, pad('F', 11), pad('F', 12), pad('B', 0), pad('C', 2), pad('C', 3), pad('A', 3)];
const VOLTAGE_PADS: [Pad; 6] = [pad('C', 0), pad('F', 10), pad('F', 8), pad('F', 6), pad('F', 4), pad('H', 5)];
const PWM_PADS: [[Pad; 4]; 2] =
    [[pad('E', 9), pad('E', 11), pad('E', 13), pad('E', 14)], [pad('I', 5), pad('I', 6), pad('I', 7), pad('I', 2)]];

/// The pad a name stands for.
pub(crate) fn pad_of(name: PinName) -> Option<Pad> {
    match name {
        PinName::Digital(pin) => Some((pin.port, pin.number)),
        PinName::External => None,
        PinName::Thermistor(input) => THERMISTOR_PADS.get(usize::from(input.0)).copied(),
        PinName::Pwm(pwm) => {
            let timer = PWM_PADS.get(usize::from(pwm.timer).checked_sub(1)?)?;
            timer.get(usize::from(pwm.channel).checked_sub(1)?).copied()
        }
    }
}

/// The pad of a voltage input.
pub(crate) fn voltage_pad(input: VoltageInput) -> Option<Pad> {
    VOLTAGE_PADS.get(usize::from(input.0)).copied()
}

/// Pads of the SPI buses: clock, in, out.
pub(crate) const fn spi_pads(channel: u8) -> (&'static str, [Pad; 3]) {
    if channel == 0 {
        ("SPI bus 0", [pad('A', 5), pad('A', 6), pad('B', 5)])
    } else {
        ("SPI bus 1", [pad('E', 12), pad('E', 5), pad('E', 6)])
    }
}

/// Pads of the auxiliary UARTs: receive, send.
pub(crate) const fn uart_pads(channel: u8) -> [Pad; 2] {
    if channel == 0 { [pad('B', 11), pad('D', 8)] } else { [pad('H', 14), pad('B', 9)] }
}

/// The FET buffer's enable: pulled up to 5 V, so a push-pull output would be driven from outside.
pub(crate) const NEEDS_OPEN_DRAIN: Pad = pad('F', 14);
/// Pads that something on the board drives: as outputs they would work against it. Source: Smoothieboard v2
/// Prime schematic, proto10, sheets smoothiev2-prime (SW2), inputs (74LCX07, LMV331) and driver (SG_TST).
const DRIVEN: &[(&str, &[(char, u8)])] = &[
    ("the boot button", &[('J', 14)]),
    ("the end stops' buffer", &[('D', 0), ('I', 3), ('I', 1), ('A', 9), ('I', 0), ('H', 15)]),
    ("the probe's comparator", &[('B', 10)]),
    ("a motor driver's stallGuard line", &[('K', 4), ('K', 5), ('J', 15), ('G', 9)]),
];

/// The stallGuard outputs of the on-board drivers, alpha to delta.
const STALL_PINS: [Pin; 4] = [Pin::new('K', 4), Pin::new('K', 5), Pin::new('J', 15), Pin::new('G', 9)];

/// Returns the input with the stall signal of a motor's on-board driver. The chip drives it, so it needs no
/// pull.
pub(crate) fn stall_pin(motor: Actuator) -> Option<Pin> {
    STALL_PINS.get(motor as usize).map(|pin| Pin { pull: Pull::None, ..*pin })
}

/// Returns the part of the board that drives a pin, so that the pin cannot be an output.
#[must_use]
pub fn driven_by(pin: Pin) -> Option<&'static str> {
    named(DRIVEN, (pin.port, pin.number))
}

fn named(table: &[(&'static str, &[(char, u8)])], pad: Pad) -> Option<&'static str> {
    let here = |pads: &[(char, u8)]| pads.iter().any(|&(port, number)| is_pad(pad, port, number));
    table.iter().find(|(_, pads)| here(pads)).map(|&(what, _)| what)
}

/// Voltage across the sense resistor at full scale. TMC2590 datasheet section "Sense resistor", as
/// Smoothieware uses it.
pub(crate) const TMC2590_SENSE_VOLTS: f32 = 0.325;
/// Voltage across the sense resistor at full scale, for the TMC2660.
pub(crate) const TMC2660_SENSE_VOLTS: f32 = 0.310;
