//! From a plant, or from a wish, to gains.
