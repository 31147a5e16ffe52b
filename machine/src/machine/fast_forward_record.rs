//! Record of the lines that a fast-forward ([`super::fast_forward`]) has read over.

use base::failure::Failure;
use config::{MAX_SWITCHES, MAX_TEMPERATURES};
use program::{Move, Place, Rate};
use units::{Axis, Celsius, HeaterId, MmPerSecond, PerAxis, SwitchId};

/// End of a fast-forward: behind a line, so that the next line read is the first to be carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Until {
    /// So many lines have begun that are no comments, each as often as it did: `Jobs::begun`.
    Begun(u32),
    /// Moves of so many seconds, at the speeds of the program, have been read.
    Seconds(f64),
    /// The line of this number is next, in the file itself.
    Line(u32),
    /// The line that begins at this offset or behind it is next.
    Offset(u32),
    /// The layer of this number begins.
    Layer(u32),
}

impl Until {
    /// Returns whether reading over has come to the place that it goes to: moves begun, the next line, the
    /// layer, and the seconds of the job.
    pub fn is_reached(self, begun: u32, next: Place, layer: u32, seconds: f64) -> bool {
        match self {
            Self::Begun(lines) => begun >= lines,
            Self::Seconds(long) => seconds >= long,
            Self::Line(number) => next.line + 1 >= number,
            Self::Layer(number) => layer >= number,
            Self::Offset(bytes) => next.offset >= bytes,
        }
    }
}

/// Record of the lines read over.
#[derive(Debug)]
pub(crate) struct Passed {
    pub until: Until,
    /// The place was reached; else the file or its program has ended before, or could not be read.
    pub has_arrived: bool,
    /// Last targets asked of heaters, by their numbers.
    pub targets: [Option<Celsius>; MAX_TEMPERATURES],
    /// Last states asked of switches: on or off, and S.
    pub switches: [Option<(bool, Option<f32>)>; MAX_SWITCHES],
    /// Number of lines that are not carried out: the file was paused there, and somebody has gone on.
    pub refused: u32,
    /// The program has asked the machine: the answer of a probe or an input is not known any more.
    pub has_asked: bool,
    /// Place where the last line read has begun: its moves go from here.
    pub line_began_at: PerAxis<f64>,
    /// Place where the last line's moves lead.
    pub at: PerAxis<f64>,
    /// Duration of the moves at the speeds of the program, s.
    pub seconds: f64,
    /// Lowest and highest Z of the moves, mm.
    pub z: [f64; 2],
}

impl Passed {
    /// Makes an empty record; the program stands here.
    pub const fn new(until: Until, here: PerAxis<f64>) -> Self {
        Self {
            until,
            has_arrived: false,
            targets: [None; MAX_TEMPERATURES],
            switches: [None; MAX_SWITCHES],
            refused: 0,
            has_asked: false,
            line_began_at: here,
            at: here,
            seconds: 0.0,
            z: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Returns the record, if its fast-forward came to its place and asked nothing on the way. Then the
    /// program stands where the file does, and the machine anywhere.
    ///
    /// # Errors
    /// `ends_before`; or that it asked.
    pub fn arrived(passed: Option<Self>, ends_before: &'static &'static str) -> Result<Self, Failure> {
        match passed.filter(|passed| passed.has_arrived) {
            None => Err(Failure::refused(ends_before)),
            Some(Self { has_asked: true, .. }) => {
                Err(Failure::refused(&"the file probes or reads inputs before: what follows depends on what it finds"))
            }
            Some(passed) => Ok(passed),
        }
    }

    /// Notes a move that is read over.
    pub fn go(&mut self, request: &Move) {
        let from = core::mem::replace(&mut self.at, request.target);
        let z = request.target[Axis::Z];
        self.z = [self.z[0].min(z), self.z[1].max(z)];
        let (Rate::Rapid(MmPerSecond(speed)) | Rate::Feed(MmPerSecond(speed))) = request.rate else { return };
        let squares = Axis::PRIMARY
            .into_iter()
            .map(|axis| (request.target[axis] - from[axis]) * (request.target[axis] - from[axis]));
        if speed > 0.0 {
            self.seconds += libm::sqrt(squares.sum()) / speed;
        }
    }

    /// Notes a state of a switch that is read over.
    pub fn note_switch(&mut self, switch: SwitchId, on: bool, value: Option<f32>) {
        if let Some(last) = self.switches.get_mut(switch.index()) {
            *last = Some((on, value));
        }
    }

    /// Notes a target that is read over.
    pub fn note_target(&mut self, heater: HeaterId, target: Celsius) {
        if let Some(last) = self.targets.get_mut(heater.index()) {
            *last = Some(target);
        }
    }
}
