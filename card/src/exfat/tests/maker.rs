//! Makes an exFAT volume, by the specification. Other crates' tests include this file.

pub const FIRST: u32 = 64;
pub const FAT: u32 = 24;
pub const FAT_BLOCKS: u32 = 8;
pub const HEAP: u32 = 40;
pub const CLUSTERS: u32 = 400;
/// Bytes of a directory's entry.
const ENTRY: usize = 32;
/// Blocks of a cluster.
const PER_CLUSTER: u32 = 2;

/// Volume under construction.
struct Maker {
    bytes: Vec<u8>,
    next: u32,
}

struct File {
    first: u32,
    size: u32,
    valid: u32,
    is_contiguous: bool,
    is_directory: bool,
}

impl Maker {
    fn new() -> Self {
        Self { bytes: vec![0; ((HEAP + CLUSTERS * PER_CLUSTER) * 512) as usize], next: 2 }
    }

    fn put(&mut self, at: u32, bytes: &[u8]) {
        self.bytes[at as usize..at as usize + bytes.len()].copy_from_slice(bytes);
    }

    fn link(&mut self, cluster: u32, next: u32) {
        self.put(FAT * 512 + cluster * 4, &next.to_le_bytes());
    }

    /// Stores content in clusters that are `apart` from each other: 1 is side by side.
    fn store(&mut self, content: &[u8], apart: u32) -> u32 {
        let (first, bytes) = (self.next, (PER_CLUSTER * 512) as usize);
        let pieces: Vec<&[u8]> = content.chunks(bytes).collect();
        for (number, piece) in pieces.iter().enumerate() {
            let cluster = first + number as u32 * apart;
            self.put((HEAP + (cluster - 2) * PER_CLUSTER) * 512, piece);
            let next = if number + 1 == pieces.len() { u32::MAX } else { cluster + apart };
            self.link(cluster, next);
        }
        self.next = first + pieces.len() as u32 * apart;
        first
    }

    fn file(&mut self, content: &[u8], apart: u32) -> File {
        let first = self.store(content, apart);
        let size = content.len() as u32;
        File { first, size, valid: size, is_contiguous: false, is_directory: false }
    }
}

fn sum(bytes: &[u8], skips: &[usize]) -> u16 {
    let counts = bytes.iter().enumerate().filter(|(at, _)| !skips.contains(at));
    counts.fold(0, |sum: u16, (_, byte)| sum.rotate_right(1).wrapping_add(u16::from(*byte)))
}

fn entries(name: &str, file: &File) -> Vec<u8> {
    let units: Vec<u16> = name.encode_utf16().collect();
    let names = units.len().div_ceil(15);
    let mut set = vec![0; ENTRY * (2 + names)];
    set[0] = 0x85;
    set[1] = 1 + names as u8;
    set[4] = if file.is_directory { 0x10 } else { 0x20 };
    // 2026-05-17 18:20: the date is the upper half.
    set[12..16].copy_from_slice(&(((46_u32 << 9 | 5 << 5 | 17) << 16) | 18 << 11 | 20 << 5).to_le_bytes());
    set[8..12].copy_from_slice(&((46_u32 << 9 | 5 << 5 | 17) << 16).to_le_bytes());
    set[16..20].copy_from_slice(&((46_u32 << 9 | 5 << 5 | 17) << 16).to_le_bytes());
    set[32] = 0xC0;
    set[33] = 1 | u8::from(file.is_contiguous) << 1;
    set[35] = units.len() as u8;
    let upper: Vec<u8> = name.to_ascii_uppercase().encode_utf16().flat_map(u16::to_le_bytes).collect();
    set[36..38].copy_from_slice(&sum(&upper, &[]).to_le_bytes());
    set[40..44].copy_from_slice(&file.valid.to_le_bytes());
    set[52..56].copy_from_slice(&file.first.to_le_bytes());
    set[56..60].copy_from_slice(&file.size.to_le_bytes());
    for (number, piece) in units.chunks(15).enumerate() {
        let at = 64 + number * ENTRY;
        set[at] = 0xC1;
        piece.iter().enumerate().for_each(|(place, unit)| {
            set[at + 2 + place * 2..at + 4 + place * 2].copy_from_slice(&unit.to_le_bytes());
        });
    }
    let checksum = sum(&set, &[2, 3]);
    set[2..4].copy_from_slice(&checksum.to_le_bytes());
    set
}

pub fn content(size: usize) -> Vec<u8> {
    (0..size).map(|at| (at * 7 + at / 512) as u8).collect()
}

/// Makes files side by side, scattered, with a part that was never written, in a directory, and with a long
/// name.
pub fn volume(others: &[(&str, &[u8])]) -> Vec<u8> {
    let mut maker = Maker::new();
    let bitmap = maker.store(&vec![0; CLUSTERS.div_ceil(8) as usize], 1);
    let upcase: Vec<u8> = (0..128_u16)
        .map(|unit| if (97..=122).contains(&unit) { unit - 32 } else { unit })
        .flat_map(u16::to_le_bytes)
        .collect();
    let table = maker.store(&upcase, 1);
    let scattered = maker.file(&content(9_000), 3);
    let mut together = maker.file(&content(20_000), 1);
    together.is_contiguous = true;
    // The FAT has no chain for a contiguous file.
    (together.first..maker.next).for_each(|cluster| maker.link(cluster, 0));
    let mut sparse = maker.file(&content(3_000), 1);
    sparse.valid = 700;
    let inner = maker.file(b"G28\n", 1);
    let mut folder = maker.file(&[&entries("inner.g", &inner)[..], &[0; 900]].concat(), 1);
    (folder.is_directory, folder.size, folder.valid) = (true, 1_024, 1_024);
    let mut root = vec![0x83, 4];
    root.extend("CARD".encode_utf16().flat_map(u16::to_le_bytes));
    root.resize(ENTRY, 0);
    let system = |kind: u8, sum: u32, first: u32, size: u32| {
        let mut entry = vec![0; ENTRY];
        entry[0] = kind;
        entry[4..8].copy_from_slice(&sum.to_le_bytes());
        entry[20..24].copy_from_slice(&first.to_le_bytes());
        entry[24..28].copy_from_slice(&size.to_le_bytes());
        entry
    };
    let check = upcase.iter().fold(0_u32, |sum, byte| sum.rotate_right(1).wrapping_add(u32::from(*byte)));
    root.extend(system(0x81, 0, bitmap, CLUSTERS.div_ceil(8)));
    root.extend(system(0x82, check, table, upcase.len() as u32));
    root.extend(entries("scattered.g", &scattered));
    // A file that was removed.
    let mut removed = entries("gone.g", &scattered);
    removed.chunks_mut(ENTRY).for_each(|entry| entry[0] &= 0x7F);
    root.extend(removed);
    root.extend(entries("together.g", &together));
    root.extend(entries("Ein langer Name über mehr als fünfzehn Zeichen.gcode", &sparse));
    root.extend(entries("folder", &folder));
    for number in 0..20 {
        let tiny = maker.file(format!("{number}").as_bytes(), 1);
        root.extend(entries(&format!("tiny {number}.g"), &tiny));
    }
    for (name, content) in others {
        let other = maker.file(content, 1);
        root.extend(entries(name, &other));
    }
    let root = maker.store(&root, 1);
    // The clusters used so far are marked in the bitmap.
    for cluster in 2..maker.next {
        let at = (HEAP + (bitmap - 2) * PER_CLUSTER) * 512 + (cluster - 2) / 8;
        maker.bytes[at as usize] |= 1 << ((cluster - 2) % 8);
    }
    // The gaps of the scattered file are free.
    for cluster in scattered.first..together.first {
        if !(cluster - scattered.first).is_multiple_of(3) {
            let at = (HEAP + (bitmap - 2) * PER_CLUSTER) * 512 + (cluster - 2) / 8;
            maker.bytes[at as usize] &= !(1 << ((cluster - 2) % 8));
        }
    }
    maker.link(0, 0xFFFF_FFF8);
    maker.link(1, u32::MAX);
    boot_regions(&mut maker, root);
    maker.bytes
}

fn boot_regions(maker: &mut Maker, root: u32) {
    let mut boot = vec![0; 12 * 512];
    boot[..11].copy_from_slice(b"\xEB\x76\x90EXFAT   ");
    boot[64..72].copy_from_slice(&u64::from(FIRST).to_le_bytes());
    boot[72..80].copy_from_slice(&u64::from(HEAP + CLUSTERS * PER_CLUSTER).to_le_bytes());
    for (at, value) in [(80, FAT), (84, FAT_BLOCKS), (88, HEAP), (92, CLUSTERS), (96, root), (100, 0x1234_5678)] {
        boot[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    boot[104..106].copy_from_slice(&0x0100_u16.to_le_bytes());
    (boot[108], boot[109], boot[110], boot[111], boot[112]) = (9, 1, 1, 0x80, 0xFF);
    boot[510..512].copy_from_slice(&[0x55, 0xAA]);
    for block in 1..9 {
        boot[block * 512 + 510..block * 512 + 512].copy_from_slice(&[0x55, 0xAA]);
    }
    let sum = boot[..11 * 512].iter().enumerate().filter(|(at, _)| !matches!(at, 106 | 107 | 112));
    let sum = sum.fold(0_u32, |sum, (_, byte)| sum.rotate_right(1).wrapping_add(u32::from(*byte)));
    boot[11 * 512..].chunks_mut(4).for_each(|word| word.copy_from_slice(&sum.to_le_bytes()));
    maker.put(0, &boot);
    maker.put(12 * 512, &boot);
}
