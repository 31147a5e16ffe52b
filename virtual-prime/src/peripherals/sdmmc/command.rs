//! The command path: a command, its response or the wait for one, and the busy signal after it, RM0399
//! section 58.5.4.

use rigless::device::{DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::sdmmc1::Register;
use rigless::time::VirtualNanos;
use sim::models::sd_card::{Reply, SdCard, Transfer};

use super::idma;
use super::state::{CMDSTOP, CMDTRANS, CPSMEN, Command, DTEN, DTMODE, Data, INDEX, POWER_ON, Sdmmc};
use crate::peripherals::sdmmc_flags as flag;

/// The fastest clock while cards are identified (SD PL 6.00 section 6.6.6).
const IDENTIFICATION_HZ: u64 = 400_000;
/// Lengths of a command and of a short response, and of a long response, bits.
const SHORT_BITS: u64 = 48;
const LONG_BITS: u64 = 136;
/// Clocks between a command and its response: 2 to 64 (SD specification, N_CR). Cards take few.
const RESPONSE_DELAY: u64 = 8;
/// Clocks after which a response is given up: "a fixed value of 64 SDMMC_CK".
const RESPONSE_TIMEOUT: u64 = 64;
/// Value of WAITRESP in CMDR for no response.
const NO_RESPONSE: u64 = 0;
/// Value of WAITRESP in CMDR for a long response.
const LONG_RESPONSE: u64 = 3;

impl Sdmmc {
    pub(super) fn write_command(&mut self, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if let Some(command) = &self.command {
            // No field of CMDR changes while a command is under way.
            file.set(Register::Cmdr, command.register);
            return;
        }
        if value & CPSMEN == 0 {
            return;
        }
        // Only power and a running clock put bits on the line.
        if self.power & POWER_ON != POWER_ON || self.kernel_hz == 0 {
            context.tell("CMDR", "RM0399 SDMMC: a command with the card's power off or without a kernel clock");
            return;
        }
        if file.get(Register::Dctrl) & DTEN != 0 {
            // Section 58.10.4 says that no command goes out then. On silicon commands do: the vendor's driver
            // reads the SCR, the SD status and CMD6's answer in that way.
            context.tell("DCTRL", "RM0399 SDMMC: DTEN is not for transfers that a command begins");
        }
        let now_ns = context.now().0;
        if now_ns < self.powered_ns {
            context.tell("CMDR", "RM0399 SDMMC: a command in the first 74 clocks after power-on");
        }
        // A question to a card that is gone may meet another card, which does not answer it.
        let identifies = matches!(value & INDEX, 0 | 2 | 3 | 8 | 41 | 55);
        let most_hz = self.card.as_ref().map_or(u64::MAX, SdCard::highest_hz);
        if self.hz(file) > most_hz && (identifies || most_hz > IDENTIFICATION_HZ) {
            context.tell(
                "CLKCR",
                match most_hz {
                    IDENTIFICATION_HZ => "SD PL 6.00 section 6.6.6: the card is identified with more than 400 kHz",
                    25_000_000 => "SD PL 6.00 section 6.6.6: more than 25 MHz, and high speed was not set",
                    _ => "SD PL 6.00 section 6.6.7: more than 50 MHz",
                },
            );
        }
        let sent_ns = now_ns.max(self.powered_ns) + self.clocks(SHORT_BITS, file);
        let event = context.schedule(VirtualNanos(sent_ns));
        let argument = file.get(Register::Argr) as u32;
        self.command = Some(Command { event, register: value, argument, heard: None });
        if value & CMDTRANS != 0 && !self.active() {
            self.enable_data(file, context);
        }
    }

    /// Ends the command, or its response.
    pub(super) fn advance_command(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let Some(mut command) = self.command.take() else { return };
        let Some((reply, transfer)) = command.heard else {
            let answer = match &mut self.card {
                Some(card) => card.command(context.now().0, command.index(), command.argument),
                None => (Reply::None, Transfer::None),
            };
            if command.awaits() == NO_RESPONSE {
                self.finish_command(command, answer.0, answer.1, file, context);
                return;
            }
            let length = if command.awaits() == LONG_RESPONSE { LONG_BITS } else { SHORT_BITS };
            let clocks = if answer.0 == Reply::None { RESPONSE_TIMEOUT } else { RESPONSE_DELAY + length };
            command.event = self.schedule_clocks(clocks, file, context);
            command.heard = Some(answer);
            self.command = Some(command);
            return;
        };
        self.finish_command(command, reply, transfer, file, context);
    }

    /// Enables the data path, which leaves Idle: by a command with CMDTRANS, or by DTEN.
    pub(super) fn enable_data(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if file.get(Register::Dctrl) & DTMODE != 0 {
            context.tell("DCTRL", "a data transfer mode other than the block mode has no model");
        }
        let block = Self::block_bytes(file);
        self.remaining = (file.get(Register::Dlenr) & 0x1FF_FFFF) / block * block;
        self.fifo.clear();
        self.overdrawn = 0;
        self.dma_address = file.get(Register::Idmabase0r);
        self.dma_room = idma::buffer_bytes(file);
        if self.remaining == 0 {
            self.complete(file);
        } else if Self::from_card(file) {
            self.wait_receive(None, file, context);
        } else {
            self.data = Data::WaitSend;
            self.follow_send(file, context);
        }
    }

    fn finish_command(
        &mut self,
        command: Command,
        reply: Reply,
        transfer: Transfer,
        file: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        file.set(Register::Cmdr, command.register & !CPSMEN);
        self.respond(&command, reply, file);
        if command.register & CMDSTOP != 0 && self.active() {
            self.idle(file);
            self.status |= flag::DABORT;
        }
        if transfer != Transfer::None {
            self.transfer = transfer;
            self.follow_receive(file, context);
            self.follow_send(file, context);
        }
        self.sample_busy(reply, file, context);
    }

    fn respond(&mut self, command: &Command, reply: Reply, file: &mut RegisterFile) {
        if command.awaits() == NO_RESPONSE {
            self.status |= flag::CMDSENT;
            return;
        }
        let (words, checked) = match reply {
            Reply::None => {
                self.status |= flag::CTIMEOUT;
                return;
            }
            Reply::Damaged => ([0; 4], false),
            Reply::Short(word) => ([word, 0, 0, 0], true),
            // A response R3 has no checksum, which is an error for a controller asked to check one.
            Reply::Unchecked(word) => ([word, 0, 0, 0], command.awaits() == 2),
            Reply::Long(words) => (words, true),
        };
        let registers = [Register::Resp1r, Register::Resp2r, Register::Resp3r, Register::Resp4r];
        for (register, word) in registers.into_iter().zip(words) {
            file.set(register, u64::from(word));
        }
        let shown = if matches!(reply, Reply::Short(_)) { u64::from(command.index()) } else { 0x3F };
        file.set(Register::Respcmdr, shown);
        self.status |= if checked { flag::CMDREND } else { flag::CCRCFAIL };
    }

    /// Samples D0 after a response. Low means busy, unless the data path keeps the card busy.
    fn sample_busy(&mut self, reply: Reply, file: &RegisterFile, context: &mut DeviceContext<'_>) {
        let until = self.card.as_ref().map_or(0, SdCard::busy_until_ns);
        if reply == Reply::None || until <= context.now().0 || matches!(self.data, Data::Busy { .. }) {
            return;
        }
        self.busy = Some(context.schedule(VirtualNanos(until)));
        self.busy_timeout = Some(self.schedule_timeout(file, context));
    }
}
