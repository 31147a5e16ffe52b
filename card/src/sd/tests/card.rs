//! A card in memory behind a host that takes its time.

use std::collections::{BTreeMap, VecDeque};

use crate::sd::{
    Answer, BLOCK_BYTES, Block, Command, Direction, Fault, Host, Place, Power, Progress, Read, Run, SLOTS, SdError,
    Service, State, Transfer,
};

pub const BLOCKS: u32 = 2048;
const ADDRESS: u32 = 0x1234_0000;
/// First address of the memory for `Place::Address`.
pub const OUTSIDE: u32 = 0x2000_0000;

/// Behaviour of the host in the next transfers, in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    Good,
    Damaged,
    Silent,
}

#[derive(Debug)]
pub struct Fake {
    pub now_us: u64,
    pub content: BTreeMap<u32, u8>,
    /// Every block written, in order: its number, and the byte that fills it.
    pub written: Vec<(u32, u8)>,
    pub slots: Vec<Block>,
    pub outside: Vec<u8>,
    pub read_us: u64,
    pub write_us: u64,
    pub turns: VecDeque<Turn>,
    pub is_there: bool,
    /// Numbers of the blocks with uncorrectable errors.
    pub unreadable: Vec<u32>,
    /// Number of the first block whose writes are accepted and lost.
    pub keeps_below: u32,
    pub bus_hz: u32,
    pub damages_above_hz: u32,
    due: Option<(u64, Progress)>,
    busy_until_us: u64,
    answer: u32,
    is_long: bool,
    status: u32,
}

impl Fake {
    pub fn new() -> Self {
        Self {
            now_us: 0,
            content: BTreeMap::new(),
            written: Vec::new(),
            slots: vec![[0; BLOCK_BYTES]; SLOTS],
            outside: vec![0; 64 * BLOCK_BYTES],
            read_us: 300,
            write_us: 300,
            turns: VecDeque::new(),
            is_there: true,
            unreadable: Vec::new(),
            keeps_below: BLOCKS,
            bus_hz: 0,
            damages_above_hz: u32::MAX,
            due: None,
            busy_until_us: 0,
            answer: 0,
            is_long: false,
            status: 0,
        }
    }

    pub fn fill_of(&self, number: u32) -> u8 {
        self.content.get(&number).copied().unwrap_or(number as u8 ^ 0x5A)
    }

    fn memory(&mut self, place: Place, block: u32) -> &mut [u8] {
        match place {
            Place::Slot(slot) => &mut self.slots[slot + block as usize],
            Place::Address(address) => {
                let at = (address - OUTSIDE) as usize + block as usize * BLOCK_BYTES;
                &mut self.outside[at..at + BLOCK_BYTES]
            }
        }
    }

    fn register(&mut self, transfer: Transfer, bytes: &[(usize, u8)]) {
        let memory = self.memory(transfer.place, 0);
        bytes.iter().for_each(|(at, byte)| memory[*at] = *byte);
    }

    fn move_blocks(&mut self, first: u32, transfer: Transfer) -> Progress {
        let turn = self.turns.pop_front().unwrap_or(Turn::Good);
        if self.bus_hz > self.damages_above_hz || turn == Turn::Damaged {
            return Progress::Failed(Fault::DataDamaged);
        }
        if turn == Turn::Silent {
            return Progress::Failed(Fault::TooLate);
        }
        for block in 0..transfer.blocks {
            let number = first + block;
            assert!(number < BLOCKS);
            if transfer.direction == Direction::FromCard {
                if self.unreadable.contains(&number) {
                    // CARD_ECC_FAILED, told by the next status.
                    self.status |= 1 << 21;
                    return Progress::Failed(Fault::TooLate);
                }
                let fill = self.fill_of(number);
                self.memory(transfer.place, block).fill(fill);
            } else {
                let fill = self.memory(transfer.place, block)[7];
                self.written.push((number, fill));
                if number < self.keeps_below {
                    self.content.insert(number, fill);
                }
            }
        }
        if transfer.direction == Direction::ToCard {
            self.busy_until_us = self.now_us + self.write_us * u64::from(transfer.blocks);
        }
        Progress::Done
    }
}

impl Host for Fake {
    fn power(&mut self, _: Power) {}

    fn set_bus(&mut self, hz: u32, _: bool) {
        self.bus_hz = hz;
    }

    fn begin(&mut self, command: Command, data: Option<Transfer>) {
        let mut takes_us = 10;
        self.is_long = command.answer == Answer::Long;
        self.answer = self.status | 4 << 9 | 1 << 8;
        let progress = if !self.is_there {
            match command.answer {
                Answer::None => Progress::Done,
                _ => Progress::Failed(Fault::NoAnswer),
            }
        } else if let Some(transfer) = data {
            takes_us = if transfer.direction == Direction::FromCard { self.read_us } else { 50 };
            match command.index {
                51 => {
                    self.register(transfer, &[(0, 2), (1, 0x35)]);
                    Progress::Done
                }
                6 => {
                    self.register(transfer, &[(13, 3), (16, (command.argument & 0xF) as u8)]);
                    Progress::Done
                }
                _ => self.move_blocks(command.argument, transfer),
            }
        } else {
            match command.index {
                8 => self.answer = 0x1AA,
                41 => self.answer = 0xC0FF_8000,
                3 => self.answer = ADDRESS | 0x500,
                // CMD13 and CMD12 tell errors, and clear them.
                12 | 13 => self.status = 0,
                _ => {}
            }
            Progress::Done
        };
        self.due = Some((self.now_us + takes_us, progress));
    }

    fn progress(&mut self) -> Progress {
        match self.due {
            Some((due_us, progress)) if self.now_us >= due_us => progress,
            _ => Progress::Busy,
        }
    }

    fn answer(&self) -> [u32; 4] {
        // The CSD of 1 MiB: two units of 512 KiB, class 10.
        if self.is_long { [0x400E_0032, 0x5B59_0000, 0x0001_7F80, 0x0A40_0001] } else { [self.answer, 0, 0, 0] }
    }

    fn is_held_busy(&mut self) -> bool {
        self.now_us < self.busy_until_us
    }

    fn load(&self, slot: usize, block: &mut Block) {
        *block = self.slots[slot];
    }

    fn store(&mut self, slot: usize, block: &Block) {
        self.slots[slot] = *block;
    }
}

pub type Bench = Service<Fake>;

pub fn run(service: &mut Bench, us: u64) {
    let end_us = service.host().now_us + us;
    while service.host().now_us < end_us {
        service.host().now_us += 10;
        let now_us = service.host().now_us;
        service.advance(now_us);
    }
}

#[track_caller]
pub fn identified() -> Bench {
    let mut service = Service::new(Fake::new());
    service.identify();
    run(&mut service, 20_000);
    assert!(matches!(service.state(), State::Ready(card) if card.blocks == BLOCKS), "{:?}", service.state());
    service.take_event();
    service
}

/// Reads a block, however long it takes; returns the byte that fills it.
#[track_caller]
pub fn read(service: &mut Bench, number: u32) -> Result<u8, SdError> {
    let mut block = [0; BLOCK_BYTES];
    for _ in 0..1_000_000 {
        match service.read(number, &mut block)? {
            Read::Done => {
                assert!(block.iter().all(|byte| *byte == block[0]), "torn");
                return Ok(block[0]);
            }
            Read::NotYet => run(service, 10),
        }
    }
    panic!("block {number} never comes");
}

/// Writes a block, waiting for room; returns the time taken, us.
#[track_caller]
pub fn write(service: &mut Bench, number: u32, fill: u8) -> Result<u64, SdError> {
    let since_us = service.host().now_us;
    while !service.write(number, &[fill; BLOCK_BYTES])? {
        run(service, 10);
    }
    Ok(service.host().now_us - since_us)
}

#[track_caller]
pub fn flush(service: &mut Bench) -> Result<(), SdError> {
    for _ in 0..10_000_000 {
        if service.is_kept()? {
            return Ok(());
        }
        run(service, 10);
    }
    panic!("never written");
}

pub const fn stretch(first: u32, count: u32) -> Run {
    Run { first, count }
}
