//! From reset to a machine that listens: configuration, motion, heat, wiring, drivers, in this order.
//!
//! Every fault of the configuration is told to every session with its line. An error switches off the part it
//! concerns; a fatal one leaves the machine safe: nothing is wired, nothing moves or heats, but sessions and
//! card work, so that the file can be mended over them.

use base::axes::{internal_motors, on_board_motors};
use base::failure::about_file;
use base::grbl::framing;
use base::motion_config::motion_config;
use base::needs::tell_what_is_off;
use base::own_frame::apart;
use base::paths::{CONFIG_PATH, OVERRIDE_PATH, Path};
use base::ports::{MotorDrivers, OpenMode, Start, StorageError, Wake};
use base::safe_file;
use base::safety::Event;
use base::sessions::{Recipient, Reply, Sessions};
use base::supervisor::{DriverTrouble, MOTOR_SUPPLY_OFF};
use base::{Ports, World};
use config::{BoardId, Diagnostic, MachineConfig, Reader, Summary};
use events::{Event as Happened, Text};
use heapless::Vec;
use procedures::leveling;
use thermal::{HeatControl, HeaterSettings};
use units::{Actuator, Micros};

use crate::machine::moments::{Features, Moments};
use crate::machine::{Machine, program_files, suspend};

/// Time within which the motor supply is read: two periods of the slow task, and its conversions.
const SUPPLY_READING_TIMEOUT: Micros = Micros::from_millis(250);
/// Notice of a configuration with errors for sessions that open later, in Smoothieware's words.
const CONFIG_NOTICE: &str = "There was an error detected in the config.ini\nPlease check the uart log\n";
/// Number of findings told one by one; the rest is counted.
const FINDINGS: usize = 12;

/// Result of reading the configuration.
pub(crate) struct Read {
    summary: Result<Summary, StorageError>,
    /// Time of the reading, from the card's mounting on.
    pub took: Micros,
}

/// Greets, reads the configuration and tells its faults.
pub(crate) fn read_config<P: Ports>(ports: &mut P, sessions: &mut Sessions, config: &mut MachineConfig) -> Read {
    sessions.configure(ports);
    greet(ports, sessions);
    let mut findings = Vec::new();
    let since = ports.now();
    let summary = apart(|| read_file(ports, config, &mut findings));
    let took = ports.now().since(since);
    let banner = <Features<P> as Moments<Machine<'_, P>>>::banner(config).unwrap_or(framing::BANNER);
    sessions.set_dialect(ports, config.general.usual_dialect(), banner);
    if let Err(why) = apart(|| ports.connect(&config.system)) {
        sessions.say(Recipient::All, format_args!("ERROR: USB does not work: {why}\n"));
    }
    report(ports, sessions, &findings, &summary);
    Read { summary, took }
}

fn greet<P: Ports>(ports: &mut P, sessions: &mut Sessions) {
    let (board, running) = (ports.board(), ports.running());
    let mut reply = Reply::new(sessions, Recipient::All);
    reply.say(format_args!("Velvet {} on Prime, board id {}\n", board.version, board.board_id));
    match &board.start {
        Start::Asked => {}
        Start::Watchdog => {
            reply.say(format_args!("WARNING: the watchdog reset the board: the firmware had stopped answering\n"));
        }
        Start::BrownOut => {
            reply.say(format_args!(
                "WARNING: the board's own supply had sagged and reset it: check the 24 V and 5 V supply\n"
            ));
        }
        Start::Ended(words) => reply.say(format_args!("WARNING: the firmware had ended itself: {words}\n")),
    }
    <Features<P> as Moments<Machine<'_, P>>>::greet(&running, &mut reply);
    if board.second_core_starts {
        reply.say(format_args!(
            "WARNING: the chip's second core (Cortex-M4) is set to start and may run anything: set the option byte BCM4 to \
             0, with STM32CubeProgrammer: STM32_Programmer_CLI -c port=SWD -ob BCM4=0\n"
        ));
    }
}

fn read_file<P: Ports>(
    ports: &mut P,
    config: &mut MachineConfig,
    findings: &mut Vec<Diagnostic, FINDINGS>,
) -> Result<Summary, StorageError> {
    ports.mount()?;
    ports.events().record(ports.now(), &Happened::CardMounted);
    // A power cut may have stopped a change half way.
    safe_file::settle(ports, CONFIG_PATH)?;
    let file = ports.open(CONFIG_PATH, OpenMode::Read)?;
    let board = BoardId::from_id(ports.board().board_id);
    let mut reader = Reader::new(config, board, findings);
    let mut chunk = [0; 512];
    loop {
        match ports.read(file, &mut chunk)? {
            0 => break,
            count => reader.feed(chunk.get(..count).unwrap_or(&[])),
        }
    }
    let summary = reader.finish();
    ports.close(file)?;
    Ok(summary)
}

/// Tells the findings in the configuration.
fn report<P: Ports>(
    ports: &mut P,
    sessions: &mut Sessions,
    findings: &Vec<Diagnostic, FINDINGS>,
    read: &Result<Summary, StorageError>,
) {
    for finding in findings {
        sessions.say(Recipient::All, format_args!("config.ini: {finding}\n"));
        drain(ports, sessions);
    }
    match read {
        Err(error) => {
            let text = about_file(CONFIG_PATH, error.text());
            sessions.say(Recipient::All, format_args!("ERROR: cannot read {text}\n"));
        }
        Ok(summary) => {
            let more = summary.total().saturating_sub(findings.len() as u32);
            if more > 0 {
                sessions.say(Recipient::All, format_args!("config.ini: and {more} more\n"));
            }
        }
    }
}

fn drain<P: Ports>(ports: &mut P, sessions: &mut Sessions) {
    while !sessions.have_taken_most(Recipient::All) {
        let now = ports.now();
        sessions.flush(ports, now);
        ports.report_alive();
        ports.heat(|heat| heat.executor_alive(now));
        ports.rest(Wake::Any);
    }
}

fn what_came_of(read: &Read) -> Happened {
    match &read.summary {
        Err(error) => Happened::ConfigurationUnreadable(Text::from(error.text())),
        Ok(summary) if summary.is_usable() => {
            Happened::ConfigurationRead { took_ms: read.took.millis() as u32, findings: summary.total() }
        }
        Ok(summary) => Happened::ConfigurationFlawed { errors: summary.errors + summary.fatals },
    }
}

/// Sets every part up from the configuration, and greets.
pub(crate) fn start<P: Ports>(machine: &mut Machine<'_, P>, read: Read) {
    machine.record(&what_came_of(&read));
    let usable = read.summary.is_ok_and(|summary| summary.is_usable());
    if usable {
        let Machine { world: World { config, sessions, .. }, .. } = machine;
        tell_what_is_off(config, &mut Reply::new(sessions, Recipient::All));
    }
    if usable && start_parts(machine) {
        Features::<P>::read_files(machine);
        program_files::load(&mut machine.world, &mut machine.program);
        if machine.world.config.general.config_override {
            // There need not be any. They are replayed once the machine listens.
            let path = Path::try_from(OVERRIDE_PATH).unwrap_or_default();
            match suspend::begin_replay(machine, &path, Recipient::All, false) {
                Ok(()) | Err(StorageError::NotFound) => {}
                Err(error) => machine.announce(format_args!("ERROR: {OVERRIDE_PATH}: {}\n", error.text())),
            }
        }
        Features::<P>::started(machine, true);
        machine.jobs.queue_boot_file(machine.world.config);
    } else {
        Features::<P>::started(machine, false);
        machine.safety.apply(Event::ConfigurationFails);
        machine.announce(format_args!(
            "There was a fatal error in the config.ini this must be fixed to continue\nOnly some shell commands are allowed \
             and sdcard access\n"
        ));
    }
    if !read.summary.is_ok_and(Summary::is_complete) {
        machine.world.sessions.notice = CONFIG_NOTICE;
    }
    for id in machine.world.sessions.ids() {
        // A session that has opened meanwhile is greeted at the first look.
        if machine.world.sessions.is_visited_anew(&machine.world.ports, id) || !machine.world.ports.inbox(id).is_open()
        {
            continue;
        }
        let greeting = machine.world.ports.profile(id).greeting;
        if let Some(session) = machine.world.sessions.get_mut(id) {
            session.greet(greeting);
        }
    }
}

/// Starts every part. False when a part cannot work: then nothing may.
fn start_parts<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let now = machine.world.ports.now();
    machine.safety.limits.configure(machine.world.config, now);
    let configured = configure_motion(&mut machine.world);
    let World { ports, config, sessions, .. } = &mut machine.world;
    leveling::configure(ports, config, &mut Reply::new(sessions, Recipient::All));
    if !(configured & configure_heat(&mut machine.world) & wire(&mut machine.world)) {
        return false;
    }
    Features::<P>::wired(machine);
    let levels = machine.world.ports.inputs();
    for output in machine.outputs.start(machine.world.config, levels) {
        // A switch takes any value.
        let _ = machine.world.ports.heat(|heat| heat.apply(output));
    }
    machine.world.ports.heat(HeatControl::enable_outputs);
    machine.world.ports.supervisor(|supervisor| supervisor.expect_fet_supply(true));
    await_supply_reading(&mut machine.world.ports, machine.world.config);
    configure_drivers(&mut machine.world);
    true
}

fn configure_motion<P: Ports>(world: &mut World<'_, P>) -> bool {
    let configured = match motion_config(world.config) {
        Ok(config) => world.ports.motion(|motion| motion.configure(config)),
        Err(solution) => {
            world.announce(format_args!(
                "ERROR: config.ini: the geometry of arm_solution {solution:?} fits no machine\n"
            ));
            return false;
        }
    };
    if let Err(error) = configured {
        world.announce(format_args!("ERROR: config.ini: {error}\n"));
    }
    configured.is_ok()
}

fn configure_heat<P: Ports>(world: &mut World<'_, P>) -> bool {
    let config = world.config;
    let all_fit = world
        .ports
        .heat(|heat| config.temperatures.iter().all(|heater| heat.add(HeaterSettings::from(heater)).is_some()));
    if !all_fit {
        world.announce(format_args!("ERROR: config.ini: more temperature controls than this board has\n"));
    }
    all_fit
}

fn wire<P: Ports>(World { ports, config, sessions, .. }: &mut World<'_, P>) -> bool {
    let mut report = |text: &str| sessions.say(Recipient::All, format_args!("ERROR: config.ini: {text}\n"));
    ports.wire(config, &mut report)
}

/// Lets the motor supply's monitor give its first reading: drivers without supply are not to be called
/// silent.
fn await_supply_reading<P: Ports>(ports: &mut P, config: &MachineConfig) {
    if !config.voltages.iter().any(|monitor| monitor.name == "vmotor") {
        return;
    }
    let since = ports.now();
    while ports.voltage("vmotor").is_none() && ports.now().since(since) < SUPPLY_READING_TIMEOUT {
        ports.report_alive();
        ports.rest(Wake::Any);
    }
}

/// Writes the drivers' registers and currents. Without motor supply they cannot answer; the supervisor does
/// it when the supply comes.
fn configure_drivers<P: Ports>(world: &mut World<'_, P>) {
    let internal = internal_motors(world.config);
    let check = world.config.motors.check_driver_errors;
    let on_board = on_board_motors(world.config);
    world.ports.supervisor(|supervisor| supervisor.configure(on_board, internal & !on_board, check));
    let supplied = world.ports.voltage("vmotor").is_none_or(|volts| volts >= MOTOR_SUPPLY_OFF);
    let awake = if supplied { internal } else { internal & !on_board };
    for motor in Actuator::of_bits(awake) {
        let current = world.config.actuators[motor].current;
        let set = world.ports.drivers(|drivers| {
            drivers.initialise(motor)?;
            current.map_or(Ok(None), |amps| drivers.set_current(motor, amps).map(Some))
        });
        if set.is_err() {
            world.ports.supervisor(|supervisor| supervisor.mark_told(motor, DriverTrouble::Silent));
            world.announce(format_args!(
                "ERROR: motor driver {} does not answer, check its supply and wiring\n",
                motor.name()
            ));
        }
    }
    world.ports.set_motor_power(true);
}
