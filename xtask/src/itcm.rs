//! The step interrupt must not wait for flash: whatever runs in ITCM may branch only within ITCM.

use std::fs;
use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol};

use crate::thumb::{self, Effect};

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

/// Targets outside ITCM of the branches and calls in `body`, which starts at `start`.
fn leaving_branches(start: u64, body: &[u8]) -> Vec<u64> {
    let half = |at: usize| body.get(at..at + 2).map_or(0, |pair| u16::from_le_bytes([pair[0], pair[1]]));
    let mut targets = Vec::new();
    let mut at = 0;
    while at < body.len() {
        let instruction = thumb::decode(start + at as u64, half(at), half(at + 2));
        if let Effect::Call(target) | Effect::Jump(target) | Effect::Branch(target) = instruction.effect
            && !ITCM.contains(&target)
        {
            targets.push(target);
        }
        at += instruction.length as usize;
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_out_of_itcm_is_seen_and_one_within_is_not() {
        // bl +0x100, assembled by hand from section A7.7.18.
        let within = [0x00, 0xF0, 0x80, 0xF8];
        assert!(leaving_branches(0x400, &within).is_empty());
        assert_eq!(leaving_branches(0xFFFC, &within), [0x1_0100]);
    }
}
