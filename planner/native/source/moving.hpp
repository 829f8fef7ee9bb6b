// Obstacles that move along known motions.
#pragma once

#include <algorithm>
#include <vector>

#include "convex.hpp"

namespace planner {

// Poses at times: between two poses the origin moves along a line and the frame turns about one axis, at constant rates;
// before the first and after the last pose it rests.
//
// A tree over the stretches returns the largest speed and the bounding box of the origin for a span of time, in
// logarithmic time.
class Motion {
   public:
    struct Stretch {
        double begin, end;  // s
        Frame from;
        Vec velocity;    // m/s
        Vec axis;        // in the frame's own coordinates
        double turning;  // rad/s
        double speed;    // m/s, upper bound of all points of the obstacle
    };

    // `size` (m): largest distance of a point of the obstacle to the frame's origin.
    Motion(std::vector<Stretch> stretches, Frame last, double size)
        : stretches_(std::move(stretches)), last_(last), size_(size), tree_(2 * stretches_.size()) {
        const size_t count = stretches_.size();
        for (size_t k = 0; k < count; ++k) tree_[count + k] = Many(stretches_[k]);
        for (size_t k = count; k-- > 1;) tree_[k] = tree_[2 * k].with(tree_[2 * k + 1]);
    }

    Frame at(double t) const {
        if (stretches_.empty() || t >= stretches_.back().end) return last_;
        const Stretch& here = stretches_[stretch_at(t)];
        const double since = std::max(0.0, t - here.begin);
        return {here.from.turn * about(here.axis, here.turning * since), here.from.shift + since * here.velocity};
    }

    // Whether its rates are constant in [low, high] s.
    bool is_even(double low, double high) const {
        if (stretches_.empty() || low >= stretches_.back().end) return true;
        return high <= stretches_.back().end && stretch_at(low) == stretch_at(high);
    }

    // Largest speed (m/s) of a point in [low, high] s.
    double fastest(double low, double high) const {
        const auto ends_before = [](const Stretch& stretch, double t) { return stretch.end < t; };
        const auto first = std::lower_bound(stretches_.begin(), stretches_.end(), low, ends_before);
        if (first == stretches_.end() || first->begin > high) return 0.0;
        return among(first - stretches_.begin(), stretch_at(high) + 1).speed;
    }

    // Bound (m) on the distance of a point at any time in [low, high] s to its position at t.
    double excursion(double t, double low, double high) const {
        if (stretches_.empty()) return 0.0;
        const size_t first = stretch_at(low), last = stretch_at(high);
        Many there = among(first + 1, last + 1);  // starts and rotations of stretches
        const Vec here = at(t).shift;
        for (double end : {low, high}) there.hold(at(end).shift);
        const auto most = [](double a, double b, double x) { return std::max(std::fabs(a - x), std::fabs(b - x)); };
        const Vec out{most(there.low.x, there.high.x, here.x), most(there.low.y, there.high.y, here.y),
                      most(there.low.z, there.high.z, here.z)};
        const Stretch& begun = stretches_[first];
        const double left = std::max(0.0, begun.end - std::max(low, begun.begin));
        const double turned = there.turned + std::fabs(begun.turning) * left;
        return (length(out) + std::min(turned, 2.0) * size_) * (1.0 + 1e-9) + 1e-10;
    }

   private:
    // Bounds of consecutive stretches.
    struct Many {
        double speed = 0.0, turned = 0.0;                                              // rad
        Vec low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};  // origin at the starts

        Many() = default;
        explicit Many(const Stretch& one)
            : speed(one.speed), turned(std::fabs(one.turning) * (one.end - one.begin)), low(one.from.shift),
              high(one.from.shift) {}
        void hold(Vec p) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        Many with(const Many& other) const {
            Many both = *this;
            both.speed = std::max(speed, other.speed), both.turned += other.turned;
            both.hold(other.low), both.hold(other.high);
            return both;
        }
    };

    // The last stretch that begins before t, or the first one.
    size_t stretch_at(double t) const {
        const auto begins_after = [](double t, const Stretch& stretch) { return t < stretch.begin; };
        const auto next = std::upper_bound(stretches_.begin(), stretches_.end(), t, begins_after);
        return std::max<size_t>(1, next - stretches_.begin()) - 1;
    }

    // Bounds of the stretches [first, last).
    Many among(size_t first, size_t last) const {
        Many found;
        const size_t count = stretches_.size();
        for (first += count, last += count; first < last; first /= 2, last /= 2) {
            if (first % 2) found = found.with(tree_[first++]);
            if (last % 2) found = found.with(tree_[--last]);
        }
        return found;
    }

    // Rodrigues' formula.
    static Mat about(Vec axis, double angle) {
        double sine, versine;
        sines_and_versines(&angle, 1, &sine, &versine);
        Mat cross, turn;
        const double entries[9] = {0, -axis.z, axis.y, axis.z, 0, -axis.x, -axis.y, axis.x, 0};
        std::copy(entries, entries + 9, cross.m);
        const Mat square = cross * cross;
        for (int k = 0; k < 9; ++k) turn.m[k] += sine * cross.m[k] + versine * square.m[k];
        return turn;
    }

    std::vector<Stretch> stretches_;
    Frame last_;
    double size_;
    std::vector<Many> tree_;  // children of node k are 2 k and 2 k + 1; leaves are the stretches
};

}  // namespace planner
