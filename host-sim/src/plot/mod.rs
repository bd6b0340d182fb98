//! Figures: SVG for papers, self-contained interactive HTML for the desk.
