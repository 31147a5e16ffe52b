//! Functions that are not part of Velvet yet. Their settings are known and checked, and refused when used.

use super::build::{ANY, bool, integer, no_text, nowhere, number, pin, text};
use super::{Docs, Form, Instances, PinRole, Section, Support};
use crate::diagnostic::Severity;

/// Instances that nothing stores yet.
const UNREAD: Instances = Instances {
    noun: super::UNREAD,
    find: |_, _| Some(0),
    create: |_, _| Ok(0),
    name: |_, _| "",
    is_live: |_, _| true,
};

/// A part's own switch, where the machine does something else than meant without that part.
const NOT_YET: &Support = &Support::NotYet { severity: Severity::Error, advice: LEAVE_DISABLED };
/// Support of a part's own switch, where the machine works without that part.
const NOT_YET_HARMLESS: &Support = &Support::NotYet { severity: Severity::Warning, advice: LEAVE_DISABLED };
const LEAVE_DISABLED: &str = "leave it disabled until Velvet can do it";

pub const LASER: Section = Section {
    name: "laser",
    store: None,
    docs: Docs::new("A laser whose power follows the speed."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", nowhere, "There is a laser.").v1("laser_module_enable").support(NOT_YET),
        pin("pwm_pin", "nc", PinRole::Pwm, nowhere, "Timer channel that drives the laser.")
            .v1("laser_module_pwm_pin")
            .dormant(),
        pin("ttl_pin", "nc", PinRole::Output, nowhere, "Output that is on while the laser has power.")
            .v1("laser_module_ttl_pin")
            .dormant(),
        bool("inverted_pwm", "false", nowhere, "The output is low where it would be high.").dormant(),
        bool("pullup", "true", nowhere, "Pull the output up.").dormant(),
        bool("opendrain", "false", nowhere, "The output only pulls low.").dormant(),
        number("maximum_power", "1", ANY, nowhere, "Duty cycle at full power.")
            .unit("fraction")
            .v1("laser_module_maximum_power")
            .dormant(),
        number("minimum_power", "0", ANY, nowhere, "Least duty cycle in a cutting move.")
            .unit("fraction")
            .v1("laser_module_minimum_power")
            .dormant(),
        number("maximum_s_value", "1", ANY, nowhere, "The S value of full power.")
            .v1("laser_module_maximum_s_value")
            .dormant(),
        number("default_power", "0.8", ANY, nowhere, "S until a program sets it.")
            .unit("S units")
            .v1("laser_module_default_power")
            .dormant(),
        bool("proportional_power", "true", nowhere, "Power follows the speed along the path.")
            .v1("laser_module_proportional_power")
            .dormant(),
        integer("proportional_power_frequency", "10000", &(0, 1_000_000), nowhere, "Rate of power updates.")
            .unit("Hz")
            .dormant(),
    ],
};

pub const LATHE: Section = Section {
    name: "lathe",
    store: None,
    docs: Docs::new("Threading in step with a spindle."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", nowhere, "Understand threading with G33.").support(NOT_YET),
        number("encoder_ppr", "1000", ANY, nowhere, "Encoder pulses per turn of the spindle, gearing included.")
            .unit("pulses/rev")
            .dormant(),
        pin(
            "index_pin",
            "nc",
            PinRole::Interrupt,
            nowhere,
            "Input that pulses once a turn: starts threads, measures the speed.",
        )
        .dormant(),
    ],
};

pub const ELS: Section = Section {
    name: "els",
    store: None,
    docs: Docs::new("Panel of an electronic leadscrew."),
    form: Form::Plain,
    settings: &[bool("enable", "false", nowhere, "There is such a panel.").support(NOT_YET_HARMLESS)],
};

pub const ST7920: Section = Section {
    name: "st7920",
    store: None,
    docs: Docs::new("Graphic display."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", nowhere, "There is such a display.").v1("panel.enable").support(NOT_YET_HARMLESS),
        pin("clk", "nc", PinRole::Output, nowhere, "Clock of the bit-banged display link.").dormant(),
        pin("mosi", "nc", PinRole::Output, nowhere, "Data of the bit-banged display link.").dormant(),
    ],
};

pub const TM1638: Section = Section {
    name: "tm1638",
    store: None,
    docs: Docs::new("Lamp and key module."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", nowhere, "There is such a module.").support(NOT_YET_HARMLESS),
        pin("clock_pin", "nc", PinRole::Output, nowhere, "Clock pin.").dormant(),
        pin("data_pin", "nc", PinRole::Output, nowhere, "Bidirectional data pin.").dormant(),
        pin("strobe_pin", "nc", PinRole::Output, nowhere, "Strobe pin.").dormant(),
    ],
};

pub const MPG: Section = Section {
    name: "mpg",
    store: None,
    docs: Docs::new("Handwheels."),
    form: Form::Named(UNREAD),
    settings: &[
        bool("enable", "false", nowhere, "There is such a handwheel.").support(NOT_YET),
        pin("enca_pin", "nc", PinRole::Interrupt, nowhere, "Encoder phase A.").v1("panel.encoder_a_pin").dormant(),
        pin("encb_pin", "nc", PinRole::Interrupt, nowhere, "Encoder phase B.").v1("panel.encoder_b_pin").dormant(),
        integer("axis", "-1", &(-1, 5), nowhere, "Actuator index that is stepped.").dormant(),
    ],
};

pub const NETWORK: Section = Section {
    name: "network",
    store: None,
    docs: Docs::new("Ethernet and what it serves."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", nowhere, "Use Ethernet.").v1("network.enable").support(NOT_YET_HARMLESS),
        text("ip_address", "auto", 96, no_text, "Fixed address, or auto for DHCP.").v1("network.ip_address").dormant(),
        text("ip_mask", "255.255.255.0", 96, no_text, "Netmask used with a fixed address.")
            .v1("network.ip_mask")
            .dormant(),
        text("ip_gateway", "192.168.1.1", 96, no_text, "Gateway used with a fixed address.")
            .v1("network.ip_gateway")
            .dormant(),
        text("dns_server", "auto", 96, no_text, "DNS server.").dormant(),
        text("hostname", "smoothiev2", 96, no_text, "Name of the machine in the network.").dormant(),
        bool("shell_enable", "false", nowhere, "A console on TCP port 23.").dormant(),
        bool("ftp_enable", "false", nowhere, "File transfer on TCP port 21.").dormant(),
        bool(
            "webserver_enable",
            "false",
            nowhere,
            "Web pages from /sd/www on TCP port 80, with console and upload over WebSocket.",
        )
        .dormant(),
        bool("ntp_enable", "true", nowhere, "Set the clock from the network.").dormant(),
        text("ntp_server", "pool.ntp.org", 96, no_text, "Host to ask for the time.").dormant(),
        integer("timezone", "0", &(-12, 14), nowhere, "Whole hours added to UTC.").unit("h").dormant(),
        text(
            "firmware_url",
            "http://download.smoothieware.org/",
            96,
            no_text,
            "Where the update command looks; ends with a slash.",
        )
        .dormant(),
    ],
};
