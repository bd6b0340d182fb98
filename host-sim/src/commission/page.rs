//! The page of a commissioning: what was measured, each value with its standard error and its step,
//! what is written, and the loop as predicted and as measured.

use super::tuning::{Line, Proposal};
use super::{EncoderError, Findings, Friction};
use crate::page::{Block, Page, Section};
use crate::plot::{Figure, Panel, Series, Style};

const INTRODUCTION: &str = "Standard errors have the residuals of the measurement, and what the \
    residuals do not show: gains of the measurements, eccentricity of the magnet, temperature of \
    the winding. Values are at the output of the gears but for the torque constant, which is that \
    of the motor by the gear ratio 2011h:3.";

const CONSTANT: &str = "The back-EMF of runs at constant rate is proportional to the rate; the slope \
    is the torque constant. Residuals that grow with the rate in one direction show an eccentric \
    magnet, an offset shows dividers that differ.";

const FRICTION: &str = "The torque of the runs, less that which accelerates the inertia, and Coulomb \
    and viscous friction in each direction.";

const EXCITATIONS: &str = "The chirp gives inertia and delay. The motor that it gives predicts the \
    multisine, of which only the first angle and a constant load are fitted.";

const LOOP: &str = "A multisine in the closed loop, with the gains in force. Margins are those of \
    the identified motor (predicted), the least ones of all motors within three standard errors, \
    and those of the motor as the sweep shows it.";

const ENCODER: &str = "The angle by the encoder less that by the integral of the back-EMF, in means \
    over 5 deg of the turn, and the error once and twice a turn, which object 2014h corrects.";

/// Makes the page; `origin` is how it was made, and `is_written` whether the values are saved.
pub fn page(findings: &Findings, origin: &str, is_written: bool) -> Page {
    let mut sections = vec![
        at_a_glance(findings, origin, is_written),
        constant(findings),
        friction(findings),
        excitations(findings),
    ];
    sections.extend((!findings.encoder.points.is_empty()).then(|| encoder(&findings.encoder)));
    sections.extend(findings.proposal().map(closed_loop));
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
    blocks.push(findings.measured().into());
    blocks.extend(findings.of_health().map(Block::from));
    blocks.extend([
        findings.stored(is_written).into(),
        findings.of_motion().into(),
    ]);
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

/// Current of the runs over rate, and what the lines of both directions make of it.
fn friction(findings: &Findings) -> Section {
    let mut runs = findings.constant_rates.clone();
    runs.sort_by(|a, b| a.rate_rad_s.total_cmp(&b.rate_rad_s));
    let constant = findings.back_emf_v_s.value;
    let inertia_kg_m2 = findings.dynamics.inertia_kg_m2.value;
    let mut panel = Panel::new("torque (mN m)");
    let Friction { upward, downward } = findings.friction;
    for (name, direction, sign) in [("upward", upward, 1.0), ("downward", downward, -1.0)] {
        let runs = runs.iter().filter(|run| run.rate_rad_s * sign > 0.0);
        let (rates, torques): (Vec<_>, Vec<_>) = runs
            .map(|run| {
                let accelerating_nm = inertia_kg_m2 * run.back_emf_change_v_s / constant;
                let torque_nm = constant * run.current_a - accelerating_nm;
                (run.rate_rad_s, 1e3 * torque_nm)
            })
            .unzip();
        let line = rates.iter().map(|rate| {
            let viscous_nm = direction.viscous_nm_s.value * rate;
            1e3 * (sign * direction.coulomb_nm.value + viscous_nm)
        });
        let line: Vec<f64> = line.collect();
        let rates: Vec<f64> = rates.iter().map(|rate| rate.to_degrees()).collect();
        panel = panel
            .series(Series::new(format!("friction {name}"), 2, &rates, &line))
            .series(Series::new("runs", 1, &rates, &torques).style(Style::Points));
    }
    let figure = Figure::new("Torque of the runs", "rate (deg/s)").panel(panel);
    Section::new("Friction", [FRICTION.into(), figure.into()])
}

/// The excitations against the model.
fn excitations(findings: &Findings) -> Section {
    let dynamics = &findings.dynamics;
    let identification = dynamics.identification.figure("Chirp, against its fit");
    let validation = (dynamics.validation).figure("Multisine, against the motor of the chirp");
    let blocks = [EXCITATIONS.into(), identification.into(), validation.into()];
    Section::new("Inertia and delay", blocks)
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
    let [margins, motions] = proposal.tables();
    let mut blocks = vec![
        LOOP.into(),
        margins.into(),
        bode(&proposal.lines).into(),
        motions.into(),
    ];
    for (title, motion) in [
        ("Step, against the prediction", &proposal.step),
        (
            "Moves with feed-forward, against the prediction",
            &proposal.moves,
        ),
    ] {
        let figure = motion.iter().map(|motion| motion.comparison.figure(title));
        blocks.extend(figure.map(Block::from));
    }
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
