// The flows of the laws for fixed parent values: s' = -(beta1 |s|^p + beta2 |s|^q) sgn(s), or s' = -s.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "vector.hpp"

namespace planner {

// Logarithms and powers to about 1e-14, without branches and calls, so that compilers vectorize them.

INLINED uint64_t bits_of(double x) {
    uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}

INLINED double of_bits(uint64_t bits) {
    double x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}

constexpr double smallest_normal = 0x1p-1022;

// log2 x for x >= 0; -1022 below the smallest normal number.
//
// x = 2^k m with m in [sqrt(1/2), sqrt(2)), and ln m = 2 artanh(s), s = (m - 1) / (m + 1): the series of artanh ends
// below the last bit, as s^2 <= 0.0295.
INLINED double log2_of(double x) {
    constexpr uint64_t root_of_half = 0x3fe6a09e667f3bcd, bias = uint64_t{1023} << 52;
    x = x > smallest_normal ? x : smallest_normal;
    const uint64_t biased = bits_of(x) - root_of_half + bias;
    // the bits of k + 1023 below those of 2^52 are 2^52 + k + 1023
    const double k = of_bits((biased >> 52) | 0x4330000000000000) - (0x1p52 + 1023.0);
    const double m = of_bits((biased & 0x000fffffffffffff) + root_of_half);
    const double s = (m - 1.0) / (m + 1.0), z = s * s;
    double series = 1.0 / 23.0;
    series = series * z + 1.0 / 21.0;
    series = series * z + 1.0 / 19.0;
    series = series * z + 1.0 / 17.0;
    series = series * z + 1.0 / 15.0;
    series = series * z + 1.0 / 13.0;
    series = series * z + 1.0 / 11.0;
    series = series * z + 1.0 / 9.0;
    series = series * z + 1.0 / 7.0;
    series = series * z + 1.0 / 5.0;
    series = series * z + 1.0 / 3.0;
    const double first = s * 2.8853900817779268;  // 2 s / ln 2
    return k + (first + first * (series * z));
}

// 2^t, with t clamped to [-1022, 1023].
//
// t = k + z / ln 2 with |z| <= ln(2) / 2: the series of e^z ends below the last bit.
INLINED double exp2_of(double t) {
    constexpr double shift = 0x1.8p52;  // its last bit is the unit
    t = t > -1022.0 ? t : -1022.0;
    t = t < 1023.0 ? t : 1023.0;
    const double shifted = t + shift, z = (t - (shifted - shift)) * 0.6931471805599453;
    double series = 1.0 / 6227020800.0;  // 1 / 13!
    series = series * z + 1.0 / 479001600.0;
    series = series * z + 1.0 / 39916800.0;
    series = series * z + 1.0 / 3628800.0;
    series = series * z + 1.0 / 362880.0;
    series = series * z + 1.0 / 40320.0;
    series = series * z + 1.0 / 5040.0;
    series = series * z + 1.0 / 720.0;
    series = series * z + 1.0 / 120.0;
    series = series * z + 1.0 / 24.0;
    series = series * z + 1.0 / 6.0;
    series = series * z + 0.5;
    series = series * z + 1.0;
    series = series * z + 1.0;
    return of_bits(bits_of(series) + (bits_of(shifted) << 52));
}

// below = 1 - p, above = q - 1; below = 0: the linear flow.
struct Flow {
    double beta1, beta2, below, above;
};

// Order of the two powers in a step.
enum Order { strang, brake_then_sink, sink_then_brake };

constexpr int flow_block = 256;  // sizes per block, which fit the first-level cache

// A step of three parts: the power below 1, the power above 1, and the power below 1.
//
// With u = s^below the power below 1 takes beta1 below dtau off u, down to 0, and the power above 1 divides u by
// (1 + g)^(below / above), g = beta2 above dtau s^above. Beyond g = 2^600 the 1 is below the last bit, and g can overflow.
struct Parts {
    double first, second;  // decrements of u by the power below 1
    double log_growth;     // log2(beta2 above dtau)
};

// From log2 g to log2 of (1 + g)^-share.
INLINED void braking(double share, int n, double* growth) {
    double one_more[flow_block];
    for (int k = 0; k < n; ++k) one_more[k] = 1.0 + exp2_of(growth[k]);
    for (int k = 0; k < n; ++k) one_more[k] = log2_of(one_more[k]);
    for (int k = 0; k < n; ++k) growth[k] = -share * (growth[k] > 600.0 ? growth[k] : one_more[k]);
}

VERSIONS("avx512f", "avx2") inline void powers_move(const Flow& flow, const Parts& parts, int n, double* size) {
    double logs[flow_block], u[flow_block], growth[flow_block];  // logs: log2 u
    const double below = flow.below, share = flow.below / flow.above, root = 1.0 / flow.below, per_share = 1.0 / share;
    for (int k = 0; k < n; ++k) logs[k] = below * log2_of(size[k]);
    if (parts.first > 0.0) {
        for (int k = 0; k < n; ++k) u[k] = exp2_of(logs[k]);
        for (int k = 0; k < n; ++k) u[k] = u[k] > parts.first ? u[k] - parts.first : 0.0;
        for (int k = 0; k < n; ++k) logs[k] = log2_of(u[k]);
    }
    for (int k = 0; k < n; ++k) growth[k] = logs[k] * per_share + parts.log_growth;
    braking(share, n, growth);
    if (parts.first > 0.0) {
        for (int k = 0; k < n; ++k) u[k] *= exp2_of(growth[k]);
    } else {
        for (int k = 0; k < n; ++k) u[k] = exp2_of(logs[k] + growth[k]);
    }
    for (int k = 0; k < n; ++k) u[k] = u[k] > parts.second ? u[k] - parts.second : 0.0;
    if (root == 2.5) {  // p of the paper
        for (int k = 0; k < n; ++k) u[k] = u[k] * u[k] * std::sqrt(u[k]);
    } else {
        for (int k = 0; k < n; ++k) logs[k] = root * log2_of(u[k]);
        for (int k = 0; k < n; ++k) u[k] = u[k] > 0.0 ? exp2_of(logs[k]) : 0.0;
    }
    for (int k = 0; k < n; ++k) size[k] = u[k] < size[k] ? u[k] : size[k];
}

// For exponents so close to 1 that the root loses more than three digits.
constexpr double near_one = 1e-3;

inline double sink(const Flow& flow, double size, double dtau) {
    const double fall = flow.below * flow.beta1 * dtau;
    if (size == 0.0) return 0.0;
    if (flow.below >= near_one) return std::pow(std::max(std::pow(size, flow.below) - fall, 0.0), 1.0 / flow.below);
    return size * std::exp(std::log1p(-std::min(fall * std::pow(size, -flow.below), 1.0)) / flow.below);
}

inline double brake(const Flow& flow, double size, double dtau) {
    const double fall = flow.above * flow.beta2 * dtau, growth = fall * std::pow(size, flow.above);
    if (growth > 0x1p600) return std::pow(fall, -1.0 / flow.above);  // independent of the start, to the last bit
    return size * std::exp(std::log1p(growth) / -flow.above);
}

inline double near_one_moves(const Flow& flow, Order order, double size, double dtau) {
    if (order == brake_then_sink) return sink(flow, brake(flow, size, dtau), dtau);
    if (order == sink_then_brake) return brake(flow, sink(flow, size, dtau), dtau);
    return sink(flow, brake(flow, sink(flow, size, 0.5 * dtau), dtau), 0.5 * dtau);
}

// Move sizes |s| (n at most flow_block) by dtau, in place; 0 stays 0, and no size grows.
inline void flow_moves(const Flow& flow, Order order, double dtau, int n, double* size) {
    if (flow.below == 0.0) {
        const double left = std::exp(-dtau);
        for (int k = 0; k < n; ++k) size[k] *= left;
    } else if (flow.below < near_one || flow.above < near_one) {
        for (int k = 0; k < n; ++k) size[k] = std::min(near_one_moves(flow, order, size[k], dtau), size[k]);
    } else {
        const double fall = flow.below * flow.beta1 * dtau;
        const double first = order == strang ? 0.5 * fall : order == sink_then_brake ? fall : 0.0;
        powers_move(flow, {first, fall - first, std::log2(flow.above * flow.beta2 * dtau)}, n, size);
    }
}

}  // namespace planner
