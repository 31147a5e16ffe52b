//! Finds the functions that a call by a register may reach, by the addresses in the image's code and tables.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};
use object::{Object, ObjectSection, SectionKind};

use super::calls::Function;

/// What is called through a field: how the caller's name begins, and what the called one's holds.
const FIELDS: [(&str, &str); 7] = [
    ("machine::machine::Machine<P>::", " as preflight::forecast::work::Forecaster>"),
    ("machine::executor::run", " as preflight::forecast::work::Forecaster>"),
    ("machine::features::forecast::", " as preflight::forecast::work::Forecaster>"),
    ("preflight::lines::Reading", " as preflight::state::Listener>"),
    ("motion::", "bsp_prime::fpu::square_root"),
    ("TIM6_DAC", "bsp_prime::fpu::square_root"),
    ("OTG_FS", " as usb_device::class::UsbClass<B>>"),
];

/// Functions of `core::fmt` that format other values; the rest of it only writes text.
const FORMATS: [&str; 5] =
    ["core::fmt::write", "core::fmt::builders::Debug", ">::debug_", "&dyn core::fmt::", "::assert_failed_inner"];

/// Ending of the name of a closure.
const CLOSURE: &str = "{{closure}}";

/// Functions whose addresses the image holds as data.
pub struct Pointers {
    in_tables: BTreeSet<u64>,
    callers: BTreeMap<u64, Vec<u64>>,
}

impl Pointers {
    /// From the image's data, and the calls that are known.
    pub fn read(elf: &[u8], functions: &BTreeMap<u64, Function>) -> Result<Self> {
        let mut in_tables = BTreeSet::new();
        let file = object::File::parse(elf).context("not an ELF file")?;
        let is_data =
            |kind| matches!(kind, SectionKind::ReadOnlyData | SectionKind::Data | SectionKind::ReadOnlyString);
        for section in file.sections().filter(|section| is_data(section.kind())) {
            let words = section.data()?.chunks_exact(4).filter_map(|word| word.try_into().ok().map(u32::from_le_bytes));
            in_tables.extend(words.filter_map(|word| function_at(word, functions)));
        }
        let mut callers: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        for (&address, function) in functions {
            function.calls.keys().for_each(|target| callers.entry(*target).or_default().push(address));
        }
        Ok(Self { in_tables, callers })
    }

    /// Functions that a call by a register may reach.
    pub fn candidates(&self, address: u64, functions: &BTreeMap<u64, Function>) -> BTreeSet<u64> {
        let caller = &functions[&address];
        let constants = |of: &Function| -> BTreeSet<u64> {
            of.constants.iter().filter_map(|word| function_at(*word, functions)).collect()
        };
        let named = |is_meant: &dyn Fn(&str) -> bool| -> BTreeSet<u64> {
            functions.iter().filter(|(_, function)| is_meant(&function.name)).map(|(at, _)| *at).collect()
        };
        if caller.name.contains("core::fmt::") || caller.name.ends_with("::fmt") {
            let says = FORMATS.iter().any(|part| caller.name.contains(part));
            let ends = ["::write_str", "::write_char", "::fmt"];
            let writes = |name: &str| !name.starts_with("<core::fmt::Formatter");
            return named(&|name| {
                writes(name) && ends.iter().take(if says { 3 } else { 2 }).any(|end| name.ends_with(end))
            });
        }
        let mut found = constants(caller);
        for (_, called) in FIELDS.iter().filter(|(begin, _)| caller.name.starts_with(begin)) {
            found.append(&mut named(&|name| name.contains(called)));
        }
        if found.is_empty() {
            let callers = self.callers.get(&address).into_iter().flatten();
            found = callers.flat_map(|caller| constants(&functions[caller])).collect();
        }
        if found.is_empty() {
            let is_closure = caller.name.ends_with(CLOSURE);
            let own = crate_of(&caller.name);
            let serves = |at: &&u64| {
                let name = &functions[*at].name;
                let is_own = [crate_of(name), crate_of(trait_of(name))].contains(&own) && !name.ends_with("::fmt");
                (is_own || name.contains("FnOnce::call_once")) && !(name.ends_with("}}") && is_closure)
            };
            found = self.in_tables.iter().filter(serves).copied().collect();
        }
        found.remove(&address);
        found
    }
}

fn function_at(word: u32, functions: &BTreeMap<u64, Function>) -> Option<u64> {
    let address = u64::from(word & !1);
    (word & 1 == 1 && functions.contains_key(&address)).then_some(address)
}

fn crate_of(name: &str) -> &str {
    let path = name.trim_start_matches(['<', '&']);
    let path = path.strip_prefix("dyn ").or_else(|| path.strip_prefix("mut ")).unwrap_or(path);
    path.split("::").next().unwrap_or_default()
}

/// `B` of `<A as B>::function`.
fn trait_of(name: &str) -> &str {
    name.split_once(" as ").map_or(name, |(_, path)| path)
}
