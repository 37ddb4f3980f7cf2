// Who traces rays in a frame: pixels of a checkerboard, and tiles of long paths.
#pragma once

#include "random.h"

inline void pass_checkerboard(Case& c) {
    int32_t width = c.whole("width");
    int32_t frame = plant("checkerboard-frozen") ? 0 : c.whole("frame");
    for (size_t i = 0; i < c.rows; i++) {
        int32_t pixel = c.indices("pixel")[i];
        int32_t x = pixel % width, y = pixel / width;
        bool turn = (x + y + frame) % 2 == 0;
        c.result<uint32_t>("draws")[i] = turn || !c.bits("has_history")[i];
    }
}

constexpr uint32_t ROULETTE_STREAM = 7;

// A tile decides as a whole, so that the threads of a wave go on or stop together.
inline uint32_t roulette_tile(int32_t pixel, int32_t width) {
    if (plant("roulette-by-pixels")) return static_cast<uint32_t>(pixel);
    int32_t x = pixel % width, y = pixel / width;
    int32_t tiles_across = (width + 63) / 64;
    return static_cast<uint32_t>(y / 32 * tiles_across + x / 64);
}

inline void pass_roulette(Case& c) {
    float probability = c.number("probability");
    float goes_on = plant("roulette-not-divided") ? 1 : 1 / probability;
    uint32_t frame = static_cast<uint32_t>(c.whole("frame"));
    uint32_t seed = static_cast<uint32_t>(c.whole("seed"));
    for (size_t i = 0; i < c.rows; i++) {
        uint32_t tile = roulette_tile(c.indices("pixel")[i], c.whole("width"));
        float u = unit_number(pcg4d({tile, frame, seed, ROULETTE_STREAM * 64})[0]);
        c.result<float>("weight")[i] = u < probability ? goes_on : 0;
    }
}

inline const PassTable SPARING_PASSES = {{"checkerboard", pass_checkerboard},
                                         {"roulette", pass_roulette}};
