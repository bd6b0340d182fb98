//! The measured frequency response of the loop.

use identification::frequency::FrequencyResponse;
use identification::{Experiment, Hold, Recording};
use serde_json::{Value, json};

use super::Context;
use crate::quantity::place;
use crate::record::Row;

/// Coherence below which a point says more of the noise than of the loop.
const LEAST_COHERENCE: f64 = 0.8;

/// Answers with the response of the angle to the demand in a recording: frequency, gain and phase.
pub fn measured(context: Context, node: u8, from_s: f64, to_s: f64) {
    let rows: Option<Vec<Row>> = context.core.with_node(node, |node| {
        let rows = node.record.rows(from_s, to_s);
        rows.copied().collect()
    });
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |_, _| {
        reply.result(response(&rows.unwrap_or_default()));
    });
    context.reply.busy(begun.map(drop));
}

fn response(rows: &[Row]) -> Result<Value, String> {
    let column = |place: usize| rows.iter().map(move |row| f64::from(row.values[place]));
    let begin_s = rows.first().map_or(0.0, |row| row.time_s);
    let recording = Recording {
        name: "telemetry".to_owned(),
        time_s: rows.iter().map(|row| row.time_s - begin_s).collect(),
        command_deg: column(place::DEMAND).collect(),
        angle_deg: column(place::ANGLE).collect(),
        hold: Hold::Zero,
        ..Recording::default()
    };
    let experiment = Experiment::try_new(recording).map_err(|error| error.to_string())?;
    let response = FrequencyResponse::of(&[&experiment.recording])
        .ok_or("the recording is too short, or nothing moves in it")?;
    let known: Vec<usize> = (0..response.frequency_hz.len())
        .filter(|i| response.coherence[*i] >= LEAST_COHERENCE)
        .collect();
    let of = |values: &[f64]| known.iter().map(|i| values[*i]).collect::<Vec<_>>();
    Ok(json!({
        "hz": of(&response.frequency_hz), "gain_db": of(&response.gain_db),
        "phase_deg": of(&response.phase_deg),
    }))
}

#[cfg(test)]
mod tests {
    use model_core::time::CONTROL_RATE_HZ;

    use super::*;
    use crate::quantity::COUNT;

    #[test]
    fn the_response_of_a_first_order_lag_is_measured() {
        // A chirp from 0.2 to 5 Hz through a lag of 0.1 s, as the control period samples both.
        let period_s = 1.0 / f64::from(CONTROL_RATE_HZ);
        let mut angle = 0.0;
        let rows: Vec<_> = (0..20 * CONTROL_RATE_HZ)
            .map(|i| {
                let time_s = f64::from(i) * period_s;
                let phase = std::f64::consts::TAU * (0.2 * time_s + 0.12 * time_s * time_s);
                let mut values = [0.0; COUNT];
                values[place::DEMAND] = (10.0 * phase.sin()) as f32;
                values[place::ANGLE] = angle as f32;
                angle += (1.0 - (-period_s / 0.1).exp()) * (10.0 * phase.sin() - angle);
                Row { time_s, values }
            })
            .collect();
        let answer = response(&rows).unwrap();
        let list =
            |name: &str| -> Vec<f64> { serde_json::from_value(answer[name].clone()).unwrap() };
        let (hz, gain, phase) = (list("hz"), list("gain_db"), list("phase_deg"));
        let inside: Vec<_> = (0..hz.len())
            .filter(|i| (0.5..4.0).contains(&hz[*i]))
            .collect();
        assert!(inside.len() > 5);
        for i in inside {
            let lag = std::f64::consts::TAU * hz[i] * 0.1;
            // The windows of the estimate are as long as some periods of the lowest frequencies.
            assert!(
                (gain[i] + 10.0 * (1.0 + lag * lag).log10()).abs() < 0.5,
                "{} Hz",
                hz[i]
            );
            assert!(
                (phase[i] + lag.atan().to_degrees()).abs() < 4.0,
                "{} Hz",
                hz[i]
            );
        }
        assert!(response(&rows[..10]).is_err());
    }
}
