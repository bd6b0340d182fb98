//! The paper's figures 9 to 13 with the data of this study.

use host_sim::{
    analysis::{
        frequency::{Response, logarithmic_grid},
        linear_models::{black_box_1, black_box_2},
    },
    plot::{Figure, Panel, Series, Style},
};
use identification::frequency::FrequencyResponse;

use crate::{
    Failure,
    host::seconds,
    models::MODELS,
    runs::{CHIRP_END_HZ, CONDITIONS, Run, SampleRate},
    study::Study,
    test_bench::BLACK_BOX_2,
    trace_measures::Traces,
};

/// Black box 1 of the paper, rad/s.
pub const BLACK_BOX_1: f64 = 30.0;
/// Colours of the runs (grey) and of the models.
const RUN_COLOUR: usize = 7;
const COLOURS: [usize; 3] = [1, 2, 3];

/// The paper's number of the figure of each model on the pulse.
pub const PULSE_FIGURES: [u32; 3] = [9, 10, 12];

/// File of a figure, relative to the page.
pub fn file(number: u32, condition: usize) -> String {
    let (controller, load) = CONDITIONS[condition];
    format!("figure-{number}-{}-{}.svg", controller.name(), load.name())
}

/// All figures for which there are runs, with their files.
///
/// # Errors
/// Those of the simulator.
pub fn all(study: &Study) -> Result<Vec<(String, Figure)>, Failure> {
    let mut figures = Vec::new();
    for condition in 0..CONDITIONS.len() {
        if let Some(traces) = Traces::of(study, condition, "pulse")? {
            for (model, number) in PULSE_FIGURES.into_iter().enumerate() {
                let title = format!("{}: {} on the pulse", called(condition), MODELS[model]);
                let figure = time_figure(&title, &traces, &[model]);
                figures.push((file(number, condition), figure));
            }
        }
        if let Some(traces) = Traces::of(study, condition, "variable-step")? {
            let title = format!("{}: all models on the variable step", called(condition));
            figures.push((
                file(13, condition),
                time_figure(&title, &traces, &[0, 1, 2]),
            ));
        }
        if let Some(figure) = bode(study, condition) {
            figures.push((file(11, condition), figure));
        }
    }
    Ok(figures)
}

/// A condition in words.
pub fn called(condition: usize) -> String {
    let (controller, load) = CONDITIONS[condition];
    format!("{} loop, {}", controller.name(), load.name())
}

/// Every fifth sample, as recorded by the paper's host, which is sufficient for a figure.
fn thin(trace: &[f64]) -> Vec<f64> {
    trace.iter().step_by(5).copied().collect()
}

/// Two panels: models with the paper's numbers, and fitted models; the runs in grey in both.
fn time_figure(title: &str, traces: &Traces, models: &[usize]) -> Figure {
    let t: Vec<f64> = (0..traces.mean_deg.len()).map(seconds).collect();
    let t = thin(&t);
    let series = |label: &str, colour, y: &[f64]| Series::new(label, colour, &t, &thin(y));
    let panel = |label: &str, answers: &[Vec<f64>]| {
        let mut panel = Panel::new(label);
        for run in &traces.runs_deg {
            panel = panel.series(series("five runs", RUN_COLOUR, run));
        }
        panel = panel.series(series("command", 0, &traces.command_deg).style(Style::Step));
        for &model in models {
            panel = panel.series(series(MODELS[model], COLOURS[model], &answers[model]));
        }
        panel
    };
    Figure::new(title, "time (s)")
        .panel(panel("paper's numbers (deg)", &traces.printed_deg))
        .panel(panel("fitted here (deg)", &traces.fitted_deg))
}

/// The black boxes, printed and fitted to the chirp, and the frequency response of the chirp.
fn bode(study: &Study, condition: usize) -> Option<Figure> {
    let runs: Vec<&Run> = study.runs(condition, "chirp");
    let recordings: Vec<_> = runs
        .iter()
        .map(|run| run.recording(SampleRate::Hz250))
        .collect();
    let measured = FrequencyResponse::of(&recordings.iter().collect::<Vec<_>>())?;
    let fit = |model| study.fit(condition, SampleRate::Hz250, "chirp", model);
    let (first, second) = (fit(0)?, fit(1)?);
    let (a, b) = BLACK_BOX_2;
    let fitted_2 = (
        second.value("position_gain_per_s2"),
        second.value("rate_gain_per_s"),
    );
    let systems = [
        (
            "black-box-1, paper",
            1,
            Style::Dashed,
            black_box_1(BLACK_BOX_1),
        ),
        ("black-box-2, paper", 2, Style::Dashed, black_box_2(a, b)),
        (
            "black-box-1, fitted",
            1,
            Style::Line,
            black_box_1(first.value("pole_rad_s")),
        ),
        (
            "black-box-2, fitted",
            2,
            Style::Line,
            black_box_2(fitted_2.0, fitted_2.1),
        ),
    ];
    let grid = logarithmic_grid(0.1, 10.0, 40);
    let (mut gain, mut phase) = (
        Panel::new("gain (dB)"),
        Panel::new("phase (deg)").y_step(45.0),
    );
    // Outside the frequencies of the chirp the response is only noise.
    let band = 0.1..=CHIRP_END_HZ;
    let shown: Vec<usize> = (0..measured.frequency_hz.len())
        .filter(|&i| measured.coherence[i] > 0.8 && band.contains(&measured.frequency_hz[i]))
        .collect();
    let take = |y: &[f64]| shown.iter().map(|&i| y[i]).collect::<Vec<f64>>();
    let f = take(&measured.frequency_hz);
    // The black boxes of the figure have no delay, as in the paper, so it is removed from the data.
    let delay_s = second.value("delay_s");
    let undelayed: Vec<f64> = (shown.iter())
        .map(|&i| measured.phase_deg[i] + 360.0 * measured.frequency_hz[i] * delay_s)
        .collect();
    let points = |y: &[f64]| Series::new("chirp, delay taken out", RUN_COLOUR, &f, y);
    gain = gain.series(points(&take(&measured.gain_db)).style(Style::Points));
    phase = phase.series(points(&undelayed).style(Style::Points));
    for (label, colour, style, system) in &systems {
        let response = Response::of(system, &grid);
        let one = |y: &[f64]| Series::new(*label, *colour, &grid, y).style(*style);
        gain = gain.series(one(&response.gain_db));
        phase = phase.series(one(&response.phase_deg));
    }
    let title = format!("{}: Bode plot of the black boxes", called(condition));
    let figure = Figure::new(title, "frequency (Hz)").log_x();
    Some(figure.panel(gain).panel(phase))
}
