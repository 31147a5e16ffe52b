//! Actions in words for a person.

use core::fmt::{self, Write};

use units::{PerAxis, PowerLaw};

use crate::action::{Action, AwaitInput, Centre, Contact, Corner, Effect, Move, ProbeAlong, ProbeDown, Rate, Shape};
use crate::function::Function;
use crate::lights::{LightChange, Lights};

/// Name of the function in words: `axis speeds`.
impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut name = heapless::String::<32>::new();
        // The buffer holds every name.
        let _ = match self {
            Self::Limit(function) => write!(name, "{function:?}"),
            Self::Setting(function) => write!(name, "{function:?}"),
            Self::Report(function) => write!(name, "{function:?}"),
            Self::File(function) => write!(name, "{function:?}"),
            Self::Standing(function) => write!(name, "{function:?}"),
            Self::Geometry(function) => write!(name, "{function:?}"),
            Self::Sequence(function) => write!(name, "{function:?}"),
        };
        for (place, letter) in name.chars().enumerate() {
            if place > 0 && letter.is_ascii_uppercase() {
                f.write_char(' ')?;
            }
            f.write_char(letter.to_ascii_lowercase())?;
        }
        Ok(())
    }
}

/// Action in words: its effect, seen from a position.
#[derive(Clone, Copy, Debug)]
pub struct Described<'a, 'b> {
    action: &'a Action<'b>,
    from: &'a PerAxis<f64>,
}

impl<'b> Action<'b> {
    /// Returns the action in words for a person. Moves name the axes that differ from where the move begins.
    #[must_use]
    pub const fn described<'a>(&'a self, from: &'a PerAxis<f64>) -> Described<'a, 'b> {
        Described { action: self, from }
    }
}

impl fmt::Display for Described<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.action {
            Action::Move(request) => describe_move(f, request, self.from),
            Action::Dwell(time) => write!(f, "dwell {} s", time.seconds()),
            Action::Effect(effect) => describe_effect(f, effect),
            Action::HeatAndWait { heater, target, .. } => {
                write!(f, "heater {} to {} C, and wait for it", heater.index(), target.0)
            }
            Action::Home(axes) if axes.is_empty() => f.write_str("home"),
            Action::Home(axes) => write!(f, "home {axes}"),
            Action::SetPosition { to, homed } => {
                f.write_str("position is")?;
                for axis in units::Axis::ALL {
                    to[axis].map_or(Ok(()), |mm| write!(f, " {}{mm}", axis.letter()))?;
                }
                if *homed { f.write_str(", homed") } else { Ok(()) }
            }
            Action::ForgetHoming(axes) => write!(f, "forget homing of {axes}"),
            Action::ProbeDown(probe) => describe_probe_down(f, probe),
            Action::ProbeAlong(probe) => describe_probe_along(f, probe, self.from),
            Action::Finish => f.write_str("wait until nothing moves"),
            Action::EndProgram => f.write_str("end of program"),
            Action::Halt => f.write_str("emergency stop"),
            Action::Release => f.write_str("clear the halt"),
            Action::Suspend { heaters_stay, .. } => {
                f.write_str(if *heaters_stay { "suspend, heaters stay on" } else { "suspend" })
            }
            Action::Resume => f.write_str("resume"),
            Action::Message(text) => write!(f, "message: {text}"),
            Action::Pause { time, text, .. } => {
                let waits = time.map(|time| write!(f, "wait {} s", time.seconds()));
                waits.unwrap_or_else(|| f.write_str("wait for the operator"))?;
                text.map_or(Ok(()), |text| write!(f, ": {text}"))
            }
            Action::Call { number, times } => write!(f, "call O{number}, {times} times"),
            Action::Return => f.write_str("end of subroutine"),
            Action::ChangeTool(tool) => write!(f, "put in tool {tool}"),
            Action::Overrides { feed, spindle, hold } => {
                let counts = |on: &bool| if *on { "count" } else { "do not count" };
                write!(f, "overrides of feed {}, of the spindle {}", counts(feed), counts(spindle))?;
                f.write_str(if *hold { "" } else { ", feed hold waits" })
            }
            Action::RetractByHand => f.write_str("wait until the tool is drawn out by hand"),
            Action::AwaitInput(awaited) => describe_awaited(f, awaited),
            Action::RigidTap { target, pitch, faster } => {
                f.write_str("tap to")?;
                describe_target(f, target, self.from)?;
                write!(f, ", {pitch} mm a turn, {faster} times faster back")
            }
            Action::Orient { degrees, turning, patience } => {
                write!(f, "turn the spindle to {degrees} degrees, {turning:?}")?;
                patience.map_or(Ok(()), |patience| write!(f, ", {} s at most", patience.seconds()))
            }
            Action::SurfaceSpeed(None) => f.write_str("S is the speed of the spindle"),
            Action::SurfaceSpeed(Some(most)) => write!(f, "S is the speed of the surface, at most {most} 1/min"),
            Action::ReadTools => f.write_str("read the tool table"),
            Action::Keep => f.write_str("keep that on the card"),
            Action::Note(text) => write!(f, "note: {text}"),
            Action::Acceleration(value) => write!(f, "accelerate with {value} mm/s2"),
            Action::Function(function, words) => write!(f, "{function}{words}"),
        }
    }
}

fn describe_move(f: &mut fmt::Formatter<'_>, request: &Move, from: &PerAxis<f64>) -> fmt::Result {
    let kind = match (&request.shape, request.rate) {
        (Shape::Line { .. }, Rate::Rapid(_)) => "rapid",
        (Shape::Line { .. }, _) => "line",
        (Shape::Arc { clockwise: true, .. }, _) => "arc clockwise",
        (Shape::Arc { .. }, _) => "arc counter-clockwise",
        (Shape::Cubic(_), _) => "cubic spline",
        (Shape::Quadratic(_), _) => "quadratic spline",
        (Shape::Nurbs { .. }, _) => "NURBS",
    };
    write!(f, "{kind} to")?;
    describe_target(f, &request.target, from)?;
    match request.shape {
        Shape::Line { .. } => {}
        Shape::Arc { plane, centre, turns, .. } => {
            let (first, second) = plane.axes();
            match centre {
                Centre::At(a, b) => {
                    let (a, b) = (tidy(from[first] + a), tidy(from[second] + b));
                    write!(f, ", centre {}{a} {}{b}", first.letter(), second.letter())?;
                }
                Centre::Radius(radius) => write!(f, ", radius {radius} in {}{}", first.letter(), second.letter())?,
            }
            if turns > 1 {
                write!(f, ", {turns} turns")?;
            }
        }
        Shape::Cubic([(i, j), (p, q)]) => write!(f, ", leaving by {i} {j}, arriving from {p} {q}")?,
        Shape::Quadratic((i, j)) => write!(f, ", by {i} {j}")?,
        Shape::Nurbs { order } => write!(f, ", of order {order}")?,
    }
    match request.rate {
        Rate::Rapid(speed) | Rate::Feed(speed) => write!(f, " at {} mm/s", speed.0)?,
        Rate::PerRevolution(mm) => write!(f, ", {mm} mm a turn")?,
        Rate::Duration(seconds) => write!(f, " in {seconds} s")?,
    }
    if request.power != 0.0 {
        write!(f, ", S{}", request.power)?;
        if request.power_law == PowerLaw::BySpeed {
            f.write_str(" by speed")?;
        }
    }
    match request.corner {
        Corner::Sharp => Ok(()),
        Corner::Stop => f.write_str(", from a stop"),
        Corner::Rounded(None) => f.write_str(", corner rounded"),
        Corner::Rounded(Some(mm)) => write!(f, ", corner rounded within {mm} mm"),
    }
}

fn describe_target(f: &mut fmt::Formatter<'_>, target: &PerAxis<f64>, from: &PerAxis<f64>) -> fmt::Result {
    for axis in units::Axis::ALL.into_iter().filter(|axis| target[*axis] != from[*axis]) {
        write!(f, " {}{}", axis.letter(), tidy(target[axis]))?;
    }
    Ok(())
}

/// Rounds to the nanometre, so that a number typed by a person is shown as typed.
fn tidy(mm: f64) -> f64 {
    libm::round(mm * 1e6) / 1e6
}

fn describe_effect(f: &mut fmt::Formatter<'_>, effect: &Effect) -> fmt::Result {
    match effect {
        Effect::Target { heater, target } => write!(f, "heater {} to {} C, on the way", heater.index(), target.0),
        Effect::Switch { switch, on, value } => {
            write!(f, "switch {} {}", switch.index(), if *on { "on" } else { "off" })?;
            value.map_or(Ok(()), |value| write!(f, " at {value}"))?;
            f.write_str(", on the way")
        }
        Effect::Arm { rule, armed } => {
            write!(f, "temperature switch {rule} {}", if *armed { "armed" } else { "disarmed" })
        }
        Effect::Light(change) => describe_light(f, change),
        Effect::Ignored { code, letter } => write!(f, "{code} takes no {letter}: it changes nothing"),
    }
}

fn describe_awaited(f: &mut fmt::Formatter<'_>, awaited: &AwaitInput) -> fmt::Result {
    let input = awaited.input.index();
    let Some(event) = awaited.event else { return write!(f, "read input {input}") };
    write!(f, "wait for input {input}, {event:?}")?;
    match awaited.patience {
        AwaitInput::FOR_EVER => Ok(()),
        patience => write!(f, ", {} s at most", patience.seconds()),
    }
}

fn describe_probe_along(f: &mut fmt::Formatter<'_>, probe: &ProbeAlong, from: &PerAxis<f64>) -> fmt::Result {
    let until = if probe.until == Contact::Closes { "contact" } else { "release" };
    write!(f, "search for {until} to")?;
    describe_target(f, &probe.target, from)?;
    probe.rate.map_or(Ok(()), |rate| write!(f, " at {} mm/s", rate.0))?;
    f.write_str(if probe.must_find { ", or alarm" } else { "" })
}

fn describe_probe_down(f: &mut fmt::Formatter<'_>, probe: &ProbeDown) -> fmt::Result {
    f.write_str(if probe.reversed { "search for the bed the other way" } else { "search for the bed" })?;
    probe.rate.map_or(Ok(()), |rate| write!(f, " at {} mm/s", rate.0))?;
    probe.reads.map_or(Ok(()), |mm| write!(f, ", Z reads {mm} there"))?;
    f.write_str(if probe.stays { ", and stay" } else { ", and return" })
}

fn describe_light(f: &mut fmt::Formatter<'_>, change: &LightChange) -> fmt::Result {
    match change.which {
        Lights::All => f.write_str("lights")?,
        Lights::One(place) => write!(f, "light {place}")?,
        Lights::Next { count, more } => write!(f, "next {count} lights{}", if more { ", more follow," } else { "" })?,
    }
    change.strip.map_or(Ok(()), |strip| write!(f, " of strip {strip}"))?;
    for (letter, part) in ['R', 'G', 'B', 'W'].into_iter().zip(change.parts) {
        part.map_or(Ok(()), |part| write!(f, " {letter}{part}"))?;
    }
    f.write_str(if change.shown { "" } else { ", not shown yet" })?;
    f.write_str(if change.rides { ", on the way" } else { ", at once" })
}
