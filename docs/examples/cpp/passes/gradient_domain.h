// Differences of two pixels from pairs of paths, which reservoirs of a sign keep.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "path_reuse.h"

// ---------------------------------------------------------------- samples

// A path of one pixel, and the path that its shift to the other pixel is.
struct PairSample {
    bool second;  // k: the base path is one of pixel j
    Vec3 base, offset;
    float inner;  // Jacobian of the shift; 0 without an offset path

    Vec3 G() const {
        float J = plant("inner-jacobian-missing") && inner > 0 ? 1 : inner;
        Vec3 difference = base - J * offset;
        return second && !plant("second-not-turned") ? -1.0f * difference : difference;
    }
};

// MIS weight of a base path beside its offset path.
inline float base_share(float p_base, float p_offset, float inner) {
    if (inner == 0) return p_base > 0 ? 1.0f : 0.0f;
    return over(p_base, p_base + p_offset * inner);
}

inline Vec3 integrand(const PairSample& s) { return base_share(1, 1, s.inner) * s.G(); }

// The part that a reservoir of a sign is for: 1, -1, or 0 for all of it.
inline Vec3 part_of(Vec3 H, int sign) {
    auto of = [sign](float x) { return sign > 0 ? std::max(x, 0.0f) : std::min(x, 0.0f); };
    return sign == 0 ? H : Vec3{of(H.x), of(H.y), of(H.z)};
}

inline int sign_of(const Case& c) {
    return c.is("sign", "plus") ? 1 : c.is("sign", "minus") ? -1 : 0;
}

inline Vec3 pair_contribution(const PairSample& s, int sign) {
    return part_of(integrand(s), sign);
}

inline float pair_target(const PairSample& s, int sign) {
    Vec3 c = pair_contribution(s, sign);
    if (plant("luminance-of-the-sum")) return std::fabs(luminance(integrand(s)));
    return luminance({std::fabs(c.x), std::fabs(c.y), std::fabs(c.z)});
}

// Sample at a place of buffers, such as base_from; k is in a buffer of its own, if at all.
inline PairSample pair_sample(const Case& c, size_t at, const std::string& end = "") {
    bool has_k = c.in.count("k" + end) > 0;
    return {has_k && c.bits("k" + end)[at] == 1, c.vectors("base" + end)[at],
            c.vectors("offset" + end)[at], c.reals("inner" + end)[at]};
}

inline void pass_pair_value(Case& c) {
    for (size_t i = 0; i < c.rows; i++) c.result<Vec3>("G")[i] = pair_sample(c, i).G();
}

inline void pass_pair_weight(Case& c) {
    for (size_t i = 0; i < c.rows; i++)
        c.result<float>("omega")[i] =
            base_share(c.reals("p_base")[i], c.reals("p_offset")[i], c.reals("inner")[i]);
}

inline void pass_pair_target(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        PairSample s = pair_sample(c, i);
        c.result<Vec3>("contribution")[i] = pair_contribution(s, sign_of(c));
        c.result<float>("p_hat")[i] = pair_target(s, sign_of(c));
    }
}

// ---------------------------------------------------------------- reservoirs

// The candidate of column k has its base path in the pixel that k names.
inline PairSample candidate(const Case& c, size_t i, size_t k) {
    PairSample s = pair_sample(c, 2 * i + k);
    s.second = k == 1;
    return s;
}

inline void pass_pair_initial(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        float p_hat[2], w[2];
        for (size_t k = 0; k < 2; k++) {
            p_hat[k] = pair_target(candidate(c, i, k), sign_of(c));
            // Both parts of the domain have one candidate each: its weight is 1.
            float m = plant("candidates-halved") ? 0.5f : 1.0f;
            w[k] = m * p_hat[k] * c.reals("W")[2 * i + k];
        }
        uint32_t kept = keeps(c.reals("u")[i], w[0], w[1]) ? 1 : 0;
        c.result<uint32_t>("k")[i] = kept;
        c.result<float>("p_hat")[i] = p_hat[kept];
        c.result<float>("W")[i] = over(w[0] + w[1], p_hat[kept]);
        c.result<float>("M")[i] = 1;
    }
}

inline void pass_pair_estimate(Case& c) {
    bool two = c.is("reservoirs", "two");
    for (size_t i = 0; i < c.rows; i++) {
        const float* W = c.reals("W") + 2 * i;
        PairSample first = pair_sample(c, 2 * i), second = pair_sample(c, 2 * i + 1);
        Vec3 delta = W[0] * pair_contribution(first, two ? 1 : 0);
        if (two) delta = delta + W[1] * pair_contribution(second, -1);
        c.result<Vec3>("delta")[i] = delta;
    }
}

// Of the two pixels' own reservoirs; targets stand in the place of densities.
inline void pass_after_estimate(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 delta = {0, 0, 0};
        for (size_t k = 0; k < 2; k++) {
            PairSample s = candidate(c, i, k);
            float share = base_share(luminance(s.base), luminance(s.offset), s.inner);
            delta = delta + (share * c.reals("W")[2 * i + k]) * s.G();
        }
        c.result<Vec3>("delta")[i] = delta;
    }
}

// ---------------------------------------------------------------- shifts

inline int32_t pixel_of_pair(const Case& c, size_t i, bool second) {
    return c.indices(second ? "second" : "first")[i];
}

inline void pass_inner_shift(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        bool onward = c.bits("k")[i] == 0;  // from pixel i to pixel j
        float step = onward || plant("step-not-turned") ? 1.0f : -1.0f;
        size_t to = 2 * i + (onward ? 1 : 0);
        float J = c.reals("jacobian_at")[to];
        c.result<int32_t>("pixel")[i] = pixel_of_pair(c, i, onward);
        c.result<float>("x_to")[i] = c.reals("x")[i] + step * c.reals("dx")[i];
        c.result<float>("y_to")[i] = c.reals("y")[i] + step * c.reals("dy")[i];
        c.result<Vec3>("offset")[i] = J > 0 ? c.vectors("value_at")[to] : Vec3{0, 0, 0};
        c.result<float>("inner")[i] = J;
    }
}

inline void pass_outer_shift(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        bool second = c.bits("k")[i] == 1;
        size_t to = 2 * i + (second ? 1 : 0);
        float J = c.reals("jacobian_at")[to];
        c.result<int32_t>("pixel")[i] = pixel_of_pair(c, i, second);
        if (!(J > 0)) continue;  // results begin as 0
        bool carried = plant("offset-carried");
        c.result<Vec3>("base")[i] = c.vectors("value_at")[to];
        c.result<Vec3>("offset")[i] =
            carried ? c.vectors("offset_from")[i] : c.vectors("rebuilt_at")[to];
        c.result<float>("inner")[i] =
            carried ? c.reals("inner_from")[i] : c.reals("inner_at")[to];
        c.result<float>("jacobian")[i] = J;
    }
}

// ---------------------------------------------------------------- reuse

// One float for each slot, or for each slot and source, as pass path_reuse has them.
inline float* add_reals(Case& c, const std::string& name, const char* like) {
    Buffer& made = c.in[name] = c.in.at(like);
    std::fill(made.bytes.begin(), made.bytes.end(), '\0');
    return reinterpret_cast<float*>(made.bytes.data());
}

// Reuse of whole paths, whose targets are those of pairs and of a sign.
inline void pass_pair_reuse(Case& c) {
    size_t slots = c.columns("W");
    int sign = sign_of(c);
    float* base = add_reals(c, "target_base", "W");
    float* here = add_reals(c, "target_here", "W");
    float* at = add_reals(c, "target_at", "jacobian_at");
    for (size_t slot = 0; slot < c.rows * slots; slot++) {
        PairSample made = pair_sample(c, slot, "_from"), moved = pair_sample(c, slot);
        moved.second = made.second;
        base[slot] = pair_target(made, sign);
        if (c.reals("jacobian")[slot] > 0) here[slot] = pair_target(moved, sign);
        for (size_t q = slot * slots; q < (slot + 1) * slots; q++) {
            PairSample there = pair_sample(c, q, "_at");
            there.second = made.second;
            float J = c.reals("jacobian_at")[q];
            at[q] = J > 0 ? pair_target(there, sign) * J : 0;
        }
    }
    pass_path_reuse(c);
}

// ---------------------------------------------------------------- pairs of pixels

struct SeenPixel {
    Vec3 albedo, normal;
    float depth;
    bool hit;
};

inline SeenPixel seen_pixel(const Case& c, size_t i, const std::string& end = "") {
    return {c.vectors("albedo" + end)[i], c.vectors("normal" + end)[i],
            c.reals("depth" + end)[i], c.bits("hit" + end)[i] == 1};
}

inline bool unlike(const SeenPixel& a, const SeenPixel& b) {
    if (!a.hit || !b.hit) return a.hit != b.hit;
    Vec3 d = a.albedo - b.albedo;
    float albedo = std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    float cosine = dot(a.normal, b.normal);
    bool turned = plant("edges-where-normals-agree") ? cosine > 0.9f : cosine < 0.9f;
    float scale = plant("edge-depth-of-the-first") ? a.depth : std::max(a.depth, b.depth);
    return albedo > 0.1f || turned || std::fabs(a.depth - b.depth) > 0.1f * scale;
}

inline void pass_edge_pair(Case& c) {
    for (size_t i = 0; i < c.rows; i++)
        c.result<uint32_t>("edge")[i] = unlike(seen_pixel(c, i, "_a"), seen_pixel(c, i, "_b"));
}

// An image of pixels, whose pairs are those with the right and the lower neighbour.
struct PairImage {
    const Case& c;
    int32_t width, height;

    explicit PairImage(const Case& c_)
        : c(c_), width(c.whole("width")), height(static_cast<int32_t>(c.rows) / width) {}

    bool has_pair(int32_t x, int32_t y, size_t axis) const {
        return x >= 0 && y >= 0 && x + (axis == 0) < width && y + (axis == 1) < height;
    }
    std::pair<SeenPixel, SeenPixel> pair(int32_t first, size_t axis) const {
        int32_t second = first + (axis == 0 ? 1 : width);
        return {seen_pixel(c, static_cast<size_t>(first)),
                seen_pixel(c, static_cast<size_t>(second))};
    }

    int32_t search(int32_t first, size_t axis, const float* u, size_t tries) const {
        int32_t x = first % width, y = first / width;
        if (!has_pair(x, y, axis)) return -1;
        auto [i, j] = pair(first, axis);
        if (!unlike(i, j)) return -1;
        int32_t radius = c.whole("radius"), n = 2 * radius + 1;
        for (size_t t = 0; t < tries; t++) {
            int32_t q = static_cast<int32_t>(u[t] * static_cast<float>(n * n));
            int32_t to_x = x + q % n - radius, to_y = y + q / n - radius;
            int32_t to = to_y * width + to_x;
            if (!has_pair(to_x, to_y, axis) || to == first) continue;
            auto [k, l] = pair(to, axis);
            bool alike = !unlike(i, k) && (plant("first-pixels-alone") || !unlike(j, l));
            if (unlike(k, l) && alike) return to;
        }
        return -1;
    }
};

inline void pass_pair_search(Case& c) {
    PairImage image(c);
    size_t tries = c.in.at("u").shape[2];
    for (size_t at = 0; at < 2 * c.rows; at++)
        c.result<int32_t>("neighbor")[at] =
            image.search(static_cast<int32_t>(at / 2), at % 2, c.reals("u") + at * tries, tries);
}

inline void pass_pair_motion(Case& c) {
    int32_t width = c.whole("width"), height = c.whole("height");
    for (size_t i = 0; i < c.rows; i++) {
        bool down = c.bits("axis")[i] == 1, hit = c.bits("hit_second")[i] == 1;
        bool nearer = c.reals("depth_second")[i] < c.reals("depth_first")[i];
        bool pivot = hit && (!c.bits("hit_first")[i] || nearer);
        if (plant("motion-of-the-first")) pivot = false;
        int32_t before = c.indices(pivot ? "before_second" : "before_first")[i];
        int32_t& row = c.result<int32_t>("row")[i];
        row = -1;
        if (before < 0) continue;
        int32_t x = before % width - (pivot && !down), y = before / width - (pivot && down);
        bool inside = x >= 0 && y >= 0 && x + !down < width && y + down < height;
        if (inside) row = y * width + x;
    }
}

// Light that is seen directly is added to the finished image.
inline void pass_primal(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 color = c.reals("W")[i] * c.vectors("value")[i];
        if (plant("primal-with-emission")) color = color + c.vectors("emission")[i];
        c.result<Vec3>("color")[i] = color;
    }
}

inline const PassTable GRADIENT_DOMAIN_PASSES = {
    {"pair_value", pass_pair_value},       {"pair_weight", pass_pair_weight},
    {"pair_target", pass_pair_target},     {"pair_initial", pass_pair_initial},
    {"inner_shift", pass_inner_shift},     {"outer_shift", pass_outer_shift},
    {"pair_reuse", pass_pair_reuse},       {"pair_estimate", pass_pair_estimate},
    {"edge_pair", pass_edge_pair},         {"after_estimate", pass_after_estimate},
    {"pair_search", pass_pair_search},     {"pair_motion", pass_pair_motion},
    {"primal", pass_primal}};
