"""Mistakes in pairs of paths and their images are refuted by the tests of them."""

from functools import partial

import pytest

from restir_gi.gradient_domain.gradient_restir import MINUS
from restir_gi.gradient_domain.least_absolute import least_absolute
from restir_gi.gradient_domain.reconstruction import least_squares
from tests.analytic import test_reconstruction as images
from tests.contracts import test_gradient_methods as methods
from tests.exact import test_paired_domain as exact
from tests.exact.paired import A
from tests.mutants.gradients import GRADIENT_MUTANTS, IMAGE_MUTANTS
from tests.mutants.plant import is_refuted, planted
from tests.properties import test_paired_paths as paths
from tests.properties import test_pairs_of_pixels as pixels


def none(faults):
    assert next(iter(faults), None) is None


# The quick ones first.
EVIDENCE = [
    paths.test_what_a_sample_says_of_a_difference,
    paths.test_parts_of_both_signs_make_the_whole,
    paths.test_channels_of_both_signs_do_not_cancel,
    partial(pixels.test_what_is_an_edge, "normal, enough"),
    partial(pixels.test_differences_are_minus_those_of_pairs, (5, 3)),
    pixels.test_pairs_around_are_drawn_evenly_from_a_square,
    lambda: exact.test_the_integrand_is_that_of_the_difference(A),
    lambda: none(exact.new_samples(A, exact.fresh())),
    lambda: none(exact.halves(exact.fresh(), "balance", exact.within)),
    lambda: none(exact.halves(exact.fresh(), "1/Z", exact.across)),
    partial(exact.test_a_chain_of_frames, "1/Z", MINUS),
    methods.test_confidence_grows_to_its_cap_and_looks_at_no_sample,
    paths.test_the_nearer_pixel_is_the_pivot,
    partial(paths.test_the_outer_shift_is_that_of_the_base_path, "paint"),
    methods.test_the_past_is_trusted_as_it_says,
]

IMAGE_EVIDENCE = [
    partial(methods.test_what_is_biased_is_told, "l1"),
    methods.test_a_picture_is_made_from_pixels_and_differences,
    methods.test_pixels_and_differences_are_averaged_before_the_image_is_made,
    partial(images.test_it_is_the_solution_of_a_sparse_solver, 13, 8),
    *(
        partial(images.test_an_image_with_its_own_differences_comes_back, make, 13, 8)
        for make in (least_squares, least_absolute)
    ),
    partial(images.test_no_image_is_much_better, 0),
]


def cases(mutants):
    return [pytest.param(m, id=m.name) for m in mutants]


@pytest.mark.parametrize("mutant", cases(GRADIENT_MUTANTS))
@pytest.mark.few(2)
def test_mistakes_in_pairs_are_refuted(mutant):
    with planted(mutant):
        assert any(is_refuted(evidence) for evidence in EVIDENCE)


@pytest.mark.parametrize("mutant", cases(IMAGE_MUTANTS))
def test_mistakes_in_images_are_refuted(mutant):
    with planted(mutant):
        assert any(is_refuted(evidence) for evidence in IMAGE_EVIDENCE)


@pytest.mark.slow
def test_control_without_a_mistake_nothing_is_refuted():
    assert not any(is_refuted(e) for e in (*EVIDENCE, *IMAGE_EVIDENCE))
