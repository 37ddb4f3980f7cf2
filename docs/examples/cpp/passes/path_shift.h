// The hybrid shift: a path is replayed up to its joint, and joined there.
#pragma once

#include <cmath>
#include <utility>

#include "../samples.h"

// ---------------------------------------------------------------- where paths are joined

struct Scatterer {
    float alpha;
    bool single;  // it scatters into single directions alone
};

struct Criterion {
    float roughness, least_distance;

    explicit Criterion(const Case& c)
        : roughness(c.number("roughness")),
          least_distance(c.number("least_distance") * c.number("extent")) {}

    bool rough(Scatterer x) const {
        float perceptual = plant("alpha-for-roughness") ? x.alpha : std::sqrt(x.alpha);
        return !x.single && perceptual >= roughness;
    }

    bool joinable(Scatterer from, Scatterer to, float distance) const {
        return distance > 0 && distance > least_distance && rough(from) && rough(to);
    }
};

inline void pass_joinable(Case& c) {
    Criterion criterion(c);
    for (size_t i = 0; i < c.rows; i++) {
        Scatterer from = {c.reals("alpha_from")[i], c.bits("single_from")[i] != 0};
        Scatterer to = {c.reals("alpha_to")[i], c.bits("single_to")[i] != 0};
        c.result<uint32_t>("joinable")[i] = criterion.joinable(from, to, c.reals("distance")[i]);
    }
}

// ---------------------------------------------------------------- its Jacobian

// |cos| / d^2: what an area at the joint spans in directions from x.
inline float solid_angle(Vec3 x, Vec3 joint, Vec3 joint_normal) {
    Vec3 v = joint - x;
    float d = length(v);
    return over(std::fabs(dot(joint_normal, v)), d * d * d);
}

inline void pass_path_jacobian(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 joint = c.vectors("joint_position")[i], normal = c.vectors("joint_normal")[i];
        float from = solid_angle(c.vectors("x_from")[i], joint, normal);
        float to = solid_angle(c.vectors("x_to")[i], joint, normal);
        if (!plant("path-jacobian-of-solid-angles")) {
            from *= c.reals("p_from")[i] * c.reals("p_onward_from")[i];
            to *= c.reals("p_to")[i] * c.reals("p_onward_to")[i];
        }
        if (plant("path-jacobian-inverted")) std::swap(from, to);
        c.result<float>("jacobian")[i] = over(to, from);
    }
}

// ---------------------------------------------------------------- paths

enum Technique { NO_PATH = 0, LIGHT_SAMPLED = 1, EMITTER_HIT = 2 };

// The path that is shifted: where its joint and its end are, and how it found its light.
struct BasePath {
    int joint, end, technique;

    BasePath(const Case& c, size_t i)
        : joint(c.indices("joint")[i]),
          end(c.indices("end")[i]),
          technique(c.indices("technique")[i]) {}
};

// The walk from the other pixel, with the base path's random numbers: x_1 to x_V.
struct OffsetWalk {
    const Case& c;
    const Criterion& criterion;
    size_t first;  // of its columns
    int last_joint;

    OffsetWalk(const Case& case_, const Criterion& criterion_, size_t i)
        : c(case_),
          criterion(criterion_),
          first(i * case_.columns("hit")),
          last_joint(case_.whole("last_joint")) {}

    size_t column(int v) const { return first + static_cast<size_t>(v) - 1; }
    bool hit(int v) const { return c.bits("hit")[column(v)] != 0; }
    bool delta(int v) const { return c.bits("delta")[column(v)] != 0; }
    Vec3 position(int v) const { return c.vectors("position")[column(v)]; }
    Vec3 contact(int v) const { return c.vectors("contact")[column(v)]; }
    Vec3 weight(int v) const { return c.vectors("weight")[column(v)]; }
    Scatterer scatterer(int v) const {
        return {c.reals("alpha")[column(v)], c.bits("single")[column(v)] != 0};
    }

    bool reaches(int m) const {
        for (int v = 1; v <= m; v++)
            if (!hit(v)) return false;
        return true;
    }

    // Whether the step to x_v could have been a joint, as it came.
    bool came(int v) const {
        if (v < 2 || v > last_joint || delta(v - 1)) return false;
        float distance = length(contact(v) - position(v - 1));
        return criterion.joinable(scatterer(v - 1), scatterer(v), distance);
    }

    // Whether the walk would have been joined at x_v, and its shift back be another one.
    bool joins(int v) const { return came(v) && !delta(v); }

    bool joins_before(int m) const {
        if (plant("earlier-joint-accepted")) return false;
        for (int v = 2; v < m; v++)
            if (joins(v)) return true;
        return false;
    }

    Vec3 throughput(int m) const {
        Vec3 product = {1, 1, 1};
        for (int v = 1; v < m; v++) product = product * weight(v);
        return product;
    }
};

struct Shifted {
    Vec3 value;
    float jacobian;
};

inline const Shifted NO_SHIFT = {{0, 0, 0}, 0};

// ---------------------------------------------------------------- joined paths

// Whether the offset path can be joined from x_m, and would not have been earlier.
inline bool can_join(const Case& c, size_t i, const OffsetWalk& walk, int m) {
    bool shifts = m == 1 || c.whole("replays") == 1;
    if (!shifts || !walk.reaches(m) || walk.joins_before(m)) return false;
    if (walk.came(m) && !plant("earlier-joint-accepted")) return false;
    if (!c.bits("seen")[i] && !plant("hidden-joint-accepted")) return false;
    Vec3 D = c.vectors("joint_position")[i] - walk.position(m);
    Scatterer joint = {c.reals("joint_alpha")[i], c.bits("joint_single")[i] != 0};
    return dot(c.vectors("joint_normal")[i], D) < 0 &&
           walk.criterion.joinable(walk.scatterer(m), joint, length(D));
}

// MIS share of the technique that found the light after x_c.
inline float technique_share(int technique, float pdf_light, float pdf_onward) {
    if (pdf_light == 0) return 1;
    float found = technique == LIGHT_SAMPLED ? pdf_light : pdf_onward;
    return over(found, pdf_light + pdf_onward);
}

inline Shifted joined(const Case& c, size_t i, const OffsetWalk& walk, const BasePath& base) {
    int m = base.joint - 1;
    if (!can_join(c, i, walk, m)) return NO_SHIFT;
    float pdf_left = c.reals("pdf_left")[i], q = c.reals("pdf_onward")[i], share = 1;
    if (base.joint == base.end) {
        share = technique_share(base.technique, c.reals("pdf_light")[i], q);
        // The light was chosen, and no direction was drawn at x_c.
        if (base.technique == LIGHT_SAMPLED) q = 1;
    }
    Vec3 before = plant("base-throughput") ? c.vectors("base_throughput")[i] : walk.throughput(m);
    Vec3 left = over(1, pdf_left) * c.vectors("left")[i];
    Vec3 onward = over(share, q) * c.vectors("onward")[i];
    Vec3 x = plant("base-distance") ? c.vectors("base_position")[i] : walk.position(m);
    float s = solid_angle(x, c.vectors("joint_position")[i], c.vectors("joint_normal")[i]);
    return {before * left * onward * c.vectors("incoming")[i],
            over(pdf_left * s * q, c.reals("density")[i])};
}

// ---------------------------------------------------------------- replayed paths

inline Shifted replayed(const Case& c, size_t i, const OffsetWalk& walk, const BasePath& base) {
    int m = base.end;
    if (c.whole("replays") != 1 || !walk.reaches(m) || walk.joins_before(m)) return NO_SHIFT;
    // A sampled light could be joined at x_end however that was left.
    bool joins = base.technique == LIGHT_SAMPLED ? walk.came(m) : walk.joins(m);
    if (joins && !plant("earlier-joint-accepted")) return NO_SHIFT;
    return {walk.throughput(m) * c.vectors("light")[i], 1};
}

inline void pass_shift(Case& c) {
    Criterion criterion(c);
    for (size_t i = 0; i < c.rows; i++) {
        OffsetWalk walk(c, criterion, i);
        BasePath base(c, i);
        Shifted found = NO_SHIFT;
        if (base.technique != NO_PATH)
            found = (base.joint > 0 ? joined : replayed)(c, i, walk, base);
        bool dark = found.value.x == 0 && found.value.y == 0 && found.value.z == 0;
        c.result<Vec3>("value")[i] = found.value;
        c.result<float>("jacobian")[i] = dark ? 0 : found.jacobian;
    }
}

inline const PassTable PATH_SHIFT_PASSES = {{"joinable", pass_joinable},
                                            {"path_jacobian", pass_path_jacobian},
                                            {"shift", pass_shift}};
