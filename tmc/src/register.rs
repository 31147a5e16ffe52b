//! The five write-only registers and their fields, as the TMC2590 datasheet V1.0 section 7.4.1 lays them out
//! (TMC2660 datasheet Rev. 1.05 section 6.4.1: the same, less the fields marked "TMC2590 only").
//!
//! A register is a 20-bit word; bits 19 to 17 are its address. Bits without a field must be written as 0.

/// Bits of one register word.
pub const WORD_BITS: u32 = 20;
/// All bits of a register word.
pub const WORD_MASK: u32 = (1 << WORD_BITS) - 1;
/// Position of the address in the word.
pub const ADDRESS: Field = Field { name: "address", lsb: 17, width: 3 };

/// Named bit field of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Field name in the datasheet.
    pub name: &'static str,
    /// Number of the lowest bit.
    pub lsb: u32,
    /// Width in bits.
    pub width: u32,
}

impl Field {
    /// Largest value the field holds.
    #[must_use]
    pub const fn max(self) -> u32 {
        (1 << self.width) - 1
    }

    /// Returns the mask of the field's bits in the word.
    #[must_use]
    pub const fn mask(self) -> u32 {
        self.max() << self.lsb
    }

    /// Returns the field's value in `word`.
    #[must_use]
    pub const fn get(self, word: u32) -> u32 {
        (word & self.mask()) >> self.lsb
    }

    /// Returns `word` with this field holding `value`; a value the field cannot hold becomes its largest.
    #[must_use]
    pub const fn put(self, word: u32, value: u32) -> u32 {
        let value = if value > self.max() { self.max() } else { value };
        word & !self.mask() | value << self.lsb
    }
}

/// Returns whether no two fields, nor a field and the address, share a bit, and all fit the word.
const fn disjoint(fields: &[Field]) -> bool {
    let mut taken = ADDRESS.mask();
    let mut index = 0;
    while index < fields.len() {
        let mask = fields[index].mask();
        if taken & mask != 0 || mask & !WORD_MASK != 0 {
            return false;
        }
        taken |= mask;
        index += 1;
    }
    true
}

macro_rules! register {
    ($(#[$doc:meta])* $name:ident, $datasheet:literal, address $address:literal;
     $($(#[$field_doc:meta])* $field:literal $get:ident $with:ident [$lsb:literal; $width:literal])+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name(u32);

        impl $name {
            /// Register name in the datasheet.
            pub const NAME: &'static str = $datasheet;
            /// Address in bits 19 to 17 of the word.
            pub const ADDRESS: u32 = $address;
            /// All fields of the register.
            pub const FIELDS: &'static [Field] =
                &[$(Field { name: $field, lsb: $lsb, width: $width }),+];
            /// The register with every field zero, as after power-up.
            pub const RESET: Self = Self($address << ADDRESS.lsb);

            /// Returns the register a 20-bit word writes, if the word is addressed to it; bits that no field
            /// names are dropped.
            #[must_use]
            pub const fn from_word(word: u32) -> Option<Self> {
                if ADDRESS.get(word) != $address || word & !WORD_MASK != 0 {
                    return None;
                }
                let mut fields = 0;
                let mut index = 0;
                while index < Self::FIELDS.len() {
                    fields |= word & Self::FIELDS[index].mask();
                    index += 1;
                }
                Some(Self(Self::RESET.0 | fields))
            }

            /// The 20-bit word, address included.
            #[must_use]
            pub const fn word(self) -> u32 {
                self.0
            }

            $(
                $(#[$field_doc])*
                #[must_use]
                pub const fn $get(self) -> u32 {
                    Field { name: $field, lsb: $lsb, width: $width }.get(self.0)
                }

                #[doc = concat!("With `", $field, "` set; a value the field cannot hold becomes its largest.")]
                #[must_use]
                pub const fn $with(self, value: u32) -> Self {
                    Self(Field { name: $field, lsb: $lsb, width: $width }.put(self.0, value))
                }
            )+
        }

        const _: () = assert!(disjoint($name::FIELDS), concat!("fields of ", $datasheet, " overlap"));
    };
}

register! {
    /// Driver control in STEP/DIR mode (`SDOFF` = 0). TMC2590 section 7.5.2, TMC2660 section 6.5.2.
    DrvCtrl, "DRVCTRL", address 0b000;
    /// Multiply STEP pulses by 16 (MicroPlyer).
    "INTPOL" intpol with_intpol [9; 1]
    /// Both edges of STEP are steps.
    "DEDGE" dedge with_dedge [8; 1]
    /// Microsteps per full step as 256 >> `MRES`; 8 is full steps.
    "MRES" mres with_mres [0; 4]
}

register! {
    /// Chopper control. TMC2590 section 7.6, TMC2660 section 6.6.
    ChopConf, "CHOPCONF", address 0b100;
    /// Blanking time after a switching event: 16, 24, 36, 54 clocks.
    "TBL" tbl with_tbl [15; 2]
    /// Chopper mode: 0 spreadCycle, 1 constant off time.
    "CHM" chm with_chm [14; 1]
    /// Random modulation of the off time.
    "RNDTF" rndtf with_rndtf [13; 1]
    /// spreadCycle: hysteresis decrement period 16, 32, 48, 64 clocks. Constant off time: bit 1 leaves the
    /// fast decay to the timer alone, bit 0 is the top bit of the fast decay time.
    "HDEC" hdec with_hdec [11; 2]
    /// spreadCycle: hysteresis end + 3. Constant off time: sine wave offset + 3.
    "HEND" hend with_hend [7; 4]
    /// spreadCycle: hysteresis start - 1. Constant off time: low bits of the fast decay time.
    "HSTRT" hstrt with_hstrt [4; 3]
    /// Off time, 24 + 32 `TOFF` clocks; 0 shuts the bridges off.
    "TOFF" toff with_toff [0; 4]
}

register! {
    /// coolStep control. TMC2590 section 7.7, TMC2660 section 6.7.
    SmartEn, "SMARTEN", address 0b101;
    /// Lowest coolStep current: 0 half of `CS`, 1 a quarter.
    "SEIMIN" seimin with_seimin [15; 1]
    /// stallGuard2 readings at or above the upper threshold per current decrement: 32, 8, 2, 1.
    "SEDN" sedn with_sedn [13; 2]
    /// Upper threshold: (`SEMIN` + `SEMAX` + 1) * 32.
    "SEMAX" semax with_semax [8; 4]
    /// Current increment per reading below the lower threshold: 1, 2, 4, 8.
    "SEUP" seup with_seup [5; 2]
    /// Lower threshold `SEMIN` * 32; 0 turns coolStep off.
    "SEMIN" semin with_semin [0; 4]
}

register! {
    /// stallGuard2 and current. TMC2590 section 7.8, TMC2660 section 6.8.
    SgCsConf, "SGCSCONF", address 0b110;
    /// Filter stallGuard2 over four full steps.
    "SFILT" sfilt with_sfilt [16; 1]
    /// stallGuard2 threshold, seven bits of two's complement.
    "SGT" sgt with_sgt [8; 7]
    /// Current scale: (`CS` + 1) / 32 of full scale.
    "CS" cs with_cs [0; 5]
}

register! {
    /// Driver configuration. TMC2590 section 7.9, TMC2660 section 6.9.
    DrvConf, "DRVCONF", address 0b111;
    /// Test mode of the maker; always 0.
    "TST" tst with_tst [16; 1]
    /// Slope of the high side.
    "SLPH" slph with_slph [14; 2]
    /// Slope of the low side.
    "SLPL" slpl with_slpl [12; 2]
    /// Top bit of both slopes. TMC2590 only.
    "SLP2" slp2 with_slp2 [11; 1]
    /// Short to ground protection off.
    "DIS_S2G" dis_s2g with_dis_s2g [10; 1]
    /// Short detection delay: 3.2, 1.6, 1.2, 0.8 us.
    "TS2G" ts2g with_ts2g [8; 2]
    /// STEP/DIR inputs off, coil currents by SPI.
    "SDOFF" sdoff with_sdoff [7; 1]
    /// Full-scale sense voltage: 0 the higher, 1 the lower.
    "VSENSE" vsense with_vsense [6; 1]
    /// Reading shown in bits 19 to 10 of the answer.
    "RDSEL" rdsel with_rdsel [4; 2]
    /// Overtemperature shutdown: 0 at 150 C, 1 at 136 C. TMC2590 only.
    "OTSENS" otsens with_otsens [3; 1]
    /// Short to ground sensitivity: 1 high. TMC2590 only.
    "SHRTSENS" shrtsens with_shrtsens [2; 1]
    /// Passive fast decay; lowers the supply limit from 7 V to 4.5 V. TMC2590 only.
    "EN_PFD" en_pfd with_en_pfd [1; 1]
    /// Short to supply and overcurrent protection on the low side. TMC2590 only.
    "EN_S2VS" en_s2vs with_en_s2vs [0; 1]
}

impl SgCsConf {
    /// Returns `SGT` as a signed number, -64 to 63.
    #[must_use]
    pub const fn threshold(self) -> i8 {
        // Sign extension: the sign bit goes to the top and back.
        ((self.sgt() << 1) as u8).cast_signed() >> 1
    }
}

impl DrvConf {
    /// Sets both slopes to this strength: two bits for each side, and above them, on a TMC2590, the common
    /// bit.
    #[must_use]
    pub const fn with_slopes(self, strength: u8) -> Self {
        let (low_bits, top_bit) = (strength as u32 & 0b11, strength as u32 >> 2 & 1);
        self.with_slph(low_bits).with_slpl(low_bits).with_slp2(top_bit)
    }

    /// Mask of the fields that a TMC2660 does not have and needs as 0.
    const TMC2590_ONLY: u32 = 1 << 11 | 0b1111;

    /// Clears the fields that a TMC2660 does not have.
    #[must_use]
    pub const fn for_tmc2660(self) -> Self {
        Self(self.0 & !Self::TMC2590_ONLY)
    }
}

/// All five registers, the copy a driver keeps because the chip cannot be read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the registers' names are the meaning")]
pub struct Registers {
    pub drvctrl: DrvCtrl,
    pub chopconf: ChopConf,
    pub smarten: SmartEn,
    pub sgcsconf: SgCsConf,
    pub drvconf: DrvConf,
}

impl Registers {
    /// Every field zero: bridges off.
    pub const RESET: Self = Self {
        drvctrl: DrvCtrl::RESET,
        chopconf: ChopConf::RESET,
        smarten: SmartEn::RESET,
        sgcsconf: SgCsConf::RESET,
        drvconf: DrvConf::RESET,
    };

    /// Returns the five words in address order.
    #[must_use]
    pub const fn words(&self) -> [u32; 5] {
        [self.drvctrl.word(), self.chopconf.word(), self.smarten.word(), self.sgcsconf.word(), self.drvconf.word()]
    }

    /// Stores `word` in the register it is addressed to. Returns whether a register has that address.
    #[must_use = "a word no register takes was not stored"]
    pub const fn store(&mut self, word: u32) -> bool {
        if let Some(register) = DrvCtrl::from_word(word) {
            self.drvctrl = register;
        } else if let Some(register) = ChopConf::from_word(word) {
            self.chopconf = register;
        } else if let Some(register) = SmartEn::from_word(word) {
            self.smarten = register;
        } else if let Some(register) = SgCsConf::from_word(word) {
            self.sgcsconf = register;
        } else if let Some(register) = DrvConf::from_word(word) {
            self.drvconf = register;
        } else {
            return false;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_word_with_a_register_s_address_survives_the_round_trip(word in 0..=WORD_MASK) {
            let mut registers = Registers::RESET;
            let address = ADDRESS.get(word);
            let taken = registers.store(word);
            prop_assert_eq!(taken, matches!(address, 0b000 | 0b100..=0b111));
            if taken {
                let stored = registers.words().into_iter().find(|w| ADDRESS.get(*w) == address).unwrap();
                // Only bits without a name may be lost.
                prop_assert_eq!(stored & !word, 0);
                let mut again = Registers::RESET;
                prop_assert!(again.store(stored));
                prop_assert_eq!(again, registers);
            }
        }

        #[test]
        fn setting_a_field_changes_that_field_only(word in 0..=WORD_MASK, lsb in 0_u32..17, width in 1_u32..4, value in 0_u32..16) {
            let field = Field { name: "any", lsb, width };
            let after = field.put(word, value);
            prop_assert_eq!(field.get(after), value.min(field.max()));
            prop_assert_eq!(after & !field.mask(), word & !field.mask());
        }
    }

    #[test]
    fn fields_stand_where_the_datasheet_has_them() {
        assert_eq!(DrvCtrl::RESET.with_intpol(1).with_dedge(1).with_mres(4).word(), 0x0_0304);
        assert_eq!(ChopConf::RESET.with_tbl(3).with_hend(3).with_hstrt(4).with_toff(5).word(), 0x9_81C5);
        assert_eq!(
            SmartEn::RESET.with_seimin(1).with_sedn(3).with_semax(15).with_seup(3).with_semin(15).word(),
            0xA_EF6F
        );
        assert_eq!(SgCsConf::RESET.with_sfilt(1).with_sgt(10).with_cs(31).word(), 0xD_0A1F);
        let drvconf = DrvConf::RESET.with_slph(3).with_slpl(3).with_slp2(1).with_rdsel(3).with_vsense(1);
        assert_eq!(drvconf.word(), 0xE_F870);
        assert_eq!(drvconf.with_otsens(1).for_tmc2660().word(), 0xE_F070);
    }

    #[test]
    fn overlapping_fields_are_noticed() {
        let twin = Field { name: "twin", lsb: 3, width: 2 };
        assert!(!disjoint(&[twin, Field { name: "other", lsb: 4, width: 1 }]));
        assert!(!disjoint(&[Field { name: "in the address", lsb: 16, width: 2 }]));
        assert!(disjoint(&[twin]));
    }
}
