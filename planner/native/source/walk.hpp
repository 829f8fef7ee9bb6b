// Motion of an arm's bodies along joint paths, interval by interval, for evenly spaced samples.
#pragma once

#include "polynomials.hpp"
#include "speeds.hpp"

namespace planner {

class Walk {
   public:
    Walk(const World& world, const Bounds& bounds, const Pieces& pieces)
        : world_(world), reach_(bounds.reach.data()), body_reach_(bounds.body_reach.data()), pieces_(pieces),
          dof_(pieces.dof), speeds_(world, body_reach_), scratch_(world.scratch()), q_(dof_), velocity_(dof_),
          planned_(dof_), rates_(world.chain.size()), bends_(world.chain.size()), fastest_(world.bodies),
          of_body_(world.bodies, 0.0), of_pair_(world.pair_count(), 0.0) {
        bounds.require_of(world);
    }

    // Number of equal intervals of a piece on which joints move no point farther than `longest` (m); can be infinite.
    double parts(int piece, double longest) {
        bound(1, piece, 0.0, 1.0, rates_);
        double motion = 0.0;
        for (int b = 0; b < world_.bodies; ++b) motion = std::max(motion, sum(body_reach_, b));
        return motion <= longest ? 1.0 : std::ceil(motion / longest);
    }

    // Bound (m) on the motion of all points on the interval [low, high].
    double part(int piece, double low, double high) {
        const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
        pieces_.at(piece, middle, q_.data());
        pieces_.velocity(piece, middle, velocity_.data());
        bound(1, piece, low, high, rates_);
        bound(2, piece, low, high, bends_);
        world_.chain.place(q_.data(), scratch_.frames.data());
        world_.place_spheres(scratch_.frames.data(), scratch_);
        speeds_.at(scratch_, velocity_.data(), rates_.data(), bends_.data());
        double fastest = 0.0;
        for (int b = 0; b < world_.bodies; ++b) {
            fastest_[b] = std::min(sum(body_reach_, b), speeds_.of(b).anywhere(half));
            fastest = std::max(fastest, fastest_[b]);
        }
        if (fastest == 0.0) return 0.0;
        for (int b = 0; b < world_.bodies; ++b) of_body_[b] = std::max(of_body_[b], fastest_[b] / fastest);
        for (int pair = world_.bodies * world_.obstacles(); pair < world_.pair_count(); ++pair) {
            const int first = world_.pairs[pair].first, second = world_.pairs[pair].second;
            const double apart = std::min(sum(reach_, pair), fastest_[first] + fastest_[second]);
            double& share = of_pair_[pair];  // the maximum does not depend on the order of intervals
            if (apart / fastest > share)
                share = std::max(share, std::min(apart, speeds_.between(first, second).anywhere(half)) / fastest);
        }
        return fastest * (high - low);
    }

    // Raise `shares` (pairs,) to the largest ratios of a pair's change of distance to the motion of the fastest point, over
    // all intervals so far.
    void raise(double* shares) const {
        const int obstacles = world_.obstacles();
        const auto at_least = [&](int pair, double share) { shares[pair] = std::max(shares[pair], share); };
        for (int pair = 0; pair < world_.bodies * obstacles; ++pair) at_least(pair, of_body_[pair / obstacles]);
        for (int pair = world_.bodies * obstacles; pair < world_.pair_count(); ++pair) at_least(pair, of_pair_[pair]);
    }

   private:
    // Bounds on a derivative of all joints on an interval.
    void bound(int order, int piece, double low, double high, std::vector<double>& all) {
        pieces_.bounds(order, piece, low, high, planned_.data());
        world_.chain.spread(planned_.data(), all.data());
    }

    // Bound on the motion of a row of reaches, per unit of s.
    double sum(const double* reach, int row) const {
        double sum = 0.0;
        for (size_t j = 0; j < rates_.size(); ++j) sum += reach[row * rates_.size() + j] * rates_[j];
        return sum;
    }

    const World& world_;
    const double *reach_, *body_reach_;
    const Pieces pieces_;
    const int dof_;
    Speeds speeds_;
    Scratch scratch_;
    std::vector<double> q_, velocity_, planned_, rates_, bends_, fastest_;
    std::vector<double> of_body_, of_pair_;  // largest shares so far
};

}  // namespace planner
