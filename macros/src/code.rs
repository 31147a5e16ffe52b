//! Instructions of a template, for a machine with a stack.
//!
//! Jumps are relative, so that a finished piece of code can be moved.

use crate::memory::Memory;

macro_rules! instructions {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// An instruction; its operands follow it in the code.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Op { $($(#[$doc])* $name,)* }
        const ALL: &[Op] = &[$(Op::$name,)*];
    };
}

instructions! {
    /// Line and column of the tag that begins; temporary values go.
    At,
    /// Writes a text of the template.
    Text,
    /// Writes the last value.
    Emit,
    None,
    True,
    False,
    /// An undefined value by its name.
    Missing,
    /// A whole number of 16 bits.
    Small,
    Int,
    Float,
    Str,
    /// Value of a variable.
    Load,
    List,
    Tuple,
    Dict,
    /// Attribute of a value by name.
    Attribute,
    Item,
    Slice,
    Negative,
    Positive,
    Not,
    Add,
    Subtract,
    Multiply,
    Divide,
    FloorDivide,
    Modulo,
    Power,
    Join,
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
    In,
    NotIn,
    /// A comparison whose right side is compared again; jumps where it does not hold.
    Chain,
    Jump,
    /// Takes a value, jumps if it is false.
    Unless,
    /// Jumps if the last value is false, else takes it.
    And,
    Or,
    /// Makes an argument by name of the last value.
    Keyword,
    /// Makes arguments of the elements, or of the members, of the last value.
    Spread,
    SpreadNamed,
    /// Number of a filter, number of arguments.
    Filter,
    Test,
    /// A filter or test that does not exist.
    Unknown,
    Call,
    Method,
    Store,
    StoreMember,
    /// Makes a place for a variable below the last value.
    Declare,
    /// Puts the parts of a value on the stack, the first one last.
    Unpack,
    /// Takes a value away.
    Drop,
    CaptureBegin,
    CaptureEnd,
    ForBegin,
    /// Puts the next element on the stack or jumps.
    ForNext,
    /// Counts a turn, and makes `loop`.
    ForCount,
    /// Ends a turn of the innermost loop.
    ForAgain,
    /// Ends the loop, and jumps if there was a turn.
    ForEnd,
    FrameBegin,
    FrameEnd,
    End,
}

impl Op {
    /// The instruction with a number.
    pub fn from_byte(byte: u8) -> Self {
        ALL.get(usize::from(byte)).copied().unwrap_or(Self::End)
    }
}

/// Appends an instruction that has no operand.
pub fn emit(memory: &mut Memory<'_>, op: Op) {
    memory.push_byte(op as u8)
}

/// Appends an instruction with an operand.
pub fn emit_word(memory: &mut Memory<'_>, op: Op, word: u16) {
    emit(memory, op);
    memory.push_word(word)
}

/// Appends a jump; returns where its distance is to be written.
pub fn emit_jump(memory: &mut Memory<'_>, op: Op) -> u16 {
    emit_word(memory, op, 0);
    memory.top.saturating_sub(2) as u16
}

/// Leads a jump to a place.
pub fn lead(memory: &mut Memory<'_>, operand: u16, to: u16) {
    memory.set_word(usize::from(operand), to.wrapping_sub(operand + 2));
}
