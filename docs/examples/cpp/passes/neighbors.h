// Neighbours whose samples a pixel reuses.
#pragma once

#include "../samples.h"

inline void pass_neighbors(Case& c) {
    const Vec3* normal = c.vectors("visible_normal");
    const float *depth = c.reals("depth"), *u = c.reals("u");
    int32_t* out = c.result<int32_t>("neighbors");
    size_t count = c.columns("u");
    int width = c.whole("width");
    int height = static_cast<int>(c.rows) / width;
    float least = c.number("min_radius");
    Similarity similar(c);
    for (size_t i = 0; i < c.rows; i++) {
        int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
        float radius = std::max(c.number("radius") * width, least);
        for (size_t k = 0; k < count; k++) {
            const float* numbers = u + (i * count + k) * 2;
            float r = radius * std::sqrt(numbers[0]), phi = 2 * PI * numbers[1];
            int x_to = x + static_cast<int>(std::nearbyint(r * std::cos(phi)));
            int y_to = y + static_cast<int>(std::nearbyint(r * std::sin(phi)));
            bool usable = x_to >= 0 && x_to < width && y_to >= 0 && y_to < height;
            size_t row = usable ? static_cast<size_t>(y_to) * width + x_to : i;
            usable = usable && similar(normal[i], depth[i], normal[row], depth[row]);
            out[i * count + k] = usable && row != i ? static_cast<int32_t>(row) : -1;
            if (!usable && !plant("radius-not-halved")) radius = std::max(radius / 2, least);
        }
    }
}

inline const PassTable NEIGHBOR_PASSES = {{"neighbors", pass_neighbors}};
