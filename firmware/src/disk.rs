//! The card as the disk of the computer at the USB socket.
//!
//! The disk belongs to the device, and so to its interrupt; the card is behind its lock. Between two events
//! of the bus the disk is told how the card stands, and what it wants of the card is begun: each takes the
//! lock for some microseconds, and neither is part of the other's frames. The executor decides on the owner
//! of the card: it lends the card, and takes it back once the disk has reported its return.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use bsp_prime::sd::{self, CardService};
use card::sd::{Direction, Lent, Run, SdError, State as CardState};
use usb::{BLOCK_BYTES, Fault, Half, Medium, Progress, State};

/// Blocks of a buffer, moved by one command of the card. While one buffer is at the bus, which takes 14 ms
/// for it, the other is at the card.
const BUFFER_BLOCKS: u32 = 32;

/// Whether computer or machine has ended the loan: then the disk is empty, and begins nothing more.
static IS_OVER: AtomicBool = AtomicBool::new(true);
/// Number of times the card was lent: a change makes the computer forget its copy of the contents.
static VISIT: AtomicU32 = AtomicU32::new(0);

/// Notes that the card has been lent.
pub fn lent() {
    VISIT.fetch_add(1, Ordering::Relaxed);
    IS_OVER.store(false, Ordering::Release);
}

/// Ends the loan: nothing more is begun.
pub fn end_loan() {
    IS_OVER.store(true, Ordering::Release);
}

/// Returns whether the loan has ended.
pub fn is_over() -> bool {
    IS_OVER.load(Ordering::Acquire)
}

/// Transfer that the disk wants of the card.
#[derive(Clone, Copy)]
struct Wanted {
    direction: Direction,
    run: Run,
    buffer: Half,
}

/// Medium of the disk, on the card.
pub struct CardMedium {
    state: State,
    wanted: Option<Wanted>,
    direction: Direction,
    progress: Progress,
}

impl CardMedium {
    /// Creates a medium without a card.
    pub const fn new() -> Self {
        Self { state: State::Absent, wanted: None, direction: Direction::FromCard, progress: Progress::Done }
    }

    /// Updates the medium from the state of the card.
    pub fn look(&mut self, card: &mut CardService) {
        self.state = match card.state() {
            CardState::Ready(info) if card.is_lent() && !is_over() => State::Ready {
                blocks: info.blocks,
                is_read_only: info.is_protected,
                visit: VISIT.load(Ordering::Relaxed),
            },
            _ => State::Absent,
        };
        if self.progress == Progress::Busy {
            self.progress = match card.lent() {
                Lent::Busy => Progress::Busy,
                Lent::Done => Progress::Done,
                Lent::Failed(error) => Progress::Failed(fault(error, self.direction)),
                Lent::Idle => Progress::Failed(Fault::Gone),
            };
        }
    }

    /// Returns whether a transfer of the card waits to begin.
    pub const fn wants_card(&self) -> bool {
        self.wanted.is_some()
    }

    /// Begins the waiting transfer of the card.
    pub fn begin(&mut self, card: &mut CardService, now_us: u64) {
        let Some(Wanted { direction, run, buffer }) = self.wanted.take() else { return };
        let begun = match sd::lent_buffer() {
            Some((address, _)) if !is_over() => card.begin(direction, run, address + place(buffer) as u32),
            _ => Err(SdError::Lent),
        };
        match begun {
            Ok(()) => card.advance(now_us),
            Err(error) => self.progress = Progress::Failed(fault(error, direction)),
        }
    }

    const fn want(&mut self, direction: Direction, first: u32, count: u32, buffer: Half) {
        self.wanted = Some(Wanted { direction, run: Run { first, count }, buffer });
        (self.direction, self.progress) = (direction, Progress::Busy);
    }
}

/// Returns the byte offset of a buffer within the blocks that are free while the card is lent.
const fn place(buffer: Half) -> usize {
    match buffer {
        Half::First => 0,
        Half::Second => BUFFER_BLOCKS as usize * BLOCK_BYTES,
    }
}

const fn fault(error: SdError, direction: Direction) -> Fault {
    match (error, direction) {
        (SdError::NoCard | SdError::Lent, _) => Fault::Gone,
        (SdError::NotResponding(_) | SdError::StaysBusy(_), _) => Fault::Silent,
        (SdError::Protected, _) => Fault::ReadOnly,
        (_, Direction::FromCard) => Fault::Unreadable,
        (_, Direction::ToCard) => Fault::NotWritten,
    }
}

impl Medium for CardMedium {
    const BUFFER_BLOCKS: u32 = BUFFER_BLOCKS;

    fn state(&self) -> State {
        self.state
    }

    fn begin_read(&mut self, block: u32, count: u32, buffer: Half) {
        self.want(Direction::FromCard, block, count, buffer);
    }

    fn begin_write(&mut self, block: u32, count: u32, buffer: Half) {
        self.want(Direction::ToCard, block, count, buffer);
    }

    fn progress(&mut self) -> Progress {
        self.progress
    }

    fn fetch(&self, buffer: Half, at: usize, into: &mut [u8]) {
        // The read is within the buffer, as its user knows the length.
        let _is_within = sd::read_lent(place(buffer) + at, into);
    }

    fn store(&mut self, buffer: Half, at: usize, bytes: &[u8]) {
        // After the end of the loan the blocks are the machine's again.
        let _is_within = !is_over() && sd::write_lent(place(buffer) + at, bytes);
    }

    fn eject(&mut self) {
        self.state = State::Absent;
        end_loan();
        crate::executor::wake();
    }
}
