//! `[laser]`: a laser whose power belongs to places of the path.

use crate::names::{Command, Name};
use crate::pin::{Pin, PwmOutput};
use crate::setting::build::{bool, integer, number, pin, places, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::{PinRole, Support};
use heapless::Vec;

/// Greatest number of points of a laser's power table.
pub const MAX_POWER_POINTS: usize = 32;
/// Greatest number of interlocks of a laser.
pub const MAX_INTERLOCKS: usize = 4;

words! {
    /// Power of a laser while a moving machine comes to rest for a hold.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum LaserInHold {
        /// None, at once.
        #[default]
        Off = "off",
        /// Power that fades with the speed, until the machine stands.
        Fade = "fade",
    }
}

settings! {
    /// A laser whose power belongs to places of the path: M3 constant, M4 by the speed, off in G0, at rest,
    /// in a hold and behind an open door. WEAR GLASSES for its wavelength; firmware replaces neither the
    /// enclosure nor its interlock.
    #[derive(Clone, Debug, Default)]
    pub struct LaserConfig {
        /// There is a laser.
        enable: bool = bool("false").v1("laser_module_enable");
        /// Timer channel that drives the laser, PWM1_1 to PWM2_4. The timer of that pin serves the laser
        /// alone. In a reset the pin floats: a pull-down keeps the laser off then.
        pwm_pin: Option<PwmOutput> = pin("nc", PinRole::Pwm).v1("laser_module_pwm_pin");
        /// Output that is on while the laser has power, switched at the same place as the duty.
        ttl_pin: Option<Pin> = pin("nc", PinRole::Output).v1("laser_module_ttl_pin");
        /// The output is low where it would be high; off is high then.
        "inverted_pwm" inverted: bool = bool("false");
        /// With opendrain: the chip's own resistor pulls the output up, to 3.3 V.
        pullup: bool = bool("true");
        /// The output only pulls low.
        "opendrain" open_drain: bool = bool("false");
        /// Frequency of the duty. The period has all counts of the timer, 10000 at 20 kHz. CO2 tubes take
        /// about 20 kHz, diodes 1 to 5 kHz.
        "pwm_frequency" frequency_hz: u32 = integer("10000", &(4, 50_000))
            .derived("frequency of [pwm1] or [pwm2] where that is there, else 10000").unit("Hz").velvet();
        /// Duty of full power.
        maximum_power: f32 = number("1", &(0.0, 1.0)).unit("fraction").v1("laser_module_maximum_power");
        /// Duty of the least power above zero: S lies evenly between this and maximum_power. $31 in GRBL's
        /// dialect.
        minimum_power: f32 = number("0", &(0.0, 1.0)).unit("fraction").v1("laser_module_minimum_power");
        /// Greatest power of a jog ($J=) between M3 and M5, which shows where a job will burn: a larger S is
        /// brought down to it. 0: jogs are dark.
        framing_power: f32 = number("0", &(0.0, 1.0)).unit("fraction").velvet();
        /// The S of full power. LightBurn writes 1 for Smoothie and 1000 for GRBL. $30 in GRBL's dialect.
        maximum_s_value: f32 = number("1", &(0.001, 1_000_000.0)).v1("laser_module_maximum_s_value");
        /// S until a program sets it.
        default_power: f32 = number("0.8", &(0.0, 1_000_000.0))
            .derived("0 with grbl_mode, else 0.8").unit("S units").v1("laser_module_default_power");
        /// The power of M3 follows the speed along the path too, as M4's always does.
        proportional_power: bool = bool("true")
            .derived("true, false with grbl_mode").v1("laser_module_proportional_power");
        /// Rate of power updates.
        "proportional_power_frequency" = integer("10000", &(0, 1_000_000)).unit("Hz")
            .support(&Support::Needless { why: "power follows the speed in steps of at most 2 percent, at their places" });
        /// The output goes on so much later than the path says, as for a laser that goes off late.
        "on_delay" on_delay_us: f64 = number("0", DELAY).unit("us").velvet();
        /// The output goes off so much later than the path says, as for a laser that lights up late.
        "off_delay" off_delay_us: f64 = number("0", DELAY).unit("us").velvet();
        /// What the laser makes of a duty, as duty and power, each from 0 to 1 and ascending, the duty
        /// counted from minimum_power to maximum_power: 0.1,0 0.5,0.3 1,1. Empty: power is proportional to
        /// the duty.
        power_table: Vec<[f64; 2], MAX_POWER_POINTS> = places(MAX_POWER_POINTS).unit("fraction").velvet();
        /// A hold's beam: off at once, which leaves a gap as long as the way to rest; or fading with the
        /// speed, so that a picture has no gap.
        hold: LaserInHold = word("off", LaserInHold::WORDS).velvet();
        /// Names of inputs of [switch], with commas between, up to four: a lid, a flow of water. While one is
        /// on, the beam is locked, a moving machine holds, and no job starts. Wire each so that a broken wire
        /// is on.
        "interlock_switches" interlocks: Command = text("", 96).velvet();
        /// Name of an output of [switch] that M3 and M4 turn on, and M5 turns off: air at the cut.
        air_switch: Name = text("", 24).velvet();
    }
}

const DELAY: &(f64, f64) = &(0.0, 20_000.0);

impl LaserConfig {
    /// Returns the names of the interlocks, without blanks.
    pub fn interlock_names(&self) -> impl Iterator<Item = &str> {
        self.interlocks.split(',').map(str::trim).filter(|name| !name.is_empty())
    }
}
