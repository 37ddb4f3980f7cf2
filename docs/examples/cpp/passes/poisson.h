// Images from differences: least squares, and least absolute values, by conjugate gradients.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../samples.h"

using Image = std::vector<Vec3>;

// Each channel for itself.
inline Vec3 over(Vec3 a, Vec3 b) { return {over(a.x, b.x), over(a.y, b.y), over(a.z, b.z)}; }

inline Vec3 sum_of_products(const Image& a, const Image& b) {
    // In double precision, as sums over a whole image are made of many small parts.
    double x = 0, y = 0, z = 0;
    for (size_t i = 0; i < a.size(); i++) {
        x += a[i].x * b[i].x;
        y += a[i].y * b[i].y;
        z += a[i].z * b[i].z;
    }
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

// ---------------------------------------------------------------- differences

struct Grid {
    size_t width, height;

    explicit Grid(const Case& c)
        : width(static_cast<size_t>(c.whole("width"))), height(c.rows / width) {}

    // The neighbour of a pixel to the right (axis 0) or below (axis 1).
    size_t next(size_t i, size_t axis) const { return axis == 0 ? i + 1 : i + width; }

    bool has_next(size_t i, size_t axis) const {
        return axis == 0 ? i % width + 1 < width : i + width < width * height;
    }

    // The same, round the image where that is the planted mistake.
    std::pair<size_t, bool> neighbor(size_t i, size_t axis) const {
        if (has_next(i, axis)) return {next(i, axis), true};
        if (!plant("poisson-wraps-around")) return {i, false};
        return {axis == 0 ? i + 1 - width : i % width, true};
    }
};

inline void pass_differences(Case& c) {
    Grid grid(c);
    const Vec3* color = c.vectors("color");
    Vec3* d[2] = {c.result<Vec3>("dx"), c.result<Vec3>("dy")};
    for (size_t axis = 0; axis < 2; axis++)
        for (size_t i = 0; i < c.rows; i++)  // results begin as 0
            if (grid.has_next(i, axis)) d[axis][i] = color[grid.next(i, axis)] - color[i];
}

// What two pixels differ by, i less j, is the forward difference turned.
inline void pass_pair_differences(Case& c) {
    Grid grid(c);
    const Vec3* delta[2] = {c.vectors("delta_x"), c.vectors("delta_y")};
    Vec3* d[2] = {c.result<Vec3>("dx"), c.result<Vec3>("dy")};
    float sign = plant("pair-differences-not-turned") ? 1.0f : -1.0f;
    for (size_t axis = 0; axis < 2; axis++)
        for (size_t i = 0; i < c.rows; i++)
            if (grid.has_next(i, axis)) d[axis][i] = sign * delta[axis][i];
}

// ---------------------------------------------------------------- what is to be solved

// For each pixel its own row, and that of its difference along each axis.
using Rows = std::array<Image, 3>;

struct Poisson {
    Grid grid;
    float alpha;
    Rows wanted;

    explicit Poisson(const Case& c) : grid(c), alpha(c.number("alpha")) {
        const char* names[3] = {"primal", "dx", "dy"};
        for (size_t k = 0; k < 3; k++)
            wanted[k].assign(c.vectors(names[k]), c.vectors(names[k]) + c.rows);
        if (plant("alpha-not-squared") && c.pass == "poisson_l2") alpha = std::sqrt(alpha);
        for (Vec3& v : wanted[0]) v = alpha * v;
        if (plant("divergence-sign"))
            for (size_t axis : {1, 2})
                for (Vec3& v : wanted[axis]) v = -1.0f * v;
    }

    size_t size() const { return wanted[0].size(); }

    Rows apply(const Image& image) const {
        Rows found = {image, Image(size(), {0, 0, 0}), Image(size(), {0, 0, 0})};
        for (size_t i = 0; i < size(); i++) {
            found[0][i] = alpha * image[i];
            for (size_t axis = 0; axis < 2; axis++)
                if (auto [n, exists] = grid.neighbor(i, axis); exists)
                    found[axis + 1][i] = image[n] - image[i];
        }
        return found;
    }

    // The transposed matrix, on rows that have weights.
    Image adjoint(const Rows& rows, const std::array<std::vector<float>, 3>& weights) const {
        Image found(size(), {0, 0, 0});
        for (size_t i = 0; i < size(); i++) {
            found[i] = found[i] + (alpha * weights[0][i]) * rows[0][i];
            for (size_t axis = 0; axis < 2; axis++)
                if (auto [n, exists] = grid.neighbor(i, axis); exists) {
                    Vec3 part = weights[axis + 1][i] * rows[axis + 1][i];
                    found[n] = found[n] + part;
                    found[i] = found[i] - part;
                }
        }
        return found;
    }

    std::array<std::vector<float>, 3> ones() const {
        std::vector<float> each(size(), 1);
        return {each, each, each};
    }

    // Conjugate gradients from what is known, until the residual is a share of what is asked.
    Image solve(Image image, const std::array<std::vector<float>, 3>& weights, float share,
                size_t steps) const {
        Image right = adjoint(wanted, weights), left = adjoint(apply(image), weights);
        for (size_t i = 0; i < size(); i++) left[i] = right[i] - left[i];
        Image way = left;
        Vec3 now = sum_of_products(left, left);
        Vec3 enough = (share * share) * sum_of_products(right, right);
        for (size_t k = 0; k < steps; k++) {
            if (now.x <= enough.x && now.y <= enough.y && now.z <= enough.z) break;
            Image moved = adjoint(apply(way), weights);
            Vec3 step = over(now, sum_of_products(way, moved));
            for (size_t i = 0; i < size(); i++) {
                image[i] = image[i] + step * way[i];
                left[i] = left[i] - step * moved[i];
            }
            Vec3 after = sum_of_products(left, left), share_kept = over(after, now);
            for (size_t i = 0; i < size(); i++) way[i] = left[i] + share_kept * way[i];
            now = after;
        }
        return image;
    }
};

inline void tell(Case& c, const Image& image) {
    std::copy(image.begin(), image.end(), c.result<Vec3>("color"));
}

inline void pass_poisson_l2(Case& c) {
    Poisson problem(c);
    Image primal(c.vectors("primal"), c.vectors("primal") + c.rows);
    tell(c, problem.solve(primal, problem.ones(), c.number("residual") / 2, 1000));
}

// Least squares whose weights are one over the lengths that the rows had before; what is
// added to the lengths shrinks from the mean towards 0.
inline void pass_poisson_l1(Case& c) {
    constexpr size_t ROUNDS = 40;
    Poisson problem(c);
    Image image(c.vectors("primal"), c.vectors("primal") + c.rows);
    auto weights = problem.ones();
    float shortest = 0;
    for (size_t round = 0; round < ROUNDS; round++) {
        Rows rows = problem.apply(image);
        float mean = 0;
        for (size_t k = 0; k < 3; k++)
            for (size_t i = 0; i < c.rows; i++) {
                weights[k][i] = length(rows[k][i] - problem.wanted[k][i]);
                mean += weights[k][i] / static_cast<float>(3 * c.rows);
            }
        shortest = round == 0 ? mean : std::max(0.7f * shortest, 1e-4f * mean);
        for (std::vector<float>& each : weights)
            for (float& weight : each)
                weight = over(1, std::sqrt(weight * weight + shortest * shortest));
        if (plant("squares-for-absolute-values")) weights = problem.ones();
        image = problem.solve(image, weights, 1e-5f, 100);
    }
    tell(c, image);
}

inline const PassTable POISSON_PASSES = {{"pair_differences", pass_pair_differences},
                                         {"differences", pass_differences},
                                         {"poisson_l2", pass_poisson_l2},
                                         {"poisson_l1", pass_poisson_l1}};
