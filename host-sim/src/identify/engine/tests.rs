use super::*;
use crate::identify::models;
use crate::identify::testing::{noisy, simulated};
use crate::settings::ModelKind;

fn problem(model: &str, runs: Vec<crate::identify::Recording>) -> Problem {
    let model = models::named(model).expect("a model");
    let runs = runs
        .into_iter()
        .map(|r| Experiment::try_new(r).expect("a recording"));
    Problem::try_new(model, runs.collect()).expect("a problem")
}

#[test]
fn the_papers_black_box_is_found_from_the_pulse() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let fit = fit(
        &problem("black-box-1", vec![run]),
        &Options::default(),
        &Quiet,
    )
    .unwrap();
    for e in &fit.estimates {
        println!(
            "{:24} {:12.6} {:12.6} {:?} {}",
            e.name, e.value, e.standard_error, e.at_bound, e.identifiable
        );
    }
    println!(
        "{} {} {:?} {:?}",
        fit.fit_percent, fit.iterations, fit.termination, fit.starts
    );
    let truth = [
        ("pole_rad_s", 30.0),
        ("delay_s", 0.0175),
        ("rate_limit_up_deg_s", 240.0),
        ("rate_limit_down_deg_s", 350.0),
        ("gain", 1.0),
        ("offset_deg", 0.0),
    ];
    for (name, truth) in truth {
        let e = fit.estimate(name).expect("an estimate");
        assert!((e.value - truth).abs() < 3.0 * e.standard_error, "{e:?}");
    }
}
