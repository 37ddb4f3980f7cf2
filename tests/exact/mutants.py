"""Mistakes to plant: source of a kernel, or of the toy passes, with one line changed.

Each entry is a mistake that somebody made, or nearly made: in a paper, a note, or a
renderer.  ``killed_by`` names claims of :mod:`tests.exact.claims` that refute it.
"""

import inspect
from dataclasses import dataclass
from fractions import Fraction
from types import ModuleType, SimpleNamespace

import numpy as np

from reference.resampling import mis, pairwise, reservoir, shift
from tests.exact import claims, pipeline

MODULES = {
    "reservoir": reservoir,
    "mis": mis,
    "pairwise": pairwise,
    "shift": shift,
    "pipeline": pipeline,
}

PRODUCTION = SimpleNamespace(**MODULES)


@dataclass(frozen=True, slots=True)
class Mutant:
    """One edit: ``old`` occurs once in the module and becomes ``new``."""

    name: str
    module: str
    old: str
    new: str
    killed_by: tuple[str, ...] = ()

    def plant(self):
        """Return the kernels and toy passes with the mistake in them."""
        module = edited(MODULES[self.module], self.old, self.new)
        return SimpleNamespace(**{**MODULES, self.module: module})


def edited(module, old, new):
    """Run a module's source with one piece of text replaced."""
    source = inspect.getsource(module)
    assert source.count(old) == 1, f"{module.__name__} has not one {old!r}"
    mutant = ModuleType(f"{module.__name__} with {new!r}")
    mutant.__dict__.update(Fraction=Fraction, np=np)
    exec(compile(source.replace(old, new), mutant.__name__, "exec"), mutant.__dict__)
    return mutant


MUTANTS = [
    # The Jacobian.
    Mutant(
        "the Jacobian is left out",
        "reservoir",
        "w = w * jacobian",
        "w = w * 1",
        ("spatial_pass", "balance_pass"),
    ),
    Mutant(
        "the weight is divided by the Jacobian",
        "reservoir",
        "w = w * jacobian",
        "w = divide_or_zero(w, jacobian)",
        ("spatial_pass", "balance_pass"),
    ),
    Mutant(
        "the Jacobian is clamped to [1/3, 3]",
        "shift",
        "return saturate(jacobian)",
        "return np.minimum(np.maximum(jacobian, Fraction(1, 3)), 3)",
        ("spatial_pass",),
    ),
    Mutant(
        "the distances are not squared",
        "shift",
        "cosines * ratio * ratio * ratio",
        "cosines * ratio * ratio",
        ("spatial_pass",),
    ),
    Mutant(
        "the cosines are left out",
        "shift",
        "cosines * ratio * ratio * ratio",
        "ratio * ratio",
        ("spatial_pass",),
    ),
    Mutant(
        "the cosines are upside down",
        "shift",
        "abs(dot(n_sample, v_to)), abs(dot(n_sample, v_from))",
        "abs(dot(n_sample, v_from)), abs(dot(n_sample, v_to))",
        ("spatial_pass",),
    ),
    Mutant(
        "donor and receiver change places",
        "pipeline",
        "ratio = jacobian(code, j, i, r.y) if",
        "ratio = jacobian(code, i, j, r.y) if",
        ("spatial_pass",),
    ),
    # Confidence.
    Mutant(
        "new samples that found nothing do not count",
        "reservoir",
        "M=np.ones_like(w)",
        "M=np.where(w > 0, 1, 0)",
        ("several_candidates", "temporal_chain"),
    ),
    Mutant(
        "neighbours whose sample is hidden do not count",
        "pipeline",
        "np.where(usable, c.w, Fraction(0)), r.M)",
        "np.where(usable, c.w, Fraction(0)), np.where(usable, r.M, Fraction(0)))\n"
        "            r = k.Reservoirs(r.y, r.W, c.M)",
        ("spatial_pass",),
    ),
    Mutant(
        "M of a merged reservoir is 1",
        "reservoir",
        "M = a.M + b.M",
        "M = a.M + 1",
        ("spatial_pass",),
    ),
    Mutant(
        "M of the reservoir is missing in its weight",
        "reservoir",
        "w = p_hat * r.W * r.M",
        "w = p_hat * r.W",
        ("spatial_pass", "temporal_chain"),
    ),
    # The cap.
    Mutant(
        "M is capped before it divides",
        "pipeline",
        "total = code.mis.one_over_m([old.M, new.M])",
        "total = np.minimum(code.mis.one_over_m([old.M, new.M]), cap)",
        ("temporal_chain",),
    ),
    Mutant(
        "the running weight outlives the cap",
        "reservoir",
        "W=r.W, M=np.minimum(r.M, cap)",
        "W=r.W * r.M / np.minimum(r.M, cap), M=np.minimum(r.M, cap)",
        ("temporal_chain",),
    ),
    Mutant(
        "the cap is put on the weight",
        "reservoir",
        "W=r.W, M=np.minimum(r.M, cap)",
        "W=r.W * np.minimum(r.M, cap) / r.M, M=r.M",
        ("temporal_chain",),
    ),
    Mutant(
        "M is capped at every pass",
        "pipeline",
        "sources, M = [*sources, j], [*M, r.M]",
        "sources, M = [*sources, j], [*M, np.minimum(r.M, 2)]",
        ("spatial_pass",),
    ),
    # The choice.
    Mutant(
        "chosen by the ratio to the old sum",
        "reservoir",
        "u * (w_a + w_b) < w_b",
        "u * w_a < w_b",
        (
            "several_candidates",
            "temporal_chain",
            "spatial_pass",
            "one_law_of_all_associations",
        ),
    ),
    Mutant(
        "the newer sample always wins",
        "reservoir",
        "(u * (w_a + w_b) < w_b)",
        "(w_b > 0)",
        ("several_candidates", "temporal_chain", "spatial_pass"),
    ),
    Mutant(
        "one random number for two decisions",
        "pipeline",
        "    for slot, (j, r) in enumerate(donors):",
        "    u = uniform()\n"
        "    uniform = lambda: u\n"
        "    for slot, (j, r) in enumerate(donors):",
        ("spatial_pass",),
    ),
    Mutant(
        "the sum of weights forgets what came before",
        "reservoir",
        "w = a.w + b.w",
        "w = b.w",
        ("several_candidates",),
    ),
    # The target.
    Mutant(
        "target of the sample at its donor",
        "pipeline",
        "p_hat = P_HAT[i][r.y]\n        ratio",
        "p_hat = P_HAT[j][r.y]\n        ratio",
        ("spatial_pass",),
    ),
    Mutant(
        "target of the sample that lost",
        "reservoir",
        "np.where(take_b, b.p_hat, a.p_hat)",
        "a.p_hat",
        ("several_candidates",),
    ),
    Mutant(
        "source density left out",
        "reservoir",
        "w = divide_or_zero(p_hat, pdf)",
        "w = p_hat",
        ("several_candidates",),
    ),
    Mutant(
        "divided by the target of the receiver's own sample",
        "pipeline",
        "c = k.Candidates(z, chosen.p_hat,",
        "c = k.Candidates(z, P_HAT[i][donors[0][1].y],",
        ("spatial_pass",),
    ),
    # Visibility and the normalization.
    Mutant(
        "1/M in place of 1/Z",
        "mis",
        "terms = [np.where(holds, M, M * 0)",
        "terms = [M",
        ("spatial_pass", "two_passes"),
    ),
    Mutant(
        "Z counts pixels without their M",
        "mis",
        "np.where(holds, M, M * 0)",
        "np.where(holds, 1, 0)",
        ("spatial_pass",),
    ),
    Mutant(
        "Z does not ask for visibility",
        "pipeline",
        "HELD[j][z] & (",
        "(P_HAT[j][z] > 0) & (",
        ("spatial_pass",),
    ),
    Mutant(
        "Z does not ask for the horizon",
        "pipeline",
        "HELD[j][z] & (",
        "SEEN[j][z] & (",
        ("spatial_pass",),
    ),
    Mutant(
        "Z asks for the receiver's view in place of the donor's",
        "pipeline",
        "HELD[j][z] & (",
        "HELD[i][z] & (",
        ("spatial_pass",),
    ),
    Mutant(
        "Z forgets the pixel's own reservoir",
        "pipeline",
        "list(held)",
        "[slot == 0, *held[1:]]",
        ("spatial_pass",),
    ),
    Mutant(
        "Z forgets who made the sample",
        "pipeline",
        "return code.mis.one_over_z(M, list(held))",
        "made = [h & (slot != s) for s, h in enumerate(held)]\n"
        "        return code.mis.one_over_z(M, [made[0] | True, *made[1:]])",
        ("spatial_pass",),
    ),
    Mutant(
        "hidden samples are reused and then kept",
        "pipeline",
        "usable = usable & SEEN[i][r.y]",
        "pass",
        ("spatial_pass",),
    ),
    Mutant(
        "the late test of visibility is forgotten",
        "pipeline",
        'if visibility == "chosen":',
        'if visibility == "never":',
        ("pass_with_late_visibility",),
    ),
    Mutant(
        "a limit on the Jacobian that Z does not know",
        "pipeline",
        " & (jacobian(code, j, i, z) <= limit)",
        "",
        ("pass_with_mirrored_limit",),
    ),
    Mutant(
        "a limit on the Jacobian that Z applies the other way round",
        "pipeline",
        " & (jacobian(code, j, i, z) <= limit)",
        " & (jacobian(code, i, j, z) <= limit)",
        ("pass_with_mirrored_limit",),
    ),
    Mutant(
        "balance heuristic for the receiver, whoever made the sample",
        "pipeline",
        "made = np.stack(p)[slot,",
        "made = np.stack(p)[0 * slot,",
        ("balance_pass",),
    ),
    Mutant(
        "balance heuristic without M",
        "mis",
        "saturate(M * p)",
        "saturate(p)",
        ("balance_pass",),
    ),
    Mutant(
        "p̂ is kept away from 0 where it divides",
        "reservoir",
        "divide_or_zero(c.w, c.p_hat), normalization",
        "divide_or_zero(c.w, np.maximum(c.p_hat, Fraction(1, 2))), normalization",
        ("several_candidates",),
    ),
    Mutant(
        "the weight W is limited",
        "reservoir",
        "return Reservoirs(y=c.y, W=saturate(W), M=c.M)",
        "return Reservoirs(y=c.y, W=np.minimum(W, Fraction(1, 2)), M=c.M)",
        ("several_candidates",),
    ),
    Mutant(
        "nothing divides the sum of weights",
        "reservoir",
        "W = divide_or_zero(divide_or_zero(c.w, c.p_hat), normalization)",
        "W = divide_or_zero(c.w, c.p_hat)",
        ("several_candidates",),
    ),
    # Weights in pairs.
    Mutant(
        "the donors' confidences include the canonical one",
        "pipeline",
        "S = sum(M_k) + M_c * 0",
        "S = sum(M)",
        ("pairwise_pass", "defensive_pass"),
    ),
    Mutant(
        "the canonical sample gets no share of its own",
        "pairwise",
        "divide_or_zero(plus(one_over_m(shares), M_c), plus(S, M_c))",
        "divide_or_zero(one_over_m(shares), plus(S, M_c))",
        ("defensive_pass",),
    ),
    Mutant(
        "each donor stands for itself alone in its pair",
        "pairwise",
        "M_k * _share(S, p_k, M_c, p_c)",
        "M_k * _share(M_k, p_k, M_c, p_c)",
        ("pairwise_pass", "defensive_pass"),
    ),
    Mutant(
        "pairs do not ask whether the donor could make the sample",
        "pipeline",
        "np.where(held, P_HAT[j][z]",
        "np.where(held | True, P_HAT[j][z]",
        ("pairwise_pass", "defensive_pass"),
    ),
    Mutant(
        "what is left of a pair goes to the wrong side",
        "pairwise",
        "M * _share(M_c, p_c, S, p)",
        "M * _share(S, p, M_c, p_c)",
        ("pairwise_pass", "defensive_pass"),
    ),
    # The loop.
    Mutant(
        "spatial history is merged without its M",
        "pipeline",
        "M = [*sources, j], [*M, r.M]",
        "M = [*sources, j], [*M, r.M if slot else r.M * 0 + 1]",
        ("loop_of_two_frames",),
    ),
]

SURVIVORS = [
    # Any weights that sum to 1 over the makers of a sample are unbiased.  These do, and
    # are noisier; the balance heuristic's own formula is tested in properties.
    Mutant(
        "balance heuristic without Jacobian",
        "pipeline",
        "P_HAT[j][z] * jacobian(code, i, j, z)",
        "P_HAT[j][z]",
    ),
    Mutant(
        "balance heuristic with the inverse Jacobian",
        "pipeline",
        "P_HAT[j][z] * jacobian(code, i, j, z)",
        "P_HAT[j][z] * jacobian(code, j, i, z)",
    ),
    # Differs where u w = w_b exactly: a set of measure 0, and two weights of 0.  Found
    # where single numbers are looked at, in properties.
    Mutant(
        "a tie goes to the newer sample",
        "reservoir",
        "u * (w_a + w_b) < w_b",
        "u * (w_a + w_b) <= w_b",
    ),
]
"""Mistakes that no expectation can see, with the reason."""

CLAIMS = [
    claims.several_candidates,
    claims.temporal_chain,
    claims.spatial_pass,
    claims.balance_pass,
    claims.pairwise_pass,
    claims.defensive_pass,
    claims.pass_with_late_visibility,
    claims.pass_with_mirrored_limit,
    claims.two_passes,
    claims.loop_of_two_frames,
    claims.one_law_of_all_associations,
]
"""All claims, in the order of their cost."""
