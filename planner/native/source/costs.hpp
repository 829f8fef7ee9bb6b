// Costs of straight motions: length, and the integral of the manipulability cost omega.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "kinematics.hpp"
#include "refusals.hpp"

namespace planner {

// The cost omega of manipulability w: 1 up to `low`, zeta from `high`, and between them affine in 1 / w (kind 0), -ln w
// (1) or -w (2). It uses libm's logarithm, as the last bits of NumPy's differ between processors.
struct Omega {
    double low, high, zeta;
    int kind;

    void fill(int64_t n, const double* w, double* costs) const {
        const auto by = [&](auto decreasing) {
            const double best = decreasing(high), worst = decreasing(low),
                         span = worst > best ? worst - best : HUGE_VAL;
            for (int64_t k = 0; k < n; ++k) {
                const double share = (decreasing(std::min(std::max(w[k], low), high)) - best) / span;
                costs[k] = zeta + (1.0 - zeta) * std::min(std::max(share, 0.0), 1.0);
            }
        };
        if (kind == 0) by([](double x) { return 1.0 / x; });
        if (kind == 1) by([](double x) { return -std::log(x); });
        if (kind == 2) by([](double x) { return -x; });
    }
};

// Another measure than manipulability: values w (n,) of configurations q (n, dof).
struct Measure {
    virtual ~Measure() = default;
    virtual void fill(size_t n, const double* q, double* w) const = 0;
};

// Points on joints, the selected rows of their Jacobians, and another measure, or null.
struct Tools {
    std::vector<ToolPoint> points;
    JacobianRows rows;
    const Measure* measure = nullptr;
};

// Length of the tool's path while q moves straight from `from` by `by` (dof,): chords between `pieces` + 1 evenly spaced
// states.
inline double path_length(const Chain& chain, int last, const Vec& point, const double* from, const double* by,
                          int64_t pieces, FourScratch& scratch) {
    double sum = 0.0;
    Vec before, here[4];
    for (int64_t first = 0; first <= pieces; first += 4) {
        poll_signal_at(first);
        for (int l = 0; l < 4; ++l) {
            const double s = static_cast<double>(first + l) / static_cast<double>(pieces);
            for (int j = 0; j < chain.dof(); ++j) scratch.q[j][l] = from[j] + s * by[j];
        }
        points_of_four(chain, last, point, scratch, here);
        for (int64_t piece = first; piece <= std::min(first + 3, pieces); ++piece) {
            if (piece > 0) sum += length(here[piece - first] - before);
            before = here[piece - first];
        }
    }
    return sum;
}

// Parameters of the cost; see MotionCost in Python.
struct Prices {
    Omega omega;
    double unit;  // of length, the divisor
    double beta, floor, longest, spacing;
    double chord;  // of the tools' paths; 0 for the length in joint space
    int fewest;    // fewest states per motion
    bool at_end;   // omega of the last state, not the mean
    const uint8_t* wraps;

    bool asks_w() const { return beta < 1.0 || floor > 0.0; }
};

constexpr int most_doublings = 7;  // of the states on longer motions

// Costs of straight motions, several at a time.
class Pricing {
   public:
    Pricing(const Chain& chain, const Tools& tools, const Prices& prices)
        : chain_(chain), tools_(tools), prices_(prices), scratch_(chain) {}

    // Costs (count,) of motions from start to end (count, dof).
    void price(int count, const double* start, const double* end, double* costs) {
        const int dof = chain_.dof();
        asked_.clear(), states_.clear();
        for (int k = 0; k < count; ++k) {
            const double *a = start + static_cast<size_t>(k) * dof, *b = end + static_cast<size_t>(k) * dof;
            double square = 0.0;
            bool allowed = true;
            for (int j = 0; j < dof; ++j) {
                const double by = b[j] - a[j];
                square += by * by;
                allowed = allowed && !(prices_.wraps[j] && std::abs(by) > half_turn);
            }
            const double length = std::sqrt(square);
            allowed = allowed && !(prices_.beta < 1.0 && length > prices_.longest);
            const double distance = (allowed && prices_.chord > 0.0 ? tool_path(a, b) : length) / prices_.unit;
            costs[k] = allowed ? std::max(distance, prices_.omega.zeta) : HUGE_VAL;
            if (allowed && prices_.asks_w()) ask(k, a, b, length);
        }
        look();
        for (const Asked& one : asked_) costs[one.motion] = weigh(one, costs[one.motion]);
    }

   private:
    struct Asked {
        int motion, states;
        size_t first;  // of its states
    };
    struct State {
        const double *from, *to;
        double share;
    };

    double tool_path(const double* a, const double* b) {
        double turned = 0.0;
        delta_.resize(chain_.dof());
        for (int j = 0; j < chain_.dof(); ++j) turned += std::fabs(delta_[j] = b[j] - a[j]);
        const double pieces = std::max(1.0, std::ceil(turned / prices_.chord));
        require(pieces < INT32_MAX, "a motion is too long to be measured in such short chords");
        double sum = 0.0;
        for (const ToolPoint& tool : tools_.points)
            sum += path_length(chain_, tool.last, tool.point, a, delta_.data(), static_cast<int64_t>(pieces), scratch_);
        return sum;
    }

    void ask(int motion, const double* a, const double* b, double length) {
        int intervals = prices_.fewest - 1;
        double reach = intervals * prices_.spacing;
        for (int level = 0; level < most_doublings && length > reach; ++level) intervals *= 2, reach *= 2.0;
        asked_.push_back({motion, intervals + 1, states_.size()});
        const double part = 1.0 / intervals;
        for (int k = 0; k < intervals; ++k) states_.push_back({a, b, k * part});
        states_.push_back({a, b, 1.0});
    }

    // w of all requested states, four at a time.
    void look() {
        const size_t all = states_.size();
        w_.resize(all);
        if (tools_.measure) return look_by_measure();
        for (size_t first = 0; first < all; first += 4) {
            poll_signal_at(static_cast<int>(first));
            const size_t count = std::min<size_t>(4, all - first);
            for (size_t l = 0; l < 4; ++l) {  // repeat the last one
                const State& state = states_[first + std::min(l, count - 1)];
                for (int j = 0; j < chain_.dof(); ++j)
                    scratch_.q[j][l] = state.from[j] + state.share * (state.to[j] - state.from[j]);
            }
            double found[4];
            manipulability_of_four(chain_, tools_.points, tools_.rows, scratch_, found);
            std::copy(found, found + count, w_.data() + first);
        }
    }

    void look_by_measure() {
        const int dof = chain_.dof();
        configurations_.clear();
        for (const State& state : states_)
            for (int j = 0; j < dof; ++j)
                configurations_.push_back(state.from[j] + state.share * (state.to[j] - state.from[j]));
        if (!states_.empty()) tools_.measure->fill(states_.size(), configurations_.data(), w_.data());
    }

    double weigh(const Asked& one, double distance) {
        const double* w = w_.data() + one.first;
        if (prices_.floor > 0.0 && *std::min_element(w, w + one.states) < prices_.floor) return HUGE_VAL;
        if (prices_.beta >= 1.0) return distance;
        omega_.resize(one.states);
        double omega = 0.0;
        if (prices_.at_end) {
            prices_.omega.fill(1, w + one.states - 1, &omega);
        } else {
            prices_.omega.fill(one.states, w, omega_.data());
            omega = mean(one.states) * distance;
        }
        return (1.0 - prices_.beta) * omega + prices_.beta * distance;
    }

    // By Simpson's rule.
    double mean(int states) const {
        const double weights = 3.0 * (states - 1);
        double sum = 0.0;
        for (int k = 0; k < states; ++k) {
            const double weight = k == 0 || k == states - 1 ? 1.0 : k % 2 ? 4.0 : 2.0;
            sum += omega_[k] * (weight / weights);
        }
        return sum;
    }

    const Chain& chain_;
    const Tools tools_;
    const Prices prices_;
    FourScratch scratch_;
    std::vector<Asked> asked_;
    std::vector<State> states_;
    std::vector<double> w_, omega_, delta_, configurations_;
};

}  // namespace planner
