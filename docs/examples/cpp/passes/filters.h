// Filters that empty reservoirs: validation of samples, and boiling.
#pragma once

#include <vector>

#include "../samples.h"

// What a filter leaves of a reservoir.
inline void store(Case& c, size_t i, bool stays) {
    c.result<float>("W")[i] = stays ? c.reals("W")[i] : 0;
    c.result<float>("M")[i] = stays || plant("filter-keeps-m") ? c.reals("M")[i] : 0;
}

inline void pass_validation(Case& c) {
    float tolerance = c.number("tolerance");
    for (size_t i = 0; i < c.rows; i++) {
        float then = luminance(c.vectors("radiance_then")[i]);
        float now = luminance(c.vectors("radiance_now")[i]);
        float change = plant("darker-alone") ? then - now : std::fabs(then - now);
        bool same = c.bits("met")[i] && change <= tolerance * std::max(then, now);
        // A ray into the void finds the void again: there is nothing to meet.
        bool null = c.bits("null")[i] && !plant("null-cleared");
        store(c, i, same || null);
    }
}

constexpr size_t BOILING_TILE = 16;

// Rows of the pixels of a tile that begins at `x`, `y`; cut off at the border of the image.
inline std::vector<size_t> rows_of_tile(size_t width, size_t height, size_t x, size_t y) {
    std::vector<size_t> rows;
    for (size_t v = y; v < std::min(y + BOILING_TILE, height); v++)
        for (size_t u = x; u < std::min(x + BOILING_TILE, width); u++)
            rows.push_back(v * width + u);
    return rows;
}

inline float light_of(const Case& c, size_t i) {
    return luminance(c.vectors("radiance")[i]) * c.reals("W")[i];
}

// Reservoirs are held against the mean of those of their tile that bring light at all.
inline void filter_tile(Case& c, const std::vector<size_t>& rows, float strength) {
    float sum = 0, count = 0;
    for (size_t i : rows) {
        sum += light_of(c, i);
        if (light_of(c, i) > 0 || plant("boiling-mean-over-all")) count++;
    }
    float limit = over(sum, count) * (10 - 9 * strength);
    for (size_t i : rows) store(c, i, light_of(c, i) * strength <= limit);
}

inline void pass_boiling(Case& c) {
    size_t width = static_cast<size_t>(c.whole("width")), height = c.rows / width;
    for (size_t y = 0; y < height; y += BOILING_TILE)
        for (size_t x = 0; x < width; x += BOILING_TILE)
            filter_tile(c, rows_of_tile(width, height, x, y), c.number("strength"));
}

inline const PassTable FILTER_PASSES = {{"validation", pass_validation}, {"boiling", pass_boiling}};
