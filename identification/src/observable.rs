//! Which unknowns an experiment determines, and which only in combination with others.
//!
//! A direction of the unknowns along which the output does not change, a null vector of `J' J`,
//! leaves open every unknown that it moves, however small the error of that unknown is while the
//! others are held: the marginal variance is infinite. The combinations that no such direction
//! moves are known. For each direction one unknown is taken as reference; every other unknown that
//! it moves is known as a multiple of a power of the references: in logarithms `x_i - sum a_p x_p`,
//! whose variance is that of `x_i` with the references held.

use nalgebra::{DMatrix, SymmetricEigen};

use super::unknowns::Unknown;

/// Share of the largest eigenvalue of the normalised `J' J` below which a direction is not
/// observable: two parameters whose effects differ by less than 1e-5 of either.
const NEGLIGIBLE_EIGENVALUE: f64 = 1e-10;
/// Component of a normalised null vector that is rounding: that of the eigenvectors where the next
/// eigenvalue is just observable.
const ROUNDING: f64 = 1e-5;
/// Distance from an integer within which an exponent is one: the null vector of a law of powers is
/// as exact as the derivatives of the simulation.
const ROUND: f64 = 0.02;
/// Largest number of choices of references that are compared.
const MOST_CHOICES: usize = 2000;

/// What is observable of the unknowns.
pub struct Observable {
    /// The unknowns other than the references and those without influence.
    pub rows: Vec<usize>,
    /// Of each row, the references that it is known with, and their exponents; empty for an unknown
    /// that is determined alone.
    pub with: Vec<Vec<(usize, f64)>>,
}

/// What an unknown is measured by in a combination: itself where ratios of it matter, or one unit.
pub fn weight(unknown: &Unknown, value: f64) -> f64 {
    let is_ratio = unknown.is_log_scaled || unknown.low == 0.0;
    if is_ratio && value > 0.0 { value } else { 1.0 }
}

impl Observable {
    /// Of the unknowns `acting`, whose weights are those of [`weight`].
    pub fn of(information: &DMatrix<f64>, acting: Vec<usize>, weights: &[f64]) -> Self {
        let scale = |i: usize| information[(acting[i], acting[i])].sqrt();
        let n = acting.len();
        if n == 0 {
            let (rows, with) = (acting, Vec::new());
            return Self { rows, with };
        }
        let normalised = DMatrix::from_fn(n, n, |i, j| {
            information[(acting[i], acting[j])] / (scale(i) * scale(j))
        });
        if is_regular(&normalised) {
            let (rows, with) = (acting, vec![Vec::new(); n]);
            return Self { rows, with };
        }
        let eigen = SymmetricEigen::new(normalised);
        let least = NEGLIGIBLE_EIGENVALUE * eigen.eigenvalues.iter().fold(0.0, |a, b| b.max(a));
        let null: Vec<usize> = (0..n).filter(|k| eigen.eigenvalues[*k] < least).collect();
        let directions = DMatrix::from_fn(n, null.len(), |i, k| {
            let component = eigen.eigenvectors[(i, null[k])];
            let is_rounding = component.abs() < ROUNDING;
            let relative = component / (scale(i) * weights[acting[i]]);
            if is_rounding { 0.0 } else { relative }
        });
        let (references, exponents) = referred(&directions);
        let others = || (0..n).filter(|i| !references.contains(i));
        let with = |i: usize| {
            let terms = references.iter().enumerate();
            let terms = terms.map(|(k, r)| (acting[*r], exponents[(i, k)]));
            terms.filter(|(_, exponent)| *exponent != 0.0).collect()
        };
        Self {
            with: others().map(with).collect(),
            rows: others().map(|i| acting[i]).collect(),
        }
    }

    /// The unknowns that are known only in combination with others.
    pub fn traded(&self) -> Vec<usize> {
        let rows = self.rows.iter().zip(&self.with);
        let traded = rows.filter(|(_, with)| !with.is_empty());
        traded
            .flat_map(|(row, with)| std::iter::once(*row).chain(with.iter().map(|w| w.0)))
            .collect()
    }

    /// Without the rows that are not `kept`.
    pub fn retain(&mut self, kept: impl Fn(usize) -> bool) {
        let mut keep = self
            .rows
            .iter()
            .map(|row| kept(*row))
            .collect::<Vec<_>>()
            .into_iter();
        self.with.retain(|_| keep.next() == Some(true));
        self.rows.retain(|row| kept(*row));
    }
}

/// Whether no eigenvalue is negligible, by a bound that takes less time than eigenvalues of many
/// unknowns: the least one is at least the inverse of the trace of the inverse, and the largest at
/// most the trace.
fn is_regular(normalised: &DMatrix<f64>) -> bool {
    let inverse = normalised.clone().cholesky().map(|factor| factor.inverse());
    inverse
        .is_some_and(|inverse| 1.0 > NEGLIGIBLE_EIGENVALUE * inverse.trace() * normalised.trace())
}

/// One reference for each column of null directions, and the exponents of all rows by them: of the
/// possible references those with the most integers among the exponents.
fn referred(directions: &DMatrix<f64>) -> (Vec<usize>, DMatrix<f64>) {
    let (n, k) = directions.shape();
    let involved = (0..n).filter(|i| directions.row(*i).amax() > 0.0);
    let involved: Vec<usize> = involved.collect();
    let mut best: Option<(usize, f64, Vec<usize>, DMatrix<f64>)> = None;
    for choice in choices(&involved, k) {
        let own = directions.select_rows(&choice);
        let size = own.determinant().abs();
        let Some(inverse) = own.try_inverse() else {
            continue;
        };
        let mut exponents = directions * inverse;
        let mut round = 0;
        for exponent in exponents.iter_mut() {
            let integer = exponent.round();
            if integer != 0.0 && (*exponent - integer).abs() < ROUND {
                *exponent = integer;
                round += usize::from(integer.abs() < 4.0);
            }
        }
        let is_better = best
            .as_ref()
            .is_none_or(|(other, least, ..)| (round, size) > (*other, *least));
        if is_better {
            best = Some((round, size, choice, exponents));
        }
    }
    best.map_or((Vec::new(), DMatrix::zeros(n, k)), |b| (b.2, b.3))
}

/// The subsets of `count` elements, at most [`MOST_CHOICES`].
fn choices(all: &[usize], count: usize) -> Vec<Vec<usize>> {
    let mut subsets: Vec<Vec<usize>> = vec![Vec::new()];
    for taken in 0..count {
        let longer = subsets.iter().flat_map(|subset| {
            let after = subset.last().copied();
            let next = all
                .iter()
                .filter(move |i| after.is_none_or(|last| **i > last));
            next.map(move |i| [&subset[..], &[*i]].concat())
        });
        // The last elements of a subset are needed to complete it.
        subsets = longer.take(MOST_CHOICES << (count - taken)).collect();
    }
    subsets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `J' J` of outputs whose logarithmic derivatives are these rows.
    fn information(rows: &[&[f64]]) -> DMatrix<f64> {
        let jacobian = DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        jacobian.transpose() * jacobian
    }

    #[test]
    fn a_product_is_known_though_neither_factor_is() {
        // The output is x0 x1, and x2 apart from it.
        let all = information(&[&[1.0, 1.0, 0.0], &[0.0, 0.0, 3.0]]);
        let observable = Observable::of(&all, vec![0, 1, 2], &[1.0; 3]);
        assert_eq!(observable.rows.len(), 2);
        let product = &observable.with[0];
        assert_eq!(product.len(), 1);
        assert_eq!(product[0].1, -1.0);
        assert!(observable.with[1].is_empty());
    }

    #[test]
    fn three_ratios_of_four_are_found_whatever_the_share_of_each() {
        // x0/x3, x1/x3 and x2/x3, of very different influence.
        let all = information(&[
            &[1e3, 0.0, 0.0, -1e3],
            &[0.0, 1.0, 0.0, -1.0],
            &[0.0, 0.0, 10.0, -10.0],
        ]);
        let observable = Observable::of(&all, vec![0, 1, 2, 3], &[1.0; 4]);
        assert_eq!(observable.rows.len(), 3);
        assert!(
            observable
                .with
                .iter()
                .all(|w| w.len() == 1 && w[0].1 == 1.0)
        );
    }

    #[test]
    fn two_null_directions_have_two_references() {
        let all = information(&[&[1.0, 1.0, 0.0, 0.0], &[0.0, 0.0, 1.0, -2.0]]);
        let observable = Observable::of(&all, vec![0, 1, 2, 3], &[1.0; 4]);
        assert_eq!(observable.rows.len(), 2);
        assert!(observable.with.iter().all(|w| w.len() == 1));
    }
}
