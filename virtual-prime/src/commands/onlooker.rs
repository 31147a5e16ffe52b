//! State of the machine as a person beside it sees it: positions of its carriages, temperatures of its
//! heaters. A test of a sender asks here, so that nothing rests on the beliefs of firmware or sender. The
//! person can also pull a cable out.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use sim::world::World;
use units::Actuator;

/// Line that pulls the USB cable out.
const UNPLUG: &[u8] = b"unplug";
/// Longest line that is read whole.
const LINE_BYTES: usize = 64;

/// Serves the state on a TCP port: each line that comes is answered by one line of JSON. A line `unplug`
/// pulls the USB cable out first; any other only asks.
pub struct Onlooker {
    listener: TcpListener,
    client: Option<TcpStream>,
    /// The line so far.
    line: Vec<u8>,
}

/// Requests since the last call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// Number of lines, each of which gets an answer.
    lines: usize,
    /// Whether the USB cable is to be pulled out before they are answered.
    pub unplugs: bool,
}

impl Onlooker {
    /// Begins to listen on this port of the loopback interface; 0 lets the system choose.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn open(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, client: None, line: Vec::new() })
    }

    /// Returns the listening address.
    ///
    /// # Errors
    /// What the system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Reads received lines. Of several clients, only the latest to connect is served.
    pub fn hear(&mut self) -> Asked {
        if let Ok((client, _)) = self.listener.accept() {
            self.client = client.set_nonblocking(true).is_ok().then_some(client);
            self.line.clear();
        }
        let Some(client) = &mut self.client else { return Asked::default() };
        let mut bytes = [0; 256];
        let count = match client.read(&mut bytes) {
            Ok(count) if count > 0 => count,
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => 0,
            _ => {
                self.client = None;
                0
            }
        };
        let mut asked = Asked::default();
        for byte in &bytes[..count] {
            if *byte == b'\n' {
                asked.lines += 1;
                asked.unplugs |= self.line.trim_ascii() == UNPLUG;
                self.line.clear();
            } else if self.line.len() < LINE_BYTES {
                self.line.push(*byte);
            }
        }
        asked
    }

    /// Answers the lines. `sent`: the bytes that the image has acknowledged at its USB socket, by OUT
    /// endpoint.
    pub fn answer(&mut self, asked: Asked, world: &World, sent: Option<[u64; 16]>) {
        if let Some(client) = &mut self.client
            && asked.lines > 0
            && client.write_all(state(world, sent).repeat(asked.lines).as_bytes()).is_err()
        {
            self.client = None;
        }
    }
}

/// Describes the state as a line of JSON: seconds since power-on, the tool in mm, carriages in mm by motor,
/// step edges so far, heaters in degrees Celsius with their mean duty, and of the USB socket, if it is
/// offered, the acknowledged bytes by OUT endpoint.
fn state(world: &World, sent: Option<[u64; 16]>) -> String {
    let [x, y, z] = world.tool_mm();
    let mut line =
        format!("{{\"s\":{:.6},\"tool\":[{x:.4},{y:.4},{z:.4}],\"carriages\":{{", world.now_ns() as f64 * 1e-9);
    let carriages = Actuator::ALL.into_iter().filter_map(|motor| Some((motor.name(), world.carriage_mm(motor)?)));
    for (index, (name, mm)) in carriages.enumerate() {
        let comma = if index > 0 { "," } else { "" };
        let _infallible = write!(line, "{comma}\"{name}\":{mm:.4}");
    }
    let _infallible = write!(line, "}},\"edges\":{},\"heaters\":{{", world.trace().total());
    for (index, heater) in world.config().heaters.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        let (celsius, duty) = (world.heater_c(index), world.heater_mean_duty(index));
        let _infallible = write!(line, "{comma}\"{}\":[{celsius:.1},{duty:.3}]", heater.name);
    }
    line.push('}');
    if let Some(sent) = sent {
        let _infallible = write!(line, ",\"usb_sent\":{sent:?}");
    }
    line.push_str("}\n");
    line
}

#[cfg(test)]
mod tests {
    use std::io::BufRead;

    use sim::world::WorldConfig;

    use super::*;

    #[test]
    fn a_line_is_answered_by_a_line() {
        let mut onlooker = Onlooker::open(0).expect("a port");
        let mut world = World::new(WorldConfig::default());
        world.place_carriage(0, Actuator::Alpha, 12.5);
        let mut asking = TcpStream::connect(onlooker.address().expect("an address")).expect("it listens");
        asking.write_all(b"\nunplug\nunplugged\n").expect("it is heard");
        let mut answers = io::BufReader::new(asking);
        let mut unplugged = 0;
        for _ in 0..3 {
            let mut line = String::new();
            while line.is_empty() {
                let asked = onlooker.hear();
                unplugged += usize::from(asked.unplugs);
                onlooker.answer(asked, &world, None);
                answers.get_ref().set_nonblocking(true).expect("a socket");
                let _not_yet = answers.read_line(&mut line);
            }
            assert!(line.starts_with("{\"s\":0.000000,\"tool\":[12.5000,") && line.ends_with("}}\n"), "{line}");
            assert!(line.contains("\"alpha\":12.5000"), "{line}");
        }
        assert_eq!(unplugged, 1, "by the one line that says so");
    }
}
