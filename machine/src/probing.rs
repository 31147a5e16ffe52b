//! The probe: a search along a straight line that ends where its contact changes.
//!
//! Where the contact changed is where the motors were at the tick its input fired, which the latch keeps; the braking after
//! it costs nothing. So the speed of a search decides how far the machine runs past the contact, never what it measures.

mod codes;
mod delta_calibration;
mod delta_fit;
mod grids;
mod points;
mod settings;
mod three_point;

use motion::Mode;
use units::{Axis, Micros, MmPerSecond, PerAxis};

use crate::controller::Controller;
use crate::failure::Failure;
use crate::ports::{Input, Ports};
use crate::state::State;

/// Searches that a contact which does not last may cut short; then the wiring is to blame.
const RETRIES: u8 = 3;

/// What the dispatcher remembers about the probe.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Probing {
    /// M670 I: the contact is the other way round for the time being.
    pub inverted: bool,
    /// Machine position X Y Z of the last G38, mm, and whether its contact was found.
    pub last: ([f64; 3], bool),
}

/// Which change of the contact ends a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Until {
    /// It closes.
    Touch,
    /// It opens.
    Release,
}

/// A search along a straight line from where the machine stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Where it ends without a contact, in machine space.
    pub target: PerAxis<f64>,
    pub rate: MmPerSecond,
    pub until: Until,
}

impl<P: Ports> Controller<P> {
    /// The probe's contact is closed now.
    pub(crate) fn probe_touches(&self) -> bool {
        self.ports.inputs().is_active(Input::Probe) != self.probing.inverted
    }

    fn probe_is(&self, until: Until) -> bool {
        self.probe_touches() == (until == Until::Touch)
    }

    /// Searches. Returns where the contact changed, exactly, while the machine stands a braking distance past it; or `None` when
    /// it did not change on the way, and the machine stands at the target.
    pub(crate) async fn search(&mut self, search: &Search) -> Result<Option<PerAxis<f64>>, Failure> {
        self.dwell(self.config.probe.dwell).await?;
        if self.probe_is(search.until) {
            return Err(Failure::refused("ZProbe triggered before move, aborting command."));
        }
        // Filters would delay the stop at the contact.
        self.ports.motion(|motion| motion.bypass_filters(true));
        self.search_takes_latch();
        let found = self.search_past_sparks(search).await;
        self.search_returns_latch();
        self.ports.motion(|motion| motion.bypass_filters(false));
        let found = found?;
        self.wait_idle().await?;
        Ok(found)
    }

    async fn search_past_sparks(&mut self, search: &Search) -> Result<Option<PerAxis<f64>>, Failure> {
        let debounce = self.config.probe.debounce;
        // A rapid, for a laser stays off then; and an override is for cutting.
        let rate = search.rate * (1.0 / self.ports.motion(|motion| motion.overrides().rapid));
        for _ in 0..=RETRIES {
            // A contact that changes between the look above and this store is found by the feed, which reads armed inputs.
            self.ports.latch().arm(self.probe_input(search.until).bit());
            self.go(search.target, rate, Mode::Rapid).await?;
            let Some(trigger) = self.wait_trigger().await? else { return Ok(None) };
            self.wait_while_held().await?;
            self.wait_for(debounce).await?;
            if debounce == Micros(0) || self.probe_is(search.until) {
                return Ok(Some(self.ports.motion(|motion| motion.position_of_steps(&trigger.steps))));
            }
        }
        Err(Failure::alarm("the probe fires but does not stay triggered: check its wiring"))
    }

    /// The input that fires at this change.
    const fn probe_input(&self, until: Until) -> Input {
        match (until, self.probing.inverted) {
            (Until::Touch, false) | (Until::Release, true) => Input::Probe,
            _ => Input::ProbeOpen,
        }
    }

    /// A contact may come while the operator holds the machine: what follows it waits for him.
    async fn wait_while_held(&mut self) -> Result<(), Failure> {
        while matches!(self.state, State::Hold { .. }) {
            self.pause().await?;
        }
        Ok(())
    }

    /// Moves and waits until the motors stand there.
    pub(crate) async fn go_there(&mut self, target: PerAxis<f64>, rate: MmPerSecond) -> Result<(), Failure> {
        self.go(target, rate, Mode::Rapid).await?;
        self.wait_idle().await
    }

    /// A search straight down from here (up, with `upwards`).
    pub(crate) fn search_down(&self, rate: MmPerSecond, travel: f64, upwards: bool) -> Search {
        let mut target = self.position;
        target[Axis::Z] += if upwards { travel } else { -travel };
        Search { target, rate, until: Until::Touch }
    }
}
