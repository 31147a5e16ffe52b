//! Consoles over the network as a person uses them. The board is a part of the test.

#[path = "network/board.rs"]
mod board;
#[path = "network/desk.rs"]
mod desk;

use std::io::Write;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::Duration;

use board::{Board, GREETING, line, locked, open};
use desk::{Announcer, errors, out, velvet};

fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a folder to write to");
    path
}

#[test]
fn a_pipe_is_a_console_until_all_is_answered() {
    let board = Board::new(open);
    let told = velvet(&["console", &board.at()], "M115\nversion");
    assert!(told.status.success() && errors(&told).is_empty(), "{}", errors(&told));
    assert_eq!(out(&told), format!("{GREETING}said M115\nok\nsaid version\nok\n"));
    assert_eq!(board.outcome(), ["M115", "version"]);
}

#[test]
fn a_late_answer_is_waited_for() {
    let board = Board::new(|mut stream| {
        stream.write_all(GREETING.as_bytes()).expect("a visitor");
        let said = line(&mut stream);
        std::thread::sleep(Duration::from_millis(2_500));
        stream.write_all(b"ok\n").expect("he waits");
        said
    });
    let told = velvet(&["console", &board.at()], "G28\n");
    assert!(told.status.success() && out(&told).ends_with("ok\nok\n"), "{}", errors(&told));
    assert_eq!(board.outcome(), Some(b"G28".to_vec()));
}

#[test]
fn a_board_is_called_by_its_name_or_is_the_only_one() {
    let announcer = Announcer::new();
    for (name, host) in [(Some("bench-a"), "bench-a"), (Some("BENCH-b.local"), "bench-b")] {
        let board = Board::new(open);
        announcer.announce(host, board.port(), &[("firmware", "velvet")]);
        let arguments = ["console", "--mdns-port", announcer.port()];
        let arguments: Vec<&str> = arguments.into_iter().chain(name).collect();
        let told = velvet(&arguments, "M115\n");
        assert!(out(&told).contains("said M115"), "{name:?}: {}", errors(&told));
        assert_eq!(board.outcome(), ["M115"]);
    }
    // An address alone is asked for where the port is given.
    let board = Board::new(open);
    let told = velvet(&["console", &format!("bench-a:{}", board.port()), "--mdns-port", announcer.port()], "M115\n");
    assert!(out(&told).contains("said M115"), "{}", errors(&told));
    assert_eq!(board.outcome(), ["M115"]);
    // Two boards are there, and neither is named.
    let told = velvet(&["console", "--mdns-port", announcer.port()], "M115\n");
    let error = errors(&told);
    assert!(error.contains("several") && error.contains("bench-a.local") && error.contains("bench-b.local"), "{error}");
    assert_eq!(told.status.code(), Some(2));
    let only = Announcer::new();
    let board = Board::new(open);
    only.announce("bench-c", board.port(), &[("firmware", "velvet")]);
    only.announce("router", 23, &[]);
    let told = velvet(&["console", "--mdns-port", only.port()], "M115\n");
    assert!(out(&told).contains("said M115"), "{}", errors(&told));
    assert_eq!(board.outcome(), ["M115"]);
}

#[test]
fn a_name_that_nobody_has_is_said_with_what_to_do() {
    let announcer = Announcer::new();
    announcer.announce("mill", 23, &[("firmware", "velvet")]);
    let told = velvet(&["console", "velvet.local", "--mdns-port", announcer.port()], "");
    let error = errors(&told);
    assert!(error.starts_with("velvet: velvet.local") && error.contains("velvet boards"), "{error}");
    assert_eq!(told.status.code(), Some(2));
}

#[test]
fn the_password_comes_from_a_file_before_any_line() {
    let word = file("password", "open sesame\nand a remark\n");
    let board = Board::new(locked);
    let told = velvet(&["console", &board.at(), "--password-from", word.to_str().expect("text")], "M115\n");
    assert_eq!(out(&told), format!("Password: \n{GREETING}said M115\nok\n"), "{}", errors(&told));
    assert_eq!(board.outcome(), ["M115"]);
    let board = Board::new(locked);
    let told = velvet(&["console", &board.at()], "M115\n");
    assert_eq!(told.status.code(), Some(2));
    assert!(errors(&told).contains("give it with --password-from FILE"), "{}", errors(&told));
    assert_eq!(board.outcome(), ["left"], "no line was taken for the password");
    let word = file("wrong-password", "sesame\n");
    let board = Board::new(locked);
    let told = velvet(&["console", &board.at(), "--password-from", word.to_str().expect("text")], "M115\n");
    assert!(errors(&told).contains("does not take the password in"), "{}", errors(&told));
    assert_eq!((told.status.code(), board.outcome()), (Some(2), vec!["left".to_owned()]));
    let board = Board::new(locked);
    let told = velvet(&["console", &board.at(), "--password-from", "/no/such/file"], "");
    assert!(errors(&told).contains("cannot read the password in /no/such/file"), "{}", errors(&told));
}

#[test]
fn a_telnet_server_is_refused_its_options_and_the_text_is_clean() {
    let board = Board::new(|mut stream| {
        stream.write_all(b"\xFF\xFD\x1F\xFF\xFB\x01Welcome\r\n").expect("a visitor");
        let heard = line(&mut stream);
        stream.write_all(b"50%\r\0ok\r\n").expect("he listens");
        assert_eq!(line(&mut stream), None);
        heard
    });
    let told = velvet(&["console", &board.at()], "M115\n");
    assert_eq!(told.stdout, b"Welcome\r\n50%\rok\r\n");
    assert_eq!(board.outcome().expect("a line"), b"\xFF\xFC\x1F\xFF\xFE\x01M115\r");
}

#[test]
fn a_board_that_waits_for_its_answers_to_be_taken_gets_every_line() {
    const LINES: usize = 2_000;
    // More than the buffers of both ends hold, each way.
    let pad = " ".repeat(10_000);
    let reply = format!("{pad}\nok\n");
    let board = Board::new(move |mut stream| {
        stream.write_all(GREETING.as_bytes()).expect("a visitor");
        let mut count = 0;
        let mut reader = std::io::BufReader::new(stream.try_clone().expect("a second handle"));
        let mut line = String::new();
        while std::io::BufRead::read_line(&mut reader, &mut line).expect("a visitor") > 0 {
            assert!(line.starts_with(&format!("G1 X{count} ;")), "{count}");
            line.clear();
            count += 1;
            stream.write_all(reply.as_bytes()).expect("he listens");
        }
        count
    });
    let lines: String = (0..LINES).map(|count| format!("G1 X{count} ;{pad}\n")).collect();
    let told = velvet(&["console", &board.at()], &lines);
    assert!(told.status.success(), "{}", errors(&told));
    assert_eq!(board.outcome(), LINES);
    assert_eq!(out(&told).lines().filter(|line| *line == "ok").count(), LINES + 1);
}

#[test]
fn a_job_is_sent_over_the_network_line_by_line() {
    let (job, word) = (file("job.gcode", "; a job\nG28 ; home\nG1 X1\n"), file("sesame", "open sesame\n"));
    let (job, word) = (job.to_str().expect("text"), word.to_str().expect("text"));
    let board = Board::new(locked);
    let sent = velvet(&["send", job, "--to", &board.at(), "--password-from", word], "");
    assert!(sent.status.success() && errors(&sent).ends_with("2 lines sent\n"), "{}", errors(&sent));
    assert_eq!(out(&sent), "said G28\nsaid G1 X1\n");
    assert_eq!(board.outcome(), ["G28", "G1 X1"]);
    let announcer = Announcer::new();
    let board = Board::new(open);
    announcer.announce("velvet", board.port(), &[("firmware", "velvet")]);
    let sent = velvet(&["send", job, "--to", "velvet.local", "--mdns-port", announcer.port()], "");
    assert!(sent.status.success() && out(&sent) == "said G28\nsaid G1 X1\n", "{}", errors(&sent));
    assert_eq!(board.outcome(), ["G28", "G1 X1"]);
    let nothing = velvet(&["send", job, "--to", "/dev/no-such-port"], "");
    assert!(errors(&nothing).contains("/dev/no-such-port") && errors(&nothing).contains("NAME.local"));
}

#[test]
fn what_cannot_be_reached_is_named_with_what_to_do() {
    let free = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address").to_string();
    let refused = velvet(&["console", &free], "");
    assert_eq!(refused.status.code(), Some(2));
    assert!(errors(&refused).contains(&free) && errors(&refused).contains("[network] shell_enable"));
    let board = Board::new(|mut stream| stream.write_all(b"All consoles are in use.\r\n"));
    let full = velvet(&["console", &board.at()], "M115\n");
    assert!(errors(&full).contains("closed the connection: All consoles are in use."), "{}", errors(&full));
    let board = Board::new(|mut stream| {
        stream.write_all(GREETING.as_bytes()).expect("a visitor");
        line(&mut stream)
    });
    let gone = velvet(&["console", &board.at()], "G28\n");
    assert_eq!(gone.status.code(), Some(2));
    assert!(errors(&gone).contains("the board closed the connection"), "{}", errors(&gone));
    let serial = velvet(&["console", "/dev/ttyACM0"], "");
    assert!(errors(&serial).contains("neither a name nor an address"), "{}", errors(&serial));
}

/// A terminal that somebody types at: what is shown there, and how velvet ends.
#[cfg(unix)]
mod terminal {
    use std::fs::File;
    use std::io::{Read, Write};
    use std::process::{Child, Command};
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Instant;

    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::{LocalModes, SpecialCodeIndex, tcgetattr};

    use super::{Board, line, locked};
    use crate::desk::PATIENCE;

    struct Terminal {
        velvet: Child,
        keys: File,
        shown: Receiver<Vec<u8>>,
        text: String,
    }

    impl Terminal {
        fn new(at: &str) -> Self {
            let pty = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
            grantpt(&pty).expect("a terminal");
            unlockpt(&pty).expect("a terminal");
            let name = ptsname(&pty, Vec::new()).expect("a terminal").into_string().expect("text");
            let end = File::options().read(true).write(true).open(name).expect("a terminal");
            let mut command = Command::new(env!("CARGO_BIN_EXE_velvet"));
            let again = || end.try_clone().expect("a second handle");
            command.args(["console", at]).stdin(again()).stdout(again()).stderr(end);
            let velvet = command.spawn().expect("velvet was built with this test");
            let keys = File::from(pty);
            let (to, shown) = channel();
            let mut screen = keys.try_clone().expect("a second handle");
            std::thread::spawn(move || {
                let mut bytes = [0; 1_000];
                while let Ok(count @ 1..) = screen.read(&mut bytes) {
                    if to.send(bytes[..count].to_vec()).is_err() {
                        return;
                    }
                }
            });
            drop(command);
            Self { velvet, keys, shown, text: String::new() }
        }

        fn see(&mut self, words: &str) {
            let end = Instant::now() + PATIENCE;
            while !self.text.contains(words) {
                match self.shown.recv_timeout(end.saturating_duration_since(Instant::now())) {
                    Ok(bytes) => self.text += &String::from_utf8_lossy(&bytes),
                    Err(_) => panic!("{words} is not shown, but {}", self.text),
                }
            }
        }

        /// Waits until keys are taken as a console or a question for a password does.
        fn wait_until_set(&self, shows: bool) {
            let end = Instant::now() + PATIENCE;
            loop {
                let settings = tcgetattr(&self.keys).expect("a terminal");
                let is_set = settings.special_codes[SpecialCodeIndex::VEOL] == 0x18;
                if is_set && settings.local_modes.contains(LocalModes::ECHO) == shows {
                    return;
                }
                assert!(Instant::now() < end, "the terminal stays as it was");
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        }

        fn hit(&mut self, keys: &str) {
            self.keys.write_all(keys.as_bytes()).expect("a terminal");
        }

        fn code(&mut self) -> Option<i32> {
            let end = Instant::now() + PATIENCE;
            while Instant::now() < end {
                if let Some(status) = self.velvet.try_wait().expect("a program") {
                    return status.code();
                }
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            panic!("it goes on: {}", self.text);
        }
    }

    impl Drop for Terminal {
        fn drop(&mut self) {
            let _has_ended = self.velvet.kill();
            let _has_ended = self.velvet.wait();
        }
    }

    #[test]
    fn a_password_is_not_shown_and_ctrl_d_ends() {
        let board = Board::new(locked);
        let mut terminal = Terminal::new(&board.at());
        terminal.see("Password: ");
        terminal.wait_until_set(false);
        terminal.hit("open sesame\n");
        terminal.see("Welcome");
        assert!(!terminal.text.contains("sesame"), "{}", terminal.text);
        terminal.wait_until_set(true);
        terminal.hit("M115\n");
        terminal.see("said M115");
        assert!(terminal.text.contains("\nM115"), "lines are shown: {}", terminal.text);
        terminal.hit("\x04");
        assert_eq!((terminal.code(), board.outcome()), (Some(0), vec!["M115".to_owned()]));
    }

    #[test]
    fn ctrl_x_halts_at_once_and_ctrl_c_ends_the_console_alone() {
        let board = Board::new(|mut stream| {
            stream.write_all(super::GREETING.as_bytes()).expect("a visitor");
            let mut byte = [0];
            stream.read_exact(&mut byte).expect("a sign, and no line");
            stream.write_all(b"ALARM: Abort during cycle\n").expect("a visitor");
            (byte[0], line(&mut stream))
        });
        let mut terminal = Terminal::new(&board.at());
        terminal.see("ok");
        terminal.wait_until_set(true);
        terminal.hit("G1 X1");
        terminal.hit("\x18");
        terminal.see("\nALARM");
        terminal.hit("G1 X1\x03");
        assert_eq!((terminal.code(), board.outcome()), (Some(130), (0x18, None)));
    }

    #[test]
    fn ctrl_c_ends_the_question_for_a_password() {
        let board = Board::new(locked);
        let mut terminal = Terminal::new(&board.at());
        terminal.see("Password: ");
        terminal.wait_until_set(false);
        terminal.hit("open\x03");
        terminal.see("no password was given");
        assert_eq!((terminal.code(), board.outcome()), (Some(2), vec!["left".to_owned()]));
    }

    #[test]
    fn a_board_that_goes_ends_the_console() {
        let board = Board::new(|mut stream| stream.write_all(super::GREETING.as_bytes()));
        let mut terminal = Terminal::new(&board.at());
        terminal.see("the board closed the connection");
        assert_eq!(terminal.code(), Some(2));
    }
}
