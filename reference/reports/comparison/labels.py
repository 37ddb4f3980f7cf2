"""What each number of a comparison is called on the page, and how it is written."""

from dataclasses import dataclass
from typing import Any

from restir_gi.reference.images.metrics import EPSILON


@dataclass(frozen=True, slots=True)
class Metric:
    """A field of `judge.Comparison`: its label, what it means, and its form."""

    name: str
    label: str
    meaning: str
    form: str = "{:.4g}"

    def text(self, value: Any) -> str:
        """Write the value as the page shows it."""
        values = value if isinstance(value, tuple) else (value,)
        return ", ".join(self.form.format(v) for v in values)


NUMBERS = (
    Metric(
        "relative_bias", "Relative bias", "luminance of mean A / mean B − 1", "{:+.3%}"
    ),
    Metric("rmse", "RMSE", "square root of MSE"),
    Metric("mse", "MSE", "mean of (A − B)²"),
    Metric(
        "mse_of_b", "MSE of B", "mean squared standard error of B: its share of MSE"
    ),
    Metric(
        "mse_corrected",
        "MSE, corrected",
        "MSE without the share of B; unbiased, so it may fall below 0",
    ),
    Metric("rel_mse", "relMSE", f"mean of (A − B)² / (B² + {EPSILON})"),
    Metric("rel_mse_corrected", "relMSE, corrected", "without the share of B"),
    Metric("mape", "MAPE", f"mean of |A − B| / (|B| + {EPSILON})", "{:.2%}"),
    Metric("smape", "SMAPE", f"mean of 2 |A − B| / (|A| + |B| + {EPSILON})", "{:.2%}"),
    Metric("flip_hdr", "HDR-FLIP", "mean; 0 is no visible difference, 1 the most"),
    Metric("flip_ldr", "LDR-FLIP", "mean, at the exposure shown here"),
    Metric(
        "z_rms", "RMS of z", "1 if both standard errors are known and there is no bias"
    ),
    Metric(
        "z_above_3",
        "|z| > 3",
        "share of all; 0.27 % if the errors are normal",
        "{:.2%}",
    ),
    Metric("mean_a", "Mean of A", "R, G, B"),
    Metric("mean_b", "Mean of B", "R, G, B"),
    Metric(
        "not_finite_a",
        "Not finite in A",
        "pixels with NaN or infinity, left out of all the rest",
        "{:d}",
    ),
    Metric("not_finite_b", "Not finite in B", "the same of B", "{:d}"),
    Metric("exposure", "Exposure", "factor under which both are shown"),
)
