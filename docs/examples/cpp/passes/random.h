// PCG4D, and directions on the hemisphere.
#pragma once

#include <array>

#include "../case_files.h"
#include "../mistakes.h"
#include "../vectors.h"

using Words = std::array<uint32_t, 4>;

inline void pcg4d_sums(Words& v) {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
}

inline Words pcg4d(Words v) {
    for (uint32_t& word : v) word = word * 1664525u + 1013904223u;
    pcg4d_sums(v);
    for (uint32_t& word : v) word ^= word >> 16;
    pcg4d_sums(v);
    return v;
}

inline float unit_number(uint32_t word) {
    return static_cast<float>(word >> 8) * 0x1p-24f;
}

inline void pass_random(Case& c) {
    const Words* key = reinterpret_cast<const Words*>(c.bits("key"));
    Words* words = c.result<Words>("words");
    float* u = c.result<float>("u");
    for (size_t i = 0; i < c.rows; i++) {
        words[i] = pcg4d(key[i]);
        for (size_t k = 0; k < 4; k++) u[4 * i + k] = unit_number(words[i][k]);
    }
}

inline void pass_direction(Case& c) {
    const Vec3* normal = c.vectors("visible_normal");
    const float* u = c.reals("u");
    Vec3* direction = c.result<Vec3>("direction");
    float* pdf = c.result<float>("pdf");
    bool uniform = c.is("source", "uniform");
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 n = normal[i];
        // Any frame about n: start from the axis that is least along it.
        Vec3 axis = std::fabs(n.x) < 0.6f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        Vec3 t = normalized(axis - dot(axis, n) * n);
        Vec3 b = cross(n, t);
        float cosine = uniform ? u[2 * i] : std::sqrt(1 - u[2 * i]);
        float sine = uniform ? std::sqrt((1 - cosine) * (1 + cosine)) : std::sqrt(u[2 * i]);
        float phi = 2 * PI * u[2 * i + 1];
        direction[i] = (sine * std::cos(phi)) * t + (sine * std::sin(phi)) * b + cosine * n;
        pdf[i] = uniform ? 1 / (plant("wrong-pdf") ? PI : 2 * PI) : cosine / PI;
    }
}

inline const PassTable RANDOM_PASSES = {{"random", pass_random}, {"direction", pass_direction}};
