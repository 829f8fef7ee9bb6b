// Two trees that grow towards each other until a motion joins them, on motions that look free.
//
// RRTConnect (Kuffner and LaValle 2000) that grows the smaller tree, with dynamic domains (Yershova, Jaillet, Simeon and
// LaValle 2005): only nearby states extend a node with a refused motion. In cages and shelves that takes a tenth of the
// motions.
#pragma once

#include "state_check.hpp"

namespace planner {

// States by joint, so that distances are computed several at a time.
class SearchTree {
   public:
    SearchTree(int dof, const uint8_t* wraps) : dof_(dof), wraps_(wraps), joints_(dof) {}

    void add(const double* q, int parent) {
        for (int j = 0; j < dof_; ++j) joints_[j].push_back(q[j]);
        parents.push_back(parent), domains.push_back(infinity);
    }

    int size() const { return static_cast<int>(parents.size()); }

    void state(int node, double* q) const {
        for (int j = 0; j < dof_; ++j) q[j] = joints_[j][node];
    }

    // The node nearest to a state, the first of equal ones, and the square of its distance.
    int nearest(const double* q, double& square) {
        squares_.assign(parents.size(), 0.0);
        for (int j = 0; j < dof_; ++j) add_squares(joints_[j].data(), size(), q[j], wraps_[j], squares_.data());
        const auto least = std::min_element(squares_.begin(), squares_.end());
        square = *least;
        return static_cast<int>(least - squares_.begin());
    }

    std::vector<int> parents;     // -1 of a root
    std::vector<double> domains;  // rad, largest distance of a state that extends a node

   private:
    FOR_THIS_PROCESSOR static void add_squares(const double* values, int count, double value, bool wraps,
                                               double* squares) {
        for (int k = 0; k < count; ++k) {
            const double apart = std::fabs(values[k] - value), around = 2.0 * M_PI - apart;
            const double shorter = wraps && around < apart ? around : apart;
            squares[k] += shorter * shorter;
        }
    }

    int dof_;
    const uint8_t* wraps_;
    std::vector<std::vector<double>> joints_;
    std::vector<double> squares_;
};

// The sampled box, and conditions on states.
struct SearchSpace {
    const double *lower, *upper;  // (dof,) sampled box
    const uint8_t* wraps;         // (dof,) joints whose values are angles from -pi to pi
    double longest;               // rad, largest length from a root of one tree over a state to one of the other
    double floor;                 // of manipulability, or 0
    double floor_apart;           // rad between samples of manipulability
    const std::vector<ToolPoint>& tools;
    JacobianRows rows;
};

class TreeSearch {
   public:
    TreeSearch(const World& world, const Bounds& bounds, const SearchSpace& space, double step, double look_apart,
               uint64_t seed)
        : world_(world), bounds_(bounds), space_(space), step_(step), look_apart_(look_apart), random_(seed),
          dof_(world.chain.dof()), glance_(world), four_(world.chain), drawn_(dof_), end_(dof_), delta_(dof_),
          from_(dof_), to_(dof_), trees_{SearchTree(dof_, space.wraps), SearchTree(dof_, space.wraps)} {}

    // The states (., dof) of a path from one of `starts` to one of `goals`, or none after `limit` checked motions, or after
    // many samples without a motion.
    std::vector<double> path(const double* starts, int start_count, const double* goals, int goal_count, int limit) {
        for (int k = 0; k < start_count; ++k) trees_[0].add(starts + k * dof_, -1);
        for (int k = 0; k < goal_count; ++k) trees_[1].add(goals + k * dof_, -1);
        roots_[0] = start_count, roots_[1] = goal_count;
        int grows = 1;
        for (int64_t round = 0; looked_at < limit && round < int64_t{draws_per_motion} * limit; ++round) {
            if (poll_signal() == Signal::finish) break;
            if (trees_[grows].size() >= trees_[1 - grows].size()) grows = 1 - grows;
            const int fresh = grow(grows);
            if (fresh < 0) continue;
            const int met = reach_out(1 - grows, trees_[grows], fresh, limit);
            if (met >= 0) return grows == 0 ? join_trees(fresh, met) : join_trees(met, fresh);
        }
        return {};
    }

    int looked_at = 0;  // motions

   private:
    static constexpr int draws_per_motion = 20;
    static constexpr double domain_in_steps = 5.0;  // of a node with a refused motion
    static constexpr double domain_change = 1e-4;   // relative, per motion of such a node

    // Extend one tree by a step towards a sample; returns the new node, or -1.
    int grow(int which) {
        SearchTree& tree = trees_[which];
        for (int j = 0; j < dof_; ++j) drawn_[j] = space_.lower[j] + (space_.upper[j] - space_.lower[j]) * draw_share();
        double square = 0.0;
        const int node = tree.nearest(drawn_.data(), square);
        const double domain = tree.domains[node];
        if (square > domain * domain || square == 0.0) return -1;
        bool there = false;
        const int fresh = step_to(which, node, drawn_.data(), there);
        if (fresh >= 0)
            tree.domains[node] = (1.0 + domain_change) * domain;  // infinite before a refusal
        else if (domain == infinity)
            tree.domains[node] = domain_in_steps * step_;
        else
            tree.domains[node] = std::max((1.0 - domain_change) * domain, step_);
        return fresh;
    }

    // Extend one tree towards a node of the other; returns the node there, or -1.
    int reach_out(int which, const SearchTree& other, int target, int limit) {
        std::vector<double> goal(dof_);
        other.state(target, goal.data());
        double square = 0.0;
        int node = trees_[which].nearest(goal.data(), square);
        bool there = square == 0.0;
        while (!there && node >= 0 && looked_at < limit) node = step_to(which, node, goal.data(), there);
        return there ? node : -1;
    }

    // Add the state a step from a node towards `target`, or a nearer `target`; returns its node, or -1 if refused. `there`
    // is set if it is the target.
    int step_to(int which, int node, const double* target, bool& there) {
        SearchTree& tree = trees_[which];
        tree.state(node, from_.data());
        double square = 0.0;
        for (int j = 0; j < dof_; ++j) {
            delta_[j] = shorter(target[j] - from_[j], j);
            square += delta_[j] * delta_[j];
        }
        const double apart = std::sqrt(square), share = apart > step_ ? step_ / apart : 1.0;
        for (int j = 0; j < dof_; ++j) {
            delta_[j] *= share;
            end_[j] = share < 1.0 ? shorter(from_[j] + delta_[j], j) : target[j];
        }
        ++looked_at;
        there = false;
        if (!within_longest() || !glance_.looks_free(from_.data(), delta_.data(), bounds_, look_apart_) ||
            !above_floor(share * apart))
            return -1;
        there = share == 1.0;
        tree.add(end_.data(), node);
        return tree.size() - 1;
    }

    bool within_longest() {
        if (space_.longest == infinity) return true;
        double sum = 0.0;
        for (int which = 0; which < 2; ++which) {
            double least = infinity;
            for (int root = 0; root < roots_[which]; ++root) {
                double square = 0.0;
                trees_[which].state(root, to_.data());
                for (int j = 0; j < dof_; ++j) {
                    const double apart = shorter(to_[j] - end_[j], j);
                    square += apart * apart;
                }
                least = std::min(least, square);
            }
            sum += std::sqrt(least);
        }
        return sum <= space_.longest;
    }

    // Whether samples of manipulability are above the floor along the motion of `length` (rad).
    bool above_floor(double length) {
        if (!(space_.floor > 0.0)) return true;
        require(length / space_.floor_apart <= INT32_MAX / 4,
                "a motion is too long to be looked at in such short steps");
        const int count = std::max(1, static_cast<int>(std::ceil(length / space_.floor_apart)));
        for (int first = 0; first <= count; first += 4) {
            for (int lane = 0; lane < 4; ++lane) {
                const double share = std::min(first + lane, count) / double(count);
                for (int j = 0; j < dof_; ++j) four_.q[j][lane] = from_[j] + share * delta_[j];
            }
            double w[4];
            manipulability_of_four(world_.chain, space_.tools, space_.rows, four_, w);
            for (const double one : w)
                if (!(one >= space_.floor)) return false;
        }
        return true;
    }

    // The path through the first tree to `first`, and from the equal state `last` through the second tree.
    std::vector<double> join_trees(int first, int last) {
        std::vector<double> states, q(dof_);
        std::vector<int> up;
        for (int node = first; node >= 0; node = trees_[0].parents[node]) up.push_back(node);
        const auto take = [&](const SearchTree& tree, int node) {
            tree.state(node, q.data());
            states.insert(states.end(), q.begin(), q.end());
        };
        for (size_t k = up.size(); k-- > 0;) take(trees_[0], up[k]);
        for (int node = trees_[1].parents[last]; node >= 0; node = trees_[1].parents[node]) take(trees_[1], node);
        return states;
    }

    // An angle, or difference of angles, reduced to half a turn for joints that wrap.
    double shorter(double angle, int joint) const {
        if (!space_.wraps[joint] || std::fabs(angle) <= M_PI) return angle;
        return angle > 0.0 ? angle - 2.0 * M_PI : angle + 2.0 * M_PI;
    }

    // The next uniform number in [0, 1], the same on every machine (SplitMix64: Steele and others 2014).
    double draw_share() {
        uint64_t mixed = random_ += 0x9E3779B97F4A7C15u;
        mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9u;
        mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBu;
        return static_cast<double>((mixed ^ (mixed >> 31)) >> 11) * 0x1p-53;
    }

    const World& world_;
    const Bounds& bounds_;
    const SearchSpace space_;
    const double step_, look_apart_;
    uint64_t random_;
    const int dof_;
    StateCheck glance_;
    FourScratch four_;
    std::vector<double> drawn_, end_, delta_, from_, to_;
    SearchTree trees_[2];
    int roots_[2] = {0, 0};
};

}  // namespace planner
