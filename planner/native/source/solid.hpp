// Shapes for distances: a convex set, or the triangles of a mesh in a tree of balls.
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

// A target of a frame, in the world.
inline Target transform(const Target& target, const Frame& frame) {
    Target placed = target;
    placed.to_local = target.to_local * inverse(frame);
    return placed;
}

// Distances (m) of `count` spheres to a target; negative if the middle is within the rounding or the radius.
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

// Part of a solid: its bounding ball, and its two halves, or its one triangle. Small, as a mesh has two per triangle.
struct Part {
    Vec middle;
    double size;
    const double* corners = nullptr;  // of the triangle: x of all, then y, then z
    int left = -1, right = -1;
    bool is_leaf() const { return left < 0; }
};

// A shape in its frame. A mesh that is not convex is the surface of its triangles.
struct Solid {
    Convex hull;
    double depth = 0.0;                           // m, largest depth of the surface below the hull
    std::vector<Part> parts;                      // the first is the whole solid; a convex solid has one
    int corners = 3;                              // of each part that is not cut: 1 in a cloud of points, 8 of boxes
    std::vector<std::unique_ptr<double[]>> kept;  // the points

    bool is_convex() const { return parts.size() == 1; }

    // The convex set of a part: its ball, or the content of a leaf.
    Convex set(const Part& part) const {
        if (part.is_leaf() && !part.corners) return hull;
        if (part.is_leaf()) return {part.corners, corners, false, hull.radius, part.middle};
        return {nullptr, 1, false, part.size, part.middle};
    }

    static Solid of_points(const double* points, int count, double radius) {
        Solid solid;
        solid.hull = solid.keep(points, count, radius);
        Box box(points);
        for (int k = 1; k < count; ++k) box.add(points + 3 * k);
        double farthest = 0.0;
        for (int k = 0; k < count; ++k) farthest = std::max(farthest, box.away(points + 3 * k));
        solid.parts.push_back(box.ball(farthest, radius));
        return solid;
    }

    // A cylinder: its middle, from there to a disc, two radii across.
    static Solid of_cylinder(const double* vectors) {
        Solid solid;
        solid.kept.push_back(std::make_unique<double[]>(12));
        std::copy(vectors, vectors + 12, solid.kept.back().get());
        solid.hull.points = solid.kept.back().get(), solid.hull.is_cylinder = true;
        const Vec half = vec_at(vectors + 3), across = vec_at(vectors + 6);
        solid.parts.push_back({vec_at(vectors), std::sqrt(dot(half, half) + dot(across, across)) * (1.0 + 1e-12)});
        return solid;
    }

    // The union of `count` triangles, rounded by `radius`, with the corners of its hull, and its depth below the hull.
    static Solid of_surface(const double* hull_points, int hull_count, const double* triangles, int count, double depth,
                            double radius) {
        Solid solid;
        solid.depth = depth;
        const size_t numbers = 9 * static_cast<size_t>(count);
        solid.hull = solid.keep(hull_points, hull_count, radius);
        solid.parts.reserve(2 * count);
        solid.kept.push_back(std::make_unique<double[]>(numbers));
        std::vector<double> middles;
        for (int axis = 0; axis < 3; ++axis)
            for (const double* p = triangles + axis; p < triangles + numbers; p += 9)
                middles.push_back(p[0] + p[3] + p[6]);
        std::vector<int> order(count);
        std::iota(order.begin(), order.end(), 0);
        std::vector<Ranked> ranked(count);
        Surface{triangles, middles.data(), count, radius, solid.kept.back().get(), ranked.data()}.grow(
            solid, order.data(), count);
        return solid;
    }

    // The axis-aligned box of points, and a ball about its middle.
    struct Box {
        Vec low, high;

        Box() = default;
        explicit Box(const double* point) : low(vec_at(point)), high(low) {}
        void add(const double* point) { add(Box(point)); }
        void add(const Box& other) {
            const Vec p = other.low, q = other.high;
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, q.x), std::max(high.y, q.y), std::max(high.z, q.z)};
        }
        Vec middle() const { return 0.5 * (low + high); }
        // Half sizes of a box about the middle that holds this one, whatever the rounding of the middle.
        Vec half() const {
            const Vec up = high - middle(), down = middle() - low;
            return {std::max(up.x, down.x), std::max(up.y, down.y), std::max(up.z, down.z)};
        }
        // Square of the distance of a point to the middle.
        double away(const double* point) const {
            const Vec out = vec_at(point) - middle();
            return dot(out, out);
        }
        Part ball(double farthest, double radius) const {
            return {middle(), (std::sqrt(farthest) + radius) * (1.0 + 1e-12)};
        }
        // A ball that holds the whole box.
        Part ball(double radius) const { return ball(dot(half(), half()), radius); }
    };

    Convex keep(const double* points, int count, double radius) {
        kept.push_back(std::make_unique<double[]>(3 * count));
        Convex set;
        set.points = by_axis(points, count, kept.back().get()), set.count = count, set.radius = radius;
        set.only = vec_at(points);
        return set;
    }

    // Write points as x, then y, then z.
    static const double* by_axis(const double* points, int count, double* place) {
        for (int k = 0; k < count; ++k)
            for (int axis = 0; axis < 3; ++axis) place[axis * count + k] = points[3 * k + axis];
        return place;
    }

   private:
    struct Ranked {
        double middle;
        int triangle;
    };

    // Triangles that a solid's parts are made of, with three times their middles, axis after axis.
    struct Surface {
        const double* triangles;
        const double* middles;
        int every;
        double radius;
        double* free;    // memory for corners
        Ranked* ranked;  // memory for sorting

        // Add the part of `count` triangles, cut at the median along the axis with the largest spread of their middles.
        int grow(Solid& solid, int* order, int count) {
            poll_signal_at(static_cast<int64_t>(solid.parts.size()));
            const int here = static_cast<int>(solid.parts.size());
            solid.parts.push_back(ball(order, count));
            if (count == 1) {
                solid.parts[here].corners = by_axis(corners_of(order[0]), 3, free);
                free += 9;
                return here;
            }
            const double* middle = middles + static_cast<size_t>(widest(order, count)) * every;
            for (int k = 0; k < count; ++k) ranked[k] = {middle[order[k]], order[k]};
            std::stable_sort(ranked, ranked + count, [](Ranked a, Ranked b) { return a.middle < b.middle; });
            for (int k = 0; k < count; ++k) order[k] = ranked[k].triangle;
            const int left = grow(solid, order, count / 2);
            const int right = grow(solid, order + count / 2, count - count / 2);
            solid.parts[here].left = left, solid.parts[here].right = right;
            return here;
        }

        Part ball(const int* order, int count) const {
            Box box(corners_of(order[0]));
            for_corners(order, count, [&](const double* point) { box.add(point); });
            double farthest = 0.0;
            for_corners(order, count, [&](const double* point) { farthest = std::max(farthest, box.away(point)); });
            return box.ball(farthest, radius);
        }

        template <class Do>
        void for_corners(const int* order, int count, Do act) const {
            for (int k = 0; k < count; ++k)
                for (int corner = 0; corner < 3; ++corner) act(corners_of(order[k]) + 3 * corner);
        }

        const double* corners_of(int triangle) const { return triangles + 9 * static_cast<size_t>(triangle); }

        int widest(const int* order, int count) const {
            int found = 0;
            double most = -1.0;
            for (int axis = 0; axis < 3; ++axis) {
                const double* middle = middles + static_cast<size_t>(axis) * every;
                double low = infinity, high = -infinity;
                for (int k = 0; k < count; ++k)
                    low = std::min(low, middle[order[k]]), high = std::max(high, middle[order[k]]);
                if (high - low > most) most = high - low, found = axis;
            }
            return found;
        }
    };
};

// Required accuracy of a bound on a distance.
struct Closeness {
    double enough = infinity;       // m, sufficient bound
    double hull_enough = infinity;  // m, sufficient bound between hulls
};

// A lower bound (m) on the distance of two placed solids, 0 if they touch; accurate to a micrometre, or as `closeness`
// allows, and to the depth of the surfaces for distant hulls.
//
// `apart` is a guess of the vector between them, and becomes the last one between the hulls. Balls of parts are checked
// first, and parts only if their balls are closer than the current bound. The distance of a ball to a `target` around b,
// if given, is a lower bound without a search.
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
        Vec towards = world(at_b, q.middle) - world(at_a, p.middle);
        double balls = length(towards) - p.size - q.size;
        if (balls >= enough) return balls;
        if (target && !p.is_leaf()) {
            const Vec middle = world(at_a, p.middle);
            double gap;
            distances_to(*target, &middle.x, &middle.y, &middle.z, &p.size, 1, &gap);
            return std::max(balls, gap);
        }
        if (!p.is_leaf() && !q.is_leaf()) return balls;
        const Convex first = a.set(p), second = b.set(q);
        return std::max(balls, convex_gap({&first, at_a}, {&second, at_b}, towards, enough).low);
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
        bool cut_first = q.is_leaf() || (!p.is_leaf() && p.size >= q.size);
        Pair one = cut_first ? Pair{p.left, here.second, 0.0} : Pair{here.first, q.left, 0.0};
        Pair two = cut_first ? Pair{p.right, here.second, 0.0} : Pair{here.first, q.right, 0.0};
        one.bound = bound(one.first, one.second), two.bound = bound(two.first, two.second);
        if (one.bound < two.bound) std::swap(one, two);
        open.push_back(one), open.push_back(two);  // the nearer one is next
    }
    return std::max(least, whole);
}

}  // namespace planner
