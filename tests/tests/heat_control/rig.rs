//! A heater of a kind under heat control and heat safety, with a noisy thermistor, a fan and filament.

use std::collections::VecDeque;

use base::ports::{SensorReading, SensorReadings, heater_bit};
use sim::models::heater::Heater;
use sim::models::thermistor::{Curve, Wiring, divider_volts};
use thermal::{Answer, HeatControl, HeaterSettings, LawSettings, ModelSettings, PidGains};
use units::{Celsius, Duty, HeaterId, Micros, ToolId};

use crate::heat_plants::plants::{Chance, Kind};

pub const AIR_C: f64 = 23.0;
/// Greatest error of a reading.
pub const NOISE_C: f64 = 0.15;
const STEP_S: f64 = 0.01;
const MODULATIONS: u32 = 20;
/// Heat that melting filament takes, J/mm3/K.
const FILAMENT_HEAT: f64 = 0.0023;

/// Disturbances: fan and filament flow.
#[derive(Clone, Copy, Default)]
pub struct Load {
    /// Duty of the fan.
    pub fan: f64,
    /// Filament flow, mm3/s.
    pub flow: f64,
}

/// Statistics over a stretch of time.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Least temperature of the sensor itself, without noise.
    pub least_c: f64,
    pub most_c: f64,
    pub mean_c: f64,
    /// Mean duty, of 255.
    pub mean_duty: f64,
    /// Share of samples with the output at one of its limits.
    pub limited: f64,
}

pub struct Rig {
    pub control: HeatControl,
    pub id: HeaterId,
    kind: Kind,
    body: Heater,
    curve: Curve,
    chance: Chance,
    /// Temperatures at the sensor, oldest first: its dead time.
    felt: VecDeque<f64>,
    pub second: f64,
}

impl Rig {
    /// Returns a heater in still air, switched off.
    pub fn new(kind: Kind, lines: &str) -> Self {
        let name = if kind.is_bed { "bed" } else { "hotend" };
        let max_c = if kind.is_bed { 120.0 } else { 300.0 };
        let text = format!(
            "[switch]\nfan.enable = true\nfan.output_pin = PE1\nfan.output_type = sigmadeltapwm\n\
             [temperature control]\n{name}.enable = true\n{name}.thermistor_pin = ADC1_1\n{name}.thermistor = Semitec\n\
             {name}.heater_pin = PE0\n{name}.max_temp = {max_c}\n{name}.runaway_heating_timeout = 900\n\
             {name}.heater_power = {}\n{name}.fan = fan\n{}",
            kind.plant.power_w,
            lines.replace("NAME", name),
        );
        let (machine, _) = config::parse(text.as_bytes(), config::BoardId::default(), &mut ());
        let mut control = HeatControl::new();
        let id = control.add(HeaterSettings::from(&machine.temperatures[0])).expect("room");
        control.enable_outputs();
        let curve = Curve::of_part("Semitec").expect("a part");
        let (body, felt) = (Heater::new(kind.plant, AIR_C), VecDeque::new());
        Self { control, id, kind, body, curve, chance: Chance::new(7), felt, second: 0.0 }
    }

    /// Adds a dead time to the sensor, seconds.
    pub fn delayed(mut self, seconds: f64) -> Self {
        self.felt = std::iter::repeat_n(AIR_C, (seconds / STEP_S) as usize).collect();
        self
    }

    fn settings(&self) -> &HeaterSettings {
        &self.control.heater(self.id).expect("it is there").settings
    }

    pub fn pid(&self) -> PidGains {
        match self.settings().law {
            LawSettings::Pid(gains) => gains,
            _ => panic!("no PID"),
        }
    }

    pub fn set_law(&mut self, law: LawSettings) {
        assert!(self.control.set_law(self.id, law, Duty::FULL));
    }

    pub fn set_target(&mut self, celsius: f64) {
        assert_eq!(self.control.set_target(self.id, Celsius(celsius as f32)), Ok(()));
    }

    fn step(&mut self, load: Load) {
        self.second += STEP_S;
        let now = Micros((self.second * 1e6) as u64);
        self.control.executor_alive(now);
        self.control.set_switch(0, Duty((load.fan * 255.0) as u8));
        self.control.set_flow(ToolId(0), load.flow as f32, now);
        self.felt.push_back(self.body.sensor_c());
        let felt = self.felt.pop_front().unwrap_or(AIR_C) + self.chance.between(-NOISE_C, NOISE_C);
        let volts = divider_volts(&self.curve, felt, Wiring::Sound);
        let mut readings = SensorReadings::default();
        readings[0] = SensorReading::Counts((volts / 3.3 * 65_535.0).round() as u16);
        self.control.tick(now, &readings);
        assert_eq!(self.control.take_fault(), None, "{} at {:.1} C", self.kind.name, self.body.sensor_c());
        let on = (0..MODULATIONS).filter(|_| self.control.modulation_tick().on & heater_bit(0) != 0).count();
        let taken_w = load.flow * FILAMENT_HEAT * (self.body.body_c() - AIR_C);
        let drive = on as f64 / f64::from(MODULATIONS) - taken_w / self.kind.plant.power_w;
        self.body.pass(STEP_S, drive, load.fan, AIR_C);
    }

    pub fn run(&mut self, seconds: f64, load: Load) -> Seen {
        let (mut least_c, mut most_c, mut sum, mut duties, mut limited) = (f64::MAX, f64::MIN, 0.0, 0.0, 0.0);
        let steps = (seconds / STEP_S) as u32;
        for _ in 0..steps {
            self.step(load);
            let felt = self.body.sensor_c();
            (least_c, most_c, sum) = (felt.min(least_c), felt.max(most_c), sum + felt);
            let duty = self.control.heater(self.id).expect("it is there").duty();
            duties += f64::from(duty.0);
            limited += f64::from(u8::from(duty == Duty::OFF || duty == Duty::FULL));
        }
        let all = f64::from(steps);
        Seen { least_c, most_c, mean_c: sum / all, mean_duty: duties / all, limited: limited / all }
    }

    /// Swings the temperature around the target until the plant's response is known; returns the response and
    /// the time taken.
    pub fn tune(&mut self, target: f64) -> (Answer, f64) {
        let began = self.second;
        self.control.heater_mut(self.id).expect("it is there").start_tuning(3, Celsius(AIR_C as f32));
        self.set_target(target);
        while self.second - began < 3_600.0 {
            self.step(Load::default());
            let heater = self.control.heater(self.id).expect("it is there");
            if let Some(found) = heater.tuning().and_then(|test| test.answer(Celsius(target as f32))) {
                let seconds = self.second - began;
                return (found.unwrap_or_else(|why| panic!("{}: {}", self.kind.name, why.text())), seconds);
            }
        }
        panic!("{}: nothing found in an hour", self.kind.name)
    }

    /// Returns the model from the response, with the fan's loss measured as M306 does.
    pub fn model(&mut self, answer: &Answer) -> ModelSettings {
        let power_w = self.kind.plant.power_w as f32;
        let capacity = power_w / answer.rise;
        let filament_heat = if self.kind.is_bed { 0.0 } else { FILAMENT_HEAT as f32 };
        let (loss, late_s) = (answer.loss * capacity, answer.late_s);
        let mut model = ModelSettings { power_w, capacity, loss, fan_loss: 0.0, late_s, filament_heat };
        self.set_law(LawSettings::Model(model));
        self.set_target(self.kind.target_c);
        let [still, blown] = [0.0, 1.0].map(|fan| {
            let load = Load { fan, flow: 0.0 };
            self.run(200.0, load);
            self.run(60.0, load).mean_duty
        });
        model.fan_loss = (((blown - still) / 255.0) as f32 * power_w / (self.kind.target_c as f32 - 25.0)).max(0.0);
        model
    }
}
