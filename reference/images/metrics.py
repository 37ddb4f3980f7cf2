"""How far an image is from the truth: each metric one function, one formula.

A is the image, B the truth, both linear radiance, finite.  Sums run over all pixels
and channels, n terms in all, in float64.
"""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.image import luminance
from restir_gi.reference.numerics.arrays import divide_or_zero

Colors = NDArray[np.float64]

EPSILON = 0.01  # radiance below which relative errors fade into absolute ones


def mse(a: Colors, b: Colors, variance: Colors | float = 0.0) -> float:
    """Mean squared error Σ ((A − B)² − v) / n.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth
    variance : (..., 3) float64, or 0
        v, the variance of the truth itself: its standard error squared.

    Returns
    -------
    float
        With v taken off, the error against the *noiseless* truth without bias: for
        independent noise E (A − B)² = E (A − E B)² + v.  It may fall below 0.
    """
    return float(np.mean((a - b) ** 2 - variance))


def rmse(a: Colors, b: Colors) -> float:
    """Root mean squared error √(Σ (A − B)² / n), in the unit of radiance.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth
    """
    return float(np.sqrt(mse(a, b)))


def rel_mse(a: Colors, b: Colors, variance: Colors | float = 0.0) -> float:
    """Relative mean squared error Σ ((A − B)² − v) / (B² + ε) / n, ε = `EPSILON`.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth
    variance : (..., 3) float64, or 0; v, as in `mse`

    Returns
    -------
    float; dark and bright pixels count alike, down to a radiance of √ε = 0.1
    """
    return float(np.mean(((a - b) ** 2 - variance) / (b**2 + EPSILON)))


def mape(a: Colors, b: Colors) -> float:
    """Mean absolute error relative to the truth, Σ |A − B| / (|B| + ε) / n.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth

    Returns
    -------
    float; a share: 0.1 is 10 %
    """
    return float(np.mean(np.abs(a - b) / (np.abs(b) + EPSILON)))


def smape(a: Colors, b: Colors) -> float:
    """Symmetric form of `mape`, Σ 2 |A − B| / (|A| + |B| + ε) / n; a share, below 2.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth, in either order
    """
    return float(np.mean(2 * np.abs(a - b) / (np.abs(a) + np.abs(b) + EPSILON)))


def channel_means(a: Colors) -> tuple[float, float, float]:
    """Mean of each channel, 3 Σ A / n, of R, of G and of B.

    Parameters
    ----------
    a : (..., 3) float64; image
    """
    red, green, blue = np.mean(a.reshape(-1, 3), axis=0)
    return float(red), float(green), float(blue)


def relative_bias(a: Colors, b: Colors) -> float:
    """Bias of the image as a whole, Y(Σ A) / Y(Σ B) − 1 with luminance Y.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth

    Returns
    -------
    float
        Above 0 if the image is too bright; 0 if both are black, infinite if only the
        truth is.
    """
    y_a, y_b = (float(luminance(np.array(channel_means(c)))) for c in (a, b))
    if y_b == 0:
        return float(np.copysign(np.inf, y_a)) if y_a else 0.0
    return y_a / y_b - 1


def z_scores(a: Colors, b: Colors, variance: Colors) -> Colors:
    """Difference in standard deviations, (A − B) / √v, channel by channel.

    Not of the luminance: the channels of a pixel share their paths, and the standard
    error of a sum needs the covariances, which nobody stores.

    Parameters
    ----------
    a, b : (..., 3) float64; image and truth
    variance : (..., 3) float64
        v = SE_A² + SE_B².  With only one of the two the noise of the other is taken
        for bias, and z is too large.

    Returns
    -------
    (..., 3) float64; where v = 0: 0 if A = B, else ±∞
    """
    difference = a - b
    z = divide_or_zero(difference, np.sqrt(variance))
    certain = (variance == 0) & (difference != 0)
    z[certain] = np.copysign(np.inf, difference[certain])
    return z


def rms(z: Colors) -> float:
    """Root mean square √(Σ z² / n); 1 without bias, if the standard errors are honest.

    Parameters
    ----------
    z : (...) float64; z scores
    """
    return float(np.sqrt(np.mean(z**2)))


def excess(z: Colors, limit: float) -> float:
    """Share of z scores with |z| above a limit.

    Parameters
    ----------
    z : (...) float64; z scores
    limit : float; in standard deviations

    Returns
    -------
    float; 0.0027 at 3 without bias, if the errors are normal as well
    """
    return float(np.mean(np.abs(z) > limit))
