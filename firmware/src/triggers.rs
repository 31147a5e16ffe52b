//! Inputs that stop motion, from pin to latch.
//!
//! An armed input is watched by its edge interrupt, which stamps the very tick. The chip has one edge
//! detector per pin number, and on this board X min (PD0) and Z min (PI0) share one: so detectors are given
//! out when inputs are armed, and every armed input is also read by the step feed, every 0.4 to 0.9 ms. An
//! input that got no detector, or was active before it was armed, is thus found a millisecond late at worst.

use bsp_prime::pins::{Input, PinSpec};
use bsp_prime::{step_engine, time, trigger};
use heapless::Vec;
use motion::Latch;

/// Endstops, probe, kill button: as many as the machine knows.
const MAX_INPUTS: usize = 32;

/// Input that stops motion: its number in the latch's mask, and its pin.
#[derive(Debug)]
struct Source {
    number: u8,
    spec: PinSpec,
    pin: Input,
}

/// All inputs that can stop motion.
#[derive(Debug, Default)]
pub struct TriggerInputs {
    sources: Vec<Source, MAX_INPUTS>,
    /// Mask of armed inputs when the detectors were last given out.
    watched: u32,
}

impl TriggerInputs {
    /// Adds an input. False when there is no room.
    pub fn add(&mut self, number: u8, spec: PinSpec, pin: Input) -> bool {
        self.sources.push(Source { number, spec, pin }).is_ok()
    }

    /// Reads the armed inputs, before the feed looks at the latch.
    pub fn look(&mut self, latch: &Latch) {
        let armed = latch.armed();
        if armed != self.watched {
            self.give_out_detectors(armed);
        }
        if armed == 0 {
            return;
        }
        for source in &self.sources {
            if armed & (1 << source.number) != 0 && source.pin.is_on() {
                latch.report(source.number, time::step_ticks(), step_engine::queue());
            }
        }
    }

    fn give_out_detectors(&mut self, armed: u32) {
        for source in &self.sources {
            trigger::unwatch(source.number);
        }
        for source in self.sources.iter().filter(|source| armed & (1 << source.number) != 0) {
            // A second input on the same detector is only read by `look`; see the module's text.
            let _shared = trigger::watch(source.spec, source.number);
        }
        self.watched = armed;
    }
}
