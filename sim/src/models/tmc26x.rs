//! TMC2590 and TMC2660 stepper drivers in STEP/DIR mode, as their SPI and logic pins show them.
//!
//! Sources: TMC2590 datasheet V1.0 (2019-02-22) and TMC2660 datasheet rev. 1.05 (2016-07-14); the register
//! chapters are numbered alike in both ("SPI interface", one section per register). The two chips share the
//! register layout; they differ in current scale, in the fourth read-back format and in the DRVCONF bits
//! below bit 4, which the TMC2660 ignores.
//!
//! Not modelled: the SPI (SDOFF = 1) current mode beyond storing its registers, coil currents in time.
//! StallGuard's readings come from the world, see [`super::rotor`].

/// Model of the driver chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// Gate driver with external power stage, fitted to boards with id 0.
    Tmc2590,
    /// Driver with internal power stage, fitted to boards with id 1.
    Tmc2660,
}

impl Chip {
    /// Returns the full-scale voltage across the sense resistor, by VSENSE. TMC2590 datasheet, "Sense
    /// resistor": 0.325 V and 0.173 V typical; TMC2660: 0.310 V and 0.165 V.
    #[must_use]
    pub const fn full_scale_volts(self, high_sensitivity: bool) -> f64 {
        match (self, high_sensitivity) {
            (Self::Tmc2590, false) => 0.325,
            (Self::Tmc2590, true) => 0.173,
            (Self::Tmc2660, false) => 0.310,
            (Self::Tmc2660, true) => 0.165,
        }
    }

    /// Returns the sense resistor that the boards with this chip carry.
    #[must_use]
    pub const fn sense_ohms(self) -> f64 {
        match self {
            Self::Tmc2590 => 0.050,
            Self::Tmc2660 => 0.100,
        }
    }
}

/// Faults of the chip or its motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Condition {
    /// The SPI output never drives: every reply reads as ones (pull-up on MISO).
    pub silent: bool,
    /// Disconnected coils: A, B.
    pub open_load: [bool; 2],
    /// Coils shorted to ground: A, B.
    pub short_to_ground: [bool; 2],
    /// Coils shorted to the motor supply: A, B.
    pub short_to_supply: [bool; 2],
    /// Chip temperature in degrees Celsius.
    pub temperature_c: i32,
    /// Interval of replies of which a bit arrives wrong; 0 for none.
    pub bit_error_every: u32,
}

/// Registers at power-on are all zero: 256 microsteps, single edge, TOFF = 0 (bridges off), STEP/DIR mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Registers {
    drvctrl: u32,
    chopconf: u32,
    smarten: u32,
    sgcsconf: u32,
    drvconf: u32,
}

/// Shorts that the detectors of both coils have latched ("S2GA", "S2VSA" and so on).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Shorts {
    to_ground: [bool; 2],
    to_supply: [bool; 2],
}

impl Shorts {
    /// Returns the flag "SHORTA" or "SHORTB" of a coil.
    const fn of(self, coil: usize) -> bool {
        self.to_ground[coil] || self.to_supply[coil]
    }
}

/// Driver chip with its registers and motor state.
#[derive(Clone, Debug)]
pub struct Tmc26x {
    chip: Chip,
    registers: Registers,
    /// Place in the electrical period: 1024 positions of 1/256 full step.
    microstep_counter: u16,
    /// Time of the last active step edge, ns since power-on.
    last_step_ns: Option<u64>,
    /// Motor supply in volts.
    supply_volts: f64,
    /// Level of the ENN pin: high switches the bridges off.
    enn_high: bool,
    /// Overtemperature shutdown, until the chip has cooled down.
    overheated: bool,
    /// Shorts met while driving; cleared by switching the bridges off (TOFF = 0 or ENN high).
    shorts: Shorts,
    /// Reading of StallGuard; 0 is a stalled motor.
    stall_guard: u16,
    /// State of CoolStep: 32nds that it has taken off the current, and high readings in a row.
    cool: (u32, u32),
    /// Faults of the chip and its motor.
    pub condition: Condition,
    frames: u64,
    /// Every different frame, in the order of its first arrival.
    words: Vec<u32>,
}

/// Standstill is shown 2^20 clocks after the last step ("STST"); the internal oscillator runs at 15 MHz
/// typical.
const STANDSTILL_NS: u64 = (1 << 20) * 1_000 / 15;
/// Overtemperature thresholds in degrees Celsius ("OTPW", "OT"; OTSENS = 0).
const PREWARNING_C: i32 = 100;
const SHUTDOWN_C: i32 = 150;
/// Temperature below which a TMC2590 comes back ("Overtemperature release"); a TMC2660 comes back below the
/// prewarning.
const RELEASE_C: i32 = 120;
/// Voltage below which a TMC2590 sets its UV_7V flag.
const UV_7V_VOLTS: f64 = 7.0;
/// A frame is 20 bits, most significant first.
pub const FRAME_MASK: u32 = 0xF_FFFF;

impl Tmc26x {
    /// Makes a chip fresh from power-on with its motor supply present, its ENN pin floating high.
    #[must_use]
    pub fn new(chip: Chip) -> Self {
        Self {
            chip,
            registers: Registers::default(),
            microstep_counter: 0,
            last_step_ns: None,
            supply_volts: 24.0,
            enn_high: true,
            overheated: false,
            shorts: Shorts::default(),
            stall_guard: 0x1FF,
            cool: (0, 0),
            condition: Condition { temperature_c: 40, ..Condition::default() },
            frames: 0,
            words: Vec::new(),
        }
    }

    /// Returns the model of the chip.
    #[must_use]
    pub const fn chip(&self) -> Chip {
        self.chip
    }

    /// Exchanges an SPI frame (chip select low to high): takes the 20 bits written, gives the 20 bits
    /// shifted out meanwhile, which are the status as chip select fell, in the format that earlier frames
    /// chose.
    pub fn transfer(&mut self, now_ns: u64, frame: u32) -> u32 {
        let shifted_out = self.status(now_ns);
        self.write(frame);
        shifted_out
    }

    /// Returns whether the chip hears and answers nothing: MISO stays at its pull-up.
    fn mute(&self) -> bool {
        self.condition.silent || self.supply_volts < self.lockout_volts()
    }

    /// Returns the supply below which the logic resets and registers are lost: 6.5 V typical; on a TMC2590
    /// 7 V, and 3.8 V with EN_PFD ("Detector Levels").
    const fn lockout_volts(&self) -> f64 {
        match self.chip {
            Chip::Tmc2590 if self.registers.drvconf & (1 << 1) != 0 => 3.8,
            Chip::Tmc2590 => 7.0,
            Chip::Tmc2660 => 6.5,
        }
    }

    /// Returns the contents of DRVCTRL, CHOPCONF, SMARTEN, SGCSCONF and DRVCONF, without their addresses.
    #[must_use]
    pub const fn registers(&self) -> [u32; 5] {
        let Registers { drvctrl, chopconf, smarten, sgcsconf, drvconf } = self.registers;
        [drvctrl, chopconf, smarten, sgcsconf, drvconf]
    }

    /// Returns the number of frames that the chip has taken.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns every different frame the chip was sent, in the order of its first arrival.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Takes the 20 bits before chip select rose, decoded by the leading ones ("Register set": 00 DRVCTRL,
    /// 100 CHOPCONF, 101 SMARTEN, 110 SGCSCONF, 111 DRVCONF; 01 is not a register).
    pub fn write(&mut self, frame: u32) {
        if self.mute() {
            return;
        }
        self.frames += 1;
        let frame = frame & FRAME_MASK;
        if !self.words.contains(&frame) {
            self.words.push(frame);
        }
        match frame >> 17 {
            0 | 1 => self.registers.drvctrl = frame,
            4 => self.registers.chopconf = frame & 0x1_FFFF,
            5 => self.registers.smarten = frame & 0x1_FFFF,
            6 => {
                self.registers.sgcsconf = frame & 0x1_FFFF;
                self.cool = (0, 0);
            }
            7 => self.registers.drvconf = frame & 0x1_FFFF,
            _ => {}
        }
        if self.off_time() == 0 {
            self.shorts = Shorts::default();
        }
    }

    /// TOFF, CHOPCONF bits 3..0; 0 switches the bridges off.
    #[must_use]
    pub const fn off_time(&self) -> u32 {
        self.registers.chopconf & 0xF
    }

    /// SDOFF, DRVCONF bit 7: STEP/DIR interface disabled, coil currents written over SPI.
    #[must_use]
    pub const fn spi_mode(&self) -> bool {
        self.registers.drvconf & (1 << 7) != 0
    }

    /// DEDGE, DRVCTRL bit 8: both edges of STEP are steps.
    #[must_use]
    pub const fn double_edge(&self) -> bool {
        !self.spi_mode() && self.registers.drvctrl & (1 << 8) != 0
    }

    /// INTPOL, DRVCTRL bit 9: the chip makes 256 microsteps of each step.
    #[must_use]
    pub const fn interpolates(&self) -> bool {
        !self.spi_mode() && self.registers.drvctrl & (1 << 9) != 0
    }

    /// Microsteps per full step from MRES, DRVCTRL bits 3..0: 0 is 256, 8 and above full steps.
    #[must_use]
    pub const fn microsteps(&self) -> u32 {
        if self.spi_mode() {
            return 256;
        }
        let mres = self.registers.drvctrl & 0xF;
        256 >> (if mres > 8 { 8 } else { mres })
    }

    /// CS, SGCSCONF bits 4..0: current scale, (CS + 1) / 32 of full scale.
    #[must_use]
    pub const fn current_scale(&self) -> u32 {
        self.registers.sgcsconf & 0x1F
    }

    /// Returns the current scale that is in force: CoolStep may have lowered it ("SE").
    #[must_use]
    pub const fn scale_in_force(&self) -> u32 {
        self.current_scale().saturating_sub(self.cool.0)
    }

    /// Takes a new reading of StallGuard, 0 for a stalled motor. CoolStep raises the current by SEUP if the
    /// reading is below 32 SEMIN, and lowers it by one after SEDN readings from 32 (SEMIN + SEMAX + 1) on,
    /// to a half or a quarter of CS (SEIMIN) ("coolStep", SMARTEN).
    pub fn measure(&mut self, reading: u16) {
        self.stall_guard = reading;
        let (word, reading) = (self.registers.smarten, u32::from(reading));
        let (least, width) = (word & 0xF, word >> 8 & 0xF);
        if least == 0 {
            self.cool = (0, 0);
            return;
        }
        let (lowered, high) = self.cool;
        let most_lowered = self.current_scale() - (self.current_scale() >> if word >> 15 & 1 == 1 { 2 } else { 1 });
        self.cool = if reading < 32 * least {
            (lowered.saturating_sub(1 << (word >> 5 & 3)), 0)
        } else if reading >= 32 * (least + width + 1) {
            let needed = [32, 8, 2, 1][(word >> 13 & 3) as usize];
            if high + 1 >= needed { ((lowered + 1).min(most_lowered), 0) } else { (lowered, high + 1) }
        } else {
            (lowered, 0)
        };
    }

    /// VSENSE, DRVCONF bit 6.
    #[must_use]
    pub const fn high_sensitivity(&self) -> bool {
        self.registers.drvconf & (1 << 6) != 0
    }

    /// SGT, SGCSCONF bits 14..8: seven bits of two's complement.
    #[must_use]
    pub const fn stall_guard_threshold(&self) -> i32 {
        let bits = (self.registers.sgcsconf >> 8 & 0x7F) as i32;
        if bits < 64 { bits } else { bits - 128 }
    }

    /// SFILT, SGCSCONF bit 16.
    #[must_use]
    pub const fn filters_stall_guard(&self) -> bool {
        self.registers.sgcsconf & (1 << 16) != 0
    }

    /// Returns the level of SG_TST: high while the bridges work and the last reading was 0.
    #[must_use]
    pub fn stall_output(&self) -> bool {
        self.drives() && self.stall_guard == 0
    }

    /// Returns the motor supply, volts.
    #[must_use]
    pub const fn supply_volts(&self) -> f64 {
        self.supply_volts
    }

    /// Returns the peak coil current the chopper regulates to, in amperes, for a sense resistor in ohms.
    #[must_use]
    pub fn peak_current_amps(&self, sense_ohms: f64) -> f64 {
        let scale = f64::from(self.scale_in_force() + 1) / 32.0;
        scale * self.chip.full_scale_volts(self.high_sensitivity()) / sense_ohms
    }

    /// Returns whether the bridges drive the motor, which then follows the microstep counter.
    #[must_use]
    pub fn drives(&self) -> bool {
        self.off_time() != 0
            && !self.enn_high
            && !self.overheated
            && self.supply_volts >= self.lockout_volts()
            && self.shorts == Shorts::default()
    }

    /// Sets the level of the ENN pin.
    pub fn set_enn(&mut self, high: bool) {
        self.enn_high = high;
        if high {
            self.shorts = Shorts::default();
        }
    }

    /// Sets the motor supply, in volts. Below the lockout the registers return to their power-on values.
    pub fn set_supply(&mut self, volts: f64) {
        self.supply_volts = volts;
        if volts < self.lockout_volts() {
            self.reset();
        }
    }

    /// Resets the chip as at power-on: its supply was gone for a moment, or dipped. Registers are zero
    /// again ("Register set": reset value), the place in the sine table too.
    pub fn reset(&mut self) {
        self.registers = Registers::default();
        self.cool = (0, 0);
        self.microstep_counter = 0;
        self.overheated = false;
        self.shorts = Shorts::default();
        self.last_step_ns = None;
    }

    /// Takes an edge on STEP with DIR at this level. For an active edge the answer is the move of the
    /// microstep counter, in 1/256 full step: up with DIR low, down with DIR high ("Microstep Table");
    /// `None` when the chip ignores the edge.
    pub fn step_edge(&mut self, now_ns: u64, rising: bool, dir_high: bool) -> Option<i32> {
        if self.spi_mode() || self.supply_volts < self.lockout_volts() || !(rising || self.double_edge()) {
            return None;
        }
        let size = 256 / self.microsteps() as u16;
        let counter = if dir_high {
            self.microstep_counter.wrapping_sub(size)
        } else {
            self.microstep_counter.wrapping_add(size)
        };
        self.microstep_counter = counter & 0x3FF;
        self.last_step_ns = Some(now_ns);
        self.notice_faults();
        Some(if dir_high { -i32::from(size) } else { i32::from(size) })
    }

    /// Notes a changed condition or passed time: shorts and heat switch the bridges off.
    pub fn notice_faults(&mut self) {
        if self.condition.temperature_c >= SHUTDOWN_C {
            self.overheated = true;
        } else if self.condition.temperature_c < if self.chip == Chip::Tmc2590 { RELEASE_C } else { PREWARNING_C } {
            self.overheated = false;
        }
        if self.off_time() == 0 || self.enn_high {
            return;
        }
        // High side: off with DIS_S2G, DRVCONF bit 10. Low side: on with EN_S2VS, bit 0 of a TMC2590; a
        // TMC2660 has none.
        let watches_ground = self.registers.drvconf & (1 << 10) == 0;
        let watches_supply = self.chip == Chip::Tmc2590 && self.registers.drvconf & 1 != 0;
        for coil in 0..2 {
            self.shorts.to_ground[coil] |= watches_ground && self.condition.short_to_ground[coil];
            self.shorts.to_supply[coil] |= watches_supply && self.condition.short_to_supply[coil];
        }
    }

    /// Returns the 20-bit reply as chip select falls ("Read response"): ten bits chosen by RDSEL (DRVCONF
    /// bits 5..4), ten status bits.
    pub fn status(&mut self, now_ns: u64) -> u32 {
        if self.mute() {
            return FRAME_MASK;
        }
        self.notice_faults();
        let stall_guard = u32::from(self.stall_guard & 0x3FF);
        let selected = match (self.registers.drvconf >> 4 & 3, self.chip) {
            (0, _) => u32::from(self.microstep_counter),
            (1, _) => stall_guard,
            (2, _) => (stall_guard >> 5) << 5 | self.scale_in_force(),
            (_, Chip::Tmc2590) => self.diagnostics(),
            (_, Chip::Tmc2660) => 0,
        };
        (selected << 10 | self.flags(now_ns)) ^ self.bit_error()
    }

    /// Returns the bit of this reply that arrives wrong, another one each time.
    fn bit_error(&self) -> u32 {
        let every = u64::from(self.condition.bit_error_every);
        if every == 0 || !self.frames.is_multiple_of(every) { 0 } else { 1 << (self.frames / every * 7 % 20) }
    }

    /// Returns the full diagnosis, TMC2590 with RDSEL = 3: supply, ENN input, shorts, temperature
    /// comparators.
    fn diagnostics(&self) -> u32 {
        let over = |limit_c: i32| self.condition.temperature_c >= limit_c;
        bits(&[
            (9, self.supply_volts < UV_7V_VOLTS),
            (8, self.enn_high),
            (7, self.shorts.to_supply[1]),
            (6, self.shorts.to_ground[1]),
            (5, self.shorts.to_supply[0]),
            (4, self.shorts.to_ground[0]),
            (3, over(150)),
            (2, over(136)),
            (1, over(120)),
            (0, over(100)),
        ])
    }

    fn flags(&self, now_ns: u64) -> u32 {
        let driving = self.off_time() != 0 && !self.enn_high;
        let standing = self.last_step_ns.is_none_or(|last| now_ns.saturating_sub(last) >= STANDSTILL_NS);
        // Open load can only be seen while the chopper works on a turning motor.
        let open = |coil: usize| self.condition.open_load[coil] && driving && !standing;
        // The format with full diagnosis reads ones in the two unused bits.
        let diagnosis = self.registers.drvconf >> 4 & 3 == 3 && self.chip == Chip::Tmc2590;
        bits(&[
            (9, diagnosis),
            (8, diagnosis),
            (7, standing),
            (6, open(1)),
            (5, open(0)),
            (4, self.shorts.of(1)),
            (3, self.shorts.of(0)),
            (2, self.condition.temperature_c >= PREWARNING_C),
            (1, self.overheated),
            (0, driving && !standing && self.stall_guard == 0),
        ])
    }

    /// Returns the microstep counter, 0 to 1023 in the electrical period.
    #[must_use]
    pub const fn microstep_counter(&self) -> u16 {
        self.microstep_counter
    }
}

fn bits(list: &[(u32, bool)]) -> u32 {
    list.iter().fold(0, |word, &(bit, set)| word | u32::from(set) << bit)
}

#[cfg(test)]
mod tests;
