"""Shifts of whole paths once more, row by row, as the contract's text has them."""

from types import SimpleNamespace

import numpy as np

from restir_gi.extensions.oracle.shifts.passes import SHIFT


def joins(real, mistake, alphas, singles, distance, s):
    """Squares in place of roots."""
    least = real(s["roughness"])
    rough = [a if mistake == "alpha" else np.sqrt(a) for a in alphas]
    fits = [r >= least and not single for r, single in zip(rough, singles, strict=True)]
    if mistake == "one end":
        fits = fits[:1]
    away = real(s["least_distance"]) * real(s["extent"])
    if mistake == "metres":
        away = real(s["least_distance"])
    far = distance > 0 and (distance > away or mistake == "near")
    return far and all(fits)


def joinable(
    real, mistake, alpha_from, alpha_to, single_from, single_to, distance, **s
):
    """A flag a row."""
    rows = zip(alpha_from, alpha_to, single_from, single_to, distance, strict=True)
    found = [joins(real, mistake, r[:2], r[2:4], r[4], s) for r in rows]
    return {"joinable": np.array(found, np.uint32)}


def solid_angle(real, mistake, x, joint, normal):
    """|n · D| / d³, through a unit vector."""
    way = joint - x
    d = np.sqrt((way * way).sum())
    if d == 0:
        return real(0)
    cosine = abs((normal * (way / d)).sum())
    if mistake == "no cosine":
        cosine = real(1)
    return cosine / d if mistake == "distance once" else cosine / (d * d)


def path_jacobian(
    real,
    mistake,
    x_from,
    x_to,
    joint_position,
    joint_normal,
    p_from,
    p_to,
    p_onward_from,
    p_onward_to,
):
    """Quotients of each factor."""
    found = np.zeros(len(p_to), real)
    for i in range(len(p_to)):
        at = joint_position[i], joint_normal[i]
        s_from, s_to = (solid_angle(real, mistake, x[i], *at) for x in (x_from, x_to))
        p, q = (p_to[i], p_from[i]), (p_onward_to[i], p_onward_from[i])
        if mistake == "no first density":
            p = (real(1), real(1))
        if min(s_from, s_to, *p, *q) > 0:
            found[i] = (p[0] / p[1]) * (q[0] / q[1]) * (s_to / s_from)
    return {"jacobian": found}


def shift(real, mistake, **t):
    """Rows one after the other, and why each is refused."""
    names = [f.name for f in SHIFT.inputs]
    columns, s = {n: t[n] for n in names}, {n: t[n] for n in t if n not in names}
    size = len(t["joint"])
    value, jacobian, why = np.zeros((size, 3), real), np.zeros(size, real), []
    for i in range(size):
        row = SimpleNamespace(**{n: column[i] for n, column in columns.items()})
        reason = refusal(real, mistake, row, s)
        why.append(reason or ("joined" if row.joint else "replayed"))
        if not reason:
            value[i], jacobian[i] = worth(real, mistake, row)
            if not value[i].any():
                jacobian[i], why[i] = 0, "black"
    return {"value": value, "jacobian": jacobian, "why": np.array(why)}


def length(v):
    return np.sqrt((v * v).sum())


def refusal(real, mistake, row, s):
    """Why there is no path; empty where there is one."""
    if row.end == 0:
        return "nothing"
    if row.joint != 2 and not s["replays"]:
        return "no replays"
    m = row.joint - 1 if row.joint else row.end
    if not row.hit[0] or (not row.hit[:m].all() and mistake != "length"):
        return "length"
    for v in range(2, m + 1):
        pair = slice(v - 2, v)
        d = length(row.contact[v - 1] - row.position[v - 2])
        able = joins(real, mistake, row.alpha[pair], row.single[pair], d, s)
        able = able and not row.delta[v - 2] and v <= s["last_joint"]
        left = not row.delta[v - 1] or mistake == "delta"
        if v == m:
            left = left or bool(row.joint) or row.technique == 1
        if able and left and mistake != "earlier":
            return "earlier" if v < m else "before"
    if not row.joint:
        return ""
    way = row.joint_position - row.position[m - 1]
    alphas, singles = (
        (
            row.alpha[m - 1],
            row.joint_alpha,
        ),
        (row.single[m - 1], row.joint_single),
    )
    able = joins(real, mistake, alphas, singles, length(way), s)
    if not able and mistake != "later":
        return "later"
    if (row.joint_normal * way).sum() >= 0 and mistake != "horizon":
        return "horizon"
    return "" if row.seen or mistake == "hidden" else "hidden"


def worth(real, mistake, row):
    """Value and Jacobian."""
    m = row.joint - 1 if row.joint else row.end
    before = row.weight[: m - 1].prod(axis=0)
    if not row.joint:
        return before * row.light, real(1)
    if mistake == "throughput":
        before = row.base_throughput
    q, light, last = row.pdf_onward, row.pdf_light, row.joint == row.end
    p_bsdf = row.base_pdf_onward if mistake == "old share" else q
    chosen = row.technique == 1
    share = real(1)
    mine = light if chosen else p_bsdf
    if last and mine > 0 and mistake != "no share":
        share = mine / (light + p_bsdf)
    if last and chosen and mistake != "density of a choice":
        q = real(1)
    position = row.base_position if mistake == "base" else row.position[m - 1]
    spread = solid_angle(real, mistake, position, row.joint_position, row.joint_normal)
    if row.pdf_left == 0 or q == 0:
        return np.zeros(3, real), real(0)
    value = before * (row.left * row.onward) * (row.incoming * share)
    jacobian = row.pdf_left * (q * spread) / row.density
    if mistake == "no first density":
        jacobian = jacobian / row.pdf_left * row.base_pdf_left
    if mistake == "inverted":
        jacobian = 1 / jacobian
    return value / row.pdf_left / q, jacobian


OTHERS = {"joinable": joinable, "path_jacobian": path_jacobian, "shift": shift}

PLANTED = {
    "joinable": {
        "alpha": "alpha-for-roughness",
        "one end": "first-end-rough",
        "metres": "least-distance-in-metres",
        "near": "least-distance-not-asked",
    },
    "path_jacobian": {
        "no cosine": None,  # where a surface is seen edge-on it stays 0 here
        "distance once": "path-jacobian-distance-once",
        "no first density": None,  # and where the density is 0
    },
    "shift": {
        "alpha": "alpha-for-roughness",
        "one end": "first-end-rough",
        "near": "least-distance-not-asked",
        "length": "path-length-not-asked",
        "delta": "delta-left-is-no-joint-forgotten",
        "earlier": "earlier-joints-accepted",
        "later": "bases-joint-not-asked",
        "horizon": "joint-seen-from-behind",
        "hidden": "hidden-joint-accepted",
        "throughput": "bases-throughput",
        "old share": "share-of-the-base",
        "no share": "share-left-out",
        "density of a choice": "chosen-light-has-a-density",
        "base": "distance-from-the-base",
        "no cosine": "offset-without-cosine",
        "distance once": "offset-distance-once",
        "no first density": "path-jacobian-without-left-density",
        "inverted": "path-jacobian-inverted",
    },
}
"""Mistakes of each pass, and the known mistake that each of them is."""
