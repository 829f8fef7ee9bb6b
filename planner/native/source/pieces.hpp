// Pieces of joint paths, and how fast they move the joints at most.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "polynomials.hpp"

namespace planner {

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
    // What holds joint j all along a piece: its smallest and largest Bernstein coefficient, and what rounding may add.
    std::pair<double, double> hull(int piece, int j) const {
        const double* c = of(piece);
        double own[highest_degree + 1], size = 0.0;
        for (int i = 0; i <= degree; ++i) own[i] = c[i * dof + j], size += std::fabs(own[i]);
        to_bernstein(own, degree);
        const auto [least, most] = std::minmax_element(own, own + degree + 1);
        return {*least - 1e-13 * size, *most + 1e-13 * size};
    }
    // Bounds on |dq_j / ds|, or with `order` 2 on the second derivative, over [low, high]: its largest Bernstein
    // coefficient there.
    void bounds(int order, int piece, double low, double high, double* bounds) const {
        const double* c = of(piece);
        const int n = degree - order;
        for (int j = 0; j < dof; ++j) {
            if (n < 1) {
                bounds[j] = n < 0 ? 0.0 : order * std::fabs(c[order * dof + j]);
                continue;
            }
            double power[highest_degree + 1];  // of the derivative, in t from 0 at low to 1 at high
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
