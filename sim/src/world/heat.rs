//! Heaters, fans and their sensors.

use super::World;
use super::config::GRID_NS;
use super::electrics::NOMINAL_VOLTS;
use super::parts::HeaterState;
use crate::models::converter::Converter;
use crate::models::fan::Condition;
use crate::models::thermistor::divider_volts;

/// Time of one conversion of a thermistor's input (`bsp_prime::adc`).
const CONVERSION_NS: u64 = 154_000;

/// Share by which a sensor slides out, and the time within which it comes to feel that.
const HALF_OUT: f64 = 0.5;
const SLIPS_WITHIN_S: f64 = 3.0;
/// Reading that a loose plug adds in the half of every period in which it has contact through dirt only.
const LOOSE_C: f64 = -15.0;
const LOOSE_PERIOD_NS: u64 = 1_200_000_000;
/// Period of noise that a wire picks up: a converter averages faster noise.
const NOISE_PERIOD_NS: u64 = 40_000_000;

impl World {
    /// Passes a step of the thermal grid, ending here. Heaters are stepped with the switches' state at its
    /// end: a change of buffer or power enable counts from the next grid point.
    pub(super) fn pass_heat(&mut self, at_ns: u64) {
        let seconds = GRID_NS as f64 * 1e-9;
        let fans: Vec<f64> = (0..self.fans.len()).map(|fan| self.pass_fan(at_ns, fan)).collect();
        for index in 0..self.heaters.len() {
            let path = self.heaters[index].path;
            let (passes, power) = (self.passes(path), (self.load_volts(path) / NOMINAL_VOLTS).powi(2));
            let state = &mut self.heaters[index];
            let commanded = state.load.finish(at_ns);
            let duty = match state.stuck {
                None if passes => commanded,
                None => 0.0,
                // The MOSFET itself conducts: the buffer cannot stop it, only its supply can, where that can
                // be switched.
                Some(stuck) => f64::from(u8::from(stuck)),
            };
            let wind =
                |(fan, &duty): (usize, &f64)| if self.config.fans[fan].cools == Some(index) { duty } else { 0.0 };
            let blown: f64 = fans.iter().enumerate().map(wind).sum();
            state.heater.pass(seconds, duty * power * state.strength, blown, self.config.air_c);
            if state.seat.slips {
                state.seat.out += (HALF_OUT - state.seat.out) * seconds / SLIPS_WITHIN_S;
            }
            state.seat.drift_k += state.seat.drift_k_per_s * seconds;
            state.max_c = state.max_c.max(state.heater.body_c());
            state.smooth_duty += (commanded - state.smooth_duty) * seconds;
        }
    }

    /// Returns the share of full speed of a fan over the grid step that ends here.
    fn pass_fan(&mut self, at_ns: u64, fan: usize) -> f64 {
        let path = self.fans[fan].path;
        let runs = self.passes(path) && self.load_volts(path) > 0.0;
        let fan = &mut self.fans[fan];
        let drive = fan.load.finish(at_ns) * f64::from(u8::from(runs));
        fan.fan.pass(GRID_NS as f64 * 1e-9, drive);
        match fan.fan.condition {
            Condition::Sound => drive,
            Condition::Stopped | Condition::Slow => 0.0,
        }
    }

    /// Returns whether the tachometer of a fan closes its contact.
    #[must_use]
    pub fn fan_tachometer(&self, index: usize) -> bool {
        self.fans[index].fan.is_closed()
    }

    /// Returns the speed of a fan, turns a minute.
    #[must_use]
    pub fn fan_rpm(&self, index: usize) -> f64 {
        self.fans[index].fan.rpm()
    }

    /// Gives a fan a fault, or repairs it.
    pub(super) fn set_fan_condition(&mut self, name: &str, condition: Condition) -> Result<(), String> {
        let known = || self.config.fans.iter().map(|fan| fan.name.as_str()).collect::<Vec<_>>().join(" ");
        match self.config.fans.iter().position(|fan| fan.name == name) {
            Some(index) => self.fans[index].fan.condition = condition,
            None => return Err(format!("no fan `{name}`; there are: {}", known())),
        }
        Ok(())
    }

    /// Share of full speed a fan ran at during the last millisecond.
    #[must_use]
    pub fn fan_speed(&self, index: usize) -> f64 {
        self.fans[index].load.last
    }

    /// Index of the heater with this name.
    #[must_use]
    pub fn heater_index(&self, name: &str) -> Option<usize> {
        self.config.heaters.iter().position(|heater| heater.name == name)
    }

    /// Returns the heater of this name.
    pub(super) fn heater_named(&mut self, name: &str) -> Result<&mut HeaterState, String> {
        match self.heater_index(name) {
            Some(index) => Ok(&mut self.heaters[index]),
            None => {
                let known: Vec<_> = self.config.heaters.iter().map(|heater| heater.name.as_str()).collect();
                Err(format!("no heater `{name}`; there are: {}", known.join(" ")))
            }
        }
    }

    /// Temperature of a heated body, degrees Celsius.
    #[must_use]
    pub fn heater_c(&self, index: usize) -> f64 {
        self.heaters[index].heater.body_c()
    }

    /// Highest temperature a heated body has had, degrees Celsius.
    #[must_use]
    pub fn heater_max_c(&self, index: usize) -> f64 {
        self.heaters[index].max_c
    }

    /// Drive of a heater averaged over about a second, 0 to 1.
    #[must_use]
    pub fn heater_mean_duty(&self, index: usize) -> f64 {
        self.heaters[index].smooth_duty
    }

    /// Sets body and sensor of a heater to a temperature.
    pub fn soak(&mut self, index: usize, celsius: f64) {
        self.heaters[index].heater.soak(celsius);
    }

    /// Returns the number of conversions that the converter of the thermistors has made; each takes 154 us.
    #[must_use]
    pub fn conversions(&self) -> u32 {
        let until_ns = self.adc_stands.as_ref().map_or(self.now_ns, |(since_ns, _)| *since_ns);
        (until_ns / CONVERSION_NS) as u32
    }

    /// Returns the voltage a heater's sensor puts on its analog input.
    #[must_use]
    pub fn sensor_volts(&self, index: usize) -> f64 {
        if let Some(volts) = self.adc_stands.as_ref().and_then(|(_, volts)| volts.get(index)) {
            return *volts;
        }
        let index = self.plugged(index);
        divider_volts(&self.config.heaters[index].curve, self.felt_c(index), self.heaters[index].wiring)
    }

    /// Two plugs in each other's places each bring their own sensor along.
    fn plugged(&self, index: usize) -> usize {
        match self.swapped {
            Some([one, other]) if index == one => other,
            Some([one, other]) if index == other => one,
            _ => index,
        }
    }

    /// Returns the temperature of a heater's sensor, as it sits in the heater.
    pub(super) fn felt_c(&self, index: usize) -> f64 {
        let state = &self.heaters[index];
        let air_c = self.config.air_c;
        let mut felt_c = state.heater.sensor_c() + (air_c - state.heater.sensor_c()) * state.seat.out;
        felt_c += state.seat.drift_k;
        if state.seat.loose && self.now_ns % LOOSE_PERIOD_NS < LOOSE_PERIOD_NS / 2 {
            felt_c += LOOSE_C;
        }
        if state.seat.noise_k > 0.0 {
            // The noise is evenly spread, and the same in every run.
            let place = (self.now_ns / NOISE_PERIOD_NS).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
            felt_c += state.seat.noise_k * (place as f64 / f64::from(1 << 23) - 1.0);
        }
        felt_c
    }

    /// Returns the converter chip of a heater's sensor.
    pub(super) fn converter_of(&mut self, name: &str) -> Result<&mut Converter, String> {
        let heater = self.heater_named(name)?;
        heater.converter.as_mut().ok_or_else(|| format!("the sensor of `{name}` has no converter chip"))
    }
}
