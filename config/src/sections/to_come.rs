//! Functions that are not part of Velvet yet. Their settings are known and checked, and refused when used.

use crate::diagnostic::Severity;
use crate::setting::build::{ANY, bool, integer, number, pin};
use crate::setting::declare::settings;
use crate::setting::{PinRole, Support};

/// Place of settings that nothing reads yet.
type Nothing = ();

settings! {
    /// A laser whose power follows the speed.
    rows Laser of Nothing {
        /// There is a laser.
        "enable" = bool("false").v1("laser_module_enable").support(NOT_YET);
        /// Timer channel that drives the laser.
        "pwm_pin" = pin("nc", PinRole::Pwm).v1("laser_module_pwm_pin").dormant();
        /// Output that is on while the laser has power.
        "ttl_pin" = pin("nc", PinRole::Output).v1("laser_module_ttl_pin").dormant();
        /// The output is low where it would be high.
        "inverted_pwm" = bool("false").dormant();
        /// Pull the output up.
        "pullup" = bool("true").dormant();
        /// The output only pulls low.
        "opendrain" = bool("false").dormant();
        /// Duty cycle at full power.
        "maximum_power" = number("1", ANY).unit("fraction").v1("laser_module_maximum_power").dormant();
        /// Least duty cycle in a cutting move.
        "minimum_power" = number("0", ANY).unit("fraction").v1("laser_module_minimum_power").dormant();
        /// The S value of full power.
        "maximum_s_value" = number("1", ANY).v1("laser_module_maximum_s_value").dormant();
        /// S until a program sets it.
        "default_power" = number("0.8", ANY).unit("S units").v1("laser_module_default_power").dormant();
        /// Power follows the speed along the path.
        "proportional_power" = bool("true").v1("laser_module_proportional_power").dormant();
        /// Rate of power updates.
        "proportional_power_frequency" = integer("10000", &(0, 1_000_000)).unit("Hz").dormant();
    }
}

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
