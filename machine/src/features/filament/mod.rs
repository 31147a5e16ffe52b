//! Filament: its detector, and how M600, M701 and M702 move filament and the tool.

pub(crate) mod cold_extrusion;

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::{Recipient, Reply};
use base::tuning::Tuning;
use config::FilamentChangeConfig;
use motion::Mode;
use parts::filament::{News, Use, WidthNews};
use program::{State, Tool, Words};
use units::{Axis, Celsius, HeaterId, Micros, Mm, MmPerSecond};

use crate::machine::Machine;
use crate::machine::hands::MachineHands;

/// Counts the pulses of the filament's wheel, where there is one.
pub(crate) fn count<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.config.filament_detector.wheel_pin().is_some() {
        let levels = machine.ports.inputs();
        machine.filament.count(levels);
    }
}

/// Looks at the detector.
pub(crate) fn watch<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let using = match machine.safety.state() {
        _ if machine.jobs.is_suspended() => Use::Rests,
        State::Alarm | State::Sleep | State::Invalid => return machine.filament.forget(),
        _ if machine.jobs.is_playing() => Use::Plays,
        _ if machine.jobs.is_open() => Use::Rests,
        State::Run => Use::Moves,
        _ => Use::Idle,
    };
    if machine.config.filament_width.enable {
        measure(machine, using, now);
    }
    let Machine { filament, ports, config, tuning, program, .. } = machine;
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
    let Some(axis) = measured_tool(machine).map(|tool| tool.settings.axis) else { return };
    let readings = machine.ports.heat(|heat| heat.filament_width());
    let pushed = machine.ports.motion(|motion| motion.live_position())[axis];
    let news = machine.filament_width.look(&sensor, readings, pushed, now);
    machine.filament.note_width(machine.filament_width.trouble());
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
fn measured_tool<'m, P: Ports>(machine: &'m Machine<'_, P>) -> Option<&'m Tool> {
    machine.program.tools().all().iter().find(|tool| tool.settings.id == machine.config.filament_width.tool)
}

/// Scales what is extruded from here on to the filament that will be at the nozzle then: more for thinner
/// filament, less for thicker.
pub(crate) fn correct_flow<P: Ports>(machine: &mut Machine<'_, P>) {
    let sensor = &machine.tuning.filament_width;
    let Some(tool) = measured_tool(machine) else { return };
    let meant = tool.settings.filament_diameter.map_or(sensor.nominal, Mm);
    let pushed = machine.program.position()[tool.settings.axis];
    let factor = machine.filament_width.factor(sensor, pushed, meant);
    machine.program.set_width_factor(sensor.tool, factor);
}

/// Whether moves are planned as far ahead as the filament is measured: more must wait, as for room in the
/// queue. The motors go on meanwhile, so it comes to an end.
pub(crate) fn is_planned_ahead<P: Ports>(machine: &Machine<'_, P>) -> bool {
    let Some(tool) = measured_tool(machine) else { return false };
    let pushed = machine.program.position()[tool.settings.axis];
    machine.filament_width.is_to_come(&machine.tuning.filament_width, pushed)
}

/// Forgets measured widths: filament was taken out, or another one put in.
pub(crate) fn forget_width<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.filament_width.forget(&machine.tuning.filament_width);
}

/// Returns the axis of the extruder in use.
///
/// # Errors
/// When there is none.
fn extruder<P: Ports>(machine: &Machine<'_, P>) -> Result<Axis, Failure> {
    let axis = machine.program.tools().active().map(|tool| tool.settings.axis);
    axis.ok_or_else(|| Failure::refused(&"there is no extruder whose filament could be changed"))
}

/// Pushes filament, or draws it back, and waits for its end.
fn push<P: Ports>(machine: &mut Machine<'_, P>, length: f64, rate: MmPerSecond) -> Result<(), Failure> {
    if length == 0.0 {
        return Ok(());
    }
    let axis = extruder(machine)?;
    let hands = &mut MachineHands::new(machine, Recipient::Nobody);
    let mut target = hands.position();
    target[axis] += length;
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}

/// Parameters of a filament change (M600).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub lengths: FilamentChangeConfig,
    /// Another temperature of the tool's heater that the job goes on with.
    pub goes_on_with: Option<(HeaterId, Celsius)>,
}

/// Returns the change as configured, but for the words of M600. Marlin takes E, U and L with either sign.
///
/// # Errors
/// For another tool than the one in use, and for a place that is out of reach.
pub(crate) fn change<P: Ports>(machine: &Machine<'_, P>, words: &Words<'_>) -> Result<Change, Failure> {
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
    let heater = tool.and_then(|tool| machine.config.heater_with(tool));
    let goes_on_with = heater.zip(words.get('R').map(|celsius| Celsius(celsius as f32)));
    Ok(Change { lengths, goes_on_with })
}

/// Leaves only the parking of M600 if its nozzle is too cold to feed filament.
pub(crate) fn unless_cold<P: Ports>(
    machine: &mut Machine<'_, P>,
    change: FilamentChangeConfig,
) -> FilamentChangeConfig {
    let feeds = [change.retract, change.unload, change.load, change.purge].iter().any(|length| length.0 > 0.0);
    match cold_extrusion::may_feed(machine, -1.0) {
        Err(why) if feeds => {
            machine.announce(format_args!("// WARNING {}: M600 leaves the filament in\n", machine.texts.of(why)));
            let nothing = Mm(0.0);
            FilamentChangeConfig { retract: nothing, unload: nothing, load: nothing, purge: nothing, ..change }
        }
        _ => change,
    }
}

/// Whether filament or the tool is moved.
pub(crate) fn moves_anything(change: &FilamentChangeConfig) -> bool {
    let lengths = [change.retract, change.lift, change.unload, change.load, change.purge];
    lengths.iter().any(|length| length.0 > 0.0) || change.park.iter().any(Option::is_some)
}

/// Leaves the part for M600, once nothing moves: draws back, lifts, goes to the tool's waiting place, and
/// takes the filament out, as far as the configuration says.
pub(crate) fn leave<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    machine.announce(format_args!("// Going aside, so that the filament can be changed\n"));
    push(machine, -change.retract.0, change.unload_rate)?;
    park(machine, change)?;
    unload(machine, change.unload)
}

fn park<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
    let from = machine.ports.motion(|motion| motion.commanded_position());
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
pub(crate) fn come_back<P: Ports>(machine: &mut Machine<'_, P>, change: &FilamentChangeConfig) -> Result<(), Failure> {
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
    extruder(machine)?;
    machine.standstill()?;
    let change = machine.tuning.filament_change;
    let length = length.map_or(if loads { change.load } else { change.unload }, Mm);
    if length.0 == 0.0 {
        let text = if loads { "M701: how far? Give L, or set M603 L" } else { "M702: how far? Give U, or set M603 U" };
        return Err(machine.texts.because(text));
    }
    cold_extrusion::may_feed(machine, if loads { length.0 } else { -length.0 })?;
    if loads {
        load(machine, length)?
    } else {
        unload(machine, length)?
    }
    forget_width(machine);
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
