//! The page's files, in flash.

use http::{Body, Cache, EntityTag, Extent, Made, Response, Slice, Status};

/// File of the page, compressed by gzip.
type Row = (&'static str, &'static str, &'static [u8]);

/// All files, made by `web/build.mjs`.
const ROWS: &[Row] = include!("../../web/dist/assets.rs");
/// The file that a browser asks for by the site's name alone.
const INDEX: &str = "/index.html";

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    name: &'static str,
    content_type: &'static str,
    /// Content, compressed by gzip.
    pub bytes: &'static [u8],
    is_index: bool,
}

impl Asset {
    /// Returns the file of a path.
    #[must_use]
    pub fn find(path: &str) -> Option<Self> {
        let path = if path == "/" { INDEX } else { path };
        let (name, content_type, bytes) = *ROWS.iter().find(|(name, ..)| *name == path)?;
        Some(Self { name, content_type, bytes, is_index: name == INDEX })
    }

    /// Returns the validator of the content.
    #[must_use]
    pub fn tag(&self) -> EntityTag {
        // The others have a hash of their content in their names.
        EntityTag(fnv(if self.is_index { self.bytes } else { self.name.as_bytes() }))
    }

    /// Returns the head of the answer that has the file.
    #[must_use]
    pub fn response(&self) -> Response {
        let length = Extent::Known(self.bytes.len() as u64);
        let mut response = Response::of(Status::Ok, self.content_type, length);
        response.is_gzip = true;
        response.tag = Some(self.tag());
        response.cache = if self.is_index { Cache::Ask } else { Cache::Always };
        response
    }
}

/// Hash that tells contents apart, and resists nobody: FNV-1a of 64 bits.
#[must_use]
pub(crate) fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3))
}

/// Body that counts how much of it was made.
pub struct Counted<'s> {
    body: Slice<'s>,
    /// Bytes that were made.
    pub made: usize,
}

impl<'s> Counted<'s> {
    /// Makes a body of these bytes.
    #[must_use]
    pub const fn new(bytes: &'s [u8]) -> Self {
        Self { body: Slice::new(bytes), made: 0 }
    }
}

impl Body for Counted<'_> {
    fn make(&mut self, room: &mut [u8]) -> Made {
        let made = self.body.make(room);
        if let Made::Part(count) | Made::Last(count) = made {
            self.made += count;
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_an_index_and_its_files_are_compressed() {
        assert!(Asset::find("/").is_some() && Asset::find("/nothing").is_none());
        for (name, content_type, bytes) in ROWS {
            assert!(bytes.starts_with(&[0x1F, 0x8B]) && content_type.contains('/'), "{name}");
        }
    }

    #[test]
    fn only_the_index_is_asked_for_each_time() {
        for (name, ..) in ROWS {
            let cache = Asset::find(name).unwrap().response().cache;
            assert_eq!(cache == Cache::Ask, *name == INDEX, "{name}");
        }
    }
}
