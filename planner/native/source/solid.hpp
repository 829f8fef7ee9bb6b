// Shapes to be measured: a convex set, or the triangles of a mesh in a tree of balls.
#pragma once

#include <array>
#include <memory>
#include <numeric>
#include <vector>

#include "convex.hpp"

namespace planner {

// A box with rounded edges, or a cylinder along its z; `to_local` takes world coordinates to its own.
struct Target {
    Frame to_local;
    Vec half;       // of a cylinder: its radius in x, half its length in z
    double radius;  // of the rounding
    bool is_cylinder;

    // The radius of a ball around its middle.
    double size() const { return (is_cylinder ? std::hypot(half.x, half.z) : length(half)) + radius; }
};

// A target in the world that is given in a frame.
inline Target carried(const Target& target, const Frame& frame) {
    Target placed = target;
    placed.to_local = target.to_local * inverse(frame);
    return placed;
}

// Distances (m) of `count` spheres from a target: below zero where the middle lies within the rounding or the radius.
FOR_THIS_PROCESSOR inline void distances_to(const Target& target, const double* x, const double* y, const double* z,
                                            const double* radii, int count, double* gaps) {
    const double* m = target.to_local.turn.m;
    const Vec shift = target.to_local.shift, half = target.half;
    if (target.is_cylinder) {
        for (int k = 0; k < count; ++k) {
            double u = m[0] * x[k] + m[1] * y[k] + m[2] * z[k] + shift.x;
            double v = m[3] * x[k] + m[4] * y[k] + m[5] * z[k] + shift.y;
            double w = std::fabs(m[6] * x[k] + m[7] * y[k] + m[8] * z[k] + shift.z) - half.z;
            double across = std::sqrt(u * u + v * v) - half.x;
            w = w > 0.0 ? w : 0.0, across = across > 0.0 ? across : 0.0;
            gaps[k] = std::sqrt(w * w + across * across) - radii[k];
        }
        return;
    }
    for (int k = 0; k < count; ++k) {
        double u = std::fabs(m[0] * x[k] + m[1] * y[k] + m[2] * z[k] + shift.x) - half.x;
        double v = std::fabs(m[3] * x[k] + m[4] * y[k] + m[5] * z[k] + shift.y) - half.y;
        double w = std::fabs(m[6] * x[k] + m[7] * y[k] + m[8] * z[k] + shift.z) - half.z;
        u = u > 0.0 ? u : 0.0, v = v > 0.0 ? v : 0.0, w = w > 0.0 ? w : 0.0;
        gaps[k] = std::sqrt(u * u + v * v + w * w) - target.radius - radii[k];
    }
}

// Part of a solid: a ball that holds it; at the end of a branch the convex set itself.
struct Part {
    Convex ball;     // a point and a radius
    Convex convex;   // of a leaf
    int left = -1, right = -1;
    bool is_leaf() const { return left < 0; }
    const Convex& set() const { return is_leaf() ? convex : ball; }
    double size() const { return ball.radius; }
    Vec middle() const { return ball.only; }
};

// A shape in the frame of what carries it. A mesh that is not convex counts as the surface of its triangles.
struct Solid {
    Convex hull;
    double depth = 0.0;       // m: how deep the surface lies below the hull
    std::vector<Part> parts;  // the first is the whole; one only where the solid is convex
    std::vector<std::unique_ptr<double[]>> kept;  // the points

    bool is_convex() const { return parts.size() == 1; }

    static Solid of_points(const double* points, int count, double radius) {
        Solid solid;
        solid.hull = solid.keep(points, count, radius);
        solid.parts.push_back({solid.ball_around(points, count, radius), solid.hull});
        return solid;
    }

    static Solid of_cylinder(Vec centre, Vec half, Vec across_u, Vec across_v) {
        Solid solid;
        solid.hull.is_cylinder = true;
        solid.hull.centre = centre, solid.hull.half = half;
        solid.hull.across_u = across_u, solid.hull.across_v = across_v;
        Convex ball;
        ball.count = 1, ball.only = centre;
        ball.radius = std::sqrt(dot(half, half) + dot(across_u, across_u)) * (1.0 + 1e-12);
        solid.parts.push_back({ball, solid.hull});
        return solid;
    }

    // The surface of `count` triangles (9 numbers each), rounded by `radius`, with the corners of their hull, and how deep
    // it lies below that.
    static Solid of_triangles(const double* hull_points, int hull_count, const double* triangles, int count,
                              double depth, double radius) {
        Solid solid;
        solid.depth = depth;
        solid.hull = solid.keep(hull_points, hull_count, radius);
        std::vector<int> order(count);
        std::iota(order.begin(), order.end(), 0);
        solid.parts.reserve(2 * count);
        solid.grow(triangles, order.data(), count, radius);
        return solid;
    }

   private:
    Convex keep(const double* points, int count, double radius) {
        kept.push_back(std::make_unique<double[]>(3 * count));
        double* by_axis = kept.back().get();
        for (int k = 0; k < count; ++k)
            for (int axis = 0; axis < 3; ++axis) by_axis[axis * count + k] = points[3 * k + axis];
        Convex set;
        set.points = by_axis, set.count = count, set.radius = radius, set.only = vec_at(points);
        return set;
    }

    static Convex ball_around(const double* points, int count, double radius) {
        Vec low = vec_at(points), high = low;
        for (int k = 1; k < count; ++k) {
            Vec p = vec_at(points + 3 * k);
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        Convex ball;
        ball.count = 1, ball.only = 0.5 * (low + high);
        for (int k = 0; k < count; ++k)
            ball.radius = std::max(ball.radius, length(vec_at(points + 3 * k) - ball.only));
        ball.radius = (ball.radius + radius) * (1.0 + 1e-12);
        return ball;
    }

    // Add the part of these triangles, cut at the median along the axis on which their middles are spread most.
    int grow(const double* triangles, int* order, int count, double radius) {
        heed_at(static_cast<int64_t>(parts.size()));
        std::vector<double> corners;
        for (int k = 0; k < count; ++k)
            corners.insert(corners.end(), triangles + 9 * order[k], triangles + 9 * order[k] + 9);
        int here = static_cast<int>(parts.size());
        parts.push_back({ball_around(corners.data(), 3 * count, radius), Convex()});
        if (count == 1) {
            parts[here].convex = keep(corners.data(), 3, radius);
            return here;
        }
        auto middle = [&](int t, int axis) {
            const double* p = triangles + 9 * t + axis;
            return p[0] + p[3] + p[6];
        };
        int widest = 0;
        double most = -1.0;
        for (int axis = 0; axis < 3; ++axis) {
            double low = infinity, high = -infinity;
            for (int k = 0; k < count; ++k) {
                low = std::min(low, middle(order[k], axis));
                high = std::max(high, middle(order[k], axis));
            }
            if (high - low > most) most = high - low, widest = axis;
        }
        std::stable_sort(order, order + count, [&](int s, int t) { return middle(s, widest) < middle(t, widest); });
        int left = grow(triangles, order, count / 2, radius);
        int right = grow(triangles, order + count / 2, count - count / 2, radius);
        parts[here].left = left, parts[here].right = right;
        return here;
    }
};

// How close a bound on a distance has to be.
struct Closeness {
    double enough = infinity;        // m: larger bounds need not be better
    double hull_enough = infinity;   // m: nor need those between hulls, whatever dents there are below them
};

// A lower bound (m) on the distance of two placed solids, 0 where they touch: a micrometre from it but for what
// `closeness` allows, and short of it by no more than dents are deep where these are farther apart than that.
//
// `apart` is a guess of the vector between them, and is left at the last one that held between the hulls. The balls of
// pairs of parts are asked first, and the parts themselves only where these are nearer than what is known. A ball's
// distance from a `target` that holds b, where there is one, is no more than that from b and takes no search.
inline double solid_gap(const Solid& a, const Frame* at_a, const Solid& b, const Frame* at_b, Vec& apart,
                        Closeness closeness, const Target* target = nullptr) {
    double enough = closeness.enough;
    double whole = convex_gap({&a.hull, at_a}, {&b.hull, at_b}, apart, enough).low;
    if (whole >= enough || whole >= closeness.hull_enough || whole > a.depth + b.depth) return whole;
    if (a.is_convex() && b.is_convex()) return whole;
    enough = std::min(enough, 2.0 * closeness.hull_enough);
    struct Pair {
        int first, second;
        double bound;
    };
    auto world = [](const Frame* at, Vec v) { return at ? *at * v : v; };
    auto bound = [&](int i, int j) {
        const Part &p = a.parts[i], &q = b.parts[j];
        Vec towards = world(at_b, q.middle()) - world(at_a, p.middle());
        double balls = length(towards) - p.size() - q.size();
        if (balls >= enough) return balls;
        if (target && !p.is_leaf()) {
            const Vec middle = world(at_a, p.middle());
            const double size = p.size();
            double gap;
            distances_to(*target, &middle.x, &middle.y, &middle.z, &size, 1, &gap);
            return std::max(balls, gap);
        }
        if (!p.is_leaf() && !q.is_leaf()) return balls;
        return std::max(balls, convex_gap({&p.set(), at_a}, {&q.set(), at_b}, towards, enough).low);
    };
    double least = infinity;
    std::vector<Pair> open{{0, 0, bound(0, 0)}};
    while (!open.empty()) {
        Pair here = open.back();
        open.pop_back();
        if (here.bound >= least) continue;
        const Part &p = a.parts[here.first], &q = b.parts[here.second];
        if (here.bound >= enough || (p.is_leaf() && q.is_leaf())) {
            least = std::max(0.0, here.bound);
            if (least <= 0.0) return 0.0;
            continue;
        }
        bool cut_first = q.is_leaf() || (!p.is_leaf() && p.size() >= q.size());
        Pair one = cut_first ? Pair{p.left, here.second, 0.0} : Pair{here.first, q.left, 0.0};
        Pair two = cut_first ? Pair{p.right, here.second, 0.0} : Pair{here.first, q.right, 0.0};
        one.bound = bound(one.first, one.second), two.bound = bound(two.first, two.second);
        if (one.bound < two.bound) std::swap(one, two);
        open.push_back(one), open.push_back(two);  // the nearer one next
    }
    return std::max(least, whole);
}

}  // namespace planner
