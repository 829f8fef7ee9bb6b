// Certain bounds on the distance of two convex sets: any separating plane is a proof.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "vector.hpp"

namespace planner {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Index of the first farthest point along d, of `count` points as x, then y, then z.
FOR_THIS_PROCESSOR inline int first_farthest(const double* points, int count, double dx, double dy, double dz) {
    const double *x = points, *y = points + count, *z = points + 2 * count;
    Four most = {-infinity, -infinity, -infinity, -infinity}, at = {}, here = {0.0, 1.0, 2.0, 3.0};
    int k = 0;
    for (; k + 4 <= count; k += 4, here = here + 4.0) {
        Four u, v, w;
        std::memcpy(&u, x + k, sizeof u), std::memcpy(&v, y + k, sizeof v), std::memcpy(&w, z + k, sizeof w);
        const Four along = u * dx + v * dy + w * dz;
        at = along > most ? here : at;
        most = along > most ? along : most;
    }
    double farthest = -infinity;
    int best = 0;
    for (int l = 0; l < 4; ++l)
        if (most[l] > farthest || (most[l] == farthest && at[l] < best))
            farthest = most[l], best = static_cast<int>(at[l]);
    for (; k < count; ++k) {
        const double along = x[k] * dx + y[k] * dy + z[k] * dz;
        if (along > farthest) farthest = along, best = k;
    }
    return best;
}

// A convex set in its frame: the hull of points, or a cylinder, enlarged by `radius`.
struct Convex {
    const double* points =
        nullptr;  // x of all points, then y, then z; of a cylinder its middle, from there to the middle
                  // of a disc, and its radius in two directions across the axis
    int count = 0;
    bool is_cylinder = false;
    double radius = 0.0;
    Vec only;  // the point if count is 1

    Vec farthest(Vec d) const {
        if (is_cylinder) {
            const Vec centre = vec_at(points), half = vec_at(points + 3);
            const Vec across_u = vec_at(points + 6), across_v = vec_at(points + 9);
            Vec end = dot(d, half) > 0.0 ? centre + half : centre - half;
            double u = dot(d, across_u), v = dot(d, across_v), norm = std::sqrt(u * u + v * v);
            return norm > 0.0 ? end + (u / norm) * across_u + (v / norm) * across_v : end;
        }
        if (count == 1) return only;
        const int best = first_farthest(points, count, d.x, d.y, d.z);
        return {points[best], points[count + best], points[2 * count + best]};
    }
};

// A convex set in the world.
struct Placed {
    const Convex* set;
    const Frame* frame;  // nullptr: the world frame

    Vec farthest(Vec d) const { return frame ? *frame * set->farthest(rotate_back(frame->turn, d)) : set->farthest(d); }
};

// Corners of the difference of two sets, and their weights in the point nearest the origin.
struct Simplex {
    Vec corner[5];
    double weight[5];
    int count = 0;

    bool has(Vec c) const {
        for (int k = 0; k < count; ++k)
            if (corner[k] == c) return true;
        return false;
    }
    Vec point() const {
        Vec sum;
        for (int k = 0; k < count; ++k) sum = sum + weight[k] * corner[k];
        return sum;
    }
};

// Weights, summing to 1, of the point nearest the origin in the affine hull of the corners, by Gram-Schmidt; a linearly
// dependent corner gets weight 0.
inline void nearest_in_flat(const Simplex& s, double* weights) {
    constexpr double thin = 1e-20;  // squared sine below which three corners count as collinear
    Vec fresh[4];
    double square[4], shares[4][4], along[4];
    int side_of[4], rows = 0;
    for (int k = 1; k < s.count; ++k) {
        Vec side = s.corner[k] - s.corner[0], rest = side;
        double share[4];
        for (int r = 0; r < rows; ++r) {
            share[r] = dot(fresh[r], side) / square[r];
            rest = rest - share[r] * fresh[r];
        }
        double size = dot(rest, rest);
        weights[k] = 0.0;
        if (rows < 3 && size > thin * dot(side, side)) {
            fresh[rows] = rest, square[rows] = size, side_of[rows] = k;
            std::copy(share, share + rows, shares[rows]);
            ++rows;
        }
    }
    for (int r = 0; r < rows; ++r) along[r] = -dot(s.corner[0], fresh[r]) / square[r];
    for (int r = rows - 1; r >= 0; --r) {
        weights[side_of[r]] = along[r];
        for (int i = 0; i < r; ++i) along[i] -= shares[r][i] * along[r];
    }
    weights[0] = 1.0;
    for (int k = 1; k < s.count; ++k) weights[0] -= weights[k];
}

// Move to the point nearest the origin in the hull of the corners, and keep the corners that span it. Wolfe (1976): move
// towards the nearest point of the affine hull; at the boundary of the hull drop a corner and repeat.
inline void move_towards_origin(Simplex& s) {
    while (s.count > 1) {
        double best[5];
        nearest_in_flat(s, best);
        if (*std::min_element(best, best + s.count) > 0.0) {
            std::copy(best, best + s.count, s.weight);
            return;
        }
        double share = infinity;
        int dropped = 0;
        for (int k = 0; k < s.count; ++k) {
            if (best[k] > 0.0) continue;
            double here = s.weight[k] > 0.0 ? s.weight[k] / (s.weight[k] - best[k]) : 0.0;
            if (here < share) share = here, dropped = k;
        }
        double total = 0.0;
        int kept = 0;
        for (int k = 0; k < s.count; ++k) {
            if (k == dropped) continue;
            double weight = std::max(0.0, s.weight[k] + share * (best[k] - s.weight[k]));
            s.corner[kept] = s.corner[k], s.weight[kept] = weight, total += weight, ++kept;
        }
        s.count = kept;
        for (int k = 0; k < kept; ++k) s.weight[k] /= total;
    }
    s.weight[0] = 1.0;
}

// Bounds (m) on the distance of two sets; two parallel planes prove `low`.
struct Gap {
    double low, high;
};

// Bounds on the distance of two convex sets, within a micrometre, or until `low` is at least `enough`.
//
// `apart` is a guess of the vector from the first to the second set, and becomes the normal of the best planes. The point
// nearest the origin in a simplex of differences defines the next pair of planes, and their support points the next
// corner (Gilbert, Johnson and Keerthi 1988).
inline Gap convex_gap(Placed a, Placed b, Vec& apart, double enough) {
    constexpr int rounds = 40;
    constexpr double close = 1e-6, touching = 1e-12;  // m
    constexpr double no_direction = 1e-150;           // m: squares of smaller numbers underflow
    const double radius = a.set->radius + b.set->radius;
    double low = 0.0, high = infinity;
    Vec direction = apart;
    Simplex simplex;
    for (int round = 0; round < rounds; ++round) {
        Vec corner = b.farthest(-direction) - a.farthest(direction);
        double size = length(direction), along = dot(corner, direction);
        double between = size > no_direction ? along / size : 0.0;
        if (between > low) low = between, apart = direction;
        if (low - radius >= enough || high - low <= close || simplex.has(corner)) break;
        simplex.corner[simplex.count] = corner;
        simplex.weight[simplex.count] = simplex.count ? 0.0 : 1.0;
        ++simplex.count;
        move_towards_origin(simplex);
        direction = simplex.point();
        high = std::min(high, length(direction));
        if (high <= radius + touching) return {0.0, 0.0};
    }
    return {std::max(0.0, low - radius), std::max(0.0, high - radius)};
}

}  // namespace planner
