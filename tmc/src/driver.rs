//! Driver of a TMC2590 or TMC2660, set in amperes, microsteps and chopper settings. The chip's registers
//! cannot be read, so the driver keeps a copy, writes what changes, and can write all of it again after a
//! loss of the motor supply.

use crate::Chip;
use crate::chopper::{Chopper, CoolStep, SettingError, in_range};
use crate::current::{CurrentSetting, current_setting};
use crate::register::{DrvConf, DrvCtrl, Registers, SgCsConf, SmartEn, WORD_MASK};
use crate::status::{ReadSelect, Status};
use embedded_hal::spi::SpiDevice;
use units::{Amps, Ohms};

/// Failure of the exchange with a driver, or a setting that the chip cannot take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The SPI bus failed.
    Bus(E),
    /// Nothing drives the data line: only zeros or only ones came back. No chip, no power, or chip select not
    /// connected.
    Absent,
    /// A single-wire UART does not receive even its own bytes.
    NoEcho,
    /// An answer came, but not in this chip's format. The 24 bits received.
    WrongAnswer(u32),
    /// The chip has been reset since it was set up: all of its registers are as after power-up, its bridges
    /// off.
    Reset,
    /// The chip cannot be set as asked; nothing was sent.
    Setting(SettingError),
}

impl<E> From<SettingError> for Error<E> {
    fn from(error: SettingError) -> Self {
        Self::Setting(error)
    }
}

impl<E: core::fmt::Debug> core::fmt::Display for Error<E> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "SPI bus error {error:?}"),
            Self::Absent => f.write_str("no answer; is the motor supply on?"),
            Self::NoEcho => f.write_str("what is sent does not come back: are TX, over 1 kOhm, and RX on the wire?"),
            Self::WrongAnswer(answer) => write!(f, "unexpected answer {answer:06x}"),
            Self::Reset => f.write_str("the driver was without power and has lost its settings"),
            Self::Setting(error) => error.fmt(f),
        }
    }
}

/// Microsteps per full step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Microsteps {
    M256 = 0,
    M128 = 1,
    M64 = 2,
    M32 = 3,
    M16 = 4,
    M8 = 5,
    M4 = 6,
    M2 = 7,
    M1 = 8,
}

impl Microsteps {
    /// Converts from a number of microsteps; a power of two from 1 to 256.
    #[must_use]
    pub const fn from_count(count: u16) -> Option<Self> {
        Some(match count {
            256 => Self::M256,
            128 => Self::M128,
            64 => Self::M64,
            32 => Self::M32,
            16 => Self::M16,
            8 => Self::M8,
            4 => Self::M4,
            2 => Self::M2,
            1 => Self::M1,
            _ => return None,
        })
    }

    /// Returns the number of microsteps per full step.
    #[must_use]
    pub const fn count(self) -> u16 {
        256 >> self as u16
    }
}

/// Interpretation of the STEP input by the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepInput {
    /// Microsteps per full step.
    pub microsteps: Microsteps,
    /// Whether every edge is a step, not only the rising one: half the edges for the same speed.
    pub double_edge: bool,
    /// Whether the chip divides each step into 16 by time, for smoothness.
    pub interpolation: bool,
}

/// Settings of the load measurement (stallGuard2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StallGuard {
    /// Threshold of the stall, -64 to 63; lower is more sensitive.
    pub threshold: i8,
    /// Whether to average over four full steps.
    pub filter: bool,
}

/// A TMC2590 or TMC2660 on an SPI bus in [`crate::SPI_MODE`].
///
/// Every setting enters the copy of the registers before it is sent, so a chip that does not answer yet,
/// because the motor supply is off, gets all of them by [`Driver::start`].
#[derive(Debug)]
pub struct Driver<SPI> {
    spi: SPI,
    chip: Chip,
    sense_resistor: Ohms,
    /// `CHOPCONF.TOFF` here is the off time to use when enabled.
    registers: Registers,
    /// `SMARTEN` to use when coolStep is switched on.
    cool_step: SmartEn,
    enabled: bool,
    /// Current in motion, and current at standstill if that differs.
    run: CurrentSetting,
    standstill: Option<CurrentSetting>,
    standing: bool,
    /// Settings to restore at the end of a search for a stall.
    before_search: Option<(CurrentSetting, SgCsConf, SmartEn)>,
    /// The restored settings have not reached the chip.
    is_stale: bool,
    /// Reading that the next answer will contain; a changed `RDSEL` shows one answer later.
    shown: ReadSelect,
    /// Current settings sent to the chip last.
    sent: SentCurrent,
    /// The chip was found reset, and has not been set up again.
    is_reset: bool,
}

/// Fills the four bits of the 24 that the chip only passes through, so that a dead line cannot look like an
/// answer.
const PADDING: u32 = 0b0101;

impl<SPI: SpiDevice> Driver<SPI> {
    /// Creates a driver with a Smoothieboard v2's settings, disabled, at the lowest current; and, if the chip
    /// has it, with the low side's short detector on, which is off in a Smoothieboard v2. Sends nothing.
    ///
    /// TMC2590 data sheet, section 12.1: "enable detection for normal use". The detector trips between 1.3 V
    /// and 1.8 V across the low-side MOSFET and the sense resistor. At the most that the chip can regulate,
    /// 6.5 A with 50 mOhm, a hot MOSFET of 50 mOhm has 0.65 V across both.
    ///
    /// # Errors
    /// A sense resistor that is not above 0.
    pub fn new(spi: SPI, chip: Chip, sense_resistor: Ohms) -> Result<Self, Error<SPI::Error>> {
        in_range("sense resistor", "above 0 Ohm", sense_resistor.0 > 0.0 && sense_resistor.0.is_finite())?;
        let run = current_setting(chip, sense_resistor, Amps(0.0));
        let low_side_detector = u32::from(chip == Chip::Tmc2590);
        let drvconf = DrvConf::RESET.with_slopes(chip.default_gate_drive()).with_en_s2vs(low_side_detector);
        let registers = Registers {
            drvctrl: DrvCtrl::RESET.with_mres(Microsteps::M32 as u32),
            chopconf: Chopper::DEFAULT.register()?,
            smarten: SmartEn::RESET,
            sgcsconf: SgCsConf::RESET.with_sgt(10).with_sfilt(1),
            drvconf: drvconf.with_rdsel(Self::health_reading(chip) as u32),
        };
        let mut driver = Self {
            spi,
            chip,
            sense_resistor,
            registers,
            cool_step: SmartEn::RESET,
            enabled: false,
            run,
            standstill: None,
            standing: false,
            before_search: None,
            is_stale: false,
            shown: ReadSelect::default(),
            sent: SentCurrent::default(),
            is_reset: false,
        };
        driver.store_current();
        Ok(driver)
    }

    /// Writes every register, then checks that a chip of this kind answers. Restores the chip also after the
    /// motor supply was gone. Takes six transfers.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`].
    pub fn start(&mut self) -> Result<Status, Error<SPI::Error>> {
        // The chip may have lost its settings, so the format of the answers before DRVCONF arrived is not
        // known.
        for word in [self.registers.drvctrl.word(), self.chopconf(), self.registers.smarten.word()] {
            self.transfer(word)?;
        }
        self.transfer(self.registers.sgcsconf.word())?;
        self.transfer(self.registers.drvconf.word())?;
        self.is_reset = false;
        self.status()
    }

    /// Asks for the chip's status, and whether it still has its settings. Takes one transfer to a TMC2590,
    /// two to a TMC2660, and twice as many where it seems to be reset.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`], [`Error::Reset`].
    pub fn status(&mut self) -> Result<Status, Error<SPI::Error>> {
        match self.chip {
            Chip::Tmc2590 => self.look_at_format(),
            Chip::Tmc2660 => self.look_at_scale(),
        }
    }

    /// Asks for one reading, and leaves the selection as it was. Takes two transfers.
    ///
    /// # Errors
    /// As [`Self::status`]; [`Error::Setting`] for diagnostics from a TMC2660, which has none.
    pub fn read(&mut self, select: ReadSelect) -> Result<Status, Error<SPI::Error>> {
        let has_it = self.chip == Chip::Tmc2590 || select != ReadSelect::Diagnostics;
        in_range("reading", "one that a TMC2660 has", has_it)?;
        let usual = self.registers.drvconf;
        self.write(usual.with_rdsel(select as u32).word())?;
        self.write(usual.word())
    }

    /// Switches the bridges on.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn enable(&mut self) -> Result<Status, Error<SPI::Error>> {
        if self.is_stale {
            self.start()?;
            self.is_stale = false;
        }
        self.enabled = true;
        self.write(self.chopconf())
    }

    /// Switches the bridges off (`TOFF` = 0); the motor turns freely.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn disable(&mut self) -> Result<Status, Error<SPI::Error>> {
        self.enabled = false;
        self.write(self.chopconf())
    }

    /// Returns whether the bridges were last switched on.
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Sets the peak coil current. Returns the current that the chip makes of it; see [`crate::CurrentFit`].
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_current(&mut self, peak: Amps) -> Result<CurrentSetting, Error<SPI::Error>> {
        let setting = current_setting(self.chip, self.sense_resistor, peak);
        self.run = setting;
        self.write_current()?;
        Ok(setting)
    }

    /// Returns the peak current of the motor in motion.
    #[must_use]
    pub const fn current(&self) -> Amps {
        self.run.actual
    }

    /// Sets the peak current to use while [`Self::set_standing`] holds; none to use the running current.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_standstill_current(&mut self, peak: Option<Amps>) -> Result<(), Error<SPI::Error>> {
        self.standstill = peak.map(|peak| current_setting(self.chip, self.sense_resistor, peak));
        self.write_current()
    }

    /// Changes between the running and the standstill current. Sends nothing if nothing changes.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_standing(&mut self, standing: bool) -> Result<(), Error<SPI::Error>> {
        let changes = standing != self.standing && self.standstill.is_some();
        self.standing = standing;
        if changes { self.write_current() } else { Ok(()) }
    }

    /// Sets the interpretation of STEP.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_step_input(&mut self, input: StepInput) -> Result<(), Error<SPI::Error>> {
        self.registers.drvctrl = DrvCtrl::RESET
            .with_mres(input.microsteps as u32)
            .with_dedge(u32::from(input.double_edge))
            .with_intpol(u32::from(input.interpolation));
        self.write(self.registers.drvctrl.word()).map(drop)
    }

    /// Sets the chopper. A disabled motor stays disabled.
    ///
    /// # Errors
    /// [`Error::Setting`] for what the chip cannot do, else as [`Self::status`].
    pub fn set_chopper(&mut self, chopper: Chopper) -> Result<(), Error<SPI::Error>> {
        self.registers.chopconf = chopper.register()?;
        self.write(self.chopconf()).map(drop)
    }

    /// Sets the load measurement.
    ///
    /// # Errors
    /// [`Error::Setting`] for a threshold out of range, else as [`Self::status`].
    pub fn set_stall_guard(&mut self, stall_guard: StallGuard) -> Result<(), Error<SPI::Error>> {
        in_range("stallGuard threshold", "-64 to 63", (-64..=63).contains(&stall_guard.threshold))?;
        let two_s_complement = u32::from(stall_guard.threshold.cast_unsigned()) & 0x7F;
        self.registers.sgcsconf =
            self.registers.sgcsconf.with_sgt(two_s_complement).with_sfilt(u32::from(stall_guard.filter));
        self.write(self.registers.sgcsconf.word()).map(drop)
    }

    /// Sets load-dependent current (coolStep); `None` turns it off.
    ///
    /// # Errors
    /// [`Error::Setting`] for what the chip cannot do, else as [`Self::status`].
    pub fn set_cool_step(&mut self, cool_step: Option<CoolStep>) -> Result<(), Error<SPI::Error>> {
        self.registers.smarten = match cool_step {
            Some(cool_step) => cool_step.register()?,
            None => SmartEn::RESET,
        };
        if cool_step.is_some() {
            self.cool_step = self.registers.smarten;
        }
        self.write(self.registers.smarten.word()).map(drop)
    }

    /// Sets the parameters of coolStep, and leaves it on or off as it is.
    ///
    /// # Errors
    /// When a value is none that the chip has ([`Error`]), or the chip does not answer.
    pub fn prepare_cool_step(&mut self, cool_step: CoolStep) -> Result<(), Error<SPI::Error>> {
        if self.registers.smarten.semin() != 0 {
            return self.set_cool_step(Some(cool_step));
        }
        self.cool_step = cool_step.register()?;
        Ok(())
    }

    /// Switches coolStep on, with its last parameters.
    ///
    /// # Errors
    /// [`Error::Setting`] when it was never set, else as [`Self::status`].
    pub fn cool_step_on(&mut self) -> Result<(), Error<SPI::Error>> {
        let smarten = if self.cool_step.semin() == 0 { self.registers.smarten } else { self.cool_step };
        in_range("lower threshold of coolStep", "set before it is switched on", smarten.semin() != 0)?;
        self.registers.smarten = smarten;
        self.write(smarten.word()).map(drop)
    }

    /// Sets passive fast decay (`EN_PFD`), which damps resonance at medium speed.
    ///
    /// # Errors
    /// [`Error::Setting`] for a TMC2660, which has none, else as [`Self::status`].
    pub fn set_passive_fast_decay(&mut self, on: bool) -> Result<(), Error<SPI::Error>> {
        in_range("passive fast decay", "off on a TMC2660", !on || self.chip == Chip::Tmc2590)?;
        self.registers.drvconf = self.registers.drvconf.with_en_pfd(u32::from(on));
        self.write(self.registers.drvconf.word()).map(drop)
    }

    /// Sets the short detector of the bridges' low side (`EN_S2VS`), which sees coils shorted to the supply
    /// and overcurrent.
    ///
    /// # Errors
    /// [`Error::Setting`] for a TMC2660, which has none, else as [`Self::status`].
    pub fn set_short_to_supply_detection(&mut self, on: bool) -> Result<(), Error<SPI::Error>> {
        in_range("short to supply detection", "off on a TMC2660", !on || self.chip == Chip::Tmc2590)?;
        self.registers.drvconf = self.registers.drvconf.with_en_s2vs(u32::from(on));
        self.write(self.registers.drvconf.word()).map(drop)
    }

    /// Sets how hard the MOSFETs' gates are driven, 0 the gentlest, both sides alike: stronger means steeper
    /// edges, so less heat in the MOSFETs, and more ringing, radio noise and false short circuits.
    ///
    /// # Errors
    /// [`Error::Setting`] for more than [`Chip::strongest_gate_drive`], else as [`Self::status`].
    pub fn set_gate_drive(&mut self, strength: u8) -> Result<(), Error<SPI::Error>> {
        let allowed = if self.chip == Chip::Tmc2590 { "0 to 7" } else { "0 to 3" };
        in_range("gate drive", allowed, strength <= self.chip.strongest_gate_drive())?;
        self.registers.drvconf = self.registers.drvconf.with_slopes(strength);
        self.write(self.registers.drvconf.word()).map(drop)
    }

    /// Returns the copy of the registers. `CHOPCONF.TOFF` is the one used when enabled.
    #[must_use]
    pub const fn registers(&self) -> &Registers {
        &self.registers
    }

    /// Returns the type of the chip.
    #[must_use]
    pub const fn chip(&self) -> Chip {
        self.chip
    }

    /// Returns the sense resistor by which currents are computed.
    #[must_use]
    pub const fn sense_resistor(&self) -> Ohms {
        self.sense_resistor
    }

    /// Gives the bus back. The chip keeps its last settings.
    #[must_use]
    pub fn release(self) -> SPI {
        self.spi
    }

    /// Returns the reading that reveals most faults of this chip.
    const fn health_reading(chip: Chip) -> ReadSelect {
        match chip {
            Chip::Tmc2590 => ReadSelect::Diagnostics,
            Chip::Tmc2660 => ReadSelect::StallGuard,
        }
    }

    fn chopconf(&self) -> u32 {
        if self.enabled { self.registers.chopconf.word() } else { self.registers.chopconf.with_toff(0).word() }
    }

    fn store_current(&mut self) {
        let setting = if self.standing { self.standstill.unwrap_or(self.run) } else { self.run };
        self.registers.sgcsconf = self.registers.sgcsconf.with_cs(u32::from(setting.cs));
        self.registers.drvconf = self.registers.drvconf.with_vsense(u32::from(setting.low_range));
    }

    /// Scale and range are in two registers. In this order the current between the two is below the larger of
    /// the old and the new one: the low range takes effect before its larger scale, the high range after its
    /// smaller scale.
    fn write_current(&mut self) -> Result<(), Error<SPI::Error>> {
        self.store_current();
        let (scale, range) = (self.registers.sgcsconf.word(), self.registers.drvconf.word());
        let low_range = self.registers.drvconf.vsense() == 1;
        for word in if low_range { [range, scale] } else { [scale, range] } {
            self.write(word)?;
        }
        Ok(())
    }

    /// Writes one register. A chip that was found reset gets no words until [`Self::start`], as it could not
    /// be told from a chip with all its settings.
    fn write(&mut self, word: u32) -> Result<Status, Error<SPI::Error>> {
        if self.is_reset {
            return Err(Error::Reset);
        }
        if SgCsConf::from_word(word).is_some() && self.chip == Chip::Tmc2660 {
            self.look_at_scale()?;
        }
        self.exchange(word)
    }

    /// Sends 20 bits in a 24-bit frame; the chip takes the last 20. Gives the 24 bits that came back: the
    /// answer in the upper 20, below it what the chip passed through.
    fn transfer(&mut self, word: u32) -> Result<u32, Error<SPI::Error>> {
        let [_, mut frame @ ..] = (PADDING << 20 | word & WORD_MASK).to_be_bytes();
        self.spi.transfer_in_place(&mut frame).map_err(Error::Bus)?;
        if let Some(drvconf) = DrvConf::from_word(word) {
            self.shown = ReadSelect::from_code(drvconf.rdsel());
        }
        self.sent.note(word);
        let [high, middle, low] = frame;
        match u32::from_be_bytes([0, high, middle, low]) {
            0 => Err(Error::Absent),
            answer if answer >> 4 == WORD_MASK => Err(Error::Absent),
            answer => Ok(answer),
        }
    }
}

mod loss;
mod raw;
mod search;
use loss::SentCurrent;
#[cfg(test)]
mod tests;
