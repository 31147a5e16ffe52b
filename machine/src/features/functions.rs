//! Functions of the machine beside moving: each one in the table of codes is led to its owner.
//!
//! Functions that only say or set something never wait, unless they need standstill, and questions among them
//! are answered at any waiting point. The others are sequences.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::motors;
use base::own_frame::apart;
use base::sessions::{Listing, Periodic, Recipient, Reply};
use base::{Ports, World};
use events::{Event, Text};
use gcode::{Blocks, Code};
use jobs::files::{self, listings};
use parts::motion_codes::Limited;
use parts::reports::{self, Status};
use parts::{driver_codes, heat_codes, motion_codes};
use procedures::probing::{self, ProbeHands};
use procedures::{alignment, arms, autotune, endstop_phase, leveling};
use program::{FileFunction, Function, Geometry, LimitCode, Report, Sequence, Setting, Standing, Words};
use units::AxisSet;

use crate::features::forecast::ForecastHands as _;
use crate::features::power_loss::job_recovery;
use crate::features::state::States;
use crate::features::{automatic_outputs, filament, forecast, objects, periodic_reports, statistics};
use crate::machine::hands::MachineHands;
use crate::machine::{Machine, abort, card, long_answers, probe_strategy, program_io, settings_file, suspend};

/// Carries out a function, and waits for its end.
pub(crate) fn run<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: Words<'_>,
    to: Recipient,
) -> Outcome {
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
        Function::Limit(code) => limit(machine, code, &words, to),
        Function::Setting(setting) => set(machine, setting, &words, to),
        Function::Report(asked) => apart(|| report(machine, asked, &words, to)),
        Function::File(asked) => apart(|| file_or_job(machine, asked, &words, to)),
        Function::Standing(setting) => {
            if function.stands_first(&words) {
                machine.standstill()?;
            }
            set_standing(machine, setting, &words, to)
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

/// Carries out a function that needs standstill.
fn set_standing<P: Ports>(
    machine: &mut Machine<'_, P>,
    setting: Standing,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    if setting == Standing::HomeOffsetsFromHere && words.has('T') {
        return apart(|| autotune::tune_model(&mut MachineHands::new(machine, to), words));
    }
    let Machine { program, axes, tuning, world: World { ports, sessions, config, .. }, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    match setting {
        Standing::Microsteps => motors::microsteps(machine.world.texts, ports, config, words, reply),
        Standing::DriverRegister => motors::write_register(machine.world.texts, ports, config, words, reply),
        Standing::StealthThresholds => {
            driver_codes::stealth_thresholds(machine.world.texts, ports, config, tuning, words, reply)
        }
        Standing::StealthMode => driver_codes::stealth_mode(machine.world.texts, ports, config, tuning, words, reply),
        Standing::MotorPositions => {
            arms::motor_positions(machine.world.texts, ports, words).inspect(|_| machine.declare_homed(words.axes()))
        }
        Standing::HomeOffsetsFromHere => {
            arms::home_offsets_from_here(machine.world.texts, ports, config, axes, tuning, words, reply)
        }
        Standing::StepsPerMm => {
            motion_codes::steps_per_mm(machine.world.texts, ports, config, program.tools(), words, reply)
        }
        Standing::PressureAdvance => {
            motion_codes::pressure_advance(machine.world.texts, ports, config, program.tools(), words, reply)
        }
        Standing::InputShaping => motion_codes::input_shaping(machine.world.texts, ports, words, reply),
        Standing::MotorsOff => {
            let extruder = program.tools().active().map(|tool| tool.settings.axis).filter(|_| words.has('E'));
            let named = extruder.map_or(words.axes(), |axis| words.axes().with(axis));
            axes.disable(ports, if named.is_empty() && !words.has('E') { AxisSet::ALL } else { named });
            Ok(Answer::Ok)
        }
    }
}

/// Carries out a function that sets limits.
fn limit<P: Ports>(machine: &mut Machine<'_, P>, code: LimitCode, words: &Words<'_>, to: Recipient) -> Outcome {
    if code == LimitCode::SpeedFactor {
        let is_beside = machine.jobs.is_open() && machine.jobs.made(machine.tag).is_none();
        let Machine { world, program, feed_waits, .. } = &mut *machine;
        if program_io::speed_factor(world, program, feed_waits, is_beside, words, to) {
            return Ok(Answer::Ok);
        }
    }
    let Machine { program, safety, tuning, world: World { ports, sessions, config, texts }, .. } = machine;
    let on = &mut Limited { texts, ports, config, program, tuning, travel: &mut safety.travel };
    if !words.is_bare() {
        motion_codes::set_limit(on, code, words)?;
    }
    motion_codes::report_limit(on, code, words, &mut Reply::new(sessions, to)).map(ok)
}

/// Carries out a function that sets something.
fn set<P: Ports>(machine: &mut Machine<'_, P>, setting: Setting, words: &Words<'_>, to: Recipient) -> Outcome {
    let now = machine.world.ports.now();
    let Machine { axes, bed, tuning, thermal, phases, world: World { ports, sessions, config, .. }, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    match setting {
        Setting::MotorsOn => axes.enable(machine.world.texts, ports, config, tuning, now).map(ok),
        Setting::EndstopPhase => {
            endstop_phase::endstop_phase(machine.world.texts, ports, config, phases, tuning, words, reply)
        }
        Setting::MotorMilliamps | Setting::MotorAmps => {
            motors::motor_currents(machine.world.texts, ports, config, axes, tuning, words, reply)
        }
        Setting::ProbeSettings => probing::probe_settings(tuning, words, reply),
        Setting::ThermalAdjust => thermal.command(words, reply),
        Setting::ProbePoint => leveling::probe_point(bed, words, reply),
        Setting::ProbeOffset => leveling::probe_offset(bed, words, reply),
        Setting::AxisTwist => leveling::axis_twist(bed, words, reply),
        Setting::MarlinProbeOffset => leveling::marlin_probe_offset(bed, words, reply),
        Setting::MaximumTemperature => {
            heat_codes::maximum_temperature(machine.world.texts, ports, config, words, reply)
        }
        Setting::PidGains => heat_codes::pid_gains(machine.world.texts, ports, config, words, reply),
        Setting::HeaterModel => heat_codes::heater_model(machine.world.texts, ports, config, words, reply),
        Setting::Sensor => heat_codes::sensors(machine.world.texts, ports, config, tuning, words, reply),
        Setting::DriverChopper => motors::describe_choppers(machine.world.texts, ports, config, words, reply),
        Setting::DriverOption => motors::driver_option(machine.world.texts, ports, config, tuning, words, reply),
        Setting::ForgetDriverTroubles => driver_codes::forget_told(machine.world.texts, ports, config, words),
        Setting::HomingThresholds => driver_codes::homing_thresholds(machine.world.texts, config, tuning, words, reply),
    }
}

const fn ok((): ()) -> Answer {
    Answer::Ok
}

/// Carries out a function that says something.
fn report<P: Ports>(machine: &mut Machine<'_, P>, asked: Report, words: &Words<'_>, to: Recipient) -> Outcome {
    let dialect = machine.world.sessions.dialect_of(to);
    let Machine {
        program,
        axes,
        tuning,
        features: States { filament, filament_width, .. },
        world: World { ports, sessions, config, .. },
        ..
    } = machine;
    let reply = &mut Reply::new(sessions, to);
    let code = words.code();
    match asked {
        Report::ReportFans => {
            automatic_outputs::report_fans(&mut machine.world, &machine.features.fans, to);
            Ok(Answer::Ok)
        }
        Report::ReportTemperatures => {
            // The line begins with its `ok`.
            heat_codes::report_temperatures(ports, config, code.number, ("ok ", reply));
            Ok(Answer::Said)
        }
        Report::ReportPosition => reports::position(ports, config, program, (dialect, words), reply),
        Report::ReportFirmware => {
            reports::firmware(ports, config, dialect, reply);
            Ok(Answer::Ok)
        }
        Report::ReportSwitches => {
            reports::end_switches(ports, config, tuning, reply);
            Ok(Answer::Ok)
        }
        Report::ReportHoming => {
            arms::report_homing(config, axes, reply);
            Ok(Answer::Ok)
        }
        Report::FilamentDiameter => {
            reports::filament_diameter(machine.world.texts, config, program.tools(), words, reply)
        }
        Report::FlowFactor => reports::flow_factor(machine.world.texts, config, program.tools(), words, reply),
        Report::SayToAll => {
            let (prefix, text) = program::said_by_m118(words.text().unwrap_or(""));
            sessions.say(Recipient::All, format_args!("{prefix}{text}\n"));
            Ok(Answer::Ok)
        }
        Report::FilamentDetector => parts::filament::told((filament, filament_width), config, tuning, words, reply),
        Report::FilamentWidth => {
            let readings = ports.heat(|heat| heat.filament_width());
            parts::filament::told_of_width(filament_width, readings, config, tuning, words, reply)
        }
        Report::FilamentLengths => Ok(filament::lengths(tuning, words, reply)),
        Report::RetractSettings | Report::RecoverSettings => Ok(Answer::Ok),
        Report::DriverStatus => long_answers::describe_drivers(&mut machine.world, words, to),
        Report::ShowMap => long_answers::begin(&mut machine.world, Listing::Map { line: 0 }, to),
        Report::ShowGrid => long_answers::begin(&mut machine.world, Listing::Grid { row: 0 }, to),
        Report::ShowSettings => {
            let loaded = if machine.settings_loaded { "config override loaded" } else { "No config override loaded" };
            machine.say(to, format_args!("// NOTE: {loaded}\n"));
            long_answers::begin(&mut machine.world, Listing::Settings { part: 0 }, to)
        }
    }
}

/// Carries out a function of files, jobs or saved settings.
fn file_or_job<P: Ports>(
    machine: &mut Machine<'_, P>,
    asked: FileFunction,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    let now = machine.world.ports.now();
    let dialect = machine.world.sessions.dialect_of(to);
    let Machine {
        files,
        jobs,
        program,
        bed,
        features: States { journal, filament, .. },
        world: World { ports, sessions, config, .. },
        ..
    } = machine;
    let reply = &mut Reply::new(sessions, to);
    let name = words.text();
    match asked {
        FileFunction::ListFiles => {
            machine.say(to, format_args!("Begin file list\n"));
            long_answers::begin(&mut machine.world, listings::card(), to)
        }
        FileFunction::AutoReport => periodic_reports::command(&mut machine.world, Periodic::Temperatures, words, to),
        FileFunction::Keepalive => periodic_reports::command(&mut machine.world, Periodic::Busy, words, to),
        FileFunction::ReportJob if words.has('S') => {
            periodic_reports::command(&mut machine.world, Periodic::Job, words, to)
        }
        FileFunction::ReportJob => {
            forecast::say_bytes(&mut machine.forecast(), to);
            Ok(Answer::Ok)
        }
        FileFunction::ReportProgress => {
            forecast::say_progress(&mut machine.forecast(), to);
            Ok(Answer::Ok)
        }
        FileFunction::LoadSettings => settings_file::load(machine, words.text(), to),
        FileFunction::LabelObject => objects::label(machine, words.text().unwrap_or(""), to),
        FileFunction::Mount => {
            let mounted = files::commands::mount(machine.world.texts, ports, reply);
            let news = match &mounted {
                Err(why) if why.is_refusal() => {
                    Event::CardFailed(Text::new(format_args!("{}", machine.world.texts.of(*why))))
                }
                _ => Event::CardMounted,
            };
            ports.events().record(ports.now(), &news);
            mounted
        }
        FileFunction::SelectFile | FileFunction::StartFile => {
            let was_open = jobs.is_open();
            let selected = jobs.select(machine.world.texts, name, asked == FileFunction::StartFile, now, ports, reply);
            if was_open && selected.is_ok() {
                // Loops and subroutines of a paused job are none of the next job's.
                program.end_program();
                journal.end(ports);
            }
            selected
        }
        // A job that has not begun is suspended before its first move instead.
        FileFunction::StartJob if jobs.begun() > 0 && filament.is_missing(config).is_some() => {
            filament.must_be_there(machine.world.texts, config).map(|()| Answer::Ok)
        }
        FileFunction::StartJob => {
            let is_back = jobs.begun() > 0 && !jobs.is_playing();
            let started = jobs.start(machine.world.texts, ports, reply);
            if is_back && started.is_ok() {
                reply.tell_hosts("resumed");
            }
            journal.reopen(ports);
            started
        }
        FileFunction::PauseJob => {
            if jobs.is_playing() {
                jobs.set_paused(true);
                reply.tell_hosts("paused");
            }
            Ok(Answer::Ok)
        }
        FileFunction::RestartJob if words.get('S').is_some_and(|offset| offset > 0.0) => Err(Failure::refused(
            &"M26 S: play file --from byte N begins there, with modes and E as the file has them by then",
        )),
        FileFunction::RestartJob => {
            let restarted = jobs.restart(machine.world.texts, ports);
            if restarted.is_ok() {
                program.end_program();
            }
            restarted
        }
        FileFunction::PowerLoss => {
            if let Some(on) = words.get('S') {
                journal.is_on = on != 0.0;
            }
            reply.say(format_args!("power-loss recovery is {}\n", if journal.is_on { "on" } else { "off" }));
            Ok(Answer::Ok)
        }
        FileFunction::Upload => match to {
            Recipient::Session(session) => files.begin_upload(session, name.unwrap_or(""), ports, reply),
            _ => Err(Failure::refused(&"only a session can upload a file")),
        },
        FileFunction::EndUpload => Ok(Answer::Ok),
        FileFunction::RemoveFile => files.remove(name.unwrap_or(""), ports, reply),
        FileFunction::DeleteGrid => leveling::delete(machine.world.texts, config, ports, bed, words, reply),
        FileFunction::ForgetSettings => settings_file::forget(machine.world.texts, ports, reply, dialect),
    }
}

// --- questions ---

/// Reports the status (`?`). A function of its own in the image too: the virtual board's tests put faults
/// there.
#[inline(never)]
pub(crate) fn report_status<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    let (progress, dialect) = (job_progress(machine), machine.world.sessions.dialect_of(to));
    let Machine { program, safety, world: World { ports, sessions, config, .. }, .. } = machine;
    let of = Status { mode: safety.mode(), program, config, dialect, progress };
    reports::status(ports, &of, &mut Reply::new(sessions, to));
}

/// Returns seconds and percent of the job, when there is one.
pub(crate) fn job_progress<P: Ports>(machine: &mut Machine<'_, P>) -> Option<(u64, u64)> {
    machine.follow_job();
    machine.jobs.progress(machine.world.ports.now())
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
        Function::Limit(code) => limit(machine, code, &words, to),
        Function::Setting(setting) => set(machine, setting, &words, to),
        Function::Report(asked) => apart(|| report(machine, asked, &words, to)),
        Function::File(asked) => apart(|| file_or_job(machine, asked, &words, to)),
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
