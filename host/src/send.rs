//! `velvet send`: G-code to a board over a serial port or the network, one line at a time, the next after
//! the board's ok.

use std::io::{ErrorKind, Read, Write, stderr};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::network::access::Access;
use crate::network::target::Target;

/// Silence after which sending is given up. Heating and homing answer late, but they talk meanwhile.
const PATIENCE: Duration = Duration::from_secs(600);
/// Longest wait for an answer before the next look.
const POLL: Duration = Duration::from_millis(100);

/// Both ends of a line to a board.
trait Port: Read + Write {}
impl<T: Read + Write> Port for T {}

/// Options of the command.
#[derive(Args)]
pub struct Options {
    /// File with the G-code to send
    file: PathBuf,
    /// Serial port (/dev/ttyACM0, COM3), or a board in the network (velvet.local, 192.168.1.20:23)
    #[arg(long, value_name = "PORT|BOARD")]
    to: String,
    /// Speed of a serial port
    #[arg(long, default_value_t = 115_200)]
    baud: u32,
    #[command(flatten)]
    access: Access,
}

/// Sends a file's lines, each when the board has answered the one before. Fails when the file cannot be
/// read, the board cannot be reached, or an answer is an error or does not come.
pub fn send(options: &Options) -> Result<()> {
    let Options { file, to, .. } = options;
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let mut port = open(options).with_context(|| format!("cannot open {to}"))?;
    let sent = stream(&text, &mut port, PATIENCE, |reply| println!("{reply}"))?;
    eprintln!("{sent} lines sent");
    Ok(())
}

fn open(options: &Options) -> Result<Box<dyn Port>> {
    let Options { to, baud, access, .. } = options;
    if let Some(target) = Target::read_unless_serial(to) {
        return Ok(Box::new(access.connect(&target, &mut stderr(), |_| {})?));
    }
    let mut port = serial2::SerialPort::open(to, *baud)
        .context("no such serial port; a board in the network is NAME.local, or an address")?;
    port.set_read_timeout(POLL)?;
    Ok(Box::new(port))
}

/// Sends line after line; returns their number. Replies other than `ok` go to `tell`.
fn stream(text: &str, port: &mut impl Port, patience: Duration, mut tell: impl FnMut(&str)) -> Result<usize> {
    let mut replies = Replies::default();
    let mut sent = 0;
    for (index, line) in text.lines().enumerate() {
        let line = line.split(';').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        port.write_all(format!("{line}\n").as_bytes()).context("the line to the board broke")?;
        sent += 1;
        let mut heard = Instant::now();
        loop {
            match replies.next(port)? {
                Some(reply) if reply == "ok" => break,
                Some(reply) if is_stop(&reply) => bail!("line {}: {line}: {reply}", index + 1),
                Some(reply) => {
                    heard = Instant::now();
                    tell(&reply);
                    // A reply such as `ok T:200.1 /200.0` answers a command as well as saying something.
                    if reply.starts_with("ok ") {
                        break;
                    }
                }
                None if heard.elapsed() > patience => {
                    bail!("line {}: {line}: no answer for {} s", index + 1, patience.as_secs());
                }
                None => {}
            }
        }
    }
    Ok(sent)
}

/// Returns whether no further line may be sent after a reply.
fn is_stop(reply: &str) -> bool {
    let lower = reply.to_ascii_lowercase();
    lower.starts_with("error")
        || lower.starts_with("alarm")
        || reply.starts_with("!!")
        || lower.contains("halt asserted")
}

/// Assembler of lines out of pieces of any size.
#[derive(Default)]
struct Replies {
    pending: Vec<u8>,
}

impl Replies {
    /// Returns the next whole line, without its end; none if none came within the port's own timeout.
    fn next(&mut self, port: &mut impl Port) -> Result<Option<String>> {
        if !self.pending.contains(&b'\n') {
            let mut piece = [0; 512];
            match port.read(&mut piece) {
                Ok(0) => bail!("the board closed the line"),
                Ok(count) => self.pending.extend_from_slice(&piece[..count]),
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
                Err(error) => return Err(error).context("the line to the board broke"),
            }
        }
        let Some(end) = self.pending.iter().position(|byte| *byte == b'\n') else { return Ok(None) };
        let line: Vec<u8> = self.pending.drain(..=end).collect();
        Ok(Some(String::from_utf8_lossy(&line).trim().to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    /// Board that answers each line with the next of its answers.
    struct FakeBoard {
        answers: VecDeque<&'static str>,
        heard: String,
        to_say: Vec<u8>,
    }

    impl FakeBoard {
        fn new(answers: &[&'static str]) -> Self {
            Self { answers: answers.iter().copied().collect(), heard: String::new(), to_say: Vec::new() }
        }
    }

    impl Read for FakeBoard {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            if self.to_say.is_empty() {
                return Err(ErrorKind::TimedOut.into());
            }
            // Slow lines deliver three bytes at a time.
            let count = self.to_say.len().min(3).min(buffer.len());
            buffer[..count].copy_from_slice(&self.to_say[..count]);
            self.to_say.drain(..count);
            Ok(count)
        }
    }

    impl Write for FakeBoard {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            assert!(self.to_say.is_empty(), "the next line came before the answer to the last was read");
            self.heard += std::str::from_utf8(bytes).unwrap();
            self.to_say.extend(self.answers.pop_front().unwrap_or_default().bytes());
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn lines_go_out_bare_and_each_waits_for_its_ok() {
        let mut board = FakeBoard::new(&["ok\n", "T:20\r\nT:21\r\nok\r\n", "ok T:22 /0\n"]);
        let mut told = Vec::new();
        let text = "; a job\nG28 ; home\n\nM109 S20\nM105\n";
        let sent = stream(text, &mut board, PATIENCE, |reply| told.push(reply.to_owned())).unwrap();
        assert_eq!((sent, board.heard.as_str()), (3, "G28\nM109 S20\nM105\n"));
        assert_eq!(told, ["T:20", "T:21", "ok T:22 /0"]);
    }

    #[test]
    fn an_error_or_a_halt_stops_at_once_and_names_the_line() {
        for reply in ["error:no such thing\n", "ALARM: Hard limit\n", "!!\n"] {
            let mut board = FakeBoard::new(&["ok\n", reply]);
            let error = stream("G28\nG999\nG1 X1\n", &mut board, PATIENCE, |_| {}).unwrap_err().to_string();
            assert!(error.starts_with("line 2: G999: "), "{error}");
            assert_eq!(board.heard, "G28\nG999\n");
        }
    }

    #[test]
    fn a_silent_board_is_given_up() {
        let mut board = FakeBoard::new(&[]);
        let error = stream("G28\n", &mut board, Duration::ZERO, |_| {}).unwrap_err().to_string();
        assert!(error.contains("no answer"), "{error}");
    }
}
