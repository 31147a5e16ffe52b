//! Reports of the machine's parts and of the known sensors: `modules`, `thermistors`, `calc_thermistor`.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::sessions::Reply;
use config::MachineConfig;
use drivers::thermistor::{BUILT_IN, Curve};
use units::{Celsius, Ohms};

/// `modules`: lists the parts that the configuration switches on, with their names.
pub fn modules(config: &MachineConfig, reply: &mut Reply<'_>) {
    let extruders = config.extruders.iter().map(|extruder| extruder.name.as_str());
    let switches = config.switches.iter().map(|switch| switch.name.as_str());
    let heaters = config.heaters().map(|(_, heater)| heater.name.as_str());
    reply.say(format_args!("conveyor\ncurrentcontrol\n"));
    if !config.endstops.is_empty() {
        reply.say(format_args!("endstops\n"));
    }
    named("extruder", extruders, reply);
    if config.kill_button.enable {
        reply.say(format_args!("killbutton\n"));
    }
    if config.safety_door.enable {
        reply.say(format_args!("safetydoor\n"));
    }
    reply.say(format_args!("player\nrobot\n"));
    named("switch", switches, reply);
    named("temperature control", heaters, reply);
    if config.probe.enable {
        reply.say(format_args!("zprobe\n"));
    }
}

fn named<'n>(module: &str, names: impl Iterator<Item = &'n str>, reply: &mut Reply<'_>) {
    let mut any = false;
    for name in names {
        match any {
            false => reply.say(format_args!("{module}: {name}")),
            true => reply.say(format_args!(",{name}")),
        }
        any = true;
    }
    if any {
        reply.say(format_args!("\n"));
    }
}

/// `thermistors`: lists those that `thermistor = ...` and M305 P know.
pub fn thermistors(reply: &mut Reply<'_>) {
    for (title, wants_beta) in [("S/H table", false), ("Beta table", true)] {
        reply.say(format_args!("{title}\n"));
        for entry in BUILT_IN.iter().filter(|entry| entry.is_beta() == wants_beta) {
            reply.say(format_args!("{} - {}\n", entry.index, entry.name));
        }
    }
}

/// `calc_thermistor T1,R1,T2,R2,T3,R3`: computes the coefficients of a sensor that is known at three points.
///
/// # Errors
/// When these are not three points of one thermistor.
pub fn thermistor_coefficients(texts: &Texts, arguments: &str, reply: &mut Reply<'_>) -> Outcome {
    const USAGE: &str = "usage: calc_thermistor T1,R1,T2,R2,T3,R3 (degrees Celsius and ohms)";
    let mut numbers = [0.0_f32; 6];
    let mut given = arguments.split([',', ' ']).filter(|word| !word.is_empty()).map(gcode::read_f32);
    for number in &mut numbers {
        *number = given.next().flatten().ok_or_else(|| Failure::refused(&USAGE))?;
    }
    if given.next().is_some() {
        return Err(Failure::refused(&USAGE));
    }
    let [t1, r1, t2, r2, t3, r3] = numbers;
    let points = [(Celsius(t1), Ohms(r1)), (Celsius(t2), Ohms(r2)), (Celsius(t3), Ohms(r3))];
    let curve = Curve::from_points(points).map_err(|error| texts.because(error.message()))?;
    let [c1, c2, c3] = curve.coefficients();
    reply.say(format_args!("Steinhart Hart coefficients:  I{c1:.18} J{c2:.18} K{c3:.18}\n"));
    Ok(Answer::Ok)
}
