//! The SDMMC1 controller: one command with its response, one data transfer by IDMA (RM0399 chapter 58).

use stm32h7xx_hal::pac;

use super::SdError;
use crate::clocks::SDMMC_KERNEL_HZ;
use crate::pins::{self, Mode, PinName, Pull, Speed};
use crate::{clocks, wait};

/// Bus clock while a card is identified: at most 400 kHz (SD physical layer 9.0, section 4.2.1).
const IDENTIFY_HZ: u32 = 400_000;
/// Bus clock afterwards: default speed (section 6.6.1).
const TRANSFER_HZ: u32 = 25_000_000;
/// A command and its response are 184 bit times at most, 460 us while identifying; the controller itself
/// gives up after 64 clocks.
const COMMAND_LIMIT_US: u32 = 10_000;
/// A card may take 100 ms to the first byte of a read, 500 ms to finish a write (section 4.6.2).
const DATA_LIMIT_US: u32 = 600_000;

/// Power-cycle and power-off take a millisecond at least (RM0399 chapter 58, power-up sequence).
const POWER_STATE_US: u32 = 1_000;
/// Longer than the 74 clocks a card wants before its first command (SD physical layer 9.0, section 6.4.1):
/// 185 us at 400 kHz. It has had its supply for long.
const FIRST_CLOCKS_US: u32 = 250;

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
    /// Everything that can be cleared.
    pub const ALL: u32 = 0x1FE0_0FFF;
    pub const COMMAND_OVER: u32 = CCRCFAIL | CTIMEOUT | CMDREND | CMDSENT;
    pub const DATA_OVER: u32 = DCRCFAIL | DTIMEOUT | TXUNDERR | RXOVERR | DATAEND | DABORT | IDMATE;
}

/// Values of PWRCTRL (RM0399 section 58.10.1).
#[derive(Clone, Copy)]
enum PowerState {
    /// Clock stopped, lines high.
    Off = 0b00,
    /// Clock stopped, lines low.
    Cycle = 0b10,
    /// The card is clocked.
    On = 0b11,
}

/// What a command answers with.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    None,
    /// 48 bits with a checksum (R1, R6, R7).
    Short,
    /// 48 bits without (R3).
    ShortUnchecked,
    /// 136 bits (R2).
    Long,
}

/// Which way data goes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Transfer {
    FromCard,
    ToCard,
}

pub(super) struct Controller {
    registers: pac::SDMMC1,
}

/// Interrupt of the controller: its flags are for the sleeper to look at; here they are only kept from
/// interrupting again.
pub fn on_interrupt() {
    // SAFETY: the mask register is written with zero here and set up again by the sleeping side before each
    // wait.
    unsafe { (*pac::SDMMC1::ptr()).maskr.write(|w| w.bits(0)) };
}

/// Every register of the block to its reset value.
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
        Self { registers }
    }

    /// Powers the card interface and clocks it for identification, one bit wide. For every card anew,
    /// whatever the interface did before.
    ///
    /// RM0399 section 58.10.1, SDMMC_POWER: once the interface is on, writes to PWRCTRL are ignored, so only
    /// a reset of the whole block brings the states before it back. The manual's order is reset, power-cycle
    /// (lines low, so that the card is not fed through them), power-off (lines high), each a millisecond at
    /// least, then on: the card gets its 74 clocks before the first command.
    pub(super) fn power_up(&mut self) {
        reset_block();
        self.set_power(PowerState::Cycle);
        wait::pause(POWER_STATE_US);
        self.set_power(PowerState::Off);
        wait::pause(POWER_STATE_US);
        self.set_clock(IDENTIFY_HZ, false);
        self.set_power(PowerState::On);
        wait::pause(FIRST_CLOCKS_US);
    }

    fn set_power(&mut self, state: PowerState) {
        // SAFETY: the three states are the field's values that mean something; all else in the register stays
        // at its reset value.
        self.registers.power.write(|w| unsafe { w.pwrctrl().bits(state as u8) });
    }

    /// Full speed, four bits.
    pub(super) fn speed_up(&mut self) {
        self.set_clock(TRANSFER_HZ, true);
    }

    fn set_clock(&mut self, rate_hz: u32, four_bits: bool) {
        // RM0399 section 58.10.2: the bus clock is the kernel's divided by twice CLKDIV. Flow control stops
        // the clock when the FIFO is not served in time.
        let divider = SDMMC_KERNEL_HZ.div_ceil(2 * rate_hz) as u16;
        self.registers.clkcr.write(|w| {
            // SAFETY: the divider is 4 or 250 (of 1023), WIDBUS = 1 is four bits.
            unsafe { w.clkdiv().bits(divider).widbus().bits(u8::from(four_bits)).hwfc_en().set_bit() }
        });
    }

    /// Sends a command and waits for its answer.
    pub(super) fn command(&mut self, index: u8, argument: u32, answer: Answer) -> Result<(), SdError> {
        self.issue(index, argument, answer, 0);
        self.finish_command(index)
    }

    /// The short answer of the last command, or the first word of a long one.
    pub(super) fn response(&self) -> u32 {
        self.registers.resp1r.read().bits()
    }

    /// The long answer of the last command, most significant word first.
    pub(super) fn long_response(&self) -> [u32; 4] {
        let sd = &self.registers;
        [sd.resp1r.read().bits(), sd.resp2r.read().bits(), sd.resp3r.read().bits(), sd.resp4r.read().bits()]
    }

    fn issue(&mut self, index: u8, argument: u32, answer: Answer, extra: u32) {
        /// CMDR: CPSMEN.
        const START: u32 = 1 << 12;
        let wait_response = match answer {
            Answer::None => 0b00,
            Answer::Short => 0b01,
            Answer::ShortUnchecked => 0b10,
            Answer::Long => 0b11,
        };
        let sd = &self.registers;
        // SAFETY: writing ones clears flags; any argument is valid; the command word is put together from the
        // fields of RM0399 section 58.10.4.
        unsafe {
            sd.icr.write(|w| w.bits(flag::ALL));
            sd.argr.write(|w| w.bits(argument));
            sd.cmdr.write(|w| w.bits(u32::from(index) | wait_response << 8 | START | extra));
        }
    }

    fn finish_command(&mut self, index: u8) -> Result<(), SdError> {
        let status = self.sleep_until(flag::COMMAND_OVER, COMMAND_LIMIT_US).ok_or(SdError::NotResponding(index))?;
        if status & flag::CTIMEOUT != 0 {
            Err(SdError::NotResponding(index))
        } else if status & flag::CCRCFAIL != 0 {
            Err(SdError::Damaged(index))
        } else {
            Ok(())
        }
    }

    /// Sends a data command and moves `bytes` (whole blocks of 512) between the card and `address`, which
    /// must be in the DMA arena.
    pub(super) fn transfer(
        &mut self,
        index: u8,
        argument: u32,
        direction: Transfer,
        address: u32,
        bytes: u32,
    ) -> Result<(), SdError> {
        /// CMDR: CMDTRANS, the data path starts with this command.
        const WITH_DATA: u32 = 1 << 6;
        /// DCTRL: blocks of 2^9 bytes; DTDIR is bit 1.
        const BLOCKS_OF_512: u32 = 9 << 4;
        let sd = &self.registers;
        let from_card = u32::from(direction == Transfer::FromCard);
        // SAFETY: lengths and the address are the caller's, which took the address from a buffer of that
        // length in the arena.
        unsafe {
            sd.dtimer.write(|w| w.bits(DATA_LIMIT_US * (TRANSFER_HZ / 1_000_000)));
            sd.dlenr.write(|w| w.bits(bytes));
            sd.dctrl.write(|w| w.bits(BLOCKS_OF_512 | from_card << 1));
            sd.idmabase0r.write(|w| w.bits(address));
        }
        sd.idmactrlr.write(|w| w.idmaen().set_bit());
        self.issue(index, argument, Answer::Short, WITH_DATA);
        let result = self.finish_command(index).and_then(|()| self.finish_data(index));
        let sd = &self.registers;
        sd.idmactrlr.reset();
        sd.dctrl.reset();
        result
    }

    fn finish_data(&mut self, index: u8) -> Result<(), SdError> {
        let status = self.sleep_until(flag::DATA_OVER, DATA_LIMIT_US).ok_or(SdError::NotResponding(index))?;
        if status & (flag::IDMATE | flag::TXUNDERR | flag::RXOVERR | flag::DABORT) != 0 {
            Err(SdError::Transfer)
        } else if status & flag::DCRCFAIL != 0 {
            Err(SdError::Damaged(index))
        } else if status & flag::DTIMEOUT != 0 {
            Err(SdError::NotResponding(index))
        } else {
            Ok(())
        }
    }

    /// Ends an open-ended transfer (CMD12) and empties the controller's FIFO if it was cut.
    pub(super) fn stop_transmission(&mut self) -> Result<(), SdError> {
        /// CMDR: CMDSTOP.
        const STOP: u32 = 1 << 7;
        self.issue(12, 0, Answer::Short, STOP);
        let result = self.finish_command(12);
        self.registers.dctrl.write(|w| w.fiforst().set_bit());
        self.registers.dctrl.reset();
        result
    }

    /// Waits while the card holds D0 low, which it does as long as it is programming.
    pub(super) fn wait_while_busy(&mut self, index: u8) -> Result<(), SdError> {
        let deadline = crate::time::now().0 + u64::from(DATA_LIMIT_US);
        while self.registers.star.read().bits() & flag::BUSYD0 != 0 {
            if crate::time::now().0 > deadline {
                return Err(SdError::NotResponding(index));
            }
            // The end of busy has its own flag; in doubt (it fell before the test above) the next tick wakes
            // us.
            let _ended_or_tick = self.sleep_until(flag::BUSYD0END, 1_000);
        }
        Ok(())
    }

    /// Sleeps until one of `flags` is up, and gives the status; `None` after `limit_us`.
    ///
    /// Interrupts are masked between the test and the sleep, so that the flag cannot slip through; WFI wakes
    /// on a masked interrupt all the same, and it is taken as soon as the mask is off again. Some periodic
    /// interrupt must run, for the limit to be noticed.
    fn sleep_until(&self, flags: u32, limit_us: u32) -> Option<u32> {
        let sd = &self.registers;
        let deadline = crate::time::now().0 + u64::from(limit_us);
        loop {
            // SAFETY: any set of flags may interrupt.
            let status = cortex_m::interrupt::free(|_| unsafe {
                sd.maskr.write(|w| w.bits(flags));
                let status = sd.star.read().bits();
                if status & flags == 0 {
                    cortex_m::asm::wfi();
                }
                sd.star.read().bits()
            });
            if status & flags != 0 {
                on_interrupt();
                return Some(status);
            }
            if crate::time::now().0 > deadline {
                on_interrupt();
                return None;
            }
        }
    }
}

const _: () =
    assert!(clocks::SDMMC_KERNEL_HZ / (2 * IDENTIFY_HZ) < 1024, "the identification clock must fit its divider");
