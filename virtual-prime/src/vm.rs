//! Runs an image on the board, one span of virtual time after another.
//!
//! The emulator calls back and runs on a thread of its own; [`Vm`] turns that round: the caller says how far
//! to run, and between runs may reach everything. The division of a run into spans does not change it: the
//! machine is served on a fixed grid of a millisecond.

use std::fmt;
use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};

use rigless::emulator::{self, Access, AccessKind, Driver, Host, Settled, Start, Stop};
use rigless::image::{self, Image};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use crate::board::PrimeBoard;
use crate::complaints::complaints;
use crate::factory;
use crate::flash_journal::{Operation, SECTOR, START};
use crate::translations;

/// Grid on which the machine's slow physics and voltages are brought up to date.
const GRID_NS: u64 = 1_000_000;
/// Address of DBGMCU_IDC, which can be read at any time and to no effect.
const DBGMCU_IDC: u64 = 0x5C00_1000;

/// Reason why an image could not be run.
#[derive(Debug)]
pub struct StartError(String);

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for StartError {}

/// End of a span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Span {
    /// Virtual time has reached the requested instant.
    Reached,
    /// The image ended the run itself, through semihosting, with this status.
    Exited(u32),
    /// The emulator gave up, with the action of the image that it cannot emulate.
    Failed(String),
}

/// State between two instructions of the image, for work on it.
pub struct Stopped<'a> {
    /// The emulator's session: the board and its complaints.
    pub session: &'a mut Session<PrimeBoard>,
    /// Access to memory and watches.
    pub host: &'a mut dyn Host,
    /// Instant and place at which the run has stopped.
    pub stop: Stop,
}

type Work = Box<dyn FnOnce(&mut Stopped<'_>) + Send>;

enum Command {
    RunUntil(u64),
    Do(Work),
}

enum Report {
    Stopped(Stop),
    /// The run is over; the board's complaints come with it.
    Ended(Span, Vec<String>),
}

/// An observer of accesses and watch hits, called on the emulator's thread.
pub trait Observer: Send {
    /// Handles something that settled: an access, a watch hit, a stop.
    fn settled(&mut self, session: &mut Session<PrimeBoard>, host: &mut dyn Host, settled: &Settled);
    /// Takes bytes of the semihosting console.
    fn console(&mut self, _bytes: &[u8]) {}
    /// Returns a reason to end the run, asked for every millisecond.
    fn verdict(&self) -> Option<String> {
        None
    }
}

/// A running board, held between spans.
pub struct Vm {
    commands: Option<Sender<Command>>,
    reports: Receiver<Report>,
    thread: Option<JoinHandle<()>>,
    stop: Stop,
    ended: Option<Span>,
    complaints: Vec<String>,
}

impl Vm {
    /// Loads an ELF image and holds it before its first instruction.
    ///
    /// # Errors
    /// When the image cannot be read or placed.
    pub fn start(board: PrimeBoard, elf: &Path, observer: Option<Box<dyn Observer>>) -> Result<Self, StartError> {
        translations::load(elf);
        let failed = |error: image::Error| StartError(error.to_string());
        let images = [Image::read(elf, None).map_err(failed)?, factory::image().map_err(failed)?];
        let session =
            Session::new(Box::new(board), 0, VirtualNanos(0)).map_err(|error| StartError(error.to_string()))?;
        let (commands, orders) = mpsc::channel();
        let (answers, reports) = mpsc::channel();
        let thread = thread::Builder::new()
            .name("virtual-prime".into())
            .spawn(move || execute(session, &images, Puppet { orders, answers, target: 0, observer }))
            .map_err(|error| StartError(error.to_string()))?;
        let mut vm = Self {
            commands: Some(commands),
            reports,
            thread: Some(thread),
            stop: Stop { at: VirtualNanos(0), instruction_count: 0, reason: emulator::StopReason::Deadline },
            ended: None,
            complaints: Vec::new(),
        };
        match vm.wait() {
            Span::Failed(reason) => Err(StartError(reason)),
            _ => Ok(vm),
        }
    }

    /// Runs the image up to this instant, in nanoseconds since power-on.
    pub fn run_until(&mut self, at_ns: u64) -> Span {
        if let Some(ended) = &self.ended {
            return ended.clone();
        }
        self.order(Command::RunUntil(at_ns));
        self.wait()
    }

    /// Runs the image for so many nanoseconds.
    pub fn run_for(&mut self, nanoseconds: u64) -> Span {
        self.run_until(self.now_ns() + nanoseconds)
    }

    fn order(&mut self, command: Command) {
        // A closed channel means the run has ended, which the next wait reports.
        let _ = self.commands.as_ref().map(|commands| commands.send(command));
    }

    fn wait(&mut self) -> Span {
        match self.reports.recv() {
            Ok(Report::Stopped(stop)) => {
                self.stop = stop;
                Span::Reached
            }
            Ok(Report::Ended(span, complaints)) => {
                self.ended = Some(span.clone());
                self.complaints = complaints;
                span
            }
            Err(_) => {
                let span = Span::Failed("the emulator's thread died".into());
                self.ended = Some(span.clone());
                span
            }
        }
    }

    /// Runs `work` with the board while the image is held; `None` once the run has ended.
    pub fn with<R: Send + 'static>(&mut self, work: impl FnOnce(&mut Stopped<'_>) -> R + Send + 'static) -> Option<R> {
        if self.ended.is_some() {
            return None;
        }
        let (sender, receiver) = mpsc::channel();
        self.order(Command::Do(Box::new(move |stopped| {
            let _ = sender.send(work(stopped));
        })));
        receiver.recv().ok()
    }

    /// Returns the emulator's complaints so far.
    pub fn complaints(&mut self) -> Vec<String> {
        self.with(|stopped| complaints(stopped.session)).unwrap_or_else(|| self.complaints.clone())
    }

    /// Returns the virtual time, nanoseconds since power-on.
    #[must_use]
    pub const fn now_ns(&self) -> u64 {
        self.stop.at.0
    }

    /// Returns the instructions executed so far.
    #[must_use]
    pub const fn instructions(&self) -> u64 {
        self.stop.instruction_count
    }
}

impl Drop for Vm {
    fn drop(&mut self) {
        self.commands = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        translations::save();
    }
}

fn execute(session: Session<PrimeBoard>, images: &[Image], puppet: Puppet) {
    let answers = puppet.answers.clone();
    let mut start = Start::new(images);
    start.semihosting = true;
    let (span, found) = match emulator::run(session, &start, puppet) {
        Ok(finished) => {
            let verdict = finished.driver.observer.as_ref().and_then(|observer| observer.verdict());
            let span = match (finished.exit_status, verdict) {
                (Some(status), _) => Span::Exited(status),
                (None, Some(reason)) => Span::Failed(reason),
                (None, None) => Span::Reached,
            };
            (span, complaints(&finished.session))
        }
        Err(error) => (Span::Failed(error.to_string()), Vec::new()),
    };
    // Nobody listens any more when the run was dropped early.
    let _ = answers.send(Report::Ended(span, found));
}

/// The driver that the emulator calls, and that obeys the commands of the [`Vm`].
struct Puppet {
    orders: Receiver<Command>,
    answers: Sender<Report>,
    target: u64,
    observer: Option<Box<dyn Observer>>,
}

impl Puppet {
    /// Returns the next instant to stop at: the grid, or the target when it comes first.
    fn next(&self, now_ns: u64) -> VirtualNanos {
        VirtualNanos(((now_ns / GRID_NS + 1) * GRID_NS).min(self.target))
    }
}

impl Driver<PrimeBoard> for Puppet {
    fn on_settled(&mut self, session: &mut Session<PrimeBoard>, host: &mut dyn Host, settled: Settled) {
        if let Settled::Access { access, .. } = &settled {
            let board = session.board_mut();
            if access.kind == AccessKind::Write {
                board.notice_modes(access.virtual_time, access.address);
                board.notice_frame(access.address);
                if let Some(Operation::Erase(sector)) = board.notice_flash(access) {
                    // A word that a power failure made unreadable can be read again after an erase.
                    host.spoil(START + (sector * SECTOR) as u64, SECTOR as u64, false);
                }
            }
            if board.take_switch_changes(access.virtual_time) {
                // The new level of a switch reaches the interrupt controller with the next access. So the
                // debug port is read here, which changes nothing, at the same instant.
                let nudge = Access::new(AccessKind::Read, DBGMCU_IDC, Width::W32, 0)
                    .at(access.instruction_count, access.virtual_time);
                session.access(nudge, host);
            }
        }
        if let Some(observer) = &mut self.observer {
            observer.settled(session, host, &settled);
        }
    }

    fn on_stop(&mut self, session: &mut Session<PrimeBoard>, stop: Stop, host: &mut dyn Host) -> Option<VirtualNanos> {
        let now_ns = stop.at.0;
        if now_ns.is_multiple_of(GRID_NS) {
            session.board_mut().tick(stop.at, stop.instruction_count);
        }
        if self.observer.as_ref().is_some_and(|observer| observer.verdict().is_some()) {
            return None;
        }
        if now_ns < self.target {
            return Some(self.next(now_ns));
        }
        self.answers.send(Report::Stopped(stop)).ok()?;
        loop {
            match self.orders.recv().ok()? {
                Command::RunUntil(target) if target > now_ns => {
                    self.target = target;
                    return Some(self.next(now_ns));
                }
                Command::RunUntil(_) => self.answers.send(Report::Stopped(stop)).ok()?,
                Command::Do(work) => {
                    work(&mut Stopped { session, host, stop });
                    session.board_mut().take_switch_changes(stop.at);
                }
            }
        }
    }

    fn on_console(&mut self, _at: VirtualNanos, _count: u64, bytes: &[u8]) {
        if let Some(observer) = &mut self.observer {
            observer.console(bytes);
        }
    }
}
