// The largest speeds along a curve of lines and parabolas within limits on the velocities and accelerations of joints.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "convex.hpp"

namespace planner {

// A stretch of a piece q(s) on which u = d²s/dt² is constant, so x = (ds/dt)² grows by 2 u per unit of s. The joint
// accelerations q' u + q'' x are linear in s, so limits at both ends suffice. A line is one stretch, on which the motion
// accelerates, cruises and brakes. `joint` is the factor of x at the start of the next stretch, 0 for a stop.
class Stretch {
   public:
    double joint = 1.0;

    // `piece` has c0, c1, c2 of q(s) = c0 + c1 s + c2 s^2; the stretch is [low, high] in s.
    Stretch(int dof, const double* piece, double low, double high, const double* velocity, const double* acceleration)
        : dof_(dof), first_(dof), last_(dof), bend_(dof), limit_(acceleration), length_(high - low) {
        most_first_ = most_last_ = rate_ = infinity, line_ = true;
        for (int j = 0; j < dof; ++j) {
            const double slope = piece[dof + j];
            bend_[j] = 2.0 * piece[2 * dof + j];
            first_[j] = slope + low * bend_[j], last_[j] = slope + high * bend_[j];
            limit_speed(first_[j], last_[j], velocity[j]);
            rate_ = std::min(rate_, acceleration[j] / std::fabs(slope));
            line_ = line_ && bend_[j] == 0.0;
        }
    }

    // The largest x at the start from which x can be at most `most` at the end: Newton's method from above on (largest u) -
    // (least u), which is concave and piecewise linear in x.
    double controllable(double most) const {
        constexpr int steps = 60;  // each step drops one of finitely many lines
        most = std::min(most, most_last_);
        if (line_) return std::min(most_first_, most + 2.0 * length_ * rate_);
        double x = most_first_;
        for (int j = 0; j < dof_; ++j) {  // with q' = 0 the acceleration depends on x only
            if (first_[j] == 0.0 && bend_[j] != 0.0) x = std::min(x, limit_[j] / std::fabs(bend_[j]));
            if (last_[j] + 2.0 * length_ * bend_[j] == 0.0 && bend_[j] != 0.0)
                x = std::min(x, limit_[j] / std::fabs(bend_[j]));
        }
        for (int k = 0; k < steps; ++k) {
            const Range range = range_at(x, most);
            if (range.low <= range.high) break;
            const double step = (range.high - range.low) / (range.high_slope - range.low_slope);
            if (!(0.0 < step && step <= x) || x - step == x) return std::max(0.0, x * (1.0 - 1e-12));
            x -= step;
        }
        return x;
    }

    // The largest x at the end, at most `most`, after x at the start; sets u, on a line the largest u.
    double quickest(double x, double most, double& u) const {
        most = std::min(most, most_last_);
        if (line_) return u = rate_, std::min(most, x + 2.0 * length_ * rate_);
        const Range range = range_at(x, most);
        u = range.high >= range.low ? range.high : 0.5 * (range.low + range.high);  // they cross only by rounding
        return std::max(0.0, x + 2.0 * length_ * u);
    }

   private:
    // Keep |q'| sqrt(x) below a joint's limit v: x below v² / q'², which is convex if q' has no root. Its chord exceeds it
    // by a factor of at most kappa, so a linear x below the chord divided by kappa is within the limit. For larger changes
    // of q' the bound is the tangent at the quicker end, and behind a root the limit of the other end.
    void limit_speed(double first, double last, double velocity) {
        constexpr double least = 1e-4, most = 0.3;  // changes of q' with the chord bound; smaller ones are rounding
        const bool falls = std::fabs(first) >= std::fabs(last);
        const double quick = falls ? first : last, ratio = (falls ? last : first) / quick;
        if (quick == 0.0) return;
        const double square = (velocity / quick) * (velocity / quick), less = 1.0 - ratio;
        double at_quick = square, at_slow = square * std::min(1.0 + 2.0 * less, 1.0 / (ratio * ratio));
        if (least < less && less < most) {
            const double more = 1.0 / (ratio * ratio) - 1.0, s = (more - 2.0 * less) / (3.0 * less * more);
            const double slope = 1.0 - less * s, kappa = slope * slope * (1.0 + more * s) * (1.0 + 1e-12);
            at_quick = square / kappa, at_slow = square * (1.0 + more) / kappa;
        }
        most_first_ = std::min(most_first_, falls ? at_quick : at_slow);
        most_last_ = std::min(most_last_, falls ? at_slow : at_quick);
    }

    struct Range {
        double low = -infinity, high = infinity, low_slope = 0.0, high_slope = 0.0;

        void keep(double by_u, double by_x, double at_most, double x) {
            const double u = (at_most - by_x * x) / by_u;
            if (by_u > 0.0 && u < high) high = u, high_slope = -by_x / by_u;
            if (by_u < 0.0 && u > low) low = u, low_slope = -by_x / by_u;
        }
    };

    Range range_at(double x, double most) const {
        Range range;
        for (int j = 0; j < dof_; ++j) {
            const double end = last_[j] + 2.0 * length_ * bend_[j];
            range.keep(first_[j], bend_[j], limit_[j], x);
            range.keep(-first_[j], -bend_[j], limit_[j], x);
            range.keep(end, bend_[j], limit_[j], x);
            range.keep(-end, -bend_[j], limit_[j], x);
        }
        range.keep(2.0 * length_, 1.0, most, x);
        range.keep(-2.0 * length_, -1.0, 0.0, x);
        return range;
    }

    int dof_;
    std::vector<double> first_, last_, bend_;        // q' at both ends, q''
    const double* limit_;                            // on accelerations
    double length_, most_first_, most_last_, rate_;  // x at both ends
    bool line_;
};

// Write x at the start of every stretch, at its end before `joint`, and u. A backward pass computes the largest x from
// which the rest is feasible, a forward pass the largest u below it (Pham and Pham 2018).
inline void quickest_motion(const std::vector<Stretch>& stretches, double* found) {
    const size_t count = stretches.size();
    std::vector<double> most(count + 1);
    for (size_t k = count; k-- > 0;) {
        poll_signal_at(static_cast<int64_t>(k));
        const double joint = stretches[k].joint;
        most[k] = stretches[k].controllable(joint > 0.0 ? most[k + 1] / joint : 0.0);
    }
    double now = 0.0;
    for (size_t k = 0; k < count; ++k) {
        const double joint = stretches[k].joint;
        double* row = found + 3 * k;
        row[0] = now;
        row[1] = stretches[k].quickest(now, joint > 0.0 ? most[k + 1] / joint : 0.0, row[2]);
        now = row[1] * joint;
    }
}

}  // namespace planner
