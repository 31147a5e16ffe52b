//! Lines to actions, in every dialect: every line has a bounded meaning, a faulty one changes nothing, and
//! the program always knows where it is.

use gcode::{Block, Blocks, Decoder, FlowLine, Line};
use program::extended::{self, Asked, CodeLine};
use program::{
    Action, Claim, Dialect, Facts, HeaterSetup, Interpreter, Meaning, Next, Place, Rate, Setup, ToolSettings,
};
use units::{Axis, AxisSet, Celsius, HeaterId, MmPerSecond, PerAxis, SwitchId, ToolId};

/// Directions that an input may hold beside its lines.
pub const DIRECTIONS: &[&str] =
    &["@grbl", "@smoothie", "@refuse", "@homed", "@unhomed", "@elsewhere", "@contact", "@halt", "@again"];
/// Number of actions that no block exceeds.
const MOST_ACTIONS: usize = 8;
/// Number of a canned cycle's moves that are checked: a cycle may mean millions.
const MOST_MOVES_OF_CYCLE: usize = 1_000;
/// Number of effects that no block exceeds.
const MOST_EFFECTS: usize = 40;

/// Returns a machine of two extruders, a hot end, a bed, and switches on several codes.
fn setup() -> Setup {
    let mut setup = Setup { feed_rate: MmPerSecond(50.0), seek_rate: MmPerSecond(100.0), ..Setup::default() };
    for (id, axis) in [(0, Axis::A), (1, Axis::B)] {
        let tool = ToolSettings {
            id: ToolId(id),
            axis,
            offset: if id == 0 { [0.0; 3] } else { [20.0, 0.5, -0.25] },
            filament_diameter: (id == 1).then_some(1.75),
            retract_length: 3.0,
            retract_rate: MmPerSecond(40.0),
            recover_length: 0.5,
            recover_rate: MmPerSecond(20.0),
            z_lift: if id == 0 { 0.4 } else { 0.0 },
            z_lift_rate: MmPerSecond(10.0),
            flow_limit: None,
            is_off: false,
        };
        assert!(setup.tools.push(tool).is_ok(), "room for two tools");
    }
    let heaters = [(0, [104, 109, 105]), (254, [140, 190, 105])];
    for (heater, (id, codes)) in HeaterId::all().zip(heaters) {
        let heater_setup = HeaterSetup { id: ToolId(id), presets: [Celsius(185.0), Celsius(230.0)] };
        assert!(setup.heaters.push(heater_setup).is_ok(), "room for two heaters");
        let claims = [Claim::Target(heater), Claim::TargetAndWait(heater), Claim::Temperature(heater)];
        for (code, claim) in codes.into_iter().zip(claims) {
            assert!(setup.claims.add(gcode::Code::m(code), claim), "a code that can be claimed");
        }
    }
    for (switch, on, off) in [(0, 106, 107), (1, 3, 5), (2, 8, 9)] {
        assert!(setup.claims.add(gcode::Code::m(on), Claim::SwitchOn(SwitchId(switch))), "a code that can be claimed");
        assert!(
            setup.claims.add(gcode::Code::m(off), Claim::SwitchOff(SwitchId(switch))),
            "a code that can be claimed"
        );
    }
    setup
}

/// Machine whose heaters and switches have no names.
struct NoNames;

impl extended::Names for NoNames {
    fn switch(&self, _: &str) -> Option<extended::NamedSwitch> {
        Some(extended::NamedSwitch {
            on: gcode::Code::m(106),
            number: None,
            off: Some(gcode::Code::m(107)),
            full: 255.0,
        })
    }

    fn heater(&self, _: &str) -> Option<(gcode::Code, u8)> {
        self.heater_at(0)
    }

    fn strip(&self, _: &str) -> Option<u8> {
        Some(0)
    }

    fn has_strips(&self) -> bool {
        true
    }

    fn heater_at(&self, place: usize) -> Option<(gcode::Code, u8)> {
        (place == 0).then_some((gcode::Code::m(104), 0))
    }

    fn motor(&self, _: &str) -> Option<char> {
        Some('X')
    }
}

/// Greatest number of lines carried out: loops may have no end.
const MOST_TURNS: u32 = 3_000;

struct Session {
    interpreter: Interpreter,
    facts: Facts,
    dialect: Dialect,
    decoder: Decoder,
    kept: Option<program::Kept>,
    /// The machine refuses the moves of the next block.
    refuses: bool,
}

/// Runs a program line by line, in every dialect.
///
/// # Panics
/// When a condition of this module does not hold.
pub fn run(bytes: &[u8]) {
    for dialect in Dialect::ALL {
        let facts = Facts { homed: AxisSet::PRIMARY, can_home: AxisSet::PRIMARY, probe_height: 1.5 };
        let mut session = Session {
            interpreter: Interpreter::new(setup()),
            facts,
            dialect,
            decoder: Decoder::new(),
            kept: None,
            refuses: false,
        };
        let lines: Vec<&[u8]> = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).collect();
        let (mut at, mut turns) = (0, 0);
        while let Some(line) = lines.get(at).filter(|_| turns < MOST_TURNS) {
            turns += 1;
            at = session.line(line.get(..gcode::MAX_LINE_LENGTH).unwrap_or(line), at);
        }
        // At the end of the file an open construct is reported, and none stays open.
        let _ = session.interpreter.end_file();
        assert!(session.interpreter.flow().is_at_rest(), "something is open behind the end");
    }
}

impl Session {
    /// Runs a line; returns the place of the next line.
    fn line(&mut self, line: &[u8], at: usize) -> usize {
        let after = at + 1;
        match line {
            b"@grbl" => self.dialect = Dialect::Grbl,
            b"@smoothie" => self.dialect = Dialect::Smoothie,
            b"@refuse" => self.refuses = true,
            b"@homed" => self.facts.homed = self.facts.can_home,
            b"@unhomed" => self.facts.homed = AxisSet::NONE,
            b"@elsewhere" => self.interpreter.resynchronise(PerAxis([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
            b"@contact" => self.interpreter.read_contact(1.5, 0.0),
            b"@halt" => self.interpreter.halt(),
            b"@again" => match self.kept.take() {
                Some(kept) => self.interpreter.come_back_to(kept),
                None => self.kept = Some(self.interpreter.keep()),
            },
            line => {
                let mut codes = CodeLine::new();
                let passes_over = self.interpreter.flow().passes_over();
                match self.decoder.decode(line) {
                    Ok(Line::Flow(flow)) => return self.flow(&flow, at),
                    Ok(Line::Code(blocks)) if !passes_over => self.blocks(blocks),
                    Ok(Line::Extended(command))
                        if !passes_over && extended::translate(&command, &NoNames, &mut codes) == Ok(Asked::Codes) =>
                    {
                        self.blocks(Blocks::new(codes.as_bytes()));
                    }
                    _ => {}
                }
            }
        }
        after
    }

    fn flow(&mut self, line: &FlowLine<'_>, at: usize) -> usize {
        let place = |at: usize| Place { offset: 0, line: at as u32 };
        match self.interpreter.flow_line(line, place(at), place(at + 1)) {
            Ok(Next::At(place)) => return place.line as usize,
            Ok(Next::FirstOf(name)) => {
                assert!(!name.is_empty(), "a subroutine without a name");
                self.interpreter.search_sub();
            }
            Ok(Next::Following) => {}
            Ok(Next::Returned) => panic!("back from a file that was never entered"),
            Err(fault) => assert!(!fault.to_string().is_empty(), "a fault without words"),
        }
        at + 1
    }

    fn blocks(&mut self, mut blocks: Blocks<'_>) {
        loop {
            let mut block = Block::new(None, 0);
            match blocks.read(&mut block, &mut self.interpreter) {
                Ok(true) => {}
                Ok(false) => break,
                Err(_) => return self.interpreter.drop_line(),
            }
            if let Some((row, _, _)) = self.interpreter.question(&block, self.dialect) {
                assert_eq!(row.waits, program::Waits::Question, "{block}: no question");
            }
            if let Some(row) = self.interpreter.row(&block, self.dialect)
                && !self.block(&block, row)
            {
                return self.interpreter.drop_line();
            }
        }
        // Ending the line may fail for want of room.
        let _ = self.interpreter.end_line();
    }

    /// Runs a block. False when the rest of the line is not read.
    fn block(&mut self, block: &Block<'_>, row: &'static program::CodeInfo) -> bool {
        let before = *self.interpreter.position();
        let meaning = match self.interpreter.run(block, row, self.facts, self.dialect) {
            Ok(meaning) => meaning,
            Err(fault) => {
                assert!(!fault.to_string().is_empty(), "{block}: a fault without words");
                assert!(fault.column <= gcode::MAX_LINE_LENGTH as u16 + 1, "{block}: column {}", fault.column);
                assert_eq!(*self.interpreter.position(), before, "{block}: refused, and yet it moved: {fault}");
                return false;
            }
        };
        let effects = std::iter::from_fn(|| self.interpreter.next_effect()).take(MOST_EFFECTS).count();
        assert!(effects < MOST_EFFECTS, "{block}: effects without end");
        let Meaning::Action(first) = meaning else { return true };
        let mut is_refused = self.carry_out(&first, block);
        let mut count = 1;
        while !is_refused && let Some(action) = self.interpreter.next_action() {
            is_refused = self.carry_out(&action, block);
            count += 1;
            if (73..=99).contains(&row.code.number) && count > MOST_MOVES_OF_CYCLE {
                break;
            }
            assert!(count <= MOST_ACTIONS || (73..=99).contains(&row.code.number), "{block}: actions without end");
        }
        if is_refused {
            self.interpreter.take_back();
            assert_eq!(*self.interpreter.position(), before, "{block}: taken back, and yet it is elsewhere");
        }
        self.refuses = false;
        let here = self.interpreter.position().0;
        assert!(here.iter().all(|mm| mm.is_finite()), "{block}: the program is at {here:?}");
        !is_refused
    }

    /// Carries out an action. True when the machine refuses it, as it does with impossible places.
    fn carry_out(&mut self, action: &Action<'_>, block: &Block<'_>) -> bool {
        match action {
            Action::Move(wanted) => {
                let rate = match wanted.rate {
                    Rate::Rapid(speed) | Rate::Feed(speed) => speed.get(),
                    Rate::Duration(seconds) => seconds,
                    Rate::PerRevolution(length) => length,
                };
                assert!(!rate.is_nan() && rate >= 0.0, "{block}: a rate of {rate}");
                self.refuses || !wanted.target.0.iter().all(|mm| mm.is_finite())
            }
            Action::SetPosition { to, .. } => {
                let mut here = *self.interpreter.position();
                for axis in Axis::ALL {
                    if let Some(mm) = to[axis].filter(|mm| mm.is_finite()) {
                        here[axis] = mm;
                    }
                }
                self.interpreter.resynchronise(here);
                false
            }
            Action::Dwell(_)
            | Action::Effect(_)
            | Action::Home(_)
            | Action::ForgetHoming(_)
            | Action::ProbeDown(_)
            | Action::ProbeAlong(_)
            | Action::Finish
            | Action::EndProgram
            | Action::Halt
            | Action::Release
            | Action::Resume
            | Action::Message(_)
            | Action::Return
            | Action::ChangeTool(_)
            | Action::RetractByHand
            | Action::AwaitInput(_)
            | Action::SurfaceSpeed(_)
            | Action::ReadTools
            | Action::Keep
            | Action::Note(_)
            | Action::Acceleration(_)
            | Action::Function(..)
            | Action::HeatAndWait { .. }
            | Action::Suspend { .. }
            | Action::Pause { .. }
            | Action::Call { .. }
            | Action::Overrides { .. }
            | Action::RigidTap { .. }
            | Action::Orient { .. } => false,
        }
    }
}
