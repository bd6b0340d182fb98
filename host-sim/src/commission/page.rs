//! The page of a commissioning: what was measured, each value with its standard error and its step,
//! what is written, and the loop as predicted and as measured.

use super::centre::ORIGIN;
use super::tuning::{Line, Proposal};
use super::{EncoderError, Estimate, Findings, Harmonics};
use crate::can::names;
use crate::page::{Block, Page, Section};
use crate::plot::{Figure, Panel, Series, Style};
use crate::table::{Cell, Table};

const INTRODUCTION: &str = "Standard errors have the residuals of the measurement, and what the \
    residuals do not show: gains of the measurements, eccentricity of the magnet, temperature of \
    the winding. Values are at the output of the gears but for the torque constant, which is that \
    of the motor by the gear ratio 2011h:3.";

const CONSTANT: &str = "The back-EMF of runs at constant rate is proportional to the rate; the slope \
    is the torque constant. Residuals that grow with the rate in one direction show an eccentric \
    magnet, an offset shows dividers that differ.";

const LOOP: &str = "A multisine in the closed loop, with the gains in force. Margins are those of \
    the identified motor (predicted), the least ones of all motors within three standard errors, \
    and those of the motor as the sweep shows it.";

/// Names of the parts of the encoder's error.
const ENCODER_NAMES: [&str; 4] = [
    "encoder once a turn, cosine",
    "encoder once a turn, sine",
    "encoder twice a turn, cosine",
    "encoder twice a turn, sine",
];

const ENCODER: &str = "The angle by the encoder less that by the integral of the back-EMF, in means \
    over 5 deg of the turn, and the error once and twice a turn, which object 2014h corrects.";

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
        let harmonics = self.encoder.harmonics.iter().flat_map(Harmonics::all);
        let harmonics = ENCODER_NAMES.into_iter().zip(harmonics);
        let of_turn = "runs over a turn";
        estimates.extend(harmonics.map(|(name, harmonic)| (name, "deg", of_turn, harmonic)));
        estimates
    }

    /// What is not written, and why.
    fn doubts(&self) -> Vec<String> {
        let contradictions = &self.dynamics.contradictions;
        let texts = contradictions
            .iter()
            .map(|it| format!("Contradiction: {}.", it.text));
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
}

/// Makes the page; `origin` is how it was made, and `is_written` whether the values are saved.
pub fn page(findings: &Findings, origin: &str, is_written: bool) -> Page {
    let mut sections = vec![
        at_a_glance(findings, origin, is_written),
        constant(findings),
    ];
    sections.extend((!findings.encoder.points.is_empty()).then(|| encoder(&findings.encoder)));
    let proposal = findings.tuning.as_ref().and_then(|it| it.proposal.as_ref());
    sections.extend(proposal.map(closed_loop));
    Page {
        title: "Commissioning",
        introduction: INTRODUCTION,
        sections,
        parameters: Vec::new(),
    }
}

fn at_a_glance(findings: &Findings, origin: &str, is_written: bool) -> Section {
    let mut blocks = vec![origin.into()];
    let warning = |text| Block::Warning(String::new(), text);
    blocks.extend(findings.doubts().into_iter().map(warning));
    let columns = [
        ("quantity", ""),
        ("unit", ""),
        ("value", ""),
        ("standard error", ""),
        ("share", "%"),
        ("measured by", ""),
    ];
    let mut measured = Table::new("Measured", &columns);
    for (name, unit, step, estimate) in findings.estimates() {
        measured.push([
            name.into(),
            unit.into(),
            Cell::significant(estimate.value),
            Cell::significant(estimate.standard_error),
            Cell::Number(100.0 * estimate.relative(), 1),
            step.into(),
        ]);
    }
    let caption = match is_written {
        true => "Written and saved",
        false => "To be written",
    };
    let mut objects = Table::new(caption, &[("object", ""), ("name", ""), ("value", "")]);
    let mut row = |object: &str, value| {
        let name = names::find(object).map(names::name).unwrap_or_default();
        objects.push([object.into(), name.into(), value]);
    };
    let (low, high) = findings.range_mdeg;
    let origin = findings.origin_mdeg.map(|origin| (ORIGIN, origin));
    for (object, mdeg) in [("607D:1", low), ("607D:2", high)]
        .into_iter()
        .chain(origin)
    {
        row(object, Cell::Number(mdeg.into(), 0));
    }
    for (object, value) in findings.objects() {
        row(object, Cell::significant(value));
    }
    let mut limits = Table::new("During the motion", &[("quantity", ""), ("value", "")]);
    for (name, value, decimals) in [
        ("lowest supply, V", findings.least_supply_v, 2),
        (
            "highest temperature of the board, deg C",
            findings.temperature_deg_c,
            1,
        ),
        ("backlash, deg", findings.dynamics.backlash_deg, 3),
    ] {
        limits.push([name.into(), Cell::Number(value, decimals)]);
    }
    blocks.extend([measured.into(), objects.into(), limits.into()]);
    Section::new("At a glance", blocks)
}

/// Back-EMF over rate, and what the line leaves.
fn constant(findings: &Findings) -> Section {
    let mut runs = findings.constant_rates.clone();
    runs.sort_by(|a, b| a.rate_rad_s.total_cmp(&b.rate_rad_s));
    let rates: Vec<f64> = runs.iter().map(|run| run.rate_rad_s.to_degrees()).collect();
    let voltages: Vec<f64> = runs.iter().map(|run| run.back_emf_v).collect();
    let per_rad_s = findings.back_emf_v_s.value;
    let line: Vec<f64> = runs.iter().map(|run| run.rate_rad_s * per_rad_s).collect();
    let residuals_mv = voltages.iter().zip(&line).map(|(v, line)| (v - line) * 1e3);
    let residuals_mv: Vec<f64> = residuals_mv.collect();
    let panel = Panel::new("back-EMF (V)")
        .series(Series::new("torque constant", 2, &rates, &line))
        .series(Series::new("runs", 1, &rates, &voltages).style(Style::Points));
    let residuals = Panel::new("residual (mV)")
        .series(Series::new("residual", 1, &rates, &residuals_mv).style(Style::Points));
    let figure = Figure::new("Back-EMF of the runs", "rate (deg/s)")
        .panel(panel)
        .panel(residuals);
    Section::new("Torque constant", [CONSTANT.into(), figure.into()])
}

/// The error of the encoder over the turn.
fn encoder(error: &EncoderError) -> Section {
    let (at, measured): (Vec<_>, Vec<_>) = error
        .points
        .iter()
        .map(|point| (point.angle_deg, point.error_deg))
        .unzip();
    let fitted: Vec<f64> = at.iter().map(|at| error.at_deg(*at)).collect();
    let panel = Panel::new("error (deg)")
        .series(Series::new("once and twice a turn", 2, &at, &fitted))
        .series(Series::new("measured", 1, &at, &measured).style(Style::Points));
    let figure = Figure::new("Error of the encoder", "angle (deg)").panel(panel);
    Section::new("Encoder", [ENCODER.into(), figure.into()])
}

fn closed_loop(proposal: &Proposal) -> Section {
    let columns = [
        ("margins", ""),
        ("phase", "deg"),
        ("gain", "dB"),
        ("crossing", "Hz"),
    ];
    let mut margins = Table::new("Margins", &columns);
    for (name, of) in proposal.margins() {
        margins.push([
            name.into(),
            Cell::optional(of.map(|margins| margins.phase_deg), 1),
            Cell::optional(of.map(|margins| margins.gain_db), 1),
            Cell::optional(of.map(|margins| margins.crossing_hz), 2),
        ]);
    }
    let blocks = [LOOP.into(), margins.into(), bode(&proposal.lines).into()];
    Section::new("Closed loop", blocks)
}

/// The lines of the sweep, measured and predicted.
fn bode(lines: &[Line]) -> Figure {
    let at: Vec<f64> = lines.iter().map(|line| line.frequency_hz).collect();
    let panel = |label: &str, values: fn(&Line) -> [f64; 2]| {
        let of = |index: usize| {
            lines
                .iter()
                .map(|line| values(line)[index])
                .collect::<Vec<_>>()
        };
        Panel::new(label)
            .series(Series::new("predicted", 2, &at, &of(1)))
            .series(Series::new("measured", 1, &at, &of(0)).style(Style::Points))
    };
    let phase = panel("phase (deg)", |line| line.phase_deg).y_step(45.0);
    Figure::new("From command to angle", "frequency (Hz)")
        .log_x()
        .panel(panel("gain (dB)", |line| line.gain_db))
        .panel(phase)
}
