//! The combinations of estimates that are known though no estimate in them is.

use crate::covariance::Covariance;
use crate::fit::Combination;
use crate::levenberg::Found;
use crate::observable::weight;
use crate::unknowns::Unknowns;

/// Exponents from which a combination is stated as a sum.
const LARGEST_POWER: f64 = 4.0;

/// The combinations, with unknowns in place of estimates.
pub fn of(
    unknowns: &Unknowns,
    found: &Found,
    covariance: &Covariance,
    at_bound: &[bool],
) -> Vec<Combination> {
    let value = |unknown: usize| found.point[unknown];
    let weight = |unknown: usize| weight(&unknowns.list[unknown], value(unknown));
    let one = |row: usize| {
        let (first, with) = (&covariance.rows[row], &covariance.with[row]);
        let all = || std::iter::once(*first).chain(with.iter().map(|(unknown, _)| *unknown));
        let is_power = with
            .iter()
            .all(|(_, exponent)| exponent.abs() < LARGEST_POWER);
        let is_ratio = |unknown: usize| value(unknown) > 0.0 && weight(unknown) == value(unknown);
        let is_product = is_power && all().all(is_ratio);
        let factor = |(unknown, exponent): &(usize, f64)| match is_product {
            true => (*unknown, -exponent),
            false => (*unknown, -exponent * weight(*first) / weight(*unknown)),
        };
        let terms: Vec<(usize, f64)> = std::iter::once((*first, 1.0))
            .chain(with.iter().map(factor))
            .collect();
        let (value, slope) = if is_product {
            let powers = terms
                .iter()
                .map(|(unknown, power)| value(*unknown).powf(*power));
            let product: f64 = powers.product();
            (product, product / value(*first))
        } else {
            let sum = terms
                .iter()
                .map(|(unknown, factor)| factor * value(*unknown));
            (sum.sum(), 1.0)
        };
        Combination {
            standard_error: slope * covariance.white[(row, row)].sqrt(),
            standard_error_coloured: slope * covariance.coloured[(row, row)].max(0.0).sqrt(),
            terms,
            is_product,
            value,
        }
    };
    let is_known =
        |row: &usize| !covariance.with[*row].is_empty() && !at_bound[covariance.rows[*row]];
    let rows = 0..covariance.rows.len();
    rows.filter(is_known).map(one).collect()
}

/// The same with the indices of the estimates that `place` has for the unknowns.
pub fn named(
    combinations: Vec<Combination>,
    place: impl Fn(&usize) -> Option<usize>,
) -> Vec<Combination> {
    let named = |combination: Combination| {
        let terms = combination.terms.iter();
        let terms = terms.map(|(unknown, factor)| Some((place(unknown)?, *factor)));
        let terms = terms.collect::<Option<_>>()?;
        Some(Combination {
            terms,
            ..combination
        })
    };
    combinations.into_iter().filter_map(named).collect()
}
