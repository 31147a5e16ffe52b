//! SDMMC1, RM0399 rev 4 chapter 58 ("SDMMC"): the host controller of the SD card, with its FIFO and internal DMA.
//!
//! The card is `sim`'s. Commands, responses and data blocks take their time on the bus: the kernel clock over CLKDIV,
//! 48 or 136 bits on CMD, one or four data lines with 16 bits of checksum per block. In FIFO mode data move in bursts
//! of eight words, the half FIFO that RXFIFOHF and TXFIFOHE speak of; with the internal DMA a block moves at its end.
//!
//! Left out: boot mode, SDIO, interrupt and read-wait periods, voltage switching, suspend, and the stream modes.

use std::collections::VecDeque;
use std::ops::Range;

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32h743::generated::sdmmc1::Register;
use rigless::time::{EventId, VirtualNanos};
use sim::models::sd_card::{Reply, SdCard, Transfer};

use super::sdmmc_flags as flag;

mod data;

/// 16 words.
const FIFO_WORDS: usize = 16;
const HALF_FIFO: usize = FIFO_WORDS / 2;
/// CMDR fields, section 58.10.4.
const CMDTRANS: u64 = 1 << 6;
const CMDSTOP: u64 = 1 << 7;
const CPSMEN: u64 = 1 << 12;
/// DCTRL fields, section 58.10.12.
const DTEN: u64 = 1;
const DTDIR: u64 = 1 << 1;
const DTHOLD: u64 = 1 << 13;
const FIFORST: u64 = 1 << 13;
/// CLKCR fields, section 58.10.2.
const HWFC_EN: u64 = 1 << 17;
/// IDMACTRLR fields.
const IDMAEN: u64 = 1;
const IDMABMODE: u64 = 1 << 1;
const IDMABACT: u64 = 1 << 2;
/// What the internal DMA of SDMMC1 reaches, RM0399 table 3: the flash, AXI SRAM and the external memories, but neither
/// the TCMs nor the second domain's SRAM.
const IDMA_REACH: [Range<u64>; 3] = [0x0800_0000..0x0820_0000, 0x2400_0000..0x2408_0000, 0x6000_0000..0xA000_0000];
/// Access time of the card before the first and between further blocks, in nanoseconds: SD cards allow up to 100 ms,
/// good ones take some hundred microseconds for the first.
const FIRST_BLOCK_NS: u64 = 200_000;
const NEXT_BLOCK_NS: u64 = 5_000;

/// A transfer on the data lines.
#[derive(Clone, Debug)]
enum Data {
    Idle,
    /// Enabled; the card has not been told yet, or has nothing to say (until DTIMER runs out).
    Waiting {
        event: Option<EventId>,
    },
    /// Words of the present block come in.
    Receiving {
        event: EventId,
        block: VecDeque<u32>,
    },
    /// Words of the present block go out; it is sent once whole.
    Sending {
        event: EventId,
        block: Vec<u8>,
    },
    /// The card programs the last block.
    Busy {
        event: EventId,
    },
}

/// A command on the command line.
#[derive(Clone, Copy, Debug)]
struct Command {
    event: EventId,
    register: u64,
    argument: u32,
}

/// The controller with the slot.
#[derive(Debug)]
pub struct Sdmmc {
    card: Option<SdCard>,
    kernel_hz: u64,
    command: Option<Command>,
    /// End of the busy signal after a response, for BUSYD0END.
    busy: Option<EventId>,
    data: Data,
    transfer: Transfer,
    fifo: VecDeque<u32>,
    status: u64,
    remaining: u64,
    dma_address: u64,
    dma_room: u64,
    raised: bool,
}

impl Sdmmc {
    /// The controller with this card in its slot, or an empty slot.
    #[must_use]
    pub fn new(card: Option<SdCard>) -> Self {
        Self {
            card,
            // Reset state of the kernel multiplexer: PLL1_Q, which does not run yet.
            kernel_hz: 0,
            command: None,
            busy: None,
            data: Data::Idle,
            transfer: Transfer::None,
            fifo: VecDeque::new(),
            status: 0,
            remaining: 0,
            dma_address: 0,
            dma_room: 0,
            raised: false,
        }
    }

    /// The card in the slot.
    #[must_use]
    pub const fn card(&self) -> Option<&SdCard> {
        self.card.as_ref()
    }

    /// Puts a card into the slot, or takes it out.
    pub fn insert(&mut self, card: Option<SdCard>) {
        self.card = card;
    }

    /// Time of this many clocks of the bus, nanoseconds.
    fn clocks(&self, count: u64, file: &RegisterFile) -> u64 {
        let divider = (file.get(Register::Clkcr) & 0x3FF) * 2;
        let hz = (self.kernel_hz.max(1) / divider.max(1)).max(1);
        count * 1_000_000_000 / hz
    }

    /// Time of a whole block on the data lines: start bit, data, checksum, end bit.
    fn block_ns(&self, bytes: u64, file: &RegisterFile) -> u64 {
        let lines = match file.get(Register::Clkcr) >> 14 & 3 {
            0 => 1,
            1 => 4,
            _ => 8,
        };
        self.clocks(bytes * 8 / lines + 18, file)
    }

    fn block_bytes(file: &RegisterFile) -> u64 {
        1 << (file.get(Register::Dctrl) >> 4 & 0xF)
    }

    fn dma(file: &RegisterFile) -> bool {
        file.get(Register::Idmactrlr) & IDMAEN != 0
    }

    fn send_command(&mut self, register: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        // Power on and a running clock are what puts bits on the line.
        if file.get(Register::Power) & 3 != 3 || self.kernel_hz == 0 {
            context.tell("CMDR", "RM0399 SDMMC: a command with the card's power off or without a kernel clock");
            return;
        }
        let long = register >> 8 & 3 == 3;
        let answered = register >> 8 & 3 != 0;
        let clocks = 48
            + if long {
                136
            } else if answered {
                48
            } else {
                0
            };
        let event = context.schedule(VirtualNanos(context.now().0 + self.clocks(clocks, file)));
        self.command = Some(Command { event, register, argument: file.get(Register::Argr) as u32 });
        if register & CMDTRANS != 0 {
            self.enable_data(file, context);
        }
    }

    fn finish_command(&mut self, command: Command, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.command = None;
        file.set(Register::Cmdr, command.register & !CPSMEN);
        let now = context.now();
        let index = (command.register & 0x3F) as u8;
        let (reply, transfer) = match &mut self.card {
            Some(card) => card.command(now.0, index, command.argument),
            None => (Reply::None, Transfer::None),
        };
        self.respond(command.register, index, reply, file);
        if command.register & CMDSTOP != 0 && !matches!(self.data, Data::Idle | Data::Busy { .. }) {
            self.data = Data::Idle;
            self.transfer = Transfer::None;
            self.status |= flag::DABORT;
        }
        if transfer != Transfer::None {
            self.transfer = transfer;
            self.follow_data(file, context);
        }
        let busy_until = self.card.as_ref().map_or(0, SdCard::busy_until_ns);
        if reply != Reply::None && busy_until > now.0 && transfer == Transfer::None && index != 13 {
            self.busy = Some(context.schedule(VirtualNanos(busy_until)));
        }
    }

    fn respond(&mut self, register: u64, index: u8, reply: Reply, file: &mut RegisterFile) {
        let wait = register >> 8 & 3;
        if wait == 0 {
            self.status |= flag::CMDSENT;
            return;
        }
        let (words, checked) = match reply {
            Reply::None => {
                // The time of the expected response has passed by now, and so has the timeout of 64 clocks, section
                // 58.5.4.
                self.status |= flag::CTIMEOUT;
                return;
            }
            Reply::Short(word) => ([word, 0, 0, 0], true),
            // R3 has no checksum: an error for a controller asked to check one.
            Reply::Unchecked(word) => ([word, 0, 0, 0], wait == 2),
            Reply::Long(words) => (words, true),
        };
        let registers = [Register::Resp1r, Register::Resp2r, Register::Resp3r, Register::Resp4r];
        for (register, word) in registers.into_iter().zip(words) {
            file.set(register, u64::from(word));
        }
        let shown = if matches!(reply, Reply::Short(_)) { u64::from(index) } else { 0x3F };
        file.set(Register::Respcmdr, shown);
        self.status |= if checked { flag::CMDREND } else { flag::CCRCFAIL };
    }

    /// The state flags of STAR, which follow the FIFO and the two state machines.
    fn live_flags(&self, now: VirtualNanos, file: &RegisterFile) -> u64 {
        let receiving = file.get(Register::Dctrl) & DTDIR != 0;
        let sending = matches!(self.data, Data::Sending { .. });
        let count = self.fifo.len();
        let busy = self.card.as_ref().is_some_and(|card| card.busy_until_ns() > now.0);
        let list = [
            (flag::CPSMACT, self.command.is_some()),
            (flag::DPSMACT, !matches!(self.data, Data::Idle)),
            (flag::BUSYD0, busy),
            (flag::RXFIFOHF, receiving && count >= HALF_FIFO),
            (flag::RXFIFOF, receiving && count == FIFO_WORDS),
            (flag::RXFIFOE, !receiving || count == 0),
            (flag::TXFIFOHE, sending && count <= HALF_FIFO),
            (flag::TXFIFOF, sending && count == FIFO_WORDS),
            (flag::TXFIFOE, !sending || count == 0),
        ];
        list.into_iter().filter(|&(_, set)| set).fold(0, |word, (bit, _)| word | bit)
    }

    fn refresh(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let shown = self.status | self.live_flags(context.now(), file);
        file.set(Register::Star, shown);
        file.set(Register::Dcntr, self.remaining);
        let raised = shown & file.get(Register::Maskr) != 0;
        if raised != self.raised {
            self.raised = raised;
            context.interrupt(0, Level::from(raised));
        }
    }
}

impl Device for Sdmmc {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        let value = match register {
            Register::Fifor => Some(u64::from(self.fifo.pop_front().unwrap_or(0))),
            _ => None,
        };
        self.refresh(file, context);
        value
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        match register {
            Register::Cmdr if value & CPSMEN != 0 && self.command.is_none() => self.send_command(value, file, context),
            Register::Dctrl => {
                if value & FIFORST != 0 {
                    self.fifo.clear();
                    file.set(Register::Dctrl, value & !FIFORST);
                }
                if value & DTEN != 0 && matches!(self.data, Data::Idle) {
                    self.enable_data(file, context);
                }
            }
            Register::Icr => {
                self.status &= !(value & flag::CLEARABLE);
                file.set(Register::Icr, 0);
            }
            Register::Fifor if self.fifo.len() < FIFO_WORDS => self.fifo.push_back(value as u32),
            _ => {}
        }
        self.refresh(file, context);
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(command) = self.command
            && command.event == event
        {
            self.finish_command(command, file, context);
        } else if self.busy == Some(event) {
            self.busy = None;
            self.status |= flag::BUSYD0END;
        } else {
            match std::mem::replace(&mut self.data, Data::Idle) {
                Data::Waiting { event: Some(mine) } if mine == event => {
                    self.status |= flag::DTIMEOUT;
                    self.end_data(file);
                }
                Data::Receiving { event: mine, block } if mine == event => self.receive(block, file, context),
                Data::Sending { event: mine, block } if mine == event => self.send(block, file, context),
                Data::Busy { event: mine } if mine == event => self.sent(file, context),
                other => self.data = other,
            }
        }
        self.refresh(file, context);
    }

    fn on_access(&mut self, _token: u64, value: u64, file: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if let Data::Sending { block, .. } = &mut self.data
            && Self::dma(file)
            && file.get(Register::Dctrl) & DTDIR == 0
        {
            block.extend((value as u32).to_le_bytes());
        }
    }

    /// The internal DMA met an address it does not reach (the TCMs, for one).
    fn on_refused(&mut self, _token: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.status |= flag::IDMATE;
        self.end_data(file);
        self.refresh(file, context);
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.kernel_hz = hz;
    }

    fn reset(&mut self) {
        let kernel_hz = self.kernel_hz;
        *self = Self { kernel_hz, ..Self::new(self.card.take()) };
    }
}
