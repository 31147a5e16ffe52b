//! `[general]`, `[system]`, `[consoles]`, `[uart console]`, `[kill button]`, `[safety door]`, `[player]`.

use units::Micros;

use super::build::{bool, integer, number, pin, text, word};
use super::{Docs, Form, PinRole, Section, Words};
use crate::machine::{Command, FileDialect, JobPreflight, Parity, PrinterDialect};
use crate::pin::PinName;

pub const GENERAL: Section = Section {
    name: "general",
    store: None,
    docs: Docs::new("How the firmware talks and starts."),
    form: Form::Plain,
    settings: &[
        bool(
            "grbl_mode",
            "false",
            |c, _, v| c.general.grbl_mode = v,
            "Consoles speak GRBL 1.1 (docs/grbl.md), and G4, G28, G30 and M30 mean what they mean there.",
        ),
        bool(
            "grblhal",
            "false",
            |c, _, v| c.general.grblhal = v,
            "With grbl_mode, what grblHAL says besides, for senders that look for it: fields of the status, `$I+`, `$ES`.",
        )
        .velvet(),
        bool(
            "config-override",
            "false",
            |c, _, v| c.general.config_override = v,
            "At the end of boot, replay the settings that M500, or `$n=` of GRBL's dialect, saved in /sd/config-override.",
        )
        .derived("as grbl_mode"),
        word(
            "dialect",
            "smoothie",
            &Words(&["smoothie", "marlin", "reprapfirmware", "klipper"]),
            |c, _, v| {
                c.general.dialect = match v {
                    1 => PrinterDialect::Marlin,
                    2 => PrinterDialect::RepRapFirmware,
                    3 => PrinterDialect::Klipper,
                    _ => PrinterDialect::Smoothie,
                }
            },
            "What consoles speak, and files that do not say it, without grbl_mode (docs/dialects.md). The command `dialect` changes it for one console.",
        )
        .velvet(),
    ],
};

pub const SYSTEM: Section = Section {
    name: "system",
    store: None,
    docs: Docs::new("The board: step timing, power outputs, indicator lamps."),
    form: Form::Plain,
    settings: &[
        integer(
            "step_pulse_us",
            "1",
            &(1, 65_535),
            |c, _, v| c.system.step_pulse_us = v as u32,
            "Length of a step pulse to an external driver. On-board drivers step on both edges and need none.",
        )
        .limited(&(1.0, 20.0))
        .unit("us")
        .v1("microseconds_per_step_pulse"),
        integer(
            "step_frequency",
            "200000",
            &(1, i32::MAX as i64),
            |c, _, v| c.system.step_frequency_hz = v as u32,
            "Highest step rate of one motor; a max_rate beyond it is lowered with a warning. Velvet has no fixed step \
             tick, so this is only a limit.",
        )
        .unit("Hz")
        .limited(&(1.0, 1_000_000.0))
        .v1("base_stepping_frequency"),
        pin(
            "aux_play_led",
            "nc",
            PinRole::Output,
            |c, _, v| c.system.aux_play_led = v.and_then(PinName::digital),
            "A second lamp that shows what board LED 2 shows: on while moving, blinking in a halt.",
        )
        .v1("play_led_pin"),
        bool(
            "flash_on_boot",
            "true",
            |c, _, v| c.system.flash_on_boot = v,
            "At boot, install /sd/flashme.bin when it is firmware for this board and another one than what runs (docs/updates.md).",
        ),
        bool(
            "dfu_enable",
            "false",
            |c, _, v| c.system.dfu_enable = v,
            "Let a computer ask for the firmware download over USB (DFU); refused while the machine moves, heats or plays a file.",
        ),
        bool(
            "msc_enable",
            "true",
            |c, _, v| c.system.msc_enable = v,
            "USB has a card reader, which the command msc gives the SD card to. false: there is none, and msc is refused.",
        ),
        pin(
            "msc_led",
            "PF13",
            PinRole::Output,
            |c, _, v| c.system.msc_led = v.and_then(PinName::digital),
            "Lamp that blinks while the computer at the USB socket has the SD card.",
        ),
        pin(
            "fets_enable_pin",
            "PF14!o",
            PinRole::Output,
            |c, _, v| c.system.fets_enable_pin = v.and_then(PinName::digital),
            "Enables all MOSFET outputs; active except in a halt. It must be open drain: its pull-up goes to 5 V.",
        ),
        pin(
            "fets_power_enable_pin",
            "PD7",
            PinRole::Output,
            |c, _, v| c.system.fets_power_enable_pin = v.and_then(PinName::digital),
            "Switches the supply of hot ends and fans; on except in a halt. The bed's supply cannot be switched.",
        ),
        number(
            "brown_out_volts",
            "",
            &(0.0, 60.0),
            |c, _, v| c.system.brown_out_volts = Some(units::Volts(v as f32)),
            "When the supply of motors (vmotor) or heaters (vfet) falls below this while something heats or moves, heaters go off at once, motors brake and are held as long as it lasts, and it is told at the next start. 0: never.",
        )
        .derived("three quarters of what the supply usually has")
        .unit("V")
        .typical(&(5.0, 45.0))
        .velvet(),
    ],
};

pub const UPDATE: Section = Section {
    name: "update",
    store: None,
    docs: Docs::new("Whose firmware may be installed and run (docs/updates.md)."),
    form: Form::Plain,
    settings: &[
        text(
            "key",
            "",
            64,
            |c, _, v| c.update.set_key(v),
            "The owner's Ed25519 public key, 64 hexadecimal digits, as `velvet key` makes it. Firmware that is signed with another key is refused then.",
        )
        .velvet(),
        bool(
            "locked",
            "false",
            |c, _, v| c.update.locked = v,
            "Only firmware that is signed with the key; false: what is not signed at all may run as well. A debug probe can do what it likes.",
        )
        .velvet(),
    ],
};

pub const CONSOLES: Section = Section {
    name: "consoles",
    store: None,
    docs: Docs::new("Which consoles there are."),
    form: Form::Plain,
    settings: &[bool(
        "second_usb_serial_enable",
        "false",
        |c, _, v| c.system.second_usb_serial_enable = v,
        "A second USB serial port with a console of its own.",
    )
    .v1("second_usb_serial_enable")],
};

pub const UART_CONSOLE: Section = Section {
    name: "uart console",
    store: None,
    docs: Docs::new("The auxiliary UART. The debug UART (PD5, PD6, 115200 baud) is always a console."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.uart.enable = v, "Use the auxiliary UART."),
        bool(
            "console",
            "true",
            |c, _, v| c.uart.console = v,
            "A full console; when false the port only sends what echo -1 writes.",
        ),
        integer(
            "channel",
            "0",
            &(0, 1),
            |c, _, v| c.uart.channel = v as u8,
            "0 is USART3 (receive PB11, send PD8), 1 is UART4 (receive PH14, send PB9).",
        ),
        integer("baudrate", "115200", &(1_200, 3_000_000), |c, _, v| c.uart.baudrate = v as u32, "Bit rate.")
            .unit("baud")
            .v1("uart0.baud_rate"),
        integer("bits", "8", &(7, 9), |c, _, v| c.uart.bits = v as u8, "Word length, parity bit included.")
            .unit("bits"),
        integer("stop_bits", "1", &(1, 2), |c, _, v| c.uart.stop_bits = v as u8, "Stop bits.").unit("bits"),
        word(
            "parity",
            "none",
            &Words(&["none", "odd", "even"]),
            |c, _, v| {
                c.uart.parity = match v {
                    1 => Parity::Odd,
                    2 => Parity::Even,
                    _ => Parity::None,
                }
            },
            "Parity of each word; its bit counts among `bits`.",
        ),
    ],
};

pub const KILL_BUTTON: Section = Section {
    name: "kill button",
    store: None,
    docs: Docs::new("A push button or latching switch that halts the machine."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.kill_button.enable = v, "There is a kill button.").v1("kill_button_enable"),
        pin(
            "pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.kill_button.pin = v.and_then(PinName::digital),
            "Its input, logically low when pressed.",
        )
        .v1("kill_button_pin"),
        bool(
            "toggle_enable",
            "false",
            |c, _, v| c.kill_button.toggle = v,
            "It latches; letting it go may clear the halt.",
        )
        .v1("kill_button_toggle_enable"),
        bool(
            "unkill_enable",
            "true",
            |c, _, v| c.kill_button.unkill = v,
            "It may clear a halt: a latching one by its release, a push button by holding it for 2 seconds.",
        )
        .v1("unkill_enable"),
    ],
};

pub const SAFETY_DOOR: Section = Section {
    name: "safety door",
    store: None,
    docs: Docs::new("The contact of a door or lid. Opened, the machine holds and spindle, laser and coolant are off; closed again, ~ \
              or M24 goes on. It does not replace a door switch in the supply of what can hurt."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.safety_door.enable = v, "There is such a contact.").velvet(),
        pin(
            "pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.safety_door.pin = v.and_then(PinName::digital),
            "Its input, logically high while the door is open: a contact to ground that the closed door closes, so that a \
             broken wire is an open door.",
        )
        .velvet(),
    ],
};

pub const PLAYER: Section = Section {
    name: "player",
    store: None,
    docs: Docs::new("Files played from the SD card."),
    form: Form::Plain,
    settings: &[
        text(
            "on_boot_gcode",
            "/sd/on_boot.gcode",
            96,
            |c, _, v| c.player.on_boot_gcode = Command::try_from(v).unwrap_or_default(),
            "A file played once after boot; nothing happens when it is not there.",
        )
        .v1("on_boot_gcode"),
        bool("on_boot_gcode_enable", "true", |c, _, v| c.player.on_boot_gcode_enable = v, "Play the boot file.")
            .v1("on_boot_gcode_enable"),
        bool(
            "leave_heaters_on_suspend",
            "false",
            |c, _, v| c.player.leave_heaters_on_suspend = v,
            "Keep the heaters on while a print is suspended.",
        )
        .v1("leave_heaters_on_suspend"),
        text(
            "after_suspend_gcode",
            "",
            96,
            |c, _, v| c.player.after_suspend_gcode = super::switches::spaced(v),
            "A line executed once suspended. Underscores stand for blanks.",
        )
        .v1("after_suspend_gcode"),
        text(
            "before_resume_gcode",
            "",
            96,
            |c, _, v| c.player.before_resume_gcode = super::switches::spaced(v),
            "A line executed before resuming. Underscores stand for blanks.",
        )
        .v1("before_resume_gcode"),
        text(
            "before_job_gcode",
            "",
            96,
            |c, _, v| c.player.before_job_gcode = super::switches::spaced(v),
            "A line executed before the first line of every job. Underscores stand for blanks.",
        )
        .velvet(),
        text(
            "after_job_gcode",
            "",
            96,
            |c, _, v| c.player.after_job_gcode = super::switches::spaced(v),
            "A line executed behind the last line of a job that comes to its end. Underscores stand for blanks.",
        )
        .velvet(),
        text(
            "after_abort_gcode",
            "",
            96,
            |c, _, v| c.player.after_abort_gcode = super::switches::spaced(v),
            "A line executed once abort has brought the machine to rest. Underscores stand for blanks.",
        )
        .velvet(),
        bool(
            "queue_auto",
            "false",
            |c, _, v| c.player.queue_auto = v,
            "The next file of the queue begins as soon as one has ended; else a person clears the bed, and says so.",
        )
        .velvet(),
        word(
            "dialect",
            "auto",
            &Words(&["auto", "smoothie", "marlin", "reprapfirmware", "klipper", "grbl"]),
            |c, _, v| {
                c.player.dialect = match v {
                    1 => FileDialect::Smoothie,
                    2 => FileDialect::Marlin,
                    3 => FileDialect::RepRapFirmware,
                    4 => FileDialect::Klipper,
                    5 => FileDialect::Grbl,
                    _ => FileDialect::Auto,
                }
            },
            "What files are written in. auto: what their slicer says in them, else as grbl_mode says.",
        )
        .velvet(),
        word(
            "preflight",
            "travel",
            &Words(&["off", "time", "warn", "travel", "refuse"]),
            |c, _, v| {
                c.player.preflight = match v {
                    0 => JobPreflight::Off,
                    1 => JobPreflight::Time,
                    2 => JobPreflight::Warn,
                    4 => JobPreflight::Refuse,
                    _ => JobPreflight::Travel,
                }
            },
            "A look ahead at the file of a job. time: only for the time left; warn: the job pauses before a line that \
             leaves the travel; travel: it is not begun when such a line is found within preflight_wait, and pauses \
             before one that is found later; refuse: the whole file is looked at first.",
        )
        .velvet(),
        word(
            "without_leveling",
            "go_on",
            &Words(&["go_on", "pause"]),
            |c, _, v| c.player.unleveled_pauses = v == 1,
            "What a job does at a code that levels the bed (G29, G32, M420, ...) on a machine with no probe and no \
             leveling. go_on: it is told when the job begins, and left out.",
        )
        .velvet(),
        number(
            "preflight_wait",
            "3",
            &(0.0, 600.0),
            |c, _, v| c.player.preflight_wait = Micros((v * 1e6) as u64),
            "With preflight = travel: how long a job waits for the look at its file.",
        )
        .unit("s")
        .typical(&(0.5, 60.0))
        .velvet(),
        bool(
            "power_loss",
            "false",
            |c, _, v| c.player.power_loss.enable = v,
            "Keep a journal of jobs on the card, to go on with them after a power cut: M1000 (M413).",
        )
        .velvet(),
        number(
            "power_loss_period",
            "5",
            &(1.0, 600.0),
            |c, _, v| c.player.power_loss.period = Micros((v * 1e6) as u64),
            "Time between entries of the journal; a new layer has one at once.",
        )
        .unit("s")
        .velvet(),
        number(
            "power_loss_motor_volts",
            "0",
            &(0.0, 60.0),
            |c, _, v| c.player.power_loss.motor_volts = v as f32,
            "When the motors' supply (vmotor) falls below this under a job, heaters go off and the job is noted at once; 0: \
             never.",
        )
        .unit("V")
        .velvet(),
        number(
            "power_loss_lift",
            "5",
            &(0.0, 200.0),
            |c, _, v| c.player.power_loss.lift = v,
            "How far above everything printed Z goes before X and Y are homed.",
        )
        .unit("mm")
        .velvet(),
        number(
            "power_loss_z_sag",
            "0",
            &(0.0, 50.0),
            |c, _, v| c.player.power_loss.sag = v,
            "How far Z sinks when its motor loses its current.",
        )
        .unit("mm")
        .velvet(),
        text(
            "power_loss_gcode",
            "",
            96,
            |c, _, v| c.player.power_loss.gcode = super::switches::spaced(v),
            "A line executed above the part before going back to it: prime, wipe. Underscores stand for blanks.",
        )
        .velvet(),
    ],
};

pub const TOOL_CHANGE: Section = Section {
    name: "tool change",
    store: None,
    docs: Docs::new("What M6 does on a machine without extruders."),
    form: Form::Plain,
    settings: &[
        text(
            "before_gcode",
            "",
            96,
            |c, _, v| c.tool_change.before_gcode = super::switches::spaced(v),
            "A line executed before the tool is changed. Underscores stand for blanks.",
        )
        .velvet(),
        bool(
            "prompt",
            "true",
            |c, _, v| c.tool_change.prompt = v,
            "Ask the operator to put the tool in, and wait for `~` or M24; false: the scripts change it.",
        )
        .velvet(),
        text(
            "after_gcode",
            "",
            96,
            |c, _, v| c.tool_change.after_gcode = super::switches::spaced(v),
            "A line executed once it has been changed. Underscores stand for blanks.",
        )
        .velvet(),
    ],
};
