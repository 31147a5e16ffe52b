//! Checks of pins: owners, reserved pins, and pins without the capability that is asked for.

use super::findings::Checks;
use crate::board::{self, Pad};
use crate::diagnostic::Severity;
use crate::ledger::{Path, Span};
use crate::machine::{DriverKind, EndstopConfig, HomingDirection};
use crate::pin::{Pin, PinName, Pull};
use crate::report::At;
use crate::schema::{Kind, PinRole, SECTIONS};
use heapless::Vec;
use units::Axis;

/// Claim of a pad by its user. The setting is none for pads that the board itself or a bus uses.
#[derive(Clone, Copy)]
struct Claim {
    pad: Pad,
    owner: Owner,
}

#[derive(Clone, Copy)]
enum Owner {
    Setting(Path),
    Bus(&'static str),
}

const MAX_CLAIMS: usize = 200;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    fixed(checks);
    let mut claims: Vec<Claim, MAX_CLAIMS> = Vec::new();
    buses(checks, &mut claims);
    let pins = checks.ledger.pins();
    for &(path, name) in pins {
        if !is_in_use(checks, path) {
            continue;
        }
        can_do(checks, path, name);
        if let Some(pad) = board::pad_of(name) {
            claim(checks, &mut claims, path, pad, name);
        }
    }
    if let Some((section, _)) = crate::schema::section("voltage monitor") {
        for (place, voltage) in checks.config.voltages.iter().enumerate() {
            if let Some(pad) = board::voltage_pad(voltage.input) {
                let name = PinName::Digital(Pin { port: pad.0, number: pad.1, ..Pin::new('A', 0) });
                claim(checks, &mut claims, Path::new(section, 0, place), pad, name);
            }
        }
    }
    interrupt_lines(checks);
}

/// The board's own enables: their copper leads to one pin each.
fn fixed(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    for (setting, pin, (port, number), what) in [
        (("system", "fets_enable_pin"), config.system.fets_enable_pin, ('F', 14), "PF14!o"),
        (("system", "fets_power_enable_pin"), config.system.fets_power_enable_pin, ('D', 7), "PD7"),
        (("actuator", "motors_enable_pin"), config.motors.motors_enable_pin, ('H', 13), "PH13!"),
    ] {
        let (section, key) = setting;
        if let Some(pin) = pin.filter(|pin| !board::is_pad((pin.port, pin.number), port, number)) {
            let reason = format_args!("{pin} is another pin than the one this board has for it");
            checks.error((section, 0, key), reason, format_args!("write {what}, or delete the line"));
        }
    }
}

fn span(checks: &Checks<'_, '_>, path: Path) -> Span {
    checks.ledger.place(path, checks.config)
}

/// Whether the setting's instance takes part, and the setting means something for it.
pub(super) fn is_in_use(checks: &Checks<'_, '_>, path: Path) -> bool {
    let config = checks.config;
    let (Some(section), Some(setting)) = (path.section(), path.setting()) else { return false };
    let place = usize::from(path.place);
    let lives = setting.is_common || section.instances().is_none_or(|instances| (instances.is_live)(config, place));
    lives
        && match (section.name, setting.key) {
            ("actuator", "en_pin") => config.actuators.0.get(place).is_some_and(|motor| !motor.driver.is_on_board()),
            ("actuator", "motors_enable_pin") => uses_driver_chips(checks),
            ("tmc2590", "reset_pin") => config.actuators().any(|(_, motor)| motor.driver == DriverKind::Tmc2590),
            ("system", "msc_led") => config.system.msc_enable,
            ("uart console", _) => config.uart.enable,
            ("network", _) => config.network.enable,
            ("zprobe", _) => config.probe.enable,
            ("kill button", _) => config.kill_button.enable,
            ("safety door", _) => config.safety_door.enable,
            ("laser", _) => config.laser.enable,
            ("filament detector", "detector_pin") => {
                config.filament_detector.enable && config.filament_detector.bulge_pin.is_none()
            }
            ("filament detector", _) => config.filament_detector.enable,
            ("filament width sensor", _) => config.filament_width.enable,
            ("switch", "output_pin") => config.switches.get(place).is_some_and(|switch| !switch.is_input()),
            ("temperature control", key) => config.temperatures.get(place).is_some_and(|heater| match key {
                "thermistor_pin" => heater.sensor.kind.is_analog(),
                "spi_select_pin" => heater.sensor.kind.is_on_spi(),
                _ => true,
            }),
            _ => true,
        }
}

fn uses_driver_chips(checks: &Checks<'_, '_>) -> bool {
    checks.config.actuators().any(|(_, motor)| motor.driver.is_on_board())
}

/// Pads of the buses that are in use.
fn buses(checks: &Checks<'_, '_>, claims: &mut Vec<Claim, MAX_CLAIMS>) {
    let config = checks.config;
    let mut add = |pads: &[Pad], name| {
        for &pad in pads {
            // The buses' dozen pads are the first claims of many.
            let _ = claims.push(Claim { pad, owner: Owner::Bus(name) });
        }
    };
    for channel in [0, 1] {
        let by_drivers = config
            .actuators()
            .filter_map(|(_, motor)| {
                let on_board = config.driver_family(motor.driver).map(|family| family.spi_channel);
                let outside = config.stealth_family(motor.driver).filter(|_| !motor.driver.is_on_uart());
                on_board.or(outside.map(|family| family.channel))
            })
            .any(|used| used == channel);
        let by_sensors = config
            .temperatures
            .iter()
            .filter(|heater| heater.enable)
            .any(|heater| heater.sensor.kind.is_on_spi() && heater.sensor.spi.channel == Some(channel));
        if by_drivers || by_sensors {
            let (name, pads) = board::spi_pads(channel);
            add(&pads, name);
        }
    }
    if config.uart.enable {
        add(&board::uart_pads(config.uart.channel), "[uart console]");
    }
    for channel in [0, 1] {
        let is_console = config.uart.enable && config.uart.channel == channel;
        if !is_console && config.actuators().any(|(motor, _)| config.driver_uart(motor) == Some(channel)) {
            add(&board::uart_pads(channel), "the drivers' UART");
        }
    }
}

fn claim(checks: &mut Checks<'_, '_>, claims: &mut Vec<Claim, MAX_CLAIMS>, path: Path, pad: Pad, name: PinName) {
    let key = path.text(checks.config);
    let at = span(checks, path);
    let pin = name.without_modifiers();
    if let Some(purpose) = name.digital().and_then(board::reserved_for) {
        let reason = format_args!("{pin} belongs to {purpose}");
        let at = At::new(at, &key, path.module(checks.config));
        checks.reporter.report(Severity::Error, at, reason, format_args!("use another pin"));
    }
    match claims.iter().find(|claim| claim.pad == pad).map(|claim| claim.owner) {
        None => {
            // There are fewer pin settings than places for claims.
            let _ = claims.push(Claim { pad, owner: Owner::Setting(path) });
        }
        Some(Owner::Bus(name)) => {
            let reason = format_args!("{pin} is used by {name} already");
            let at = At::new(at, &key, path.module(checks.config));
            checks.reporter.report(Severity::Error, at, reason, format_args!("use another pin"));
        }
        Some(Owner::Setting(first)) => {
            two_owners(checks, first, path, pin);
        }
    }
}

/// Reports two users of a pad, at the later of their lines; a default has no line.
fn two_owners(checks: &mut Checks<'_, '_>, one: Path, other: Path, pin: PinName) {
    let line = |path| checks.ledger.span(path).map_or(0, |span| span.line);
    let (first, second) = if line(one) <= line(other) { (one, other) } else { (other, one) };
    let (owner, line) = (first.text(checks.config), line(first));
    let (key, at) = (second.text(checks.config), span(checks, second));
    let fix = format_args!("use another pin for one of them, or nc");
    // Nobody can tell which of the two is wrong, so neither is driven.
    let at = At::new(at, &key, first.module(checks.config)).and(second.module(checks.config));
    let mut say = |reason| checks.reporter.report(Severity::Error, at, reason, fix);
    match line {
        0 => say(format_args!("{pin} is used by {owner} already, by default")),
        _ => say(format_args!("{pin} is used by {owner} already, in line {line}")),
    }
}

/// Checks modifiers and pads that cannot serve in this role.
fn can_do(checks: &mut Checks<'_, '_>, path: Path, name: PinName) {
    let (PinName::Digital(pin), Some(Kind::Pin(role))) = (name, path.setting().map(|setting| setting.kind)) else {
        return;
    };
    let key = path.text(checks.config);
    let at = span(checks, path);
    let at = At::new(at, &key, path.module(checks.config));
    let is_output = matches!(role, PinRole::Output | PinRole::OutputOrPwm);
    let pad = (pin.port, pin.number);
    let mut say = |severity, reason: &str, fix: &str| {
        checks.reporter.report(severity, at, format_args!("{pin}: {reason}"), format_args!("{fix}"));
    };
    if is_output && pin.pull != Pull::Default {
        say(Severity::Warning, "an output has no pull resistor", "delete ^, v or -");
    }
    if !is_output && pin.open_drain {
        say(Severity::Warning, "an input is never open drain", "delete the o");
    }
    if is_output && pad == board::NEEDS_OPEN_DRAIN && !pin.open_drain {
        say(Severity::Error, "its pull-up goes to 5 V, so it must be open drain", "write PF14!o");
    }
    if let Some(driver) = board::driven_by(pin).filter(|_| is_output) {
        let reason = format_args!("{pin}: {driver} drives it, so it cannot be an output");
        checks.reporter.report(Severity::Error, at, reason, format_args!("use another pin"));
    }
}

/// The chip has one interrupt line for each pin number, whatever the port. Switches that are watched at the
/// same time need lines of their own: those of X and Y, which home together; on a delta or a scara, those of
/// all three motors.
fn interrupt_lines(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let homing = &config.homing;
    let together: &[(Axis, Axis)] = if homing.delta || homing.rotary_delta || homing.scara {
        &[(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)]
    } else if homing.corexy || !homing.order.is_empty() {
        &[]
    } else {
        &[(Axis::X, Axis::Y)]
    };
    let pin_of = |axis| config.endstops.iter().position(|stop| stop.enable && homes(stop, axis));
    let number = |place: usize| config.endstops.get(place).and_then(|stop| stop.pin).map(|pin| pin.number);
    for (first, second) in together {
        let (Some(one), Some(other)) = (pin_of(*first), pin_of(*second)) else { continue };
        if let (Some(line), true) = (number(one), number(one) == number(other)) {
            let (first, second) = (first.letter(), second.letter());
            let reason = format_args!(
                "the {first} and {second} switches share interrupt line {line} and home together: the second to be hit is seen \
                 up to half a millisecond late"
            );
            let fix = match together.len() {
                1 => "use pins with different numbers, or homing_order",
                _ => "use pins with different numbers",
            };
            checks.warn(("endstops", one.max(other), "pin"), reason, format_args!("{fix}"));
        }
    }
}

fn homes(stop: &EndstopConfig, axis: Axis) -> bool {
    stop.axis == Some(axis) && stop.homing_direction != HomingDirection::None
}

const _: () = assert!(SECTIONS.len() <= 128, "the ledger keeps one bit per section");
