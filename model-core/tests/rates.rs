//! The sampled loop at the rates of this build against the referee at the same rates.
//!
//! In the default build these are 250 Hz and 1 kHz; `tests/rates/check.sh` builds it with 1 kHz
//! and 20 kHz.

use model_core::{
    actuator::{Actuator, ModelKind, PlantKind, Settings},
    excitation::catalogue::Input,
    presets::preset,
    time::{
        CONTROL_PERIOD_TICKS, CONTROL_RATE_HZ, PWM_RATE_HZ, TICKS_PER_SECOND, UPDATE_PERIOD_TICKS,
        UPDATE_RATE_HZ,
    },
};

/// The golden file's model at the rates of this build.
fn referee() -> &'static str {
    match (CONTROL_RATE_HZ, PWM_RATE_HZ) {
        (250, 1_000) => "fw",
        (1_000, 20_000) => "fw-1000",
        rates => panic!("the referee has no rows at {rates:?} Hz"),
    }
}

/// Tick and angle, deg, of the referee's rows.
fn rows(input: &str) -> Vec<(u64, f64)> {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/referee/golden");
    let path = format!("{directory}/{}-{input}.csv", referee());
    let text = std::fs::read_to_string(&path).expect("a golden file");
    text.lines()
        .skip(1)
        .map(|line| {
            let field = |index| line.split(',').nth(index).and_then(|f| f.parse().ok());
            let (t, angle_deg): (f64, f64) = (field(0).expect("t"), field(3).expect("an angle"));
            ((t * TICKS_PER_SECOND as f64).round() as u64, angle_deg)
        })
        .collect()
}

#[test]
fn the_periods_are_those_of_the_rates() {
    let ticks = TICKS_PER_SECOND;
    assert_eq!(CONTROL_PERIOD_TICKS * u64::from(CONTROL_RATE_HZ), ticks);
    assert_eq!(UPDATE_PERIOD_TICKS * u64::from(UPDATE_RATE_HZ), ticks);
}

#[test]
fn the_board_follows_the_referee_at_the_rates_of_this_build() {
    for name in ["pulse", "3211"] {
        let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
        settings
            .apply(preset("consistent").expect("a preset"))
            .expect("of the board");
        let mut actuator = Actuator::try_new(&settings).expect("in range");
        let input = Input::named(name).expect("an input");
        let excitation = input.excitation().expect("in range");
        for (tick, expected_deg) in rows(name) {
            while actuator.tick() < tick {
                let command_deg = excitation.command(actuator.tick()).to_f64();
                actuator.advance(command_deg, 1).expect("finite");
            }
            // As tests/referee_simulator.rs: no count differs, the coefficients by 2^-31 of them.
            let angle_deg = actuator.reading().angle_deg;
            let error_deg = (angle_deg - expected_deg).abs();
            assert!(error_deg < 5e-6, "{name}, tick {tick}: {error_deg}");
        }
    }
}
