// A reservoir in twelve words: halves, octahedral normals, and the words themselves.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "../samples.h"

using Packed = std::array<uint32_t, 12>;

// ---------------------------------------------------------------- numbers in bits

inline uint32_t bits_of(float number) {
    uint32_t word;
    std::memcpy(&word, &number, sizeof word);
    return word;
}

// Whatever a word may hold, what is read from it is finite.
inline float tamed(float number, float largest) {
    if (std::isnan(number)) return 0;
    return std::isinf(number) ? std::copysign(largest, number) : number;
}

inline float real_of(uint32_t word) {
    float number;
    std::memcpy(&number, &word, sizeof number);
    return tamed(number, std::numeric_limits<float>::max());
}

inline uint32_t lower(uint32_t word) { return word & 0xffffu; }
inline uint32_t upper(uint32_t word) { return word >> 16; }
inline uint32_t both(uint32_t low, uint32_t high) { return low | high << 16; }

// ---------------------------------------------------------------- halves

constexpr float LARGEST_HALF = 65504;
constexpr uint32_t INFINITE_HALF = 0x7c00;

inline float rounded(float number) {
    return plant("half-cut-off") ? std::trunc(number) : std::nearbyint(number);
}

inline uint32_t half_bits(float number) {
    uint32_t sign = std::signbit(number) ? 0x8000u : 0;
    float size = std::fabs(number);
    if (plant("half-overflows") && size >= 65520) return sign | INFINITE_HALF;
    size = std::min(size, LARGEST_HALF);
    // Below the normal halves all are multiples of one step.
    if (size < 0x1p-14f) return sign | static_cast<uint32_t>(rounded(size * 0x1p24f));
    int exponent = std::ilogb(size);
    // From 1024 to 2048: where it rounds up to 2048, the carry makes the next exponent.
    auto mantissa = static_cast<uint32_t>(rounded(std::ldexp(size, 10 - exponent)));
    return sign | ((static_cast<uint32_t>(exponent + 14) << 10) + mantissa);
}

inline float half_real(uint32_t bits) {
    int exponent = static_cast<int>(bits >> 10 & 31u);
    float mantissa = static_cast<float>(bits & 1023u);
    if (exponent == 31 && mantissa != 0) return 0;  // no number
    float size = exponent == 31  ? LARGEST_HALF
                 : exponent == 0 ? std::ldexp(mantissa, -24)
                                 : std::ldexp(1024 + mantissa, exponent - 25);
    return bits & 0x8000u ? -size : size;
}

// ---------------------------------------------------------------- normals

inline float sign(float number) {
    if (plant("sign-of-zero") && number == 0) return 0;
    return number < 0 ? -1.0f : 1.0f;
}

// The lower half of the octahedron is folded out over the corners of the square.
inline void fold(float& u, float& v) {
    float folded_u = (1 - std::fabs(v)) * sign(u);
    v = (1 - std::fabs(u)) * sign(v);
    u = folded_u;
}

inline uint32_t coordinate_bits(float coordinate) {
    auto code = static_cast<int32_t>(std::nearbyint(32767 * coordinate));
    auto word = static_cast<uint32_t>(code);
    return plant("normal-code-unmasked") ? word : lower(word);
}

inline float coordinate_real(uint32_t bits) {
    auto code = static_cast<int32_t>(bits);
    if (bits >= 0x8000u && !plant("normal-code-unsigned")) code -= 0x10000;
    return static_cast<float>(std::max(code, -32767)) / 32767;
}

inline uint32_t normal_bits(Vec3 n) {
    float size = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    float u = over(n.x, size), v = over(n.y, size);
    if (n.z < 0) fold(u, v);
    return both(coordinate_bits(u), coordinate_bits(v));
}

inline Vec3 normal_real(uint32_t word) {
    float u = coordinate_real(lower(word)), v = coordinate_real(upper(word));
    float z = 1 - std::fabs(u) - std::fabs(v);
    if (z < 0) fold(u, v);
    return normalized({u, v, z});
}

// ---------------------------------------------------------------- words

inline void put(Packed& words, size_t first, Vec3 v) {
    words[first] = bits_of(v.x);
    words[first + 1] = bits_of(v.y);
    words[first + 2] = bits_of(v.z);
}

inline Vec3 taken(const Packed& words, size_t first) {
    return {real_of(words[first]), real_of(words[first + 1]), real_of(words[first + 2])};
}

// A confidence that is there stays there, however small it is.
inline uint32_t confidence_bits(float M) {
    if (!(M > 0)) return 0;
    return static_cast<uint32_t>(std::min(std::max(std::nearbyint(M), 1.0f), 65535.0f));
}

inline void pass_pack(Case& c) {
    Packed* packed = c.result<Packed>("words");
    for (size_t i = 0; i < c.rows; i++) {
        Packed& words = packed[i];
        Reservoir r = reservoir(c, i);
        Vec3 L = r.y.radiance;
        put(words, 0, c.vectors("visible_position")[i]);
        words[3] = normal_bits(c.vectors("visible_normal")[i]);
        put(words, 4, r.y.position);
        words[7] = normal_bits(r.y.normal);
        words[8] = both(half_bits(L.x), half_bits(L.y));
        words[9] = both(half_bits(L.z), confidence_bits(r.M));
        words[10] = bits_of(r.W);
        words[11] = c.bits("seed")[i];
    }
}

// Of two numbers in a word the first stands in the lower bits.
inline uint32_t first(uint32_t word) {
    return plant("upper-half-first") ? upper(word) : lower(word);
}
inline uint32_t second(uint32_t word) {
    return plant("upper-half-first") ? lower(word) : upper(word);
}

inline void pass_unpack(Case& c) {
    const Packed* packed = reinterpret_cast<const Packed*>(c.bits("words"));
    for (size_t i = 0; i < c.rows; i++) {
        const Packed& words = packed[i];
        c.result<Vec3>("visible_position")[i] = taken(words, 0);
        c.result<Vec3>("visible_normal")[i] = normal_real(words[3]);
        c.result<Vec3>("position")[i] = taken(words, 4);
        c.result<Vec3>("normal")[i] = normal_real(words[7]);
        c.result<Vec3>("radiance")[i] = {half_real(first(words[8])), half_real(second(words[8])),
                                           half_real(first(words[9]))};
        c.result<float>("M")[i] = static_cast<float>(second(words[9]));
        c.result<float>("W")[i] = real_of(words[10]);
        c.result<uint32_t>("seed")[i] = words[11];
    }
}

inline const PassTable PACKING_PASSES = {{"pack", pass_pack}, {"unpack", pass_unpack}};
