//! Kinds of temperature sensors: Klipper's names, those that a file describes, chips on SPI.

use super::super::account::Class;
use super::super::account::Verdict;
use super::super::migration::{Migration, text};
use super::super::source::Section;
use super::super::wiring::Role;
use super::table::{Change, NUMBER, Rule, apply};

const TEMPERATURE: &str = "temperature control";

/// Thermistors by the names that Klipper has for them: three pairs of temperature and resistance, or beta.
const CURVES: &[(&str, [f64; 6])] = &[
    ("ATC Semitec 104GT-2", [20.0, 126_800.0, 150.0, 1360.0, 300.0, 80.65]),
    ("ATC Semitec 104NT-4-R025H42G", [25.0, 100_000.0, 160.0, 1074.0, 300.0, 82.78]),
    ("EPCOS 100K B57560G104F", [25.0, 100_000.0, 150.0, 1641.9, 250.0, 226.15]),
    ("Generic 3950", [25.0, 100_000.0, 150.0, 1770.0, 250.0, 230.0]),
    ("SliceEngineering 450", [25.0, 500_000.0, 200.0, 3734.0, 400.0, 240.0]),
    ("TDK NTCG104LH104JT1", [25.0, 100_000.0, 50.0, 31_230.0, 125.0, 2066.0]),
];
/// Thermistors of 100 kOhm at 25 C by their beta.
const BETAS: &[(&str, f64)] = &[("Honeywell 100K 135-104LAG-J01", 3974.0), ("NTC 100K MGB18-104F39050L32", 4100.0)];
/// Chips on SPI by their names, the same in both.
const CHIPS: [&str; 3] = ["MAX31855", "MAX31856", "MAX31865"];
/// Amplifiers that give 5 mV a degree.
const AMPLIFIERS: [&str; 4] = ["AD8494", "AD8495", "AD8496", "AD8497"];
const MOST_POINTS: usize = 6;

/// Sensor in the words of the new file.
enum Kind {
    Curve([f64; 6]),
    Beta {
        beta: f64,
        r0: f64,
        t0: f64,
    },
    Platinum,
    Amplifier,
    /// Points of temperature and voltage.
    Volts(Vec<(f64, f64)>),
    Chip(&'static str),
    Controller,
    Unknown,
}

fn kind(m: &Migration<'_>, name: &str) -> Kind {
    if let Some((_, curve)) = CURVES.iter().find(|(known, _)| *known == name) {
        return Kind::Curve(*curve);
    }
    if let Some((_, beta)) = BETAS.iter().find(|(known, _)| *known == name) {
        return Kind::Beta { beta: *beta, r0: 100_000.0, t0: 25.0 };
    }
    if let Some(chip) = CHIPS.into_iter().find(|known| *known == name) {
        return Kind::Chip(chip);
    }
    if AMPLIFIERS.contains(&name) {
        return Kind::Amplifier;
    }
    match name {
        "PT1000" => Kind::Platinum,
        "temperature_mcu" => Kind::Controller,
        _ => described(m, name).unwrap_or(Kind::Unknown),
    }
}

/// Reads `[thermistor NAME]` and `[adc_temperature NAME]`.
fn described(m: &Migration<'_>, name: &str) -> Option<Kind> {
    let by = |kind: &str| m.source.sections.iter().find(|of| of.kind() == kind && of.label() == name);
    if let Some(of) = by("thermistor") {
        let (t0, r0) = (of.number("temperature1")?, of.number("resistance1")?);
        return Some(match of.number("beta") {
            Some(beta) => Kind::Beta { beta, r0, t0 },
            None => Kind::Curve([
                t0,
                r0,
                of.number("temperature2")?,
                of.number("resistance2")?,
                of.number("temperature3")?,
                of.number("resistance3")?,
            ]),
        });
    }
    let of = by("adc_temperature")?;
    let points = volts(of)?;
    (2..=MOST_POINTS).contains(&points.len()).then_some(Kind::Volts(points))
}

fn volts(of: &Section) -> Option<Vec<(f64, f64)>> {
    let pairs = (1..).map_while(|n| Some((of.number(&format!("temperature{n}"))?, n)));
    pairs.map(|(temperature, n)| Some((temperature, of.number(&format!("voltage{n}"))?))).collect()
}

/// Returns whether Velvet can read a sensor of this name.
pub fn is_known(m: &Migration<'_>, name: &str) -> bool {
    !matches!(kind(m, name), Kind::Unknown)
}

/// Converts the sensor of a heater, a fan or itself.
pub fn sensor(m: &mut Migration<'_>, section: usize, name: &str) {
    let role = match name {
        "bed" => Role::BedSensor,
        _ if name.starts_with("hotend") => Role::HotendSensor,
        _ => Role::Thermistor,
    };
    let Some(wanted) = m.section(section).get("sensor_type") else { return unknown(m, section, name, "(none)") };
    match kind(m, wanted) {
        Kind::Curve(points) => {
            let value = points.map(text).join(",");
            m.put_for(section, "sensor_type", (TEMPERATURE, name, "rt_curve"), value, wanted);
        }
        Kind::Beta { beta, r0, t0 } => {
            m.put_for(section, "sensor_type", (TEMPERATURE, name, "beta"), text(beta), wanted);
            m.write((TEMPERATURE, name, "r0"), text(r0), wanted);
            m.write((TEMPERATURE, name, "t0"), text(t0), wanted);
        }
        Kind::Platinum => m.put(section, "sensor_type", (TEMPERATURE, name, "sensor"), "pt1000"),
        Kind::Amplifier => {
            m.put(section, "sensor_type", (TEMPERATURE, name, "sensor"), "ad849x");
            m.ask(format!("{name}: the amplifier's output has to stay below 3.3 V, and its input has a pull-up"));
        }
        Kind::Volts(points) => {
            let value: Vec<String> = points.iter().flat_map(|(t, v)| [text(*t), text(*v)]).collect();
            m.put_for(section, "sensor_type", (TEMPERATURE, name, "sensor"), "voltage", wanted);
            m.write((TEMPERATURE, name, "voltage_curve"), value.join(","), wanted);
        }
        Kind::Chip(chip) => {
            m.put(section, "sensor_type", (TEMPERATURE, name, "sensor"), chip.to_lowercase());
            return on_spi(m, section, name);
        }
        Kind::Controller => {
            m.put(section, "sensor_type", (TEMPERATURE, name, "sensor"), "chip");
            for option in ["sensor_mcu", "sensor_temperature1", "sensor_adc1", "sensor_temperature2", "sensor_adc2"] {
                m.needless(section, option, "the board's one microcontroller has its calibration in it");
            }
            return;
        }
        Kind::Unknown => return unknown(m, section, name, wanted),
    }
    if let Some((place, _)) = m.place(section, "sensor_pin", role, "sensor") {
        m.put(section, "sensor_pin", (TEMPERATURE, name, "thermistor_pin"), place.pin);
    }
    apply(m, section, name, DIVIDER);
}

const DIVIDER: &[(&str, Rule)] = &[
    ("pullup_resistor", Rule::Needless("the board's own pull-up counts, 4.7 kOhm")),
    ("inline_resistor", Rule::Only("0", "a resistor in series is not reckoned with", "[temperature control] rt_curve")),
    ("adc_voltage", Rule::Needless("the board's inputs measure to 3.3 V")),
    ("voltage_offset", Rule::Only("0", "an offset is not reckoned with", "[temperature control] voltage_curve")),
];

fn on_spi(m: &mut Migration<'_>, section: usize, name: &str) {
    m.write((TEMPERATURE, name, "spi_channel"), "0", "header GE");
    if let Some((place, _)) = m.place(section, "sensor_pin", Role::Select, "chip select of the sensor") {
        m.put(section, "sensor_pin", (TEMPERATURE, name, "spi_select_pin"), place.pin);
    }
    for option in ["tc_use_50hz_filter", "rtd_use_50hz_filter"] {
        if let Some(is_50) = m.section(section).get(option).and_then(super::super::source::truth) {
            let value = if is_50 { "50" } else { "60" };
            m.put(section, option, (TEMPERATURE, name, "mains_frequency"), value);
        }
    }
    if let Some(kind) = m.section(section).get("tc_type") {
        m.put(section, "tc_type", (TEMPERATURE, name, "tc_type"), kind.to_uppercase());
    }
    apply(m, section, name, ON_SPI);
    let names: Vec<&str> = m.section(section).options.iter().map(|option| option.name.as_str()).collect();
    for option in names.into_iter().filter(|name| name.starts_with("spi_")) {
        m.needless(section, option, "the sensor is on the board's SPI1, header GE");
    }
}

const ON_SPI: &[(&str, Rule)] = &[
    ("tc_averaging_count", Rule::To(TEMPERATURE, "tc_averaging", Change::Whole(1.0))),
    ("rtd_nominal_r", Rule::To(TEMPERATURE, "rtd_nominal", NUMBER)),
    ("rtd_reference_r", Rule::To(TEMPERATURE, "rtd_reference", NUMBER)),
    ("rtd_num_of_wires", Rule::To(TEMPERATURE, "rtd_wires", Change::Whole(1.0))),
];

fn unknown(m: &mut Migration<'_>, section: usize, name: &str, wanted: &str) {
    let why = format!("Velvet has no sensor of the kind {wanted}");
    m.judge(section, "sensor_type", Verdict::refused(why.clone(), "[temperature control] rt_curve, sensor"));
    m.refuse(section, "sensor_pin", "its sensor is not known", "[temperature control] thermistor_pin");
    m.write((TEMPERATURE, name, "enable"), "false", "off: its sensor is not known");
    m.ask(format!("{name}: {why}: describe it (docs/settings.md), or the heater stays off"));
}

/// Gives verdicts on `[thermistor NAME]` and `[adc_temperature NAME]`.
pub fn description(m: &mut Migration<'_>, section: usize) {
    let name = m.section(section).label();
    let verdict = if m.section(section).options.is_empty() {
        Verdict::needless("Velvet knows its sensors")
    } else if is_known(m, &name) {
        Verdict::new(Class::Converted, "goes into the temperature controls that name it")
    } else {
        Verdict::refused("not two to six points of voltage", "[temperature control] voltage_curve")
    };
    m.judge_rest(section, &verdict);
}
