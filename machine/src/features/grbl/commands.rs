//! GRBL's commands: lines that begin with `$`, and the bytes that act at once.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::grbl::framing::LOCKED;
use base::hands::Hands;
use base::motion_config::motion_config;
use base::reason::Reason;
use base::safety::{Event, Safety};
use base::sessions::{Consoles as _, Listing, Recipient, Reply, Rights, SessionId, Sessions};
use base::tuning::Tuning;
use base::{Ports, World};
use gcode::realtime::Realtime;
use gcode::{Blocks, Refusal};
use jobs::files::listings;
use parts::outputs::Outputs;
use program::{Dialect, Interpreter, State};
use units::{Axis, AxisSet};

use crate::features::grbl::hands::{GrblHands, Spoken};
use crate::features::grbl::numbered_settings::{Change, Setting, Sources};
use crate::features::grbl::reports::Ahead;
use crate::features::grbl::state::{HELP, Own, Text};
use crate::features::grbl::status::{self, Report};
use crate::features::grbl::{hal, jog, overrides, reports, stored};
use crate::machine::settings_file::SettingsHands;
use crate::machine::{long_answers, program_files, program_io, settings_file};

/// Whether a line is a command of GRBL's own. GRBL has no `$P` and `$S`, and its jog is `$J=`: `$J` with a
/// blank is Smoothieware's, whose pendants go on working.
pub(crate) fn owns(sessions: &Sessions, line: &str, to: Recipient) -> bool {
    let is_jog = line.strip_prefix("$J ").is_some_and(|words| !words.trim_start().starts_with('='));
    let is_ours = is_jog || matches!(line.split_once([' ', '\t']).map_or(line, |(word, _)| word), "$P" | "$S");
    line.starts_with('$') && !is_ours && sessions.dialect_of(to) == Dialect::Grbl
}

/// Carries out a line that began with `$`, which has been taken off.
pub(crate) fn run<'c>(hands: &mut impl GrblHands<'c>, command: &str, to: Recipient) -> Outcome {
    hands.follow_motion();
    if let Some(words) = command.strip_prefix("J=") {
        let modal = hands.program().modal().clone();
        let jog = jog::read(hands.world().texts, words, &modal)?;
        let s = program::laser::constant_s(hands.program());
        let jogged = jog::jog(&mut hands.sequence(to), &jog, &modal, s);
        hands.resynchronise();
        return jogged.map(|()| Answer::Ok);
    }
    if command.contains('=') {
        // What is set is also saved.
        let job = hands.jobs().rights();
        hands.world().owner_only(to, job)?;
    }
    if let Some(axes) = command.strip_prefix('H') {
        return home(hands, axes, to);
    }
    if let Some(what) = command.strip_prefix("RST=") {
        return restore(hands, what, to);
    }
    if let Some((number, value)) = command.split_once('=')
        && let Ok(number) = number.parse()
    {
        return set(hands, number, value, to);
    }
    let has_more = hands.world().config.general.grblhal;
    let Spoken { world, program, safety, tuning, outputs, grbl, .. } = hands.spoken();
    match command {
        "" => world.say(to, format_args!("{HELP}")),
        "X" if safety.is_halted() => hands.unlock(to),
        "X" => {}
        "C" => return hands.check_mode(to).map_err(not_idle),
        "SLP" => {
            hands.sleep().map_err(not_idle)?;
            hands.say(to, format_args!("[MSG:Sleeping]\n"));
        }
        "$" => list(world, safety, tuning, (program, &grbl.own), to)?,
        "G" | "#" | "N" | "I" | "I+" if command != "I+" || has_more => {
            report(world, program, outputs, &grbl.own, command, to);
        }
        "EA" | "EE" | "EG" | "ES" if has_more => {
            let Some(list) = hal::list_named(command) else { return Ok(Answer::Ok) };
            return long_answers::begin(world, Listing::Enumeration { list, line: 0 }, to);
        }
        _ => match command.split_once('=') {
            Some((key @ ("N0" | "N1" | "I"), text)) => {
                may_set(safety.state())?;
                store(world, program, &mut grbl.own, key, text)?;
            }
            _ => {
                return Err(
                    Failure::refused(&"this $ command is not known: $ lists them").with_reason(Reason::Statement)
                );
            }
        },
    }
    Ok(Answer::Ok)
}

/// Reports modes, offsets, startup lines or the build: `$G`, `$#`, `$N`, `$I`.
fn report<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    outputs: &Outputs,
    own: &Own,
    what: &str,
    to: Recipient,
) {
    let World { ports, sessions, config, .. } = world;
    let (moves, version) = (ports.motion(|motion| motion.queue_level().1), ports.board().version);
    let ahead = Ahead { moves, bytes: ports.inbox(to.session().unwrap_or(SessionId(0))).capacity() };
    let reply = &mut Reply::new(sessions, to);
    match what {
        "G" => reports::modal(config, program, outputs, reply),
        "#" => reports::offsets(own, program, reply),
        "N" => reports::startup(own, reply),
        _ if config.general.grblhal => {
            reports::version(own, reply);
            hal::build(config, program, ahead, reply);
            if what == "I+" {
                hal::firmware(version, reply);
            }
            reports::short(version, reply);
        }
        _ => reports::build(config, own, version, ahead, reply),
    }
}

/// Sends GRBL's status report (`?`).
pub(crate) fn report_status<P: Ports>(spoken: Spoken<'_, '_, P>, id: SessionId) {
    let Spoken { world, program, safety, tuning, outputs, jobs, grbl, homed, .. } = spoken;
    let World { ports, sessions, config, .. } = world;
    let line = ports.motion(|motion| (!motion.is_idle()).then(|| motion.passed().tag));
    let line = line.and_then(|tag| jobs.line_of(tag));
    let room = ports.inbox(id).room();
    let Some(told) = grbl.told.get_mut(usize::from(id.0)) else { return };
    let of = Report {
        mode: safety.told_mode(),
        program,
        config,
        tuning,
        outputs,
        own: &grbl.own,
        spindle_percent: f64::from(outputs.spindle_percent()),
        line,
        room,
        homed,
        job: jobs.share(),
    };
    status::report(ports, &of, told, &mut Reply::new(sessions, Recipient::Session(id)));
}

// --- settings ---

/// Calls `f` with the sources that settings are read from.
fn with_sources<P: Ports, R>(
    World { ports, config, sessions, .. }: &mut World<'_, P>,
    safety: &mut Safety,
    tuning: &Tuning,
    (program, own): (&Interpreter, &Own),
    f: impl FnOnce(&Sources<'_>, &mut Sessions) -> R,
) -> Result<R, Failure> {
    let motion = ports.motion(|motion| motion.config().copied());
    let motion = motion.ok_or_else(|| Failure::refused(&"motion is not configured").with_reason(Reason::Locked))?;
    let travel = safety.travel.up_to_date(config, tuning);
    let (soft_limits, ends) = (travel.is_on(config), travel.ends());
    let laser = program::laser::of(program).map(|laser| (tuning.laser, laser.is_laser_mode));
    Ok(f(&Sources { motion: &motion, config, own, soft_limits, laser, ends: &ends }, sessions))
}

/// Lists all of GRBL's settings (`$$`).
fn list<P: Ports>(
    world: &mut World<'_, P>,
    safety: &mut Safety,
    tuning: &Tuning,
    own: (&Interpreter, &Own),
    to: Recipient,
) -> Result<(), Failure> {
    with_sources(world, safety, tuning, own, |of, sessions| {
        for setting in Setting::all() {
            let (value, decimals) = setting.value(of);
            sessions.say(to, format_args!("${}={value:.decimals$}\n", setting.number()));
        }
    })
}

/// Sets a setting, which acts and is saved at once (`$n=value`).
fn set<'c>(hands: &mut impl GrblHands<'c>, number: u16, value: &str, to: Recipient) -> Outcome {
    may_set(hands.state())?;
    let setting = Setting::of(number)
        .ok_or_else(|| Failure::refused(&"there is no such setting").with_reason(Reason::Statement))?;
    let Spoken { safety, tuning, grbl, world, program, .. } = hands.spoken();
    let texts = world.texts;
    let change = with_sources(world, safety, tuning, (program, &grbl.own), |of, _| setting.change(texts, value, of))??;
    match &change {
        Change::Nothing => {}
        Change::Own(set, value) => {
            set(&mut grbl.own, *value);
            save_own(world, &grbl.own)?;
        }
        Change::Switch(code) | Change::Code(code) => {
            // Numbers of the code are in mm.
            let inches = hands.program().count_in_mm();
            let outcome = hands.run_text(code.as_str());
            hands.program().count_in_inches(inches);
            outcome?;
        }
    }
    if let Change::Code(_) = change {
        save(hands, to)?;
    }
    Ok(Answer::Ok)
}

/// Refuses settings unless the machine does nothing.
fn may_set(state: State) -> Result<(), Failure> {
    match state {
        State::Idle | State::Alarm => Ok(()),
        _ => Err(Failure::refused(&"settings are changed from standstill").with_reason(Reason::NotIdle)),
    }
}

/// Saves what M500 saves.
fn save<'c>(hands: &mut impl SettingsHands<'c>, to: Recipient) -> Result<(), Failure> {
    if let Err(why) = settings_file::save(hands, None, Recipient::Nobody)
        && why.is_refusal()
    {
        return Err(why.with_reason(Reason::Storage));
    }
    if !hands.world().config.general.config_override {
        hands.say(to, format_args!("saved, but [general] config-override is off: the next reset forgets it\n"));
    }
    Ok(())
}

fn save_own<P: Ports>(world: &mut World<'_, P>, own: &Own) -> Result<(), Failure> {
    stored::write(&mut world.ports, own)
        .map_err(|error| world.texts.about_file(stored::PATH, error.text()).with_reason(Reason::Storage))
}

/// Stores a startup line, looked through, for the next boot or reset (`$N0=`, `$N1=`); or a text (`$I=`).
fn store<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    own: &mut Own,
    key: &str,
    text: &str,
) -> Result<(), Failure> {
    let text = text.trim();
    let too_long = |_| Failure::refused(&"80 characters are kept at most").with_reason(Reason::StoredLength);
    let kept = Text::try_from(text).map_err(too_long)?;
    if key != "I" {
        look_through(world.texts, program, text)?;
    }
    match key {
        "N0" => own.startup[0] = kept,
        "N1" => own.startup[1] = kept,
        _ => own.build = kept,
    }
    save_own(world, own)
}

/// Refuses a startup line that cannot be read, or with codes that nobody knows.
fn look_through(texts: &Texts, program: &Interpreter, text: &str) -> Result<(), Failure> {
    for block in Blocks::new(text.as_bytes()) {
        let block = block.map_err(|error| {
            let number = Reason::of_refusal(&Refusal::Syntax(error));
            texts.refused(format_args!("{error}")).with_reason(number)
        })?;
        let is_known = program.row(&block, Dialect::Grbl).is_some()
            || block.code.is_some_and(crate::features::grbl::state::accepts);
        if !is_known {
            return Err(Failure::refused(&"a startup line has only known codes"));
        }
    }
    Ok(())
}

/// Resets settings (`$RST=$`), offsets (`$RST=#`), or both and the startup lines (`$RST=*`).
fn restore<'c>(hands: &mut impl GrblHands<'c>, what: &str, to: Recipient) -> Outcome {
    may_set(hands.state())?;
    if !matches!(what, "$" | "#" | "*") {
        return Err(
            Failure::refused(&"$RST=$ restores settings, $RST=# offsets, $RST=* all").with_reason(Reason::Statement)
        );
    }
    if what != "#" {
        let Spoken { grbl, world, .. } = hands.spoken();
        if what == "*" {
            grbl.own = Own::default();
        }
        (grbl.own.report_mask, grbl.own.inches) = (1, false);
        save_own(world, &grbl.own)?;
        restore_motion(&mut hands.sequence(to))?;
    }
    if what != "$" {
        hands.program().clear_offsets();
        program_files::save_unless_playing(hands);
    }
    save(hands, to)?;
    hands.say(to, format_args!("[MSG:Restoring defaults]\n"));
    Ok(Answer::Ok)
}

/// Puts steps and limits back as `config.ini` has them.
fn restore_motion<'c>(hands: &mut impl Hands<'c>) -> Result<(), Failure> {
    hands.standstill()?;
    let config = motion_config(hands.config()).map_err(|_| Failure::refused(&"the geometry fits no machine"))?;
    let configured = hands.motion(|motion| motion.configure(config));
    configured.map_err(|error| hands.texts().refused(format_args!("{error}")))
}

// --- the rest ---

/// Numbers a refusal as one because the machine is not idle.
fn not_idle(failure: Failure) -> Failure {
    if failure.is_refusal() { failure.with_reason(Reason::NotIdle) } else { failure }
}

/// Homes (`$H`, `$HX` and so on), and ends an alarm, too.
fn home<'c>(hands: &mut impl GrblHands<'c>, axes: &str, to: Recipient) -> Outcome {
    let mut named = AxisSet::NONE;
    for letter in axes.chars() {
        let axis = Axis::from_letter(letter.to_ascii_uppercase());
        let unknown = || Failure::refused(&"$H homes all axes, $HX, $HY and $HZ one").with_reason(Reason::Statement);
        named = named.with(axis.ok_or_else(unknown)?);
    }
    if hands.can_home().is_empty() {
        return Err(Failure::refused(&"no endstop has a homing_direction: [endstops]").with_reason(Reason::NotEnabled));
    }
    match hands.state() {
        State::Idle | State::Suspended => {}
        // Check mode only reads the command.
        State::Check => return Ok(Answer::Ok),
        State::Alarm => {
            hands.release();
        }
        _ => return Err(Failure::refused(&"homing begins from standstill").with_reason(Reason::NotIdle)),
    }
    crate::machine::homing::home(hands, named, to)
}

/// Whether the machine jogs, for a session of this dialect: then only jogs are taken.
pub(crate) fn jogs<'c>(hands: &mut impl GrblHands<'c>, to: Recipient) -> bool {
    if hands.state() != State::Jog || hands.sessions().dialect_of(to) != Dialect::Grbl {
        return false;
    }
    hands.follow_motion();
    hands.state() == State::Jog
}

/// Resets (Ctrl-X): stops all work, drops lines that were sent, and greets anew. No alarm if nothing goes on,
/// or a hold has come to rest.
pub(crate) fn reset<'c>(hands: &mut impl GrblHands<'c>, id: SessionId) {
    hands.follow_motion();
    let World { sessions, ports, .. } = hands.world();
    if let Some(session) = sessions.get_mut(id) {
        session.reset(ports.inbox(id));
        if let Some(listing) = session.listing.take() {
            listings::close(&listing, ports);
        }
    }
    hands.apply(Event::CheckEnds);
    hands.stop();
    hands.program().reset();
    hands.resynchronise();
    program_io::reset_overrides(hands.overrides());
    hands.begin_startup();
    let Spoken { safety, world, .. } = hands.spoken();
    let halted = safety.is_halted() && !safety.is_resetting();
    if let Some(session) = world.sessions.get_mut(id) {
        let banner = session.grbl_banner;
        session.announce(format_args!("{banner}{}", if halted { LOCKED } else { "" }));
    }
}

/// Carries out a byte that changes an override or an output.
pub(crate) fn change<P: Ports>(spoken: Spoken<'_, '_, P>, request: Realtime, id: SessionId) {
    let Spoken { world, safety, outputs, feed_waits, .. } = spoken;
    let operates = world.sessions.get(id).is_some_and(|session| session.rights >= Rights::Operate);
    if !operates || safety.is_halted() {
        return;
    }
    let factors = world.ports.motion(|motion| motion.overrides());
    match request {
        Realtime::FeedReset | Realtime::FeedUp10 | Realtime::FeedDown10 | Realtime::FeedUp1 | Realtime::FeedDown1 => {
            let percent =
                overrides::changed(libm::round(program_io::feed(&mut world.ports, *feed_waits) * 100.0), request);
            program_io::set_feed(&mut world.ports, feed_waits, percent / 100.0);
        }
        Realtime::RapidFull | Realtime::RapidHalf | Realtime::RapidQuarter => {
            let rapid = overrides::rapid(request) / 100.0;
            world.ports.motion(|motion| motion.set_overrides(factors.feed, rapid));
        }
        Realtime::SpindleStop => {
            // The spindle stops only in a hold: a tool that stands must not be moved on.
            if safety.state() == State::Hold {
                outputs.stop_spindle(!outputs.spindle_is_stopped());
            }
        }
        Realtime::Flood | Realtime::Mist => {
            let code = if request == Realtime::Flood { 8 } else { 7 };
            if matches!(safety.state(), State::Idle | State::Run | State::Hold | State::Suspended) {
                let change = outputs.turn_over(world.config, code);
                program_io::apply(&mut world.ports, change);
            }
        }
        spindle => {
            let percent = overrides::changed(f64::from(outputs.spindle_percent()), spindle);
            outputs.override_spindle(percent as f32);
        }
    }
    program_io::say_spindle(world, outputs);
}
