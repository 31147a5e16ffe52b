//! Values of the language, as Python has them.

use crate::environment::{Kind, Object};
use crate::fault::Words;
use crate::memory::Text;

/// Deepest values within values.
pub const DEEPEST: u8 = 8;
/// Words about values within values that are deeper.
pub const TOO_DEEP: Words = &"lists and dicts within each other go down to 8: make them flatter";
/// Length of a value in memory, bytes.
pub const SIZE: usize = 9;

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

/// A value of the language. A tag of a whole word makes it four words, which are copied at once: with a byte
/// the code is a twentieth larger.
#[derive(Clone, Copy, Debug)]
#[repr(u32)]
pub enum Value {
    /// Nothing, with the name that led to it.
    Undefined(Text),
    None,
    Bool(bool),
    Int(i64),
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

const SEQS: [Seq; 6] = [Seq::List, Seq::Tuple, Seq::Keys, Seq::Values, Seq::Items, Seq::Once];

impl Value {
    /// Bytes of the value in memory.
    pub fn encode(self) -> (u8, [u8; 8]) {
        let word = |word: u16| u64::from(word).to_le_bytes();
        match self {
            Self::Undefined(text) => (0, (u64::from(text.at) | u64::from(text.len) << 16).to_le_bytes()),
            Self::None => (1, [0; 8]),
            Self::Bool(is) => (2, word(u16::from(is))),
            Self::Int(int) => (3, int.to_le_bytes()),
            Self::Float(float) => (4, float.to_le_bytes()),
            Self::Str(text) => (5, (u64::from(text.at) | u64::from(text.len) << 16).to_le_bytes()),
            Self::Seq(kind, head) => (6 + kind as u8, word(head)),
            Self::Map(Map::Dict, head) => (12, word(head)),
            Self::Map(Map::Namespace, head) => (13, word(head)),
            Self::Range(at) => (14, word(at)),
            Self::Object(object) => (15 + object.kind as u8, u64::from(object.id).to_le_bytes()),
            Self::Function(number) => (19, word(u16::from(number))),
            Self::Method => (20, [0; 8]),
            Self::Loop(place) => (21, word(place)),
        }
    }

    /// The value with these bytes.
    pub fn decode(tag: u8, payload: [u8; 8]) -> Self {
        let bits = u64::from_le_bytes(payload);
        let word = bits as u16;
        let text = Text { at: word, len: (bits >> 16) as u16 };
        match tag {
            0 => Self::Undefined(text),
            2 => Self::Bool(bits != 0),
            3 => Self::Int(bits as i64),
            4 => Self::Float(f64::from_bits(bits)),
            5 => Self::Str(text),
            6..=11 => Self::Seq(SEQS.get(usize::from(tag - 6)).copied().unwrap_or(Seq::List), word),
            12 => Self::Map(Map::Dict, word),
            13 => Self::Map(Map::Namespace, word),
            14 => Self::Range(word),
            15..=18 => {
                let kind = [Kind::Lookup, Kind::Dict, Kind::List, Kind::Tuple];
                let kind = kind.get(usize::from(tag - 15)).copied().unwrap_or(Kind::Lookup);
                Self::Object(Object { id: bits as u32, kind })
            }
            19 => Self::Function(word as u8),
            20 => Self::Method,
            21 => Self::Loop(word),
            _ => Self::None,
        }
    }

    /// Whether the value lies in memory behind a place, so that it has to be kept.
    pub fn lies_behind(self, keep: usize, pool: usize) -> bool {
        let is = |at: u16| usize::from(at) >= keep && usize::from(at) < pool;
        match self {
            Self::Str(text) => is(text.at),
            Self::Seq(_, at) | Self::Map(_, at) | Self::Range(at) => is(at),
            Self::Undefined(_) | Self::None | Self::Bool(_) | Self::Int(_) | Self::Float(_) => false,
            Self::Object(_) | Self::Function(_) | Self::Method | Self::Loop(_) => false,
        }
    }

    /// Name of the value's type, as Python calls it.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Undefined(_) => "undefined",
            Self::None => "none",
            Self::Bool(_) => "bool",
            Self::Int(_) => "int",
            Self::Float(_) => "float",
            Self::Str(_) => "str",
            Self::Seq(Seq::List, _) => "list",
            Self::Seq(Seq::Tuple, _) => "tuple",
            Self::Seq(Seq::Keys | Seq::Values | Seq::Items, _) => "view of a dict",
            Self::Seq(Seq::Once, _) => "result of a filter",
            Self::Map(Map::Dict, _) => "dict",
            Self::Map(Map::Namespace, _) => "namespace",
            Self::Range(_) => "range",
            Self::Object(object) => match object.kind {
                Kind::Lookup => "object",
                Kind::Dict => "dict",
                Kind::List => "list",
                Kind::Tuple => "tuple",
            },
            Self::Function(_) | Self::Method => "function",
            Self::Loop(_) => "loop",
        }
    }
}
