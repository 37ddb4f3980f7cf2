"""Mistakes that the oracle's author has not seen: samples, targets, time and light.

The second half of :mod:`tests.mutants.held_out`.
"""

from tests.mutants.catalogue import (
    COSINE_SAMPLE,
    ENTRIES,
    FRAMES,
    HISTORY,
    LIGHT,
    NORMALIZATION,
    RESAMPLE,
    SAMPLING,
    SEEN,
    TARGET,
    TEMPORAL,
    UNIFORM_SAMPLE,
    Mutant,
)

INITIAL_PASS = "reference.passes.initial"
HALVES = "reference.passes.halves"
PASSAGE = "reference.options.motion"
PAST = "reference.passes.past"
RECEIVERS = "reference.passes.receivers"

FRESH_WEIGHT = "new = initial_candidates(places, p_hat, initial.pdf)"
PATH = "radiance = reflected_radiance(world, met, bounces - 1, paths, tail=tail)"
SHINING = "shining = np.where(shared[:, None], radiance, 0.0)"
OMEGA = "omega, _ = direction_and_distance(points.position, x_s)"
SHARED = "shared = ~drawn.delta & (density > 0)"
FAR = "omega, distance = direction_and_distance(points.position, x_s)"
DENSITY = "density = source_pdf(source, world.materials, points, omega)"
REFLECTS = "value = scattering(table, receiver, omega) * y.radiance"
ALL_SEE = 'if settings.visibility == "all":'
FROM_HERE = "return sees(self.world, self.points, y, active)"
ARRIVES = "return _passed(self.after, self.forth, self.replay, y, active)"
HIDDEN_CHOICE = """if settings.visibility == "chosen" and shifted:
        kept = drop_hidden(receivers, kept)"""

EMISSION_TOO = f"""{PATH}
    from reference.scene.emitters import emitted

    radiance = radiance + emitted(world.emitters, world.geometry, met)"""

WITHOUT_ALBEDO = f"""{FRESH_WEIGHT}
    from reference.resampling.target import luminance

    shown = luminance(receivers.points.color * initial.y.radiance)
    more = luminance(initial.y.radiance) / np.maximum(shown, 1e-30)
    new = replace(new, w=new.w * more)"""

UNSCALED_TANGENTS = """axis = np.where(abs(z) < 0.9, 0.0, 1.0)
    up = vectors(axis, axis * 0.0, 1.0 - axis)
    tangent = np.cross(up, n)
    bitangent = np.cross(n, tangent)"""

CAMERA_RELATIVE = """from numpy import subtract

        y = _passed(self.after, self.forth, self.replay, y, active)
        step = subtract(self.after.camera.position, self.before.camera.position)
        return replace(y, position=y.position + step)"""

GIVES_WAY = """if shifted:
        from reference.records import where

        own, c = entries[canonical].y, entries[canonical].candidate
        hidden = (kept.W > 0) & (drop_hidden(receivers, kept).W == 0)
        W = kept.W * ~hidden + hidden * c.w / (c.p_hat * c.M + 1e-30)
        kept = replace(kept, y=where(hidden, own, kept.y), W=W)"""

CLOSE_BY = """v, x_to = x.position - points.position, y.position - points.position
        near = (v * v).sum(axis=1) < 0.02 * (x_to * x_to).sum(axis=1)
        seen = near | receivers.see(y, candidate.w > 0)"""

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
        FRESH_WEIGHT,
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
        SHARED,
        f"{SHARED}\n"
        "    reach = ((x_s - points.position) ** 2).sum(axis=1)\n"
        "    shared &= reach < world.geometry.extent**2",
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
        "        density = pdf_cosine_hemisphere(-(met.normal * omega).sum(axis=1))",
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
        "the donors of the last frame stand where this frame's points do",
        ("TR-03", "TR-13"),
        PAST,
        "return Donors(last.world, last.visible, r",
        "return Donors(last.world, moment.visible, r",
    ),
    Mutant(
        "the past is not tested for visibility when the camera moves",
        ("TR-15",),
        ENTRIES,
        ALL_SEE,
        ALL_SEE.replace(":", " and place > 0:"),
        expected=("visibility-missing-in-weight",),
    ),
    Mutant(
        "the past always counts in Z",
        ("SR-05", "TR-13"),
        NORMALIZATION,
        "if entry.origin is None:",
        "if entry.origin is None or place == 0:",
        expected=("one-over-m",),
    ),
    Mutant(
        "the past of the pixel to the left, as it stands",
        ("TR-05", "TR-03"),
        HISTORY,
        "return cut(self.donors.reservoirs, self.rows)",
        "return take(self.donors.reservoirs, np.maximum(self.indices - 1, 0))",
    ),
    Mutant(
        "sample points are kept relative to a camera that moves",
        ("TR-03",),
        PASSAGE,
        ARRIVES,
        CAMERA_RELATIVE,
    ),
    Mutant(
        "the receiver's ray meets the sample itself",
        ("SR-33",),
        RECEIVERS,
        FROM_HERE,
        "end = y.position + 0.001 * (y.position - self.points.position)\n"
        "        y = Samples(end, y.normal * 0, y.radiance)\n"
        f"        {FROM_HERE}",
    ),
    Mutant(
        "donors close by are taken to see the same",
        ("SR-33", "SR-21"),
        ENTRIES,
        SEEN,
        CLOSE_BY,
    ),
    Mutant(
        "a hidden choice gives way to the pixel's own sample",
        ("SR-33", "SR-31"),
        RESAMPLE,
        HIDDEN_CHOICE,
        GIVES_WAY,
        also=((ENTRIES, ALL_SEE, "if False:"),),
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
        HALVES,
        "color = shade(moment.world, receivers.points, kept.reservoirs)",
        "W = fresh.kept.reservoirs.W[r]\n"
        "    shown = replace(kept.reservoirs, W=W)\n"
        "    color = shade(moment.world, receivers.points, shown)",
    ),
)
