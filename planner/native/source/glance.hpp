// A quick look at states, which proves nothing of what lies between them.
#pragma once

#include "refusals.hpp"
#include "world.hpp"

namespace planner {

constexpr double clearly = 1e-6;  // m beyond the margin, so that no rounding matters

class Glance {
   public:
    explicit Glance(const World& world)
        : world_(world), scratch_(world.scratch()), bounds_(world.pair_count()),
          enough_(world.pair_count(), world.margin + rounding) {
        world.place_moving(0.0, scratch_.frames.data());
    }

    // Whether a pair is not farther apart than the margin at a configuration, or that holds what is no finite number.
    bool finds_near(const double* q) {
        if (!within(q, world_.chain.dof(), farthest)) return true;
        const Frame* frames = scratch_.frames.data();
        world_.chain.place(q, scratch_.frames.data());
        world_.find_far(frames, world_.margin + clearly, least_, far_);
        world_.coarse(frames, scratch_, bounds_.data(), nullptr, enough_.data(), far_.data());
        for (int p = 0; p < world_.pair_count(); ++p) {
            if (bounds_[p] > world_.margin) continue;
            Vec apart = world_.between_middles(p, frames);
            if (!(world_.close(p, frames, apart, {world_.margin + rounding}) > world_.margin)) return true;
        }
        return false;
    }

   private:
    const World& world_;
    Scratch scratch_;
    std::vector<double> bounds_, enough_, least_;
    std::vector<uint8_t> far_;
};

}  // namespace planner
