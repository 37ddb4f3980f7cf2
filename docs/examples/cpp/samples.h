// Visible points, samples and reservoirs; target, Jacobian and the tests between points.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "case_files.h"
#include "mistakes.h"
#include "vectors.h"

struct Receiver {
    Vec3 position, normal, albedo;
};

struct Sample {
    Vec3 position, normal, radiance;
};

struct Reservoir {
    Sample y;
    float W, M;
};

inline Receiver receiver(const Case& c, size_t i, const std::string& prefix = "") {
    return {c.vectors(prefix + "visible_position")[i],
            c.vectors(prefix + "visible_normal")[i], c.vectors(prefix + "albedo")[i]};
}

inline Sample sample(const Case& c, size_t i, const std::string& prefix = "") {
    return {c.vectors(prefix + "position")[i], c.vectors(prefix + "normal")[i],
            c.vectors(prefix + "radiance")[i]};
}

inline Reservoir reservoir(const Case& c, size_t i, const std::string& prefix = "") {
    return {sample(c, i, prefix), c.reals(prefix + "W")[i], c.reals(prefix + "M")[i]};
}

inline float planted_cosine(float cosine) {
    return plant("cosine-omitted") ? 1 : plant("cosine-twice") ? cosine * cosine : cosine;
}

// Target of Equation 9 or 10; 0 below the horizon and on the unlit side.
inline float target(bool outgoing, const Receiver& x, const Sample& y) {
    Vec3 v = y.position - x.position;
    if (dot(x.normal, v) <= 0 || dot(y.normal, v) >= 0) return 0;
    if (outgoing) return luminance(y.radiance);
    // 0 where the square of the distance is too small for single precision.
    float cosine = planted_cosine(over(dot(x.normal, v), length(v)));
    float pi = plant("missing-one-over-pi") ? 1 : PI;
    return luminance(x.albedo * y.radiance) / pi * cosine;
}

// Equation 11: |d omega_to / d omega_from|.
inline float jacobian(const Receiver& from, const Receiver& to, const Sample& y) {
    if (plant("jacobian-omitted")) return 1;
    Vec3 v = from.position - y.position, w = to.position - y.position;
    float d_from = dot(v, v), d_to = dot(w, w);
    if (d_from == 0 || d_to == 0) return 0;
    float cosine_from = std::fabs(dot(y.normal, v)) / std::sqrt(d_from);
    float cosine_to = std::fabs(dot(y.normal, w)) / std::sqrt(d_to);
    if (plant("jacobian-receiver-cosine")) {
        cosine_from = std::fabs(dot(from.normal, v)) / std::sqrt(d_from);
        cosine_to = std::fabs(dot(to.normal, w)) / std::sqrt(d_to);
    }
    float ratio = d_from / d_to;
    if (plant("jacobian-unsquared")) ratio = std::sqrt(ratio);
    float J = over(cosine_to, cosine_from) * ratio;
    if (plant("jacobian-divided")) return over(1, J);
    if (plant("jacobian-clamped")) return std::min(std::max(J, 1.0f / 3), 3.0f);
    return std::isfinite(J) ? J : 0;
}

// Whether a candidate takes the place of what was kept before it.
inline bool keeps(float u, float before, float w) {
    if (before == 0) return w > 0;
    if (plant("accept-old-sum")) return u * before < w;
    return u * (before + w) < w;
}

// In double precision: the limit itself belongs to what is similar.
inline float cosine_of_degrees(double angle) {
    return static_cast<float>(std::cos(angle * 3.14159265358979 / 180));
}

// Whether two visible points may share samples.
struct Similarity {
    float least_cosine, max_depth;

    explicit Similarity(const Case& c)
        : least_cosine(cosine_of_degrees(c.number("max_angle"))),
          max_depth(c.number("max_depth")) {}

    // `z_a` is the depth of the point that asks.
    bool operator()(Vec3 n_a, float z_a, Vec3 n_b, float z_b) const {
        float scale = plant("depth-relative-to-own") ? z_a : std::max(z_a, z_b);
        return z_a > 0 && z_b > 0 && dot(n_a, n_b) >= least_cosine &&
               std::fabs(z_a - z_b) <= max_depth * scale;
    }
};
