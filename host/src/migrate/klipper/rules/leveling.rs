//! Rules of sections about bed and gantry: meshes, screws, Z motors, twist, skew, frames that grow.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::source::{numbers, points};
use super::super::wiring::Role;
use super::machine::kinematics;
use super::sensors;
use super::table::{Change, NUMBER, Rule, apply};

const GRID: &str = "cartesian grid leveling strategy";
const ROUND: &str = "delta grid leveling strategy";
const MESH: &str = "bed mesh";
const ALIGNMENT: &str = "z alignment";

/// Converts `[bed_mesh]`.
pub fn mesh(m: &mut Migration<'_>, section: usize) {
    let is_round = matches!(kinematics(m).as_deref(), Some("delta" | "rotary_delta"));
    let strategy = if is_round { "delta grid" } else { "cartesian grid" };
    let area = if is_round { "mesh_radius" } else { "mesh_max" };
    if m.section(section).get(area).is_none() {
        let why = "a mesh without its area";
        return m.judge_rest(section, &Verdict::refused(why, "[zprobe] leveling"));
    }
    m.write(("zprobe", "", "leveling"), strategy, "of [bed_mesh]");
    if is_round {
        of_delta(m, section)
    } else {
        of_rectangle(m, section)
    }
    match m.section(section).get("algorithm") {
        Some("bicubic") => m.put(section, "algorithm", (MESH, "", "interpolation"), "spline"),
        Some("lagrange") => m.put(section, "algorithm", (MESH, "", "interpolation"), "lagrange"),
        Some("direct") => m.put(section, "algorithm", (MESH, "", "interpolation"), "bilinear"),
        _ => m.refuse(section, "algorithm", "Velvet has no such surface", "[bed mesh] interpolation"),
    }
    apply(m, section, "", MESH_ROWS);
    for (option, key) in
        [("fade_start", "dampening_start"), ("fade_end", "height_limit"), ("fade_target", "fade_target")]
    {
        match is_round {
            true => m.refuse(section, option, "the grid of a delta does not fade", "M376"),
            false => m.scaled(section, option, (GRID, "", key), 1.0),
        }
    }
    if m.section(section).get("fade_end").is_some() && m.section(section).get("fade_start").is_none() {
        m.put(section, "fade_start", (GRID, "", "dampening_start"), "1");
    }
    faulty(m, section);
    m.judge_section(section, Verdict::new(Class::Converted, "a grid of heights"));
}

const MESH_ROWS: &[(&str, Rule)] = &[
    ("speed", Rule::To("zprobe", "fast_feedrate", NUMBER)),
    ("horizontal_move_z", Rule::To("zprobe", "probe_height", NUMBER)),
    ("adaptive_margin", Rule::To(MESH, "adaptive_margin", NUMBER)),
    ("zero_reference_position", Rule::To(MESH, "zero_reference", Change::Numbers)),
    ("mesh_pps", Rule::Needless("the surface lies between the points everywhere, not at more points")),
    ("bicubic_tension", Rule::Needless("the spline between the points has no tension")),
    ("split_delta_z", Rule::Needless("Z follows the surface all along a move")),
    ("move_check_distance", Rule::Needless("Z follows the surface all along a move")),
    ("relative_reference_index", Rule::Refused("a place, not a point's number", "[bed mesh] zero_reference")),
    ("scan_overshoot", Rule::Refused("the probe touches, it does not scan", "G32")),
];

fn of_rectangle(m: &mut Migration<'_>, section: usize) {
    let [low, high] = ["mesh_min", "mesh_max"].map(|option| m.section(section).get(option).and_then(numbers));
    let (Some([x0, y0]), Some([x1, y1])) = (low.as_deref(), high.as_deref()) else {
        for option in ["mesh_min", "mesh_max", "mesh_radius"] {
            m.refuse(
                section,
                option,
                "two corners make the area of a mesh",
                "[cartesian grid leveling strategy] x_size",
            );
        }
        return;
    };
    for (option, key, value) in [
        ("mesh_min", "x_start", x0),
        ("mesh_min", "y_start", y0),
        ("mesh_max", "x_size", &(x1 - x0)),
        ("mesh_max", "y_size", &(y1 - y0)),
    ] {
        m.put(section, option, (GRID, "", key), text(*value));
    }
    if let Some(count) = m.section(section).get("probe_count").and_then(numbers) {
        let [x, y] = match count.as_slice() {
            [one] => [*one, *one],
            [x, y] => [*x, *y],
            _ => return m.refuse(section, "probe_count", "one number or two", "[cartesian grid leveling strategy]"),
        };
        m.put(section, "probe_count", (GRID, "", "grid_x_size"), text(x));
        m.put(section, "probe_count", (GRID, "", "grid_y_size"), text(y));
    } else {
        m.put(section, "probe_count", (GRID, "", "grid_x_size"), "3");
        m.put(section, "probe_count", (GRID, "", "grid_y_size"), "3");
    }
}

fn of_delta(m: &mut Migration<'_>, section: usize) {
    let rows: &[(&str, Rule)] = &[
        ("mesh_radius", Rule::To(ROUND, "radius", NUMBER)),
        ("round_probe_count", Rule::To(ROUND, "size", Change::Whole(1.0))),
        ("mesh_origin", Rule::Refused("the grid of a delta is around the middle", "[delta grid leveling strategy]")),
    ];
    apply(m, section, "", rows);
}

/// Writes the regions that the probe keeps out of.
fn faulty(m: &mut Migration<'_>, section: usize) {
    let mut places = Vec::new();
    let mut used = Vec::new();
    for number in 1..100 {
        let names = ["min", "max"].map(|end| format!("faulty_region_{number}_{end}"));
        let corners = names.each_ref().map(|name| m.section(section).get(name).and_then(numbers));
        let [Some(low), Some(high)] = corners else { continue };
        for corner in [low, high] {
            places.push(corner.into_iter().map(text).collect::<Vec<_>>().join(","));
        }
        used.extend(names);
    }
    let Some((first, others)) = used.split_first() else { return };
    let value = places.join(" ");
    m.put(section, first, (MESH, "", "faulty_regions"), value.clone());
    for name in others {
        m.merged(section, name, "", &format!("[bed mesh] faulty_regions = {value}"));
    }
}

fn told(places: &[[f64; 2]]) -> String {
    places.iter().map(|[x, y]| format!("{},{}", text(*x), text(*y))).collect::<Vec<_>>().join(" ")
}

/// Returns where the probe is when the nozzle is at these places.
fn under_probe(m: &Migration<'_>, places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let probe = ["probe", "bltouch", "smart_effector"].iter().find_map(|name| m.source.section(name));
    let offset = |option| probe.and_then(|probe| probe.number(option)).unwrap_or(0.0);
    let (dx, dy) = (offset("x_offset"), offset("y_offset"));
    // Sums of decimal fractions have a tail of digits that nobody measures.
    let neat = |value: f64| (value * 1e6).round() / 1e6;
    places.iter().map(|[x, y]| [neat(x + dx), neat(y + dy)]).collect()
}

/// Converts `[z_tilt]` and `[quad_gantry_level]`.
pub fn z_motors(m: &mut Migration<'_>, section: usize) {
    let is_quad = m.section(section).kind() == "quad_gantry_level";
    let option = if is_quad { "gantry_corners" } else { "z_positions" };
    let motors = m.motors.keys().filter(|name| name.starts_with("stepper_z")).count();
    let Some(mut places) = m.section(section).get(option).and_then(points) else {
        return m.judge_rest(section, &Verdict::refused("no places of motors", "[z alignment]"));
    };
    if is_quad {
        // Two opposite corners: the motors go round from the first, as Klipper counts them.
        if let [[x0, y0], [x1, y1]] = places[..] {
            places = vec![[x0, y0], [x0, y1], [x1, y1], [x1, y0]];
        }
    }
    if places.len() != motors || !(2..=4).contains(&motors) {
        let why = format!("it wants {} motors for Z, and {motors} found a place on the Prime", places.len());
        m.ask(format!("[{}]: {why}", m.section(section).name));
        return m.judge_rest(section, &Verdict::refused(why, "[z alignment], [actuator] slaved_to"));
    }
    m.put(section, option, (ALIGNMENT, "", "motors"), told(&places));
    match m.section(section).get("points").and_then(points) {
        Some(touched) => {
            let touched = told(&under_probe(m, &touched));
            m.put_for(section, "points", (ALIGNMENT, "", "points"), touched, "the probe's places, not the nozzle's");
        }
        None => m.refuse(section, "points", "these are no places", "[z alignment] points"),
    }
    m.write((ALIGNMENT, "", "twist"), is_quad.to_string(), "");
    apply(m, section, "", Z_MOTORS);
    if m.section(section).get("retries").is_none() {
        m.put(section, "retries", (ALIGNMENT, "", "retries"), "0");
    }
    m.judge_section(section, Verdict::new(Class::Converted, "G34"));
}

const Z_MOTORS: &[(&str, Rule)] = &[
    ("retries", Rule::To(ALIGNMENT, "retries", Change::Whole(1.0))),
    ("retry_tolerance", Rule::To(ALIGNMENT, "tolerance", NUMBER)),
    ("max_adjust", Rule::To(ALIGNMENT, "max_adjust", NUMBER)),
    ("speed", Rule::Refused("all that probes travels at one speed", "[zprobe] fast_feedrate")),
    ("horizontal_move_z", Rule::To(ALIGNMENT, "initial_height", NUMBER)),
];

/// Converts `[screws_tilt_adjust]` and `[bed_screws]`.
pub fn screws(m: &mut Migration<'_>, section: usize) {
    let is_probed = m.section(section).kind() == "screws_tilt_adjust";
    let has_both = m.find("screws_tilt_adjust").is_some();
    let named: Vec<(String, [f64; 2])> = (1..100)
        .map_while(|number| {
            let option = format!("screw{number}");
            let place = m.section(section).get(&option).and_then(numbers)?;
            Some((option, <[f64; 2]>::try_from(place).ok()?))
        })
        .collect();
    let places: Vec<[f64; 2]> = named.iter().map(|(_, place)| *place).collect();
    let value = if is_probed { told(&under_probe(m, &places)) } else { told(&places) };
    if !is_probed && has_both {
        for (option, _) in &named {
            m.merged(section, option, "the screws are those of [screws_tilt_adjust]", "");
        }
    } else if let Some(((first, _), others)) = named.split_first() {
        m.put(section, first, ("bed screws", "", "screws"), value.clone());
        for (option, _) in others {
            m.merged(section, option, "", &format!("[bed screws] screws = {value}"));
        }
    }
    for number in 1..=named.len() {
        m.needless(section, &format!("screw{number}_name"), "screws are told by their corner");
        m.refuse(section, &format!("screw{number}_fine_adjust"), "a screw has one place", "[bed screws] screws");
    }
    apply(m, section, "", SCREWS);
    m.judge_section(section, Verdict::new(Class::Converted, "G35, and BED_SCREWS_ADJUST by paper"));
}

const SCREWS: &[(&str, Rule)] = &[
    ("screw_thread", Rule::To("bed screws", "thread", Change::Word)),
    ("speed", Rule::Refused("all that probes travels at one speed", "[zprobe] fast_feedrate")),
    ("horizontal_move_z", Rule::To("bed screws", "initial_height", NUMBER)),
    ("probe_height", Rule::To("bed screws", "paper_height", NUMBER)),
    ("probe_speed", Rule::Refused("Z goes down as fast as elsewhere", "[motion control] z_axis_max_speed")),
];

/// Converts `[bed_tilt]`.
pub fn tilt(m: &mut Migration<'_>, section: usize) {
    let three = m.section(section).get("points").and_then(points).filter(|points| points.len() >= 3);
    let is_free = m.written(("zprobe", "", "leveling")).is_none() && m.find("bed_mesh").is_none();
    if let (Some(places), true) = (three, is_free) {
        m.write(("zprobe", "", "leveling"), "three point", "of [bed_tilt]");
        for (number, place) in places.iter().take(3).enumerate() {
            let key = format!("point{}", number + 1);
            m.put_for(
                section,
                "points",
                ("three point leveling strategy", "", &key),
                told(&[*place]),
                "three of them make a plane",
            );
        }
    }
    let why = "the plane is measured, not written";
    let rows: &[(&str, Rule)] = &[
        ("points", Rule::Refused("a mesh levels this bed", "[zprobe] leveling")),
        ("x_adjust", Rule::Refused(why, "G32, M500")),
        ("y_adjust", Rule::Refused(why, "G32, M500")),
        ("z_adjust", Rule::Refused(why, "G32, M500")),
        ("speed", Rule::Refused("all that probes travels at one speed", "[zprobe] fast_feedrate")),
        ("horizontal_move_z", Rule::To("zprobe", "probe_height", NUMBER)),
    ];
    apply(m, section, "", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "three points make a plane"));
}

/// Converts `[delta_calibrate]`.
pub fn delta(m: &mut Migration<'_>, section: usize) {
    m.write(("zprobe", "", "calibration"), "delta", "of [delta_calibrate]");
    let rows: &[(&str, Rule)] = &[
        ("radius", Rule::To("delta calibration strategy", "radius", NUMBER)),
        ("horizontal_move_z", Rule::To("delta calibration strategy", "initial_height", NUMBER)),
        ("speed", Rule::Refused("all that probes travels at one speed", "[zprobe] fast_feedrate")),
    ];
    apply(m, section, "", rows);
    let why = "what an earlier calibration measured: calibrate anew";
    m.judge_rest(section, &Verdict::refused(why, "G32 P1, M500"));
}

/// Converts `[axis_twist_compensation]`.
pub fn twist(m: &mut Migration<'_>, section: usize) {
    const TWIST: &str = "axis twist compensation";
    let rows: &[(&str, Rule)] = &[
        ("calibrate_start_x", Rule::To(TWIST, "start", NUMBER)),
        ("calibrate_end_x", Rule::To(TWIST, "end", NUMBER)),
        ("calibrate_y", Rule::To(TWIST, "line", NUMBER)),
        ("horizontal_move_z", Rule::To(TWIST, "initial_height", NUMBER)),
        ("speed", Rule::Refused("all that probes travels at one speed", "[zprobe] fast_feedrate")),
        ("z_compensations", Rule::Refused("measure it anew", "M851.1 P4, M500")),
        ("compensation_start_x", Rule::Refused("measure it anew", "M851.1 P4, M500")),
        ("compensation_end_x", Rule::Refused("measure it anew", "M851.1 P4, M500")),
    ];
    apply(m, section, "", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "M851.1 P4 measures it"));
}

/// Converts `[z_thermal_adjust]`: a sensor on the frame.
pub fn thermal(m: &mut Migration<'_>, section: usize) {
    const THERMAL: &str = "z thermal adjust";
    let kind = m.section(section).get("sensor_type").unwrap_or("").to_owned();
    if !sensors::is_known(m, &kind) {
        let why = format!("Velvet has no sensor of the kind {kind}");
        return m.judge_rest(section, &Verdict::refused(why, "[z thermal adjust] sensor"));
    }
    if !super::heat::heater(m, section, "frame", Role::Load) {
        return;
    }
    m.write(("temperature control", "frame", "heater_pin"), "nc", "a sensor only");
    m.write((THERMAL, "", "sensor"), "frame", "");
    let rows: &[(&str, Rule)] = &[
        ("temp_coeff", Rule::To(THERMAL, "coefficient", NUMBER)),
        ("smooth_time", Rule::To(THERMAL, "smooth_time", NUMBER)),
        ("max_z_adjustment", Rule::To(THERMAL, "max_adjust", NUMBER)),
        ("z_adjust_off_above", Rule::Refused("it acts at every height", "M290.1 K0")),
    ];
    apply(m, section, "", rows);
    m.judge_section(section, Verdict::new(Class::Converted, "Z follows the frame"));
}
