// Proofs that a piece of a joint path is free: adaptive sampling with clearance (Schwarzer, Saha and Latombe 2005).
//
// Where a pair of bodies is d apart, no motion that moves them against each other by less than d can make them touch.
// A joint's motion dq moves a point no further than its distance from the joint's axis times |dq|, so every sample
// clears an interval of the piece; when the intervals of every pair cover it, it is proven for all its configurations.
// That distance is at most the body's reach in any configuration, and near a sample at most what it is there and what
// the joints beyond can add to it: an arm that is folded moves its hand half as fast as one that is stretched out.
#pragma once

#include <algorithm>

#include "world.hpp"

namespace planner {

constexpr double first_motion = 0.5;     // m: first intervals move no point further than this
constexpr double always_close = 0.03;    // m: pairs that a coarse bound puts nearer get a closer look where it is short
constexpr int close_looks = 8;           // per sample, for pairs that are farther apart: more cost more than halving
constexpr double reported = 5e-3;        // m beyond what covers an interval, so that the clearance reported is worth it
constexpr double hull_is_enough = 0.01;  // m: where hulls are so far apart, dents below them are not looked into
constexpr double rounding = 1e-9;        // m by which a computed distance may exceed the true one

enum Verdict : int64_t { proven_free = 0, collides = 1, undecided = 2 };

// Polynomial joint paths: q(s) = sum_k c_k s^k, s in [0, 1].
struct Pieces {
    const double* coefficients;  // (count, degree + 1, dof)
    int count, degree, dof;

    const double* of(int piece) const { return coefficients + static_cast<size_t>(piece) * (degree + 1) * dof; }
    void at(int piece, double s, double* q) const {
        const double* c = of(piece);
        for (int j = 0; j < dof; ++j) {
            double value = c[degree * dof + j];
            for (int k = degree - 1; k >= 0; --k) value = value * s + c[k * dof + j];
            q[j] = value;
        }
    }
    // Bounds on |dq_j / ds| over [low, high]: the largest of the derivative's Bernstein coefficients there.
    void rates(int piece, double low, double high, double* rates) const {
        const double* c = of(piece);
        for (int j = 0; j < dof; ++j) {
            if (degree < 2) {
                rates[j] = degree ? std::fabs(c[dof + j]) : 0.0;
                continue;
            }
            double power[16];  // of the derivative, in t from 0 at low to 1 at high
            const int n = degree - 1;
            for (int k = 0; k <= n; ++k) power[k] = (k + 1) * c[(k + 1) * dof + j];
            for (int i = 0; i < n; ++i)
                for (int k = n - 1; k >= i; --k) power[k] += low * power[k + 1];
            double width = 1.0;
            for (int k = 0; k <= n; ++k, width *= high - low) power[k] *= width;
            double most = 0.0, size = 0.0;
            for (int i = 0; i <= n; ++i) {
                double value = 0.0, share = 1.0;  // share: binomial(i, k) / binomial(n, k)
                for (int k = 0; k <= i; ++k) {
                    value += share * power[k];
                    share *= static_cast<double>(i - k) / (n - k > 0 ? n - k : 1);
                }
                most = std::max(most, std::fabs(value));
                size += std::fabs(power[i]);
            }
            rates[j] = most + 1e-14 * size;
        }
    }
};

// When a piece is run, s: it begins at `begin`, or by at most `slack` earlier or later.
struct Span {
    double begin = 0.0, duration = 0.0, slack = 0.0;

    double at(double s) const { return begin + duration * s; }
};

// What came of one piece.
struct Proof {
    int64_t verdict = proven_free, pair = -1, samples = 0;
    double clearance = infinity;  // m beyond the margin, of the pairs that the piece can move
    double where = 0.0;           // s at which it stopped
};

class Prover {
   public:
    // `reach` (pairs, dof) and `body_reach` (bodies, dof) hold in every configuration.
    Prover(const World& world, const double* reach, const double* body_reach, const uint8_t* is_static)
        : world_(world), reach_(reach), body_reach_(body_reach), static_(is_static), scratch_(world.scratch()),
          gap_(world.pair_count()), rate_(world.pair_count()), whole_rate_(world.pair_count()),
          own_rate_(world.pair_count()), keep_(world.pair_count(), world.margin), joint_rate_(world.chain.dof()),
          q_(world.chain.dof()), here_(static_cast<size_t>(world.bodies) * world.chain.dof()), is_here_(world.bodies),
          apart_(world.pair_count()), guessed_(world.pair_count()) {}

    // Sample until every interval is cleared, or a pair is left with less than `room` (m) of clearance. With a `span`
    // obstacles move on meanwhile; without one all is as at time 0.
    Proof prove(const Pieces& pieces, int piece, double room, const Span* span = nullptr) {
        Proof proof;
        span_ = span;
        world_.place_moving(0.0, scratch_.frames.data());
        std::fill(guessed_.begin(), guessed_.end(), 0);
        rates(pieces, piece, 0.0, 1.0);
        double motion = 0.0;
        for (double rate : whole_rate_) motion = std::max(motion, rate);
        int count = std::max(1, static_cast<int>(std::ceil(motion / first_motion)));
        open_.clear();
        for (int k = 0; k < count; ++k) {
            const double low = k / double(count), high = (k + 1) / double(count);
            push({low, high, std::fabs(low + high - 1.0) - 1.0});  // the middle first, both ends last
        }
        while (!open_.empty() && proof.verdict == proven_free) {
            const Interval here = pop();
            if (pieces.degree > 1 || span_) rates(pieces, piece, here.low, here.high);
            sample(pieces, piece, here, room, proof);
        }
        return proof;
    }

   private:
    // Intervals next to where a pair was nearest come first: what is not free is met sooner, what is free takes as long.
    struct Interval {
        double low, high, gap;

        bool operator<(const Interval& other) const { return gap != other.gap ? gap > other.gap : low > other.low; }
    };
    void push(Interval interval) {
        open_.push_back(interval);
        std::push_heap(open_.begin(), open_.end());
    }
    Interval pop() {
        std::pop_heap(open_.begin(), open_.end());
        const Interval first = open_.back();
        open_.pop_back();
        return first;
    }

    // Metres by which each pair's distance can change per unit of s.
    void rates(const Pieces& pieces, int piece, double low, double high) {
        pieces.rates(piece, low, high, joint_rate_.data());
        const int dof = pieces.dof;
        for (int p = 0; p < world_.pair_count(); ++p) {
            double rate = 0.0;
            if (!static_[p])
                for (int j = 0; j < dof; ++j) rate += reach_[p * dof + j] * joint_rate_[j];
            whole_rate_[p] = rate;
        }
        if (span_) add_obstacles_rates(low, high);
    }

    // The same within `need` (in s) of the sample, for one pair.
    void rate_here(int p, double need) {
        const Pair& pair = world_.pairs[p];
        const int dof = world_.chain.dof();
        const double* first = reach_here(pair.first, need);
        const double* second = pair.second < world_.bodies ? reach_here(pair.second, need) : nullptr;
        double rate = own_rate_[p];
        for (int j = 0; j < dof; ++j) {
            double reach = std::min(reach_[p * dof + j], first[j]);
            if (second) reach = std::min(reach, second[j]);
            rate += reach * joint_rate_[j];
        }
        rate_[p] = std::min(rate_[p], rate);
    }

    // How far a body's points are from the axes of the joints that carry it, on average over an interval of `need` from
    // the sample; infinite for other joints. Joints beyond an axis change the distance from it, its own does not.
    const double* reach_here(int body, double need) {
        const int dof = world_.chain.dof();
        double* here = here_.data() + static_cast<size_t>(body) * dof;
        if (is_here_[body]) return here;
        is_here_[body] = 1;
        std::fill(here, here + dof, infinity);
        const Item& item = world_.items[body];
        double beyond = 0.0;  // per unit of s, by the joints beyond
        for (int j = item.joint; j > 0; j = world_.chain.joints[j - 1].parent) {
            const double whole = body_reach_[static_cast<size_t>(body) * dof + j - 1];
            double now = 0.0;
            if (world_.chain.joints[j - 1].prismatic) {
                now = 1.0;
            } else {
                const Vec axis = scratch_.frames[j].turn * world_.chain.joints[j - 1].axis, at = scratch_.frames[j].shift;
                for (int k = item.first_sphere; k < item.first_sphere + item.spheres; ++k) {
                    const Vec out = cross(axis, Vec{scratch_.x[k], scratch_.y[k], scratch_.z[k]} - at);
                    now = std::max(now, length(out) + world_.radii[k]);
                }
            }
            here[j - 1] = std::min(whole, now + 0.5 * beyond * need);
            beyond += joint_rate_[j - 1] * std::min(whole, now + beyond * need);
        }
        return here;
    }

    // What an obstacle's own motion adds: to the rate, and to the distance to keep as it may be early, late or elsewhere.
    void add_obstacles_rates(double low, double high) {
        const double first = span_->at(low) - span_->slack, last = span_->at(high) + span_->slack;
        for (int p = 0; p < world_.bodies * world_.obstacles(); ++p) {
            const int item = world_.pairs[p].second;
            const Motion* motion = world_.motion_of(item);
            const double known = motion ? motion->fastest(first, last) : 0.0, limit = world_.items[item].speed_limit;
            if (static_[p]) continue;
            own_rate_[p] = (known + limit) * span_->duration;
            whole_rate_[p] += own_rate_[p];
            const double latest = span_->at(0.5 * (low + high)) + span_->slack;
            keep_[p] = world_.margin + known * span_->slack + limit * std::max(0.0, latest);
        }
    }

    void sample(const Pieces& pieces, int piece, Interval here, double room, Proof& proof) {
        const double middle = 0.5 * (here.low + here.high), need = 0.5 * (here.high - here.low);
        pieces.at(piece, middle, q_.data());
        world_.chain.place(q_.data(), scratch_.frames.data());
        if (span_) world_.place_moving(span_->at(middle), scratch_.frames.data());
        world_.coarse(scratch_.frames.data(), scratch_, gap_.data(), static_);
        ++proof.samples;
        std::copy(whole_rate_.begin(), whole_rate_.end(), rate_.begin());
        std::fill(is_here_.begin(), is_here_.end(), 0);
        look_closer(need);
        double reach = infinity;
        int limit = -1;
        for (int p = 0; p < world_.pair_count(); ++p) {
            if (static_[p]) continue;
            if (rate_[p] <= 0.0) {
                if (gap_[p] <= 0.0) reach = -1.0, limit = p;  // nothing in this piece moves them apart
            } else if (gap_[p] / rate_[p] < reach) {
                reach = gap_[p] / rate_[p], limit = p;
            }
        }
        const double covered = std::min(reach, need);
        for (int p = 0; p < world_.pair_count(); ++p)
            if (!static_[p]) proof.clearance = std::min(proof.clearance, gap_[p] - rate_[p] * covered);
        if (reach >= need) return;
        if (gap_[limit] < room) {
            proof.verdict = undecided, proof.pair = limit, proof.where = middle;
            return;
        }
        push({here.low, middle - reach, gap_[limit]});
        push({middle + reach, here.high, gap_[limit]});
    }

    // Make bounds that do not cover `need` better where that is likely to pay; all of them less what is to keep.
    void look_closer(double need) {
        short_.clear();
        for (int p = 0; p < world_.pair_count(); ++p) {
            gap_[p] -= keep_[p];
            if (static_[p]) gap_[p] = infinity;
            else if (gap_[p] < rate_[p] * need) rate_here(p, need);
            if (gap_[p] < rate_[p] * need || gap_[p] <= 0.0) short_.push_back(p);
        }
        const bool all = static_cast<int>(short_.size()) <= close_looks;
        for (int p : short_) {
            const double wanted = rate_[p] * need;
            if (!all && gap_[p] >= std::max(always_close, 0.25 * wanted)) continue;
            if (!guessed_[p]) apart_[p] = world_.between_middles(p, scratch_.frames.data()), guessed_[p] = 1;
            const Closeness closeness{wanted + reported + keep_[p], hull_is_enough + keep_[p]};
            const double closer = world_.close(p, scratch_.frames.data(), apart_[p], closeness);
            gap_[p] = std::max(gap_[p], closer - keep_[p] - rounding);
        }
    }

    const World& world_;
    const double* reach_;
    const double* body_reach_;
    const uint8_t* static_;
    Scratch scratch_;
    const Span* span_ = nullptr;
    std::vector<double> gap_, rate_, whole_rate_, own_rate_;  // own_rate_: an obstacle's
    std::vector<double> keep_, joint_rate_, q_;               // keep_: m, the margin and what is unknown of an obstacle
    std::vector<double> here_;                                // (bodies, dof) reach_here, of those that is_here_
    std::vector<char> is_here_;
    std::vector<Vec> apart_;
    std::vector<char> guessed_;
    std::vector<int> short_;
    std::vector<Interval> open_;
};

}  // namespace planner
