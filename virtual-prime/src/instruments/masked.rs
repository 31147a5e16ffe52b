//! Windows of masked interrupts: from the instruction that sets PRIMASK to the instruction that clears or
//! restores it.

use crate::image::Mask;

/// A window of masked interrupts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Start of the window, nanoseconds since power-on.
    pub at_ns: u64,
    /// Address of the instruction that began the window.
    pub address: u64,
    /// Instructions executed while interrupts were masked, including the instruction that unmasked them.
    pub instructions: u64,
}

/// Windows of masked interrupts in a run.
///
/// A section within a section puts back a PRIMASK that is set already, so sections are counted in and out.
#[derive(Clone, Debug, Default)]
pub struct Masking {
    depth: u32,
    open: Option<(u64, u64, u64)>,
    /// Windows that have ended, in order.
    pub windows: Vec<Window>,
}

impl Masking {
    pub(super) fn meet(&mut self, mask: Mask, address: u64, at_ns: u64, count: u64) {
        match mask {
            Mask::Set => {
                self.depth += 1;
                self.open.get_or_insert((address, at_ns, count));
                return;
            }
            Mask::Clear => self.depth = 0,
            Mask::PutBack => self.depth = self.depth.saturating_sub(1),
        }
        if self.depth == 0
            && let Some((address, at_ns, began)) = self.open.take()
        {
            self.windows.push(Window { at_ns, address, instructions: count - began });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(met: &[(Mask, u64)]) -> Vec<u64> {
        let mut masking = Masking::default();
        for &(mask, count) in met {
            masking.meet(mask, 0x0800_0000, count, count);
        }
        masking.windows.iter().map(|window| window.instructions).collect()
    }

    #[test]
    fn a_window_ends_where_the_outer_section_does() {
        assert_eq!(lengths(&[(Mask::Set, 10), (Mask::PutBack, 15)]), [5]);
        let nested = [(Mask::Set, 10), (Mask::Set, 12), (Mask::PutBack, 14), (Mask::PutBack, 20), (Mask::Clear, 30)];
        assert_eq!(lengths(&nested), [10]);
        assert_eq!(lengths(&[(Mask::Set, 1), (Mask::Set, 2), (Mask::Clear, 9), (Mask::PutBack, 11)]), [8]);
        assert!(lengths(&[(Mask::PutBack, 3), (Mask::Set, 4)]).is_empty());
    }
}
