// Proofs that a piece of a joint path is free: adaptive sampling with clearance (Schwarzer, Saha and Latombe 2005).
//
// Where a pair of bodies is d apart, no motion that moves them against each other by less than d can make them touch.
// A joint's motion dq moves a point no further than its distance from the joint's axis times |dq|, so every sample
// clears an interval of the piece; when the intervals of every pair cover it, it is proven for all its configurations.
// Where that does not reach, it is looked at how fast the bodies move at the sample and how much faster around it, see
// speeds.hpp: joints work against each other, so that is a third of it in the mean. Of a box of configurations no
// velocities are known: there the distance near a sample is what it is there and what the joints beyond can add to it.
//
// A sample is taken in the middle m of an interval of half width h. A pair that is d apart there, and whose distance
// changes by no more than r per unit of s anywhere in the interval, is at least d - r |s - m| apart at s. If d >= r h it
// is clear on the whole interval, whatever comes of other pairs: what these leave open is sampled for them alone, after
// the first sample for a handful. What all pairs clear is what the one clears that clears least, so it does not matter
// how much more the others do: pairs are looked at in the order of what coarse bounds clear, the least first, and no
// closer than shows that a pair clears as much as those before it.
#pragma once

#include <algorithm>

#include "pieces.hpp"
#include "refusals.hpp"
#include "speeds.hpp"
#include "world.hpp"

namespace planner {

constexpr double first_motion = 0.7;  // m: first intervals move no point further than this
constexpr double first_journey =
    32.0;  // m: of obstacles that go farther by themselves it is found out where it matters
constexpr double longest_motion = 1e6;   // m: the first intervals of longer ones would take too much memory
constexpr double always_close = 0.03;    // m: pairs that a coarse bound puts nearer get a closer look where it is short
constexpr int close_looks = 8;           // per sample, for pairs that are farther apart: more cost more than halving
constexpr double reported = 5e-3;        // m beyond what covers an interval, so that the clearance reported is worth it
constexpr double hull_is_enough = 0.01;  // m: where hulls are so far apart, dents below them are not looked into

enum Verdict : int64_t { proven_free = 0, collides = 1, undecided = 2 };

// When a piece is run, s: it begins at `begin`, or by at most `slack` earlier or later.
struct Span {
    double begin = 0.0, duration = 0.0, slack = 0.0;

    double at(double s) const { return begin + duration * s; }
    bool holds() const {
        return std::fabs(begin) <= farthest && duration >= 0.0 && duration <= farthest && slack >= 0.0 &&
               slack <= farthest;
    }
};

// What came of one piece.
struct Proof {
    int64_t verdict = proven_free, pair = -1, samples = 0;
    double clearance = infinity;  // m beyond the margin, of the pairs that the piece can move
    double where = 0.0;           // s at which it stopped
    double gap = infinity;        // m beyond the margin that the pair which stopped it has there, or more
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

    // Sample until every interval is cleared, or a pair is left with less than `room` (m) of clearance. With a `span`
    // obstacles move on meanwhile; without one all is as at time 0.
    Proof prove(const Pieces& pieces, int piece, double room, const Span* span = nullptr) {
        Attempt attempt;
        begin(attempt, pieces, piece, span);
        while (!attempt.done()) {
            if (heed() == Told::finish) return attempt.left_open();
            go_on(attempt, room);
        }
        return attempt.proof;
    }

    // A pair that is still to be cleared, and a guess of the vector between its two: where it was at the last sample.
    struct Task {
        int pair;
        bool guessed;
        Vec apart;
    };
    // A part of a piece: its pairs are tasks `first` to `last`, or all of them if `last` is 0. Those next to where a
    // pair was nearest come first: what is not free is met sooner, what is free takes as long.
    struct Interval {
        double low, high, gap;
        int first = 0, last = 0;

        bool operator<(const Interval& other) const { return gap != other.gap ? gap > other.gap : low > other.low; }
    };
    // How far the proof of a piece has come: free once no interval is open.
    struct Attempt {
        Pieces pieces{};
        int piece = 0;
        const Span* span = nullptr;
        bool is_box = false;  // the piece stands for all states in the box that it is a diagonal of: no signs are known
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
        if (!held || leaves_reach(pieces, piece)) {  // no finite numbers, or no reach: nothing is known of such a piece
            attempt.proof.verdict = undecided;
            return;
        }
        const int count = std::max(1, static_cast<int>(std::ceil(motion / first_motion)));
        for (int k = 0; k < count; ++k) {
            const double low = k / double(count), high = (k + 1) / double(count);
            attempt.push({low, high, std::fabs(low + high - 1.0) - 1.0});  // the middle first, both ends last
        }
    }

    // Whether a slide may go farther on a piece than reaches allow for.
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

    // One sample more, in the middle of the first open interval.
    void go_on(Attempt& attempt, double room) {
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
        finish(attempt, here, middle, need, room);
    }

   private:
    // Look closer where it pays, and open what is left of an interval for the pairs that do not cover it.
    void finish(Attempt& attempt, Interval here, double middle, double need, double room) {
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
        if (!(gap_[limit] >= room)) {
            proof.verdict = undecided, proof.pair = tasks_[limit].pair, proof.where = middle;
            proof.gap = gap_[limit] + (keep_[limit] - world_.margin);
            return;
        }
        const int last = static_cast<int>(attempt.tasks.size());
        attempt.push({here.low, middle - reach, gap_[limit], first, last});
        attempt.push({middle + reach, here.high, gap_[limit], first, last});
    }

    // By how much the distance of task k changes at most within x (in s, up to the half width) of the sample: at its rate,
    // or while the obstacle goes all that it can on the interval.
    double needed(size_t k, double x) const { return std::min(rate_[k] * x, flat_rate_[k] * x + extra_[k]); }

    // How far (in s) from the sample task k is clear; nowhere if nothing in the piece moves what touches, or where one of
    // the two is no number.
    double covered(int k) const {
        if (rate_[k] == 0.0) return gap_[k] > 0.0 ? infinity : -1.0;
        const double reach = gap_[k] / rate_[k];
        if (gap_[k] > extra_[k]) return std::max(reach, (gap_[k] - extra_[k]) / flat_rate_[k]);
        return reach == reach ? reach : -infinity;
    }

    // Make bounds better that do not cover `need`, where that is likely to pay: the task that covers least, or -1.
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
            if (!(gap_[k] > 0.0)) break;  // no sample covers anything there
        }
        return limit;
    }

    // The distance of task k by planes, no closer than shows that it is `wanted`.
    void look_at(int k, double wanted) {
        Task& task = tasks_[k];
        if (!task.guessed) task.apart = world_.between_middles(task.pair, scratch_.frames.data()), task.guessed = true;
        const Closeness closeness{wanted + reported + keep_[k], hull_is_enough + keep_[k]};
        const double closer = world_.close(task.pair, scratch_.frames.data(), task.apart, closeness);
        gap_[k] = std::max(gap_[k], closer - keep_[k] - rounding);
    }

    // Metres by which each pair's distance can change per unit of s in [low, high], of all tasks that there are.
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

    // The same, of the tasks at hand.
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

    // What an obstacle's own motion adds to what its pairs need.
    struct Own {
        int64_t of = -1;                   // number of the interval that this is of
        double keep = 0.0, fastest = 0.0;  // m that it may be early or late, m/s
        double extra = infinity;           // m beyond `keep` that it moves away from the sample on the interval
    };

    // What obstacles' own motions add: to the rates, and to the distance to keep as they may be early, late or elsewhere.
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

    // Of an obstacle that moves, looked up once for all of its pairs. Where its speed changes meanwhile it may stay nearer
    // to where it is at the sample than the fastest stretch would take it.
    const Own& own_of(int item, const Span& span, double low, double high) {
        Own& own = own_[item - world_.bodies];
        if (own.of == intervals_) return own;
        own = Own{intervals_};
        const Motion* motion = world_.motion_of(item);
        if (!motion) return own;
        const double soonest = span.at(low) - span.slack, latest = span.at(high) + span.slack;
        const double tick = 4e-16 * std::max(std::fabs(soonest), std::fabs(latest));  // s to which these are rounded
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

    // Make the rate of task k better within `need` (in s) of the sample at `middle`.
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

    // That the arm moves the two of task k against each other by no more than `rate` (m per unit of s).
    void lower_rate(int k, double rate) {
        rate_[k] = std::min(rate_[k], rate + own_rate_[k]);
        flat_rate_[k] = std::min(flat_rate_[k], rate + limited_rate_[k]);
    }

    // How fast bodies move at the sample, and on the interval around it, where that is not known yet.
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

    // How far a body's points are from the axes of the joints that carry it, on average over an interval of `need` from
    // the sample; infinite for other joints. Joints beyond an axis change the distance from it, its own does not.
    const double* reach_here(int body, double need) {
        const int joints = world_.chain.size();
        double* here = here_.data() + static_cast<size_t>(body) * joints;
        if (is_here_[body]) return here;
        is_here_[body] = 1;
        std::fill(here, here + joints, infinity);
        const Item& item = world_.items[body];
        double beyond = 0.0;  // per unit of s, by the joints beyond
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
    std::vector<Task> every_, tasks_;     // all pairs that the piece may move; those of the sample at hand
    std::vector<double> reach_by_joint_;  // (joints, every_)
    Scratch scratch_;
    std::vector<double> coarse_, enough_;               // (pairs,) bounds, and how large they have to be
    std::vector<double> gap_, rate_, own_rate_, keep_;  // per task; own_rate_: an obstacle's; keep_: m, the margin and
                                                        // what is unknown of an obstacle
    std::vector<double> limited_rate_, flat_rate_, extra_;  // per task, see needed(); limited_rate_: of speed limits
    std::vector<Own> own_;                                  // (obstacles,)
    int64_t intervals_ = 0;
    std::vector<double> planned_rate_, joint_rate_, velocity_, bend_, q_;
    Speeds speeds_;
    bool has_speeds_ = false;
    std::vector<Speed> body_speed_;  // of those that has_speed_
    std::vector<char> has_speed_;
    std::vector<double> here_;  // (bodies, joints) reach_here, of those that is_here_
    std::vector<char> is_here_;
    std::vector<std::pair<double, int>> short_;
};

}  // namespace planner
