// Polynomials c0 + c1 s + ... on [0, 1], ascending powers: values, Bernstein coefficients, exact extrema.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "interrupts.hpp"
#include "vector.hpp"

namespace planner {

constexpr int highest_degree = 16;

inline double value_of(const double* c, int degree, double s) {
    double value = c[degree];
    for (int k = degree - 1; k >= 0; --k) value = value * s + c[k];
    return value;
}

// The Bernstein coefficients of a polynomial of its powers: it stays between the least and the largest of them. The i-th
// one is the sum of binomial(i, k) / binomial(degree, k) c_k; Pascal's triangle adds them up.
INLINED void to_bernstein(double* c, int degree, int across = 1) {
    double binomial = 1.0;
    for (int k = 1; k < degree; ++k) {
        binomial = binomial * (degree - k + 1) / k;
        for (int j = 0; j < across; ++j) c[k * across + j] /= binomial;
    }
    for (int row = 1; row <= degree; ++row)
        for (int i = degree; i >= row; --i)
            for (int j = 0; j < across; ++j) c[i * across + j] += c[(i - 1) * across + j];
}

// The derivative by s, `order` times; its degree, at least 0.
inline int derive(const double* c, int degree, int order, double* found, int across = 1) {
    if (c != found) std::copy(c, c + (degree + 1) * across, found);
    for (; order > 0; --order) {
        for (int k = 0; k < degree; ++k)
            for (int j = 0; j < across; ++j) found[k * across + j] = (k + 1) * found[(k + 1) * across + j];
        if (degree > 0)
            --degree;
        else
            std::fill(found, found + across, 0.0);
    }
    return degree;
}

// The largest absolute values (across,) of polynomials at 0 and 1.
FOR_THIS_PROCESSOR inline void largest_at_ends(const double* c, int degree, int across, double* largest) {
    std::copy(c + degree * across, c + (degree + 1) * across, largest);
    for (int k = degree - 1; k >= 0; --k)
        for (int j = 0; j < across; ++j) largest[j] += c[k * across + j];
    for (int j = 0; j < across; ++j) {
        const double begin = std::fabs(c[j]), end = std::fabs(largest[j]);
        largest[j] = begin > end ? begin : end;
    }
}

// The largest absolute Bernstein coefficients (across,), which no value exceeds; the polynomials are overwritten.
FOR_THIS_PROCESSOR inline void largest_coefficients(double* c, int degree, int across, double* largest) {
    to_bernstein(c, degree, across);
    std::fill(largest, largest + across, 0.0);
    for (int k = 0; k <= degree; ++k)
        for (int j = 0; j < across; ++j) {
            const double size = std::fabs(c[k * across + j]);
            largest[j] = size > largest[j] ? size : largest[j];
        }
}

// Where in (0, 1) the sign changes, ascending, to the last bit of s; how many places there are. Between two neighbouring
// ones of its derivative a polynomial is monotone, so halving finds the one that is there.
inline int sign_changes(const double* c, int degree, double* places) {
    if (degree < 1 || degree > highest_degree) return 0;
    double slope[highest_degree + 1], turns[highest_degree + 1];
    const int between = sign_changes(slope, derive(c, degree, 1, slope), turns);
    int count = 0;
    double low = 0.0;
    bool below = value_of(c, degree, low) < 0.0;
    for (int k = 0; k <= between; ++k) {
        const double end = k < between ? turns[k] : 1.0;
        const bool there = value_of(c, degree, end) < 0.0;
        if (there != below) {
            double high = end;
            for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
                ((value_of(c, degree, middle) < 0.0) == below ? low : high) = middle;
            places[count++] = 0.5 * (low + high);
        }
        low = end, below = there;
    }
    return count;
}

// The least and the largest value, exact but for rounding.
inline void extrema_of(const double* c, int degree, double& least, double& largest) {
    double slope[highest_degree + 1], turns[highest_degree + 1];
    const int count = sign_changes(slope, derive(c, degree, 1, slope), turns);
    least = std::min(c[0], value_of(c, degree, 1.0)), largest = std::max(c[0], value_of(c, degree, 1.0));
    for (int k = 0; k < count; ++k) {
        const double value = value_of(c, degree, turns[k]);
        least = std::min(least, value), largest = std::max(largest, value);
    }
}

// The largest share that the `order`-th derivative by time of polynomials c (n, degree + 1, dof), which take `seconds` (n,),
// has of limits `most` (dof,), and in `where` (2,) on which piece and for which joint. Shares up to `beyond` may come out
// smaller.
inline double worst_share(int64_t n, int degree, int dof, int order, const double* c, const double* seconds,
                          const double* most, double beyond, int64_t* where) {
    const int left = std::max(degree - order, 0);  // the degree of the derivatives
    const size_t block = (degree + size_t{1}) * dof, slope_block = (left + size_t{1}) * dof;
    std::vector<double> slopes(n * slope_block), own(block), most_here(dof), units(n, 1.0);
    double worst = -1.0;
    const auto take = [&](double value, int64_t k, int j) {
        if (!(value > worst * (units[k] * most[j]))) return;
        worst = value / units[k] / most[j], where[0] = k, where[1] = j;
    };
    where[0] = where[1] = 0;
    for (int64_t k = 0; k < n; ++k) {  // at the ends of the pieces
        poll_signal_at(k);
        for (int i = 0; i < order; ++i) units[k] *= seconds[k];
        derive(c + k * block, degree, order, own.data(), dof);
        std::copy(own.begin(), own.begin() + slope_block, slopes.begin() + k * slope_block);
        largest_at_ends(own.data(), left, dof, most_here.data());
        for (int j = 0; j < dof; ++j) take(most_here[j], k, j);
    }
    for (int64_t k = 0; k < n; ++k) {  // and inside, where that may be more
        poll_signal_at(k);
        const double* slope = &slopes[k * slope_block];
        std::copy(slope, slope + slope_block, own.begin());
        largest_coefficients(own.data(), left, dof, most_here.data());
        for (int j = 0; j < dof; ++j) {
            if (!(most_here[j] > std::max(worst, beyond) * (units[k] * most[j]))) continue;
            double low = 0.0, high = 0.0, alone[highest_degree + 1];
            for (int i = 0; i <= left; ++i) alone[i] = slope[i * dof + j];
            extrema_of(alone, left, low, high);
            take(std::max(std::fabs(low), std::fabs(high)), k, j);
        }
    }
    return worst;
}

// Hermite's quintic (6, dof) in u on [0, 1] of a piece that takes `h` s, from positions, velocities and accelerations
// (dof,) at its beginning to those a row of dof behind them.
INLINED void hermite_quintic(const double* q, const double* v, const double* a, double h, int dof, double* c) {
    for (int j = 0; j < dof; ++j) {
        const double start = v[j] * h, end = v[dof + j] * h, bend = a[j] * (h * h), bent = a[dof + j] * (h * h);
        const double rest = q[dof + j] - q[j] - start - 0.5 * bend, slope = end - start - bend, curve = bent - bend;
        c[j] = q[j], c[dof + j] = start, c[2 * dof + j] = 0.5 * bend;
        c[3 * dof + j] = 10.0 * rest - 4.0 * slope + 0.5 * curve;
        c[4 * dof + j] = -15.0 * rest + 7.0 * slope - curve;
        c[5 * dof + j] = 6.0 * rest - 3.0 * slope + 0.5 * curve;
    }
}

// Polynomial joint paths: q(s) = sum_k c_k s^k, s in [0, 1].
struct Pieces {
    const double* coefficients;  // (count, degree + 1, dof)
    int count, degree, dof;

    const double* of(int piece) const { return coefficients + static_cast<size_t>(piece) * (degree + 1) * dof; }
    void at(int piece, double s, double* q) const {
        const double* c = of(piece);
        for (int j = 0; j < dof; ++j) {
            double value = c[degree * dof + j];
            for (int k = degree - 1; k >= 0; --k) value = value * s + c[k * dof + j];
            q[j] = value;
        }
    }
    // dq / ds at s.
    void velocity(int piece, double s, double* velocity) const {
        const double* c = of(piece);
        for (int j = 0; j < dof; ++j) {
            double value = degree ? degree * c[degree * dof + j] : 0.0;
            for (int k = degree - 1; k >= 1; --k) value = value * s + k * c[k * dof + j];
            velocity[j] = value;
        }
    }
    // The interval of joint j on a piece: its smallest and largest Bernstein coefficient, enlarged by rounding.
    std::pair<double, double> hull(int piece, int j) const {
        const double* c = of(piece);
        double own[highest_degree + 1], size = 0.0;
        for (int i = 0; i <= degree; ++i) own[i] = c[i * dof + j], size += std::fabs(own[i]);
        to_bernstein(own, degree);
        const auto [least, most] = std::minmax_element(own, own + degree + 1);
        return {*least - 1e-13 * size, *most + 1e-13 * size};
    }
    // Bounds on |dq_j / ds|, or with `order` 2 on the second derivative, over [low, high], by Bernstein coefficients.
    void bounds(int order, int piece, double low, double high, double* bounds) const {
        const double* c = of(piece);
        const int n = degree - order;
        for (int j = 0; j < dof; ++j) {
            if (n < 1) {
                bounds[j] = n < 0 ? 0.0 : order * std::fabs(c[order * dof + j]);
                continue;
            }
            double power[highest_degree + 1];  // of the derivative, in t = (s - low) / (high - low)
            for (int k = 0; k <= n; ++k) {
                power[k] = (k + order) * c[(k + order) * dof + j];
                if (order == 2) power[k] *= k + 1;
            }
            for (int i = 0; i < n; ++i)
                for (int k = n - 1; k >= i; --k) power[k] += low * power[k + 1];
            double width = 1.0;
            for (int k = 0; k <= n; ++k, width *= high - low) power[k] *= width;
            double most = 0.0, size = 0.0;
            for (int i = 0; i <= n; ++i) size += std::fabs(power[i]);
            to_bernstein(power, n);
            for (int i = 0; i <= n; ++i) most = std::max(most, std::fabs(power[i]));
            bounds[j] = most + 1e-14 * size;
        }
    }
};

}  // namespace planner
