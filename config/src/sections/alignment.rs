//! Settings of the alignment of tool and bed: `[z alignment]`, `[bed screws]`, `[axis twist compensation]`,
//! `[z thermal adjust]` and `[delta calibration strategy]`.

use crate::names::Name;
use crate::setting::Words;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, places, text, word};
use crate::setting::declare::settings;
use heapless::Vec;
use units::Mm;

/// Greatest number of Z motors: gamma and the three that can be slaved to it.
pub const MAX_Z_MOTORS: usize = 4;
/// Greatest number of bed screws.
pub const MAX_SCREWS: usize = 8;
/// Greatest number of probed points.
pub const MAX_POINTS: usize = 12;

settings! {
    /// Levels a bed or a gantry by the motors that carry it: two or more Z motors, gamma and its slaves
    /// (slaved_to), each turned alone. G34 does it.
    #[derive(Clone, Debug, Default)]
    pub struct ZAlignment {
        /// Where each Z motor carries the bed or the gantry: gamma first, then its slaves in their order.
        motors: Vec<[f64; 2], MAX_Z_MOTORS> = places(MAX_Z_MOTORS).klipper("[z_tilt] z_positions").velvet();
        /// Where the probe touches the bed (Klipper writes where the nozzle is then); as many as there are
        /// motors, or more.
        points: Vec<[f64; 2], MAX_POINTS> = places(MAX_POINTS).klipper("[z_tilt] points").velvet();
        /// With four motors: a twist is taken out too, as of a gantry on belts. A stiff bed has none.
        twist: bool = bool("true").velvet();
        /// Aligned when no motor is off by more. G34 T changes it.
        tolerance: Mm = number("0.02", POSITIVE)
            .unit("mm").typical(&(0.001, 1.0)).velvet().klipper("[z_tilt] retry_tolerance");
        /// Rounds after the first one at most. G34 I changes it.
        retries: u8 = integer("5", &(0, 30)).unit("rounds").klipper("[z_tilt] retries").velvet();
        /// A motor that is off by more than this is not moved: something else is wrong.
        max_adjust: Mm = number("5", POSITIVE)
            .unit("mm").typical(&(0.1, 20.0)).klipper("[quad_gantry_level] max_adjust").velvet();
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("10", POSITIVE).unit("mm").velvet();
    }
}

/// Thread of a bed screw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thread {
    /// Height change per turn, mm; zero: not given.
    pub pitch: f64,
    /// Whether a clockwise turn raises the bed.
    pub clockwise_raises: bool,
}

/// Greatest number of points along a twisted axis.
pub const MOST_TWIST_POINTS: usize = 8;

settings! {
    /// A probe beside the tool reads wrongly along an axis whose rail is twisted. What it reads too high is
    /// taken off.
    #[derive(Clone, Debug, Default)]
    pub struct AxisTwist {
        /// The axis whose rail is twisted.
        "axis" along_y: bool = word("x", &Words(&["x", "y"])).velvet();
        /// Places along the axis, in rising order, and what the probe reads too high there (Klipper's
        /// z_compensations have the other sign). M851.1 P4 finds them, M500 saves them.
        points: Vec<[f64; 2], MOST_TWIST_POINTS> = places(MOST_TWIST_POINTS)
            .klipper("[axis_twist_compensation] z_compensations").velvet();
        /// Where along the axis it is measured first.
        start: Mm = number("0", ANY).unit("mm").velvet().klipper("[axis_twist_compensation] calibrate_start_x");
        /// Where it is measured last.
        end: Mm = number("0", ANY).unit("mm").velvet().klipper("[axis_twist_compensation] calibrate_end_x");
        /// On which line of the other axis it is measured.
        line: Mm = number("0", ANY).unit("mm").velvet().klipper("[axis_twist_compensation] calibrate_y");
        /// At how many places it is measured.
        samples: u8 = integer("3", &(2, 8)).unit("places").velvet();
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("10", POSITIVE).unit("mm").velvet();
    }
}

settings! {
    /// The screws that a person levels the bed by. G35 says how far each is to be turned.
    #[derive(Clone, Debug, Default)]
    pub struct BedScrews {
        /// Where they are (Klipper's screws_tilt_adjust writes where the nozzle is with the probe over them).
        /// The first one stays; the others are turned.
        screws: Vec<[f64; 2], MAX_SCREWS> = places(MAX_SCREWS).klipper("[screws_tilt_adjust] screw1").velvet();
        /// Their thread; CW: turned clockwise it raises the bed.
        thread: Thread = word("CW-M3", THREADS).klipper("[screws_tilt_adjust] screw_thread").velvet() => thread;
        /// Way of one turn of another thread; 0: that of thread.
        "pitch" = number("0", NOT_NEGATIVE).unit("mm").typical(&(0.2, 2.0)).velvet() => BedScrews::set_pitch;
        /// Level when no screw is off by more.
        tolerance: Mm = number("0.02", POSITIVE).unit("mm").typical(&(0.001, 1.0)).velvet();
        /// Height of the tool over the screws while a person turns them by paper (BED_SCREWS_ADJUST).
        paper_height: Mm = number("0", ANY).unit("mm").klipper("[bed_screws] probe_height").velvet();
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("10", POSITIVE).unit("mm").velvet();
    }
}

settings! {
    /// Finds the geometry of a delta by probing: endstop trims, radius, angles, arms.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct DeltaCalibrationConfig {
        /// Distance of the probed points from the centre. G32 J changes it.
        radius: Mm = number("100", POSITIVE).unit("mm").v1("leveling-strategy.delta-calibration.radius");
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("20", POSITIVE)
            .unit("mm").v1("leveling-strategy.delta-calibration.initial_height");
        /// How many numbers G32 finds: 3 the trims, 4 the radius too, 6 also the angles of two towers, 7 the
        /// length of the arms, 9 that of each. G32 S changes it.
        factors: u8 = word("4", FACTORS)
            .klipper("DELTA_CALIBRATE").velvet() => |v: usize| FACTOR_COUNTS.get(v).copied().unwrap_or(4);
        /// Spread of the points' heights that is good enough. G32 I changes it.
        tolerance: Mm = number("0.03", POSITIVE).unit("mm").v1("leveling-strategy.delta-calibration.tolerance");
        /// Whether `[zprobe] calibration` asks for the calibration.
        enable: bool;
    }
}

settings! {
    /// A frame that grows with its temperature moves the tool against the bed. Z is shifted against that,
    /// from where it homed.
    #[derive(Clone, Debug, Default)]
    pub struct ZThermalConfig {
        /// The temperature control whose sensor is on the frame.
        sensor: Name = text("", 24).klipper("[z_thermal_adjust] sensor_type").velvet();
        /// By how much the tool comes away from the bed for each degree; 0: not known, and nothing is
        /// shifted. M290.1 K changes it.
        coefficient: f64 = number("0", &(-1.0, 1.0)).unit("mm/K").klipper("[z_thermal_adjust] temp_coeff").velvet();
        /// Readings are smoothed over so long.
        "smooth_time" smooth_s: f64 = number("2", &(0.0, 600.0))
            .unit("s").klipper("[z_thermal_adjust] smooth_time").velvet();
        /// Z is shifted by no more.
        max_adjust: Mm = number("0.5", POSITIVE)
            .unit("mm").typical(&(0.01, 2.0)).klipper("[z_thermal_adjust] max_z_adjustment").velvet();
    }
}

impl BedScrews {
    /// Sets another pitch than that of the thread; 0 leaves it.
    fn set_pitch(&mut self, pitch: f64) {
        if pitch > 0.0 {
            self.thread.pitch = pitch;
        }
    }
}

/// The words of `factors`, and their numbers.
const FACTORS: &Words = &Words(&["3", "4", "6", "7", "9"]);
const FACTOR_COUNTS: [u8; 5] = [3, 4, 6, 7, 9];

/// Threads of common screws with which way raises the bed, named as Klipper names them.
const THREADS: &Words = &Words(&["CW-M3", "CCW-M3", "CW-M4", "CCW-M4", "CW-M5", "CCW-M5", "CW-M6", "CCW-M6"]);
/// Coarse pitches of the threads (ISO 261), mm, one for each pair of words.
const PITCHES: [f64; 4] = [0.5, 0.7, 0.8, 1.0];

/// As Klipper has it, `CW` means that a clockwise turn raises the bed.
fn thread(word: usize) -> Thread {
    Thread { pitch: PITCHES.get(word / 2).copied().unwrap_or(0.5), clockwise_raises: word.is_multiple_of(2) }
}

settings! {
    /// The choice of the calibration.
    rows ProbeCalibration of DeltaCalibrationConfig {
        /// How G32 calibrates the machine; the strategy has a section of its own.
        "calibration" = word("", &Words(&["delta"]))
            => |calibration: &mut DeltaCalibrationConfig, _: usize| calibration.enable = true;
    }
}
