"""What a user would fit without a library of actuators: a first-order lag, and an ARX."""

import warnings

import numpy as np
from scipy.optimize import least_squares

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS


class Lag:
    """Gain, offset, delay and time constant by scipy; exact between samples of a held command."""

    NAMES = ("gain", "offset", "delay", "time constant")

    def angles(self, run, values):
        gain, offset, delay, tau = values
        late = np.interp(run.time_s - delay, run.time_s, run.goal)
        kept = np.exp(-np.diff(run.time_s) / tau)
        angles = np.empty(len(run.time_s))
        angles[0] = run.angle[0]
        target = gain * late + offset
        for i, share in enumerate(kept):
            angles[i + 1] = share * angles[i] + (1 - share) * target[i]
        return angles

    def search(self, runs, kept=None):
        """Estimates and their standard errors, of the samples that are `kept`."""
        kept = kept or [slice(None)] * len(runs)
        residual = lambda x: np.concatenate(
            [(self.angles(run, x) - run.angle)[part] for run, part in zip(runs, kept)]
        )
        low, high = [-5.0, -1.0, 0.0, 1e-3], [5.0, 1.0, 0.5, 5.0]
        found = least_squares(residual, [1.0, 0.0, 0.02, 0.1], bounds=(low, high), x_scale="jac")
        freedom = len(found.fun) - len(found.x)
        covariance = np.linalg.pinv(found.jac.T @ found.jac) * 2 * found.cost / freedom
        return found.x, np.sqrt(np.diag(covariance))

    def fit(self, runs):
        return self.search(runs)[0]


class Arx:
    """Two lags of angle and command, on even samples at the median rate; simulated freely."""

    ORDER = 2

    def even(self, run, step_s):
        grid = np.arange(0.0, run.time_s[-1], step_s)
        at = lambda values: np.interp(grid, run.time_s, values)[:, None]
        return grid, at(run.goal), at(run.angle)

    def fit(self, runs):
        step_s = float(np.median(np.concatenate([np.diff(run.time_s) for run in runs])))
        # One after the other: the few samples across the joints are a thousandth.
        parts = [self.even(run, step_s)[1:] for run in runs]
        goal, angle = (np.concatenate(column) for column in zip(*parts))
        model = FROLS(
            ylag=self.ORDER,
            xlag=self.ORDER,
            order_selection=False,
            n_terms=2 * self.ORDER + 1,
            basis_function=Polynomial(degree=1),
        )
        model.fit(X=goal, y=angle)
        return model, step_s

    def angles(self, run, fitted):
        model, step_s = fitted
        grid, goal, angle = self.even(run, step_s)
        found = model.predict(X=goal, y=angle[: self.ORDER])
        return np.interp(run.time_s, grid, np.ravel(found))
