//! The SDMMC1 controller: one command with its answer, and data by IDMA (RM0399 chapter 58).

use card::sd::{Answer, Block, Command, Direction, Fault, Host, Place, Power, Progress, Transfer};
use stm32h7xx_hal::pac;

use super::{BLOCKS, WORDS};
use crate::clocks;
use crate::clocks::SDMMC_KERNEL_HZ;
use crate::pins::{self, Mode, PinName, Pull, Speed};

/// Limit of a read, ms. A card may take 100 ms to the first byte of a read, and 500 ms to finish a write (SD
/// physical layer 6.00, section 4.6.2); DTIMER gives it more, as some take more.
const READ_LIMIT_MS: u32 = 500;
const WRITE_LIMIT_MS: u32 = 1_000;
/// Slowest clock of the bus, Hz.
const SLOWEST_HZ: u32 = 400_000;

/// Status flags (RM0399 section 58.10.11, SDMMC_STAR).
mod flag {
    pub const CCRCFAIL: u32 = 1 << 0;
    pub const DCRCFAIL: u32 = 1 << 1;
    pub const CTIMEOUT: u32 = 1 << 2;
    pub const DTIMEOUT: u32 = 1 << 3;
    pub const TXUNDERR: u32 = 1 << 4;
    pub const RXOVERR: u32 = 1 << 5;
    pub const CMDREND: u32 = 1 << 6;
    pub const CMDSENT: u32 = 1 << 7;
    pub const DATAEND: u32 = 1 << 8;
    pub const DABORT: u32 = 1 << 11;
    pub const BUSYD0: u32 = 1 << 20;
    pub const BUSYD0END: u32 = 1 << 21;
    pub const IDMATE: u32 = 1 << 27;
    /// All flags that can be cleared.
    pub const ALL: u32 = 0x1FE0_0FFF;
    pub const COMMAND_OVER: u32 = CCRCFAIL | CTIMEOUT | CMDREND | CMDSENT;
    pub const DATA_OVER: u32 = DCRCFAIL | DTIMEOUT | TXUNDERR | RXOVERR | DATAEND | DABORT | IDMATE;
}

/// Controller with its last command and transfer.
pub struct Controller {
    registers: pac::SDMMC1,
    bus_hz: u32,
    /// The command has been answered.
    is_answered: bool,
    has_data: bool,
    stops: bool,
    progress: Progress,
}

/// Masks the controller's interrupt, whose flags are left to the code that advances the service.
pub fn on_interrupt() {
    // SAFETY: the mask register is written with zero here, and set up again by whoever waits for a flag,
    // which happens with the service locked: this interrupt is not among those that run meanwhile.
    unsafe { (*pac::SDMMC1::ptr()).maskr.write(|w| w.bits(0)) };
}

/// Resets every register of the block.
fn reset_block() {
    // RM0399 chapter 9, RCC_AHB3RSTR: SDMMC1RST.
    // SAFETY: this register is written here alone, by the one owner of the card.
    let reset = unsafe { &(*pac::RCC::ptr()).ahb3rstr };
    reset.modify(|_, w| w.sdmmc1rst().set_bit());
    // The read back makes sure that the pulse has reached the block before it ends.
    let _settled = reset.read().bits();
    reset.modify(|_, w| w.sdmmc1rst().clear_bit());
    let _settled = reset.read().bits();
}

impl Controller {
    pub(super) fn new(registers: pac::SDMMC1) -> Self {
        for (port, number) in [('C', 8), ('C', 9), ('C', 10), ('C', 11), ('D', 2)] {
            pins::configure(PinName::new(port, number), Mode::Alternate(12, Speed::High), Pull::Up, false);
        }
        pins::configure(PinName::new('C', 12), Mode::Alternate(12, Speed::High), Pull::Floating, false);
        let progress = Progress::Done;
        Self { registers, bus_hz: SLOWEST_HZ, is_answered: true, has_data: false, stops: false, progress }
    }

    /// Enables the interrupts of these flags, each once.
    fn listen(&self, flags: u32) {
        // SAFETY: any set of flags may interrupt.
        self.registers.maskr.write(|w| unsafe { w.bits(flags) });
    }

    fn prepare(&mut self, data: Transfer) {
        let address = match data.place {
            Place::Slot(slot) => BLOCKS.address().map_or(0, |first| first + (slot * WORDS * 4) as u32),
            Place::Address(address) => address,
        };
        let from_card = u32::from(data.direction == Direction::FromCard);
        let limit_ms = if from_card == 1 { READ_LIMIT_MS } else { WRITE_LIMIT_MS };
        // The core's writes to the buffer must reach memory before the controller reads it.
        cortex_m::asm::dsb();
        let sd = &self.registers;
        // DCTRL (RM0399 section 58.10.12): blocks of 2^DBLOCKSIZE bytes, DTDIR is bit 1.
        // SAFETY: lengths and the address are those of the service's own blocks, or of a buffer that its user
        // vouches for. An address of nothing is refused by the DMA (IDMATE), as memory ends below it.
        unsafe {
            sd.dtimer.write(|w| w.bits(self.bus_hz / 1_000 * limit_ms));
            sd.dlenr.write(|w| w.bits(data.blocks * u32::from(data.block_bytes)));
            sd.dctrl.write(|w| w.bits(data.block_bytes.trailing_zeros() << 4 | from_card << 1));
            sd.idmabase0r.write(|w| w.bits(address));
        }
        sd.idmactrlr.write(|w| w.idmaen().set_bit());
    }

    /// Returns the progress by the flags of the command, and then of the data.
    fn look(&mut self) -> Progress {
        let status = self.registers.star.read().bits();
        if !self.is_answered {
            if status & flag::COMMAND_OVER == 0 {
                self.listen(flag::COMMAND_OVER);
                return Progress::Busy;
            }
            if status & flag::CTIMEOUT != 0 {
                return Progress::Failed(Fault::NoAnswer);
            }
            if status & flag::CCRCFAIL != 0 {
                return Progress::Failed(Fault::AnswerDamaged);
            }
            self.is_answered = true;
        }
        if !self.has_data {
            return Progress::Done;
        }
        if status & flag::DATA_OVER == 0 {
            self.listen(flag::DATA_OVER);
            return Progress::Busy;
        }
        if status & (flag::IDMATE | flag::TXUNDERR | flag::RXOVERR | flag::DABORT) != 0 {
            Progress::Failed(Fault::Host)
        } else if status & flag::DCRCFAIL != 0 {
            Progress::Failed(Fault::DataDamaged)
        } else if status & flag::DTIMEOUT != 0 {
            Progress::Failed(Fault::TooLate)
        } else {
            Progress::Done
        }
    }
}

impl Host for Controller {
    /// RM0399 section 58.10.1, SDMMC_POWER: once the interface is on, writes to PWRCTRL are ignored, so only
    /// a reset of the whole block brings the states before it back.
    fn power(&mut self, state: Power) {
        let bits = match state {
            Power::Cycle => {
                reset_block();
                0b10
            }
            Power::Off => 0b00,
            Power::On => 0b11,
        };
        // SAFETY: the three states are the field's values that mean something; all else in the register stays
        // at its reset value.
        self.registers.power.write(|w| unsafe { w.pwrctrl().bits(bits) });
    }

    fn set_bus(&mut self, hz: u32, is_wide: bool) {
        self.bus_hz = hz.max(SLOWEST_HZ);
        // RM0399 section 58.10.2: the bus clock is the kernel's divided by twice CLKDIV. Flow control stops
        // the clock when the FIFO is not served in time. At 50 MHz the card takes what comes with the rising
        // edge, and the controller changes it 5 ns later, a clock of the kernel (NEGEDGE = 0): the card
        // wants 2 ns (SD physical layer 6.00, section 6.6.7).
        let divider = SDMMC_KERNEL_HZ.div_ceil(2 * self.bus_hz) as u16;
        self.registers.clkcr.write(|w| {
            // SAFETY: the divider is 2 to 250 (of 1023), WIDBUS = 1 is four bits.
            unsafe { w.clkdiv().bits(divider).widbus().bits(u8::from(is_wide)).hwfc_en().set_bit() }
        });
    }

    fn begin(&mut self, command: Command, data: Option<Transfer>) {
        /// CMDR (RM0399 section 58.10.4): CPSMEN, CMDTRANS (the data path starts with this command), CMDSTOP.
        const START: u32 = 1 << 12;
        const WITH_DATA: u32 = 1 << 6;
        const STOP: u32 = 1 << 7;
        (self.is_answered, self.has_data, self.progress) = (false, data.is_some(), Progress::Busy);
        self.stops = command.index == 12;
        let mut word = u32::from(command.index) | START;
        word |= match command.answer {
            Answer::None => 0b00,
            Answer::Short => 0b01,
            Answer::ShortUnchecked => 0b10,
            Answer::Long => 0b11,
        } << 8;
        if let Some(data) = data {
            self.prepare(data);
            word |= WITH_DATA;
        }
        if self.stops {
            word |= STOP;
        }
        let sd = &self.registers;
        // SAFETY: writing ones clears flags; any argument is valid; the command word is put together from its
        // fields above.
        unsafe {
            sd.icr.write(|w| w.bits(flag::ALL));
            sd.argr.write(|w| w.bits(command.argument));
            sd.cmdr.write(|w| w.bits(word));
        }
    }

    fn progress(&mut self) -> Progress {
        if self.progress != Progress::Busy {
            return self.progress;
        }
        self.progress = self.look();
        if self.progress != Progress::Busy {
            let sd = &self.registers;
            if self.stops {
                // A transfer that was cut has left something in the FIFO.
                sd.dctrl.write(|w| w.fiforst().set_bit());
            }
            // While the data path is active, after an error, these writes have no effect: CMD12 ends that
            // state.
            sd.idmactrlr.reset();
            sd.dctrl.reset();
        }
        self.progress
    }

    fn answer(&self) -> [u32; 4] {
        let sd = &self.registers;
        [sd.resp1r.read().bits(), sd.resp2r.read().bits(), sd.resp3r.read().bits(), sd.resp4r.read().bits()]
    }

    fn is_held_busy(&mut self) -> bool {
        let is_busy = self.registers.star.read().bits() & flag::BUSYD0 != 0;
        if is_busy {
            self.listen(flag::BUSYD0END);
        }
        is_busy
    }

    fn load(&self, slot: usize, block: &mut Block) {
        // The slot belongs to the service, so the load is within the buffer.
        let _inside = BLOCKS.load(slot * WORDS, block);
    }

    fn store(&mut self, slot: usize, block: &Block) {
        let _inside = BLOCKS.store(slot * WORDS, block);
    }
}

const _: () = assert!(clocks::SDMMC_KERNEL_HZ / (2 * SLOWEST_HZ) < 1024, "the slowest clock must fit its divider");
