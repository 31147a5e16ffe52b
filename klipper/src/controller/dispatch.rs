//! Blocks of the host to commands.

use super::job::{Job, Work};
use super::state::{Controller, Outcome, Rest};
use crate::args::Args;
use crate::board::Board;
use crate::numbers::STATS_SUMSQ_BASE;
use crate::objects::Object;
use crate::objects::i2c::Status;
use crate::reason::Reason;
use crate::table::{Command, Response};
use crate::wire::Block;

impl Command {
    /// Whether the command is carried out while the board is shut down.
    pub(super) const fn is_for_shutdown(self) -> bool {
        matches!(
            self,
            Self::Identify
                | Self::GetUptime
                | Self::GetClock
                | Self::GetConfig
                | Self::EmergencyStop
                | Self::ClearShutdown
                | Self::Reset
                | Self::DebugNop
                | Self::DebugPing
                | Self::DebugRead
        )
    }
}

impl<B: Board> Controller<B> {
    /// Executes a block of the host. Only while [`Self::is_busy`] says no.
    pub fn receive(&mut self, block: &Block) {
        self.has_told_damage = false;
        self.heard_at = self.board.clock();
        if self.is_silent {
            self.is_silent = false;
            self.hold_heaters(false);
        }
        if block.sequence() != self.out.expected {
            return self.out.acknowledge();
        }
        self.out.expected = (self.out.expected + 1) & 0x0F;
        self.execute(block, 0);
    }

    /// Executes commands of a block, from byte `done` of its content on, up to one that needs a bus.
    fn execute(&mut self, block: &Block, done: usize) {
        let mut content = block.content().get(done..).unwrap_or(&[]);
        while !content.is_empty() {
            let Some((command, args, behind)) = Args::read(content) else {
                self.shut_down(Reason::ParserError);
                break;
            };
            content = behind;
            self.obey(command, &args);
            if self.job.is_some() {
                self.rest = Some(Rest { block: block.clone(), done: block.content().len() - content.len() });
                return;
            }
        }
        self.out.acknowledge();
    }

    fn obey(&mut self, command: Command, args: &Args<'_>) {
        if let Some(reason) = self.shutdown
            && !command.is_for_shutdown()
        {
            return self.out.send(Response::IsShutdown, &[u32::from(reason.number())]);
        }
        if let Err(reason) = self.carry_out(command, args) {
            self.shut_down(reason);
        }
    }

    pub(super) fn carry_out(&mut self, command: Command, args: &Args<'_>) -> Outcome {
        match command {
            Command::QueueStep => self.queue_step(args),
            Command::SetNextStepDir => self.set_next_step_dir(args),
            Command::QueueDigitalOut => self.queue_digital_out(args),
            Command::Identify => self.identify(args),
            Command::GetUptime => self.get_uptime(),
            Command::GetClock => self.get_clock(),
            Command::GetConfig => self.get_config(),
            Command::AllocateOids => self.allocate_oids(args),
            Command::FinalizeConfig => self.finalize_config(args),
            Command::EmergencyStop => Err(Reason::CommandRequest),
            Command::ClearShutdown => self.clear_shutdown(),
            Command::Reset => self.reset(),
            Command::DebugNop | Command::DebugPing | Command::DebugRead => self.debug(command, args),
            Command::ConfigDigitalOut => self.config_digital_out(args),
            Command::SetDigitalOutPwmCycle => self.set_digital_out_pwm_cycle(args),
            Command::UpdateDigitalOut => self.update_digital_out(args),
            Command::SetDigitalOut => self.set_digital_out(args),
            Command::ConfigPwmOut => self.config_pwm_out(args),
            Command::QueuePwmOut => self.queue_pwm_out(args),
            Command::SetPwmOut => self.set_pwm_out(args),
            Command::ConfigAnalogIn => self.config_analog_in(args),
            Command::QueryAnalogIn => self.query_analog_in(args),
            Command::ConfigStepper => self.config_stepper(args),
            Command::ResetStepClock => self.reset_step_clock(args),
            Command::StepperGetPosition => self.stepper_get_position(args),
            Command::StepperStopOnTrigger => self.stepper_stop_on_trigger(args),
            Command::ConfigEndstop => self.config_endstop(args),
            Command::EndstopHome => self.endstop_home(args),
            Command::EndstopQueryState => self.endstop_query_state(args),
            Command::ConfigTrsync => self.config_trsync(args),
            Command::TrsyncStart => self.trsync_start(args),
            Command::TrsyncSetTimeout => self.trsync_set_timeout(args),
            Command::TrsyncTrigger => self.trsync_trigger(args),
            Command::ConfigSpi
            | Command::ConfigSpiWithoutCs
            | Command::SpiSetBus
            | Command::SpiTransfer
            | Command::SpiSend
            | Command::ConfigSpiShutdown
            | Command::SpiSetSwBus
            | Command::ConfigI2c
            | Command::I2cSetSwBus
            | Command::I2cTransfer
            | Command::ConfigTmcuart
            | Command::TmcuartSend
            | Command::ConfigNeopixel
            | Command::NeopixelUpdate
            | Command::NeopixelSend
            | Command::ConfigAdxl345
            | Command::QueryAdxl345
            | Command::QueryAdxl345Status => self.carry_out_on_bus(command, args),
            Command::ConfigButtons => self.config_buttons(args),
            Command::ButtonsAdd => self.buttons_add(args),
            Command::ButtonsQuery => self.buttons_query(args),
            Command::ButtonsAck => self.buttons_ack(args),
            Command::ConfigCounter => self.config_counter(args),
            Command::QueryCounter => self.query_counter(args),
        }
    }

    /// Carries out the commands of chips on buses, serial lines and strips of lights.
    fn carry_out_on_bus(&mut self, command: Command, args: &Args<'_>) -> Outcome {
        match command {
            Command::ConfigSpi => self.config_spi(args.oid(), Some((args.at(1), args.at(2) != 0))),
            Command::ConfigSpiWithoutCs => self.config_spi(args.oid(), None),
            Command::SpiSetBus => self.spi_set_bus(args),
            Command::SpiTransfer => self.spi_exchange(args, true),
            Command::SpiSend => self.spi_exchange(args, false),
            Command::ConfigSpiShutdown => self.config_spi_shutdown(args),
            Command::SpiSetSwBus => self.spi_set_sw_bus(args),
            Command::ConfigI2c => self.configure(args.oid(), Object::I2c(None)),
            Command::I2cSetSwBus => self.i2c_set_sw_bus(args),
            Command::I2cTransfer => self.i2c_transfer(args),
            Command::ConfigTmcuart => self.config_tmcuart(args),
            Command::TmcuartSend => self.tmcuart_send(args),
            Command::ConfigNeopixel => self.config_neopixel(args),
            Command::NeopixelUpdate => self.neopixel_update(args),
            Command::NeopixelSend => self.neopixel_send(args),
            Command::ConfigAdxl345 => self.config_adxl345(args),
            Command::QueryAdxl345 => self.query_adxl345(args),
            Command::QueryAdxl345Status => self.query_adxl345_status(args),
            // The caller lists exactly the commands above.
            _ => Err(Reason::InvalidCommand),
        }
    }

    /// Takes a job back, and goes on with the commands behind it.
    pub fn finish(&mut self, job: Job<B>) {
        self.job_is_out = false;
        let oid = job.oid;
        match (job.work, self.objects.get_mut(usize::from(oid))) {
            (Work::Spi { chip, bytes, answers }, Some(Object::Spi(device))) => {
                device.chip = Some(chip);
                if answers {
                    self.out.send_bytes(Response::SpiTransferred, &[u32::from(oid)], Some(&bytes));
                }
            }
            (Work::Accelerometer { chip, request, answer }, Some(Object::Accelerometer(sensor))) => {
                let device = sensor.device;
                if let Some(Object::Spi(spi)) = self.objects.get_mut(usize::from(device)) {
                    spi.chip = Some(chip);
                }
                if let Some(answer) = answer {
                    self.take_measurement(oid, request, &answer);
                }
            }
            (Work::I2c { chip, outcome, .. }, Some(Object::I2c(device))) => {
                *device = Some(chip);
                let (status, bytes) = match &outcome {
                    Ok(bytes) => (Status::Success, &bytes[..]),
                    Err(status) => (*status, &[][..]),
                };
                self.out.send_bytes(Response::I2cOutcome, &[u32::from(oid), status as u32], Some(bytes));
            }
            // An object stays what it is until the reset.
            (Work::Spi { .. } | Work::I2c { .. } | Work::Accelerometer { .. }, _) => {}
        }
        if let Some(rest) = self.rest.take() {
            self.execute(&rest.block, rest.done);
        }
    }

    /// A damaged block has come, the first since a good one: the host repeats what is expected.
    pub fn damaged(&mut self) {
        if !core::mem::replace(&mut self.has_told_damage, true) {
            self.out.acknowledge();
        }
    }

    /// Whether commands wait for a bus: then there must be no further block.
    pub const fn is_busy(&self) -> bool {
        self.job.is_some() || self.job_is_out || self.rest.is_some()
    }

    /// Whether no motor has a step to make.
    pub fn is_at_rest(&self) -> bool {
        self.steppers.are_at_rest()
    }

    /// Whether there are bytes for the host, or work on a bus.
    pub fn has_news(&self) -> bool {
        !self.out.is_empty() || self.job.is_some() || self.wants_measurement
    }

    /// Takes bytes for the host. Returns how many.
    pub fn fetch(&mut self, into: &mut [u8]) -> usize {
        self.out.fetch(into)
    }

    /// Whether the host has asked for a reset.
    pub const fn wants_reset(&self) -> bool {
        self.wants_reset
    }

    /// Notes that a turn of the task that executes commands took so many ticks. Called every 50 ms at least:
    /// a task that has no time left is a host that asks for too much.
    pub fn note_turn(&mut self, ticks: u32) {
        self.turned_at = self.board.clock();
        let turns = &mut self.turns;
        turns.count = turns.count.wrapping_add(1);
        turns.sum = turns.sum.wrapping_add(ticks);
        let square = (ticks as u64 * ticks as u64).div_ceil(STATS_SUMSQ_BASE as u64);
        let sum = turns.sum_of_squares as u64 + square;
        turns.sum_of_squares = if sum > u32::MAX as u64 { u32::MAX } else { sum as u32 };
    }
}
