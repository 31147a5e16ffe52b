//! Commands of chips on a bus.

use super::job::Job;
use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::{Board, SpiSettings};
use crate::objects::Object;
use crate::objects::spi::{Bytes, LastWords, SpiDevice};
use crate::reason::Reason;

impl<B: Board> Controller<B> {
    pub(super) fn config_spi(&mut self, oid: u8, select: Option<(u32, bool)>) -> Outcome {
        self.configure(oid, Object::Spi(SpiDevice::new(select)))
    }

    pub(super) fn spi_set_bus(&mut self, args: &Args<'_>) -> Outcome {
        let device = object!(self, args.oid(), Spi);
        if device.is_set || args.at(2) > 3 {
            return Err(Reason::InvalidSpi);
        }
        let settings = SpiSettings {
            select: device.select.map(|(pin, _)| pin),
            active_high: device.select.is_some_and(|(_, is_high)| is_high),
            bus: args.at(1),
            mode: args.at(2) as u8,
            rate_hz: args.at(3),
        };
        device.chip = Some(self.board.spi(settings)?);
        device.is_set = true;
        Ok(())
    }

    /// Has bytes exchanged; a chip whose bus is not set gets none.
    pub(super) fn spi_exchange(&mut self, args: &Args<'_>, answers: bool) -> Outcome {
        let device = object!(self, args.oid(), Spi);
        let Some(chip) = device.chip.take() else { return Ok(()) };
        let bytes = Bytes::from_slice(args.bytes).unwrap_or_default();
        self.job = Some(Job { oid: args.oid(), chip, bytes, answers });
        Ok(())
    }

    pub(super) fn config_spi_shutdown(&mut self, args: &Args<'_>) -> Outcome {
        let device = args.at(1) as u8;
        let _is_one = object!(self, device, Spi);
        let bytes = Bytes::from_slice(args.bytes).unwrap_or_default();
        self.configure(args.oid(), Object::SpiShutdown(LastWords { device, bytes }))
    }

    /// Takes what is to be done on a bus: what the host has asked for, or what a chip is told at a shutdown.
    pub fn take_job(&mut self) -> Option<Job<B>> {
        if self.job_is_out {
            return None;
        }
        let job = self.job.take().or_else(|| self.last_words())?;
        self.job_is_out = true;
        Some(job)
    }

    fn last_words(&mut self) -> Option<Job<B>> {
        self.shutdown?;
        for index in 0..self.objects.len() {
            let Some(Object::SpiShutdown(words)) = self.objects.get_mut(index) else { continue };
            if words.bytes.is_empty() {
                continue;
            }
            let (oid, bytes) = (words.device, core::mem::take(&mut words.bytes));
            if let Some(Object::Spi(device)) = self.objects.get_mut(usize::from(oid))
                && let Some(chip) = device.chip.take()
            {
                return Some(Job { oid, chip, bytes, answers: false });
            }
        }
        None
    }
}
