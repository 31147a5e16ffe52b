//! Symbol table of an image: begin and end of functions, and places of variables.

use std::collections::BTreeMap;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

/// Names and code of an ELF image.
#[derive(Debug)]
pub struct Symbols {
    functions: Vec<Function>,
    objects: Vec<(String, Variable)>,
}

/// Place of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Address of the first byte.
    pub address: u64,
    /// Length of the variable, bytes.
    pub size: u64,
}

/// A function's place and code.
#[derive(Clone, Debug)]
pub struct Function {
    /// Name in the symbol table.
    pub name: String,
    /// Address of the first instruction.
    pub address: u64,
    code: Vec<u8>,
}

impl Symbols {
    /// Reads the symbol table of an ELF file.
    ///
    /// # Errors
    /// When the file is no ELF file.
    pub fn read(elf: &Path) -> Result<Self, String> {
        let in_file = |reason: &dyn std::fmt::Display| format!("{}: {reason}", elf.display());
        let bytes = std::fs::read(elf).map_err(|error| in_file(&error))?;
        let file = object::File::parse(&*bytes).map_err(|error| in_file(&error))?;
        let mut symbols = Self { functions: Vec::new(), objects: Vec::new() };
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            if symbol.kind() != SymbolKind::Text {
                symbols.objects.push((name.into(), Variable { address: symbol.address(), size: symbol.size() }));
                continue;
            }
            // Bit 0 of a function's symbol marks Thumb code.
            let address = symbol.address() & !1;
            let code = symbol
                .section_index()
                .and_then(|index| file.section_by_index(index).ok())
                .and_then(|section| section.data_range(address, symbol.size()).ok().flatten())
                .unwrap_or_default();
            symbols.functions.push(Function { name: name.into(), address, code: code.to_vec() });
        }
        Ok(symbols)
    }

    /// Returns the function of this name; a mangled Rust name is found by a segment of its path as well.
    #[must_use]
    pub fn function(&self, name: &str) -> Option<&Function> {
        let segment = format!("{}{name}", name.len());
        self.functions
            .iter()
            .find(|function| function.name == name)
            .or_else(|| self.functions.iter().find(|function| function.name.contains(&segment)))
    }

    /// Returns the function whose code holds this address.
    #[must_use]
    pub fn at(&self, address: u64) -> Option<&Function> {
        self.functions
            .iter()
            .find(|function| (function.address..function.address + function.code.len() as u64).contains(&address))
    }

    /// Returns a variable, by its symbol or by a piece of a mangled one.
    #[must_use]
    pub fn object(&self, name: &str) -> Option<Variable> {
        let exact = self.objects.iter().find(|(object, _)| object == name);
        exact.or_else(|| self.objects.iter().find(|(object, _)| object.contains(name))).map(|&(_, variable)| variable)
    }

    /// Returns the instructions that mask or unmask interrupts, by address.
    #[must_use]
    pub fn masks(&self) -> BTreeMap<u64, Mask> {
        self.functions.iter().flat_map(Function::masks).collect()
    }
}

/// Effect of an instruction on PRIMASK, which masks every interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mask {
    /// `cpsid i`: masks interrupts.
    Set,
    /// `cpsie i`: unmasks interrupts.
    Clear,
    /// `msr primask, rn`: restores an earlier state.
    PutBack,
}

impl Mask {
    /// Decodes an instruction, ARM DDI 0403E.b, B5.2.1 (CPS) and B5.2.3 (MSR, SYSm 16).
    const fn of(first: u16, second: u16) -> Option<Self> {
        match (first, second) {
            (0xB672, _) => Some(Self::Set),
            (0xB662, _) => Some(Self::Clear),
            (0xF380..=0xF38F, 0x8810) => Some(Self::PutBack),
            _ => None,
        }
    }
}

impl Function {
    /// Returns the addresses of the instructions that leave the function: returns, and jumps to other
    /// functions.
    #[must_use]
    pub fn exits(&self) -> Vec<u64> {
        let end = self.address + self.code.len() as u64;
        let mut exits = Vec::new();
        self.walk(|address, first, second, wide| {
            let jumps_away =
                jump_target(address, first, second, wide).is_some_and(|target| !(self.address..end).contains(&target));
            if jumps_away || leaves(first, second, wide) {
                exits.push(address);
            }
        });
        exits
    }

    fn masks(&self) -> Vec<(u64, Mask)> {
        let mut masks = Vec::new();
        self.walk(|address, first, second, _| masks.extend(Mask::of(first, second).map(|mask| (address, mask))));
        masks
    }

    /// Visits each instruction with its address, first and second half, and whether it has two. Constants
    /// between functions look like instructions, and are never executed.
    fn walk(&self, mut visit: impl FnMut(u64, u16, u16, bool)) {
        let half = |at: usize| self.code.get(at..at + 2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
        let mut at = 0;
        while let Some(first) = half(at) {
            // ARM DDI 0403E.b, A5.1: 32-bit instructions begin with 0b11101, 0b11110 or 0b11111.
            let wide = first >> 11 >= 0b11101;
            visit(self.address + at as u64, first, if wide { half(at + 2).unwrap_or(0) } else { 0 }, wide);
            at += if wide { 4 } else { 2 };
        }
    }
}

/// Whether an instruction returns: `bx lr`, `pop {.., pc}`, `ldmia sp!, {.., pc}`, `ldr pc, [sp], #4`.
const fn leaves(first: u16, second: u16, wide: bool) -> bool {
    if wide {
        (first == 0xE8BD && second & 0x8000 != 0) || (first == 0xF85D && second & 0xFF00 == 0xFB00)
    } else {
        first == 0x4770 || first & 0xFF00 == 0xBD00
    }
}

/// Target of an unconditional `b` or `b.w` (A7.7.12, encodings T2 and T4).
fn jump_target(address: u64, first: u16, second: u16, wide: bool) -> Option<u64> {
    let pc = address as i64 + 4;
    if !wide {
        return (first & 0xF800 == 0xE000).then(|| {
            let offset = i64::from(((first & 0x7FF) << 5) as i16 >> 5) * 2;
            (pc + offset) as u64
        });
    }
    if first & 0xF800 != 0xF000 || second & 0xD000 != 0x9000 {
        return None;
    }
    let (s, j1, j2) = (i64::from(first >> 10 & 1), i64::from(second >> 13 & 1), i64::from(second >> 11 & 1));
    let (i1, i2) = (1 - (j1 ^ s), 1 - (j2 ^ s));
    let high = i64::from(first & 0x3FF);
    let low = i64::from(second & 0x7FF);
    let offset = s << 24 | i1 << 23 | i2 << 22 | high << 12 | low << 1;
    Some((pc + if s == 1 { offset - (1 << 25) } else { offset }) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(code: &[u16]) -> Function {
        let code = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        Function { name: "f".into(), address: 0x0800_1000, code }
    }

    #[test]
    fn returns_and_tail_calls_are_exits_and_loops_are_not() {
        // push {r4,lr}; b.n self; bl elsewhere; b.w far away; pop {r4,pc}; ldmia.w sp!,{r4,pc}; bx lr
        let code = [0xB510, 0xE7FE, 0xF000, 0xF800, 0xF000, 0xBFFF, 0xBD10, 0xE8BD, 0x8010, 0x4770];
        let exits: Vec<_> = function(&code).exits().iter().map(|exit| exit - 0x0800_1000).collect();
        assert_eq!(exits, [8, 12, 14, 18]);
    }

    #[test]
    fn instructions_that_mask_interrupts_are_found() {
        // mrs r6, primask; cpsid i; nop; msr primask, r6; cpsie i; msr basepri, r6
        let code = [0xF3EF, 0x8610, 0xB672, 0xBF00, 0xF386, 0x8810, 0xB662, 0xF386, 0x8811];
        let found: Vec<_> = function(&code).masks().iter().map(|(at, mask)| (at - 0x0800_1000, *mask)).collect();
        assert_eq!(found, [(4, Mask::Set), (8, Mask::PutBack), (12, Mask::Clear)]);
    }
}
