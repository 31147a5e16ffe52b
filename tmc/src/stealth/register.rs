//! Registers and fields that the driver uses, under their datasheet names ("Register mapping" of each chip).
//! A chip's name at the end of a text limits a field to that chip.

use crate::register::Field;

const fn field(name: &'static str, lsb: u32, width: u32) -> Field {
    Field { name, lsb, width }
}

/// Register of a stealthChop chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register {
    /// Register name in the datasheet.
    pub name: &'static str,
    /// Address, 0 to 0x7F.
    pub address: u8,
}

macro_rules! registers {
    ($($(#[$doc:meta])* $name:ident $address:literal)+) => {
        $($(#[$doc])* pub const $name: Register = Register { name: stringify!($name), address: $address };)+
        /// All registers of this list.
        pub const ALL: &[Register] = &[$($name),+];
    };
}

registers! {
    /// General configuration of the chip.
    GCONF 0x00
    /// Reset, fault and charge pump, latched.
    GSTAT 0x01
    /// Levels of the inputs, and the chip's version.
    IOIN 0x04
    /// Current range and slopes of a TMC2240. The slopes of a TMC5160's MOSFETs keep their reset values.
    DRV_CONF 0x0A
    /// Share of full scale in 256ths, 0 for all. TMC5160, TMC2240.
    GLOBALSCALER 0x0B
    /// Current scales at rest and in motion. Write only.
    IHOLD_IRUN 0x10
    /// Time until IHOLD. Write only.
    TPOWERDOWN 0x11
    /// Time between two steps of 1/256.
    TSTEP 0x12
    /// Highest speed of stealthChop, as a TSTEP. Write only.
    TPWMTHRS 0x13
    /// Least speed of coolStep and of the stall output, as a TSTEP. Write only.
    TCOOLTHRS 0x14
    /// Least speed of the chopper for high speeds, as a TSTEP; 0 never. Write only.
    THIGH 0x15
    /// Place in the sine table.
    MSCNT 0x6A
    /// Chopper settings and microsteps.
    CHOPCONF 0x6C
    /// coolStep and stallGuard2. Write only.
    COOLCONF 0x6D
    /// Status of the bridges.
    DRV_STATUS 0x6F
    /// Amplitude settings of stealthChop. Write only.
    PWMCONF 0x70
    /// stallGuard4, which works with stealthChop. TMC2240.
    SG4_RESULT 0x75
}

/// Fields of the register GCONF.
pub mod gconf {
    use super::{Field, field};
    /// Enables stealthChop below TPWMTHRS.
    pub const EN_PWM_MODE: Field = field("en_pwm_mode", 2, 1);
    /// Filters the pulses of STEP for stealthChop. TMC5160, TMC2240; an encoder's in a TMC2130.
    pub const MULTISTEP_FILT: Field = field("multistep_filt", 3, 1);
    /// DIAG0 is low while stallGuard2 reads a stall; its driver is open otherwise.
    pub const DIAG0_STALL: Field = field("diag0_stall", 7, 1);
    /// DIAG1 is low while stallGuard2 reads a stall.
    pub const DIAG1_STALL: Field = field("diag1_stall", 8, 1);
    /// All fields of GCONF.
    pub const FIELDS: &[Field] = &[EN_PWM_MODE, MULTISTEP_FILT, DIAG0_STALL, DIAG1_STALL];
}

/// Fields of the register COOLCONF.
pub mod coolconf {
    use super::{Field, field};
    /// Bits of coolStep, at the places of a TMC2590's SMARTEN fields.
    pub const COOL_STEP: u32 = 0xFFFF;
    /// stallGuard2's threshold, two's complement.
    pub const SGT: Field = field("sgt", 16, 7);
    /// Measures over four full steps.
    pub const SFILT: Field = field("sfilt", 24, 1);
    /// All fields of COOLCONF.
    pub const FIELDS: &[Field] = &[SGT, SFILT];
}

/// Fields of the register GSTAT.
pub mod gstat {
    use super::{Field, field};
    /// The chip has been reset since the flag was cleared: all registers are as after power-up.
    pub const RESET: Field = field("reset", 0, 1);
    /// Shut down by heat or a short.
    pub const DRV_ERR: Field = field("drv_err", 1, 1);
    /// The charge pump has too little voltage.
    pub const UV_CP: Field = field("uv_cp", 2, 1);
    /// Writing this clears all, also `register_reset` and `vm_uvlo` of a TMC2240.
    pub const ALL: u32 = 0b1_1111;
    /// All fields of GSTAT.
    pub const FIELDS: &[Field] = &[RESET, DRV_ERR, UV_CP];
}

/// Fields of the register IOIN.
pub mod ioin {
    use super::{Field, field};
    /// The enable input: high is off.
    pub const DRV_ENN: Field = field("drv_enn", 4, 1);
    /// Version of the chip.
    pub const VERSION: Field = field("version", 24, 8);
    /// All fields of IOIN.
    pub const FIELDS: &[Field] = &[DRV_ENN, VERSION];
}

/// Fields of DRV_CONF of a TMC2240.
pub mod drv_conf {
    use super::{Field, field};
    /// Full scale with 12 kOhm: 1 A, 2 A, 3 A.
    pub const CURRENT_RANGE: Field = field("current_range", 0, 2);
    /// All fields of DRV_CONF.
    pub const FIELDS: &[Field] = &[CURRENT_RANGE];
}

/// Fields of the register IHOLD_IRUN.
pub mod ihold_irun {
    use super::{Field, field};
    /// Current scale at rest, in 32nds less one.
    pub const IHOLD: Field = field("ihold", 0, 5);
    /// Current scale in motion, in 32nds less one.
    pub const IRUN: Field = field("irun", 8, 5);
    /// Time between two steps down to IHOLD.
    pub const IHOLDDELAY: Field = field("iholddelay", 16, 4);
    /// All fields of IHOLD_IRUN.
    pub const FIELDS: &[Field] = &[IHOLD, IRUN, IHOLDDELAY];
}

/// Fields of the register CHOPCONF.
pub mod chopconf {
    use super::{Field, field};
    /// Off time; 0 shuts the bridges off.
    pub const TOFF: Field = field("toff", 0, 4);
    /// Hysteresis start - 1.
    pub const HSTRT: Field = field("hstrt", 4, 3);
    /// Hysteresis end plus 3.
    pub const HEND: Field = field("hend", 7, 4);
    /// Blanking time of the comparator.
    pub const TBL: Field = field("tbl", 15, 2);
    /// The lower full-scale voltage. TMC2130.
    pub const VSENSE: Field = field("vsense", 17, 1);
    /// Passive fast decay time. TMC5160, TMC2240.
    pub const TPFD: Field = field("tpfd", 20, 4);
    /// Microsteps per full step as 256 >> `mres`.
    pub const MRES: Field = field("mres", 24, 4);
    /// Interpolation to 256 microsteps.
    pub const INTPOL: Field = field("intpol", 28, 1);
    /// Both edges of STEP are steps.
    pub const DEDGE: Field = field("dedge", 29, 1);
    /// All fields of CHOPCONF.
    pub const FIELDS: &[Field] = &[TOFF, HSTRT, HEND, TBL, VSENSE, TPFD, MRES, INTPOL, DEDGE];
    /// Bits that [`crate::Chopper`] fills: off time, hysteresis, mode and blanking, at the places of a
    /// TMC2590's.
    pub const CHOPPER: u32 = 0x1_FFFF;
}

/// Fields of the register DRV_STATUS.
pub mod drv_status {
    use super::{Field, field};
    /// stallGuard2: 0 for the highest load.
    pub const SG_RESULT: Field = field("sg_result", 0, 10);
    /// Short to supply, coil A. TMC5160, TMC2240.
    pub const S2VSA: Field = field("s2vsa", 12, 1);
    /// Short to supply, coil B. TMC5160, TMC2240.
    pub const S2VSB: Field = field("s2vsb", 13, 1);
    /// stealthChop drives the motor now. TMC5160, TMC2240.
    pub const STEALTH: Field = field("stealth", 14, 1);
    /// Current scale in force.
    pub const CS_ACTUAL: Field = field("cs_actual", 16, 5);
    /// stallGuard2 reads a stall.
    pub const STALLGUARD: Field = field("stallguard", 24, 1);
    /// Shut down by heat.
    pub const OT: Field = field("ot", 25, 1);
    /// Warning of high temperature.
    pub const OTPW: Field = field("otpw", 26, 1);
    /// Short to ground, coil A.
    pub const S2GA: Field = field("s2ga", 27, 1);
    /// Short to ground, coil B.
    pub const S2GB: Field = field("s2gb", 28, 1);
    /// Open load, coil A.
    pub const OLA: Field = field("ola", 29, 1);
    /// Open load, coil B.
    pub const OLB: Field = field("olb", 30, 1);
    /// No step for 2^20 clocks.
    pub const STST: Field = field("stst", 31, 1);
    /// All fields of DRV_STATUS.
    pub const FIELDS: &[Field] =
        &[SG_RESULT, S2VSA, S2VSB, STEALTH, CS_ACTUAL, STALLGUARD, OT, OTPW, S2GA, S2GB, OLA, OLB, STST];
}

/// Differences of the chips with a UART, TMC2208 and TMC2209: "Register map" of their datasheets. Registers
/// missing here have the addresses of the other chips.
pub mod wire {
    use super::{Field, Register, field};

    macro_rules! registers {
        ($($(#[$doc:meta])* $name:ident $address:literal)+) => {
            $($(#[$doc])* pub const $name: Register = Register { name: stringify!($name), address: $address };)+
            /// All registers of this list.
            pub const ALL: &[Register] = &[$($name),+];
        };
    }

    registers! {
        /// Number of writes that have arrived, 8 bits, wrapping.
        IFCNT 0x02
        /// Time from a request to its answer.
        SLAVECONF 0x03
        /// Levels of the inputs, and the chip's version.
        IOIN 0x06
        /// Half of the greatest stallGuard4 reading that is a stall. Write only. TMC2209.
        SGTHRS 0x40
        /// Load reading of stallGuard4. TMC2209.
        SG_RESULT 0x41
        /// Settings of coolStep. Write only. TMC2209.
        COOLCONF 0x42
    }

    /// SENDDELAY: three times eight bit times, the least with which drivers of one line do not take each
    /// other's answers for requests.
    pub const SENDDELAY: Field = field("senddelay", 8, 4);

    /// Fields of the register GCONF.
    pub mod gconf {
        use super::{Field, field};
        /// The current's reference is the voltage at VREF, as after power-up.
        pub const I_SCALE_ANALOG: Field = field("i_scale_analog", 0, 1);
        /// Selects spreadCycle at any speed. A high level at the pin SPREAD of a TMC2209 inverts the bit.
        pub const EN_SPREADCYCLE: Field = field("en_spreadcycle", 2, 1);
        /// The pin PDN_UART is the UART alone.
        pub const PDN_DISABLE: Field = field("pdn_disable", 6, 1);
        /// Microsteps are those of CHOPCONF, and not of the pins MS1 and MS2.
        pub const MSTEP_REG_SELECT: Field = field("mstep_reg_select", 7, 1);
        /// Filters the pulses of STEP for stealthChop.
        pub const MULTISTEP_FILT: Field = field("multistep_filt", 8, 1);
        /// All fields of GCONF.
        pub const FIELDS: &[Field] = &[I_SCALE_ANALOG, EN_SPREADCYCLE, PDN_DISABLE, MSTEP_REG_SELECT, MULTISTEP_FILT];
    }

    /// Fields of the register DRV_STATUS.
    pub mod drv_status {
        use super::{Field, field};
        /// Warning of high temperature.
        pub const OTPW: Field = field("otpw", 0, 1);
        /// Shut down by heat.
        pub const OT: Field = field("ot", 1, 1);
        /// Short to ground, coil A.
        pub const S2GA: Field = field("s2ga", 2, 1);
        /// Short to ground, coil B.
        pub const S2GB: Field = field("s2gb", 3, 1);
        /// Short to supply, coil A.
        pub const S2VSA: Field = field("s2vsa", 4, 1);
        /// Short to supply, coil B.
        pub const S2VSB: Field = field("s2vsb", 5, 1);
        /// Open load, coil A.
        pub const OLA: Field = field("ola", 6, 1);
        /// Open load, coil B.
        pub const OLB: Field = field("olb", 7, 1);
        /// Current scale in force.
        pub const CS_ACTUAL: Field = field("cs_actual", 16, 5);
        /// stealthChop drives the motor now.
        pub const STEALTH: Field = field("stealth", 30, 1);
        /// No step for 2^20 clocks.
        pub const STST: Field = field("stst", 31, 1);
        /// All fields of DRV_STATUS.
        pub const FIELDS: &[Field] = &[OTPW, OT, S2GA, S2GB, S2VSA, S2VSB, OLA, OLB, CS_ACTUAL, STEALTH, STST];
    }
}
