//! The step interrupt must not wait for flash: whatever runs in ITCM may branch only within ITCM.
//!
//! Thumb-2 branches are decoded here by hand: only BL, B.W and the literal loads of a long call matter, and a
//! disassembler would be a large dependency for four bit patterns (ARM DDI 0403E, sections A7.7.12 and
//! A7.7.18).

use std::fs;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol};

/// ITCM (RM0399 section 2.3, table 7).
const ITCM: Range<u64> = 0x0000_0000..0x0001_0000;

/// Fails when a branch in ITCM leaves it.
pub fn check(elf: &Path) -> Result<()> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    let file = object::File::parse(bytes.as_slice()).context("not an ELF file")?;
    let mut faults = Vec::new();
    let mut code = 0;
    for symbol in file.symbols().filter(|symbol| symbol.kind() == object::SymbolKind::Text && symbol.size() > 0) {
        // Bit 0 of a Thumb symbol is the instruction set, not the address.
        let start = symbol.address() & !1;
        if !ITCM.contains(&start) {
            continue;
        }
        let section = file.section_by_index(symbol.section_index().context("symbol without a section")?)?;
        let offset = usize::try_from(start - section.address())?;
        let data = section.data()?;
        let body = data.get(offset..offset + usize::try_from(symbol.size())?).context("symbol outside its section")?;
        code += body.len();
        for target in leaving_branches(start, body) {
            let from = symbol.name().unwrap_or("?");
            faults.push(format!("{from} branches to 0x{target:08X} ({})", name_at(&file, target)));
        }
    }
    ensure!(code > 0, "no code in ITCM: the step interrupt has lost its place");
    if faults.is_empty() {
        println!("itcm: {code} bytes of code, no branch leaves");
        return Ok(());
    }
    for fault in &faults {
        eprintln!("  {fault}");
    }
    bail!("{} branch(es) leave ITCM", faults.len())
}

fn name_at(file: &object::File<'_>, address: u64) -> String {
    file.symbols()
        .find(|symbol| symbol.address() & !1 == address)
        .and_then(|symbol| symbol.name().ok().map(str::to_owned))
        .unwrap_or_else(|| "no symbol".into())
}

/// Targets outside ITCM of the 32-bit branches in `body`, which starts at `start`.
fn leaving_branches(start: u64, body: &[u8]) -> Vec<u64> {
    let halves: Vec<u16> = body.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    let mut targets = Vec::new();
    let mut index = 0;
    while index < halves.len() {
        let first = halves[index];
        // 32-bit instructions begin with 0b11101, 0b11110 or 0b11111 (section A5.1).
        let wide = first >> 11 >= 0b11101;
        if wide && index + 1 < halves.len() {
            let pc = start + 2 * index as u64 + 4;
            if let Some(offset) = long_branch(first, halves[index + 1]) {
                let target = pc.wrapping_add_signed(offset) & 0xFFFF_FFFF;
                if !ITCM.contains(&target) {
                    targets.push(target);
                }
            }
        }
        index += if wide { 2 } else { 1 };
    }
    targets
}

/// The offset of a BL (T1) or an unconditional B.W (T4); none for anything else.
fn long_branch(first: u16, second: u16) -> Option<i64> {
    let is_bl = second & 0xD000 == 0xD000;
    let is_b = second & 0xD000 == 0x9000;
    if first & 0xF800 != 0xF000 || !(is_bl || is_b) {
        return None;
    }
    let sign = u32::from(first >> 10) & 1;
    let j1 = u32::from(second >> 13) & 1;
    let j2 = u32::from(second >> 11) & 1;
    let i1 = !(j1 ^ sign) & 1;
    let i2 = !(j2 ^ sign) & 1;
    let high = u32::from(first) & 0x3FF;
    let low = u32::from(second) & 0x7FF;
    let offset = sign << 24 | i1 << 23 | i2 << 22 | high << 12 | low << 1;
    // Sign-extend 25 bits.
    Some(i64::from((offset << 7).cast_signed() >> 7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_out_of_itcm_is_seen_and_one_within_is_not() {
        // bl +0x100 and b.w -4, assembled by hand from section A7.7.18 and A7.7.12.
        assert_eq!(long_branch(0xF000, 0xF880), Some(0x100));
        assert_eq!(long_branch(0xF7FF, 0xBFFE), Some(-4));
        let within = [0x00, 0xF0, 0x80, 0xF8];
        assert!(leaving_branches(0x400, &within).is_empty());
        assert_eq!(leaving_branches(0xFFFC, &within), [0x1_0100]);
    }

    #[test]
    fn other_wide_instructions_are_no_branches() {
        // movw r0, #0x1234 and ldr.w r0, [r1, #4].
        assert_eq!(long_branch(0xF241, 0x2034), None);
        assert_eq!(long_branch(0xF8D1, 0x0004), None);
    }
}
