"""Passes of the contract about shifts of whole paths."""

from restir_gi.reference.oracle.contract.fields import (
    Pass,
    Setting,
    bits,
    index,
    real,
    vector,
)

CRITERION = (
    Setting("roughness", "number, 0 upwards", "least √alpha of both points"),
    Setting("least_distance", "number, 0 upwards", "in half extents of the scene"),
    Setting("extent", "m", "half extent of the scene"),
)

JOINABLE = Pass(
    name="joinable",
    summary="Whether two neighbouring points of a path may be joined",
    formula=(
        "1 where distance > 0, distance > least_distance · extent, single_from = "
        "single_to = 0, √alpha_from ≥ roughness and √alpha_to ≥ roughness; else 0"
    ),
    inputs=(
        real("alpha_from", "GGX width of x_v; 1 for diffuse, 0 for single directions"),
        real("alpha_to", "GGX width of x_(v+1), likewise"),
        bits("single_from", "1 where x_v scatters into single directions alone"),
        bits("single_to", "1 where x_(v+1) does"),
        real("distance", "between them, m"),
    ),
    outputs=(bits("joinable", "1 or 0"),),
    settings=CRITERION,
    source="[Lin22, section 7.2]; thresholds are perceptual roughness, √alpha",
    clauses=(
        "thresholds are perceptual roughness",
        "both ends are rough",
        "single directions are not joined",
        "the distance is above the least one, in extents",
        "0 where the distance is 0",
    ),
)

PATH_JACOBIAN = Pass(
    name="path_jacobian",
    summary="Jacobian of a shift that joins a path at x_c, by its random numbers",
    formula=(
        "v = joint_position − x, d² = v·v, s = |joint_normal·v| / (√d² · d²);\n"
        "jacobian = (p_to · s_to · p_onward_to) / (p_from · s_from · p_onward_from); "
        "0 where any factor is 0"
    ),
    inputs=(
        vector("x_from", "x_(c−1) of the base path, m"),
        vector("x_to", "x_(c−1) of the offset path, m"),
        vector("joint_position", "x_c, which both share, m"),
        vector("joint_normal", "unit normal there"),
        real("p_from", "density with which the base path left x_(c−1), 1/sr"),
        real("p_to", "the same of the offset path, 1/sr"),
        real("p_onward_from", "density with which the base path left x_c, or 1"),
        real("p_onward_to", "the same of the offset path, or 1"),
    ),
    outputs=(real("jacobian", "J = |∂u_to / ∂u_from|"),),
    source="[Lin22, section 7.2], in primary sample space",
    joins=(("x_from", "joint_position"), ("x_to", "joint_position")),
    clauses=(
        "the offset path stands above",
        "the densities are in it",
        "the solid angles are in it",
        "0 where any factor is 0",
    ),
)

RECORD = (
    index("joint", "c of the base path; 0 where it is replayed whole"),
    index("end", "index of its last surface point, 2 to V; 0 for no path"),
    index("technique", "1: its light was sampled; 2: an emitter hit; 0: no path"),
    vector(
        "incoming", "light that arrives at x_c, over all densities beyond, W/(m² sr)"
    ),
    real("density", "p · s · p_onward of the base path at its joint"),
    real("pdf_light", "with which the light after x_c is chosen, 1/sr; 0: never"),
)

MORE = (
    vector("base_position", "x_(c−1) of the base path, m"),
    vector("base_throughput", "product of its weights of x_1 to x_(c−2)"),
    real("base_pdf_left", "with which it left x_(c−1), 1/sr"),
    real("base_pdf_onward", "with which it left x_c, 1/sr"),
    vector("base_value", "f / p at its own pixel, W/(m² sr)"),
)

WALK = (
    bits("hit", "1 where the walk has a point x_v", "V"),
    real("position", "where its rays leave x_v, m", "V", 3),
    real("contact", "x_v on its surface, as it is seen from x_(v−1), m", "V", 3),
    real("alpha", "GGX width at x_v; 1 for diffuse, 0 for single directions", "V"),
    bits("single", "1 where x_v scatters into single directions alone", "V"),
    real("weight", "f cos / p of the direction drawn at x_v", "V", 3),
    bits("delta", "1 where that was drawn from a delta lobe", "V"),
)

CONNECTION = (
    vector("joint_position", "x_c on its surface, m"),
    vector("joint_normal", "unit normal, on the side that the base path came from"),
    real("joint_alpha", "GGX width there; 1 for diffuse, 0 for single directions"),
    bits("joint_single", "1 where it scatters into single directions alone"),
    vector("left", "f cos at x_(c−1) towards x_c"),
    real("pdf_left", "density of that direction, 1/sr"),
    vector("onward", "f cos at x_c, from x_(c−1), in the base path's direction"),
    real("pdf_onward", "density of that direction, 1/sr"),
    bits("seen", "1 where nothing lies between x_(c−1) and x_c"),
)

SHIFT = Pass(
    name="shift",
    summary="Value of a path at another pixel, and the Jacobian of its shift",
    formula=(
        "D = y − x, d = |D|, from a point x to a point y;\n"
        "came_v, v = 2 to V: pass joinable of x_(v−1) and x_v, with d from "
        "position_(v−1) to contact_v, and delta_(v−1) = 0, and v ≤ last_joint; "
        "came_1 = 0;\n"
        "joint = c > 0, at m = c − 1, with D and d from position_m to joint_position: "
        "there is a path where hit_1 to hit_m are 1; came_v is 0, or delta_v 1, for "
        "v < m; came_m is 0; joinable of x_m and the joint is 1; joint_normal · D < 0; "
        "seen is 1; and c = 2 or replays is 1;\n"
        "q = pdf_onward; where c = end, share = pdf_light / (pdf_light + q) for "
        "technique 1, or 1 where pdf_light is 0, and q / (q + pdf_light) for technique "
        "2; for technique 1 then q = 1; share = 1 where c < end;\n"
        "value = weight_1 ⋯ weight_(m−1) · left / pdf_left · onward / q · share · "
        "incoming;\n"
        "jacobian = pdf_left · s · q / density, s = |joint_normal · D| / d³;\n"
        "joint = 0, at m = end: there is a path where replays is 1; hit_1 to hit_m are "
        "1; came_v is 0, or delta_v 1, for v < m; and at m too for technique 2; for "
        "technique 1 came_m is 0;\n"
        "value = weight_1 ⋯ weight_(m−1) · light, jacobian = 1;\n"
        "both 0 where there is no path, or value is 0"
    ),
    inputs=(
        index("path", "number of the base path; only for a backend that walks itself"),
        index("pixel", "row y · size + x that it is shifted to; likewise"),
        *RECORD,
        *MORE,
        *WALK,
        *CONNECTION,
        vector("light", "of x_end by the technique: f cos L / p, with its share"),
    ),
    outputs=(
        vector("value", "f / p at the pixel, W/(m² sr)"),
        real("jacobian", "J = |∂u_to / ∂u_from|"),
    ),
    settings=(
        *CRITERION,
        Setting("last_joint", "whole number", "largest index of a joint"),
        Setting("replays", "0 or 1", "whether any but joints at x_2 are shifted"),
        Setting("scene", "name", "where the tables come from; not needed"),
        Setting("size", "pixels", "of its square image; not needed"),
        Setting("seed", "whole number, 0 to 2²⁷ − 1", "of its run; not needed"),
        Setting("frame", "whole number, 0 to 2²⁷ − 1", "of its paths; not needed"),
        Setting("bounces", "whole number", "V − 1; of indirect light"),
    ),
    source=(
        "[Lin22, section 7.2]. V columns are the points x_1 to x_V of the offset walk, "
        "of which x_1 is the pixel's visible point, and which draws with the base "
        "path's random numbers. Where the offset walk has no "
        "point, its columns hold the base path's numbers: what stands there is to be "
        "refused, not read. None of the columns base_ is needed. What lies under a "
        "smooth coat counts as diffuse"
    ),
    clauses=(
        "both ends of a joint are rough",
        "the joint is far enough away",
        "the joint is seen, from its front",
        "a path that could be joined earlier does not exist",
        "points left by a delta lobe are no joints",
        "the walk is long enough",
        "points beyond the last joint are not joined",
        "only joints at x_2 where replays is 0",
        "the throughput is the offset path's",
        "the density at x_c is divided by, but not where the light was chosen",
        "the share is that of the offset path and of its technique",
        "the share is 1 where pdf_light is 0",
        "the Jacobian is that of the offset path over the base path",
        "the Jacobian of what is replayed is 1",
    ),
)

SHIFT_PASSES = (JOINABLE, PATH_JACOBIAN, SHIFT)
