//! Wiring of the board: the pins behind drivers, outputs, inputs and converters. Names of pins are the
//! chip's: `PD3`.

/// Socket of an on-board motor driver.
#[derive(Clone, Copy, Debug)]
pub struct DriverSocket {
    /// Pin of the STEP signal.
    pub step: &'static str,
    /// Pin of the DIR signal.
    pub direction: &'static str,
    /// Pin of the chip select, low selects; 10 kOhm to 3.3 V (RN6).
    pub select: &'static str,
    /// Pin of the chip's stallGuard output.
    pub stall: &'static str,
}

/// The drivers, alpha to delta. Schematic: smoothiev2-prime, sheets driver-a to driver-d.
pub const DRIVERS: [DriverSocket; 4] = [
    DriverSocket { step: "PD3", direction: "PD4", select: "PJ13", stall: "PK4" },
    DriverSocket { step: "PK2", direction: "PG2", select: "PG8", stall: "PK5" },
    DriverSocket { step: "PG3", direction: "PG4", select: "PG7", stall: "PJ15" },
    DriverSocket { step: "PC6", direction: "PG5", select: "PG6", stall: "PG9" },
];

/// Level of a plain direction pin while a motor counts up: low, at every socket, for external drivers and
/// slaves. Known good: the firmware of running boards, and the machines built around them.
pub const UP_IS_HIGH: bool = false;

/// ENN of all four drivers: low enables. Nothing on the board pulls it.
pub const MOTORS_ENABLE: &str = "PH13";
/// Enable of the 74HCT541 that drives MOSFETs and relay outputs: low enables, 4.7 kOhm to 5 V (R80).
pub const OUTPUT_BUFFER_ENABLE: &str = "PF14";
/// Gate of Q26, which switches Q25 on: high switches on, 10 kOhm to ground (R93).
pub const SUPPLY_SWITCH: &str = "PD7";
/// Enable of the USB-A socket's 5 V (U16): high switches on. Nothing on the board pulls it.
pub const USB_HOST_POWER: &str = "PB13";

/// Source of the current of a power output's load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// From the heaters' supply through Q25, which [`SUPPLY_SWITCH`] opens.
    Switched,
    /// From the heaters' supply straight: only its own MOSFETs are in the way.
    Direct,
    /// From the board's 5 V, through a P channel MOSFET of its own.
    FiveVolts,
}

/// An output behind the buffer.
#[derive(Clone, Copy, Debug)]
pub struct PowerOutput {
    /// Name on the board.
    pub name: &'static str,
    /// Pin of the output.
    pub pin: &'static str,
    /// Whether the high level means on.
    pub on_high: bool,
    /// Feed of the output's load.
    pub feed: Feed,
}

const fn output(name: &'static str, pin: &'static str, on_high: bool, feed: Feed) -> PowerOutput {
    PowerOutput { name, pin, on_high, feed }
}

/// Hot ends, bed, fans and relay outputs. Schematic: sheet mosfets. Q25 lies between the supply's connectors
/// (J11, J12, J16) and J17 to J20; the bed's connectors (J13, J14) lie on the supply itself.
pub const POWER_OUTPUTS: [PowerOutput; 7] = [
    output("hotend A", "PE0", true, Feed::Switched),
    output("hotend B", "PB8", true, Feed::Switched),
    output("bed", "PE3", true, Feed::Direct),
    output("fan 1", "PE1", true, Feed::Switched),
    output("fan 2", "PI11", true, Feed::Switched),
    output("SSR 1", "PI4", false, Feed::FiveVolts),
    output("SSR 2", "PB7", false, Feed::FiveVolts),
];

/// Returns the power output on this pin.
#[must_use]
pub fn power_output(pin: &str) -> Option<&'static PowerOutput> {
    POWER_OUTPUTS.iter().find(|output| output.pin == pin)
}

/// End stop inputs: name and pin. Schematic: sheet inputs; 10 kOhm to 5 V and 100 nF at the connector, then a
/// 74LCX07, which does not invert and only pulls low.
pub const END_STOPS: [(&str, &str); 6] =
    [("X min", "PD0"), ("X max", "PI3"), ("Y min", "PI1"), ("Y max", "PA9"), ("Z min", "PI0"), ("Z max", "PH15")];
/// Probe: an LMV331 that pulls low below 2.9 V at the connector.
pub const PROBE: &str = "PB10";
/// LED1 to LED4, and the mass-storage LED: high lights.
pub const LEDS: [&str; 5] = ["PH9", "PH10", "PH11", "PH12", "PF13"];
/// Identity straps, bit 0 first: to ground is a one.
pub const BOARD_ID: [&str; 4] = ["PF7", "PF5", "PF3", "PE10"];

/// A resistive or divided voltage on a converter's input.
#[derive(Clone, Copy, Debug)]
pub struct AnalogInput {
    /// Name in configuration files.
    pub name: &'static str,
    /// Converter, 1 or 3.
    pub converter: u8,
    /// Number of the INP channel.
    pub channel: u8,
    /// Pin of the input; none for PA0_C, a pad of its own.
    pub pin: Option<&'static str>,
}

const fn input(name: &'static str, converter: u8, channel: u8, pin: Option<&'static str>) -> AnalogInput {
    AnalogInput { name, converter, channel, pin }
}

/// Thermistor inputs: the one on the board, connectors T1 to T3 (J21 to J23), and three raw header pins.
/// Schematic: sheet inputs; DS12923, pin definitions.
pub const THERMISTORS: [AnalogInput; 7] = [
    input("ADC1_0", 1, 0, None),
    input("ADC1_1", 1, 2, Some("PF11")),
    input("ADC1_2", 1, 6, Some("PF12")),
    input("ADC1_3", 1, 9, Some("PB0")),
    input("ADC1_4", 1, 12, Some("PC2")),
    input("ADC1_5", 1, 13, Some("PC3")),
    input("ADC1_6", 1, 15, Some("PA3")),
];
/// Upper half of each thermistor's divider (RN3), ohms; the thermistor is the lower half.
pub const THERMISTOR_PULL_UP_OHMS: f64 = 4_700.0;
/// Voltage of the dividers' feed, V; VREF+ is the same net, so that ratios are exact.
pub const ANALOG_REFERENCE_VOLTS: f64 = 3.3;

/// The heaters' supply, measured before Q25, so it is there whether or not the switch is on. Schematic:
/// FETSENSE, R69 to R71.
pub const HEATER_SUPPLY: AnalogInput = input("vfet", 3, 7, Some("PF8"));
/// The motors' supply. Schematic: VMOTSENSE, R60 to R62.
pub const MOTOR_SUPPLY: AnalogInput = input("vmotor", 3, 16, Some("PH5"));
/// Ratio of the dividers of both supplies: 100 kOhm over 10 kOhm.
pub const SUPPLY_DIVIDER: f64 = 11.0;

/// Outputs of the timers TIM1 (PWM1) and TIM8 (PWM2), channels 1 to 4, on the headers GD and GC.
pub const PWM: [[&str; 4]; 2] = [["PE9", "PE11", "PE13", "PE14"], ["PI5", "PI6", "PI7", "PI2"]];
/// The alternate function that makes a pin the timer's output (STM32H745 data sheet, DS12923, alternate
/// functions).
pub const PWM_FUNCTIONS: [u8; 2] = [1, 3];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Every pin that the wiring names, with what it is for.
    fn pins() -> Vec<(&'static str, String)> {
        let drivers = DRIVERS.iter().enumerate().flat_map(|(place, socket)| {
            let pins = [socket.step, socket.direction, socket.select, socket.stall];
            pins.map(|pin| (pin, format!("driver {place}")))
        });
        let switches = [MOTORS_ENABLE, OUTPUT_BUFFER_ENABLE, SUPPLY_SWITCH, USB_HOST_POWER, PROBE];
        let switches = switches.into_iter().chain(LEDS).chain(BOARD_ID).map(|pin| (pin, "a switch".into()));
        let outputs = POWER_OUTPUTS.iter().map(|output| (output.pin, output.name.into()));
        let stops = END_STOPS.iter().map(|(name, pin)| (*pin, (*name).into()));
        let analog = THERMISTORS.iter().chain([&HEATER_SUPPLY, &MOTOR_SUPPLY]);
        let analog = analog.filter_map(|input| Some((input.pin?, input.name.into())));
        let timers = PWM.into_iter().flatten().map(|pin| (pin, "a timer".into()));
        drivers.chain(switches).chain(outputs).chain(stops).chain(analog).chain(timers).collect()
    }

    #[test]
    fn every_pin_is_wired_to_one_thing() {
        let mut seen = BTreeSet::new();
        for (pin, use_of_it) in pins() {
            assert!(seen.insert(pin), "{pin} of {use_of_it} is wired twice");
        }
    }

    #[test]
    fn pins_are_named_as_the_chip_names_them() {
        for (pin, use_of_it) in pins() {
            let (port, number) = pin.split_at(2);
            let is_port = ('A'..='K').any(|letter| port == format!("P{letter}"));
            assert!(is_port && number.parse::<u8>().is_ok_and(|number| number < 16), "{pin} of {use_of_it}");
        }
    }

    #[test]
    fn a_power_output_is_found_by_its_pin_and_nothing_else_is() {
        for output in &POWER_OUTPUTS {
            assert_eq!(power_output(output.pin).map(|found| found.name), Some(output.name));
        }
        for pin in [DRIVERS[0].step, PROBE, SUPPLY_SWITCH, "", "PE"] {
            assert!(power_output(pin).is_none(), "{pin}");
        }
    }

    #[test]
    fn each_axis_has_two_end_stops_of_its_own_names() {
        let names: BTreeSet<_> = END_STOPS.iter().map(|(name, _)| *name).collect();
        let all = ["X", "Y", "Z"].into_iter().flat_map(|axis| [format!("{axis} max"), format!("{axis} min")]);
        assert!(all.eq(names.into_iter().map(str::to_string)));
    }

    #[test]
    fn no_channel_of_a_converter_measures_two_things() {
        let inputs = THERMISTORS.iter().chain([&HEATER_SUPPLY, &MOTOR_SUPPLY]);
        let channels: BTreeSet<_> = inputs.clone().map(|input| (input.converter, input.channel)).collect();
        assert_eq!(channels.len(), inputs.clone().count());
        assert!(inputs.clone().all(|input| [1, 3].contains(&input.converter) && input.channel < 20));
    }
}
