//! Cost of loading a configuration on the board: time for a file of 300 lines, and the memory that any
//! file takes.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use super::figures::Ledger;

const LINES: usize = 300;
/// A board that has not answered by then, in virtual seconds, does not.
const PATIENCE_S: &str = "20";

/// Adds `config_load_ms` and `config_memory_bytes`: boots the image and asks it with `mem`.
pub fn measure(root: &Path, elf: &Path, virtual_prime: &Path, scratch: &Path, ledger: &mut Ledger) -> Result<()> {
    eprintln!("measuring config");
    let text = fs::read_to_string(root.join("bench/config.ini")).context("bench/config.ini")?;
    let path: PathBuf = scratch.join("config.ini");
    fs::create_dir_all(scratch).with_context(|| scratch.display().to_string())?;
    fs::write(&path, padded(&text)).with_context(|| path.display().to_string())?;
    let mut board = Command::new(virtual_prime)
        .arg("console")
        .arg("--elf")
        .arg(elf)
        .arg("--config")
        .arg(&path)
        .args(["--until", PATIENCE_S])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| virtual_prime.display().to_string())?;
    let (mut typed, said) = (board.stdin.take().context("its input")?, board.stdout.take().context("its output")?);
    let mut answer = None;
    for line in BufReader::new(said).lines() {
        let line = line.context("what the board says")?;
        if line.starts_with("Welcome") {
            typed.write_all(b"mem\n").context("typing")?;
        }
        if let Some(cost) = line.strip_prefix("configuration: read in ") {
            answer = numbers(cost);
            break;
        }
    }
    // The board has said all that matters; a board that is gone already needs no end.
    let _ = board.kill();
    let _ = board.wait();
    let Some((ms, bytes)) = answer else { bail!("the board does not say what its configuration cost") };
    ledger.insert("config_load_ms".into(), ms);
    ledger.insert("config_memory_bytes".into(), bytes);
    Ok(())
}

/// The two numbers of `23.15 ms within 31000 bytes`.
fn numbers(text: &str) -> Option<(f64, f64)> {
    let mut numbers = text.split(' ').filter_map(|word| word.parse().ok());
    Some((numbers.next()?, numbers.next()?))
}

/// The file with settings that change nothing added, up to [`LINES`] lines.
fn padded(text: &str) -> String {
    let mut text = format!("{text}\n[switch]\n");
    let missing = LINES.saturating_sub(text.lines().count());
    for line in 0..missing {
        let key = ["enable = false", "output_pin = PJ1", "output_type = digital", "max_pwm = 200"][line % 4];
        // Writing to a string cannot fail.
        let _ = match line {
            0..40 => writeln!(text, "spare{}.{key}", line / 4),
            _ => writeln!(text, "# {line}: what somebody wanted to remember"),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_of_the_board_has_two_numbers() {
        assert_eq!(numbers("23.15 ms within 31000 bytes"), Some((23.15, 31_000.0)));
        assert_eq!(numbers("some time"), None);
    }

    #[test]
    fn the_file_has_its_lines() {
        assert_eq!(padded("[planner]\n").lines().count(), LINES);
        assert!(padded("x\n".repeat(400).as_str()).lines().count() > LINES);
    }
}
