"""Mistakes in pairs of paths, and in images that are made from differences.

In the manner of :mod:`tests.mutants.catalogue`.  Of section 8 one cannot be planted:
nothing is left uninitialised where no sample was chosen (GD-27).
"""

from tests.mutants.catalogue import Mutant

PAGE, PAIRS = (
    f"restir_gi.gradient_domain.{name}" for name in ("gradient_restir", "pairs")
)
SOLVER, ROBUST, ADJOINT, METHOD = (
    f"restir_gi.gradient_domain.{name}"
    for name in ("reconstruction", "least_absolute", "reconstruction", "method")
)
WINDOWS = "restir_gi.extensions.area_restir"

SIGNED = "found: Vec3s = np.where((value.k == 0)[:, None], own, -own)"
JACOBIAN = "return scatter(at, value, size), jacobian"

GRADIENT_MUTANTS = [
    Mutant(
        "pairs of one normal are edges",
        ("GD-01",),
        PAGE,
        "facing < limits.cosine",
        "facing > limits.cosine",
    ),
    Mutant(
        "new samples of both pixels are weighted by one half",
        ("GD-03",),
        PAGE,
        "Candidates(y, p_hat, p_hat * r.W, r.M)",
        "Candidates(y, p_hat, p_hat * r.W / 2, r.M)",
    ),
    Mutant(
        "differences have the sign of the paper's",
        ("GD-05",),
        PAIRS,
        "scatter(pairs.first[at], -delta[at], pixels)",
        "scatter(pairs.first[at], delta[at], pixels)",
    ),
    Mutant(
        "the negative part is added",
        ("GD-07",),
        PAGE,
        "one_sided = sign * np.maximum(",
        "one_sided = sign * sign * np.maximum(",
    ),
    Mutant(
        "the target is the magnitude of the luminance",
        ("GD-09",),
        PAGE,
        "return luminance(np.abs(contribution(value)))",
        "return np.abs(luminance(integrand(value)))",
    ),
    Mutant(
        "samples are shifted twice",
        ("GD-11",),
        PAGE,
        "between(samples.base, pixel, dx, dy)",
        "between(samples.base, pixel, dx + dx, dy + dy)",
    ),
    Mutant(
        "the outer Jacobian is that of the offset path",
        ("GD-13",),
        PAGE,
        JACOBIAN,
        "return scatter(at, value, size), jacobian * np.where("
        "scatter(at, value.inner, size) > 0, scatter(at, value.inner, size), 1)",
    ),
    Mutant(
        "there is no outer Jacobian",
        ("GD-13",),
        PAGE,
        JACOBIAN,
        "return scatter(at, value, size), (jacobian > 0) * (jacobian * 0 + 1)",
    ),
    Mutant(
        "the weight of the base path is left out",
        ("GD-15",),
        PAGE,
        "return difference(value) * share_of_base(one, one, value.inner)[:, None]",
        "return difference(value)",
    ),
    Mutant(
        "shown is what has not the weight of the base path",
        ("GD-15",),
        PAGE,
        "terms = [contribution(r.y.value) * r.W[:, None] for r in reservoirs]",
        "terms = ["
        "(contribution(r.y.value) != 0) * difference(r.y.value) * r.W[:, None]"
        " for r in reservoirs]",
    ),
    Mutant(
        "new samples that are worth nothing are not counted",
        ("GD-17",),
        PAGE,
        "replace(kept, M=one)",
        "replace(kept, M=(kept.w > 0) * one)",
    ),
    Mutant(
        "base paths without offset path are thrown away",
        ("GD-19",),
        PAGE,
        "    own = value.base.value - value.offset * value.inner[:, None]\n",
        "    own = value.base.value - value.offset * value.inner[:, None]\n"
        "    own = np.where((value.inner > 0)[:, None], own, 0 * own)\n",
    ),
    Mutant(
        "base paths without offset path have half the weight",
        ("GD-19",),
        PAGE,
        "(p_base > 0) + 0 * jacobian)",
        "((p_base > 0) + 0 * jacobian) / 2)",
    ),
    Mutant(
        "small Jacobians are refused on the way there alone",
        ("GD-21",),
        PAGE,
        "return outer_shift(\n            self.shift,\n",
        "value, jacobian = outer_shift(\n            self.shift,\n",
        also=(
            (
                PAGE,
                "            sign=self.sign,\n        )\n",
                "            sign=self.sign,\n        )\n"
                "        return value, jacobian * (jacobian >= 0.75)\n",
            ),
        ),
    ),
    Mutant(
        "pairs move with the farther pixel",
        ("GD-23",),
        PAIRS,
        "second = depth[pairs.second] < depth[pairs.first]",
        "second = depth[pairs.second] > depth[pairs.first]",
    ),
    Mutant(
        "the past has the confidence of a new sample",
        ("GD-25",),
        WINDOWS,
        "kept = resample([*before, own]",
        "kept = resample([*(replace(d, reservoirs=replace(d.reservoirs,"
        " M=d.reservoirs.M * 0 + 1)) for d in before), own]",
    ),
    Mutant(
        "the other k is taken at the other pair",
        (),
        PAGE,
        "pixel = np.where(k == 0, pairs.first, pairs.second)",
        "pixel = np.where(k == 1, pairs.first, pairs.second)",
    ),
    Mutant(
        "offset paths remain those of the other pair",
        (),
        PAGE,
        "offset, inner = inner_shift(between, base, k, pairs)",
        "offset, inner = samples.offset[at], samples.inner[at]",
    ),
    Mutant(
        "the difference of k = 1 has the sign of k = 0",
        (),
        PAGE,
        SIGNED,
        "found: Vec3s = own",
    ),
    Mutant(
        "the offset path has no Jacobian",
        (),
        PAGE,
        "own = value.base.value - value.offset * value.inner[:, None]",
        "own = value.base.value - value.offset",
    ),
    Mutant(
        "sources of the other sign are taken for the receiver's",
        (),
        PAGE,
        "sign=self.sign_from,",
        "sign=self.sign,",
    ),
    Mutant(
        "a pair takes over its own samples once more",
        (),
        PAIRS,
        "return np.where(found == rows, NONE, found)",
        "return found",
    ),
]

IMAGE_MUTANTS = [
    Mutant(
        "differences to the right and down are exchanged",
        ("RC-01",),
        METHOD,
        "Differences(x, y), width)",
        "Differences(y, x), width)",
    ),
    Mutant(
        "differences at the borders lead to the other side",
        ("RC-03",),
        ADJOINT,
        "total[:, 1:] += x[:, :-1]",
        "total += np.roll(x, 1, axis=1) + np.roll(-x * 0 + 1e-3, 1, axis=1)",
    ),
    Mutant(
        "the image begins from nothing, and has few steps",
        ("RC-05",),
        ROBUST,
        "    for _ in range(STEPS):",
        "    image, off = primal * 0, [a * 0 for a in off]\n    for _ in range(2):",
    ),
    Mutant(
        "an image of least absolute values passes for unbiased",
        ("RC-07",),
        METHOD,
        'if job.settings.reconstruction == "l1":',
        "if False:",
    ),
    Mutant(
        "differences are divided by the number of frames once more",
        ("RC-09",),
        METHOD,
        "Differences(x, y), width)",
        'Differences(x / job.counts["frames"], y / job.counts["frames"]), width)',
    ),
    Mutant(
        "alpha weighs the squares",
        (),
        SOLVER,
        "right = alpha * alpha * primal + spread_back(d, width)\n"
        "    return screened(right, width, alpha * alpha)",
        "right = alpha * primal + spread_back(d, width)\n"
        "    return screened(right, width, alpha)",
    ),
]
