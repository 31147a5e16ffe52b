//! What machines do beside moving: each function of the table of codes, led to its owner.
//!
//! Those that only say or set something never wait, and questions among them are answered at any waiting
//! point. The others are sequences.

use gcode::Blocks;
use program::{Function, State, Words};
use units::AxisSet;

use super::frames::Then;
use super::{Hands, Machine, objects, program_io, suspend};
use crate::failure::{Answer, Failure, Outcome, about_file};
use crate::files::{self, OVERRIDE_PATH, listings, safe_file};
use crate::grbl::hal;
use crate::ports::Ports;
use crate::reports::Status;
use crate::sessions::{Listing, Recipient, Reply, SessionId};
use crate::{arms, autotune, heat_codes, leveling, motion_codes, motors, probing, reports, saved_settings};

/// Does one, and waits for its end.
pub(super) async fn run<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: Words<'_>,
    to: Recipient,
) -> Outcome {
    if let Some(outcome) = say_or_set(machine, function, &words, to) {
        return outcome;
    }
    let is_checking = machine.safety.state() == State::Check;
    if stands_first(function, &words) {
        if is_checking {
            return Ok(Answer::Ok);
        }
        machine.standstill().await?;
    }
    if let Some(outcome) = set_standing(machine, function, &words, to) {
        return outcome;
    }
    // What is left moves, heats, or counts on having moved.
    if is_checking {
        return Ok(Answer::Ok);
    }
    let function = match function {
        Function::UseGrid if words.get('S') == Some(0.0) => Function::LevelingOff,
        // What was measured must not give way to what was saved once.
        Function::UseGrid
            if machine.ports.motion(|motion| motion.compensation().bed() != motion::compensation::Bed::Flat) =>
        {
            return Ok(Answer::Ok);
        }
        Function::UseGrid => Function::LoadGrid,
        function => function,
    };
    let hands = &mut Hands::new(machine, to);
    match function {
        Function::ProbeStrategy => probe_strategy(machine, &words, to).await,
        Function::ProbeRepeatability => probing::repeatability(hands, &words).await,
        Function::LevelingOff => leveling::level_off(hands).await,
        Function::SaveGrid => leveling::save_grid(hands).await,
        Function::LoadGrid => leveling::load_grid(hands).await,
        Function::GridPoint => leveling::grid_point(hands, &words).await,
        Function::BedPlane => leveling::bed_plane(hands, &words).await,
        Function::Skew => leveling::skew(hands, &words).await,
        Function::ArmSettings => arms::arm_settings(hands, &words).await.map(|()| Answer::Ok),
        Function::WaitForHeaters => heat_codes::wait_for_all(hands, &words).await.map(|()| Answer::Ok),
        Function::TunePid => autotune::tune_pid(hands, &words).await,
        Function::SaveSettings => save_settings(machine, words.text(), to).await,
        _ => Ok(Answer::Unknown),
    }
}

/// G29, G31 and G32. The scripts around a cartesian grid may hold any code, so they are run from here.
async fn probe_strategy<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> Outcome {
    match probing::prepare(&mut Hands::new(machine, to), words).await? {
        Some(shape) => {
            let [before, _] = &machine.config.probe_gcode;
            suspend::start_script(machine, before, Then::LevelByGrid(shape, to))
        }
        None => probing::strategy(&mut Hands::new(machine, to), words).await,
    }
}

/// Those that change what every step or filter means.
fn stands_first(function: Function, words: &Words<'_>) -> bool {
    match function {
        Function::StepsPerMm | Function::Microsteps => !words.is_bare(),
        Function::PressureAdvance => words.has('K') || words.has('S') || words.has('W'),
        Function::InputShaping => !words.is_bare(),
        Function::MotorsOff | Function::MotorPositions | Function::HomeOffsetsFromHere | Function::DriverRegister => {
            true
        }
        _ => false,
    }
}

/// What is done once nothing moves.
fn set_standing<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    let Machine { ports, program, sessions, axes, config, tuning, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    Some(match function {
        Function::Microsteps => motors::microsteps(ports, config, words, reply),
        Function::DriverRegister => motors::write_register(ports, config, words, reply),
        Function::MotorPositions => arms::motor_positions(ports, words),
        Function::HomeOffsetsFromHere => arms::home_offsets_from_here(ports, config, axes, tuning, words, reply),
        Function::StepsPerMm => motion_codes::steps_per_mm(ports, config, program.tools(), words, reply),
        Function::PressureAdvance => motion_codes::pressure_advance(ports, config, program.tools(), words, reply),
        Function::InputShaping => motion_codes::input_shaping(ports, words, reply),
        Function::MotorsOff => {
            let extruder = program.tools().active().map(|tool| tool.settings.axis).filter(|_| words.has('E'));
            let named = extruder.map_or(words.axes(), |axis| words.axes().with(axis));
            axes.disable(ports, if named.is_empty() { AxisSet::ALL } else { named });
            Ok(Answer::Ok)
        }
        _ => return None,
    })
}

/// What only says or sets something. `None` for what takes time.
fn say_or_set<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    motion_or_heat(machine, function, words, to)
        .or_else(|| report(machine, function, words, to))
        .or_else(|| file_or_job(machine, function, words, to))
}

fn motion_or_heat<P: Ports>(
    machine: &mut Machine<'_, P>,
    function: Function,
    words: &Words<'_>,
    to: Recipient,
) -> Option<Outcome> {
    if function == Function::SpeedFactor {
        let said = motion_codes::speed_factor(&mut machine.ports, words, &mut Reply::new(&mut machine.sessions, to));
        program_io::speed_factor_set(machine);
        return Some(said);
    }
    let now = machine.ports.now();
    let Machine { ports, program, sessions, safety, axes, bed, tuning, config, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    Some(match function {
        Function::MotorsOn => axes.enable(ports, config, tuning, now).map(ok),
        Function::AxisSpeeds => {
            let set = motion_codes::axis_speeds(ports, config, program, words, reply);
            set.map(|rate| {
                if let Some(rate) = rate {
                    program.set_seek_rate(rate);
                }
                Answer::Ok
            })
        }
        Function::MotorSpeeds => motion_codes::motor_speeds(ports, config, program.tools(), words, reply),
        Function::Accelerations => motion_codes::accelerations(ports, config, program.tools(), words),
        Function::CornerSettings => motion_codes::corner_settings(ports, words),
        Function::Jerk => motion_codes::jerk(ports, words),
        Function::Trims => arms::trims(tuning, words, reply).map(ok),
        Function::HomeOffsets => arms::home_offsets(tuning, words, reply).map(ok),
        Function::SoftEndstops => motion_codes::soft_endstops(&mut safety.travel, config, tuning, words, reply),
        Function::MotorMilliamps | Function::MotorAmps => {
            motors::motor_currents(ports, config, axes, tuning, words, reply)
        }
        Function::ProbeSettings => probing::probe_settings(tuning, words, reply),
        Function::ProbePoint => leveling::probe_point(bed, words, reply),
        Function::ProbeOffset => leveling::probe_offset(bed, words, reply),
        Function::MaximumTemperature => heat_codes::maximum_temperature(ports, config, words, reply),
        Function::PidGains => heat_codes::pid_gains(ports, config, words, reply),
        Function::Sensor => heat_codes::sensors(ports, config, tuning, words, reply),
        Function::DriverChopper => motors::describe_choppers(ports, config, words, reply),
        Function::DriverOption => motors::driver_option(ports, config, words, reply),
        Function::AlignSlave => Err(Failure::refused("G28.7 needs motors of one axis that turn alone (not there yet)")),
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
    let dialect = machine.sessions.dialect_of(to);
    let Machine { ports, program, sessions, axes, tuning, config, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    let code = words.code();
    Some(match function {
        Function::ReportTemperatures => {
            // The line begins with its `ok`.
            heat_codes::report_temperatures(ports, config, code.number, reply);
            Ok(Answer::Said)
        }
        Function::ReportPosition => reports::position(ports, config, program, code.subcode, reply),
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
        Function::FilamentDiameter => reports::filament_diameter(config, program.tools(), words, reply),
        Function::FlowFactor => reports::flow_factor(config, program.tools(), words, reply),
        Function::SayToAll => {
            let text = program::said_by_m118(words.text().unwrap_or(""));
            sessions.say(Recipient::All, format_args!("{text}\n"));
            Ok(Answer::Ok)
        }
        Function::RetractSettings | Function::RecoverSettings => Ok(Answer::Ok),
        Function::DriverStatus => describe_drivers(machine, words, to),
        Function::ShowGrid => begin_listing(machine, Listing::Grid { row: 0 }, to),
        Function::ShowSettings => {
            let loaded = if machine.settings_loaded { "config override loaded" } else { "No config override loaded" };
            machine.say(to, format_args!("// NOTE: {loaded}\n"));
            begin_listing(machine, Listing::Settings { part: 0 }, to)
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
            return Some(begin_listing(machine, listing, to));
        }
        Function::LoadSettings => return Some(load_settings(machine, words.text(), to)),
        Function::LabelObject => return Some(objects::label(machine, words.text().unwrap_or(""), to)),
        _ => {}
    }
    let now = machine.ports.now();
    let Machine { ports, sessions, files, jobs, config, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    let name = words.text();
    Some(match function {
        Function::Mount => files::commands::mount(ports, reply),
        Function::SelectFile => jobs.select(name, false, now, ports, reply),
        Function::StartFile => jobs.select(name, true, now, ports, reply),
        Function::StartJob => jobs.start(reply),
        Function::PauseJob => {
            let _was_open = jobs.set_paused(true);
            Ok(Answer::Ok)
        }
        Function::RestartJob => jobs.restart(ports),
        Function::ReportJob => {
            jobs.say_bytes(reply);
            Ok(Answer::Ok)
        }
        Function::Upload => match to {
            Recipient::Session(session) => files.begin_upload(session, name.unwrap_or(""), ports, reply),
            _ => Err(Failure::refused("only a session can upload a file")),
        },
        Function::EndUpload => Ok(Answer::Ok),
        Function::RemoveFile => files.remove(name.unwrap_or(""), ports, reply),
        Function::DeleteGrid => leveling::delete_grid(config, ports, reply),
        Function::ForgetSettings => {
            let removed = safe_file::remove(ports, OVERRIDE_PATH);
            match removed {
                Ok(()) => {
                    reply.say(format_args!("configuration override file deleted\n"));
                    Ok(Answer::Ok)
                }
                Err(error) => Err(Failure::Refused(about_file(OVERRIDE_PATH, error.text()))),
            }
        }
        _ => return None,
    })
}

// --- saved settings ---

fn load_settings<P: Ports>(machine: &mut Machine<'_, P>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = files::override_path(set)?;
    if let Err(error) = suspend::begin_replay(machine, &path, to, false) {
        machine.say(to, format_args!("failed to load configuration override {path}: {}\n", error.text()));
    }
    Ok(Answer::Ok)
}

/// Whatever moment the power goes, the file is the old one or the new one.
pub(super) async fn save_settings<P: Ports>(machine: &mut Machine<'_, P>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = files::override_path(set)?;
    let failed = |error: crate::ports::StorageError| Failure::Refused(about_file(&path, error.text()));
    let mut draft = safe_file::Draft::begin(&mut machine.ports, &path).map_err(failed)?;
    for part in 0..saved_settings::PARTS {
        let Machine { ports, program, config, tuning, bed, .. } = machine;
        let written = match saved_settings::part(part, ports, program, config, tuning, bed) {
            Ok(text) => draft.write(ports, text.as_bytes()).map(|_| ()),
            Err(_) => Err(crate::ports::StorageError::Full),
        };
        if let Err(error) = written {
            draft.give_up(&mut machine.ports);
            return Err(failed(error));
        }
        machine.serve();
        crate::wait::yield_once().await;
    }
    draft.finish(&mut machine.ports).map_err(failed)?;
    if path == OVERRIDE_PATH && !machine.config.general.config_override {
        machine.say(to, format_args!("WARNING: override will NOT be loaded on boot\n"));
    }
    machine.say(to, format_args!("Settings Stored to {path}\n"));
    Ok(Answer::Ok)
}

// --- questions and long answers ---

/// `?`. A function of its own in the image too: there the virtual board's tests put faults.
#[inline(never)]
pub(super) fn report_status<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    let (progress, dialect) = (job_progress(machine), machine.sessions.dialect_of(to));
    let Machine { ports, program, safety, sessions, config, .. } = machine;
    let of = Status { mode: safety.mode(), program, config, dialect, progress };
    reports::status(ports, &of, &mut Reply::new(sessions, to));
}

/// Seconds and percent of the job, when there is one.
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
        // What is wrong with it is said in its turn.
        _ => false,
    }
}

/// A long answer: given as fast as a session takes it, beside everything else. A file that is played has
/// nobody to read one.
pub(super) fn begin_listing<P: Ports>(machine: &mut Machine<'_, P>, listing: Listing, to: Recipient) -> Outcome {
    match to.session().and_then(|id| machine.sessions.get_mut(id)) {
        Some(session) => {
            session.listing = Some(listing);
            Ok(Answer::Said)
        }
        None => {
            listings::close(&listing, &mut machine.ports);
            Ok(Answer::Ok)
        }
    }
}

fn describe_drivers<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> Outcome {
    let motors = motors::named_drivers(words, machine.config)?;
    if !machine.ports.supervisor(|supervisor| supervisor.motor_supply_on()) {
        machine.say(to, format_args!("VMOT is off\n"));
    }
    begin_listing(machine, Listing::Drivers { motors, all: !words.has('P') && words.axes().is_empty() }, to)
}

/// The next piece of a long answer, when there is one and room for it.
pub(super) fn continue_listing<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    let Some(session) = machine.sessions.get_mut(id).filter(|session| session.has_room_for_listing()) else { return };
    let Some(mut listing) = session.listing.take() else { return };
    let to = Recipient::Session(id);
    if matches!(listing, Listing::Transfer) {
        return continue_transfer(machine, id);
    }
    if machine.sessions.take_stop(to) {
        // He waits for its end all the same.
        listings::close(&listing, &mut machine.ports);
        machine.say(to, format_args!("{}", listings::ending(&listing)));
        return settle(machine, id);
    }
    let more = piece(machine, &mut listing, to);
    match more {
        Ok(true) => {
            if let Some(session) = machine.sessions.get_mut(id) {
                session.listing = Some(listing);
            }
        }
        Ok(false) => {
            listings::close(&listing, &mut machine.ports);
            machine.say(to, format_args!("{}", listings::ending(&listing)));
        }
        Err(failure) => {
            listings::close(&listing, &mut machine.ports);
            if let Failure::Refused(text) | Failure::Alarm(text) = failure {
                machine.sessions.refuse(to, text.error, format_args!("{text}"));
            }
        }
    }
    settle(machine, id);
}

/// A console takes what it sends for a file from now on.
pub(super) fn begin_transfer<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    if let Recipient::Session(id) = to {
        machine.ports.inbox(id).set_raw(true);
    }
    begin_listing(machine, Listing::Transfer, to)
}

fn continue_transfer<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    let to = Recipient::Session(id);
    let now = machine.ports.now();
    let Machine { files, ports, sessions, .. } = machine;
    let directory = files.directory().clone();
    let goes_on = files.transfers.go_on(&directory, id, now, ports, &mut Reply::new(sessions, to));
    if goes_on {
        if let Some(session) = machine.sessions.get_mut(id) {
            session.listing = Some(Listing::Transfer);
        }
        return;
    }
    machine.ports.inbox(id).set_raw(false);
    machine.say(to, format_args!("ok\n"));
    settle(machine, id);
}

fn settle<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    if let Some(session) = machine.sessions.get_mut(id) {
        session.settle();
    }
}

/// Says one piece. True while there are more.
fn piece<P: Ports>(machine: &mut Machine<'_, P>, listing: &mut Listing, to: Recipient) -> Result<bool, Failure> {
    let now = machine.ports.now();
    let Machine { ports, program, sessions, config, tuning, bed, .. } = machine;
    let reply = &mut Reply::new(sessions, to);
    match listing {
        Listing::Settings { part } => {
            let text = saved_settings::part(*part, ports, program, config, tuning, bed);
            let text = text.map_err(|_| Failure::refused("the settings are too many to show"))?;
            reply.say(format_args!("{text}"));
            if *part == 1 {
                arms::say_line_cutting(tuning, reply);
            }
            *part += 1;
            Ok(*part < saved_settings::PARTS)
        }
        Listing::Grid { row } => {
            let more = leveling::grid_line(ports, config.leveling.grid.human_readable, *row, reply)?;
            *row += 1;
            Ok(more)
        }
        Listing::Help { line } => {
            let Some(command) = program::commands::COMMANDS.get(*line) else { return Ok(false) };
            reply.say(format_args!("{}\n", command.word));
            *line += 1;
            Ok(*line < program::commands::COMMANDS.len())
        }
        Listing::Enumeration { list, line } => {
            *line += 1;
            Ok(hal::list_line(*list, *line - 1, reply))
        }
        Listing::Drivers { motors, all } => {
            let Some(motor) = crate::axes::motors(*motors).next() else { return Ok(false) };
            *motors &= !motor.bit();
            motors::describe_driver(ports, motor, *all, reply);
            Ok(*motors != 0)
        }
        listing => listings::piece(listing, now, ports, reply),
    }
}
