"""A judge for each of the further passes."""

from collections.abc import Callable, Mapping

from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.further.packing import judge_pack, judge_unpack
from restir_gi.reference.oracle.replay.further.pixels import (
    judge_checkerboard,
    judge_roulette,
)
from restir_gi.reference.oracle.replay.further.reservoirs import (
    judge_boiling,
    judge_validation,
)
from restir_gi.reference.oracle.replay.further.visible import (
    judge_gbuffer,
    judge_reproject,
)
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.rules import Rules

FURTHER_JUDGES: Mapping[str, Callable[[Case, Buffers, Rules, Precision], Judgement]] = {
    "gbuffer": judge_gbuffer,
    "reproject": judge_reproject,
    "validation": judge_validation,
    "boiling": judge_boiling,
    "checkerboard": judge_checkerboard,
    "roulette": judge_roulette,
    "pack": judge_pack,
    "unpack": judge_unpack,
}
