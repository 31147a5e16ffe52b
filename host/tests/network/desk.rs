//! Common parts of the network's tests: the command as a user runs it, and boards that announce themselves.

use std::io::Write;
use std::net::UdpSocket;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use mdns_sd::{DaemonEvent, IfKind, ServiceDaemon, ServiceInfo};

/// Longest time that anything may take.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Runs velvet with this input, and ends it if it takes too long.
pub fn velvet(arguments: &[&str], input: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_velvet"));
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("velvet was built with this test");
    let mut stdin = child.stdin.take().expect("a pipe");
    let id = child.id();
    let (done, ended) = std::sync::mpsc::channel::<()>();
    let guard = std::thread::spawn(move || {
        let is_late = ended.recv_timeout(PATIENCE) == Err(std::sync::mpsc::RecvTimeoutError::Timeout);
        if is_late {
            let _killed = Command::new("kill").arg("-9").arg(id.to_string()).status();
        }
        is_late
    });
    let input = input.to_owned();
    // A program that ends before it has read everything is no failure of the test.
    let writer = std::thread::spawn(move || drop(stdin.write_all(input.as_bytes())));
    let output = child.wait_with_output().expect("it ends");
    drop(done);
    assert!(!guard.join().expect("no panic"), "velvet {arguments:?} did not end: {output:?}");
    writer.join().expect("no panic");
    output
}

/// Returns what a program said.
pub fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Returns what a program complained about.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Machines that announce themselves by mDNS: on the loopback interface, at a port of their own.
pub struct Announcer {
    daemon: ServiceDaemon,
    port: String,
}

impl Announcer {
    /// Begins without a machine.
    pub fn new() -> Self {
        let free = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a port").port();
        let daemon = ServiceDaemon::new_with_port(free).expect("mDNS");
        daemon.disable_interface(IfKind::All).expect("mDNS");
        daemon.enable_interface(IfKind::LoopbackV4).expect("mDNS");
        Self { daemon, port: free.to_string() }
    }

    /// Returns the port, for `--mdns-port`.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// Announces a machine with a telnet service, and waits until the name is its own.
    pub fn announce(&self, host: &str, port: u16, texts: &[(&str, &str)]) {
        let told = self.daemon.monitor().expect("mDNS");
        let name = format!("{host}.local.");
        let service =
            ServiceInfo::new("_telnet._tcp.local.", host, &name, "127.0.0.1", port, texts).expect("a service");
        let fullname = service.get_fullname().to_owned();
        self.daemon.register(service).expect("mDNS");
        let end = Instant::now() + PATIENCE;
        loop {
            match told.recv_deadline(end).expect("the machine is announced") {
                DaemonEvent::Announce(announced, _) if announced == fullname => return,
                _ => {}
            }
        }
    }
}

impl Drop for Announcer {
    fn drop(&mut self) {
        let _has_ended = self.daemon.shutdown();
    }
}
