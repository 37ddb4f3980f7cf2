"""What wrong numbers may be that is no product: cut off, rounded, of another row."""

from collections.abc import Callable, Iterator, Mapping
from itertools import chain, product

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.diagnosis.naming.fits import SHARE, Claim, Fit, fitted
from restir_gi.reference.oracle.diagnosis.naming.monomials import monomials, number
from restir_gi.reference.oracle.diagnosis.naming.numbers import Numbers, Prediction

FEW = 5
"""Wrong numbers, of which nothing is said."""


def explained(n: Numbers) -> Fit | None:
    """The simplest sentence that is true of the numbers, if there is any."""
    claims = (
        _sums,
        _factors,
        _scaled_words,
        _changed_factors,
        _limited_factors,
        _other_rows,
        monomials,
    )
    found = chain(_of_itself(n), *(claim(n) for claim in claims))
    return fitted(n, found) if n.wrong.sum() >= FEW else None


def explained_by_itself(n: Numbers) -> Fit | None:
    """The simplest such sentence that names no factor but in a condition."""
    return fitted(n, _of_itself(n)) if n.wrong.sum() >= FEW else None


def _of_itself(n: Numbers) -> Iterator[Claim]:
    return chain(_constants(n), _limits(n), _whole_numbers(n), _offsets(n))


def _constants(n: Numbers) -> Iterator[Claim]:
    """One number in all rows."""

    def one(at: float) -> Claim:
        def predict(n: Numbers) -> Prediction:
            value = np.full(len(n.right), at)
            return value, n.rounded(value)

        return Claim(f"is {number(at)}", predict, 0.0 if at == 0 else 0.9)

    yield one(0.0)
    at = _common(n.found[n.wrong])
    if at and _common(n.right[n.wrong]) in (None, 0.0):
        yield one(at)

    def complement(n: Numbers) -> Prediction:
        return 1 - n.right, n.rounded(np.ones(len(n.right)))

    yield Claim("is 1 minus what is right", complement, 3.0)


def _common(values: Scalars) -> float | None:
    """What nearly all values are."""
    if not len(values):
        return None
    at = float(np.median(values))
    same = np.abs(values - at) <= 1e-6 * abs(at)
    return at if same.mean() >= SHARE else None


def _limits(n: Numbers) -> Iterator[Claim]:
    """Limits that nothing exceeds."""
    if _common(n.right[n.wrong]) is not None:
        return
    above = _common(n.found[n.wrong & (n.found < n.right)])
    below = _common(n.found[n.wrong & (n.found > n.right)])
    least = -np.inf if below is None else below
    most = np.inf if above is None else above
    # Else nobody knows whether anything but the limit is ever there.
    within = n.clear & ~n.wrong & (n.right != 0) & (least < n.right) & (n.right < most)
    if within.sum() < FEW or not (above or below):
        return

    def predict(n: Numbers) -> Prediction:
        value = np.clip(n.right, least, most)
        return value, n.allowed + n.rounded(value)

    text = f"is held within {least:.6g} and {most:.6g}"
    if below is None:
        text = f"is cut off at {most:.6g}"
    elif above is None:
        text = f"is at least {least:.6g}"
    yield Claim(text, predict, 0.5, "all")


def _whole_numbers(n: Numbers) -> Iterator[Claim]:
    """Integers in place of reals."""
    if len(np.unique(n.found[n.wrong])) < FEW:
        return
    for word, rounded in (
        ("rounded down", np.floor),
        ("rounded up", np.ceil),
        ("rounded", np.rint),
    ):

        def predict(n: Numbers, rounded: np.ufunc = rounded) -> Prediction:
            value = rounded(n.right)
            return value, n.allowed + n.rounded(value)

        yield Claim(f"is {word} to whole numbers", predict, 0.8, "all")


def _offsets(n: Numbers) -> Iterator[Claim]:
    """A number too much or too little."""
    difference = (n.found - n.right)[n.wrong]
    at = _common(difference)
    # Of one right number alone, nobody knows what was added to it.
    if at and (abs(at) == 1 or _common(n.right[n.wrong]) is None):

        def predict(n: Numbers) -> Prediction:
            value = n.right + at
            return value, n.allowed + n.rounded(np.abs(n.right) + abs(at))

        word = "larger" if at > 0 else "smaller"
        cost = 1.9 if abs(at) == 1 else 2.5
        yield Claim(f"is {word} by {abs(at):.6g}", predict, cost)


def _sums(n: Numbers) -> Iterator[Claim]:
    """A factor too much or too little."""
    for name, factor in n.factors.items():
        for sign, word in ((1.0, "larger"), (-1.0, "smaller")):
            total = n.right + sign * factor.value
            if _agrees(n, total, n.allowed + factor.error):

                def more(n: Numbers, name: str = name, s: float = sign) -> Prediction:
                    f = n.factors[name]
                    room = n.rounded(np.abs(n.right) + np.abs(f.value))
                    return n.right + s * f.value, n.allowed + f.error + room

                yield Claim(f"is {word} by {name}", more, 4.5, "some")


def _agrees(n: Numbers, value: Scalars, room: Scalars) -> bool:
    same: Masks = np.abs(n.found - value) <= room + n.rounded(value)
    return bool(same[n.wrong].mean() >= SHARE)


def _factors(n: Numbers) -> Iterator[Claim]:
    """A factor in place of the product."""
    for name, factor in n.factors.items():
        # What is 0 everywhere is no other number's 0.
        if not np.median(np.abs(factor.value[n.wrong])):
            continue
        if _agrees(n, factor.value, factor.error):

            def predict(n: Numbers, name: str = name) -> Prediction:
                f = n.factors[name]
                return f.value, f.error + n.rounded(f.value)

            yield Claim(f"is {name}", predict, 2.2, "some")
        if n.name == "M" and "cap" in n.factors:

            def capped(n: Numbers, name: str = name) -> Prediction:
                value = np.minimum(n.factors[name].value, n.factors["cap"].value)
                return value, n.rounded(value)

            if _agrees(n, *capped(n)):
                yield Claim(f"is {name}, capped", capped, 2.4, "some")


def _scaled_words(n: Numbers) -> Iterator[Claim]:
    """An integer times a power of two, as floats round it, where nothing is allowed."""
    kind = np.float32 if n.most < 1e39 else np.float64
    if n.allowed[n.wrong].any():
        return
    for name, factor in n.factors.items():
        some = n.wrong & (factor.value > 0) & (n.found > 0)
        if factor.error.any() or not some.any():
            continue
        power = int(np.rint(np.median(np.log2((n.found / factor.value)[some]))))

        def predict(n: Numbers, name: str = name, power: int = power) -> Prediction:
            value = (n.factors[name].value * 2.0**power).astype(kind)
            return value.astype(np.float64), np.zeros(len(value))

        yield Claim(f"is {name} times 2^{power}", predict, 2.3)


CHANGED: Mapping[str, Callable[[Scalars], Scalars]] = {
    "{0} + 1": lambda f: f + 1,
    "{0} − 1": lambda f: f - 1,
    "1 − {0}": lambda f: 1 - f,
    "1 + {0}²": lambda f: 1 + f * f,
    "{0}, rounded down,": np.floor,
}
"""What may stand in place of a factor."""


def _changed_factors(n: Numbers) -> Iterator[Claim]:
    """Another number in place of one of the factors, or of a divisor."""
    for name, (text, change), power in product(n.factors, CHANGED.items(), (1, -1)):

        def predict(
            n: Numbers,
            name: str = name,
            change: Callable[[Scalars], Scalars] = change,
            power: int = power,
        ) -> Prediction:
            f = n.factors[name]
            new = change(f.value)
            value = np.where(n.right == 0, 0.0, n.right * (new / f.value) ** power)
            share = np.abs(f.error / f.value) + np.abs(f.error / new)
            return value, n.rounded(value) + np.abs(value) * share

        # Where the new number is ever the same, nobody knows what it is made of.
        varies = _common(change(n.factors[name].value[n.wrong])) is None
        if varies and _agrees(n, *predict(n)):
            where = "" if power > 0 else " in the divisor"
            said = f"is as with {text.format(name)} for {name}{where}"
            yield Claim(said, predict, 4.0)


def _limited_factors(n: Numbers) -> Iterator[Claim]:
    """A factor, or a divisor, that is not let beyond a limit."""
    sure = n.wrong & (n.right != 0)
    if sure.sum() < FEW:
        return
    for (name, factor), power in product(n.factors.items(), (1, -1, 2, -2)):
        f = factor.value
        if _common(f[sure]) is not None:
            continue
        limit = _common((f * (n.found / n.right) ** (1 / power))[sure])
        if not limit or not limit > 0:
            continue
        least = bool(np.median(f[sure]) < limit)

        def limited(f: Scalars, limit: float = limit, least: bool = least) -> Scalars:
            return np.maximum(f, limit) if least else np.minimum(f, limit)

        def predict(
            n: Numbers,
            name: str = name,
            power: int = power,
            limited: Callable[[Scalars], Scalars] = limited,
        ) -> Prediction:
            f = n.factors[name]
            value = n.right * (limited(f.value) / f.value) ** power
            value = np.where(n.right == 0, 0.0, value)
            share = abs(power) * np.abs(f.error / f.value)
            return value, n.rounded(value) + np.abs(value) * share

        # Else nobody knows whether the factor is there at all.
        beyond = ~n.wrong & (n.right != 0) & (limited(f) == f)
        if beyond.sum() >= FEW:
            word = "at least" if least else "at most"
            where = "" if power > 0 else " in the divisor"
            cost = 4.1 + 0.1 * abs(power)
            yield Claim(f"is as with {name} {word} {limit:.6g}{where}", predict, cost)


def _other_rows(n: Numbers) -> Iterator[Claim]:
    """What another row should have."""
    for name, values in n.other_rows.items():
        if _agrees(n, values, n.rounded(values)):

            def predict(n: Numbers, name: str = name) -> Prediction:
                value = n.other_rows[name]
                return value, n.rounded(value)

            yield Claim(f"is what is right in {name}", predict, 4.0, "some")
