//! Board at the other end of a connection, as its consoles speak (`net/src/consoles`).

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::desk::PATIENCE;

/// Words to a visitor who is let in.
pub const GREETING: &str = "Welcome to Smoothie\nok\n";

/// Board that lets one visitor in.
pub struct Board<T> {
    port: u16,
    visit: JoinHandle<T>,
}

impl<T: Send + 'static> Board<T> {
    /// Opens the port, and has the visitor served.
    pub fn new(serve: impl FnOnce(TcpStream) -> T + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("an address").port();
        listener.set_nonblocking(true).expect("a port");
        let visit = std::thread::spawn(move || {
            let end = Instant::now() + PATIENCE;
            let stream = loop {
                match listener.accept() {
                    Ok((stream, _)) => break stream,
                    Err(_) if Instant::now() < end => std::thread::sleep(Duration::from_millis(5)),
                    Err(error) => panic!("nobody came: {error}"),
                }
            };
            stream.set_nonblocking(false).expect("a connection");
            stream.set_read_timeout(Some(PATIENCE)).expect("a connection");
            stream.set_write_timeout(Some(PATIENCE)).expect("a connection");
            serve(stream)
        });
        Self { port, visit }
    }

    /// Returns the port of the console.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Returns the address of the console.
    pub fn at(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    /// Waits until the visitor has left; returns what was made of the visit.
    pub fn outcome(self) -> T {
        self.visit.join().expect("no panic")
    }
}

/// Reads a line byte by byte; none if the visitor has left.
pub fn line(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut line = Vec::new();
    loop {
        let mut byte = [0];
        match stream.read(&mut byte) {
            Ok(0) => return None,
            Ok(_) if byte == *b"\n" => return Some(line),
            Ok(_) => line.push(byte[0]),
            Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => return None,
            Err(error) => panic!("a visitor who neither speaks nor leaves: {error}"),
        }
    }
}

/// Answers each line with `ok` until the visitor leaves; returns the lines.
pub fn obey(mut stream: TcpStream) -> Vec<String> {
    let mut lines = Vec::new();
    while let Some(line) = line(&mut stream) {
        let line = String::from_utf8(line).expect("text");
        let _gone = stream.write_all(format!("said {line}\nok\n").as_bytes());
        lines.push(line);
    }
    lines
}

/// Greets at once, then obeys.
pub fn open(mut stream: TcpStream) -> Vec<String> {
    stream.write_all(GREETING.as_bytes()).expect("a visitor");
    obey(stream)
}

/// Asks for the password, then obeys.
pub fn locked(mut stream: TcpStream) -> Vec<String> {
    // A client of telnet would show here that it is one.
    std::thread::sleep(Duration::from_millis(300));
    stream.write_all(b"Password: ").expect("a visitor");
    for _ in 0..2 {
        match line(&mut stream).as_deref() {
            None => return vec!["left".to_owned()],
            Some(b"open sesame") => return open(stream),
            Some(_) => stream.write_all(b"\r\nWrong password.\r\nPassword: ").expect("a visitor"),
        }
    }
    vec!["wrong".to_owned()]
}
