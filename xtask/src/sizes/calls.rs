//! The call graph of an image, with the bytes of stack that each caller holds, from its machine code,
//! with the frames as they are, inlined calls and tail calls included.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use crate::thumb::{self, Effect};

/// A function of the image.
#[derive(Debug, Default)]
pub struct Function {
    /// As a person writes it.
    pub name: String,
    /// Largest frame on the stack, bytes, calls not counted.
    pub frame: i64,
    /// Functions called by address: where each begins, and the bytes on the stack of the caller meanwhile.
    pub calls: BTreeMap<u64, i64>,
    /// Most bytes on the stack of the caller while it calls by a register; none if it does not.
    pub by_register: Option<i64>,
    /// The addresses in the image that it has as constants, with bit 0: functions that it may hand on.
    pub constants: Vec<u32>,
}

/// Every function of the image, by the address at which it begins.
pub fn functions(elf: &[u8]) -> Result<BTreeMap<u64, Function>> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    let mut bounds = BTreeMap::new();
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
        bounds.entry(symbol.address() & !1).or_insert((symbol.size(), symbol.name().unwrap_or_default()));
    }
    let mut functions = BTreeMap::new();
    for section in file.sections().filter(|section| section.kind() == SectionKind::Text) {
        let (data, from) = (section.data()?, section.address());
        let code = Code { data, from, marks: marks(&file) };
        for (&start, &(size, name)) in bounds.range(from..from + section.size()) {
            let mut function = read(&code, start, start + size);
            function.name = format!("{:#}", rustc_demangle::demangle(name));
            functions.insert(start, function);
        }
    }
    Ok(functions)
}

/// A section with code.
struct Code<'e> {
    data: &'e [u8],
    from: u64,
    /// Where code begins (true) and data (false): mapping symbols `$t` and `$d` (ELF for the Arm
    /// architecture, section 5.5.5).
    marks: BTreeMap<u64, bool>,
}

impl Code<'_> {
    fn half(&self, address: u64) -> u16 {
        let at = usize::try_from(address - self.from).unwrap_or(usize::MAX);
        let bytes = self.data.get(at..).and_then(|bytes| bytes.first_chunk());
        bytes.map_or(0, |bytes| u16::from_le_bytes(*bytes))
    }

    fn is_code(&self, address: u64) -> bool {
        self.marks.range(..=address).next_back().is_none_or(|(_, &is_code)| is_code)
    }
}

fn marks(file: &object::File<'_>) -> BTreeMap<u64, bool> {
    let mark = |symbol: object::Symbol<'_, '_>| {
        let name = symbol.name().ok()?;
        let is_code = name == "$t" || name.starts_with("$t.");
        (is_code || name == "$d" || name.starts_with("$d.")).then_some((symbol.address(), is_code))
    };
    file.symbols().filter_map(mark).collect()
}

/// Follows the instructions of a function in their order. The depth of the stack is known behind a branch
/// forwards; behind what does not go on and is led to from nowhere before, it is that of the last table or
/// else the deepest.
fn read(code: &Code<'_>, start: u64, end: u64) -> Function {
    let mut walk = Walk {
        code,
        within: start..end,
        function: Function::default(),
        registers: [None; 16],
        below: [0; 16],
        known: BTreeMap::new(),
        of_table: None,
    };
    let (mut depth, mut address) = (Some(0), start);
    while address < end {
        if !code.is_code(address) {
            address += 2;
            continue;
        }
        let instruction = thumb::decode(address, code.half(address), code.half(address + 2));
        let known = walk.known.get(&address).copied();
        let at = known.or(depth).or(walk.of_table).unwrap_or(walk.function.frame);
        let here = walk.stack(&instruction.effect, at);
        let goes_on = walk.flow(&instruction.effect, at);
        walk.write(&instruction.effect, at);
        walk.function.frame = walk.function.frame.max(here);
        depth = goes_on.then_some(here);
        address += instruction.length;
    }
    walk.function
}

/// State of a walk through a function's instructions.
struct Walk<'c, 'e> {
    code: &'c Code<'e>,
    within: Range<u64>,
    function: Function,
    /// Constants in registers.
    registers: [Option<u32>; 16],
    /// Depths of the stack that registers have kept.
    below: [i64; 16],
    /// Depths at the targets of branches.
    known: BTreeMap<u64, i64>,
    /// Depth at the last table of branches.
    of_table: Option<i64>,
}

impl Walk<'_, '_> {
    /// Returns the depth behind an instruction, from that before it.
    fn stack(&self, effect: &Effect, at: i64) -> i64 {
        match *effect {
            Effect::Stack(bytes) => at + bytes,
            Effect::StackBy(register) => at + i64::from(self.registers[usize::from(register)].unwrap_or_default()),
            Effect::StackFrom(register) => at.max(self.below[usize::from(register)] + ALIGNED),
            _ => at,
        }
    }

    /// Follows calls and branches. Returns whether the next instruction is the one behind.
    fn flow(&mut self, effect: &Effect, at: i64) -> bool {
        match *effect {
            Effect::Call(target) => call(&mut self.function, target, at),
            Effect::CallRegister(register) | Effect::JumpRegister(register) => {
                match self.registers[usize::from(register)] {
                    Some(target) => call(&mut self.function, u64::from(target), at),
                    None => self.function.by_register = self.function.by_register.max(Some(at)),
                }
            }
            Effect::Branch(target) | Effect::Jump(target) if self.within.contains(&target) => {
                self.known.insert(target, at);
            }
            Effect::Branch(target) | Effect::Jump(target) => call(&mut self.function, target, at),
            Effect::Table => self.of_table = Some(at),
            _ => {}
        }
        !matches!(effect, Effect::JumpRegister(_) | Effect::Jump(_) | Effect::Table | Effect::Return)
    }

    /// Keeps track of what registers hold.
    fn write(&mut self, effect: &Effect, at: i64) {
        match *effect {
            Effect::BelowStack(register, bytes) => self.below[usize::from(register)] = at + bytes,
            Effect::Constant(register, value) => self.registers[usize::from(register)] = Some(value),
            Effect::Upper(register, value) => {
                let register = &mut self.registers[usize::from(register)];
                *register = register.map(|lower| lower & 0xFFFF | u32::from(value) << 16);
                self.function.constants.extend(*register);
            }
            Effect::Literal(register, address) => {
                let word = u32::from(self.code.half(address)) | u32::from(self.code.half(address + 2)) << 16;
                self.registers[usize::from(register)] = Some(word);
                self.function.constants.push(word);
            }
            Effect::Call(_) | Effect::CallRegister(_) => forget(&mut self.registers, CALLERS),
            Effect::Other(written) => forget(&mut self.registers, written),
            _ => {}
        }
    }
}

/// Bytes that aligning a frame may add to it.
const ALIGNED: i64 = 32;

/// r0 to r3 and r12, which a called function may change (procedure call standard, section 6.1.1).
const CALLERS: u16 = 0x100F;

fn forget(registers: &mut [Option<u32>; 16], written: u16) {
    for (number, register) in registers.iter_mut().enumerate().filter(|(number, _)| written >> number & 1 == 1) {
        debug_assert!(number < 16);
        *register = None;
    }
}

fn call(function: &mut Function, target: u64, depth: i64) {
    let most = function.calls.entry(target & !1).or_insert(depth);
    *most = depth.max(*most);
}
