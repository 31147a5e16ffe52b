//! `velvet boards`: the boards of the local network, as they answer by mDNS.

use std::fmt::Write as _;
use std::time::Duration;

use anyhow::Result;
use clap::Args;

use crate::network::browser::{Browser, Machine, Mdns};

/// Things to look at when no board answers.
const ADVICE: &str = "Look at these:\n\
    - The board is on, its cable is in, and this computer is in the same network.\n\
    - Its config.ini has [network] enable = true and shell_enable = true.\n\
    - A firewall on this computer lets UDP from port 5353 in.\n\
    - `net` on a USB or serial console says the board's link, address and name.";

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

/// Returns a line a board, in columns.
fn table(boards: &[Machine]) -> String {
    let width = boards.iter().map(|board| board.name.chars().count()).max().unwrap_or(0);
    let mut table = String::new();
    for Machine { name, address, telnet, grbl, version, .. } in boards {
        let grbl = grbl.map(|port| format!(", GRBL's dialect {port}")).unwrap_or_default();
        let version = version.as_ref().map(|version| format!(", version {version}")).unwrap_or_default();
        let _written = writeln!(table, "{name:width$}  {:15}  telnet {telnet}{grbl}{version}", address.to_string());
    }
    table
}
