"""Mistakes that the oracle's author has not seen: reconnection, weights, M and Z.

A held-out set: written from the code of the passes and from the bug catalogue, without
sight of the oracle.  All are of kind 'bias'.  The other half is in
:mod:`tests.mutants.held_out_more`.
"""

from tests.mutants.catalogue import (
    AT_NEIGHBOR,
    CAP,
    CLOSE,
    CLOSE_S,
    COSINES,
    COULD,
    JACOBIAN,
    JACOBIAN_OF_NEIGHBOR,
    LIMITED,
    LOOKS,
    MERGED,
    MIS,
    PIXELS,
    REPLACE,
    RESERVOIR,
    REUSED,
    SHIFT,
    SHIFTED,
    SPATIAL,
    SUM_M,
    SUM_Z,
    TAKE,
    TARGET,
    TEMPORAL,
    Mutant,
)
from tests.mutants.held_out_more import HELD_OUT_MORE

Z_TERMS = (
    "terms = [np.where(holds, M, M * 0) for M, holds in zip(M_k, holds_k, strict=True)]"
)

WHOLE_GEOMETRY_TERM = """y, x_q = self.reservoirs.y, self.q.points
        n_from = take(self.frame.visible.surface.normal, np.maximum(self.rows, 0))
        from restir_gi.reference.scene.surface import direction_and_distance

        u_from, _ = direction_and_distance(self.x.position, y.position)
        u_to, _ = direction_and_distance(x_q.position, y.position)
        c_from = np.maximum((n_from * u_from).sum(axis=1), 1e-4)
        c_to = np.maximum((x_q.normal * u_to).sum(axis=1), 0.0)
        return self.q.shift(self.x.position, x_q.position, y) * c_to / c_from"""

UNTIL_THE_FIRST = """terms, on = [], holds_k[0] | True
    for M, holds in zip(M_k, holds_k, strict=True):
        on = on & (holds | (M == 0))
        terms.append(np.where(on, M, M * 0))"""

LESS_TRUST = f"""from numpy import where

    {REPLACE}old = R.candidates[0]
    trust = where(new.w * old.M > 2.0 * old.w, 0.25, 1.0)
    R = begin(replace(old, w=old.w * trust, M=old.M * trust))
    {MERGED}"""

REC_601 = f"""from numpy import maximum

    from restir_gi.reference.resampling.target import luminance

    {REPLACE}c = R.kept
    shown = q.points.color * c.y.radiance
    other = shown @ (0.299, 0.587, 0.114) / maximum(luminance(shown), 1e-30)
    c = replace(c, p_hat=c.p_hat * other)
    {CLOSE.replace("R.kept", "c")}"""

OLD_W = f"""from numpy import maximum, where

    {REPLACE}kept, first = finalize(R.kept, Z), R.candidates[0]
    before = first.w / maximum(first.p_hat * first.M, 1e-30)
    kept = replace(kept, W=where(R.slot == 0, before, kept.W))
    return cap_confidence(kept, cap)"""

ONCE_EACH = f"""before = [
                n.rows == q_n.rows
                for n in Q[1:slot]
                if not isinstance(n, Candidates | Reservoirs)
            ]
            {COULD}
            could[slot] = could[slot] & ~np.any(before, axis=0)"""

BETWEEN_THE_TWO = """at, n = self.q.points.position, self.q.points.normal
        y = replace(y, position=at, normal=n)
        return sees(self.frame.world, self.x, y, possible)"""


def spatially(edit: str) -> str:
    """The same edit on the page of Algorithm 4."""
    return edit.replace("R.", "R_s.")


HELD_OUT: tuple[Mutant, ...] = (
    Mutant(
        "the Jacobian is the ratio of whole geometry terms",
        ("JC-05", "IS-05"),
        PIXELS,
        JACOBIAN_OF_NEIGHBOR,
        WHOLE_GEOMETRY_TERM,
    ),
    Mutant(
        "the Jacobian's cosines are taken with the receiver's normal",
        ("JC-05",),
        PIXELS,
        JACOBIAN_OF_NEIGHBOR,
        "y = replace(self.reservoirs.y, normal=self.q.points.normal)\n"
        "        return self.q.shift(self.x.position, self.q.points.position, y)",
    ),
    Mutant(
        "the source's cosine is left out of the Jacobian",
        ("JC-15",),
        SHIFT,
        f"divide_or_zero({COSINES})\n        {JACOBIAN}",
        "abs(dot(n_sample, v_to)) / sqrt(dot(v_to, v_to))\n"
        "        jacobian = cosines * ratio * ratio",
    ),
    Mutant(
        "the squared distances of the Jacobian are kept away from 0",
        ("JC-11",),
        SHIFT,
        "divide_or_zero(dot(v_from, v_from), dot(v_to, v_to))",
        "(dot(v_from, v_from) + 0.1) / (dot(v_to, v_to) + 0.1)",
    ),
    Mutant(
        "the Jacobian is in the target that divides, too",
        ("JC-13",),
        RESERVOIR,
        "w = w * jacobian",
        "w, p_hat = w * jacobian, p_hat * jacobian",
    ),
    Mutant(
        "samples that the source sees edge-on, within 6 degrees, are refused",
        ("JC-12", "JC-15"),
        SHIFT,
        LIMITED,
        "edge = abs(dot(n_sample, v_from)) < 0.1 * sqrt(dot(v_from, v_from))\n"
        "    return np.where(edge, 0.0, saturate(jacobian))",
    ),
    Mutant(
        "the weight has the source's target, W the receiver's",
        ("SR-09",),
        REUSED,
        SHIFTED,
        TAKE
        + SHIFTED.replace("q.target(R_n.y)", AT_NEIGHBOR)
        + "\n    c = replace(c, p_hat=q.target(R_n.y))",
    ),
    Mutant(
        "weighted by the luminance of Rec. 709, divided by that of 601",
        ("PK-13",),
        TEMPORAL,
        CLOSE,
        REC_601,
        also=((SPATIAL, CLOSE_S, spatially(REC_601)),),
    ),
    Mutant(
        "samples are chosen by target alone",
        ("IS-25", "SR-10"),
        RESERVOIR,
        "choose_second(a.w, b.w, u)",
        "choose_second(a.p_hat * (a.w > 0), b.p_hat * (b.w > 0), u)",
    ),
    Mutant(
        "M grows only where the sample is taken",
        ("SR-25",),
        RESERVOIR,
        "M = a.M + b.M",
        "M = a.M + b.M * take_b",
    ),
    Mutant(
        "W is refreshed only where the sample changes",
        ("TR-01", "IN-03"),
        TEMPORAL,
        CLOSE,
        OLD_W,
        also=((SPATIAL, CLOSE_S, spatially(OLD_W)),),
    ),
    Mutant(
        "M starts over where no sample was kept",
        ("SR-25", "RG-01"),
        RESERVOIR,
        CAP,
        "W=r.W, M=np.where(r.W > 0, np.minimum(r.M, cap), 1.0)",
    ),
    Mutant(
        "M is capped in Z alone",
        ("TR-01", "SR-02"),
        REUSED,
        SUM_Z,
        SUM_Z.replace("R.M", "[np.minimum(M, 8) for M in R.M]"),
        also=(
            (REUSED, SUM_M, SUM_M.replace("R.M", "[np.minimum(M, 8) for M in R.M]")),
        ),
    ),
    Mutant(
        "the past is trusted less where the new sample outshines it",
        ("TR-07",),
        TEMPORAL,
        MERGED,
        LESS_TRUST,
    ),
    Mutant(
        "Z counts those whose own sample had a weight",
        ("SR-05", "SR-25"),
        REUSED,
        COULD,
        "could[slot] = R.candidates[slot].w > 0",
    ),
    Mutant(
        "Z asks whether source and receiver see each other",
        ("SR-05",),
        PIXELS,
        LOOKS,
        BETWEEN_THE_TWO,
    ),
    Mutant(
        "Z asks that the source has the sample 6 degrees above its horizon",
        ("SR-05", "JC-12"),
        TARGET,
        "holds &= dot(take(surface.normal, rows), toward) > 0",
        "least = 0.1 * np.sqrt(dot(toward, toward))\n"
        "    holds &= dot(take(surface.normal, rows), toward) > least",
        also=(
            (
                TARGET,
                "drawn = source_pdf(source, table, points, omega) > 0",
                "drawn = dot(points.normal, omega) > 0.1",
            ),
        ),
    ),
    Mutant(
        "the loop over Z ends at the first that could not have made it",
        ("SR-02", "SR-25"),
        MIS,
        Z_TERMS,
        UNTIL_THE_FIRST,
    ),
    Mutant(
        "a neighbour drawn twice is merged twice, and counted once in Z",
        ("HS-17",),
        REUSED,
        COULD,
        ONCE_EACH,
    ),
    *HELD_OUT_MORE,
)
