//! Functions of the machine beside moving: each one in the table of codes is led to its owner.
//!
//! Functions that only say or set something never wait, unless they need standstill, and questions among them
//! are answered at any waiting point. The others are sequences.

use base::failure::{Answer, Outcome};
use base::hands::Hands;
use base::own_frame::apart;
use base::ports::Clock as _;
use base::safety::Mode;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use gcode::{Blocks, Code};
use jobs::player::Jobs;
use parts::heat_codes;
use parts::outputs::Outputs;
use parts::reports::{self, Status};
use procedures::probing::{self, ProbeHands};
use procedures::{alignment, arms, autotune, leveling};
use program::{FileFunction, Function, Geometry, Interpreter, Sequence, Words};

use crate::features::power_loss::job_recovery;
use crate::features::{filament, file_functions, report_functions, setting_functions, statistics};
use crate::machine::hands::MachineHands;
use crate::machine::work_hands::WorldHands;
use crate::machine::{Machine, abort, card, probe_strategy, settings_file, suspend};

/// Carries out a function, and waits for its end.
pub(crate) fn run<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: Words<'_>,
    to: Recipient,
) -> Outcome {
    if function.is_for_owner() {
        machine.world.owner_only(to, machine.jobs.rights())?;
    }
    if function.needs_card() {
        card::at_rest(machine);
    }
    if function == Function::File(FileFunction::Mount) {
        // Looking for the card forgets writes that wait. A failure among those has been told.
        let _ = card::kept(machine);
    }
    match function {
        // A suspended job goes on from where it stopped.
        Function::File(FileFunction::StartJob) if machine.jobs.is_suspended() => suspend::resume(machine, to),
        Function::Limit(code) => setting_functions::limit(machine, code, &words, to),
        Function::Setting(setting) => setting_functions::set(machine, setting, &words, to),
        Function::Report(asked) => apart(|| report_functions::report(machine, asked, &words, to)),
        Function::File(asked) => apart(|| file_functions::file_or_job(machine, asked, &words, to)),
        Function::Standing(setting) => {
            if function.stands_first(&words) {
                machine.standstill()?;
            }
            setting_functions::set_standing(machine, setting, &words, to)
        }
        // These move, heat, or count on having moved.
        Function::Geometry(what) => apart(|| geometry(&mut MachineHands::new(machine, to), what, &words)),
        Function::Sequence(what) => sequence(machine, what, &words, to),
    }
}

/// Changes where places of the program lie.
fn geometry<'c>(hands: &mut impl Hands<'c>, what: Geometry, words: &Words<'_>) -> Outcome {
    match what {
        Geometry::LoadGrid => leveling::load(hands, words),
        Geometry::FadeHeight => leveling::fade_height(hands, words.as_length('H'), words.as_length('T')),
        Geometry::BedPlane => leveling::bed_plane(hands, words),
        Geometry::Skew => leveling::skew(hands, words),
        Geometry::ArmSettings => arms::arm_settings(hands, words).map(|()| Answer::Ok),
    }
}

/// Runs a function that takes time. Each has a stack frame of its own: functions wait, and much is called
/// from there.
fn sequence<P: Ports>(machine: &mut Machine<'_, P>, what: Sequence, words: &Words<'_>, to: Recipient) -> Outcome {
    let hands = &mut MachineHands::new(machine, to);
    match what {
        Sequence::ProbeStrategy => probe_strategy::run(machine, words, words.code(), to),
        Sequence::MeasureBed => probe_strategy::run(machine, words, Code::g(31), to),
        Sequence::ProbeRepeatability => stowed(hands, |hands| probing::repeatability(hands, words)),
        Sequence::AlignZ => stowed(hands, |hands| alignment::align(hands, words)),
        Sequence::AlignSlave => apart(|| alignment::align_slave(hands, words)),
        Sequence::BedScrews => stowed(hands, alignment::advise),
        Sequence::PaperTest => apart(|| procedures::paper::paper_test(hands, words)),
        Sequence::DeployProbe => probing::deploy_or_stow(hands, true),
        Sequence::StowProbe => probing::deploy_or_stow(hands, false),
        Sequence::LevelingOff => apart(|| leveling::level_off(hands)),
        Sequence::SaveGrid => apart(|| leveling::save(hands, words)),
        Sequence::ListMeshes => apart(|| leveling::list(hands)),
        Sequence::UseGrid => apart(|| leveling::use_mesh(hands, words)),
        Sequence::MeshOffset => apart(|| leveling::mesh_offset(hands, words)),
        Sequence::GridPoint => apart(|| leveling::grid_point(hands, words)),
        Sequence::MeasuredPart => apart(|| probing::measured_part(hands, words)),
        Sequence::Statistics => {
            apart(|| Ok(statistics::told(&mut machine.world, &mut machine.jobs.statistics, words, to)))
        }
        Sequence::AbortJob => apart(|| abort::abort(machine, to)),
        Sequence::Park => apart(|| filament::go_aside(machine, words)),
        Sequence::LoadFilament => apart(|| filament::by_hand(machine, true, words.get('L'))),
        Sequence::UnloadFilament => apart(|| filament::by_hand(machine, false, words.get('U'))),
        Sequence::WaitForHeaters | Sequence::WaitForTargets => {
            let cools = what == Sequence::WaitForTargets;
            apart(|| heat_codes::wait_for_all(hands, words, cools)).map(|()| Answer::Ok)
        }
        Sequence::TunePid => apart(|| autotune::tune_pid(hands, words)),
        Sequence::SaveSettings => settings_file::save(machine, words.text(), to),
        Sequence::GoOnWithJob => apart(|| job_recovery::command(machine, words, to)),
    }
}

/// Runs a sequence that probes, and stows the probe after it.
fn stowed<'c, H: ProbeHands<'c>>(hands: &mut H, probe: impl FnOnce(&mut H) -> Outcome) -> Outcome {
    let ended = apart(|| probe(hands));
    probing::stow_after(hands, ended)
}

// --- questions ---

/// Parts of the machine that its status tells.
pub(crate) struct Stating<'m, 'c, P> {
    pub world: &'m mut World<'c, P>,
    pub program: &'m Interpreter,
    pub mode: Mode,
    pub jobs: &'m mut Jobs,
    pub outputs: &'m mut Outputs,
}

/// The machine for its status.
pub(crate) trait StatusHands<'c>: WorldHands<'c> {
    /// Returns the parts of the machine that its status tells.
    fn stating(&mut self) -> Stating<'_, 'c, Self::Ports>;

    /// Tells the jobs which of their moves the motors make.
    fn follow_job(&mut self);
}

impl<'c, P: Ports> StatusHands<'c> for Machine<'c, P> {
    fn stating(&mut self) -> Stating<'_, 'c, P> {
        let Self { world, program, jobs, outputs, safety, .. } = self;
        Stating { world, program, mode: safety.mode(), jobs, outputs }
    }

    fn follow_job(&mut self) {
        self.follow_job();
    }
}

/// Reports the status (`?`). A function of its own in the image too: the virtual board's tests put faults
/// there.
#[inline(never)]
pub(crate) fn report_status<'c>(hands: &mut impl StatusHands<'c>, to: Recipient) {
    let progress = job_progress(hands);
    let Stating { world: World { ports, sessions, config, .. }, program, mode, .. } = hands.stating();
    let of = Status { mode, program, config, dialect: sessions.dialect_of(to), progress };
    reports::status(ports, &of, &mut Reply::new(sessions, to));
}

/// Returns seconds and percent of the job, when there is one.
pub(crate) fn job_progress<'c>(hands: &mut impl StatusHands<'c>) -> Option<(u64, u64)> {
    hands.follow_job();
    let Stating { world, jobs, .. } = hands.stating();
    jobs.progress(world.ports.now())
}

/// Answers a line that is one question. False for every other line.
pub(crate) fn answer<P: Ports>(machine: &mut Machine<'_, P>, mut blocks: Blocks<'_>, to: Recipient) -> bool {
    let (Some(Ok(block)), None) = (blocks.next(), blocks.next()) else { return false };
    let Some((row, function, words)) = machine.program.question(&block, machine.world.sessions.dialect_of(to)) else {
        return false;
    };
    if !row.states.has(machine.safety.state()) {
        return false;
    }
    let outcome = match function {
        Function::File(FileFunction::StartJob) if machine.jobs.is_suspended() => return false,
        Function::Limit(code) => setting_functions::limit(machine, code, &words, to),
        Function::Setting(setting) => setting_functions::set(machine, setting, &words, to),
        Function::Report(asked) => apart(|| report_functions::report(machine, asked, &words, to)),
        Function::File(asked) => apart(|| file_functions::file_or_job(machine, asked, &words, to)),
        Function::Standing(_) | Function::Geometry(_) | Function::Sequence(_) => return false,
    };
    match outcome {
        Ok(Answer::Said) => true,
        Ok(Answer::Ok) => {
            machine.say(to, format_args!("ok\n"));
            true
        }
        // Faults of the question are told in its turn.
        Ok(_) | Err(_) => false,
    }
}
