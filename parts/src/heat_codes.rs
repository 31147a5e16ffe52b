//! Codes for temperatures: targets, waits, reports, gains and limits.

mod gains;
pub mod named;
mod preheat;
mod sensors;
mod wait;

use core::fmt;

use base::failure::{Failure, Texts};
use base::hands::Hands;
use base::ports::HeatPort;
use base::sessions::Reply;
use config::{HeaterId, MachineConfig};
use units::Celsius;

pub use gains::{heater_model, maximum_temperature, pid_gains};
pub use named::{heater_named, heater_of};
pub use preheat::preheat;
pub use sensors::{sensors, write_sensor};
use thermal::{HeatCause, HeatControl, HeatFault, OFF_BELOW, TargetRefused};
pub use wait::{heat_and_wait, wait_for_all, wait_for_first_reading, wait_for_temperature};

/// Temperature reported for an unreadable sensor, C.
const NO_READING: f32 = -100.0;

// --- setting and waiting ---

/// Refuses to heat without the heaters' supply.
///
/// # Errors
/// An alarm, when the supply is off and the target is not.
pub fn check_supply<'c>(hands: &mut impl Hands<'c>, target: Celsius) -> Result<(), Failure> {
    if target > OFF_BELOW && !hands.supervisor(|supervisor| supervisor.fet_supply_on()) {
        return Err(no_heater_supply());
    }
    Ok(())
}

/// Returns the alarm that heaters have no supply.
pub fn no_heater_supply() -> Failure {
    Failure::alarm(&"heater supply is off (vfet below 6 V): switch it on, then M999")
}

/// Refuses a target that the heater would refuse, before anything waits or changes for it.
///
/// # Errors
/// When it is above the heater's maximum.
pub fn check_target(
    texts: &Texts,
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    heater: HeaterId,
    target: Celsius,
) -> Result<(), Failure> {
    ports.heat(|heat| allow_target(texts, heat, config, heater, target))
}

/// Sets a target at once.
///
/// # Errors
/// When the heater does not allow it, or there is no such heater.
pub fn set_target(
    texts: &Texts,
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    heater: HeaterId,
    target: Celsius,
) -> Result<(), Failure> {
    ports.heat(|heat| change_target(texts, heat, config, heater, target))
}

/// Does what [`check_target`] does, for callers that hold heat control.
pub fn allow_target(
    texts: &Texts,
    heat: &HeatControl,
    config: &MachineConfig,
    heater: HeaterId,
    target: Celsius,
) -> Result<(), Failure> {
    let max = heat.heater(heater).map(|heater| heater.settings.max);
    match max.filter(|max| target > *max) {
        Some(max) => {
            let why = TargetRefused::AboveMaximum(max);
            Err(TargetRefusal { config, heater, target, why }.failure(texts))
        }
        None => Ok(()),
    }
}

/// Does what [`set_target`] does, for callers that hold heat control.
pub fn change_target(
    texts: &Texts,
    heat: &mut HeatControl,
    config: &MachineConfig,
    heater: HeaterId,
    target: Celsius,
) -> Result<(), Failure> {
    heat.set_target(heater, target).map_err(|why| TargetRefusal { config, heater, target, why }.failure(texts))
}

/// Refusal of a target, with the reason.
pub struct TargetRefusal<'c> {
    /// Configuration of the heaters.
    pub config: &'c MachineConfig,
    /// Heater that was to have the target.
    pub heater: HeaterId,
    /// Target that was refused.
    pub target: Celsius,
    /// Reason of the refusal.
    pub why: TargetRefused,
}

impl fmt::Display for TargetRefusal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.config.heater(self.heater).map_or("?", |heater| heater.name.as_str());
        match self.why {
            TargetRefused::AboveMaximum(max) => {
                write!(f, "{name}: {:.1} C is above its max_temp {:.1} C", self.target.0, max.0)
            }
            TargetRefused::HasNoHeater => write!(f, "{name} is a sensor without a heater"),
        }
    }
}

impl TargetRefusal<'_> {
    /// Makes the failure for the command that set the target.
    pub fn failure(&self, texts: &Texts) -> Failure {
        texts.refused(format_args!("{self}"))
    }
}

// --- saying temperatures ---

/// Text `T:25.0 /0.0 @0`: reading, target, output.
pub struct TemperatureText<'c> {
    designator: &'c str,
    reading: f32,
    target: f32,
    duty: u8,
}

impl fmt::Display for TemperatureText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { designator, reading, target, duty } = self;
        write!(f, "{designator}:{reading:.1} /{target:.1} @{duty}")
    }
}

/// Returns the temperature of a heater or sensor; `None` when there is none with this id.
pub fn temperature_text<'c>(
    heat: &HeatControl,
    config: &'c MachineConfig,
    heater: HeaterId,
) -> Option<TemperatureText<'c>> {
    let designator = config.heater(heater)?.designator.as_str();
    let heater = heat.heater(heater)?;
    let reading = heater.reading().map_or(NO_READING, |celsius| celsius.0);
    Some(TemperatureText { designator, reading, target: heater.target().0, duty: heater.duty().0 })
}

/// Prints `T:25.0 /0.0 @0 B:24.9 /0.0 @0 ` of all heaters that listen to this code, behind a beginning: `ok `
/// for M105.
pub fn report_temperatures(
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    get_m_code: u16,
    (before, reply): (&str, &mut Reply<'_>),
) {
    reply.say(format_args!("{before}"));
    for (id, _) in config.heaters().filter(|(_, heater)| heater.get_m_code == get_m_code) {
        if let Some(text) = ports.heat(|heat| temperature_text(heat, config, id)) {
            reply.say(format_args!("{text} "));
        }
    }
    reply.say(format_args!("\n"));
}

/// Fault that stopped heating, as text.
pub struct HeatFaultText<'c> {
    /// Configuration of the heaters.
    pub config: &'c MachineConfig,
    /// The fault.
    pub fault: HeatFault,
}

impl fmt::Display for HeatFaultText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.designator(self.fault.heater);
        self.of_sensor(f, name).or_else(|| self.of_heater(f, name)).unwrap_or(Ok(()))
    }
}

impl HeatFaultText<'_> {
    fn designator(&self, heater: HeaterId) -> &str {
        self.config.heater(heater).map_or("?", |heater| heater.designator.as_str())
    }

    /// Writes a fault of which the sensor is suspected; `None` for every other one.
    fn of_sensor(&self, f: &mut fmt::Formatter<'_>, name: &str) -> Option<fmt::Result> {
        Some(match self.fault.cause {
            HeatCause::NoReading(fault) => {
                let part = fault.part().and_then(|part| self.config.heater(part)).map_or("", |part| &part.name);
                let colon = if part.is_empty() { "" } else { ": " };
                write!(f, "MINTEMP or MAXTEMP triggered on {name}: {part}{colon}{}", fault.message())
            }
            HeatCause::BelowMinimum(Celsius(at)) | HeatCause::AboveMaximum(Celsius(at)) => {
                write!(f, "MINTEMP or MAXTEMP triggered on {name}. Check your temperature sensors! (reads {at:.1})")
            }
            HeatCause::RisesTooFast(Celsius(by)) => write!(
                f,
                "{name} reads {by:.0} C more than a second before: no heater warms so fast. Check its sensor's plug and wire"
            ),
            HeatCause::FallsTooFast(Celsius(by)) => write!(
                f,
                "{name} reads {by:.0} C less than a second before: its sensor has come off or is shorting. TURN POWER OFF"
            ),
            HeatCause::Erratic => {
                write!(f, "{name}: the reading jumps up and down: a loose contact, or noise on its wire")
            }
            HeatCause::Frozen(time) => write!(
                f,
                "{name} has read exactly the same for {} s while its output changed: its sensor or converter stands",
                time.seconds()
            ),
            HeatCause::Swapped(other) => {
                let other = self.designator(other);
                write!(f, "{name} warms the sensor of {other}, not its own: swap their heater or sensor plugs")
            }
            HeatCause::FallsWhileDriven(_)
            | HeatCause::Stalls
            | HeatCause::NoResponse(..)
            | HeatCause::Sinking(_)
            | HeatCause::FullTooLong(_)
            | HeatCause::HeldTooLong(_)
            | HeatCause::DrivenWithoutTarget
            | HeatCause::HeatingTooSlow
            | HeatCause::DoesNotCool(_)
            | HeatCause::Runaway(_)
            | HeatCause::StuckOn(_)
            | HeatCause::ExecutorSilent => return None,
        })
    }

    /// Writes a fault of which heater or output is suspected; `None` for every other one.
    fn of_heater(&self, f: &mut fmt::Formatter<'_>, name: &str) -> Option<fmt::Result> {
        Some(match self.fault.cause {
            HeatCause::FallsWhileDriven(Celsius(by)) => write!(
                f,
                "{name} cools by {by:.0} C in 3 s at full output: its heater has failed, or its sensor slides out. TURN POWER OFF"
            ),
            HeatCause::Stalls => write!(
                f,
                "{name} stopped warming at full output: its sensor slides out, or its heater has failed. TURN POWER OFF"
            ),
            HeatCause::NoResponse(within, Celsius(gain)) => write!(
                f,
                "{name} was given full output for {} s and did not warm by {gain} C: check heater, supply, and that the \
                 sensor is on it",
                within.seconds()
            ),
            HeatCause::Sinking(Celsius(by)) => write!(
                f,
                "{name} has sunk {by:.0} C below its target: heater failing, sensor loose, or cooled too much"
            ),
            HeatCause::FullTooLong(limit) => write!(
                f,
                "{name} was at full output for {} s, its full_power_timeout: it is too weak for its target",
                limit.seconds()
            ),
            HeatCause::HeldTooLong(limit) => {
                write!(f, "{name} was on at one target for {} s, its hold_timeout", limit.seconds())
            }
            HeatCause::DrivenWithoutTarget => {
                write!(f, "the output of {name} was on without a target: a mistake of the firmware, please report it")
            }
            HeatCause::HeatingTooSlow => write!(
                f,
                "Temperature took too long to be reached on {name}, HALT asserted, TURN POWER OFF IMMEDIATELY"
            ),
            HeatCause::DoesNotCool(Celsius(at)) => write!(
                f,
                "{name} stays at {at:.0} C without being heated: its MOSFET or relay conducts. TURN POWER OFF IMMEDIATELY"
            ),
            HeatCause::Runaway(Celsius(by)) => write!(
                f,
                "Temperature runaway on {name} (delta temp {by:.6}), HALT asserted, TURN POWER OFF IMMEDIATELY"
            ),
            HeatCause::StuckOn(Celsius(by)) => write!(
                f,
                "{name} is switched off and has warmed by {by:.0} C: its MOSFET or relay conducts. TURN POWER OFF IMMEDIATELY"
            ),
            HeatCause::ExecutorSilent => {
                let seconds = thermal::EXECUTOR_TIMEOUT.seconds();
                write!(f, "the controller did not answer for {seconds} s while {name} was on")
            }
            HeatCause::NoReading(_)
            | HeatCause::BelowMinimum(_)
            | HeatCause::AboveMaximum(_)
            | HeatCause::RisesTooFast(_)
            | HeatCause::FallsTooFast(_)
            | HeatCause::Erratic
            | HeatCause::Frozen(_)
            | HeatCause::Swapped(_) => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::{TemperatureConfig, ToolId};

    fn config() -> MachineConfig {
        let mut config = MachineConfig::default();
        for (name, designator, id) in [("bed", "B", 250), ("hotend", "T", 0)] {
            let heater = TemperatureConfig {
                name: name.try_into().unwrap(),
                designator: designator.try_into().unwrap(),
                tool_id: ToolId(id),
                max_temp: Celsius(120.0),
                ..TemperatureConfig::default()
            };
            assert!(config.temperatures.push(heater).is_ok());
        }
        config
    }

    fn control(config: &MachineConfig) -> HeatControl {
        let mut control = HeatControl::new();
        for heater in &config.temperatures {
            assert!(control.add(heater.into()).is_some());
        }
        control
    }

    #[test]
    fn a_heater_that_nobody_has_is_refused_with_those_there_are() {
        let config = config();
        let texts = Texts::new();
        let names = |word| heater_named(&texts, &config, 301, 'S', word);
        assert_eq!(names(0.0).map(HeaterId::index), Ok(1));
        for word in ["7", "0.5", "-1"] {
            let text = format!("M301: no temperature control has tool_id {word}; there are S250 bed, S0 hotend");
            assert_eq!(texts.of(names(word.parse().unwrap()).unwrap_err()).to_string(), text);
        }
    }

    #[test]
    fn a_target_above_the_maximum_is_refused_by_name() {
        let config = config();
        let control = control(&config);
        let hotend = HeaterId::all().nth(1).unwrap();
        let texts = Texts::new();
        assert_eq!(allow_target(&texts, &control, &config, hotend, Celsius(120.0)), Ok(()));
        let refused = allow_target(&texts, &control, &config, hotend, Celsius(121.0)).unwrap_err();
        assert_eq!(texts.of(refused).to_string(), "hotend: 121.0 C is above its max_temp 120.0 C");
    }

    #[test]
    fn what_only_reads_cannot_be_given_a_target() {
        let config = config();
        let mut control = control(&config);
        let bed = HeaterId::all().next().unwrap();
        let texts = Texts::new();
        let refused = change_target(&texts, &mut control, &config, bed, Celsius(50.0)).unwrap_err();
        assert_eq!(texts.of(refused).to_string(), "bed is a sensor without a heater");
        assert_eq!(change_target(&texts, &mut control, &config, bed, Celsius(0.0)), Ok(()));
    }

    #[test]
    fn a_sensor_without_a_reading_is_reported_as_far_below_zero() {
        let config = config();
        let bed = HeaterId::all().next().unwrap();
        let text = temperature_text(&control(&config), &config, bed).unwrap();
        assert_eq!(text.to_string(), "B:-100.0 /0.0 @0");
    }
}
