//! Lock step with a host program on this computer, by a page in a file that both have in memory: the host's
//! clock reads the board's time there and says until when it waits. The board goes on only while everything
//! in the host that counts time waits, and while no byte is on its way between the two. The host's side is
//! `peers/klippy/clock.c`.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::{Duration, Instant};

/// Boards that may share a page.
pub const BOARDS: usize = 4;
const THREADS: usize = 64;
/// Words of a board: its time, the same again, bytes that the host has written to it and read from it.
const BOARD_WORDS: usize = 4;
/// Goes up whenever a thread of the host begins or ends to wait.
const TURNS: usize = BOARDS * BOARD_WORDS;
/// Bytes in the pipes by which threads of the host wake each other.
const PIPED: usize = TURNS + 1;
/// For each thread of the host that counts time, until when it waits.
const WAITS: usize = PIPED + 1;
const WORDS: usize = WAITS + THREADS;
/// What a board calls zero is this for the host.
const BASE_NS: u64 = 100_000_000_000;
/// A thread of the host that works; above it, the instant until which it waits.
const WORKS: u64 = 1;
/// Time after which bytes that do not arrive count as lost: the host has thrown them away, or is gone.
const LOST: Duration = Duration::from_millis(500);

/// Bytes between the board's serial socket and its client, since the socket was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes from the client.
    pub heard: u64,
    /// Bytes to the client.
    pub said: u64,
    /// Whether the line to the board has room for more.
    pub has_room: bool,
}

/// Answer to whether the board may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// It may.
    Go,
    /// Not yet: ask again soon.
    Wait,
    /// There is no host; real time will do.
    Alone,
}

/// The page, as one of its boards has it.
pub struct ClockFile {
    file: File,
    board: usize,
    /// Bytes on their way to and from the host, and within it, that will never arrive, as differences of
    /// counts.
    lost: [u64; 3],
    /// The same differences as last seen, and since when they are so.
    seen: ([u64; 3], Instant),
    turns: Option<u64>,
}

impl ClockFile {
    /// Opens the page, and makes it if need be.
    ///
    /// # Errors
    /// What the file system says, with the path.
    pub fn open(path: &Path, board: usize) -> Result<Self, String> {
        let fail = |error: io::Error| format!("{}: {error}", path.display());
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let file = options.map_err(fail)?;
        file.set_len((WORDS * 8) as u64).map_err(fail)?;
        let page = Self { file, board, lost: [0; 3], seen: ([0; 3], Instant::now()), turns: None };
        page.write(board * BOARD_WORDS, &[0; BOARD_WORDS]).map_err(fail)?;
        Ok(page)
    }

    fn write(&self, at: usize, words: &[u64]) -> io::Result<()> {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.file.write_all_at(&bytes, (at * 8) as u64)
    }

    fn read(&self) -> io::Result<[u64; WORDS]> {
        let mut bytes = [0; WORDS * 8];
        self.file.read_exact_at(&mut bytes, 0)?;
        let mut words = [0; WORDS];
        for (word, chunk) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u64::from_le_bytes(*chunk);
        }
        Ok(words)
    }

    /// Tells the board's time.
    ///
    /// # Errors
    /// What the file system says.
    pub fn tell(&self, now_ns: u64) -> io::Result<()> {
        self.write(self.board * BOARD_WORDS, &[now_ns, now_ns])
    }

    /// Whether the board may go on from here. It is asked twice before it does: a thread that has just been
    /// given something to do by another one may not know yet.
    ///
    /// # Errors
    /// What the file system says.
    pub fn turn(&mut self, now_ns: u64, traffic: Traffic) -> io::Result<Turn> {
        let words = self.read()?;
        let threads = words[WAITS..].iter().copied().filter(|&until| until > 0);
        let Some(earliest) = threads.min() else { return Ok(Turn::Alone) };
        let others = words[..TURNS].chunks_exact(BOARD_WORDS).map(|board| board[0]).filter(|&ns| ns > 0);
        let is_ahead = others.min().is_some_and(|slowest| slowest < now_ns);
        let is_due = earliest <= WORKS || earliest <= now_ns + BASE_NS;
        let settled = self.has_arrived(&words, traffic) && !is_due && !is_ahead;
        let turns = settled.then_some(words[TURNS]);
        let may_go = settled && turns == self.turns;
        self.turns = turns;
        Ok(if may_go { Turn::Go } else { Turn::Wait })
    }

    /// Whether all bytes between the two have arrived, or will not any more.
    fn has_arrived(&mut self, words: &[u64; WORDS], traffic: Traffic) -> bool {
        let at = self.board * BOARD_WORDS;
        let on_the_way =
            [words[at + 2].wrapping_sub(traffic.heard), traffic.said.wrapping_sub(words[at + 3]), words[PIPED]];
        if on_the_way != self.seen.0 {
            self.seen = (on_the_way, Instant::now());
        } else if self.seen.1.elapsed() >= LOST {
            self.lost = on_the_way;
        }
        let is_heard = on_the_way[0] == self.lost[0] || !traffic.has_room;
        is_heard && on_the_way[1..] == self.lost[1..]
    }
}

impl Drop for ClockFile {
    fn drop(&mut self) {
        // The other boards do not wait for this one any more.
        let _gone = self.write(self.board * BOARD_WORDS, &[0; BOARD_WORDS]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW_NS: u64 = 5_000_000;

    /// A page with a host's thread that waits for a second, and a board at [`NOW_NS`].
    struct Pair {
        page: ClockFile,
        path: std::path::PathBuf,
    }

    impl Pair {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("clock-file-{name}-{}", std::process::id()));
            let page = ClockFile::open(&path, 0).expect("a file");
            page.tell(NOW_NS).expect("written");
            let pair = Self { page, path };
            pair.host(WAITS, BASE_NS + 1_000_000_000);
            pair
        }

        fn host(&self, word: usize, value: u64) {
            self.page.write(word, &[value]).expect("written");
        }

        fn turns(&mut self, traffic: Traffic) -> [Turn; 2] {
            [(); 2].map(|()| self.page.turn(NOW_NS, traffic).expect("read"))
        }
    }

    impl Drop for Pair {
        fn drop(&mut self) {
            let _gone = std::fs::remove_file(&self.path);
        }
    }

    const QUIET: Traffic = Traffic { heard: 0, said: 0, has_room: true };

    #[test]
    fn a_board_goes_on_while_the_host_waits() {
        let mut pair = Pair::new("waits");
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Go]);
        pair.host(TURNS, 7);
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Go], "a thread has begun to wait in between");
        pair.host(WAITS + 1, WORKS);
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Wait]);
        pair.host(WAITS + 1, BASE_NS + NOW_NS);
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Wait], "it has to wake up first");
        pair.host(WAITS + 1, 0);
        pair.host(WAITS, 0);
        assert_eq!(pair.turns(QUIET), [Turn::Alone, Turn::Alone]);
    }

    #[test]
    fn a_board_waits_for_one_that_is_behind() {
        let mut pair = Pair::new("behind");
        pair.host(BOARD_WORDS, NOW_NS - 1);
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Wait]);
        pair.host(BOARD_WORDS, NOW_NS);
        assert_eq!(pair.turns(QUIET), [Turn::Wait, Turn::Go]);
    }

    #[test]
    fn a_board_waits_for_bytes_until_they_are_lost() {
        let mut pair = Pair::new("bytes");
        pair.host(2, 3);
        for traffic in [Traffic { heard: 2, ..QUIET }, Traffic { heard: 3, said: 1, ..QUIET }] {
            assert_eq!(pair.turns(traffic), [Turn::Wait, Turn::Wait]);
        }
        assert_eq!(pair.turns(Traffic { heard: 2, has_room: false, ..QUIET }), [Turn::Wait, Turn::Go]);
        assert_eq!(pair.turns(Traffic { heard: 3, ..QUIET }), [Turn::Go, Turn::Go]);
        pair.host(PIPED, 1);
        assert_eq!(pair.turns(Traffic { heard: 3, ..QUIET }), [Turn::Wait, Turn::Wait]);
        pair.host(PIPED, 0);
        let lost = Traffic { heard: 3, said: 1, ..QUIET };
        assert_eq!(pair.turns(lost), [Turn::Wait, Turn::Wait]);
        std::thread::sleep(LOST);
        assert_eq!(pair.turns(lost), [Turn::Wait, Turn::Go]);
    }
}
