"""Mistakes that no hypothesis of the catalogue knows, around the built-in passes.

Each changes what a pass is given, or what it gives, and says which words name it.
"""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.oracle.builtin.backend import FLOAT32

SHARES = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class TermPlant:
    """A mistake: its pass, what it does, and the words of which one names it."""

    name: str
    pass_name: str
    answer: object
    words: tuple[str, ...]


def right(case, **changed):
    """Answers of the built-in pass, to inputs of which some are changed."""
    given = {**case.inputs}
    for name, values in changed.items():
        given[name] = np.ascontiguousarray(values).astype(given[name].dtype)
    return dict(getattr(FLOAT32, case.pass_name)(**given, **case.settings))


def seen(x, y, n, n_s):
    """Distance, cosine at the visible point, cosine at the sample."""
    v = y.astype(float) - x
    d = np.sqrt((v * v).sum(axis=1))
    with np.errstate(all="ignore"):
        return d, abs((v * n).sum(axis=1)) / d, abs((v * n_s).sum(axis=1)) / d


def around(case, prefix=""):
    """Of a case's samples."""
    i = case.inputs
    return seen(
        i["visible_position"],
        i[prefix + "position"],
        i["visible_normal"],
        i[prefix + "normal"],
    )


def lit(case, prefix=""):
    """Luminance of radiance, of albedo."""
    return case.inputs[prefix + "radiance"] @ SHARES, case.inputs["albedo"] @ SHARES


def jacobian_of(x_from, x_to, y, n):
    """J, distances and cosines."""
    d_from, _, c_from = seen(x_from, y, n, n)
    d_to, _, c_to = seen(x_to, y, n, n)
    with np.errstate(all="ignore"):
        return (c_to / c_from) * (d_from / d_to) ** 2, d_from, d_to, c_from, c_to


def moved_jacobian(case):
    """Of pass moved."""
    i = case.inputs
    return jacobian_of(
        i["past_visible_position"],
        i["visible_position"],
        i["past_position"],
        i["past_normal"],
    )


def becomes(out, **changed):
    """Outputs, of which some are changed, in their own type."""
    for name, values in changed.items():
        values = np.nan_to_num(values, nan=0.0, posinf=1e38, neginf=-1e38)
        values = np.clip(values, -1e38, 1e38)
        out[name] = np.ascontiguousarray(values).astype(out[name].dtype)
    return out


def times(name, factor):
    """One output times a factor of the case's."""

    def answer(case):
        out = right(case)
        with np.errstate(all="ignore"):
            f = np.nan_to_num(np.asarray(factor(case), float))
        f = f.reshape(f.shape + (1,) * (out[name].ndim - f.ndim))
        return becomes(out, **{name: out[name] * f})

    return answer


def replaced(name, change):
    """One output as a function of the case and itself."""

    def answer(case):
        out = right(case)
        with np.errstate(all="ignore"):
            values = change(case, out[name].astype(float), out)
        return becomes(out, **{name: values})

    return answer


def given(**changes):
    """Inputs as functions of the case."""

    def answer(case):
        with np.errstate(all="ignore"):
            return right(case, **{k: f(case) for k, f in changes.items()})

    return answer


def kept_is(case, out, prefix):
    """Whether the output holds the sample with the prefix."""
    return (out["position"] == case.inputs[prefix + "position"]).all(axis=1)


def d(case):
    """Distances of an output's samples."""
    return around(case)[0]


def _of_kept(case, out):
    i = case.inputs
    return seen(
        i["visible_position"], out["position"], i["visible_normal"], out["normal"]
    )


def closing(factor):
    """W times a factor of the sample that is kept, and of nothing else."""

    def answer(case):
        out = right(case)
        with np.errstate(all="ignore"):
            f = np.nan_to_num(factor(case, out, *_of_kept(case, out)))
        return becomes(out, W=out["W"] * f)

    return answer


def same(case, value, prefix):
    """No change."""
    return value


def own_temporal(target=same, weight=same, decided=same, u=lambda case, u: u):
    """Pass temporal of our own, with changes.

    Each changes a number of one of both samples, given the case and the prefix of its
    buffers: the target, wherever it stands; the weight; the weight in the decision
    alone; and the random number.
    """

    def answer(case):
        i = {k: a.astype(float) for k, a in case.inputs.items()}
        p, w = {}, {}
        for prefix in ("past_", "new_"):
            cos = around(case, prefix)[1]
            toward = i[prefix + "position"] - i["visible_position"]
            front = (toward * i["visible_normal"]).sum(axis=1) > 0
            front &= (toward * i[prefix + "normal"]).sum(axis=1) < 0
            p_hat = (i["albedo"] * i[prefix + "radiance"]) @ SHARES * cos / np.pi
            p[prefix] = target(case, np.where(front, np.nan_to_num(p_hat), 0), prefix)
        w["past_"] = p["past_"] * i["past_W"] * i["past_M"]
        w["new_"] = p["new_"] / np.maximum(i["new_pdf"], 1e-30) * (i["new_pdf"] > 0)
        w = {k: np.nan_to_num(weight(case, v, k)) for k, v in w.items()}
        by = {k: np.nan_to_num(decided(case, v, k)) for k, v in w.items()}
        number = u(case, i["u"])
        second = number * (by["past_"] + by["new_"]) < by["new_"]
        second |= (by["past_"] == 0) & (by["new_"] > 0)
        total, p_kept = w["past_"] + w["new_"], where(second, p["new_"], p["past_"])
        with np.errstate(all="ignore"):
            W = np.where(total > 0, total / p_kept / (i["past_M"] + 1), 0)
        out = right(case)
        for name in ("position", "normal", "radiance"):
            out[name] = np.where(
                second[:, None], case.inputs["new_" + name], case.inputs["past_" + name]
            )
        return becomes(out, W=W)

    return answer


def distance(power):
    """Changes a number by a power of the distance."""
    return lambda case, v, prefix: v * around(case, prefix)[0] ** power


def where(mask, yes, no):
    """Where one, else the other."""
    return np.where(mask, yes, no)


def _shifted_rows(case, name, by):
    return np.roll(case.inputs[name], by, axis=0)


PLANTS = (
    # Jacobian
    TermPlant("J d_to", "jacobian", times("jacobian", lambda c: jac(c)[2]), ("d_to",)),
    TermPlant(
        "J without cos φ_from",
        "jacobian",
        times("jacobian", lambda c: jac(c)[3]),
        ("times cos φ_from",),
    ),
    TermPlant(
        "J with cos² φ_to",
        "jacobian",
        times("jacobian", lambda c: jac(c)[4]),
        ("times cos φ_to",),
    ),
    TermPlant(
        "J cubed distances",
        "jacobian",
        times("jacobian", lambda c: jac(c)[1] / jac(c)[2]),
        ("d_from / d_to",),
    ),
    TermPlant(
        "J cut at 20",
        "jacobian",
        replaced("jacobian", lambda c, J, o: np.minimum(J, 20)),
        ("cut off at 20",),
    ),
    TermPlant(
        "J refused beyond 5",
        "jacobian",
        replaced("jacobian", lambda c, J, o: where(J > 5, 0, J)),
        ("is 0 where the right one > 5",),
    ),
    TermPlant(
        "J squared",
        "jacobian",
        replaced("jacobian", lambda c, J, o: np.minimum(J**2, 1e30)),
        ("the square of what is right",),
    ),
    # target
    TermPlant(
        "albedo squared",
        "target",
        times("p_hat", lambda c: lit(c)[1]),
        ("times Y(albedo)",),
    ),
    TermPlant(
        "no 1/π, cosine twice",
        "target",
        times("p_hat", lambda c: np.pi * around(c)[1]),
        ("times π · cos θ",),
    ),
    TermPlant(
        "over d²",
        "target",
        times("p_hat", lambda c: 1 / around(c)[0] ** 2),
        ("divided by d²",),
    ),
    TermPlant(
        "geometry term",
        "target",
        times("p_hat", lambda c: around(c)[2] / around(c)[0] ** 2),
        ("cos φ / d²",),
    ),
    TermPlant(
        "root of target",
        "target",
        replaced("p_hat", lambda c, p, o: np.sqrt(p)),
        ("the root of what is right",),
    ),
    TermPlant(
        "fireflies of 100 cut",
        "target",
        replaced("p_hat", lambda c, p, o: np.minimum(p, 100)),
        ("cut off at 100",),
    ),
    TermPlant(
        "near samples are refused",
        "target",
        times("p_hat", lambda c: around(c)[0] > 0.3),
        ("is 0 where d < 0.3",),
    ),
    # initial
    TermPlant(
        "W over pdf's root",
        "initial",
        times("W", lambda c: np.sqrt(c.inputs["pdf"])),
        ("√pdf", "times 1/√(2π)"),
    ),
    TermPlant(
        "W of 4π", "initial", times("W", lambda c: np.full(c.rows, 2.0)), ("times 2",)
    ),
    TermPlant(
        "W with d²/cos φ",
        "initial",
        times("W", lambda c: around(c)[0] ** 2 / around(c)[2]),
        ("d² / cos φ",),
    ),
    TermPlant(
        "M of nulls 0",
        "initial",
        times("M", lambda c: lit(c)[0] > 0),
        ("is 0 where the sample is a null",),
    ),
    # finalize
    TermPlant(
        "Z under a root",
        "finalize",
        times("W", lambda c: np.sqrt(c.inputs["Z"])),
        ("√Z",),
    ),
    TermPlant(
        "p_hat² ",
        "finalize",
        times("W", lambda c: 1 / c.inputs["p_hat"]),
        ("divided by p_hat",),
    ),
    TermPlant(
        "Z + 1",
        "finalize",
        given(Z=lambda c: c.inputs["Z"] + 1),
        ("Z + 1",),
    ),
    TermPlant(
        "W cut at 7",
        "finalize",
        replaced("W", lambda c, W, o: np.minimum(W, 7)),
        ("cut off at 7",),
    ),
    # merge
    TermPlant(
        "M as int of mean",
        "merge",
        replaced("M", lambda c, M, o: M + 1),
        ("larger by 1",),
    ),
    TermPlant(
        "w twice b",
        "merge",
        replaced("w", lambda c, w, o: w + c.inputs["w_b"]),
        ("larger by w_b",),
    ),
    # direction
    TermPlant(
        "pdf of 1/π for cosine, squared",
        "direction",
        replaced(
            "pdf",
            lambda c, p, o: p * np.pi * p if c.settings["source"] == "cosine" else p,
        ),
        ("where source is cosine",),
    ),
    # shade
    TermPlant(
        "albedo under a root",
        "shade",
        replaced(
            "color", lambda c, x, o: x / np.sqrt(np.maximum(c.inputs["albedo"], 1e-20))
        ),
        ("divided by √albedo",),
    ),
    TermPlant(
        "2π", "shade", times("color", lambda c: np.full(c.rows, 0.5)), ("times 1/2",)
    ),
    TermPlant(
        "over d", "shade", times("color", lambda c: 1 / around(c)[0]), ("divided by d",)
    ),
    TermPlant(
        "cos φ", "shade", times("color", lambda c: around(c)[2]), ("times cos φ",)
    ),
    TermPlant("W²", "shade", times("color", lambda c: c.inputs["W"]), ("times W",)),
    TermPlant(
        "row off by one",
        "shade",
        given(
            **{
                name: (lambda c, name=name: _shifted_rows(c, name, 1))
                for name in (
                    "visible_position",
                    "visible_normal",
                    "albedo",
                    "position",
                    "normal",
                    "radiance",
                    "W",
                )
            }
        ),
        ("the row before",),
    ),
    TermPlant(
        "clamped at 3",
        "shade",
        replaced("color", lambda c, x, o: np.minimum(x, 3)),
        ("cut off at 3",),
    ),
    # temporal
    TermPlant("W d²", "temporal", closing(lambda c, o, d, ct, cp: d**2), ("times d²",)),
    TermPlant(
        "W / cos φ",
        "temporal",
        closing(lambda c, o, d, ct, cp: 1 / cp),
        ("divided by cos φ",),
    ),
    TermPlant(
        "cos φ, past only",
        "temporal",
        closing(lambda c, o, d, ct, cp: where(kept_is(c, o, "past_"), cp, 1)),
        ("times cos φ where the past is kept",),
    ),
    TermPlant(
        "M twice at the cap",
        "temporal",
        replaced("M", lambda c, M, o: where(c.settings["cap"] > M, M, 2 * M)),
        ("times 2",),
    ),
    TermPlant(
        "int of M", "temporal", replaced("M", lambda c, M, o: M + 1), ("larger by 1",)
    ),
    TermPlant(
        "W cut at 17",
        "temporal",
        replaced("W", lambda c, W, o: np.minimum(W, 17)),
        ("cut off at 17",),
    ),
    TermPlant(
        "past with W²",
        "temporal",
        given(past_W=lambda c: c.inputs["past_W"] ** 2),
        ("the past",),
    ),
    TermPlant(
        "past with W d²",
        "temporal",
        given(past_W=lambda c: c.inputs["past_W"] * around(c, "past_")[0] ** 2),
        ("the past",),
    ),
    TermPlant(
        "pdf under a root",
        "temporal",
        given(new_pdf=lambda c: np.sqrt(c.inputs["new_pdf"])),
        ("the new sample",),
    ),
    TermPlant(
        "pdf times cosine",
        "temporal",
        given(new_pdf=lambda c: c.inputs["new_pdf"] * around(c, "new_")[1]),
        ("the new sample",),
    ),
    TermPlant(
        "target over d²",
        "temporal",
        own_temporal(target=distance(-2)),
        ("p̂ is right divided by d²",),
    ),
    TermPlant(
        "target with cosine twice",
        "temporal",
        own_temporal(target=lambda c, p, k: p * around(c, k)[1]),
        ("p̂ is right times cos θ",),
    ),
    TermPlant(
        "decided by √w",
        "temporal",
        own_temporal(decided=lambda c, w, k: np.sqrt(w)),
        ("√w for w",),
    ),
    TermPlant(
        "decided without M",
        "temporal",
        own_temporal(
            decided=lambda c, w, k: (
                w / np.maximum(c.inputs["past_M"], 1) if k == "past_" else w
            )
        ),
        ("w divided by M for w",),
    ),
    TermPlant(
        "decided by u²", "temporal", own_temporal(u=lambda c, u: u**2), ("u² for u",)
    ),
    TermPlant(
        "u of the row before",
        "temporal",
        own_temporal(u=lambda c, u: np.roll(u, 1)),
        ("the u of the row before",),
    ),
    TermPlant(
        "weights at most 2",
        "temporal",
        own_temporal(weight=lambda c, w, k: np.minimum(w, 2) if k == "past_" else w),
        ("w of the past is cut off at 2",),
    ),
    # moved
    TermPlant(
        "J without cos φ_from",
        "moved",
        given(past_W=lambda c: c.inputs["past_W"] * moved_jacobian(c)[3]),
        ("the past",),
    ),
    TermPlant(
        "J cut at 3/2",
        "moved",
        given(
            past_W=lambda c: (
                c.inputs["past_W"]
                * np.minimum(moved_jacobian(c)[0], 1.5)
                / moved_jacobian(c)[0]
            )
        ),
        ("J of the past is cut off at 1.5",),
    ),
    TermPlant(
        "J refused beyond 1.2",
        "moved",
        given(past_W=lambda c: c.inputs["past_W"] * (moved_jacobian(c)[0] <= 1.2)),
        ("is 0 where J > 1.2",),
    ),
    TermPlant(
        "W over 2π",
        "moved",
        closing(lambda c, o, d, ct, cp: d * 0 + 1 / (2 * np.pi)),
        ("1/2π",),
    ),
    # spatial
    TermPlant("W d²", "spatial", closing(lambda c, o, d, ct, cp: d**2), ("times d²",)),
    TermPlant(
        "W cos θ", "spatial", closing(lambda c, o, d, ct, cp: ct), ("times cos θ",)
    ),
    TermPlant(
        "own and neighbours with W²",
        "spatial",
        given(W=lambda c: c.inputs["W"] ** 2),
        ("w of the pixel's own and the neighbours is right times W",),
    ),
    TermPlant(
        "past with W d²",
        "spatial",
        given(past_W=lambda c: c.inputs["past_W"] * around(c, "past_")[0] ** 2),
        ("the past",),
    ),
    TermPlant(
        "M is 1 more", "spatial", replaced("M", lambda c, M, o: M + 1), ("larger by 1",)
    ),
    TermPlant(
        "W cut at 25",
        "spatial",
        replaced("W", lambda c, W, o: np.minimum(W, 25)),
        ("cut off at 25",),
    ),
    # further
    TermPlant(
        "depth is distance over two",
        "gbuffer",
        times("depth", lambda c: np.full(c.rows, 0.5)),
        ("times 1/2",),
    ),
    TermPlant(
        "M stays",
        "validation",
        lambda c: becomes(right(c), M=c.inputs["M"]),
        ("is the given M",),
    ),
    TermPlant(
        "halves", "boiling", replaced("W", lambda c, W, o: W / 2), ("times 1/2",)
    ),
    TermPlant(
        "weight squared",
        "roulette",
        replaced("weight", lambda c, w, o: w**2),
        ("square of what is right", "is 4", "times 2"),
    ),
    TermPlant(
        "flag turned",
        "checkerboard",
        replaced("draws", lambda c, x, o: 1 - x),
        ("1 minus",),
    ),
    TermPlant(
        "p root",
        "path_jacobian",
        times("jacobian", lambda c: np.sqrt(c.inputs["p_from"])),
        ("√p_from",),
    ),
    TermPlant(
        "x π", "path_reuse", replaced("W", lambda c, W, o: W * np.pi), ("times π",)
    ),
)


def jac(case):
    """Of pass jacobian."""
    i = case.inputs
    return jacobian_of(i["x_from"], i["x_to"], i["position"], i["normal"])
