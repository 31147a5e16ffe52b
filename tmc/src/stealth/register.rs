//! Registers and fields that the driver uses, under their datasheet names ("Register mapping" of each chip).
//! A chip's name at the end of a text limits a field to that chip.

use crate::register::Field;

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

macro_rules! fields {
    ($(#[$doc:meta])* $module:ident;
     $($(#[$field_doc:meta])* $name:ident $datasheet:literal [$lsb:literal; $width:literal])+
     $({ $($item:item)+ })?) => {
        $(#[$doc])*
        pub mod $module {
            use crate::register::Field;
            $($(#[$field_doc])* pub const $name: Field = Field { name: $datasheet, lsb: $lsb, width: $width };)+
            /// All fields of the register.
            pub const FIELDS: &[Field] = &[$($name),+];
            $($($item)+)?
        }
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

fields! {
    /// Fields of the register GCONF.
    gconf;
    /// Enables stealthChop below TPWMTHRS.
    EN_PWM_MODE "en_pwm_mode" [2; 1]
    /// Filters the pulses of STEP for stealthChop. TMC5160, TMC2240; an encoder's in a TMC2130.
    MULTISTEP_FILT "multistep_filt" [3; 1]
    /// DIAG0 is low while stallGuard2 reads a stall; its driver is open otherwise.
    DIAG0_STALL "diag0_stall" [7; 1]
    /// DIAG1 is low while stallGuard2 reads a stall.
    DIAG1_STALL "diag1_stall" [8; 1]
}

fields! {
    /// Fields of the register COOLCONF.
    coolconf;
    /// stallGuard2's threshold, two's complement.
    SGT "sgt" [16; 7]
    /// Measures over four full steps.
    SFILT "sfilt" [24; 1]
    {
        /// Bits of coolStep, at the places of a TMC2590's SMARTEN fields.
        pub const COOL_STEP: u32 = 0xFFFF;
    }
}

fields! {
    /// Fields of the register GSTAT.
    gstat;
    /// The chip has been reset since the flag was cleared: all registers are as after power-up.
    RESET "reset" [0; 1]
    /// Shut down by heat or a short.
    DRV_ERR "drv_err" [1; 1]
    /// The charge pump has too little voltage.
    UV_CP "uv_cp" [2; 1]
    {
        /// Writing this clears all, also `register_reset` and `vm_uvlo` of a TMC2240.
        pub const ALL: u32 = 0b1_1111;
    }
}

fields! {
    /// Fields of the register IOIN.
    ioin;
    /// The enable input: high is off.
    DRV_ENN "drv_enn" [4; 1]
    /// Version of the chip.
    VERSION "version" [24; 8]
}

fields! {
    /// Fields of DRV_CONF of a TMC2240.
    drv_conf;
    /// Full scale with 12 kOhm: 1 A, 2 A, 3 A.
    CURRENT_RANGE "current_range" [0; 2]
}

fields! {
    /// Fields of the register IHOLD_IRUN.
    ihold_irun;
    /// Current scale at rest, in 32nds less one.
    IHOLD "ihold" [0; 5]
    /// Current scale in motion, in 32nds less one.
    IRUN "irun" [8; 5]
    /// Time between two steps down to IHOLD.
    IHOLDDELAY "iholddelay" [16; 4]
}

fields! {
    /// Fields of the register CHOPCONF.
    chopconf;
    /// Off time; 0 shuts the bridges off.
    TOFF "toff" [0; 4]
    /// Hysteresis start - 1.
    HSTRT "hstrt" [4; 3]
    /// Hysteresis end plus 3.
    HEND "hend" [7; 4]
    /// Blanking time of the comparator.
    TBL "tbl" [15; 2]
    /// The lower full-scale voltage. TMC2130.
    VSENSE "vsense" [17; 1]
    /// Passive fast decay time. TMC5160, TMC2240.
    TPFD "tpfd" [20; 4]
    /// Microsteps per full step as 256 >> `mres`.
    MRES "mres" [24; 4]
    /// Interpolation to 256 microsteps.
    INTPOL "intpol" [28; 1]
    /// Both edges of STEP are steps.
    DEDGE "dedge" [29; 1]
    {
        /// Bits that [`crate::Chopper`] fills: off time, hysteresis, mode and blanking, at the places of a
        /// TMC2590's.
        pub const CHOPPER: u32 = 0x1_FFFF;
    }
}

fields! {
    /// Fields of the register DRV_STATUS.
    drv_status;
    /// stallGuard2: 0 for the highest load.
    SG_RESULT "sg_result" [0; 10]
    /// Short to supply, coil A. TMC5160, TMC2240.
    S2VSA "s2vsa" [12; 1]
    /// Short to supply, coil B. TMC5160, TMC2240.
    S2VSB "s2vsb" [13; 1]
    /// stealthChop drives the motor now. TMC5160, TMC2240.
    STEALTH "stealth" [14; 1]
    /// Current scale in force.
    CS_ACTUAL "cs_actual" [16; 5]
    /// stallGuard2 reads a stall.
    STALLGUARD "stallguard" [24; 1]
    /// Shut down by heat.
    OT "ot" [25; 1]
    /// Warning of high temperature.
    OTPW "otpw" [26; 1]
    /// Short to ground, coil A.
    S2GA "s2ga" [27; 1]
    /// Short to ground, coil B.
    S2GB "s2gb" [28; 1]
    /// Open load, coil A.
    OLA "ola" [29; 1]
    /// Open load, coil B.
    OLB "olb" [30; 1]
    /// No step for 2^20 clocks.
    STST "stst" [31; 1]
}

/// Differences of the chips with a UART, TMC2208 and TMC2209: "Register map" of their datasheets. Registers
/// missing here have the addresses of the other chips.
pub mod wire {
    use super::{Field, Register};

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
    pub const SENDDELAY: Field = Field { name: "senddelay", lsb: 8, width: 4 };

    fields! {
        /// Fields of the register GCONF.
        gconf;
        /// The current's reference is the voltage at VREF, as after power-up.
        I_SCALE_ANALOG "i_scale_analog" [0; 1]
        /// Selects spreadCycle at any speed. A high level at the pin SPREAD of a TMC2209 inverts the bit.
        EN_SPREADCYCLE "en_spreadcycle" [2; 1]
        /// The pin PDN_UART is the UART alone.
        PDN_DISABLE "pdn_disable" [6; 1]
        /// Microsteps are those of CHOPCONF, and not of the pins MS1 and MS2.
        MSTEP_REG_SELECT "mstep_reg_select" [7; 1]
        /// Filters the pulses of STEP for stealthChop.
        MULTISTEP_FILT "multistep_filt" [8; 1]
    }

    fields! {
        /// Fields of the register DRV_STATUS.
        drv_status;
        /// Warning of high temperature.
        OTPW "otpw" [0; 1]
        /// Shut down by heat.
        OT "ot" [1; 1]
        /// Short to ground, coil A.
        S2GA "s2ga" [2; 1]
        /// Short to ground, coil B.
        S2GB "s2gb" [3; 1]
        /// Short to supply, coil A.
        S2VSA "s2vsa" [4; 1]
        /// Short to supply, coil B.
        S2VSB "s2vsb" [5; 1]
        /// Open load, coil A.
        OLA "ola" [6; 1]
        /// Open load, coil B.
        OLB "olb" [7; 1]
        /// Current scale in force.
        CS_ACTUAL "cs_actual" [16; 5]
        /// stealthChop drives the motor now.
        STEALTH "stealth" [30; 1]
        /// No step for 2^20 clocks.
        STST "stst" [31; 1]
    }
}
