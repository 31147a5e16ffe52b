//! Console commands: `help`, `version`, `play`, `$G` and the like.

use base::failure::{Answer, Failure, FailureKind, Outcome, ShortText, Texts, short};
use base::motors;
use base::needs::needs;
use base::own_frame::apart;
use base::ports::{Clock as _, DateTime, Disk, StorageError};
use base::sessions::{Listing, Recipient, Reply, SessionId};
use base::{Ports, World};
use config::MachineConfig;
use gcode::Blocks;
use jobs::files::Files;
use jobs::player::Jobs;
use parts::heat_codes;
use parts::outputs::Outputs;
use parts::reports::{self, Status};
use program::commands::{Command, CommandInfo, Question, asks_for_help, find};
use program::{Dialect, Interpreter, Part, State};
use units::Micros;

use crate::features::axis_tests::command;
use crate::features::forecast::ForecastHands;
use crate::features::functions::{Stating, StatusHands};
use crate::features::play_from::PlayFromHands;
use crate::features::{
    event_log, file_commands, forecast, functions, laser, macros, network, play_from, update, usb_disk,
};
use crate::machine::fast_forward_record::Until;
use crate::machine::hands::MachineHands;
use crate::machine::moments::{Features, Moments as _, Served as _};
use crate::machine::work_hands::MoveHands;
use crate::machine::{Machine, abort, card, homing, job_control, long_answers, suspend};

/// What questions on a console are answered with.
struct Asked<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    program: &'m Interpreter,
    outputs: &'m Outputs,
    /// Time of reading the configuration, from the card's mounting on.
    config_took: Micros,
}

/// The machine for questions on a console.
trait AskedHands<'c>: StatusHands<'c> + ForecastHands<'c> {
    /// Returns what questions are answered with.
    fn asked(&mut self) -> Asked<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> AskedHands<'c> for Machine<'c, P> {
    fn asked(&mut self) -> Asked<'_, 'c, P> {
        let Self { world, program, outputs, config_took, .. } = self;
        Asked { world, program, outputs, config_took: *config_took }
    }
}

/// The machine for commands about files that become jobs, or lines.
trait FileHands<'c>: PlayFromHands<'c> + ForecastHands<'c> {
    /// Returns the files.
    fn files(&mut self) -> &mut Files;

    /// Returns the files, the jobs that are played from them, and the world.
    fn files_and_jobs(&mut self) -> (&mut Files, &mut Jobs, &mut World<'c, Self::Ports>);
}

impl<'c, P: Ports> FileHands<'c> for Machine<'c, P> {
    fn files(&mut self) -> &mut Files {
        &mut self.files
    }

    fn files_and_jobs(&mut self) -> (&mut Files, &mut Jobs, &mut World<'c, P>) {
        (&mut self.files, &mut self.jobs, &mut self.world)
    }
}

/// Splits a line into the command word and its arguments.
fn split(line: &str) -> (&str, &str) {
    if let Some(rest) = line.strip_prefix("$J") {
        return ("$J", rest.trim_start_matches('=').trim());
    }
    let (word, arguments) = line.split_once([' ', '\t']).unwrap_or((line, ""));
    (word, arguments.trim())
}

/// Runs the line of a command.
///
/// # Errors
/// For an unknown command, for one that may not run now, and those of the command.
pub(crate) fn run<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Outcome {
    if let Some(outcome) = Features::<P>::run_console_line(machine, line, to) {
        return outcome;
    }
    let (word, arguments) = split(line);
    // Printers' hosts write these words in lower case; they are answered and do nothing.
    if matches!(word, "m23" | "m32" | "m117") {
        return Ok(Answer::Ok);
    }
    let Some(info) = find(word) else { return Err(unknown(machine.world.texts, line, word)) };
    if asks_for_help(arguments) {
        machine.say(to, format_args!("{} {} - {}\n", info.word, info.takes, info.help));
        return Ok(Answer::Ok);
    }
    may_run(machine.safety.state(), info)?;
    if info.is_for_owner {
        machine.world.owner_only(to, machine.jobs.rights())?;
    }
    machine.wait_for_door(info.states)?;
    if info.needs_card {
        card::at_rest(machine);
    }
    // A pause at a place further on is set in a file that is read over.
    let is_place = info.does == Command::Pause && !arguments.is_empty() && machine.passed.is_some();
    if info.acts && machine.safety.state() == State::Check && !is_place {
        return Ok(Answer::Ok);
    }
    carry_out(machine, info.does, arguments, to)
}

fn unknown(texts: &Texts, line: &str, word: &str) -> Failure {
    match program::commands::waits_for(word) {
        Some(part) => texts.refused(format_args!("{word} needs {part}")),
        None if line.starts_with('$') => Failure::refused(&"Invalid statement"),
        None => texts.refused(format_args!("Unsupported command - {line}")),
    }
}

fn may_run(state: State, info: &CommandInfo) -> Result<(), Failure> {
    match state {
        _ if info.states.has(state) => Ok(()),
        State::Invalid => Err(Failure::refused(&"the configuration has errors: mend config.ini and reset")),
        _ => Err(Failure::HALTED),
    }
}

/// Answers a line that is a question. False for every other line.
pub(crate) fn answer<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> bool {
    if Features::<P>::owns_console_line(machine, line, to) {
        // A feature's own commands wait for their turn.
        return false;
    }
    let (word, arguments) = split(line);
    let Some(info) = find(word) else { return false };
    let Command::Ask(question) = info.does else { return false };
    if asks_for_help(arguments) || !info.states.has(machine.safety.state()) {
        return false;
    }
    match tell(machine, question, arguments, to) {
        Ok(Answer::Ok) => machine.say(to, format_args!("ok\n")),
        Ok(_) => {}
        Err(text @ Failure { kind: FailureKind::Refused, .. }) => machine.refuse(to, text),
        Err(_) => return false,
    }
    true
}

/// Carries a command out. Each has a stack frame of its own: commands wait, and much is called from there.
fn carry_out<P: Ports>(machine: &mut Machine<'_, P>, command: Command, arguments: &str, to: Recipient) -> Outcome {
    use Command as C;
    match command {
        C::Ask(question) => tell(machine, question, arguments, to),
        C::File(file) => apart(|| file_commands::run(machine, file, arguments, to)),
        C::Date => apart(|| date(&mut machine.world, arguments, to)),
        C::Dialect => apart(|| speak(&mut machine.world, arguments, to)),
        C::Break => apart(|| event_log::stop_for_debugger(&mut machine.world, &machine.safety, to)),
        C::LendCard => apart(|| usb_disk::msc(&mut MachineHands::new(machine, to), arguments)),
        C::LoadSettings => apart(|| load(machine, arguments, to)),
        C::Check => apart(|| check(machine, arguments, to)),
        C::Play => play_file(machine, arguments, to),
        C::Queue => {
            let (files, jobs, world) = machine.files_and_jobs();
            apart(|| job_control::queue(jobs, files, world, arguments, to))
        }
        C::Pause => apart(|| job_control::pause(machine, arguments, to)),
        C::Suspend => apart(|| suspend::suspend(machine, arguments.starts_with(['l', 'h']), to)),
        C::Resume => suspend::resume(machine, to),
        C::Abort => apart(|| abort::abort(machine, to)),
        C::Preheat => apart(|| heat_codes::preheat(&mut MachineHands::new(machine, to), arguments)),
        C::Switch => apart(|| switch(&mut machine.world, &mut machine.outputs, arguments, to)),
        C::SetRegisters => apart(|| set_registers(&mut machine.world, arguments, to)),
        C::Fire => apart(|| laser::fire(machine, arguments, to)),
        C::Gpio => apart(|| parts::gpio::command(&mut MachineHands::new(machine, to), arguments)),
        C::Test => apart(|| command::run(&mut MachineHands::new(machine, to), arguments)),
        C::TuneDriver => apart(|| tune_driver(machine, arguments, to)),
        C::Home => apart(|| homing::home(machine, units::AxisSet::NONE, to)),
        C::Jog => apart(|| jog(machine, arguments, to)),
        C::Probe => apart(|| {
            let line = probe_line(machine.world.config, arguments)?;
            let dialect = machine.world.sessions.dialect_of(to);
            P::run_text(machine, line.as_str(), dialect, to)
        }),
        C::CheckMode => apart(|| machine.check_mode(to)),
        C::Password => apart(|| network::set_password(&mut MachineHands::new(machine, to), arguments)),
        C::Macros => apart(|| macros::reload::run(machine, arguments, to)),
        C::Sleep => machine.sleep().map(|()| Answer::Ok),
        C::Flash => apart(|| update::flash(&mut MachineHands::new(machine, to))),
        C::Dfu => apart(|| update::download(&mut MachineHands::new(machine, to))),
        C::Reset => {
            machine.say(to, format_args!("Reset will occur in 1 second\n"));
            machine.record(&events::Event::ResetAsked);
            machine.world.ports.request_reset();
            Ok(Answer::Ok)
        }
    }
}

/// Echoes text to the session that asks, or to the device at the auxiliary UART: `echo [-n] [-1] text`.
fn echo<P: Ports>(world: &mut World<'_, P>, arguments: &str, to: Recipient) -> Outcome {
    let (mut text, mut end, mut heard_by) = (arguments, "\n", to);
    loop {
        text = if let Some(rest) = text.strip_prefix("-n ") {
            end = "";
            rest
        } else if let Some(rest) = text.strip_prefix("-1 ") {
            let uart = &world.config.uart;
            if !uart.enable {
                return Err(Failure::refused(&"echo -1: [uart console] is not enabled"));
            }
            // The debug UART is 0, the others follow.
            heard_by = Recipient::Session(SessionId(1 + uart.channel));
            rest
        } else {
            break;
        };
    }
    world.say(heard_by, format_args!("{text}{end}"));
    Ok(Answer::Ok)
}

/// Sets or tells the dialect of a console: `dialect [name]`.
fn speak<P: Ports>(world: &mut World<'_, P>, name: &str, to: Recipient) -> Outcome {
    let is_grbl = world.config.general.grbl_mode;
    let known = Dialect::named(name).filter(|dialect| !is_grbl && *dialect != Dialect::Grbl);
    match (known, to.session().and_then(|id| world.sessions.get_mut(id))) {
        _ if name.is_empty() => {}
        (Some(dialect), Some(session)) => session.dialect = dialect,
        _ if is_grbl => return Err(Failure::refused(&"with grbl_mode every console speaks GRBL's dialect")),
        _ => return Err(Failure::refused(&"a console speaks smoothie, marlin, reprapfirmware or klipper")),
    }
    let spoken = world.sessions.dialect_of(to);
    world.say(to, format_args!("this console speaks {}'s dialect\n", spoken.name()));
    Ok(Answer::Ok)
}

/// Answers a question. Nothing here waits: the machine answers while it waits for something else.
fn tell<P: Ports>(machine: &mut Machine<'_, P>, question: Question, arguments: &str, to: Recipient) -> Outcome {
    match question {
        Question::Get => apart(|| get(machine, arguments, to)),
        Question::Progress => apart(|| progress(machine, arguments, to)),
        Question::Events => apart(|| event_log::tell(machine, arguments, to)),
        Question::Network => apart(|| network::tell(&mut machine.world, to)),
        Question::Echo => apart(|| echo(&mut machine.world, arguments, to)),
        Question::Help => apart(|| help(&mut machine.world, &machine.program, arguments, to)),
        Question::Unlock => {
            if machine.safety.is_halted() {
                machine.unlock(to);
            }
            Ok(Answer::Ok)
        }
        Question::Version
        | Question::Memory
        | Question::Modules
        | Question::Thermistors
        | Question::CalculateThermistor
        | Question::Modes
        | Question::ModesWithoutOk
        | Question::Offsets
        | Question::Switches => apart(|| report(machine, question, arguments, to)),
    }
}

/// Says what is. Some of these answers have no `ok`, as in Smoothieware.
fn report<'c>(hands: &mut impl AskedHands<'c>, question: Question, arguments: &str, to: Recipient) -> Outcome {
    let Asked { program, outputs, config_took, world: World { ports, sessions, config, texts }, .. } = hands.asked();
    let reply = &mut Reply::new(sessions, to);
    match question {
        Question::Version => reports::version(ports, config, reply),
        Question::Memory => reports::memory(ports, config_took, reply),
        Question::Modules => reports::modules(config, reply),
        Question::ModesWithoutOk => reports::modal(config, program, outputs, reply),
        Question::Switches => outputs.report(config, arguments, reply),
        Question::CalculateThermistor => return reports::thermistor_coefficients(texts, arguments, reply),
        Question::Thermistors => {
            reports::thermistors(reply);
            return Ok(Answer::Ok);
        }
        Question::Offsets => {
            reports::offsets(program, arguments.trim_start_matches('-').starts_with('v'), reply);
            return Ok(Answer::Ok);
        }
        _ => {
            reports::modal(config, program, outputs, reply);
            return Ok(Answer::Ok);
        }
    }
    Ok(Answer::Said)
}

fn set_registers<P: Ports>(
    World { ports, config, texts, sessions }: &mut World<'_, P>,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    motors::set_registers(texts, ports, config, arguments, &mut Reply::new(sessions, to))
}

fn progress<'c>(hands: &mut impl AskedHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    hands.follow_job();
    let time_left = forecast::time_left(&mut hands.forecast());
    let Stating { jobs, world, .. } = hands.stating();
    let now = world.ports.now();
    jobs.progress_command(arguments, now, &time_left, &mut world.reply(to));
    Ok(Answer::Ok)
}

/// Tells a value: `get pos|wcs|state|status|mode|steps|temp|volts`.
fn get<'c>(hands: &mut impl StatusHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let progress = functions::job_progress(hands);
    let Stating { program, mode, outputs, world: World { ports, sessions, config, .. }, .. } = hands.stating();
    let of = Status { mode, program, config, dialect: sessions.dialect_of(to), progress };
    reports::get(ports, &of, outputs, arguments, &mut Reply::new(sessions, to))
}

fn help<P: Ports>(world: &mut World<'_, P>, program: &Interpreter, about: &str, to: Recipient) -> Outcome {
    if about.is_empty() {
        return long_answers::begin(world, Listing::Help { line: 0 }, to);
    }
    if let Some(info) = find(about) {
        world.say(to, format_args!("{} {} - {}\n", info.word, info.takes, info.help));
        return Ok(Answer::Ok);
    }
    if let Some(row) = program::extended::find(about) {
        world.say(to, format_args!("{} {} - {}\n", row.name, row.takes, row.help));
        return Ok(Answer::Ok);
    }
    let dialect = world.sessions.dialect_of(to);
    let block = Blocks::new(about.as_bytes()).next().and_then(Result::ok);
    let row = block.as_ref().filter(|block| block.code.is_some()).and_then(|block| program.row(block, dialect));
    match row {
        Some(row) => {
            world.say(to, format_args!("{about} - {}\n", row.help));
            Ok(Answer::Ok)
        }
        None => Err(world.texts.refused(format_args!("nothing is known of {about}"))),
    }
}

/// Opens a file to be played; returns the answer, and the place from which the job is to begin, if not from
/// its first line.
fn play<P: Ports>(
    World { ports, sessions, config, texts }: &mut World<'_, P>,
    jobs: &mut Jobs,
    files: &mut Files,
    arguments: &str,
    to: Recipient,
) -> Result<(Answer, Option<Until>), Failure> {
    needs(texts, config, Part::Player, jobs.is_playing())?;
    if ports.disk() != Disk::Kept {
        return Err(texts.because(StorageError::Lent.text()));
    }
    let forced = arguments.strip_prefix("--force ").or_else(|| arguments.strip_suffix(" --force"));
    let (arguments, from) = play_from::split(forced.unwrap_or(arguments))?;
    let (was_open, now) = (jobs.is_open(), ports.now());
    let played = jobs.play_command(texts, files, arguments, now, ports, &mut Reply::new(sessions, to));
    if forced.is_some() && !was_open {
        jobs.force();
    }
    played.map(|answer| (answer, from.filter(|_| !was_open && jobs.is_open())))
}

fn load<'c>(hands: &mut impl FileHands<'c>, name: &str, to: Recipient) -> Outcome {
    if name.is_empty() {
        hands.say(to, format_args!("filename required\n"));
        return Ok(Answer::Ok);
    }
    let path = hands.files().absolute(name);
    if let Err(error) = suspend::begin_replay(hands, &path, to, true) {
        hands.say(to, format_args!("failed to load config override file {name}: {}\n", error.text()));
    }
    Ok(Answer::Ok)
}

fn date<P: Ports>(world: &mut World<'_, P>, arguments: &str, to: Recipient) -> Outcome {
    if arguments.is_empty() {
        let date = world.ports.date();
        world.say(to, format_args!("{date}\n"));
        return Ok(Answer::Ok);
    }
    let date = DateTime::parse(arguments).ok_or_else(|| Failure::refused(&"write date YYMMDDhhmmss"))?;
    if world.ports.set_date(date) { Ok(Answer::Ok) } else { Err(Failure::refused(&"the clock does not run")) }
}

fn play_file<'c>(hands: &mut impl FileHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let (files, jobs, world) = hands.files_and_jobs();
    match apart(|| play(world, jobs, files, arguments, to)) {
        Ok((_, Some(until))) => apart(|| play_from::begin(hands, until, to)),
        played => played.map(|(answer, _)| answer),
    }
}

fn tune_driver<'c>(hands: &mut impl MoveHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let tuned = procedures::driver_tuning::tune(&mut hands.sequence(to), arguments);
    hands.resynchronise_if_still();
    tuned
}

fn jog<'c>(hands: &mut impl MoveHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let e_axis = hands.program().tools().active().map(|tool| tool.settings.axis);
    let done = procedures::jog::jog(&mut hands.sequence(to), arguments, e_axis);
    hands.resynchronise();
    done
}

fn switch<P: Ports>(
    World { ports, sessions, config, texts }: &mut World<'_, P>,
    outputs: &mut Outputs,
    arguments: &str,
    to: Recipient,
) -> Outcome {
    let change = outputs.switch_command(texts, config, arguments, &mut Reply::new(sessions, to))?;
    if let Some(output) = change {
        // A switch takes any value.
        let _ = ports.heat(|heat| heat.apply(output));
    }
    Ok(Answer::Ok)
}

/// Returns the line that probes with G30's words, also where G30 means something else (`$P`).
fn probe_line(config: &MachineConfig, words: &str) -> Result<ShortText, Failure> {
    if !config.probe.enable {
        return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
    }
    let text = short(format_args!("G30 P1 {words}"));
    let mut blocks = Blocks::new(text.as_str().as_bytes());
    if !matches!((blocks.next(), blocks.next()), (Some(Ok(_)), None)) {
        return Err(Failure::refused(&"$P takes the words of G30"));
    }
    Ok(text)
}

/// Begins to look at a file: `check file`.
fn check<'c>(hands: &mut impl FileHands<'c>, name: &str, to: Recipient) -> Outcome {
    if name.is_empty() {
        return Err(Failure::refused(&"which file? check file"));
    }
    let path = hands.files().absolute(name.trim_matches('"'));
    forecast::check(&mut hands.forecast(), &path, to)
}
