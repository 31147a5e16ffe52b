//! Reasons of a shutdown, in the words that Klipper's host knows (its advice depends on their beginning).

macro_rules! reasons {
    ($($(#[$meta:meta])* $name:ident = $text:literal),* $(,)?) => {
        /// Reason of a shutdown, or of the refusal of a command.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u16)]
        #[allow(missing_docs, reason = "the texts say it")]
        pub enum Reason {
            $($(#[$meta])* $name),*
        }

        impl Reason {
            /// All reasons, in the order of their numbers.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// Returns the text of the dictionary's enumeration `static_string_id`.
            #[must_use]
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$name => $text),*
                }
            }
        }
    };
}

reasons! {
    TimerTooClose = "Timer too close",
    RescheduledInPast = "Rescheduled timer in the past",
    MissedDigitalOut = "Missed scheduling of next digital out event",
    MissedPwm = "Missed scheduling of next hard pwm event",
    DigitalOutDuration = "Scheduled digital out event will exceed max_duration",
    PwmDuration = "Scheduled pwm event will exceed max_duration",
    AdcOutOfRange = "ADC out of range",
    StepperTooLate = "Stepper too far in past",
    CommandRequest = "Command request",
    InvalidCommand = "Invalid command",
    ParserError = "Command parser error",
    NotShutdown = "Shutdown cleared when not shutdown",
    OidsAllocated = "oids already allocated",
    CannotAssignOid = "Can't assign oid",
    InvalidOid = "Invalid oid type",
    AlreadyFinalized = "Already finalized",
    TooManyObjects = "More objects than this board has room for",
    MoveQueueOverflow = "Move queue overflow",
    UpdateWhileQueued = "update_digital_out not valid with active queue",
    CycleWhileQueued = "Can not set soft pwm cycle ticks while updates pending",
    ResetWhileActive = "Can't reset time when stepper active",
    InvalidCount = "Invalid count parameter",
    TooManyMotors = "This board steps six motors at most",
    ReportTooLong = "Invalid analog_in bytes_per_report",
    InvalidSpi = "Invalid spi config",
    InvalidSpiBus = "Invalid spi bus",
    NotAPin = "Not a valid pin",
    NotAnAnalogPin = "Not a valid ADC pin",
    NotAPwmPin = "Not a valid PWM pin",
    PwmOtherSpeed = "PWM already programmed at different speed",
    ButtonsRetransmit = "Invalid buttons retransmit count",
    ButtonsRange = "Set button past maximum button count",
    ButtonsMost = "Max of 8 buttons",
    NotReadable = "debug_read reads the chip's factory words only",
    UartTooLong = "tmcuart data too large",
    LightsSize = "Invalid neopixel data_size",
    LightsUpdate = "Invalid neopixel update command",
    TooManyLights = "This board has memory for four strips of lights",
    AdcStopped = "The converter has stopped",
}

impl Reason {
    /// Number in the enumeration `static_string_id`, of which 2 is the lowest used.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16 + 2
    }
}
