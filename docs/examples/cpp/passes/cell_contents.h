// What the cells of a hash grid keep: light reservoirs, and suffixes of paths.
#pragma once

#include "path_reuse.h"

// ---------------------------------------------------------------- light

inline void pass_light_target(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 v = c.vectors("light_position")[i] - c.vectors("visible_position")[i];
        float d = length(v);
        float theta = dot(c.vectors("visible_normal")[i], v) / d;
        float phi = -dot(c.vectors("light_normal")[i], v) / d;
        Vec3& value = c.result<Vec3>("value")[i];
        value = {0, 0, 0};
        if (theta <= 0 || phi <= 0) continue;
        // Radiance over its density in solid angle.
        float pdf = d * d / (phi * c.reals("area")[i]);
        value = (theta / (PI * pdf)) * (c.vectors("albedo")[i] * c.vectors("radiance")[i]);
    }
}

inline void pass_light_candidates(Case& c) {
    size_t count = c.columns("p_hat");
    for (size_t i = 0; i < c.rows; i++) {
        const float *p_hat = c.reals("p_hat") + i * count, *u = c.reals("u") + i * count;
        const float* choice = c.reals("choice") + i * count;
        const float* density = c.reals("density") + i * count;
        size_t kept = 0;
        float total = 0;
        for (size_t k = 0; k < count; k++) {
            float w = p_hat[k] / choice[k] / density[k];
            if (keeps(u[k], total, w)) kept = k;
            total += w;
        }
        float M = static_cast<float>(count);
        c.result<int32_t>("slot")[i] = static_cast<int32_t>(kept);
        c.result<float>("W")[i] = over(total, p_hat[kept]) / M;
        c.result<float>("M")[i] = M;
    }
}

// A point on a light is the same seen from anywhere: all Jacobians are 1.
inline void pass_light_reuse(Case& c) {
    Buffer& jacobian = c.in["jacobian"] = c.in.at("W");
    float* ones = reinterpret_cast<float*>(jacobian.bytes.data());
    std::fill(ones, ones + jacobian.count(), 1.0f);
    c.settings["canonical"] = "0";
    pass_path_reuse(c);
}

// ---------------------------------------------------------------- suffixes of paths

inline void pass_bounce_reservoir(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 longer = c.vectors("weight")[i] * c.vectors("value_suffix")[i];
        float w_end = c.reals("w_end")[i];
        float w_longer = luminance(longer) * c.reals("W_suffix")[i];
        bool takes = keeps(c.reals("u")[i], w_end, w_longer);
        Vec3 value = takes ? longer : c.vectors("value_end")[i];
        c.result<uint32_t>("longer")[i] = takes;
        c.result<Vec3>("value")[i] = value;
        c.result<float>("W")[i] = over(w_end + w_longer, luminance(value));
        c.result<float>("M")[i] = 1;  // a path without light counts
    }
}

inline void pass_path_cache(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        c.result<uint32_t>("stored")[i] = c.bits("rough")[i];
        c.result<float>("W")[i] = c.indices("joint")[i] == 2 ? c.reals("W")[i] : 0;
        c.result<float>("M")[i] = c.reals("M")[i];
    }
}

inline void pass_suffix_reach(Case& c) {
    int32_t bounces = c.whole("bounces");
    for (size_t i = 0; i < c.rows; i++) {
        bool fits = c.indices("end")[i] + c.indices("v")[i] <= bounces + 2;
        c.result<Vec3>("value")[i] = fits ? c.vectors("value")[i] : Vec3{0, 0, 0};
        c.result<float>("jacobian")[i] = fits ? c.reals("jacobian")[i] : 0;
    }
}

inline const PassTable CELL_CONTENT_PASSES = {
    {"light_target", pass_light_target},         {"light_candidates", pass_light_candidates},
    {"light_reuse", pass_light_reuse},           {"path_cache", pass_path_cache},
    {"bounce_reservoir", pass_bounce_reservoir}, {"suffix_reach", pass_suffix_reach}};
