//! Test that every supported setting has an effect: one row a setting, the same machine twice with two values
//! of it, and an observation that differs. Observed is the machine's behaviour: step edges, temperatures,
//! replies, driver registers. A setting without a row fails the test, so none can be forgotten.

mod fans;
mod filament;
mod heat;
mod homing;
mod kinematics;
mod laser;
mod leveling;
mod lights;
mod motion;
mod motors;
mod network;
mod probe;
mod switches;
mod system;
mod tools;

use config::schema::{Form, SECTIONS, Section, Setting, Support};
use scenarios::{Bench, CARTESIAN, Plan};
use std::collections::BTreeSet;

/// Observation that a setting must change.
#[derive(Clone, Copy)]
pub enum See {
    /// Answers to these lines.
    Say(&'static [&'static str]),
    /// Step edges that these lines make: motor, direction and time of each.
    Edges(&'static [&'static str]),
    /// Messages at boot: findings of the checker among them.
    Boot,
    /// Any other observation of the machine.
    Look(fn(&mut Bench) -> String),
    /// Pins or peripherals that the native runner does not have: the test in this file of the virtual board
    /// must name the setting.
    Board(&'static str),
}

/// A setting and what it changes.
#[derive(Clone, Copy)]
pub struct Row {
    /// `[section] key`, with an instance's name where there are some.
    key: &'static str,
    /// Two values; an empty one leaves the line out.
    values: [&'static str; 2],
    see: See,
    /// Configuration that the setting is tested in.
    base: &'static str,
    /// Changes to the configuration, `[section] key = value` each.
    with: &'static [&'static str],
    /// Whether the machine stays built for the first value.
    built: bool,
}

/// Returns a row in the Cartesian sample.
pub const fn row(key: &'static str, one: &'static str, other: &'static str, see: See) -> Row {
    Row { key, values: [one, other], see, base: CARTESIAN, with: &[], built: false }
}

impl Row {
    const fn with(self, with: &'static [&'static str]) -> Self {
        Self { with, ..self }
    }

    const fn on(self, base: &'static str) -> Self {
        Self { base, ..self }
    }

    /// Builds the machine for the first value: a sensor measures the same, whatever the file says.
    const fn built(self) -> Self {
        Self { built: true, ..self }
    }

    fn start(&self, value: &str) -> Bench {
        let setting = |value: &str| match value {
            "" => self.key.to_owned(),
            value => format!("{} = {value}", self.key),
        };
        let plan = self.with.iter().fold(Plan::new(self.base), |plan, line| plan.set(line));
        let plan = if self.built { plan.set(&setting(self.values[0])).built() } else { plan };
        FILES.iter().fold(plan.set(&setting(value)), |plan, (name, text)| plan.file(name, text)).start()
    }

    /// Returns the observation with this value; none when only the board can show it.
    fn seen(&self, value: &str) -> Option<String> {
        if let See::Board(_) = self.see {
            return None;
        }
        let mut bench = self.start(value);
        Some(match self.see {
            See::Say(lines) => lines.iter().map(|line| bench.say(line)).collect(),
            See::Edges(lines) => edges(&mut bench, lines),
            See::Boot => bench.greeting().to_owned(),
            See::Look(look) => look(&mut bench),
            See::Board(_) => String::new(),
        })
    }
}

/// Files on every card.
const FILES: &[(&str, &str)] = &[
    ("config-override", "M204 S777\n"),
    ("on_boot.gcode", "G91\nG1 X1 F600\n"),
    ("other.g", "G91\nG1 X2 F600\n"),
    ("crash.gcode", "G28\nG1 Z1 F600\nG1 X150 F6000\nG1 X20\n"),
    ("part.gcode", "G91\nG1 X3 F600\nM600\nG1 X1\n"),
];

/// Returns every edge since now, with its time.
pub fn edges(bench: &mut Bench, lines: &[&str]) -> String {
    let start_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.trace_mut().take());
    for line in lines {
        bench.say(line);
    }
    bench.say("M400");
    let edges = bench.world(|world| world.trace_mut().take());
    edges.iter().map(|edge| format!("{} {:?} {:?}\n", edge.time_ns - start_ns, edge.actuator, edge.direction)).collect()
}

fn tables() -> [(&'static str, &'static [Row]); 15] {
    [
        ("system", system::ROWS),
        ("motion", motion::ROWS),
        ("motors", motors::ROWS),
        ("network", network::ROWS),
        ("tools", tools::ROWS),
        ("filament", filament::ROWS),
        ("heat", heat::ROWS),
        ("homing", homing::ROWS),
        ("probe", probe::ROWS),
        ("switches", switches::ROWS),
        ("fans", fans::ROWS),
        ("laser", laser::ROWS),
        ("lights", lights::ROWS),
        ("kinematics", kinematics::ROWS),
        ("leveling", leveling::ROWS),
    ]
}

/// Returns the schema's row of `[section] name.key`.
fn schema_row(key: &str) -> Option<(&'static Section, &'static Setting)> {
    let (section, key) = key.strip_prefix('[')?.split_once("] ")?;
    let (_, section) = config::schema::section(section)?;
    let place = match section.form {
        Form::Plain => section.position(key, false),
        Form::Keyed(_) => Some(0),
        Form::Named(_) => {
            let (name, key) = key.split_once('.')?;
            section.position(key, name == "common")
        }
    };
    Some((section, section.settings.get(place?)?))
}

fn name(section: &Section, setting: &Setting) -> String {
    format!("[{}] {}{}", section.name, if setting.is_common { "common." } else { "" }, setting.key)
}

#[test]
fn every_setting_that_is_acted_on_has_a_row() {
    let mut with_rows = BTreeSet::new();
    for row in tables().iter().flat_map(|(_, rows)| rows.iter()) {
        let (section, setting) = schema_row(row.key).unwrap_or_else(|| panic!("no setting {}", row.key));
        with_rows.insert(name(section, setting));
        if let See::Board(file) = row.see {
            let text = std::fs::read_to_string(format!("{}/../virtual-prime/tests/{file}", env!("CARGO_MANIFEST_DIR")));
            let key = row.key.rsplit([' ', '.']).next().unwrap_or_default();
            assert!(text.is_ok_and(|text| text.contains(key)), "{file} does not name {}", row.key);
        }
    }
    let acted_on = SECTIONS.iter().flat_map(|section| section.settings.iter().map(move |setting| (section, setting)));
    let missing: Vec<_> = acted_on
        .filter(|(_, setting)| *setting.support == Support::Now)
        .map(|(section, setting)| name(section, setting))
        .filter(|name| !with_rows.contains(name))
        .collect();
    assert!(missing.is_empty(), "add rows for what these change: {missing:#?}");
}

/// Returns the rows of a table whose two values look alike.
fn alike(rows: &[Row]) -> Vec<String> {
    let is_acted_on = |row: &&Row| schema_row(row.key).is_some_and(|(_, setting)| *setting.support == Support::Now);
    let mut alike = Vec::new();
    for row in rows.iter().filter(is_acted_on) {
        let [one, other] = row.values.map(|value| row.seen(value));
        if let (See::Edges(_), Some("")) = (row.see, one.as_deref()) {
            alike.push(format!("{}: nothing moved, {}", row.key, row.start(row.values[0]).greeting()));
        } else if one.is_some() && one == other {
            let one: String = one.unwrap_or_default().chars().take(2_000).collect();
            alike.push(format!("{}: {:?} look alike: {}", row.key, row.values, one));
        }
    }
    alike
}

macro_rules! tests {
    ($($name:ident: $table:ident;)*) => {$(
        #[test]
        fn $name() {
            let alike = alike($table::ROWS);
            assert!(alike.is_empty(), "{}", alike.join("\n"));
        }
    )*};
}

tests! {
    each_setting_of_the_system_changes_something: system;
    each_setting_of_motion_changes_something: motion;
    each_setting_of_motors_changes_something: motors;
    each_setting_of_tools_changes_something: tools;
    each_setting_of_heat_changes_something: heat;
    each_setting_of_homing_changes_something: homing;
    each_setting_of_the_probe_changes_something: probe;
    each_setting_of_switches_changes_something: switches;
    each_setting_of_fans_changes_something: fans;
    each_setting_of_filament_changes_something: filament;
    each_setting_of_the_laser_changes_something: laser;
    each_setting_of_lights_changes_something: lights;
    each_setting_of_kinematics_changes_something: kinematics;
    each_setting_of_leveling_changes_something: leveling;
}
