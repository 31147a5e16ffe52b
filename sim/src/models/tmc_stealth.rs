//! TMC2130, TMC5160 and TMC2240 in STEP/DIR mode, as their SPI and logic pins show them.
//!
//! Sources: TMC2130 datasheet rev. 1.10, TMC5160 datasheet rev. 1.14, TMC2240 datasheet rev. 1, chapters "SPI
//! interface" and "Register mapping".
//!
//! Not modelled: encoder, motion controller, coil currents in time, stealthChop's and coolStep's regulation,
//! readings of the load.

use super::tmc26x::Condition;

/// Which chip is on the driver's board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum StealthKind {
    Tmc2130,
    Tmc5160,
    Tmc2240,
}

const GCONF: usize = 0x00;
const GSTAT: usize = 0x01;
const IOIN: usize = 0x04;
const DRV_CONF: usize = 0x0A;
const GLOBALSCALER: usize = 0x0B;
const IHOLD_IRUN: usize = 0x10;
const TSTEP: usize = 0x12;
const MSCNT: usize = 0x6A;
const CHOPCONF: usize = 0x6C;
const DRV_STATUS: usize = 0x6F;
const PWMCONF: usize = 0x70;
const SG4_RESULT: usize = 0x75;

/// "drv_enn" among the inputs.
const ENN: u32 = 1 << 4;
/// Temperature warning, shutdown, and where a chip that has shut down comes back.
const PREWARNING_C: i32 = 120;
const SHUTDOWN_C: i32 = 150;

impl StealthKind {
    /// "VERSION" of IOIN.
    const fn version(self) -> u32 {
        match self {
            Self::Tmc2130 => 0x11,
            Self::Tmc5160 => 0x30,
            Self::Tmc2240 => 0x40,
        }
    }

    /// Typical frequency of the internal oscillator, MHz.
    const fn clock_mhz(self) -> u64 {
        match self {
            Self::Tmc2130 => 13,
            Self::Tmc5160 | Self::Tmc2240 => 12,
        }
    }

    /// "reset default" of the registers where it is not 0.
    const fn reset_values(self) -> &'static [(usize, u32)] {
        match self {
            Self::Tmc2130 => &[(GSTAT, 1), (PWMCONF, 0x0005_0480)],
            Self::Tmc5160 => &[(GSTAT, 1), (DRV_CONF, 0x0008_0400), (CHOPCONF, 0x1041_0150), (PWMCONF, 0xC40C_001E)],
            Self::Tmc2240 => &[(GSTAT, 1), (CHOPCONF, 0x1041_0150), (PWMCONF, 0xC40C_001D)],
        }
    }

    /// Access "R", "RW", "R+C" or "R+WC": others read as 0. A TMC2240's can all be read.
    fn can_be_read(self, address: usize) -> bool {
        const READABLE: [usize; 7] = [GCONF, GSTAT, IOIN, TSTEP, MSCNT, CHOPCONF, DRV_STATUS];
        self == Self::Tmc2240 || READABLE.contains(&address)
    }

    fn can_be_written(self, address: usize) -> bool {
        !matches!(address, IOIN | TSTEP | MSCNT | DRV_STATUS | SG4_RESULT)
    }
}

/// One chip on the board of a driver.
#[derive(Clone, Debug)]
pub struct TmcStealth {
    kind: StealthKind,
    registers: [u32; 128],
    /// What the next datagram shifts out.
    answer: u32,
    /// Place in the electrical period: 1024 positions of 1/256 full step.
    microstep_counter: u16,
    last_step_ns: Option<u64>,
    overheated: bool,
    short_to_ground: [bool; 2],
    short_to_supply: [bool; 2],
    /// What is wrong with it.
    pub condition: Condition,
    datagrams: u64,
    written: Vec<[u8; 5]>,
}

impl TmcStealth {
    /// A chip fresh from power-on, its enable input as given.
    #[must_use]
    pub fn new(kind: StealthKind, enn_high: bool) -> Self {
        let mut chip = Self {
            kind,
            registers: [0; 128],
            answer: 0,
            microstep_counter: 0,
            last_step_ns: None,
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

    /// Its supply was gone, and is back.
    pub fn reset(&mut self) {
        let inputs = self.registers[IOIN] & ENN;
        self.registers = [0; 128];
        self.registers[IOIN] = self.kind.version() << 24 | inputs;
        for &(address, value) in self.kind.reset_values() {
            self.registers[address] = value;
        }
        (self.answer, self.microstep_counter, self.last_step_ns) = (0, 0, None);
        (self.overheated, self.short_to_ground, self.short_to_supply) = (false, [false; 2], [false; 2]);
    }

    /// Which chip this is.
    #[must_use]
    pub const fn kind(&self) -> StealthKind {
        self.kind
    }

    /// What stands in a register, readable or not.
    #[must_use]
    pub fn register(&self, address: u8) -> u32 {
        self.registers[usize::from(address & 0x7F)]
    }

    /// How many datagrams have come.
    #[must_use]
    pub const fn datagrams(&self) -> u64 {
        self.datagrams
    }

    /// Every different datagram that wrote something, in the order in which it first came.
    #[must_use]
    pub fn written(&self) -> &[[u8; 5]] {
        &self.written
    }

    /// One datagram of 40 bits. Back come the status as select fell, and what the one before asked for, or
    /// wrote.
    pub fn transfer(&mut self, now_ns: u64, datagram: [u8; 5]) -> [u8; 5] {
        if self.condition.silent {
            return [0xFF; 5];
        }
        self.datagrams += 1;
        self.notice_faults();
        let reply = u64::from(self.spi_status(now_ns)) << 32 | u64::from(self.answer);
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
        let [_, _, _, reply @ ..] = (reply ^ self.bit_error()).to_be_bytes();
        reply
    }

    /// The bit of this reply that arrives wrong, another one each time.
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
            DRV_STATUS => self.drv_status(now_ns),
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

    /// "SPI_STATUS": reset, driver error, stallGuard, standstill.
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
        flags.into_iter().fold(scale << 16, |word, (bit, set)| word | u32::from(set) << bit)
    }

    /// TOFF, CHOPCONF bits 3..0; 0 switches the bridges off.
    #[must_use]
    pub const fn off_time(&self) -> u32 {
        self.registers[CHOPCONF] & 0xF
    }

    /// Microsteps per full step from MRES, CHOPCONF bits 27..24.
    #[must_use]
    pub const fn microsteps(&self) -> u32 {
        let mres = self.registers[CHOPCONF] >> 24 & 0xF;
        256 >> (if mres > 8 { 8 } else { mres })
    }

    /// DEDGE, CHOPCONF bit 29.
    #[must_use]
    pub const fn double_edge(&self) -> bool {
        self.registers[CHOPCONF] & 1 << 29 != 0
    }

    const fn enn_high(&self) -> bool {
        self.registers[IOIN] & ENN != 0
    }

    /// The level of DRV_ENN: high switches the bridges off.
    pub fn set_enn(&mut self, high: bool) {
        self.registers[IOIN] = self.registers[IOIN] & !ENN | if high { ENN } else { 0 };
        if high {
            (self.short_to_ground, self.short_to_supply) = ([false; 2], [false; 2]);
        }
    }

    /// The bridges drive the motor.
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
                StealthKind::Tmc5160 => global * 0.325 / resistor_ohms,
                StealthKind::Tmc2240 => {
                    let volts = [11_750.0, 24_000.0, 36_000.0, 36_000.0][(self.registers[DRV_CONF] & 3) as usize];
                    global * volts / resistor_ohms
                }
            }
    }

    /// An edge on STEP with DIR at this level. When it is an active edge, answers how far the microstep
    /// counter moves, in 1/256 full step.
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
        self.last_step_ns = Some(now_ns);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(chip: &mut TmcStealth, address: u8) -> u32 {
        chip.transfer(0, [address, 0, 0, 0, 0]);
        let [_, data @ ..] = chip.transfer(0, [address, 0, 0, 0, 0]);
        u32::from_be_bytes(data)
    }

    #[test]
    fn the_answer_comes_with_the_next_datagram() {
        let mut chip = TmcStealth::new(StealthKind::Tmc5160, false);
        chip.transfer(0, [0x6C, 0, 0, 0, 0]);
        assert_eq!(chip.transfer(0, [0x04, 0, 0, 0, 0])[1..], [0x10, 0x41, 0x01, 0x50]);
        assert_eq!(chip.transfer(0, [0xEC, 1, 2, 3, 4])[1..], [0x30, 0, 0, 0]);
        assert_eq!(chip.transfer(0, [0, 0, 0, 0, 0])[1..], [1, 2, 3, 4], "what was written");
    }

    #[test]
    fn a_reset_is_flagged_until_it_is_cleared_as_each_chip_wants_it() {
        for kind in [StealthKind::Tmc5160, StealthKind::Tmc2240] {
            let mut chip = TmcStealth::new(kind, false);
            assert_eq!((read(&mut chip, 1), read(&mut chip, 1)), (1, 1));
            chip.transfer(0, [0x81, 0, 0, 0, 1]);
            assert_eq!(read(&mut chip, 1), 0);
        }
        let mut chip = TmcStealth::new(StealthKind::Tmc2130, false);
        chip.transfer(0, [1, 0, 0, 0, 0]);
        assert_eq!(chip.transfer(0, [1, 0, 0, 0, 0])[4], 1);
        assert_eq!(chip.transfer(0, [1, 0, 0, 0, 0])[4], 0, "reading clears");
    }

    #[test]
    fn shorts_and_heat_shut_the_bridges() {
        let mut chip = TmcStealth::new(StealthKind::Tmc5160, false);
        chip.transfer(0, [0xEC, 0, 0, 0, 3]);
        assert!(chip.drives());
        chip.condition.short_to_supply[0] = true;
        assert_eq!(read(&mut chip, 0x6F) & 1 << 12, 1 << 12);
        assert!(!chip.drives());
        chip.condition.short_to_supply[0] = false;
        chip.transfer(0, [0xEC, 0, 0, 0, 0]);
        chip.transfer(0, [0xEC, 0, 0, 0, 3]);
        assert!(chip.drives(), "off and on again");
        chip.condition.temperature_c = 155;
        assert_eq!(read(&mut chip, 0x6F) >> 25 & 0b11, 0b11);
        assert!(!chip.drives());
    }
}
