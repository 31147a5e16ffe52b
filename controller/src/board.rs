//! The board as a Klipper host uses it: pins by number, motors, buses, the supply of the outputs.
//!
//! Levels are those of the pin. What the board guards (the drivers' enable, the outputs' buffer) acts low or
//! is switched here: see [`PrimeBoard::output`] and [`PrimeBoard::power_outputs`].

use bsp_prime::adc::{Supplies, Thermistors};
use bsp_prime::board::Guards;
use bsp_prime::led_strip::LedSender;
use bsp_prime::pins::{self, Output, PinName, PinSpec, Pins, table};
use bsp_prime::pwm::Pwm;
use bsp_prime::spi::{SpiBuses, SpiChip};
use bsp_prime::step_engine::{self, MotorLines};
use bsp_prime::{factory, time};
use embedded_hal::spi::{MODE_0, MODE_1, MODE_2, MODE_3};
use klipper::Reason;
use klipper::board::{Board, MotorSettings, Pull, SpiSettings, StepEdge};
use units::MAX_ACTUATORS;

use crate::analog::{AnalogInput, AnalogInputs};
use crate::pwm::{Channel, PwmPins};

/// Owner of all pins that the host claims.
pub const OWNER: &str = "the host";
/// Ticks of the step clock in a microsecond.
const TICKS_PER_US: u32 = units::STEP_CLOCK_HZ / 1_000_000;

/// Longest wait within a transfer: 0.1 ms, half a period at 5 kHz.
const MOST_PAUSE_TICKS: u32 = 100 * TICKS_PER_US;

/// The board, with what the host has claimed.
pub struct PrimeBoard {
    pins: &'static mut Pins,
    /// Enable of the motor drivers, until the host claims its pin.
    motors_enable: Option<Output>,
    fets: Output,
    fets_power: Output,
    spi: SpiBuses,
    analog: AnalogInputs,
    pwm: PwmPins,
    motors: [MotorLines; MAX_ACTUATORS],
    /// Longest pulse that a motor of pulses asks for.
    pulse_ticks: u32,
}

/// Output that the host sets by its level.
pub struct LevelOutput {
    output: Output,
    /// The output is on when its pin is low.
    inverted: bool,
}

/// Input that the host reads by its level.
pub struct LevelInput(pins::Input);

/// Open-drain line that the host uses by its level.
pub struct OpenLine(pins::Line);

/// Chip on an SPI bus.
pub struct Chip(SpiChip);

impl PrimeBoard {
    /// Creates the board with nothing claimed.
    pub const fn new(
        pins: &'static mut Pins,
        guards: Guards,
        spi: SpiBuses,
        (thermistors, supplies): (Thermistors, Supplies),
        (pwm, lights): (Pwm, LedSender),
    ) -> Self {
        Self {
            pins,
            motors_enable: Some(guards.motors),
            fets: guards.fets,
            fets_power: guards.fets_power,
            spi,
            analog: AnalogInputs::new(thermistors, supplies),
            pwm: PwmPins::new(pwm, lights),
            motors: [MotorLines::NONE; MAX_ACTUATORS],
            pulse_ticks: 0,
        }
    }
}

/// The pin of a number, on at this level.
fn spec(pin: u32, on_is_high: bool) -> Option<PinSpec> {
    PinName::numbered(pin).map(|pin| if on_is_high { PinSpec::plain(pin) } else { PinSpec::inverted(pin) })
}

/// The pin of a number with a resistor.
fn pulled(pin: u32, pull: Pull) -> Option<PinSpec> {
    let pull = match pull {
        Pull::Up => pins::Pull::Up,
        Pull::Down => pins::Pull::Down,
        Pull::None => pins::Pull::Floating,
    };
    Some(PinSpec { pull, ..spec(pin, true)? })
}

impl klipper::board::Output for LevelOutput {
    fn set(&mut self, high: bool) {
        self.output.set(high != self.inverted);
    }
}

impl klipper::board::Input for LevelInput {
    fn is_high(&self) -> bool {
        self.0.is_on()
    }
}

impl klipper::board::Wire for OpenLine {
    fn set(&mut self, high: bool) {
        self.0.set(high);
    }

    fn is_high(&self) -> bool {
        self.0.is_high()
    }
}

impl klipper::board::Spi for Chip {
    fn exchange(&mut self, bytes: &mut [u8]) {
        if self.0.exchange(bytes).is_err() {
            bytes.fill(0);
        }
    }
}

impl Board for PrimeBoard {
    type Output = LevelOutput;
    type Input = LevelInput;
    type Analog = AnalogInput;
    type Pwm = Channel;
    type Spi = Chip;
    type Wire = OpenLine;
    type Strip = Channel;

    fn clock(&self) -> u32 {
        time::step_ticks()
    }

    fn clock_turns(&self) -> u32 {
        (time::now_ticks().0 >> 32) as u32
    }

    /// The drivers' enable is claimed by the board, which hands it over: low lets the motors run.
    fn output(&mut self, pin: u32, high: bool) -> Option<LevelOutput> {
        // The level to begin with is the one of off, which a new output has.
        let spec = spec(pin, !high)?;
        if spec.pin == table::MOTORS_ENABLE.pin {
            let mut output = LevelOutput { output: self.motors_enable.take()?, inverted: true };
            klipper::board::Output::set(&mut output, high);
            return Some(output);
        }
        let output = self.pins.output(spec, OWNER).ok()?;
        Some(LevelOutput { output, inverted: spec.inverted })
    }

    fn input(&mut self, pin: u32, pull: Pull) -> Option<LevelInput> {
        self.pins.input(pulled(pin, pull)?, OWNER).ok().map(LevelInput)
    }

    fn wire(&mut self, pin: u32, pull: Pull) -> Option<OpenLine> {
        self.pins.line(pulled(pin, pull)?, OWNER).ok().map(OpenLine)
    }

    /// A host's waits are half periods of a clock; what is longer than any is cut.
    fn pause(ticks: u32) {
        let (begun, most) = (time::step_ticks(), ticks.min(MOST_PAUSE_TICKS));
        while time::step_ticks().wrapping_sub(begun) < most {}
    }

    fn strip(&mut self, pin: u32) -> Result<Channel, Reason> {
        self.pwm.claim_strip(pin, self.pins)
    }

    fn send_to_strip(&mut self, strip: Channel, bytes: &[u8]) -> bool {
        self.pwm.send(strip, bytes)
    }

    fn analog(&mut self, pin: u32) -> Option<AnalogInput> {
        self.analog.claim(pin, self.pins)
    }

    fn read_analog(&mut self, input: AnalogInput) -> Option<u16> {
        self.analog.read(input)
    }

    fn pwm(&mut self, pin: u32, cycle_ticks: u32, value: u16) -> Result<Channel, Reason> {
        self.pwm.claim(pin, cycle_ticks, value, self.pins)
    }

    fn set_pwm(&mut self, channel: Channel, value: u16) {
        self.pwm.set(channel, value);
    }

    fn motor(&mut self, index: usize, settings: MotorSettings) -> Option<()> {
        let lines = self.motors.get_mut(index)?;
        let step = self.pins.fast_output(spec(settings.step_pin, settings.edge != StepEdge::Falling)?, OWNER).ok()?;
        let direction = self.pins.fast_output(spec(settings.dir_pin, true)?, OWNER).ok()?;
        let double_edge = settings.edge == StepEdge::Both;
        *lines = MotorLines { step, direction, double_edge, least_distance_ticks: settings.pulse_ticks };
        if !double_edge {
            self.pulse_ticks = self.pulse_ticks.max(settings.pulse_ticks);
        }
        Some(())
    }

    fn spi(&mut self, settings: SpiSettings) -> Result<Chip, Reason> {
        let modes = [MODE_0, MODE_1, MODE_2, MODE_3];
        let mode = *modes.get(usize::from(settings.mode)).ok_or(Reason::InvalidSpi)?;
        let bus = u8::try_from(settings.bus).map_err(|_| Reason::InvalidSpiBus)?;
        let select = match settings.select {
            Some(pin) => {
                let spec = spec(pin, settings.active_high).ok_or(Reason::NotAPin)?;
                Some(self.pins.output(spec, OWNER).map_err(|_| Reason::NotAPin)?)
            }
            None => None,
        };
        match self.spi.chip(bus, (mode, settings.rate_hz), select, self.pins, OWNER) {
            Ok(Some(chip)) => Ok(Chip(chip)),
            Ok(None) | Err(_) => Err(Reason::InvalidSpiBus),
        }
    }

    fn begin(&mut self) {
        self.analog.start();
        step_engine::configure(&self.motors, self.pulse_ticks.div_ceil(TICKS_PER_US));
        self.power_outputs(true);
    }

    fn power_outputs(&mut self, on: bool) {
        self.fets_power.set(on);
        self.fets.set(on);
    }

    fn read_factory(&self, bytes: u8, address: u32) -> Option<u32> {
        factory::read(bytes, address)
    }

    fn wake_steps(&self) {
        step_engine::wake();
    }
}
