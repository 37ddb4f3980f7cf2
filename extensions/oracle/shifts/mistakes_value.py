"""Known mistakes with the value of shifted paths."""

from restir_gi.extensions.oracle.shifts.rules import ShiftRules
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake

SHIFT = ("shift",)
SHARE_RIGHT = "the share of the technique, with the offset path's density at x_c"

VALUES = (
    mistake(
        "distance-from-the-base",
        "the solid angle of the joint is that from the base path's x_(c−1)",
        "s of D = x_c − base_position",
        "s of D = x_c − position_(c−1)",
        SHIFT,
        "Vulkan-ReSTIR-PT ae52a17",
        part=ShiftRules(bases_distance=True),
    ),
    mistake(
        "joined-one-vertex-late",
        "the offset path is replayed to x_c, and joined from there",
        "m = c",
        "m = c − 1",
        SHIFT,
        part=ShiftRules(replayed_once_more=1),
    ),
    mistake(
        "joined-one-vertex-early",
        "the offset path is joined from x_(c−2)",
        "m = c − 2",
        "m = c − 1",
        SHIFT,
        part=ShiftRules(replayed_once_more=-1),
    ),
    mistake(
        "bases-throughput",
        "the throughput up to the joint is the base path's",
        "value = base_throughput · …",
        "value = weight_1 ⋯ weight_(m−1) · …",
        SHIFT,
        part=ShiftRules(throughput="base"),
    ),
    mistake(
        "throughput-left-out",
        "the throughput up to the joint is left out",
        "value = left / pdf_left · …",
        "value = weight_1 ⋯ weight_(m−1) · left / pdf_left · …",
        SHIFT,
        part=ShiftRules(throughput="none"),
    ),
    mistake(
        "throughput-is-the-last-weight",
        "each weight takes the place of the product",
        "value = weight_(m−1) · …",
        "value = weight_1 ⋯ weight_(m−1) · …",
        SHIFT,
        part=ShiftRules(throughput="last", end_throughput="last"),
    ),
    mistake(
        "replayed-throughput-left-out",
        "the throughput of paths that are replayed whole is left out",
        "value = light",
        "value = weight_1 ⋯ weight_(m−1) · light",
        SHIFT,
        part=ShiftRules(end_throughput="none"),
    ),
    mistake(
        "bases-value",
        "the value that the base path had is kept",
        "value = base_value",
        "value of the offset path",
        SHIFT,
        part=ShiftRules(bases_value=True),
    ),
    mistake(
        "share-of-the-base",
        "the share of the technique is the base path's",
        "the share, with base_pdf_onward",
        SHARE_RIGHT,
        SHIFT,
        part=ShiftRules(share="base"),
    ),
    mistake(
        "share-of-the-other-technique",
        "the shares of both techniques change places",
        "pdf_onward / (pdf_light + pdf_onward) for technique 1",
        SHARE_RIGHT,
        SHIFT,
        part=ShiftRules(share="other"),
    ),
    mistake(
        "share-of-choice-for-both",
        "emitter hits have the MIS weight of light sampling",
        "pdf_light / (pdf_light + pdf_onward) for technique 2",
        SHARE_RIGHT,
        SHIFT,
        part=ShiftRules(share="choice"),
    ),
    mistake(
        "share-left-out",
        "a light after the joint keeps its whole weight",
        "share = 1",
        SHARE_RIGHT,
        SHIFT,
        part=ShiftRules(share="none"),
    ),
    mistake(
        "replayed-over-density",
        "paths without a joint are divided by the density of a joint, which is 0",
        "J = 1 / density, 0 where density is 0",
        "J = 1 where joint = 0",
        SHIFT,
        part=ShiftRules(replayed_over_density=True),
    ),
)
