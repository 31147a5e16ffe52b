//! The machine as somebody sees who stands beside it: where its carriages are, how warm its heaters. A test
//! of a sender asks here, so that nothing rests on what the firmware or the sender believes.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use sim::world::World;
use units::Actuator;

/// Serves the state on a TCP port: each line that comes, whatever it says, is answered by one line of JSON.
pub struct Onlooker {
    listener: TcpListener,
    client: Option<TcpStream>,
}

impl Onlooker {
    /// Begins to listen on this port of the loopback interface; 0 lets the system choose.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn open(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, client: None })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// What the system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Answers what was asked since the last call. The latest client to connect is the one that is heard.
    /// `sent`: the bytes that the image has acknowledged at its USB socket, by OUT endpoint.
    pub fn serve(&mut self, world: &World, sent: Option<[u64; 16]>) {
        if let Ok((client, _)) = self.listener.accept() {
            self.client = client.set_nonblocking(true).is_ok().then_some(client);
        }
        let Some(client) = &mut self.client else { return };
        let mut bytes = [0; 256];
        let asked = match client.read(&mut bytes) {
            Ok(0) => Err(()),
            Ok(count) => Ok(bytes[..count].iter().filter(|byte| **byte == b'\n').count()),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(0),
            Err(_) => Err(()),
        };
        let answered = asked
            .is_ok_and(|asked| asked == 0 || client.write_all(state(world, sent).repeat(asked).as_bytes()).is_ok());
        if !answered {
            self.client = None;
        }
    }
}

/// One line of JSON: seconds since power-on, the tool in mm, carriages in mm by motor, step edges so far,
/// heaters in degrees Celsius with their mean duty, and of the USB socket, if it is offered, the acknowledged
/// bytes by OUT endpoint.
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
        asking.write_all(b"\n\n").expect("it is heard");
        let mut answers = io::BufReader::new(asking);
        for _ in 0..2 {
            let mut line = String::new();
            while line.is_empty() {
                onlooker.serve(&world, None);
                answers.get_ref().set_nonblocking(true).expect("a socket");
                let _not_yet = answers.read_line(&mut line);
            }
            assert!(line.starts_with("{\"s\":0.000000,\"tool\":[12.5000,") && line.ends_with("}}\n"), "{line}");
            assert!(line.contains("\"alpha\":12.5000"), "{line}");
        }
    }
}
