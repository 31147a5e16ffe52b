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
