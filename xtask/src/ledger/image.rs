//! Sizes of the linked image.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol};

use super::figures::{Ledger, SIZE};
use crate::{memory, sizes};

/// The source with the interrupts' priorities.
const TASKS: &str = "firmware/src/main.rs";
/// The symbol of the executor's stack.
const STACK: &str = "thread_stack5STACK";

/// Returns the sizes of the linked image: flash in all and by crate, what is free of each memory, and its
/// stacks.
pub fn sizes(root: &Path, image: &[u8]) -> Result<Ledger> {
    let mut figures = Ledger::new();
    for ((name, used), (_, range)) in memory::used(image)?.into_iter().zip(memory::REGIONS) {
        if name == "flash" {
            figures.insert("flash_bytes".into(), used as f64);
        } else {
            figures.insert(format!("{name}_free_bytes"), (range.end - range.start) as f64 - used as f64);
        }
    }
    for (name, bytes) in sizes::by_crate(image)? {
        figures.insert(format!("{SIZE}{}", name.replace(' ', "_")), bytes as f64);
    }
    let tasks = fs::read_to_string(root.join(TASKS)).context(TASKS)?;
    let (executor, main) = (sizes::executor_bytes(image)? as f64, sizes::main_bytes(image, &tasks)? as f64);
    figures.insert("executor_stack_bytes".into(), executor);
    figures.insert("executor_stack_margin_bytes".into(), executor_stack(image)? as f64 - executor);
    figures.insert("main_stack_bytes".into(), main);
    let free = figures.get("dtcm_free_bytes").copied().unwrap_or_default();
    figures.insert("main_stack_margin_bytes".into(), free - main);
    Ok(figures)
}

/// The size of what is reserved for the executor's stack.
fn executor_stack(image: &[u8]) -> Result<u64> {
    let file = object::File::parse(image).context("not an ELF file")?;
    let stack = file.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains(STACK)));
    Ok(stack.context("the image has no stack of the executor")?.size())
}
