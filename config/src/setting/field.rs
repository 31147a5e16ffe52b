//! Conversion of values as read to the types of fields.

use crate::pin::{OutputPin, Pin, PinName, PwmOutput, ThermistorInput, VoltageInput};
use crate::setting::value::Value;
use gcode::Code;
use heapless::{String, Vec};
use units::{Amps, Axis, Celsius, Duty, Micros, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3, Ohms, ToolId, Volts};

/// Type of a field that takes a value without more ado.
pub(crate) trait Field {
    /// Stores the value. A value of another kind is left out.
    fn set(&mut self, value: &Value<'_>);
}

/// Content of a value, as the functions behind `=>` take it.
pub(crate) trait Content<'v>: Sized {
    /// Returns the content; none when the value is of another kind.
    fn of(value: &'v Value<'v>) -> Option<Self>;
}

/// Calls a function with the content of a value. Inlined, because a call would be longer than the function.
#[inline(always)]
pub(crate) fn with<'v, T: Content<'v>>(value: &'v Value<'v>, put: impl FnOnce(T)) {
    match T::of(value) {
        Some(content) => put(content),
        None => debug_assert!(false, "a value of the wrong kind"),
    }
}

/// The content of a kind of value.
macro_rules! content {
    ($($type:ty: $pattern:pat => $content:expr;)+) => {
        $(impl<'v> Content<'v> for $type {
            fn of(value: &'v Value<'v>) -> Option<Self> {
                match value {
                    $pattern => Some($content),
                    _ => None,
                }
            }
        })+
    };
}

content! {
    bool: &Value::Bool(value) => value;
    i64: &Value::Integer(value) => value;
    f64: &Value::Number(value) => value;
    &'v [f64]: Value::Numbers(values) => values;
    &'v [[f64; 2]]: Value::Places(places) => places;
    usize: &Value::Word(place) => place;
    &'v str: &Value::Text(text) => text;
    Option<Code>: &Value::Command(code) => code;
    Option<[u32; 5]>: &Value::Registers(registers) => registers;
    &'v [Axis]: Value::Axes(axes) => axes;
    Option<PinName>: &Value::Pin(pin) => pin;
    (VoltageInput, f64): &Value::Voltage(input, scale) => (input, scale);
}

/// Fields of a type, and fields that may be none, from the content of a value.
macro_rules! fields {
    ($($type:ty: |$value:ident: $content:ty| $field:expr;)+) => {
        $(impl Field for $type {
            fn set(&mut self, value: &Value<'_>) {
                with(value, |$value: $content| *self = $field);
            }
        })+
    };
}

fields! {
    u8: |value: i64| value as u8;
    u16: |value: i64| value as u16;
    u32: |value: i64| value as u32;
    i8: |value: i64| value as i8;
    i16: |value: i64| value as i16;
    Duty: |value: i64| Duty(value as u8);
    ToolId: |value: i64| ToolId(value as u8);
    f64: |value: f64| value;
    f32: |value: f64| value as f32;
    Mm: |value: f64| Mm(value);
    MmPerSecond: |value: f64| MmPerSecond(value);
    MmPerSecond2: |value: f64| MmPerSecond2(value);
    MmPerSecond3: |value: f64| MmPerSecond3(value);
    Celsius: |value: f64| Celsius(value as f32);
    Ohms: |value: f64| Ohms(value as f32);
    Volts: |value: f64| Volts(value as f32);
    Option<bool>: |value: bool| Some(value);
    Option<u8>: |value: i64| Some(value as u8);
    Option<u16>: |value: i64| Some(value as u16);
    Option<u32>: |value: i64| Some(value as u32);
    Option<i8>: |value: i64| Some(value as i8);
    Option<f64>: |value: f64| Some(value);
    Option<Mm>: |value: f64| Some(Mm(value));
    Option<Amps>: |value: f64| Some(Amps(value as f32));
    Option<Ohms>: |value: f64| Some(Ohms(value as f32));
    Option<Volts>: |value: f64| Some(Volts(value as f32));
    Option<PwmOutput>: |value: Option<PinName>| match value {
        Some(PinName::Pwm(output)) => Some(output),
        _ => None,
    };
    Option<Pin>: |value: Option<PinName>| value.and_then(PinName::digital);
    Option<OutputPin>: |value: Option<PinName>| value.and_then(PinName::output);
    Option<ThermistorInput>: |value: Option<PinName>| value.and_then(PinName::thermistor);
    Option<Code>: |value: Option<Code>| value;
    Option<[u32; 5]>: |value: Option<[u32; 5]>| value;
    Option<Axis>: |value: usize| Axis::ALL.get(value).copied();
}

impl<const N: usize> Field for String<N> {
    fn set(&mut self, value: &Value<'_>) {
        // The schema limits the text to what fits.
        with(value, |text: &str| *self = Self::try_from(text).unwrap_or_default());
    }
}

impl<const N: usize> Field for [f64; N] {
    fn set(&mut self, value: &Value<'_>) {
        with(value, |values: &[f64]| *self = values.try_into().unwrap_or([0.0; N]));
    }
}

impl<const N: usize> Field for Option<[f64; N]> {
    fn set(&mut self, value: &Value<'_>) {
        with(value, |values: &[f64]| *self = values.try_into().ok());
    }
}

/// A word says false or true where there are two.
impl Field for bool {
    fn set(&mut self, value: &Value<'_>) {
        match *value {
            Value::Bool(value) => *self = value,
            Value::Word(place) => *self = place == 1,
            _ => debug_assert!(false, "a value of the wrong kind"),
        }
    }
}

impl<const N: usize> Field for Vec<[f64; 2], N> {
    fn set(&mut self, value: &Value<'_>) {
        // The schema limits the places to what fits.
        with(value, |places: &[[f64; 2]]| *self = Self::from_slice(places).unwrap_or_default());
    }
}

/// A duration: a number counts seconds, and so does a whole number.
impl Field for Micros {
    fn set(&mut self, value: &Value<'_>) {
        match *value {
            Value::Number(seconds) => *self = Self((seconds * 1e6) as u64),
            Value::Integer(seconds) => *self = Self::from_seconds(seconds.unsigned_abs()),
            _ => debug_assert!(false, "a value of the wrong kind"),
        }
    }
}

/// Fields whose values are words.
macro_rules! word_field {
    ($name:ident) => {
        impl $crate::setting::field::Field for $name {
            fn set(&mut self, value: &$crate::setting::value::Value<'_>) {
                $crate::setting::field::with(value, |word: usize| {
                    if let Some(meant) = Self::ALL.get(word) {
                        *self = *meant;
                    }
                });
            }
        }
        impl $crate::setting::field::Field for Option<$name> {
            fn set(&mut self, value: &$crate::setting::value::Value<'_>) {
                $crate::setting::field::with(value, |word: usize| *self = $name::ALL.get(word).copied());
            }
        }
    };
}

pub(crate) use word_field;
