//! Values of the language, as Python has them.

use core::num::NonZeroU32;

use crate::environment::{Kind, Object};
use crate::memory::Text;

/// Deepest values within values.
pub const DEEPEST: u8 = 8;
/// Length of a value in memory, bytes.
pub const SIZE: usize = 8;

/// Kind of a sequence in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seq {
    List,
    Tuple,
    /// Keys of a dict as `keys()` gives them.
    Keys,
    Values,
    Items,
    /// Result of `map`, `select` and others, which can be gone through once.
    Once,
}

/// Kind of a table in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    Dict,
    Namespace,
}

/// A value of the language in two words, so that it stays in registers: the second word is never 0, which is
/// how a result without a value is told.
///
/// Second word: below 0x1_0000 a tag; up to 0x1_ffff a whole number, whose highest 16 bits it has; above that
/// a real number, whose upper word is less by 0x2_0000.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    low: u32,
    high: NonZeroU32,
}

/// What a value is, to be told apart.
#[derive(Clone, Copy, Debug)]
pub enum View {
    /// Nothing, with the name that led to it.
    Undefined(Text),
    None,
    /// A truth value, a whole or a real number.
    Number,
    Str(Text),
    Seq(Seq, u16),
    Map(Map, u16),
    /// Start, end and step, 24 bytes in memory.
    Range(u16),
    /// Something of the caller's.
    Object(Object),
    /// A function by its number.
    Function(u8),
    /// A method that was named and not called.
    Method,
    /// A loop by its place on the stack.
    Loop(u16),
}

/// Tags of values in memory, and sets of them: one bit for each.
pub mod tag {
    pub const UNDEFINED: u32 = 1;
    pub const NONE: u32 = 2;
    pub const BOOL: u32 = 3;
    pub const STR: u32 = 4;
    pub const RANGE: u32 = 5;
    pub const FUNCTION: u32 = 6;
    pub const METHOD: u32 = 7;
    pub const LOOP: u32 = 8;
    pub const LONG: u32 = 9;
    /// Sequences in memory, by their kinds.
    pub const SEQ: u32 = 10;
    /// Tables in memory, by their kinds.
    pub const MAP: u32 = 16;
    /// Objects of the machine's, by their kinds.
    pub const OBJECT: u32 = 18;
    /// Numbers, which have no tag in memory.
    pub const INT: u32 = 22;
    pub const FLOAT: u32 = 23;
}

/// Types of values, one bit for each.
pub mod types {
    use super::tag;

    pub const UNDEFINED: u32 = 1 << tag::UNDEFINED;
    pub const BOOL: u32 = 1 << tag::BOOL;
    pub const INT: u32 = 1 << tag::INT | 1 << tag::LONG;
    pub const FLOAT: u32 = 1 << tag::FLOAT;
    pub const NUMBER: u32 = BOOL | INT | FLOAT;
    pub const STR: u32 = 1 << tag::STR;
    pub const RANGE: u32 = 1 << tag::RANGE;
    pub const CALLABLE: u32 = 1 << tag::FUNCTION | 1 << tag::METHOD;
    pub const LOOP: u32 = 1 << tag::LOOP;
    /// Lists and tuples, in memory and of the machine's.
    pub const LIST: u32 = 1 << tag::SEQ | 1 << (tag::OBJECT + 2);
    pub const TUPLE: u32 = 1 << (tag::SEQ + 1) | 1 << (tag::OBJECT + 3);
    pub const ONCE: u32 = 1 << (tag::SEQ + 5);
    pub const SEQ: u32 = 0x3f << tag::SEQ;
    /// Dicts, in memory and of the machine's.
    pub const DICT: u32 = 1 << tag::MAP | 1 << (tag::OBJECT + 1);
    pub const NAMESPACE: u32 = 1 << (tag::MAP + 1);
    /// Lists, tuples, views, dicts and namespaces in memory.
    pub const IN_MEMORY: u32 = SEQ | 3 << tag::MAP;
    pub const LOOKUP: u32 = 1 << tag::OBJECT;
    /// Everything of the machine's.
    pub const OBJECT: u32 = 0xf << tag::OBJECT;
    /// What has elements by number.
    pub const INDEXED: u32 = STR | LIST | TUPLE | RANGE;
}

const INT: u32 = 0x1_0000;
const FLOAT: u32 = 0x2_0000;

impl Value {
    pub const NONE: Self = Self::new(tag::NONE, 0);
    pub const METHOD: Self = Self::new(tag::METHOD, 0);
    /// What is not there and has no name.
    pub const MISSING: Self = Self::new(tag::UNDEFINED, 0);

    const fn new(high: u32, low: u32) -> Self {
        let high = match NonZeroU32::new(high) {
            Some(high) => high,
            None => NonZeroU32::MIN,
        };
        Self { low, high }
    }

    /// The value with these words.
    pub fn from_words(low: u32, high: u32) -> Self {
        Self::new(high, low)
    }

    /// Both words of the value.
    pub fn words(self) -> [u32; 2] {
        [self.low, self.high.get()]
    }

    /// Something that is not there, by its name.
    pub fn undefined(name: Text) -> Self {
        Self::new(tag::UNDEFINED, name.bits())
    }

    /// A truth value, `True` or `False`.
    pub fn bool(is: bool) -> Self {
        Self::new(tag::BOOL, u32::from(is))
    }

    /// A whole number of up to 48 bits; none if it is longer.
    pub fn short(int: i64) -> Option<Self> {
        ((int << 16) >> 16 == int).then(|| Self::new(INT | (int >> 32) as u32 & 0xffff, int as u32))
    }

    /// A whole number that is known to be short.
    pub const fn small(int: i32) -> Self {
        Self::new(INT | (int >> 31) as u32 & 0xffff, int as u32)
    }

    /// A number of elements, bytes or turns.
    pub fn count(count: usize) -> Self {
        Self::new(INT, count as u32)
    }

    /// A longer whole number, by its place in memory.
    pub fn long(at: usize) -> Self {
        Self::new(tag::LONG, at as u32)
    }

    /// A real number; those that are none are all the same.
    pub fn float(float: f64) -> Self {
        let bits = if float.is_nan() { f64::NAN.to_bits() & (u64::MAX >> 1) } else { float.to_bits() };
        Self::new((bits >> 32) as u32 + FLOAT, bits as u32)
    }

    /// A text.
    pub fn str(text: Text) -> Self {
        Self::new(tag::STR, text.bits())
    }

    /// A sequence, by its head in memory.
    pub fn seq(kind: Seq, head: u16) -> Self {
        Self::new(tag::SEQ + kind as u32, u32::from(head))
    }

    /// A dict or namespace, by its head in memory.
    pub fn map(kind: Map, head: u16) -> Self {
        Self::new(tag::MAP + kind as u32, u32::from(head))
    }

    /// A range, by its place in memory.
    pub fn range(at: usize) -> Self {
        Self::new(tag::RANGE, at as u32)
    }

    /// An object of the machine's.
    pub fn object(object: Object) -> Self {
        Self::new(tag::OBJECT + object.kind as u32, object.id)
    }

    /// A function, by its number.
    pub fn function(number: u8) -> Self {
        Self::new(tag::FUNCTION, u32::from(number))
    }

    /// A loop, by its place on the stack.
    pub fn turns(place: usize) -> Self {
        Self::new(tag::LOOP, place as u32)
    }

    /// Tag of the value.
    pub fn tag(self) -> u32 {
        match self.high.get() {
            tag @ ..INT => tag,
            INT..FLOAT => tag::INT,
            _ => tag::FLOAT,
        }
    }

    /// Whether the value is of one of some types.
    #[inline(never)]
    pub fn is(self, types: u32) -> bool {
        types >> self.tag() & 1 != 0
    }

    /// What the value is.
    #[inline(always)]
    pub fn view(self) -> View {
        let (low, high) = (self.low, self.high.get());
        let place = low as u16;
        let object = |kind| View::Object(Object { id: low, kind });
        match high {
            tag::UNDEFINED => View::Undefined(Text::from_bits(low)),
            tag::STR => View::Str(Text::from_bits(low)),
            tag::RANGE => View::Range(place),
            tag::FUNCTION => View::Function(low as u8),
            tag::METHOD => View::Method,
            tag::LOOP => View::Loop(place),
            10 => View::Seq(Seq::List, place),
            11 => View::Seq(Seq::Tuple, place),
            12 => View::Seq(Seq::Keys, place),
            13 => View::Seq(Seq::Values, place),
            14 => View::Seq(Seq::Items, place),
            15 => View::Seq(Seq::Once, place),
            16 => View::Map(Map::Dict, place),
            17 => View::Map(Map::Namespace, place),
            18 => object(Kind::Lookup),
            19 => object(Kind::Dict),
            20 => object(Kind::List),
            21 => object(Kind::Tuple),
            tag::NONE => View::None,
            _ => View::Number,
        }
    }

    /// The truth value that the value is.
    pub fn as_bool(self) -> Option<bool> {
        (self.high.get() == tag::BOOL).then_some(self.low != 0)
    }

    /// The whole number that the value is, if it is short.
    pub fn as_short(self) -> Option<i64> {
        let high = self.high.get();
        (high & !0xffff == INT).then(|| i64::from(high as i16) << 32 | i64::from(self.low))
    }

    /// Place of the longer whole number that the value is.
    pub fn as_long(self) -> Option<usize> {
        (self.high.get() == tag::LONG).then_some(self.low as usize)
    }

    /// The real number that the value is.
    #[inline(never)]
    pub fn as_float(self) -> Option<f64> {
        let high = self.high.get();
        (high >= FLOAT).then(|| f64::from_bits(u64::from(high - FLOAT) << 32 | u64::from(self.low)))
    }

    /// Whether the value is not there.
    pub fn is_undefined(self) -> bool {
        self.high.get() == tag::UNDEFINED
    }

    /// Whether the value is `None`.
    pub fn is_none(self) -> bool {
        self.high.get() == tag::NONE
    }

    /// The text that the value is.
    pub fn text(self) -> Option<Text> {
        (self.high.get() == tag::STR).then(|| Text::from_bits(self.low))
    }

    /// Name of what is not there.
    pub fn missing_name(self) -> Text {
        Text::from_bits(self.low)
    }

    /// Head of the list, dict or view in memory that the value is.
    pub fn head(self) -> Option<u16> {
        self.is(types::IN_MEMORY).then_some(self.low as u16)
    }

    /// The machine's object that the value is.
    pub fn as_object(self) -> Option<Object> {
        if let View::Object(object) = self.view() { Some(object) } else { None }
    }

    /// Whether the value lies in memory behind a place, so that it has to be kept.
    pub fn lies_behind(self, keep: usize, pool: usize) -> bool {
        let at = usize::from(self.low as u16);
        self.is(types::IN_MEMORY | types::STR | types::RANGE | 1 << tag::LONG) && at >= keep && at < pool
    }

    /// Name of the value's type, as Python calls it.
    pub fn kind(self) -> &'static str {
        const NAMES: &str = "undefined;none;bool;str;range;function;function;loop;int;list;tuple;view;view;view;iterator;\
                             dict;namespace;object;dict;list;tuple;int;float;";
        crate::chars::nth(NAMES, b';', self.tag() as usize - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::{Value, types};
    use crate::memory::Text;

    #[test]
    fn real_numbers_come_back_bit_by_bit() {
        for float in [0.0, -0.0, 1.5, -1e308, f64::MIN_POSITIVE / 8.0, f64::INFINITY, f64::NEG_INFINITY] {
            let value = Value::float(float);
            assert_eq!(value.as_float().map(f64::to_bits), Some(float.to_bits()));
            assert!(value.is(types::FLOAT) && value.as_short().is_none() && value.text().is_none());
        }
        assert!(Value::float(-f64::NAN).as_float().is_some_and(f64::is_nan));
    }

    #[test]
    fn whole_numbers_of_48_bits_are_short() {
        let most = (1 << 47) - 1;
        for int in [0, 1, -1, 1 << 32, -(1 << 32), most, -most - 1] {
            let value = Value::short(int).expect("short");
            assert_eq!((value.as_short(), value.is(types::INT)), (Some(int), true));
        }
        assert!(Value::short(most + 1).is_none() && Value::short(-most - 2).is_none());
        assert_eq!((Value::small(-7).as_short(), Value::count(70_000).as_short()), (Some(-7), Some(70_000)));
    }

    #[test]
    fn a_value_is_of_one_type() {
        let text = Text::new(5, 9);
        assert_eq!((Value::str(text).text(), Value::str(text).kind()), (Some(text), "str"));
        assert!(Value::NONE.is_none() && Value::MISSING.is_undefined() && !Value::bool(false).is(types::INT));
        assert_eq!((Value::float(1.0).kind(), Value::small(1).kind(), Value::NONE.kind()), ("float", "int", "none"));
    }

    #[test]
    fn a_result_takes_no_more_than_two_words() {
        assert_eq!(size_of::<crate::fault::Result<Value>>(), 8);
        assert_eq!(size_of::<Option<Value>>(), 8);
    }
}
