//! Values that are numbers.

use crate::memory::Memory;
use crate::value::Value;

/// A value as a number, if it is one.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    Int(i64),
    Float(f64),
}

/// The number that a value is; truth values are 0 and 1.
pub fn number(memory: &Memory<'_>, value: Value) -> Option<Number> {
    value.as_float().map(Number::Float).or_else(|| memory.whole(value).map(Number::Int))
}

/// A number as a real one.
pub fn float(number: Number) -> f64 {
    match number {
        Number::Int(int) => int as f64,
        Number::Float(float) => float,
    }
}
