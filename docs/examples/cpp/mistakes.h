// Mistakes that others have made: `--plant NAME` makes one of them.
#pragma once

#include <string>

inline std::string planted;

inline bool plant(const char* name) { return planted == name; }

inline const char* const PLANTS[] = {
    // from random to shade
    "jacobian-divided", "jacobian-omitted", "jacobian-unsquared",
    "jacobian-receiver-cosine", "jacobian-clamped", "cosine-omitted", "cosine-twice",
    "missing-one-over-pi", "one-over-m", "nulls-not-counted", "m-times-two",
    "cap-missing", "confidence-missing", "source-target", "canonical-missing",
    "visibility-ignored-in-z", "visibility-ignored-in-weight", "hidden-not-counted",
    "accept-old-sum", "wrong-pdf", "random-reused", "depth-relative-to-own",
    "radius-not-halved", "albedo-missing", "cap-before-weight",
    // fused
    "source-point-of-now",
    // gbuffer, reproject
    "pixel-corner", "distance-for-depth", "place-rounded", "own-pixel-tested",
    // validation, boiling
    "darker-alone", "null-cleared", "boiling-mean-over-all", "filter-keeps-m",
    // checkerboard, roulette
    "checkerboard-frozen", "roulette-not-divided", "roulette-by-pixels",
    // pack, unpack
    "half-overflows", "half-cut-off", "sign-of-zero", "normal-code-unmasked",
    "upper-half-first", "normal-code-unsigned",
    // path_reuse
    "reuse-jacobian-omitted", "reuse-maker-without-jacobian", "reuse-pairs-exchanged",
    "reuse-empty-slots-counted",
    // joinable, path_jacobian, shift
    "alpha-for-roughness", "path-jacobian-inverted", "path-jacobian-of-solid-angles",
    "earlier-joint-accepted", "hidden-joint-accepted", "base-throughput",
    "base-distance",
    // cell_insert, cell_find, cell_scan, cell_level
    "insertion-lost", "checksum-missing", "scan-inclusive", "eye-of-now",
    // from pair_value to pair_motion
    "inner-jacobian-missing", "second-not-turned",
    "luminance-of-the-sum", "candidates-halved", "step-not-turned", "offset-carried",
    "edges-where-normals-agree", "edge-depth-of-the-first", "first-pixels-alone",
    "motion-of-the-first",
    // primal, pair_differences, poisson_l2, poisson_l1
    "primal-with-emission", "pair-differences-not-turned", "alpha-not-squared",
    "poisson-wraps-around", "divergence-sign", "squares-for-absolute-values"};
