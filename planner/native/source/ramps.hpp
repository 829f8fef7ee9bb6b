// Parabolic ramps: every joint from a position and velocity to another in the same time (Hauser, Ng-Thow-Hing 2010).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "phases.hpp"

namespace planner {

// Positions and velocities (dof).
struct State {
    std::vector<double> q, v;
};

// A motion of one joint between two states: an acceleration for `rise` s, constant speed, and the opposite acceleration
// for the last `fall` s.
struct JointRamp {
    double rate, rise, fall;

    // In t seconds, at most `velocity` fast. Without constant speed, the acceleration a lasts (t + change / a) / 2, and
    // a² t² + 2 (t (v0 + v1) - 2 d) a = change² for the distance d and the change of velocity; of two solutions the one
    // with times in [0, t].
    JointRamp(double q0, double v0, double q1, double v1, double t, double velocity) {
        const double distance = q1 - q0, change = v1 - v0, missing = t * (v0 + v1) - 2.0 * distance;
        const double root = std::sqrt(missing * missing + (t * change) * (t * change));
        rate = -std::copysign(std::fabs(missing) + root, missing) / (t * t);
        rise = rate == 0.0 ? 0.5 * t : 0.5 * (t + change / rate);
        fall = t - rise;
        if (!(std::fabs(v0 + rate * rise) > velocity)) return;
        const double most = std::copysign(velocity, rate), up = most - v0, down = most - v1;
        const double slower = (up * up + down * down) / (2.0 * (most * t - distance));
        rate = slower * most > 0.0 ? slower : HUGE_VAL;
        rise = up / rate, fall = down / rate;
    }

    bool fits(double t, double acceleration) const {
        return std::fabs(rate) <= acceleration && rise + fall <= t * (1.0 + 1e-12);
    }
};

// The pieces (m, 3, dof) of the ramp from `start` to `end` in the first of ascending `durations` that suits all joints, s
// in proportion to time; none if no duration suffices.
inline std::vector<double> quickest_ramp(const State& start, const State& end, const double* durations, int count,
                                         const double* velocity, const double* acceleration) {
    constexpr double shortest = 1e-6;  // share of the ramp; closer changes of acceleration are merged
    const int dof = static_cast<int>(start.q.size());
    std::vector<JointRamp> joints;
    double t = 0.0;
    for (int k = 0; k < count && static_cast<int>(joints.size()) < dof; ++k) {
        t = durations[k], joints.clear();
        for (int j = 0; j < dof; ++j) {
            joints.emplace_back(start.q[j], start.v[j], end.q[j], end.v[j], t, velocity[j]);
            if (!joints.back().fits(t, acceleration[j])) {
                joints.clear();
                break;
            }
        }
    }
    std::vector<double> pieces;
    if (static_cast<int>(joints.size()) < dof) return pieces;
    std::vector<double> moments{0.0, t};  // changes of a joint's acceleration
    for (const JointRamp& joint : joints)
        for (const double moment : {joint.rise, t - joint.fall}) moments.push_back(std::min(std::max(moment, 0.0), t));
    std::sort(moments.begin(), moments.end());
    moments.erase(std::unique(moments.begin(), moments.end()), moments.end());
    std::vector<double> kept{moments[0]};
    for (size_t k = 1; k < moments.size(); ++k)
        if (moments[k] - moments[k - 1] > shortest * t) kept.push_back(moments[k]);
    kept.back() = t;
    for (size_t k = 0; k + 1 < kept.size(); ++k) {
        const double early = kept[k], h = kept[k + 1] - early, middle = 0.5 * (early + kept[k + 1]);
        const size_t row = pieces.size();
        pieces.resize(row + 3 * dof);
        for (int j = 0; j < dof; ++j) {
            const auto& [rate, rise, fall] = joints[j];
            const double bend = middle < rise       ? rate
                                : middle > t - fall ? -rate
                                                    : 0.0,
                         cruise = start.v[j] + rate * rise;
            const double up = std::min(early, rise), back = std::min(t - early, fall);
            const bool begun = early <= t - fall;
            const double q = begun ? start.q[j] + start.v[j] * up + 0.5 * rate * up * up + cruise * (early - up)
                                   : end.q[j] - end.v[j] * back - 0.5 * rate * back * back;
            pieces[row + j] = q;
            pieces[row + dof + j] = (begun ? start.v[j] + rate * up : end.v[j] + rate * back) * h;
            pieces[row + 2 * dof + j] = 0.5 * bend * h * h;
        }
    }
    return pieces;
}

// A motion through its phases along a curve.
class MotionOnCurve {
   public:
    MotionOnCurve(const Curve& curve, const Phase* phases, int count) : curve_(curve), phases_(phases) {
        double end = 0.0;
        for (int k = 0; k < count; ++k) ends_.push_back(end += phases[k].duration);
    }

    // Piece, s, position and velocity at t seconds.
    void at(double t, int64_t& piece, double& s, State& state) const {
        const size_t after = std::lower_bound(ends_.begin(), ends_.end(), t) - ends_.begin();
        const size_t k = std::min(after, ends_.size() - 1);
        const Phase& phase = phases_[k];
        const double into = std::min(std::max(t - (ends_[k] - phase.duration), 0.0), phase.duration);
        const double on = phase.s + (phase.speed + 0.5 * phase.acceleration * into) * into;
        const double speed = std::max(phase.speed + phase.acceleration * into, 0.0);
        const int own = static_cast<int>(phase.piece);
        piece = own, s = std::min(std::max(on, 0.0), 1.0);
        state.q.resize(curve_.dof), state.v.resize(curve_.dof);
        for (int j = 0; j < curve_.dof; ++j)
            state.q[j] = curve_.at(own, s, j), state.v[j] = curve_.slope(own, s, j) * speed;
    }

   private:
    Curve curve_;
    const Phase* phases_;
    std::vector<double> ends_;
};

// Whether parabolas (m, 3, dof) are within `lower` and `upper`, by Bernstein coefficients.
inline bool stay_between(const std::vector<double>& pieces, int dof, const double* lower, const double* upper) {
    for (size_t row = 0; row < pieces.size(); row += 3 * dof)
        for (int j = 0; j < dof; ++j) {
            const double c[] = {pieces[row + j], pieces[row + dof + j], pieces[row + 2 * dof + j]};
            for (const double value : {c[0], c[0] + 0.5 * c[1], c[0] + c[1] + c[2]})
                if (!(lower[j] <= value && value <= upper[j])) return false;
        }
    return true;
}

}  // namespace planner
