//! Members of the objects of `printer`, in Klipper's units.

use core::fmt::{self, Write as _};

use ::macros::Given;
use base::ports::{Clock as _, HeatPort as _, MotionPort as _};
use base::snapshot::{HeaterShown, JobEnd, JobShown};
use jobs::player::ObjectShown;
use program::State;
use units::Axis;

use super::hands::{MacroHands, Seen};
use super::look::Look;
use super::objects::{Kind, Thing, Vector};

/// Rounds to hundredths, as Klipper tells temperatures.
fn hundredths(value: f32) -> f64 {
    libm::round(f64::from(value) * 100.0) / 100.0
}

const fn vector_of(which: Vector) -> Option<Given<'static>> {
    Some(Thing::Vector(which).given())
}

/// Letters of axes.
struct Letters(units::AxisSet);

impl fmt::Display for Letters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes = self.0.axes().filter(|axis| Axis::PRIMARY.contains(axis));
        axes.into_iter().try_for_each(|axis| f.write_char(axis.letter().to_ascii_lowercase()))
    }
}

/// Gives a member of an object.
pub(super) fn value<'t, 'c, H: MacroHands<'c>>(
    look: &'t mut Look<'_, 'c, H>,
    kind: Kind,
    instance: u8,
    name: &str,
) -> Option<Given<'t>> {
    let snapshot = look.snapshot;
    let heater = snapshot.heaters.get(usize::from(instance));
    match kind {
        Kind::Toolhead => toolhead(look, name),
        Kind::Move => gcode_move(look, name),
        Kind::Extruder => match name {
            "can_extrude" | "pressure_advance" | "smooth_time" => extruder(look, heater?, name),
            name => temperature(heater?, name),
        },
        Kind::Heater | Kind::Sensor => temperature(heater?, name),
        Kind::PartFan | Kind::Output => duty(look, instance, name),
        Kind::PrintStats | Kind::PrintInfo | Kind::Card => job(look, kind, name),
        Kind::LiveMotion => match name {
            "live_position" => vector_of(Vector::Live),
            "live_velocity" => Some(Given::Float(snapshot.speed.0)),
            _ => None,
        },
        Kind::Pause => (name == "is_paused").then_some(Given::Bool(is_paused(look))),
        Kind::Idle => (name == "state").then(|| Given::Text(idle_state(look))),
        Kind::Probe => match name {
            "last_query" => Some(Given::Bool(snapshot.probe?.touches)),
            "last_z_result" => Some(Given::Float(snapshot.probe?.last.map_or(0.0, |[_, _, z]| z))),
            _ => None,
        },
        Kind::Mesh => mesh(look, name),
        Kind::Retraction => retraction(look, name),
        Kind::Filament => {
            let Seen { filament, world, .. } = look.hands.seen();
            match name {
                "filament_detected" => Some(Given::Bool(filament.is_missing(world.config).is_none())),
                "enabled" => Some(Given::Bool(filament.is_on())),
                _ => None,
            }
        }
        Kind::Display => match name {
            "progress" => Some(Given::Float(progress(snapshot.job.as_ref()))),
            "message" => match look.hands.macros().message.as_str() {
                "" => Some(Given::None),
                text => Some(Given::Text(text)),
            },
            _ => None,
        },
        Kind::Alignment => (name == "applied").then(|| Given::Bool(look.hands.axes().are_aligned())),
        Kind::Host => (name == "state").then_some(Given::Text("ready")),
        Kind::Endstops if name == "last_query" => endstops(look),
        Kind::Heaters => heaters(look, name),
        Kind::Print => print(look, name),
        Kind::Endstops => None,
    }
}
fn toolhead<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    let snapshot = look.snapshot;
    let Seen { program, world, .. } = look.hands.seen();
    let limits = |pick: fn(&motion::Limits) -> f64, ports: &mut H::Ports| {
        ports.motion(|motion| motion.config().map(|config| pick(&config.limits)))
    };
    match name {
        "homed_axes" => look.write(format_args!("{}", Letters(snapshot.homed)), Given::Text),
        "axis_minimum" => vector_of(Vector::Least),
        "axis_maximum" => vector_of(Vector::Greatest),
        "position" => vector_of(Vector::Position),
        "extruder" => match program.tools().active_id().0 {
            0 => Some(Given::Text("extruder")),
            tool => look.write(format_args!("extruder{tool}"), Given::Text),
        },
        "max_accel" => Some(Given::Float(snapshot.most.1)),
        "max_velocity" => Some(Given::Float(snapshot.most.0.unwrap_or(f64::from(u16::MAX)))),
        "square_corner_velocity" => {
            limits(|limits| limits.square_corner_velocity.map_or(0.0, |speed| speed.0), &mut world.ports)
                .map(Given::Float)
        }
        "minimum_cruise_ratio" => limits(|limits| limits.cruise_ratio, &mut world.ports).map(Given::Float),
        "stalls" => Some(Given::Int(i64::from(world.ports.motion(|motion| motion.counters().starved)))),
        "print_time" | "estimated_print_time" => Some(Given::Float(world.ports.now().0 as f64 / 1e6)),
        _ => None,
    }
}

fn gcode_move<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    let snapshot = look.snapshot;
    Some(match name {
        "gcode_position" => return vector_of(Vector::GcodePosition),
        "position" => return vector_of(Vector::Position),
        "homing_origin" => return vector_of(Vector::Origin),
        "absolute_coordinates" => Given::Bool(snapshot.absolute[0]),
        "absolute_extrude" => Given::Bool(snapshot.absolute[1]),
        // Klipper's is in mm/min.
        "speed" => Given::Float(snapshot.feed_rate.0 * 60.0),
        "speed_factor" => Given::Float(snapshot.feed_factor),
        "extrude_factor" => Given::Float(snapshot.flow_factor),
        _ => return None,
    })
}

fn temperature(heater: &HeaterShown, name: &str) -> Option<Given<'static>> {
    Some(match name {
        "temperature" => Given::Float(heater.reading.map_or(0.0, |celsius| hundredths(celsius.0))),
        "target" if heater.heats => Given::Float(hundredths(heater.target.0)),
        "power" if heater.heats => Given::Float(f64::from(heater.power)),
        _ => return None,
    })
}

fn extruder<'t, 'c, H: MacroHands<'c>>(
    look: &'t mut Look<'_, 'c, H>,
    heater: &HeaterShown,
    name: &str,
) -> Option<Given<'t>> {
    let Seen { program, tuning, world, .. } = look.hands.seen();
    let places = program.tools().all().iter();
    let place = places.clone().position(|tool| tool.settings.id == program.tools().active_id())?;
    if name == "can_extrude" {
        let [least, _] = tuning.least_warm.get(place).copied().unwrap_or_default();
        return Some(Given::Bool(heater.reading.is_some_and(|reading| reading.0 >= least)));
    }
    let index = parts::motion_codes::advance_of(program.tools().all().get(place)?.settings.axis);
    let filters = world.ports.motion(|motion| motion.config().map(|config| config.filters));
    let advance = filters.and_then(|filters| filters.advance.get(index).copied().flatten());
    let picked =
        advance.map_or(0.0, |advance| if name == "pressure_advance" { advance.factor } else { advance.smooth_time });
    Some(Given::Float(picked))
}

fn duty<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, instance: u8, name: &str) -> Option<Given<'t>> {
    let snapshot = look.snapshot;
    let world = look.hands.world();
    match name {
        "speed" | "value" => Some(Given::Float(f64::from(world.ports.heat(|heat| heat.switch_duty(instance))))),
        "rpm" => {
            let named = world.config.switches.get(usize::from(instance)).map(|switch| switch.name.as_str())?;
            let fan = snapshot.fans.iter().find(|fan| fan.name.as_str() == named);
            Some(fan.and_then(|fan| fan.rpm).map_or(Given::None, |rpm| Given::Float(f64::from(rpm))))
        }
        _ => None,
    }
}

fn is_paused<'c, H: MacroHands<'c>>(look: &Look<'_, 'c, H>) -> bool {
    let job = look.snapshot.job.as_ref();
    look.snapshot.is_suspended || job.is_some_and(|job| job.end.is_none() && job.is_paused)
}

fn idle_state<'c, H: MacroHands<'c>>(look: &mut Look<'_, 'c, H>) -> &'static str {
    let is_printing = look.snapshot.job.as_ref().is_some_and(|job| job.end.is_none() && !job.is_paused);
    match look.snapshot.state {
        _ if look.hands.macros().is_idle => "Idle",
        State::Idle | State::Suspended if !is_printing => "Ready",
        _ => "Printing",
    }
}

fn progress(job: Option<&JobShown>) -> f64 {
    job.filter(|job| job.end.is_none()).map_or(0.0, |job| f64::from(job.done) / f64::from(job.size.max(1)))
}

fn job<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, kind: Kind, name: &str) -> Option<Given<'t>> {
    let is_paused = is_paused(look);
    let job = look.snapshot.job.as_ref();
    let is_open = job.is_some_and(|job| job.end.is_none());
    let path = job.map_or("", |job| job.path.as_str());
    let number = |number: Option<u32>| number.map_or(Given::None, |number| Given::Int(i64::from(number)));
    Some(match (kind, name) {
        (Kind::PrintStats, "state") => Given::Text(match job.map(|job| job.end) {
            _ if is_paused => "paused",
            None => "standby",
            Some(None) => "printing",
            Some(Some(JobEnd::Complete)) => "complete",
            Some(Some(JobEnd::Cancelled)) => "cancelled",
            Some(Some(JobEnd::Halted)) => "error",
        }),
        (Kind::PrintStats, "filename") => Given::Text(path.strip_prefix("/sd/").unwrap_or(path)),
        (Kind::PrintStats, "message") => Given::Text(""),
        (Kind::PrintStats, "total_duration" | "print_duration") => {
            Given::Float(job.map_or(0.0, |job| f64::from(job.elapsed_s)))
        }
        (Kind::PrintStats, "filament_used") => Given::Float(job.map_or(0.0, |job| f64::from(job.filament))),
        (Kind::PrintStats, "info") => Thing::Status(Kind::PrintInfo, 0).given(),
        (Kind::PrintInfo, "current_layer") => number(job.map(|job| job.layer)),
        (Kind::PrintInfo, "total_layer") => number(job.and_then(|job| job.layers)),
        (Kind::Card, "is_active") => Given::Bool(is_open && !is_paused),
        (Kind::Card, "progress") => Given::Float(progress(job)),
        (Kind::Card, "file_position") => Given::Int(job.map_or(0, |job| i64::from(job.done))),
        (Kind::Card, "file_size") => Given::Int(job.map_or(0, |job| i64::from(job.size))),
        (Kind::Card, "file_path") => {
            if is_open {
                Given::Text(path)
            } else {
                Given::None
            }
        }
        _ => return None,
    })
}

fn mesh<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    let mesh = look.snapshot.mesh.as_ref();
    let [least, greatest] = mesh.map_or([[0.0; 2]; 2], |mesh| mesh.ends);
    match name {
        // A mesh that is not saved has Klipper's name for the one that was made last.
        "profile_name" => Some(Given::Text(match mesh {
            None => "",
            Some(mesh) if mesh.name.is_empty() => "default",
            Some(mesh) => mesh.name.as_str(),
        })),
        "profiles" => Some(Thing::Profiles.given()),
        "mesh_min" => look.write(format_args!("({:?}, {:?})", least[0], least[1]), Given::Literal),
        "mesh_max" => look.write(format_args!("({:?}, {:?})", greatest[0], greatest[1]), Given::Literal),
        _ => None,
    }
}

fn retraction<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    let Seen { program, .. } = look.hands.seen();
    let tool = &program.tools().active()?.settings;
    Some(Given::Float(match name {
        "retract_length" => tool.retract_length,
        "retract_speed" => tool.retract_rate.0,
        "unretract_extra_length" => tool.recover_length,
        "unretract_speed" => tool.recover_rate.0,
        _ => return None,
    }))
}

/// Gives the end switches as a dict, 1 where they are pressed.
fn endstops<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>) -> Option<Given<'t>> {
    struct Levels<'s>(&'s base::snapshot::Snapshot);
    impl fmt::Display for Levels<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_char('{')?;
            for limit in &self.0.limits {
                write!(f, "'{}':{},", limit.axis.letter().to_ascii_lowercase(), u8::from(limit.is_pressed))?;
            }
            f.write_char('}')
        }
    }
    let snapshot = look.snapshot;
    look.write(format_args!("{}", Levels(snapshot)), Given::Literal)
}

/// Gives Klipper's lists of heaters and sensors, under the names that they have in the printer.cfg.
fn heaters<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    struct List<'s>(&'s [HeaterShown], bool);
    impl fmt::Display for List<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_char('[')?;
            for heater in self.0.iter().filter(|heater| heater.heats || self.1) {
                let kind = match heater.designator.as_str() {
                    "T" | "T0" => "extruder",
                    "B" => "heater_bed",
                    _ if heater.heats => "heater_generic ",
                    _ => "temperature_sensor ",
                };
                let name = if kind.ends_with(' ') { heater.name.as_str() } else { "" };
                write!(f, "'{kind}{name}',")?;
            }
            f.write_char(']')
        }
    }
    let all = match name {
        "available_heaters" => false,
        "available_sensors" => true,
        _ => return None,
    };
    let heaters = &look.snapshot.heaters;
    look.write(format_args!("{}", List(heaters, all)), Given::Literal)
}

/// Gives a member of `printer.exclude_object`: objects of the print, with the rectangles around them.
fn print<'t, 'c, H: MacroHands<'c>>(look: &'t mut Look<'_, 'c, H>, name: &str) -> Option<Given<'t>> {
    let Seen { jobs, macros, .. } = look.hands.seen();
    match name {
        "objects" => Some(Thing::PrintObjects.given()),
        "current_object" => match jobs.objects.current().and_then(|place| jobs.objects.shown(place)) {
            Some(object) => {
                macros.memory.text.fill(object.name.bytes());
                look.read_text(Given::Text)
            }
            None => Some(Given::None),
        },
        "excluded_objects" => {
            let text = &mut *macros.memory.text;
            text.fill("[".bytes());
            for object in (0..).map_while(|place| jobs.objects.shown(place)).filter(|object| object.is_left_out) {
                // A text that does not fit is seen by its length.
                let _ = fmt::Write::write_fmt(text, format_args!("{:?},", object.name));
            }
            text.push(b']');
            look.read_text(Given::Literal)
        }
        _ => None,
    }
}

/// Gives a member of an object of the print.
pub(super) fn print_object<'t, 'c, H: MacroHands<'c>>(
    look: &'t mut Look<'_, 'c, H>,
    place: u8,
    name: &str,
) -> Option<Given<'t>> {
    let Seen { jobs, macros, .. } = look.hands.seen();
    let ObjectShown { name: own, outline, .. } = jobs.objects.shown(usize::from(place))?;
    if name == "name" {
        macros.memory.text.fill(own.bytes());
        return look.read_text(Given::Text);
    }
    let [left, near, right, far] = outline?;
    match name {
        "center" => look
            .write(format_args!("[{:?},{:?}]", f32::midpoint(left, right), f32::midpoint(near, far)), Given::Literal),
        "polygon" => look.write(
            format_args!("[[{left:?},{near:?}],[{right:?},{near:?}],[{right:?},{far:?}],[{left:?},{far:?}]]"),
            Given::Literal,
        ),
        _ => None,
    }
}
