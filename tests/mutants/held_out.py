"""Mistakes that the oracle's author has not seen: reconnection, weights, M and Z.

A held-out set: written from the code of the passes and from the bug catalogue, without
sight of the oracle.  All are of kind 'bias'.  The other half is in
:mod:`tests.mutants.held_out_more`.
"""

from tests.mutants.catalogue import (
    AT_DONOR,
    CAP,
    COSINES,
    ENTRIES,
    JACOBIAN,
    LENT,
    LIMITED,
    LOOKS,
    MIS,
    MOVED,
    NORMALIZATION,
    RESAMPLE,
    RESERVOIR,
    SHIFT,
    TEMPORAL,
    WITHOUT,
    Mutant,
)
from tests.mutants.held_out_more import HELD_OUT_MORE

CLOSE = "kept = finalize(replace(chosen, y=y), total)"
COUNTED = "holds.append(p_k > 0)"
NEW_ENTRY = "entries.append(new_entry(receivers, initial, canonical, drawn))"
Z_TERMS = (
    "terms = [np.where(holds, M, M * 0) for M, holds in zip(M_k, holds_k, strict=True)]"
)

WHOLE_GEOMETRY_TERM = f"""{MOVED}
    from reference.scene.surface import direction_and_distance

    n_from = take(donors.visible.surface.normal, row)
    u_from, _ = direction_and_distance(x_from, y.position)
    u_to, _ = direction_and_distance(points.position, y.position)
    c_from = np.maximum((n_from * u_from).sum(axis=1), 1e-4)
    c_to = np.maximum((points.normal * u_to).sum(axis=1), 0.0)
    moved = replace(moved, factor=moved.factor * c_to / c_from)"""

UNTIL_THE_FIRST = """terms, on = [], holds_k[0] | True
    for M, holds in zip(M_k, holds_k, strict=True):
        on = on & (holds | (M == 0))
        terms.append(np.where(on, M, M * 0))"""

LESS_TRUST = f"""{NEW_ENTRY}
    if history:
        old, new = (entry.candidate for entry in entries)
        trust = np.where(new.w * old.M > 2.0 * old.w, 0.25, 1.0)
        old = replace(old, w=old.w * trust, M=old.M * trust)
        entries[0] = replace(entries[0], candidate=old)"""

REC_601 = f"""from reference.resampling.target import luminance

    shown = receivers.points.color * y.radiance
    other = shown @ (0.299, 0.587, 0.114) / np.maximum(luminance(shown), 1e-30)
    chosen = replace(chosen, p_hat=chosen.p_hat * other)
    {CLOSE}"""

OLD_W = f"""{CLOSE}
    first = entries[0].candidate
    before = first.w / np.maximum(first.p_hat * first.M, 1e-30)
    kept = replace(kept, W=np.where(chosen.y == 0, before, kept.W))"""

ONCE_EACH = """before = [
            e.origin.rows == entry.origin.rows for e in entries[1:place] if e.origin
        ]
        holds.append((p_k > 0) & ~np.any(before, axis=0))"""

BETWEEN_THE_TWO = """at = replace(
        y, position=receivers.points.position, normal=receivers.points.normal
    )
    seen = made | sees(donors.world, x_k, at, possible & ~made)"""

IMPORT_NUMPY = (
    RESAMPLE,
    "from dataclasses import dataclass, replace\n",
    "from dataclasses import dataclass, replace\n\nimport numpy as np\n",
)

HELD_OUT: tuple[Mutant, ...] = (
    Mutant(
        "the Jacobian is the ratio of whole geometry terms",
        ("JC-05", "IS-05"),
        ENTRIES,
        MOVED,
        WHOLE_GEOMETRY_TERM,
    ),
    Mutant(
        "the Jacobian's cosines are taken with the receiver's normal",
        ("JC-05",),
        ENTRIES,
        MOVED,
        "moved = shift(\n"
        "        settings, x_from, points.position, replace(y, normal=points.normal)\n"
        "    )",
    ),
    Mutant(
        "the donor's cosine is left out of the Jacobian",
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
        "samples that the donor sees edge-on, within 6 degrees, are refused",
        ("JC-12", "JC-15"),
        SHIFT,
        LIMITED,
        "edge = abs(dot(n_sample, v_from)) < 0.1 * sqrt(dot(v_from, v_from))\n"
        "    return np.where(edge, 0.0, saturate(jacobian))",
    ),
    Mutant(
        "the weight has the donor's target, W the receiver's",
        ("SR-09",),
        ENTRIES,
        "receivers.target(y), moved.factor",
        f"{AT_DONOR}.target(y), moved.factor",
        also=(
            (
                ENTRIES,
                WITHOUT,
                f"{WITHOUT}\n"
                "    candidate = replace(candidate, p_hat=receivers.target(y))",
            ),
        ),
    ),
    Mutant(
        "weighted by the luminance of Rec. 709, divided by that of 601",
        ("PK-13",),
        RESAMPLE,
        CLOSE,
        REC_601,
        also=(IMPORT_NUMPY,),
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
        RESAMPLE,
        CLOSE,
        OLD_W,
        also=(IMPORT_NUMPY,),
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
        NORMALIZATION,
        LENT,
        "[np.minimum(entry.candidate.M, 8) for entry in entries]",
    ),
    Mutant(
        "the past is trusted less where the new sample outshines it",
        ("TR-07",),
        TEMPORAL,
        NEW_ENTRY,
        LESS_TRUST,
    ),
    Mutant(
        "Z counts those whose own sample had a weight",
        ("SR-05", "SR-25"),
        NORMALIZATION,
        COUNTED,
        "holds.append(entry.candidate.w > 0)",
    ),
    Mutant(
        "Z asks whether donor and receiver see each other",
        ("SR-05",),
        NORMALIZATION,
        LOOKS,
        BETWEEN_THE_TWO,
    ),
    Mutant(
        "Z asks that the donor has the sample 6 degrees above its horizon",
        ("SR-05", "JC-12"),
        NORMALIZATION,
        "holds &= dot(take(surface.normal, donor), toward) > 0",
        "least = 0.1 * np.sqrt(dot(toward, toward))\n"
        "        holds &= dot(take(surface.normal, donor), toward) > least",
        also=(
            (
                NORMALIZATION,
                "possible = source_pdf(settings.source, materials, k, omega) > 0",
                "possible = dot(k.normal, omega) > 0.1",
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
        NORMALIZATION,
        COUNTED,
        ONCE_EACH,
    ),
    *HELD_OUT_MORE,
)
