//! `[tmc2590]` and `[tmc2660]`: what a driver makes of the load that it measures.

/// The settings of the chips of one family.
macro_rules! load_settings {
    ($family:ident) => {
        pub mod $family {
            use crate::machine::{MachineConfig, TmcConfig};
            use crate::schema::{Setting, Words};
            use crate::schema::build::{NOT_NEGATIVE, bool, integer, number, word};
            use units::MmPerSecond;

            const UP: &Words = &Words(&["1", "2", "4", "8"]);
            const DOWN: &Words = &Words(&["32", "8", "2", "1"]);
            const LEAST: &Words = &Words(&["half", "quarter"]);

            fn of(config: &mut MachineConfig, place: usize) -> Option<&mut TmcConfig> {
                config.$family.axes.0.get_mut(place)
            }

            /// `|chip, value| ...` on the chip at the instance's place.
            macro_rules! chip {
                (|$chip:ident, $value:ident| $body:expr) => {
                    |c, i, $value| {
                        if let Some($chip) = of(c, i) {
                            $body;
                        }
                    }
                };
            }

            pub const THRESHOLD: Setting = integer(
                "stall_threshold",
                "10",
                &(-64, 63),
                chip!(|chip, v| chip.stall_threshold = Some(v as i8)),
                "Shifts what the driver measures of the load (SGT), which coolStep goes by: lower reads lower. Homing without a \
                 switch has a threshold of its own, in [endstops].",
            )
            .klipper("[tmc2660 <stepper>] driver_SGT")
            .derived("10, or what reg says")
            .velvet();

            pub const FILTER: Setting = bool(
                "stall_filter",
                "true",
                chip!(|chip, v| chip.stall_filter = Some(v)),
                "Measures over four full steps rather than one (SFILT).",
            )
            .klipper("[tmc2660 <stepper>] driver_SFILT")
            .derived("true, or what reg says")
            .velvet();

            pub const WATCH: Setting = bool(
                "stall_watch",
                "false",
                chip!(|chip, v| chip.stall_watch = v),
                "Watch for a stall of the motor while it moves: a carriage that has hit something. Only at a constant speed of \
                 stall_least_speed or more is it seen. Set stall_threshold first, so that the motor never stalls by itself.",
            )
            .velvet();

            pub const LEAST_SPEED: Setting = number(
                "stall_least_speed",
                "0",
                NOT_NEGATIVE,
                chip!(|chip, v| chip.stall_least_speed = MmPerSecond(v)),
                "Speed of the motor from which on its load says anything.",
            )
            .derived("200 full steps a second")
            .unit("mm/s")
            .velvet();

            pub const LOWER: Setting = integer(
                "coolstep_lower",
                "0",
                &(0, 480),
                chip!(|chip, v| chip.cool_step.lower = v as u16),
                "Lets the driver lower the current by itself where the load is small, and raise it below this reading of the \
                 load (M911 says it; 32 SEMIN): a multiple of 32. 0 keeps the current as it is.",
            )
            .klipper("[tmc2660 <stepper>] driver_SEMIN")
            .derived("off, or what reg says")
            .velvet();

            pub const UPPER: Setting = integer(
                "coolstep_upper",
                "0",
                &(0, 992),
                chip!(|chip, v| chip.cool_step.upper = Some(v as u16)),
                "From this reading on the current falls (32 (SEMIN + SEMAX + 1)): a multiple of 32 above coolstep_lower.",
            )
            .klipper("[tmc2660 <stepper>] driver_SEMAX")
            .derived("coolstep_lower + 64")
            .velvet();

            pub const RISE: Setting = word(
                "coolstep_up",
                "1",
                UP,
                chip!(|chip, v| chip.cool_step.up = v as u8),
                "32nds of the current that a low reading adds (SEUP).",
            )
            .klipper("[tmc2660 <stepper>] driver_SEUP")
            .velvet();

            pub const FALL: Setting = word(
                "coolstep_down",
                "32",
                DOWN,
                chip!(|chip, v| chip.cool_step.down = v as u8),
                "High readings that take one 32nd of the current away (SEDN): 32 is the slowest.",
            )
            .klipper("[tmc2660 <stepper>] driver_SEDN")
            .velvet();

            pub const FLOOR: Setting = word(
                "coolstep_least",
                "half",
                LEAST,
                chip!(|chip, v| chip.cool_step.quarter = v == 1),
                "How far down the current goes (SEIMIN).",
            )
            .klipper("[tmc2660 <stepper>] driver_SEIMIN")
            .velvet();
        }
    };
}

load_settings!(tmc2590);
load_settings!(tmc2660);
