//! Remedies for halts: a sentence for each kind of fault that says how to go on.

/// Words of a halt's text, and what to do then. The first row that fits is taken.
const REMEDIES: &[(&str, &str)] = &[
    ("M112", "When all is safe again, release the machine and home it."),
    ("ill button", "Unlatch the button, then release the machine and home it."),
    ("limit", "Release the machine, move the axis away from its switch, and home it."),
    ("robe", "Look at the probe and its cable: it must be free at the start, and must come to touch."),
    ("supply", "Look at the supply and its fuse, release the machine and home it."),
    ("heat", "Check heater, sensor and their cables before you heat again."),
    ("emperature", "Check heater, sensor and their cables before you heat again."),
    ("ensor", "Check heater, sensor and their cables before you heat again."),
    ("stall", "Take away what blocks the axis, look at the motor's cable, release the machine and home it."),
    ("motor", "Look at the motor, its cable and its driver's supply, release the machine and home it."),
    ("oming", "See whether the switches work (the page's signals show them), release the machine and home it."),
    ("steps", "Check the positions, then release the machine; the console's get steps says more."),
];

/// Remedy of all other halts.
const ANY: &str = "Put right what the text says, then release the machine and home it.";

/// Returns what to do about a halt with this text.
#[must_use]
pub fn remedy(text: &str) -> &'static str {
    REMEDIES.iter().find(|(words, _)| text.contains(words)).map_or(ANY, |(_, remedy)| remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_halts_find_their_remedy() {
        for (text, words) in [
            ("ALARM: Emergency stop (M112)", "safe"),
            ("ALARM: Kill button pressed - reset, $X or M999 to clear HALT", "Unlatch"),
            ("ALARM: Hard limit -X was hit (minx)", "away from its switch"),
            ("ALARM: Probe fail", "Look at the probe"),
            ("ERROR: motor supply lost while moving", "fuse"),
            ("ERROR: heater supply lost while heating (vfet below 6 V)", "fuse"),
            ("ERROR: motor X stalls", "blocks"),
            ("ERROR: Homing cycle failed", "switches"),
            ("ALARM: Abort during cycle", "Put right"),
        ] {
            assert!(remedy(text).contains(words), "{text}: {}", remedy(text));
        }
    }
}
