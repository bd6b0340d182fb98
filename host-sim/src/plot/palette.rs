//! Colours that colour-blind readers can distinguish.
//!
//! Okabe and Ito, "Color Universal Design" (2008), ordered by contrast. Their yellow is not legible
//! as a line on white and is replaced by grey.

/// The colours on a white background, as `#rrggbb`. Index 0 is used for the command.
pub const PALETTE: [&str; 8] = [
    "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999",
];

/// The colours on a dark background: the same hues, lighter where the contrast requires it.
pub const PALETTE_DARK: [&str; 8] = [
    "#f0f0f0", "#4aa8e8", "#ff7f2a", "#1fc79a", "#e29ac4", "#f0b429", "#9ad8ff", "#a8a8a8",
];

/// Assigns a colour to each name.
#[derive(Debug, Clone, Default)]
pub struct Colours {
    names: Vec<String>,
}

impl Colours {
    /// The index of the colour of `name`. A new name gets the next index.
    ///
    /// ```
    /// # use host_sim::plot::Colours;
    /// let mut colours = Colours::default();
    /// assert_eq!(colours.of("command"), 0);
    /// assert_eq!(colours.of("grey-box"), 1);
    /// assert_eq!(colours.of("command"), 0);
    /// ```
    pub fn of(&mut self, name: &str) -> usize {
        if let Some(index) = self.names.iter().position(|n| n == name) {
            return index;
        }
        self.names.push(name.to_owned());
        self.names.len() - 1
    }
}

/// The colour of this index on white. Indices beyond the palette wrap around.
pub fn colour(index: usize) -> &'static str {
    PALETTE[index % PALETTE.len()]
}
