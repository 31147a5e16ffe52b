//! A job from the SD card, from power-on to standstill: what `run` writes down and `bench` measures.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use sim::output::{Outcome, Recorder};
use sim::session::{Opening, Session};
use virtual_prime::board::{CORE_HZ, SharedWorld};
use virtual_prime::console::Line;
use virtual_prime::instruments::{Instruments, Probe, Records};
use virtual_prime::vm::{Span, Vm};

use super::computer::Computer;
use super::log::{Log, texts};
use super::machine::BoardOptions;
use super::network_load::{Load, NetworkLoad};

const MS: u64 = 1_000_000;
/// Interval at which the console is served; a coarser grid would delay answers, a finer grid the run.
const SLICE_NS: u64 = 10 * MS;
/// The job's name on the card.
const JOB: &str = "job.gcode";

/// A job and what it runs on.
#[derive(Args)]
pub struct JobOptions {
    #[command(flatten)]
    pub board: BoardOptions,
    /// The job.
    #[arg(long)]
    pub gcode: PathBuf,
    /// Virtual seconds after which the job counts as hung.
    #[arg(long)]
    pub until: Option<f64>,
    /// An image that is not ours: the operator waits for its first words, and complaints of the board are
    /// listed only.
    #[arg(long)]
    pub foreign: bool,
    /// Virtual seconds after which the operator speaks, whatever the image has said.
    #[arg(long)]
    pub start: Option<f64>,
}

impl JobOptions {
    fn opening(&self) -> Opening {
        match self.start {
            Some(seconds) => Opening::At((seconds * 1e9) as u64),
            None if self.foreign => Opening::AfterFirstWords,
            None => Opening::AtOnce,
        }
    }
}

/// Purpose of a run, beside its files.
#[derive(Default)]
pub struct Study {
    /// Selection of the measurements.
    pub probe: Probe,
    /// Whether the operator asks for status and temperatures all the time while the machine moves.
    pub flood: bool,
    /// Whether a computer at the USB socket says and hears all it can meanwhile.
    pub usb_flood: bool,
    /// Traffic on the network meanwhile; without it the cable is out.
    pub network: Option<Load>,
    /// Number of steps after which the operator types `!` once, and `~` [`HELD_NS`] later.
    pub hold_after: Option<u64>,
    /// Delay of the `!` after that: the board is looked at only every [`SLICE_NS`], a whole number of periods
    /// of the image's tasks.
    pub hold_delay_ns: u64,
}

/// Duration of a hold.
const HELD_NS: u64 = 200 * MS;
/// Slices between two M105 of an operator who floods.
const SLICES_PER_M105: u64 = 4;

/// A job that has come to its end, successful or not.
pub struct Finished {
    /// Result of the job.
    pub outcome: Outcome,
    /// Records of the instruments.
    pub records: Records,
    /// Virtual time of the run, nanoseconds.
    pub virtual_ns: u64,
    /// Number of instructions executed.
    pub instructions: u64,
    /// Instants of the first and the last step, nanoseconds since power-on.
    pub moving: Option<(u64, u64)>,
    /// Instant at which `!` was typed.
    pub held_ns: Option<u64>,
}

struct Running {
    vm: Vm,
    console: Line,
    world: SharedWorld,
    records: Records,
    session: Session,
    recorder: Recorder,
    moving: Option<(u64, u64)>,
    held_ns: Option<u64>,
    resumed: bool,
    computer: Computer,
    network: Option<NetworkLoad>,
}

/// Runs a job, measures what the study asks for, and writes its files to `out`.
///
/// # Errors
/// When it cannot be set up, or its files cannot be written. A job that fails is an [`Outcome`].
pub fn play(options: &JobOptions, study: &Study, out: &Path) -> Result<Finished, String> {
    let gcode = fs::read(&options.gcode).map_err(|error| format!("{}: {error}", options.gcode.display()))?;
    let lines = gcode.iter().filter(|&&byte| byte == b'\n').count() as u64;
    let mut running = start(options, study, out, gcode)?;
    let fail = |error: io::Error| format!("{}: {error}", out.display());
    // Log frames of another image need not be in our format.
    let table =
        if options.foreign { texts(&options.board.elf).unwrap_or_default() } else { texts(&options.board.elf)? };
    let mut frames = Log::new(table.as_ref());
    let mut log = fs::File::create(out.join("rtt.log")).map_err(fail)?;
    let mut meter = Meter::new();
    let mut ended = None;
    while !running.session.is_over() && ended.is_none() {
        let span = running.slice(&mut meter).map_err(fail)?;
        running.interfere(study);
        if study.usb_flood {
            running.use_usb()?;
        }
        running.use_network();
        frames.take(&std::mem::take(&mut running.records.lock().rtt), &mut log);
        meter.show(running.vm.now_ns(), &running.session);
        let seconds = running.vm.now_ns() as f64 * 1e-9;
        ended = match span {
            Span::Reached if options.until.is_some_and(|until| seconds >= until) => {
                Some(format!("the job was not done after {seconds:.1} virtual seconds"))
            }
            Span::Reached => None,
            Span::Exited(status) => Some(format!("the image ended itself with status {status}")),
            Span::Failed(reason) => Some(reason),
        };
    }
    meter.done(running.vm.now_ns());
    running.finish(lines, ended).map_err(fail)
}

fn start(options: &JobOptions, study: &Study, out: &Path, gcode: Vec<u8>) -> Result<Running, String> {
    let board = options.board.build(vec![(JOB.to_owned(), gcode)])?;
    let (console, world) = (board.console(0).clone(), board.world().clone());
    let recorder = Recorder::create(out, &world.lock()).map_err(|error| error.to_string())?;
    let (instruments, records) = Instruments::new(&options.board.elf, &study.probe)?;
    let mut vm =
        Vm::start(board, &options.board.elf, Some(Box::new(instruments))).map_err(|error| error.to_string())?;
    let session = Session::new(JOB, options.opening());
    let network = study.network.map(|load| NetworkLoad::plug(load, &mut vm));
    Ok(Running {
        vm,
        console,
        world,
        records,
        session,
        recorder,
        moving: None,
        held_ns: None,
        resumed: false,
        computer: Computer::default(),
        network,
    })
}

impl Running {
    /// Runs the board for a slice, and lets the operator read and type.
    fn slice(&mut self, meter: &mut Meter) -> io::Result<Span> {
        let span = self.vm.run_for(SLICE_NS);
        let said = self.console.receive();
        self.recorder.console(&said)?;
        // The operator comes when the board has its address.
        if self.network.as_ref().is_none_or(NetworkLoad::knows_the_board) {
            self.session.hear(self.vm.now_ns(), &said);
            if let Some(words) = self.session.say(self.vm.now_ns()) {
                self.console.send(words.as_bytes());
            }
        }
        let load = meter.load(self.vm.now_ns(), self.vm.instructions());
        let mut world = self.world.lock();
        if let [first, .., last] = world.trace().edges() {
            self.moving = Some((self.moving.map_or(first.time_ns, |(began_ns, _)| began_ns), last.time_ns));
        }
        self.recorder.observe(&mut world, load)?;
        Ok(span)
    }

    /// Types for the operator the extra input that the study asks for.
    fn interfere(&mut self, study: &Study) {
        let (now_ns, steps) = (self.vm.now_ns(), self.world.lock().trace().total());
        match (study.hold_after, self.held_ns) {
            (Some(after), None) if steps >= after => {
                self.vm.run_for(study.hold_delay_ns);
                self.console.send(b"!");
                self.held_ns = Some(self.vm.now_ns());
            }
            (_, Some(held_ns)) if !self.resumed && now_ns >= held_ns + HELD_NS => {
                self.console.send(b"~");
                self.resumed = true;
            }
            _ => {}
        }
        // More questions would only queue up behind bytes that are still on the wire.
        if study.flood && steps > 0 && self.console.unsent() == 0 {
            self.console.send(b"?");
            if (now_ns / SLICE_NS).is_multiple_of(SLICES_PER_M105) {
                self.console.send(b"M105\n");
            }
        }
    }

    /// Lets the computer use the USB socket once the machine moves.
    fn use_usb(&mut self) -> Result<(), String> {
        if self.computer.is_plugged() {
            self.computer.flood(&mut self.vm);
        } else if self.world.lock().trace().total() > 0 {
            self.computer.plug(&mut self.vm).map_err(|error| format!("the USB host: {error}"))?;
        }
        Ok(())
    }

    /// Lets the computer at the cable have its turn: the traffic begins once the machine moves.
    fn use_network(&mut self) {
        let moves = self.world.lock().trace().total() > 0;
        if let Some(network) = &mut self.network {
            network.serve(&mut self.vm, moves);
        }
    }

    fn finish(mut self, lines: u64, ended: Option<String>) -> io::Result<Finished> {
        let mut errors = self.session.errors().to_vec();
        errors.extend(ended);
        let halted = self.session.halted().map(str::to_owned);
        let outcome = Outcome { lines, halted, errors, board: self.vm.complaints(), ..Outcome::default() };
        self.recorder.finish(&mut self.world.lock(), &outcome)?;
        self.records.lock().end_calls();
        Ok(Finished {
            outcome,
            records: self.records,
            virtual_ns: self.vm.now_ns(),
            instructions: self.vm.instructions(),
            moving: self.moving,
            held_ns: self.held_ns,
        })
    }
}

/// Progress on standard error, and the processor's load.
struct Meter {
    began: Instant,
    percent: u64,
    /// Virtual time and instruction count at the last reading.
    last: (u64, u64),
}

impl Meter {
    fn new() -> Self {
        Self { began: Instant::now(), percent: 0, last: (0, 0) }
    }

    /// Share of time since the last call that the core executed instead of sleeping.
    fn load(&mut self, now_ns: u64, instructions: u64) -> f64 {
        let (then_ns, before) = std::mem::replace(&mut self.last, (now_ns, instructions));
        let possible = (now_ns - then_ns) as f64 * 1e-9 * CORE_HZ as f64;
        (instructions - before) as f64 / possible
    }

    fn show(&mut self, now_ns: u64, session: &Session) {
        let percent = session.progress().map_or(0, |share| (share * 100.0) as u64);
        if percent > self.percent {
            self.percent = percent;
            let wall = self.began.elapsed().as_secs_f64();
            eprintln!("{percent:3} %  {:.1} s of the machine's time in {wall:.1} s", now_ns as f64 * 1e-9);
        }
    }

    fn done(&self, now_ns: u64) {
        let (machine, wall) = (now_ns as f64 * 1e-9, self.began.elapsed().as_secs_f64());
        eprintln!("{machine:.1} s of the machine's time in {wall:.1} s");
    }
}
