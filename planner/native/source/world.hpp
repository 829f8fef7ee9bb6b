// A robot among obstacles, and lower bounds on the distances of all checked pairs.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kinematics.hpp"
#include "moving.hpp"
#include "refusals.hpp"
#include "solid.hpp"

namespace planner {

constexpr double rounding = 1e-9;  // m, largest excess of a computed distance

struct Item {
    int joint = -1;            // of a body; -1: an obstacle
    int frame = -1;            // of a body its joint, of a moving obstacle one behind these; -1: the world
    double speed_limit = 0.0;  // m/s of an obstacle with unknown motion from its placement at time 0
    std::shared_ptr<const Solid> solid;
    int first_sphere = 0, spheres = 0;  // of a body
    std::vector<Target> targets;        // of an obstacle: their union contains it
};

struct Pair {
    int first, second;  // numbers of items
    bool checked;
};

// Balls: x, y and z of their middles, and radii.
struct Balls {
    std::vector<double> x, y, z, radius;

    void add(const std::vector<Vec>& middles, const std::vector<double>& radii) {
        Vec middle{0.0, 0.0, 0.0};
        for (const Vec& one : middles) middle = middle + (1.0 / middles.size()) * one;
        double size = 0.0;
        for (size_t k = 0; k < middles.size(); ++k) size = std::max(size, length(middles[k] - middle) + radii[k]);
        x.push_back(middle.x), y.push_back(middle.y), z.push_back(middle.z), radius.push_back(size);
    }

    Vec middle(int k) const { return {x[k], y[k], z[k]}; }
};

// Reduce `least` (balls,) to the squared distance of each ball to a point, less the square of `size` plus radius.
FOR_THIS_PROCESSOR inline void lessen_to_ball(const Balls& balls, const Vec& point, double size, double* least) {
    const double *x = balls.x.data(), *y = balls.y.data(), *z = balls.z.data(), *radius = balls.radius.data();
    for (size_t k = 0; k < balls.x.size(); ++k) {
        const double u = x[k] - point.x, v = y[k] - point.y, w = z[k] - point.z, near = size + radius[k];
        const double excess = u * u + v * v + w * w - near * near;
        least[k] = excess < least[k] ? excess : least[k];
    }
}

// The smallest distance (m) of `count` spheres, from number `first` on, to `others`; minus the sum of radii, a contact, for
// NaN. `gaps` (others,) is working memory.
FOR_THIS_PROCESSOR inline double least_between(const double* x, const double* y, const double* z, const double* radii,
                                               int first, int count, int other, int others, double* gaps) {
    const double *u = x + other, *v = y + other, *w = z + other, *size = radii + other;
    std::fill(gaps, gaps + others, infinity);
    for (int i = first; i < first + count; ++i)
        for (int k = 0; k < others; ++k) {
            const double along = x[i] - u[k], across = y[i] - v[k], up = z[i] - w[k];
            const double square = along * along + across * across + up * up;
            const double gap = std::sqrt(square > 0.0 ? square : 0.0) - (radii[i] + size[k]);
            gaps[k] = gap < gaps[k] ? gap : gaps[k];
        }
    return *std::min_element(gaps, gaps + others);
}

// Write points (count,) of a frame in the world: u, v and w.
FOR_THIS_PROCESSOR inline void place_points(const Frame& frame, int count, const double* x, const double* y,
                                            const double* z, double* __restrict u, double* __restrict v,
                                            double* __restrict w) {
    const Mat turn = frame.turn;
    const Vec shift = frame.shift;
    const double* m = turn.m;
    for (int k = 0; k < count; ++k) {
        u[k] = m[0] * x[k] + m[1] * y[k] + m[2] * z[k] + shift.x;
        v[k] = m[3] * x[k] + m[4] * y[k] + m[5] * z[k] + shift.y;
        w[k] = m[6] * x[k] + m[7] * y[k] + m[8] * z[k] + shift.z;
    }
}

// The minimum of numbers and `least`; four at a time, to shorten dependencies.
inline double least_of(const double* numbers, int count, double least) {
    if (count < 4) {
        for (int k = 0; k < count; ++k) least = std::min(least, numbers[k]);
        return least;
    }
    double of_four[4] = {numbers[0], numbers[1], numbers[2], numbers[3]};
    for (int k = 4; k < count; k += 4) {
        const double* next = numbers + std::min(k, count - 4);
        for (int l = 0; l < 4; ++l) of_four[l] = std::min(of_four[l], next[l]);
    }
    return std::min(least, std::min(std::min(of_four[0], of_four[1]), std::min(of_four[2], of_four[3])));
}

// Working memory of a thread.
struct Scratch {
    std::vector<Frame> frames;
    std::vector<double> x, y, z, gaps, least;
    std::vector<Vec> middles;  // of the bodies
};

class World {
   public:
    Chain chain;
    std::vector<Item> items;     // bodies, then obstacles
    std::vector<int> unchecked;  // pairs without a check
    std::vector<Pair> pairs;     // every body against every obstacle, then self-collision pairs
    std::vector<double> radii, sphere_x, sphere_y, sphere_z;  // of all bodies, in their joints' frames
    std::vector<Motion> motions;       // of obstacles; their frames are behind those of the joints
    Balls body_balls, obstacle_balls;  // one around each; of bodies in their joints' frames
    int bodies = 0;
    double margin = 0.0;
    std::vector<double> travel;  // m (joints,), range of slides in which reaches hold; empty: always

    int obstacles() const { return static_cast<int>(items.size()) - bodies; }
    // Frames of the base, of joints and of moving obstacles.
    size_t frame_count() const { return chain.size() + 1 + motions.size(); }
    int pair_count() const { return static_cast<int>(pairs.size()); }

    const Frame* frame_of(int item, const Frame* frames) const {
        return items[item].frame < 0 ? nullptr : frames + items[item].frame;
    }

    // The motion of an obstacle, or none.
    const Motion* motion_of(int item) const {
        return items[item].joint < 0 && items[item].frame >= 0 ? &motions[items[item].frame - chain.size() - 1]
                                                               : nullptr;
    }

    // Give an obstacle a motion and a frame.
    void let_move(Item& obstacle, Motion motion) {
        motions.push_back(std::move(motion));
        obstacle.frame = chain.size() + static_cast<int>(motions.size());
    }

    // Place the frames of moving obstacles at time t.
    void place_moving(double t, Frame* frames) const {
        for (size_t k = 0; k < motions.size(); ++k) frames[chain.size() + 1 + k] = motions[k].at(t);
    }

    Scratch scratch() const {
        size_t n = radii.size();
        return {std::vector<Frame>(frame_count()),
                std::vector<double>(n),
                std::vector<double>(n),
                std::vector<double>(n),
                std::vector<double>(n),
                std::vector<double>(bodies),
                std::vector<Vec>(bodies)};
    }

    // Compute the ball around every item, and list unchecked pairs; call after the last item.
    void measure() {
        for (int p = 0; p < pair_count(); ++p)
            if (!pairs[p].checked) unchecked.push_back(p);
        for (const Item& item : items) {
            std::vector<Vec> middles;
            std::vector<double> sizes;
            for (int k = item.first_sphere; k < item.first_sphere + item.spheres; ++k)
                middles.push_back({sphere_x[k], sphere_y[k], sphere_z[k]}), sizes.push_back(radii[k]);
            for (const Target& target : item.targets)
                middles.push_back(inverse(target.to_local).shift), sizes.push_back(target.size());
            (item.joint >= 0 ? body_balls : obstacle_balls).add(middles, sizes);
        }
    }

    // Mark obstacles (obstacles,) farther than `apart` (m) from all bodies at placed joints, by their balls; never moving
    // ones. `least` (obstacles,) is working memory.
    void find_far(const Frame* frames, double apart, std::vector<double>& least, std::vector<uint8_t>& far) const {
        least.assign(obstacles(), infinity), far.resize(obstacles());
        for (int b = 0; b < bodies; ++b)
            lessen_to_ball(obstacle_balls, frames[items[b].joint] * body_balls.middle(b), body_balls.radius[b] + apart,
                           least.data());
        for (int o = 0; o < obstacles(); ++o) far[o] = least[o] > 0.0 && items[bodies + o].frame < 0;
    }

    // Place the spheres of all bodies.
    void place_spheres(const Frame* frames, Scratch& s) const {
        for (int b = 0; b < bodies; ++b) {
            const int first = items[b].first_sphere;
            place_points(frames[items[b].joint], items[b].spheres, &sphere_x[first], &sphere_y[first], &sphere_z[first],
                         &s.x[first], &s.y[first], &s.z[first]);
        }
    }

    // Lower bounds (pairs,) on distances at placed joints, by a few spheres per body; infinite for unchecked pairs. Bounds
    // are not computed for obstacles whose pairs are all `left_out` (pairs,), and are coarse for two bodies whose balls are
    // `enough` (pairs,) apart. Obstacles marked `far` (obstacles,) are infinitely far.
    void coarse(const Frame* frames, Scratch& scratch, double* bounds, const uint8_t* left_out = nullptr,
                const double* enough = nullptr, const uint8_t* far = nullptr) const {
        const int count = static_cast<int>(radii.size());
        place_spheres(frames, scratch);
        for (int o = 0; o < obstacles(); ++o) {
            if (left_out && all_of_obstacle(o, left_out)) continue;
            std::fill(scratch.least.begin(), scratch.least.end(), infinity);
            const Frame* frame = frame_of(bodies + o, frames);
            for (const Target& target : items[bodies + o].targets) {
                if (far && far[o]) break;
                distances_to(frame ? transform(target, *frame) : target, scratch.x.data(), scratch.y.data(),
                             scratch.z.data(), radii.data(), count, scratch.gaps.data());
                for (int b = 0; b < bodies; ++b)
                    scratch.least[b] =
                        least_of(scratch.gaps.data() + items[b].first_sphere, items[b].spheres, scratch.least[b]);
            }
            for (int b = 0; b < bodies; ++b) bounds[b * obstacles() + o] = scratch.least[b];
        }
        if (enough)
            for (int b = 0; b < bodies; ++b)
                scratch.middles[b] = frames[items[b].joint] * items[b].solid->parts[0].middle;
        for (int p = bodies * obstacles(); p < pair_count(); ++p) {
            if (left_out && left_out[p]) continue;
            if (enough) bounds[p] = between_balls(pairs[p], scratch);
            if (!enough || !(bounds[p] >= enough[p])) bounds[p] = between_spheres(pairs[p], scratch);
        }
        for (const int p : unchecked) bounds[p] = infinity;
    }

    // The lower bound of one checked pair, for placed spheres.
    double coarse_of(int pair, const Frame* frames, Scratch& scratch) const {
        const Pair& p = pairs[pair];
        if (p.second < bodies) return between_spheres(p, scratch);
        const int first = items[p.first].first_sphere, count = items[p.first].spheres;
        const Frame* frame = frame_of(p.second, frames);
        double least = infinity;
        for (const Target& target : items[p.second].targets) {
            distances_to(frame ? transform(target, *frame) : target, scratch.x.data() + first, scratch.y.data() + first,
                         scratch.z.data() + first, radii.data() + first, count, scratch.gaps.data());
            least = least_of(scratch.gaps.data(), count, least);
        }
        return least;
    }

    // A lower bound (m) on the distance of one pair, see solid_gap; improves the guess `apart` of the vector between them.
    double close(int pair, const Frame* frames, Vec& apart, Closeness closeness) const {
        const Pair& p = pairs[pair];
        const Item &a = items[p.first], &b = items[p.second];
        const Frame* frame = frame_of(p.second, frames);
        if (b.targets.size() != 1)
            return solid_gap(*a.solid, frame_of(p.first, frames), *b.solid, frame, apart, closeness);
        const Target target = frame ? transform(b.targets[0], *frame) : b.targets[0];
        return solid_gap(*a.solid, frame_of(p.first, frames), *b.solid, frame, apart, closeness, &target);
    }

    // A guess of the vector between a pair's two solids.
    Vec between_middles(int pair, const Frame* frames) const {
        auto middle = [&](int item) {
            Vec own = items[item].solid->parts[0].middle;
            const Frame* frame = frame_of(item, frames);
            return frame ? *frame * own : own;
        };
        return middle(pairs[pair].second) - middle(pairs[pair].first);
    }

   private:
    bool all_of_obstacle(int o, const uint8_t* flags) const {
        for (int b = 0; b < bodies; ++b)
            if (!flags[b * obstacles() + o]) return false;
        return true;
    }

    double between_balls(const Pair& pair, const Scratch& s) const {
        const double sizes = items[pair.first].solid->parts[0].size + items[pair.second].solid->parts[0].size;
        return length(s.middles[pair.second] - s.middles[pair.first]) - sizes;
    }

    double between_spheres(const Pair& pair, Scratch& s) const {
        const Item &a = items[pair.first], &b = items[pair.second];
        if (!a.spheres || !b.spheres) return infinity;
        return least_between(s.x.data(), s.y.data(), s.z.data(), radii.data(), a.first_sphere, a.spheres,
                             b.first_sphere, b.spheres, s.gaps.data());
    }
};

// Bounds over all configurations on the change of the distance of pairs (pairs, joints) and the motion of points of bodies
// (bodies, joints) per joint motion; without static pairs.
struct Bounds {
    std::vector<double> reach, body_reach;
    std::vector<uint8_t> is_static;

    void require_of(const World& world) const {
        const size_t joints = world.chain.size(), pairs = world.pair_count();
        require(is_static.size() == pairs && reach.size() == pairs * joints &&
                    body_reach.size() == static_cast<size_t>(world.bodies) * joints,
                "the bounds are those of another world");
    }
};

}  // namespace planner
