//! Descriptors as a host reads them.

/// Descriptor split into type and body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Descriptor {
    pub kind: u8,
    /// Bytes behind length and type.
    pub body: Vec<u8>,
}

/// Walks descriptors by their lengths, to the very end.
pub fn walk(mut bytes: &[u8]) -> Vec<Descriptor> {
    let mut descriptors = Vec::new();
    while !bytes.is_empty() {
        let length = usize::from(bytes[0]);
        assert!((2..=bytes.len()).contains(&length), "a descriptor of {length} bytes, {} are left", bytes.len());
        descriptors.push(Descriptor { kind: bytes[1], body: bytes[2..length].to_vec() });
        bytes = &bytes[length..];
    }
    descriptors
}
