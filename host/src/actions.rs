//! `velvet actions`: what a program asks of a machine, one action a line, without a machine.
//!
//! A file that says which firmware it is for is read in that dialect, with one extruder; else in GRBL's,
//! without extruders. The program runs as on a machine that stands at the origin: loops turn, subroutines are
//! called from their files, no move is limited. Lengths are mm in machine coordinates, rates mm/min, times
//! seconds.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use gcode::{Block, Blocks, Code, Decoder, Letter, Line, WholeLine};
use motion::geometry::{Arc, ArcShape};
use program::{
    Action, Centre, Claim, Dialect, Effect, Facts, Interpreter, IoKind, IoSetup, Meaning, Move, Next, Place, Rate,
    Remark, Setup, Shape, SpindleSetup, ToolEntry, ToolSettings,
};
use units::{Axis, AxisSet, MmPerSecond, PerAxis, Plane, SwitchId, ToolId};

/// Number of outputs, of outputs with a value, and of inputs, as LinuxCNC has them.
const IO: u8 = 4;
/// First switch beyond those with numbers.
const COOLANT: SwitchId = SwitchId(100);
/// Switches of M3, M4 and M5: separate, so that the three codes are told apart.
const SPINDLE: [(SwitchId, &str); 3] = [(SwitchId(103), "cw"), (SwitchId(104), "ccw"), (SwitchId(105), "stop")];
/// Greatest number of lines carried out: loops may have no end.
const MOST_LINES: u32 = 1_000_000;

/// Prints the actions of a program.
///
/// # Errors
/// When a file cannot be read, or a line cannot be carried out: it is named.
pub fn print(file: &Path, tools: Option<&Path>) -> Result<()> {
    let mut run = Run::begin(file)?;
    if let Some(tools) = tools {
        read_tools(&mut run.program, tools)?;
    }
    let ended = run.run();
    print!("{}", run.out);
    ended
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

/// File that is read line by line.
struct Source {
    path: PathBuf,
    lines: Vec<Vec<u8>>,
    at: usize,
}

impl Source {
    fn open(path: &Path) -> Result<Self> {
        let text = fs::read(path).with_context(|| path.display().to_string())?;
        let lines = text.split(|byte| *byte == b'\n').map(|line| line.trim_ascii_end().to_vec()).collect();
        Ok(Self { path: path.into(), lines, at: 0 })
    }
}

struct Run {
    program: Interpreter,
    dialect: Dialect,
    sources: Vec<Source>,
    here: PerAxis<f64>,
    out: String,
    has_ended: bool,
    has_begun: bool,
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

fn place(line: usize) -> Place {
    Place { offset: 0, line: line as u32 }
}

impl Run {
    fn begin(file: &Path) -> Result<Self> {
        // No rates are set, as a program finds them on a mill.
        let spindle = SpindleSetup { has_encoder: true, has_speed_control: true };
        let mut setup = Setup { seek_rate: MmPerSecond(100.0), compliant_seek_rate: true, spindle, ..Setup::default() };
        setup.is_preview = true;
        let source = Source::open(file)?;
        let dialect = preflight::dialect_of(&source.lines.join(&b'\n')).unwrap_or(Dialect::Grbl);
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
        Ok(Self {
            program: Interpreter::new(setup),
            dialect,
            sources: vec![source],
            here: PerAxis([0.0; units::MAX_AXES]),
            out: String::new(),
            has_ended: false,
            has_begun: false,
        })
    }

    fn run(&mut self) -> Result<()> {
        let mut count = 0;
        while !self.has_ended {
            let Some(source) = self.sources.last_mut() else { break };
            let Some(line) = source.lines.get(source.at).cloned() else { break };
            source.at += 1;
            count += 1;
            if count > MOST_LINES {
                bail!("more than {MOST_LINES} lines: a loop without an end?");
            }
            let (number, path) = (source.at, source.path.clone());
            self.program.at_line(number as u32);
            let carried_out = self.line(&line, place(number - 1), place(number));
            carried_out.with_context(|| format!("{}, line {number}", path.display()))?;
        }
        self.program.end_file().map_err(|fault| anyhow::anyhow!("at the end of the file: {fault}"))
    }

    fn line(&mut self, line: &[u8], here: Place, after: Place) -> Result<()> {
        if line.trim_ascii_start().first() == Some(&b'%') {
            // The first `%` begins the program, the second one ends it.
            self.has_ended = core::mem::replace(&mut self.has_begun, true);
            return Ok(());
        }
        match Decoder::new().decode(line) {
            Ok(Line::Flow(line)) => {
                let next = self.program.flow_line(&line, here, after).map_err(|fault| anyhow::anyhow!("{fault}"))?;
                self.effects()?;
                while let Some(action) = self.program.next_action() {
                    self.action(&action, after)?;
                }
                self.go_on(next)
            }
            _ if self.program.flow().passes_over() => Ok(()),
            Ok(Line::Code(blocks)) => self.blocks(blocks, after),
            Ok(Line::Blank) => Ok(()),
            Ok(Line::Extended(command)) => bail!("a command by name: {}", command.name()),
            Ok(Line::Console(text)) => bail!("a console command: {text}"),
            Err(refusal) => bail!("{refusal}"),
        }
    }

    fn go_on(&mut self, next: Next) -> Result<()> {
        match next {
            Next::Following => {}
            Next::At(place) => {
                if let Some(source) = self.sources.last_mut() {
                    source.at = place.line as usize;
                }
            }
            Next::FirstOf(name) => {
                let folder = self.sources.first().and_then(|source| source.path.parent()).unwrap_or(Path::new(""));
                match Source::open(&folder.join(format!("{name}.ngc"))) {
                    Ok(source) => {
                        self.sources.push(source);
                        self.program.enter_file();
                    }
                    Err(_) => self.program.search_sub(),
                }
            }
            Next::Returned => {
                self.sources.pop();
            }
        }
        Ok(())
    }

    fn blocks(&mut self, mut blocks: Blocks<'_>, after: Place) -> Result<()> {
        let mut block = Block::new(None, 0);
        if self.dialect.orders_lines() && self.in_order(&blocks, after)? {
            return Ok(());
        }
        loop {
            let read = blocks.read(&mut block, &mut self.program).map_err(|error| anyhow::anyhow!("{error}"))?;
            if let Some(remark) = blocks.take_remark().and_then(Remark::read) {
                self.remark(remark)?;
            }
            if !read {
                break;
            }
            self.block(&block, after)?;
        }
        self.program.end_line().map_err(|fault| anyhow::anyhow!("{fault}"))
    }

    /// Reads a line whose codes have an order of their own; false when the dialect does not read it so.
    fn in_order(&mut self, blocks: &Blocks<'_>, after: Place) -> Result<bool> {
        let (mut ahead, mut whole) = (blocks.clone(), WholeLine::default());
        let read = ahead.read_whole(&mut whole, &mut self.program);
        let Some(parts) = read.ok().and_then(|()| program::arrange(&whole)) else {
            self.program.drop_line();
            return Ok(false);
        };
        if let Some(remark) = ahead.take_remark().and_then(Remark::read) {
            self.remark(remark)?;
        }
        for part in &parts.map_err(|fault| anyhow::anyhow!("{fault}"))? {
            let block = whole.part(part.code, |letter| part.takes(letter)).clone();
            self.block(&block, after)?;
        }
        self.program.end_line().map_err(|fault| anyhow::anyhow!("{fault}"))?;
        Ok(true)
    }

    fn remark(&mut self, remark: Remark<'_>) -> Result<()> {
        let mut text = String::new();
        match remark {
            Remark::Message(said) => text.push_str(said),
            Remark::Printed(said) => program::write_values(&self.program, said, &mut text)?,
            Remark::Debug(said) if self.program.debugs() => program::write_values(&self.program, said, &mut text)?,
            _ => return Ok(()),
        }
        let kind = if matches!(remark, Remark::Printed(_)) { "print" } else { "message" };
        writeln!(self.out, "{kind} {text}")?;
        Ok(())
    }

    fn block(&mut self, block: &Block<'_>, after: Place) -> Result<()> {
        let Some(row) = self.program.row(block, self.dialect) else {
            if block.code.is_some_and(|code| code.letter == Letter::M && matches!(code.number, 3..=5 | 7..=9)) {
                // Commands for a spindle and coolant may be missing on a machine, so they pass.
                return Ok(());
            }
            // Unknown codes are left out as in a job, except for a G-code.
            if let Some(code) = block.code.filter(|code| code.letter == Letter::M && self.dialect != Dialect::Grbl) {
                writeln!(self.out, "left out {code}")?;
                return Ok(());
            }
            bail!("{} is not known", block.code.map_or_else(String::new, |code| code.to_string()));
        };
        let facts = Facts { homed: AxisSet::PRIMARY, can_home: AxisSet::PRIMARY };
        let meaning = self.program.run(block, row, facts, self.dialect).map_err(|fault| anyhow::anyhow!("{fault}"))?;
        self.effects()?;
        match (meaning, block.code) {
            (Meaning::Action(action), _) => self.action(&action, after)?,
            // A job waits here: what follows counts on it.
            (Meaning::PassedOver | Meaning::Unknown, Some(code)) if row.is_missing() => {
                bail!("{code} is not carried out here: {}", row.help);
            }
            (Meaning::PassedOver | Meaning::Unknown, Some(code)) if self.dialect != Dialect::Grbl => {
                writeln!(self.out, "left out {code}")?;
            }
            _ => {}
        }
        while let Some(action) = self.program.next_action() {
            self.action(&action, after)?;
        }
        Ok(())
    }

    fn effects(&mut self) -> Result<()> {
        while let Some(effect) = self.program.next_effect() {
            self.effect(effect, " with the path")?;
        }
        Ok(())
    }

    fn effect(&mut self, effect: Effect, when: &str) -> Result<()> {
        let Effect::Switch { switch, on, value } = effect else { return Ok(()) };
        if let Some((_, turning)) = SPINDLE.iter().find(|(own, _)| *own == switch) {
            writeln!(self.out, "spindle {turning}")?;
            return Ok(());
        }
        match (switch.0.checked_sub(IO), value) {
            _ if switch == COOLANT => {}
            (None, _) => writeln!(self.out, "output {} {}{when}", switch.0, if on { "on" } else { "off" })?,
            (Some(number), value) => writeln!(self.out, "value {number} {:.6}{when}", value.unwrap_or(0.0))?,
        }
        Ok(())
    }

    fn action(&mut self, action: &Action<'_>, after: Place) -> Result<()> {
        match action {
            Action::Move(request) => self.movement(request)?,
            Action::Dwell(time) => writeln!(self.out, "dwell {}", time.0 as f64 / 1e6)?,
            Action::Pause { .. } | Action::RetractByHand => writeln!(self.out, "pause")?,
            Action::ChangeTool(tool) => writeln!(self.out, "tool {tool}")?,
            Action::Message(text) => writeln!(self.out, "message {text}")?,
            Action::EndProgram => {
                self.has_ended = true;
                self.program.end_program();
                writeln!(self.out, "end")?;
            }
            Action::Call { number, times } => {
                let next = self.program.call(*number, *times, after).map_err(|fault| anyhow::anyhow!("{fault}"))?;
                self.go_on(next)?;
            }
            Action::Return => {
                let next = self.program.end_call().unwrap_or(Next::At(Place::default()));
                self.effects()?;
                self.go_on(next)?;
            }
            Action::Keep | Action::Finish => {}
            Action::Effect(effect) => self.effect(*effect, "")?,
            Action::Overrides { feed, spindle, .. } => writeln!(self.out, "overrides {feed} {spindle}")?,
            Action::AwaitInput(wait) => writeln!(self.out, "input {} {:?}", wait.input.0 - 2 * IO, wait.event)?,
            Action::Orient { degrees, turning, patience } => {
                let seconds = patience.map_or(0.0, |patience| patience.0 as f64 / 1e6);
                writeln!(self.out, "orient {degrees:.4} {} {seconds:.4}", *turning as u8)?;
            }
            Action::SurfaceSpeed(most) => writeln!(self.out, "surface_speed {:.4}", most.unwrap_or(0.0))?,
            Action::RigidTap { target, pitch, .. } => {
                let [x, y, z, ..] = target.0.map(|mm| mm + 0.0);
                writeln!(self.out, "tap {x:.5} {y:.5} {z:.5} P{pitch:.6}")?;
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
            | Action::Function(..) => writeln!(self.out, "{}", action.described(&self.here))?,
        }
        Ok(())
    }

    fn movement(&mut self, request: &Move) -> Result<()> {
        let from = self.here;
        arc_is_sound(&from, request)?;
        self.here = request.target;
        let mut end = String::new();
        for axis in Axis::ALL {
            write!(end, " {:.5}", self.here[axis] + 0.0)?;
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
        writeln!(self.out, "{kind}{end}{rate}")?;
        Ok(())
    }
}

/// Fails unless such an arc exists: the machine itself checks an arc only when it draws it.
fn arc_is_sound(from: &PerAxis<f64>, request: &Move) -> Result<()> {
    let Shape::Arc { plane, centre, clockwise, turns, column } = request.shape else { return Ok(()) };
    let shape = match centre {
        Centre::Radius(radius) => ArcShape::by_radius(from, &request.target, plane, radius, clockwise),
        Centre::At(first, second) => {
            Ok(ArcShape { plane, to_centre_first: first, to_centre_second: second, clockwise, turns })
        }
    };
    let arc = shape.and_then(|shape| Arc::new(*from, request.target, &ArcShape { turns, ..shape }));
    arc.map(drop).map_err(|error| anyhow::anyhow!("{error}, column {column}"))
}

const fn plane_name(plane: Plane) -> &'static str {
    match plane {
        Plane::Xy => "XY",
        Plane::Xz => "XZ",
        Plane::Yz => "YZ",
    }
}
