//! Functions that are not part of Velvet yet. Their settings are known and checked, and refused when used.

use crate::diagnostic::Severity;
use crate::setting::build::{ANY, bool, integer, number, pin};
use crate::setting::declare::settings;
use crate::setting::{PinRole, Support};

/// Place of settings that nothing reads yet.
type Nothing = ();

settings! {
    /// Threading in step with a spindle.
    rows Lathe of Nothing {
        /// Understand threading with G33.
        "enable" = bool("false").support(NOT_YET);
        /// Encoder pulses per turn of the spindle, gearing included.
        "encoder_ppr" = number("1000", ANY).unit("pulses/rev").dormant();
        /// Input that pulses once a turn: starts threads, measures the speed.
        "index_pin" = pin("nc", PinRole::Interrupt).dormant();
    }
}

settings! {
    /// Panel of an electronic leadscrew.
    rows LeadScrew of Nothing {
        /// There is such a panel.
        "enable" = bool("false").support(NOT_YET_HARMLESS);
    }
}

settings! {
    /// Graphic display.
    rows GraphicDisplay of Nothing {
        /// There is such a display.
        "enable" = bool("false").v1("panel.enable").support(NOT_YET_HARMLESS);
        /// Clock of the bit-banged display link.
        "clk" = pin("nc", PinRole::Output).dormant();
        /// Data of the bit-banged display link.
        "mosi" = pin("nc", PinRole::Output).dormant();
    }
}

settings! {
    /// Lamp and key module.
    rows KeyModule of Nothing {
        /// There is such a module.
        "enable" = bool("false").support(NOT_YET_HARMLESS);
        /// Clock pin.
        "clock_pin" = pin("nc", PinRole::Output).dormant();
        /// Bidirectional data pin.
        "data_pin" = pin("nc", PinRole::Output).dormant();
        /// Strobe pin.
        "strobe_pin" = pin("nc", PinRole::Output).dormant();
    }
}

settings! {
    /// Handwheels.
    rows Handwheels of Nothing {
        /// There is such a handwheel.
        "enable" = bool("false").support(NOT_YET);
        /// Encoder phase A.
        "enca_pin" = pin("nc", PinRole::Interrupt).v1("panel.encoder_a_pin").dormant();
        /// Encoder phase B.
        "encb_pin" = pin("nc", PinRole::Interrupt).v1("panel.encoder_b_pin").dormant();
        /// Actuator index that is stepped.
        "axis" = integer("-1", &(-1, 5)).dormant();
    }
}

/// Support of a part's own switch, where the machine does something else than meant without that part.
const NOT_YET: &Support = &Support::NotYet { severity: Severity::Error, advice: LEAVE_DISABLED };
/// Support of a part's own switch, where the machine works without that part.
pub(super) const NOT_YET_HARMLESS: &Support = &Support::NotYet { severity: Severity::Warning, advice: LEAVE_DISABLED };
const LEAVE_DISABLED: &str = "leave it disabled until Velvet can do it";
