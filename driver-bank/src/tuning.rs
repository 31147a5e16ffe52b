//! Drivers register by register, for people who tune them: M911 and its subcodes, `setregs`.

use core::fmt::{Result, Write};

use base::ports::DriverFault;
use embedded_hal::spi::SpiDevice;
use tmc::register::ChopConf;
use tmc::{
    BlankTime, Chip, Chopper, CoolStep, Driver, HysteresisDecrement, ReadSelect, Reading, StallGuard, StepInput,
};
use units::Actuator;

use crate::error::fault;

/// Names of the registers as M911.2 numbers them, from 1, with the bits of their addresses.
const REGISTERS: [(&str, u32); 5] = [
    ("driver control", 0),
    ("chopper config", 0b100 << 17),
    ("cool step", 0b101 << 17),
    ("stall guard2 current", 0b110 << 17),
    ("driver configuration", 0b111 << 17),
];

/// Bit `DEDGE` of the first register: always set, as the step engine makes a step of every edge.
const DOUBLE_EDGE: u32 = 1 << 8;

/// Returns the word for a register by its number, with its address.
pub fn addressed(number: u8, value: u32) -> Option<u32> {
    let (_, address) = REGISTERS.get(usize::from(number).checked_sub(1)?)?;
    let fixed = if number == 1 { DOUBLE_EDGE } else { 0 };
    (value >> 20 == 0).then_some(value & 0x1_FFFF | address | fixed)
}

const fn on_off(bit: u32) -> &'static str {
    if bit == 1 { "on" } else { "off" }
}

/// Prints the chip's readings and registers, and at the end the line that would set them again.
pub fn describe<SPI: SpiDevice>(chip: &mut Driver<SPI>, motor: Actuator, out: &mut dyn Write) -> Result {
    writeln!(out, "Chip type {}", chip.chip().name())?;
    let microstep = chip.read(ReadSelect::Microstep);
    let load = chip.read(ReadSelect::StallGuard);
    match &microstep {
        Ok(status) if status.standstill => writeln!(out, "Motor is standing still")?,
        Ok(_) => writeln!(out, "Motor is moving")?,
        Err(error) => writeln!(out, "WARNING: {error}")?,
    }
    writeln!(out, "Enabled: {}", u8::from(chip.is_enabled()))?;
    if let Ok(Reading::Microstep(position)) = microstep.map(|status| status.reading) {
        writeln!(out, "Microstep position phase A: {position}")?;
    }
    if let Ok(Reading::StallGuard(value)) = load.map(|status| status.reading) {
        writeln!(out, "Stall Guard value: {value}")?;
    }
    faults(chip, out)?;
    settings(chip, out)?;
    writeln!(out, "Register dump:")?;
    let words = chip.registers().words();
    for ((name, _), word) in REGISTERS.iter().zip(words) {
        writeln!(out, " {name} register: {word:05X}({word})")?;
    }
    let [drvctrl, chopconf, smarten, sgcsconf, drvconf] = words;
    let kind = if chip.chip() == Chip::Tmc2660 { "tmc2660" } else { "tmc2590" };
    let name = motor.name();
    writeln!(
        out,
        "config-set {kind} {name}.reg = {drvctrl:05X},{chopconf:05X},{smarten:05X},{sgcsconf:05X},{drvconf:05X}"
    )
}

fn faults<SPI: SpiDevice>(chip: &mut Driver<SPI>, out: &mut dyn Write) -> Result {
    let Ok(status) = chip.status() else { return Ok(()) };
    for (there, text) in [
        (status.over_temperature_warning, "Overtemperature Prewarning"),
        (status.over_temperature, "Overtemperature Shutdown"),
        (status.short_a, "SHORT to ground on channel A"),
        (status.short_b, "SHORT to ground on channel B"),
        (status.open_load_a, "Channel A seems to be unconnected"),
        (status.open_load_b, "Channel B seems to be unconnected"),
    ] {
        if there {
            writeln!(out, "WARNING: {text}")?;
        }
    }
    let Reading::Diagnostics(all) = status.reading else { return Ok(()) };
    for (there, text) in [
        (all.undervoltage, "Undervoltage"),
        (all.enable_input_off, "ENN is high: the bridges are off"),
        (all.short_to_supply_a, "SHORT to supply on channel A"),
        (all.short_to_supply_b, "SHORT to supply on channel B"),
    ] {
        if there {
            writeln!(out, " {text}")?;
        }
    }
    Ok(())
}

fn settings<SPI: SpiDevice>(chip: &Driver<SPI>, out: &mut dyn Write) -> Result {
    let registers = chip.registers();
    let (drvctrl, drvconf) = (registers.drvctrl, registers.drvconf);
    let peak = chip.current().0;
    let rms = peak * core::f32::consts::FRAC_1_SQRT_2;
    writeln!(out, "Current setting: {:.0}mA Peak - {rms:.6} Amps RMS", peak * 1_000.0)?;
    writeln!(out, "Coolstep: {}", on_off(u32::from(registers.smarten.semin() != 0)))?;
    writeln!(out, "Microsteps: 1/{}", 256 >> drvctrl.mres())?;
    writeln!(out, "Step interpolation is {}", on_off(drvctrl.intpol()))?;
    if chip.chip() == Chip::Tmc2590 {
        let (heat, short) = (if drvconf.otsens() == 1 { 136 } else { 150 }, drvconf.shrtsens());
        writeln!(out, "Overtemperature sensitivity: {heat}C")?;
        writeln!(out, "Short to ground sensitivity: {}", if short == 1 { "high" } else { "low" })?;
        writeln!(out, "Passive fast decay is {}", on_off(drvconf.en_pfd()))?;
        let enabled = if drvconf.en_s2vs() == 1 { "enabled" } else { "disabled" };
        writeln!(out, "Short to VS protection is {enabled}")?;
    }
    let enabled = if drvconf.dis_s2g() == 1 { "disabled" } else { "enabled" };
    writeln!(out, "Short to GND protection is {enabled}")?;
    let delay = ["3.2", "1.6", "1.2", "0.8"].get(drvconf.ts2g() as usize).unwrap_or(&"?");
    writeln!(out, "Short detection delay is {delay}us")?;
    writeln!(out, "Slope control - high: {}, low: {}", drvconf.slph(), drvconf.slpl())
}

/// Prints mode, off time, blanking time, then hysteresis start, end and decrement, or fast decay, sine offset
/// and whether the comparator ends the decay.
pub fn describe_chopper<SPI>(chip: &Driver<SPI>, out: &mut dyn Write) -> Result
where
    SPI: SpiDevice,
{
    let conf = chip.registers().chopconf;
    let [off, blank, first, end, last] = chopper_words(conf, conf.chm() != 0).unwrap_or_default();
    writeln!(out, "{},{off},{blank},{first},{end},{last}", conf.chm())
}

/// Returns U V W X and Y of M911.3 S0 or S1, if the chip is in that mode.
fn chopper_words(conf: ChopConf, constant: bool) -> Option<[i32; 5]> {
    let blank = [16, 24, 36, 54].get(conf.tbl() as usize).copied().unwrap_or(0);
    let (first, last) = match conf.chm() {
        0 => (conf.hstrt() + 1, conf.hdec()),
        _ => (conf.hstrt() | (conf.hdec() & 1) << 3, u32::from(conf.hdec() & 2 == 0)),
    };
    let words = [conf.toff() as i32, blank, first as i32, conf.hend() as i32 - 3, last as i32];
    (constant == (conf.chm() != 0)).then_some(words)
}

/// Applies a group of settings by its number, as M911.3 counts them.
pub fn set_option<SPI: SpiDevice>(
    chip: &mut Driver<SPI>,
    option: u8,
    word: &dyn Fn(char) -> Option<f64>,
) -> core::result::Result<(), DriverFault> {
    let number = |letter: char| word(letter).map(|value| value as i32);
    let switch = || number('Z').map(|value| value != 0).ok_or(DriverFault::BadSetting);
    // As Smoothieware v2 reads Z of coolStep and of passive fast decay.
    let is_one = || number('Z').map(|value| value == 1).ok_or(DriverFault::BadSetting);
    let now = chip.registers().drvctrl;
    let done = match option {
        0 | 1 => {
            let before = chopper_words(chip.registers().chopconf, option == 0);
            if !"UVWXY".chars().any(|letter| word(letter).is_some()) {
                return Err(DriverFault::BadSetting);
            }
            let number = |letter| number(letter).or_else(|| before?.get("UVWXY".find(letter)?).copied());
            chip.set_chopper(chopper(option == 0, &number).ok_or(DriverFault::BadSetting)?)
        }
        2 => {
            let conf = chip.registers().chopconf.with_rndtf(u32::from(switch()?));
            chip.write_raw(conf.word())
        }
        4 => chip.set_step_input(StepInput {
            microsteps: tmc::Microsteps::from_count(256 >> now.mres()).ok_or(DriverFault::BadSetting)?,
            double_edge: now.dedge() == 1,
            interpolation: switch()?,
        }),
        5 if is_one()? => chip.cool_step_on(),
        5 => chip.set_cool_step(None),
        6 => chip.set_passive_fast_decay(is_one()?),
        7 => {
            let before = chip.registers().sgcsconf;
            // Seven bits with a sign.
            let threshold = number('O').unwrap_or((before.sgt() as i32 ^ 0x40) - 0x40);
            let filter = number('Q').map_or(before.sfilt() == 1, |value| value != 0);
            if number('O').or(number('Q')).is_none() {
                return Err(DriverFault::BadSetting);
            }
            let threshold = i8::try_from(threshold).map_err(|_| DriverFault::BadSetting)?;
            chip.set_stall_guard(StallGuard { threshold, filter })
        }
        8 => chip.prepare_cool_step(cool_step(&number).ok_or(DriverFault::BadSetting)?),
        // Double edges (3) cannot be changed, as the step engine relies on them.
        _ => return Err(DriverFault::BadSetting),
    };
    done.map_err(fault)
}

pub(crate) fn cool_step(number: &dyn Fn(char) -> Option<i32>) -> Option<CoolStep> {
    let small = |letter: char| number(letter).and_then(|value| u8::try_from(value).ok());
    // Both values are in readings, of which the chip takes 32 at a time.
    let steps = |letter: char| number(letter).and_then(|value| u8::try_from(value / 32).ok());
    Some(CoolStep {
        lower_threshold: steps('H')?,
        threshold_width: steps('I')?,
        decrement: small('J')?,
        increment: small('K')?,
        quarter_current: small('L')? != 0,
    })
}

pub(crate) fn chopper(constant: bool, number: &dyn Fn(char) -> Option<i32>) -> Option<Chopper> {
    let small = |letter: char| number(letter).and_then(|value| u8::try_from(value).ok());
    let signed = |letter: char| number(letter).and_then(|value| i8::try_from(value).ok());
    // A value that the chip does not have is rounded down.
    let clocks = [54, 36, 24].into_iter().find(|clocks| number('V').is_some_and(|value| value >= *clocks));
    let blank_time = BlankTime::from_clocks(clocks.map_or(16, |clocks| clocks as u8))?;
    let off_time = small('U')?;
    Some(if constant {
        Chopper::ConstantOffTime {
            off_time,
            blank_time,
            fast_decay: small('W')?,
            sine_offset: signed('X')?,
            comparator_ends_decay: small('Y')? != 0,
            random_off_time: false,
        }
    } else {
        Chopper::SpreadCycle {
            off_time,
            blank_time,
            hysteresis_start: small('W')?,
            hysteresis_end: signed('X')?,
            decrement: match small('Y')? {
                0 => HysteresisDecrement::Clocks16,
                1 => HysteresisDecrement::Clocks32,
                2 => HysteresisDecrement::Clocks48,
                3 => HysteresisDecrement::Clocks64,
                _ => return None,
            },
            random_off_time: false,
        }
    })
}
