// Formulas of which the resampling is made, one at a time.
#pragma once

#include "../samples.h"

inline void pass_target(Case& c) {
    float* p_hat = c.result<float>("p_hat");
    bool outgoing = c.is("target", "outgoing");
    for (size_t i = 0; i < c.rows; i++)
        p_hat[i] = target(outgoing, receiver(c, i), sample(c, i));
}

inline void pass_jacobian(Case& c) {
    float* J = c.result<float>("jacobian");
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 n = c.vectors("normal")[i];
        Receiver from = {c.vectors("x_from")[i], n, n}, to = {c.vectors("x_to")[i], n, n};
        J[i] = jacobian(from, to, {c.vectors("position")[i], n, n});
    }
}

inline void pass_merge(Case& c) {
    uint32_t* second = c.result<uint32_t>("second");
    float *w = c.result<float>("w"), *M = c.result<float>("M");
    const float *w_a = c.reals("w_a"), *w_b = c.reals("w_b"), *u = c.reals("u");
    for (size_t i = 0; i < c.rows; i++) {
        second[i] = keeps(u[i], w_a[i], w_b[i]);
        w[i] = w_a[i] + w_b[i];
        M[i] = c.reals("M_a")[i] + c.reals("M_b")[i];
    }
}

inline void pass_finalize(Case& c) {
    float* W = c.result<float>("W");
    for (size_t i = 0; i < c.rows; i++) {
        W[i] = over(over(c.reals("w")[i], c.reals("p_hat")[i]), c.reals("Z")[i]);
        W[i] = std::min(W[i], 3.4028234e38f);
    }
}

inline void pass_similar(Case& c) {
    uint32_t* out = c.result<uint32_t>("similar");
    Similarity similar(c);
    for (size_t i = 0; i < c.rows; i++)
        out[i] = similar(c.vectors("normal_a")[i], c.reals("depth_a")[i],
                         c.vectors("normal_b")[i], c.reals("depth_b")[i]);
}

inline const PassTable KERNEL_PASSES = {{"target", pass_target},
                                        {"jacobian", pass_jacobian},
                                        {"merge", pass_merge},
                                        {"finalize", pass_finalize},
                                        {"similar", pass_similar}};
