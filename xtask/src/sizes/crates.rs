//! Bytes of the image's flash by crate, by the names of its symbols.
//!
//! A function that was inlined counts for the crate it ended up in, a generic one for the crate it was
//! written in. Constants without a name, and what has no symbol at all, are one entry each.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol, SymbolKind};

use crate::memory;

/// Constants that the compiler made, without a name of their own.
const CONSTANTS: &str = "constants";
/// Tables of sections, padding, strings that the linker merged.
const UNNAMED: &str = "unnamed";

/// Bytes of flash by crate, and the two entries above.
pub fn by_crate(elf_bytes: &[u8]) -> Result<BTreeMap<String, u64>> {
    let file = object::File::parse(elf_bytes).context("not an ELF file")?;
    let flash = memory::REGIONS.iter().find(|(name, _)| *name == "flash").map(|(_, range)| range.clone());
    let flash = flash.context("no flash")?;
    let mut sizes = BTreeMap::new();
    // Several names may stand for one place.
    let mut places: BTreeMap<u64, (u64, &str)> = BTreeMap::new();
    for symbol in file.symbols() {
        let is_stored = matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data);
        if is_stored && flash.contains(&symbol.address()) && symbol.size() > 0 {
            places.insert(symbol.address() & !1, (symbol.size(), symbol.name().unwrap_or_default()));
        }
    }
    for (size, name) in places.values() {
        *sizes.entry(crate_of(name)).or_insert(0) += size;
    }
    let named: u64 = sizes.values().sum();
    let stored = memory::used(elf_bytes)?.into_iter().find(|(name, _)| *name == "flash").map_or(0, |(_, bytes)| bytes);
    sizes.insert(UNNAMED.into(), stored.saturating_sub(named));
    Ok(sizes)
}

/// Prints them, largest first.
pub fn report(elf: &[u8]) -> Result<()> {
    let mut sizes: Vec<_> = by_crate(elf)?.into_iter().collect();
    sizes.sort_by_key(|(_, size)| std::cmp::Reverse(*size));
    let sum: u64 = sizes.iter().map(|(_, size)| size).sum();
    for (name, size) in sizes {
        println!("{name:>24} {size:>8} bytes  {:>5.1} %", size as f64 * 100.0 / sum as f64);
    }
    println!("{:>24} {sum:>8} bytes", "flash");
    Ok(())
}

fn crate_of(symbol: &str) -> String {
    if symbol.contains("Lanon") || symbol.contains("anon.") {
        return CONSTANTS.into();
    }
    let name = format!("{:#}", rustc_demangle::demangle(symbol));
    let path = name.trim_start_matches(|c: char| !c.is_alphanumeric() && c != '_');
    let path = path.strip_prefix("impl ").or_else(|| path.strip_prefix("mut ")).unwrap_or(path);
    match path.split_once("::") {
        Some((first, _)) if first.chars().all(|c| c.is_alphanumeric() || c == '_') => first.into(),
        _ => "without a crate".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symbol_belongs_to_the_crate_it_names_first() {
        for (symbol, owner) in [
            ("_ZN7machine8executor3run17h0123456789abcdefE", "machine"),
            (
                "_ZN81_$LT$gcode..scanner..Blocks$u20$as$u20$core..iter..traits..iterator..Iterator$GT$4next17h580ad284d6ddc38fE",
                "gcode",
            ),
            (".Lanon.88b94e7312261267de5bd5db2f6d1e4d.214", CONSTANTS),
            ("memcpy", "without a crate"),
        ] {
            assert_eq!(crate_of(symbol), owner, "{symbol}");
        }
    }
}
