// Resampling of whole paths, whose targets and Jacobians stand in tables.
#pragma once

#include <string>
#include <utility>

#include "../samples.h"

// What the sources bring to one receiver.
struct Slots {
    const float *W, *M, *target_base, *target_here, *jacobian, *target_at, *u;
    const uint32_t* there;
    size_t count, canonical;

    Slots(const Case& c, size_t i)
        : count(c.columns("W")), canonical(static_cast<size_t>(c.whole("canonical"))) {
        size_t first = i * count;
        W = c.reals("W") + first;
        M = c.reals("M") + first;
        target_base = c.reals("target_base") + first;
        target_here = c.reals("target_here") + first;
        jacobian = c.reals("jacobian") + first;
        target_at = c.reals("target_at") + first * count;
        u = c.reals("u") + first;
        there = c.bits("there") + first;
    }

    // A slot without a source does not count; a source without a sample does.
    float confidence(size_t k) const {
        return there[k] || plant("reuse-empty-slots-counted") ? M[k] : 0;
    }

    // Density with which source k makes the sample of slot s, in the receiver's measure.
    float density(size_t k, size_t s) const {
        if (k == canonical) return target_here[s];
        if (k == s) {
            float J = plant("reuse-maker-without-jacobian") ? 1 : jacobian[s];
            return over(target_base[s], J);
        }
        return target_at[s * count + k];
    }

    float total_confidence() const {
        float sum = 0;
        for (size_t k = 0; k < count; k++) sum += confidence(k);
        return sum;
    }
};

// ---------------------------------------------------------------- pairwise weights

// Each source shares with the canonical one alone; `defensive` lets that one keep a part.
struct Pairs {
    const Slots& slots;
    bool defensive;
    float S, T;

    Pairs(const Slots& slots_, bool defensive_) : slots(slots_), defensive(defensive_) {
        float canonical = slots.confidence(slots.canonical);
        S = 0;
        for (size_t k = 0; k < slots.count; k++)
            if (k != slots.canonical) S += slots.confidence(k);
        T = defensive ? S + canonical : S;
    }

    float m_source(size_t k) const {
        size_t c = slots.canonical;
        float there = slots.density(k, k), here = slots.density(c, k);
        if (plant("reuse-pairs-exchanged")) std::swap(there, here);
        float source = S * there, own = slots.confidence(c) * here;
        return over(slots.confidence(k), T) * over(source, source + own);
    }

    float m_canonical() const {
        size_t c = slots.canonical;
        float M_c = slots.confidence(c), own = M_c * slots.density(c, c);
        float m = defensive ? over(M_c, T) : S == 0 ? 1.0f : 0.0f;
        for (size_t k = 0; k < slots.count; k++) {
            if (k == c) continue;
            float source = S * slots.density(k, c);
            m += over(slots.confidence(k), T) * over(own, source + own);
        }
        return m;
    }
};

// ---------------------------------------------------------------- sums of confidences

// What the sum of weights is divided by, where sample s is kept.
inline float divisor(const Slots& slots, const std::string& mis, size_t s) {
    if (mis == "pairwise" || mis == "defensive") return 1;
    if (mis == "1/M") return slots.total_confidence();
    float Z = 0;
    for (size_t k = 0; k < slots.count; k++) {
        float p = slots.density(k, s);
        bool could = p > 0 || k == s;
        float share = mis == "balance" ? over(p, slots.density(s, s)) : could ? 1.0f : 0.0f;
        Z += slots.confidence(k) * share;
    }
    return Z;
}

inline float mis_weight(const Slots& slots, const std::string& mis, size_t k) {
    if (mis != "pairwise" && mis != "defensive") return slots.confidence(k);
    Pairs pairs(slots, mis == "defensive");
    return k == slots.canonical ? pairs.m_canonical() : pairs.m_source(k);
}

inline float resampling_weight(const Slots& slots, const std::string& mis, size_t k) {
    if (!slots.there[k]) return 0;
    float J = plant("reuse-jacobian-omitted") ? 1 : slots.jacobian[k];
    return mis_weight(slots, mis, k) * slots.target_here[k] * slots.W[k] * J;
}

inline void pass_path_reuse(Case& c) {
    const std::string& mis = c.settings.at("mis");
    float cap = c.number("cap");
    for (size_t i = 0; i < c.rows; i++) {
        Slots slots(c, i);
        size_t kept = 0;
        float total = resampling_weight(slots, mis, 0);
        for (size_t k = 1; k < slots.count; k++) {
            float w = resampling_weight(slots, mis, k);
            if (keeps(slots.u[k], total, w)) kept = k;
            total += w;
        }
        float Z = divisor(slots, mis, kept), p_hat = slots.target_here[kept];
        c.result<int32_t>("slot")[i] = static_cast<int32_t>(kept);
        c.result<float>("p_hat")[i] = p_hat;
        c.result<float>("W")[i] = over(over(total, p_hat), Z);
        c.result<float>("M")[i] = std::min(slots.total_confidence(), cap);
    }
}

inline const PassTable PATH_REUSE_PASSES = {{"path_reuse", pass_path_reuse}};
