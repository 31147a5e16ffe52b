//! Reads a whole volume and checks that it makes sense. The checker shares nothing with the code under test:
//! bytes in, a tree out.

use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use super::card::Card;

/// A file or directory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    pub short_name: String,
    /// Contents of the file; `None`: a directory.
    pub content: Option<Vec<u8>>,
    pub attributes: u8,
}

/// A volume whose every cluster belongs to one file or to none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Files and directories by path, with names as they are on the card.
    pub tree: BTreeMap<String, Node>,
    /// Number of clusters taken by nothing.
    pub lost: usize,
    /// Number of pieces of long names that belong to nothing.
    pub orphans: usize,
    /// Number of blocks in which the second table differs.
    pub tables_differ: usize,
    /// Number of directories whose `..` leads elsewhere.
    pub wrong_parents: usize,
    /// Number of slots behind a directory's end that are not zero.
    pub behind_end: usize,
}

impl Found {
    /// Returns whether nothing at all is left over.
    pub fn is_clean(&self) -> bool {
        [self.lost, self.orphans, self.tables_differ, self.wrong_parents, self.behind_end] == [0; 5]
    }
}

fn number(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}

struct Reader<'a> {
    card: &'a Card,
    fat32: bool,
    cluster_blocks: u32,
    data: u32,
    table: Vec<u32>,
    owner: Vec<Option<String>>,
    root: (u32, u32),
    found: Found,
}

/// Reads and checks the volume.
///
/// # Errors
/// A fault that no power cut may ever cause.
pub fn check(card: &Card) -> Result<Found, String> {
    let boot = card.block(0);
    let table_blocks = match number(&boot[22..24]) {
        0 => number(&boot[36..40]),
        blocks => blocks,
    };
    let total = number(&boot[19..21]).max(number(&boot[32..36]));
    let (reserved, tables, root_entries) = (number(&boot[14..16]), u32::from(boot[16]), number(&boot[17..19]));
    let root_block = reserved + tables * table_blocks;
    let data = root_block + root_entries / 16;
    let cluster_blocks = u32::from(boot[13]);
    let clusters = (total - data) / cluster_blocks;
    let fat32 = clusters >= 65_525;
    let mut found = Found::default();
    let mut table = Vec::new();
    for block in 0..table_blocks {
        let first = card.block(reserved + block);
        let entries = first.chunks(if fat32 { 4 } else { 2 });
        table.extend(entries.map(|entry| number(entry) & 0x0FFF_FFFF));
        found.tables_differ +=
            usize::from((1..tables).any(|copy| card.block(reserved + copy * table_blocks + block) != first));
    }
    table.truncate(clusters as usize + 2);
    let owner = vec![None; table.len()];
    let root = if fat32 { (number(&boot[44..48]), 0) } else { (root_block, root_entries / 16) };
    let mut reader = Reader { card, fat32, cluster_blocks, data, table, owner, root, found };
    let root = reader.root_blocks()?;
    reader.directory("", &root, 0)?;
    let taken =
        |(cluster, owner): (usize, &Option<String>)| cluster >= 2 && owner.is_none() && reader.table[cluster] != 0;
    reader.found.lost = reader.owner.iter().enumerate().filter(|pair| taken(*pair)).count();
    Ok(reader.found)
}

impl Reader<'_> {
    fn root_blocks(&mut self) -> Result<Vec<u32>, String> {
        let (first, blocks) = self.root;
        if self.fat32 { self.chain(first, "the root") } else { Ok((first..first + blocks).collect()) }
    }

    /// Returns the blocks of a chain, which becomes its owner's.
    fn chain(&mut self, first: u32, owner: &str) -> Result<Vec<u32>, String> {
        let (mut blocks, mut at) = (Vec::new(), first);
        let end = if self.fat32 { 0x0FFF_FFF8 } else { 0xFFF8 };
        loop {
            let place = self.owner.get_mut(at as usize).filter(|_| at >= 2);
            let place = place.ok_or_else(|| format!("{owner}: cluster {at} is none"))?;
            if let Some(other) = place.replace(owner.to_string()) {
                return Err(format!("cluster {at} belongs to {other} and to {owner}"));
            }
            let first = self.data + (at - 2) * self.cluster_blocks;
            blocks.extend(first..first + self.cluster_blocks);
            match self.table[at as usize] {
                next if next >= end => return Ok(blocks),
                0 => return Err(format!("{owner}: cluster {at} is free")),
                next => at = next,
            }
        }
    }

    fn directory(&mut self, path: &str, blocks: &[u32], own: u32) -> Result<(), String> {
        let slots: Vec<[u8; 32]> = blocks
            .iter()
            .flat_map(|block| {
                self.card.block(*block).chunks(32).map(|slot| slot.try_into().unwrap()).collect::<Vec<_>>()
            })
            .collect();
        let mut pieces: Vec<[u8; 32]> = Vec::new();
        let mut names: Vec<String> = Vec::new();
        for (place, slot) in slots.iter().enumerate() {
            if slot[0] == 0 {
                self.found.behind_end += slots[place..].iter().filter(|slot| slot[0] != 0).count();
                break;
            }
            let is_piece = slot[11] & 0x3F == 0x0F;
            if slot[0] != 0xE5 && is_piece {
                if slot[0] & 0x40 != 0 {
                    self.found.orphans += pieces.len();
                    pieces.clear();
                }
                pieces.push(*slot);
                continue;
            }
            let long = if slot[0] == 0xE5 { None } else { long_name(&pieces, slot) };
            self.found.orphans += if long.is_some() { 0 } else { pieces.len() };
            pieces.clear();
            if slot[0] == 0xE5 || slot[11] & 8 != 0 {
                continue;
            }
            let cluster = number(&slot[26..28]) | if self.fat32 { number(&slot[20..22]) << 16 } else { 0 };
            if slot[0] == b'.' {
                self.dots(path, place, slot, cluster, own);
                continue;
            }
            let name = long.unwrap_or_else(|| short_text(slot, slot[12]));
            let short = short_text(slot, 0);
            for taken in [capitals(&name), short.clone()] {
                if names.contains(&taken) {
                    return Err(format!("{path:?} has {taken:?} twice"));
                }
            }
            names.push(capitals(&name));
            if short != capitals(&name) {
                names.push(short);
            }
            self.entry(&if path.is_empty() { name } else { format!("{path}/{name}") }, slot, cluster)?;
        }
        self.found.orphans += pieces.len();
        Ok(())
    }

    fn dots(&mut self, path: &str, place: usize, slot: &[u8; 32], cluster: u32, own: u32) {
        let parent = path.rsplit_once('/').map(|(parent, _)| parent);
        let expected = match (place, parent) {
            (0, _) => own,
            (_, None) => 0,
            // The parent's cluster is the one whose owner it is and that no other of its clusters leads to.
            (_, Some(parent)) => self.first_cluster_of(parent),
        };
        self.found.wrong_parents += usize::from(cluster != expected || slot[11] & 0x10 == 0 || path.is_empty());
    }

    fn first_cluster_of(&self, path: &str) -> u32 {
        let owned: Vec<u32> =
            (2..self.table.len() as u32).filter(|c| self.owner[*c as usize].as_deref() == Some(path)).collect();
        let led_to: Vec<u32> = owned.iter().map(|cluster| self.table[*cluster as usize]).collect();
        owned.into_iter().find(|cluster| !led_to.contains(cluster)).unwrap_or(0)
    }

    fn entry(&mut self, path: &str, slot: &[u8; 32], cluster: u32) -> Result<(), String> {
        let (size, is_directory) = (number(&slot[28..32]), slot[11] & 0x10 != 0);
        let node = |content| Node { short_name: short_text(slot, 0), content, attributes: slot[11] };
        if is_directory {
            let blocks = self.chain(cluster, path)?;
            self.found.tree.insert(path.to_string(), node(None));
            return self.directory(path, &blocks, cluster);
        }
        let needed = size.div_ceil(self.cluster_blocks * 512) * self.cluster_blocks;
        let blocks = if cluster == 0 { Vec::new() } else { self.chain(cluster, path)? };
        if blocks.len() != needed as usize {
            return Err(format!("{path}: {size} bytes in {} blocks", blocks.len()));
        }
        let mut content: Vec<u8> = blocks.iter().flat_map(|block| self.card.block(*block)).collect();
        content.truncate(size as usize);
        self.found.tree.insert(path.to_string(), node(Some(content)));
        Ok(())
    }
}

/// The name in capitals, as far as letters have one.
pub fn capitals(name: &str) -> String {
    let capital = |letter: char| Some(letter.to_uppercase()).filter(|capital| capital.len() == 1);
    name.chars().map(|letter| capital(letter).and_then(|mut capital| capital.next()).unwrap_or(letter)).collect()
}

fn short_text(slot: &[u8; 32], case: u8) -> String {
    let part = |bytes: &[u8], small: bool| {
        let text = String::from_utf8_lossy(bytes).trim_end().to_string();
        if small { text.to_ascii_lowercase() } else { text }
    };
    let (stem, extension) = (part(&slot[..8], case & 8 != 0), part(&slot[8..11], case & 16 != 0));
    if extension.is_empty() { stem } else { format!("{stem}.{extension}") }
}

fn long_name(pieces: &[[u8; 32]], entry: &[u8; 32]) -> Option<String> {
    let sum = entry[..11].iter().fold(0_u8, |sum, byte| sum.rotate_right(1).wrapping_add(*byte));
    let mut units = Vec::new();
    for (place, piece) in pieces.iter().rev().enumerate() {
        let last = if place + 1 == pieces.len() { 0x40 } else { 0 };
        if piece[0] != (place as u8 + 1) | last || piece[13] != sum {
            return None;
        }
        for at in [1, 3, 5, 7, 9, 14, 16, 18, 20, 22, 24, 28, 30] {
            units.push(u16::from_le_bytes([piece[at], piece[at + 1]]));
        }
    }
    let end = units.iter().position(|unit| *unit == 0).unwrap_or(units.len());
    let padded = units[end..].iter().skip(1).all(|unit| *unit == 0xFFFF) && units.len() - end <= 13;
    (!pieces.is_empty() && padded).then(|| String::from_utf16_lossy(&units[..end]))
}
