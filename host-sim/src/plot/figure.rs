//! The content of a figure, independent of its rendering as SVG or HTML.
//!
//! Points are sorted by x before they are drawn. Points with equal x keep their order and give a
//! vertical line.

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios. Values that are not positive are not drawn.
    Log,
}

/// How the points of a series are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// Straight lines from point to point.
    #[default]
    Line,
    /// The same, dashed.
    Dashed,
    /// Held until the next point (right-continuous), like a command.
    Step,
    /// Dots without lines, for measurements.
    Points,
}

/// One curve. A NaN in `y` is a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The name in the legend.
    pub label: String,
    /// Index into [`super::palette::PALETTE`].
    pub colour: usize,
    /// How the points are joined.
    pub style: Style,
    /// Abscissa of each point, ascending.
    pub x: Vec<f64>,
    /// Ordinate of each point. Values beyond the length of `x` are not drawn.
    pub y: Vec<f64>,
}

impl Series {
    /// Creates a solid curve through these points.
    ///
    /// ```
    /// # use host_sim::plot::Series;
    /// assert_eq!(Series::new("angle", 1, &[0.0, 1.0], &[0.0, 30.0]).y[1], 30.0);
    /// ```
    pub fn new(label: impl Into<String>, colour: usize, x: &[f64], y: &[f64]) -> Self {
        Self {
            label: label.into(),
            colour,
            style: Style::Line,
            x: x.to_vec(),
            y: y.to_vec(),
        }
    }

    /// Sets the style.
    pub fn style(mut self, style: Style) -> Self {
        self.style = style;
        self
    }
}

/// One pair of axes. The panels of a figure are stacked vertically and share the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The quantity and, in brackets, its unit.
    pub y_label: String,
    /// Distance of the ticks, if it is not a round decimal number: 45 for a phase.
    pub y_step: Option<f64>,
    /// The curves; later ones are drawn on top.
    pub series: Vec<Series>,
}

impl Panel {
    /// Creates an empty panel.
    ///
    /// ```
    /// # use host_sim::plot::Panel;
    /// assert_eq!(Panel::new("phase (deg)").y_step(45.0).y_step, Some(45.0));
    /// ```
    pub fn new(y_label: impl Into<String>) -> Self {
        Self {
            y_label: y_label.into(),
            y_step: None,
            series: Vec::new(),
        }
    }

    /// Sets the ticks to multiples of `step`.
    pub fn y_step(mut self, step: f64) -> Self {
        self.y_step = Some(step);
        self
    }

    /// Adds a curve on top.
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }
}

/// A figure of one or more panels over a common x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The heading.
    pub title: String,
    /// An explanation. It is not part of the SVG: a paper has its own caption.
    pub caption: String,
    /// Limitations of the figure. They are part of the SVG, so that a copy includes them.
    pub warnings: Vec<String>,
    /// The quantity and, in brackets, its unit.
    pub x_label: String,
    /// The scale of the x axis.
    pub x_scale: Scale,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Whether a page shows it on the screen only.
    pub is_detail: bool,
}

impl Figure {
    /// Creates a figure without panels, with a linear x axis.
    ///
    /// ```
    /// # use host_sim::plot::{Figure, Panel};
    /// let figure = Figure::new("Step", "time (s)").panel(Panel::new("angle (deg)"));
    /// assert_eq!(figure.panels.len(), 1);
    /// ```
    pub fn new(title: impl Into<String>, x_label: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: String::new(),
            warnings: Vec::new(),
            x_label: x_label.into(),
            x_scale: Scale::Linear,
            panels: Vec::new(),
            is_detail: false,
        }
    }

    /// Leaves it out of printed pages.
    pub fn detail(mut self) -> Self {
        self.is_detail = true;
        self
    }

    /// Makes the x axis logarithmic.
    pub fn log_x(mut self) -> Self {
        self.x_scale = Scale::Log;
        self
    }

    /// Sets the caption.
    pub fn caption(mut self, text: impl Into<String>) -> Self {
        self.caption = text.into();
        self
    }

    /// Adds a warning.
    pub fn warning(mut self, text: impl Into<String>) -> Self {
        self.warnings.push(text.into());
        self
    }

    /// Adds a panel below the others.
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }
}
