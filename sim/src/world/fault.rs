//! Faults that a run can be asked to suffer.

use units::Actuator;

use crate::models::converter::Leads;

/// Fault of the machine. Heaters, switches and motors are named as in the machine's configuration.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The sensor of this heater is not connected.
    ThermistorOpen(String),
    /// The sensor of this heater is shorted to ground.
    ThermistorShort(String),
    /// A wire of this heater's sensor touches the supply.
    SensorToSupply(String),
    /// Single leads of this heater's platinum sensor are at fault.
    SensorLead(String, Leads),
    /// The converter chip of this heater's sensor does not answer.
    ConverterSilent(String),
    /// Data line of this heater's sensor chip is at ground, as with a chip without supply.
    ConverterLow(String),
    /// The supply of this heater's sensor chip fails for a moment: the chip forgets its settings.
    ConverterReset(String),
    /// The sensor of this heater slides half out: it comes to feel as much of the air as of the heater.
    ThermistorSlips(String),
    /// The plug of this heater's sensor is loose: the reading jumps.
    ThermistorLoose(String),
    /// The wire of this heater's sensor picks up the switching of other loads: the reading is off by up to
    /// so many kelvin, either way.
    ThermistorNoisy(String, f64),
    /// The sensor of this heater comes to read more and more too much, or too little: kelvin per second.
    ThermistorDrifts(String, f64),
    /// The sensors of these two heaters are in each other's plugs.
    ThermistorsSwapped(String, String),
    /// The converter of the thermistors stands: its last results stay.
    AdcStands,
    /// The heater's switch conducts whatever its input.
    HeaterStuckOn(String),
    /// The heater gives no heat.
    HeaterDead(String),
    /// The heater gives this share of its power, 0 to 1: an element of several that has burnt out, a bad
    /// contact.
    HeaterWeak(String, f64),
    /// Something holds the fan of this name.
    FanStopped(String),
    /// The fan of this name hardly turns.
    FanSlow(String),
    /// The switch never operates.
    SwitchNeverOperates(String),
    /// The switch always reads as operated.
    SwitchAlwaysOperated(String),
    /// The contact of the switch bounces.
    SwitchBounces(String),
    /// The driver chip does not answer on SPI.
    DriverSilent(Actuator),
    /// A bit of every so many replies of the driver chip arrives wrong.
    DriverBitErrors(Actuator, u32),
    /// The driver chip is this hot, degrees Celsius.
    DriverTemperature(Actuator, i32),
    /// Coil A of the motor is not connected.
    DriverOpenLoad(Actuator),
    /// Coil A of the motor is shorted to ground.
    DriverShort(Actuator),
    /// Coil A of the motor is shorted to the motor supply.
    DriverShortToSupply(Actuator),
    /// A driver chip was without supply for a moment, which nothing but the chip has noticed.
    DriverReset(Actuator),
    /// The motor supply has this voltage.
    MotorSupply(f64),
    /// The supply of heaters and fans has this voltage.
    FetSupply(f64),
    /// The load switch of that supply conducts whatever its input.
    FetSwitchStuckOn,
    /// Everything of the above repaired.
    Repaired,
}

/// A fault and when it happens.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFault {
    /// Time of the fault, nanoseconds since power-on.
    pub at_ns: u64,
    /// Fault that happens then.
    pub fault: Fault,
}

/// Spelling of faults, for usage texts.
pub const SPELLING: &str = "thermistor-open:HEATER thermistor-short:HEATER sensor-to-supply:HEATER sensor-lead:HEATER,LEAD (force-open, minus-to-ground, plus-to-ground) converter-silent:HEATER converter-low:HEATER converter-reset:HEATER thermistor-slip:HEATER thermistor-loose:HEATER thermistor-noisy:HEATER,K thermistor-drifts:HEATER,K_PER_S thermistors-swapped:HEATER,HEATER adc-stands heater-stuck-on:HEATER heater-dead:HEATER heater-weak:HEATER,SHARE fan-stopped:FAN fan-slow:FAN \
switch-never:SWITCH switch-always:SWITCH switch-bounces:SWITCH driver-silent:MOTOR driver-bit-errors:MOTOR,EVERY driver-overheat:MOTOR driver-prewarn:MOTOR \
driver-open-load:MOTOR driver-short:MOTOR driver-short-to-supply:MOTOR driver-reset:MOTOR motor-supply:VOLTS fet-supply:VOLTS fet-switch-stuck-on \
repaired, each with @SECONDS for when";

impl TimedFault {
    /// Reads `kind[:object][@seconds]`, for example `thermistor-open:hotend@30`.
    ///
    /// # Errors
    /// What is wrong with the text, with the possible spellings.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (what, at_ns) = match text.split_once('@') {
            None => (text, 0),
            Some((what, seconds)) => {
                let seconds: f64 =
                    seconds.parse().map_err(|_| format!("fault `{text}`: `{seconds}` is not a time in seconds"))?;
                (what, (seconds * 1e9) as u64)
            }
        };
        let (kind, object) = what.split_once(':').unwrap_or((what, ""));
        let named = || match object {
            "" => Err(format!("fault `{text}`: which one? write {kind}:NAME")),
            name => Ok(name.to_owned()),
        };
        let motor_named = |name: &str| {
            Actuator::from_name(name).ok_or_else(|| format!("fault `{text}`: `{name}` is not a motor (alpha to zeta)"))
        };
        let motor = || motor_named(object);
        let with_number = || {
            let (name, number) = object.split_once(',')?;
            Some((name, number.parse::<f64>().ok()?))
        };
        let named_number = || {
            with_number().ok_or_else(|| format!("fault `{text}`: which one, and how much? write {kind}:NAME,NUMBER"))
        };
        let volts =
            || object.parse().map_err(|_| format!("fault `{text}`: `{object}` is not a voltage, write {kind}:VOLTS"));
        let fault = match kind {
            "thermistor-open" => Fault::ThermistorOpen(named()?),
            "thermistor-short" => Fault::ThermistorShort(named()?),
            "sensor-to-supply" => Fault::SensorToSupply(named()?),
            "sensor-lead" => {
                let lead = |(name, lead): (&str, &str)| {
                    let leads = match lead {
                        "force-open" => Leads::ForceOpen,
                        "minus-to-ground" => Leads::MinusToGround,
                        "plus-to-ground" => Leads::PlusToGround,
                        _ => return None,
                    };
                    Some(Fault::SensorLead(name.to_owned(), leads))
                };
                let read = object.split_once(',').and_then(lead);
                read.ok_or_else(|| format!("fault `{text}`: write sensor-lead:NAME,force-open or the like"))?
            }
            "converter-silent" => Fault::ConverterSilent(named()?),
            "converter-low" => Fault::ConverterLow(named()?),
            "converter-reset" => Fault::ConverterReset(named()?),
            "heater-stuck-on" => Fault::HeaterStuckOn(named()?),
            "thermistor-slip" => Fault::ThermistorSlips(named()?),
            "thermistor-loose" => Fault::ThermistorLoose(named()?),
            "thermistor-noisy" => {
                let (name, kelvin) = named_number()?;
                Fault::ThermistorNoisy(name.to_owned(), kelvin)
            }
            "thermistor-drifts" => {
                let (name, kelvin_per_s) = named_number()?;
                Fault::ThermistorDrifts(name.to_owned(), kelvin_per_s)
            }
            "heater-weak" => {
                let (name, share) = named_number()?;
                Fault::HeaterWeak(name.to_owned(), share)
            }
            "driver-bit-errors" => {
                let (name, every) = named_number()?;
                Fault::DriverBitErrors(motor_named(name)?, every as u32)
            }
            "thermistors-swapped" => {
                let two = object.split_once(',');
                let (one, other) = two.ok_or_else(|| format!("fault `{text}`: which two? write {kind}:NAME,NAME"))?;
                Fault::ThermistorsSwapped(one.to_owned(), other.to_owned())
            }
            "adc-stands" => Fault::AdcStands,
            "heater-dead" => Fault::HeaterDead(named()?),
            "fan-stopped" => Fault::FanStopped(named()?),
            "fan-slow" => Fault::FanSlow(named()?),
            "switch-never" => Fault::SwitchNeverOperates(named()?),
            "switch-always" => Fault::SwitchAlwaysOperated(named()?),
            "switch-bounces" => Fault::SwitchBounces(named()?),
            "driver-silent" => Fault::DriverSilent(motor()?),
            "driver-overheat" => Fault::DriverTemperature(motor()?, 160),
            "driver-prewarn" => Fault::DriverTemperature(motor()?, 125),
            "driver-open-load" => Fault::DriverOpenLoad(motor()?),
            "driver-short" => Fault::DriverShort(motor()?),
            "driver-short-to-supply" => Fault::DriverShortToSupply(motor()?),
            "driver-reset" => Fault::DriverReset(motor()?),
            "motor-supply" => Fault::MotorSupply(volts()?),
            "fet-supply" => Fault::FetSupply(volts()?),
            "fet-switch-stuck-on" => Fault::FetSwitchStuckOn,
            "repaired" => Fault::Repaired,
            _ => return Err(format!("fault `{text}` is not one of {SPELLING}")),
        };
        Ok(Self { at_ns, fault })
    }
}
