//! The board and the program itself: `[general]`, `[system]`, consoles, kill button, player.

use crate::names::{Command, spaced};
use crate::pin::Pin;
use crate::setting::build::{bool, integer, number, pin, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::{PinRole, Words};
use gcode::Dialect;
use units::{CycleSetup, Micros, Volts};

/// Kind of board the image runs on; decides the default driver chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoardId {
    /// Prime with TMC2590 drivers (board id 0, and any unknown id).
    #[default]
    Prime2590,
    /// Prime with TMC2660 drivers (board id 1).
    Prime2660,
}

impl BoardId {
    /// Returns the board for the number on its four identity pins.
    #[must_use]
    pub const fn from_id(id: u8) -> Self {
        if id == 1 { Self::Prime2660 } else { Self::Prime2590 }
    }
}

settings! {
    /// How the firmware talks and starts.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct General {
        /// Consoles speak GRBL 1.1 (docs/grbl.md), and G4, G28, G30 and M30 mean what they mean there.
        grbl_mode: bool = bool("false");
        /// With grbl_mode, what grblHAL says besides, for senders that look for it: fields of the status,
        /// `$I+`, `$ES`.
        grblhal: bool = bool("false").velvet();
        /// At the end of boot, replay the settings that M500, or `$n=` of GRBL's dialect, saved in
        /// /sd/config-override.
        "config-override" config_override: bool = bool("false").derived("as grbl_mode");
        /// What consoles speak, and files that do not say it, without grbl_mode (docs/dialects.md). The
        /// command `dialect` changes it for one console.
        dialect: Dialect = word("smoothie", OF_CONSOLES)
            .velvet() => |word: usize| DIALECTS.get(word).copied().unwrap_or_default();
    }
}

impl General {
    /// Returns the dialect of lines of the machine's own: saved settings, configured scripts.
    #[must_use]
    pub const fn own_dialect(&self) -> Dialect {
        if self.grbl_mode { Dialect::Grbl } else { Dialect::Smoothie }
    }

    /// Returns the dialect of sessions that have none of their own, and of files that do not say theirs.
    #[must_use]
    pub const fn usual_dialect(&self) -> Dialect {
        if self.grbl_mode { Dialect::Grbl } else { self.dialect }
    }
}

/// Dialects of consoles and of files, in the order of their words.
const DIALECTS: [Dialect; 5] =
    [Dialect::Smoothie, Dialect::Marlin, Dialect::RepRapFirmware, Dialect::Klipper, Dialect::Grbl];
const OF_CONSOLES: &Words = &Words(&["smoothie", "marlin", "reprapfirmware", "klipper"]);
const OF_FILES: &Words = &Words(&["auto", "smoothie", "marlin", "reprapfirmware", "klipper", "grbl"]);

settings! {
    /// Canned cycles G73 and G81 to G89.
    rows Cycles of CycleSetup {
        /// Understand canned cycles; else they are refused.
        "enable" is_off = bool("true").v1("drillingcycles.enable") => |enable: bool| !enable;
        /// Unit of a cycle's P word: S for seconds, P for milliseconds.
        "dwell_units" dwell_in_ms = word("S", &Words(&["S", "P"])).v1("drillingcycles.dwell_units");
    }
}

settings! {
    /// The board: step timing, power outputs, indicator lamps.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct SystemConfig {
        /// Length of a step pulse to an external driver. On-board drivers step on both edges and need none.
        step_pulse_us: u32 = integer("1", &(1, 65_535))
            .limited(&(1.0, 20.0)).unit("us").v1("microseconds_per_step_pulse");
        /// Highest step rate of one motor; a max_rate beyond it is lowered with a warning. Velvet has no
        /// fixed step tick, so this is only a limit.
        "step_frequency" step_frequency_hz: u32 = integer("200000", &(1, i32::MAX as i64))
            .unit("Hz").limited(&(1.0, 1_000_000.0)).v1("base_stepping_frequency");
        /// A second lamp that shows what board LED 2 shows: on while moving, blinking in a halt.
        aux_play_led: Option<Pin> = pin("nc", PinRole::Output).v1("play_led_pin");
        /// At boot, install /sd/flashme.bin when it is firmware for this board and another one than what runs
        /// (docs/updates.md).
        flash_on_boot: bool = bool("true");
        /// Let a computer ask for the firmware download over USB (DFU); refused while the machine moves,
        /// heats or plays a file.
        dfu_enable: bool = bool("false");
        /// USB has a card reader, which the command msc gives the SD card to. false: there is none, and msc
        /// is refused.
        msc_enable: bool = bool("true");
        /// Lamp that blinks while the computer at the USB socket has the SD card.
        msc_led: Option<Pin> = pin("PF13", PinRole::Output);
        /// Enables all MOSFET outputs; active except in a halt. It must be open drain: its pull-up goes to 5
        /// V.
        fets_enable_pin: Option<Pin> = pin("PF14!o", PinRole::Output);
        /// Switches the supply of hot ends and fans; on except in a halt. The bed's supply cannot be
        /// switched.
        fets_power_enable_pin: Option<Pin> = pin("PD7", PinRole::Output);
        /// When the supply of motors (vmotor) or heaters (vfet) falls below this while something heats or
        /// moves, heaters go off at once, motors brake and are held as long as it lasts, and it is told at
        /// the next start. 0: never.
        brown_out_volts: Option<Volts> = number("", &(0.0, 60.0))
            .derived("three quarters of what the supply usually has").unit("V").typical(&(5.0, 45.0)).velvet();
        /// Whether there is a second USB serial port.
        second_usb_serial_enable: bool;
    }
}

settings! {
    /// Whose firmware may be installed and run (docs/updates.md).
    #[derive(Clone, Copy, Debug, Default)]
    pub struct UpdateConfig {
        /// The owner's Ed25519 public key, 64 hexadecimal digits, as `velvet key` makes it. Firmware that is
        /// signed with another key is refused then.
        "key" = text("", 64).velvet() => UpdateConfig::set_key;
        /// Only firmware that is signed with the key; false: what is not signed at all may run as well. A
        /// debug probe can do what it likes.
        locked: bool = bool("false").velvet();
        /// The owner's Ed25519 public key.
        key: Option<[u8; 32]>;
        /// Whether the text written for `key` is no valid key.
        key_is_flawed: bool;
    }
}

impl UpdateConfig {
    /// Returns whether the section is consistent: the key is valid, and a lock has a key.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        !self.key_is_flawed && (self.key.is_some() || !self.locked)
    }

    /// Parses the key from 64 hexadecimal digits; an empty text means no key.
    pub(crate) fn set_key(&mut self, text: &str) {
        let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
        let mut key = [0; 32];
        let mut is_good = text.len() == 2 * key.len();
        for (place, pair) in key.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
            match pair {
                [high, low] => match (digit(*high), digit(*low)) {
                    (Some(high), Some(low)) => *place = high << 4 | low,
                    _ => is_good = false,
                },
                _ => is_good = false,
            }
        }
        self.key = is_good.then_some(key);
        self.key_is_flawed = !is_good && !text.is_empty();
    }
}

words! {
    /// Parity of the auxiliary UART.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[allow(missing_docs, reason = "the names are the meaning")]
    pub enum Parity {
        #[default]
        None = "none",
        Odd = "odd",
        Even = "even",
    }
}

settings! {
    /// The auxiliary UART. The debug UART (PD5, PD6, 115200 baud) is always a console.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct UartConfig {
        /// Use the auxiliary UART.
        enable: bool = bool("false");
        /// A full console; when false the port only sends what echo -1 writes.
        console: bool = bool("true");
        /// 0 is USART3 (receive PB11, send PD8), 1 is UART4 (receive PH14, send PB9).
        channel: u8 = integer("0", &(0, 1));
        /// Bit rate.
        baudrate: u32 = integer("115200", &(1_200, 3_000_000)).unit("baud").v1("uart0.baud_rate");
        /// Word length, parity bit included.
        bits: u8 = integer("8", &(7, 9)).unit("bits");
        /// Stop bits.
        stop_bits: u8 = integer("1", &(1, 2)).unit("bits");
        /// Parity of each word; its bit counts among `bits`.
        parity: Parity = word("none", Parity::WORDS);
    }
}

settings! {
    /// A push button or latching switch that halts the machine.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct KillButton {
        /// There is a kill button.
        enable: bool = bool("false").v1("kill_button_enable");
        /// Its input, logically low when pressed.
        pin: Option<Pin> = pin("nc", PinRole::Input).v1("kill_button_pin");
        /// It latches; letting it go may clear the halt.
        "toggle_enable" toggle: bool = bool("false").v1("kill_button_toggle_enable");
        /// It may clear a halt: a latching one by its release, a push button by holding it for 2 seconds.
        "unkill_enable" unkill: bool = bool("true").v1("unkill_enable");
    }
}

settings! {
    /// The contact of a door or lid. Opened, the machine holds and spindle, laser and coolant are off; closed
    /// again, ~ or M24 goes on. It does not replace a door switch in the supply of what can hurt.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct SafetyDoor {
        /// There is such a contact.
        enable: bool = bool("false").velvet();
        /// Its input, logically high while the door is open: a contact to ground that the closed door closes,
        /// so that a broken wire is an open door.
        pin: Option<Pin> = pin("nc", PinRole::Input).velvet();
    }
}

settings! {
    /// Files played from the SD card.
    #[derive(Clone, Debug, Default)]
    pub struct PlayerConfig {
        /// A file played once after boot; nothing happens when it is not there.
        on_boot_gcode: Command = text("/sd/on_boot.gcode", 96).v1("on_boot_gcode");
        /// Play the boot file.
        on_boot_gcode_enable: bool = bool("true").v1("on_boot_gcode_enable");
        /// Keep the heaters on while a print is suspended.
        leave_heaters_on_suspend: bool = bool("false").v1("leave_heaters_on_suspend");
        /// A line executed once suspended. Underscores stand for blanks.
        after_suspend_gcode: Command = text("", 96).v1("after_suspend_gcode") => spaced;
        /// A line executed before resuming. Underscores stand for blanks.
        before_resume_gcode: Command = text("", 96).v1("before_resume_gcode") => spaced;
        /// A line executed before the first line of every job. Underscores stand for blanks.
        before_job_gcode: Command = text("", 96).velvet() => spaced;
        /// A line executed behind the last line of a job that comes to its end. Underscores stand for blanks.
        after_job_gcode: Command = text("", 96).velvet() => spaced;
        /// A line executed once abort has brought the machine to rest. Underscores stand for blanks.
        after_abort_gcode: Command = text("", 96).velvet() => spaced;
        /// The next file of the queue begins as soon as one has ended; else a person clears the bed, and says
        /// so.
        queue_auto: bool = bool("false").velvet();
        /// What files are written in. auto: what their slicer says in them, else as grbl_mode says.
        dialect: Option<Dialect> = word("auto", OF_FILES)
            .velvet() => |word: usize| DIALECTS.get(word.checked_sub(1)?).copied();
        /// A look ahead at the file of a job. time: only for the time left; warn: the job pauses before a
        /// line that leaves the travel; travel: it is not begun when such a line is found within
        /// preflight_wait, and pauses before one that is found later; refuse: the whole file is looked at
        /// first.
        preflight: JobPreflight = word("travel", JobPreflight::WORDS).velvet();
        /// What a job does at a code that levels the bed (G29, G32, M420, ...) on a machine with no probe and
        /// no leveling. go_on: it is told when the job begins, and left out.
        "without_leveling" unleveled_pauses: bool = word("go_on", &Words(&["go_on", "pause"])).velvet();
        /// With preflight = travel: how long a job waits for the look at its file.
        preflight_wait: Micros = number("3", &(0.0, 600.0)).unit("s").typical(&(0.5, 60.0)).velvet();
        /// Settings for resuming after a power cut.
        power_loss: PowerLossConfig;
    }
}

words! {
    /// Use of a preflight check, which reads the file of a job ahead.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum JobPreflight {
        /// Preflight check is off.
        Off = "off",
        /// The check estimates the time left.
        Time = "time",
        /// The check estimates the time left, and the job pauses before a line that was found to stop it.
        Warn = "warn",
        /// The file is checked for a while before the job, which does not begin when the file leaves the
        /// travel; later findings act as with [`Self::Warn`].
        #[default]
        Travel = "travel",
        /// The whole file is checked before the job, which does not begin when a line would stop it.
        Refuse = "refuse",
    }
}

settings! {
    /// Settings `power_loss_*` in `[player]`.
    #[derive(Clone, Debug, Default)]
    pub struct PowerLossConfig {
        /// Keep a journal of jobs on the card, to go on with them after a power cut: M1000 (M413).
        "power_loss" enable: bool = bool("false").velvet();
        /// Time between entries of the journal; a new layer has one at once.
        "power_loss_period" period: Micros = number("5", &(1.0, 600.0)).unit("s").velvet();
        /// When the motors' supply (vmotor) falls below this under a job, heaters go off and the job is noted
        /// at once; 0: never.
        "power_loss_motor_volts" motor_volts: f32 = number("0", &(0.0, 60.0)).unit("V").velvet();
        /// How far above everything printed Z goes before X and Y are homed.
        "power_loss_lift" lift: f64 = number("5", &(0.0, 200.0)).unit("mm").velvet();
        /// How far Z sinks when its motor loses its current.
        "power_loss_z_sag" sag: f64 = number("0", &(0.0, 50.0)).unit("mm").velvet();
        /// A line executed above the part before going back to it: prime, wipe. Underscores stand for blanks.
        "power_loss_gcode" gcode: Command = text("", 96).velvet() => spaced;
    }
}

settings! {
    /// Klipper's macros (docs/macros.md).
    #[derive(Clone, Debug, Default)]
    pub struct MacrosConfig {
        /// Klipper's configuration file on the card, with its macros. Without a name there are none.
        file: Command = text("", 96).velvet();
    }
}

settings! {
    /// What M6 does on a machine without extruders.
    #[derive(Clone, Debug, Default)]
    pub struct ToolChangeConfig {
        /// A line executed before the tool is changed. Underscores stand for blanks.
        before_gcode: Command = text("", 96).velvet() => spaced;
        /// Ask the operator to put the tool in, and wait for `~` or M24; false: the scripts change it.
        prompt: bool = bool("true").velvet();
        /// A line executed once it has been changed. Underscores stand for blanks.
        after_gcode: Command = text("", 96).velvet() => spaced;
    }
}

settings! {
    /// Which consoles there are.
    rows Consoles of SystemConfig {
        /// A second USB serial port with a console of its own.
        "second_usb_serial_enable" second_usb_serial_enable = bool("false").v1("second_usb_serial_enable");
    }
}
