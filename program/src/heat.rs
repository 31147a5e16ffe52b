//! Codes that heaters listen to: which heater is meant, and which temperature.

use units::{Celsius, HeaterId, ToolId};

use crate::action::{Action, Effect, Function};
use crate::claims::Claim;
use crate::fault::{Fault, Problem};
use crate::interpreter::{Context, Interpreter, Meaning, NOTHING};

/// Temperature controls numbered from here are always addressed, whatever tool is selected.
const ALWAYS_ACTIVE: ToolId = ToolId(250);

impl Interpreter {
    /// A code that heaters claim.
    pub(crate) fn heat<'b>(
        &mut self,
        claim: Claim,
        claims: &[Claim],
        context: &Context<'b>,
    ) -> Result<Meaning<'b>, Fault> {
        let words = &context.words;
        if matches!(claim, Claim::Temperature(_)) {
            return Ok(Meaning::Action(Action::Function(Function::ReportTemperatures, *words)));
        }
        let Some(celsius) = words.get('S') else { return NOTHING };
        let (heater, waits) = self.addressed(claims, context)?;
        let target = self.meant(heater, celsius);
        if waits {
            return Ok(Meaning::Action(Action::HeatAndWait { heater, target }));
        }
        self.by_the_way(Effect::Target { heater, target });
        NOTHING
    }

    /// The heater that a code addresses, and whether it waits: by T, else that of the active tool, else one
    /// that is always active.
    fn addressed(&self, claims: &[Claim], context: &Context<'_>) -> Result<(HeaterId, bool), Fault> {
        let active = self.tools.active_id();
        let word = context.words.get('T');
        let wanted = word.and_then(ToolId::from_word);
        let is_meant = |id: ToolId| match word {
            Some(_) => wanted == Some(id),
            None => id == active || id >= ALWAYS_ACTIVE,
        };
        let listening = claims.iter().filter_map(|claim| match *claim {
            Claim::Target(heater) => Some((heater, false)),
            Claim::TargetAndWait(heater) => Some((heater, true)),
            _ => None,
        });
        let mut meant =
            listening.filter(|(heater, _)| self.heaters.get(heater.index()).is_some_and(|h| is_meant(h.id)));
        let number = context.words.code().number;
        meant.next().ok_or_else(|| match word {
            Some(word) => Problem::NoHeaterOf(number, word).refused(context.words.column_of('T')),
            None => Problem::ToolWithoutHeater(number, active).refused(0),
        })
    }

    /// What a target means: 1 and 2 stand for the presets.
    fn meant(&self, heater: HeaterId, celsius: f64) -> Celsius {
        match (celsius, self.heaters.get(heater.index()).map(|heater| heater.presets)) {
            (1.0, Some([first, _])) => first,
            (2.0, Some([_, second])) => second,
            _ => Celsius(celsius as f32),
        }
    }
}
