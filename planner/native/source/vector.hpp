// Vectors and rotations in space. Sums are written out, so that every compiler and processor adds in the same order.
#pragma once

#include <cmath>

namespace planner {

struct Vec {
    double x = 0.0, y = 0.0, z = 0.0;
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline bool operator==(Vec a, Vec b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vec a) { return std::sqrt(dot(a, a)); }
inline Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

// A 3 x 3 matrix, row after row.
struct Mat {
    double m[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

inline Vec operator*(const Mat& a, Vec v) {
    return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
            a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}

// The transpose times a vector.
inline Vec turned_back(const Mat& a, Vec v) {
    return {a.m[0] * v.x + a.m[3] * v.y + a.m[6] * v.z, a.m[1] * v.x + a.m[4] * v.y + a.m[7] * v.z,
            a.m[2] * v.x + a.m[5] * v.y + a.m[8] * v.z};
}

inline Mat operator*(const Mat& a, const Mat& b) {
    Mat c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c.m[3 * i + j] = a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
    return c;
}

// A rotation and a position: where a frame stands in another.
struct Frame {
    Mat turn;
    Vec shift;
};

inline Vec operator*(const Frame& f, Vec v) { return f.turn * v + f.shift; }

inline Frame operator*(const Frame& f, const Frame& g) { return {f.turn * g.turn, f * g.shift}; }

inline Frame inverse(const Frame& f) {
    Frame back;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) back.turn.m[3 * i + j] = f.turn.m[3 * j + i];
    back.shift = -(back.turn * f.shift);
    return back;
}

inline Vec vec_at(const double* p) { return {p[0], p[1], p[2]}; }

}  // namespace planner
