//! `velvet console`: a console on a board, over the network.

use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::process::exit;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::network::access::Access;
use crate::network::connection::{Connection, Heard};
use crate::network::target::Target;
use crate::network::terminal::{CTRL_C, CTRL_X, Terminal};

/// Silence that ends a console whose input has ended.
const QUIET: Duration = Duration::from_secs(1);
/// Silence of a board that owes answers. Heating and homing answer late, but they talk meanwhile.
const PATIENCE: Duration = Duration::from_secs(600);
/// Longest wait before the next look at the input.
const POLL: Duration = Duration::from_millis(20);
/// Exit code of a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// Options of the command.
#[derive(Args)]
pub struct Options {
    /// Name or address of the board, as `velvet boards` lists them; with :PORT where that is not the usual
    /// one [default: the only board that answers by mDNS]
    #[arg(value_name = "NAME|ADDRESS[:PORT]")]
    board: Option<String>,
    #[command(flatten)]
    access: Access,
}

/// Opens a console: lines of the standard input go to the board, and what it says to the standard output.
pub fn console(options: &Options) -> Result<()> {
    let target = options.board.as_deref().map_or(Ok(Target::Only), Target::read)?;
    let is_typed = io::stdin().is_terminal();
    let mut output = io::stdout();
    let mut connection = options.access.connect(&target, &mut output, |address| {
        if is_typed {
            eprintln!("Connected to {address}. Ctrl-X halts the machine, Ctrl-C ends this.");
        }
    })?;
    let terminal = Terminal::new(false).map(Arc::new);
    let outcome = talk(&mut connection, &input(terminal.clone()), is_typed, &mut output);
    // The thread that reads holds the terminal too, and waits for a key.
    terminal.iter().for_each(|terminal| terminal.restore());
    outcome
}

/// Reads the standard input as it comes, no faster than it is taken.
fn input(terminal: Option<Arc<Terminal>>) -> Receiver<Vec<u8>> {
    let (to, input) = sync_channel(1);
    std::thread::spawn(move || {
        let mut piece = [0; 16_384];
        // An input that cannot be read has ended.
        while let Ok(count @ 1..) = io::stdin().read(&mut piece) {
            let typed = piece.get(..count).unwrap_or_default();
            let sent = match (&terminal, typed.last()) {
                (Some(terminal), Some(&CTRL_C)) => {
                    terminal.restore();
                    eprintln!();
                    exit(INTERRUPTED);
                }
                // Whoever halts does not mean the beginning of a line before it.
                (Some(_), Some(&CTRL_X)) => {
                    eprintln!();
                    to.send(vec![CTRL_X])
                }
                _ => to.send(typed.to_vec()),
            };
            if sent.is_err() {
                break;
            }
        }
    });
    input
}

/// Carries lines to the board and its words to the output, until the input has ended and the board is quiet;
/// whoever typed does not wait for that.
fn talk(connection: &mut Connection, input: &Receiver<Vec<u8>>, is_typed: bool, output: &mut impl Write) -> Result<()> {
    let (mut owed, mut since, mut has_ended) = (OwedAnswers::default(), Instant::now(), false);
    loop {
        match connection.hear(POLL).context("the connection broke")? {
            Heard::Text(text) => {
                match output.write_all(&text).and_then(|()| output.flush()) {
                    // Whoever reads has seen enough.
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => return Ok(()),
                    written => written.context("cannot write what the board says")?,
                }
                owed.hear(&text);
                since = Instant::now();
            }
            Heard::End if has_ended && owed.count == 0 => return Ok(()),
            Heard::End => bail!("the board closed the connection"),
            Heard::Nothing => {}
        }
        match input.try_recv() {
            Ok(bytes) => {
                owed.say(&bytes);
                match connection.write_all(&bytes) {
                    // The board's last words come first.
                    Err(error) if matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::ConnectionReset) => {}
                    written => written.context("the board takes nothing any more")?,
                }
                since = Instant::now();
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) if is_typed => return Ok(()),
            Err(TryRecvError::Disconnected) if !has_ended => {
                has_ended = true;
                // A last line need not have an end.
                if owed.said.is_open() {
                    owed.say(b"\n");
                    connection.write_all(b"\n").context("the connection broke")?;
                }
            }
            Err(TryRecvError::Disconnected) => {}
        }
        let silence = since.elapsed();
        if has_ended && silence >= QUIET && owed.count == 0 {
            return Ok(());
        }
        if has_ended && silence >= PATIENCE {
            bail!("the board has not answered the last {} lines for {} s", owed.count, PATIENCE.as_secs());
        }
    }
}

/// Lines of G-code that the board owes an answer: they may wait in buffers on the way, and would be lost with
/// the connection.
#[derive(Debug, Default)]
struct OwedAnswers {
    count: usize,
    said: LineStart,
    heard: LineStart,
}

impl OwedAnswers {
    fn say(&mut self, bytes: &[u8]) {
        let lines = self.said.lines(bytes);
        self.count += lines.iter().filter(|line| is_code(line)).count();
    }

    fn hear(&mut self, bytes: &[u8]) {
        let lines = self.heard.lines(bytes);
        self.count = self.count.saturating_sub(lines.iter().filter(|line| is_answer(line)).count());
    }
}

/// Beginning of the line that is not whole yet.
#[derive(Debug, Default)]
struct LineStart(Vec<u8>);

impl LineStart {
    /// Bytes of a line that are looked at.
    const MOST: usize = 16;

    /// Returns whether a line has begun.
    fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Returns the beginnings of the lines that are whole with these bytes; some are empty.
    fn lines(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut lines = Vec::new();
        for &byte in bytes {
            if matches!(byte, b'\n' | b'\r') {
                lines.push(std::mem::take(&mut self.0));
            } else if self.0.len() < Self::MOST && !(self.0.is_empty() && byte.is_ascii_whitespace()) {
                self.0.push(byte);
            }
        }
        lines
    }
}

/// Returns whether a line is G-code, which is answered with `ok` or an error.
fn is_code(line: &[u8]) -> bool {
    let letter = line.first().is_some_and(|letter| b"GMTN".contains(&letter.to_ascii_uppercase()));
    letter && line.get(1).is_some_and(u8::is_ascii_digit)
}

fn is_answer(line: &[u8]) -> bool {
    let line = line.to_ascii_lowercase();
    ["ok", "error", "!!", "alarm"].iter().any(|answer| line.starts_with(answer.as_bytes()))
}
