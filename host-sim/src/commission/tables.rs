//! The findings as tables, which a page and a terminal show alike.

use super::baseline::Baseline;
use super::tuning::Proposal;
use super::{Estimate, Findings, Harmonics};
use crate::can::names;
use crate::table::{Cell, Table};

/// Names of the parts of the encoder's error.
const ENCODER_NAMES: [&str; 4] = [
    "encoder once a turn, cosine",
    "encoder once a turn, sine",
    "encoder twice a turn, cosine",
    "encoder twice a turn, sine",
];

impl Findings {
    /// Each measured quantity with its unit, the step that measures it, and its value.
    pub fn estimates(&self) -> Vec<(&'static str, &'static str, &'static str, Estimate)> {
        let (upward, downward) = (&self.friction.upward, &self.friction.downward);
        let dynamics = &self.dynamics;
        let runs = "runs at constant rate";
        let mut estimates = vec![
            ("resistance", "ohm", "pulses", self.resistance_ohm),
            ("torque constant", "Nm/A", runs, self.torque_constant_nm_a),
            ("friction upward", "Nm", runs, upward.coulomb_nm),
            ("friction downward", "Nm", runs, downward.coulomb_nm),
            ("viscous upward", "Nm s/rad", runs, upward.viscous_nm_s),
            ("viscous downward", "Nm s/rad", runs, downward.viscous_nm_s),
            ("inertia", "kg m^2", "chirp", dynamics.inertia_kg_m2),
            ("delay", "s", "chirp", dynamics.delay_s),
        ];
        let backlash = dynamics.backlash_deg.iter();
        estimates.extend(backlash.map(|it| ("backlash", "deg", "chirp and multisine", *it)));
        let harmonics = self.encoder.harmonics.iter().flat_map(Harmonics::all);
        let harmonics = ENCODER_NAMES.into_iter().zip(harmonics);
        let of_turn = "runs over a turn";
        estimates.extend(harmonics.map(|(name, harmonic)| (name, "deg", of_turn, harmonic)));
        estimates
    }

    /// What is not written, and why.
    pub fn doubts(&self) -> Vec<String> {
        let contradictions = &self.dynamics.contradictions;
        let texts = contradictions.iter().map(|it| {
            format!(
                "Contradicted by a second measurement, and not written: {}.",
                it.text
            )
        });
        let mut doubts: Vec<String> = texts.collect();
        if let Some(tuning) = &self.tuning {
            let gains = tuning.disagreements.iter();
            doubts.extend(gains.map(|why| format!("Gains are not written: {why}.")));
            let forward = tuning.without_forward.iter();
            doubts.extend(forward.map(|why| format!("Feed-forward is not written: {why}.")));
        }
        let encoder = self.encoder.without_error.iter();
        doubts
            .extend(encoder.map(|why| format!("The error of the encoder is not written: {why}.")));
        let baseline = self.baseline.iter();
        let without = baseline.filter_map(|baseline| baseline.without_baseline.as_ref());
        doubts.extend(without.map(|why| format!("The baseline is not written: {why}.")));
        doubts
    }

    /// The gains that are proposed, if any are.
    pub(super) fn proposal(&self) -> Option<&Proposal> {
        self.tuning.as_ref()?.proposal.as_ref()
    }

    /// All that was found, and the objects in which it is stored; `is_written` says whether they
    /// are saved.
    pub fn tables(&self, is_written: bool) -> Vec<Table> {
        let mut tables = vec![self.measured()];
        tables.extend(self.proposal().map(Proposal::tables).into_iter().flatten());
        tables.extend(self.of_health());
        tables.extend([self.of_motion(), self.stored(is_written)]);
        tables
    }

    /// What was measured.
    pub(super) fn measured(&self) -> Table {
        let columns = [
            ("quantity", ""),
            ("unit", ""),
            ("value", ""),
            ("standard error", ""),
            ("relative error", "%"),
            ("measured by", ""),
        ];
        let mut measured = Table::new("Measured", &columns);
        for (name, unit, step, estimate) in self.estimates() {
            measured.push([
                name.into(),
                unit.into(),
                Cell::significant(estimate.value),
                Cell::significant(estimate.standard_error),
                Cell::Number(100.0 * estimate.relative(), 1),
                step.into(),
            ]);
        }
        measured
    }

    /// The baseline, if the moves give one.
    pub(super) fn of_health(&self) -> Option<Table> {
        let baseline = self.baseline.as_ref()?;
        let is_known = baseline.without_baseline.is_none();
        is_known.then(|| baseline.table())
    }

    /// What was observed during the motion.
    pub(super) fn of_motion(&self) -> Table {
        let mut table = Table::new("During the motion", &[("quantity", ""), ("value", "")]);
        for (name, value, decimals) in [
            ("lowest supply, V", self.least_supply_v, 2),
            (
                "highest temperature of the board, deg C",
                self.temperature_deg_c,
                1,
            ),
        ] {
            table.push([name.into(), Cell::Number(value, decimals)]);
        }
        table
    }

    /// The objects that are stored.
    pub(super) fn stored(&self, is_written: bool) -> Table {
        let caption = match is_written {
            true => "Written and saved",
            false => "Not written",
        };
        let mut objects = Table::new(caption, &[("object", ""), ("name", ""), ("value", "")]);
        let mut row = |object: &str, value| {
            let name = names::find(object).map(names::name).unwrap_or_default();
            objects.push([object.into(), name.into(), value]);
        };
        for (object, mdeg) in self.positions() {
            row(object, Cell::Number(mdeg.into(), 0));
        }
        for (object, value) in self.objects() {
            let cell = match value.fract() {
                0.0 => Cell::Number(value, 0),
                _ => Cell::significant(value),
            };
            row(object, cell);
        }
        objects
    }
}

impl Proposal {
    /// The margins, and the motions against the model.
    pub(super) fn tables(&self) -> [Table; 2] {
        let columns = [
            ("margins", ""),
            ("phase", "deg"),
            ("gain", "dB"),
            ("crossing", "Hz"),
        ];
        let mut margins = Table::new("Margins", &columns);
        for (name, of) in self.margins() {
            margins.push([
                name.into(),
                Cell::optional(of.map(|margins| margins.phase_deg), 1),
                Cell::optional(of.map(|margins| margins.gain_db), 1),
                Cell::optional(of.map(|margins| margins.crossing_hz), 2),
            ]);
        }
        let columns = [
            ("motion", ""),
            ("rms difference", "deg"),
            ("expected below", "deg"),
        ];
        let mut motions = Table::new("Motions against the model", &columns);
        for (name, motion) in [("step", &self.step), ("with feed-forward", &self.moves)] {
            motions.push([
                name.into(),
                Cell::optional(motion.as_ref().map(|motion| motion.difference_deg), 3),
                Cell::optional(motion.as_ref().map(|motion| motion.limit_deg), 3),
            ]);
        }
        [margins, motions]
    }
}

impl Baseline {
    /// The means; those that the moves do not show have no value.
    fn table(&self) -> Table {
        let columns = [
            ("mean", ""),
            ("unit", ""),
            ("value", ""),
            ("standard error", ""),
        ];
        let mut table = Table::new("Baseline of the health", &columns);
        let [friction, constant, supply, play] = self.standard_errors;
        let shown = |value: i64| Cell::optional((value > 0).then_some(value as f64), 0);
        for (name, unit, value, error) in [
            (
                "friction",
                "mA",
                Cell::Number(self.friction_ma, 1),
                Cell::optional(friction, 1),
            ),
            (
                "constant of the back-EMF",
                "mV s/deg",
                Cell::Number(self.constant_v_s_deg * 1e3, 3),
                Cell::optional(constant.map(|error| error * 1e3), 3),
            ),
            (
                "load",
                "mA",
                Cell::Number(self.load_ma, 1),
                Cell::optional(friction, 1),
            ),
            (
                "supply resistance",
                "mohm",
                shown(self.supply_mohm),
                Cell::optional(supply, 0),
            ),
            (
                "play",
                "mdeg",
                shown(self.play_mdeg),
                Cell::optional(play, 0),
            ),
        ] {
            table.push([name.into(), unit.into(), value, error]);
        }
        table
    }
}
