//! Pins as a configuration names them: `PD0^`, `PE1!`, `ADC1_3`, `PWM1_2`.
//!
//! A name is a claim, not a handle: the board package turns claims into pins it owns.

use core::fmt;

/// Electrical pull of an input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pull {
    /// The text named none: inputs take a pull-up, outputs take none.
    #[default]
    Default,
    /// Pull-up resistor, written `^`.
    Up,
    /// Pull-down resistor, written `v`.
    Down,
    /// No pull resistor, written `-`.
    None,
}

/// A digital pin and how it is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Port, 0 for A to 10 for K.
    pub port: u8,
    /// Number within the port, 0 to 15.
    pub number: u8,
    /// `!`: the logical level is the opposite of the electrical one.
    pub inverted: bool,
    /// `o`: an output only pulls low.
    pub open_drain: bool,
    /// Pull resistor, for inputs.
    pub pull: Pull,
}

impl Pin {
    /// A plain pin, as in `Pin::new('D', 3)`. Callers give a port letter A to K.
    #[must_use]
    pub const fn new(port: char, number: u8) -> Self {
        Self { port: port as u8 - b'A', number, inverted: false, open_drain: false, pull: Pull::Default }
    }

    /// Returns the port's letter.
    #[must_use]
    pub const fn port_letter(self) -> char {
        (b'A' + self.port) as char
    }

    /// Returns whether both names mean the same pad, whatever their modifiers.
    #[must_use]
    pub const fn is_same_pad(self, other: Self) -> bool {
        self.port == other.port && self.number == other.number
    }
}

/// `PD0!^`: the form Smoothieware prints, modifiers in the order `o ! ^ v -`.
impl fmt::Display for Pin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{}{}", self.port_letter(), self.number)?;
        if self.open_drain {
            f.write_str("o")?;
        }
        if self.inverted {
            f.write_str("!")?;
        }
        f.write_str(match self.pull {
            Pull::Default => "",
            Pull::Up => "^",
            Pull::Down => "v",
            Pull::None => "-",
        })
    }
}

/// A thermistor input `ADC1_0` to `ADC1_6`; the number is the board's name, not the converter's channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThermistorInput(pub u8);

/// A voltage input `ADC3_0` to `ADC3_5`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VoltageInput(pub u8);

/// A hardware PWM output `PWM1_1` to `PWM2_4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PwmOutput {
    /// Timer, 1 (TIM1) or 2 (TIM8).
    pub timer: u8,
    /// Channel of the timer, 1 to 4.
    pub channel: u8,
}

/// Output of a switch's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputPin {
    /// A GPIO, on or off or sigma-delta modulated.
    Digital(Pin),
    /// A channel of a PWM timer.
    Pwm(PwmOutput),
}

/// Anything a pin setting can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinName {
    /// Digital pin such as `PD3`, with modifiers.
    Digital(Pin),
    /// PWM output such as `PWM1_2`.
    Pwm(PwmOutput),
    /// Thermistor input such as `ADC1_3`.
    Thermistor(ThermistorInput),
    /// `external`: no pin of the board, but a key of a panel.
    External,
}

impl PinName {
    /// Returns the bare name, for messages about the pad itself.
    pub(crate) const fn without_modifiers(self) -> Self {
        match self {
            Self::Digital(Pin { port, number, .. }) => {
                Self::Digital(Pin { port, number, inverted: false, open_drain: false, pull: Pull::Default })
            }
            other => other,
        }
    }

    /// The GPIO, when it is one.
    #[must_use]
    pub const fn digital(self) -> Option<Pin> {
        match self {
            Self::Digital(pin) => Some(pin),
            _ => None,
        }
    }

    /// The thermistor input, when it is one.
    #[must_use]
    pub const fn thermistor(self) -> Option<ThermistorInput> {
        match self {
            Self::Thermistor(input) => Some(input),
            _ => None,
        }
    }

    /// The output, when it is one.
    #[must_use]
    pub const fn output(self) -> Option<OutputPin> {
        match self {
            Self::Digital(pin) => Some(OutputPin::Digital(pin)),
            Self::Pwm(pwm) => Some(OutputPin::Pwm(pwm)),
            Self::Thermistor(_) | Self::External => None,
        }
    }
}

impl fmt::Display for PinName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Digital(pin) => pin.fmt(f),
            Self::Pwm(pwm) => write!(f, "PWM{}_{}", pwm.timer, pwm.channel),
            Self::Thermistor(input) => write!(f, "ADC1_{}", input.0),
            Self::External => f.write_str("external"),
        }
    }
}

/// Reason why a text names no pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinFlaw {
    /// The text begins like no pin.
    NotAPin,
    /// Ports are A to K.
    NoSuchPort(char),
    /// Numbers are 0 to 15.
    NoSuchNumber,
    /// Modifiers are `!`, `o`, `^`, `v` and `-`.
    NoSuchModifier(char),
    /// Two pulls at once.
    TwoPulls,
    /// ADC1 has inputs 0 to 6.
    NoSuchAdc,
    /// PWM1 and PWM2 have channels 1 to 4.
    NoSuchPwm,
}

impl fmt::Display for PinFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAPin => f.write_str("is not a pin name"),
            Self::NoSuchPort(port) => write!(f, "names port {port}, but ports are A to K"),
            Self::NoSuchNumber => f.write_str("needs a number from 0 to 15 after the port letter"),
            Self::NoSuchModifier(character) => write!(f, "has '{character}', which is not a pin modifier"),
            Self::TwoPulls => f.write_str("asks for two pulls at once"),
            Self::NoSuchAdc => f.write_str("is not a thermistor input: there are ADC1_0 to ADC1_6"),
            Self::NoSuchPwm => f.write_str("is not a PWM output: there are PWM1_1 to PWM1_4 and PWM2_1 to PWM2_4"),
        }
    }
}

/// Reads a pin's name; none for `nc` and for an empty text.
pub fn parse_pin(text: &str) -> Result<Option<PinName>, PinFlaw> {
    let has_prefix = |prefix: &str| text.get(..prefix.len()).is_some_and(|start| start.eq_ignore_ascii_case(prefix));
    if text.is_empty() || text.eq_ignore_ascii_case("nc") {
        Ok(None)
    } else if has_prefix("ADC") {
        let number = two_numbers(text, 3).filter(|&(unit, input)| unit == 1 && input <= 6).ok_or(PinFlaw::NoSuchAdc)?;
        Ok(Some(PinName::Thermistor(ThermistorInput(number.1))))
    } else if has_prefix("PWM") {
        let (timer, channel) = two_numbers(text, 3)
            .filter(|&(timer, channel)| matches!(timer, 1 | 2) && matches!(channel, 1..=4))
            .ok_or(PinFlaw::NoSuchPwm)?;
        Ok(Some(PinName::Pwm(PwmOutput { timer, channel })))
    } else {
        digital(text).map(|pin| Some(PinName::Digital(pin)))
    }
}

/// Parses a voltage input such as `ADC3_5`.
#[must_use]
pub fn parse_voltage_input(text: &str) -> Option<VoltageInput> {
    let is_adc = text.get(..3)?.eq_ignore_ascii_case("ADC");
    two_numbers(text, 3)
        .filter(|&(unit, input)| is_adc && unit == 3 && input <= 5)
        .map(|(_, input)| VoltageInput(input))
}

/// Returns the digits of `ADC1_3`: exactly one on each side of the `_`.
fn two_numbers(text: &str, from: usize) -> Option<(u8, u8)> {
    match text.as_bytes().get(from..)? {
        [a @ b'0'..=b'9', b'_', b @ b'0'..=b'9'] => Some((a - b'0', b - b'0')),
        _ => None,
    }
}

/// Parses a digital pin: `P`, port, `_` or `.` or nothing, number, modifiers.
fn digital(text: &str) -> Result<Pin, PinFlaw> {
    let mut characters = text.chars().peekable();
    if !characters.next().is_some_and(|c| c.eq_ignore_ascii_case(&'p')) {
        return Err(PinFlaw::NotAPin);
    }
    let port = characters.next().filter(char::is_ascii_alphabetic).ok_or(PinFlaw::NotAPin)?.to_ascii_uppercase();
    if !('A'..='K').contains(&port) {
        return Err(PinFlaw::NoSuchPort(port));
    }
    characters.next_if(|c| matches!(c, '_' | '.'));
    let mut number = None;
    while let Some(digit) = characters.peek().and_then(|c| c.to_digit(10)) {
        number = Some(number.unwrap_or(0_u32).saturating_mul(10).saturating_add(digit));
        characters.next();
    }
    let number = number.and_then(|n| u8::try_from(n).ok()).filter(|&n| n <= 15).ok_or(PinFlaw::NoSuchNumber)?;
    characters.try_fold(Pin::new(port, number), |pin, modifier| {
        Ok(match modifier {
            '!' => Pin { inverted: true, ..pin },
            'o' | 'O' => Pin { open_drain: true, ..pin },
            '^' => with_pull(pin, Pull::Up)?,
            'v' | 'V' => with_pull(pin, Pull::Down)?,
            '-' => with_pull(pin, Pull::None)?,
            other => return Err(PinFlaw::NoSuchModifier(other)),
        })
    })
}

fn with_pull(pin: Pin, pull: Pull) -> Result<Pin, PinFlaw> {
    if pin.pull == Pull::Default || pin.pull == pull { Ok(Pin { pull, ..pin }) } else { Err(PinFlaw::TwoPulls) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_three_spellings_of_a_pin_are_equal() {
        for text in ["PA6", "pa6", "PA_6", "PA.6", "Pa_06"] {
            assert_eq!(parse_pin(text), Ok(Some(PinName::Digital(Pin::new('A', 6)))), "{text}");
        }
    }

    #[test]
    fn modifiers_may_stand_in_any_order() {
        let pin = Pin { inverted: true, open_drain: true, pull: Pull::Up, ..Pin::new('F', 14) };
        for text in ["PF14!o^", "PF14^o!", "PF14o^!"] {
            assert_eq!(parse_pin(text), Ok(Some(PinName::Digital(pin))), "{text}");
        }
    }

    #[test]
    fn nc_and_nothing_are_not_connected() {
        assert_eq!(parse_pin("nc"), Ok(None));
        assert_eq!(parse_pin("NC"), Ok(None));
        assert_eq!(parse_pin(""), Ok(None));
    }

    #[test]
    fn other_kinds_of_pin_have_their_own_names() {
        assert_eq!(parse_pin("ADC1_6"), Ok(Some(PinName::Thermistor(ThermistorInput(6)))));
        assert_eq!(parse_pin("pwm2_4"), Ok(Some(PinName::Pwm(PwmOutput { timer: 2, channel: 4 }))));
        assert_eq!(parse_voltage_input("ADC3_5"), Some(VoltageInput(5)));
        assert_eq!(parse_voltage_input("ADC1_5"), None);
    }

    #[test]
    fn flaws_say_what_is_wrong() {
        assert_eq!(parse_pin("D3"), Err(PinFlaw::NotAPin));
        assert_eq!(parse_pin("PL1"), Err(PinFlaw::NoSuchPort('L')));
        assert_eq!(parse_pin("PA"), Err(PinFlaw::NoSuchNumber));
        assert_eq!(parse_pin("PA16"), Err(PinFlaw::NoSuchNumber));
        assert_eq!(parse_pin("PA99999999999"), Err(PinFlaw::NoSuchNumber));
        assert_eq!(parse_pin("PA1i"), Err(PinFlaw::NoSuchModifier('i')));
        assert_eq!(parse_pin("PA1^v"), Err(PinFlaw::TwoPulls));
        assert_eq!(parse_pin("ADC1_7"), Err(PinFlaw::NoSuchAdc));
        assert_eq!(parse_pin("ADC3_0"), Err(PinFlaw::NoSuchAdc));
        assert_eq!(parse_pin("PWM1_2!"), Err(PinFlaw::NoSuchPwm));
    }

    proptest! {
        #[test]
        fn a_printed_pin_reads_back_as_itself(port in 0_u8..=10, number in 0_u8..16, inverted: bool, open_drain: bool, pull in 0..4) {
            let pull = [Pull::Default, Pull::Up, Pull::Down, Pull::None][pull as usize];
            let pin = Pin { port, number, inverted, open_drain, pull };
            prop_assert_eq!(parse_pin(&pin.to_string()), Ok(Some(PinName::Digital(pin))));
        }

        #[test]
        fn no_text_makes_it_panic(text in "\\PC{0,12}", near in "[Pp][A-Za-z_.]?[0-9]{0,3}[!o^v-]{0,3}") {
            let _ = parse_pin(&text);
            let _ = parse_pin(&near);
            let _ = parse_voltage_input(&text);
        }
    }
}
