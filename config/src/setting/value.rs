//! Values of settings: parsed from text, checked against the schema, and stored in the description.

use super::{Kind, PinRole, Words};
use crate::pin::{self, PinName, VoltageInput};
use crate::setting::flaw::Flaw;
use gcode::{Code, Letter};
use heapless::Vec;
use units::Axis;

/// A value as read.
#[expect(clippy::large_enum_variant, reason = "there is one at a time, while its line is read")]
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value<'t> {
    Bool(bool),
    Integer(i64),
    Number(f64),
    Numbers(Vec<f64, 6>),
    Places(Vec<[f64; 2], MOST_PLACES>),
    Word(usize),
    Text(&'t str),
    Command(Option<Code>),
    Registers(Option<[u32; 5]>),
    Axes(Vec<Axis, 6>),
    Pin(Option<PinName>),
    Voltage(VoltageInput, f64),
}

/// Places that a setting can have.
const MOST_PLACES: usize = 32;

/// The board's dividers of 100 and 10 kOhm.
const DIVIDER_SCALE: f64 = 11.0;

/// Reads the text of a value, blanks already trimmed.
pub(crate) fn parse<'t>(kind: &Kind, text: &'t str) -> Result<Value<'t>, Flaw<'t>> {
    let may_be_empty = matches!(
        kind,
        Kind::Text(..)
            | Kind::Pin(..)
            | Kind::Numbers(..)
            | Kind::Places(..)
            | Kind::Command
            | Kind::Registers
            | Kind::Axes
    );
    if text.is_empty() && !may_be_empty {
        return Err(Flaw::Empty);
    }
    match *kind {
        Kind::Bool => boolean(text),
        Kind::Integer(&(low, high)) => integer(text, low, high),
        Kind::Number(&range) => number(text).and_then(|value| in_range(value, range)).map(Value::Number),
        Kind::Numbers(count) => numbers(text, count),
        Kind::Places(most) => places(text, most),
        Kind::Word(&Words(words)) => {
            let index = words.iter().position(|word| word.eq_ignore_ascii_case(text));
            index.map(Value::Word).ok_or(Flaw::NotAWord(text, words))
        }
        Kind::Text(longest) if text.len() > longest => Err(Flaw::TooLong { bytes: text.len(), longest }),
        Kind::Text(..) => Ok(Value::Text(text)),
        Kind::Command if text.is_empty() => Ok(Value::Command(None)),
        Kind::Command => command(text).map(|code| Value::Command(Some(code))).ok_or(Flaw::NotACode(text)),
        Kind::Registers => registers(text),
        Kind::Axes => axes(text),
        Kind::Pin(role) => pin_for(role, text),
        Kind::Voltage => voltage(text),
    }
}

fn boolean(text: &str) -> Result<Value<'_>, Flaw<'_>> {
    match text {
        "true" | "t" | "1" => Ok(Value::Bool(true)),
        "false" | "f" | "0" => Ok(Value::Bool(false)),
        _ => Err(Flaw::NotBool(text)),
    }
}

fn all_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

fn integer(text: &str, low: i64, high: i64) -> Result<Value<'_>, Flaw<'_>> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let hexadecimal = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
    if digits.len() > 1 && digits.starts_with('0') && all_digits(digits) {
        return Err(Flaw::Octal(text));
    }
    let magnitude = match hexadecimal {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => whole(digits),
    };
    let magnitude = magnitude.filter(|&value| value >= 0).ok_or(Flaw::NotWhole(text))?;
    let value = if negative { -magnitude } else { magnitude };
    if (low..=high).contains(&value) {
        Ok(Value::Integer(value))
    } else {
        Err(Flaw::OutOfRange(value as f64, (low as f64, high as f64)))
    }
}

/// `30`, and `30.7`, whose fraction Smoothieware cuts.
fn whole(digits: &str) -> Option<i64> {
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, "0"));
    if !all_digits(whole) || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    whole.parse().ok()
}

/// Whether a whole number was written with a fraction that is not 0.
pub(crate) fn has_fraction(text: &str) -> bool {
    text.split_once('.').is_some_and(|(_, fraction)| fraction.bytes().any(|byte| byte != b'0'))
}

fn number(text: &str) -> Result<f64, Flaw<'_>> {
    // The reader also knows "inf" and "nan"; a machine does not.
    let starts_well = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
    let value = gcode::read_f64(text).filter(|value| value.is_finite() && starts_well);
    value.ok_or(Flaw::NotNumber(text))
}

fn in_range<'t>(value: f64, range: (f64, f64)) -> Result<f64, Flaw<'t>> {
    if (range.0..=range.1).contains(&value) { Ok(value) } else { Err(Flaw::OutOfRange(value, range)) }
}

fn numbers(text: &str, wanted: usize) -> Result<Value<'_>, Flaw<'_>> {
    let mut values = Vec::new();
    if text.is_empty() {
        return Ok(Value::Numbers(values));
    }
    let wrong_count = Flaw::Count { found: text.split(',').count(), wanted };
    for part in text.split(',') {
        values.push(number(part.trim())?).map_err(|_| wrong_count)?;
    }
    if values.len() == wanted { Ok(Value::Numbers(values)) } else { Err(wrong_count) }
}

/// Pairs of numbers, with commas or blanks between all of them.
fn places(text: &str, most: usize) -> Result<Value<'_>, Flaw<'_>> {
    let parts = || text.split([',', ' ', '\t']).filter(|part| !part.is_empty());
    let mut places: Vec<[f64; 2], MOST_PLACES> = Vec::new();
    let (found, mut before) = (parts().count(), None);
    let wrong_count = Flaw::PlaceCount { found, most };
    for part in parts() {
        let here = number(part)?;
        before = match before {
            None => Some(here),
            Some(x) => {
                places.push([x, here]).map_err(|_| wrong_count)?;
                None
            }
        };
    }
    if before.is_none() && places.len() <= most { Ok(Value::Places(places)) } else { Err(wrong_count) }
}

fn command(text: &str) -> Option<Code> {
    let letter = match text.chars().next()?.to_ascii_uppercase() {
        'G' => Letter::G,
        'M' => Letter::M,
        _ => return None,
    };
    let digits = text.get(1..)?;
    let (number, subcode) = digits.split_once('.').unwrap_or((digits, "0"));
    if !all_digits(number) || !all_digits(subcode) {
        return None;
    }
    Some(Code { letter, number: number.parse().ok()?, subcode: subcode.parse().ok()? })
}

fn registers(text: &str) -> Result<Value<'_>, Flaw<'_>> {
    if text.is_empty() {
        return Ok(Value::Registers(None));
    }
    let mut values = [0; 5];
    let mut count = 0;
    for part in text.split(',') {
        let digits = part.trim();
        let digits = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")).unwrap_or(digits);
        // The drivers' registers have 20 bits.
        let value = u32::from_str_radix(digits, 16).ok().filter(|&value| value < 1 << 20);
        let value = value.ok_or(Flaw::NotARegister(part))?;
        if let Some(place) = values.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    if count == values.len() { Ok(Value::Registers(Some(values))) } else { Err(Flaw::RegisterCount(count)) }
}

fn axes(text: &str) -> Result<Value<'_>, Flaw<'_>> {
    let mut list: Vec<Axis, 6> = Vec::new();
    for letter in text.chars() {
        let axis = Axis::from_letter(letter).filter(|axis| !list.contains(axis)).ok_or(Flaw::NotAnAxis(letter))?;
        list.push(axis).map_err(|_| Flaw::NotAnAxis(letter))?;
    }
    Ok(Value::Axes(list))
}

fn pin_for(role: PinRole, text: &str) -> Result<Value<'_>, Flaw<'_>> {
    if role == PinRole::Button && text == "external" {
        return Ok(Value::Pin(Some(PinName::External)));
    }
    let name = pin::parse_pin(text).map_err(|problem| Flaw::NotAPin(text, problem, role))?;
    let fits = name.is_none_or(|name| match role {
        PinRole::Output | PinRole::Input | PinRole::Button | PinRole::Interrupt => matches!(name, PinName::Digital(_)),
        PinRole::OutputOrPwm => matches!(name, PinName::Digital(_) | PinName::Pwm(_)),
        PinRole::Pwm => matches!(name, PinName::Pwm(_)),
        PinRole::Thermistor => matches!(name, PinName::Thermistor(_)),
    });
    if fits { Ok(Value::Pin(name)) } else { Err(Flaw::OtherPin(text, role)) }
}

fn voltage(text: &str) -> Result<Value<'_>, Flaw<'_>> {
    let (name, scale) = text.split_once(',').map_or((text, None), |(name, scale)| (name, Some(scale)));
    let input = pin::parse_voltage_input(name.trim()).ok_or(Flaw::NotAVoltage(text))?;
    let scale = scale.map_or(Ok(DIVIDER_SCALE), |scale| number(scale.trim()))?;
    in_range(scale, (1e-6, 1e6)).map(|scale| Value::Voltage(input, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const NUMBER: Kind = Kind::Number(&(-1e9, 1e9));
    const INTEGER: Kind = Kind::Integer(&(i64::MIN, i64::MAX));
    const REGISTERS: Kind = Kind::Registers;

    #[test]
    fn registers_are_five_numbers_of_twenty_bits() {
        let read = |text| parse(&REGISTERS, text);
        assert_eq!(
            read("204,901B4, 0xA8202,C011F,0"),
            Ok(Value::Registers(Some([0x204, 0x901B4, 0xA8202, 0xC011F, 0])))
        );
        assert_eq!(read(""), Ok(Value::Registers(None)));
        assert_eq!(read("1,2,3"), Err(Flaw::RegisterCount(3)));
        assert_eq!(read("1,2,3,4,100000"), Err(Flaw::NotARegister("100000")));
    }

    #[test]
    fn places_are_pairs_however_they_are_parted() {
        let read = |text| parse(&Kind::Places(3), text).map(|value| format!("{value:?}"));
        for text in ["1,2 3.5,-4", "1, 2, 3.5, -4", "1 2\t3.5 -4"] {
            assert_eq!(read(text), Ok("Places([[1.0, 2.0], [3.5, -4.0]])".into()), "{text}");
        }
        assert_eq!(read(""), Ok("Places([])".into()));
        assert_eq!(read("1,2 3"), Err(Flaw::PlaceCount { found: 3, most: 3 }));
        assert_eq!(read("1,2 3,4 5,6 7,8"), Err(Flaw::PlaceCount { found: 8, most: 3 }));
        assert_eq!(read("1,2 x,4"), Err(Flaw::NotNumber("x")));
    }

    #[test]
    fn axis_letters_may_not_repeat() {
        let axes = Kind::Axes;
        assert_eq!(parse(&axes, "zxY").map(|v| format!("{v:?}")), Ok("Axes([Z, X, Y])".into()));
        assert_eq!(parse(&axes, "XYX"), Err(Flaw::NotAnAxis('X')));
        assert_eq!(parse(&axes, "XE"), Err(Flaw::NotAnAxis('E')));
    }

    #[test]
    fn a_voltage_has_a_scale_of_its_own_or_the_boards() {
        let kind = Kind::Voltage;
        assert_eq!(parse(&kind, "ADC3_2"), Ok(Value::Voltage(VoltageInput(2), 11.0)));
        assert_eq!(parse(&kind, "ADC3_2, 5.5"), Ok(Value::Voltage(VoltageInput(2), 5.5)));
        assert_eq!(parse(&kind, "ADC3_6"), Err(Flaw::NotAVoltage("ADC3_6")));
    }

    proptest! {
        #[test]
        fn numbers_printed_read_back_as_themselves(x in -1e9_f64..1e9, n in any::<i64>()) {
            let (number, integer) = (x.to_string(), n.to_string());
            prop_assert_eq!(parse(&NUMBER, &number), Ok(Value::Number(x)));
            prop_assume!(n != i64::MIN);
            prop_assert_eq!(parse(&INTEGER, &integer), Ok(Value::Integer(n)));
        }

        #[test]
        fn no_text_makes_any_kind_panic(text in "\\PC{0,20}", near in "[-+]?[0x.,A-F_0-9]{0,12}") {
            for section in crate::schema::SECTIONS {
                for row in section.settings {
                    for text in [&text, &near] {
                        if let Err(flaw) = parse(&row.kind, text) {
                            let _ = (flaw.reason().to_string(), flaw.fix().to_string());
                        }
                    }
                }
            }
        }
    }
}
