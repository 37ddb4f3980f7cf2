// Streams of candidates: Algorithms 2 to 4, and temporal and spatial reuse in one pass.
#pragma once

#include <vector>

#include "../samples.h"

// A sample that competes: its weight, its confidence, and the point that it comes from.
struct Candidate {
    Sample y;
    float p_hat, w, M, u;
    bool elsewhere;  // it comes from another point than the receiver, which is x:
    Receiver x;
    uint32_t sees;  // which of the samples x sees, a bit each
    int bit;        // of its own sample
};

struct Stream {
    std::vector<Candidate> candidates;
    size_t canonical;  // what the receiver itself has drawn
    size_t kept = 0;
    float total = 0;  // of the weights
};

inline bool sees(uint32_t mask, int bit) { return (mask >> bit) & 1u; }

// ---------------------------------------------------------------- candidates

inline float confidence(float w) { return plant("nulls-not-counted") && !(w > 0) ? 0.0f : 1.0f; }

// The new sample of a pixel.
inline Candidate fresh(const Case& c, size_t i, const Receiver& x, int bit) {
    Sample y = sample(c, i, "new_");
    float p_hat = target(c.is("target", "outgoing"), x, y);
    float w = over(p_hat, c.reals("new_pdf")[i]);
    return {y, p_hat, w, confidence(w), c.reals("u")[i], false, x, 0, bit};
}

// A reservoir of the receiver itself.
inline Candidate reused(const Case& c, const Receiver& x, const Reservoir& r, float u, int bit) {
    float p_hat = target(c.is("target", "outgoing"), x, r.y);
    float M = plant("confidence-missing") ? 1 : r.M;
    return {r.y, p_hat, p_hat * r.W * M, r.M, u, false, x, 0, bit};
}

// A reservoir of another point x_from; `seen` says whether x sees its sample.
inline Candidate shifted(const Case& c, const Receiver& x, const Receiver& x_from,
                         const Reservoir& r, float u, int bit, bool seen, uint32_t mask) {
    Candidate shift = reused(c, x, r, u, bit);
    shift.elsewhere = true;
    shift.x = x_from;
    shift.sees = mask;
    shift.w = shift.w > 0 ? shift.w * jacobian(x_from, x, r.y) : 0;
    if (!seen && !plant("visibility-ignored-in-weight")) shift.w = 0;
    if (!seen && plant("hidden-not-counted")) shift.M = 0;
    return shift;
}

// What stands for a neighbour or a source that there is not.
inline Candidate nothing(const Receiver& x) { return {{}, 0, 0, 0, 0, false, x, 0, 0}; }

// ---------------------------------------------------------------- resampling

inline void choose(Stream& s) {
    s.total = s.candidates[0].w;
    for (size_t k = 1; k < s.candidates.size(); k++) {
        const Candidate& next = s.candidates[k];
        if (keeps(next.u, s.total, next.w)) s.kept = k;
        s.total += next.w;
    }
}

// Whether the point that a candidate comes from could have made the sample that is kept.
inline bool could_have_made(const Candidate& candidate, const Candidate& kept, bool outgoing) {
    if (!candidate.elsewhere) return true;
    bool seen = sees(candidate.sees, kept.bit) || plant("visibility-ignored-in-z");
    return seen && target(outgoing, candidate.x, kept.y) > 0;
}

inline float divisor(const Case& c, const Stream& s, const std::string& mis) {
    bool all = mis == "1/M" || plant("one-over-m");
    float Z = 0;
    for (size_t k = 0; k < s.candidates.size(); k++) {
        if (plant("canonical-missing") && k == s.canonical && !all) continue;
        const Candidate &candidate = s.candidates[k], &kept = s.candidates[s.kept];
        if (all || could_have_made(candidate, kept, c.is("target", "outgoing"))) Z += candidate.M;
    }
    return plant("cap-before-weight") ? std::min(Z, c.number("cap")) : Z;
}

inline void store_terms(Case& c, size_t i, const Stream& s, float p_hat, float Z) {
    float* w = c.result<float>("term_w") + i * s.candidates.size();
    for (size_t k = 0; k < s.candidates.size(); k++) w[k] = s.candidates[k].w;
    c.result<float>("term_p_hat")[i] = p_hat;
    c.result<float>("term_Z")[i] = Z;
}

inline void resample(Case& c, size_t i, Stream& s, const std::string& mis) {
    choose(s);
    const Candidate& kept = s.candidates[s.kept];
    float M = 0, Z = divisor(c, s, mis), p_hat = kept.p_hat;
    for (const Candidate& candidate : s.candidates) M += candidate.M;
    if (plant("source-target") && kept.elsewhere)
        p_hat = target(c.is("target", "outgoing"), kept.x, kept.y);
    c.result<Vec3>("position")[i] = kept.y.position;
    c.result<Vec3>("normal")[i] = kept.y.normal;
    c.result<Vec3>("radiance")[i] = kept.y.radiance;
    c.result<float>("W")[i] = over(over(s.total, p_hat), Z);
    c.result<float>("M")[i] = plant("cap-missing") ? M : std::min(M, c.number("cap"));
    store_terms(c, i, s, p_hat, Z);
}

// ---------------------------------------------------------------- passes

inline void pass_initial(Case& c) {
    bool outgoing = c.is("target", "outgoing");
    for (size_t i = 0; i < c.rows; i++) {
        float p_hat = target(outgoing, receiver(c, i), sample(c, i));
        float w = over(p_hat, c.reals("pdf")[i]);
        c.result<float>("p_hat")[i] = p_hat;
        c.result<float>("W")[i] = over(w, p_hat);
        c.result<float>("M")[i] = confidence(w);
    }
}

inline void pass_temporal(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Stream s = {{reused(c, x, reservoir(c, i, "past_"), 0, 1), fresh(c, i, x, 0)}, 1};
        resample(c, i, s, "1/M");  // where nothing moves, both could have made all
    }
}

inline void pass_moved(Case& c) {
    const uint32_t* visible = c.bits("visible");
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i), x_past = receiver(c, i, "past_");
        uint32_t from_x = visible[2 * i], from_past = visible[2 * i + 1];
        Candidate past = shifted(c, x, x_past, reservoir(c, i, "past_"), 0, 1, sees(from_x, 1),
                                 from_past);
        Stream s = {{past, fresh(c, i, x, 0)}, 1};
        resample(c, i, s, c.settings.at("mis"));
    }
}

// Buffers of neighbours or sources: their rows and numbers, and prefixes of what they name.
struct Sources {
    std::string rows, numbers, points, samples;
};

inline void add_sources(const Case& c, size_t i, Stream& s, const Receiver& x, const Sources& of) {
    size_t count = c.columns(of.rows);
    const uint32_t* visible = c.bits("visible") + i * (count + 1);
    for (size_t k = 0; k < count; k++) {
        int32_t row = c.indices(of.rows)[i * count + k];
        if (row < 0) {
            s.candidates.push_back(nothing(x));
            continue;
        }
        float u = c.reals(of.numbers)[i * count + (plant("random-reused") ? 0 : k)];
        int bit = static_cast<int>(k) + 1;
        Receiver x_from = receiver(c, row, of.points);
        Candidate source = shifted(c, x, x_from, reservoir(c, row, of.samples), u, bit,
                                   sees(visible[0], bit), visible[1 + k]);
        if (plant("m-times-two")) source.w *= 2;
        s.candidates.push_back(source);
    }
}

inline void pass_spatial(Case& c) {
    int past_bit = static_cast<int>(c.columns("neighbors")) + 1;
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Candidate past = reused(c, x, reservoir(c, i, "past_"), 0, past_bit);
        Stream s = {{past, reused(c, x, reservoir(c, i), c.reals("u_own")[i], 0)}, 1};
        add_sources(c, i, s, x, {"neighbors", "u_neighbors", "", ""});
        resample(c, i, s, c.settings.at("mis"));
    }
}

inline void pass_fused(Case& c) {
    // Sources stand in the past frame, and so do the visible points that made them.
    std::string points = plant("source-point-of-now") ? "" : "past_";
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Stream s = {{reused(c, x, reservoir(c, i), 0, 0)}, 0};
        add_sources(c, i, s, x, {"sources", "u", points, "past_"});
        resample(c, i, s, c.settings.at("mis"));
    }
}

inline const PassTable RESAMPLING_PASSES = {{"initial", pass_initial},
                                            {"temporal", pass_temporal},
                                            {"moved", pass_moved},
                                            {"spatial", pass_spatial},
                                            {"fused", pass_fused}};
