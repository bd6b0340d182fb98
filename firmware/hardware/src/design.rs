//! The design, and what follows from its parts and nets.

use crate::rows::{
    Chain, Connector, Electrical, Figure, Functions, Limit, Part, Pin, ProcessorPin, Rail,
};

/// Type of the processor's board; its pins are those of the Morpho connectors.
const NUCLEO: &str = "NUCLEO-F429ZI";

/// Supply of the processor and of the parts around it, V.
pub(crate) const LOGIC_V: f64 = 3.3;

/// A net: what its pins have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Net {
    /// `actuator` or `comm`.
    pub board: String,
    /// Name.
    pub name: String,
    /// Designators and pins.
    pub pins: Vec<(String, String)>,
}

/// A pin of a part, with the net that it is on.
#[derive(Debug, Clone, PartialEq)]
pub struct PinOf<'a> {
    /// The part.
    pub part: &'a Part,
    /// The pin.
    pub pin: Pin,
    /// Its net, if it is connected.
    pub net: Option<&'a Net>,
}

/// Voltages of a net, V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lowest in operation.
    pub low_v: f64,
    /// Highest in operation.
    pub high_v: f64,
    /// Highest for a moment.
    pub surge_v: f64,
}

/// The boards. A test changes a field to put an error back.
#[derive(Debug, Clone)]
pub struct Design {
    /// The parts of both boards.
    pub parts: Vec<Part>,
    /// The pins of the parts' types.
    pub pins: Vec<Pin>,
    /// The nets of both boards.
    pub nets: Vec<Net>,
    /// The processor's pins that the programs use.
    pub processor: Vec<ProcessorPin>,
    /// The limits of the program.
    pub limits: Vec<Limit>,
    /// The figures of the data sheets and of the actuator.
    pub figures: Vec<Figure>,
    pub(crate) rails: Vec<Rail>,
    pub(crate) functions: Vec<Functions>,
    pub(crate) connectors: Vec<Connector>,
    pub(crate) chains: Vec<Chain>,
}

impl Design {
    /// The part with this designator.
    #[must_use]
    pub fn part(&self, designator: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.designator == designator)
    }

    /// The part with this designator, to change it.
    pub fn part_mut(&mut self, designator: &str) -> Option<&mut Part> {
        let mut parts = self.parts.iter_mut();
        parts.find(|part| part.designator == designator)
    }

    /// The value of a part; `NaN`, which no check accepts, if it does not exist.
    #[must_use]
    pub fn value(&self, designator: &str) -> f64 {
        let part = self.part(designator);
        part.and_then(|part| part.value).unwrap_or(f64::NAN)
    }

    /// A figure of `figures.csv`; `NaN`, which no check accepts, if it does not exist.
    #[must_use]
    pub fn figure(&self, of: &str, figure: &str) -> f64 {
        let mut figures = self.figures.iter();
        let found = figures.find(|row| row.of == of && row.figure == figure);
        found.map_or(f64::NAN, |row| row.value)
    }

    /// A limit of the program.
    #[must_use]
    pub fn limit(&self, name: &str) -> Option<&Limit> {
        self.limits.iter().find(|limit| limit.name == name)
    }

    /// The nets of a board.
    pub(crate) fn nets_of(&self, board: &str) -> impl Iterator<Item = &Net> {
        self.nets.iter().filter(move |net| net.board == board)
    }

    /// The net of a board.
    pub(crate) fn net(&self, board: &str, name: &str) -> Option<&Net> {
        self.nets_of(board).find(|net| net.name == name)
    }

    /// The net that a part's pin is on.
    #[must_use]
    pub fn net_at(&self, designator: &str, pin: &str) -> Option<&Net> {
        let is_here = |net: &&Net| net.pins.iter().any(|(d, p)| d == designator && p == pin);
        self.nets.iter().find(is_here)
    }

    /// The pins that a part has, connected or not.
    #[must_use]
    pub fn pins_of<'a>(&'a self, part: &'a Part) -> Vec<PinOf<'a>> {
        let pins: Vec<Pin> = if part.kind == NUCLEO {
            self.connectors
                .iter()
                .map(|row| self.nucleo_pin(part, row))
                .collect()
        } else {
            let is_of = |pin: &&Pin| pin.kind == part.kind;
            self.pins.iter().filter(is_of).cloned().collect()
        };
        let on_net = |pin: Pin| PinOf {
            net: self.net_at(&part.designator, &pin.pin),
            part,
            pin,
        };
        pins.into_iter().map(on_net).collect()
    }

    /// The pins on a net. A pin that its part does not have is left out.
    #[must_use]
    pub fn pins_on(&self, net: &Net) -> Vec<PinOf<'_>> {
        let pins = net.pins.iter().filter_map(|(designator, pin)| {
            let part = self.part(designator)?;
            let pins = self.pins_of(part);
            pins.into_iter().find(|found| found.pin.pin == *pin)
        });
        pins.collect()
    }

    /// A pin of a Morpho connector, as the board uses it.
    fn nucleo_pin(&self, part: &Part, row: &Connector) -> Pin {
        let tolerance = self.figure(NUCLEO, "reference_tolerance");
        let used = self
            .processor
            .iter()
            .find(|pin| pin.board == part.board && pin.pin == row.name);
        let (electrical, range) = match (row.name.as_str(), used) {
            ("GND" | "AGND", _) => (Electrical::Ground, None),
            ("E5V", _) if part.rating == "E5V" => (Electrical::Power, Some((4.75, 5.25))),
            ("3V3", _) => {
                let range = (LOGIC_V * (1.0 - tolerance), LOGIC_V * (1.0 + tolerance));
                (Electrical::Supply, Some(range))
            }
            (_, Some(used)) if used.mode == "analog" => (Electrical::AnalogInput, None),
            (_, Some(used)) if used.mode == "open drain" => (Electrical::OpenDrain, None),
            (_, Some(used)) if used.direction == "out" => (Electrical::Output, None),
            (_, Some(_)) => {
                let high = self.figure("STM32F429ZI", "input_high_share");
                let range = (LOGIC_V * (1.0 - high), LOGIC_V * high);
                (Electrical::Input, Some(range))
            }
            _ => (Electrical::Open, None),
        };
        Pin {
            kind: part.kind.clone(),
            pin: row.morpho.clone(),
            name: row.name.clone(),
            electrical,
            min_v: range.map(|range| range.0),
            max_v: range.map(|range| range.1),
            absolute_v: None,
            tie: String::new(),
        }
    }

    /// The voltages of a net, if it is a supply or has its own range.
    #[must_use]
    pub fn range(&self, board: &str, name: &str) -> Option<Range> {
        let mut rails = self.rails.iter();
        if let Some(rail) = rails.find(|rail| rail.board == board && rail.net == name) {
            return Some(Range {
                low_v: self.level(&rail.low_v),
                high_v: self.level(&rail.high_v),
                surge_v: self.level(&rail.surge_v),
            });
        }
        let pins = self.pins_on(self.net(board, name)?);
        let supply = pins
            .iter()
            .find(|pin| pin.pin.electrical == Electrical::Supply)?;
        let (low_v, high_v) = (supply.pin.min_v?, supply.pin.max_v?);
        Some(Range {
            low_v,
            high_v,
            surge_v: high_v,
        })
    }

    /// A voltage of `rails.csv`. The limits of the program hold for what it measures: the supply is
    /// lower or higher by the error of the measurement.
    fn level(&self, text: &str) -> f64 {
        let default_v = |name: &str| {
            let limit = self.limit(name);
            limit.map_or(f64::NAN, |limit| limit.default as f64 / 1000.0)
        };
        let error = self.supply_error();
        match text {
            "under_voltage" => default_v("under_voltage_mv") * (1.0 - error),
            "over_voltage" => default_v("over_voltage_mv") * (1.0 + error),
            "clamp" => {
                let clamp = self.part("D1").map_or("", |part| part.kind.as_str());
                let [breakdown_v, rated_v, rated_a] =
                    ["breakdown_max", "clamp", "clamp_current"].map(|f| self.figure(clamp, f));
                let share = self.figure("battery", "surge_current") / rated_a;
                breakdown_v + (rated_v - breakdown_v) * share
            }
            number => number.parse().unwrap_or(f64::NAN),
        }
    }

    /// The other ends of the two-terminal parts of a type on a net: the part, and the net there.
    pub(crate) fn across<'a>(
        &'a self,
        net: &'a Net,
        kind: &'a str,
    ) -> impl Iterator<Item = (&'a Part, &'a Net)> {
        net.pins.iter().filter_map(move |(designator, pin)| {
            let part = self.part(designator).filter(|part| part.kind == kind)?;
            let other = if pin == "1" { "2" } else { "1" };
            Some((part, self.net_at(designator, other)?))
        })
    }
}
