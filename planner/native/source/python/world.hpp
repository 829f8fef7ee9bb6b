// Bindings of a robot among obstacles: checks of states, proofs of motions, and searches.
#pragma once

#include <mutex>
#include <numeric>

#include <nanobind/stl/variant.h>

#include "../first_proven.hpp"
#include "../state_check.hpp"
#include "../box_proof.hpp"
#include "../cloud.hpp"
#include "../tree_search.hpp"
#include "../walk.hpp"
#include "robot.hpp"

namespace planner {

// The body or obstacle with a number.
inline Item& item_of(World& world, int item, bool body) {
    require(item >= 0 && item < static_cast<int>(world.items.size()), "there is no such item");
    require((world.items[item].joint >= 0) == body, body ? "the item is no body" : "the item is no obstacle");
    return world.items[item];
}

// Add an item on `joint`, or in the world if negative; bodies come first. Returns its number.
inline int added(World& world, Item item) {
    require(world.pairs.empty(), "items come before the pairs");
    require(item.joint < 0 || world.obstacles() == 0, "bodies come before obstacles");
    require(item.joint <= world.chain.size(), "there is no such joint");
    if (item.joint >= 0) ++world.bodies;
    world.items.push_back(std::move(item));
    return static_cast<int>(world.items.size()) - 1;
}

inline int added(World& world, int joint, Solid solid) {
    Item item;
    item.joint = joint, item.frame = joint;
    item.solid = std::make_shared<const Solid>(std::move(solid));
    return added(world, std::move(item));
}

inline int add_hull(World& world, int joint, const Floats<any, 3>& points, double radius) {
    require(points.count() >= 1 && within(points, points.size(), farthest),
            "a shape has no points, or one is far away");
    require(not_negative(&radius, 1, farthest), "a radius is no distance");
    return added(world, joint, Solid::of_points(points, points.count(), radius));
}

inline int add_cylinder(World& world, int joint, const Floats<3>& middle, const Floats<3>& half,
                        const Floats<2, 3>& across) {
    double points[12];
    std::copy_n(middle.data(), 3, points), std::copy_n(half.data(), 3, points + 3);
    std::copy_n(across.data(), 6, points + 6);
    require(within(points, 12, farthest), "a point is no finite number");
    return added(world, joint, Solid::of_cylinder(points));
}

inline int add_surface(World& world, int joint, const Floats<any, 3>& hull, const Floats<any, 3, 3>& triangles,
                       double depth, double radius) {
    require(hull.count() >= 1 && triangles.count() >= 1, "a surface has at least one triangle");
    require(within(hull, hull.size(), farthest) && within(triangles, triangles.size(), farthest),
            "a triangle is no finite number");
    require(depth >= 0.0 && not_negative(&radius, 1, farthest), "a radius or a depth is no distance");
    return added(world, joint, Solid::of_surface(hull, hull.count(), triangles, triangles.count(), depth, radius));
}

inline int add_cloud(World& world, int joint, const Floats<any, any, 3>& sets, double radius, int boxes) {
    require(sets.size() > 0 && sets.array.shape(0) <= INT32_MAX / 4, "a cloud has from one to 2^29 sets of points");
    require(within(sets, sets.size(), farthest), "a point is no finite number");
    require(not_negative(&radius, 1, farthest) && boxes >= 1, "a radius is no distance, or there is no box");
    CloudBuilder cloud(sets, sets.count(), sets.count(1), radius);
    std::vector<Target> targets = joint < 0 ? cloud.sections(boxes) : std::vector<Target>{};
    const int number = added(world, joint, std::move(cloud.solid));
    world.items[number].targets = std::move(targets);
    return number;
}

// Enlarged by the rounding of distances, so that bounds never exceed the true distance.
inline void add_spheres(World& world, int item, const Floats<any, 3>& centres, const Floats<any>& radii) {
    Item& body = item_of(world, item, true);
    const int n = radii.count();
    require(n >= 1 && body.spheres == 0, "a body has at least one sphere, and all of them at once");
    require(within(centres.of({n, 3}), centres.size(), farthest), "a sphere's middle is no finite number");
    require(not_negative(radii, n, farthest), "a sphere's radius is no distance");
    body.first_sphere = static_cast<int>(world.radii.size()), body.spheres = n;
    for (int k = 0; k < n; ++k) {
        world.sphere_x.push_back(centres[3 * k]), world.sphere_y.push_back(centres[3 * k + 1]);
        world.sphere_z.push_back(centres[3 * k + 2]), world.radii.push_back(radii[k] + rounding);
    }
}

inline int take(World& world, const World& other, int item) {
    require(item >= 0 && item < static_cast<int>(other.items.size()), "there is no such item");
    require(other.chain.size() == world.chain.size(), "the other world is of another arm");
    Item taken = other.items[item];
    if (taken.joint >= 0) {
        const int first = taken.first_sphere, last = first + taken.spheres;
        taken.first_sphere = static_cast<int>(world.radii.size());
        for (int k = first; k < last; ++k) {
            world.sphere_x.push_back(other.sphere_x[k]), world.sphere_y.push_back(other.sphere_y[k]);
            world.sphere_z.push_back(other.sphere_z[k]), world.radii.push_back(other.radii[k]);
        }
    }
    if (const Motion* motion = other.motion_of(item)) world.let_move(taken, *motion);
    return added(world, std::move(taken));
}

inline void set_motion(World& world, int item, const Floats<any>& times, const Floats<any, 3, 3>& turns,
                       const Floats<any, 3>& shifts, const Floats<any, 3>& axes, const Floats<any>& rates,
                       const Floats<any>& speeds, double size) {
    Item& obstacle = item_of(world, item, false);
    const int n = times.count();
    require(n >= 1 && obstacle.frame < 0, "a motion has at least one pose, and an obstacle one motion");
    turns.of({n, 3, 3}), shifts.of({n, 3}), axes.of({n - 1, 3}), rates.of({n - 1}), speeds.of({n - 1});
    require(within(times, n, farthest) && within(turns, turns.size(), farthest) &&
                within(shifts, shifts.size(), farthest) && within(axes, axes.size(), farthest) &&
                within(rates, n - 1, infinity) && not_negative(speeds, n - 1, infinity) &&
                not_negative(&size, 1, farthest),
            "a motion holds what is no finite number");
    std::vector<Motion::Stretch> stretches;
    for (int k = 0; k + 1 < n; ++k) {
        require(times[k] < times[k + 1], "the times of a motion do not increase");
        const Vec from = vec_at(shifts + 3 * k), to = vec_at(shifts + 3 * (k + 1));
        stretches.push_back({times[k], times[k + 1], frame_at(turns, shifts, k),
                             (1.0 / (times[k + 1] - times[k])) * (to - from), vec_at(axes + 3 * k), rates[k],
                             speeds[k]});
    }
    world.let_move(obstacle, Motion(std::move(stretches), frame_at(turns, shifts, n - 1), size));
}

inline void set_speed_limit(World& world, int item, double limit) {
    require(limit >= 0.0 && limit <= farthest, "the speed limit is no speed");
    item_of(world, item, false).speed_limit = limit;
}

inline void set_travel(World& world, const Floats<any>& travel) {
    require(not_negative(travel.of({world.chain.size()}), travel.size(), infinity), "a travel is no distance");
    world.travel.assign(travel + 0, travel + travel.size());
}

inline void add_target(World& world, int item, const Floats<3, 3>& turn, const Floats<3>& shift, const Floats<3>& half,
                       double radius, bool is_cylinder) {
    Item& obstacle = item_of(world, item, false);
    require(within(turn, 9, farthest) && within(shift, 3, farthest), "a placement is no finite number");
    require(not_negative(half, 3, farthest) && not_negative(&radius, 1, farthest), "a size is no distance");
    Target target;
    target.to_local = planner::inverse(frame_at(turn, shift, 0));
    target.half = vec_at(half), target.radius = radius, target.is_cylinder = is_cylinder;
    obstacle.targets.push_back(target);
}

inline void set_pairs(World& world, const Ints<any, 2>& pairs, const Bools& checked) {
    require(world.pairs.empty(), "the pairs are there already");
    const int n = pairs.count(), bodies = world.bodies, obstacles = world.obstacles(), scene = bodies * obstacles;
    checked.of({n});
    for (const Item& item : world.items)
        require(item.joint >= 0 ? item.spheres > 0 : !item.targets.empty(), "an item has nothing that holds it");
    require(n >= scene, "every body is in a pair with every obstacle");
    for (int p = 0; p < n; ++p) {
        const int64_t first = pairs[2 * p], second = pairs[2 * p + 1];
        if (p < scene)
            require(first == p / obstacles && second == bodies + p % obstacles, "the pairs are in another order");
        else
            require(between(pairs + 2 * p, 2, 0, bodies), "there is no such body");
    }
    for (int p = 0; p < n; ++p)
        world.pairs.push_back({static_cast<int>(pairs[2 * p]), static_cast<int>(pairs[2 * p + 1]), checked[p]});
    world.measure();
}

inline Bounds bounds_of(const World& world, const States& reach, const States& body_reach, const Bools& is_static) {
    const int64_t joints = world.chain.size(), pairs = world.pair_count();
    reach.of({pairs, joints}), body_reach.of({world.bodies, joints}), is_static.of({pairs});
    return {{reach + 0, reach + reach.size()},
            {body_reach + 0, body_reach + body_reach.size()},
            {is_static + 0, is_static + pairs}};
}

// Placements of n configurations: rotations and positions of the base and all joints.
struct Placements {
    const Rotations& rotation;
    const Positions& position;
    const size_t frames, n;

    Placements(const World& world, const Rotations& turns, const Positions& shifts)
        : rotation(turns), position(shifts), frames(world.chain.size() + 1), n(turns.count(1)) {
        turns.of({world.chain.size() + 1, any, 3, 3}), shifts.of({world.chain.size() + 1, turns.count(1), 3});
    }
    void at(size_t k, Frame* into) const {
        for (size_t j = 0; j < frames; ++j) into[j] = frame_at(rotation, position, j * n + k);
    }
};

inline Made<double, 2> coarse(const World& world, const Rotations& rotation, const Positions& position) {
    const Placements placed(world, rotation, position);
    Made<double, 2> bounds(placed.n, world.pair_count());
    Scratch scratch = world.scratch();
    for (size_t k = 0; k < placed.n; ++k) {
        poll_signal();
        placed.at(k, scratch.frames.data());
        world.place_moving(0.0, scratch.frames.data());
        world.coarse(scratch.frames.data(), scratch, bounds + k * world.pair_count());
    }
    return bounds;
}

// Close bounds (k,) of pairs, and normals (k, 3) of the best planes between the two hulls.
template <class Keep>
void look_closely(const World& world, const Rotations& rotation, const Positions& position, const Ints<any>& rows,
                  const Ints<any>& pairs, const std::variant<Floats<any>, double>& enough, const Keep& keep) {
    const Placements placed(world, rotation, position);
    const int count = rows.count();
    const auto* each = std::get_if<Floats<any>>(&enough);
    require(between(rows, count, 0, static_cast<int64_t>(placed.n)), "there is no such configuration");
    require(between(pairs.of({count}), count, 0, world.pair_count()), "there is no such pair");
    const auto enough_of = [&](int k) { return each ? (*each)[k] : std::get<double>(enough); };
    if (each) each->of({count});
    for (int k = 0; k < count; ++k) require(enough_of(k) >= 0.0, "what is enough is no distance");
    struct Posed {
        std::vector<Frame> frames;
        int64_t row = -1;
    };
    const auto make = [&] {
        Posed posed{std::vector<Frame>(world.frame_count())};
        world.place_moving(0.0, posed.frames.data());
        return posed;
    };
    constexpr int together = 64;  // checks, of microseconds each for distant pairs
    share_out((count + together - 1) / together, 8, make, [&](int block, Posed& posed) {
        for (int k = block * together; k < std::min(count, (block + 1) * together); ++k) {
            poll_signal();
            if (rows[k] != posed.row) placed.at(posed.row = rows[k], posed.frames.data());
            const int pair = static_cast<int>(pairs[k]);
            Vec apart = world.between_middles(pair, posed.frames.data());
            Closeness closeness;
            closeness.enough = enough_of(k);
            const double bound = world.close(pair, posed.frames.data(), apart, closeness);
            keep(k, bound, apart);
        }
    });
}

inline Made<double, 1> close(const World& world, const Rotations& rotation, const Positions& position,
                             const Ints<any>& rows, const Ints<any>& pairs,
                             const std::variant<Floats<any>, double>& enough) {
    Made<double, 1> bounds(rows.count());
    look_closely(world, rotation, position, rows, pairs, enough,
                 [&](int k, double bound, const Vec&) { bounds[k] = bound; });
    return bounds;
}

inline Made<double, 2> planes(const World& world, const Rotations& rotation, const Positions& position,
                              const Ints<any>& rows, const Ints<any>& pairs,
                              const std::variant<Floats<any>, double>& enough) {
    Made<double, 2> normals(rows.count(), 3);
    look_closely(world, rotation, position, rows, pairs, enough, [&](int k, double, const Vec& apart) {
        normals[3 * k] = apart.x, normals[3 * k + 1] = apart.y, normals[3 * k + 2] = apart.z;
    });
    return normals;
}

// Which points (n,) are within `reach` (m) of a body at placed joints.
inline Made<bool, 1> points_within(const World& world, const Rotations& rotation, const Positions& position,
                                   const Floats<any, 3>& points, double reach) {
    const Placements placed(world, rotation, position);
    require(placed.n == 1 && not_negative(&reach, 1, farthest), "a reach is no distance, or there is no configuration");
    require(within(points, points.size(), farthest), "a point is no finite number");
    std::vector<Frame> frames(world.frame_count());
    placed.at(0, frames.data());
    const int count = points.count(), together = 256;
    Made<bool, 1> near(count);
    const auto is_near = [&](const Item& body, Solid& point) {
        const Vec at = rotate_back(frames[body.joint].turn, point.hull.only - frames[body.joint].shift);
        bool held = false;
        for (int k = body.first_sphere; k < body.first_sphere + body.spheres && !held; ++k)
            held = length(Vec{world.sphere_x[k], world.sphere_y[k], world.sphere_z[k]} - at) <= world.radii[k] + reach;
        Vec apart = point.hull.only - frames[body.joint] * body.solid->parts[0].middle;
        return held && solid_gap(*body.solid, &frames[body.joint], point, nullptr, apart, {reach + rounding}) <= reach;
    };
    share_out((count + together - 1) / together, 4,
              [] { return Solid::of_points(std::array<double, 3>{}.data(), 1, 0.0); },
              [&](int block, Solid& point) {
                  for (int k = block * together; k < std::min(count, (block + 1) * together); ++k) {
                      point.hull.only = point.parts[0].middle = vec_at(points + 3 * k), near[k] = false;
                      for (int b = 0; b < world.bodies && !near[k]; ++b) near[k] = is_near(world.items[b], point);
                  }
              });
    return near;
}

inline int first_near(const World& world, const States& q) {
    const int n = q.of({any, world.chain.dof()}).count();
    StateCheck glance(world);
    for (int k = 0; k < n; ++k, poll_signal())
        if (glance.finds_near(q + static_cast<size_t>(k) * world.chain.dof(), clearly)) return k;
    return n;
}

// Checks of motions on one thread; the world must outlive it.
class Look {
   public:
    Look(const World& world, const Bounds& bounds, double step) : bounds_(bounds), step_(step), glance_(world) {
        require(step > 0.0, "a step is longer than nothing");
        bounds.require_of(world);
    }

    bool operator()(const Floats<any>& start, const Floats<any>& delta) {
        const int dof = glance_.dof();
        require(glance_.fits(), "items and pairs come before the glance");
        return glance_.looks_free(start.of({dof}), delta.of({dof}), bounds_, step_);
    }

   private:
    const Bounds& bounds_;
    const double step_;
    StateCheck glance_;
};

constexpr int64_t most_parts = INT32_MAX / 8;  // of a walk

// Pieces (count, degree + 1, dof) of the world's robot.
inline Pieces pieces_of(const World& world, const Coefficients& coefficients) {
    const Pieces pieces{coefficients, coefficients.of({any, any, world.chain.dof()}).count(), coefficients.count(1) - 1,
                        world.chain.dof()};
    require(pieces.degree >= 0 && pieces.degree <= highest_degree,
            "the pieces are of a higher degree than is supported");
    return pieces;
}

inline void require_memory(double resolution) {
    require(resolution >= rounding, "the resolution is below what distances are rounded by");
}

// Start, duration and tolerance of the start of pieces, s.
using Spans = std::optional<Floats<any, 3>>;

inline std::vector<Span> spans_of(const Spans& spans, int count) {
    std::vector<Span> found;
    if (spans) spans->of({count, 3});
    for (int k = 0; spans && k < count; ++k) {
        const double* row = *spans + 3 * k;
        found.push_back({row[0], row[1], row[2]});
    }
    return found;
}

inline auto prove(const World& world, const Bounds& bounds, const Coefficients& coefficients, double resolution,
                  const Spans& spans) {
    const Pieces pieces = pieces_of(world, coefficients);
    const std::vector<Span> times = spans_of(spans, pieces.count);
    require_memory(resolution);
    const size_t count = pieces.count;
    Made<int64_t, 1> verdict(count), pair(count), samples(count);
    Made<double, 1> clearance(count), where(count);
    share_out(
        pieces.count, 4, [&] { return Prover(world, bounds); },
        [&](int k, Prover& prover) {
            const Proof proof = prover.prove(pieces, k, resolution, spans ? &times[k] : nullptr);
            verdict[k] = proof.verdict, pair[k] = proof.pair, samples[k] = proof.samples;
            clearance[k] = proof.clearance, where[k] = proof.where;
        });
    return std::tuple{std::move(verdict), std::move(pair), std::move(samples), std::move(clearance), std::move(where)};
}

inline std::optional<std::pair<double, int64_t>> prove_motion(const World& world, const Bounds& bounds,
                                                              const Floats<any>& start, const Floats<any>& delta,
                                                              double resolution) {
    const int dof = world.chain.dof();
    require_memory(resolution);
    std::vector<double> piece(start.of({dof}) + 0, start + dof);
    piece.insert(piece.end(), delta.of({dof}) + 0, delta + dof);
    const Proof proof = Prover(world, bounds).prove({piece.data(), 1, 1, dof}, 0, resolution);
    if (proof.verdict != proven_free) return std::nullopt;
    return std::pair{proof.clearance, proof.samples};
}

inline auto prove_together(const World& world, const Bounds& bounds, const Coefficients& coefficients,
                           double resolution, const Spans& spans) {
    const Pieces pieces = pieces_of(world, coefficients);
    const std::vector<Span> times = spans_of(spans, pieces.count);
    require_memory(resolution);
    require(within(coefficients, coefficients.size(), farthest), "a coefficient is no finite number");
    for (const Span& span : times) require(span.holds(), "a span is no time");
    const int count = pieces.count;
    std::vector<Proof> proofs(count);
    Prover prover(world, bounds);
    if (count) BoxProof(prover, pieces, spans ? times.data() : nullptr, resolution, proofs.data()).prove(0, count);
    Made<int64_t, 1> verdict(count), pair(count);
    Made<double, 1> where(count);
    for (int k = 0; k < count; ++k)
        verdict[k] = proofs[k].verdict, pair[k] = proofs[k].pair, where[k] = proofs[k].where;
    return std::tuple{std::move(verdict), std::move(pair), std::move(where)};
}

// Sums of the first 0, 1, 2, ... counts.
inline std::vector<int64_t> offsets_of(const Ints<any>& counts) {
    std::vector<int64_t> offsets(counts.size() + 1);
    for (size_t k = 0; k < counts.size(); ++k) {
        require(counts[k] >= 0 && counts[k] <= INT32_MAX, "there are no so many");
        offsets[k + 1] = offsets[k] + counts[k];
    }
    return offsets;
}

inline auto first_proven_of(const World& world, const Bounds& bounds, const Coefficients& coefficients,
                            const Ints<any>& motions, const Ints<any>& alternatives, const Ints<any>& begin,
                            double resolution) {
    const Pieces pieces = pieces_of(world, coefficients);
    const std::vector<int64_t> items = offsets_of(alternatives), ends = offsets_of(motions);
    const int count = alternatives.count();
    require(items.back() == motions.count() && ends.back() == pieces.count,
            "the numbers of alternatives and motions do not fit each other");
    require(between(begin.of({count}), count, 0, INT32_MAX), "there is no such alternative to begin with");
    require_memory(resolution);
    Made<int64_t, 1> chosen(count), samples(pieces.count);
    Made<double, 1> clearance(pieces.count);
    std::vector<Proof> proofs(pieces.count);
    for (Proof& proof : proofs) proof.samples = -1;
    share_out(
        count, 2, [&] { return Prover(world, bounds); },
        [&](int k, Prover& prover) {
            chosen[k] =
                first_proven(prover, pieces, static_cast<int>(begin[k]), static_cast<int>(items[k + 1] - items[k]),
                             &ends[items[k]], resolution, proofs.data());
        });
    for (int k = 0; k < pieces.count; ++k) clearance[k] = proofs[k].clearance, samples[k] = proofs[k].samples;
    return std::tuple{std::move(chosen), std::move(clearance), std::move(samples)};
}

inline auto cheapest_proven_chain(const World& world, const Bounds& bounds, const States& points, const States& price,
                                  double resolution) {
    const int count = points.of({any, world.chain.dof()}).count(), most = threads();
    require(count >= 1, "a chain has at least one point");
    require_memory(resolution);
    std::vector<double> prices(price.of({count, count}) + 0, price + price.size());
    ChainSearch search(count, world.chain.dof(), points, prices.data());
    share_out(
        most, 1, [&] { return Prover(world, bounds); }, [&](int, Prover& prover) { search.work(prover, resolution); },
        most);
    const std::vector<int>& found = search.rows();
    Made<int64_t, 1> rows(found.size()), samples(found.size() - 1);
    Made<double, 1> clearance(found.size() - 1);
    for (size_t k = 0; k < found.size(); ++k) {
        rows[k] = found[k];
        if (!k) continue;
        const Proof* proof = search.proof(found[k - 1], found[k]);
        clearance[k - 1] = proof ? proof->clearance : 0.0, samples[k - 1] = proof ? proof->samples : -1;
    }
    return std::tuple{std::move(rows), std::move(clearance), std::move(samples)};
}

inline auto walk(const World& world, const Bounds& bounds, const Coefficients& coefficients, double longest) {
    const Pieces pieces = pieces_of(world, coefficients);
    require(within(coefficients, coefficients.size(), farthest), "a coefficient is no finite number");
    require(longest > 0.0, "a part is longer than nothing");
    Made<int64_t, 1> parts(pieces.count);
    Made<double, 1> shares(world.pair_count());
    std::fill_n(shares.data(), shares.size(), 0.0);
    std::vector<std::pair<int, int64_t>> of;  // piece of each interval, and index of the interval
    Walk whole(world, bounds, pieces);
    for (int k = 0; k < pieces.count; ++k, poll_signal()) {
        const double cut = whole.parts(k, longest);
        require(cut + of.size() <= most_parts, "a motion is too long to be walked along in such short parts");
        parts[k] = static_cast<int64_t>(cut);
        for (int64_t part = 0; part < parts[k]; ++part) of.emplace_back(k, part);
    }
    Made<double, 1> moved(of.size());
    std::mutex alone;
    struct Worker {
        Walk walk;
        std::mutex& alone;
        double* shares;
        ~Worker() {
            const std::lock_guard<std::mutex> held(alone);
            walk.raise(shares);
        }
    };
    constexpr int at_a_time = 8;
    const int all = static_cast<int>(of.size());
    share_out((all + at_a_time - 1) / at_a_time, 2, [&] { return Worker{{world, bounds, pieces}, alone, shares}; },
              [&](int batch, Worker& at) {
                  for (int i = batch * at_a_time; i < std::min(all, (batch + 1) * at_a_time); ++i) {
                      const auto [piece, part] = of[i];
                      const double number = part, cut = parts[piece];
                      moved[i] = at.walk.part(piece, number / cut, (number + 1) / cut);
                  }
              });
    return std::tuple{std::move(parts), std::move(moved), std::move(shares)};
}

inline auto tree_path(const World& world, const Bounds& bounds, const Limits& limits, const Bools& wraps,
                      double longest, const ToolsGiven& given, double floor, double floor_apart, const States& starts,
                      const States& goals, double step, double look_apart, uint64_t seed, int limit) {
    const int dof = world.chain.dof();
    const auto& [lower, upper] = limits;
    const Tools tools = tools_of(world.chain, given);
    lower.of({dof}), upper.of({dof}), wraps.of({dof}), starts.of({any, dof}), goals.of({any, dof});
    require(starts.count() >= 1 && goals.count() >= 1, "there is no start or no goal");
    require(limit >= 0, "the limit is below 0");
    require(within(starts, starts.size(), farthest) && within(goals, goals.size(), farthest),
            "a start or a goal is no finite number");
    require(within(lower, dof, farthest) && within(upper, dof, farthest), "a limit is no finite number");
    require(longest >= 0.0 && floor >= 0.0, "a length or a floor is below 0");
    require(floor_apart > 0.0 && look_apart > 0.0 && step > 0.0, "a step is longer than nothing");
    const SearchSpace space{lower, upper, bytes_of(wraps), longest, floor, floor_apart, tools.points, tools.rows};
    TreeSearch search(world, bounds, space, step, look_apart, seed);
    const std::vector<double> path = search.path(starts, starts.count(), goals, goals.count(), limit);
    std::optional<Made<double, 2>> found;
    if (!path.empty()) found = copy_into(path.data(), Made<double, 2>(path.size() / dof, dof));
    return std::tuple{std::move(found), search.looked_at};
}

inline auto group_rows(const Floats<any, 3>& rows, double side) {
    require(side >= 0.0, "the side of a cell is no length");
    const RowGroups groups(rows, rows.array.shape(0), side);
    return std::tuple{made_of(groups.first), made_of(groups.which), groups.spread};
}

inline auto components(const Floats<any, 3>& points, double radius) {
    require(radius > 0.0, "the radius is no length");
    return made_of(first_of_components(points, points.array.shape(0), radius));
}

inline void bind_world(nb::module_& m) {
    m.def("group_rows", &group_rows, "rows"_a, "side"_a, at_work,
          "Return the first row (m,) of each group of rows (n, 3), the group (n,) of each row, and the largest\n"
          "distance of a row from the first of its group.\n\n"
          "Equal rows are a group, or with a side above 0 rows in one cubic cell; in the order of first rows.");
    m.def("components", &components, "points"_a, "radius"_a, at_work,
          "Return a point (m,) of each connected component of balls of radius around points (n, 3), or of more.");
    nb::class_<Bounds>(m, "NativeBounds", "How fast pairs and bodies of one world move at most.")
        .def_prop_ro("left_out", [](const Bounds& self) {
            return copy_into(reinterpret_cast<const bool*>(self.is_static.data()),
                             Made<bool, 1>(self.is_static.size()));
        });
    nb::class_<Look>(m, "Look", "Whether no pair is near along a motion from start by delta (dof,).")
        .def("__call__", &Look::operator(), "start"_a, "delta"_a, at_work);
    nb::class_<World>(m, "NativeWorld",
                      "Bodies of a robot and obstacles, added in order, bodies first; then the checked pairs.\n\n"
                      "Every body has spheres, every obstacle targets, and set_pairs comes last; then threads can\n"
                      "share the world. A joint of -1 is the world: its items are obstacles.")
        .def(
            "__init__",
            [](World* self, const Chain& chain, double margin) {
                require(margin >= 0.0 && margin <= farthest, "the margin is no distance");
                new (self) World();
                self->chain = chain, self->margin = margin;
            },
            "chain"_a, "margin"_a)
        .def_prop_ro("dof", [](const World& self) { return self.chain.dof(); })
        .def_prop_ro("bodies", [](const World& self) { return self.bodies; })
        .def_prop_ro("pairs", &World::pair_count)
        .def("add_hull", &add_hull, "joint"_a, "points"_a, "radius"_a, at_work,
             "Add the convex hull of points (k, 3), rounded by radius; return its number.")
        .def("add_cylinder", &add_cylinder, "joint"_a, "middle"_a, "half"_a, "across"_a,
             "Add a cylinder: middle (3,), half of its axis (3,), two radii across (2, 3); return its number.")
        .def("add_surface", &add_surface, "joint"_a, "hull"_a, "triangles"_a, "depth"_a, "radius"_a = 0.0, at_work,
             "Add the union of triangles (m, 3, 3), with points (k, 3) of its hull.\n\n"
             "It is at most depth (m) below the hull, which replaces it at larger distances; both are rounded by "
             "radius (m). Return its number.")
        .def("add_cloud", &add_cloud, "joint"_a, "sets"_a, "radius"_a, "boxes"_a, at_work,
             "Add the union of the hulls of points (m, c, 3), rounded by radius (m); return its number.\n\n"
             "An obstacle gets its targets here, at most so many boxes.")
        .def("take", &take, "other"_a, "item"_a,
             "Add the item of another world of the same arm, with its motion and speed limit; return its number.")
        .def("set_motion", &set_motion, "item"_a, "times"_a, "turns"_a, "shifts"_a, "axes"_a, "rates"_a, "speeds"_a,
             "size"_a,
             "Set the motion of an obstacle: its frame is at turns (n, 3, 3), shifts (n, 3) at times (n,) s.\n\n"
             "Between times it turns about axes (n - 1, 3), in its own frame, at rates (n - 1,) rad/s; its points\n"
             "are at most speeds (n - 1,) m/s fast, and at most size (m) from the origin of the frame. Calls\n"
             "without a time use time 0.")
        .def("set_speed_limit", &set_speed_limit, "item"_a, "limit"_a,
             "Let points of an obstacle move at most limit (m/s) times t from their position at time 0.")
        .def("set_travel", &set_travel, "travel"_a,
             "Set the range of slides around 0 (joints,) m, infinite for joints that turn.\n\n"
             "Reaches hold in this range: motions beyond it are undecided.")
        .def("add_spheres", &add_spheres, "item"_a, "centres"_a, "radii"_a,
             "Set spheres (k, 3), (k,) whose union contains a body, in the frame of its joint.")
        .def("add_target", &add_target, "item"_a, "turn"_a, "shift"_a, "half"_a, "radius"_a, "is_cylinder"_a,
             "Add a box of half sizes half (3,), rounded by radius, that contains a section of an obstacle.\n\n"
             "It is placed by turn (3, 3), shift (3,). A cylinder has its radius and half length in half[0], [2].")
        .def("set_pairs", &set_pairs, "pairs"_a, "checked"_a,
             "Set pairs (n, 2) of items in the order of their numbers, and which (n,) are checked.\n\n"
             "Pairs are first every body with every obstacle, by body; then two bodies each.")
        .def("bounds", &bounds_of, "reach"_a, "body_reach"_a, "is_static"_a,
             "Return bounds on motions, for proofs.\n\n"
             "reach (pairs, joints) bounds the rate of a pair's distance per joint, body_reach (bodies, joints) the\n"
             "rate of points of a body, in any configuration; static pairs have none.")
        .def("coarse", &coarse, "rotation"_a, "position"_a, at_work,
             "Return lower bounds (n, pairs) on distances by spheres, for placements; inf for unchecked pairs.")
        .def("close", &close, "rotation"_a, "position"_a, "rows"_a, "pairs"_a, "enough"_a = infinity, at_work,
             "Return lower bounds (k,) on the distances of pairs (k,) in configurations rows (k,), by planes.\n\n"
             "They are accurate to a micrometre, or to the depth of surfaces at larger distances; 0 for contacts.\n"
             "Bounds of at least enough (k,) m are not improved.")
        .def("planes", &planes, "rotation"_a, "position"_a, "rows"_a, "pairs"_a, "enough"_a = infinity, at_work,
             "Return normals (k, 3), not of unit length, of the best planes between the hulls of pairs.\n\n"
             "They point from the first of a pair to the second. If hulls intersect they separate nothing.")
        .def("points_within", &points_within, "rotation"_a, "position"_a, "points"_a, "reach"_a, at_work,
             "Return which points (n, 3) are within reach (m) of a body in one configuration, to a micrometre.")
        .def("first_near", &first_near, "q"_a, at_work,
             "Return the first configuration of (n, dof) with a pair within the margin; n if there is none.\n\n"
             "A configuration with a number that is not finite counts as near.")
        .def(
            "look", [](const World& self, const Bounds& bounds, double step) { return new Look(self, bounds, step); },
            "bounds"_a, "step"_a, nb::rv_policy::take_ownership, nb::keep_alive<0, 1>(), nb::keep_alive<0, 2>(),
            "Return a check of motions from a start by a delta (dof,), which is true if first_near finds no sample\n"
            "except the start.\n\n"
            "Samples are the end, the middle, and states between which no point moves farther than step (m), except\n"
            "those that another sample clears. It is for one thread.")
        .def("prove", &prove, "bounds"_a, "coefficients"_a, "resolution"_a, "spans"_a = nb::none(), at_work,
             "Prove pieces q(s) = sum_k c_k s^k, (m, degree + 1, dof), s in [0, 1].\n\n"
             "spans (m, 3), for moving obstacles, are start, duration and tolerance of the start of each piece, s.\n"
             "Return verdicts (m,), the pairs that stopped them, samples, clearances and s of the end. Pieces with\n"
             "numbers that are not finite, or that move a point farther than a million metres, are undecided.")
        .def("prove_motion", &prove_motion, "bounds"_a, "start"_a, "delta"_a, "resolution"_a, at_work,
             "Return clearance and samples of one straight motion; None without a proof.")
        .def("prove_together", &prove_together, "bounds"_a, "coefficients"_a, "resolution"_a, "spans"_a = nb::none(),
             at_work,
             "Prove neighbouring pieces as prove, on one thread.\n\n"
             "Distant pairs are cleared for many pieces at once. Return verdicts (m,), the pairs that stopped them\n"
             "and s; pieces behind the first that is not free are undecided, without a pair.")
        .def("first_proven", &first_proven_of, "bounds"_a, "coefficients"_a, "motions"_a, "alternatives"_a, "begin"_a,
             "resolution"_a, at_work,
             "Return for each of n items the first alternative with all motions proven, or -1.\n\n"
             "Item k has alternatives[k] alternatives, the first begin[k] of which are skipped; alternative j has\n"
             "motions[j] of the pieces (m, degree + 1, dof), in order. Return numbers (n,), and clearances and\n"
             "samples (m,) of the chosen motions, -1 samples for others.")
        .def("cheapest_chain", &cheapest_proven_chain, "bounds"_a, "points"_a, "price"_a, "resolution"_a, at_work,
             "Return the rows (r,) of the cheapest chain of proven straight motions from the first of points to the\n"
             "last.\n\n"
             "Motions between consecutive points (k, dof) are proven; price (k, k) is of forward motions. Also\n"
             "return clearances and samples (r - 1,) of the motions between them, -1 samples for consecutive\n"
             "points. All points are returned if every chain has an infinite price.")
        .def("walk", &walk, "bounds"_a, "coefficients"_a, "longest"_a, at_work,
             "Return the number of equal intervals of each of m pieces, and bounds on the motion of points on each.\n\n"
             "On an interval the joints move no point farther than longest (m). The bounds (intervals,) m hold for\n"
             "sections of an interval in proportion. shares (pairs,) are the largest ratios of a pair's change of\n"
             "distance to the motion of the fastest point.")
        .def("tree_path", &tree_path, "bounds"_a, "limits"_a, "wraps"_a, "longest"_a, "tools"_a, "floor"_a,
             "floor_apart"_a, "starts"_a, "goals"_a, "step"_a, "look_apart"_a, "seed"_a, "limit"_a, at_work,
             "A path (k, dof) of motions that look free, from a start to a goal, and how many it looked at.\n\n"
             "RRTConnect (Kuffner and LaValle 2000) with steps of step (rad), whose smaller tree grows, with dynamic\n"
             "domains (Yershova et al. 2005). Motions are looked at as look says, look_apart (m), and proven nowhere.\n"
             "States are drawn between limits, or from -pi to pi where a joint wraps; none is farther from the\n"
             "nearest start and the nearest goal than longest in all. Along motions the manipulability of all tools\n"
             "(joints, points, rows) is not below floor in states that are floor_apart apart. None after limit "
             "motions,\n"
             "or when a stop is asked for. The same seed gives the same path.");
}

}  // namespace planner
