//! Subcommand `virtual-prime test`: runs an on-target test image to its semihosting exit.

use std::io::{self, Write};

use clap::Args;
use virtual_prime::instruments::{Instruments, Probe};
use virtual_prime::vm::{Span, Vm};

use super::log::{Log, texts};
use super::machine::BoardOptions;

const MS: u64 = 1_000_000;

/// Options of `test`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    board: BoardOptions,
    /// Virtual seconds after which the test counts as hung.
    #[arg(long, default_value_t = 60.0)]
    until: f64,
    /// Fail when the emulator has complaints about the image's use of the hardware.
    #[arg(long)]
    strict: bool,
}

/// Runs the image; its log and consoles go to standard output.
///
/// # Errors
/// When a test failed, the image crashed or the deadline passed.
pub fn run(options: &Options) -> Result<(), String> {
    let board = options.board.build(Vec::new())?;
    let consoles = [0, 1, 2].map(|index| board.console(index).clone());
    let (instruments, records) = Instruments::new(&options.board.elf, &Probe::default())?;
    let table = texts(&options.board.elf)?;
    let mut log = Log::new(table.as_ref());
    let mut vm =
        Vm::start(board, &options.board.elf, Some(Box::new(instruments))).map_err(|error| error.to_string())?;
    let deadline_ns = (options.until * 1e9) as u64;
    let outcome = loop {
        let mut span = vm.run_for(MS);
        let mut out = io::stdout().lock();
        {
            let mut records = records.lock();
            log.take(&std::mem::take(&mut records.rtt), &mut out);
            let _ = out.write_all(&std::mem::take(&mut records.semihosting));
        }
        for console in &consoles {
            let _ = out.write_all(&console.receive());
        }
        if vm.now_ns() >= deadline_ns && span == Span::Reached {
            span = Span::Failed(format!("no end after {} virtual seconds", options.until));
        }
        match span {
            Span::Reached => {}
            Span::Exited(0) => break Ok(()),
            Span::Exited(status) => break Err(format!("the image ended with status {status}")),
            Span::Failed(reason) => break Err(reason),
        }
    };
    let found = vm.complaints();
    for line in &found {
        eprintln!("board: {line}");
    }
    if options.strict && !found.is_empty() {
        return outcome.and(Err(format!("{} complaints of the board", found.len())));
    }
    outcome
}
