//! `virtual-prime console`: a live board, paced to real time.

use std::io::{self, IsTerminal, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use sim::session::{BOOT_SILENCE_NS, Opening};
use virtual_prime::console::Line;
use virtual_prime::instruments::{Instruments, Probe};
use virtual_prime::sd_image;
use virtual_prime::typed::{AHEAD, Typed};
use virtual_prime::vm::{Span, Vm};

use super::log::{Log, texts};
use super::machine::BoardOptions;
use super::onlooker::Onlooker;

/// How much virtual time passes between two looks at the world outside.
const SLICE: Duration = Duration::from_millis(5);
/// How long our image says nothing between two of its first words. What is typed before its consoles are up
/// is lost, as on the board, so a pipe is held until then.
const FIRST_WORDS_NS: u64 = 200_000_000;
/// When the input of a pipe has ended, the session ends after this long without a word and without a step:
/// heating tells its temperatures more often.
const QUIET_NS: u64 = 2_000_000_000;
const PORT_NAMES: [&str; 3] = ["debug (USART2)", "UART 0 (USART3)", "UART 1 (UART4)"];

/// Options of `console`.
#[derive(Args)]
pub struct Options {
    /// The firmware image.
    #[arg(long)]
    elf: PathBuf,
    #[command(flatten)]
    board: BoardOptions,
    /// Directory whose files go onto the SD card.
    #[arg(long)]
    sd: Option<PathBuf>,
    /// First of three TCP ports for the serial ports; 0 lets the system choose.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// TCP port that tells the machine's true state, a line of JSON for each line asked; 0 lets the system
    /// choose.
    #[arg(long)]
    state_port: Option<u16>,
    /// End after this many seconds.
    #[arg(long)]
    until: Option<f64>,
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

    const fn first_words_ns(&self) -> u64 {
        if self.foreign { BOOT_SILENCE_NS } else { FIRST_WORDS_NS }
    }
}

/// A serial port on TCP: the latest client to connect has the wire.
struct Socket {
    listener: TcpListener,
    client: Option<TcpStream>,
    line: Line,
}

impl Socket {
    fn open(port: u16, line: Line) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, client: None, line })
    }

    /// Takes a new client, and as much of what the present one has sent as the wire takes.
    fn hear(&mut self) {
        if let Ok((client, _)) = self.listener.accept() {
            self.client = client.set_nonblocking(true).is_ok().then_some(client);
        }
        let mut bytes = [0; AHEAD];
        if let Some(client) = &mut self.client
            && self.line.unsent() < AHEAD
        {
            match client.read(&mut bytes) {
                Ok(0) => self.client = None,
                Ok(count) => self.line.send(&bytes[..count]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => self.client = None,
            }
        }
    }

    /// A client that does not take its bytes loses them, as on a wire.
    fn say(&mut self, bytes: &[u8]) {
        if let Some(client) = &mut self.client
            && !bytes.is_empty()
            && client.write_all(bytes).is_err_and(|error| error.kind() != io::ErrorKind::WouldBlock)
        {
            self.client = None;
        }
    }
}

/// Runs the board until standard input ends or the image does. A person ends it at once; a pipe, when all it
/// said has been done, as far as can be heard and seen.
///
/// # Errors
/// When the image cannot be started, or crashes.
pub fn run(options: &Options) -> Result<(), String> {
    let mut board = options.board.build()?;
    let files: Vec<_> = options.board.config_file()?.into_iter().collect();
    board.insert_card(Some(sd_image::build(options.sd.as_deref(), &files)?));
    let mut sockets = Vec::new();
    for (index, name) in PORT_NAMES.into_iter().enumerate() {
        let port = if options.port == 0 { 0 } else { options.port + index as u16 };
        let socket =
            Socket::open(port, board.console(index).clone()).map_err(|error| format!("port {port}: {error}"))?;
        let address = socket.listener.local_addr().map_err(|error| error.to_string())?;
        eprintln!("{name} on tcp {address}");
        sockets.push(socket);
    }
    let mut onlooker = options.state_port.map(Onlooker::open).transpose().map_err(|error| error.to_string())?;
    if let Some(onlooker) = &onlooker {
        eprintln!("the machine's state on tcp {}", onlooker.address().map_err(|error| error.to_string())?);
    }
    eprintln!("standard input and output are the debug console; end it with Ctrl-D");
    let is_person = io::stdin().is_terminal();
    let world = board.world().clone();
    let (instruments, records) = Instruments::new(&options.elf, &Probe::default())?;
    let table = texts(&options.elf).unwrap_or_else(|reason| {
        eprintln!("{reason}: its log is shown as it is");
        None
    });
    let mut log = Log::new(table.as_ref());
    let mut vm = Vm::start(board, &options.elf, Some(Box::new(instruments))).map_err(|error| error.to_string())?;
    let mut typed = Typed::read(io::stdin());
    // When the board may be spoken to, as far as is known.
    let mut open_ns = match options.opening() {
        Opening::AtOnce => 0,
        Opening::AfterFirstWords => u64::MAX,
        Opening::At(ns) => ns,
    };
    // When a byte last went either way or a step was last made.
    let mut stirred_ns = 0;
    let began = Instant::now();
    loop {
        let span = vm.run_for(SLICE.as_nanos() as u64);
        for (index, socket) in sockets.iter_mut().enumerate() {
            let said = socket.line.receive();
            socket.say(&said);
            if index == 0 {
                if !said.is_empty() && vm.now_ns() < open_ns && options.opening() == Opening::AfterFirstWords {
                    open_ns = vm.now_ns() + options.first_words_ns();
                }
                // Taken, so that they need no memory.
                let steps = world.lock().trace_mut().take();
                if !said.is_empty() || !steps.is_empty() {
                    stirred_ns = vm.now_ns();
                }
                let mut out = io::stdout().lock();
                // Whoever read it has gone.
                if out.write_all(&said).and_then(|()| out.flush()).is_err() {
                    return Ok(());
                }
            }
            socket.hear();
        }
        if let Some(onlooker) = &mut onlooker {
            onlooker.serve(&world.lock());
        }
        log.take(&std::mem::take(&mut records.lock().rtt), &mut io::stderr().lock());
        match span {
            Span::Reached => {}
            Span::Exited(_) => return Ok(()),
            Span::Failed(reason) => return Err(reason),
        }
        if options.until.is_some_and(|until| vm.now_ns() as f64 * 1e-9 >= until) {
            return Ok(());
        }
        let line = &sockets[0].line;
        if vm.now_ns() >= open_ns {
            typed.hand_to(line);
        }
        if line.unsent() > 0 {
            stirred_ns = vm.now_ns();
        }
        let is_quiet = vm.now_ns() - stirred_ns >= QUIET_NS;
        // With a time to end at, the end of the input is not the end of the session.
        if typed.is_over() && options.until.is_none() && (is_person || is_quiet) {
            return Ok(());
        }
        let ahead = Duration::from_nanos(vm.now_ns()).saturating_sub(began.elapsed());
        thread::sleep(ahead);
    }
}
