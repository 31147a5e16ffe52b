//! Functions of the machine beside moving: each one in the table of codes is led to its owner.
//!
//! Functions that only say or set something never wait, and questions among them are answered at any waiting
//! point. The others are sequences.

use base::Ports;
use base::apart::apart;
use base::failure::{Answer, Failure, Outcome};
use base::motors;
use base::sessions::{Listing, Recipient, Reply};
use events::{Event, Text};
use gcode::{Blocks, Code};
use jobs::files::{self, listings};
use parts::driver_codes;
use parts::heat_codes;
use parts::motion_codes;
use parts::reports;
use parts::reports::Status;
use procedures::alignment;
use procedures::arms;
use procedures::autotune;
use procedures::endstop_phase;
use procedures::leveling;
use procedures::probing::{self, ProbeHands};
use program::{Function, State, Words};
use units::AxisSet;

use super::{
    Machine, MachineHands, abort, automatic, card, cold, filament, foresee, long_answers, objects, periodic,
    probe_strategy, program_io, recover, settings_file, statistics, suspend,
};

/// Carries out a function, and waits for its end.
pub(super) fn run<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: Words<'_>,
    to: Recipient,
) -> Outcome {
    if machine.passed.is_some() {
        return read_over(machine, function, &words);
    }
    if card::is_used_by(function) {
        card::at_rest(machine);
    }
    if function == Function::Mount {
        // Looking for the card forgets writes that wait. A failure among those has been told.
        let _ = card::kept(machine);
    }
    if let Some(outcome) = say_or_set(machine, function, &words, to) {
        return outcome;
    }
    let is_checking = machine.safety.state() == State::Check;
    if stands_first(function, &words) {
        if is_checking {
            return Ok(Answer::Ok);
        }
        machine.standstill()?;
    }
    if let Some(outcome) = set_standing(machine, function, &words, to) {
        return outcome;
    }
    // The remaining functions move, heat, or count on having moved.
    if is_checking {
        return Ok(Answer::Ok);
    }
    if function == Function::GoOnWithJob {
        return apart(|| recover::command(machine, &words, to));
    }
    sequence(machine, function, &words, to)
}

/// Runs a function that takes time. Each has a stack frame of its own: functions wait, and much is called
/// from there.
fn sequence<P: Ports>(machine: &mut Machine<'_, P>, function: Function, words: &Words<'_>, to: Recipient) -> Outcome {
    let hands = &mut MachineHands::new(machine, to);
    match function {
        Function::ProbeStrategy => probe_strategy::run(machine, words, words.code(), to),
        Function::MeasureBed => probe_strategy::run(machine, words, Code::g(31), to),
        Function::ProbeRepeatability => stowed(hands, |hands| probing::repeatability(hands, words)),
        Function::AlignZ => stowed(hands, |hands| alignment::align(hands, words)),
        Function::AlignSlave => apart(|| alignment::align_slave(hands, words)),
        Function::BedScrews => stowed(hands, alignment::advise),
        Function::PaperTest => apart(|| procedures::paper::paper_test(hands, words)),
        Function::DeployProbe => probing::deploy_or_stow(hands, true),
        Function::StowProbe => probing::deploy_or_stow(hands, false),
        Function::LevelingOff => apart(|| leveling::level_off(hands)),
        Function::SaveGrid => apart(|| leveling::save(hands, words)),
        Function::ListMeshes => apart(|| leveling::list(hands)),
        Function::LoadGrid => apart(|| leveling::load(hands, words)),
        Function::UseGrid => apart(|| leveling::use_mesh(hands, words)),
        Function::FadeHeight => apart(|| leveling::fade_height(hands, words.as_length('H'), words.as_length('T'))),
        Function::MeshOffset => apart(|| leveling::mesh_offset(hands, words)),
        Function::GridPoint => apart(|| leveling::grid_point(hands, words)),
        Function::BedPlane => apart(|| leveling::bed_plane(hands, words)),
        Function::Skew => apart(|| leveling::skew(hands, words)),
        Function::MeasuredPart => apart(|| probing::measured_part(hands, words)),
        Function::ArmSettings => apart(|| arms::arm_settings(hands, words)).map(|()| Answer::Ok),
        Function::Statistics => apart(|| Ok(statistics::told(machine, words, to))),
        Function::AbortJob => apart(|| abort::abort(machine, to)),
        Function::Park => apart(|| filament::go_aside(machine, words)),
        Function::LoadFilament => apart(|| filament::by_hand(machine, true, words.get('L'))),
        Function::UnloadFilament => apart(|| filament::by_hand(machine, false, words.get('U'))),
        // A suspended job goes on from where it stopped.
        Function::StartJob => suspend::resume(machine, to),
        Function::WaitForHeaters | Function::WaitForTargets => {
            let cools = function == Function::WaitForTargets;
            apart(|| heat_codes::wait_for_all(hands, words, cools)).map(|()| Answer::Ok)
        }
        Function::TunePid => apart(|| autotune::tune_pid(hands, words)),
        Function::HomeOffsetsFromHere => apart(|| autotune::tune_model(hands, words)),
        Function::SaveSettings => settings_file::save(machine, words.text(), to),
        _ => Ok(Answer::Unknown),
    }
}

/// Runs a sequence that probes, and stows the probe after it.
fn stowed<'c, H: ProbeHands<'c>>(hands: &mut H, probe: impl FnOnce(&mut H) -> Outcome) -> Outcome {
    let ended = apart(|| probe(hands));
    probing::stow_after(hands, ended)
}

/// Whether a function changes the meaning of every step or filter, so that motion must stand first.
fn stands_first(function: Function, words: &Words<'_>) -> bool {
    match function {
        Function::StepsPerMm | Function::Microsteps | Function::StealthThresholds => !words.is_bare(),
        Function::StealthMode => true,
        Function::PressureAdvance => words.has('K') || words.has('S') || words.has('W'),
        Function::InputShaping => !words.is_bare(),
        Function::MotorsOff | Function::MotorPositions => true,
        Function::HomeOffsetsFromHere | Function::DriverRegister => true,
        _ => false,
    }
}

/// Carries out a function that a fast-forward reads over: settings of speeds, motors, filters, gains and
/// objects count from there on too.
#[cold]
fn read_over<P: Ports>(machine: &mut Machine<'_, P>, function: Function, words: &Words<'_>) -> Outcome {
    let nobody = Recipient::Nobody;
    match function {
        Function::LabelObject => objects::label(machine, words.text().unwrap_or(""), nobody),
        Function::MotorsOn | Function::MotorsOff => Ok(Answer::Ok),
        _ => {
            let set = motion_or_heat(machine, function, words, nobody);
            set.or_else(|| set_standing(machine, function, words, nobody)).unwrap_or(Ok(Answer::Ok))
        }
    }
}

/// Carries out a function that needs standstill; `None` for any other.
fn set_standing<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    let Machine { ports, program, sessions, axes, config, tuning, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    Some(match function {
        Function::Microsteps => motors::microsteps(machine.texts, ports, config, words, reply),
        Function::DriverRegister => motors::write_register(machine.texts, ports, config, words, reply),
        Function::StealthThresholds => {
            driver_codes::stealth_thresholds(machine.texts, ports, config, tuning, words, reply)
        }
        Function::StealthMode => driver_codes::stealth_mode(machine.texts, ports, config, tuning, words, reply),
        Function::MotorPositions => {
            arms::motor_positions(machine.texts, ports, words).inspect(|_| machine.declare_homed(words.axes()))
        }
        Function::HomeOffsetsFromHere if !words.has('T') => {
            arms::home_offsets_from_here(machine.texts, ports, config, axes, tuning, words, reply)
        }
        Function::StepsPerMm => motion_codes::steps_per_mm(machine.texts, ports, config, program.tools(), words, reply),
        Function::PressureAdvance => {
            motion_codes::pressure_advance(machine.texts, ports, config, program.tools(), words, reply)
        }
        Function::InputShaping => motion_codes::input_shaping(machine.texts, ports, words, reply),
        Function::MotorsOff => {
            let extruder = program.tools().active().map(|tool| tool.settings.axis).filter(|_| words.has('E'));
            let named = extruder.map_or(words.axes(), |axis| words.axes().with(axis));
            axes.disable(ports, if named.is_empty() && !words.has('E') { AxisSet::ALL } else { named });
            Ok(Answer::Ok)
        }
        _ => return None,
    })
}

/// Carries out a function that only says or sets something; `None` for any other.
fn say_or_set<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    motion_or_heat(machine, function, words, to)
        .or_else(|| apart(|| report(machine, function, words, to)))
        .or_else(|| apart(|| file_or_job(machine, function, words, to)))
}

fn motion_or_heat<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    match function {
        Function::SpeedFactor => {
            program_io::speed_factor(machine, words, to);
            return Some(Ok(Answer::Ok));
        }
        Function::ColdExtrusion => return Some(cold::command(machine, words, to)),
        _ => {}
    }
    let now = machine.ports.now();
    let Machine { ports, program, sessions, safety, axes, bed, tuning, config, thermal, phases, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    Some(match function {
        Function::MotorsOn => axes.enable(machine.texts, ports, config, tuning, now).map(ok),
        Function::AxisSpeeds => {
            let set = motion_codes::axis_speeds(machine.texts, ports, config, program, words, reply);
            set.map(|rate| {
                if let Some(rate) = rate {
                    program.set_seek_rate(rate);
                }
                Answer::Ok
            })
        }
        Function::MotorSpeeds => {
            motion_codes::motor_speeds(machine.texts, ports, config, program.tools(), words, reply)
        }
        Function::Accelerations => motion_codes::accelerations(machine.texts, ports, config, program.tools(), words),
        Function::CornerSettings => motion_codes::corner_settings(machine.texts, ports, words),
        Function::Jerk => motion_codes::jerk(machine.texts, ports, words),
        Function::Trims => arms::trims(tuning, words, reply).map(ok),
        Function::HomeOffsets => arms::home_offsets(tuning, words, reply).map(ok),
        Function::EndstopPhase => {
            endstop_phase::endstop_phase(machine.texts, ports, config, phases, tuning, words, reply)
        }
        Function::SoftEndstops => motion_codes::soft_endstops(&mut safety.travel, config, tuning, words, reply),
        Function::MotorMilliamps | Function::MotorAmps => {
            motors::motor_currents(machine.texts, ports, config, axes, tuning, words, reply)
        }
        Function::ProbeSettings => probing::probe_settings(tuning, words, reply),
        Function::ThermalAdjust => thermal.command(words, reply),
        Function::ProbePoint => leveling::probe_point(bed, words, reply),
        Function::ProbeOffset => leveling::probe_offset(bed, words, reply),
        Function::AxisTwist => leveling::axis_twist(bed, words, reply),
        Function::MarlinProbeOffset => leveling::marlin_probe_offset(bed, words, reply),
        Function::MaximumTemperature => heat_codes::maximum_temperature(machine.texts, ports, config, words, reply),
        Function::PidGains => heat_codes::pid_gains(machine.texts, ports, config, words, reply),
        Function::HeaterModel => heat_codes::heater_model(machine.texts, ports, config, words, reply),
        Function::Sensor => heat_codes::sensors(machine.texts, ports, config, tuning, words, reply),
        Function::DriverChopper => motors::describe_choppers(machine.texts, ports, config, words, reply),
        Function::DriverOption => motors::driver_option(machine.texts, ports, config, tuning, words, reply),
        Function::ForgetDriverTroubles => driver_codes::forget_told(machine.texts, ports, config, words),
        Function::HomingThresholds => driver_codes::homing_thresholds(machine.texts, config, tuning, words, reply),
        _ => return None,
    })
}

const fn ok((): ()) -> Answer {
    Answer::Ok
}

fn report<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    if function == Function::ReportFans {
        automatic::report_fans(machine, to);
        return Some(Ok(Answer::Ok));
    }
    let dialect = machine.sessions.dialect_of(to);
    let Machine { ports, program, sessions, axes, tuning, config, filament, filament_width, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    let code = words.code();
    Some(match function {
        Function::ReportTemperatures => {
            // The line begins with its `ok`.
            heat_codes::report_temperatures(ports, config, code.number, ("ok ", reply));
            Ok(Answer::Said)
        }
        Function::ReportPosition => reports::position(ports, config, program, (dialect, words), reply),
        Function::ReportFirmware => {
            reports::firmware(ports, config, dialect, reply);
            Ok(Answer::Ok)
        }
        Function::ReportSwitches => {
            reports::end_switches(ports, config, tuning, reply);
            Ok(Answer::Ok)
        }
        Function::ReportHoming => {
            arms::report_homing(config, axes, reply);
            Ok(Answer::Ok)
        }
        Function::FilamentDiameter => reports::filament_diameter(machine.texts, config, program.tools(), words, reply),
        Function::FlowFactor => reports::flow_factor(machine.texts, config, program.tools(), words, reply),
        Function::SayToAll => {
            let (prefix, text) = program::said_by_m118(words.text().unwrap_or(""));
            sessions.say(Recipient::All, format_args!("{prefix}{text}\n"));
            Ok(Answer::Ok)
        }
        Function::FilamentDetector => parts::filament::told((filament, filament_width), config, tuning, words, reply),
        Function::FilamentWidth => {
            let readings = ports.heat(|heat| heat.filament_width());
            parts::filament::told_of_width(filament_width, readings, config, tuning, words, reply)
        }
        Function::FilamentLengths => Ok(filament::lengths(tuning, words, reply)),
        Function::RetractSettings | Function::RecoverSettings => Ok(Answer::Ok),
        Function::DriverStatus => long_answers::describe_drivers(machine, words, to),
        Function::ShowMap => long_answers::begin(machine, Listing::Map { line: 0 }, to),
        Function::ShowGrid => long_answers::begin(machine, Listing::Grid { row: 0 }, to),
        Function::ShowSettings => {
            let loaded = if machine.settings_loaded { "config override loaded" } else { "No config override loaded" };
            machine.say(to, format_args!("// NOTE: {loaded}\n"));
            long_answers::begin(machine, Listing::Settings { part: 0 }, to)
        }
        _ => return None,
    })
}

fn file_or_job<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    match function {
        Function::ListFiles => {
            machine.say(to, format_args!("Begin file list\n"));
            let listing = listings::card();
            return Some(long_answers::begin(machine, listing, to));
        }
        Function::AutoReport | Function::Keepalive => return Some(periodic::command(machine, function, words, to)),
        Function::ReportJob if words.has('S') => return Some(periodic::command(machine, function, words, to)),
        Function::ReportJob | Function::ReportProgress => {
            let outlook = foresee::outlook(machine);
            let Machine { jobs, sessions, .. } = machine;
            let reply = &mut Reply::new(sessions, to);
            match function {
                Function::ReportJob => jobs.say_bytes(&outlook, reply),
                _ => jobs.say_progress(&outlook, reply),
            }
            return Some(Ok(Answer::Ok));
        }
        Function::LoadSettings => return Some(settings_file::load(machine, words.text(), to)),
        Function::LabelObject => return Some(objects::label(machine, words.text().unwrap_or(""), to)),
        _ => {}
    }
    let now = machine.ports.now();
    let dialect = machine.sessions.dialect_of(to);
    let Machine { ports, sessions, files, jobs, journal, filament, config, program, bed, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    let name = words.text();
    Some(match function {
        Function::Mount => {
            let mounted = files::commands::mount(machine.texts, ports, reply);
            let news = match &mounted {
                Err(why) if why.is_refusal() => {
                    Event::CardFailed(Text::new(format_args!("{}", machine.texts.of(*why))))
                }
                _ => Event::CardMounted,
            };
            ports.events().record(ports.now(), &news);
            mounted
        }
        Function::SelectFile | Function::StartFile => {
            let was_open = jobs.is_open();
            let selected = jobs.select(machine.texts, name, function == Function::StartFile, now, ports, reply);
            if was_open && selected.is_ok() {
                // Loops and subroutines of a paused job are none of the next job's.
                program.end_program();
                journal.end(ports);
            }
            selected
        }
        // A suspended job is not where its machine is.
        Function::StartJob if jobs.is_suspended() => return None,
        // A job that has not begun is suspended before its first move instead.
        Function::StartJob if jobs.begun() > 0 && filament.is_missing(config).is_some() => {
            filament.must_be_there(machine.texts, config).map(|()| Answer::Ok)
        }
        Function::StartJob => {
            let is_back = jobs.begun() > 0 && !jobs.is_playing();
            let started = jobs.start(machine.texts, ports, reply);
            if is_back && started.is_ok() {
                reply.tell_hosts("resumed");
            }
            journal.reopen(ports);
            started
        }
        Function::PauseJob => {
            if jobs.is_playing() {
                jobs.set_paused(true);
                reply.tell_hosts("paused");
            }
            Ok(Answer::Ok)
        }
        Function::RestartJob if words.get('S').is_some_and(|offset| offset > 0.0) => Err(Failure::refused(
            &"M26 S: play file --from byte N begins there, with modes and E as the file has them by then",
        )),
        Function::RestartJob => {
            let restarted = jobs.restart(machine.texts, ports);
            if restarted.is_ok() {
                program.end_program();
            }
            restarted
        }
        Function::PowerLoss => {
            if let Some(on) = words.get('S') {
                journal.is_on = on != 0.0;
            }
            reply.say(format_args!("power-loss recovery is {}\n", if journal.is_on { "on" } else { "off" }));
            Ok(Answer::Ok)
        }
        Function::Upload => match to {
            Recipient::Session(session) => files.begin_upload(session, name.unwrap_or(""), ports, reply),
            _ => Err(Failure::refused(&"only a session can upload a file")),
        },
        Function::EndUpload => Ok(Answer::Ok),
        Function::RemoveFile => files.remove(name.unwrap_or(""), ports, reply),
        Function::DeleteGrid => leveling::delete(machine.texts, config, ports, bed, words, reply),
        Function::ForgetSettings => settings_file::forget(machine.texts, ports, reply, dialect),
        _ => return None,
    })
}

// --- questions ---

/// Reports the status (`?`). A function of its own in the image too: the virtual board's tests put faults
/// there.
#[inline(never)]
pub(super) fn report_status<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    let (progress, dialect) = (job_progress(machine), machine.sessions.dialect_of(to));
    let Machine { ports, program, safety, sessions, config, .. } = machine;
    let of = Status { mode: safety.mode(), program, config, dialect, progress };
    reports::status(ports, &of, &mut Reply::new(sessions, to));
}

/// Returns seconds and percent of the job, when there is one.
pub(super) fn job_progress<P: Ports>(machine: &mut Machine<'_, P>) -> Option<(u64, u64)> {
    machine.follow_job();
    machine.jobs.progress(machine.ports.now())
}

/// Answers a line that is one question. False for every other line.
pub(super) fn answer<P: Ports>(machine: &mut Machine<'_, P>, mut blocks: Blocks<'_>, to: Recipient) -> bool {
    let (Some(Ok(block)), None) = (blocks.next(), blocks.next()) else { return false };
    let Some((row, function, words)) = machine.program.question(&block, machine.sessions.dialect_of(to)) else {
        return false;
    };
    if !row.states.has(machine.safety.state()) {
        return false;
    }
    match say_or_set(machine, function, &words, to) {
        Some(Ok(Answer::Said)) => true,
        Some(Ok(Answer::Ok)) => {
            machine.say(to, format_args!("ok\n"));
            true
        }
        // Faults of the question are told in its turn.
        _ => false,
    }
}
