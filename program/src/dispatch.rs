//! Dispatch of a block: finds its row of the table and its words, and calls the row's handler.

use gcode::{Block, Code, Letter, NO_TOOL};
use heapless::Vec;
use units::SwitchId;

use crate::action::Effect;
use crate::codes::{self, CodeInfo, Handler};
use crate::context::{Context, Facts, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::function::Function;
use crate::interpreter::Interpreter;
use crate::meaning::{extruders, heat};
use crate::state::auxiliary::Spindle;
use crate::state::claims::{Claim, MOST_CLAIMS};
use crate::state::setup::PulseSetup;
use crate::words::Words;
use crate::words_not_taken;
use gcode::Dialect;

impl Interpreter {
    /// Returns the row that says how a block is read and where the block may run; `None` when the code is
    /// unknown in this dialect.
    #[must_use]
    pub fn row(&self, block: &Block<'_>, dialect: Dialect) -> Option<&'static CodeInfo> {
        let code = block.code.unwrap_or_else(|| self.modal.motion_code());
        if code.letter == Letter::T {
            return Some(codes::TOOL);
        }
        let otherwise = codes::find_in(code, dialect);
        if otherwise.is_some() {
            return otherwise;
        }
        let known = codes::find(code);
        if known.is_none() && self.setup.claims.may_have(code) {
            return self.setup.claims.of(code).next().map(codes::claimed);
        }
        known
    }

    /// Returns row, function and words of a question, which changes nothing and may be answered while another
    /// line runs. `None` when the block is no question, or has a wrong word.
    #[must_use]
    pub fn question<'b>(
        &self,
        block: &'b Block<'b>,
        dialect: Dialect,
    ) -> Option<(&'static CodeInfo, Function, Words<'b>)> {
        let row = self.row(block, dialect).filter(|row| row.waits == codes::Waits::Question)?;
        let (Handler::Function(function) | Handler::Both(_, function)) = row.handler else { return None };
        let words = row.words_of(block, self.modal.lengths());
        words.check().is_ok().then_some((row, function, words))
    }

    /// Returns the meaning of a block, read as its row says.
    ///
    /// # Errors
    /// When the block is wrong; nothing has changed then, unless the fault halts.
    pub fn run<'b>(
        &mut self,
        block: &'b Block<'b>,
        row: &'static CodeInfo,
        facts: Facts,
        dialect: Dialect,
    ) -> Result<Meaning<'b>, Fault> {
        self.begin_block();
        let words = row.words_of(block, self.modal.lengths());
        if row.is_bounded {
            words.check()?;
        }
        if words.has_strange(row.letters) {
            words_not_taken::look(self, &words, row, dialect)?;
        }
        let claimed = block.code.filter(|code| self.setup.claims.may_have(*code));
        // Nearly every line of a program takes this path.
        if let (Handler::Interpret(interpret), None) = (row.handler, claimed) {
            return interpret(self, &Context { words, facts, dialect, function: None });
        }
        let function = match row.handler {
            Handler::Function(function) | Handler::Both(_, function) => Some(function),
            _ => None,
        };
        let context = Context { words, facts, dialect, function };
        if let Some(meaning) = claimed.map(|code| self.claimed(fan_of(code, &context), &context)).transpose()?.flatten()
        {
            return Ok(meaning);
        }
        // A configuration that assigns one of these codes to a switch is older than the codes' meaning, so
        // the switch has priority.
        let is_switch_s =
            |code: Code| matches!(code.number, 42 | 62..=68 | 226) && self.setup.claims.of(code).next().is_some();
        if claimed.is_some_and(|code| code.letter == Letter::M && is_switch_s(code)) {
            return NOTHING;
        }
        match row.handler {
            Handler::Interpret(interpret) | Handler::Both(interpret, _) => interpret(self, &context),
            Handler::Function(_) => Ok(context.function()),
            // Other firmwares put the tool down; here the tool stays.
            Handler::Tool if context.words.code().number == NO_TOOL && dialect.is_other_printers() => {
                Ok(Meaning::PassedOver)
            }
            Handler::Tool => extruders::select_tool(self, context.words.code().number, words.column()),
            Handler::Nothing => NOTHING,
            // A switch of the configuration that listens to the code has already acted.
            Handler::PassedOver | Handler::Missing
                if claimed.is_some_and(|code| self.setup.claims.of(code).next().is_some()) =>
            {
                NOTHING
            }
            Handler::PassedOver => Ok(Meaning::PassedOver),
            Handler::Missing => Ok(Meaning::Unknown),
            Handler::Claimed => {
                let claims = claimed.and_then(|code| self.setup.claims.of(fan_of(code, &context)).next());
                Ok(if claims.is_some() { Meaning::Nothing } else { Meaning::Unknown })
            }
        }
    }

    /// Returns the value for a switch: S, or P where P is the pulse width in microseconds. An output on a
    /// timer takes percent.
    fn value_for(&self, switch: SwitchId, context: &Context<'_>) -> Option<f32> {
        // S is the laser's power: what else M3 turns on, such as air, is on.
        if self.setup.laser.is_some() && Spindle::of(context.words.code()).is_some() {
            return None;
        }
        let word = |letter| context.words.get(letter).map(|value| value as f32);
        let is_fan = is_fan(context);
        let pulses = self.setup.pulses.iter().find(|pulses| pulses.switch == switch);
        let value = match (pulses, word('S')) {
            (Some(pulses), None) if !context.dialect.numbers_fans() => word('P').map(|us| pulses.percent_of_width(us)),
            (Some(PulseSetup { servo: None, .. }), Some(s)) if is_fan => Some(of_255(s, context) / 2.55),
            (Some(pulses), Some(s)) => Some(pulses.percent_of_s(s)),
            (None, Some(s)) if is_fan => Some(of_255(s, context)),
            (_, s) => s,
        };
        // Outputs that turn the spindle take the S in force.
        let speed = self.modal.auxiliary.speed.filter(|_| Spindle::of(context.words.code()).is_some());
        value.or_else(|| speed.map(|speed| self.setup.value_of_s(switch, speed)))
    }

    /// Runs the switches and heaters that listen to a code. A code of a heater does nothing else.
    fn claimed<'b>(&mut self, code: Code, context: &Context<'b>) -> Result<Option<Meaning<'b>>, Fault> {
        let claims: Vec<Claim, MOST_CLAIMS> = self.setup.claims.of(code).take(MOST_CLAIMS).collect();
        let words = &context.words;
        if is_fan(context)
            && !words.has('S')
            && let Some(letter) = words.other_than("P")
        {
            // Without S, the other words set a fan up or restore an earlier speed, so full speed would be
            // wrong.
            return Err(Problem::NotTaken(words.code(), letter).refused(words.column_of(letter)));
        }
        // A sender of laser jobs may write M4 in front of each line: what is on stays on.
        let now = self.modal.auxiliary.spindle;
        if self.setup.laser.is_some() && now != Spindle::Stopped && Spindle::of(code) == Some(now) {
            return Ok(None);
        }
        let reverses = Spindle::of(code).is_some_and(|spindle| spindle.is_against(self.modal.auxiliary.spindle));
        if reverses && self.setup.laser.is_none() {
            self.switch(Spindle::Stopped.code());
        }
        if is_fan(context) && !words.has('S') && context.dialect.takes_shares() {
            // RepRapFirmware reads M106 without S as a question about the fan.
            return NOTHING.map(Some);
        }
        for claim in &claims {
            let effect = match *claim {
                Claim::SwitchOn(switch) => Effect::Switch { switch, on: true, value: self.value_for(switch, context) },
                Claim::SwitchOff(switch) => Effect::Switch { switch, on: false, value: None },
                Claim::Arm(rule) => {
                    Effect::Arm { rule, armed: context.words.get('S').is_some_and(|value| value != 0.0) }
                }
                _ => continue,
            };
            self.by_the_way(effect);
        }
        let heats =
            claims.iter().find(|claim| !matches!(claim, Claim::SwitchOn(_) | Claim::SwitchOff(_) | Claim::Arm(_)));
        heats.map(|claim| heat::heat(self, *claim, &claims, context)).transpose()
    }
}

/// Returns the speed of a fan, 255 for full: RepRapFirmware's S of 1 and less is a share of full speed.
fn of_255(s: f32, context: &Context<'_>) -> f32 {
    if s <= 1.0 && context.dialect.takes_shares() { s * 255.0 } else { s }
}

/// Whether the code is M106 in a dialect that numbers fans.
fn is_fan(context: &Context<'_>) -> bool {
    let code = context.words.code();
    code.letter == Letter::M && code.number == 106 && context.dialect.numbers_fans()
}

/// Returns the code with P as its subcode: `M106 P1` is a different fan than the part's, so `M106.1` listens.
/// `M280 P1` is a different servo.
fn fan_of(code: Code, context: &Context<'_>) -> Code {
    let is_fan = code.letter == Letter::M && matches!(code.number, 106 | 107 | 280) && code.subcode == 0;
    match context.words.get('P') {
        Some(fan) if is_fan && context.dialect.numbers_fans() => code.sub(units::within(fan, 0.0, 255.0) as u8),
        _ => code,
    }
}
