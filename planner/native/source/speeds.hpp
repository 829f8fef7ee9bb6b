// Speeds of an arm's bodies along a joint path: exact at a state, and bounds on their change around it.
//
// A point p of a body moves at dp/ds = sum_j q'_j dp/dq_j, by the body's turn and slide at the state. That is less than
// the sum over joints of absolute values. If joint j carries joint k, dp/dq_k turns with joint j, so |d2p / dq_j dq_k| is
// at most the reach R_k from the axis of joint k, and 0 if joint j slides. So |d2p/ds2| <= sum_k |q''_k| R_k +
// sum_jk |q'_j| |q'_k| R_k, with k the outer one of the two.
#pragma once

#include "world.hpp"

namespace planner {

// Bounds on the speed of a body's points, per unit of s: `at` at the state, plus `change` times |s| elsewhere; infinite if
// unknown.
struct Speed {
    double at = infinity, change = 0.0;

    // Bound on the speed within `x` of the state.
    double anywhere(double x) const { return at + change * x; }
    // Bound (m) on the motion within `x` of the state.
    double moved(double x) const { return (at + 0.5 * change * x) * x; }
    // Distance in s from the state within which no point moves by `distance` (m), at least 0.
    double within(double distance) const {
        return distance > 0.0 ? 2.0 * distance / (at + std::sqrt(at * at + 2.0 * change * distance)) : 0.0;
    }
};

class Speeds {
   public:
    // `body_reach` (bodies, joints) holds in every configuration.
    Speeds(const World& world, const double* body_reach)
        : world_(world), body_reach_(body_reach), turns_(world.chain.size() + 1), slides_(world.chain.size() + 1) {}

    // Compute speeds for the placements of `scratch`, velocities (dof,) of planned joints at the state, and bounds on
    // velocities `rates` (joints,) and their derivatives `bends` (joints,) on the interval.
    void at(const Scratch& scratch, const double* velocities, const double* rates, const double* bends) {
        scratch_ = &scratch, rates_ = rates, bends_ = bends;
        for (int j = 1; j <= world_.chain.size(); ++j) {
            const Joint& joint = world_.chain.joints[j - 1];
            const Frame& frame = scratch.frames[j];
            const Vec along = (joint.factor * velocities[joint.leader]) * (frame.turn * joint.axis);
            turns_[j] = turns_[joint.parent], slides_[j] = slides_[joint.parent];
            if (joint.prismatic)
                slides_[j] = slides_[j] + along;
            else
                turns_[j] = turns_[j] + along, slides_[j] = slides_[j] + cross(frame.shift, along);
        }
    }

    // Speed of a body, relative to the base.
    Speed of(int body) const { return seen_from(0, body); }

    // Relative speed of two bodies; unknown if neither joint carries the other.
    Speed between(int first, int second) const {
        const int a = world_.items[first].joint, b = world_.items[second].joint;
        return carries(a, b) ? seen_from(a, second) : carries(b, a) ? seen_from(b, first) : Speed();
    }

   private:
    bool carries(int joint, int other) const {
        while (other > joint) other = world_.chain.joints[other - 1].parent;
        return other == joint;
    }

    Speed seen_from(int joint, int body) const {
        const Item& item = world_.items[body];
        if (item.spheres == 0) return {};
        const double* reach = body_reach_ + static_cast<size_t>(body) * world_.chain.size();
        Speed speed{0.0, 0.0};
        double beyond = 0.0;  // of the outer joints
        for (int j = item.joint; j != joint; j = world_.chain.joints[j - 1].parent) {
            const double own = rates_[j - 1] * reach[j - 1];
            if (!world_.chain.joints[j - 1].prismatic) speed.change += rates_[j - 1] * (own + 2.0 * beyond);
            speed.change += bends_[j - 1] * reach[j - 1];
            beyond += own;
        }
        const Vec turn = turns_[item.joint] - turns_[joint], slide = slides_[item.joint] - slides_[joint];
        const double around = length(turn);
        for (int k = item.first_sphere; k < item.first_sphere + item.spheres; ++k) {
            const Vec middle{scratch_->x[k], scratch_->y[k], scratch_->z[k]};
            speed.at = std::max(speed.at, length(slide + cross(turn, middle)) + around * world_.radii[k]);
        }
        return speed;
    }

    const World& world_;
    const double* body_reach_;
    std::vector<Vec> turns_, slides_;  // of each joint's frame: velocity of the point at the world origin
    const Scratch* scratch_ = nullptr;
    const double *rates_ = nullptr, *bends_ = nullptr;
};

}  // namespace planner
