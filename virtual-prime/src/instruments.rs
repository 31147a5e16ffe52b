//! Observation of an image while it runs: its log (RTT), its crashes, the instructions its functions take,
//! the time it masks interrupts, and its step queue's lead.
//! All of it uses the emulator's watches, which cost the image nothing and do not change its run.

mod calls;
mod masked;
mod queue;

pub use calls::{Call, CallStack};
pub use masked::{Masking, Window};
pub use queue::{QueueProbe, Sample};

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::emulator::{HitKind, Host, Settled, Watch};
use rigless::session::Session;
use rigless::soc::Width;

use crate::board::PrimeBoard;
use crate::image::{Mask, Symbols};
use crate::rtt;
use crate::vm::Observer;

/// Addresses of the configurable fault status and of the address that the MPU refused (Armv7-M manual,
/// B3.2.15 and B3.2.17).
const CFSR: u64 = 0xE000_ED28;
const MMFAR: u64 = 0xE000_ED34;
/// Names of the hard fault handler in cortex-m-rt and CMSIS.
const HARD_FAULT: [&str; 2] = ["HardFault", "HardFault_Handler"];

/// Records of the instruments, shared with the code that set them up.
#[derive(Clone, Debug, Default)]
pub struct Records(Arc<Mutex<Recorded>>);

/// Contents of the [`Records`].
#[derive(Debug, Default)]
pub struct Recorded {
    /// Bytes of RTT channel 0 not yet taken.
    pub rtt: Vec<u8>,
    /// Bytes of the semihosting console not yet taken.
    pub semihosting: Vec<u8>,
    /// Place at which the processor met a fault, once it has.
    pub crashed: Option<String>,
    /// Calls of the counted functions, by name, in the order in which they ended.
    pub calls: HashMap<String, Vec<Call>>,
    /// Counted calls that have not ended.
    pub call_stack: CallStack,
    /// Windows of masked interrupts, with their lengths in instructions.
    pub masking: Masking,
    /// Samples of the step queue's lead.
    pub queue: Vec<Sample>,
}

impl Recorded {
    /// Ends the calls that have left, as the run is over.
    pub fn end_calls(&mut self) {
        self.call_stack.close_all(&mut self.calls);
    }
}

impl Records {
    /// Locks the records so far.
    pub fn lock(&self) -> MutexGuard<'_, Recorded> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[derive(Clone, Debug)]
enum Point {
    Rtt,
    Crash,
    Enter(String),
    Leave(String),
    Mask(Mask),
    Queue(QueueProbe),
}

/// Selection of measurements, beside log and crashes.
#[derive(Clone, Debug, Default)]
pub struct Probe {
    /// Functions whose instructions are counted, by symbol or by a name within a mangled one.
    pub functions: Vec<String>,
    /// Whether windows of masked interrupts are measured.
    pub masked: bool,
    /// Step queue to sample, as [`QueueProbe::find`] takes it.
    pub queue: Option<String>,
    /// Whether a hard fault is part of the run, and does not end it.
    pub faults_are_meant: bool,
    /// Whether the log is left unread.
    pub leaves_log: bool,
}

/// The instruments of one image.
#[derive(Debug)]
pub struct Instruments {
    records: Records,
    points: HashMap<u64, Vec<Point>>,
    rtt: Option<rtt::Probe>,
    armed: bool,
}

impl Instruments {
    /// Sets up watches on the image's RTT channel and its hard fault handler, if it has them, and for the
    /// probe's selection.
    ///
    /// # Errors
    /// When the image cannot be read or lacks a function or a variable.
    pub fn new(elf: &Path, probe: &Probe) -> Result<(Self, Records), String> {
        let symbols = Symbols::read(elf)?;
        let mut points: HashMap<u64, Vec<Point>> = HashMap::new();
        let rtt = rtt::Probe::in_image(&symbols);
        if let Some(probe) = rtt.filter(|_| !probe.leaves_log) {
            points.entry(probe.write_word(0)).or_default().push(Point::Rtt);
        }
        for handler in
            HARD_FAULT.into_iter().filter(|_| !probe.faults_are_meant).filter_map(|name| symbols.function(name))
        {
            points.entry(handler.address).or_default().push(Point::Crash);
        }
        let records = Records::default();
        for name in &probe.functions {
            let function = symbols.function(name).ok_or_else(|| format!("{}: no function `{name}`", elf.display()))?;
            points.entry(function.address).or_default().push(Point::Enter(name.clone()));
            for exit in function.exits() {
                points.entry(exit).or_default().push(Point::Leave(name.clone()));
            }
            records.lock().calls.insert(name.clone(), Vec::new());
        }
        if probe.masked {
            for (address, mask) in symbols.masks() {
                points.entry(address).or_default().push(Point::Mask(mask));
            }
        }
        if let Some(words) = &probe.queue {
            let (address, queue) = QueueProbe::find(&symbols, words)?;
            points.entry(address).or_default().push(Point::Queue(queue));
        }
        Ok((Self { records: records.clone(), points, rtt, armed: false }, records))
    }

    fn arm(&mut self, session: &mut Session<PrimeBoard>, host: &mut dyn Host) {
        self.armed = true;
        for (&address, points) in &self.points {
            let data = points.iter().any(|point| matches!(point, Point::Rtt));
            session.watch(if data { Watch::Writes { address, length: 4 } } else { Watch::Instruction(address) });
        }
        session.settle_watches(host);
    }

    /// Takes all bytes that the image has written to RTT channel 0, as a debug probe does.
    fn drain_rtt(&self, host: &mut dyn Host) {
        let Some(probe) = self.rtt else { return };
        let bytes = probe.read(host, 0);
        self.records.lock().rtt.extend(bytes);
    }
}

impl Observer for Instruments {
    fn settled(&mut self, session: &mut Session<PrimeBoard>, host: &mut dyn Host, settled: &Settled) {
        if !self.armed {
            self.arm(session, host);
        }
        let Settled::Hit(hit) = settled else { return };
        if hit.kind == HitKind::Write {
            self.drain_rtt(host);
            return;
        }
        for point in self.points.get(&hit.address).into_iter().flatten() {
            let mut records = self.records.lock();
            match point {
                Point::Rtt => {}
                Point::Crash => {
                    let mut read = |address| host.read(address, Width::W32).unwrap_or(0);
                    let (status, address) = (read(CFSR), read(MMFAR));
                    records.crashed.get_or_insert_with(|| {
                        let at_s = hit.at.0 as f64 * 1e-9;
                        format!("hard fault at {at_s:.6} s, CFSR {status:#010x}, MMFAR {address:#010x}")
                    });
                }
                Point::Enter(name) => {
                    let Recorded { call_stack, calls, .. } = &mut *records;
                    call_stack.enter(name, hit.at.0, hit.instruction_count, calls);
                }
                Point::Leave(name) => {
                    let Recorded { call_stack, calls, .. } = &mut *records;
                    call_stack.leave(name, hit.instruction_count, calls);
                }
                Point::Mask(mask) => records.masking.meet(*mask, hit.address, hit.at.0, hit.instruction_count),
                Point::Queue(queue) => {
                    let ahead_ns = queue.ahead_ns(|address| host.read(address, Width::W32).unwrap_or(0) as u32);
                    records.queue.push(Sample { at_ns: hit.at.0, ahead_ns });
                }
            }
        }
    }

    fn console(&mut self, bytes: &[u8]) {
        self.records.lock().semihosting.extend(bytes);
    }

    fn verdict(&self) -> Option<String> {
        self.records.lock().crashed.clone()
    }
}
