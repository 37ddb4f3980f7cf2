"""Mistakes in shifts of whole paths.

In the manner of :mod:`tests.mutants.catalogue`.
"""

from tests.mutants.catalogue import Mutant

SHIFTING = "restir_gi.extensions.shifting"

ROUGH = "np.minimum(roughness(table, x_from), roughness(table, x_to))"
SINGLE = "np.where(single, -1.0, np.sqrt(table.alpha))"
DIFFUSE = "(kind == Kind.LAMBERTIAN) | (kind == Kind.SMOOTH_COATED)"
FAR = "far = distance > criterion.distance * geometry.extent"
JOINABLE = "(distance > 0) & far & (rough >= max(criterion.roughness, 0.0))"
SPREAD = "spread = divide_or_zero(cosine, distance**2)"
COSINE = "cosine = np.abs(dot(x_to.normal, omega))"

SAME = "same = ~(step.joinable & ~leaving.bsdf.delta)"
FITS = "fits = came.joinable & ~step.joinable & (dot(there.normal, omega) < 0)"
HORIZON = "(dot(there.normal, omega) < 0)"
SHARE = "weight = weight * np.where(last, share, 1.0)[:, None]"
BSDF_SAMPLING = "balance(p_onward, paths.pdf_light)"
BY_TECHNIQUE = (
    "np.where(\n            chosen,\n"
    "            light_sampling_weight(world, there, paths.wi, paths.pdf_light)"
)
ONE = "p_onward = np.where(last & chosen, 1.0, p_onward)"
DENSITY = "np.where(seen & fits, p_left * came.spread * p_onward, 0.0)"
QUOTIENT = "return value, divide_or_zero(density, base)"
BASE = "base = np.where(joint > 0, paths.density[rows], 1.0)"
SEEN = 'seen = world.caster.visible(x, x_s, there.normal, shines, "reuse")'
VALUE = "value = step.throughput * weight * paths.incoming"
END_CHOSEN = "active = chosen & x.hit & ~step.joinable"
END_MET = "active = ~chosen & ~(step.joinable & ~bsdf.delta)"
JOINS = "joins = paths.joint == vertex + 1"
ENDS = "ends = (paths.joint == 0) & (paths.end == vertex)"
GOING = "going = able & (joint != 2) & self.criterion.replays"
LIGHT = "choose_light(world, x, uniforms.draw(2 * vertex - 1), active)"
MET = "radiance * share[:, None]"
END_VALUE = "value = step.throughput * value\n"
KEPT = "_kept(same & step.points.hit, rows, paths, step)"
ABLE = "able = (points.primitive[at] >= 0) & (paths.end[rows] > 0)"

STEP = "return Step(met, step.throughput * weight, weight, came, joinable, density)"
DRAWN = "uniforms.draw(2 * (vertex - 1))"

FORTH = "self.shift(self.world, self.points, at, paths, rows)"
BACK = "self.shift(self.world_from, self.points_from, rows, samples, at)"
OFFERED = "paths, rows = self.reservoirs.y, self.rows[at]"

CRITERION = [
    Mutant(
        "alpha is taken for the perceptual roughness",
        ("HS-03",),
        SHIFTING,
        SINGLE,
        "np.where(single, -1.0, table.alpha)",
        ("alpha-for-roughness",),
    ),
    Mutant(
        "only the point that is left has to be rough",
        (),
        SHIFTING,
        ROUGH,
        "roughness(table, x_from)",
        ("first-end-rough",),
    ),
    Mutant(
        "only the point that is reached has to be rough",
        (),
        SHIFTING,
        ROUGH,
        "roughness(table, x_to)",
        ("second-end-rough",),
    ),
    Mutant(
        "the rougher of two points decides",
        (),
        SHIFTING,
        ROUGH,
        ROUGH.replace("minimum", "maximum"),
        ("one-rough-end-is-enough",),
    ),
    Mutant(
        "single directions are lobes of no width",
        (),
        SHIFTING,
        SINGLE,
        SINGLE.replace("-1.0", "0.0"),
        ("single-directions-joined",),
    ),
    Mutant(
        "what lies under a smooth coat is smooth",
        (),
        SHIFTING,
        DIFFUSE,
        "kind == Kind.LAMBERTIAN",
    ),
    Mutant(
        "the least distance is in metres",
        (),
        SHIFTING,
        FAR,
        "far = distance > criterion.distance",
        ("least-distance-in-metres",),
    ),
    Mutant(
        "points may be as near as they like",
        (),
        SHIFTING,
        JOINABLE,
        JOINABLE.replace("far & ", ""),
        ("least-distance-not-asked",),
    ),
    Mutant(
        "points that are far apart are not joined",
        (),
        SHIFTING,
        FAR,
        FAR.replace(">", "<"),
    ),
]

JACOBIANS = [
    Mutant(
        "no cosine at the joint",
        (),
        SHIFTING,
        SPREAD,
        "spread = divide_or_zero(np.ones_like(cosine), distance**2)",
        ("path-jacobian-without-cosine", "offset-without-cosine"),
    ),
    Mutant(
        "the distance to the joint is not squared",
        (),
        SHIFTING,
        SPREAD,
        "spread = divide_or_zero(cosine, distance)",
        ("path-jacobian-distance-once", "offset-distance-once"),
    ),
    Mutant(
        "no distance to the joint",
        (),
        SHIFTING,
        SPREAD,
        "spread = cosine",
        ("path-jacobian-without-distance", "offset-without-distance"),
    ),
    Mutant(
        "the cosine at the joint is that at the point before",
        (),
        SHIFTING,
        COSINE,
        "cosine = np.abs(dot(x_from.normal, omega))",
    ),
    Mutant(
        "the Jacobian of a path is upside down",
        (),
        SHIFTING,
        QUOTIENT,
        "return value, divide_or_zero(base, density)",
        ("path-jacobian-inverted",),
    ),
    Mutant(
        "no Jacobian of a path",
        (),
        SHIFTING,
        QUOTIENT,
        "return value, (density > 0).astype(float)",
        ("path-jacobian-omitted",),
    ),
    Mutant(
        "the first density is left out",
        (),
        SHIFTING,
        DENSITY,
        DENSITY.replace("p_left * ", ""),
        ("offset-without-left-density",),
    ),
    Mutant(
        "the second density is left out",
        (),
        SHIFTING,
        DENSITY,
        DENSITY.replace(" * p_onward", ""),
        ("offset-without-onward-density",),
    ),
    Mutant(
        "a chosen light has the density of its direction",
        (),
        SHIFTING,
        ONE,
        "p_onward = np.where(last & chosen, p_onward, p_onward)",
        ("chosen-light-has-a-density",),
    ),
    Mutant(
        "paths that are replayed have the density of a joint",
        (),
        SHIFTING,
        BASE,
        "base = paths.density[rows]",
        ("replayed-over-density",),
    ),
]

DOMAINS = [
    Mutant(
        "offset paths that can be joined earlier are replayed further",
        ("HS-01",),
        SHIFTING,
        SAME,
        "same = np.ones(len(rows), bool)",
        ("earlier-joints-accepted-but-at-the-last",),
    ),
    Mutant(
        "the point before the joint may be one",
        ("HS-01",),
        SHIFTING,
        FITS,
        FITS.replace("~step.joinable & ", ""),
        ("joint-before-accepted",),
    ),
    Mutant(
        "offset paths are not asked whether they can be joined earlier",
        ("HS-01",),
        SHIFTING,
        SAME,
        "same = np.ones(len(rows), bool)",
        ("earlier-joints-accepted",),
        also=(
            (SHIFTING, FITS, FITS.replace("~step.joinable & ", "")),
            (SHIFTING, END_CHOSEN, "active = chosen & x.hit"),
            (SHIFTING, END_MET, "active = ~chosen & x.hit"),
        ),
    ),
    Mutant(
        "the joint of the base path is not tested again",
        ("HS-01",),
        SHIFTING,
        FITS,
        FITS.replace("came.joinable & ", ""),
        ("bases-joint-not-asked",),
    ),
    Mutant(
        "the end of a replayed path may be a joint",
        ("HS-01",),
        SHIFTING,
        END_CHOSEN,
        "active = chosen & x.hit",
        ("joint-at-the-end-accepted",),
        also=((SHIFTING, END_MET, "active = ~chosen & x.hit"),),
    ),
    Mutant(
        "points that are left by a delta lobe are joints",
        (),
        SHIFTING,
        SAME,
        "same = ~step.joinable",
        ("delta-left-is-no-joint-forgotten",),
        also=((SHIFTING, END_MET, "active = ~chosen & ~step.joinable"),),
    ),
    Mutant(
        "points that are reached by a delta lobe are joints",
        (),
        SHIFTING,
        # The flag alone: where rays lead remains what the tables say.
        STEP,
        STEP.replace("joinable", "came.joinable & (vertex < criterion.last_joint)"),
        ("delta-came-is-a-joint",),
    ),
    Mutant(
        "a hidden joint is accepted",
        ("HS-11",),
        SHIFTING,
        SEEN,
        "seen = shines",
        ("hidden-joint-accepted",),
    ),
    Mutant(
        "replayed paths end at their first light",
        ("HS-05",),
        SHIFTING,
        ENDS,
        "ends = (paths.joint == 0) & (paths.end >= vertex)",
    ),
    Mutant(
        "reconnections are replayed too",
        (),
        SHIFTING,
        GOING,
        "going = able & (joint != 2)",
        ("replays-not-asked",),
    ),
]

VALUES = [
    Mutant(
        "no share at the joint",
        (),
        SHIFTING,
        SHARE,
        "weight = weight * np.where(last, 1.0, 1.0)[:, None]",
        ("share-left-out",),
    ),
    Mutant(
        "an emitter hit has the MIS weight of light sampling",
        (),
        SHIFTING,
        BSDF_SAMPLING,
        "balance(paths.pdf_light, p_onward)",
        ("share-of-choice-for-both",),
    ),
    Mutant(
        "the shares change places",
        (),
        SHIFTING,
        BY_TECHNIQUE,
        BY_TECHNIQUE.replace("chosen", "~chosen", 1),
        ("share-of-the-other-technique",),
    ),
    Mutant(
        "no throughput up to the joint",
        (),
        SHIFTING,
        VALUE,
        "value = weight * paths.incoming",
        ("throughput-left-out",),
    ),
    Mutant(
        "the value of the base path is kept",
        (),
        SHIFTING,
        QUOTIENT,
        "value = np.where((density > 0)[:, None], paths.value[rows], 0.0)\n"
        "        return value, divide_or_zero(density, base)",
        ("bases-value",),
    ),
    Mutant(
        "paths are joined from x_c",
        ("HS-09",),
        SHIFTING,
        JOINS,
        "joins = paths.joint == vertex",
    ),
    Mutant(
        "the last light is chosen by the numbers of a direction",
        (),
        SHIFTING,
        LIGHT,
        LIGHT.replace("2 * vertex - 1", "2 * vertex - 2"),
    ),
    Mutant(
        "no share at the end of a replayed path",
        (),
        SHIFTING,
        MET,
        "radiance",
    ),
    Mutant(
        "no throughput up to the end of a replayed path",
        (),
        SHIFTING,
        END_VALUE,
        "value = value.copy()\n",
        ("replayed-throughput-left-out",),
    ),
    Mutant(
        "the throughput is the last weight",
        (),
        SHIFTING,
        STEP,
        STEP.replace("step.throughput * weight", "weight"),
        ("throughput-is-the-last-weight",),
    ),
    Mutant(
        "directions are replayed with the numbers of the next vertex",
        (),
        SHIFTING,
        DRAWN,
        "uniforms.draw(2 * vertex)",
    ),
    Mutant(
        "a neighbour's paths are shifted to the neighbour",
        (),
        SHIFTING,
        FORTH,
        "self.shift(self.world_from, self.points_from, rows, paths, rows)",
    ),
    Mutant(
        "a receiver's paths are shifted to the receiver",
        (),
        SHIFTING,
        BACK,
        "self.shift(self.world, self.points, at, samples, at)",
    ),
    Mutant(
        "the receiver's number is taken for the neighbour's",
        (),
        SHIFTING,
        OFFERED,
        "paths, rows = self.reservoirs.y, at",
    ),
]

EQUIVALENT = [
    Mutant(
        "the horizon of a joint is left to its visibility",
        (),
        SHIFTING,
        HORIZON,
        "(dot(there.normal, omega) != 0)",
        kind="equivalent",
    ),
    Mutant(
        "walks that have ended are dropped where they end",
        ("HS-05",),
        SHIFTING,
        KEPT,
        "_kept(same, rows, paths, step)",
        kind="equivalent",
    ),
    Mutant(
        "points as rough as the threshold are not joined",
        (),
        SHIFTING,
        JOINABLE,
        JOINABLE.replace(">=", ">"),
        kind="equivalent",
    ),
    Mutant(
        "a joint seen edge-on is accepted",
        (),
        SHIFTING,
        HORIZON,
        "(dot(there.normal, omega) <= 0)",
        kind="equivalent",
    ),
    Mutant(
        "the factors of the density in another order",
        (),
        SHIFTING,
        DENSITY,
        DENSITY.replace(
            "p_left * came.spread * p_onward", "p_onward * p_left * came.spread"
        ),
        kind="equivalent",
    ),
    Mutant(
        "whether a path is there is asked once more at its light",
        (),
        SHIFTING,
        ABLE,
        f"{ABLE} & (paths.technique[rows] > 0)",
        kind="equivalent",
    ),
]

SHIFT_MUTANTS = (*CRITERION, *JACOBIANS, *DOMAINS, *VALUES, *EQUIVALENT)
