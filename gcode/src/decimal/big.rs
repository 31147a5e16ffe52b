//! Natural numbers as long as reading a decimal text takes: 10^1094, and the bits of a quotient more.

const LIMBS: usize = 120;

/// A natural number.
pub(super) struct Big {
    /// The least first.
    limbs: [u32; LIMBS],
    /// Limbs in use: those behind are zero, the last of them is not.
    length: usize,
}

impl From<u32> for Big {
    fn from(value: u32) -> Self {
        let mut big = Self { limbs: [0; LIMBS], length: 0 };
        big.scale(1, value);
        big
    }
}

impl Big {
    /// Multiplies by a factor and adds. One loop for all who call it, as it is to be small.
    #[inline(never)]
    pub(super) fn scale(&mut self, factor: u32, add: u32) {
        let mut carry = u64::from(add);
        for limb in self.limbs.iter_mut().take(self.length) {
            carry += u64::from(*limb) * u64::from(factor);
            *limb = carry as u32;
            carry >>= 32;
        }
        if carry > 0
            && let Some(limb) = self.limbs.get_mut(self.length)
        {
            *limb = carry as u32;
            self.length += 1;
        }
    }

    /// Multiplies by a power of two.
    #[inline(never)]
    pub(super) fn shift(&mut self, mut bits: u32) {
        while bits > 0 {
            let step = bits.min(31);
            self.scale(1 << step, 0);
            bits -= step;
        }
    }

    fn halve(&mut self) {
        let mut carry = 0;
        for limb in self.limbs.iter_mut().take(self.length).rev() {
            let whole = *limb;
            *limb = whole >> 1 | carry << 31;
            carry = whole & 1;
        }
        self.trim();
    }

    fn trim(&mut self) {
        while self.length > 0 && self.limbs.get(self.length - 1) == Some(&0) {
            self.length -= 1;
        }
    }

    pub(super) fn is_zero(&self) -> bool {
        self.length == 0
    }

    /// Bits without leading zeros.
    pub(super) fn bits(&self) -> i32 {
        let last = self.length.checked_sub(1).and_then(|last| self.limbs.get(last));
        last.map_or(0, |last| (self.length * 32) as i32 - last.leading_zeros() as i32)
    }

    /// Whether it is at least another number. If so, that is subtracted.
    fn take(&mut self, other: &Self) -> bool {
        let (ours, theirs) = (self.limbs.iter().rev(), other.limbs.iter().rev());
        if self.length < other.length || self.length == other.length && ours.lt(theirs) {
            return false;
        }
        let mut borrow = 0;
        for (limb, other) in self.limbs.iter_mut().zip(&other.limbs).take(self.length) {
            let difference = i64::from(*limb) - i64::from(*other) - borrow;
            *limb = difference as u32;
            borrow = i64::from(difference < 0);
        }
        self.trim();
        true
    }

    /// Divides; the quotient has at most so many bits. The rest stays.
    pub(super) fn divide(&mut self, divisor: &mut Self, bits: u32) -> u64 {
        divisor.shift(bits);
        let mut quotient = 0;
        for _ in 0..bits {
            divisor.halve();
            quotient = quotient << 1 | u64::from(self.take(divisor));
        }
        quotient
    }
}
