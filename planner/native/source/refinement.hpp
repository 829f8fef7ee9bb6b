// Candidates of path refinement: new positions of waypoints, and stretches on which some joints move evenly. Proofs are
// elsewhere.
#pragma once

#include <numeric>

#include "costs.hpp"

namespace planner {

struct MoveRules {
    double gain;                  // smallest relative gain of a candidate
    const double *lower, *upper;  // (dof,) of joints that do not wrap
    const double* mixes;          // (mixes, 2) shares of a step downhill, and of the way to the middle
    int mix_count, draw_count, most;
};

// Candidates of a waypoint between its neighbours: down the gradient of the cost by finite differences, towards the
// midpoint, and at random near the gradient.
class WaypointMoves {
   public:
    WaypointMoves(const Chain& chain, const Tools& tools, const Prices& prices, const MoveRules& rules)
        : dof_(chain.dof()), pricing_(chain, tools, prices), slopes_(chain, tools, coarse(prices)),
          wraps_(prices.wraps), rules_(rules), downhill_(dof_) {}

    // Write up to `most` positions (most, dof) of the waypoint `here`, the cheapest first; returns their number. `size`
    // (rad) is the step; `draws` (draws, dof + 1) are offsets to the unit direction downhill, and shares of the step.
    int find(const double* here, double size, const double* draws, double* places) {
        look_downhill(here);
        rows_.assign(here, here + dof_);
        price(pricing_, here, 1);
        const double now = costs_[0];
        rows_.clear();
        for (int k = 0; k < rules_.mix_count; ++k) {
            const double step = rules_.mixes[2 * k] * size, middle = rules_.mixes[2 * k + 1];
            add(here, [&](int j) { return step * downhill_[j] + middle * to_middle(here, j); });
        }
        for (int k = 0; k < rules_.draw_count; ++k) {
            const double* own = draws + static_cast<size_t>(k) * (dof_ + 1);
            add(here, [&](int j) { return own[dof_] * size * (downhill_[j] + own[j]); });
        }
        const int count = rules_.mix_count + rules_.draw_count;
        price(pricing_, here, count);
        order_.resize(count);
        std::iota(order_.begin(), order_.end(), 0);
        std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return costs_[a] < costs_[b]; });
        int found = 0;
        for (const int k : order_) {
            if (found == rules_.most || !(costs_[k] < now * (1.0 - rules_.gain))) break;
            std::copy(&rows_[k * static_cast<size_t>(dof_)], &rows_[k * static_cast<size_t>(dof_)] + dof_,
                      places + static_cast<size_t>(found++) * dof_);
        }
        return found;
    }

   private:
    double to_middle(const double* here, int j) const { return 0.5 * (here[j - dof_] + here[j + dof_]) - here[j]; }

    template <class Move>
    void add(const double* here, Move move) {
        for (int j = 0; j < dof_; ++j) {
            const double to = here[j] + move(j);
            rows_.push_back(wraps_[j] ? to : std::min(std::max(to, rules_.lower[j]), rules_.upper[j]));
        }
    }

    // Costs of the two motions through each of `count` rows.
    void price(Pricing& pricing, const double* here, int count) {
        const size_t width = dof_;
        start_.resize(2 * count * width), end_.resize(2 * count * width), both_.resize(2 * count), costs_.resize(count);
        for (int k = 0; k < count; ++k) {
            const double* row = &rows_[k * width];
            std::copy(here - width, here, &start_[2 * k * width]);
            std::copy(row, row + width, &end_[2 * k * width]);
            std::copy(row, row + width, &start_[(2 * k + 1) * width]);
            std::copy(here + width, here + 2 * width, &end_[(2 * k + 1) * width]);
        }
        pricing.price(2 * count, start_.data(), end_.data(), both_.data());
        for (int k = 0; k < count; ++k) costs_[k] = both_[2 * k] + both_[2 * k + 1];
    }

    // Prices for the gradient: w at few states.
    static Prices coarse(Prices prices) {
        constexpr int few = 3;
        prices.spacing *= (prices.fewest - 1.0) / (few - 1.0);
        prices.fewest = few;
        return prices;
    }

    // `downhill_` becomes the unit vector of steepest descent of the cost. At a floor a slope can be infinite; then only the
    // finite slopes count.
    void look_downhill(const double* here) {
        constexpr double far = 1e-3;  // rad
        rows_.assign(here, here + dof_);
        for (int k = 0; k < dof_; ++k)
            for (int j = 0; j < dof_; ++j) rows_.push_back(here[j] + (j == k ? far : 0.0));
        price(slopes_, here, dof_ + 1);
        double square = 0.0;
        for (int j = 0; j < dof_; ++j) {
            const double rise = costs_[1 + j] - costs_[0];
            downhill_[j] = std::isfinite(rise) ? -rise : 0.0;
            square += downhill_[j] * downhill_[j];
        }
        const double norm = std::max(std::sqrt(square), 1e-300);
        for (double& value : downhill_) value /= norm;
    }

    int dof_;
    Pricing pricing_, slopes_;
    const uint8_t* wraps_;
    const MoveRules rules_;
    std::vector<double> downhill_, rows_, start_, end_, both_, costs_;
    std::vector<int> order_;
};

// A stretch (length + 1, dof) of a path with `joints` (dof,) moved by a `share` towards even motion in the arc length of
// all joints.
inline void even_stretch(const double* path, int length, int dof, const uint8_t* joints, double share, double* found) {
    const size_t width = dof;
    std::vector<double> along(length + 1, 0.0);
    for (int k = 1; k <= length; ++k) {
        double square = 0.0;
        for (int j = 0; j < dof; ++j) {
            const double by = path[k * width + j] - path[(k - 1) * width + j];
            square += by * by;
        }
        along[k] = along[k - 1] + std::sqrt(square);
    }
    const double whole = std::max(along[length], 1e-300);
    std::copy(path, path + (length + 1) * width, found);
    for (int k = 1; k < length; ++k)
        for (int j = 0; j < dof; ++j) {
            if (!joints[j]) continue;
            const double even = path[j] + along[k] / whole * (path[length * width + j] - path[j]);
            found[k * width + j] += share * (even - found[k * width + j]);
        }
}

// Tries (tries, count): stretches between rows `ends` (2), on which `joints` (dof,) move by a `share` towards even motion.
// Of each try at most the `most` best stretches with a relative gain above `gain` are candidates.
struct StretchRules {
    int count, most;
    double gain;
    const int64_t* ends;
    const uint8_t* joints;
    const double* share;
};

// The stretches of a try on `path` (n, dof), whose motions have the costs `now` (n - 1,).
class Stretches {
   public:
    std::vector<double> path, now;

    Stretches(const Chain& chain, const Tools& tools, const Prices& prices, const StretchRules& rules, int n)
        : path(static_cast<size_t>(n) * chain.dof()), now(std::max(n - 1, 0)), dof_(chain.dof()), rules_(rules),
          pricing_(chain, tools, prices), states_(rules.count * path.size()), costs_(rules.count * now.size()),
          gains_(rules.count), order_(rules.count) {}

    // The number of candidates of the `attempt`-th try.
    int find(int attempt) {
        before_ = static_cast<size_t>(attempt) * rules_.count;
        for (int k = 0; k < rules_.count; ++k) {
            const int length = length_of(k);
            double *own = &states_[k * path.size()], *costs = &costs_[k * now.size()];
            even_stretch(&path[first_of(k) * dof_], length, dof_, rules_.joints + (before_ + k) * dof_,
                         rules_.share[before_ + k], own);
            pricing_.price(length, own, own + dof_, costs);
            gains_[k] = 0.0;
            for (int i = 0; i < length; ++i) gains_[k] += now[first_of(k) + i] - costs[i];
            if (std::isnan(gains_[k])) gains_[k] = -infinity;  // w is below the floor before and after
        }
        std::iota(order_.begin(), order_.end(), 0);
        std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return gains_[a] > gains_[b]; });
        const double least = rules_.gain * std::accumulate(now.begin(), now.end(), 0.0);
        int worth = 0;
        while (worth < std::min(rules_.most, rules_.count) && gains_[order_[worth]] > least) ++worth;
        return worth;
    }

    // The candidate of a rank: first row, number of motions, states and costs.
    size_t first(int place) const { return first_of(order_[place]); }
    int length(int place) const { return length_of(order_[place]); }
    const double* states(int place) const { return &states_[order_[place] * path.size()]; }
    const double* costs(int place) const { return &costs_[order_[place] * now.size()]; }

   private:
    size_t first_of(int k) const { return static_cast<size_t>(rules_.ends[2 * (before_ + k)]); }
    int length_of(int k) const {
        const int64_t* ends = rules_.ends + 2 * (before_ + k);
        return static_cast<int>(ends[1] - ends[0]);
    }

    int dof_;
    const StretchRules rules_;
    Pricing pricing_;
    std::vector<double> states_, costs_, gains_;
    std::vector<int> order_;
    size_t before_ = 0;
};

}  // namespace planner
