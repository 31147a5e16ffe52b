//! Defaults that depend on other settings, and the tidying up after the checks.

use crate::board;
use crate::ledger::{Ledger, Path};
use crate::machine::{
    ArmSolution, DriverKind, FanFollows, HomingDirection, MachineConfig, OutputKind, ThermistorConfig, ToolId,
};
use crate::off::OffModule;
use crate::pin::OutputPin;
use units::{Actuator, Amps, Duty, Micros, Mm, MmPerSecond, Ohms, sort_short};

/// `tool_id` of a temperature control before one is given to it: the section does not set it.
const NO_NUMBER: ToolId = ToolId(255);
/// Numbers of temperature controls without one count down from here.
const LAST_FREE_NUMBER: u8 = 253;
/// Pieces of a straight move on the two deltas.
const DELTA_SEGMENTS_PER_SECOND: f64 = 100.0;
const DEFAULT_PWM_HZ: u32 = 10_000;

/// Fills in what the file did not write and other settings decide.
pub(crate) fn fill_in(config: &mut MachineConfig, ledger: &Ledger) {
    let written = |section: &str, place: usize, key: &str| {
        Path::named(section, place, key).is_some_and(|path| ledger.span(path).is_some())
    };
    kinematics(config, &written);
    if !written("soft endstop", 0, "halt") {
        // GRBL raises an alarm for a target beyond the travel.
        config.soft_endstops.halt = config.general.grbl_mode;
    }
    if !written("general", 0, "config-override") {
        // A GRBL sender expects its settings to outlive a reset.
        config.general.config_override = config.general.grbl_mode;
    }
    temperatures(config, &written);
    switches(config, &written);
    for (place, fan) in config.fans.iter_mut().enumerate() {
        if !written("fan", place, "idle_speed") {
            fan.idle_speed = if fan.follows == FanFollows::Electronics { fan.speed } else { 0.0 };
        }
    }
    strips(config, &written);
    drivers(config, &written);
    for (place, stop) in config.endstops.iter_mut().enumerate() {
        if !written("endstops", place, "homing_position") {
            stop.homing_position = Mm(if stop.homing_direction == HomingDirection::ToMax { 200.0 } else { 0.0 });
        }
        if stop.stall.homing {
            // A motor that turns too slowly induces too little to be seen to stall.
            if !written("endstops", place, "slow_rate") {
                stop.slow_rate = stop.fast_rate;
            }
            let motor = stop.axis.and_then(|axis| Actuator::from_index(axis as usize));
            let on_board = motor.filter(|motor| config.actuators[*motor].driver.is_on_board());
            if !written("endstops", place, "pin") {
                stop.pin = on_board.and_then(board::stall_pin);
            }
        }
    }
    for (frequency, section) in config.pwm_frequency_hz.iter_mut().zip(["pwm1", "pwm2"]) {
        if ledger.has_section(section) {
            frequency.get_or_insert(DEFAULT_PWM_HZ);
        }
    }
    laser(config, &written);
    let probe = &mut config.probe;
    if probe.return_rate == MmPerSecond(0.0) {
        probe.return_rate = probe.usual_return_rate();
    }
}

/// A laser has its timer's frequency, and the S and the law of M3 that senders of the dialect expect.
fn laser(config: &mut MachineConfig, written: Written) {
    let MachineConfig { laser, pwm_frequency_hz, general, .. } = config;
    let of_timer = laser.pwm_pin.and_then(|pin| *pwm_frequency_hz.get(usize::from(pin.timer).checked_sub(1)?)?);
    if !written("laser", 0, "pwm_frequency") {
        laser.frequency_hz = of_timer.unwrap_or(DEFAULT_PWM_HZ);
    }
    if !written("laser", 0, "default_power") {
        laser.default_power = if general.grbl_mode { 0.0 } else { 0.8 };
    }
    if !written("laser", 0, "proportional_power") {
        laser.proportional_power = !general.grbl_mode;
    }
}

type Written<'a> = &'a dyn Fn(&str, usize, &str) -> bool;

fn kinematics(config: &mut MachineConfig, written: Written) {
    let arm = config.motion.arm_solution;
    if !written("motion control", 0, "must_be_homed") {
        config.motion.must_be_homed = matches!(arm, ArmSolution::LinearDelta | ArmSolution::RotaryDelta);
    }
    if !written("motion control", 0, "delta_segments_per_second") {
        let is_delta = matches!(arm, ArmSolution::LinearDelta | ArmSolution::RotaryDelta);
        config.motion.lines.segments_per_second = is_delta.then_some(DELTA_SEGMENTS_PER_SECOND);
    }
    let homing = &mut config.homing;
    for (key, flag, by) in [
        ("corexy_homing", &mut homing.corexy, ArmSolution::CoreXy),
        ("delta_homing", &mut homing.delta, ArmSolution::LinearDelta),
        ("rdelta_homing", &mut homing.rotary_delta, ArmSolution::RotaryDelta),
        ("scara_homing", &mut homing.scara, ArmSolution::Morgan),
    ] {
        if !written("endstops", 0, key) {
            *flag = arm == by;
        }
    }
    if !written("endstops", 0, "move_to_origin_after_home") {
        homing.move_to_origin = homing.delta;
    }
}

/// Time at full output in which a bed warms by two degrees.
const BED_GAIN_TIME: Micros = Micros::from_seconds(60);
/// Time at full output in which a hot end warms by two degrees.
const HOT_END_GAIN_TIME: Micros = Micros::from_seconds(20);

/// Usual powers of a bed and of a hot end.
const BED_WATTS: f32 = 200.0;
const HOT_END_WATTS: f32 = 40.0;

/// Resolves a thermistor's name against the keys beside it: written values win, the name's own fill the rest.
fn thermistor(thermistor: &mut ThermistorConfig, is_written: impl Fn(&str) -> bool) {
    let name = thermistor.table.unwrap_or_default();
    if is_written("beta") && (thermistor.use_beta_table || matches!(name, "RRRF100K" | "RRRF10K" | "HT100K")) {
        thermistor.table = None;
    }
    // All other thermistors have 100 kOhm and fit the divider on the board.
    if name == "RRRF10K" {
        let meant = [("r0", &mut thermistor.r0, 10_000.0), ("r1", &mut thermistor.r1, 680.0)];
        for (key, place, ohms) in meant.into_iter().chain([("r2", &mut thermistor.r2, 1_600.0)]) {
            *place = if is_written(key) { *place } else { Ohms(ohms) };
        }
    }
}

/// Numbers the controls without a number as Smoothieware does: in the order of their names, less one for each
/// that is enabled. Smoothieware may give two controls one number; here the second gets the next free one.
fn number(config: &mut MachineConfig) {
    let heaters = &mut config.temperatures;
    for before in 0..heaters.len() {
        let rank = |name: &str| heaters.iter().filter(|other| other.enable && *other.name < *name).count();
        let next = heaters.iter().position(|heater| heater.enable && rank(&heater.name) == before);
        let Some(place) = next.filter(|place| heaters.get(*place).is_some_and(|heater| heater.tool_id == NO_NUMBER))
        else {
            continue;
        };
        let is_free = |number: &u8| !heaters.iter().any(|other| other.enable && other.tool_id == ToolId(*number));
        let number = (0..=LAST_FREE_NUMBER.saturating_sub(before as u8)).rev().find(is_free);
        if let (Some(number), Some(heater)) = (number, heaters.get_mut(place)) {
            heater.tool_id = ToolId(number);
        }
    }
}

fn temperatures(config: &mut MachineConfig, written: Written) {
    const SECTION: &str = "temperature control";
    for (place, heater) in config.temperatures.iter_mut().enumerate() {
        let has_own = matches!(heater.name.as_str(), "hotend" | "hotend2" | "bed" | "board");
        if !has_own && !written(SECTION, place, "tool_id") {
            heater.tool_id = NO_NUMBER;
        }
    }
    number(config);
    for (place, heater) in config.temperatures.iter_mut().enumerate() {
        if !written(SECTION, place, "i_max") {
            heater.pid.i_max = f32::from(heater.max_pwm.0);
        }
        thermistor(&mut heater.sensor.thermistor, |key| written(SECTION, place, key));
        if !written(SECTION, place, "runaway_cooling_timeout") {
            heater.runaway.cooling_timeout = heater.runaway.heating_timeout;
        }
        let is_bed = heater.tool_id >= ToolId::FIRST_BED;
        if !written(SECTION, place, "verify_gain_time") {
            heater.verify.gain_time = Some(if is_bed { BED_GAIN_TIME } else { HOT_END_GAIN_TIME });
        }
        let [sets, waits] = match (heater.name.as_str(), is_bed) {
            ("chamber", _) => [141, 191],
            (_, true) => [140, 190],
            (_, false) => [104, 109],
        };
        if !written(SECTION, place, "set_m_code") {
            heater.set_m_code = sets;
        }
        if !written(SECTION, place, "set_and_wait_m_code") {
            heater.set_and_wait_m_code = waits;
        }
        if !written(SECTION, place, "heater_power") {
            heater.model.power_w = if is_bed { BED_WATTS } else { HOT_END_WATTS };
        }
        // A bed melts nothing.
        if !heater.is_hot_end() {
            heater.model.filament_heat = 0.0;
        }
    }
}

fn switches(config: &mut MachineConfig, written: Written) {
    for (place, switch) in config.switches.iter_mut().enumerate() {
        let subcode = switch.subcode;
        let codes = [&mut switch.input_on_command, &mut switch.input_reverse_command, &mut switch.input_off_command];
        for code in codes.into_iter().flatten() {
            if code.subcode == 0 {
                code.subcode = subcode;
            }
        }
        let Duty(most) = switch.max_pwm;
        let is_sigma_delta = switch.output_kind == OutputKind::SigmaDelta;
        if !written("switch", place, "startup_value") {
            switch.startup_value = if is_sigma_delta { f32::from(most) } else { 0.0 };
        } else if is_sigma_delta {
            switch.startup_value = switch.startup_value.min(f32::from(most));
        }
    }
}

/// Strips without a number of their own have those that are free, in the order of their names.
fn strips(config: &mut MachineConfig, written: Written) {
    let mut taken = 0_u16;
    let mut unnumbered = 0_u16;
    for (place, strip) in config.led_strips.iter().enumerate().filter(|(_, strip)| strip.enable) {
        if written("led strip", place, "number") && strip.number < 16 {
            taken |= 1 << strip.number;
        } else {
            unnumbered |= 1 << place;
        }
    }
    while unnumbered != 0 {
        let places = config.led_strips.iter().enumerate().filter(|(place, _)| unnumbered & 1 << place != 0);
        let Some((place, _)) = places.min_by(|(_, a), (_, b)| a.name.cmp(&b.name)) else { return };
        unnumbered &= !(1 << place);
        let free = taken.trailing_ones();
        taken |= 1 << free;
        if let Some(strip) = config.led_strips.get_mut(place) {
            strip.number = free as u8;
        }
    }
}

fn drivers(config: &mut MachineConfig, written: Written) {
    for actuator in Actuator::ALL {
        let place = actuator as usize;
        let motor = &mut config.actuators[actuator];
        if !written("actuator", place, "dir_setup_ns") {
            motor.dir_setup_ns = if motor.driver == DriverKind::External { 5_000 } else { 500 };
        }
        let turn = config.turn_a_second(actuator);
        stealth_driver(config, actuator, written);
        for (section, family) in [("tmc2590", &mut config.tmc2590), ("tmc2660", &mut config.tmc2660)] {
            if !written(section, place, "stall_least_speed") {
                family.axes[actuator].stall_least_speed = turn;
            }
        }
        if !written("tmc2590", place, "max_current") {
            let chip = &mut config.tmc2590.axes[actuator];
            // Smoothieware's ceilings for the resistors its boards were built with.
            let milliohms = chip.sense_resistor.get() * 1_000.0;
            chip.max_current = Amps(match milliohms {
                r if (49.5..50.5).contains(&r) => 5.5,
                r if (74.5..75.5).contains(&r) => 4.4,
                _ => 3.2,
            });
        }
    }
    slave_currents(config);
}

/// A slaved motor without a current of its own has its master's.
fn slave_currents(config: &mut MachineConfig) {
    for motor in Actuator::ALL {
        let of_master = config.actuators[motor].slaved_to.and_then(|master| config.actuators[master].current);
        let settings = &mut config.actuators[motor];
        if settings.driver.is_spoken_with() {
            settings.current = settings.current.or(of_master);
        }
    }
}

/// Sets an external driver's greatest current to the value its resistor can measure, as far as its bridges
/// bear it.
fn stealth_driver(config: &mut MachineConfig, actuator: Actuator, written: Written) {
    let turn = config.turn_a_second(actuator);
    for kind in DriverKind::OUTSIDE {
        let Some(family) = config.stealth_family_mut(kind) else { continue };
        let chip = &mut family.axes[actuator];
        if !written(kind.name(), actuator as usize, "stall_least_speed") {
            chip.stall_least_speed = turn;
        }
        let measurable = chip.resistor.and_then(|resistor| kind.measurable(resistor));
        if let Some(most) = measurable.filter(|_| !written(kind.name(), actuator as usize, "max_current")) {
            let most = kind.most_current().filter(|bearable| *bearable < most).unwrap_or(most);
            // Cuts to whole mA, as written in the file.
            chip.max_current = Amps((most.get() * 1_000.0 + 0.5) as u32 as f32 / 1_000.0);
        }
    }
}

/// Removes pins and enabling from the parts that stay off, so that nothing of them is wired. Names and codes
/// stay: the commands are refused with the reason.
pub(crate) fn switch_off(config: &mut MachineConfig, ledger: &Ledger) {
    forget_disabled(config, ledger);
    without_their_timer(config);
    let off = core::mem::take(&mut config.off);
    let is_off =
        |section: &str, name: &str| off.iter().any(|o| o.section == section && (o.name.is_empty() || o.name == name));
    for heater in config.temperatures.iter_mut().filter(|heater| is_off("temperature control", &heater.name)) {
        heater.enable = true;
        heater.heater_pin = None;
        heater.sensor.thermistor.input = None;
        heater.sensor.spi.select_pin = None;
        heater.combines.clear();
    }
    for switch in config.switches.iter_mut().filter(|switch| is_off("switch", &switch.name)) {
        switch.enable = true;
        (switch.input_pin, switch.output_pin) = (None, None);
    }
    for extruder in config.extruders.iter_mut().filter(|extruder| is_off("extruder", &extruder.name)) {
        extruder.enable = true;
    }
    config.voltages.retain(|voltage| !is_off("voltage monitor", &voltage.name));
    for (frequency, section) in config.pwm_frequency_hz.iter_mut().zip(["pwm1", "pwm2"]) {
        if is_off(section, "") {
            *frequency = None;
        }
    }
    if is_off("input shaper", "") {
        config.input_shapers.iter_mut().for_each(|shaper| shaper.frequency_hz = None);
    }
    config.probe.enable &= !is_off("zprobe", "");
    if is_off("bed mesh", "") {
        // A faulty `[bed mesh]` may hold regions that the probe must not touch.
        config.leveling.strategy = None;
    }
    if is_off("z alignment", "") {
        config.z_alignment.motors.clear();
    }
    if is_off("z thermal adjust", "") {
        config.z_thermal.sensor.clear();
    }
    if is_off("axis twist compensation", "") {
        config.axis_twist = crate::AxisTwist::default();
    }
    if is_off("bed screws", "") {
        config.bed_screws.screws.clear();
    }
    config.uart.enable &= !is_off("uart console", "");
    config.laser.enable &= !is_off("laser", "");
    config.filament_detector.enable &= !is_off("filament detector", "");
    config.filament_width.enable &= !is_off("filament width sensor", "");
    config.player.on_boot_gcode_enable &= !is_off("player", "");
    config.buttons.retain(|button| !is_off("button box", &button.name));
    config.fans.retain(|fan| !is_off("fan", &fan.name));
    config.led_strips.retain(|strip| !is_off("led strip", &strip.name));
    config.temperature_switches.retain(|rule| !is_off("temperature switch", &rule.name));
    config.off = off;
}

/// Puts the switches on the channels of a timer that stays off out of service too.
fn without_their_timer(config: &mut MachineConfig) {
    for switch in config.switches.iter().filter(|switch| switch.enable) {
        let Some(OutputPin::Pwm(pwm)) = switch.output_pin else { continue };
        let timer = if pwm.timer == 1 { "pwm1" } else { "pwm2" };
        let known =
            config.off.iter().any(|off| off.section == "switch" && (off.name.is_empty() || off.name == switch.name));
        let Some(cause) = config.off.iter().find(|off| off.section == timer).filter(|_| !known) else { continue };
        let module = OffModule { section: "switch", name: switch.name.clone(), ..cause.clone() };
        // Without room the switch has no entry in the list, but no timer either.
        let _ = config.off.push(module);
    }
}

/// Forgets the faults of parts that the file does not enable: nobody needs to hear of them.
fn forget_disabled(config: &mut MachineConfig, ledger: &Ledger) {
    let mut off = core::mem::take(&mut config.off);
    off.retain(|module| {
        let Some((_, section)) = crate::schema::section(module.section) else { return true };
        let place = section.instances().and_then(|instances| (instances.find)(config, &module.name));
        let enable = Path::named(module.section, place.unwrap_or_default(), "enable");
        let is_live = match (section.instances(), place) {
            (Some(instances), Some(place)) => (instances.is_live)(config, place),
            // Every instance, or one that could not be made.
            (Some(_), None) => true,
            (None, _) => match module.section {
                "zprobe" => config.probe.enable,
                "uart console" => config.uart.enable,
                "laser" => config.laser.enable,
                "filament detector" => config.filament_detector.enable,
                "filament width sensor" => config.filament_width.enable,
                _ => true,
            },
        };
        is_live || enable.is_some_and(|enable| ledger.is_unreadable(enable))
    });
    config.off = off;
}

/// Removes the instances that are not enabled, and sorts the rest by name, as Smoothieware visits them.
pub(crate) fn keep_enabled(config: &mut MachineConfig) {
    macro_rules! keep_enabled {
        ($($list:ident),+) => {
            $(
                config.$list.retain(|one| one.enable);
                sort_short(&mut config.$list, |a, b| a.name.cmp(&b.name));
            )+
        };
    }
    keep_enabled!(extruders, temperatures, endstops, switches, buttons, fans, led_strips, temperature_switches);
    name_parts(config);
}

/// Resolves the names in combined sensors, in the fans of heaters and in the controls that fans watch, now
/// that all instances have their places.
fn name_parts(config: &mut MachineConfig) {
    for place in 0..config.temperatures.len() {
        let Some(heater) = config.temperatures.get(place) else { return };
        let mut parts = [None; units::MAX_HEATERS];
        for (part, name) in parts.iter_mut().zip(heater.part_names()) {
            *part = config.heaters().find(|(_, other)| other.name == name).map(|(id, _)| id);
        }
        if let Some(heater) = config.temperatures.get_mut(place) {
            heater.sensor.parts = parts;
            let named = |switch: &crate::SwitchConfig| switch.name == heater.fan_name && !switch.is_input();
            heater.fan = config.switches.iter().position(named).and_then(|place| u8::try_from(place).ok());
        }
    }
    let MachineConfig { fans, temperatures, .. } = config;
    for fan in fans {
        let watched = |name: &str| temperatures.iter().position(|control| control.name == name);
        fan.watched = fan.sensor_names().filter_map(watched).fold(0, |bits, place| bits | 1 << place);
    }
}
