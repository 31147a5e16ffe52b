//! The machines the ledger is measured on, and for each kind of kinematics a path inside it that turns all
//! its motors.

/// Files read from `bench`: a printer, and a fast machine with a place for each kind of kinematics.
pub struct Machines {
    pub printer: String,
    pub fast: String,
}

/// A kind of kinematics: its word in configurations, sections it needs, and its path.
pub struct Kind {
    pub word: &'static str,
    sections: &'static str,
    /// A line before the moves, where the machine cannot start at zero.
    before: &'static str,
    /// Ends of the moves.
    to: &'static [&'static str],
}

const fn kind(word: &'static str, to: &'static [&'static str]) -> Kind {
    Kind { word, sections: "", before: "", to }
}

/// Every kind that `arm_solution` knows (words for the same kind once).
pub const KINDS: [Kind; 13] = [
    kind("cartesian", &["X30 Y29 Z28", "X0 Y0 Z0"]),
    kind("corexy", &["X28 Y5 Z29", "X0 Y0 Z0"]),
    kind("corexz", &["X28 Y29 Z2", "X0 Y0 Z0"]),
    kind("hybrid_corexy", &["X-4 Y26 Z29", "X0 Y0 Z0"]),
    kind("hybrid_corexz", &["X-4 Y29 Z26", "X0 Y0 Z0"]),
    kind("linear_delta", &["X12 Y10 Z30", "X0 Y0 Z0"]),
    kind("rotary_delta", &["X-35 Y-30 Z2", "X35 Y30 Z18"]),
    kind("morgan", &["X-50 Y50 Z0", "X50 Y115 Z40"]),
    kind("deltesian", &["X12 Y29 Z30", "X0 Y0 Z0"]),
    // A turning bed has no middle.
    Kind { before: "G28.3 X30 Y0 Z0\n", ..kind("polar", &["X54 Y45 Z40"]) },
    Kind {
        sections: "[winch]\nalpha = -500,-400,900\nbeta = 500,-400,950\ngamma = 0,600,1000\n",
        ..kind("winch", &["X12 Y12 Z35", "X0 Y0 Z0"])
    },
    Kind {
        sections: "[generic cartesian]\nalpha = 1,0.2,0\nbeta = -0.3,1,0.1\ngamma = 0,0.1,1\n",
        ..kind("generic_cartesian", &["X24 Y36 Z26", "X0 Y0 Z0"])
    },
    kind("lathe", &["X30 Z29", "X0 Z0"]),
];

/// Filters as a fast printer has them.
const SHAPERS: &str =
    "[input shaper]\nshaper_type_x = mzv\nshaper_freq_x = 50\nshaper_type_y = mzv\nshaper_freq_y = 40\n";
const ADVANCE: (&str, &str) = ("[extruder]\n", "[extruder]\nhotend.pressure_advance = 0.02\n");

/// Line that sets the jerk limit.
const PLANNER: &str = "[planner]\n";

/// Points 10 mm apart under the paths.
const GRIDS: &str = "[cartesian grid leveling strategy]\nx_size = 40\ny_size = 40\ngrid_x_size = 5\ngrid_y_size = 5\n\
    [delta grid leveling strategy]\nradius = 30\nsize = 7\n";

/// Pulsed drivers on an expansion header, for the fifth and the sixth motor.
const EXTERNAL: &str = "[actuator]\n\
    epsilon.steps_per_mm = 1600\nepsilon.max_rate = 20000\nepsilon.step_pin = PG0\nepsilon.dir_pin = PG1\n\
    zeta.steps_per_mm = 1600\nzeta.max_rate = 20000\nzeta.step_pin = PA4\nzeta.dir_pin = PJ3\n";

impl Machines {
    /// The fast machine of a kind; shaped: with input shapers on X and Y and pressure advance.
    pub fn of(&self, kind: &Kind, shaped: bool) -> String {
        let arm = format!("arm_solution = {}", kind.word);
        let mut text = self.fast.replace("arm_solution = cartesian", &arm) + kind.sections;
        if shaped {
            text = text.replace(ADVANCE.0, ADVANCE.1) + SHAPERS;
        }
        text
    }

    /// As [`Self::of`], plain, with a grid of heights; [`Kind::levelled_job`] has the heights.
    pub fn levelled(&self, kind: &Kind) -> String {
        let strategy = if kind.word == "linear_delta" { "delta grid" } else { "cartesian grid" };
        format!("{}[zprobe]\nleveling = {strategy}\n{GRIDS}", self.of(kind, false))
    }

    /// As [`Self::of`], shaped, with jerk-limited ramps of at least 20 ms.
    pub fn smooth(&self, kind: &Kind) -> String {
        self.of(kind, true).replace(PLANNER, &format!("{PLANNER}jerk = 1000000\n"))
    }

    /// The printer, with filters and jerk-limited ramps of at least 20 ms.
    pub fn smooth_printer(&self) -> String {
        self.shaped_printer().replace(PLANNER, &format!("{PLANNER}jerk = 250000\n"))
    }

    /// The printer, spoken to in GRBL's dialect.
    pub fn in_grbl(&self) -> String {
        self.printer.replace("grbl_mode = false", "grbl_mode = true")
    }

    /// The printer, which looks ahead at its jobs.
    pub fn looking_ahead(&self) -> String {
        self.printer.replace("preflight = off", "preflight = warn")
    }

    /// The printer, with both serial ports at the USB socket.
    pub fn with_two_ports(&self) -> String {
        self.printer.clone() + "\n[consoles]\nsecond_usb_serial_enable = true\n"
    }

    /// The printer, with a console on the network.
    pub fn with_network(&self) -> String {
        self.printer.clone() + "\n[network]\nenable = true\nshell_enable = true\npassword_required = false\n"
    }

    /// The printer, with filters.
    pub fn shaped_printer(&self) -> String {
        self.printer.replace(ADVANCE.0, ADVANCE.1) + SHAPERS
    }

    /// The fast machine with filters that look far ahead: pressure advance over 40 ms, and a shaper of Y that
    /// is longer than that of X.
    pub fn looking_far_ahead(&self) -> String {
        let far = "[extruder]\nhotend.pressure_advance = 0.04\nhotend.pressure_advance_smooth_time = 0.04\n";
        let shapers = SHAPERS.replace("shaper_type_y = mzv", "shaper_type_y = 2hump_ei");
        self.fast.replace(ADVANCE.0, far) + &shapers
    }

    /// The fast machine with six motors.
    pub fn six_motors(&self) -> String {
        format!("{}{EXTERNAL}", self.fast)
    }

    /// The fast machine with motors of up to a million steps a second.
    pub fn fastest(&self) -> String {
        self.fast.replace("max_rate = 20000", "max_rate = 37500")
    }
}

impl Kind {
    /// The path on an uneven bed.
    pub fn levelled_job(&self) -> String {
        format!("M421 I1 J1 Z0.2\nM421 I2 J2 Z-0.1\nM421 I3 J4 Z0.15\n{}", self.job(false))
    }

    /// The path at full speed; extruding a quarter of what the axes go, or not at all.
    pub fn job(&self, extruding: bool) -> String {
        let mut job = format!("M83\n{}", self.before);
        for to in self.to {
            job += &format!("G1 {to}{} F40000\n", if extruding { " E7" } else { "" });
        }
        job
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machines_differ_in_what_they_are_for() {
        let fast = include_str!("../../../bench/fast.ini").to_owned();
        let machines = Machines { printer: include_str!("../../../bench/config.ini").to_owned(), fast };
        let winch = KINDS.iter().find(|kind| kind.word == "winch").expect("a kind");
        let (plain, shaped) = (machines.of(winch, false), machines.of(winch, true));
        assert!(plain.contains("arm_solution = winch\n") && plain.contains("[winch]\n"));
        assert!(!plain.contains("shaper") && shaped.contains("shaper_freq_x") && shaped.contains("pressure_advance"));
        assert!(machines.shaped_printer().contains("pressure_advance"));
        assert!(
            machines.smooth_printer().contains("\njerk = 250000\n") && machines.smooth_printer().contains("shaper")
        );
        assert!(machines.in_grbl().contains("\ngrbl_mode = true\n"));
        assert!(machines.looking_ahead().contains("\npreflight = warn\n"));
        assert!(machines.smooth(winch).contains("\njerk = 1000000\n") && !shaped.contains("jerk"));
        let levelled = machines.levelled(&KINDS[0]);
        assert!(levelled.contains("leveling = cartesian grid") && KINDS[0].levelled_job().starts_with("M421 "));
        assert!(machines.fastest().contains("max_rate = 37500") && machines.six_motors().contains("zeta.step_pin"));
        assert!(winch.job(true).contains("E7") && !winch.job(false).contains('E'));
    }

    #[test]
    fn every_kind_that_a_configuration_may_name_is_measured() {
        /// Other words for a linear delta and for corexy.
        const ALIASES: [&str; 4] = ["rostock", "kossel", "delta", "hbot"];
        let schema = include_str!("../../../config/src/sections/motion.rs");
        let (_, list) = schema.split_once("const ARM_SOLUTIONS:").expect("the words of arm_solution");
        let (list, _) = list.split_once(']').expect("their end");
        // Odd pieces lie between quotes.
        let mut words: Vec<&str> = list.split('"').skip(1).step_by(2).filter(|word| !ALIASES.contains(word)).collect();
        let mut measured: Vec<&str> = KINDS.iter().map(|kind| kind.word).collect();
        words.sort_unstable();
        measured.sort_unstable();
        assert_eq!(measured, words);
    }
}
