//! Physical quantities as newtypes. Public interfaces use them; inside a function a bare number with its unit
//! in the name will do. Motion is `f64` (a metre of travel to the nanometre needs more than 24 bits),
//! everything electrical and thermal is `f32`.

use core::ops::{Add, Mul, Neg, Sub};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident($number:ty), $symbol:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        pub struct $name(pub $number);

        impl $name {
            /// Returns the bare number, in this type's unit.
            #[must_use]
            pub const fn get(self) -> $number {
                self.0
            }
        }

        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl Neg for $name {
            type Output = Self;
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Mul<$number> for $name {
            type Output = Self;
            fn mul(self, factor: $number) -> Self {
                Self(self.0 * factor)
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                self.0.fmt(f)?;
                f.write_str(concat!(" ", $symbol))
            }
        }
    };
}

quantity!(
    /// Length in millimetres (degrees for a rotary auxiliary axis).
    Mm(f64), "mm");
quantity!(
    /// Speed in millimetres per second.
    MmPerSecond(f64), "mm/s");
quantity!(
    /// Acceleration in millimetres per second squared.
    MmPerSecond2(f64), "mm/s^2");
quantity!(
    /// Jerk, the rate of change of acceleration, in millimetres per second cubed.
    MmPerSecond3(f64), "mm/s^3");
quantity!(
    /// Temperature in degrees Celsius.
    Celsius(f32), "C");
quantity!(
    /// Electric potential in volts.
    Volts(f32), "V");
quantity!(
    /// Electric current in amperes, peak unless a name says otherwise.
    Amps(f32), "A");
quantity!(
    /// Electric resistance in ohms.
    Ohms(f32), "Ohm");

impl MmPerSecond {
    /// Converts from the millimetres per minute of programs and configuration files.
    #[must_use]
    pub const fn from_per_minute(mm_per_minute: f64) -> Self {
        Self(mm_per_minute / 60.0)
    }

    /// Converts to the millimetres per minute that programs and reports use.
    #[must_use]
    pub const fn per_minute(self) -> f64 {
        self.0 * 60.0
    }
}

/// Share of full power of a switched output, 0 (off) to 255 (fully on), the resolution of the sigma-delta
/// modulator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Duty(pub u8);

impl Duty {
    /// Duty of an output that is off.
    pub const OFF: Self = Self(0);
    /// Duty of an output that is always on.
    pub const FULL: Self = Self(255);
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn quantities_add_scale_and_print_with_their_unit() {
        assert_eq!(Mm(1.5) + Mm(2.0) * 2.0 - Mm(0.5), Mm(5.0));
        assert_eq!(MmPerSecond::from_per_minute(1_500.0), MmPerSecond(25.0));
        assert_eq!(MmPerSecond(25.0).per_minute(), 1_500.0);
        assert_eq!(Celsius(-4.5).to_string(), "-4.5 C");
        assert_eq!(std::format!("{:.2}", Volts(24.0)), "24.00 V");
    }
}
