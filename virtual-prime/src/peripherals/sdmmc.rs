//! SDMMC1, RM0399 rev 4 chapter 58 ("SDMMC"): the host controller of the SD card, with its FIFO and internal
//! DMA.
//!
//! The card is `sim`'s. Everything takes its time on the bus: the kernel clock over CLKDIV, 48 or 136 bits on
//! CMD, one or four data lines. Through the FIFO a word comes or goes every 32 / lines clocks; with the
//! internal DMA a block moves at its end, since nobody sees its words on the way.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | PWRCTRL = 11 stays until the block is reset by RCC | 58.10.1: "any further write is ignored" |
//! | no command in the first 74 clocks after power-on | 58.10.1 |
//! | flags of the FIFO only while the data path is active | 58.5.5, FIFO; 58.10.14 resets to zero |
//! | DATAEND once the receive FIFO is empty | 58.5.5, Wait_R with DATACOUNT = 0 |
//! | an error leaves the data path active until CMD12 with CMDSTOP, or reset | 58.5.5; others' drivers |
//! | a command goes out while DTEN is set, and is a complaint | others' drivers, against 58.10.4 |
//! | BUSYD0 is sampled at the end of a response and follows the line from then on | 58.10.14 |
//! | a bus faster than the card may have it damages all data: a complaint | SD PL 6.00, 6.6.6 and 6.6.7 |
//! | registers of the data path keep their values while it is active | 58.10.2 to 58.10.20, each field |
//!
//! Left out: boot mode, SDIO (interrupts, read wait, suspend), voltage switching, and the data transfer modes
//! other than the block mode. FIFOR answers at its first address alone.

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::stm32h743::generated::sdmmc1::Register;
use rigless::time::EventId;

use super::sdmmc_flags as flag;

mod command;
mod idma;
mod receive;
mod send;
mod state;

pub use state::Sdmmc;
use state::{DTEN, Data, FIFO_WORDS, FIFORST, LOCKED, POWER_ON, POWER_UP_CLOCKS};

#[cfg(test)]
mod tests;

impl Sdmmc {
    fn refresh(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let shown = self.status | self.live_flags(file);
        file.set(Register::Star, shown);
        file.set(Register::Dcntr, self.remaining);
        let raised = shown & file.get(Register::Maskr) != 0;
        if raised != self.raised {
            self.raised = raised;
            context.interrupt(0, Level::from(raised));
        }
    }

    fn write_power(&mut self, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        // Value 01 is reserved and changes nothing; 11 stays until a reset.
        if self.power & POWER_ON == POWER_ON || value & POWER_ON == 0b01 {
            file.set(Register::Power, value & !POWER_ON | self.power & POWER_ON);
        } else if value & POWER_ON == POWER_ON {
            self.powered_ns = context.now().0.saturating_add(self.clocks(POWER_UP_CLOCKS, file));
        }
        self.power = file.get(Register::Power);
    }

    fn write_data_control(&mut self, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.active() {
            if value & FIFORST != 0 && matches!(self.data, Data::Failed) && !Self::dma(file) {
                self.fifo.clear();
            }
        } else {
            file.set(Register::Dctrl, value & !FIFORST);
            self.keep(file);
            if value & DTEN != 0 {
                self.enable_data(file, context);
            }
        }
    }

    /// Whether words can move between firmware and the FIFO: only while the data path is active and the DMA
    /// is off.
    fn fifo_open(&self, file: &RegisterFile, from_card: bool) -> bool {
        self.active() && !Self::dma(file) && Self::from_card(file) == from_card
    }
}

impl Device for Sdmmc {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        if register != Register::Fifor {
            return None;
        }
        if !self.fifo_open(file, true) {
            return Some(0);
        }
        let word = self.read_fifo(file, context);
        self.refresh(file, context);
        Some(word)
    }

    fn steady(&self, register: Register, _: &RegisterFile) -> bool {
        register != Register::Fifor
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(place) = LOCKED.iter().position(|&locked| locked == register) {
            if self.active() {
                file.set(register, self.kept[place]);
            } else {
                self.kept[place] = file.get(register);
            }
        }
        match register {
            Register::Power => self.write_power(value, file, context),
            Register::Cmdr => self.write_command(value, file, context),
            Register::Dctrl => self.write_data_control(value, file, context),
            Register::Icr => {
                self.status &= !(value & flag::CLEARABLE);
                file.set(Register::Icr, 0);
            }
            Register::Fifor if self.fifo_open(file, false) && self.fifo.len() < FIFO_WORDS => {
                self.fifo.push_back(value as u32);
                self.word_in_fifo(file, context);
            }
            _ => {}
        }
        self.refresh(file, context);
    }

    /// Handles an event. Two ends at the same instant share an event, so each part checks for its own.
    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.command.as_ref().is_some_and(|command| command.event == event) {
            self.advance_command(file, context);
        }
        if self.busy_timeout == Some(event) {
            self.busy_timeout = None;
            if self.busy != Some(event) {
                self.status |= flag::DTIMEOUT;
            }
        }
        if self.busy == Some(event) {
            self.busy = None;
            self.busy_timeout = None;
            self.status |= flag::BUSYD0END;
        }
        match std::mem::replace(&mut self.data, Data::Failed) {
            Data::WaitReceive { timeout, start } => self.wait_is_over(event, timeout, start, file, context),
            Data::Receive(incoming) => self.receive(event, incoming, file, context),
            Data::Send(outgoing) => self.send(event, outgoing, file, context),
            Data::Busy { ready, timeout } => self.busy_is_over(event, ready, timeout, file, context),
            other => self.data = other,
        }
        self.refresh(file, context);
    }

    fn on_access(&mut self, token: u64, value: u64, file: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if let Data::Send(outgoing) = &mut self.data
            && Self::dma(file)
            && token == idma::FETCH
        {
            outgoing.fetched(value as u32);
        }
    }

    /// Handles a DMA access to an address that does not answer.
    fn on_refused(&mut self, _token: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.fail(flag::IDMATE);
        self.refresh(file, context);
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.kernel_hz = hz;
    }

    /// Resets the block, with the part or by RCC. The card has its own supply and notices nothing.
    fn reset(&mut self) {
        let kernel_hz = self.kernel_hz;
        *self = Self { kernel_hz, ..Self::new(self.card.take()) };
    }
}
