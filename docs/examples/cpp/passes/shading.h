// The estimate that the reservoirs of a frame leave.
#pragma once

#include "../samples.h"

inline void pass_shade(Case& c) {
    Vec3* color = c.result<Vec3>("color");
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Sample y = sample(c, i);
        Vec3 v = y.position - x.position;
        Vec3* f = c.result<Vec3>("term_f") + i;
        color[i] = *f = {0, 0, 0};
        if (dot(x.normal, v) <= 0 || dot(y.normal, v) >= 0) continue;
        float cosine = planted_cosine(dot(x.normal, v) / std::sqrt(dot(v, v)));
        float pi = plant("missing-one-over-pi") ? 1 : PI;
        Vec3 albedo = plant("albedo-missing") ? Vec3{1, 1, 1} : x.albedo;
        *f = (cosine / pi) * (albedo * y.radiance);
        color[i] = c.reals("W")[i] * *f;
    }
}

inline const PassTable SHADING_PASSES = {{"shade", pass_shade}};
