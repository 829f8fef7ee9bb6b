// What Python asks of a robot among obstacles; see ../../library.py for shapes and units.
#pragma once

#include <mutex>
#include <numeric>

#include "../choices.hpp"
#include "../glance.hpp"
#include "../sharing.hpp"
#include "../tree_search.hpp"
#include "../walk.hpp"
#include "robot.hpp"

namespace planner {

namespace {

// The item of a world with a number, a body or an obstacle as is asked.
Item& item_of(World& world, int item, bool body) {
    require(item >= 0 && item < static_cast<int>(world.items.size()), "there is no such item");
    require((world.items[item].joint >= 0) == body, body ? "the item is no body" : "the item is no obstacle");
    return world.items[item];
}

// Make room for one more item, which `joint` carries, or the world where that is negative; bodies come first.
void require_place(const World& world, int joint) {
    require(world.pairs.empty(), "items come before the pairs");
    require(joint < 0 || world.obstacles() == 0, "bodies come before obstacles");
    require(joint <= world.chain.size(), "there is no such joint");
}

int added(World& world, Item item) {
    if (item.joint >= 0) ++world.bodies;
    world.items.push_back(std::move(item));
    return static_cast<int>(world.items.size()) - 1;
}

constexpr int64_t most_parts = INT32_MAX / 8;  // of a walk

// Pieces (count, degree + 1, dof) of numbers that can be walked along.
Pieces to_walk(const World& world, const double* coefficients, int count, int degree) {
    require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
    const Pieces pieces{coefficients, count, degree, world.chain.dof()};
    require(within(coefficients, static_cast<size_t>(count) * (degree + 1) * pieces.dof, farthest),
            "a coefficient is no finite number");
    return pieces;
}

}  // namespace

extern "C" {

World* world_new(const Chain* chain, double margin) {
    return answered([&] {
        require(margin >= 0.0 && margin <= farthest, "the margin is no distance");
        auto world = std::make_unique<World>();
        world->chain = *chain, world->margin = margin;
        return world.release();
    });
}

void world_free(World* world) { delete world; }

// The shape is given in the frame of what carries it: `joint`, or the world where that is negative.
// kind 0: the convex hull of points (n, 3), rounded by radius; 1: a cylinder by its middle, the vector to a disc's
// middle, two radii across; 2: the surface of triangles (m, 3, 3) `depth` deep below the hull of points (n, 3), both rounded by
// radius
int world_add(World* world, int joint, int kind, int n, const double* points, double radius, int m,
              const double* triangles, double depth) {
    return answered([&] {
        require_place(*world, joint);
        require(kind >= 0 && kind <= 2, "there is no such kind of shape");
        require(kind == 1 ? n == 4 : n >= 1, "a shape has at least one point, and a cylinder four");
        require(kind != 2 || m >= 1, "a surface has at least one triangle");
        require(within(points, 3 * static_cast<size_t>(n), farthest), "a point is no finite number");
        require(m == 0 || within(triangles, 9 * static_cast<size_t>(m), farthest), "a triangle is no finite number");
        require(depth >= 0.0 && not_negative(&radius, 1, farthest), "a radius or a depth is no distance");
        Item item;
        item.joint = joint, item.frame = joint;
        Solid solid;
        if (kind == 0) solid = Solid::of_points(points, n, radius);
        if (kind == 1) solid = Solid::of_cylinder(points);
        if (kind == 2) solid = Solid::of_triangles(points, n, triangles, m, depth, radius);
        item.solid = std::make_shared<const Solid>(std::move(solid));
        return added(*world, std::move(item));
    });
}

// Spheres (n,) that together hold body `item`, in its joint's frame; bodies in order. They are kept larger by the rounding
// of distances, so that no bound by them exceeds the true distance.
int world_add_spheres(World* world, int item, int n, const double* centres, const double* radii) {
    return answered([&] {
        Item& body = item_of(*world, item, true);
        require(n >= 1 && body.spheres == 0, "a body has at least one sphere, and all of them at once");
        require(within(centres, 3 * static_cast<size_t>(n), farthest), "a sphere's middle is no finite number");
        require(not_negative(radii, n, farthest), "a sphere's radius is no distance");
        body.first_sphere = static_cast<int>(world->radii.size()), body.spheres = n;
        for (int k = 0; k < n; ++k) {
            world->sphere_x.push_back(centres[3 * k]), world->sphere_y.push_back(centres[3 * k + 1]);
            world->sphere_z.push_back(centres[3 * k + 2]), world->radii.push_back(radii[k] + rounding);
        }
    });
}

// Add what another world of the same arm has as number `item`, its motion and its speed limit too; its shape is shared.
// Bodies in order. Its number here.
int world_take(World* world, const World* other, int item) {
    return answered([&] {
        require(item >= 0 && item < static_cast<int>(other->items.size()), "there is no such item");
        require(other->chain.size() == world->chain.size(), "the other world is of another arm");
        Item taken = other->items[item];
        require_place(*world, taken.joint);
        if (taken.joint >= 0) {
            const int first = taken.first_sphere, last = first + taken.spheres;
            taken.first_sphere = static_cast<int>(world->radii.size());
            for (int k = first; k < last; ++k) {
                world->sphere_x.push_back(other->sphere_x[k]), world->sphere_y.push_back(other->sphere_y[k]);
                world->sphere_z.push_back(other->sphere_z[k]), world->radii.push_back(other->radii[k]);
            }
        }
        if (const Motion* motion = other->motion_of(item)) world->let_move(taken, *motion);
        return added(*world, std::move(taken));
    });
}

// Obstacle `item`, given in its own frame, is at poses (n, 3, 3) and (n, 3) at times (n,); between two of them it turns
// about an axis (n - 1, 3) in its own frame at rates (n - 1,), and no point of it exceeds speeds (n - 1,) nor is farther
// than `size` from that frame's origin.
int world_set_motion(World* world, int item, int n, const double* times, const double* turns, const double* shifts,
                     const double* axes, const double* rates, const double* speeds, double size) {
    return answered([&] {
        Item& obstacle = item_of(*world, item, false);
        require(n >= 1 && obstacle.frame < 0, "a motion has at least one pose, and an obstacle one motion");
        const size_t poses = n, between_them = poses - 1;
        require(within(times, poses, farthest) && within(turns, 9 * poses, farthest) &&
                    within(shifts, 3 * poses, farthest) && within(axes, 3 * between_them, farthest) &&
                    within(rates, between_them, infinity) && not_negative(speeds, between_them, infinity) &&
                    not_negative(&size, 1, farthest),
                "a motion holds what is no finite number");
        std::vector<Motion::Stretch> stretches;
        for (int k = 0; k + 1 < n; ++k) {
            require(times[k] < times[k + 1], "the times of a motion do not increase");
            const Vec from = vec_at(shifts + 3 * k), to = vec_at(shifts + 3 * (k + 1));
            stretches.push_back({times[k],
                                 times[k + 1],
                                 {mat_at(turns + 9 * k), from},
                                 (1.0 / (times[k + 1] - times[k])) * (to - from),
                                 vec_at(axes + 3 * k),
                                 rates[k],
                                 speeds[k]});
        }
        const Frame last{mat_at(turns + 9 * (n - 1)), vec_at(shifts + 3 * (n - 1))};
        world->let_move(obstacle, Motion(std::move(stretches), last, size));
    });
}

// Obstacle `item` may be elsewhere from time 0 on, no point of it farther than `limit` (m/s) times t from where it was.
int world_set_speed_limit(World* world, int item, double limit) {
    return answered([&] {
        require(limit >= 0.0 && limit <= farthest, "the speed limit is no speed");
        item_of(*world, item, false).speed_limit = limit;
    });
}

// How far slides go from 0 at most, travel (joints,) m, infinite for joints that turn: reaches hold as long as they do.
int world_set_travel(World* world, const double* travel) {
    return answered([&] {
        require(not_negative(travel, world->chain.size(), infinity), "a travel is no distance");
        world->travel.assign(travel, travel + world->chain.size());
    });
}

// A rounded box or a cylinder that holds a part of obstacle `item`; placement (3, 3) and (3,) in the world.
int world_add_target(World* world, int item, int is_cylinder, const double* turn, const double* shift,
                     const double* half, double radius) {
    return answered([&] {
        Item& obstacle = item_of(*world, item, false);
        require(within(turn, 9, farthest) && within(shift, 3, farthest), "a placement is no finite number");
        require(not_negative(half, 3, farthest) && not_negative(&radius, 1, farthest), "a size is no distance");
        Target target;
        Mat t = mat_at(turn);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) target.to_local.turn.m[3 * i + j] = t.m[3 * j + i];
        target.to_local.shift = -(target.to_local.turn * vec_at(shift));
        target.half = vec_at(half), target.radius = radius, target.is_cylinder = is_cylinder;
        obstacle.targets.push_back(target);
    });
}

// pairs (n, 2) of items, in the order of their numbers: every body with every obstacle, then two bodies each
int world_set_pairs(World* world, int n, const int64_t* pairs, const uint8_t* checked) {
    return answered([&] {
        require(world->pairs.empty(), "the pairs are there already");
        const int bodies = world->bodies, obstacles = world->obstacles(), scene = bodies * obstacles;
        for (const Item& item : world->items)
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
            world->pairs.push_back(
                {static_cast<int>(pairs[2 * p]), static_cast<int>(pairs[2 * p + 1]), checked[p] != 0});
        world->measure();
    });
}

// bounds (n, pairs) for placements as chain_placements gives them
int world_coarse(const World* world, int n, const double* rotation, const double* position, double* bounds) {
    return answered([&] {
        Scratch scratch = world->scratch();
        for (int k = 0; k < n; ++k) {
            heed();
            for (int j = 0; j <= world->chain.size(); ++j) {
                const size_t row = static_cast<size_t>(j) * n + k;
                scratch.frames[j] = {mat_at(rotation + 9 * row), vec_at(position + 3 * row)};
            }
            world->place_moving(0.0, scratch.frames.data());
            world->coarse(scratch.frames.data(), scratch, bounds + static_cast<size_t>(k) * world->pair_count());
        }
    });
}

// Configurations of placements as chain_placements gives them, one of which stands in the frames.
struct Posed {
    const World& world;
    int n;
    const double *rotation, *position;
    std::vector<Frame> frames;
    int64_t placed = -1;

    Posed(const World& in, int count, const double* turns, const double* shifts)
        : world(in), n(count), rotation(turns), position(shifts), frames(in.frame_count()) {
        world.place_moving(0.0, frames.data());
    }
    const Frame* at(int64_t k) {
        if (k == placed) return frames.data();
        for (int j = 0; j <= world.chain.size(); ++j) {
            const size_t row = static_cast<size_t>(j) * n + k;
            frames[j] = {mat_at(rotation + 9 * row), vec_at(position + 3 * row)};
        }
        placed = k;
        return frames.data();
    }
};

// close lower bounds (count,) of numbered pairs in configurations `rows` of n, no better than to show that they are
// `enough` (count,); and the normals (count, 3) of the planes that held best between the two hulls, unless null
int world_close(const World* world, int n, const double* rotation, const double* position, int count,
                const int64_t* rows, const int64_t* pairs, const double* enough, int threads, double* bounds,
                double* normals) {
    return answered([&] {
        require(between(rows, count, 0, n), "there is no such configuration");
        require(between(pairs, count, 0, world->pair_count()), "there is no such pair");
        for (int k = 0; k < count; ++k) require(enough[k] >= 0.0, "what is enough is no distance");
        constexpr int together = 64;  // looks, of microseconds each where pairs are far apart
        share_out((count + together - 1) / together, threads, 8, [&] { return Posed(*world, n, rotation, position); },
                  [&](int block, Posed& posed) {
                      const int last = std::min(count, (block + 1) * together);
                      for (int k = block * together; k < last; ++k) {
                          heed();
                          const Frame* frames = posed.at(rows[k]);
                          const int pair = static_cast<int>(pairs[k]);
                          Vec apart = world->between_middles(pair, frames);
                          Closeness closeness;
                          closeness.enough = enough[k];
                          bounds[k] = world->close(pair, frames, apart, closeness);
                          if (normals)
                              normals[3 * k] = apart.x, normals[3 * k + 1] = apart.y, normals[3 * k + 2] = apart.z;
                      }
                  });
    });
}

// Proofs of polynomial pieces (count, degree + 1, dof); reach (pairs, joints), body_reach (bodies, joints), is_static (pairs,).
// spans (count, 3), or null where nothing moves by itself: when each piece begins, how long it takes, and how much sooner
// or later it may begin, s.
int world_prove(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                const double* coefficients, const double* spans, int count, int degree, double room, int threads,
                int64_t* verdict, int64_t* pair, int64_t* samples, double* clearance, double* where) {
    return answered([&] {
        require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
        require(room >= rounding, "the room is below what distances are rounded by");
        const Pieces pieces{coefficients, count, degree, world->chain.dof()};
        share_out(
            count, threads, 4, [&] { return Prover(*world, reach, body_reach, is_static); },
            [&](int k, Prover& prover) {
                const Span span = spans ? Span{spans[3 * k], spans[3 * k + 1], spans[3 * k + 2]} : Span();
                const Proof proof = prover.prove(pieces, k, room, spans ? &span : nullptr);
                verdict[k] = proof.verdict, pair[k] = proof.pair, samples[k] = proof.samples;
                clearance[k] = proof.clearance, where[k] = proof.where;
            });
    });
}

// Of each of `count` items the first alternative whose motions are all proven, or -1: chosen (count,), where it says at
// first which alternative to begin with. They are those from items[k] to items[k + 1] of `alternatives` in all, and the
// motions of one are the pieces from ends[a] to ends[a + 1] of `motions`, (motions, degree + 1, dof). clearance and samples (motions,) of what was
// chosen, -1 samples of the others.
int world_first_proven(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                       const double* coefficients, int motions, int degree, int count, const int64_t* items,
                       int alternatives, const int64_t* ends, double room, int threads, int64_t* chosen,
                       double* clearance, int64_t* samples) {
    return answered([&] {
        require(are_offsets(items, count, alternatives) && are_offsets(ends, alternatives, motions),
                "the numbers of alternatives and motions do not fit each other");
        require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
        require(between(chosen, count, 0, INT32_MAX), "there is no such alternative to begin with");
        require(room >= rounding, "the room is below what distances are rounded by");
        const Pieces pieces{coefficients, motions, degree, world->chain.dof()};
        std::vector<Proof> proofs(pieces.count);
        for (Proof& proof : proofs) proof.samples = -1;
        share_out(
            count, threads, 2, [&] { return Prover(*world, reach, body_reach, is_static); },
            [&](int k, Prover& prover) {
                const int begin = static_cast<int>(chosen[k]), end = static_cast<int>(items[k + 1] - items[k]);
                chosen[k] = first_proven(prover, pieces, begin, end, ends + items[k], room, proofs.data());
            });
        for (int k = 0; k < pieces.count; ++k) clearance[k] = proofs[k].clearance, samples[k] = proofs[k].samples;
    });
}

// The cheapest chain of proven motions through points (count, dof), of which consecutive ones are proven, by forward
// price (count, count), in which refused ones become infinite: its rows, their number, and clearance and samples of the
// motions to rows[1], rows[2] and so on, -1 samples of those that were proven before.
int world_cheapest_chain(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                         int count, const double* points, double* price, double room, int threads, int64_t* rows,
                         double* clearance, int64_t* samples) {
    return answered([&] {
        require(count >= 1, "a chain has at least one point");
        require(room >= rounding, "the room is below what distances are rounded by");
        ChainSearch search(count, world->chain.dof(), points, price);
        share_out(
            threads, threads, 1, [&] { return Prover(*world, reach, body_reach, is_static); },
            [&](int, Prover& prover) { search.work(prover, room); });
        const std::vector<int>& found = search.rows();
        for (size_t k = 0; k < found.size(); ++k) {
            const Proof* proof = k > 0 ? search.proof(found[k - 1], found[k]) : nullptr;
            rows[k] = found[k], clearance[k] = proof ? proof->clearance : 0.0, samples[k] = proof ? proof->samples : -1;
        }
        return static_cast<int>(found.size());
    });
}

// Into how many parts each of the pieces (count, degree + 1, dof) is cut that no joint moves anything farther on than
// `longest` (m), parts (count,). How many these are in all.
int world_parts(const World* world, const double* body_reach, const double* coefficients, int count, int degree,
                double longest, int64_t* parts) {
    return answered([&] {
        const Pieces pieces = to_walk(*world, coefficients, count, degree);
        require(longest > 0.0, "a part is longer than nothing");
        Walk walk(*world, nullptr, body_reach, pieces);
        int64_t all = 0;
        for (int k = 0; k < count; ++k, heed()) {
            const double cut = walk.parts(k, longest);
            require(cut + all <= most_parts, "a motion is too long to be walked along in such short parts");
            all += parts[k] = static_cast<int64_t>(cut);
        }
        return static_cast<int>(all);
    });
}

// By how many metres, moved (all parts,), no point of an arm is moved farther on each of the parts (count,) of pieces, and
// in `shares` (pairs,) by how much the distances of pairs change at most meanwhile, of that.
int world_walk(const World* world, const double* reach, const double* body_reach, const double* coefficients, int count,
               int degree, const int64_t* parts, int threads, double* moved, double* shares) {
    return answered([&] {
        const Pieces pieces = to_walk(*world, coefficients, count, degree);
        require(between(parts, count, 0, most_parts), "there are no so many parts");
        std::vector<int> of;  // a piece of each part
        for (int k = 0; k < count; ++k) of.insert(of.end(), parts[k], k);
        std::vector<int64_t> first(count);
        std::exclusive_scan(parts, parts + count, first.begin(), int64_t{0});
        std::fill_n(shares, world->pair_count(), 0.0);
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
        share_out((all + at_a_time - 1) / at_a_time, threads, 2,
                  [&] { return Worker{{*world, reach, body_reach, pieces}, alone, shares}; },
                  [&](int batch, Worker& at) {
                      for (int i = batch * at_a_time; i < std::min(all, (batch + 1) * at_a_time); ++i) {
                          const double number = i - first[of[i]], cut = parts[of[i]];
                          moved[i] = at.walk.part(of[i], number / cut, (number + 1) / cut);
                      }
                  });
    });
}

// The first of configurations (n, dof) in which a pair is not farther apart than the margin, or n.
int world_first_near(const World* world, int n, const double* q) {
    return answered([&] {
        Glance glance(*world);
        for (int k = 0; k < n; ++k, heed())
            if (glance.finds_near(q + static_cast<size_t>(k) * world->chain.dof(), clearly)) return k;
        return n;
    });
}

// What looks at one motion after the other, on one thread, for as long as the world is there.
Glance* glance_new(const World* world) {
    return answered([&] { return std::make_unique<Glance>(*world).release(); });
}

void glance_free(Glance* glance) { delete glance; }

// Whether no pair is so near in states along the motion from start by delta (dof,): at its end, in its middle, and where
// no point moves further than `step` (m) from one to the next; reach (pairs, joints), body_reach (bodies, joints).
int glance_looks_free(Glance* glance, const double* reach, const double* body_reach, const double* start,
                      const double* delta, double step) {
    return answered([&] {
        require(step > 0.0, "a step is longer than nothing");
        require(glance->fits(), "items and pairs come before the glance");
        return static_cast<int>(glance->looks_free(start, delta, reach, body_reach, step));
    });
}

// A path of motions that look free from one of starts to one of goals, (., dof): its states, of which there are no more
// than `limit` and two; how many, 0 where none was found, and in looked_at (1,) how many motions were looked at. `numbers`:
// longest, floor, how far apart floor and clearance are looked at, step.
int world_tree_path(const World* world, const double* reach, const double* body_reach, const double* lower,
                    const double* upper, const uint8_t* wraps, int last, const double* point, int rows,
                    const double* numbers, int start_count, const double* starts, int goal_count, const double* goals,
                    int64_t seed, int limit, double* states, int64_t* looked_at) {
    return answered([&] {
        const int dof = world->chain.dof();
        require_joint(world->chain, last);
        require(rows >= 1 && rows <= 6, "a Jacobian has from one to six rows");
        require(start_count >= 1 && goal_count >= 1, "there is no start or no goal");
        require(limit >= 0, "the limit is below 0");
        require(within(starts, static_cast<size_t>(start_count) * dof, farthest) &&
                    within(goals, static_cast<size_t>(goal_count) * dof, farthest),
                "a start or a goal is no finite number");
        require(within(lower, dof, farthest) && within(upper, dof, farthest), "a limit is no finite number");
        require(numbers[0] >= 0.0 && numbers[1] >= 0.0, "a length or a floor is below 0");
        require(numbers[2] > 0.0 && numbers[3] > 0.0 && numbers[4] > 0.0, "a step is longer than nothing");
        const SearchSpace space{lower, upper, wraps, numbers[0], numbers[1], numbers[2], last, rows, vec_at(point)};
        TreeSearch search(*world, reach, body_reach, space, numbers[4], numbers[3], static_cast<uint64_t>(seed));
        const std::vector<double> path = search.path(starts, start_count, goals, goal_count, limit);
        std::copy(path.begin(), path.end(), states);
        *looked_at = search.looked_at;
        return static_cast<int>(path.size()) / dof;
    });
}

}  // extern "C"

}  // namespace planner
