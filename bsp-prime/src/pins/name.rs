//! Names of pins, `PD3`, and of pins with modifiers, `PE1!^`.

use core::fmt;

/// Number of ports of the package: A to K.
pub const PORTS: usize = 11;

/// Pin of the chip: port and number.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PinName {
    port: u8,
    number: u8,
}

impl PinName {
    /// From a port letter and a number; for tables of constants. Out of range gives the last pin there is,
    /// PK15, which leads nowhere.
    #[must_use]
    pub const fn new(port: char, number: u8) -> Self {
        let port = (port as u8).wrapping_sub(b'A');
        if (port as usize) < PORTS && number < 16 { Self { port, number } } else { Self { port: 10, number: 15 } }
    }

    /// Returns the pin of a number that counts sixteen to a port: PA0 is 0, PK15 is 175.
    #[must_use]
    pub const fn numbered(number: u32) -> Option<Self> {
        if number < PORTS as u32 * 16 {
            Some(Self { port: (number / 16) as u8, number: (number % 16) as u8 })
        } else {
            None
        }
    }

    /// Reads `PD3`, `pd3`, `PD_3`, `PD.3` as configuration files write them.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let rest = text.strip_prefix(['P', 'p'])?;
        let letter = rest.chars().next()?.to_ascii_uppercase();
        let port = (letter as u32).checked_sub('A' as u32)? as usize;
        let digits = rest.get(1..)?.trim_start_matches(['_', '.']);
        let number: u8 = if digits.starts_with('+') { return None } else { digits.parse().ok()? };
        (port < PORTS && number < 16).then_some(Self { port: port as u8, number })
    }

    /// Port index, A being 0.
    #[must_use]
    pub const fn port(self) -> usize {
        self.port as usize
    }

    /// Pin number within the port, 0 to 15.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.number
    }

    /// The pin's bit within its port.
    #[must_use]
    pub const fn bit(self) -> u32 {
        1 << self.number
    }
}

impl fmt::Display for PinName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "P{}{}", (b'A' + self.port) as char, self.number)
    }
}

impl fmt::Debug for PinName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Resistor to hold an open input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pull {
    /// To 3.3 V, about 40 kOhm. The default, as the endstop buffers are open-drain.
    #[default]
    Up,
    /// To ground, about 40 kOhm.
    Down,
    /// No pull-up or pull-down resistor.
    Floating,
}

/// Pin with the modifiers of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinSpec {
    /// Name of the pin.
    pub pin: PinName,
    /// `!`: on is low.
    pub inverted: bool,
    /// `o`: only ever pulls low.
    pub open_drain: bool,
    /// `^`, `v`, `-`: resistor of an input.
    pub pull: Pull,
}

impl PinSpec {
    /// Creates a plain pin: on is high, push-pull, pull-up as an input.
    #[must_use]
    pub const fn plain(pin: PinName) -> Self {
        Self { pin, inverted: false, open_drain: false, pull: Pull::Up }
    }

    /// Creates a plain pin with on being low.
    #[must_use]
    pub const fn inverted(pin: PinName) -> Self {
        Self { inverted: true, ..Self::plain(pin) }
    }

    /// Reads `PE1!^`: a pin name followed by modifiers in any order.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let split = text.find(['!', 'o', '^', 'v', '-']).unwrap_or(text.len());
        let mut spec = Self::plain(PinName::parse(text.get(..split)?)?);
        for modifier in text.get(split..)?.chars() {
            match modifier {
                '!' => spec.inverted = true,
                'o' => spec.open_drain = true,
                '^' => spec.pull = Pull::Up,
                'v' => spec.pull = Pull::Down,
                '-' => spec.pull = Pull::Floating,
                _ => return None,
            }
        }
        Some(spec)
    }
}
