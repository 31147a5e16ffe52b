//! Codes that search: G30 down to the bed, G38 along a line, M48 again and again.

use config::Leveling;
use gcode::{Block, Decoder, Line};
use units::{Axis, MmPerSecond, PerAxis};

use super::{Search, Until};
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;
use crate::state::State;

/// How far M48 searches, mm: it starts just above the bed.
const REPEAT_TRAVEL: f64 = 20.0;
/// Probes of M48 without P, and at most.
const REPEATS: f64 = 10.0;
const MOST_REPEATS: f64 = 1_000.0;

impl<P: Ports> Controller<P> {
    /// G29 to G32, G38.n. Without a probe those of printers are ignored, as their programs expect; G38 is not, for what follows
    /// it relies on what it finds.
    pub(crate) async fn probing_code(&mut self, number: u16, subcode: u8, block: &Block<'_>) -> Outcome {
        if !self.config.probe.enable {
            return match number {
                38 => Err(Failure::refused("no probe is configured: [zprobe] enable")),
                _ => Ok(Answer::Unknown),
            };
        }
        match (number, subcode) {
            (29 | 31 | 32, _) => self.strategy_code(number, subcode, block).await,
            (30, 0) => self.probe_bed(block).await,
            (38, 2) => self.probe_along(block, Until::Touch, true).await,
            (38, 3) => self.probe_along(block, Until::Touch, false).await,
            (38, 4) => self.probe_along(block, Until::Release, true).await,
            (38, 5) => self.probe_along(block, Until::Release, false).await,
            (38, _) => Err(Failure::refused("Only G38.2 to G38.5 are supported")),
            _ => Ok(Answer::Unknown),
        }
    }

    /// G29, G31 and G32 go to the leveling strategy, and those it does not know to calibration; P1 means the latter alone.
    async fn strategy_code(&mut self, number: u16, subcode: u8, block: &Block<'_>) -> Outcome {
        let strategy = self.config.leveling.strategy.filter(|_| block.get('P') != Some(1.0));
        let calibrates = self.config.delta_calibration.enable && block.get('P') != Some(0.0);
        match (strategy, number, subcode) {
            (Some(Leveling::ThreePoint), 29, 0) => return self.measure_three_points().await,
            (Some(Leveling::ThreePoint), 31, 0) => return self.show_plane(),
            (Some(Leveling::ThreePoint), 32, 0) => return self.level_by_three_points().await,
            (Some(Leveling::CartesianGrid), 29, 0) => return self.scan_cartesian(block).await,
            (Some(Leveling::CartesianGrid), 31 | 32, 0) => return self.level_by_cartesian_grid(block).await,
            (Some(Leveling::DeltaGrid), 29, 0 | 1) => return self.scan_delta(block, subcode == 1).await,
            (Some(Leveling::DeltaGrid), 31, 0) => return self.level_by_delta_grid(block).await,
            _ => {}
        }
        match (number, subcode) {
            (29, 0 | 1) | (32, 0) if calibrates => {
                self.wait_idle().await?;
                // The machine itself is measured, not what makes up for its bed.
                self.set_compensation_aside()?;
                let done =
                    if number == 29 { self.measure_delta(block).await } else { self.calibrate_delta(block).await };
                self.put_compensation_back().await;
                done
            }
            _ => Err(Failure::Refused(message(format_args!("No strategy found to handle G{number}")))),
        }
    }

    /// M48 and M670.
    pub(crate) async fn probe_m_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        match number {
            _ if !self.config.probe.enable => Ok(Answer::Unknown),
            48 => self.repeat_probe(block).await,
            _ => self.probe_settings_code(block),
        }
    }

    /// `$P`: G30 with these words, also where G30 means something else.
    pub(crate) async fn probe_command(&mut self, words: &str) -> Outcome {
        if self.state == State::Halt || self.crippled {
            return Err(Failure::Halted);
        }
        if !self.config.probe.enable {
            return Err(Failure::refused("no probe is configured: [zprobe] enable"));
        }
        let text = message(format_args!("G30 {words}"));
        let mut decoder = Decoder::new();
        let Ok(Line::Code(mut blocks)) = decoder.decode(text.as_bytes()) else {
            return Err(Failure::refused("$P takes the words of G30"));
        };
        match (blocks.next(), blocks.next()) {
            (Some(Ok(block)), None) => self.probe_bed(&block).await,
            _ => Err(Failure::refused("$P takes the words of G30")),
        }
    }

    /// G30: searches for the bed and returns to where it began; with Z or L it stays where the contact was, and Z makes that
    /// height read as given.
    async fn probe_bed(&mut self, block: &Block<'_>) -> Outcome {
        let rate = self.probing_rate(block)?;
        let probe = self.config.probe;
        let upwards = probe.reverse_z != (block.get('R') == Some(1.0));
        self.wait_idle().await?;
        let start = self.position;
        let found = self.search(&self.search_down(rate, probe.max_travel.0, upwards)).await?;
        let stays = block.has('Z') || block.has('L');
        match found {
            Some(contact) if stays => self.go_there(contact, rate).await?,
            None if stays => {}
            _ => self.go_there(start, probe.return_rate).await?,
        }
        let Some(contact) = found else {
            if self.player.is_playing() {
                // The file waits here: what follows counts on the height.
                return Err(Failure::refused("ZProbe not triggered"));
            }
            self.say(format_args!("ZProbe not triggered\n"));
            return Ok(Answer::Ok);
        };
        self.say(format_args!("Z:{:.4}\n", start[Axis::Z] - contact[Axis::Z]));
        if let Some(z) = block.get('Z') {
            let mm = self.modal.to_mm(z);
            self.modal.set_g92(Axis::Z, mm, contact[Axis::Z]);
        }
        Ok(Answer::Ok)
    }

    /// G38: searches along the line that the words describe, and stands where the contact changed.
    async fn probe_along(&mut self, block: &Block<'_>, until: Until, must_find: bool) -> Outcome {
        let rate = self.probing_rate(block)?;
        self.wait_idle().await?;
        let target = self.probing_target(block)?;
        self.modal.machine_next = false;
        // The tool goes straight, not along the bed's shape.
        let target = self.ports.motion(|motion| motion.compensation().motors(&target));
        self.set_compensation_aside()?;
        let found = self.search_and_return(&Search { target, rate, until }).await;
        self.put_compensation_back().await;
        let found = found?;
        let [x, y, z] = Axis::PRIMARY.map(|axis| self.position[axis]);
        self.probing.last = ([x, y, z], found);
        self.say(format_args!("[PRB:{x:.3},{y:.3},{z:.3}:{}]\n", u8::from(found)));
        if !found && must_find {
            self.halt(format_args!("ALARM: Probe fail\n"));
            return Err(Failure::Halted);
        }
        Ok(Answer::Ok)
    }

    /// Whether the contact was found; the machine then stands there.
    async fn search_and_return(&mut self, search: &Search) -> Result<bool, Failure> {
        let Some(contact) = self.search(search).await? else { return Ok(false) };
        // Braking went a little past it.
        self.go_there(contact, search.rate).await?;
        Ok(true)
    }

    /// The words of G38. In GRBL mode they are read as those of any move, as GRBL does; else they are distances, whatever the
    /// distance mode, as in Smoothieware.
    fn probing_target(&self, block: &Block<'_>) -> Result<PerAxis<f64>, Failure> {
        let grbl = self.config.general.grbl_mode;
        let mut target = self.position;
        for axis in Axis::PRIMARY {
            if let Some(word) = block.get(axis.letter()) {
                let now = self.position[axis];
                target[axis] = if grbl { self.modal.machine(axis, word, now) } else { now + self.modal.to_mm(word) };
            }
        }
        let named = |letter: char| block.has(letter);
        if "ABCE".chars().any(named) {
            return Err(Failure::refused("only X Y and Z can be probed along"));
        }
        if !"XYZ".chars().any(named) {
            return Err(Failure::refused("at least one of X Y or Z must be specified"));
        }
        if !grbl && named('Z') && (named('X') || named('Y')) {
            return Err(Failure::refused("Z cannot be probed at the same time as X or Y"));
        }
        if target == self.position {
            return Err(Failure::refused("the way to probe along has no length"));
        }
        Ok(target)
    }

    /// Probing moves, so it needs what moves need.
    pub(super) fn check_homed(&self) -> Result<(), Failure> {
        if self.config.motion.must_be_homed && !self.all_homed() {
            return Err(Failure::alarm("Must be homed before moving"));
        }
        Ok(())
    }

    /// F, for this search alone, or else `slow_feedrate`. Also what must hold before any search.
    fn probing_rate(&self, block: &Block<'_>) -> Result<MmPerSecond, Failure> {
        self.check_homed()?;
        match block.get('F') {
            None => Ok(self.config.probe.slow_rate),
            Some(rate) if rate > 0.0 => Ok(MmPerSecond::from_per_minute(self.modal.to_mm(rate))),
            Some(_) => Err(Failure::refused("the feed rate of a search must be above zero")),
        }
    }

    /// M48: how well the probe repeats itself.
    async fn repeat_probe(&mut self, block: &Block<'_>) -> Outcome {
        let rate = self.probing_rate(block)?;
        let repeats = block.get('P').unwrap_or(REPEATS);
        if !(1.0..=MOST_REPEATS).contains(&repeats) {
            return Err(Failure::refused("M48: P is the number of probes, 1 to 1000"));
        }
        let probe = self.config.probe;
        self.wait_idle().await?;
        let start = self.position;
        let mut seen = Spread::default();
        for _ in 0..repeats as u32 {
            let found = self.search(&self.search_down(rate, REPEAT_TRAVEL, probe.reverse_z)).await?;
            self.go_there(start, probe.return_rate).await?;
            let Some(contact) = found else {
                return Err(Failure::refused("ZProbe not triggered within 20 mm"));
            };
            let distance = start[Axis::Z] - contact[Axis::Z];
            seen.add(distance);
            self.say(format_args!("Z:{distance:.4}\n"));
            self.drain().await;
        }
        let (mean, deviation) = seen.mean_and_deviation();
        self.say(format_args!("Delta: {:.4}\nMean: {mean:.4} Standard deviation: {deviation:.4}\n", seen.delta()));
        Ok(Answer::Ok)
    }
}

/// What several probes of one place found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spread {
    count: f64,
    /// The first one: sums of differences from it stay small, and so exact.
    first: f64,
    least: f64,
    most: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    fn add(&mut self, value: f64) {
        if self.count == 0.0 {
            (self.first, self.least, self.most) = (value, value, value);
        }
        self.count += 1.0;
        if value < self.least {
            self.least = value;
        }
        if value > self.most {
            self.most = value;
        }
        let part = value - self.first;
        self.sum += part;
        self.squares += part * part;
    }

    fn delta(&self) -> f64 {
        self.most - self.least
    }

    /// Mean, and standard deviation of the values themselves (not of the population they are drawn from).
    fn mean_and_deviation(&self) -> (f64, f64) {
        if self.count == 0.0 {
            return (0.0, 0.0);
        }
        let part = self.sum / self.count;
        let variance = self.squares / self.count - part * part;
        (self.first + part, libm::sqrt(if variance > 0.0 { variance } else { 0.0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn mean_and_deviation_are_the_textbooks(values in proptest::collection::vec(-50.0..50.0_f64, 1..40)) {
            let mut seen = Spread::default();
            values.iter().for_each(|value| seen.add(*value));
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
            let (found_mean, found_deviation) = seen.mean_and_deviation();
            prop_assert!((found_mean - mean).abs() < 1e-9, "{found_mean} for {mean}");
            // Near zero a root magnifies the rounding of what is under it.
            prop_assert!((found_deviation * found_deviation - variance).abs() < 1e-9, "{found_deviation} for {variance}");
            let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(l, m), v| (l.min(*v), m.max(*v)));
            prop_assert_eq!(seen.delta(), most - least);
        }
    }
}
