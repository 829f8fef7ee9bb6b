// Checks of single states; they prove nothing about the states between.
#pragma once

#include "refusals.hpp"
#include "world.hpp"

namespace planner {

constexpr double clearly = 1e-6;  // m beyond the margin, larger than rounding
constexpr double ahead = 0.3;     // m, largest distance that is measured around a state

// For one thread. A check begins with the results of the previous state: the touching pair, and the vector between two
// bodies.
class StateCheck {
   public:
    explicit StateCheck(const World& world)
        : world_(world), scratch_(world.scratch()), bounds_(world.pair_count()),
          enough_(world.pair_count(), world.margin + rounding),
          motion_(world.bodies + world.pair_count() - world.bodies * world.obstacles()), apart_(world.pair_count()),
          guessed_(world.pair_count()) {
        world.place_moving(0.0, scratch_.frames.data());
    }

    int dof() const { return world_.chain.dof(); }

    // Whether the world has the same size as at construction.
    bool fits() const {
        return bounds_.size() == world_.pairs.size() && scratch_.x.size() == world_.radii.size() &&
               scratch_.middles.size() == static_cast<size_t>(world_.bodies) &&
               scratch_.frames.size() == world_.frame_count();
    }

    // Whether a pair is within the margin at a configuration, or a number is not finite. The pair of the last contact is
    // checked first, as it is the likeliest.
    bool finds_near(const double* q, double beyond) {
        if (!within(q, world_.chain.dof(), farthest)) return true;
        const Frame* frames = scratch_.frames.data();
        world_.chain.place(q, scratch_.frames.data());
        if (suspect_ >= 0) {
            world_.place_spheres(frames, scratch_);
            if (world_.coarse_of(suspect_, frames, scratch_) <= world_.margin && touches(suspect_)) return true;
        }
        world_.find_far(frames, world_.margin + beyond, least_, far_);
        world_.coarse(frames, scratch_, bounds_.data(), nullptr, enough_.data(), far_.data());
        for (int p = 0; p < world_.pair_count(); ++p) {
            if (bounds_[p] > world_.margin) continue;
            if (!touches(p)) continue;
            suspect_ = p;
            return true;
        }
        return false;
    }

    // Whether no sample of a motion from `start` by `delta` touches, apart from `start`: its end, its middle, and states
    // between which no point moves farther than `step` (m). A sample is skipped if the distances at another sample
    // exceed the motion between the two.
    bool looks_free(const double* start, const double* delta, const Bounds& bounds, double step) {
        const double *reach = bounds.reach.data(), *body_reach = bounds.body_reach.data();
        const int dof = world_.chain.dof(), joints = world_.chain.size(), scene = world_.bodies * world_.obstacles();
        if (!within(delta, dof, farthest)) return false;
        std::vector<double> sizes(joints);
        for (int j = 0; j < joints; ++j)
            sizes[j] = std::fabs(world_.chain.joints[j].factor * delta[world_.chain.joints[j].leader]);
        const auto moved = [&](const double* row) {
            double motion = 0.0;
            for (int j = 0; j < joints; ++j) motion += row[j] * sizes[j];
            require(motion >= 0.0, "a reach is no distance");
            return motion;
        };
        double most = 0.0;
        for (int b = 0; b < world_.bodies; ++b) most = std::max(most, motion_[b] = moved(body_reach + b * joints));
        for (int p = scene; p < world_.pair_count(); ++p)
            motion_[world_.bodies + p - scene] = moved(reach + static_cast<size_t>(p) * joints);
        require(most / step <= INT32_MAX / 4, "a motion is too long to be looked at in such short steps");
        const int count = static_cast<int>(std::ceil(most / step));
        std::vector<double> q(dof);
        std::vector<uint8_t> clear(count + 1);
        const auto is_near = [&](double share) {
            poll_signal();
            for (int j = 0; j < dof; ++j) q[j] = start[j] + share * delta[j];
            if (finds_near(q.data(), ahead)) return true;
            const double around = std::min(clear_around(), 1.0) * count, at = share * count;
            if (around > 0.0)
                for (int k = std::max(0, static_cast<int>(std::ceil(at - around))); k <= count && k <= at + around; ++k)
                    clear[k] = 1;
            return false;
        };
        if (is_near(1.0) || is_near(0.5)) return false;
        int stride = 1;
        while (2 * stride < count) stride *= 2;
        for (; stride > 0; stride /= 2)  // far apart first, as contacts are contiguous
            for (int k = stride; k < count; k += 2 * stride)
                if (!clear[k] && is_near(k / double(count))) return false;
        return true;
    }

   private:
    bool touches(int pair) {
        Vec& apart = apart_[pair];
        if (!guessed_[pair]) apart = world_.between_middles(pair, scratch_.frames.data()), guessed_[pair] = 1;
        return !(world_.close(pair, scratch_.frames.data(), apart, {world_.margin + rounding}) > world_.margin);
    }

    // The share of the motion around the last state that is certainly clear.
    double clear_around() const {
        const int obstacles = world_.obstacles(), scene = world_.bodies * obstacles;
        double around = infinity;
        const auto keep = [&](int pair, double motion) {
            if (motion == 0.0) return;  // the distance is the same all along
            const double gap = std::min(bounds_[pair], world_.margin + ahead) - world_.margin - 10.0 * clearly;
            around = std::min(around, std::max(gap, 0.0) / motion);
        };
        for (int b = 0; b < world_.bodies; ++b)
            for (int o = 0; o < obstacles; ++o) keep(b * obstacles + o, motion_[b]);
        for (int p = scene; p < world_.pair_count(); ++p) keep(p, motion_[world_.bodies + p - scene]);
        return around;
    }

    const World& world_;
    Scratch scratch_;
    std::vector<double> bounds_, enough_, least_,
        motion_;  // m, largest motion of bodies, and of pairs of bodies
    std::vector<uint8_t> far_;
    std::vector<Vec> apart_;  // vectors between the two of a pair, once computed
    std::vector<uint8_t> guessed_;
    int suspect_ = -1;
};

}  // namespace planner
