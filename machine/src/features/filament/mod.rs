//! Filament: its detector, and how M600, M701 and M702 move filament and the tool.

pub(crate) mod cold_extrusion;

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::{Recipient, Reply};
use base::tuning::Tuning;
use base::{Ports, World};
use config::{Command, FilamentChangeConfig, MachineConfig};
use jobs::player::Jobs;
use motion::Mode;
use parts::filament::{Filament, News, Use, Width, WidthNews};
use program::{Interpreter, Move, State, Tool, Words};
use units::{Axis, Celsius, HeaterId, Micros, Mm, MmPerSecond};

use crate::features::state::States;
use crate::machine::moments::Moments;
use crate::machine::source::Source;
use crate::machine::work_hands::JobHands;
use crate::machine::{Machine, suspend};

/// Sensors of filament, and what their readings are compared with.
pub(crate) struct Sensors<'m, 'c, P> {
    detector: &'m mut Filament,
    width: &'m mut Width,
    world: &'m mut World<'c, P>,
    program: &'m mut Interpreter,
    tuning: &'m Tuning,
}

/// The machine for work on filament.
pub(crate) trait FilamentHands<'c>: JobHands<'c> {
    /// Returns the filament's detector.
    fn detector(&mut self) -> &mut Filament;

    /// Returns the sensors of filament.
    fn sensors(&mut self) -> Sensors<'_, 'c, Self::Ports>;

    /// Returns the line that the detector would like to have run.
    fn wished(&self) -> Option<&str>;

    /// Whether moves are planned as far ahead as the filament is measured: more must wait, as for room in the
    /// queue. The motors go on meanwhile, so it comes to an end.
    fn is_planned_ahead(&self) -> bool;
}

impl<'c, P: Ports> FilamentHands<'c> for Machine<'c, P> {
    fn detector(&mut self) -> &mut Filament {
        &mut self.features.filament
    }

    fn sensors(&mut self) -> Sensors<'_, 'c, P> {
        let Self { features: States { filament, filament_width, .. }, world, program, tuning, .. } = self;
        Sensors { detector: filament, width: filament_width, world, program, tuning }
    }

    fn wished(&self) -> Option<&str> {
        self.features.filament.line(self.world.config)
    }

    fn is_planned_ahead(&self) -> bool {
        if !self.world.config.filament_width.enable {
            return false;
        }
        let Some(tool) = measured_tool(&self.program, self.world.config) else { return false };
        let pushed = self.program.position()[tool.settings.axis];
        self.features.filament_width.is_to_come(&self.tuning.filament_width, pushed)
    }
}

/// Filament at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: FilamentHands<'c>> Moments<M> for Feature {
    fn each_250_us(hands: &mut M, _now: Micros) {
        count(&mut hands.sensors());
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        let config = hands.world().config;
        if config.filament_detector.enable || config.filament_width.enable {
            let using = used(hands.state(), hands.jobs());
            watch(&mut hands.sensors(), using, now);
        }
    }

    fn line(hands: &M) -> Option<&str> {
        hands.wished()
    }

    fn take_line(hands: &mut M) -> Option<Command> {
        let Sensors { detector, world, tuning, .. } = hands.sensors();
        detector.take_line(world.config, tuning)
    }

    fn hold_moves_back(hands: &M) -> bool {
        hands.is_planned_ahead()
    }

    fn block_begins(hands: &mut M, _source: Source) {
        if hands.world().config.filament_width.enable {
            correct_flow(hands.sensors());
        }
    }

    fn may_move(hands: &mut M, request: &Move) -> Result<(), Failure> {
        let Sensors { world, program, tuning, .. } = hands.sensors();
        cold_extrusion::may_extrude(world, program, tuning, request)
    }

    fn job_may_begin(hands: &mut M) -> bool {
        // With a detector about to ask, the job is suspended before its first move.
        let config = hands.world().config;
        !hands.detector().is_about_to_ask(config)
    }

    fn suspend(hands: &mut M, heaters_stay: bool, words: &Words<'_>, to: Recipient) -> Option<Outcome> {
        Some(change_filament(hands, heaters_stay, words, to))
    }

    fn may_resume(hands: &mut M) -> Result<(), Failure> {
        let Sensors { detector, world, .. } = hands.sensors();
        detector.must_be_there(world.texts, world.config)
    }

    fn before_going_back(hands: &mut M) -> Result<(), Failure> {
        match hands.jobs().suspended().and_then(|suspended| suspended.change) {
            Some(change) => come_back(hands, &change),
            None => Ok(()),
        }
    }

    fn goes_back(hands: &mut M) {
        forget_width(hands.sensors());
    }

    fn extruders_count_anew(hands: &mut M) {
        hands.detector().counts_anew();
    }

    fn job_is_dropped(hands: &mut M) {
        hands.detector().forget();
    }
}

/// Counts the pulses of the filament's wheel, where there is one.
fn count<P: Ports>(sensors: &mut Sensors<'_, '_, P>) {
    if sensors.world.config.filament_detector.wheel_pin().is_some() {
        let levels = sensors.world.ports.inputs();
        sensors.detector.count(levels);
    }
}

/// Returns how filament is used at present; none on a machine that is halted.
fn used(state: State, jobs: &Jobs) -> Option<Use> {
    Some(match state {
        _ if jobs.is_suspended() => Use::Rests,
        State::Alarm | State::Sleep | State::Invalid => return None,
        _ if jobs.is_playing() => Use::Plays,
        _ if jobs.is_open() => Use::Rests,
        State::Run => Use::Moves,
        _ => Use::Idle,
    })
}

/// Looks at the detector.
fn watch<P: Ports>(sensors: &mut Sensors<'_, '_, P>, using: Option<Use>, now: Micros) {
    let Some(using) = using else { return sensors.detector.forget() };
    if sensors.world.config.filament_width.enable {
        measure(sensors, using, now);
    }
    let Sensors { detector, world, program, tuning, .. } = sensors;
    let World { ports, config, .. } = &mut **world;
    let levels = ports.inputs();
    let axis = program.tools().active().map(|tool| tool.settings.axis);
    let extruder = || axis.map(|axis| (axis, ports.motion(|motion| motion.live_position())[axis]));
    match detector.look(levels, config, tuning, using, extruder, now) {
        Some(News::Suspends(trouble)) => {
            let text = trouble.text();
            world.announce(format_args!("// Filament Detector: {text}: the job is being suspended\n"));
        }
        Some(News::Noted(trouble)) => world.announce(format_args!("// NOTE {}\n", trouble.text())),
        None => {}
    }
}

/// Measures the width of filament, and tells its faults.
fn measure<P: Ports>(sensors: &mut Sensors<'_, '_, P>, using: Use, now: Micros) {
    let Sensors { detector, width, world, program, tuning } = sensors;
    let sensor = tuning.filament_width;
    let Some(axis) = measured_tool(program, world.config).map(|tool| tool.settings.axis) else { return };
    let readings = world.ports.heat(|heat| heat.filament_width());
    let pushed = world.ports.motion(|motion| motion.live_position())[axis];
    let news = width.look(&sensor, readings, pushed, now);
    detector.note_width(width.trouble());
    match news {
        Some(WidthNews::Lost(why)) => world.announce(format_args!(
            "ERROR: filament width sensor: ADC1_{} gives no signal ({:.0} of 10000): the flow is not corrected\n",
            why.input.0, why.raw
        )),
        Some(WidthNews::Back) => world.announce(format_args!("// NOTE the filament width sensor is back\n")),
        Some(WidthNews::Measured(_)) if using == Use::Rests => {}
        Some(WidthNews::Measured(width)) => world.announce(format_args!("// Filament width: {:.3} mm\n", width.0)),
        None => {}
    }
}

/// Returns the extruder whose filament is measured.
fn measured_tool<'p>(program: &'p Interpreter, config: &MachineConfig) -> Option<&'p Tool> {
    program.tools().all().iter().find(|tool| tool.settings.id == config.filament_width.tool)
}

/// Scales what is extruded from here on to the filament that will be at the nozzle then: more for thinner
/// filament, less for thicker.
fn correct_flow<P: Ports>(Sensors { width, world, program, tuning, .. }: Sensors<'_, '_, P>) {
    let sensor = &tuning.filament_width;
    let Some(tool) = measured_tool(program, world.config) else { return };
    let meant = tool.settings.filament_diameter.map_or(sensor.nominal, Mm);
    let pushed = program.position()[tool.settings.axis];
    let factor = width.factor(sensor, pushed, meant);
    program.set_width_factor(sensor.tool, factor);
}

/// Forgets measured widths: filament was taken out, or another one put in.
fn forget_width<P>(Sensors { width, tuning, .. }: Sensors<'_, '_, P>) {
    width.forget(&tuning.filament_width);
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
fn push<'c>(hands: &mut impl FilamentHands<'c>, length: f64, rate: MmPerSecond) -> Result<(), Failure> {
    if length == 0.0 {
        return Ok(());
    }
    let axis = extruder(hands.program())?;
    let mut target = hands.position();
    target[axis] += length;
    hands.sequence(Recipient::Nobody).go(target, rate, Mode::Feed)?;
    hands.standstill()
}

/// M600: suspends the job, and takes the filament out, as far as its words and [filament change] say.
fn change_filament<'c>(
    hands: &mut impl FilamentHands<'c>,
    heaters_stay: bool,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    let (jobs, world) = hands.jobs_in_world();
    if suspend::is_already(jobs, world, to) {
        return Ok(Answer::Ok);
    }
    let change = change(hands, words)?;
    suspend::begin(hands, to)?;
    let mut targets = suspend::targets(&mut hands.world().ports);
    if let Some((heater, target)) = change.goes_on_with
        && let Some(to) = targets.get_mut(heater.index())
    {
        *to = target;
    }
    let lengths = unless_cold(hands, change.lengths);
    let moved = moves_anything(&lengths).then_some(lengths);
    suspend::keep(hands, targets, moved);
    if let Some(lengths) = &moved {
        // The job is suspended all the same where filament or tool cannot move.
        let (left, texts) = (leave(hands, lengths), hands.world().texts);
        hands.resynchronise_if_still();
        match left {
            Err(why) if why.is_refusal() => hands.announce(format_args!("// WARNING {}\n", texts.of(why))),
            left => left?,
        }
    }
    suspend::rest(hands, heaters_stay)
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
fn change<'c>(hands: &mut impl FilamentHands<'c>, words: &Words<'_>) -> Result<Change, Failure> {
    let tool = hands.program().tools().active().map(|tool| tool.settings.id);
    if let Some(wanted) = words.get('T')
        && tool.is_none_or(|tool| f64::from(tool.0) != wanted)
    {
        return Err(Failure::refused(&"M600 T: select this tool first, with T"));
    }
    let mut lengths = hands.tuning().filament_change;
    let length = |letter, as_ever| words.get(letter).map_or(as_ever, |length: f64| Mm(length.abs()));
    lengths.retract = length('E', lengths.retract);
    lengths.lift = length('Z', lengths.lift);
    lengths.unload = length('U', lengths.unload);
    lengths.load = length('L', lengths.load);
    for (place, letter) in lengths.park.iter_mut().zip(['X', 'Y']) {
        *place = words.get(letter).map(Mm).or(*place);
    }
    let heater = tool.and_then(|tool| hands.world().config.heater_with(tool));
    let goes_on_with = heater.zip(words.get('R').map(|celsius| Celsius(celsius as f32)));
    Ok(Change { lengths, goes_on_with })
}

/// Leaves only the parking of M600 if its nozzle is too cold to feed filament.
fn unless_cold<'c>(hands: &mut impl FilamentHands<'c>, change: FilamentChangeConfig) -> FilamentChangeConfig {
    let feeds = [change.retract, change.unload, change.load, change.purge].iter().any(|length| length.0 > 0.0);
    let Sensors { world, program, tuning, .. } = hands.sensors();
    match cold_extrusion::may_feed(world, program, tuning, -1.0) {
        Err(why) if feeds => {
            let why = world.texts.of(why);
            world.announce(format_args!("// WARNING {why}: M600 leaves the filament in\n"));
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
fn leave<'c>(hands: &mut impl FilamentHands<'c>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    hands.announce(format_args!("// Going aside, so that the filament can be changed\n"));
    push(hands, -change.retract.0, change.unload_rate)?;
    park(hands, change)?;
    unload(hands, change.unload)
}

fn park<'c>(hands: &mut impl FilamentHands<'c>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    let from = hands.position();
    let mut above = from;
    above[Axis::Z] += change.lift.0;
    if change.lift.0 > 0.0 {
        if hands.stays_within(&from, &above).is_err() {
            hands.announce(format_args!("// NOTE there is no room to lift the tool: it stays where it is\n"));
            return Ok(());
        }
        hands.sequence(Recipient::Nobody).go(above, change.park_rate, Mode::Rapid)?;
    }
    let mut away = above;
    for (axis, place) in [Axis::X, Axis::Y].into_iter().zip(change.park) {
        away[axis] = place.map_or(away[axis], |place| place.0);
    }
    if away == above {
        return Ok(());
    }
    let homed = hands.axes().homed();
    let is_homed = [Axis::X, Axis::Y].into_iter().all(|axis| homed.has(axis));
    if !is_homed || hands.stays_within(&above, &away).is_err() {
        hands.announce(format_args!(
            "// NOTE the tool does not go aside: X and Y are not homed, or it is out of travel\n"
        ));
        return Ok(());
    }
    hands.sequence(Recipient::Nobody).go(away, change.park_rate, Mode::Rapid)?;
    hands.standstill()
}

/// Lifts and parks the tool (G27).
pub(crate) fn go_aside<'c>(hands: &mut impl FilamentHands<'c>, words: &Words<'_>) -> Outcome {
    if words.get('P') == Some(1.0) {
        return Err(Failure::refused(
            &"G27 P1: the tool is lifted by [filament change] lift, from where it is: leave P out",
        ));
    }
    let change = hands.tuning().filament_change;
    if change.lift.0 <= 0.0 && change.park.iter().all(Option::is_none) {
        return Err(Failure::refused(&"G27: where to? [filament change] has no lift, park_x and park_y"));
    }
    hands.standstill()?;
    let parked = park(hands, &change);
    hands.standstill()?;
    hands.resynchronise();
    parked.map(|()| Answer::Ok)
}

fn unload<'c>(hands: &mut impl FilamentHands<'c>, length: Mm) -> Result<(), Failure> {
    let rate = hands.tuning().filament_change.unload_rate;
    if length.0 > 0.0 {
        hands.announce(format_args!("// Taking {} mm of filament out\n", length.0));
    }
    push(hands, -length.0, rate)
}

/// Pushes new filament in, or the filament drawn back, before the job goes on, once the nozzle is hot.
fn come_back<'c>(hands: &mut impl FilamentHands<'c>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    if change.unload.0 == 0.0 && change.load.0 == 0.0 {
        push(hands, change.retract.0, change.unload_rate)?;
        return push(hands, change.purge.0, change.purge_rate);
    }
    load(hands, change.load)
}

fn load<'c>(hands: &mut impl FilamentHands<'c>, length: Mm) -> Result<(), Failure> {
    let change = hands.tuning().filament_change;
    if length.0 > 0.0 {
        hands.announce(format_args!("// Pushing {} mm of filament in\n", length.0));
    }
    push(hands, length.0, change.load_rate)?;
    push(hands, change.purge.0, change.purge_rate)
}

/// Loads (M701, `loads`) or unloads (M702) filament, by `length` or else as M603 says. The operator sees to a
/// hot nozzle, or [`super::cold_extrusion`] does where that was asked for.
pub(crate) fn by_hand<'c>(hands: &mut impl FilamentHands<'c>, loads: bool, length: Option<f64>) -> Outcome {
    extruder(hands.program())?;
    hands.standstill()?;
    let change = hands.tuning().filament_change;
    let length = length.map_or(if loads { change.load } else { change.unload }, Mm);
    if length.0 == 0.0 {
        let text = if loads { "M701: how far? Give L, or set M603 L" } else { "M702: how far? Give U, or set M603 U" };
        return Err(hands.world().texts.because(text));
    }
    let Sensors { world, program, tuning, .. } = hands.sensors();
    cold_extrusion::may_feed(world, program, tuning, if loads { length.0 } else { -length.0 })?;
    if loads {
        load(hands, length)?
    } else {
        unload(hands, length)?
    }
    forget_width(hands.sensors());
    hands.resynchronise();
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
