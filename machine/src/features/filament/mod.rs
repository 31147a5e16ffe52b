//! Filament: its detector, and how M600, M701 and M702 move filament and the tool.

pub(crate) mod cold_extrusion;

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::{Recipient, Reply};
use base::tuning::Tuning;
use base::{Ports, World};
use config::{FilamentChangeConfig, MachineConfig};
use motion::Mode;
use parts::filament::{News, Use, WidthNews};
use program::{Interpreter, Move, State, Tool, Words};
use units::{Axis, Celsius, HeaterId, Micros, Mm, MmPerSecond};

use crate::features::state::States;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;
use crate::machine::source::Source;
use crate::machine::{Machine, suspend};

/// Filament at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn each_250_us(machine: &mut Machine<'_, P>, _now: Micros) {
        count(machine);
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        if machine.world.config.filament_detector.enable || machine.world.config.filament_width.enable {
            watch(machine, now);
        }
    }

    fn line(machine: &Machine<'_, P>) -> Option<&'static str> {
        machine.features.filament.has_command().then_some("M600")
    }

    fn take_line(machine: &mut Machine<'_, P>) -> Option<&'static str> {
        machine.features.filament.take_command(&machine.tuning)
    }

    fn hold_moves_back(machine: &Machine<'_, P>) -> bool {
        machine.world.config.filament_width.enable && is_planned_ahead(machine)
    }

    fn block_begins(machine: &mut Machine<'_, P>, _source: Source) {
        if machine.world.config.filament_width.enable {
            correct_flow(machine);
        }
    }

    fn may_move(machine: &mut Machine<'_, P>, request: &Move) -> Result<(), Failure> {
        let Machine { world, program, tuning, .. } = machine;
        cold_extrusion::may_extrude(world, program, tuning, request)
    }

    fn job_may_begin(machine: &mut Machine<'_, P>) -> bool {
        // With a detector about to ask, the job is suspended before its first move.
        !machine.features.filament.is_about_to_ask(machine.world.config)
    }

    fn suspend(machine: &mut Machine<'_, P>, heaters_stay: bool, words: &Words<'_>, to: Recipient) -> Option<Outcome> {
        Some(change_filament(machine, heaters_stay, words, to))
    }

    fn may_resume(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
        machine.features.filament.must_be_there(machine.world.texts, machine.world.config)
    }

    fn before_going_back(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
        match machine.jobs.suspended().and_then(|suspended| suspended.change) {
            Some(change) => come_back(machine, &change),
            None => Ok(()),
        }
    }

    fn goes_back(machine: &mut Machine<'_, P>) {
        forget_width(&mut machine.features, &machine.tuning);
    }

    fn extruders_count_anew(machine: &mut Machine<'_, P>) {
        machine.features.filament.counts_anew();
    }

    fn job_is_dropped(machine: &mut Machine<'_, P>) {
        machine.features.filament.forget();
    }
}

/// Counts the pulses of the filament's wheel, where there is one.
fn count<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.world.config.filament_detector.wheel_pin().is_some() {
        let levels = machine.world.ports.inputs();
        machine.features.filament.count(levels);
    }
}

/// Looks at the detector.
fn watch<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let using = match machine.safety.state() {
        _ if machine.jobs.is_suspended() => Use::Rests,
        State::Alarm | State::Sleep | State::Invalid => return machine.features.filament.forget(),
        _ if machine.jobs.is_playing() => Use::Plays,
        _ if machine.jobs.is_open() => Use::Rests,
        State::Run => Use::Moves,
        _ => Use::Idle,
    };
    if machine.world.config.filament_width.enable {
        measure(machine, using, now);
    }
    let Machine { tuning, program, features: States { filament, .. }, world: World { ports, config, .. }, .. } =
        machine;
    let levels = ports.inputs();
    let axis = program.tools().active().map(|tool| tool.settings.axis);
    let extruder = || axis.map(|axis| (axis, ports.motion(|motion| motion.live_position())[axis]));
    match filament.look(levels, config, tuning, using, extruder, now) {
        Some(News::Suspends(trouble)) => {
            let text = trouble.text();
            machine.announce(format_args!("// Filament Detector: {text}: the job is being suspended\n"));
        }
        Some(News::Noted(trouble)) => machine.announce(format_args!("// NOTE {}\n", trouble.text())),
        None => {}
    }
}

/// Measures the width of filament, and tells its faults.
fn measure<P: Ports>(machine: &mut Machine<'_, P>, using: Use, now: Micros) {
    let sensor = machine.tuning.filament_width;
    let Some(axis) = measured_tool(&machine.program, machine.world.config).map(|tool| tool.settings.axis) else {
        return;
    };
    let readings = machine.world.ports.heat(|heat| heat.filament_width());
    let pushed = machine.world.ports.motion(|motion| motion.live_position())[axis];
    let news = machine.features.filament_width.look(&sensor, readings, pushed, now);
    machine.features.filament.note_width(machine.features.filament_width.trouble());
    match news {
        Some(WidthNews::Lost(why)) => machine.announce(format_args!(
            "ERROR: filament width sensor: ADC1_{} gives no signal ({:.0} of 10000): the flow is not corrected\n",
            why.input.0, why.raw
        )),
        Some(WidthNews::Back) => machine.announce(format_args!("// NOTE the filament width sensor is back\n")),
        Some(WidthNews::Measured(_)) if using == Use::Rests => {}
        Some(WidthNews::Measured(width)) => machine.announce(format_args!("// Filament width: {:.3} mm\n", width.0)),
        None => {}
    }
}

/// Returns the extruder whose filament is measured.
fn measured_tool<'p>(program: &'p Interpreter, config: &MachineConfig) -> Option<&'p Tool> {
    program.tools().all().iter().find(|tool| tool.settings.id == config.filament_width.tool)
}

/// Scales what is extruded from here on to the filament that will be at the nozzle then: more for thinner
/// filament, less for thicker.
fn correct_flow<P: Ports>(machine: &mut Machine<'_, P>) {
    let sensor = &machine.tuning.filament_width;
    let Some(tool) = measured_tool(&machine.program, machine.world.config) else { return };
    let meant = tool.settings.filament_diameter.map_or(sensor.nominal, Mm);
    let pushed = machine.program.position()[tool.settings.axis];
    let factor = machine.features.filament_width.factor(sensor, pushed, meant);
    machine.program.set_width_factor(sensor.tool, factor);
}

/// Whether moves are planned as far ahead as the filament is measured: more must wait, as for room in the
/// queue. The motors go on meanwhile, so it comes to an end.
fn is_planned_ahead<P: Ports>(machine: &Machine<'_, P>) -> bool {
    let Some(tool) = measured_tool(&machine.program, machine.world.config) else { return false };
    let pushed = machine.program.position()[tool.settings.axis];
    machine.features.filament_width.is_to_come(&machine.tuning.filament_width, pushed)
}

/// Forgets measured widths: filament was taken out, or another one put in.
fn forget_width(states: &mut States, tuning: &Tuning) {
    states.filament_width.forget(&tuning.filament_width);
}

/// Returns the axis of the extruder in use.
///
/// # Errors
/// When there is none.
fn extruder(program: &Interpreter) -> Result<Axis, Failure> {
    let axis = program.tools().active().map(|tool| tool.settings.axis);
    axis.ok_or_else(|| Failure::refused(&"there is no extruder whose filament could be changed"))
}

/// Pushes filament, or draws it back, and waits for its end.
fn push<P: Ports>(machine: &mut Machine<'_, P>, length: f64, rate: MmPerSecond) -> Result<(), Failure> {
    if length == 0.0 {
        return Ok(());
    }
    let axis = extruder(&machine.program)?;
    let hands = &mut MachineHands::new(machine, Recipient::Nobody);
    let mut target = hands.position();
    target[axis] += length;
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}

/// M600: suspends the job, and takes the filament out, as far as its words and [filament change] say.
fn change_filament<P: Ports>(
    machine: &mut Machine<'_, P>,
    heaters_stay: bool,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    if suspend::is_already(&machine.jobs, &mut machine.world, to) {
        return Ok(Answer::Ok);
    }
    let change = change(machine, words)?;
    suspend::begin(machine, to)?;
    let mut targets = suspend::targets(&mut machine.world.ports);
    if let Some((heater, target)) = change.goes_on_with
        && let Some(to) = targets.get_mut(heater.index())
    {
        *to = target;
    }
    let lengths = unless_cold(machine, change.lengths);
    let moved = moves_anything(&lengths).then_some(lengths);
    suspend::keep(machine, targets, moved);
    if let Some(lengths) = &moved {
        // The job is suspended all the same where filament or tool cannot move.
        let left = leave(machine, lengths);
        machine.resynchronise_if_still();
        match left {
            Err(why) if why.is_refusal() => {
                machine.announce(format_args!("// WARNING {}\n", machine.world.texts.of(why)))
            }
            left => left?,
        }
    }
    suspend::rest(&mut machine.world, &mut machine.frames, heaters_stay)
}

/// Parameters of a filament change (M600).
#[derive(Clone, Copy, Debug)]
struct Change {
    pub lengths: FilamentChangeConfig,
    /// Another temperature of the tool's heater that the job goes on with.
    pub goes_on_with: Option<(HeaterId, Celsius)>,
}

/// Returns the change as configured, but for the words of M600. Marlin takes E, U and L with either sign.
///
/// # Errors
/// For another tool than the one in use, and for a place that is out of reach.
fn change<P: Ports>(machine: &Machine<'_, P>, words: &Words<'_>) -> Result<Change, Failure> {
    let tool = machine.program.tools().active().map(|tool| tool.settings.id);
    if let Some(wanted) = words.get('T')
        && tool.is_none_or(|tool| f64::from(tool.0) != wanted)
    {
        return Err(Failure::refused(&"M600 T: select this tool first, with T"));
    }
    let mut lengths = machine.tuning.filament_change;
    let length = |letter, as_ever| words.get(letter).map_or(as_ever, |length: f64| Mm(length.abs()));
    lengths.retract = length('E', lengths.retract);
    lengths.lift = length('Z', lengths.lift);
    lengths.unload = length('U', lengths.unload);
    lengths.load = length('L', lengths.load);
    for (place, letter) in lengths.park.iter_mut().zip(['X', 'Y']) {
        *place = words.get(letter).map(Mm).or(*place);
    }
    let heater = tool.and_then(|tool| machine.world.config.heater_with(tool));
    let goes_on_with = heater.zip(words.get('R').map(|celsius| Celsius(celsius as f32)));
    Ok(Change { lengths, goes_on_with })
}

/// Leaves only the parking of M600 if its nozzle is too cold to feed filament.
fn unless_cold<P: Ports>(machine: &mut Machine<'_, P>, change: FilamentChangeConfig) -> FilamentChangeConfig {
    let feeds = [change.retract, change.unload, change.load, change.purge].iter().any(|length| length.0 > 0.0);
    match cold_extrusion::may_feed(&mut machine.world, &machine.program, &machine.tuning, -1.0) {
        Err(why) if feeds => {
            machine.announce(format_args!("// WARNING {}: M600 leaves the filament in\n", machine.world.texts.of(why)));
            let nothing = Mm(0.0);
            FilamentChangeConfig { retract: nothing, unload: nothing, load: nothing, purge: nothing, ..change }
        }
        _ => change,
    }
}

/// Whether filament or the tool is moved.
fn moves_anything(change: &FilamentChangeConfig) -> bool {
    let lengths = [change.retract, change.lift, change.unload, change.load, change.purge];
    lengths.iter().any(|length| length.0 > 0.0) || change.park.iter().any(Option::is_some)
}

/// Leaves the part for M600, once nothing moves: draws back, lifts, goes to the tool's waiting place, and
/// takes the filament out, as far as the configuration says.
fn leave<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    machine.announce(format_args!("// Going aside, so that the filament can be changed\n"));
    push(machine, -change.retract.0, change.unload_rate)?;
    park(machine, change)?;
    unload(machine, change.unload)
}

fn park<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    let from = machine.world.ports.motion(|motion| motion.commanded_position());
    let mut above = from;
    above[Axis::Z] += change.lift.0;
    if change.lift.0 > 0.0 {
        if machine.stays_within(&from, &above).is_err() {
            machine.announce(format_args!("// NOTE there is no room to lift the tool: it stays where it is\n"));
            return Ok(());
        }
        MachineHands::new(machine, Recipient::Nobody).go(above, change.park_rate, Mode::Rapid)?;
    }
    let mut away = above;
    for (axis, place) in [Axis::X, Axis::Y].into_iter().zip(change.park) {
        away[axis] = place.map_or(away[axis], |place| place.0);
    }
    if away == above {
        return Ok(());
    }
    let is_homed = [Axis::X, Axis::Y].into_iter().all(|axis| machine.axes.homed().has(axis));
    if !is_homed || machine.stays_within(&above, &away).is_err() {
        machine.announce(format_args!(
            "// NOTE the tool does not go aside: X and Y are not homed, or it is out of travel\n"
        ));
        return Ok(());
    }
    let hands = &mut MachineHands::new(machine, Recipient::Nobody);
    hands.go(away, change.park_rate, Mode::Rapid)?;
    hands.standstill()
}

/// Lifts and parks the tool (G27).
pub(crate) fn go_aside<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>) -> Outcome {
    if words.get('P') == Some(1.0) {
        return Err(Failure::refused(
            &"G27 P1: the tool is lifted by [filament change] lift, from where it is: leave P out",
        ));
    }
    let change = machine.tuning.filament_change;
    if change.lift.0 <= 0.0 && change.park.iter().all(Option::is_none) {
        return Err(Failure::refused(&"G27: where to? [filament change] has no lift, park_x and park_y"));
    }
    machine.standstill()?;
    let parked = park(machine, &change);
    machine.standstill()?;
    machine.resynchronise();
    parked.map(|()| Answer::Ok)
}

fn unload<P: Ports>(machine: &mut Machine<'_, P>, length: Mm) -> Result<(), Failure> {
    let rate = machine.tuning.filament_change.unload_rate;
    if length.0 > 0.0 {
        machine.announce(format_args!("// Taking {} mm of filament out\n", length.0));
    }
    push(machine, -length.0, rate)
}

/// Pushes new filament in, or the filament drawn back, before the job goes on, once the nozzle is hot.
fn come_back<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    if change.unload.0 == 0.0 && change.load.0 == 0.0 {
        push(machine, change.retract.0, change.unload_rate)?;
        return push(machine, change.purge.0, change.purge_rate);
    }
    load(machine, change.load)
}

fn load<P: Ports>(machine: &mut Machine<'_, P>, length: Mm) -> Result<(), Failure> {
    let change = machine.tuning.filament_change;
    if length.0 > 0.0 {
        machine.announce(format_args!("// Pushing {} mm of filament in\n", length.0));
    }
    push(machine, length.0, change.load_rate)?;
    push(machine, change.purge.0, change.purge_rate)
}

/// Loads (M701, `loads`) or unloads (M702) filament, by `length` or else as M603 says. The operator sees to a
/// hot nozzle, or [`super::cold_extrusion`] does where that was asked for.
pub(crate) fn by_hand<P: Ports>(machine: &mut Machine<'_, P>, loads: bool, length: Option<f64>) -> Outcome {
    extruder(&machine.program)?;
    machine.standstill()?;
    let change = machine.tuning.filament_change;
    let length = length.map_or(if loads { change.load } else { change.unload }, Mm);
    if length.0 == 0.0 {
        let text = if loads { "M701: how far? Give L, or set M603 L" } else { "M702: how far? Give U, or set M603 U" };
        return Err(machine.world.texts.because(text));
    }
    cold_extrusion::may_feed(
        &mut machine.world,
        &machine.program,
        &machine.tuning,
        if loads { length.0 } else { -length.0 },
    )?;
    if loads {
        load(machine, length)?
    } else {
        unload(machine, length)?
    }
    forget_width(&mut machine.features, &machine.tuning);
    machine.resynchronise();
    Ok(Answer::Ok)
}

/// Sets the lengths that are pushed in and taken out (M603); without words tells them.
pub(crate) fn lengths(tuning: &mut Tuning, words: &Words<'_>, reply: &mut Reply<'_>) -> Answer {
    let change = &mut tuning.filament_change;
    change.load = words.get('L').map_or(change.load, Mm);
    change.unload = words.get('U').map_or(change.unload, Mm);
    if words.is_bare() {
        reply.say(format_args!("M603 L{} U{}\n", change.load.0, change.unload.0));
    }
    Answer::Ok
}
