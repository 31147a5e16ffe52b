//! `[tmc2130]`, `[tmc5160]`, `[tmc2240]`, `[tmc2209]`, `[tmc2226]`: stalls of a motor whose driver is outside
//! the board.

/// The rows of the chips of one family.
macro_rules! outside_stall {
    ($family:ident) => {
        pub mod $family {
            use crate::pin::PinName;
            use crate::schema::actuators::chip;
            use crate::schema::build::{NOT_NEGATIVE, bool, number, pin};
            use crate::schema::{PinRole, Setting};
            use units::MmPerSecond;

            pub const WATCH: Setting = bool(
                "stall_watch",
                "false",
                chip!($family, |chip, v| chip.stall_watch = v),
                "Watch for a stall of the motor while it moves: a carriage that has hit something. Only at a constant speed of \
                 stall_least_speed or more is it seen, and where the chopper drives whose load the chip measures. Set \
                 stall_threshold first, so that the motor never stalls by itself.",
            )
            .velvet();

            pub const OUTPUT: Setting = pin(
                "stall_pin",
                "nc",
                PinRole::Input,
                chip!($family, |chip, v| chip.stall_pin = v.and_then(PinName::digital)),
                "The input that the driver's output DIAG is wired to, for stall_watch. A TMC2209 says stall with a high level; \
                 the chips on SPI with a low one: write !.",
            )
            .derived("the pin of the endstop by which its axis homes without a switch")
            .velvet();

            pub const LEAST_SPEED: Setting = number(
                "stall_least_speed",
                "0",
                NOT_NEGATIVE,
                chip!($family, |chip, v| chip.stall_least_speed = MmPerSecond(v)),
                "Speed of the motor from which on its load says anything.",
            )
            .derived("200 full steps a second")
            .unit("mm/s")
            .velvet();
        }
    };
}

outside_stall!(tmc2130);
outside_stall!(tmc5160);
outside_stall!(tmc2240);
outside_stall!(tmc2209);
outside_stall!(tmc2226);
