//! Checks and builds that cargo alone cannot do. `cargo run -p xtask` lists them.

mod budget;
mod circles;
mod deps;
mod docs;
mod itcm;
mod ledger;
mod limit;
mod memory;
mod package;
mod paths;
mod seal;
mod shape;
mod sizes;
mod sources;
mod structure;
mod thumb;
mod words;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Result, bail};

const HELP: &str = "usage: cargo xtask <task>
  budget ELF VP    the image keeps within bench/budget.toml: its sizes, and what it costs on the virtual board VP
  deps             every crate uses only what the architecture allows, and no source breaks a house rule
  deps CRATE       which file of a crate names which, and those that need each other
  docs             what the documentation names exists, and its figures are those of the ledger
  figures          writes the ledger's figures into docs/performance.md, and draws them over the commits
  itcm ELF         the step interrupt stays in ITCM: no branch from there leaves it
  ledger ELF VP V  what the image costs, counted by the virtual board VP and verified by the velvet command V, against the
                   committed ledger
  seal ELF BOOT    puts the boot stage BOOT and the digest into the image ELF; the whole flash as raw bytes into ELF.bin,
                   the image for a card into flashme.bin beside the firmware, of any other image in the folder ELF.card
  memory ELF       bytes taken in each memory region
  paths ELF        the image ELF names no folder of this computer
  shape            functions, matches, public items and tests of every crate keep their limits
  shape CRATE      which of a crate do not, or not yet
  sizes ELF [WHAT] where bytes and stacks go: crate (bytes of flash by crate), function (the largest), text (constants by
                   kind, texts that are there twice) or stack (how deep stacks get, by calls and frames)
  words [FOLDER]   comments that open with a pronoun or are of a few words, by crate; with FOLDER each of them there";

/// Comments that may open with a pronoun, and that may be of a few words, percent of all.
const MOST_OF_WORDS: (f64, f64) = (1.0, 1.0);

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Result<()> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["deps"] => deps::check(root()),
        ["deps", package] => circles::report(root(), package),
        ["shape"] => shape::check(root()),
        ["shape", package] => shape::report(root(), package),
        ["figures"] => ledger::write_committed(root()),
        ["docs"] => docs::check(root()).and_then(|()| ledger::page::check(root())),
        ["seal", elf, boot] => seal::run(Path::new(elf), Path::new(boot)),
        ["ledger", elf, board, velvet] => ledger::run(root(), Path::new(elf), Path::new(board), Path::new(velvet)),
        ["memory", elf] => memory::report(Path::new(elf)),
        ["sizes", elf] => sizes::report(Path::new(elf), "crate"),
        ["sizes", elf, what] => sizes::report(Path::new(elf), what),
        ["paths", elf] => paths::check(root(), Path::new(elf)),
        ["budget", elf, board] => budget::check(root(), Path::new(elf), Path::new(board)),
        ["words"] => words::check(root(), None, MOST_OF_WORDS),
        ["words", folder] => words::check(root(), Some(folder), MOST_OF_WORDS),
        ["itcm", elf] => itcm::check(Path::new(elf)),
        _ => bail!("{HELP}"),
    }
}

/// The workspace's root: this crate lies one folder below it.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
