//! `velvet boards`: the boards of the local network, as they answer by mDNS.

use std::time::Duration;

use anyhow::Result;
use clap::Args;

use crate::network::browser::{ADVICE, Browser, Machine, Mdns, table};

/// Options of the command.
#[derive(Args)]
pub struct Options {
    /// Seconds to wait for answers
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=600))]
    seconds: u64,
    /// Boards as a JSON array
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    mdns: Mdns,
}

/// Lists the boards. Returns whether there are any.
pub fn boards(options: &Options) -> Result<bool> {
    let machines = Browser::new(&options.mdns)?.machines(Duration::from_secs(options.seconds))?;
    let (boards, others): (Vec<Machine>, Vec<Machine>) = machines.into_iter().partition(Machine::is_board);
    if options.json {
        println!("{}", serde_json::to_string_pretty(&boards)?);
    } else {
        print!("{}", table(&boards));
    }
    if boards.is_empty() {
        eprintln!("No board of Velvet's answered within {} s. {ADVICE}", options.seconds);
    }
    match others.len() {
        0 => {}
        1 => eprintln!("1 other machine offers telnet and is not Velvet's"),
        others => eprintln!("{others} other machines offer telnet and are not Velvet's"),
    }
    Ok(!boards.is_empty())
}
