//! What is watched while an image runs: its log (RTT), its crashes, and the instructions its functions take.
//!
//! All of it rides on the emulator's watches, which cost the image nothing and do not change its run.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::emulator::{HitKind, Host, Settled, Watch};
use rigless::session::Session;
use rigless::soc::Width;

use crate::board::PrimeBoard;
use crate::image::Symbols;
use crate::vm::Observer;

/// Layout of the RTT control block (SEGGER UM08001, "RTT control block"): 16 bytes of name, two counts, then 24 bytes
/// per up channel. Offsets of channel 0's fields.
const RTT_BUFFER: u64 = 28;
const RTT_SIZE: u64 = 32;
const RTT_WRITE: u64 = 36;
const RTT_READ: u64 = 40;

/// What the instruments have recorded, shared with whoever set them up.
#[derive(Clone, Debug, Default)]
pub struct Records(Arc<Mutex<Recorded>>);

/// See [`Records`].
#[derive(Debug, Default)]
pub struct Recorded {
    /// Bytes of RTT channel 0 not yet taken.
    pub rtt: Vec<u8>,
    /// Bytes of the semihosting console not yet taken.
    pub semihosting: Vec<u8>,
    /// Where the processor met a fault, once it has.
    pub crashed: Option<String>,
    /// Calls of the counted functions, by name.
    pub calls: HashMap<String, Calls>,
    /// Counted calls that have not ended.
    pub call_stack: CallStack,
}

impl Recorded {
    fn enter(&mut self, name: &str, count: u64) {
        self.call_stack.enter(name, count, &mut self.calls);
    }

    fn leave(&mut self, name: &str, count: u64) {
        self.call_stack.leave(name, count, &mut self.calls);
    }

    /// The run is over: calls that have left end now.
    pub fn end_calls(&mut self) {
        while !self.call_stack.0.is_empty() {
            self.call_stack.close_top(&mut self.calls);
        }
    }
}

impl Records {
    /// The records so far.
    pub fn lock(&self) -> MutexGuard<'_, Recorded> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Instruction counts of one function's calls.
#[derive(Clone, Debug, Default)]
pub struct Calls {
    /// One entry per call, in order: its own instructions, without those of counted functions that interrupted it.
    pub instructions: Vec<u32>,
}

/// A call under way.
#[derive(Clone, Debug)]
struct Frame {
    name: String,
    entered: u64,
    /// Instruction count after the last exit instruction that was reached. A conditional one may turn out not to be taken,
    /// so the call ends for good only when something else is entered, or an outer call leaves.
    left: Option<u64>,
    /// Instructions of counted functions that ran in between.
    nested: u64,
}

/// The counted calls under way, outermost first: interrupts nest.
#[derive(Clone, Debug, Default)]
pub struct CallStack(Vec<Frame>);

impl CallStack {
    fn enter(&mut self, name: &str, count: u64, calls: &mut HashMap<String, Calls>) {
        while self.0.last().is_some_and(|top| top.left.is_some()) {
            self.close_top(calls);
        }
        self.0.push(Frame { name: name.to_owned(), entered: count, left: None, nested: 0 });
    }

    /// An exit instruction of this function was reached; it counts itself.
    fn leave(&mut self, name: &str, count: u64, calls: &mut HashMap<String, Calls>) {
        if !self.0.iter().any(|frame| frame.name == name) {
            return;
        }
        while self.0.last().is_some_and(|top| top.name != name) {
            self.close_top(calls);
        }
        if let Some(top) = self.0.last_mut() {
            top.left = Some(count + 1);
        }
    }

    /// Ends the innermost call. One that never reached an exit is not recorded.
    fn close_top(&mut self, calls: &mut HashMap<String, Calls>) {
        let Some(frame) = self.0.pop() else { return };
        let Some(left) = frame.left else { return };
        let inclusive = left - frame.entered;
        if let Some(outer) = self.0.last_mut() {
            outer.nested += inclusive;
        }
        calls.entry(frame.name).or_default().instructions.push((inclusive - frame.nested.min(inclusive)) as u32);
    }
}

#[derive(Clone, Debug)]
enum Point {
    Rtt,
    Crash,
    Enter(String),
    Leave(String),
}

/// The instruments, set up for one image.
#[derive(Debug)]
pub struct Instruments {
    records: Records,
    points: HashMap<u64, Vec<Point>>,
    rtt: Option<u64>,
    armed: bool,
}

impl Instruments {
    /// Watches the image's RTT channel and its hard fault handler, if it has them, and counts these functions.
    ///
    /// # Errors
    /// When the image cannot be read or lacks a function.
    pub fn new(elf: &Path, functions: &[String]) -> Result<(Self, Records), String> {
        let symbols = Symbols::read(elf)?;
        let mut points: HashMap<u64, Vec<Point>> = HashMap::new();
        let rtt = symbols.object("_SEGGER_RTT");
        if let Some(block) = rtt {
            points.entry(block + RTT_WRITE).or_default().push(Point::Rtt);
        }
        if let Some(handler) = symbols.function("HardFault") {
            points.entry(handler.address).or_default().push(Point::Crash);
        }
        let records = Records::default();
        for name in functions {
            let function = symbols.function(name).ok_or_else(|| format!("{}: no function `{name}`", elf.display()))?;
            points.entry(function.address).or_default().push(Point::Enter(name.clone()));
            for exit in function.exits() {
                points.entry(exit).or_default().push(Point::Leave(name.clone()));
            }
            records.lock().calls.insert(name.clone(), Calls::default());
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

    /// Takes everything the image has written to RTT channel 0, as a debug probe does.
    fn drain_rtt(&self, host: &mut dyn Host) {
        let Some(block) = self.rtt else { return };
        let mut word = |address| host.read(address, Width::W32).unwrap_or(0);
        let (buffer, size) = (word(block + RTT_BUFFER), word(block + RTT_SIZE));
        let (write, mut read) = (word(block + RTT_WRITE), word(block + RTT_READ));
        if size == 0 || write >= size || read >= size {
            return;
        }
        let mut records = self.records.lock();
        while read != write {
            records.rtt.push(host.read(buffer + read, Width::W8).unwrap_or(0) as u8);
            read = (read + 1) % size;
        }
        drop(records);
        // A failed write leaves the bytes in the buffer, and they come again.
        let _ = host.write(block + RTT_READ, Width::W32, read);
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
                    records.crashed.get_or_insert_with(|| format!("hard fault at {:.6} s", hit.at.0 as f64 * 1e-9));
                }
                Point::Enter(name) => records.enter(name, hit.instruction_count),
                Point::Leave(name) => records.leave(name, hit.instruction_count),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interrupted_call_counts_only_its_own_instructions() {
        let mut records = Recorded::default();
        records.enter("outer", 100);
        records.enter("inner", 110);
        records.leave("inner", 119);
        records.leave("outer", 129);
        // Whatever comes next closes them.
        records.enter("outer", 200);
        assert_eq!(records.calls["inner"].instructions, [10]);
        assert_eq!(records.calls["outer"].instructions, [20]);
    }

    #[test]
    fn an_exit_that_was_not_taken_does_not_end_the_call() {
        let mut records = Recorded::default();
        records.enter("f", 0);
        records.leave("f", 4);
        records.leave("f", 9);
        records.enter("f", 50);
        assert_eq!(records.calls["f"].instructions, [10]);
    }
}
