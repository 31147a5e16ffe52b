//! A heated body with a sensor: lumped heat capacity, loss to the air, a fan, and a sensor that lags.
//!
//! C dT/dt = P - (k + fan k_fan)(T - T_air), and tau dT_s/dt = T - T_s. Explicit Euler in fixed steps far
//! below either time constant (1 ms against seconds), so the result depends only on the inputs and never on
//! how often it is asked.

/// Constants of one heated body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Heater power at the supply's nominal voltage, watts.
    pub power_w: f64,
    /// Heat capacity, joules per kelvin.
    pub capacity_j_per_k: f64,
    /// Loss to the air, watts per kelvin.
    pub loss_w_per_k: f64,
    /// Additional loss with the fan full on, watts per kelvin.
    pub fan_loss_w_per_k: f64,
    /// Time constant of the sensor, seconds.
    pub sensor_lag_s: f64,
}

impl Plant {
    /// A 40 W hot end: 300 K above air at 80 % duty, 3 K/s at the start.
    pub const HOT_END: Self =
        Self { power_w: 40.0, capacity_j_per_k: 12.0, loss_w_per_k: 0.1, fan_loss_w_per_k: 0.02, sensor_lag_s: 1.5 };
    /// A 250 W printing bed: 0.6 K/s at the start, 125 K above air at most.
    pub const BED: Self =
        Self { power_w: 250.0, capacity_j_per_k: 400.0, loss_w_per_k: 2.0, fan_loss_w_per_k: 0.0, sensor_lag_s: 4.0 };
}

/// A heated body in time.
#[derive(Clone, Debug)]
pub struct Heater {
    plant: Plant,
    body_c: f64,
    sensor_c: f64,
}

impl Heater {
    /// At rest at the temperature of the air.
    #[must_use]
    pub const fn new(plant: Plant, air_c: f64) -> Self {
        Self { plant, body_c: air_c, sensor_c: air_c }
    }

    /// Lets `seconds` pass (a few milliseconds at most) with this share of nominal power, fan duty and air
    /// temperature.
    pub fn pass(&mut self, seconds: f64, power_share: f64, fan_duty: f64, air_c: f64) {
        let plant = &self.plant;
        let loss = (plant.loss_w_per_k + fan_duty * plant.fan_loss_w_per_k) * (self.body_c - air_c);
        self.sensor_c += (self.body_c - self.sensor_c) * seconds / plant.sensor_lag_s;
        self.body_c += (power_share * plant.power_w - loss) * seconds / plant.capacity_j_per_k;
    }

    /// Temperature of the body, degrees Celsius.
    #[must_use]
    pub const fn body_c(&self) -> f64 {
        self.body_c
    }

    /// Temperature of the sensor, degrees Celsius.
    #[must_use]
    pub const fn sensor_c(&self) -> f64 {
        self.sensor_c
    }

    /// Sets body and sensor to a temperature (tests, and starting warm).
    pub const fn soak(&mut self, celsius: f64) {
        self.body_c = celsius;
        self.sensor_c = celsius;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 1e-3;

    fn after(heater: &mut Heater, seconds: f64, power_share: f64, fan_duty: f64) -> f64 {
        let steps = (seconds / STEP_S).round() as u32;
        (0..steps).for_each(|_| heater.pass(STEP_S, power_share, fan_duty, 20.0));
        heater.body_c()
    }

    #[test]
    fn heat_in_and_heat_lost_come_to_balance() {
        // 32 W against 0.1 W/K, or 0.12 W/K with the fan; the time constant is 120 s.
        let mut heater = Heater::new(Plant::HOT_END, 20.0);
        let still = after(&mut heater, 1_500.0, 0.8, 0.0);
        assert!((still - (20.0 + 32.0 / 0.1)).abs() < 0.01, "{still}");
        let blown = after(&mut heater, 1_500.0, 0.8, 1.0);
        assert!((blown - (20.0 + 32.0 / 0.12)).abs() < 0.01, "{blown}");
    }

    #[test]
    fn a_cold_body_warms_by_its_capacity_alone_at_first() {
        let mut heater = Heater::new(Plant::BED, 20.0);
        let warmed = after(&mut heater, 1.0, 1.0, 0.0) - 20.0;
        assert!((warmed - 250.0 / 400.0).abs() < 0.002, "{warmed} K in the first second");
    }

    #[test]
    fn a_body_without_power_cools_by_its_time_constant() {
        let mut heater = Heater::new(Plant::HOT_END, 20.0);
        heater.soak(220.0);
        // 12 J/K over 0.1 W/K.
        let left = after(&mut heater, 120.0, 0.0, 0.0) - 20.0;
        assert!((left - 200.0 / core::f64::consts::E).abs() < 0.05, "{left}");
    }

    #[test]
    fn a_sensor_follows_a_ramp_late_by_its_lag() {
        let plant = Plant { loss_w_per_k: 0.0, ..Plant::HOT_END };
        let mut heater = Heater::new(plant, 20.0);
        let body = after(&mut heater, 20.0, 0.5, 0.0);
        let late_s = (body - heater.sensor_c()) / (0.5 * plant.power_w / plant.capacity_j_per_k);
        assert!((late_s - plant.sensor_lag_s).abs() < 0.01, "{late_s} s");
    }
}
