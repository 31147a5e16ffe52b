//! Tests of the language as pages of text, `language/*.txt`: program lines, and the actions they mean.
//!
//! `# title` begins a program with a new interpreter. A line at the margin is a line of the program; the
//! indented lines below it are the expected actions of the machine, or `error:` or `alarm:` with the message.
//! `@` lines describe the machine or its findings. The machine has extruders 0 (A) and 1 (B, 20 mm to the
//! right, its filament 1.75 mm thick and counted in mm3), heater 0 of tool 0, heater 1 with id 254, switch 0
//! on M106 and M107 (and its number is 0), switch 1 on M3 and M5 (its number is 1), input 3 is number 1,
//! switch 4 on M7, 5 on M8, both off by M9, switch 2 on M106 alone, heater 2 that reads only.

use gcode::{Block, Blocks, Code, Decoder, Line, WholeLine};
use program::extended::{Asked, CodeLine, NamedSwitch, Names, translate};
use program::{
    Action, Claim, CycleSetup, Dialect, Facts, HeaterSetup, Interpreter, IoKind, IoSetup, LaserSetup, Meaning, Next,
    Place, PulseSetup, ServoSetup, Setup, SpindleSetup, StripSetup, ToolSettings,
};
use units::{Axis, AxisSet, Celsius, HeaterId, MmPerSecond, PerAxis, SwitchId, ToolId};

fn tool(id: u8, axis: Axis) -> ToolSettings {
    ToolSettings {
        id: ToolId(id),
        axis,
        offset: if id == 0 { [0.0; 3] } else { [20.0, 0.0, 0.0] },
        filament_diameter: (id == 1).then_some(1.75),
        retract_length: 3.0,
        retract_rate: MmPerSecond(40.0),
        recover_length: 0.5,
        recover_rate: MmPerSecond(20.0),
        z_lift: if id == 0 { 0.4 } else { 0.0 },
        z_lift_rate: MmPerSecond(10.0),
        flow_limit: None,
        is_off: false,
    }
}

fn setup() -> Setup {
    let mut setup = Setup { feed_rate: MmPerSecond(50.0), seek_rate: MmPerSecond(100.0), ..Setup::default() };
    for (id, axis) in [(0, Axis::A), (1, Axis::B)] {
        setup.tools.push(tool(id, axis)).unwrap();
    }
    let heaters: Vec<HeaterId> = HeaterId::all().collect();
    for (id, heater) in [0, 254, 7].into_iter().zip(&heaters) {
        setup.heaters.push(HeaterSetup { id: ToolId(id), presets: [Celsius(185.0), Celsius(230.0)] }).unwrap();
        let codes = if id == 254 { [140, 190, 105] } else { [104, 109, 105] };
        let claims = [Claim::Target(*heater), Claim::TargetAndWait(*heater), Claim::Temperature(*heater)];
        for (code, claim) in codes.into_iter().zip(claims).skip(if id == 7 { 2 } else { 0 }) {
            assert!(setup.claims.add(Code::m(code), claim));
        }
    }
    for (switch, on, off) in [(0, 106, Some(107)), (1, 3, Some(5)), (2, 106, None)] {
        assert!(setup.claims.add(Code::m(on), Claim::SwitchOn(SwitchId(switch))));
        if let Some(off) = off {
            assert!(setup.claims.add(Code::m(off), Claim::SwitchOff(SwitchId(switch))));
        }
    }
    for (number, switch, kind) in [(0, 0, IoKind::Analog), (1, 1, IoKind::Digital), (1, 3, IoKind::Input)] {
        setup.io.push(IoSetup { number, switch: SwitchId(switch), kind }).unwrap();
    }
    for (code, claim) in [(7, Claim::SwitchOn(SwitchId(4))), (8, Claim::SwitchOn(SwitchId(5)))] {
        assert!(setup.claims.add(Code::m(code), claim));
    }
    for switch in [4, 5] {
        assert!(setup.claims.add(Code::m(9), Claim::SwitchOff(SwitchId(switch))));
    }
    setup
}

/// Single program of a page.
struct Session {
    interpreter: Interpreter,
    facts: Facts,
    dialect: Dialect,
}

impl Session {
    fn new() -> Self {
        let facts = Facts { homed: AxisSet::PRIMARY, can_home: AxisSet::PRIMARY, probe_height: 1.5 };
        Self { interpreter: Interpreter::new(setup()), facts, dialect: Dialect::Smoothie }
    }

    fn told(&mut self, words: &str) {
        match words.split_once(' ').unwrap_or((words, "")) {
            ("dialect", name) => self.dialect = Dialect::named(name).unwrap(),
            ("extruders", "none") => {
                self.interpreter = Interpreter::new(Setup { tools: heapless::Vec::new(), ..setup() });
            }
            ("spindle", "with encoder") => {
                let spindle = SpindleSetup { has_encoder: true, has_speed_control: true };
                self.interpreter = Interpreter::new(Setup { spindle, ..setup() });
            }
            ("spindle", "turns both ways") => {
                let mut setup = setup();
                for (code, claim) in [(4, Claim::SwitchOn(SwitchId(6))), (5, Claim::SwitchOff(SwitchId(6)))] {
                    assert!(setup.claims.add(Code::m(code), claim));
                }
                self.interpreter = Interpreter::new(setup);
            }
            ("laser", "") => {
                let laser = Some(LaserSetup { is_laser_mode: true, always_by_speed: false, default_s: 0.0 });
                self.interpreter = Interpreter::new(Setup { laser, tools: heapless::Vec::new(), ..setup() });
            }
            ("servos", "") => {
                let mut setup = setup();
                for (switch, code) in [(7, Code::m(280)), (8, Code::m(280).sub(1))] {
                    assert!(setup.claims.add(code, Claim::SwitchOn(SwitchId(switch))));
                    let servo = (switch == 7).then_some(ServoSetup { max_angle: 180.0, pulse_us: [1_000.0, 2_000.0] });
                    let pulses = PulseSetup { switch: SwitchId(switch), percent_per_us: 0.005, servo };
                    setup.pulses.push(pulses).unwrap();
                }
                self.interpreter = Interpreter::new(setup);
            }
            ("strips", "") => {
                let mut setup = setup();
                for (number, lights) in [(0, 5), (3, 2)] {
                    setup.strips.push(StripSetup { number, lights }).unwrap();
                }
                self.interpreter = Interpreter::new(setup);
            }
            ("rule", "") => {
                let mut setup = setup();
                assert!(setup.claims.add(Code::m(801), Claim::Arm(0)));
                self.interpreter = Interpreter::new(setup);
            }
            ("offsets", "kept") => self.interpreter = Interpreter::new(Setup { keeps_offsets: true, ..setup() }),
            ("tool", line) => {
                let tool = program::ToolEntry::read(line).unwrap().unwrap();
                self.interpreter.tool_table().add(tool).unwrap();
            }
            ("cycles", "off") => self.cycles_are(CycleSetup { is_off: true, ..CycleSetup::default() }),
            ("cycles", "dwell in ms") => self.cycles_are(CycleSetup { dwell_in_ms: true, ..CycleSetup::default() }),
            ("homed", axes) => {
                self.facts.homed = AxisSet::collect(axes.chars().filter_map(Axis::from_letter));
            }
            ("homes", axes) => {
                self.facts.can_home = AxisSet::collect(axes.chars().filter_map(Axis::from_letter));
            }
            ("machine", "refuses") => self.interpreter.take_back(),
            ("machine", place) => {
                let mut position = PerAxis([0.0; units::MAX_AXES]);
                for word in place.split_whitespace().filter(|word| *word != "at") {
                    let (letter, number) = word.split_at(1);
                    let axis = Axis::from_letter(letter.chars().next().unwrap()).unwrap();
                    position[axis] = number.parse().unwrap();
                }
                self.interpreter.resynchronise(position);
            }
            ("contact", words) => {
                let (z, reads) = words.split_once(" reads ").unwrap();
                self.interpreter.read_contact(z.parse().unwrap(), reads.parse().unwrap());
            }
            _ => panic!("nobody understands: @ {words}"),
        }
    }

    /// Starts a new program on a machine with these settings of cycles.
    fn cycles_are(&mut self, cycles: CycleSetup) {
        self.interpreter = Interpreter::new(Setup { cycles, ..setup() });
    }

    /// Runs the lines of a program, in sequence or as its O words say. Returns the actions asked for by each
    /// line.
    fn run_program(&mut self, lines: &[&str]) -> Vec<Vec<String>> {
        let mut asked = vec![Vec::new(); lines.len()];
        let mut at = 0;
        while let Some(line) = lines.get(at) {
            let (here, after) = (place(at), place(at + 1));
            at += 1;
            self.interpreter.at_line(at as u32);
            if let Some(words) = line.strip_prefix("@ ") {
                self.told(words);
                continue;
            }
            let next = self.run(line, here, after, &mut asked[at - 1]);
            assert!(asked.iter().map(Vec::len).sum::<usize>() < 1_000, "it does not end");
            match next {
                Next::Following => {}
                Next::At(place) => at = place.line as usize,
                Next::FirstOf(name) => {
                    asked[at - 1].push(format!("file of {name}?"));
                    self.interpreter.search_sub();
                }
                Next::Returned => unreachable!("there are no other files"),
            }
        }
        if let Err(fault) = self.interpreter.end_file()
            && let Some(last) = asked.last_mut()
        {
            last.push(format!("at the end: {fault}"));
        }
        asked
    }

    /// Runs a line of the program. Adds the actions asked for, and returns the next line.
    fn run(&mut self, line: &str, here: Place, after: Place, asked: &mut Vec<String>) -> Next {
        let mut codes = CodeLine::new();
        match Decoder::new().decode(line.as_bytes()) {
            Ok(Line::Flow(line)) => match self.interpreter.flow_line(&line, here, after) {
                Ok(next) => {
                    self.say_what_returns(asked);
                    return next;
                }
                Err(fault) => asked.push(format!("alarm: {fault}")),
            },
            _ if self.interpreter.flow().passes_over() => {}
            Ok(Line::Code(blocks)) => self.run_blocks(blocks, asked),
            Ok(Line::Blank) => {}
            Ok(Line::Console(_)) => asked.push("a console command".into()),
            Ok(Line::Extended(command)) => match translate(&command, self, &mut codes) {
                Ok(Asked::Codes) => {
                    asked.push(format!("is {}", codes.trim()));
                    self.run_blocks(Blocks::new(codes.as_bytes()), asked);
                }
                Ok(Asked::Tower) => asked.push("a setting changes with the height".into()),
                Ok(Asked::Console(command)) => asked.push(format!("is the console's {command}")),
                Ok(Asked::Macros) => asked.push("kept for macros".into()),
                Ok(Asked::PassedOver(name)) => asked.push(format!("passed over, as {name}")),
                Err(fault) => asked.push(format!("error: {} {fault}", command.name())),
            },
            Err(refusal) => asked.push(format!("error: {refusal}")),
        }
        Next::Following
    }

    fn run_blocks(&mut self, mut blocks: Blocks<'_>, asked: &mut Vec<String>) {
        let mut whole = WholeLine::default();
        if self.dialect.orders_lines() && blocks.clone().read_whole(&mut whole, &mut self.interpreter).is_ok() {
            match program::arrange(&whole) {
                Some(Ok(parts)) => {
                    for part in &parts {
                        let block = whole.part(part.code, part.letters).clone();
                        if !self.run_block(&block, asked) {
                            return self.interpreter.drop_line();
                        }
                    }
                    return self.end_line(asked);
                }
                Some(Err(fault)) => return asked.push(format!("error: {fault}")),
                None => {}
            }
        }
        self.interpreter.drop_line();
        let mut block = Block::new(None, 0);
        loop {
            match blocks.read(&mut block, &mut self.interpreter) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => {
                    self.interpreter.drop_line();
                    return asked.push(format!("error: {error}"));
                }
            }
            if !self.run_block(&block, asked) {
                return;
            }
        }
        self.end_line(asked);
    }

    /// Adds the changes by which M73's modes are restored at the end of a subroutine.
    fn say_what_returns(&mut self, asked: &mut Vec<String>) {
        let from = *self.interpreter.position();
        while let Some(effect) = self.interpreter.next_effect() {
            asked.push(Action::Effect(effect).described(&from).to_string());
        }
        while let Some(action) = self.interpreter.next_action() {
            asked.push(action.described(&from).to_string());
        }
    }

    fn end_line(&mut self, asked: &mut Vec<String>) {
        if let Err(fault) = self.interpreter.end_line() {
            asked.push(format!("error: {fault}"));
        }
    }

    /// Returns false when the block was refused.
    fn run_block(&mut self, block: &Block<'_>, asked: &mut Vec<String>) -> bool {
        let Some(row) = self.interpreter.row(block, self.dialect) else {
            asked.push("unknown".into());
            return true;
        };
        let mut from = *self.interpreter.position();
        let meaning = match self.interpreter.run(block, row, self.facts, self.dialect) {
            Ok(meaning) => meaning,
            Err(fault) => {
                let kind = if fault.halts { "alarm" } else { "error" };
                asked.push(format!("{kind}: {fault}"));
                return false;
            }
        };
        let mut say = |asked: &mut Vec<String>, action: Action<'_>| {
            asked.push(action.described(&from).to_string());
            if let Action::Move(request) = action {
                from = request.target;
            }
        };
        while let Some(effect) = self.interpreter.next_effect() {
            say(asked, Action::Effect(effect));
        }
        match meaning {
            Meaning::Nothing => {}
            Meaning::Action(action) => say(asked, action),
            Meaning::PassedOver => asked.push("passed over".into()),
            Meaning::Unknown => asked.push("unknown".into()),
        }
        while let Some(action) = self.interpreter.next_action() {
            say(asked, action);
        }
        true
    }
}

/// `fan` is switch 0, `extruder` heater 0, `heater_bed` heater 1.
impl Names for Session {
    fn switch(&self, name: &str) -> Option<NamedSwitch> {
        (name == "fan").then_some(NamedSwitch { on: Code::m(106), number: None, off: Some(Code::m(107)), full: 255.0 })
    }

    fn heater(&self, name: &str) -> Option<(Code, u8)> {
        self.heater_at(["extruder", "heater_bed"].iter().position(|known| *known == name)?)
    }

    fn strip(&self, name: &str) -> Option<u8> {
        ["case", "nozzle"].iter().position(|known| *known == name).map(|place| place as u8)
    }

    fn has_strips(&self) -> bool {
        true
    }

    fn heater_at(&self, place: usize) -> Option<(Code, u8)> {
        [(Code::m(104), 0), (Code::m(140), 254)].get(place).copied()
    }

    fn motor(&self, name: &str) -> Option<char> {
        ["stepper_x", "extruder"].iter().position(|known| *known == name).map(|place| ['X', 'A'][place])
    }
}

/// Runs a page and returns the page with the actual actions.
fn run_page(text: &str) -> String {
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("    ")).collect();
    let mut page = String::new();
    let mut begin = 0;
    while begin < lines.len() {
        // A program comprises the lines below its title.
        let length = lines[begin + 1..].iter().take_while(|line| !line.starts_with("# ")).count() + 1;
        let program = &lines[begin..begin + length];
        let first = usize::from(program[0].starts_with("# "));
        let mut asked = vec![Vec::new(); first];
        asked.extend(Session::new().run_program(&program[first..]));
        for (line, asked) in program.iter().zip(asked) {
            page.push_str(line);
            page.push('\n');
            for action in asked {
                page.push_str(&format!("    {action}\n"));
            }
        }
        begin += length;
    }
    page
}

fn place(line: usize) -> Place {
    Place { offset: 0, line: line as u32 }
}

/// Runs a page, and holds each line against what it says there.
fn check_page(name: &str) {
    let path = format!("{FOLDER}/{name}.txt");
    let text = std::fs::read_to_string(&path).unwrap();
    let is = run_page(&text);
    // `WRITE_LANGUAGE=1` writes the actual actions into the pages, to be reviewed before a commit.
    if std::env::var_os("WRITE_LANGUAGE").is_some() {
        std::fs::write(&path, &is).unwrap();
        return;
    }
    let mut title = "";
    for (number, (wanted, got)) in text.lines().zip(is.lines()).enumerate() {
        title = wanted.strip_prefix("# ").unwrap_or(title);
        assert_eq!(got, wanted, "{path}, line {}, of: {title}", number + 1);
    }
    assert_eq!(text.lines().count(), is.lines().count(), "{path}");
}

/// Folder of the pages.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/language");

/// Makes a test of each page, and the list of them.
macro_rules! pages {
    ($($page:ident)+) => {
        const PAGES: &[&str] = &[$(stringify!($page)),+];

        $(
            #[test]
            fn $page() {
                check_page(stringify!($page));
            }
        )+
    };
}

pages! {
    curves
    cycles
    extruder
    feed_modes
    flow
    homing
    laser
    mills
    moves
    offsets
    order
    outputs
    parameters
    printers
    program
    settings
    smoothie
    tools
}

/// A page that is not listed would not be looked at.
#[test]
fn every_page_is_a_test() {
    let files = std::fs::read_dir(FOLDER).unwrap().map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = files.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    names.sort();
    assert_eq!(names, PAGES);
}

/// Every code of the table stands on some page.
#[test]
fn no_code_is_without_a_line() {
    let mut seen = std::collections::BTreeSet::new();
    for entry in std::fs::read_dir(FOLDER).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        for line in text.lines().filter(|line| !line.starts_with(['#', '@', ' '])) {
            if let Ok(Line::Code(blocks)) = Decoder::new().decode(line.as_bytes()) {
                seen.extend(blocks.flatten().filter_map(|block| block.code).map(|code| code.to_string()));
            }
        }
    }
    let missing: Vec<String> =
        program::codes::all().map(|row| row.code.to_string()).filter(|code| !seen.contains(code)).collect();
    assert!(missing.is_empty(), "no line for {missing:?}");
}
