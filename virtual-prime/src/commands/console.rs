//! `virtual-prime console`: a live board, paced to real time.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use sim::output::{Outcome, Recorder};
use sim::session::{BOOT_SILENCE_NS, Opening};
use virtual_prime::board::{PrimeBoard, SharedWorld};
use virtual_prime::instruments::{Instruments, Probe};
use virtual_prime::typed::Typed;
use virtual_prime::vm::{Span, Vm};

use super::clock_file::{BOARDS, ClockFile};
use super::log::{Log, texts};
use super::machine::BoardOptions;
use super::net::{NetOptions, NetSocket};
use super::onlooker::Onlooker;
use super::pace::{self, FOLLOWED_SLICE, Pace, Timing};
use super::serial::SerialSocket;
use super::usb::{UsbOptions, UsbSocket};

/// Virtual time between two rounds of serving the sockets and standard input.
const SLICE: Duration = Duration::from_millis(5);
/// Virtual time between two rounds while a computer or a network is plugged in: a frame of USB.
const FRAME: Duration = Duration::from_millis(1);
/// Longest silence of our image between two of its first words. Input before its consoles are up is lost, as
/// on the board, so a pipe is held until then.
const FIRST_WORDS_NS: u64 = 200_000_000;
/// Silence, without a word and without a step, after which the session ends once the input of a pipe has
/// ended: heating tells its temperatures more often.
const QUIET_NS: u64 = 2_000_000_000;
const PORT_NAMES: [&str; 3] = ["debug (USART2)", "UART 0 (USART3)", "UART 1 (UART4)"];

/// Options of `console`.
#[derive(Args)]
pub struct Options {
    #[command(flatten)]
    board: BoardOptions,
    /// First of three TCP ports for the serial ports; 0 lets the system choose.
    #[arg(long, default_value_t = 0)]
    port: u16,
    #[command(flatten)]
    usb: UsbOptions,
    #[command(flatten)]
    net: NetOptions,
    /// TCP port that tells the machine's true state, a line of JSON for each line asked; `unplug` pulls the
    /// USB cable out. 0 lets the system choose.
    #[arg(long)]
    state_port: Option<u16>,
    /// Directory for the files that `run` leaves: every step, the debug console, temperatures, a summary.
    #[arg(long)]
    out: Option<PathBuf>,
    /// End after this many seconds.
    #[arg(long)]
    until: Option<f64>,
    /// Share of real time at which the board runs, for a program that fits its clock to the board's: never
    /// faster on the mean, and never more than twice as fast to catch up. Without it the board keeps real
    /// time and makes up for lost time at once.
    #[arg(long, value_parser = pace::parse)]
    pace: Option<f64>,
    /// Page for lock step with a host program that has this board's time for its own: the board goes on only
    /// while the host waits and no byte of the debug port is on its way.
    #[arg(long, conflicts_with = "pace")]
    clock_file: Option<PathBuf>,
    /// Number of this board among those that share the page.
    #[arg(long, default_value_t = 0, requires = "clock_file", value_parser = clap::value_parser!(u8).range(..BOARDS as i64))]
    clock_slot: u8,
    /// An image that is not ours, which may lose what it is told while it boots: what is typed waits for its
    /// first words.
    #[arg(long)]
    foreign: bool,
    /// Virtual seconds until which what is typed waits, whatever the image has said.
    #[arg(long)]
    start: Option<f64>,
}

impl Options {
    fn opening(&self) -> Opening {
        match self.start {
            Some(seconds) => Opening::At((seconds * 1e9) as u64),
            // A person sees the prompt.
            None if !self.foreign && io::stdin().is_terminal() => Opening::AtOnce,
            None => Opening::AfterFirstWords,
        }
    }

    /// Whether a program on this computer reads the board's time.
    const fn is_followed(&self) -> bool {
        self.pace.is_some() || self.clock_file.is_some()
    }

    fn timing(&self) -> Result<Timing, String> {
        Ok(match &self.clock_file {
            Some(path) => Timing::Locked(ClockFile::open(path, usize::from(self.clock_slot))?),
            None => Timing::paced(self.pace.map_or_else(Pace::real_time, Pace::steady)),
        })
    }

    const fn first_words_ns(&self) -> u64 {
        if self.foreign { BOOT_SILENCE_NS } else { FIRST_WORDS_NS }
    }
}

/// Sockets for everything that can be connected to the board.
struct Sockets {
    serial: Vec<SerialSocket>,
    usb: Option<UsbSocket>,
    net: Option<NetSocket>,
    onlooker: Option<Onlooker>,
}

impl Sockets {
    /// Opens all sockets, and prints their addresses.
    fn open(options: &Options, board: &PrimeBoard) -> Result<Self, String> {
        let mut serial = Vec::new();
        for (index, name) in PORT_NAMES.into_iter().enumerate() {
            let port = if options.port == 0 { 0 } else { options.port + index as u16 };
            let fail = |error: io::Error| format!("port {port}: {error}");
            let socket = SerialSocket::open(port, board.console(index).clone()).map_err(fail)?;
            eprintln!("{name} on tcp {}", socket.address().map_err(fail)?);
            serial.push(socket);
        }
        let onlooker = options.state_port.map(Onlooker::open).transpose().map_err(|error| error.to_string())?;
        if let Some(onlooker) = &onlooker {
            eprintln!("the machine's state on tcp {}", onlooker.address().map_err(|error| error.to_string())?);
        }
        Ok(Self { serial, usb: UsbSocket::open(&options.usb)?, net: NetSocket::open(&options.net)?, onlooker })
    }

    fn slice(&self, is_followed: bool) -> Duration {
        let usb = self.usb.as_ref().is_some_and(UsbSocket::is_plugged);
        match (is_followed, usb || self.net.is_some()) {
            (true, _) => FOLLOWED_SLICE,
            (_, true) => FRAME,
            _ => SLICE,
        }
    }

    /// Serves all sockets, both ways. Returns the board's bytes on the debug console.
    fn serve(&mut self, vm: &mut Vm, world: &SharedWorld) -> Vec<u8> {
        let mut debug = Vec::new();
        for (index, socket) in self.serial.iter_mut().enumerate() {
            let said = socket.line.receive();
            socket.say(&said);
            socket.hear();
            if index == 0 {
                debug = said;
            }
        }
        let asked = self.onlooker.as_mut().map(Onlooker::hear).unwrap_or_default();
        if let Some(usb) = &self.usb {
            if asked.unplugs {
                usb.unplug();
            }
            usb.serve(vm);
        }
        if let Some(net) = &mut self.net {
            net.serve(vm);
        }
        if let Some(onlooker) = &mut self.onlooker {
            onlooker.answer(asked, &world.lock(), self.usb.as_ref().map(UsbSocket::sent));
        }
        debug
    }
}

/// Runs the board until standard input ends or the image does. A person's end of input ends the session at
/// once; a pipe's, when the board seems to have done all that was sent.
///
/// # Errors
/// When the image cannot be started, or crashes.
pub fn run(options: &Options) -> Result<(), String> {
    let board = options.board.build(Vec::new())?;
    let mut sockets = Sockets::open(options, &board)?;
    eprintln!("standard input and output are the debug console; end it with Ctrl-D");
    let world = board.world().clone();
    let recorder = options.out.as_ref().map(|out| Recorder::create(out, &world.lock())).transpose();
    let mut recorder = recorder.map_err(|error| error.to_string())?;
    let (instruments, records) = Instruments::new(&options.board.elf, &Probe::default())?;
    let table = texts(&options.board.elf).unwrap_or_else(|reason| {
        eprintln!("{reason}: its log is shown as it is");
        None
    });
    let mut log = Log::new(table.as_ref());
    let mut vm =
        Vm::start(board, &options.board.elf, Some(Box::new(instruments))).map_err(|error| error.to_string())?;
    let mut desk = Desk::new(options);
    let mut timing = options.timing()?;
    let slice_ns = |sockets: &Sockets| sockets.slice(options.is_followed()).as_nanos() as u64;
    let ended = loop {
        let goes = timing.may_go(vm.now_ns(), sockets.serial[0].traffic())?;
        let span = if goes { vm.run_for(slice_ns(&sockets)) } else { Span::Reached };
        let said = sockets.serve(&mut vm, &world);
        let moved = take_steps(&world, &mut recorder, &said).map_err(|error| error.to_string())?;
        log.take(&std::mem::take(&mut records.lock().rtt), &mut io::stderr().lock());
        if !desk.hear(vm.now_ns(), &said, moved) {
            break Ok(());
        }
        match span {
            Span::Reached => {}
            Span::Exited(_) => break Ok(()),
            Span::Failed(reason) => break Err(reason),
        }
        if options.until.is_some_and(|until| vm.now_ns() as f64 * 1e-9 >= until) {
            break Ok(());
        }
        desk.speak(vm.now_ns(), &sockets.serial[0]);
        if desk.is_over(vm.now_ns(), options.until.is_some()) {
            break Ok(());
        }
        timing.rest(vm.now_ns(), goes)?;
    };
    if let Some(recorder) = recorder {
        let errors = ended.as_ref().err().cloned().into_iter().collect();
        let outcome = Outcome { errors, board: vm.complaints(), ..Outcome::default() };
        recorder.finish(&mut world.lock(), &outcome).map_err(|error| error.to_string())?;
    }
    ended
}

/// Takes the steps since the last call, so that they need no memory, and writes them to the recorder, if
/// there is one. Returns whether there were any.
fn take_steps(world: &SharedWorld, recorder: &mut Option<Recorder>, said: &[u8]) -> io::Result<bool> {
    let mut world = world.lock();
    let moved = !world.trace().edges().is_empty();
    match recorder {
        Some(recorder) => {
            recorder.console(said)?;
            recorder.observe(&mut world, f64::NAN)?;
        }
        None => drop(world.trace_mut().take()),
    }
    Ok(moved)
}

/// Standard input and output, used by a person or a pipe.
struct Desk {
    typed: Typed,
    is_person: bool,
    opening: Opening,
    first_words_ns: u64,
    /// Earliest instant to send input to the board, as far as is known.
    open_ns: u64,
    /// Instant of the last byte in either direction or the last step.
    stirred_ns: u64,
}

impl Desk {
    fn new(options: &Options) -> Self {
        let opening = options.opening();
        let open_ns = match opening {
            Opening::AtOnce => 0,
            Opening::AfterFirstWords => u64::MAX,
            Opening::At(ns) => ns,
        };
        Self {
            typed: Typed::read(io::stdin()),
            is_person: io::stdin().is_terminal(),
            opening,
            first_words_ns: options.first_words_ns(),
            open_ns,
            stirred_ns: 0,
        }
    }

    /// Shows the board's bytes. Returns whether anybody still reads them.
    fn hear(&mut self, now_ns: u64, said: &[u8], moved: bool) -> bool {
        if !said.is_empty() && now_ns < self.open_ns && self.opening == Opening::AfterFirstWords {
            self.open_ns = now_ns + self.first_words_ns;
        }
        if !said.is_empty() || moved {
            self.stirred_ns = now_ns;
        }
        let mut out = io::stdout().lock();
        out.write_all(said).and_then(|()| out.flush()).is_ok()
    }

    /// Passes on typed input.
    fn speak(&mut self, now_ns: u64, socket: &SerialSocket) {
        if now_ns >= self.open_ns {
            self.typed.hand_to(&socket.line);
        }
        if socket.line.unsent() > 0 {
            self.stirred_ns = now_ns;
        }
    }

    /// Whether all input is sent and the board is quiet. With a time to end at, the end of the input is not
    /// the end of the session.
    const fn is_over(&self, now_ns: u64, has_end: bool) -> bool {
        let is_quiet = now_ns - self.stirred_ns >= QUIET_NS;
        self.typed.is_over() && !has_end && (self.is_person || is_quiet)
    }
}
