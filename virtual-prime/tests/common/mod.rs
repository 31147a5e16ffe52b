//! Finds the test images, and runs one.

pub mod hang;
pub mod klipper_host;
pub mod machine;
pub mod print;
pub mod seal;
pub mod stacks;
pub mod switched;
pub mod velvet;
pub mod writes;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use sim::world::WorldConfig;
use virtual_prime::board::{PrimeBoard, SharedWorld};
use virtual_prime::console::Line;
use virtual_prime::instruments::{Instruments, Probe, Records};
use virtual_prime::vm::{Span, Vm};

pub const MS: u64 = 1_000_000;
/// Duration of a byte on a console's wire: ten bits at 115200 baud.
pub const FRAME_NS: u64 = 10 * 1_000_000_000 / 115_200;

/// Returns the ELF file of a test image: from `PRIME_IMAGES` when that names a directory, otherwise built
/// here and now.
pub fn image(name: &str) -> PathBuf {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| std::env::var_os("PRIME_IMAGES").map_or_else(build, PathBuf::from)).join(name)
}

fn build() -> PathBuf {
    let images = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("images");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| images.join("target"), PathBuf::from);
    let target = std::path::absolute(target.join("images")).expect("a working directory");
    // The makefile sets the compiler for images; without it, the compiler in the path builds them.
    let compiler = std::env::var("FW_CARGO").unwrap_or_else(|_| "cargo".into());
    let flags = std::env::var("FW_FLAGS").unwrap_or_default();
    let mut words = compiler.split_whitespace();
    let status = Command::new(words.next().unwrap_or("cargo"))
        .args(words)
        .args(["build", "--quiet", "--locked", "--release"])
        .args(flags.split_whitespace())
        .env("CARGO_TARGET_DIR", &target)
        .env_remove("RUSTC")
        .env_remove("RUSTUP_TOOLCHAIN")
        .current_dir(&images)
        .status()
        .expect("cargo runs");
    assert!(status.success(), "the test images do not build");
    target.join("thumbv7em-none-eabihf/release")
}

/// A board that runs a test image.
pub struct Bench {
    pub vm: Vm,
    /// Our end of the debug console, USART2.
    pub console: Line,
    /// Our end of UART 0, USART3.
    pub uart: Line,
    pub records: Records,
    /// Log of writes to the addresses that were named.
    pub writes: writes::WriteLog,
}

/// Starts a board of the default machine with a test image.
pub fn boot(name: &str) -> Bench {
    boot_on(name, PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right"))
}

/// Starts the board with a test image.
pub fn boot_on(name: &str, board: PrimeBoard) -> Bench {
    boot_elf(&image(name), board)
}

/// Starts the board with the image of an ELF file.
pub fn boot_elf(elf: &Path, board: PrimeBoard) -> Bench {
    boot_watched(elf, board, Vec::new(), &Probe::default())
}

/// Starts the board with the image of an ELF file, and logs writes to these addresses.
pub fn boot_watched(elf: &Path, board: PrimeBoard, addresses: Vec<Range<u64>>, probe: &Probe) -> Bench {
    let (console, uart) = (board.console(0).clone(), board.console(1).clone());
    let (instruments, records) = Instruments::new(elf, probe).expect("an image with symbols");
    let writes = writes::WriteLog::default();
    let listener = writes::Listener { inner: Box::new(instruments), addresses, log: writes.clone() };
    let vm = Vm::start(board, elf, Some(Box::new(listener))).expect("the image loads");
    Bench { vm, console, uart, records, writes }
}

impl Bench {
    /// Runs until the image ends itself with success. Returns its words on the console.
    #[track_caller]
    pub fn expect_pass(&mut self, deadline_ms: u64) -> String {
        let mut said = Vec::new();
        for _ in 0..deadline_ms {
            let span = self.vm.run_for(MS);
            said.extend(self.console.receive());
            match span {
                Span::Reached => {}
                Span::Exited(0) => return String::from_utf8_lossy(&said).into_owned(),
                other => panic!("{other:?} after {} ns: {}", self.vm.now_ns(), self.words(&said)),
            }
        }
        panic!("no end after {deadline_ms} ms: {}", self.words(&said));
    }

    /// Joins the image's words on the console and to the debugger.
    pub fn words(&self, said: &[u8]) -> String {
        String::from_utf8_lossy(&[said, &self.records.lock().semihosting].concat()).into_owned()
    }

    /// Returns the simulated machine on the board.
    pub fn world(&mut self) -> SharedWorld {
        self.vm.with(|stopped| stopped.session.board().world().clone()).expect("the run goes on")
    }
}
