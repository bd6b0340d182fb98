//! The table of a campaign in a document.

use std::collections::BTreeSet;

use statrs::distribution::{Beta, ContinuousCDF};

use crate::history::{Entry, recorded};
use crate::outcome::{Outcome, Verdict};

/// A row of a table: the name of a place or class, and the verdicts on its experiments.
pub type Row = (String, Vec<Verdict>);

const BEGIN: &str = "<!-- table of the campaign: begin -->";
const END: &str = "<!-- table of the campaign: end -->";

/// Probability that a rate of hazards is below the bound of the table.
const CONFIDENCE: f64 = 0.95;

/// The table in Markdown of the outcomes in these places or classes.
pub fn table(rows: &[Row]) -> String {
    let mut text = "| place | injections | of these, simulated | no effect | small or short | told and safe | restarted and safe | told, coasting | told, driven on | **silent and hazardous** | not judged | silent and hazardous, at most |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for (name, verdicts) in rows {
        let injections = verdicts.len() as u64;
        let simulated = injections - recorded(verdicts);
        text += &format!("| {name} | {injections} | {simulated} |");
        for outcome in Outcome::ALL {
            let count = verdicts.iter().filter(|other| other.outcome == outcome);
            text += &format!(" {} |", count.count());
        }
        text += &format!(" {} |\n", hazard_bound(verdicts));
    }
    text
}

/// The sums of all campaigns so far, in Markdown.
pub fn total(entries: &[Entry]) -> String {
    let programs: BTreeSet<_> = entries.iter().map(|entry| &entry.program).collect();
    let sum = |count: fn(&Entry) -> u64| entries.iter().map(count).sum::<u64>();
    format!(
        "All campaigns so far, of {} programs: {} injections, {} of them simulated and the others \
         decided by a recording; {} told, coasting; {} told, driven on; \
         **{} silent and hazardous**; {} not judged.\n",
        programs.len(),
        sum(|entry| entry.injections),
        sum(|entry| entry.injections - entry.recorded),
        sum(|entry| entry.coasting),
        sum(|entry| entry.driven),
        sum(|entry| entry.hazardous),
        sum(|entry| entry.unjudged),
    )
}

/// The rate of silent hazards that is not exceeded with the probability [`CONFIDENCE`]: the upper
/// bound of Clopper and Pearson for k cases among n, a quantile of the beta distribution with the
/// parameters k + 1 and n - k. Cases that were not judged count as hazardous.
fn hazard_bound(verdicts: &[Verdict]) -> String {
    let is_hazard = |verdict: &&Verdict| verdict.outcome >= Outcome::Hazardous;
    let hazards = verdicts.iter().filter(is_hazard).count() as f64;
    let others = verdicts.len() as f64 - hazards;
    // Two digits of the rate of so many injections without a hazard.
    let digits = if verdicts.len() > 10_000 { 4 } else { 2 };
    let rate = Beta::new(hazards + 1.0, others).map(|beta| beta.inverse_cdf(CONFIDENCE));
    rate.map_or("-".into(), |rate| format!("{:.*} %", digits, 100.0 * rate))
}

/// The document with this text between the two comments that enclose the table; `None` if it lacks
/// them.
pub fn replace_table(document: &str, text: &str) -> Option<String> {
    let (before, rest) = document.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{text}\n{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_of_the_rate_is_that_of_the_rule_of_three() {
        let harmless = Verdict {
            outcome: Outcome::Told,
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

    #[test]
    fn the_table_is_replaced_between_its_comments_alone() {
        let document = format!("before\n{BEGIN}\nold\n{END}\nafter\n");
        let new = replace_table(&document, "new\n").unwrap();
        assert_eq!(new, format!("before\n{BEGIN}\n\nnew\n\n{END}\nafter\n"));
        assert_eq!(replace_table(&new, "new\n"), Some(new.clone()));
        assert_eq!(replace_table("no table", "new"), None);
    }
}
