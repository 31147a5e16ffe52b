//! The board's pins by role, to be held next to the schematic (proto9/proto10, sheet named in brackets).
//! "act" is the level that means on.

use super::name::{PinName, PinSpec};

const fn pin(port: char, number: u8) -> PinName {
    PinName::new(port, number)
}

/// Pins of one on-board driver socket. Step acts high; chip select acts low; the StallGuard output is an
/// input of the processor.
#[derive(Clone, Copy, Debug)]
pub struct MotorPins {
    /// Every edge or every rising edge is a step, as the driver is set.
    pub step: PinName,
    /// Low is forward: what v2 boards and the machines built around them are wired for.
    pub direction: PinName,
    /// SPI4 chip select, 10 k pull-up on the board.
    pub select: PinName,
    /// SG_TST of the driver.
    pub stall: PinName,
}

/// The four on-board drivers, alpha to delta [smoothiev2-prime, driver].
pub const MOTORS: [MotorPins; 4] = [
    MotorPins { step: pin('D', 3), direction: pin('D', 4), select: pin('J', 13), stall: pin('K', 4) },
    MotorPins { step: pin('K', 2), direction: pin('G', 2), select: pin('G', 8), stall: pin('K', 5) },
    MotorPins { step: pin('G', 3), direction: pin('G', 4), select: pin('G', 7), stall: pin('J', 15) },
    MotorPins { step: pin('C', 6), direction: pin('G', 5), select: pin('G', 6), stall: pin('G', 9) },
];

/// Enable of all drivers (ENN), act low. Floats in reset: driven high first of all.
pub const MOTORS_ENABLE: PinSpec = PinSpec::inverted(pin('H', 13));
/// Output enable of the MOSFET and SSR buffer, act low, pulled up to 5 V: open-drain only, push-pull would
/// feed 5 V into the chip [mosfets].
pub const FETS_ENABLE: PinSpec = PinSpec { open_drain: true, ..PinSpec::inverted(pin('F', 14)) };
/// High-side switch of the hot ends' and fans' supply, act high, pulled down; the bed lies before it
/// [mosfets].
pub const FETS_POWER_ENABLE: PinSpec = PinSpec::plain(pin('D', 7));

/// Switches 5 V to the USB-A socket, act high. Nothing on the board pulls it, so it is driven low until
/// something uses the port.
pub const USB_HOST_POWER: PinSpec = PinSpec::plain(pin('B', 13));

/// MOSFET outputs, act high: hotend A, hotend B, bed, fan 1, fan 2 [mosfets].
pub const MOSFETS: [PinSpec; 5] = [
    PinSpec::plain(pin('E', 0)),
    PinSpec::plain(pin('B', 8)),
    PinSpec::plain(pin('E', 3)),
    PinSpec::plain(pin('E', 1)),
    PinSpec::plain(pin('I', 11)),
];
/// Solid-state relay outputs, act low: SSR1, SSR2 [mosfets].
pub const RELAYS: [PinSpec; 2] = [PinSpec::inverted(pin('I', 4)), PinSpec::inverted(pin('B', 7))];

/// Endstop inputs X min, X max, Y min, Y max, Z min, Z max. Open-drain buffers: the chip's pull-up is
/// mandatory [inputs].
pub const ENDSTOPS: [PinName; 6] = [pin('D', 0), pin('I', 3), pin('I', 1), pin('A', 9), pin('I', 0), pin('H', 15)];
/// Probe comparator, open collector: the chip's pull-up is mandatory; high from 2.9 V at the connector
/// [inputs].
pub const PROBE: PinName = pin('B', 10);

/// LED1 to LED4, act high.
pub const LEDS: [PinName; 4] = [pin('H', 9), pin('H', 10), pin('H', 11), pin('H', 12)];
/// The mass-storage LED, act high.
pub const MSC_LED: PinName = pin('F', 13);
/// Board identity resistors, bit 3 first; to ground = 1 [smoothiev2-prime].
pub const BOARD_ID: [PinName; 4] = [pin('E', 10), pin('F', 3), pin('F', 5), pin('F', 7)];

/// Hardware PWM: name, pin. PWM1 is TIM1 channel 1 to 4 (AF1), PWM2 is TIM8 channel 1 to 4 (AF3) [expansion,
/// GD and GC].
pub const PWM: [(&str, PinName); 8] = [
    ("PWM1_1", pin('E', 9)),
    ("PWM1_2", pin('E', 11)),
    ("PWM1_3", pin('E', 13)),
    ("PWM1_4", pin('E', 14)),
    ("PWM2_1", pin('I', 5)),
    ("PWM2_2", pin('I', 6)),
    ("PWM2_3", pin('I', 7)),
    ("PWM2_4", pin('I', 2)),
];

/// Pins with one fixed use, which a configuration may not have, and the name of that use.
pub const RESERVED: &[(PinName, &str)] = &[
    (pin('D', 11), "the QSPI flash"),
    (pin('F', 9), "the QSPI flash"),
    (pin('E', 2), "the QSPI flash"),
    (pin('D', 13), "the QSPI flash"),
    (pin('B', 6), "the QSPI flash"),
    (pin('B', 2), "the QSPI flash"),
    (pin('G', 10), "the SD card"),
    (pin('C', 8), "the SD card"),
    (pin('C', 9), "the SD card"),
    (pin('C', 10), "the SD card"),
    (pin('C', 11), "the SD card"),
    (pin('C', 12), "the SD card"),
    (pin('D', 2), "the SD card"),
    (pin('A', 1), "Ethernet"),
    (pin('A', 2), "Ethernet"),
    (pin('A', 7), "Ethernet"),
    (pin('G', 11), "Ethernet"),
    (pin('C', 1), "Ethernet"),
    (pin('C', 4), "Ethernet"),
    (pin('C', 5), "Ethernet"),
    (pin('G', 12), "Ethernet"),
    (pin('G', 13), "Ethernet"),
    (pin('B', 13), "the USB host port"),
    (pin('B', 14), "the USB host port"),
    (pin('B', 15), "the USB host port"),
    (pin('A', 10), "the USB port"),
    (pin('A', 11), "the USB port"),
    (pin('A', 12), "the USB port"),
    (pin('A', 13), "the debug port"),
    (pin('A', 14), "the debug port"),
    (pin('B', 3), "the debug port"),
    (pin('H', 0), "the crystal"),
    (pin('H', 1), "the crystal"),
    (pin('C', 14), "the clock crystal"),
    (pin('C', 15), "the clock crystal"),
    (pin('D', 5), "the debug console"),
    (pin('D', 6), "the debug console"),
    (pin('E', 12), "the motor drivers' SPI bus"),
    (pin('E', 5), "the motor drivers' SPI bus"),
    (pin('E', 6), "the motor drivers' SPI bus"),
];

/// A thermistor input of ADC1 [inputs].
#[derive(Clone, Copy, Debug)]
pub struct AnalogInput {
    /// Name in configuration files.
    pub name: &'static str,
    /// Channel of the converter.
    pub channel: u8,
    /// Pin of the input; `None` for PA0_C, a pad of its own without a digital side.
    pub pin: Option<PinName>,
}

/// The thermistor inputs: the on-board one, T1, T2, T3, and three raw header pins.
pub const THERMISTORS: [AnalogInput; 7] = [
    AnalogInput { name: "ADC1_0", channel: 0, pin: None },
    AnalogInput { name: "ADC1_1", channel: 2, pin: Some(pin('F', 11)) },
    AnalogInput { name: "ADC1_2", channel: 6, pin: Some(pin('F', 12)) },
    AnalogInput { name: "ADC1_3", channel: 9, pin: Some(pin('B', 0)) },
    AnalogInput { name: "ADC1_4", channel: 12, pin: Some(pin('C', 2)) },
    AnalogInput { name: "ADC1_5", channel: 13, pin: Some(pin('C', 3)) },
    AnalogInput { name: "ADC1_6", channel: 15, pin: Some(pin('A', 3)) },
];

/// The voltage and header inputs of ADC3 [power, mosfets, expansion], and three sources inside the chip
/// (RM0399 section 26.4.4, table of inputs).
pub const SUPPLIES: [AnalogInput; 9] = [
    AnalogInput { name: "ADC3_0", channel: 10, pin: Some(pin('C', 0)) },
    AnalogInput { name: "ADC3_1", channel: 6, pin: Some(pin('F', 10)) },
    AnalogInput { name: "ADC3_2", channel: 7, pin: Some(pin('F', 8)) },
    AnalogInput { name: "ADC3_3", channel: 8, pin: Some(pin('F', 6)) },
    AnalogInput { name: "ADC3_4", channel: 9, pin: Some(pin('F', 4)) },
    AnalogInput { name: "ADC3_5", channel: 16, pin: Some(pin('H', 5)) },
    AnalogInput { name: "chip temperature", channel: 18, pin: None },
    AnalogInput { name: "vref", channel: 19, pin: None },
    AnalogInput { name: "vbat", channel: 17, pin: None },
];
/// Index into [`SUPPLIES`] of the heaters' and fans' supply.
pub const VFET: usize = 2;
/// Index into [`SUPPLIES`] of the motors' supply.
pub const VMOTOR: usize = 5;
/// Index into [`SUPPLIES`] of the chip's temperature sensor.
pub const CHIP_TEMPERATURE: usize = 6;
/// Index into [`SUPPLIES`] of the chip's own 1.2 V reference.
pub const VREF: usize = 7;
/// Index into [`SUPPLIES`] of the pin for a coin cell.
pub const VBAT: usize = 8;
/// Divider of the coin cell's voltage, by a bridge inside the chip (RM0399 section 26.4.36).
pub const VBAT_DIVIDER: f32 = 4.0;
/// Both supplies come through 100 k over 10 k.
pub const SUPPLY_DIVIDER: f32 = 11.0;
