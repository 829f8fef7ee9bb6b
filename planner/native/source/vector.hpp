// Vectors and rotations in space. Sums are written out, so all compilers and processors add in the same order.
#pragma once

#include <cmath>
#include <cstdint>

// The loader selects the best version for the processor, if compiler and C library support it. Wider registers give the
// same bits: sums keep their order, and nothing is fused. The thread sanitizer does not run at load time.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__)
#define VERSIONS(...) __attribute__((target_clones(__VA_ARGS__, "default")))
#else
#define VERSIONS(...)
#endif
#define FOR_THIS_PROCESSOR VERSIONS("avx2")

// A call from a function with wider registers would pass a Four in other registers.
#define INLINED inline __attribute__((always_inline))

namespace planner {

// Four numbers at a time; each has the same bits as alone.
typedef double Four __attribute__((vector_size(32)));

// Integers, as many as in a Four.
typedef int64_t FourWhole __attribute__((vector_size(32)));

// A vector in space, or with T = Four one of each of four robots.
template <class T>
struct VecOf {
    T x{}, y{}, z{};
};
using Vec = VecOf<double>;

template <class T>
INLINED VecOf<T> operator+(const VecOf<T>& a, const VecOf<T>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
INLINED VecOf<T> operator-(const VecOf<T>& a, const VecOf<T>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
INLINED VecOf<T> operator-(const VecOf<T>& a) {
    return {-a.x, -a.y, -a.z};
}
template <class T>
INLINED VecOf<T> operator*(const T& s, const VecOf<T>& a) {
    return {s * a.x, s * a.y, s * a.z};
}
template <class T>
INLINED VecOf<T> cross(const VecOf<T>& a, const VecOf<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline bool operator==(Vec a, Vec b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vec a) { return std::sqrt(dot(a, a)); }

// A 3 x 3 matrix by rows; initially the unit matrix.
template <class T>
struct MatOf {
    T m[9] = {T{} + 1.0, T{}, T{}, T{}, T{} + 1.0, T{}, T{}, T{}, T{} + 1.0};
};
using Mat = MatOf<double>;

template <class T, class S>
INLINED VecOf<T> operator*(const MatOf<T>& a, const VecOf<S>& v) {
    return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
            a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}

// The transpose times a vector.
inline Vec rotate_back(const Mat& a, Vec v) {
    return {a.m[0] * v.x + a.m[3] * v.y + a.m[6] * v.z, a.m[1] * v.x + a.m[4] * v.y + a.m[7] * v.z,
            a.m[2] * v.x + a.m[5] * v.y + a.m[8] * v.z};
}

template <class T>
INLINED MatOf<T> operator*(const MatOf<T>& a, const MatOf<T>& b) {
    MatOf<T> c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c.m[3 * i + j] = a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
    return c;
}

// A rotation and a position: the placement of a frame in another.
template <class T>
struct FrameOf {
    MatOf<T> turn;
    VecOf<T> shift;
};
using Frame = FrameOf<double>;

template <class T, class S>
INLINED VecOf<T> operator*(const FrameOf<T>& f, const VecOf<S>& v) {
    return f.turn * v + f.shift;
}

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
