//! Normal equations of many recordings.
//!
//! Unknowns of different recordings, such as their initial angles, do not meet in `J' J`: it has
//! the shape of an arrow. Their elimination leaves equations of the shared unknowns alone (the
//! Schur complement), so that the effort grows with the number of recordings, not with its cube.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::unknowns::Unknowns;

/// Unknowns of one recording, eliminated from its equations.
pub struct Eliminated {
    /// By how much they decrease by each of the shared unknowns.
    by_shared: DMatrix<f64>,
    /// Their values where the shared ones are zero.
    alone: DVector<f64>,
    /// What the matrix of the shared ones loses.
    pub matrix: DMatrix<f64>,
    /// What their right side loses.
    pub right: DVector<f64>,
}

/// Eliminates the unknowns with the matrix `own` from equations that they share by `cross`; `None`
/// where they are not determined.
pub fn eliminate(
    own: DMatrix<f64>,
    cross: &DMatrix<f64>,
    right: &DVector<f64>,
) -> Option<Eliminated> {
    let factor = Cholesky::new(own)?;
    let (by_shared, alone) = (factor.solve(cross), factor.solve(right));
    Some(Eliminated {
        matrix: cross.tr_mul(&by_shared),
        right: cross.tr_mul(&alone),
        by_shared,
        alone,
    })
}

/// The solution of `A x = right` for the unknowns `rows`, `A` being positive definite with these
/// entries by places in `rows`; `None` where it is not.
pub fn solve(
    unknowns: &Unknowns,
    rows: &[usize],
    entry: impl Fn(usize, usize) -> f64,
    right: &DVector<f64>,
) -> Option<DVector<f64>> {
    let (mut shared, mut owned) = (Vec::new(), BTreeMap::<usize, Vec<usize>>::new());
    for (place, row) in rows.iter().enumerate() {
        match unknowns.list[*row].experiment {
            Some(run) if unknowns.runs.len() > 1 => owned.entry(run).or_default().push(place),
            _ => shared.push(place),
        }
    }
    let matrix =
        |a: &[usize], b: &[usize]| DMatrix::from_fn(a.len(), b.len(), |i, j| entry(a[i], b[j]));
    let (mut reduced, mut rest) = (matrix(&shared, &shared), right.select_rows(&shared));
    let mut eliminated = Vec::with_capacity(owned.len());
    for own in owned.values() {
        let cross = matrix(own, &shared);
        let one = eliminate(matrix(own, own), &cross, &right.select_rows(own))?;
        reduced -= &one.matrix;
        rest -= &one.right;
        eliminated.push((own, one));
    }
    let of_shared = Cholesky::new(reduced)?.solve(&rest);
    let mut solution = DVector::zeros(rows.len());
    let mut place = |at: &[usize], values: &DVector<f64>| {
        at.iter()
            .zip(values)
            .for_each(|(i, value)| solution[*i] = *value);
    };
    place(&shared, &of_shared);
    for (own, one) in &eliminated {
        place(own, &(&one.alone - &one.by_shared * &of_shared));
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use model_core::actuator::ModelKind;

    use super::*;
    use crate::experiment::Experiment;
    use crate::models;
    use crate::normal::normal;
    use crate::problem::Problem;
    use crate::testing::simulated;

    #[test]
    fn the_solution_satisfies_the_equations_of_several_recordings() {
        let run = |input| {
            let run = simulated(ModelKind::BlackBox1, input, 80, &[]);
            Experiment::try_new(run).expect("a recording")
        };
        let runs = ["pulse", "3-2-1-1", "chirp"].map(run).into();
        let model = models::named("black-box-1").expect("a model");
        let problem = Problem::try_new(model, runs).expect("a problem");
        let unknowns = Unknowns::of(&problem).expect("unknowns");
        let owned = unknowns.list.iter().filter(|u| u.experiment.is_some());
        assert!(owned.count() >= 3);
        let at = normal(&problem, &unknowns, &unknowns.start());
        let rows: Vec<usize> = (0..unknowns.list.len()).collect();
        // Damped as in a search, because not every unknown acts there.
        let entry = |i, j| at.hessian[(i, j)] + f64::from(u8::from(i == j));
        let found = solve(&unknowns, &rows, entry, &at.gradient).expect("a solution");
        let matrix = DMatrix::from_fn(rows.len(), rows.len(), entry);
        let error = matrix * found - &at.gradient;
        assert!(error.norm() < 1e-9 * at.gradient.norm(), "{error}");
    }
}
