//! `velvet flash`: the image onto a board, by the tool that is installed.
//!
//! Three ways lead in: a debug probe on the board's SWD header, with probe-rs; the boot stage over USB, with
//! dfu-util, which has the firmware that runs make way; or the chip's own boot loader over USB (hold BOOT0,
//! press reset), with dfu-util as well.

use std::ffi::OsString;
use std::io::{Read, Write, stdout};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

/// The chip on the Prime, as probe-rs names it.
const CHIP: &str = "STM32H745XIHx";
/// ST's boot loader on USB (AN2606, "DFU").
const BOOT_LOADER: &str = "0483:df11";
/// The board on USB, whether the firmware runs or the boot stage waits.
const BOARD: &str = "1d50:6015";
/// Seconds that dfu-util waits for the board to detach: the running firmware is copied to the card first,
/// which takes longer than dfu-util's own five seconds.
const DETACH_SECONDS: &str = "20";
/// Exit status EX_IOERR of dfu-util.
const RESET_FAILED: i32 = 74;
/// Print of errVENDOR by dfu-util (DFU 1.1 section 6.1.2): the card holds no firmware to come back to,
/// the only meaning that the boot stage gives this status.
const NO_COPY: &str = "status(11)";
/// Number of a tool's last bytes that are kept.
const LAST_WORDS: usize = 64;
/// Image for the boot stage, which `make firmware` writes beside the ELF file.
const CARD_FILE: &str = "flashme.bin";
/// Address at which the image begins, and dfu-util's order to start it when done.
const ADDRESS: &str = "0x08000000:leave";

/// A way to the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// A debug probe on SWD, with probe-rs
    Probe,
    /// The boot stage over USB, with dfu-util: press reset twice first, or type dfu
    Usb,
    /// The boot loader over USB, with dfu-util: hold BOOT0 and press reset first
    Dfu,
}

impl Way {
    const fn tool(self) -> &'static str {
        match self {
            Self::Probe => "probe-rs",
            Self::Usb | Self::Dfu => "dfu-util",
        }
    }

    fn arguments(self, image: &Path) -> Vec<OsString> {
        let words = |words: &[&str]| words.iter().map(OsString::from).collect::<Vec<_>>();
        match self {
            Self::Probe => [words(&["run", "--chip", CHIP, "--no-location"]), vec![image.into()]].concat(),
            Self::Usb => {
                let is_file = image.extension().is_some_and(|extension| extension == "bin");
                let file = if is_file { image.to_path_buf() } else { image.with_file_name(CARD_FILE) };
                [
                    words(&["--device", BOARD, "--detach-delay", DETACH_SECONDS, "--reset", "--download"]),
                    vec![file.into()],
                ]
                .concat()
            }
            Self::Dfu => {
                // The boot loader wants the plain bytes, which `make firmware` writes beside the ELF file.
                let mut binary = image.to_path_buf();
                if binary.extension().is_none_or(|extension| extension != "bin") {
                    let mut name = binary.file_name().unwrap_or_default().to_owned();
                    name.push(".bin");
                    binary.set_file_name(name);
                }
                [
                    words(&["--alt", "0", "--device", BOOT_LOADER, "--dfuse-address", ADDRESS, "--download"]),
                    vec![binary.into()],
                ]
                .concat()
            }
        }
    }
}

/// Flashes `image` by `way`, or by the first way whose tool is installed.
pub fn flash(image: &Path, way: Option<Way>) -> Result<()> {
    if !image.is_file() {
        bail!("{} is not there; make firmware builds it", image.display());
    }
    let way = choose(way, installed)?;
    let mut command = Command::new(way.tool());
    command.args(way.arguments(image));
    let started = || format!("cannot start {}", way.tool());
    if way == Way::Probe {
        // A debug probe's tool draws on the terminal itself.
        return ended(way, command.status().with_context(started)?, "");
    }
    let mut tool = command.stdout(Stdio::piped()).spawn().with_context(started)?;
    let said = tool.stdout.take().map_or(Ok(String::new()), |output| passed_on(output, &mut stdout()))?;
    ended(way, tool.wait().with_context(started)?, &said)
}

/// Passes a tool's output on as it comes; returns its last words.
fn passed_on(mut from: impl Read, to: &mut impl Write) -> std::io::Result<String> {
    let (mut piece, mut last) = ([0; 256], Vec::new());
    loop {
        let count = from.read(&mut piece)?;
        if count == 0 {
            return Ok(String::from_utf8_lossy(&last).into_owned());
        }
        to.write_all(&piece[..count])?;
        to.flush()?;
        last.extend_from_slice(&piece[..count]);
        last.drain(..last.len().saturating_sub(LAST_WORDS));
    }
}

/// Whether the board has its firmware. dfu-util 0.11 resets a board at the end that has started the new
/// firmware already, does not find it, and ends with [`RESET_FAILED`] behind its `Done!`.
fn ended(way: Way, status: ExitStatus, said: &str) -> Result<()> {
    let is_done = way == Way::Usb && status.code() == Some(RESET_FAILED) && said.trim_end().ends_with("Done!");
    if status.success() || is_done {
        return Ok(());
    }
    if way == Way::Usb && said.contains(NO_COPY) {
        bail!(
            "the board keeps its firmware, for its card holds none to come back to: put a card in, or, where it holds \
             no firmware.previous, copy any flashme.bin to it by that name"
        );
    }
    bail!("{} could not flash the board: {status}", way.tool())
}

fn choose(asked: Option<Way>, installed: impl Fn(&str) -> bool) -> Result<Way> {
    match asked {
        Some(way) if installed(way.tool()) => Ok(way),
        Some(way) => bail!("{} is not installed", way.tool()),
        None => [Way::Probe, Way::Usb].into_iter().find(|way| installed(way.tool())).context(
            "neither probe-rs nor dfu-util is installed; one of them is needed: \
             https://probe.rs for a debug probe, https://dfu-util.sourceforge.net for USB",
        ),
    }
}

fn installed(tool: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| {
        [PathBuf::from(tool), PathBuf::from(format!("{tool}.exe"))].iter().any(|name| folder.join(name).is_file())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_is_preferred_and_a_missing_tool_is_named() {
        assert_eq!(choose(None, |_| true).unwrap(), Way::Probe);
        assert_eq!(choose(None, |tool| tool == "dfu-util").unwrap(), Way::Usb);
        assert!(choose(None, |_| false).unwrap_err().to_string().contains("probe-rs"));
        assert_eq!(choose(Some(Way::Dfu), |_| false).unwrap_err().to_string(), "dfu-util is not installed");
    }

    #[test]
    fn the_boot_loader_gets_the_plain_bytes() {
        for image in ["out/firmware", "out/firmware.bin"] {
            let last = Way::Dfu.arguments(Path::new(image)).pop().unwrap();
            assert_eq!(last, "out/firmware.bin");
        }
        assert_eq!(Way::Probe.arguments(Path::new("out/firmware")).pop().unwrap(), "out/firmware");
    }

    #[test]
    fn the_boot_stage_gets_the_file_for_the_card() {
        let arguments = |image| Way::Usb.arguments(Path::new(image));
        assert_eq!(arguments("out/firmware").pop().unwrap(), "out/flashme.bin");
        assert_eq!(arguments("mine.bin").pop().unwrap(), "mine.bin");
        assert_eq!(arguments("mine.bin")[1], "1d50:6015");
    }

    #[cfg(unix)]
    #[test]
    fn a_reset_that_finds_no_board_any_more_is_no_failure_behind_a_download() {
        use std::os::unix::process::ExitStatusExt;
        let exit = |code: i32| ExitStatus::from_raw(code << 8);
        let mut shown = Vec::new();
        let said = passed_on(&b"Download [=] 100%\nDone!\n"[..], &mut shown).unwrap();
        assert!(shown.ends_with(b"Done!\n"));
        assert!(ended(Way::Usb, exit(74), &said).is_ok());
        assert!(ended(Way::Usb, exit(74), "Lost device after RESET?\n").is_err());
        let no_copy = " state(10) = dfuERROR, status(11) = iString indicates a vendor specific error\n";
        assert!(ended(Way::Usb, exit(74), no_copy).unwrap_err().to_string().contains("firmware.previous"));
        assert!(ended(Way::Usb, exit(1), &said).is_err());
        assert!(ended(Way::Dfu, exit(74), &said).is_err());
        assert!(ended(Way::Probe, exit(0), "").is_ok());
    }

    #[test]
    fn an_image_that_is_not_there_is_said_before_any_tool_starts() {
        let error = flash(Path::new("/no/such/image"), None).unwrap_err().to_string();
        assert!(error.contains("/no/such/image") && error.contains("make firmware"), "{error}");
    }

    /// Compares [`CHIP`] with the files that probe-rs and cargo-embed read when they are given no options.
    #[test]
    fn the_probes_files_name_the_same_chip() {
        let preset = include_str!("../../.probe-rs.yaml");
        let lines: Vec<&str> = preset.lines().filter(|line| !line.starts_with('#')).collect();
        let chip = format!("    chip: {CHIP}");
        assert_eq!(lines, ["presets:", "  default:", &chip, "    protocol: swd", "    speed: 4000"]);
        assert!(include_str!("../../Embed.toml").contains(&format!("\nchip = \"{CHIP}\"\n")));
        assert!(include_str!("../../scripts/on-board.sh").contains(&format!("probe-rs run --chip {CHIP} ")));
    }
}
