//! Blocks of the journal. Each is written whole and ends with a check value over all of it, so a block is
//! either as it was written or known to be broken.

use base::paths::Path;
use program::BEGINNING_BYTES;
use units::{MAX_AXES, MAX_HEATERS};

/// Size of the card's blocks, bytes.
pub const BLOCK: usize = 512;
const MAGIC: [u8; 4] = *b"VPLJ";
const VERSION: u8 = 1;
/// Offset of the check value, bytes.
const SUM_AT: usize = BLOCK - 4;
/// Length of the longest path that is kept, bytes.
const PATH: usize = 400;

/// Contents of a block.
pub type Block = [u8; BLOCK];

/// CRC table of four bits that leave the check value: half a byte at a time is eight times as fast as bit by
/// bit, and needs no kilobyte.
const OF_FOUR_BITS: [u32; 16] = {
    let mut table = [0; 16];
    let mut index = 0;
    while index < table.len() {
        let (mut sum, mut bit) = (index as u32, 0);
        while bit < 4 {
            sum = (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg());
            bit += 1;
        }
        table[index] = sum;
        index += 1;
    }
    table
};

/// Returns the CRC-32 (ISO 3309) of bytes, continued from an earlier value; 0 at first.
pub fn crc32(before: u32, bytes: &[u8]) -> u32 {
    let half = |sum: u32| (sum >> 4) ^ OF_FOUR_BITS[(sum & 0xF) as usize];
    bytes.iter().fold(!before, |sum, byte| half(half(sum ^ u32::from(*byte)))) ^ u32::MAX
}

/// Kind of a block's contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The file that is played.
    File = 1,
    /// State of the program at its beginning.
    Beginning = 2,
    /// Progress of the job, with the motors running.
    Running = 3,
    /// Progress of the job with the motors at rest: nothing newer will come.
    Stopped = 4,
    /// End of the job: there is nothing to go on with.
    Ended = 5,
}

/// Writes or reads the fields of a block, in order.
pub struct Fields<'b> {
    block: &'b mut Block,
    at: usize,
    reads: bool,
}

impl<'b> Fields<'b> {
    /// Begins to write a block.
    pub fn write(block: &'b mut Block, kind: Kind, sequence: u32) -> Self {
        *block = [0; BLOCK];
        let mut fields = Self { block, at: 0, reads: false };
        let (mut magic, mut version, mut kind, mut sequence) = (MAGIC, VERSION, kind as u8, sequence);
        fields.bytes(&mut magic);
        fields.byte(&mut version);
        fields.byte(&mut kind);
        fields.word(&mut sequence);
        fields
    }

    /// Begins to read a block; returns its kind and sequence number. `None` if it is broken or blank.
    pub fn read(block: &'b mut Block) -> Option<(Kind, u32, Self)> {
        let (body, sum) = block.split_at(SUM_AT);
        if sum != crc32(0, body).to_le_bytes() {
            return None;
        }
        let mut fields = Self { block, at: 0, reads: true };
        let (mut magic, mut version, mut kind, mut sequence) = ([0; 4], 0, 0, 0);
        fields.bytes(&mut magic);
        fields.byte(&mut version);
        fields.byte(&mut kind);
        fields.word(&mut sequence);
        let kinds = [Kind::File, Kind::Beginning, Kind::Running, Kind::Stopped, Kind::Ended];
        let kind = kinds.into_iter().find(|known| *known as u8 == kind)?;
        (magic == MAGIC && version == VERSION).then_some((kind, sequence, fields))
    }

    /// Completes the block with its check value.
    pub fn seal(self) {
        let (body, sum) = self.block.split_at_mut(SUM_AT);
        sum.copy_from_slice(&crc32(0, body).to_le_bytes());
    }

    /// Writes these bytes, or reads them.
    pub fn bytes(&mut self, value: &mut [u8]) {
        for value in value {
            self.byte(value);
        }
    }

    /// Writes a byte, or reads it.
    pub fn byte(&mut self, value: &mut u8) {
        let Some(byte) = self.block.get_mut(self.at).filter(|_| self.at < SUM_AT) else { return };
        if self.reads {
            *value = *byte;
        } else {
            *byte = *value;
        }
        self.at += 1;
    }

    /// Writes a number of 32 bits, or reads it.
    pub fn word(&mut self, value: &mut u32) {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes);
        *value = u32::from_le_bytes(bytes);
    }

    /// Writes a number of 64 bits, or reads it.
    pub fn long(&mut self, value: &mut u64) {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes);
        *value = u64::from_le_bytes(bytes);
    }

    /// Writes a floating-point number, or reads it.
    pub fn number(&mut self, value: &mut f64) {
        let mut bits = value.to_bits();
        self.long(&mut bits);
        *value = f64::from_bits(bits);
    }
}

/// The file that is played, and the machine's configuration.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlayedFile {
    /// Path of the file.
    pub path: Path,
    /// Size of the file, bytes.
    pub size: u32,
    /// Time at which the file was written, as the directory says.
    pub written: u32,
    /// Check value over samples of the file.
    pub check: u32,
    /// Check value over the configuration.
    pub machine: u32,
    /// The place of the file's dialect among all, from 1; 0: the machine's.
    pub dialect: u8,
}

impl PlayedFile {
    /// Returns whether a path is short enough to be kept.
    pub fn fits(path: &Path) -> bool {
        path.len() <= PATH
    }

    /// Writes the fields to a block, or reads them from it.
    pub fn go_through(&mut self, fields: &mut Fields<'_>) {
        for word in [&mut self.size, &mut self.written, &mut self.check, &mut self.machine] {
            fields.word(word);
        }
        fields.byte(&mut self.dialect);
        let mut length = self.path.len() as u32;
        fields.word(&mut length);
        let mut text = [0; PATH];
        text.iter_mut().zip(self.path.bytes()).for_each(|(to, from)| *to = from);
        fields.bytes(&mut text);
        let text = text.get(..length as usize).and_then(|text| core::str::from_utf8(text).ok());
        self.path = text.and_then(|text| Path::try_from(text).ok()).unwrap_or_default();
    }
}

/// State of the job at an entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Doing {
    /// The job runs: the machine was on the way of its file.
    #[default]
    Job = 0,
    /// The job waits: it was suspended, or the machine was on its way back to it. Nothing but the noted moves
    /// had moved the machine.
    Waits = 1,
    /// The job waits, and a script may have moved Z since.
    WaitsAnywhere = 2,
    /// The machine makes a move outside the job, after which the job goes on.
    Passes = 3,
}

impl Doing {
    /// Returns whether the file had nothing moved since.
    pub const fn waits(self) -> bool {
        matches!(self, Self::Waits | Self::WaitsAnywhere)
    }
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Sequence number of the file's blocks.
    pub job: u32,
    /// Number of lines made: the next line is to be made again.
    pub made: u32,
    /// Number of that line, for people.
    pub line: u32,
    /// Time since the job began, s.
    pub seconds: u32,
    /// Position of the motors, mm.
    pub position: [f64; MAX_AXES],
    /// Lowest and highest possible Z before the next entry, mm.
    pub z: [f64; 2],
    /// Targets of the heaters, degrees Celsius.
    pub targets: [f64; MAX_HEATERS],
    /// Factor of M220.
    pub feed_factor: f64,
    /// Factors of M221, by extruder.
    pub flow: [f64; 3],
    /// Homed axes, a bit each.
    pub homed: u8,
    /// Whether the bed's mesh is in force.
    pub has_mesh: u8,
    /// State of the job.
    pub doing: Doing,
    /// Objects that are left out, a bit each.
    pub left_out: u64,
    /// Temperature of the frame at which Z is right, degrees Celsius; 0: not known.
    pub frame: f64,
    /// Correction of Z for the frame's temperature, mm.
    pub thermal_z: f64,
    /// Axes that other moves have moved since, a bit each.
    pub strayed: u8,
    /// Whether the motors are at rest, so that nothing newer will come.
    pub stands: bool,
}

impl Entry {
    /// Writes the fields to a block, or reads them from it.
    pub fn go_through(&mut self, fields: &mut Fields<'_>) {
        for word in [&mut self.job, &mut self.made, &mut self.line, &mut self.seconds] {
            fields.word(word);
        }
        let lists: [&mut [f64]; 4] = [&mut self.position, &mut self.z, &mut self.targets, &mut self.flow];
        lists.into_iter().flatten().for_each(|value| fields.number(value));
        fields.number(&mut self.feed_factor);
        fields.byte(&mut self.homed);
        fields.byte(&mut self.has_mesh);
        let mut doing = self.doing as u8;
        fields.byte(&mut doing);
        let all = [Doing::Job, Doing::Waits, Doing::WaitsAnywhere, Doing::Passes];
        self.doing = all.get(usize::from(doing)).copied().unwrap_or(Doing::WaitsAnywhere);
        fields.long(&mut self.left_out);
        fields.byte(&mut self.strayed);
        fields.number(&mut self.frame);
        fields.number(&mut self.thermal_z);
    }
}

/// State of the program at the beginning of the job.
pub type Beginning = [u8; BEGINNING_BYTES];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_check_value_is_the_usual_one() {
        assert_eq!(crc32(0, b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(crc32(0, b"1234"), b"56789"), 0xCBF4_3926);
    }

    #[test]
    fn nothing_has_moved_since_an_entry_that_waits() {
        let waits = [Doing::Job, Doing::Waits, Doing::WaitsAnywhere, Doing::Passes].map(Doing::waits);
        assert_eq!(waits, [false, true, true, false]);
    }

    #[test]
    fn a_file_comes_back() {
        let path = Path::try_from("/sd/parts/gear ö.gcode").unwrap();
        let mut file = PlayedFile { path, size: 7, written: 9, check: 11, machine: 13, dialect: 2 };
        let mut block = [0; BLOCK];
        let mut fields = Fields::write(&mut block, Kind::File, 5);
        file.clone().go_through(&mut fields);
        fields.seal();
        let (kind, sequence, mut fields) = Fields::read(&mut block).unwrap();
        let mut read = PlayedFile::default();
        read.go_through(&mut fields);
        assert_eq!((kind, sequence, &mut read), (Kind::File, 5, &mut file));
    }

    proptest! {
        #[test]
        fn a_block_that_is_not_whole_is_none(at in 0..BLOCK, bit in 0_u8..8, made in any::<u32>(), z in any::<[f64; 2]>()) {
            let mut block = [0; BLOCK];
            let mut entry = Entry { made, z, ..Entry::default() };
            let mut fields = Fields::write(&mut block, Kind::Running, 77);
            entry.go_through(&mut fields);
            fields.seal();
            let mut read = Entry::default();
            read.go_through(&mut Fields::read(&mut block.clone()).unwrap().2);
            prop_assert_eq!(format!("{read:?}"), format!("{entry:?}"));
            block[at] ^= 1 << bit;
            prop_assert!(Fields::read(&mut block).is_none());
        }
    }

    #[test]
    fn only_a_job_that_waits_waits() {
        use Doing as D;
        assert!(D::Waits.waits() && D::WaitsAnywhere.waits() && !D::Passes.waits() && !D::default().waits());
    }
}
