//! Values of the language, as Python has them.

use core::num::NonZeroU32;

use crate::environment::{Kind, Object};
use crate::fault::Words;
use crate::memory::Text;

/// Deepest values within values.
pub const DEEPEST: u8 = 8;
/// Words about values within values that are deeper.
pub const TOO_DEEP: Words = &"lists and dicts within each other go down to 8: make them flatter";
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
/// Second word: below 0x1_0000 a tag with a kind above it; up to 0x1_ffff a whole number, whose highest 16 bits
/// it has; above that a real number, whose upper word is less by 0x2_0000.
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
    Bool(bool),
    /// A whole number of up to 48 bits.
    Int(i64),
    /// A longer whole number, by its place in memory.
    Long(u16),
    Float(f64),
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

const UNDEFINED: u32 = 1;
const NONE: u32 = 2;
const BOOL: u32 = 3;
const STR: u32 = 4;
const SEQ: u32 = 5;
const MAP: u32 = 6;
const RANGE: u32 = 7;
const OBJECT: u32 = 8;
const FUNCTION: u32 = 9;
const METHOD: u32 = 10;
const LOOP: u32 = 11;
const LONG: u32 = 12;
const INT: u32 = 0x1_0000;
const FLOAT: u32 = 0x2_0000;

const SEQS: [Seq; 6] = [Seq::List, Seq::Tuple, Seq::Keys, Seq::Values, Seq::Items, Seq::Once];
const KINDS: [Kind; 4] = [Kind::Lookup, Kind::Dict, Kind::List, Kind::Tuple];

impl Value {
    pub const NONE: Self = Self::new(NONE, 0);
    pub const METHOD: Self = Self::new(METHOD, 0);
    /// What is not there and has no name.
    pub const MISSING: Self = Self::new(UNDEFINED, 0);

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

    pub fn undefined(name: Text) -> Self {
        Self::new(UNDEFINED, name.bits())
    }

    pub fn bool(is: bool) -> Self {
        Self::new(BOOL, u32::from(is))
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
        Self::new(LONG, at as u32)
    }

    pub fn float(float: f64) -> Self {
        let bits = if float.is_nan() { f64::NAN.to_bits() & (u64::MAX >> 1) } else { float.to_bits() };
        Self::new((bits >> 32) as u32 + FLOAT, bits as u32)
    }

    pub fn str(text: Text) -> Self {
        Self::new(STR, text.bits())
    }

    pub fn seq(kind: Seq, head: u16) -> Self {
        Self::new(SEQ | (kind as u32) << 8, u32::from(head))
    }

    pub fn map(kind: Map, head: u16) -> Self {
        Self::new(MAP | (kind as u32) << 8, u32::from(head))
    }

    pub fn range(at: usize) -> Self {
        Self::new(RANGE, at as u32)
    }

    pub fn object(object: Object) -> Self {
        Self::new(OBJECT | (object.kind as u32) << 8, object.id)
    }

    pub fn function(number: u8) -> Self {
        Self::new(FUNCTION, u32::from(number))
    }

    pub fn turns(place: usize) -> Self {
        Self::new(LOOP, place as u32)
    }

    /// What the value is.
    #[inline(always)]
    pub fn view(self) -> View {
        let (low, high) = (self.low, self.high.get());
        let place = low as u16;
        if high >= FLOAT {
            return View::Float(f64::from_bits(u64::from(high - FLOAT) << 32 | u64::from(low)));
        }
        if high >= INT {
            return View::Int(i64::from(high as i16) << 32 | i64::from(low));
        }
        let kind = usize::from((high >> 8) as u8);
        match high & 0xff {
            UNDEFINED => View::Undefined(Text::from_bits(low)),
            BOOL => View::Bool(low != 0),
            STR => View::Str(Text::from_bits(low)),
            SEQ => View::Seq(SEQS.get(kind).copied().unwrap_or(Seq::Once), place),
            MAP => View::Map(if kind == 0 { Map::Dict } else { Map::Namespace }, place),
            RANGE => View::Range(place),
            OBJECT => View::Object(Object { id: low, kind: KINDS.get(kind).copied().unwrap_or(Kind::Tuple) }),
            FUNCTION => View::Function(low as u8),
            METHOD => View::Method,
            LOOP => View::Loop(place),
            LONG => View::Long(place),
            _ => View::None,
        }
    }

    pub fn is_undefined(self) -> bool {
        self.high.get() == UNDEFINED
    }

    pub fn is_none(self) -> bool {
        self.high.get() == NONE
    }

    /// The text that the value is.
    pub fn text(self) -> Option<Text> {
        (self.high.get() == STR).then(|| Text::from_bits(self.low))
    }

    /// Whether the value is a result that can be gone through once.
    pub fn is_once(self) -> bool {
        self.high.get() == SEQ | (Seq::Once as u32) << 8
    }

    /// Head of the list, dict or view in memory that the value is.
    pub fn head(self) -> Option<u16> {
        matches!(self.high.get() & !0xff00, SEQ | MAP).then_some(self.low as u16)
    }

    /// Whether the value lies in memory behind a place, so that it has to be kept.
    pub fn lies_behind(self, keep: usize, pool: usize) -> bool {
        let at = usize::from(self.low as u16);
        let has_place = matches!(self.high.get() & !0xff00, STR | SEQ | MAP | RANGE | LONG);
        has_place && at >= keep && at < pool
    }

    /// Name of the value's type, as Python calls it.
    pub fn kind(self) -> &'static str {
        match self.view() {
            View::Undefined(_) => "undefined",
            View::None => "none",
            View::Bool(_) => "bool",
            View::Int(_) | View::Long(_) => "int",
            View::Float(_) => "float",
            View::Str(_) => "str",
            View::Seq(Seq::List, _) => "list",
            View::Seq(Seq::Tuple, _) => "tuple",
            View::Seq(Seq::Keys | Seq::Values | Seq::Items, _) => "view of a dict",
            View::Seq(Seq::Once, _) => "result of a filter",
            View::Map(Map::Dict, _) => "dict",
            View::Map(Map::Namespace, _) => "namespace",
            View::Range(_) => "range",
            View::Object(object) => match object.kind {
                Kind::Lookup => "object",
                Kind::Dict => "dict",
                Kind::List => "list",
                Kind::Tuple => "tuple",
            },
            View::Function(_) | View::Method => "function",
            View::Loop(_) => "loop",
        }
    }
}
