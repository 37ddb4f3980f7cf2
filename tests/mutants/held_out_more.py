"""Mistakes that the oracle's author has not seen: samples, targets, time and light.

The second half of :mod:`tests.mutants.held_out`.
"""

from tests.mutants.catalogue import (
    CLOSE,
    CLOSE_S,
    COSINE_SAMPLE,
    FRAMES,
    IS_OTHER,
    LIGHT,
    MOVES,
    NEW,
    PAST,
    PAST_S,
    PIXELS,
    REPLACE,
    REUSED,
    SAMPLING,
    SEEN,
    SPATIAL,
    TARGET,
    TEMPORAL,
    UNIFORM_SAMPLE,
    Mutant,
)

INITIAL_PASS = "restir_gi.reference.passes.initial"
LOOP_OF_FRAMES = "restir_gi.reference.restir_gi"
MOTION = "restir_gi.reference.options.motion"
HISTORY = "restir_gi.reference.options.history"

PATH = "radiance = reflected_radiance(world, met, bounces - 1, paths, tail=tail)"
SHINING = "shining = np.where(shared[:, None], radiance, 0.0)"
OMEGA = "omega, _ = direction_and_distance(points.position, x_s)"
FAR = "omega, distance = direction_and_distance(points.position, x_s)"
DENSITY = "density = source_pdf(source, world.materials, points, omega)"
REFLECTS = "value = scattering(table, receiver, omega) * y.radiance"
FROM_HERE = "return sees(self.world, self.points, y, asked)"
ARRIVES = "return _carried(self.after, self.motion, self.replay, y, active)"
EARLIER = "return EarlierReservoirs(r.world, r.visible, reservoirs, shift)"
SHOWN = "color, seen = shade(frame.world, q.points, kept), None"

EMISSION_TOO = f"""{PATH}
    from restir_gi.reference.scene.emitters import emitted

    radiance = radiance + emitted(world.emitters, world.geometry, met)"""

WITHOUT_ALBEDO = f"""{NEW}
    from numpy import maximum

    from restir_gi.reference.resampling.target import luminance

    {REPLACE}shown = luminance(q.points.color * initial.y.radiance)
    more = luminance(initial.y.radiance) / maximum(shown, 1e-30)
    new = replace(new, w=new.w * more)"""

UNSCALED_TANGENTS = """axis = np.where(abs(z) < 0.9, 0.0, 1.0)
    up = vectors(axis, axis * 0.0, 1.0 - axis)
    tangent = np.cross(up, n)
    bitangent = np.cross(n, tangent)"""

CAMERA_RELATIVE = """from numpy import subtract

        y = _carried(self.after, self.motion, self.replay, y, active)
        step = subtract(self.after.camera.position, self.before.camera.position)
        return replace(y, position=y.position + step)"""

GIVES_WAY = f"""from restir_gi.reference.numerics.records import where

    {REPLACE}kept, c = finalize(R_s.kept, Z), R_s.candidates[1]
    hidden = (kept.W > 0) & ~q.sees(kept.y, kept.W > 0)
    W = kept.W * ~hidden + hidden * c.w / (c.p_hat * c.M + 1e-30)
    kept = replace(kept, y=where(hidden, c.y, kept.y), W=W)
    return cap_confidence(kept, cap)"""

GIVES_WAY_IN_TIME = f"""if not ({MOVES}):
        {CLOSE}
    {GIVES_WAY.replace("R_s.", "R.")}"""

TRUSTED = f"""from restir_gi.reference.options.visibility import trusting

    R = begin(reused(trusting(q) if {MOVES} else q, past))"""

CLOSE_BY = """x_q = q.points.position
    v, x_to = q_n.x.position - x_q, R_n.y.position - x_q
    near = (v * v).sum(axis=1) < 0.02 * (x_to * x_to).sum(axis=1)
    seen = near | q.sees(R_n.y, c.w > 0)"""

TO_THE_LEFT = f"""from numpy import arange, maximum

    from restir_gi.reference.numerics.records import take

    if not ({MOVES}):
        past = take(past, maximum(arange(len(past.M)) - 1, 0))
    {PAST}"""

HELD_OUT_MORE: tuple[Mutant, ...] = (
    Mutant(
        "the emission of the sample point is in L_o",
        ("IS-07",),
        INITIAL_PASS,
        PATH,
        EMISSION_TOO,
    ),
    Mutant(
        "the density of a new sample is per area",
        ("JC-17", "IS-05"),
        INITIAL_PASS,
        f"{OMEGA}\n    {DENSITY}",
        f"{FAR}\n    {DENSITY}\n"
        "    facing = abs((met.normal * omega).sum(axis=1))\n"
        "    density = density * facing / np.maximum(distance * distance, 1e-9)",
    ),
    Mutant(
        "the weight of a new sample lacks the albedo, W is divided by it",
        ("RG-03", "SR-09"),
        TEMPORAL,
        NEW,
        WITHOUT_ALBEDO,
    ),
    Mutant(
        "L_o is clamped against fireflies",
        ("§0", "PK-01"),
        INITIAL_PASS,
        SHINING,
        SHINING.replace("radiance", "np.minimum(radiance, 0.5)"),
    ),
    Mutant(
        "new rays end after half the extent of the scene",
        ("IS-29", "SR-33"),
        INITIAL_PASS,
        SHINING,
        "reach = ((x_s - points.position) ** 2).sum(axis=1)\n"
        f"    shared &= reach < world.geometry.extent**2\n    {SHINING}",
    ),
    Mutant(
        "θ is uniform",
        ("IS-13",),
        SAMPLING,
        UNIFORM_SAMPLE,
        "_about_z(np.cos(np.pi / 2 * u1), np.sin(np.pi / 2 * u1), u2)",
    ),
    Mutant(
        "the disk under a cosine direction lacks its root",
        ("IS-13",),
        SAMPLING,
        COSINE_SAMPLE,
        "_about_z(np.sqrt(1.0 - u1 * u1), u1, u2)",
    ),
    Mutant(
        "tangents are not normalized",
        ("IS-13",),
        FRAMES,
        "tangent = vectors(1.0 + sign * x * x * a, sign * b, -sign * x)\n"
        "    bitangent = vectors(b, sign + y * y * a, -y)",
        UNSCALED_TANGENTS,
    ),
    Mutant(
        "the cosine pdf has the cosine at the sample point",
        ("IS-13", "JC-05"),
        INITIAL_PASS,
        f"{OMEGA}\n    {DENSITY}",
        f"{OMEGA}\n    {DENSITY}\n"
        '    if source == "cosine":\n'
        "        from restir_gi.reference.numerics import sampling\n\n"
        "        cosine = -(met.normal * omega).sum(axis=1)\n"
        "        density = sampling.pdf_cosine_hemisphere(cosine)",
    ),
    Mutant(
        "new directions stay 6 degrees above the horizon",
        ("IS-13",),
        SAMPLING,
        UNIFORM_SAMPLE,
        "_about_z(0.1 + 0.9 * u1, np.sqrt(1.0 - (0.1 + 0.9 * u1) ** 2), u2)",
    ),
    Mutant(
        "dim samples are taken for nothing in the target",
        ("PK-09", "HG-13"),
        TARGET,
        LIGHT,
        "p_hat = luminance(receiver.color * y.radiance) * scale\n"
        "    return np.where(p_hat > 0.01, p_hat, 0.0)",
    ),
    Mutant(
        "the sources of the last frame stand where this frame's points do",
        ("TR-03", "TR-13"),
        HISTORY,
        EARLIER,
        EARLIER.replace("r.visible", "frame.visible"),
    ),
    Mutant(
        "the past is not tested for visibility when the camera moves",
        ("TR-15",),
        TEMPORAL,
        PAST,
        TRUSTED,
        also=((SPATIAL, PAST_S, TRUSTED.replace("R = ", "R_s = ")),),
        expected=("visibility-missing-in-weight",),
    ),
    Mutant(
        "the past always counts in Z",
        ("SR-05", "TR-13"),
        REUSED,
        IS_OTHER,
        IS_OTHER.replace("if ", "if slot and "),
        expected=("one-over-m",),
    ),
    Mutant(
        "the past of the pixel to the left, as it stands",
        ("TR-05", "TR-03"),
        TEMPORAL,
        PAST,
        TO_THE_LEFT,
    ),
    Mutant(
        "sample points are kept relative to a camera that moves",
        ("TR-03",),
        MOTION,
        ARRIVES,
        CAMERA_RELATIVE,
    ),
    Mutant(
        "the receiver's ray meets the sample itself",
        ("SR-33",),
        PIXELS,
        FROM_HERE,
        "end = y.position + 0.001 * (y.position - self.points.position)\n"
        "        y = Samples(end, y.normal * 0, y.radiance)\n"
        f"        {FROM_HERE}",
    ),
    Mutant(
        "sources close by are taken to see the same",
        ("SR-33", "SR-21"),
        REUSED,
        SEEN,
        CLOSE_BY,
    ),
    Mutant(
        "a hidden choice gives way to the pixel's own sample",
        ("SR-33", "SR-31"),
        SPATIAL,
        CLOSE_S,
        GIVES_WAY,
        also=(
            (TEMPORAL, CLOSE, GIVES_WAY_IN_TIME),
            (REUSED, SEEN, "seen = c.w > 0"),
        ),
    ),
    Mutant(
        "a sample keeps what its own pixel reflects of it",
        ("IS-23",),
        INITIAL_PASS,
        SHINING,
        SHINING.replace("radiance", "radiance * points.color"),
        also=(
            (TARGET, LIGHT, "return luminance(y.radiance) * scale"),
            (
                TARGET,
                REFLECTS,
                "cosine = lit_cosine(table, receiver, omega)\n"
                "    value = y.radiance * (cosine / np.pi)[:, None]",
            ),
        ),
        expected=("target-without-albedo", "shade-without-albedo"),
    ),
    Mutant(
        "the spatial sample is shown with the temporal W",
        ("SR-09", "SR-11"),
        LOOP_OF_FRAMES,
        SHOWN,
        "shown = replace(kept, W=first.temporal.W[r])\n    "
        + SHOWN.replace("kept", "shown"),
    ),
)
