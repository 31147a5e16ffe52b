//! The packets of USB/IP 1.1.1 (Linux, `Documentation/usb/usbip_protocol.rst`): big-endian, of fixed length
//! but for what follows them.

use crate::hub::Found;

/// Version of the protocol, in BCD.
pub const VERSION: u16 = 0x0111;
/// Length of a busid with its trailing zeros, bytes.
pub const BUSID_BYTES: usize = 32;
/// Length of a command, and of its answer, without data, bytes.
pub const COMMAND_BYTES: usize = 48;

const REQ_IMPORT: u16 = 0x8003;
const REP_IMPORT: u16 = 0x0003;
const REQ_DEVLIST: u16 = 0x8005;
const REP_DEVLIST: u16 = 0x0005;
const CMD_SUBMIT: u32 = 1;
const CMD_UNLINK: u32 = 2;
const RET_SUBMIT: u32 = 3;
const RET_UNLINK: u32 = 4;
const OPERATION_BYTES: usize = 8;
const PATH_BYTES: usize = 256;
/// Length of the description of a packet of an isochronous transfer, bytes.
const ISO_PACKET_BYTES: usize = 16;
/// The longest transfer that a client may ask for.
const MOST_BYTES: usize = 64 << 20;
/// Full speed, USB_SPEED_FULL of Linux.
const FULL_SPEED: u32 = 2;

/// Reason why a device cannot be imported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Refusal {
    /// Another client has the device.
    Busy = 2,
    /// The device is there and cannot be used.
    Unusable = 3,
    /// No device has this name.
    Absent = 4,
}

/// Question of a client that has no device yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Operation {
    /// The list of devices, OP_REQ_DEVLIST.
    List,
    /// The device of this name, OP_REQ_IMPORT.
    Import(String),
}

/// A request for a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submit {
    /// Number that names the request.
    pub sequence: u32,
    /// Whether data come from the device.
    pub input: bool,
    /// Number of the endpoint, without its direction.
    pub endpoint: u8,
    /// Flags, as in [`SHORT_NOT_OK`] and [`ZERO_PACKET`].
    pub flags: u32,
    /// Bytes wanted or sent.
    pub length: u32,
    /// SETUP packet of a control transfer.
    pub setup: [u8; 8],
    /// Whether the transfer is isochronous.
    pub isochronous: bool,
    /// Data of an OUT transfer.
    pub data: Vec<u8>,
}

/// Flag for which fewer bytes than asked for are an error.
pub const SHORT_NOT_OK: u32 = 0x01;
/// Flag for an empty packet after a full last packet.
pub const ZERO_PACKET: u32 = 0x40;

/// Command of a client that has a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// A request for a transfer.
    Submit(Submit),
    /// Cancels the transfer of the second number (USBIP_CMD_UNLINK).
    Unlink(u32, u32),
}

/// A complete packet with its length; `None` while more of it is to come.
type Parsed<T> = Result<Option<(T, usize)>, String>;

fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).map_or(0, |word| u32::from_be_bytes([word[0], word[1], word[2], word[3]]))
}

/// Parses an operation at the front of `bytes`.
///
/// # Errors
/// It is none.
pub fn operation(bytes: &[u8]) -> Parsed<Operation> {
    let Some(head) = bytes.get(..OPERATION_BYTES) else { return Ok(None) };
    let (version, code) = ((word(head, 0) >> 16) as u16, word(head, 0) as u16);
    match code {
        _ if version != VERSION => Err(format!("version {version:04x} of USB/IP, where this is {VERSION:04x}")),
        REQ_DEVLIST => Ok(Some((Operation::List, OPERATION_BYTES))),
        REQ_IMPORT => {
            let end = OPERATION_BYTES + BUSID_BYTES;
            let Some(name) = bytes.get(OPERATION_BYTES..end) else { return Ok(None) };
            let length = name.iter().position(|&byte| byte == 0).unwrap_or(BUSID_BYTES);
            Ok(Some((Operation::Import(String::from_utf8_lossy(&name[..length]).into_owned()), end)))
        }
        other => Err(format!("operation {other:04x}")),
    }
}

/// Parses a command at the front of `bytes`.
///
/// # Errors
/// It is none.
pub fn command(bytes: &[u8]) -> Parsed<Command> {
    let Some(head) = bytes.get(..COMMAND_BYTES) else { return Ok(None) };
    let sequence = word(head, 4);
    match word(head, 0) {
        CMD_UNLINK => Ok(Some((Command::Unlink(sequence, word(head, 20)), COMMAND_BYTES))),
        CMD_SUBMIT => {
            let (input, length, packets) = (word(head, 12) != 0, word(head, 24), word(head, 32));
            let isochronous = packets != 0 && packets != u32::MAX;
            let data = if input { 0 } else { length as usize };
            let tail = if isochronous { (packets as usize).saturating_mul(ISO_PACKET_BYTES) } else { 0 };
            if length as usize > MOST_BYTES || tail > MOST_BYTES || word(head, 16) > 15 {
                return Err(format!("a transfer of {length} bytes at endpoint {}", word(head, 16)));
            }
            let end = COMMAND_BYTES + data + tail;
            let Some(whole) = bytes.get(..end) else { return Ok(None) };
            let submit = Submit {
                sequence,
                input,
                endpoint: word(head, 16) as u8,
                flags: word(head, 20),
                length,
                setup: std::array::from_fn(|at| head[40 + at]),
                isochronous,
                data: whole[COMMAND_BYTES..COMMAND_BYTES + data].to_vec(),
            };
            Ok(Some((Command::Submit(submit), end)))
        }
        other => Err(format!("command {other}")),
    }
}

/// Describes the device, as in the answers to both operations.
fn description(found: &Found, busid: &str, configuration: u8) -> Vec<u8> {
    let device = &found.device;
    let mut bytes = format!("/sys/devices/virtual-prime/{busid}").into_bytes();
    bytes.resize(PATH_BYTES, 0);
    bytes.extend(busid.bytes());
    bytes.resize(PATH_BYTES + BUSID_BYTES, 0);
    // Bus 1, device 2, as in the busid.
    bytes.extend([1, 2, FULL_SPEED].map(u32::to_be_bytes).concat());
    bytes.extend([device.vendor, device.product, device.release].map(u16::to_be_bytes).concat());
    bytes.extend(device.class);
    bytes.extend([configuration, device.configurations, interfaces(found).count() as u8]);
    bytes
}

fn interfaces(found: &Found) -> impl Iterator<Item = [u8; 3]> + '_ {
    let all = found.configurations.first().map_or(&[][..], |configuration| &configuration.interfaces);
    all.iter().filter(|one| one.setting == 0).map(|one| one.class)
}

fn head(code: u16, status: u32) -> Vec<u8> {
    [&VERSION.to_be_bytes()[..], &code.to_be_bytes(), &status.to_be_bytes()].concat()
}

/// Returns the answer to [`Operation::List`].
#[must_use]
pub fn list(device: Option<&Found>, busid: &str, configuration: u8) -> Vec<u8> {
    let mut bytes = head(REP_DEVLIST, 0);
    bytes.extend(u32::from(device.is_some()).to_be_bytes());
    if let Some(found) = device {
        bytes.extend(description(found, busid, configuration));
        bytes.extend(interfaces(found).flat_map(|[c0, c1, c2]| [c0, c1, c2, 0]));
    }
    bytes
}

/// Returns the answer to [`Operation::Import`].
#[must_use]
pub fn imported(device: Result<&Found, Refusal>, busid: &str, configuration: u8) -> Vec<u8> {
    match device {
        Ok(found) => [head(REP_IMPORT, 0), description(found, busid, configuration)].concat(),
        Err(refusal) => head(REP_IMPORT, refusal as u32),
    }
}

/// Returns the answer to a submit: a status of 0 or a negative error number, bytes moved, and received data.
#[must_use]
pub fn submitted(sequence: u32, status: i32, actual: u32, data: &[u8]) -> Vec<u8> {
    let words = [RET_SUBMIT, sequence, 0, 0, 0, status as u32, actual, 0, 0, 0, 0, 0];
    [&words.map(u32::to_be_bytes).concat(), data].concat()
}

/// Returns the answer to [`Command::Unlink`].
#[must_use]
pub fn unlinked(sequence: u32, status: i32) -> Vec<u8> {
    let words = [RET_UNLINK, sequence, 0, 0, 0, status as u32, 0, 0, 0, 0, 0, 0];
    words.map(u32::to_be_bytes).concat()
}
