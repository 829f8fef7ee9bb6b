// Motions to rest from a position, velocity v and acceleration a in a time T, with tau = t / T in [0, 1]:
//
//     v(tau) = v (1 - 3 tau² + 2 tau³) + a T (tau - 2 tau² + tau³) = (1 - tau)² (v (1 + 2 tau) + a T tau)
//
// The acceleration (1 - tau) (a (1 - 3 tau) - b tau), b = 6 v / T, begins at a and ends at 0; the jerk is linear. If a
// joint accelerates near its velocity limit, this motion exceeds the limit. Then the acceleration first decreases to 0
// with the largest jerk, a (1 - tau), and such a motion to rest follows.
#pragma once

#include <algorithm>
#include <cmath>

#include "convex.hpp"
#include "polynomials.hpp"

namespace planner {

// Limits of one joint on |v|, |a| and |jerk|, infinite for no limit, and on positions.
struct StopLimits {
    double most[3], lower, upper;
};

class Stop {
   public:
    Stop(double q, double v, double a, double T) : q_(q), v_(v), a_(a), T_(T), b_(6.0 * v / T) {}

    // c (5,) of q(tau).
    void coefficients(double* c) const {
        const double vT = v_ * T_, aTT = a_ * T_ * T_;
        c[0] = q_, c[1] = vT, c[2] = 0.5 * aTT, c[3] = -vT - 2.0 / 3.0 * aTT, c[4] = 0.5 * vT + 0.25 * aTT;
    }

    // The largest ratio to a limit, exact up to rounding. Kinds 0 to 2 are limits on derivatives; kind 3 is 1 plus the
    // excess (rad) over a position limit.
    double share(int kind, const StopLimits& limits) const {
        if (kind == 3) {
            double c[5];
            coefficients(c);
            double least = q_, largest = q_;
            for (const double tau : {1.0, inner(-v_, 2.0 * v_ + a_ * T_)}) {
                const double q = (((c[4] * tau + c[3]) * tau + c[2]) * tau + c[1]) * tau + c[0];
                least = std::min(least, q), largest = std::max(largest, q);
            }
            return 1.0 + std::max(limits.lower - least, largest - limits.upper);
        }
        const double slope = 3.0 * a_ + b_;
        double most = 0.0;
        if (kind == 0)
            for (const double tau : {0.0, inner(a_, slope)}) most = std::max(most, std::fabs(velocity(tau)));
        if (kind == 1)
            for (const double tau : {0.0, inner(4.0 * a_ + b_, 2.0 * slope)})
                most = std::max(most, std::fabs((1.0 - tau) * (a_ * (1.0 - 3.0 * tau) - b_ * tau)));
        if (kind == 2) most = std::max(std::fabs(4.0 * a_ + b_), std::fabs(2.0 * a_ + b_)) / T_;
        return most / limits.most[kind];
    }

   private:
    // above / below if that is in [0, 1], else 0.
    static double inner(double above, double below) {
        const double tau = above / below;
        return tau > 0.0 && tau < 1.0 ? tau : 0.0;
    }
    double velocity(double tau) const { return (1.0 - tau) * (1.0 - tau) * (v_ * (1.0 + 2.0 * tau) + a_ * T_ * tau); }

    double q_, v_, a_, T_, b_;
};

// Index of the first of ascending `times` (count,) in which all joints come to rest within limits, or -1. Then `worst`
// has the kind of limit and the joint with the smallest violation over all times. The limit that one time violates is
// checked first for the next time.
inline int quickest_stop(const double* q, const double* v, const double* a, int dof, const double* times, int count,
                         const StopLimits* limits, int* worst) {
    double least = infinity;
    int tight[2] = {2, 0};
    for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < count; ++k) {
            const int j = tight[1];
            if (!pass && !(Stop(q[j], v[j], a[j], times[k]).share(tight[0], limits[j]) <= 1.0)) continue;
            double most = 0.0;
            int where[2] = {0, 0};
            for (int kind = 0; kind < 4 && (pass || most <= 1.0); ++kind)
                for (int j = 0; j < dof; ++j) {
                    const double share = Stop(q[j], v[j], a[j], times[k]).share(kind, limits[j]);
                    if (!(share <= most)) most = share, where[0] = kind, where[1] = j;
                    if (!pass && !(most <= 1.0)) {
                        tight[0] = kind, tight[1] = j;
                        break;
                    }
                }
            if (!pass && most <= 1.0) return k;
            if (pass && most < least) least = most, worst[0] = where[0], worst[1] = where[1];
        }
    return -1;
}

constexpr double shortest_ease = 1e-3;  // s in which accelerations decrease to 0, if jerk limits allow

// Decrease accelerations to 0 with the largest jerk; returns the time, in whole nanoseconds, or 0 if a limit is
// violated. Writes the piece c (5, dof), and q and v (dof,) at its end.
inline double ease(const double* q, const double* v, const double* a, int dof, const StopLimits* limits, double* c,
                   double* end_q, double* end_v) {
    double T = shortest_ease;
    for (int j = 0; j < dof; ++j) T = std::max(T, std::fabs(a[j]) / limits[j].most[2]);
    T = std::ceil(T * 1e9) / 1e9;
    for (int j = 0; j < dof; ++j) {
        const double own[5] = {q[j], v[j] * T, 0.5 * a[j] * T * T, -a[j] * T * T / 6.0, 0.0};
        double least, largest;
        extrema_of(own, 3, least, largest);
        for (int k = 0; k < 5; ++k) c[k * dof + j] = own[k];
        end_q[j] = value_of(own, 3, 1.0), end_v[j] = v[j] + 0.5 * a[j] * T;
        const bool fast = std::max(std::fabs(v[j]), std::fabs(end_v[j])) > limits[j].most[0];
        if (fast || std::fabs(a[j]) > limits[j].most[1] || least < limits[j].lower || largest > limits[j].upper)
            return 0.0;
    }
    return T;
}

}  // namespace planner
