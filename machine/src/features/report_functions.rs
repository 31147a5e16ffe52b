//! Functions that say something.

use base::axes::Axes;
use base::failure::{Answer, Outcome};
use base::sessions::{Listing, Recipient, Reply};
use base::tuning::Tuning;
use base::{CodeContext, Ports, World};
use parts::fans::Fans;
use parts::filament::{Filament, Width};
use parts::heat_codes;
use parts::reports;
use procedures::arms;
use program::{Interpreter, Report, Words};

use crate::features::state::States;
use crate::features::{automatic_outputs, filament};
use crate::machine::work_hands::WorldHands;
use crate::machine::{Machine, long_answers};

/// Parts of the machine that functions say something about.
pub(crate) struct Reported<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    program: &'m Interpreter,
    axes: &'m Axes,
    tuning: &'m mut Tuning,
    filament: &'m mut Filament,
    filament_width: &'m mut Width,
    fans: &'m Fans,
    /// Saved settings were loaded since boot.
    settings_loaded: bool,
}

/// The machine for functions that say something.
pub(crate) trait ReportedHands<'c>: WorldHands<'c> {
    /// Returns the parts of the machine that functions say something about.
    fn reported(&mut self) -> Reported<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> ReportedHands<'c> for Machine<'c, P> {
    fn reported(&mut self) -> Reported<'_, 'c, P> {
        let Self { world, program, axes, tuning, settings_loaded, .. } = self;
        let States { filament, filament_width, fans, .. } = &mut self.features;
        let settings_loaded = *settings_loaded;
        Reported { world, program, axes, tuning, filament, filament_width, fans, settings_loaded }
    }
}

/// Carries out a function that says something.
pub(crate) fn report<'c>(
    hands: &mut impl ReportedHands<'c>,
    asked: Report,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    let Reported { world, program, axes, tuning, filament, filament_width, fans, settings_loaded } = hands.reported();
    let dialect = world.sessions.dialect_of(to);
    let World { ports, sessions, config, texts } = &mut *world;
    let code = CodeContext { texts, ports, config, words, reply: &mut Reply::new(sessions, to) };
    match asked {
        Report::ReportFans => {
            automatic_outputs::report_fans(world, fans, to);
            Ok(Answer::Ok)
        }
        Report::ReportTemperatures => {
            // The line begins with its `ok`.
            heat_codes::report_temperatures(code.ports, config, words.code().number, ("ok ", code.reply));
            Ok(Answer::Said)
        }
        Report::ReportPosition => reports::position(code, program, dialect),
        Report::ReportFirmware => {
            reports::firmware(code.ports, config, dialect, code.reply);
            Ok(Answer::Ok)
        }
        Report::ReportSwitches => {
            reports::end_switches(code.ports, config, tuning, code.reply);
            Ok(Answer::Ok)
        }
        Report::ReportHoming => {
            arms::report_homing(config, axes, code.reply);
            Ok(Answer::Ok)
        }
        Report::FilamentDiameter => reports::filament_diameter(code, program.tools()),
        Report::FlowFactor => reports::flow_factor(code, program.tools()),
        Report::SayToAll => {
            let (prefix, text) = program::said_by_m118(words.text().unwrap_or(""));
            sessions.say(Recipient::All, format_args!("{prefix}{text}\n"));
            Ok(Answer::Ok)
        }
        Report::FilamentDetector => parts::filament::told(code, (filament, filament_width), tuning),
        Report::FilamentWidth => parts::filament::told_of_width(code, filament_width, tuning),
        Report::FilamentLengths => Ok(filament::lengths(tuning, words, code.reply)),
        Report::RetractSettings | Report::RecoverSettings => Ok(Answer::Ok),
        Report::DriverStatus => long_answers::describe_drivers(world, words, to),
        Report::ShowMap => long_answers::begin(world, Listing::Map { line: 0 }, to),
        Report::ShowGrid => long_answers::begin(world, Listing::Grid { row: 0 }, to),
        Report::ShowSettings => {
            let loaded = if settings_loaded { "config override loaded" } else { "No config override loaded" };
            world.say(to, format_args!("// NOTE: {loaded}\n"));
            long_answers::begin(world, Listing::Settings { part: 0 }, to)
        }
    }
}
