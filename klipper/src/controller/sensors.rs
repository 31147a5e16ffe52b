//! Commands that configure and read accelerometers.

use super::job::{Job, Work};
use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::Board;
use crate::objects::Object;
use crate::objects::accelerometer::{Accelerometer, Answer, Request};
use crate::table::Response;

impl<B: Board> Controller<B> {
    pub(super) fn config_adxl345(&mut self, args: &Args<'_>) -> Outcome {
        let device = args.at(1) as u8;
        let _is_one = object!(self, device, Spi);
        self.configure(args.oid(), Object::Accelerometer(Accelerometer::new(device)))
    }

    pub(super) fn query_adxl345(&mut self, args: &Args<'_>) -> Outcome {
        let now = self.board.clock();
        let due = object!(self, args.oid(), Accelerometer).begin(args.at(1), now);
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    /// Asks the chip at once: the host waits for the answer.
    pub(super) fn query_adxl345_status(&mut self, args: &Args<'_>) -> Outcome {
        let device = object!(self, args.oid(), Accelerometer).device;
        self.job = self.measuring(args.oid(), device, Request::Status);
        Ok(())
    }

    /// Has the chip asked as soon as its bus is free.
    pub(super) fn look_at_accelerometer(&mut self, oid: u8) -> Outcome {
        object!(self, oid, Accelerometer).want(Request::Sample);
        self.wants_measurement = true;
        Ok(())
    }

    fn measuring(&mut self, oid: u8, device: u8, request: Request) -> Option<Job<B>> {
        let Some(Object::Spi(spi)) = self.objects.get_mut(usize::from(device)) else { return None };
        let chip = spi.chip.take()?;
        Some(Job { oid, work: Work::Accelerometer { chip, request, answer: None } })
    }

    /// Returns what an accelerometer is to be asked.
    pub(super) fn next_measurement(&mut self) -> Option<Job<B>> {
        if !self.wants_measurement {
            return None;
        }
        for oid in 0..self.objects.len() as u8 {
            if let Some(Object::Accelerometer(accelerometer)) = self.objects.get_mut(usize::from(oid))
                && let Some(request) = accelerometer.take_request()
            {
                let device = accelerometer.device;
                return self.measuring(oid, device, request);
            }
        }
        self.wants_measurement = false;
        None
    }

    pub(super) fn take_measurement(&mut self, oid: u8, request: Request, answer: &Answer) {
        let now = self.board.clock();
        let Some(Object::Accelerometer(accelerometer)) = self.objects.get_mut(usize::from(oid)) else { return };
        match request {
            Request::Status => {
                let [clock, ticks, sequence, waiting, overflows] = accelerometer.state(answer);
                let state = [u32::from(oid), clock, ticks, sequence, waiting, overflows];
                self.out.send(Response::SensorBulkStatus, &state);
            }
            Request::Sample => {
                let (message, next) = accelerometer.take(answer, now);
                if let Some((number, samples)) = message {
                    let words = [u32::from(oid), u32::from(number)];
                    self.out.send_bytes(Response::SensorBulkData, &words, Some(&samples));
                }
                match next {
                    Some(next) => self.timers.set(oid, next),
                    None => self.wants_measurement = true,
                }
            }
        }
    }
}
