//! The operator at the console: has the board play a file from its SD card and watches it to the end.
//!
//! The dialogue is Smoothieware v2's. The state machine has no clock of its own: it is told the time and
//! the board's words, and returns the next text to type. The same serves for every board and runner.

/// Time for the board's answer, before the question is asked again.
const PATIENCE_NS: u64 = 2_000_000_000;
/// Interval of progress questions while the file plays.
const PROGRESS_NS: u64 = 2_000_000_000;
/// Interval of status questions while waiting for standstill.
const STATUS_NS: u64 = 200_000_000;
/// Attempts to reach the board, and to start the job.
const ATTEMPTS: u32 = 10;

/// Longest silence of a booting board between two of its first words: an image may wait for the 32 kHz
/// crystal twice, 2 s each (the data sheet's typical start-up).
pub const BOOT_SILENCE_NS: u64 = 5_000_000_000;

/// Distance below its target at which a heater is still on its way, kelvins.
const WARM_K: f64 = 0.5;
/// Standstills in a row that end a job on a board that is not ours: such a board may have read the file far
/// ahead of its motion, be idle while it waits for a heater, and for a moment before it goes on.
const FOREIGN_IDLE: u32 = 25;

/// Time at which the operator speaks for the first time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Opening {
    /// At once: the board answers when it can.
    #[default]
    AtOnce,
    /// After the board's first words and a pause, for a board that loses any text sent before.
    AfterFirstWords,
    /// At this time since power-on, nanoseconds.
    At(u64),
}

/// State of the dialogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// Waiting for the board's first words.
    Listen,
    /// Waiting for any answer: the board boots.
    Greet,
    /// `M23` was typed: waiting for the file to be selected.
    Select,
    /// `M24` was typed: waiting for its ok.
    Start,
    /// The file is being played.
    Play,
    /// The file is through: waiting for standstill.
    Settle,
    /// Nothing more to do.
    Over,
}

/// Dialogue of a job.
#[derive(Clone, Debug)]
pub struct Session {
    file: String,
    step: Step,
    /// Time of the next words.
    speak_ns: u64,
    attempts: u32,
    /// Standstills seen in a row after the file, and the number that ends the job.
    idle: u32,
    idle_needed: u32,
    partial: Vec<u8>,
    progress: Option<(u64, u64)>,
    halted: Option<String>,
    errors: Vec<String>,
    /// The last message in GRBL's dialect.
    message: String,
}

impl Session {
    /// Makes a session that has the board play this file of its card's root directory.
    #[must_use]
    pub fn new(file: &str, opening: Opening) -> Self {
        let (step, speak_ns) = match opening {
            Opening::AtOnce => (Step::Greet, 0),
            Opening::AfterFirstWords => (Step::Listen, u64::MAX),
            Opening::At(ns) => (Step::Greet, ns),
        };
        Self {
            file: file.to_owned(),
            step,
            speak_ns,
            attempts: 0,
            idle: 0,
            idle_needed: if opening == Opening::AtOnce { 1 } else { FOREIGN_IDLE },
            partial: Vec::new(),
            progress: None,
            halted: None,
            errors: Vec::new(),
            message: String::new(),
        }
    }

    /// Takes bytes that the board has sent.
    pub fn hear(&mut self, now_ns: u64, bytes: &[u8]) {
        if self.step == Step::Listen && !bytes.is_empty() {
            self.speak_ns = now_ns + BOOT_SILENCE_NS;
        }
        for &byte in bytes {
            if byte == b'\n' {
                let line = std::mem::take(&mut self.partial);
                self.line(now_ns, String::from_utf8_lossy(&line).trim());
            } else {
                self.partial.push(byte);
            }
        }
    }

    fn line(&mut self, now_ns: u64, line: &str) {
        if self.step == Step::Over || line.is_empty() {
            return;
        }
        if let Some(reason) = halt_reason(line) {
            // The mark `!!` only says that the machine has halted; the error before it tells the reason.
            let reason = self.errors.last().filter(|_| reason == "!!").map_or(reason, String::as_str).to_owned();
            self.halted.get_or_insert(reason);
            self.go(now_ns, Step::Over);
            return;
        }
        if is_error(line) && !self.errors.iter().any(|error| error == line) {
            self.errors.push(line.to_owned());
        }
        if line.starts_with(INVALID) {
            return self.go(now_ns, Step::Over);
        }
        if let Some(bytes) = line.strip_prefix("SD printing byte ") {
            self.progress = bytes.split_once('/').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        }
        match self.step {
            Step::Greet if line.starts_with("ok") => self.go(now_ns, Step::Select),
            Step::Select if line.contains("File selected") => self.go(now_ns, Step::Start),
            Step::Select if line.contains("file.open failed") => self.give_up(now_ns, line),
            // Before the question the line is still the answer to the last one.
            Step::Start if line.starts_with("ok") && self.attempts > 0 => {
                self.go(now_ns, Step::Play);
                self.speak_ns = now_ns + PROGRESS_NS;
            }
            Step::Start | Step::Play if line.contains(NOT_BEGUN) => self.give_up(now_ns, line),
            Step::Start | Step::Play if line.contains("Done printing file") => self.go(now_ns, Step::Settle),
            Step::Play if line.contains("Not currently playing") || line.contains("Not SD printing") => {
                self.give_up(now_ns, "the file stopped playing before its end");
            }
            Step::Start | Step::Play if line.starts_with(PAUSED) => self.go(now_ns, Step::Over),
            // In GRBL's dialect messages tell the reason, and no line is an error's.
            Step::Start | Step::Play if line.starts_with(PAUSED_GRBL) => {
                let why = std::mem::take(&mut self.message);
                self.errors.extend([why, line.to_owned()]);
                self.go(now_ns, Step::Over);
            }
            // The tool is in, and any other wait of the program is done.
            Step::Start | Step::Play if line.contains(WAITS) => self.go(now_ns, Step::Start),
            Step::Settle if line.starts_with("<Idle") => {
                self.idle = if self.idle_needed > 1 && warms_up(line) { 0 } else { self.idle + 1 };
                if self.idle >= self.idle_needed {
                    self.go(now_ns, Step::Over);
                }
            }
            Step::Settle if line.starts_with("<Run") => self.idle = 0,
            Step::Settle if line.starts_with("<Alarm") => self.give_up(now_ns, "the machine is in alarm after the job"),
            _ => {}
        }
        if line.starts_with("[MSG:") {
            line.clone_into(&mut self.message);
        }
    }

    fn go(&mut self, now_ns: u64, step: Step) {
        self.step = step;
        self.speak_ns = now_ns;
        self.attempts = 0;
    }

    fn give_up(&mut self, now_ns: u64, reason: &str) {
        if !self.errors.iter().any(|error| error == reason) {
            self.errors.push(reason.to_owned());
        }
        self.go(now_ns, Step::Over);
    }

    /// Returns the operator's next text, if any.
    pub fn say(&mut self, now_ns: u64) -> Option<String> {
        if now_ns < self.speak_ns {
            return None;
        }
        if self.step == Step::Listen {
            self.step = Step::Greet;
        }
        let (words, interval) = match self.step {
            Step::Listen | Step::Greet => ("M21\n".to_owned(), PATIENCE_NS),
            Step::Select => (format!("M23 {}\n", self.file), PATIENCE_NS),
            Step::Start => ("M24\n".to_owned(), PATIENCE_NS),
            Step::Play => ("M27\n".to_owned(), PROGRESS_NS),
            Step::Settle => ("?".to_owned(), STATUS_NS),
            Step::Over => return None,
        };
        // While the file plays or moves run out, questions may go on for hours; before, silence means
        // something.
        if !matches!(self.step, Step::Play | Step::Settle) {
            if self.attempts == ATTEMPTS {
                let asked = words.trim_end().to_owned();
                self.give_up(now_ns, &format!("no answer to {asked}"));
                return None;
            }
            self.attempts += 1;
        }
        self.speak_ns = now_ns + interval;
        Some(words)
    }

    /// Share of the file that was played, 0 to 1, once known.
    #[must_use]
    pub fn progress(&self) -> Option<f64> {
        match (self.step, self.progress) {
            (Step::Settle | Step::Over, _) if self.succeeded() => Some(1.0),
            (_, Some((done, all))) if all > 0 => Some(done as f64 / all as f64),
            _ => None,
        }
    }

    /// Returns whether nothing more is to do.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.step == Step::Over
    }

    /// Returns whether the job went through so far.
    #[must_use]
    pub fn succeeded(&self) -> bool {
        self.halted.is_none() && self.errors.is_empty()
    }

    /// Returns the reason of a halt, if the machine halted.
    #[must_use]
    pub fn halted(&self) -> Option<&str> {
        self.halted.as_deref()
    }

    /// Returns the errors so far.
    #[must_use]
    pub fn errors(&self) -> &[String] {
        &self.errors
    }
}

/// Returns the reason if a line means that the machine has halted.
fn halt_reason(line: &str) -> Option<&str> {
    let halted = line.starts_with("ALARM")
        || line.starts_with("!!")
        || line.contains("HALT asserted")
        || line.contains("HALTED");
    halted.then_some(line)
}

/// Whether a status line shows a heater well below its target: a field of two temperatures, present and
/// wanted.
fn warms_up(status: &str) -> bool {
    status.trim_end_matches('>').split('|').any(|field| {
        let Some((name, values)) = field.split_once(':') else { return false };
        let Some((present, wanted)) = values.split_once(',') else { return false };
        let (Ok(present), Ok(wanted)) = (present.parse::<f64>(), wanted.parse::<f64>()) else { return false };
        name != "F" && name != "FS" && wanted - present > WARM_K
    })
}

/// Mark of a line of the job that could not be read, with the fault behind it.
const UNREAD_LINE: &str = "// WARNING gcode parse failed";
/// The job waits for a person, because one of its lines could not be carried out.
const PAUSED: &str = "error:paused";
const PAUSED_GRBL: &str = "[MSG:paused";

/// The job was refused before its first line; an error in one dialect, a message in GRBL's.
const NOT_BEGUN: &str = "the job was not begun: ";

/// The program waits for a person (M0, M6), who is to say that it may go on.
const WAITS: &str = ": ~ or M24 goes on";

/// Mark of a board whose configuration cannot be used, so that nothing can be played. The findings come
/// before it.
const INVALID: &str = "There was a fatal error in the config.ini";

fn is_error(line: &str) -> bool {
    let head: String = line.chars().take(6).collect::<String>().to_ascii_lowercase();
    let is_finding = line.starts_with("config.ini: ") && !line.contains("warning");
    head == "error:" || head.starts_with("fatal") || line.starts_with(UNREAD_LINE) || is_finding
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    /// Runs a board that answers the operator; returns the transcript of the board's input.
    fn transcript(answers: &[(&str, &str)], until_s: u64) -> (Session, Vec<String>) {
        let mut session = Session::new("job.gcode", Opening::AtOnce);
        let mut heard = Vec::new();
        for now_ns in (0..until_s * S).step_by(100_000_000) {
            if let Some(words) = session.say(now_ns) {
                let answer = answers.iter().find(|(question, _)| *question == words.trim_end());
                heard.push(words.trim_end().to_owned());
                if let Some((_, answer)) = answer {
                    session.hear(now_ns, answer.as_bytes());
                }
            }
        }
        (session, heard)
    }

    const HAPPY: [(&str, &str); 5] = [
        ("M21", "SD card ok\nok\n"),
        ("M23 job.gcode", "File opened:job.gcode Size:100\nFile selected\nok\n"),
        ("M24", "ok\n"),
        ("M27", "SD printing byte 50/100\nok\nDone printing file\n"),
        ("?", "<Idle|MPos:0.0000,0.0000,0.0000|F:0.0>\n"),
    ];

    #[test]
    fn a_board_with_a_wrong_configuration_is_asked_nothing_and_its_findings_are_told() {
        let mut session = Session::new("job.gcode", Opening::AtOnce);
        let finding = "config.ini: line 3: error: [actuator] alpha.steps_per_mm: banana is no number";
        session
            .hear(0, format!("{finding}\nThere was a fatal error in the config.ini this must be fixed\n").as_bytes());
        assert_eq!(session.say(10 * S), None);
        assert_eq!(session.errors(), [finding.to_owned()]);
        assert!(session.is_over());
    }

    #[test]
    fn a_job_is_selected_started_watched_and_waited_for() {
        let (session, heard) = transcript(&HAPPY, 10);
        assert_eq!(heard, ["M21", "M23 job.gcode", "M24", "M27", "?"]);
        assert!(session.is_over() && session.succeeded());
        assert_eq!(session.progress(), Some(1.0));
    }

    #[test]
    fn a_job_that_pauses_in_grbls_dialect_is_over_and_its_reason_told() {
        let mut session = Session::new("job.gcode", Opening::AtOnce);
        session.step = Step::Play;
        session.hear(0, b"[MSG:G77 is not known here]\n[MSG:paused, line 6 of /sd/job.gcode was not carried out]\n");
        assert!(session.is_over() && !session.succeeded());
        assert_eq!(session.errors()[0], "[MSG:G77 is not known here]");
    }

    #[test]
    fn a_program_that_waits_is_told_to_go_on() {
        let mut session = Session::new("job.gcode", Opening::AtOnce);
        session.step = Step::Play;
        session.hear(0, b"// put in tool 1 (M6): ~ or M24 goes on, abort ends the job\n");
        assert_eq!(session.say(0).as_deref(), Some("M24\n"));
        session.hear(0, b"ok\n");
        assert_eq!(session.say(10 * S).as_deref(), Some("M27\n"));
    }

    #[test]
    fn a_board_that_reads_ahead_is_watched_until_its_heaters_are_warm_and_it_stays_idle() {
        let mut session = Session::new("job.gcode", Opening::At(0));
        session.step = Step::Settle;
        let mut hear = |status: &str| {
            session.hear(0, format!("<{status}>\n").as_bytes());
            session.is_over()
        };
        for _ in 0..10 {
            assert!(!hear("Idle|MPos:5.0,5.0,5.0|F:4000.0,100.0|B:22.0,0.0|T:41.5,60.0"));
        }
        assert!((1..FOREIGN_IDLE).all(|_| !hear("Idle|MPos:5.0,5.0,5.0|T:59.5,60.0")));
        assert!(!hear("Run|MPos:7.0,5.0,5.0|T:59.5,60.0"));
        assert!((1..FOREIGN_IDLE).all(|_| !hear("Idle|MPos:9.0,5.0,5.0|F:4000.0,9000.0|T:59.5,0.0")));
        assert!(hear("Idle|MPos:9.0,5.0,5.0|F:4000.0,9000.0|T:59.5,0.0"));
    }

    #[test]
    fn the_operator_can_wait_until_the_board_has_said_its_first_words() {
        let mut session = Session::new("job.gcode", Opening::AfterFirstWords);
        assert_eq!(session.say(100 * S), None);
        session.hear(S, b"INFO: starting up\n");
        session.hear(4 * S, b"ready");
        assert_eq!(session.say(4 * S + BOOT_SILENCE_NS - 1), None);
        assert_eq!(session.say(4 * S + BOOT_SILENCE_NS).as_deref(), Some("M21\n"));
        let mut session = Session::new("job.gcode", Opening::At(7 * S));
        assert_eq!(session.say(7 * S - 1), None);
        assert_eq!(session.say(7 * S).as_deref(), Some("M21\n"));
    }

    #[test]
    fn a_halt_ends_the_job_with_its_reason() {
        let mut answers = HAPPY;
        answers[3].1 = "ALARM: Kill button pressed - reset, $X or M999 to clear HALT\n";
        let (session, _) = transcript(&answers, 10);
        assert!(session.is_over() && !session.succeeded());
        assert_eq!(session.halted(), Some("ALARM: Kill button pressed - reset, $X or M999 to clear HALT"));
    }

    #[test]
    fn a_bare_refusal_takes_its_reason_from_the_error_before_it() {
        let mut answers = HAPPY;
        answers[3].1 = "ERROR: Homing cycle failed\n!!\n";
        assert_eq!(transcript(&answers, 10).0.halted(), Some("ERROR: Homing cycle failed"));
    }

    #[test]
    fn a_missing_file_and_a_silent_board_are_errors() {
        let mut answers = HAPPY;
        answers[1].1 = "file.open failed: job.gcode\nok\n";
        assert_eq!(transcript(&answers, 10).0.errors(), ["file.open failed: job.gcode"]);
        let (session, heard) = transcript(&[], 60);
        assert_eq!(heard.len(), 10);
        assert_eq!(session.errors(), ["no answer to M21"]);
    }

    #[test]
    fn a_line_that_cannot_be_read_is_an_error_of_the_job() {
        assert!(is_error("// WARNING gcode parse failed Illegal parameter word: Y needs a number, column 8 - G1 Yfoo"));
        assert!(!is_error("// WARNING something else"));
    }

    #[test]
    fn a_job_that_was_not_begun_is_an_error_in_both_dialects() {
        for refusal in ["error:the job was not begun: home first", "[MSG:the job was not begun: home first]"] {
            let (mut answers, said) = (HAPPY, format!("ok\n{refusal}\nDone printing file\n").leak());
            answers[2].1 = said;
            assert_eq!(transcript(&answers, 10).0.errors(), [refusal]);
        }
    }

    #[test]
    fn a_file_that_stops_playing_before_its_end_is_an_error() {
        let mut answers = HAPPY;
        answers[3].1 = "Not currently playing\nok\n";
        assert_eq!(transcript(&answers, 10).0.errors(), ["the file stopped playing before its end"]);
    }
}
