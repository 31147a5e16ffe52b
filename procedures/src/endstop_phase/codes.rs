//! M875: reports the collected phases, and sets the calibrated ones.

use core::fmt;

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::ports::MotionPort;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use program::Words;
use units::{Axis, AxisSet};

use super::axes::{checked, is_external};
use super::cycle::{CYCLE, within};
use super::records::{EndstopPhases, Record};

/// Number of homings below which the mean is hardly better than the switch.
const FEW: u32 = 5;

/// M875 reports the collected phases, M875.1 makes their mean the calibrated phase, M875.2 sets that, M875.3
/// forgets the collected phases.
///
/// # Errors
/// A refusal where an axis has no phase, or what was collected says nothing.
pub fn endstop_phase(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl MotionPort>,
    phases: &mut EndstopPhases,
    tuning: &mut Tuning,
) -> Outcome {
    let code = words.code().subcode;
    let able = checked(config);
    let named = words.axes();
    if let Some(axis) = named.without(able).axes().next() {
        let letter = axis.letter();
        return refused(texts, format_args!("{letter}: write phase_check = true for its homing endstop first"));
    }
    if able.is_empty() {
        return refused(texts, format_args!("no homing endstop has phase_check = true"));
    }
    let motion = ports.motion(|motion| motion.config().copied());
    let motion = motion.ok_or_else(|| Failure::refused(&"motion is not configured"))?;
    for axis in if named.is_empty() { able } else { named }.axes() {
        let external = is_external(config, &motion, axis);
        match code {
            0 => {
                report(axis, phases.of(axis), tuning.phases[axis], external, reply);
                say_wide(axis, phases.of(axis), config, reply);
            }
            1 => calibrate(texts, axis, phases.of(axis), tuning, external, reply)?,
            2 => set(texts, axis, words, tuning, external)?,
            _ => phases.of(axis).forget(),
        }
    }
    Ok(Answer::Ok)
}

fn refused(texts: &Texts, why: fmt::Arguments<'_>) -> Outcome {
    Err(texts.refused(why))
}

fn report(axis: Axis, record: &Record, calibrated: Option<f64>, external: bool, reply: &mut Reply<'_>) {
    let (letter, all) = (axis.letter(), &record.collected);
    match (external, calibrated, record.first) {
        (false, Some(phase), _) => reply.say(format_args!("{letter}: calibrated phase {phase:.2} of 1024\n")),
        (true, _, None) | (false, None, None) => {
            reply.say(format_args!("{letter}: not calibrated; the next homing's phase counts until power goes\n"));
        }
        (_, _, Some(phase)) => reply.say(format_args!(
            "{letter}: not calibrated; the first homing's phase {phase:.2} of 1024 counts until power goes\n"
        )),
    }
    if all.count() == 0 {
        return reply.say(format_args!("{letter}: no homing yet\n"));
    }
    let [least, most] = all.ends().map(|phase| within(phase, CYCLE));
    reply.say(format_args!(
        "{letter}: {} homings, phases from {least:.2} to {most:.2}, mean {:.2}: within {:.4} mm of a cycle of {:.4}, standard \
         deviation {:.4} mm\n",
        all.count(),
        within(all.mean(), CYCLE),
        all.range() * record.mm,
        CYCLE * record.mm,
        all.deviation() * record.mm
    ));
    reply.say(format_args!("{letter}: the last were"));
    record.last.iter().for_each(|phase| reply.say(format_args!(" {phase}")));
    reply.say(format_args!("\n"));
}

/// Warns here, since the checker cannot work out the cycle of every machine, and codes change steps.
fn say_wide(axis: Axis, record: &Record, config: &MachineConfig, reply: &mut Reply<'_>) {
    let tolerance = config.homing_endstop(axis).and_then(|stop| stop.phase.tolerance);
    let half = CYCLE / 2.0 * record.mm;
    if record.mm > 0.0 && tolerance.is_some_and(|tolerance| tolerance.0 >= half) {
        let letter = axis.letter();
        reply.say(format_args!(
            "{letter}: phase_tolerance finds nothing, for it is half a cycle or more: write less than {half:.4}\n"
        ));
    }
}

fn calibrate(
    texts: &Texts,
    axis: Axis,
    record: &Record,
    tuning: &mut Tuning,
    external: bool,
    reply: &mut Reply<'_>,
) -> Result<(), Failure> {
    let (letter, all) = (axis.letter(), &record.collected);
    let refused = |why: fmt::Arguments<'_>| Err(texts.refused(why));
    if external {
        return refused(format_args!(
            "{letter}: no phase of an external driver is true after power up; the first homing's is used"
        ));
    }
    if all.count() == 0 {
        return refused(format_args!("{letter}: home it first, ten times or so, and from different places"));
    }
    if all.range() >= CYCLE / 2.0 {
        return refused(format_args!(
            "{letter}: phases lie over {:.3} mm, half a cycle or more: its switch is too noisy, or something slips",
            all.range() * record.mm
        ));
    }
    let phase = as_saved(all.mean());
    tuning.phases[axis] = Some(phase);
    let sure = all.deviation() * record.mm / libm::sqrt(f64::from(all.count()));
    let count = all.count();
    reply.say(format_args!("{letter}: calibrated phase {phase:.2} of 1024, by {count} homings"));
    if count < FEW {
        reply.say(format_args!(": home it some times more to be sure"));
    } else {
        reply.say(format_args!(", sure to {sure:.4} mm"));
    }
    reply.say(format_args!("; M500 saves it\n"));
    Ok(())
}

/// Rounds a phase to the decimals that are saved.
fn as_saved(phase: f64) -> f64 {
    within(libm::round(phase * 100.0) / 100.0, CYCLE)
}

fn set(texts: &Texts, axis: Axis, words: &Words<'_>, tuning: &mut Tuning, external: bool) -> Result<(), Failure> {
    let letter = axis.letter();
    let Some(phase) = words.get(letter) else { return Ok(()) };
    if external {
        return Err(texts.refused(format_args!("{letter}: no phase of an external driver is true after power up")));
    }
    tuning.phases[axis] = (phase >= 0.0).then_some(as_saved(phase));
    Ok(())
}

/// Writes the line that M500 saves, if phases differ from the configured ones.
///
/// # Errors
/// When the text is full.
pub fn write(text: &mut impl fmt::Write, tuning: &Tuning, config: &MachineConfig) -> fmt::Result {
    let configured = |axis: Axis| config.homing_endstop(axis).and_then(|stop| stop.phase.calibrated);
    let changed = |axis: &Axis| tuning.phases[*axis] != configured(*axis);
    let changed = AxisSet::collect(checked(config).axes().filter(changed));
    if changed.is_empty() {
        return Ok(());
    }
    write!(text, ";Phases at endstops:\nM875.2")?;
    for axis in changed.axes() {
        write!(text, " {}{:.2}", axis.letter(), tuning.phases[axis].unwrap_or(-1.0))?;
    }
    writeln!(text)
}
