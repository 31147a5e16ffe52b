//! Settings of `[general]`, `[system]`, `[uart console]`, `[kill button]`, `[safety door]`, `[player]` and
//! `[voltage monitor]`.

use super::See::{Board, Boot, Edges, Look, Say};
use super::{Bench, Row, edges, row};

const BUTTON: &[&str] = &["[kill button] enable = true", "[kill button] pin = PB7^"];
const DOOR: &[&str] = &["[safety door] enable = true", "[safety door] pin = PB7^"];
const LATCHING: &[&str] =
    &["[kill button] enable = true", "[kill button] pin = PB7^", "[kill button] toggle_enable = true"];
const BOOT_FILE: &[&str] = &["[player] on_boot_gcode_enable = true"];
/// A machine without an extruder, and without a prompt for the tool.
const SPINDLE: &[&str] = &["[extruder] hotend.enable = false", "[tool change] prompt = false"];
/// A file with M203, which is per minute in one dialect and per second in the others.
const PLAYED: &[&str] = &["M28 a.g", "M203 X600", "M29", "play /sd/a.g", "G4 P200", "M203"];
const JOURNAL: &[&str] = &["[player] power_loss = true"];
/// A public key, of RFC 8032 section 7.1, test 1.
const KEY: &str = "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a";
const KEYED: &[&str] = &["[update] key = d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a"];
const UART: &[&str] = &["[uart console] enable = true", "[switch] fan.output_pin = PB9"];

pub const ROWS: &[Row] = &[
    row("[general] grbl_mode", "false", "true", Say(&["M112", "G1 X1"])),
    row("[general] dialect", "smoothie", "reprapfirmware", Say(&["M203 X600", "M203"])),
    row("[general] grblhal", "false", "true", Say(&["$I"])).with(&["[general] grbl_mode = true"]),
    row("[general] config-override", "false", "true", Say(&["M503"])),
    row("[system] step_pulse_us", "1", "20", Edges(&["G91", "G1 A5 F9000", "G1 A-5"])).with(EXTERNAL),
    row("[system] step_frequency", "200000", "2000", Edges(&["G91", "G1 X5 F6000"])),
    row("[system] aux_play_led", "", "PJ9", Board("conventions/inputs.rs")),
    row("[system] dfu_enable", "false", "true", Board("usb/download.rs")),
    row("[system] msc_enable", "true", "false", Say(&["msc"])),
    row("[system] msc_led", "PF13", "PJ9", Board("usb/disk.rs")).with(&["[system] msc_enable = true"]),
    row("[system] flash_on_boot", "true", "false", Board("updates/machine.rs")),
    row("[update] key", "", KEY, Board("updates/machine.rs")),
    row("[update] locked", "false", "true", Board("updates/machine.rs")).with(KEYED),
    row("[system] fets_enable_pin", "PF14!o", "PF15!o", Boot),
    row("[system] fets_power_enable_pin", "PD7", "PJ5", Boot),
    row("[consoles] second_usb_serial_enable", "false", "true", Board("usb/ports.rs")),
    row("[system] brown_out_volts", "0", "30", Say(&["M104 S50", "G4 S1", "get temp hotend"])),
    row("[uart console] enable", "true", "false", Boot).with(&["[switch] fan.output_pin = PB11"]),
    row("[uart console] channel", "0", "1", Boot).with(UART),
    row("[uart console] console", "true", "false", Board("settings.rs")),
    row("[uart console] baudrate", "115200", "9600", Board("settings.rs")),
    row("[uart console] bits", "8", "7", Board("settings.rs")),
    row("[uart console] stop_bits", "1", "2", Board("settings.rs")),
    row("[uart console] parity", "none", "even", Board("settings.rs")),
    row("[macros] file", "", "printer.cfg", Look(called)),
    row("[player] before_job_gcode", "", "G91 G1 X2 F600", Look(played)),
    row("[player] after_job_gcode", "", "G91 G1 X2 F600", Look(played)),
    row("[player] after_abort_gcode", "", "G91 G1 X2 F600", Look(aborted)),
    row("[player] queue_auto", "false", "true", Look(queued)),
    row("[kill button] enable", "true", "false", Look(pressed)).with(BUTTON),
    row("[kill button] pin", "PB7^", "PD3^", Boot).with(BUTTON),
    row("[kill button] toggle_enable", "true", "false", Look(pressed)).with(BUTTON),
    row("[kill button] unkill_enable", "true", "false", Look(pressed)).with(LATCHING),
    row("[safety door] enable", "true", "false", Look(opened)).with(DOOR),
    row("[safety door] pin", "PB7^", "PD3^", Boot).with(DOOR),
    row("[player] on_boot_gcode", "/sd/on_boot.gcode", "/sd/other.g", Look(at_boot)).with(BOOT_FILE),
    row("[player] on_boot_gcode_enable", "true", "false", Look(at_boot)),
    row("[player] leave_heaters_on_suspend", "true", "false", Say(&["M104 S50", "M600", "get temp hotend"])),
    row("[player] after_suspend_gcode", "", "G91_G1_X1_F600", Edges(&["G91", "G1 Y1 F600", "M600"])),
    row("[player] before_resume_gcode", "", "G91_G1_Z1_F600", Edges(&["G91", "G1 Y1 F600", "M600", "resume"])),
    row("[player] power_loss", "false", "true", Say(&["M413"])),
    row("[player] power_loss_period", "1", "600", Look(journal)).with(JOURNAL),
    row("[player] power_loss_motor_volts", "0", "30", Look(journal)).with(JOURNAL),
    row("[player] power_loss_lift", "3", "7", Look(gone_on_with)).with(JOURNAL),
    row("[player] power_loss_z_sag", "0", "1", Look(gone_on_with)).with(JOURNAL),
    row("[player] power_loss_gcode", "", "M118_primed", Look(gone_on_with)).with(JOURNAL),
    row("[tool change] before_gcode", "", "G91_G1_X1_F600", Look(changed)).with(SPINDLE),
    row("[tool change] after_gcode", "", "G91_G1_Y1_F600", Look(changed)).with(SPINDLE),
    row("[tool change] prompt", "true", "false", Look(changed)).with(&["[extruder] hotend.enable = false"]),
    row("[player] preflight", "off", "refuse", Look(looked_at)),
    row("[player] preflight_wait", "3", "0", Look(looked_at)),
    row("[player] without_leveling", "go_on", "pause", Look(unleveled)),
    row("[player] dialect", "klipper", "reprapfirmware", Say(PLAYED)),
    row("[voltage monitor] vmotor", "ADC3_5,11", "ADC3_5,22", Say(&["get volts vmotor"])),
];

/// A motor on a driver of its own, beside the four on the board.
pub const EXTERNAL: &[&str] = &[
    "[extruder] hotend.enable = false",
    "[actuator] delta.driver = external",
    "[actuator] delta.step_pin = PJ5",
    "[actuator] delta.dir_pin = PJ1",
    "[actuator] delta.en_pin = PJ3",
    "[actuator] delta.max_rate = 60000",
    "[actuator] delta.acceleration = 20000",
    "[current control] delta.current",
];

/// Returns the steps of a job, and of the scripts around it.
fn played(bench: &mut Bench) -> String {
    bench.say("play other.g");
    bench.hear(3.0);
    bench.world(|world| world.trace().total()).to_string()
}

/// Calls a macro of a file on the card.
fn called(bench: &mut Bench) -> String {
    bench.write_card("printer.cfg", b"[gcode_macro HELLO]\ngcode: M118 hello\n");
    bench.say("macros reload") + &bench.say("HELLO")
}

/// Returns the steps of a job that is aborted.
fn aborted(bench: &mut Bench) -> String {
    bench.say("play other.g -p");
    bench.say("abort");
    bench.hear(3.0);
    bench.world(|world| world.trace().total()).to_string()
}

/// Plays two files from the queue.
fn queued(bench: &mut Bench) -> String {
    bench.say("queue add other.g 2");
    bench.type_in("queue next\n");
    bench.hear(3.0)
}

/// Plays a file with a line that would stop the job.
fn looked_at(bench: &mut Bench) -> String {
    bench.write_card("out.g", b"G28\nG1 X9999 F600\n");
    bench.type_in("play out.g\n");
    bench.hear(3.0)
}

/// Plays a file that levels the bed.
fn unleveled(bench: &mut Bench) -> String {
    bench.write_card("level.g", b"M420 S1\n");
    bench.type_in("play level.g\n");
    bench.hear(3.0)
}

/// Presses, holds and releases the kill button.
fn pressed(bench: &mut Bench) -> String {
    let mut said = String::new();
    for (down, seconds) in [(true, 0.5), (false, 0.5), (true, 3.0), (false, 0.5)] {
        let at_ns = (bench.now_s() * 1e9) as u64;
        // Without a kill button there is none to press.
        let _ = bench.world(|world| world.press(at_ns, "kill", down));
        said += &bench.hear(seconds);
        said += &bench.status();
    }
    said
}

/// Opens the door while X moves.
fn opened(bench: &mut Bench) -> String {
    bench.type_in("G1 X50 F600\n");
    bench.hear(0.5);
    let at_ns = (bench.now_s() * 1e9) as u64;
    // Without a contact there is none to open.
    let _ = bench.world(|world| world.press(at_ns, "door", true));
    bench.hear(0.5) + &bench.status()
}

fn at_boot(bench: &mut Bench) -> String {
    bench.hear(2.0);
    let moved = bench.world(|world| world.trace().total());
    moved.to_string() + &edges(bench, &["G91", "G1 X1 F600"])
}

/// Plays a job that lays filament; returns the entries of its journal.
fn journal(bench: &mut Bench) -> String {
    bench.write_card("laid.g", b"G28\nG90\nG1 Z0.3 F600\nG1 X50 E5 F30\n");
    bench.type_in("play /sd/laid.g\n");
    let said = bench.hear(60.0);
    let blocks = bench.read_card_bytes("power-loss.journal").unwrap_or_default();
    let written = blocks.chunks(512).filter(|block| block.iter().any(|byte| *byte != 0)).count();
    format!("{said}{written} blocks")
}

/// Returns the messages when such a job resumes after a halt.
fn gone_on_with(bench: &mut Bench) -> String {
    journal(bench);
    bench.type_in("M112\n");
    bench.hear(2.0);
    bench.type_in("M999\nM916 S\nM1000\n");
    bench.hear(60.0)
}

/// Returns the messages of a tool change, and the position after it.
fn changed(bench: &mut Bench) -> String {
    bench.type_in("T1 M6\n");
    bench.hear(2.0) + &bench.status()
}
