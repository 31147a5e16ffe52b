//! Raw register words, for expert settings without a method in [`Driver`].

use super::{CurrentSetting, Driver, Error};
use crate::Chip;
use crate::chopper::in_range;
use crate::register::Registers;
use embedded_hal::spi::SpiDevice;

impl<SPI: SpiDevice> Driver<SPI> {
    /// Stores and sends one raw 20-bit word. The word cannot enable a disabled motor, leave STEP/DIR mode or
    /// change the selected reading; its current fields replace the running current.
    ///
    /// # Errors
    /// [`Error::Setting`] when no register has that address or the off time is 0, else as [`Self::status`].
    pub fn write_raw(&mut self, word: u32) -> Result<(), Error<SPI::Error>> {
        let mut registers = self.registers;
        in_range("register word", "20 bits addressed to one of the five registers", registers.store(word))?;
        in_range("off time", "1 to 15", registers.chopconf.toff() != 0)?;
        self.adopt(registers);
        self.start().map(drop)
    }

    /// Takes all five registers into the copy, as a configuration file or `M911` gives them, in any order;
    /// sends nothing. An off time of 0, as a dump of a disabled motor has, leaves the off time as it was.
    ///
    /// # Errors
    /// [`Error::Setting`] when they are not one word for each register; nothing is stored then.
    pub fn load_registers(&mut self, words: [u32; 5]) -> Result<(), Error<SPI::Error>> {
        let mut registers = Registers::RESET;
        let mut seen = 0_u32;
        for word in words {
            in_range("register words", "20 bits each, one for each register", registers.store(word))?;
            seen |= 1 << (word >> 17);
        }
        in_range("register words", "one for each register", seen.count_ones() == 5)?;
        if registers.chopconf.toff() == 0 {
            registers.chopconf = registers.chopconf.with_toff(self.registers.chopconf.toff());
        }
        self.adopt(registers);
        Ok(())
    }

    fn adopt(&mut self, mut registers: Registers) {
        registers.drvconf = registers.drvconf.with_rdsel(self.registers.drvconf.rdsel()).with_sdoff(0).with_tst(0);
        if self.chip == Chip::Tmc2660 {
            registers.drvconf = registers.drvconf.for_tmc2660();
        }
        let current = |r: &Registers| (r.sgcsconf.cs() as u8, r.drvconf.vsense() == 1);
        if current(&registers) != current(&self.registers) {
            let (cs, low_range) = current(&registers);
            self.run = CurrentSetting::new(self.chip, self.sense_resistor, cs, low_range);
            self.standing = false;
        }
        self.registers = registers;
    }
}
