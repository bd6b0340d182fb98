//! Information and gradient of a fit by stretches of its recordings.
//!
//! They show what the sums over all samples hide: residuals that are larger where the parameters
//! act, residuals that are correlated for longer than any lag of their autocorrelation, and
//! parameters that are larger in one part of the recordings than in another.

use nalgebra::{DMatrix, DVector};

use super::problem::Problem;
use super::unknowns::Unknowns;

/// Stretches of equal length of each recording.
const PER_RUN: usize = 16;

/// A stretch of a recording.
pub struct Block {
    /// The recording.
    pub experiment: usize,
    /// Its place in the recording, from 0 to 1.
    pub place: f64,
    /// The sum of residuals times derivatives.
    gradient: DVector<f64>,
    /// The sum of the products of derivatives.
    information: DMatrix<f64>,
}

/// The sums of a stretch: of residuals times derivatives, and of the weighted products of
/// derivatives, whose lower triangle is stored row by row.
#[derive(Clone)]
struct Products {
    gradient: Vec<f64>,
    lower: Vec<f64>,
}

impl Products {
    fn new(width: usize) -> Self {
        Self {
            gradient: vec![0.0; width],
            lower: vec![0.0; width * (width + 1) / 2],
        }
    }

    fn add(&mut self, residual: f64, weight: f64, row: &[f64]) {
        for (sum, slope) in self.gradient.iter_mut().zip(row) {
            *sum += residual * slope;
        }
        let mut rest = &mut self.lower[..];
        for (a, slope) in row.iter().enumerate() {
            let (sums, others) = rest.split_at_mut(a + 1);
            let weighted = weight * slope;
            for (sum, other) in sums.iter_mut().zip(row) {
                *sum += weighted * other;
            }
            rest = others;
        }
    }

    fn matrix(&self) -> DMatrix<f64> {
        let width = self.gradient.len();
        DMatrix::from_fn(width, width, |a, b| {
            let (low, high) = (a.min(b), a.max(b));
            self.lower[high * (high + 1) / 2 + low]
        })
    }
}

/// All stretches. The rows are those of the unknowns of the run, and a last one for the drift of
/// the clock: the derivative by the delay times the time from the middle of the recording.
pub struct Blocks {
    list: Vec<Block>,
    /// Of each recording: the products of the derivatives weighted by squared residuals.
    weighted: Vec<DMatrix<f64>>,
    /// The places of the rows in the unknowns.
    columns: Vec<Vec<usize>>,
    width: usize,
}

impl Blocks {
    /// The stretches at a point, with the residuals that `influence` makes of the plain ones.
    pub fn of(
        problem: &Problem,
        unknowns: &Unknowns,
        point: &[f64],
        influence: &dyn Fn(f64) -> f64,
    ) -> Self {
        let mut blocks = Self {
            list: Vec::new(),
            weighted: Vec::new(),
            columns: Vec::new(),
            width: point.len(),
        };
        for (experiment, (run, own)) in problem.experiments.iter().zip(&unknowns.runs).enumerate() {
            let width = own.free.len();
            let delay = problem.model.parameter_index("delay_s");
            let delay = own.free.iter().position(|p| Some(*p) == delay);
            let count = PER_RUN.min(run.len());
            let mut products = vec![Products::new(width + 1); count];
            let mut weighted = Products::new(width);
            let (angles, length) = (&run.recording.angle_deg, run.len());
            let middle_s = 0.5 * run.duration_s();
            let mut row = vec![0.0; width + 1];
            let output = &mut |i: usize, angle: f64, slope: &[f64]| {
                let residual = influence(angles[i] - angle);
                if residual.is_nan() {
                    return;
                }
                row[..width].copy_from_slice(slope);
                row[width] = delay.map_or(0.0, |delay| {
                    slope[delay] * (run.time_ns[i] as f64 * 1e-9 - middle_s)
                });
                products[i * count / length].add(residual, 1.0, &row);
                weighted.add(residual, residual * residual, slope);
            };
            problem
                .model
                .sensitivity(run, &own.values(point), &own.free, output);
            blocks
                .list
                .extend(products.into_iter().enumerate().map(|(k, products)| Block {
                    experiment,
                    place: (k as f64 + 0.5) / count as f64,
                    information: products.matrix(),
                    gradient: DVector::from_vec(products.gradient),
                }));
            blocks.weighted.push(weighted.matrix());
            // The drift follows the unknowns.
            let columns = own.columns.iter().copied().chain([point.len()]);
            blocks.columns.push(columns.collect());
        }
        blocks
    }

    /// Gradient and information of the selected stretches by these unknowns; the drift is the one
    /// after the last.
    pub fn sum(
        &self,
        rows: &[usize],
        selected: impl Fn(&Block) -> bool,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let mut gradient = DVector::zeros(rows.len());
        let mut information = DMatrix::zeros(rows.len(), rows.len());
        let mut places = vec![None; self.width + 1];
        for (place, row) in rows.iter().enumerate() {
            places[*row] = Some(place);
        }
        for block in self.list.iter().filter(|block| selected(block)) {
            let columns = &self.columns[block.experiment];
            let own = || columns.iter().enumerate();
            for (a, row) in own().filter_map(|(a, column)| Some((a, places[*column]?))) {
                gradient[row] += block.gradient[a];
                for (b, column) in own().filter_map(|(b, column)| Some((b, places[*column]?))) {
                    information[(row, column)] += block.information[(a, b)];
                }
            }
        }
        (gradient, information)
    }

    /// `sum r^2 J J'`: the covariance of the gradient where the variance of the residuals changes
    /// (White, Econometrica 48, 1980).
    pub fn heteroskedastic(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.width, self.width);
        for (weighted, columns) in self.weighted.iter().zip(&self.columns) {
            for a in 0..weighted.nrows() {
                for b in 0..weighted.ncols() {
                    sum[(columns[a], columns[b])] += weighted[(a, b)];
                }
            }
        }
        sum
    }

    /// `sum g g'` over the stretches: the covariance of the gradient where residuals of one stretch
    /// are correlated, and those of different ones are not.
    pub fn between_blocks(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.width, self.width);
        for block in &self.list {
            let columns = &self.columns[block.experiment];
            let own = columns.len() - 1;
            for a in 0..own {
                for b in 0..own {
                    sum[(columns[a], columns[b])] += block.gradient[a] * block.gradient[b];
                }
            }
        }
        let count = self.list.len() as f64;
        sum * (count / (count - 1.0).max(1.0))
    }
}
