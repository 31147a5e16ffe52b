//! `velvet`: what a person does with a machine description and a job, away from the machine.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

mod actions;
mod bed;
mod boards;
mod check;
mod colour;
mod console;
mod flash;
mod heat;
mod keys;
mod macros;
mod migrate;
mod motion_page;
mod network;
mod page;
mod plot;
mod preflight;
mod progress;
mod raster;
mod report;
mod run;
mod send;
mod verify;

#[derive(Parser)]
#[command(name = "velvet", version, about, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Check a configuration; exits 1 when something of the machine stays off or all of it, 2 when the file
    /// cannot be read
    Check {
        /// The configuration
        file: PathBuf,
        /// Findings as one JSON object
        #[arg(long)]
        json: bool,
        /// Exit 1 for warnings too
        #[arg(long)]
        deny_warnings: bool,
        /// Which drivers the board has: they decide some defaults
        #[arg(long, value_enum, default_value_t)]
        board: run::Chip,
    },
    /// Print what a G-code program asks of a machine, one action a line; exits 2 at a line that cannot be
    /// carried out
    Actions {
        /// The program
        file: PathBuf,
        /// The tool table, as the machine has it in tool.tbl
        #[arg(long, value_name = "FILE")]
        tools: Option<PathBuf>,
    },
    /// Look through a job before it is made: what stops it, what limits cut, how long it takes; exits 1 when
    /// something stops it
    Preflight(preflight::Options),
    /// Look at a mesh of a bed, as the board saved it on its card: where it is high, what to do about it
    Bed(bed::Options),
    /// Look at the tuning of a heater (M303, M306), as a console has heard it: what was measured, what the
    /// gains mean
    Heat(heat::Options),
    /// Print the JSON Schema of the configuration
    Schema,
    /// Turn a Smoothieware v1 config into a config.ini; exits 1 when something must be mended before it can
    /// be used
    Migrate(migrate::Options),
    /// Klipper's macros: check the templates of a printer.cfg, or print the lines that one makes
    #[command(subcommand)]
    Macro(macros::Options),
    /// Execute a job on this computer in virtual time, and write down what the machine did
    Run(run::Options),
    /// Compare every step edge of a run with the ideal trajectory of its job, whichever board made them
    Verify(verify::Options),
    /// Draw how a job moves: OUT/motion.html with speed, acceleration, jerk, corners, and each step's
    /// distance from ideal
    Motion(motion_page::Options),
    /// Draw the page about a run: OUT/report.html
    Report {
        /// The run's folder
        out: PathBuf,
        #[command(flatten)]
        sources: report::Sources,
    },
    /// Say in a few lines how a run went; exits 1 when a check failed
    Summary {
        /// The run's folder
        out: PathBuf,
        #[command(flatten)]
        sources: report::Sources,
    },
    /// Compare each edge of a laser's power with its place in the program, and draw the picture the edges
    /// make: OUT/laser.svg; exits 1 when an edge is not in its place
    Laser {
        /// The run's folder
        out: PathBuf,
        #[command(flatten)]
        sources: report::Sources,
    },
    /// Turn a picture into G-code for a laser, and draw the page that shows what the G-code burns
    Raster(raster::Options),
    /// Draw a run's curves in the terminal
    Plot {
        /// The run's folder
        out: PathBuf,
        /// What to draw
        #[arg(long, value_enum, default_values_t = [report::Quantity::Speed, report::Quantity::Temperature])]
        of: Vec<report::Quantity>,
        #[command(flatten)]
        sources: report::Sources,
    },
    /// Send G-code to a board, a line at a time
    Send(send::Options),
    /// List the boards of the local network, as they answer by mDNS; exits 1 when none does
    Boards(boards::Options),
    /// Open a console on a board in the network: lines of the standard input go to the board, typed or piped
    Console(console::Options),
    /// Say the public half of the key that firmware is signed with, as config.ini has it; makes a key
    /// when there is none
    Key(keys::KeyOptions),
    /// Sign firmware with a key
    Sign(keys::SignOptions),
    /// Write the firmware onto a board, with probe-rs or dfu-util
    Flash {
        /// The image
        #[arg(default_value = "target/thumbv7em-none-eabihf/release/firmware")]
        image: PathBuf,
        /// How [default: by the tool that is installed]
        #[arg(long, value_enum)]
        with: Option<flash::Way>,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("velvet: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run(command: Command) -> Result<ExitCode> {
    match command {
        Command::Check { file, json, deny_warnings, board } => {
            Ok(success(check::check(&file, json, deny_warnings, board.board())?))
        }
        Command::Actions { file, tools } => actions::print(&file, tools.as_deref()).map(|()| ExitCode::SUCCESS),
        Command::Preflight(options) => Ok(success(preflight::preflight(&options)?)),
        Command::Bed(options) => bed::bed(&options).map(|()| ExitCode::SUCCESS),
        Command::Heat(options) => heat::heat(&options).map(|()| ExitCode::SUCCESS),
        Command::Schema => {
            print!("{}", config::schema::json_schema());
            Ok(ExitCode::SUCCESS)
        }
        Command::Migrate(options) => Ok(success(migrate::migrate(&options)?)),
        Command::Macro(options) => Ok(success(macros::macros(&options)?)),
        Command::Run(options) => Ok(success(run::run(&options)?)),
        Command::Verify(options) => Ok(success(verify::verify(&options)?)),
        Command::Motion(options) => {
            println!("{}", motion_page::write(&options)?.display());
            Ok(ExitCode::SUCCESS)
        }
        Command::Report { out, sources } => {
            let page = report::Report::read(&out, &sources)?.write_page(&out)?;
            println!("{}", page.display());
            Ok(ExitCode::SUCCESS)
        }
        Command::Summary { out, sources } => {
            let report = report::Report::read(&out, &sources)?;
            print!("{}", report.text());
            Ok(success(report.passes()))
        }
        Command::Laser { out, sources } => Ok(success(report::laser::laser(&out, &sources)?)),
        Command::Raster(options) => raster::raster(&options).map(|()| ExitCode::SUCCESS),
        Command::Plot { out, of, sources } => {
            let report = report::Report::read(&out, &sources)?;
            of.into_iter().for_each(|quantity| print!("{}", report.plot(quantity)));
            Ok(ExitCode::SUCCESS)
        }
        Command::Send(options) => send::send(&options).map(|()| ExitCode::SUCCESS),
        Command::Boards(options) => Ok(success(boards::boards(&options)?)),
        Command::Console(options) => console::console(&options).map(|()| ExitCode::SUCCESS),
        Command::Key(options) => keys::key(&options).map(|()| ExitCode::SUCCESS),
        Command::Sign(options) => keys::sign(&options).map(|()| ExitCode::SUCCESS),
        Command::Flash { image, with } => flash::flash(&image, with).map(|()| ExitCode::SUCCESS),
    }
}

const fn success(yes: bool) -> ExitCode {
    if yes { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
