"""Differences of pixels and their images as a part of the contract."""

from restir_gi.gradient_domain.oracle.cases import declared_cases, pair_cases
from restir_gi.gradient_domain.oracle.contract import GRADIENT_PASSES
from restir_gi.gradient_domain.oracle.edges import (
    judge_edge_pair,
    judge_pair_motion,
    judge_pair_search,
)
from restir_gi.gradient_domain.oracle.exact import exact_probes
from restir_gi.gradient_domain.oracle.images import (
    judge_differences,
    judge_pair_differences,
    judge_poisson_l1,
    judge_poisson_l2,
    judge_primal,
)
from restir_gi.gradient_domain.oracle.mistakes import GRADIENT_MISTAKES
from restir_gi.gradient_domain.oracle.own import OWN
from restir_gi.gradient_domain.oracle.replay import (
    judge_after_estimate,
    judge_inner_shift,
    judge_outer_shift,
    judge_pair_estimate,
    judge_pair_initial,
    judge_pair_reuse,
    judge_pair_target,
    judge_pair_value,
    judge_pair_weight,
)
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import SEED, Part


def _probes(precision: Precision, seed: int = SEED) -> list[Probe]:
    tables = [replayed("L0", case) for case in pair_cases(precision, seed)]
    return [*tables, *exact_probes(precision)]


def _more(precision: Precision, seed: int = SEED) -> list[Probe]:
    return [replayed("L0", case) for case in declared_cases(precision, seed)]


PART = Part(
    title="differences of pixels",
    passes=GRADIENT_PASSES,
    judges={
        "pair_value": judge_pair_value,
        "pair_weight": judge_pair_weight,
        "pair_target": judge_pair_target,
        "pair_initial": judge_pair_initial,
        "inner_shift": judge_inner_shift,
        "outer_shift": judge_outer_shift,
        "pair_reuse": judge_pair_reuse,
        "pair_estimate": judge_pair_estimate,
        "after_estimate": judge_after_estimate,
        "edge_pair": judge_edge_pair,
        "pair_search": judge_pair_search,
        "pair_motion": judge_pair_motion,
        "primal": judge_primal,
        "pair_differences": judge_pair_differences,
        "differences": judge_differences,
        "poisson_l2": judge_poisson_l2,
        "poisson_l1": judge_poisson_l1,
    },
    own=OWN,
    probes=_probes,
    hypotheses=GRADIENT_MISTAKES,
    more=_more,
)
