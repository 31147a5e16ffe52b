//! Identity, clock, configuration, shutdown: the commands of every controller.

use super::state::{Controller, Outcome};
use crate::args::Args;
use crate::board::Board;
use crate::dictionary::DICTIONARY;
use crate::moves::MOVES;
use crate::reason::Reason;
use crate::table::{Command, Response};
use crate::timers::MAX_OBJECTS;

impl<B: Board> Controller<B> {
    /// A host fetches the dictionary piece by piece; an empty piece is its end.
    pub(super) fn identify(&mut self, args: &Args<'_>) -> Outcome {
        let (offset, count) = (args.at(0), args.at(1) as u8);
        let rest = DICTIONARY.get(offset as usize..).unwrap_or(&[]);
        let part = &rest[..rest.len().min(usize::from(count))];
        self.out.send_bytes(Response::Identified, &[offset], Some(part));
        Ok(())
    }

    pub(super) fn get_uptime(&mut self) -> Outcome {
        // The turns are counted once a turn is over; a clock that has turned meanwhile is read once more.
        let (mut turns, mut clock) = (self.board.clock_turns(), self.board.clock());
        if self.board.clock_turns() != turns {
            (turns, clock) = (self.board.clock_turns(), self.board.clock());
        }
        self.out.send(Response::Uptime, &[turns, clock]);
        Ok(())
    }

    pub(super) fn get_clock(&mut self) -> Outcome {
        let clock = self.board.clock();
        self.out.send(Response::Clock, &[clock]);
        Ok(())
    }

    pub(super) fn get_config(&mut self) -> Outcome {
        let crc = self.configuration.crc;
        let state = [u32::from(crc.is_some()), crc.unwrap_or(0), u32::from(self.shutdown.is_some()), MOVES as u32];
        self.out.send(Response::Config, &state);
        Ok(())
    }

    pub(super) fn allocate_oids(&mut self, args: &Args<'_>) -> Outcome {
        if self.configuration.oids != 0 {
            return Err(Reason::OidsAllocated);
        }
        if args.at(0) as usize > MAX_OBJECTS {
            return Err(Reason::TooManyObjects);
        }
        self.configuration.oids = args.at(0) as u8;
        Ok(())
    }

    pub(super) fn finalize_config(&mut self, args: &Args<'_>) -> Outcome {
        if self.configuration.crc.is_some() {
            return Err(Reason::AlreadyFinalized);
        }
        self.configuration.crc = Some(args.at(0));
        self.board.begin();
        Ok(())
    }

    pub(super) fn clear_shutdown(&mut self) -> Outcome {
        if self.shutdown.take().is_none() {
            return Err(Reason::NotShutdown);
        }
        Ok(())
    }

    pub(super) fn reset(&mut self) -> Outcome {
        self.wants_reset = true;
        Ok(())
    }

    /// `debug_nop` is there to be counted.
    pub(super) fn debug(&mut self, command: Command, args: &Args<'_>) -> Outcome {
        match command {
            Command::DebugPing => self.debug_ping(args),
            Command::DebugRead => self.debug_read(args),
            _ => Ok(()),
        }
    }

    pub(super) fn debug_ping(&mut self, args: &Args<'_>) -> Outcome {
        self.out.send_bytes(Response::Pong, &[], Some(args.bytes));
        Ok(())
    }

    /// Reads a word of the factory's: a host asks for the calibration of the chip's temperature sensor.
    /// Nothing else can be read: reading a register may change it.
    pub(super) fn debug_read(&mut self, args: &Args<'_>) -> Outcome {
        let bytes = 1_u8.checked_shl(args.at(0)).filter(|bytes| *bytes <= 4).ok_or(Reason::NotReadable)?;
        let value = self.board.read_factory(bytes, args.at(1)).ok_or(Reason::NotReadable)?;
        self.out.send(Response::DebugResult, &[value]);
        Ok(())
    }
}
