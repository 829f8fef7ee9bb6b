// Proofs that a piece of a joint path is free: adaptive sampling with clearance (Schwarzer, Saha and Latombe 2005).
//
// Two bodies at distance d cannot touch while their relative motion is less than d. A joint motion dq moves a point by at
// most its distance to the joint's axis times |dq|, so each sample clears an interval of the piece. The piece is proven
// when intervals cover it for every pair. If that bound is too coarse, the prover uses the velocities of the bodies at the
// sample and their change around it, see speeds.hpp: joint motions partly cancel, to a third on average. A box of
// configurations has no velocities; there the distance to an axis near a sample is bounded by the joints beyond.
//
// A sample is the middle m of an interval of half width h. If a pair has distance d there, and the distance changes by at
// most r per unit of s in the interval, it is at least d - r |s - m| at s. If d >= r h the pair is clear on the whole
// interval. The open halves are sampled for the other pairs only, a handful after the first sample. The pair that clears
// least determines the result, so pairs are sorted by coarse bounds, and a closer bound stops when a pair clears as much
// as the pairs before it.
#pragma once

#include <algorithm>

#include "polynomials.hpp"
#include "refusals.hpp"
#include "speeds.hpp"
#include "world.hpp"

namespace planner {

constexpr double first_motion = 0.7;     // m, largest motion of a point in the first intervals
constexpr double first_journey = 32.0;   // m, the same of obstacles; longer motions are refined on demand
constexpr double longest_motion = 1e6;   // m: longer motions need too much memory for intervals
constexpr double always_close = 0.03;    // m, coarse bound below which a closer bound is computed if needed
constexpr int close_looks = 8;           // per sample, for other pairs: more cost more than halving
constexpr double reported = 5e-3;        // m beyond the distance that covers an interval, for the reported clearance
constexpr double hull_is_enough = 0.01;  // m: at larger distances of hulls the surfaces below are not checked

enum Verdict : int64_t { proven_free = 0, collides = 1, undecided = 2 };

// Time span of a piece, s; it begins at `begin`, at most `slack` earlier or later.
struct Span {
    double begin = 0.0, duration = 0.0, slack = 0.0;

    double at(double s) const { return begin + duration * s; }
    bool holds() const {
        return std::fabs(begin) <= farthest && duration >= 0.0 && duration <= farthest && slack >= 0.0 &&
               slack <= farthest;
    }
};

// The result for one piece.
struct Proof {
    int64_t verdict = proven_free, pair = -1, samples = 0;
    double clearance = infinity;  // m beyond the margin, of all moving pairs
    double where = 0.0;           // s of the last sample
    double gap = infinity;        // lower bound (m) beyond the margin of that pair there
};

class Prover {
   public:
    Prover(const World& world, const Bounds& bounds)
        : world_(world), reach_(bounds.reach.data()), body_reach_(bounds.body_reach.data()),
          static_(bounds.is_static.data()), scratch_(world.scratch()), coarse_(world.pair_count()),
          enough_(world.pair_count()), planned_rate_(world.chain.dof()), joint_rate_(world.chain.size()),
          velocity_(world.chain.dof()), bend_(world.chain.size()), q_(world.chain.dof()),
          speeds_(world, bounds.body_reach.data()), here_(static_cast<size_t>(world.bodies) * world.chain.size()),
          is_here_(world.bodies) {
        bounds.require_of(world);
        for (int p = 0; p < world.pair_count(); ++p)
            if (!static_[p] && world.pairs[p].checked) every_.push_back({p, false, {}});
        const int joints = world.chain.size(), count = static_cast<int>(every_.size());
        const size_t rows = world.pairs.size(), bodies = world.bodies;
        require(not_negative(reach_, rows * joints, farthest) && not_negative(body_reach_, bodies * joints, farthest),
                "a reach is no distance");
        reach_by_joint_.resize(static_cast<size_t>(joints) * count);
        for (int j = 0; j < joints; ++j)
            for (int k = 0; k < count; ++k) reach_by_joint_[j * count + k] = reach_[every_[k].pair * joints + j];
        gap_.resize(count), rate_.resize(count), own_rate_.resize(count), keep_.resize(count, world.margin);
        limited_rate_.resize(count), flat_rate_.resize(count), extra_.resize(count, infinity);
        own_.resize(world.obstacles()), body_speed_.resize(world.bodies), has_speed_.resize(world.bodies);
    }

    // Sample until every interval is clear, or the clearance of a pair is below `resolution` (m). With a `span` obstacles
    // move during the piece; without one they are at time 0.
    Proof prove(const Pieces& pieces, int piece, double resolution, const Span* span = nullptr) {
        Attempt attempt;
        begin(attempt, pieces, piece, span);
        while (!attempt.done()) {
            if (poll_signal() == Signal::finish) return attempt.left_open();
            go_on(attempt, resolution);
        }
        return attempt.proof;
    }

    // A pair to clear, and a guess of the vector between its two, from the last sample.
    struct Task {
        int pair;
        bool guessed;
        Vec apart;
    };
    // An interval of a piece with tasks [first, last), or all tasks if `last` is 0. Intervals next to the smallest distance
    // come first, so contacts are found early.
    struct Interval {
        double low, high, gap;
        int first = 0, last = 0;

        bool operator<(const Interval& other) const { return gap != other.gap ? gap > other.gap : low > other.low; }
    };
    // State of the proof of a piece; it is free when no interval is open.
    struct Attempt {
        Pieces pieces{};
        int piece = 0;
        const Span* span = nullptr;
        bool is_box = false;  // the piece is the diagonal of a box of states
        Proof proof;
        std::vector<Interval> open;  // a heap
        std::vector<Task> tasks;

        bool done() const { return open.empty() || proof.verdict != proven_free; }
        double next_gap() const { return open.front().gap; }
        const Proof& left_open() {
            proof.verdict = undecided;
            return proof;
        }
        void push(Interval interval) {
            open.push_back(interval);
            std::push_heap(open.begin(), open.end());
        }
        Interval pop() {
            std::pop_heap(open.begin(), open.end());
            const Interval first = open.back();
            open.pop_back();
            return first;
        }
    };

    void begin(Attempt& attempt, const Pieces& pieces, int piece, const Span* span = nullptr) {
        attempt.pieces = pieces, attempt.piece = piece, attempt.span = span;
        rates_of_all(attempt, 0.0, 1.0);
        double motion = 0.0;
        bool held =
            within(pieces.of(piece), (pieces.degree + size_t{1}) * pieces.dof, farthest) && (!span || span->holds());
        for (size_t k = 0; k < every_.size(); ++k) {
            const double moved = std::min(rate_[k], flat_rate_[k] + 2.0 * extra_[k]);
            held = held && moved <= longest_motion;
            motion = std::max(motion, span ? std::min(moved, flat_rate_[k] + first_journey) : moved);
        }
        if (!held || leaves_reach(pieces, piece)) {  // numbers or reaches are not finite, so nothing is proven
            attempt.proof.verdict = undecided;
            return;
        }
        const int count = std::max(1, static_cast<int>(std::ceil(motion / first_motion)));
        for (int k = 0; k < count; ++k) {
            const double low = k / double(count), high = (k + 1) / double(count);
            attempt.push({low, high, std::fabs(low + high - 1.0) - 1.0});  // middle first, ends last
        }
    }

    // Whether a sliding joint leaves the range for which reaches hold.
    bool leaves_reach(const Pieces& pieces, int piece) const {
        for (size_t j = 0; j < world_.travel.size(); ++j) {
            if (world_.travel[j] == infinity) continue;
            const Joint& joint = world_.chain.joints[j];
            const auto [low, high] = pieces.hull(piece, joint.leader);
            const double one = joint.factor * low + joint.zero, other = joint.factor * high + joint.zero;
            if (std::max(std::fabs(one), std::fabs(other)) > world_.travel[j] + rounding) return true;
        }
        return false;
    }

    // Take a sample in the middle of the first open interval.
    void go_on(Attempt& attempt, double resolution) {
        const Interval here = attempt.pop();
        const double middle = 0.5 * (here.low + here.high), need = 0.5 * (here.high - here.low);
        attempt.pieces.at(attempt.piece, middle, q_.data());
        world_.chain.place(q_.data(), scratch_.frames.data());
        world_.place_moving(attempt.span ? attempt.span->at(middle) : 0.0, scratch_.frames.data());
        ++attempt.proof.samples;
        std::fill(is_here_.begin(), is_here_.end(), 0), has_speeds_ = false;
        if (here.last == 0) {
            tasks_ = every_;
            rates_of_all(attempt, here.low, here.high);
            for (size_t k = 0; k < tasks_.size(); ++k)
                enough_[tasks_[k].pair] = keep_[k] + needed(k, need) + always_close;
            world_.coarse(scratch_.frames.data(), scratch_, coarse_.data(), static_, enough_.data());
            for (size_t k = 0; k < tasks_.size(); ++k) gap_[k] = coarse_[tasks_[k].pair] - keep_[k];
        } else {
            tasks_.assign(attempt.tasks.begin() + here.first, attempt.tasks.begin() + here.last);
            rates_of_tasks(attempt, here.low, here.high);
            world_.place_spheres(scratch_.frames.data(), scratch_);
            for (size_t k = 0; k < tasks_.size(); ++k)
                gap_[k] = world_.coarse_of(tasks_[k].pair, scratch_.frames.data(), scratch_) - keep_[k];
        }
        finish(attempt, here, middle, need, resolution);
    }

   private:
    // Compute closer bounds, and open the rest of an interval for the pairs that do not cover it.
    void finish(Attempt& attempt, Interval here, double middle, double need, double resolution) {
        Proof& proof = attempt.proof;
        const int limit = look_closer(attempt, middle, need);
        const double reach = limit < 0 ? infinity : covered(limit), clear = std::min(reach, need);
        const int first = static_cast<int>(attempt.tasks.size());
        for (size_t k = 0; k < tasks_.size(); ++k) {
            const bool done = gap_[k] >= needed(k, need) && gap_[k] > 0.0;
            proof.clearance = std::min(proof.clearance, gap_[k] - needed(k, done ? need : clear));
            if (!done && reach < need) attempt.tasks.push_back(tasks_[k]);
        }
        if (reach >= need) return;
        if (!(gap_[limit] >= resolution)) {
            proof.verdict = undecided, proof.pair = tasks_[limit].pair, proof.where = middle;
            proof.gap = gap_[limit] + (keep_[limit] - world_.margin);
            return;
        }
        const int last = static_cast<int>(attempt.tasks.size());
        attempt.push({here.low, middle - reach, gap_[limit], first, last});
        attempt.push({middle + reach, here.high, gap_[limit], first, last});
    }

    // Bound on the change of the distance of task k within x (in s, at most the half width) of the sample: by its rate, or
    // by the whole motion of the obstacle on the interval.
    double needed(size_t k, double x) const { return std::min(rate_[k] * x, flat_rate_[k] * x + extra_[k]); }

    // Half width (in s) around the sample on which task k is clear; 0 if a touching pair does not move, or for NaN.
    double covered(int k) const {
        if (rate_[k] == 0.0) return gap_[k] > 0.0 ? infinity : -1.0;
        const double reach = gap_[k] / rate_[k];
        if (gap_[k] > extra_[k]) return std::max(reach, (gap_[k] - extra_[k]) / flat_rate_[k]);
        return reach == reach ? reach : -infinity;
    }

    // Improve bounds that do not cover `need`, if likely to succeed; returns the task that covers least, or -1.
    int look_closer(const Attempt& attempt, double middle, double need) {
        short_.clear();
        for (int k = 0; k < static_cast<int>(tasks_.size()); ++k) {
            if (!(gap_[k] >= needed(k, need))) rate_here(attempt, k, middle, need);
            if (!(gap_[k] >= needed(k, need) && gap_[k] > 0.0)) short_.push_back({covered(k), k});
        }
        std::sort(short_.begin(), short_.end());
        const bool all = static_cast<int>(short_.size()) <= close_looks;
        double least = infinity;
        int limit = -1;
        for (const auto& [bound, k] : short_) {
            const double wanted = needed(k, std::min(need, least));
            if (!(gap_[k] >= wanted && gap_[k] > 0.0))
                if (all || gap_[k] < std::max(always_close, 0.25 * wanted)) look_at(k, wanted);
            const double reach = covered(k);
            if (reach < least) least = reach, limit = k;
            if (!(gap_[k] > 0.0)) break;  // then no sample covers an interval
        }
        return limit;
    }

    // Improve the distance of task k by planes, until it is at least `wanted`.
    void look_at(int k, double wanted) {
        Task& task = tasks_[k];
        if (!task.guessed) task.apart = world_.between_middles(task.pair, scratch_.frames.data()), task.guessed = true;
        const Closeness closeness{wanted + reported + keep_[k], hull_is_enough + keep_[k]};
        const double closer = world_.close(task.pair, scratch_.frames.data(), task.apart, closeness);
        gap_[k] = std::max(gap_[k], closer - keep_[k] - rounding);
    }

    // Bounds (m per unit of s) on the rate of each pair's distance in [low, high], for all tasks.
    void rates_of_all(const Attempt& attempt, double low, double high) {
        bound(attempt, 1, low, high, joint_rate_);
        const int count = static_cast<int>(every_.size());
        std::fill(rate_.begin(), rate_.end(), 0.0);
        for (int j = 0; j < world_.chain.size(); ++j) {
            const double *reach = reach_by_joint_.data() + static_cast<size_t>(j) * count, joint = joint_rate_[j];
            for (int k = 0; k < count; ++k) rate_[k] += reach[k] * joint;
        }
        if (attempt.span) add_obstacles_rates(every_, *attempt.span, low, high);
    }

    // The rates of the current tasks.
    void rates_of_tasks(const Attempt& attempt, double low, double high) {
        bound(attempt, 1, low, high, joint_rate_);
        const int joints = world_.chain.size();
        for (size_t k = 0; k < tasks_.size(); ++k) {
            const double* reach = reach_ + static_cast<size_t>(tasks_[k].pair) * joints;
            rate_[k] = 0.0;
            for (int j = 0; j < joints; ++j) rate_[k] += reach[j] * joint_rate_[j];
        }
        if (attempt.span) add_obstacles_rates(tasks_, *attempt.span, low, high);
    }

    // Bounds on the first or second derivative of all joints in [low, high].
    void bound(const Attempt& attempt, int order, double low, double high, std::vector<double>& all) {
        attempt.pieces.bounds(order, attempt.piece, low, high, planned_rate_.data());
        world_.chain.spread(planned_rate_.data(), all.data());
    }

    // Terms of an obstacle's own motion in the bounds of its pairs.
    struct Own {
        int64_t of = -1;                   // number of its interval
        double keep = 0.0, fastest = 0.0;  // m of uncertainty in time, m/s
        double extra = infinity;           // m beyond `keep` of its motion on the interval
    };

    // Add the obstacles' own motions to the rates, and their uncertainty to the distance to keep.
    void add_obstacles_rates(const std::vector<Task>& tasks, const Span& span, double low, double high) {
        const double latest = std::max(0.0, span.at(0.5 * (low + high)) + span.slack);
        ++intervals_;
        for (size_t k = 0; k < tasks.size(); ++k) {
            const int item = world_.pairs[tasks[k].pair].second;
            own_rate_[k] = limited_rate_[k] = 0.0, keep_[k] = world_.margin, extra_[k] = infinity;
            if (item < world_.bodies) continue;
            const double limit = world_.items[item].speed_limit;
            const Own& own = own_of(item, span, low, high);
            own_rate_[k] = (own.fastest + limit) * span.duration, limited_rate_[k] = limit * span.duration;
            flat_rate_[k] = rate_[k] + limited_rate_[k], extra_[k] = own.extra;
            rate_[k] += own_rate_[k];
            keep_[k] = world_.margin + own.keep + limit * latest;
        }
    }

    // Terms of a moving obstacle, computed once for all its pairs. If its speed changes, the bounding box of its motion can
    // be smaller than the bound by its largest speed.
    const Own& own_of(int item, const Span& span, double low, double high) {
        Own& own = own_[item - world_.bodies];
        if (own.of == intervals_) return own;
        own = Own{intervals_};
        const Motion* motion = world_.motion_of(item);
        if (!motion) return own;
        const double soonest = span.at(low) - span.slack, latest = span.at(high) + span.slack;
        const double tick = 4e-16 * std::max(std::fabs(soonest), std::fabs(latest));  // s, rounding of these
        const double first = soonest - tick, last = latest + tick;
        own.fastest = motion->fastest(first, last), own.keep = own.fastest * span.slack;
        if (own.fastest * tick > rounding) own.keep += own.fastest * tick;
        if (motion->is_even(first, last)) return own;
        const double middle = span.at(0.5 * (low + high)), far = own.fastest * 0.5 * (high - low) * span.duration;
        const double whole = motion->excursion(middle, first, last);
        if (!(whole < (far + own.keep) * (1.0 - 1e-9))) return own;
        const double early = middle - span.slack - tick, late = middle + span.slack + tick;
        if (own.keep > 0.0) own.keep = std::min(own.keep, motion->excursion(middle, early, late));
        own.extra = std::max(0.0, whole - own.keep);
        return own;
    }

    // Improve the rate of task k within `need` (in s) of the sample at `middle`.
    void rate_here(const Attempt& attempt, int k, double middle, double need) {
        const Pair& pair = world_.pairs[tasks_[k].pair];
        const bool is_scene = pair.second >= world_.bodies;
        if (!attempt.is_box) {
            take_speeds(attempt, middle, need);
            const Speed speed = is_scene ? body_speed(pair.first) : speeds_.between(pair.first, pair.second);
            lower_rate(k, speed.anywhere(0.5 * need));
            if (speed.at < infinity) return;
        }
        const int joints = world_.chain.size();
        const double* anywhere = reach_ + static_cast<size_t>(tasks_[k].pair) * joints;
        const double* first = reach_here(pair.first, need);
        const double* second = is_scene ? nullptr : reach_here(pair.second, need);
        double rate = 0.0;
        for (int j = 0; j < joints; ++j) {
            double reach = std::min(anywhere[j], first[j]);
            if (second) reach = std::min(reach, second[j]);
            rate += reach * joint_rate_[j];
        }
        lower_rate(k, rate);
    }

    // Set the bound `rate` (m per unit of s) on the relative motion of task k by the arm.
    void lower_rate(int k, double rate) {
        rate_[k] = std::min(rate_[k], rate + own_rate_[k]);
        flat_rate_[k] = std::min(flat_rate_[k], rate + limited_rate_[k]);
    }

    // Speed of a body at the sample and on the interval around it, computed on demand.
    void take_speeds(const Attempt& attempt, double middle, double need) {
        if (has_speeds_) return;
        has_speeds_ = true;
        attempt.pieces.velocity(attempt.piece, middle, velocity_.data());
        bound(attempt, 2, middle - need, middle + need, bend_);
        speeds_.at(scratch_, velocity_.data(), joint_rate_.data(), bend_.data());
        std::fill(has_speed_.begin(), has_speed_.end(), 0);
    }

    const Speed& body_speed(int body) {
        if (!has_speed_[body]) body_speed_[body] = speeds_.of(body), has_speed_[body] = 1;
        return body_speed_[body];
    }

    // Distances of a body's points to the axes of its joints, averaged over an interval of `need` from the sample; infinite
    // for other joints. Only joints beyond an axis change the distance to it.
    const double* reach_here(int body, double need) {
        const int joints = world_.chain.size();
        double* here = here_.data() + static_cast<size_t>(body) * joints;
        if (is_here_[body]) return here;
        is_here_[body] = 1;
        std::fill(here, here + joints, infinity);
        const Item& item = world_.items[body];
        double beyond = 0.0;  // rate by the joints beyond
        for (int j = item.joint; j > 0; j = world_.chain.joints[j - 1].parent) {
            const double whole = body_reach_[static_cast<size_t>(body) * joints + j - 1];
            double now = 0.0;
            if (world_.chain.joints[j - 1].prismatic) {
                now = 1.0;
            } else {
                const Vec axis = scratch_.frames[j].turn * world_.chain.joints[j - 1].axis,
                          at = scratch_.frames[j].shift;
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

    const World& world_;
    const double* reach_;
    const double* body_reach_;
    const uint8_t* static_;
    std::vector<Task> every_, tasks_;     // all moving pairs; those of the current sample
    std::vector<double> reach_by_joint_;  // (joints, every_)
    Scratch scratch_;
    std::vector<double> coarse_, enough_;               // (pairs,) bounds, and their sufficient size
    std::vector<double> gap_, rate_, own_rate_, keep_;  // per task; own_rate_: an obstacle's; keep_: m, the margin and
                                                        // what is unknown of an obstacle
    std::vector<double> limited_rate_, flat_rate_, extra_;  // per task, see needed(); limited_rate_: of speed limits
    std::vector<Own> own_;                                  // (obstacles,)
    int64_t intervals_ = 0;
    std::vector<double> planned_rate_, joint_rate_, velocity_, bend_, q_;
    Speeds speeds_;
    bool has_speeds_ = false;
    std::vector<Speed> body_speed_;  // valid if has_speed_
    std::vector<char> has_speed_;
    std::vector<double> here_;  // (bodies, joints) reach_here, valid if is_here_
    std::vector<char> is_here_;
    std::vector<std::pair<double, int>> short_;
};

}  // namespace planner
