//! Bits of inputs. Numbers, not names: the board binds each to a pin once, at boot.

const _: () = assert!(config::MAX_ENDSTOPS <= 12, "endstops must fit below the switches in the input word");

/// Input that the machine knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Endstop, by its place in the configuration's list.
    Endstop(u8),
    /// The probe's contact closes.
    Probe,
    /// The probe's contact opens. For the trigger latch alone, whose inputs fire when they become active.
    ProbeOpen,
    /// The kill button is pressed.
    Kill,
    /// Input switch, by its place in the configuration's list of switches.
    Switch(u8),
    /// There is no filament, or it is too thick.
    Filament,
    /// The wheel that filament turns.
    FilamentWheel,
    /// The probe is deployed.
    ProbeDeployed,
    /// A button of the button box, by its place in the configuration's list.
    Button(u8),
    /// The safety door is open.
    Door,
    /// The on-board driver of the motor with this number reports a stall.
    Stall(u8),
}

impl Input {
    /// Returns the input's place in [`InputLevels`]; for inputs that stop motion, below 32, also the number
    /// at the trigger latch.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Endstop(index) => index & 0xF,
            Self::Switch(index) => 12 + (index & 0xF),
            Self::Probe => 28,
            Self::Kill => 29,
            Self::ProbeOpen => 30,
            Self::Filament => 32,
            Self::FilamentWheel => 33,
            Self::ProbeDeployed => 34,
            Self::Button(index) => 40 + (index & 0xF),
            Self::Door => 35,
            Self::Stall(motor) => 56 + (motor & 7),
        }
    }

    /// Returns the input's bit in the trigger latch's masks; 0 for one that never stops motion.
    #[must_use]
    pub const fn bit(self) -> u32 {
        match 1_u32.checked_shl(self.number() as u32) {
            Some(bit) => bit,
            None => 0,
        }
    }
}

/// Level of every input, one bit each; set is triggered or pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputLevels(u64);

impl InputLevels {
    /// Returns the same levels with this input triggered as well.
    #[must_use]
    pub const fn with(self, input: Input) -> Self {
        self.with_number(input.number())
    }

    /// Returns the same levels with the input of this number triggered as well.
    #[must_use]
    pub const fn with_number(self, number: u8) -> Self {
        Self(self.0 | 1 << (number & 63))
    }

    /// Returns the levels of the inputs that can stop motion, as in the trigger latch's masks.
    #[must_use]
    pub const fn mask(self) -> u32 {
        self.0 as u32
    }

    /// Returns whether an input is triggered.
    #[must_use]
    pub const fn is_active(self, input: Input) -> bool {
        self.0 & 1 << input.number() != 0
    }
}
