// What a pinhole camera sees, and where in the last frame it saw it.
#pragma once

#include "../samples.h"

inline Vec3 vector_setting(const Case& c, const std::string& name) {
    return {c.number(name + "_x"), c.number(name + "_y"), c.number(name + "_z")};
}

struct Camera {
    Vec3 eye, forward, right, upward;
    float width, height;  // of the image, in pixels
    float half;           // tangent of half of the horizontal angle of view

    explicit Camera(const Case& c)
        : eye(vector_setting(c, "eye")),
          forward(normalized(vector_setting(c, "target") - eye)),
          right(normalized(cross(forward, vector_setting(c, "up")))),
          upward(cross(right, forward)),
          width(c.number("width")),
          height(c.number("height")),
          half(std::tan(c.number("fov_x") * PI / 360)) {}

    // Direction from the eye through a place of the image, y downwards; not a unit vector.
    Vec3 ray(float x, float y) const {
        return ((2 * x - width) / width * half) * right +
               ((height - 2 * y) / width * half) * upward + forward;
    }

    float depth(Vec3 p) const {
        Vec3 v = p - eye;
        return plant("distance-for-depth") ? length(v) : dot(forward, v);
    }

    // Row of the pixel in which a point appears; -1 outside of the image.
    int32_t row(Vec3 p) const {
        float z = dot(forward, p - eye);
        if (z <= 0) return -1;
        float pixels = width / (2 * z * half);
        float x = width / 2 + dot(p - eye, right) * pixels;
        float y = height / 2 - dot(p - eye, upward) * pixels;
        if (plant("place-rounded")) x += 0.5f, y += 0.5f;
        if (!(x >= 0 && x < width && y >= 0 && y < height)) return -1;
        return static_cast<int32_t>(y) * static_cast<int32_t>(width) + static_cast<int32_t>(x);
    }
};

struct Triangle {
    Vec3 a, b, c;

    Vec3 normal() const { return cross(b - a, c - a); }

    // Whether a point of its plane lies inside of all three edges.
    bool holds(Vec3 n, Vec3 p) const {
        return dot(n, cross(b - a, p - a)) > 0 && dot(n, cross(c - b, p - b)) > 0 &&
               dot(n, cross(a - c, p - c)) > 0;
    }
};

inline void pass_gbuffer(Case& c) {
    Camera camera(c);
    int32_t width = c.whole("width");
    float centre = plant("pixel-corner") ? 0 : 0.5f;
    for (size_t i = 0; i < c.rows; i++) {
        int32_t pixel = c.indices("pixel")[i];
        Vec3 d = camera.ray(static_cast<float>(pixel % width) + centre,
                            static_cast<float>(pixel / width) + centre);
        Triangle triangle = {c.vectors("a")[i], c.vectors("b")[i], c.vectors("c")[i]};
        Vec3 n = triangle.normal();
        float t = over(dot(n, triangle.a - camera.eye), dot(n, d));
        Vec3 p = camera.eye + t * d;
        if (!(t > 0 && triangle.holds(n, p))) continue;  // results begin as 0
        c.result<uint32_t>("hit")[i] = 1;
        c.result<Vec3>("position")[i] = p;
        c.result<Vec3>("normal")[i] = (dot(n, d) > 0 ? -1.0f : 1.0f) * normalized(n);
        c.result<float>("depth")[i] = camera.depth(p);
    }
}

inline void pass_reproject(Case& c) {
    Camera before(c);
    Similarity similar(c);
    const Vec3 *position = c.vectors("position"), *normal = c.vectors("normal");
    const Vec3* normal_before = c.vectors("normal_before");
    const float* depth_before = c.reals("depth_before");
    int32_t* rows = c.result<int32_t>("row");
    for (size_t i = 0; i < c.rows; i++) {
        rows[i] = -1;
        int32_t row = before.row(position[i]);
        if (!c.bits("hit")[i] || row < 0) continue;
        size_t then = plant("own-pixel-tested") ? i : static_cast<size_t>(row);
        float depth = before.depth(position[i]);
        if (similar(normal[i], depth, normal_before[then], depth_before[then])) rows[i] = row;
    }
}

inline const PassTable CAMERA_PASSES = {{"gbuffer", pass_gbuffer}, {"reproject", pass_reproject}};
