//! A ring of few entries, for what is noted per move.

/// A ring whose oldest entry is first.
#[derive(Clone, Debug)]
pub struct Ring<T, const N: usize> {
    items: [T; N],
    first: usize,
    length: usize,
}

impl<T: Copy, const N: usize> Ring<T, N> {
    /// Creates an empty ring of copies of `empty`.
    pub const fn new(empty: T) -> Self {
        Self { items: [empty; N], first: 0, length: 0 }
    }

    /// Returns an entry, counted from the oldest.
    pub fn get(&self, index: usize) -> Option<T> {
        if index < self.length { self.items.get((self.first + index) % N).copied() } else { None }
    }

    /// Returns an entry, counted from the oldest.
    pub fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index < self.length { self.items.get_mut((self.first + index) % N) } else { None }
    }

    /// Whether there is no entry.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Number of entries.
    pub const fn len(&self) -> usize {
        self.length
    }

    /// Returns the newest entry.
    pub fn last_mut(&mut self) -> Option<&mut T> {
        let last = self.length.checked_sub(1)?;
        self.items.get_mut((self.first + last) % N)
    }

    /// Appends an entry. False if there is no room.
    pub fn push(&mut self, item: T) -> bool {
        if self.length == N {
            return false;
        }
        self.length += 1;
        if let Some(place) = self.last_mut() {
            *place = item;
        }
        true
    }

    /// Drops the oldest entry.
    pub fn drop_first(&mut self) {
        self.first = (self.first + 1) % N;
        self.length = self.length.saturating_sub(1);
    }

    /// Drops the newest entry.
    pub fn drop_last(&mut self) {
        self.length = self.length.saturating_sub(1);
    }

    /// Drops the entries, as nobody reads them any more.
    pub fn clear(&mut self) {
        self.length = 0;
    }
}
