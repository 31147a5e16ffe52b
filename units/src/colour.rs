//! Colours of lights, and the order in which the chips of a strip take them.

/// Brightness of each part of a light, 0 to 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Colour {
    /// Brightness of red light.
    pub red: u8,
    /// Brightness of green light.
    pub green: u8,
    /// Brightness of blue light.
    pub blue: u8,
    /// Brightness of white light, if the chip has it.
    pub white: u8,
}

impl Colour {
    /// Colour of a light that is off.
    pub const BLACK: Self = Self::rgb(0, 0, 0);

    /// Creates a colour without white.
    #[must_use]
    pub const fn rgb(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue, white: 0 }
    }

    /// Returns red, green, blue and white.
    #[must_use]
    pub const fn parts(self) -> [u8; 4] {
        [self.red, self.green, self.blue, self.white]
    }

    /// Creates a colour from red, green, blue and white.
    #[must_use]
    pub const fn from_parts([red, green, blue, white]: [u8; 4]) -> Self {
        Self { red, green, blue, white }
    }

    /// Returns the colour at a share of its brightness, 0 to 1; to the nearest step.
    #[must_use]
    pub fn dimmed(self, share: f32) -> Self {
        let share = crate::within(share, 0.0, 1.0);
        Self::from_parts(self.parts().map(|part| (f32::from(part) * share + 0.5) as u8))
    }
}

/// The order in which a chip takes the parts of its colour: `GRB`, `RGBW`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColourOrder {
    /// Places of the parts in [`Colour::parts`], in the order of sending.
    places: [u8; 4],
    count: u8,
}

/// Letters of the [`Colour::parts`].
const LETTERS: &[u8; 4] = b"RGBW";

impl Default for ColourOrder {
    fn default() -> Self {
        Self::GRB
    }
}

impl ColourOrder {
    /// Order of a WS2812.
    pub const GRB: Self = Self { places: [1, 0, 2, 3], count: 3 };

    /// Parses red, green and blue in any order, with or without white; `None` for anything else.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        if !matches!(bytes.len(), 3 | 4) {
            return None;
        }
        let mut order = Self { places: [0, 1, 2, 3], count: bytes.len() as u8 };
        let mut seen = 0_u8;
        for (slot, letter) in order.places.iter_mut().zip(bytes) {
            let place = LETTERS.iter().position(|known| *known == letter.to_ascii_uppercase())?;
            *slot = place as u8;
            seen |= 1 << place;
        }
        // No letter is missing, so none is there twice.
        (seen == if bytes.len() == 4 { 0b1111 } else { 0b111 }).then_some(order)
    }

    /// Returns the number of bytes that a light takes: 3, or 4 with white.
    #[must_use]
    pub const fn bytes_each(self) -> usize {
        self.count as usize
    }

    /// Returns the bytes of a colour, in the order of sending.
    pub fn bytes(self, colour: Colour) -> impl Iterator<Item = u8> {
        let parts = colour.parts();
        self.places.into_iter().take(self.bytes_each()).map(move |place| parts[usize::from(place & 3)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_each_colour_once_and_white_at_most_once() {
        let colour = Colour { red: 1, green: 2, blue: 3, white: 4 };
        for (text, sent) in
            [("GRB", &[2, 1, 3][..]), ("rgb", &[1, 2, 3]), ("GRBW", &[2, 1, 3, 4]), ("WBGR", &[4, 3, 2, 1])]
        {
            let order = ColourOrder::parse(text).expect(text);
            assert!(order.bytes(colour).eq(sent.iter().copied()), "{text}");
            assert_eq!(order.bytes_each(), sent.len());
        }
        for text in ["", "RG", "RGG", "RGW", "RGBB", "RGBWW", "RGX", "äö"] {
            assert_eq!(ColourOrder::parse(text), None, "{text}");
        }
        assert_eq!(ColourOrder::parse("GRB"), Some(ColourOrder::GRB));
    }

    #[test]
    fn dimming_rounds_and_never_brightens() {
        let colour = Colour { red: 255, green: 1, blue: 100, white: 3 };
        assert_eq!(colour.dimmed(1.0), colour);
        assert_eq!(colour.dimmed(0.5), Colour { red: 128, green: 1, blue: 50, white: 2 });
        assert_eq!([colour.dimmed(-1.0), colour.dimmed(9.0)], [Colour::BLACK, colour]);
    }
}
