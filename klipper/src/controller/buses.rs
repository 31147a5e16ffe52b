//! Commands of chips on a bus.

use super::job::{Job, Work};
use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::{Board, Pull, SpiSettings};
use crate::objects::Object;
use crate::objects::i2c::I2c;
use crate::objects::lights::Lights;
use crate::objects::soft_spi::SoftSpi;
use crate::objects::spi::{Bytes, Chip, LastWords, SpiDevice};
use crate::objects::tmc_uart::{Next, TmcUart};
use crate::reason::Reason;
use crate::table::Response;

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
        device.chip = Some(Chip::OnBus(self.board.spi(settings)?));
        device.is_set = true;
        Ok(())
    }

    pub(super) fn spi_set_sw_bus(&mut self, args: &Args<'_>) -> Outcome {
        let device = object!(self, args.oid(), Spi);
        if device.is_set || args.at(4) > 3 {
            return Err(Reason::InvalidSpi);
        }
        let mode = args.at(4) as u8;
        let select = match device.select {
            Some((pin, is_high)) => Some((self.board.output(pin, !is_high).ok_or(Reason::NotAPin)?, is_high)),
            None => None,
        };
        device.chip = Some(Chip::AtPins(SoftSpi {
            select,
            from_chip: self.board.input(args.at(1), Pull::Up).ok_or(Reason::NotAPin)?,
            to_chip: self.board.output(args.at(2), false).ok_or(Reason::NotAPin)?,
            clock: self.board.output(args.at(3), mode & 2 != 0).ok_or(Reason::NotAPin)?,
            mode,
            pulse_ticks: args.at(5),
        }));
        device.is_set = true;
        Ok(())
    }

    /// Has bytes exchanged; a chip whose bus is not set gets none.
    pub(super) fn spi_exchange(&mut self, args: &Args<'_>, answers: bool) -> Outcome {
        let device = object!(self, args.oid(), Spi);
        let Some(chip) = device.chip.take() else { return Ok(()) };
        let bytes = Bytes::from_slice(args.bytes).unwrap_or_default();
        self.job = Some(Job { oid: args.oid(), work: Work::Spi { chip, bytes, answers } });
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
        let job = self.job.take().or_else(|| self.last_words()).or_else(|| self.next_measurement())?;
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
                return Some(Job { oid, work: Work::Spi { chip, bytes, answers: false } });
            }
        }
        None
    }

    pub(super) fn i2c_set_sw_bus(&mut self, args: &Args<'_>) -> Outcome {
        let device = object!(self, args.oid(), I2c);
        let mut wire = |pin| self.board.wire(pin, Pull::Up).ok_or(Reason::NotAPin);
        let (clock, data) = (wire(args.at(1))?, wire(args.at(2))?);
        *device = Some(I2c { clock, data, pulse_ticks: args.at(3), address: args.at(4) as u8 & 0x7F });
        Ok(())
    }

    /// Has bytes written and read; a chip whose pins are not set gets none.
    pub(super) fn i2c_transfer(&mut self, args: &Args<'_>) -> Outcome {
        let Some(chip) = object!(self, args.oid(), I2c).take() else { return Ok(()) };
        let write = Bytes::from_slice(args.bytes).unwrap_or_default();
        let read_length = args.at(2) as usize;
        let work = Work::I2c { chip, write, read_length, outcome: Ok(Bytes::new()) };
        self.job = Some(Job { oid: args.oid(), work });
        Ok(())
    }

    pub(super) fn config_tmcuart(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let (rx_pin, tx_pin) = (args.at(1), args.at(3));
        let pull = if args.at(2) != 0 { Pull::Up } else { Pull::None };
        let line = self.board.wire(rx_pin, pull).ok_or(Reason::NotAPin)?;
        let transmitter = match tx_pin {
            pin if pin == rx_pin => None,
            pin => Some(self.board.wire(pin, Pull::Up).ok_or(Reason::NotAPin)?),
        };
        self.configure(args.oid(), Object::TmcUart(TmcUart::new(line, transmitter, args.at(4))))
    }

    pub(super) fn tmcuart_send(&mut self, args: &Args<'_>) -> Outcome {
        let now = self.board.clock();
        let due = object!(self, args.oid(), TmcUart).send(args.bytes, args.at(2), now)?;
        if let Some(due) = due {
            self.timers.set(args.oid(), due);
        }
        Ok(())
    }

    pub(super) fn look_at_tmcuart(&mut self, oid: u8, due: u32) -> Outcome {
        match object!(self, oid, TmcUart).on_timer(due) {
            Next::At(time) => self.timers.set(oid, time),
            Next::Answer(bits) => {
                self.out.send_bytes(Response::TmcuartAnswer, &[u32::from(oid)], Some(&bits));
            }
        }
        Ok(())
    }

    pub(super) fn config_neopixel(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let strip = self.board.strip(args.at(1))?;
        let number = self.strips.len();
        self.strips.push(Lights::new(strip, args.at(2))?).map_err(|_| Reason::TooManyLights)?;
        self.configure(args.oid(), Object::Lights(number as u8))
    }

    pub(super) fn neopixel_update(&mut self, args: &Args<'_>) -> Outcome {
        let number = *object!(self, args.oid(), Lights);
        let lights = self.strips.get_mut(usize::from(number)).ok_or(Reason::InvalidOid)?;
        lights.update(args.at(1), args.bytes)
    }

    pub(super) fn neopixel_send(&mut self, args: &Args<'_>) -> Outcome {
        let number = *object!(self, args.oid(), Lights);
        let lights = self.strips.get(usize::from(number)).ok_or(Reason::InvalidOid)?;
        let success = self.board.send_to_strip(lights.strip, &lights.bytes);
        self.out.send(Response::NeopixelResult, &[args.at(0), u32::from(success)]);
        Ok(())
    }
}
