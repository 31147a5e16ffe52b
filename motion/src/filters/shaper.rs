//! Input shapers: a few weighted, delayed copies of an axis whose vibrations cancel each other.
//!
//! A resonance of frequency f and damping ratio z answers an impulse with a decaying oscillation of period
//! `Td = 1 / (f q)`, `q = sqrt(1 - z^2)`, which loses the factor `K = exp(-z pi / q)` in half a period. The
//! shapers differ in how far the frequency may be off and in how long they take. Sources: Singer and Seering
//! 1990 (ZV, ZVD); Singhose, Seering and Singer 1994 and Singhose 1997 (EI and its humps, with a tolerated
//! vibration of 1/20); amplitudes and times as Klipper documents them, against whose values they are tested.

use core::f64::consts::PI;

use crate::square_root;
pub use units::ShaperKind;

/// Most pulses of any shaper.
pub const MAX_PULSES: usize = 5;

/// Vibration that the EI shapers tolerate at the design frequency, as a share of the unshaped one.
const TOLERANCE: f64 = 0.05;

/// Lowest and highest frequency that can be shaped, Hz: the slowest shaper spans 0.4 s at the lower end.
pub const FREQUENCY_RANGE: (f64, f64) = (5.0, 1_000.0);

/// A shaper for one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaper {
    /// Kind of the shaper.
    pub kind: ShaperKind,
    /// Resonance frequency, in Hz.
    pub frequency: f64,
    /// Damping ratio of the resonance, 0 to [`ShaperKind::max_damping`].
    pub damping: f64,
}

/// A weighted, delayed copy of the input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pulse {
    /// Weight; those of a shaper add up to one.
    pub amplitude: f64,
    /// Delay after the first pulse, seconds.
    pub time: f64,
}

/// The pulses of a shaper, in order of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pulses {
    pulses: [Pulse; MAX_PULSES],
    count: usize,
}

/// Cubics of the damping ratio, constant term first: time in periods of the undamped resonance, and
/// amplitude.
type Hump = ([f64; 4], [f64; 4]);

const TWO_HUMPS: [Hump; 4] = [
    ([0.0, 0.0, 0.0, 0.0], [0.160_54, 0.766_99, 2.265_60, -1.227_50]),
    ([0.498_90, 0.162_70, -0.542_62, 6.161_80], [0.339_11, 0.450_81, -2.580_80, 1.736_50]),
    ([0.997_48, 0.183_82, -1.582_70, 8.171_20], [0.340_89, -0.615_33, -0.687_65, 0.422_61]),
    ([1.499_20, -0.092_97, -0.283_38, 1.857_10], [0.159_97, -0.602_46, 1.002_80, -0.931_45]),
];

const THREE_HUMPS: [Hump; 5] = [
    ([0.0, 0.0, 0.0, 0.0], [0.112_75, 0.766_32, 3.291_60, -1.443_80]),
    ([0.499_74, 0.238_34, 0.445_59, 12.472_0], [0.236_98, 0.611_64, -2.578_50, 4.852_20]),
    ([0.998_49, 0.298_08, -2.364_60, 23.399_0], [0.300_08, -0.190_62, -2.145_60, 0.137_44]),
    ([1.498_70, 0.103_06, -2.013_90, 17.032_0], [0.237_75, -0.732_97, 0.468_85, -2.086_50]),
    ([1.999_60, -0.282_31, 0.615_36, 5.404_50], [0.112_44, -0.454_39, 0.963_82, -1.460_00]),
];

fn cubic([c0, c1, c2, c3]: [f64; 4], z: f64) -> f64 {
    c0 + (c1 + (c2 + c3 * z) * z) * z
}

impl Shaper {
    /// Whether frequency and damping ratio are in range.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        // A NaN lies in no range.
        (FREQUENCY_RANGE.0..=FREQUENCY_RANGE.1).contains(&self.frequency)
            && (0.0..=self.kind.max_damping()).contains(&self.damping)
    }

    /// Returns the shaper's pulses, the first at time zero, amplitudes adding up to one.
    #[must_use]
    pub fn pulses(&self) -> Pulses {
        let z = self.damping;
        let q = square_root(1.0 - z * z);
        let period = 1.0 / (self.frequency * q);
        // Share of an oscillation's amplitude that is left after this share of a damped period.
        let decay = |share: f64| libm::exp(-2.0 * share * z * PI / q);
        let k = decay(0.5);
        match self.kind {
            ShaperKind::Zv => Pulses::of(&[(1.0, 0.0), (k, 0.5)], period),
            ShaperKind::Zvd => Pulses::of(&[(1.0, 0.0), (2.0 * k, 0.5), (k * k, 1.0)], period),
            ShaperKind::Mzv => {
                // Amplitudes 1 - 1/sqrt 2, sqrt 2 - 1, 1 - 1/sqrt 2 cancel three pulses three eighths apart.
                let outer = 1.0 - core::f64::consts::FRAC_1_SQRT_2;
                let (middle, k) = (core::f64::consts::SQRT_2 - 1.0, decay(0.375));
                Pulses::of(&[(outer, 0.0), (middle * k, 0.375), (outer * k * k, 0.75)], period)
            }
            ShaperKind::Ei => Self::extra_insensitive(z, period),
            ShaperKind::TwoHumpEi => Self::humps(&TWO_HUMPS, z, 1.0 / self.frequency),
            ShaperKind::ThreeHumpEi => Self::humps(&THREE_HUMPS, z, 1.0 / self.frequency),
        }
    }

    fn extra_insensitive(z: f64, period: f64) -> Pulses {
        let v = TOLERANCE;
        let first = (0.249_68 + 0.249_61 * v) + ((0.800_08 + 1.233_28 * v) + (0.495_99 + 3.173_16 * v) * z) * z;
        let last = (0.251_49 + 0.214_74 * v) + ((-0.832_49 + 1.414_98 * v) + (0.851_81 - 4.900_94 * v) * z) * z;
        let bend = [(0.461_59 + 8.578_43 * v) * v, (4.261_69 - 108.644 * v) * v, (1.756_01 + 336.989 * v) * v];
        let middle_time = 0.499_9 + bend[0] * z + bend[1] * z * z + bend[2] * z * z * z;
        Pulses::of(&[(first, 0.0), (1.0 - first - last, middle_time), (last, 1.0)], period)
    }

    fn humps(table: &[Hump], z: f64, period: f64) -> Pulses {
        let mut pairs = [(0.0, 0.0); MAX_PULSES];
        for (pair, (time, amplitude)) in pairs.iter_mut().zip(table) {
            *pair = (cubic(*amplitude, z), cubic(*time, z));
        }
        Pulses::of(pairs.get(..table.len()).unwrap_or_default(), period)
    }
}

impl Pulses {
    /// Builds the pulses from pairs of amplitude and time in periods.
    fn of(pairs: &[(f64, f64)], period: f64) -> Self {
        let sum: f64 = pairs.iter().map(|(amplitude, _)| amplitude).sum();
        let mut pulses = Self::default();
        for (pulse, (amplitude, time)) in pulses.pulses.iter_mut().zip(pairs) {
            *pulse = Pulse { amplitude: amplitude / sum, time: time * period };
            pulses.count += 1;
        }
        pulses
    }

    /// The pulses, in order of time.
    #[must_use]
    pub fn as_slice(&self) -> &[Pulse] {
        self.pulses.get(..self.count).unwrap_or_default()
    }

    /// Returns the time by which the shaped axis must look ahead so that it does not lag at constant speed:
    /// the mean time of the pulses, seconds.
    #[must_use]
    pub fn shift(&self) -> f64 {
        self.as_slice().iter().map(|pulse| pulse.amplitude * pulse.time).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Amplitudes, times in ms and shift in ms at 50 Hz and a damping ratio of 0.1, as Klipper computes them.
    const KNOWN: [(ShaperKind, &[f64], &[f64], f64); 6] = [
        (ShaperKind::Zv, &[0.578_286, 0.421_714], &[0.0, 10.0504], 4.2384),
        (ShaperKind::Mzv, &[0.365_128, 0.407_489, 0.227_383], &[0.0, 7.5378, 15.0756], 6.4995),
        (ShaperKind::Zvd, &[0.334_415, 0.487_743, 0.177_843], &[0.0, 10.0504, 20.1008], 8.4768),
        (ShaperKind::Ei, &[0.354_881, 0.452_998, 0.192_121], &[0.0, 10.1448, 20.1008], 8.4573),
        (
            ShaperKind::TwoHumpEi,
            &[0.258_535, 0.359_936, 0.272_764, 0.108_765],
            &[0.0, 10.3181, 20.1641, 29.7785],
            12.4528,
        ),
        (
            ShaperKind::ThreeHumpEi,
            &[0.220_854, 0.277_211, 0.259_700, 0.167_055, 0.075_179],
            &[0.0, 10.8100, 20.5610, 30.1180, 39.6585],
            16.3492,
        ),
    ];

    #[test]
    fn pulses_have_the_known_amplitudes_and_times() {
        for (kind, amplitudes, times, shift) in KNOWN {
            let pulses = Shaper { kind, frequency: 50.0, damping: 0.1 }.pulses();
            assert_eq!(pulses.as_slice().len(), amplitudes.len(), "{kind:?}");
            for ((pulse, amplitude), time) in pulses.as_slice().iter().zip(amplitudes).zip(times) {
                assert!((pulse.amplitude - amplitude).abs() < 1e-6, "{kind:?}: {pulse:?} is not {amplitude}");
                assert!((pulse.time * 1e3 - time).abs() < 1e-4, "{kind:?}: {pulse:?} is not at {time} ms");
            }
            assert!((pulses.shift() * 1e3 - shift).abs() < 1e-4, "{kind:?}: {}", pulses.shift());
        }
    }

    /// Vibration that is left at `frequency`, as a share of what one impulse leaves.
    fn residue(shaper: &Shaper, frequency: f64) -> f64 {
        let omega = 2.0 * PI * frequency;
        let damped = omega * (1.0 - shaper.damping * shaper.damping).sqrt();
        let pulses = shaper.pulses();
        let last = pulses.as_slice().last().map_or(0.0, |pulse| pulse.time);
        let sum = |wave: fn(f64) -> f64| -> f64 {
            let part = |pulse: &Pulse| {
                pulse.amplitude * (-shaper.damping * omega * (last - pulse.time)).exp() * wave(damped * pulse.time)
            };
            pulses.as_slice().iter().map(part).sum()
        };
        sum(f64::cos).hypot(sum(f64::sin))
    }

    proptest! {
        #[test]
        fn a_shaper_leaves_no_more_vibration_than_it_tolerates(frequency in 10.0..200.0_f64, damping in 0.0..0.2_f64) {
            for &kind in ShaperKind::ALL {
                let left = residue(&Shaper { kind, frequency, damping }, frequency);
                let tolerated = match kind {
                    ShaperKind::Zv | ShaperKind::Mzv | ShaperKind::Zvd => 1e-9,
                    // Fitted polynomials: near the tolerance, not at it.
                    _ => 1.2 * TOLERANCE,
                };
                prop_assert!(left <= tolerated, "{kind:?} leaves {left}");
            }
        }

        #[test]
        fn pulses_are_positive_ordered_and_add_up_to_one(damping in 0.0..0.2_f64, frequency in 5.0..1000.0_f64) {
            for &kind in ShaperKind::ALL {
                let shaper = Shaper { kind, frequency, damping };
                prop_assert!(shaper.is_valid());
                let pulses = shaper.pulses();
                let sum: f64 = pulses.as_slice().iter().map(|pulse| pulse.amplitude).sum();
                prop_assert!((sum - 1.0).abs() < 1e-14);
                prop_assert!(pulses.as_slice().iter().all(|pulse| pulse.amplitude > 0.0));
                prop_assert!(pulses.as_slice().windows(2).all(|pair| pair[0].time < pair[1].time));
            }
        }
    }

    #[test]
    fn frequencies_and_damping_ratios_out_of_range_are_not_valid() {
        let valid = |kind, frequency, damping| Shaper { kind, frequency, damping }.is_valid();
        assert!(valid(ShaperKind::ThreeHumpEi, 40.0, 0.2));
        assert!(!valid(ShaperKind::ThreeHumpEi, 40.0, 0.21));
        assert!(!valid(ShaperKind::Mzv, 0.0, 0.1) && !valid(ShaperKind::Mzv, f64::NAN, 0.1));
        assert!(!valid(ShaperKind::Mzv, 40.0, -0.1) && !valid(ShaperKind::Mzv, 40.0, f64::NAN));
    }
}
