//! The table of a campaign.

use statrs::distribution::{Beta, ContinuousCDF};

use crate::outcome::{Outcome, Verdict};

/// A row of a table: the name of a place or class, and the verdicts on its experiments.
pub type Row = (String, Vec<Verdict>);

/// Probability that a rate of hazards is below the bound of the table.
const CONFIDENCE: f64 = 0.95;

/// The table in Markdown of the outcomes in these places or classes.
pub fn table(rows: &[Row]) -> String {
    let mut text = "| place | injections | no effect | small or short | detected and safe | restarted and safe | detected, coasting | detected, still driven | **silent and hazardous** | not judged | silent and hazardous, at most |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for (name, verdicts) in rows {
        text += &format!("| {name} | {} |", verdicts.len());
        for outcome in Outcome::ALL {
            let count = verdicts.iter().filter(|other| other.outcome == outcome);
            text += &format!(" {} |", count.count());
        }
        text += &format!(" {} |\n", hazard_bound(verdicts));
    }
    text
}

/// The rate of silent hazards that is not exceeded with the probability [`CONFIDENCE`]: the upper
/// bound of Clopper and Pearson for k cases among n, a quantile of the beta distribution with the
/// parameters k + 1 and n - k. Cases that were not judged count as hazardous.
fn hazard_bound(verdicts: &[Verdict]) -> String {
    let is_hazard = |verdict: &&Verdict| verdict.outcome >= Outcome::Hazardous;
    let hazards = verdicts.iter().filter(is_hazard).count() as f64;
    let others = verdicts.len() as f64 - hazards;
    // Two digits of the rate of so many injections without a hazard.
    let digits = if verdicts.len() > 3_000 { 4 } else { 2 };
    let rate = Beta::new(hazards + 1.0, others).map(|beta| beta.inverse_cdf(CONFIDENCE));
    rate.map_or("-".into(), |rate| format!("{:.*} %", digits, 100.0 * rate))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_of_the_rate_is_that_of_the_rule_of_three() {
        let harmless = Verdict {
            outcome: Outcome::Detected,
            ..Verdict::UNJUDGED
        };
        // -ln(0.05) = 3.00 cases among 1000.
        assert_eq!(hazard_bound(&[harmless; 1000]), "0.30 %");
        // Tables of the binomial distribution: 0.47 % for one case among 1000.
        let mut verdicts = [harmless; 1000];
        verdicts[0].outcome = Outcome::Hazardous;
        assert_eq!(hazard_bound(&verdicts), "0.47 %");
        assert_eq!(hazard_bound(&[Verdict::UNJUDGED]), "-");
        assert_eq!(hazard_bound(&[]), "-");
    }
}
