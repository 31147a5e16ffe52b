//! Texts that many rows of the schema share. A row keeps a text's place in its list, which is a byte.

/// The unit of a value in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit(u8);

/// Every unit, behind none.
#[rustfmt::skip]
const UNITS: &[&str] = &[
    "",
    "%", "% s/C", "%/(C s)", "%/C", "1/256 full step", "1/min", "1/s", "A", "C", "C s", "C,Ohm", "C,V", "C/s",
    "Hz", "J/K", "J/mm3/K", "K", "Ohm", "S units", "V", "W", "W/K", "baud", "bits", "deg", "degree", "fraction",
    "h", "mA", "mH", "mOhm", "mm", "mm/K", "mm/V", "mm/min", "mm/s", "mm/s^2", "mm/s^3", "moves", "ms", "ns",
    "places", "points", "pulses/mm", "pulses/rev", "ratio", "rounds", "s", "steps/mm", "times", "touches", "us",
];

impl Unit {
    /// The value has none.
    pub const NONE: Self = Self(0);

    /// Returns the unit of this text.
    ///
    /// # Panics
    /// When there is none: as rows are constants, the compiler says it. Add the unit to the list.
    pub(crate) const fn of(text: &str) -> Self {
        let mut place = 0;
        while place < UNITS.len() {
            if UNITS[place].len() == text.len() && starts_with(text.as_bytes(), UNITS[place].as_bytes()) {
                return Self(place as u8);
            }
            place += 1;
        }
        panic!("no such unit")
    }

    /// Returns the unit as it is written; empty for none.
    #[must_use]
    pub fn text(self) -> &'static str {
        UNITS.get(usize::from(self.0)).copied().unwrap_or_default()
    }
}

/// A section of Klipper's configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KlipperSection(u8);

/// Every section of Klipper that has a setting of ours, behind none.
#[rustfmt::skip]
const KLIPPER_SECTIONS: &[&str] = &[
    "",
    "axis_twist_compensation", "bed_mesh", "bed_screws", "controller_fan <name>",
    "endstop_phase stepper_<axis>", "extruder", "fan", "fan_generic <name>", "filament_motion_sensor",
    "filament_switch_sensor", "firmware_retraction", "gcode_arcs", "hall_filament_width_sensor",
    "heater_fan <name>", "homing_override", "input_shaper", "led <name>", "neopixel <name>",
    "output_pin <name>", "printer", "probe", "quad_gantry_level", "safe_z_home", "screws_tilt_adjust",
    "servo <name>", "stepper_<axis>", "stepper_a", "stepper_b", "stepper_c", "temperature_fan <name>",
    "tmc2130 <stepper>", "tmc2208 <stepper>", "tmc2209 <stepper>", "tmc2226 <stepper>", "tmc2240 <stepper>",
    "tmc2660 <stepper>", "tmc5160 <stepper>", "verify_heater", "z_thermal_adjust", "z_tilt",
];

impl KlipperSection {
    /// Klipper has no such setting, or not in a section.
    pub const NONE: Self = Self(0);

    /// Returns the section of a setting that is written `[section] key`.
    ///
    /// # Panics
    /// When the list has no such section: as rows are constants, the compiler says it. Add it to the list.
    pub(crate) const fn of(setting: &str) -> Self {
        let Some((b'[', rest)) = setting.as_bytes().split_first() else { return Self::NONE };
        let mut place = 0;
        while place < KLIPPER_SECTIONS.len() {
            let section = KLIPPER_SECTIONS[place].as_bytes();
            if section.len() < rest.len() && rest[section.len()] == b']' && starts_with(rest, section) {
                return Self(place as u8);
            }
            place += 1;
        }
        panic!("no such section of Klipper")
    }

    /// Returns the name of the section; empty for none.
    #[must_use]
    pub fn text(self) -> &'static str {
        KLIPPER_SECTIONS.get(usize::from(self.0)).copied().unwrap_or_default()
    }
}

/// Whether a text begins with another one. The standard library's comparison is none of constants.
const fn starts_with(text: &[u8], beginning: &[u8]) -> bool {
    let mut index = 0;
    while index < beginning.len() {
        if index >= text.len() || text[index] != beginning[index] {
            return false;
        }
        index += 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::SECTIONS;
    use crate::setting::Setting;

    #[test]
    fn every_text_of_the_lists_is_some_rows() {
        let is_some = |is: &dyn Fn(&Setting) -> bool| SECTIONS.iter().flat_map(|section| section.settings).any(is);
        for (place, unit) in UNITS.iter().enumerate() {
            assert!(is_some(&|row| usize::from(row.unit.0) == place), "{unit}");
        }
        for (place, section) in KLIPPER_SECTIONS.iter().enumerate() {
            assert!(is_some(&|row| usize::from(row.klipper_section.0) == place), "{section}");
        }
    }

    #[test]
    fn a_row_names_the_section_that_its_setting_of_klipper_has() {
        for row in SECTIONS.iter().flat_map(|section| section.settings) {
            let section = row.docs.klipper.strip_prefix('[').and_then(|rest| rest.split_once(']'));
            assert_eq!(row.klipper_section.text(), section.map_or("", |(section, _)| section), "{}", row.key);
        }
    }
}
