//! Access to a board's console: its place is found, the connection made, the password given, the greeting
//! heard out. A line that comes sooner would be taken for the password, and the greeting's `ok` for its
//! answer.

use std::io::{ErrorKind, IsTerminal, Read, Write, stdin};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;

use super::browser::Mdns;
use super::connection::{Connection, Heard};
use super::target::Target;
use super::terminal::{CTRL_C, CTRL_X, Terminal};

/// Time in which a board greets or asks for the password.
const GREETING: Duration = Duration::from_millis(1_500);
/// Silence that ends a greeting.
const QUIET: Duration = Duration::from_millis(150);
/// Time that a board may take to look at a password.
const VERDICT: Duration = Duration::from_secs(15);
/// End of what asks for a password.
const PROMPT: &[u8] = b"password:";
const POLL: Duration = Duration::from_millis(20);

/// Options of a command that talks to a board in the network.
#[derive(Args)]
pub struct Access {
    /// File whose first line is the board's password [default: typed when the board asks for it]
    #[arg(long, value_name = "FILE")]
    password_from: Option<PathBuf>,
    #[command(flatten)]
    mdns: Mdns,
}

impl Access {
    /// Connects to a board, or to the only one there is, and waits until its console takes lines. What the
    /// board says meanwhile goes to `output`; `tell` is called with the address.
    pub fn connect(&self, target: &Target, output: &mut impl Write, tell: impl FnOnce(&str)) -> Result<Connection> {
        let addresses = target.resolve(&self.mdns)?;
        let shown = addresses.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let mut connection = Connection::open(&addresses)
            .map_err(|error| {
                let advice = advice(error.kind());
                anyhow::Error::new(error).context(advice)
            })
            .with_context(|| format!("no connection to {shown}"))?;
        tell(&shown);
        self.arrive(&mut connection, output)?;
        Ok(connection)
    }

    /// Waits until the console takes lines.
    fn arrive(&self, connection: &mut Connection, output: &mut impl Write) -> Result<()> {
        let (mut said, mut since, mut patience, mut asked) = (Vec::new(), Instant::now(), GREETING, 0);
        loop {
            match connection.hear(POLL).context("the connection broke")? {
                Heard::Text(text) => {
                    output.write_all(&text)?;
                    output.flush()?;
                    said.extend(text);
                    since = Instant::now();
                }
                Heard::End if said.is_empty() => bail!("the board closed the connection at once"),
                Heard::End => bail!("the board closed the connection: {}", last_words(&said)),
                Heard::Nothing => {}
            }
            let is_quiet = since.elapsed() >= QUIET;
            if is_quiet && asks(&said) {
                let word = self.password(asked, output)?;
                writeln!(connection, "{word}").context("the connection broke")?;
                (said, since, patience, asked) = (Vec::new(), Instant::now(), VERDICT, asked + 1);
            } else if is_quiet && said.iter().any(|byte| !byte.is_ascii_whitespace()) {
                return Ok(());
            } else if since.elapsed() >= patience {
                if asked > 0 {
                    bail!("the board has not said for {} s whether the password is right", VERDICT.as_secs());
                }
                // Some consoles do not greet.
                return Ok(());
            }
        }
    }

    /// Returns the password; `given` says how many were wrong.
    fn password(&self, given: usize, output: &mut impl Write) -> Result<String> {
        if self.password_from.is_none() && stdin().is_terminal() {
            return typed();
        }
        // Nobody ends the line of the prompt by a key.
        writeln!(output)?;
        match &self.password_from {
            Some(file) if given > 0 => bail!("the board does not take the password in {}", file.display()),
            Some(file) => read(file),
            None => bail!("the board asks for a password: give it with --password-from FILE"),
        }
    }
}

/// Returns what to do about a connection that failed.
fn advice(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::ConnectionRefused => {
            "nothing listens there: [network] shell_enable = true opens the console, shell_port is its port"
        }
        _ => "is the board on, its cable in, and this computer in the same network? `velvet boards` looks for it",
    }
}

fn asks(said: &[u8]) -> bool {
    let said = said.trim_ascii_end();
    let from = said.len().saturating_sub(PROMPT.len());
    said.get(from..).is_some_and(|end| end.eq_ignore_ascii_case(PROMPT))
}

/// Returns the last line of what a board said, for a message.
fn last_words(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(said);
    let last = text.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("without a word");
    last.replace(|sign: char| sign.is_control(), "?")
}

fn read(file: &Path) -> Result<String> {
    let text =
        std::fs::read_to_string(file).with_context(|| format!("cannot read the password in {}", file.display()))?;
    match text.lines().next() {
        Some(word) if !word.is_empty() => Ok(word.to_owned()),
        _ => bail!("the first line of {} is empty: the password belongs there", file.display()),
    }
}

/// Has a password typed, without being shown.
fn typed() -> Result<String> {
    let hidden = Terminal::new(true);
    if hidden.is_none() {
        eprint!("(it is shown as you type) ");
    }
    let mut word = Vec::new();
    let mut is_given = false;
    for byte in stdin().lock().bytes() {
        match byte.context("cannot read the password")? {
            b'\n' => {
                is_given = !word.is_empty();
                break;
            }
            CTRL_C | CTRL_X => break,
            byte => word.push(byte),
        }
    }
    if hidden.is_some() {
        eprintln!();
    }
    drop(hidden);
    if !is_given {
        bail!("no password was given");
    }
    Ok(String::from_utf8_lossy(&word).trim_end_matches('\r').to_owned())
}
