//! TMC2130, TMC5160, TMC2240, TMC2208 and TMC2209 in STEP/DIR mode, as their buses and logic pins show them.
//!
//! Sources: TMC2130 datasheet rev. 1.10, TMC5160 datasheet rev. 1.14, TMC2240 datasheet rev. 1, chapters
//! "SPI interface" and "Register mapping"; TMC220x and TMC222x datasheet rev. 1.02, TMC2209 datasheet rev.
//! 1.03, chapter "Register map". The UART of the last two is in [`super::tmc_wire`].
//!
//! Not modelled: encoder, motion controller, coil currents in time, stealthChop's and coolStep's
//! regulation, the voltage at VREF (it is open). The readings of the load measurement come from the world.

use super::tmc26x::Condition;

/// Model of the chip on the driver's board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum StealthKind {
    Tmc2130,
    Tmc5160,
    Tmc2240,
    Tmc2208,
    Tmc2209,
}

const GCONF: usize = 0x00;
const GSTAT: usize = 0x01;
const IFCNT: usize = 0x02;
const IOIN: usize = 0x04;
const WIRE_IOIN: usize = 0x06;
const DRV_CONF: usize = 0x0A;
const GLOBALSCALER: usize = 0x0B;
const IHOLD_IRUN: usize = 0x10;
const TSTEP: usize = 0x12;
const MSCNT: usize = 0x6A;
const CHOPCONF: usize = 0x6C;
const DRV_STATUS: usize = 0x6F;
const PWMCONF: usize = 0x70;
const SG4_RESULT: usize = 0x75;
const SG_RESULT: usize = 0x41;
const TPWMTHRS: usize = 0x13;
const TCOOLTHRS: usize = 0x14;

/// Temperatures of the warning, below which a chip that has shut down comes back, and of the shutdown.
const PREWARNING_C: i32 = 120;
const SHUTDOWN_C: i32 = 150;

impl StealthKind {
    /// Returns the "VERSION" field of IOIN.
    const fn version(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x11,
            Self::Tmc5160 => 0x30,
            Self::Tmc2240 => 0x40,
            Self::Tmc2208 => 0x20,
            Self::Tmc2209 => 0x21,
        }
    }

    /// Returns the typical frequency of the internal oscillator, MHz.
    const fn clock_mhz(self) -> u64 {
        match self {
            Self::Tmc2130 => 13,
            _ => 12,
        }
    }

    /// Returns whether the chip is on a UART.
    const fn is_on_wire(self) -> bool {
        matches!(self, Self::Tmc2208 | Self::Tmc2209)
    }

    /// Returns the register of the inputs, and "drv_enn" or "ENN" among them.
    const fn inputs(self) -> (usize, u32) {
        if self.is_on_wire() { (WIRE_IOIN, 1) } else { (IOIN, 1 << 4) }
    }

    /// Returns the "reset default" of the registers in which it is not 0.
    const fn reset_values(self) -> &'static [(usize, u32)] {
        match self {
            Self::Tmc2130 => &[(GSTAT, 1), (PWMCONF, 0x0005_0480)],
            Self::Tmc5160 => &[(GSTAT, 1), (DRV_CONF, 0x0008_0400), (CHOPCONF, 0x1041_0150), (PWMCONF, 0xC40C_001E)],
            Self::Tmc2240 => &[(GSTAT, 1), (CHOPCONF, 0x1041_0150), (PWMCONF, 0xC40C_001D)],
            // Values of a chip whose one-time memory (OTP) is not programmed.
            Self::Tmc2208 | Self::Tmc2209 => &[
                (GCONF, 0x101),
                (GSTAT, 1),
                (IHOLD_IRUN, 0x0001_1F10),
                (0x11, 20),
                (CHOPCONF, 0x1000_0053),
                (PWMCONF, 0xC10D_0024),
            ],
        }
    }

    /// Returns whether a register has the access "R", "RW", "R+C" or "R+WC": others read as 0. All
    /// registers of a TMC2240 can be read.
    fn can_be_read(self, address: usize) -> bool {
        const READABLE: [usize; 7] = [GCONF, GSTAT, IOIN, TSTEP, MSCNT, CHOPCONF, DRV_STATUS];
        const ON_WIRE: [usize; 9] = [GCONF, GSTAT, IFCNT, WIRE_IOIN, TSTEP, MSCNT, CHOPCONF, DRV_STATUS, PWMCONF];
        match self {
            Self::Tmc2240 => true,
            Self::Tmc2208 => ON_WIRE.contains(&address),
            Self::Tmc2209 => address == SG_RESULT || ON_WIRE.contains(&address),
            _ => READABLE.contains(&address),
        }
    }

    fn can_be_written(self, address: usize) -> bool {
        let (inputs, _) = self.inputs();
        let is_result = if self.is_on_wire() { matches!(address, IFCNT | SG_RESULT) } else { address == SG4_RESULT };
        address != inputs && !matches!(address, TSTEP | MSCNT | DRV_STATUS) && !is_result
    }
}

/// Driver chip on the board of a driver.
#[derive(Clone, Debug)]
pub struct TmcStealth {
    kind: StealthKind,
    registers: [u32; 128],
    /// Value that the next datagram shifts out.
    answer: u32,
    /// Place in the electrical period: 1024 positions of 1/256 full step.
    microstep_counter: u16,
    last_step_ns: Option<u64>,
    /// Time between the last two steps.
    step_ns: Option<u64>,
    /// Levels of MS1 and MS2: address on a UART, and microsteps until a register says how many.
    address: u8,
    /// Reading of the load measurement: stallGuard2, or stallGuard4 of a TMC2209.
    pub load: u16,
    overheated: bool,
    short_to_ground: [bool; 2],
    short_to_supply: [bool; 2],
    /// Faults of the chip and its motor.
    pub condition: Condition,
    datagrams: u64,
    written: Vec<[u8; 5]>,
}

impl TmcStealth {
    /// Makes a chip fresh from power-on, its enable input as given.
    #[must_use]
    pub fn new(kind: StealthKind, enn_high: bool) -> Self {
        let mut chip = Self {
            kind,
            registers: [0; 128],
            answer: 0,
            microstep_counter: 0,
            last_step_ns: None,
            step_ns: None,
            address: 0,
            load: 0x1FF,
            overheated: false,
            short_to_ground: [false; 2],
            short_to_supply: [false; 2],
            condition: Condition { temperature_c: 40, ..Condition::default() },
            datagrams: 0,
            written: Vec::new(),
        };
        chip.reset();
        chip.set_enn(enn_high);
        chip
    }

    /// Makes a chip on a UART, its pins MS1 and MS2 at this address.
    #[must_use]
    pub fn on_wire(kind: StealthKind, address: u8, enn_high: bool) -> Self {
        Self { address, ..Self::new(kind, enn_high) }
    }

    /// Returns the chip's address on a UART.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.address
    }

    /// Resets the chip after a loss of its supply.
    pub fn reset(&mut self) {
        let (inputs, enn) = self.kind.inputs();
        let levels = self.registers[inputs] & enn;
        self.registers = [0; 128];
        self.registers[inputs] = self.kind.version() << 24 | levels;
        for &(address, value) in self.kind.reset_values() {
            self.registers[address] = value;
        }
        (self.answer, self.microstep_counter, self.last_step_ns, self.step_ns) = (0, 0, None, None);
        (self.overheated, self.short_to_ground, self.short_to_supply) = (false, [false; 2], [false; 2]);
    }

    /// Returns the model of the chip.
    #[must_use]
    pub const fn kind(&self) -> StealthKind {
        self.kind
    }

    /// Returns the contents of a register, readable or not.
    #[must_use]
    pub fn register(&self, address: u8) -> u32 {
        self.registers[usize::from(address & 0x7F)]
    }

    /// Returns the number of datagrams so far.
    #[must_use]
    pub const fn datagrams(&self) -> u64 {
        self.datagrams
    }

    /// Returns every different datagram that wrote something, in the order of its first arrival.
    #[must_use]
    pub fn written(&self) -> &[[u8; 5]] {
        &self.written
    }

    /// Exchanges a datagram of 40 bits. The answer holds the status as select fell, and the value that the
    /// datagram before asked for, or wrote.
    pub fn transfer(&mut self, now_ns: u64, datagram: [u8; 5]) -> [u8; 5] {
        let shown = self.shown(now_ns);
        self.take(now_ns, datagram);
        shown
    }

    /// Returns the bits shifted out after select fell.
    pub fn shown(&mut self, now_ns: u64) -> [u8; 5] {
        if self.condition.silent {
            return [0xFF; 5];
        }
        self.datagrams += 1;
        self.notice_faults();
        let reply = u64::from(self.spi_status(now_ns)) << 32 | u64::from(self.answer);
        let [_, _, _, reply @ ..] = (reply ^ self.bit_error()).to_be_bytes();
        reply
    }

    /// Takes the 40 bits before select rose.
    pub fn take(&mut self, now_ns: u64, datagram: [u8; 5]) {
        if self.condition.silent {
            return;
        }
        let [address, data @ ..] = datagram;
        let (place, data) = (usize::from(address & 0x7F), u32::from_be_bytes(data));
        if address & 0x80 == 0 {
            self.answer = self.read(now_ns, place);
        } else {
            if !self.written.contains(&datagram) {
                self.written.push(datagram);
            }
            self.write(place, data);
            self.answer = data;
        }
    }

    /// Answers a read request over a UART with the register's value, as it leaves the chip.
    pub fn read_wire(&mut self, now_ns: u64, register: u8) -> u32 {
        self.datagrams += 1;
        self.notice_faults();
        self.read(now_ns, usize::from(register & 0x7F)) ^ self.bit_error() as u32
    }

    /// Writes over a UART, and counts the write.
    pub fn write_wire(&mut self, register: u8, data: u32) {
        self.datagrams += 1;
        let [a, b, c, d] = data.to_be_bytes();
        let datagram = [register | 0x80, a, b, c, d];
        if !self.written.contains(&datagram) {
            self.written.push(datagram);
        }
        self.write(usize::from(register & 0x7F), data);
        self.registers[IFCNT] = (self.registers[IFCNT] + 1) & 0xFF;
    }

    /// Returns the bit of this reply that arrives wrong, another one each time.
    fn bit_error(&self) -> u64 {
        let every = u64::from(self.condition.bit_error_every);
        if every == 0 || !self.datagrams.is_multiple_of(every) { 0 } else { 1 << (self.datagrams / every * 7 % 40) }
    }

    fn read(&mut self, now_ns: u64, place: usize) -> u32 {
        if !self.kind.can_be_read(place) {
            return 0;
        }
        match place {
            MSCNT => u32::from(self.microstep_counter),
            DRV_STATUS if self.kind.is_on_wire() => self.wire_status(now_ns),
            DRV_STATUS => self.drv_status(now_ns),
            SG_RESULT if self.kind.is_on_wire() => u32::from(self.load),
            TSTEP => self.step_time(now_ns),
            GSTAT => {
                let value = self.gstat();
                if self.kind == StealthKind::Tmc2130 {
                    self.registers[GSTAT] = 0;
                }
                value
            }
            _ => self.registers[place],
        }
    }

    fn write(&mut self, place: usize, data: u32) {
        match place {
            GSTAT if self.kind == StealthKind::Tmc2130 => {}
            GSTAT => self.registers[GSTAT] &= !data,
            _ if !self.kind.can_be_written(place) => {}
            _ => self.registers[place] = data,
        }
        if self.off_time() == 0 {
            (self.short_to_ground, self.short_to_supply) = ([false; 2], [false; 2]);
        }
    }

    fn gstat(&self) -> u32 {
        self.registers[GSTAT] | u32::from(self.is_shut()) << 1
    }

    fn is_shut(&self) -> bool {
        self.overheated || self.short_to_ground.contains(&true) || self.short_to_supply.contains(&true)
    }

    /// Returns "SPI_STATUS": reset, driver error, stallGuard, standstill.
    fn spi_status(&self, now_ns: u64) -> u8 {
        (self.gstat() & 0b11) as u8 | u8::from(self.stands(now_ns)) << 3
    }

    fn stands(&self, now_ns: u64) -> bool {
        let after_ns = (1 << 20) * 1_000 / self.kind.clock_mhz();
        self.last_step_ns.is_none_or(|last| now_ns.saturating_sub(last) >= after_ns)
    }

    fn drv_status(&self, now_ns: u64) -> u32 {
        let (standing, driving) = (self.stands(now_ns), self.off_time() != 0 && !self.enn_high());
        // Open load can only be seen while the chopper works on a turning motor.
        let open = |coil: usize| self.condition.open_load[coil] && driving && !standing;
        let tells_supply = self.kind != StealthKind::Tmc2130;
        let flags = [
            (12, tells_supply && self.short_to_supply[0]),
            (13, tells_supply && self.short_to_supply[1]),
            (14, tells_supply && self.registers[GCONF] & 1 << 2 != 0 && standing),
            (25, self.overheated),
            (26, self.condition.temperature_c >= PREWARNING_C),
            (27, self.short_to_ground[0]),
            (28, self.short_to_ground[1]),
            (29, open(0)),
            (30, open(1)),
            (31, standing),
        ];
        let scale = self.registers[IHOLD_IRUN] >> if standing { 0 } else { 8 } & 0x1F;
        let load = scale << 16 | u32::from(self.load) & 0x3FF;
        flags.into_iter().fold(load, |word, (bit, set)| word | u32::from(set) << bit)
    }

    /// Returns DRV_STATUS of the chips on a UART.
    fn wire_status(&self, now_ns: u64) -> u32 {
        let (standing, driving) = (self.stands(now_ns), self.off_time() != 0 && !self.enn_high());
        let open = |coil: usize| self.condition.open_load[coil] && driving && !standing;
        let over = |celsius: i32| self.condition.temperature_c >= celsius;
        let flags = [
            (0, over(PREWARNING_C)),
            (1, self.overheated),
            (2, self.short_to_ground[0]),
            (3, self.short_to_ground[1]),
            (4, self.short_to_supply[0]),
            (5, self.short_to_supply[1]),
            (6, open(0)),
            (7, open(1)),
            (8, over(120)),
            (9, over(143)),
            (10, over(150)),
            (11, over(157)),
            (30, self.uses_stealth_chop(now_ns)),
            (31, standing),
        ];
        let scale = self.registers[IHOLD_IRUN] >> if standing { 0 } else { 8 } & 0x1F;
        flags.into_iter().fold(scale << 16, |word, (bit, set)| word | u32::from(set) << bit)
    }

    /// TOFF, CHOPCONF bits 3..0; 0 switches the bridges off.
    #[must_use]
    pub const fn off_time(&self) -> u32 {
        self.registers[CHOPCONF] & 0xF
    }

    /// Microsteps per full step from MRES, CHOPCONF bits 27..24; on a UART from MS1 and MS2, unless
    /// "mstep_reg_select" (GCONF bit 7) is set.
    #[must_use]
    pub const fn microsteps(&self) -> u32 {
        if self.kind.is_on_wire() && self.registers[GCONF] & 1 << 7 == 0 {
            return match self.address {
                0 => 8,
                1 => 32,
                2 => 64,
                _ => 16,
            };
        }
        let mres = self.registers[CHOPCONF] >> 24 & 0xF;
        256 >> (if mres > 8 { 8 } else { mres })
    }

    /// DEDGE, CHOPCONF bit 29.
    #[must_use]
    pub const fn double_edge(&self) -> bool {
        self.registers[CHOPCONF] & 1 << 29 != 0
    }

    const fn enn_high(&self) -> bool {
        let (inputs, enn) = self.kind.inputs();
        self.registers[inputs] & enn != 0
    }

    /// Sets the level of DRV_ENN: high switches the bridges off.
    pub fn set_enn(&mut self, high: bool) {
        let (inputs, enn) = self.kind.inputs();
        self.registers[inputs] = self.registers[inputs] & !enn | if high { enn } else { 0 };
        if high {
            (self.short_to_ground, self.short_to_supply) = ([false; 2], [false; 2]);
        }
    }

    /// Returns whether the bridges drive the motor.
    #[must_use]
    pub fn drives(&self) -> bool {
        self.off_time() != 0 && !self.enn_high() && !self.is_shut()
    }

    /// Peak coil current in motion, amperes, for the resistor on the driver's board, ohms: the RMS value of
    /// the datasheets times the square root of 2.
    #[must_use]
    pub fn peak_current_amps(&self, resistor_ohms: f64) -> f64 {
        let scale = f64::from((self.registers[IHOLD_IRUN] >> 8 & 0x1F) + 1) / 32.0;
        let global = match self.registers[GLOBALSCALER] & 0xFF {
            0 => 1.0,
            share => f64::from(share) / 256.0,
        };
        scale
            * match self.kind {
                StealthKind::Tmc2130 => {
                    let volts = if self.registers[CHOPCONF] & 1 << 17 != 0 { 0.18 } else { 0.32 };
                    volts / (resistor_ohms + 0.02)
                }
                StealthKind::Tmc2208 | StealthKind::Tmc2209 => {
                    let volts = if self.registers[CHOPCONF] & 1 << 17 != 0 { 0.18 } else { 0.325 };
                    volts / (resistor_ohms + 0.02)
                }
                StealthKind::Tmc5160 => global * 0.325 / resistor_ohms,
                StealthKind::Tmc2240 => {
                    let volts = [11_750.0, 24_000.0, 36_000.0, 36_000.0][(self.registers[DRV_CONF] & 3) as usize];
                    global * volts / resistor_ohms
                }
            }
    }

    /// Takes an edge on STEP with DIR at this level. For an active edge the answer is the move of the
    /// microstep counter, in 1/256 full step.
    pub fn step_edge(&mut self, now_ns: u64, rising: bool, dir_high: bool) -> Option<i32> {
        if !(rising || self.double_edge()) {
            return None;
        }
        let size = 256 / self.microsteps() as u16;
        let moved = if dir_high {
            self.microstep_counter.wrapping_sub(size)
        } else {
            self.microstep_counter.wrapping_add(size)
        };
        self.microstep_counter = moved & 0x3FF;
        self.step_ns = self.last_step_ns.replace(now_ns).map(|last| now_ns.saturating_sub(last));
        self.notice_faults();
        Some(if dir_high { -i32::from(size) } else { i32::from(size) })
    }

    fn notice_faults(&mut self) {
        if self.condition.temperature_c >= SHUTDOWN_C {
            self.overheated = true;
        } else if self.condition.temperature_c < PREWARNING_C {
            self.overheated = false;
        }
        if self.off_time() == 0 || self.enn_high() {
            return;
        }
        for coil in 0..2 {
            self.short_to_ground[coil] |= self.condition.short_to_ground[coil];
            // Without flags of its own a TMC2130 shuts down all the same, as for a short to ground.
            if self.kind == StealthKind::Tmc2130 {
                self.short_to_ground[coil] |= self.condition.short_to_supply[coil];
            } else {
                self.short_to_supply[coil] |= self.condition.short_to_supply[coil];
            }
        }
    }
}

mod stall;
#[cfg(test)]
mod tests;
