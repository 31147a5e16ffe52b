//! The blocks of the journal. Each is written whole, and is either as it was written or known to be broken:
//! it ends with a check value over all of it.

use program::BEGINNING_BYTES;
use units::{MAX_AXES, MAX_HEATERS};

use crate::files::Path;

/// A block of the card, bytes.
pub const BLOCK: usize = 512;
const MAGIC: [u8; 4] = *b"VPLJ";
const VERSION: u8 = 1;
/// Where the check value is.
const SUM_AT: usize = BLOCK - 4;
/// Longest path that is kept.
const PATH: usize = 400;

/// A block.
pub type Block = [u8; BLOCK];

/// What four bits that leave the check value add to it: half a byte at a time is eight times as fast as bit
/// by bit, and needs no kilobyte.
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

/// CRC-32 (ISO 3309), from where an earlier one has come to; 0 at first.
pub fn crc32(before: u32, bytes: &[u8]) -> u32 {
    let half = |sum: u32| (sum >> 4) ^ OF_FOUR_BITS[(sum & 0xF) as usize];
    bytes.iter().fold(!before, |sum, byte| half(half(sum ^ u32::from(*byte)))) ^ u32::MAX
}

/// What a block holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Which file is played.
    File = 1,
    /// What the program stood on where it began.
    Beginning = 2,
    /// How far the motors are.
    Running = 3,
    /// The same, and they stand: there will be nothing newer.
    Stopped = 4,
    /// The job is over: there is nothing to go on with.
    Ended = 5,
}

/// Writes or reads the fields of a block, in order.
pub struct Fields<'b> {
    block: &'b mut Block,
    at: usize,
    reads: bool,
}

impl<'b> Fields<'b> {
    /// To write a block.
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

    /// To read one; its kind and sequence number. `None`: it is broken, or none.
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

    /// It is complete.
    pub fn seal(self) {
        let (body, sum) = self.block.split_at_mut(SUM_AT);
        sum.copy_from_slice(&crc32(0, body).to_le_bytes());
    }

    pub fn bytes(&mut self, value: &mut [u8]) {
        for value in value {
            self.byte(value);
        }
    }

    pub fn byte(&mut self, value: &mut u8) {
        let Some(byte) = self.block.get_mut(self.at).filter(|_| self.at < SUM_AT) else { return };
        if self.reads {
            *value = *byte;
        } else {
            *byte = *value;
        }
        self.at += 1;
    }

    pub fn word(&mut self, value: &mut u32) {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes);
        *value = u32::from_le_bytes(bytes);
    }

    pub fn long(&mut self, value: &mut u64) {
        let mut bytes = value.to_le_bytes();
        self.bytes(&mut bytes);
        *value = u64::from_le_bytes(bytes);
    }

    pub fn number(&mut self, value: &mut f64) {
        let mut bits = value.to_bits();
        self.long(&mut bits);
        *value = f64::from_bits(bits);
    }
}

/// Which file is played, on which machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlayedFile {
    pub path: Path,
    pub size: u32,
    /// When it was written, as the directory says.
    pub written: u32,
    /// A check value over samples of it.
    pub check: u32,
    /// A check value over the configuration.
    pub machine: u32,
    /// The place of its dialect among all, from 1; 0: the machine's.
    pub dialect: u8,
}

impl PlayedFile {
    /// Whether a path is short enough to be kept.
    pub fn fits(path: &Path) -> bool {
        path.len() <= PATH
    }

    /// To or from a block.
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

/// What the machine was about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Doing {
    /// The job: the machine was on the way of its file.
    #[default]
    Job = 0,
    /// The job waited: it was suspended, or the machine was on its way back to it. Nothing but what is noted
    /// had moved it.
    Waits = 1,
    /// The same, and a script may have moved Z since.
    WaitsAnywhere = 2,
    /// A move that is none of the job's, which goes on behind it.
    Passes = 3,
}

impl Doing {
    /// The file had nothing moved since.
    pub const fn waits(self) -> bool {
        matches!(self, Self::Waits | Self::WaitsAnywhere)
    }
}

/// How far a job is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// The sequence number of its file's blocks.
    pub job: u32,
    /// Lines that have been made: the next one is to be made again.
    pub made: u32,
    /// The number of that line, for people.
    pub line: u32,
    /// Seconds since the job began.
    pub seconds: u32,
    /// Where the motors are, mm.
    pub position: [f64; MAX_AXES],
    /// The lowest and the highest Z that they may be at before the next entry, mm.
    pub z: [f64; 2],
    pub targets: [f64; MAX_HEATERS],
    pub feed_factor: f64,
    pub flow: [f64; 3],
    /// Axes that are homed, a bit each.
    pub homed: u8,
    /// The bed's mesh is in force.
    pub has_mesh: u8,
    /// What the machine was about.
    pub doing: Doing,
    /// Objects that are left out, a bit each.
    pub left_out: u64,
    /// The frame's temperature at which Z is right, degrees Celsius; 0: not known.
    pub frame: f64,
    /// What is made up for in Z for the frame's temperature, mm.
    pub thermal_z: f64,
    /// Axes that something else has moved since, a bit each.
    pub strayed: u8,
    /// The motors stand there, and nothing newer will come.
    pub stands: bool,
}

impl Entry {
    /// To or from a block.
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

/// What the program stood on.
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
}
