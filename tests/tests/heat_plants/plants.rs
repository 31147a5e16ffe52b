//! Hot ends and beds as they are sold, and random variations of them.

use sim::models::heater::Plant;

/// A kind of heater, and what it is used at.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    pub name: &'static str,
    pub plant: Plant,
    pub target_c: f64,
    pub is_bed: bool,
}

const fn kind(name: &'static str, figures: [f64; 5], target_c: f64, is_bed: bool) -> Kind {
    let [power_w, capacity_j_per_k, loss_w_per_k, fan_loss_w_per_k, sensor_lag_s] = figures;
    let plant = Plant { power_w, capacity_j_per_k, loss_w_per_k, fan_loss_w_per_k, sensor_lag_s };
    Kind { name, plant, target_c, is_bed }
}

/// Power, heat capacity, loss, loss to the part's fan, lag of the sensor. Capacities are those of the parts'
/// masses (aluminium 0.9, brass and copper 0.38, glass 0.84 J/gK), losses what holds the usual target at a
/// third to a half of the power.
pub const KINDS: [Kind; 12] = [
    kind("small hot end, 24 W", [24.0, 6.0, 0.05, 0.015, 2.0], 200.0, false),
    kind("hot end with PTFE inside, 40 W", [40.0, 13.0, 0.08, 0.03, 4.0], 205.0, false),
    kind("all-metal hot end with sock, 40 W", [40.0, 11.0, 0.075, 0.02, 2.5], 215.0, false),
    kind("all-metal hot end without sock, 40 W", [40.0, 11.0, 0.09, 0.06, 2.5], 215.0, false),
    kind("quick-change hot end, 40 W", [40.0, 8.0, 0.07, 0.015, 1.0], 230.0, false),
    kind("long hot end for high flow, 65 W", [65.0, 24.0, 0.11, 0.03, 3.0], 240.0, false),
    kind("ceramic hot end, 115 W", [115.0, 18.0, 0.16, 0.03, 1.5], 280.0, false),
    kind("PCB bed, 220 W", [220.0, 320.0, 1.6, 0.1, 5.0], 60.0, true),
    kind("aluminium bed on 24 V, 250 W", [250.0, 400.0, 1.4, 0.1, 6.0], 80.0, true),
    kind("glass on a bed, 150 W", [150.0, 420.0, 0.9, 0.1, 10.0], 60.0, true),
    kind("cast bed on mains, 750 W", [750.0, 2_200.0, 3.5, 0.3, 8.0], 100.0, true),
    kind("small bed, 60 W", [60.0, 80.0, 0.45, 0.05, 4.0], 60.0, true),
];

/// Repeatable chance (xorshift64*, S. Vigna, 2016).
pub struct Chance(u64);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Returns a random number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Returns a variant of a kind, with every figure up to a quarter more or less.
    pub fn one_of(&mut self, kind: &Kind) -> Kind {
        let mut near = |figure: f64| figure * self.between(0.75, 1.25);
        let plant = &kind.plant;
        let plant = Plant {
            power_w: near(plant.power_w),
            capacity_j_per_k: near(plant.capacity_j_per_k),
            loss_w_per_k: near(plant.loss_w_per_k),
            fan_loss_w_per_k: near(plant.fan_loss_w_per_k),
            sensor_lag_s: near(plant.sensor_lag_s),
        };
        Kind { plant, ..*kind }
    }
}
