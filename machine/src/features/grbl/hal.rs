//! Reports of grblHAL beyond GRBL 1.1, for senders that look for them (`[general] grblhal`): fields of the
//! status report, the options in `$I`, and the lists of errors, alarms and settings. Facts: the reports of
//! grblHAL (github.com/grblHAL/core, `report.c`) and what gSender and ioSender read of them.

use base::reason::{Alarm, Reason};
use base::sessions::{Enumeration, Reply};
use config::MachineConfig;
use parts::reports::{Line, add, free_axes};
use program::{Interpreter, write_system_name};
use units::{Axis, AxisSet};

use super::last_report::{Extra, Told};
use super::numbered_settings::Setting;
use super::reports::Ahead;

/// First text of a session.
pub(crate) const BANNER: &str = "GrblHAL 1.1f ['$' for help]\n";

/// Progress of a job: percent done, and the name of its file.
pub(crate) type Share<'m> = (u8, &'m str);

/// Returns the state of program and machine that grblHAL reports.
pub(crate) fn extra(program: &Interpreter, homed: AxisSet) -> Extra {
    let axes = (0..).zip(Axis::PRIMARY).filter(|(_, axis)| homed.has(*axis));
    Extra {
        system: program.modal().system,
        tool: program.tools().number(),
        homed: axes.fold(0, |bits, (bit, _)| bits | 1 << bit),
    }
}

/// Adds grblHAL's fields to a report: those that have changed, or all of them. `can_home`: axes that are
/// homed before the machine counts as homed.
pub(crate) fn add_fields(line: &mut Line, now: Extra, can_home: AxisSet, job: Option<Share<'_>>, told: &mut Told) {
    let before = told.extra.filter(|_| !told.wants_all);
    if before.map(|extra| extra.system) != Some(now.system) {
        add!(*line, "|WCS:");
        // A line takes any text, cut to fit, so errors are ignored.
        let _ = write_system_name(line, now.system);
    }
    if before.map(|extra| extra.homed) != Some(now.homed) && can_home != AxisSet::NONE {
        let all = (0..).zip(Axis::PRIMARY).filter(|(_, axis)| can_home.has(*axis));
        let all = all.fold(0, |bits, (bit, _)| bits | 1 << bit);
        add!(*line, "|H:{},{}", u8::from(now.homed & all == all), now.homed);
    }
    if before.map(|extra| extra.tool) != Some(now.tool) {
        add!(*line, "|T:{}", now.tool);
    }
    if let Some((percent, name)) = job {
        add!(*line, "|SD:{percent},{name}");
    }
    if told.wants_all {
        add!(*line, "|TLR:0|FW:grblHAL");
    }
    (told.extra, told.wants_all) = (Some(now), false);
}

/// Prints the part of `$I+` that `$I` also has: axes, and options beyond GRBL.
pub(crate) fn build(config: &MachineConfig, program: &Interpreter, ahead: Ahead, reply: &mut Reply<'_>) {
    let axes = || Axis::PRIMARY.into_iter().chain(free_axes(config, program.tools()));
    let count = axes().count();
    reply.say(format_args!("[OPT:VNMH,{},{},{count},0]\n[AXS:{count}:", ahead.moves, ahead.bytes));
    axes().for_each(|axis| reply.say(format_args!("{}", axis.letter())));
    reply.say(format_args!("]\n[NEWOPT:ENUMS,HOME,EXPR,TC,SD]\n"));
}

/// Prints the rest of `$I+`.
pub(crate) fn firmware(version: &str, reply: &mut Reply<'_>) {
    reply.say(format_args!(
        "[FIRMWARE:grblHAL]\n[DRIVER:Velvet]\n[DRIVER VERSION:{version}]\n[BOARD:Smoothieboard Prime]\n"
    ));
}

/// Returns the list of a name behind the `$`.
#[must_use]
pub(crate) fn list_named(name: &str) -> Option<Enumeration> {
    Some(match name {
        "EA" => Enumeration::Alarms,
        "EE" => Enumeration::Errors,
        "EG" => Enumeration::Groups,
        "ES" => Enumeration::Settings,
        _ => return None,
    })
}

/// Prints one line of a list, counted from 0. False when there is none.
pub(crate) fn list_line(list: Enumeration, line: usize, reply: &mut Reply<'_>) -> bool {
    match list {
        Enumeration::Alarms => Alarm::ALL.get(line).is_some_and(|(alarm, text)| {
            reply.say(format_args!("[ALARMCODE:{}||{text}]\n", alarm.number()));
            true
        }),
        Enumeration::Errors => Reason::ALL.get(line).is_some_and(|(error, text)| {
            reply.say(format_args!("[ERRORCODE:{}||{text}]\n", error.number()));
            true
        }),
        Enumeration::Groups if line == 0 => {
            reply.say(format_args!("[SETTINGGROUP:1|0|Machine]\n"));
            true
        }
        Enumeration::Groups => false,
        Enumeration::Settings => Setting::all().nth(line).is_some_and(|setting| {
            say_setting(setting, reply);
            true
        }),
    }
}

fn say_setting(setting: Setting, reply: &mut Reply<'_>) {
    let (name, unit) = setting.meaning().split_once(", ").unwrap_or((setting.meaning(), ""));
    let (kind, format) = if setting.decimals() > 0 { (6, "#####0.000") } else { (5, "####0") };
    let number = setting.number();
    let axis = setting.axis().map(|axis| [' ', axis.letter()]);
    reply.say(format_args!("[SETTING:{number}|1|{name}"));
    axis.into_iter().flatten().for_each(|letter| reply.say(format_args!("{letter}")));
    reply.say(format_args!("|{unit}|{kind}|{format}|||0|0]\n"));
}
