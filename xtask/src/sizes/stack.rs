//! Bytes that the image needs of its two stacks: the executor's, and the main one, on which the start-up code
//! and interrupts run.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use object::{Object, ObjectSection};

use super::depth::{Descent, END, EXECUTOR, Graph, PANIC, RESET};

/// From this size on a frame is looked at.
const LARGE: i64 = 4096;
/// Frame of an interrupt's entry: 26 words with the registers of the floating point unit, and
/// one to align them (ARM DDI 0403E, section B1.5.6).
const ENTRY_BYTES: i64 = 27 * 4;

/// Greatest depth of the executor's stack, bytes.
///
/// # Errors
/// Those of [`Graph::deepest`].
pub fn executor_bytes(elf: &[u8]) -> Result<i64> {
    Ok(bytes(&Graph::read(elf)?.deepest(EXECUTOR)?))
}

/// Greatest depth of the main stack, bytes: bringing the board up, with interrupts off; or an interrupt
/// of each priority in the middle of one of the next lower; and an end behind that. `tasks`: the source that
/// has the priorities, which RTIC sets.
///
/// # Errors
/// Those of [`Graph::deepest`].
pub fn main_bytes(elf: &[u8], tasks: &str) -> Result<i64> {
    let graph = Graph::read(elf)?;
    let (begin, interrupts) = on_main(elf, &graph)?;
    let mut levels: BTreeMap<String, i64> = BTreeMap::new();
    for (name, bytes) in interrupts {
        // An interrupt without a task has a priority of its own.
        let most = levels.entry(priority(tasks, &name).unwrap_or(name)).or_default();
        *most = bytes.max(*most);
    }
    Ok(begin.max(levels.values().sum()) + end_bytes(&graph)?)
}

/// The priority in `#[task(binds = NAME, priority = 4, ...)]`.
fn priority(tasks: &str, interrupt: &str) -> Option<String> {
    let (_, behind) = tasks.split_once(&format!("binds = {interrupt}, priority = "))?;
    Some(behind.chars().take_while(char::is_ascii_digit).collect())
}

/// Depth of the end of the program: a panic's, which says the most. A panic begins with the function of all
/// ends that is left out of every other path.
fn end_bytes(graph: &Graph) -> Result<i64> {
    Ok(bytes(&graph.deepest(PANIC)?) + bytes(&graph.deepest(END)?))
}

fn bytes(descent: &Descent) -> i64 {
    descent.iter().map(|(_, bytes)| bytes).sum()
}

/// Depth of bringing the board up, and of each interrupt.
fn on_main(elf: &[u8], graph: &Graph) -> Result<(i64, Vec<(String, i64)>)> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    let table = file.section_by_name(".vector_table").context("no vector table")?;
    let words = table.data()?.chunks_exact(4).filter_map(|word| word.try_into().ok().map(u32::from_le_bytes));
    let mut names: Vec<String> = words.filter_map(|word| graph.name_of(word)).collect();
    names.sort_unstable();
    names.dedup();
    names.retain(|name| name != RESET);
    let of = |name: &str| Ok::<_, anyhow::Error>(bytes(&graph.deepest(name)?));
    let interrupts: Result<Vec<_>> =
        names.into_iter().map(|name| Ok((name.clone(), of(&name)? + ENTRY_BYTES))).collect();
    Ok((of(RESET)?, interrupts?))
}

/// Prints the deepest path from a function.
pub fn report_from(elf: &[u8], name: &str) -> Result<()> {
    show(&Graph::read(elf)?.deepest(name)?);
    Ok(())
}

fn show(descent: &Descent) {
    let mut sum = 0;
    for (name, bytes) in descent {
        sum += bytes;
        println!("{bytes:>8} {sum:>8}  {name}");
    }
}

/// Prints the deepest path of the executor, what the main stack takes, and the largest frames.
pub fn report(elf: &[u8]) -> Result<()> {
    let graph = Graph::read(elf)?;
    let descent = graph.deepest(EXECUTOR)?;
    show(&descent);
    println!(
        "{} bytes at most on the executor's stack; a panic there takes {} more",
        bytes(&descent),
        end_bytes(&graph)?
    );
    let (begin, interrupts) = on_main(elf, &graph)?;
    println!("\n{begin:>8}  bringing the board up, on the main stack");
    interrupts.iter().for_each(|(name, bytes)| println!("{bytes:>8}  {name}"));
    println!("\nframes of {LARGE} bytes and more");
    let large = graph.by_frame().into_iter().take_while(|function| function.frame >= LARGE);
    large.for_each(|function| println!("{:>8}  {}", function.frame, function.name));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_priority_is_that_of_its_task() {
        let tasks = "#[task(binds = TIM7, priority = 5, shared = [heat])]\n#[task(binds = EXTI0, priority = 7)]";
        assert_eq!(priority(tasks, "TIM7").as_deref(), Some("5"));
        assert_eq!(priority(tasks, "EXTI0").as_deref(), Some("7"));
        assert_eq!(priority(tasks, "TIM2"), None);
    }
}
