//! `velvet actions`: what a program asks of a machine, one action a line, without a machine.
//!
//! A file that says which firmware it is for is read in that dialect, with one extruder; else in GRBL's,
//! without extruders. The program runs as in a preflight, on a machine that stands at the origin: loops turn,
//! subroutines are called from their files, no move is limited. Lengths are mm in machine coordinates, rates
//! mm/min, times seconds.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use base::failure::{ShortText, short};
use config::MachineConfig;
use gcode::{Code, Letter};
use motion::Motion;
use motion::geometry::{Arc, ArcShape};
use preflight::{Finding, Kind, Listener, Preflight, Severity};
use program::{
    Action, Centre, Claim, CodeInfo, Dialect, Effect, Interpreter, IoKind, IoSetup, Move, Rate, Remark, Setup, Shape,
    SpindleSetup, ToolEntry, ToolSettings,
};
use units::{Axis, MmPerSecond, PerAxis, Plane, SwitchId, ToolId};

use crate::preflight::Subs;

/// Number of outputs, of outputs with a value, and of inputs, as LinuxCNC has them.
const IO: u8 = 4;
/// First switch beyond those with numbers.
const COOLANT: SwitchId = SwitchId(100);
/// Switches of M3, M4 and M5: separate, so that the three codes are told apart.
const SPINDLE: [(SwitchId, &str); 3] = [(SwitchId(103), "cw"), (SwitchId(104), "ccw"), (SwitchId(105), "stop")];
/// Greatest number of actions: loops may have no end.
const MOST_ACTIONS: u32 = 1_000_000;

/// Prints the actions of a program.
///
/// # Errors
/// When a file cannot be read, or a line cannot be carried out: it is named.
pub fn print(file: &Path, tools: Option<&Path>) -> Result<()> {
    let text = fs::read(file).with_context(|| file.display().to_string())?;
    let dialect = preflight::dialect_of(&text).unwrap_or(Dialect::Grbl);
    let mut program = Interpreter::new(setup(dialect));
    if let Some(tools) = tools {
        read_tools(&mut program, tools)?;
    }
    let (config, texts) = (MachineConfig::default(), base::failure::Texts::new());
    let (mut place, mut motion) = (None, Box::new(Motion::new()));
    let mut preflight = Preflight::of_nothing(&config, &texts, &mut place);
    preflight.only_listens(program, dialect);
    let mut list = List { dialect, here: PerAxis([0.0; units::MAX_AXES]), out: String::new(), count: 0, wrong: None };
    let subs = Subs::beside(file)?;
    let read = preflight::read(&mut preflight, &text, &|name| subs.text(name), &mut motion, &mut list);
    print!("{}", list.out);
    subs.check()?;
    if let Some(Finding { sub, line, what, .. }) = list.wrong {
        let path = sub.map_or_else(|| file.to_owned(), |sub| file.with_file_name(format!("{sub}.ngc")));
        return Err(anyhow!("{what}").context(format!("{}, line {line}", path.display())));
    }
    read.map_err(|why| anyhow!("{}: {why}", file.display()))
}

fn read_tools(program: &mut Interpreter, file: &Path) -> Result<()> {
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    for (number, tool) in (1..).zip(text.lines().map(ToolEntry::read)) {
        if let Some(tool) = tool {
            let added = tool.and_then(|tool| program.tool_table().add(tool));
            added.map_err(|flaw| anyhow::anyhow!("{}, line {number}: {flaw}", file.display()))?;
        }
    }
    Ok(())
}

/// Returns the settings of an extruder as in the sample configurations.
const fn extruder() -> ToolSettings {
    ToolSettings {
        id: ToolId(0),
        axis: Axis::A,
        offset: [0.0; 3],
        filament_diameter: None,
        retract_length: 3.0,
        retract_rate: MmPerSecond(45.0),
        recover_length: 0.0,
        recover_rate: MmPerSecond(30.0),
        z_lift: 0.0,
        z_lift_rate: MmPerSecond(10.0),
        flow_limit: None,
        is_off: false,
    }
}

/// Returns a mill with all that a program may ask for; a printer in other dialects than GRBL's.
fn setup(dialect: Dialect) -> Setup {
    // No rates are set, as a program finds them on a mill.
    let spindle = SpindleSetup { has_encoder: true, has_speed_control: true };
    let mut setup = Setup { seek_rate: MmPerSecond(100.0), compliant_seek_rate: true, spindle, ..Setup::default() };
    setup.is_preview = true;
    if dialect != Dialect::Grbl {
        // The tool list has room for this extruder.
        let _ = setup.tools.push(extruder());
    }
    for (code, claim) in [
        (3, Claim::SwitchOn(SPINDLE[0].0)),
        (4, Claim::SwitchOn(SPINDLE[1].0)),
        (5, Claim::SwitchOff(SPINDLE[2].0)),
        (7, Claim::SwitchOn(COOLANT)),
        (8, Claim::SwitchOn(COOLANT)),
        (9, Claim::SwitchOff(COOLANT)),
    ] {
        // Every one of these codes can be claimed.
        let _ = setup.claims.add(Code::m(code), claim);
    }
    for number in 0..IO {
        for (from, kind) in [(0, IoKind::Digital), (IO, IoKind::Analog), (2 * IO, IoKind::Input)] {
            // The list has room for three times as many.
            let _ = setup.io.push(IoSetup { number, switch: SwitchId(from + number), kind });
        }
    }
    setup
}

/// The list of actions, as far as the file has been read.
struct List {
    dialect: Dialect,
    here: PerAxis<f64>,
    out: String,
    count: u32,
    /// The fault at which the list ends.
    wrong: Option<Finding>,
}

impl Listener for List {
    fn found(&mut self, finding: &Finding) {
        let ends = finding.kind.severity() == Severity::Stop || finding.kind == Kind::Unforeseen;
        if ends && self.wrong.is_none() {
            self.wrong = Some(finding.clone());
        }
    }

    fn has_heard_enough(&self) -> bool {
        self.wrong.is_some()
    }

    fn acts(&mut self, action: &Action<'_>) -> Result<bool, ShortText> {
        self.count += 1;
        if self.count > MOST_ACTIONS {
            return Err(short(format_args!("more than {MOST_ACTIONS} actions: a loop without an end?")));
        }
        if self.wrong.is_none() {
            self.list(action)?;
        }
        Ok(matches!(action, Action::Call { .. } | Action::Return | Action::EndProgram))
    }

    fn acts_on_the_way(&mut self, effect: Effect) -> bool {
        if self.wrong.is_none() {
            self.effect(effect, " with the path");
        }
        false
    }

    fn remarks(&mut self, remark: Remark<'_>, program: &Interpreter) {
        let (kind, said) = match remark {
            Remark::Message(said) => return self.line(format_args!("message {said}")),
            Remark::Printed(said) => ("print", said),
            Remark::Debug(said) if program.debugs() => ("message", said),
            _ => return,
        };
        let mut text = String::new();
        // A String takes any text.
        let _ = program::write_values(program, said, &mut text);
        self.line(format_args!("{kind} {text}"));
    }

    fn commands(&mut self, text: &str) -> Result<(), ShortText> {
        Err(short(format_args!("a console command: {text}")))
    }

    /// A job waits at codes that are missing, for what follows counts on them. Other codes are left out as in
    /// a job, but a mill's program is refused for those that nobody knows; commands for a spindle and coolant
    /// may be missing on a machine.
    fn leaves_out(&mut self, row: Option<&CodeInfo>, code: Code) -> Result<bool, ShortText> {
        let is_unknown = row.is_none() && (code.letter != Letter::M || self.dialect == Dialect::Grbl);
        match row {
            Some(row) if row.is_missing() => {
                return Err(short(format_args!("{code} is not carried out here: {}", row.help)));
            }
            None if is_unknown && !(code.letter == Letter::M && matches!(code.number, 3..=5 | 7..=9)) => {
                return Err(short(format_args!("{code} is not known")));
            }
            _ if self.dialect != Dialect::Grbl => self.line(format_args!("left out {code}")),
            _ => {}
        }
        Ok(false)
    }
}

impl List {
    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        // A String takes any text.
        let _ = writeln!(self.out, "{text}");
    }

    fn effect(&mut self, effect: Effect, when: &str) {
        let Effect::Switch { switch, on, value } = effect else { return };
        if let Some((_, turning)) = SPINDLE.iter().find(|(own, _)| *own == switch) {
            return self.line(format_args!("spindle {turning}"));
        }
        match (switch.0.checked_sub(IO), value) {
            _ if switch == COOLANT => {}
            (None, _) => self.line(format_args!("output {} {}{when}", switch.0, if on { "on" } else { "off" })),
            (Some(number), value) => self.line(format_args!("value {number} {:.6}{when}", value.unwrap_or(0.0))),
        }
    }

    fn list(&mut self, action: &Action<'_>) -> Result<(), ShortText> {
        match action {
            Action::Move(request) => self.movement(request)?,
            Action::Dwell(time) => self.line(format_args!("dwell {}", time.0 as f64 / 1e6)),
            Action::Pause { .. } | Action::RetractByHand => self.line(format_args!("pause")),
            Action::ChangeTool(tool) => self.line(format_args!("tool {tool}")),
            Action::Message(text) => self.line(format_args!("message {text}")),
            Action::EndProgram => self.line(format_args!("end")),
            Action::Call { .. } | Action::Return | Action::Keep | Action::Finish => {}
            Action::Effect(effect) => self.effect(*effect, ""),
            Action::Overrides { feed, spindle, .. } => self.line(format_args!("overrides {feed} {spindle}")),
            Action::AwaitInput(wait) => self.line(format_args!("input {} {:?}", wait.input.0 - 2 * IO, wait.event)),
            Action::Orient { degrees, turning, patience } => {
                let seconds = patience.map_or(0.0, |patience| patience.0 as f64 / 1e6);
                self.line(format_args!("orient {degrees:.4} {} {seconds:.4}", *turning as u8));
            }
            Action::SurfaceSpeed(most) => self.line(format_args!("surface_speed {:.4}", most.unwrap_or(0.0))),
            Action::RigidTap { target, pitch, .. } => {
                let [x, y, z, ..] = target.0.map(|mm| mm + 0.0);
                self.line(format_args!("tap {x:.5} {y:.5} {z:.5} P{pitch:.6}"));
            }
            Action::HeatAndWait { .. }
            | Action::Home(_)
            | Action::SetPosition { .. }
            | Action::ForgetHoming(_)
            | Action::ProbeDown(_)
            | Action::ProbeAlong(_)
            | Action::Halt
            | Action::Release
            | Action::Suspend { .. }
            | Action::Resume
            | Action::ReadTools
            | Action::Note(_)
            | Action::Acceleration(_)
            | Action::Function(..) => {
                let here = self.here;
                self.line(format_args!("{}", action.described(&here)));
            }
        }
        Ok(())
    }

    fn movement(&mut self, request: &Move) -> Result<(), ShortText> {
        let from = self.here;
        arc_is_sound(&from, request)?;
        self.here = request.target;
        let mut end = String::new();
        for axis in Axis::ALL {
            end += &format!(" {:.5}", self.here[axis] + 0.0);
        }
        let rate = match request.rate {
            Rate::Rapid(_) => String::new(),
            Rate::Feed(rate) => format!(" F{:.4}", rate.0 * 60.0),
            Rate::PerRevolution(mm) => format!(" P{mm:.6}"),
            Rate::Duration(seconds) => format!(" T{seconds:.6}"),
        };
        let kind = match (request.shape, request.rate) {
            (Shape::Line { .. }, Rate::Rapid(_)) => "rapid".into(),
            (Shape::Line { .. }, _) => "feed".into(),
            (Shape::Arc { plane, centre, clockwise, turns, .. }, _) => {
                let (first, second) = plane.axes();
                let (plane, sense) = (plane_name(plane), if clockwise { "cw" } else { "ccw" });
                match centre {
                    Centre::At(i, j) => {
                        format!("arc {plane} {sense} {turns} {:.5} {:.5}", from[first] + i, from[second] + j)
                    }
                    Centre::Radius(radius) => format!("arc {plane} {sense} {turns} R{radius:.5}"),
                }
            }
            (shape, _) => format!("{shape:?}"),
        };
        self.line(format_args!("{kind}{end}{rate}"));
        Ok(())
    }
}

/// Fails unless such an arc exists: the machine itself checks an arc only when it draws it.
fn arc_is_sound(from: &PerAxis<f64>, request: &Move) -> Result<(), ShortText> {
    let Shape::Arc { plane, centre, clockwise, turns, column } = request.shape else { return Ok(()) };
    let shape = match centre {
        Centre::Radius(radius) => ArcShape::by_radius(from, &request.target, plane, radius, clockwise),
        Centre::At(first, second) => {
            Ok(ArcShape { plane, to_centre_first: first, to_centre_second: second, clockwise, turns })
        }
    };
    let arc = shape.and_then(|shape| Arc::new(*from, request.target, &ArcShape { turns, ..shape }));
    arc.map(drop).map_err(|error| short(format_args!("{error}, column {column}")))
}

const fn plane_name(plane: Plane) -> &'static str {
    match plane {
        Plane::Xy => "XY",
        Plane::Xz => "XZ",
        Plane::Yz => "YZ",
    }
}
