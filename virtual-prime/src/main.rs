//! `virtual-prime`: runs firmware images on the emulated board. `virtual-prime help` lists what it does.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod commands;

/// The emulated Smoothieboard v2 Prime.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Has the image play a job from the SD card, headless, and writes down what the machine did.
    Run(commands::run::Options),
    /// Counts the instructions of functions while a job runs; JSON on standard output.
    Bench(commands::bench::Options),
    /// A live prompt on the image's consoles, paced to real time.
    Console(commands::console::Options),
    /// Runs an on-target test image to its end.
    Test(commands::test::Options),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Run(options) => commands::run::run(&options),
        Command::Bench(options) => commands::bench::run(&options),
        Command::Console(options) => commands::console::run(&options),
        Command::Test(options) => commands::test::run(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}
