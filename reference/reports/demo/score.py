"""What several runs of a method say about it, against a truth with an error."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images import metrics
from restir_gi.reference.images.image import luminance, luminance_weights
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.reports.demo.runs import Runs


@dataclass(frozen=True, slots=True)
class RunScore:
    """Error of a method.

    Attributes
    ----------
    mse : float; mean over the runs, without the share of the truth's own error
    gain : float
        (MSE · seconds) of path tracing over the same of this method: how many times
        longer path tracing takes to the same error.
    bias : float; mean luminance of all runs over that of the truth, less 1
    bias_error : float
        Its standard error, from the scatter of the runs and the error of the truth.
    """

    name: str
    seconds: float
    mse: float
    gain: float
    bias: float
    bias_error: float


def scores(truth: Moments, paths: Runs, others: list[Runs]) -> list[RunScore]:
    """Judge all methods.  Path tracing first.

    Parameters
    ----------
    truth : Moments; of independent samples
    paths : Runs; of path tracing, the measure of the rest
    others : list of Runs; at least two runs each
    """
    cost = mean_mse(paths, truth) * paths.seconds
    found = []
    for runs in (paths, *others):
        mse = mean_mse(runs, truth)
        gain = cost / (mse * runs.seconds) if mse > 0 else float("inf")
        bias, error = relative_bias(runs.colors, truth)
        found.append(RunScore(runs.method.name, runs.seconds, mse, gain, bias, error))
    return found


def mean_mse(runs: Runs, truth: Moments) -> float:
    """Mean squared error of one picture, against the noiseless truth.

    Parameters
    ----------
    truth : Moments; whose own variance is taken off

    Returns
    -------
    float; it may fall below 0 where the truth is noisier than the pictures
    """
    variance = truth.standard_error() ** 2
    return float(np.mean([metrics.mse(c, truth.mean, variance) for c in runs.colors]))


def relative_bias(colors: list[Vec3s], truth: Moments) -> tuple[float, float]:
    """Bias of the mean luminance of a picture, and its standard error.

    The channels of a sample share their paths.  Their covariances are not known; they
    are taken as fully correlated, which makes the error of the truth too large rather
    than too small.

    Parameters
    ----------
    colors : list of (N, 3) float64; independent runs, at least two
    truth : Moments; of independent samples

    Returns
    -------
    float, float; 0 and 0 where the truth is black
    """
    weights = np.array(luminance_weights())
    true = float(np.mean(luminance(truth.mean)))
    if true == 0:
        return 0.0, 0.0
    of_pixels = truth.standard_error() @ weights
    true_error = float(np.sqrt(np.sum(of_pixels**2)) / len(of_pixels))
    means = [float(np.mean(luminance(color))) for color in colors]
    mean, scatter = float(np.mean(means)), float(np.std(means, ddof=1))
    error = np.hypot(scatter / np.sqrt(len(means)), mean / true * true_error) / true
    return mean / true - 1, float(error)
