"""Moments of independent batches, put together."""

from collections.abc import Sequence

from reference.moments import Moments


def merge(batches: Sequence[Moments]) -> Moments:
    """Moments of all samples of several batches.

    Σ (x − μ)² over both = the two sums + (μ_a − μ_b)² n_a n_b / (n_a + n_b)
    [Chan83].

    Parameters
    ----------
    batches : sequence of Moments; at least one; of different samples of the same rows

    Returns
    -------
    Moments; as if one batch had held all samples, but for rounding
    """
    merged = batches[0]
    for batch in batches[1:]:
        count = merged.count + batch.count
        step = batch.mean - merged.mean
        mean = merged.mean + step * (batch.count / count)
        between = step**2 * (merged.count * batch.count / count)
        merged = Moments(count, mean, merged.squares + batch.squares + between)
    return merged
