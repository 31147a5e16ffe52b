//! The sums of a run's time: by kind, layer, feature and object.

use serde::Serialize;

use super::marks::Label;
use super::path::Samples;
use super::program::Program;
use super::spent::{Kind, Span};

/// Sums of a run's time.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Times {
    /// Length of the run, seconds.
    pub seconds: f64,
    /// Times by kind, in the order of [`Kind::ALL`]; they sum to `seconds`.
    pub kinds: Vec<KindRow>,
    /// Moving time of print moves and of travel, by change of speed.
    pub pace: [Pace; 2],
    /// Motion and waiting that belong to no known line of the program, seconds.
    pub untold: f64,
    /// Times by layer; row 0 is the time before the first.
    pub layers: Vec<LayerRow>,
    /// Print moves by the slicer's features.
    pub features: Vec<FeatureRow>,
    /// Times by object; the first row is the time that belongs to none.
    pub objects: Vec<ObjectRow>,
}

/// Row of the table of kinds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KindRow {
    /// Kind of time of the row.
    pub kind: Kind,
    /// Name of the kind in words.
    pub name: &'static str,
    /// Time of the kind, seconds.
    pub seconds: f64,
}

/// Moving time by change of speed, seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Pace {
    /// Time at even speed.
    pub cruising: f64,
    /// Time of growing speed.
    pub accelerating: f64,
    /// Time of falling speed.
    pub braking: f64,
}

/// Row of the table of layers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LayerRow {
    /// Layer number from 1; 0 before the first.
    pub number: u32,
    /// Height of the layer's last line of filament, mm.
    pub z: Option<f64>,
    /// Beginning of the layer, seconds.
    pub from: f64,
    /// End of the layer, seconds.
    pub to: f64,
    /// Time spent on the layer's lines, seconds.
    pub seconds: f64,
    /// Waiting as part of that time, seconds.
    pub waiting: f64,
    /// Filament that the layer took, mm.
    pub filament: f64,
}

/// Row of the table of features.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FeatureRow {
    /// Name that the slicer gives the feature; empty if none.
    pub name: String,
    /// Place among all features that the file names, from 1.
    pub place: usize,
    /// Time of the feature's print moves, seconds.
    pub seconds: f64,
    /// Length of the feature's print moves, mm.
    pub length: f64,
    /// Filament that the feature took, mm.
    pub filament: f64,
}

/// Row of the table of objects.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ObjectRow {
    /// Name in the file; empty for the time that belongs to no object.
    pub name: String,
    /// The file says that the object is not to be made.
    pub left_out: bool,
    /// Time spent on the object's lines, seconds.
    pub seconds: f64,
    /// Print moves as part of that time, seconds.
    pub printing: f64,
    /// Filament that the object took, mm.
    pub filament: f64,
}

/// Time on either side over which speeds and their changes are averaged, seconds: in a shorter one single
/// steps show.
const PACE_S: f64 = 0.004;
/// Change of speed below which a speed is even, mm/s^2; single steps of an even speed make less.
const EVEN_MM_PER_S2: f64 = 100.0;

/// Length of the executed path and of filament at any time.
pub struct Odometer<'a> {
    samples: &'a Samples,
    /// Length of the path at each sample, mm.
    length: Vec<f64>,
}

impl<'a> Odometer<'a> {
    /// Measures the path of a run.
    pub fn new(samples: &'a Samples) -> Self {
        let mut sum = 0.0;
        let steps = samples.points.windows(2).map(|pair| {
            sum += (0..3).map(|axis| (pair[1][axis] - pair[0][axis]).powi(2)).sum::<f64>().sqrt();
            sum
        });
        Self { samples, length: std::iter::once(0.0).chain(steps).collect() }
    }

    fn between(&self, at_s: f64, of: impl Fn(usize) -> f64) -> f64 {
        let last = self.samples.points.len() - 1;
        let at = (at_s / self.samples.period_s).clamp(0.0, last as f64);
        let before = at.floor() as usize;
        let after = (before + 1).min(last);
        of(before) + (at - before as f64) * (of(after) - of(before))
    }

    /// Returns the length of the path in a time, mm.
    pub fn length(&self, from_s: f64, to_s: f64) -> f64 {
        self.between(to_s, |sample| self.length[sample]) - self.between(from_s, |sample| self.length[sample])
    }

    /// Returns the filament fed in a time, less the filament pulled back, mm.
    pub fn filament(&self, from_s: f64, to_s: f64) -> f64 {
        let fed = |at_s| self.between(at_s, |sample| self.samples.points[sample][3]);
        fed(to_s) - fed(from_s)
    }

    /// Returns the speed along the path about a sample, mm/s.
    fn speed(&self, sample: usize, window: usize) -> f64 {
        let (first, last) = (sample.saturating_sub(window), (sample + window).min(self.length.len() - 1));
        (self.length[last] - self.length[first]) / ((last - first).max(1) as f64 * self.samples.period_s)
    }

    /// Adds the time of a span to its change of speed.
    fn pace(&self, span: &Span, pace: &mut Pace) {
        let period_s = self.samples.period_s;
        let window = ((PACE_S / period_s) as usize).max(1);
        let mut at_s = span.from_s;
        while at_s < span.to_s {
            let slot = (at_s / period_s + 1e-6) as usize;
            let until_s = ((slot + 1) as f64 * period_s).min(span.to_s);
            let last = self.length.len() - 1;
            let (before, after) = (slot.saturating_sub(window).min(last), (slot + 1 + window).min(last));
            let grows = self.speed(after, window) - self.speed(before, window);
            let change = grows / ((after - before).max(1) as f64 * period_s);
            let sum = match change {
                _ if change > EVEN_MM_PER_S2 => &mut pace.accelerating,
                _ if change < -EVEN_MM_PER_S2 => &mut pace.braking,
                _ => &mut pace.cruising,
            };
            *sum += until_s - at_s;
            at_s = until_s;
        }
    }
}

impl Times {
    /// Sums up a run that took `seconds`.
    pub fn of(spans: &[Span], odometer: &Odometer<'_>, program: Option<&Program>, seconds: f64) -> Self {
        let mut times = Self { seconds, ..Self::default() };
        times.kinds = Kind::ALL.map(|kind| KindRow { kind, name: kind.name(), seconds: 0.0 }).to_vec();
        let names = |names: &[String]| std::iter::once(String::new()).chain(names.iter().cloned()).collect::<Vec<_>>();
        let features = names(program.map_or(&[], |program| program.features.as_slice()));
        let features = features.into_iter().enumerate();
        let features = features.map(|(place, name)| FeatureRow { name, place, ..FeatureRow::default() });
        times.features = features.collect();
        times.objects = vec![ObjectRow::default()];
        for object in program.map_or(&[][..], |program| &program.objects) {
            let (name, left_out) = (object.name.clone(), object.is_left_out);
            times.objects.push(ObjectRow { name, left_out, ..ObjectRow::default() });
        }
        spans.iter().for_each(|span| times.take(span, odometer));
        times.layers.retain(|layer| layer.seconds > 0.0);
        times.features.retain(|feature| feature.seconds > 0.0);
        times.set_heights(program);
        times
    }

    fn take(&mut self, span: &Span, odometer: &Odometer<'_>) {
        let seconds = span.to_s - span.from_s;
        let filament = odometer.filament(span.from_s, span.to_s);
        let kind = self.kinds.iter_mut().find(|row| row.kind == span.kind);
        kind.into_iter().for_each(|row| row.seconds += seconds);
        match span.kind {
            Kind::Print => odometer.pace(span, &mut self.pace[0]),
            Kind::Travel => odometer.pace(span, &mut self.pace[1]),
            _ => {}
        }
        if span.line.is_none() && matches!(span.kind, Kind::Print | Kind::Travel) {
            self.untold += seconds;
        }
        let Label { layer, feature, object } = span.label;
        let place = layer as usize;
        if self.layers.len() <= place {
            self.layers.resize(place + 1, LayerRow::default());
        }
        let row = &mut self.layers[place];
        if row.seconds == 0.0 {
            (row.number, row.from) = (layer, span.from_s);
        }
        row.to = span.to_s;
        row.seconds += seconds;
        row.filament += filament;
        if !matches!(span.kind, Kind::Print | Kind::Travel | Kind::Filament | Kind::Own) {
            row.waiting += seconds;
        }
        if let (Kind::Print, Some(row)) = (span.kind, self.features.get_mut(feature as usize)) {
            row.seconds += seconds;
            row.length += odometer.length(span.from_s, span.to_s);
            row.filament += filament;
        }
        if let Some(row) = self.objects.get_mut(object as usize) {
            row.seconds += seconds;
            row.filament += filament;
            row.printing += if span.kind == Kind::Print { seconds } else { 0.0 };
        }
    }

    fn set_heights(&mut self, program: Option<&Program>) {
        let corners = program.map_or(&[][..], |program| &program.corners);
        for corner in corners.iter().filter(|corner| corner.extrudes) {
            let place = self.layers.binary_search_by_key(&corner.label.layer, |row| row.number);
            if let Ok(place) = place {
                self.layers[place].z = Some(corner.at[2]);
            }
        }
    }

    /// Returns the time of a kind, seconds.
    pub fn of_kind(&self, kind: Kind) -> f64 {
        self.kinds.iter().find(|row| row.kind == kind).map_or(0.0, |row| row.seconds)
    }
}
