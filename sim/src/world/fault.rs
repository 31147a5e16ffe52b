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
        let fault = Words { text, kind, object }.fault()?;
        Ok(Self { at_ns, fault })
    }
}

/// A fault as it is written: all of the text, and `kind:object` in it.
struct Words<'a> {
    text: &'a str,
    kind: &'a str,
    object: &'a str,
}

impl Words<'_> {
    fn fault(&self) -> Result<Fault, String> {
        Ok(match self.kind {
            "thermistor-open" => Fault::ThermistorOpen(self.name()?),
            "thermistor-short" => Fault::ThermistorShort(self.name()?),
            "sensor-to-supply" => Fault::SensorToSupply(self.name()?),
            "sensor-lead" => self.lead()?,
            "converter-silent" => Fault::ConverterSilent(self.name()?),
            "converter-low" => Fault::ConverterLow(self.name()?),
            "converter-reset" => Fault::ConverterReset(self.name()?),
            "heater-stuck-on" => Fault::HeaterStuckOn(self.name()?),
            "thermistor-slip" => Fault::ThermistorSlips(self.name()?),
            "thermistor-loose" => Fault::ThermistorLoose(self.name()?),
            "thermistor-noisy" => self.name_and_number(|name, kelvin| Ok(Fault::ThermistorNoisy(name, kelvin)))?,
            "thermistor-drifts" => self.name_and_number(|name, rate| Ok(Fault::ThermistorDrifts(name, rate)))?,
            "heater-weak" => self.name_and_number(|name, share| Ok(Fault::HeaterWeak(name, share)))?,
            "driver-bit-errors" => {
                self.name_and_number(|name, every| Ok(Fault::DriverBitErrors(self.motor_named(&name)?, every as u32)))?
            }
            "thermistors-swapped" => self.two_names()?,
            "adc-stands" => Fault::AdcStands,
            "heater-dead" => Fault::HeaterDead(self.name()?),
            "fan-stopped" => Fault::FanStopped(self.name()?),
            "fan-slow" => Fault::FanSlow(self.name()?),
            "switch-never" => Fault::SwitchNeverOperates(self.name()?),
            "switch-always" => Fault::SwitchAlwaysOperated(self.name()?),
            "switch-bounces" => Fault::SwitchBounces(self.name()?),
            "driver-silent" => Fault::DriverSilent(self.motor()?),
            "driver-overheat" => Fault::DriverTemperature(self.motor()?, 160),
            "driver-prewarn" => Fault::DriverTemperature(self.motor()?, 125),
            "driver-open-load" => Fault::DriverOpenLoad(self.motor()?),
            "driver-short" => Fault::DriverShort(self.motor()?),
            "driver-short-to-supply" => Fault::DriverShortToSupply(self.motor()?),
            "driver-reset" => Fault::DriverReset(self.motor()?),
            "motor-supply" => Fault::MotorSupply(self.volts()?),
            "fet-supply" => Fault::FetSupply(self.volts()?),
            "fet-switch-stuck-on" => Fault::FetSwitchStuckOn,
            "repaired" => Fault::Repaired,
            _ => return Err(format!("fault `{}` is not one of {SPELLING}", self.text)),
        })
    }

    fn name(&self) -> Result<String, String> {
        match self.object {
            "" => Err(format!("fault `{}`: which one? write {}:NAME", self.text, self.kind)),
            name => Ok(name.to_owned()),
        }
    }

    fn motor(&self) -> Result<Actuator, String> {
        self.motor_named(self.object)
    }

    fn motor_named(&self, name: &str) -> Result<Actuator, String> {
        let motor = Actuator::from_name(name);
        motor.ok_or_else(|| format!("fault `{}`: `{name}` is not a motor (alpha to zeta)", self.text))
    }

    fn name_and_number(&self, fault: impl Fn(String, f64) -> Result<Fault, String>) -> Result<Fault, String> {
        let words = self.object.split_once(',').and_then(|(name, number)| Some((name, number.parse().ok()?)));
        let (name, number) = words.ok_or_else(|| {
            format!("fault `{}`: which one, and how much? write {}:NAME,NUMBER", self.text, self.kind)
        })?;
        fault(name.to_owned(), number)
    }

    fn two_names(&self) -> Result<Fault, String> {
        let two = self.object.split_once(',');
        let (one, other) =
            two.ok_or_else(|| format!("fault `{}`: which two? write {}:NAME,NAME", self.text, self.kind))?;
        Ok(Fault::ThermistorsSwapped(one.to_owned(), other.to_owned()))
    }

    fn lead(&self) -> Result<Fault, String> {
        let lead = |(name, lead): (&str, &str)| {
            let leads = match lead {
                "force-open" => Leads::ForceOpen,
                "minus-to-ground" => Leads::MinusToGround,
                "plus-to-ground" => Leads::PlusToGround,
                _ => return None,
            };
            Some(Fault::SensorLead(name.to_owned(), leads))
        };
        let read = self.object.split_once(',').and_then(lead);
        read.ok_or_else(|| format!("fault `{}`: write sensor-lead:NAME,force-open or the like", self.text))
    }

    fn volts(&self) -> Result<f64, String> {
        let not_volts =
            |_| format!("fault `{}`: `{}` is not a voltage, write {}:VOLTS", self.text, self.object, self.kind);
        self.object.parse().map_err(not_volts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Objects that stand for those of the usage text.
    fn written(spelling: &str) -> String {
        let objects = [
            ("HEATER,HEATER", "bed,hotend"),
            ("HEATER,LEAD", "hotend,minus-to-ground"),
            ("HEATER,K_PER_S", "hotend,-0.5"),
            ("HEATER,SHARE", "bed,0.5"),
            ("HEATER,K", "hotend,3"),
            ("MOTOR,EVERY", "beta,100"),
            ("HEATER", "hotend"),
            ("SWITCH", "minx"),
            ("MOTOR", "beta"),
            ("VOLTS", "9.5"),
            ("FAN", "fan"),
        ];
        objects.iter().fold(spelling.to_owned(), |text, (word, object)| text.replace(word, object))
    }

    #[test]
    fn every_spelling_is_a_fault_of_its_own() {
        let (kinds, _) = SPELLING.split_once(", each with").expect("the end of the list");
        let kinds = kinds.replace(" (force-open, minus-to-ground, plus-to-ground)", "");
        let mut faults: Vec<Fault> = Vec::new();
        for spelling in kinds.split_whitespace() {
            let fault = TimedFault::parse(&written(spelling)).unwrap_or_else(|reason| panic!("{reason}")).fault;
            assert!(!faults.contains(&fault), "{spelling} is another's");
            faults.push(fault);
        }
        assert!(faults.len() > 30, "the list is not read: {kinds}");
    }

    #[test]
    fn objects_and_times_are_read() {
        let parse = |text: &str| TimedFault::parse(text).unwrap();
        let weak = Fault::HeaterWeak("bed".into(), 0.25);
        assert_eq!(parse("heater-weak:bed,0.25@1.5"), TimedFault { at_ns: 1_500_000_000, fault: weak });
        assert_eq!(parse("motor-supply:9.5"), TimedFault { at_ns: 0, fault: Fault::MotorSupply(9.5) });
        assert_eq!(parse("driver-prewarn:gamma").fault, Fault::DriverTemperature(Actuator::Gamma, 125));
        let lead = Fault::SensorLead("bed".into(), Leads::PlusToGround);
        assert_eq!(parse("sensor-lead:bed,plus-to-ground").fault, lead);
    }

    #[test]
    fn a_misspelled_fault_says_what_is_wrong_with_it() {
        for (text, words) in [
            ("thermistor-open", "which one?"),
            ("thermistor-open:bed@soon", "`soon` is not a time"),
            ("heater-weak:bed", "how much?"),
            ("heater-weak:bed,much", "how much?"),
            ("thermistors-swapped:bed", "which two?"),
            ("driver-silent:omega", "`omega` is not a motor"),
            ("driver-bit-errors:omega,5", "`omega` is not a motor"),
            ("sensor-lead:bed,both", "force-open or the like"),
            ("fet-supply:low", "`low` is not a voltage"),
            ("fire", "is not one of thermistor-open:HEATER"),
        ] {
            let reason = TimedFault::parse(text).expect_err(text);
            assert!(reason.starts_with(&format!("fault `{text}")) && reason.contains(words), "{reason}");
        }
    }
}
