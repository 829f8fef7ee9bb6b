// What Python calls: plain C functions over arrays of doubles; see ../library.py for shapes and units.

#include <atomic>
#include <cstdint>
#include <memory>
#include <system_error>
#include <thread>

#include "choices.hpp"
#include "dynamics.hpp"
#include "glance.hpp"
#include "graph.hpp"
#include "inverse.hpp"
#include "time_optimal.hpp"

using namespace planner;

namespace {

// What is left to do of work that is shared among threads, and how many of them are at it.
struct Shares {
    std::atomic<int> next{0}, busy{0};
};

// Do `work(k, worker)` for k in [0, count) on up to `threads` threads; `make` makes what each of them works in.
// Whatever the threads, every k is worked on alone: the results are the same. No thread is waited for that has not
// begun: on a busy machine that takes longer than the work. Such a late one finds nothing left to do, and all that it
// looks at are the shares, which live as long as it does.
template <class Make, class Work>
void share_out(int count, int threads, int least, Make make, Work work) {
    const auto shares = std::make_shared<Shares>();
    const auto help = [shares, count, &make, &work] {
        ++shares->busy;
        int k = shares->next++;
        if (k < count) {
            auto worker = make();
            for (; k < count; k = shares->next++) work(k, worker);
        }
        --shares->busy;
    };
    try {
        for (int t = 1; t < threads && t * least < count; ++t) std::thread(help).detach();
    } catch (const std::system_error&) {
        // no more threads are to be had: those that there are do it
    }
    help();
    while (shares->busy > 0) std::this_thread::yield();
}

// The same for the rows [begin, end) of many blocks of `flow_block` rows.
template <class Work>
void share_out_rows(int64_t rows, int threads, Work work) {
    const int blocks = static_cast<int>((rows + flow_block - 1) / flow_block);
    share_out(blocks, threads, 32, [] { return 0; }, [&](int b, int) {
        work(int64_t{b} * flow_block, std::min(int64_t{b + 1} * flow_block, rows), b);
    });
}

Mat mat_at(const double* p) {
    Mat m;
    std::copy(p, p + 9, m.m);
    return m;
}

}  // namespace

extern "C" {

int planner_version() { return 13; }

// The cost omega (n,) of manipulability w: 1 up to `low`, zeta from `high` on, and between them as 1 / w (kind 0), -ln w
// (1) or -w (2) goes. By libm's logarithm on every processor: NumPy's differs in the last bits from one to the next.
void manipulability_costs(int64_t n, const double* w, double low, double high, double zeta, int kind, double* costs) {
    const auto fill = [&](auto decreasing) {
        const double best = decreasing(high), worst = decreasing(low), span = worst > best ? worst - best : HUGE_VAL;
        for (int64_t k = 0; k < n; ++k) {
            const double share = (decreasing(std::min(std::max(w[k], low), high)) - best) / span;
            costs[k] = zeta + (1.0 - zeta) * std::min(std::max(share, 0.0), 1.0);
        }
    };
    if (kind == 0) fill([](double x) { return 1.0 / x; });
    if (kind == 1) fill([](double x) { return -std::log(x); });
    if (kind == 2) fill([](double x) { return -x; });
}

// The sums (n,) of the same costs of w (n, states), each times its weight (states,).
void manipulability_cost_sums(int64_t n, int states, const double* w, const double* weights, double low, double high,
                              double zeta, int kind, double* sums) {
    constexpr int64_t at_a_time = 64;  // so that the costs stay in the nearest cache
    std::vector<double> costs(at_a_time * states);
    for (int64_t first = 0; first < n; first += at_a_time) {
        const int64_t count = std::min(at_a_time, n - first);
        manipulability_costs(count * states, w + first * states, low, high, zeta, kind, costs.data());
        for (int64_t k = 0; k < count; ++k) {
            double sum = 0.0;
            for (int state = 0; state < states; ++state) sum += costs[k * states + state] * weights[state];
            sums[first + k] = sum;
        }
    }
}

Chain* chain_new(int dof, const int64_t* parent, const uint8_t* prismatic, const double* turns, const double* offset,
                 const double* slide, const double* axis) {
    auto* chain = new Chain;
    for (int j = 0; j < dof; ++j) {
        Joint joint;
        joint.parent = static_cast<int>(parent[j]), joint.prismatic = prismatic[j];
        for (int k = 0; k < 3; ++k) joint.turns[k] = mat_at(turns + 27 * j + 9 * k);
        joint.offset = vec_at(offset + 3 * j), joint.slide = vec_at(slide + 3 * j), joint.axis = vec_at(axis + 3 * j);
        chain->joints.push_back(joint);
    }
    return chain;
}

void chain_free(Chain* chain) { delete chain; }

// rotation (dof + 1, n, 3, 3), position (dof + 1, n, 3)
void chain_placements(const Chain* chain, int n, const double* q, double* rotation, double* position) {
    std::vector<Frame> frames(chain->dof() + 1);
    for (int k = 0; k < n; ++k) {
        chain->place(q + static_cast<size_t>(k) * chain->dof(), frames.data());
        for (int j = 0; j <= chain->dof(); ++j) {
            const size_t row = static_cast<size_t>(j) * n + k;
            std::copy(frames[j].turn.m, frames[j].turn.m + 9, rotation + 9 * row);
            position[3 * row] = frames[j].shift.x, position[3 * row + 1] = frames[j].shift.y;
            position[3 * row + 2] = frames[j].shift.z;
        }
    }
}

// positions (n, 3) of a point that joint `last` carries
void chain_points(const Chain* chain, int n, const double* q, int last, const double* point, double* positions) {
    const int dof = chain->dof();
    FourScratch scratch(dof);
    Vec found[4];
    for (int first = 0; first < n; first += 4) {
        const int count = std::min(4, n - first);
        for (int l = 0; l < 4; ++l) {  // the last one again where there are fewer
            const double* own = q + static_cast<size_t>(first + std::min(l, count - 1)) * dof;
            for (int j = 0; j < dof; ++j) scratch.q[j][l] = own[j];
        }
        points_of_four(*chain, last, vec_at(point), scratch, found);
        for (int l = 0; l < count; ++l) {
            double* position = positions + 3 * (static_cast<size_t>(first) + l);
            position[0] = found[l].x, position[1] = found[l].y, position[2] = found[l].z;
        }
    }
}

// Lengths (n,) of the paths that a point takes, carried by joint `last`, while q goes straight from start (n, dof) by
// delta (n, dof): chords between pieces (n,) + 1 evenly spaced states.
void chain_path_lengths(const Chain* chain, int n, const double* start, const double* delta, const int64_t* pieces,
                        int last, const double* point, int threads, double* lengths) {
    const int dof = chain->dof();
    share_out(n, threads, 64, [&] { return FourScratch(dof); }, [&](int k, FourScratch& scratch) {
        const double *from = start + static_cast<size_t>(k) * dof, *by = delta + static_cast<size_t>(k) * dof;
        double sum = 0.0;
        Vec before, here[4];
        for (int64_t first = 0; first <= pieces[k]; first += 4) {
            for (int l = 0; l < 4; ++l) {
                const double s = static_cast<double>(first + l) / static_cast<double>(pieces[k]);
                for (int j = 0; j < dof; ++j) scratch.q[j][l] = from[j] + s * by[j];
            }
            points_of_four(*chain, last, vec_at(point), scratch, here);
            for (int64_t piece = first; piece <= std::min(first + 3, pieces[k]); ++piece) {
                if (piece > 0) sum += length(here[piece - first] - before);
                before = here[piece - first];
            }
        }
        lengths[k] = sum;
    });
}

// w (n, states) of a point that joint `last` carries, of the first `rows` rows of its Jacobian, at start + share * delta
// (n, dof) for each of shares (states,).
void chain_manipulability(const Chain* chain, int n, const double* start, const double* delta, int states,
                          const double* shares, int last, const double* point, int rows, int threads, double* w) {
    const int dof = chain->dof();
    const int64_t all = static_cast<int64_t>(n) * states, fours = (all + 3) / 4;
    constexpr int at_a_time = 16;
    share_out(
        static_cast<int>((fours + at_a_time - 1) / at_a_time), threads, 4, [&] { return FourScratch(dof); },
        [&](int part, FourScratch& scratch) {
            const int64_t begin = static_cast<int64_t>(part) * at_a_time, end = std::min(fours, begin + at_a_time);
            for (int64_t four = begin; four < end; ++four) {
                const int64_t first = 4 * four, count = std::min<int64_t>(4, all - first);
                for (int l = 0; l < 4; ++l) {  // the last one again where there are fewer
                    const int64_t k = first + std::min<int64_t>(l, count - 1);
                    const double share = shares[k % states];
                    const double *from = start + k / states * dof, *by = delta + k / states * dof;
                    for (int j = 0; j < dof; ++j) scratch.q[j][l] = from[j] + share * by[j];
                }
                double found[4];
                manipulability_of_four(*chain, last, vec_at(point), rows, scratch, found);
                std::copy(found, found + count, w + first);
            }
        });
}

// Seeds q (n, dof) become where the descents to a target end; distance (n,) m and angle (n,) rad are left there.
void chain_inverse(const Chain* chain, int n, double* q, int last, const double* tool_turn, const double* tool_shift,
                   const double* turn, const double* shift, int oriented, const double* lower, const double* upper,
                   const uint8_t* wraps, int iterations, int threads, double* distance, double* angle) {
    const Task task{*chain, last, {mat_at(tool_turn), vec_at(tool_shift)}, {mat_at(turn), vec_at(shift)},
                    oriented != 0, lower, upper, wraps};
    share_out(n, threads, 8, [&] { return Descent(task); }, [&](int k, Descent& descent) {
        double* own = q + static_cast<size_t>(k) * chain->dof();
        descent.run(own, iterations);
        descent.miss(own, distance[k], angle[k]);
    });
}

// Boxes from low to high in frames (3, 3), (3,) that are given in that of joint `outer`; and a point of joint `inner`.
PointsInBoxes* boxes_new(const Chain* chain, int count, const int64_t* inner, const double* points,
                         const int64_t* outer, const double* turns, const double* shifts, const double* low,
                         const double* high) {
    auto* made = new PointsInBoxes{*chain, {}};
    for (int k = 0; k < count; ++k)
        made->boxes.push_back({static_cast<int>(inner[k]), static_cast<int>(outer[k]), vec_at(points + 3 * k),
                               {mat_at(turns + 9 * k), vec_at(shifts + 3 * k)}, vec_at(low + 3 * k),
                               vec_at(high + 3 * k)});
    return made;
}

void boxes_free(PointsInBoxes* boxes) { delete boxes; }

// The points that lie in their boxes in configurations (n, dof), at most `room` of them: rows (m, 2) of configuration
// and box, and where they are in the box's own frame (m, 3); how many there are in all.
int64_t boxes_hits(const PointsInBoxes* boxes, int n, const double* q, int64_t room, int64_t* rows, double* local) {
    int64_t found = 0;
    boxes->find(n, q, [&](int row, int box, const Vec& at) {
        if (found < room) {
            rows[2 * found] = row, rows[2 * found + 1] = box;
            local[3 * found] = at.x, local[3 * found + 1] = at.y, local[3 * found + 2] = at.z;
        }
        ++found;
    });
    return found;
}

World* world_new(const Chain* chain, double margin) {
    auto* world = new World;
    world->chain = *chain, world->margin = margin;
    return world;
}

void world_free(World* world) { delete world; }

// The shape is given in the frame of what carries it: `joint`, or the world where that is negative.
// kind 0: the convex hull of points (n, 3), rounded by radius; 1: a cylinder by its middle, the vector to a disc's
// middle, and two radii across; 2: the surface of triangles (m, 3, 3) `radius` deep below the hull of points (n, 3)
int world_add(World* world, int joint, int kind, int n, const double* points, double radius, int m,
              const double* triangles) {
    Item item;
    item.joint = joint, item.frame = joint;
    Solid solid;
    if (kind == 0) solid = Solid::of_points(points, n, radius);
    if (kind == 1)
        solid = Solid::of_cylinder(vec_at(points), vec_at(points + 3), vec_at(points + 6), vec_at(points + 9));
    if (kind == 2) solid = Solid::of_triangles(points, n, triangles, m, radius);
    item.solid = std::make_shared<const Solid>(std::move(solid));
    if (joint >= 0) ++world->bodies;
    world->items.push_back(std::move(item));
    return static_cast<int>(world->items.size()) - 1;
}

// Spheres (n,) that together hold body `item`, in its joint's frame; bodies in order.
void world_add_spheres(World* world, int item, int n, const double* centres, const double* radii) {
    world->items[item].first_sphere = static_cast<int>(world->radii.size()), world->items[item].spheres = n;
    for (int k = 0; k < n; ++k) {
        world->sphere_x.push_back(centres[3 * k]), world->sphere_y.push_back(centres[3 * k + 1]);
        world->sphere_z.push_back(centres[3 * k + 2]), world->radii.push_back(radii[k]);
    }
}

// Add what another world of the same arm has as number `item`; its shape is shared. Bodies in order. Its number here.
int world_take(World* world, const World* other, int item) {
    Item taken = other->items[item];
    if (taken.joint >= 0) {
        const int first = taken.first_sphere, last = first + taken.spheres;
        taken.first_sphere = static_cast<int>(world->radii.size());
        for (int k = first; k < last; ++k) {
            world->sphere_x.push_back(other->sphere_x[k]), world->sphere_y.push_back(other->sphere_y[k]);
            world->sphere_z.push_back(other->sphere_z[k]), world->radii.push_back(other->radii[k]);
        }
        ++world->bodies;
    }
    world->items.push_back(std::move(taken));
    return static_cast<int>(world->items.size()) - 1;
}

// Obstacle `item`, given in its own frame, is at poses (n, 3, 3) and (n, 3) at times (n,); between two of them it turns
// about an axis (n - 1, 3) in its own frame at rates (n - 1,), and no point of it exceeds speeds (n - 1,).
void world_set_motion(World* world, int item, int n, const double* times, const double* turns, const double* shifts,
                      const double* axes, const double* rates, const double* speeds) {
    Motion motion;
    motion.last = {mat_at(turns + 9 * (n - 1)), vec_at(shifts + 3 * (n - 1))};
    for (int k = 0; k + 1 < n; ++k) {
        const Vec from = vec_at(shifts + 3 * k), to = vec_at(shifts + 3 * (k + 1));
        motion.stretches.push_back({times[k], times[k + 1], {mat_at(turns + 9 * k), from},
                                    (1.0 / (times[k + 1] - times[k])) * (to - from), vec_at(axes + 3 * k), rates[k],
                                    speeds[k]});
    }
    world->items[item].frame = world->chain.dof() + 1 + static_cast<int>(world->motions.size());
    world->motions.push_back(std::move(motion));
}

// Obstacle `item` may be elsewhere from time 0 on, no point of it farther than `limit` (m/s) times t from where it was.
void world_set_speed_limit(World* world, int item, double limit) { world->items[item].speed_limit = limit; }

// A rounded box or a cylinder that holds a part of obstacle `item`; placement (3, 3) and (3,) in the world.
void world_add_target(World* world, int item, int is_cylinder, const double* turn, const double* shift,
                      const double* half, double radius) {
    Target target;
    Mat t = mat_at(turn);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) target.to_local.turn.m[3 * i + j] = t.m[3 * j + i];
    target.to_local.shift = -(target.to_local.turn * vec_at(shift));
    target.half = vec_at(half), target.radius = radius, target.is_cylinder = is_cylinder;
    world->items[item].targets.push_back(target);
}

// pairs (n, 2) of items, in the order of their numbers
void world_set_pairs(World* world, int n, const int64_t* pairs, const uint8_t* checked) {
    for (int p = 0; p < n; ++p) {
        world->pairs.push_back({static_cast<int>(pairs[2 * p]), static_cast<int>(pairs[2 * p + 1]), checked[p] != 0});
    }
}

// bounds (n, pairs) for placements as chain_placements gives them
void world_coarse(const World* world, int n, const double* rotation, const double* position, double* bounds) {
    Scratch scratch = world->scratch();
    for (int k = 0; k < n; ++k) {
        for (int j = 0; j <= world->chain.dof(); ++j) {
            const size_t row = static_cast<size_t>(j) * n + k;
            scratch.frames[j] = {mat_at(rotation + 9 * row), vec_at(position + 3 * row)};
        }
        world->place_moving(0.0, scratch.frames.data());
        world->coarse(scratch.frames.data(), scratch, bounds + static_cast<size_t>(k) * world->pair_count());
    }
}

// close lower bounds (count,) of numbered pairs in configurations `rows` of n
void world_close(const World* world, int n, const double* rotation, const double* position, int count,
                 const int64_t* rows, const int64_t* pairs, double* bounds) {
    std::vector<Frame> frames(world->chain.dof() + 1 + world->motions.size());
    world->place_moving(0.0, frames.data());
    int64_t placed = -1;
    for (int k = 0; k < count; ++k) {
        if (rows[k] != placed) {
            placed = rows[k];
            for (int j = 0; j <= world->chain.dof(); ++j) {
                const size_t row = static_cast<size_t>(j) * n + placed;
                frames[j] = {mat_at(rotation + 9 * row), vec_at(position + 3 * row)};
            }
        }
        const int pair = static_cast<int>(pairs[k]);
        Vec apart = world->between_middles(pair, frames.data());
        bounds[k] = world->close(pair, frames.data(), apart, Closeness());
    }
}

// Proofs of polynomial pieces (count, degree + 1, dof); reach (pairs, dof), body_reach (bodies, dof), is_static (pairs,). spans (count, 3), or null
// where nothing moves by itself: when each piece begins, how long it takes, and how much sooner or later it may begin, s.
void world_prove(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                 const double* coefficients, const double* spans, int count, int degree, double room, int threads,
                 int64_t* verdict, int64_t* pair, int64_t* samples, double* clearance, double* where) {
    const Pieces pieces{coefficients, count, degree, world->chain.dof()};
    share_out(
        count, threads, 4, [&] { return Prover(*world, reach, body_reach, is_static); },
        [&](int k, Prover& prover) {
            const Span span = spans ? Span{spans[3 * k], spans[3 * k + 1], spans[3 * k + 2]} : Span();
            const Proof proof = prover.prove(pieces, k, room, spans ? &span : nullptr);
            verdict[k] = proof.verdict, pair[k] = proof.pair, samples[k] = proof.samples;
            clearance[k] = proof.clearance, where[k] = proof.where;
        });
}

// Of each of `count` items the first alternative whose motions are all proven, or -1: chosen (count,), where it says at
// first which alternative to begin with. They are those from items[k] to items[k + 1], and the motions of one are the
// pieces from ends[a] to ends[a + 1]. clearance and samples (pieces,) of what was chosen, -1 samples of the others.
void world_first_proven(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                        const double* coefficients, int count, const int64_t* items, const int64_t* ends, double room,
                        int threads, int64_t* chosen, double* clearance, int64_t* samples) {
    const Pieces pieces{coefficients, static_cast<int>(ends[items[count]]), 1, world->chain.dof()};
    std::vector<Proof> proofs(pieces.count);
    for (Proof& proof : proofs) proof.samples = -1;
    share_out(
        count, threads, 2, [&] { return Prover(*world, reach, body_reach, is_static); },
        [&](int k, Prover& prover) {
            const int begin = static_cast<int>(chosen[k]), end = static_cast<int>(items[k + 1] - items[k]);
            chosen[k] = first_proven(prover, pieces, begin, end, ends + items[k], room, proofs.data());
        });
    for (int k = 0; k < pieces.count; ++k) clearance[k] = proofs[k].clearance, samples[k] = proofs[k].samples;
}

// The cheapest chain of proven motions through points (count, dof), of which consecutive ones are proven, by forward
// price (count, count), in which refused ones become infinite: its rows, their number, and clearance and samples of the
// motions to rows[1], rows[2] and so on, -1 samples of those that were proven before.
int world_cheapest_chain(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                         int count, const double* points, double* price, double room, int64_t* rows,
                         double* clearance, int64_t* samples) {
    Prover prover(*world, reach, body_reach, is_static);
    ChainSearch search(prover, count, world->chain.dof(), points, price);
    const std::vector<int> found = search.search(room);
    for (size_t k = 0; k < found.size(); ++k) {
        const Proof* proof = k > 0 ? search.proof(found[k - 1], found[k]) : nullptr;
        rows[k] = found[k], clearance[k] = proof ? proof->clearance : 0.0, samples[k] = proof ? proof->samples : -1;
    }
    return static_cast<int>(found.size());
}

// The first of configurations (n, dof) in which a pair is not farther apart than the margin, or n.
int world_first_near(const World* world, int n, const double* q) {
    Glance glance(*world);
    for (int k = 0; k < n; ++k)
        if (glance.finds_near(q + static_cast<size_t>(k) * world->chain.dof())) return k;
    return n;
}

// Whether no pair is so near in states along the motion from start by delta (dof,): at its end, in its middle, and where
// no point moves further than `step` (m) from one to the next; body_reach (bodies, dof).
int world_motion_looks_free(const World* world, const double* start, const double* delta, const double* body_reach,
                            int bodies, double step) {
    const int dof = world->chain.dof();
    Glance glance(*world);
    std::vector<double> q(dof);
    auto is_near = [&](double share) {
        for (int j = 0; j < dof; ++j) q[j] = start[j] + share * delta[j];
        return glance.finds_near(q.data());
    };
    if (is_near(1.0) || is_near(0.5)) return 0;
    double most = 0.0;
    for (int b = 0; b < bodies; ++b) {
        double motion = 0.0;
        for (int j = 0; j < dof; ++j) motion += body_reach[b * dof + j] * std::fabs(delta[j]);
        most = std::max(most, motion);
    }
    const int count = static_cast<int>(std::ceil(most / step));
    int stride = 1;
    while (2 * stride < count) stride *= 2;
    for (; stride > 0; stride /= 2)  // far apart first, as contacts lie in runs
        for (int k = stride; k < count; k += 2 * stride)
            if (is_near(k / double(count))) return 0;
    return 1;
}

// Lengths (count,) of the shortest paths between pairs (count, 2) of nodes; infinite beyond limits (count,)
void graph_detours(int nodes, int edges, const int64_t* ends, const double* lengths, int count, const int64_t* pairs,
                   const double* limits, int threads, double* detours) {
    const Graph graph(nodes, edges, ends, lengths);
    share_out(
        count, threads, 64, [&] { return DetourSearch(graph); },
        [&](int k, DetourSearch& search) {
            detours[k] =
                search.length(static_cast<int>(pairs[2 * k]), static_cast<int>(pairs[2 * k + 1]), limits[k]);
        });
}

// The cheapest path over arcs (count, 2) from one of `starts` to one of `goals`: its nodes, `path` (nodes,), their number
int graph_cheapest(int nodes, int arcs, const int64_t* ends, const double* costs, int start_count,
                   const int64_t* starts, int goal_count, const int64_t* goals, int64_t* path) {
    CostSearch search(nodes, arcs, ends, costs);
    std::vector<char> is_start(nodes);
    for (int k = 0; k < start_count; ++k) is_start[starts[k]] = 1;
    int count = 0;
    const int start = search.run({goals, goals + goal_count}, nullptr, [&](int node) { return is_start[node]; });
    for (int node = start; node >= 0; node = search.next[node]) path[count++] = node;
    return count;
}

// The cost (nodes,) of the cheapest path over arcs (count, 2) to one of `goals`, their own `values` added
void graph_costs(int nodes, int arcs, const int64_t* ends, const double* costs, int goal_count, const int64_t* goals,
                 const double* values, double* found) {
    CostSearch search(nodes, arcs, ends, costs);
    search.run({goals, goals + goal_count}, values, [](int) { return false; });
    std::copy(search.cost.begin(), search.cost.end(), found);
}

// The quickest motion along `count` stretches: `piece` (count,) says of which piece (., 3, dof) one is the part between
// low and high (count, 2), `joint` (count,) by what x is multiplied behind it; `found` (count, 3) as quickest_motion says
void curve_quickest(int count, int dof, const double* pieces, const int64_t* piece, const double* parts,
                    const double* joint, const double* velocity, const double* acceleration, double* found) {
    std::vector<Stretch> stretches;
    stretches.reserve(count);
    for (int k = 0; k < count; ++k) {
        const double* coefficients = pieces + 3 * dof * piece[k];
        stretches.emplace_back(dof, coefficients, parts[2 * k], parts[2 * k + 1], velocity, acceleration);
        stretches.back().joint = joint[k];
    }
    quickest_motion(stretches, found);
}

// Rows (count,) of `arcs` arcs: `first` (count + 1,), `head` and `offset` (arcs,), `slope` (arcs,) or null
Arcs* arcs_new(int64_t count, int64_t arcs, const int64_t* first, const int64_t* head, const double* slope,
               const double* offset) {
    auto* made = new Arcs{{first, first + count + 1}, {head, head + arcs}, {}, {offset, offset + arcs}};
    if (slope) made->slope.assign(slope, slope + arcs);
    return made;
}

void arcs_free(Arcs* arcs) { delete arcs; }

// m (count,) of rows `index` (count,), or of the first `count`, at states y
void arcs_parent_values(const Arcs* arcs, int64_t count, const int64_t* index, const double* y, int threads,
                        double* m) {
    const Rows rows{count, index};
    share_out_rows(count, threads, [&](int64_t begin, int64_t end, int) {
        for (int64_t k = begin; k < end; ++k) m[k] = arcs->parent_value(rows[k], y);
    });
}

// hops (count,) of nodes whose arcs `head` go from first[n] to first[n + 1]
void arcs_hops(int64_t count, const int64_t* first, const int64_t* head, int64_t source_count, const int64_t* sources,
               int64_t* hops) {
    hops_to_source(count, first, head, source_count, sources, hops);
}

// moved (n,): s after dtau, `order` as in flows.hpp
void flow_moved(const Flow* flow, int order, int64_t n, const double* s, double dtau, int threads, double* moved) {
    share_out_rows(n, threads, [&](int64_t begin, int64_t end, int) {
        for (int64_t k = begin; k < end; ++k) moved[k] = std::abs(s[k]);
        flow_moves(*flow, static_cast<Order>(order), dtau, static_cast<int>(end - begin), moved + begin);
        for (int64_t k = begin; k < end; ++k) moved[k] = std::copysign(moved[k], s[k]);
    });
}

void flow_sketch(const Flow* flow, int64_t count, const int64_t* index, const double* y, const double* xhat,
                 double dtau, int threads, double* next) {
    share_out_rows(count, threads, [&](int64_t begin, int64_t end, int) {
        sketch_rows(*flow, {count, index}, begin, end, y, xhat, dtau, next);
    });
}

double flow_advance(const Flow* flow, int64_t count, const int64_t* index, const double* m, const double* y,
                    const double* xhat, double dtau, double size, int threads, double* next) {
    std::vector<double> off((count + flow_block - 1) / flow_block);
    share_out_rows(count, threads, [&](int64_t begin, int64_t end, int block) {
        off[block] = advance_rows(*flow, {count, index}, begin, end, m, y, xhat, dtau, size, next);
    });
    return count ? *std::max_element(off.begin(), off.end()) : 0.0;
}

// xhat of rows `index` (count,), or of the first `count`; standing (4,): the largest |xhat| of these, the least and the
// largest of the states y (rows,) of all rows, and the least state or parent value of those that move
void arcs_standing(const Arcs* arcs, int64_t count, const int64_t* index, int64_t rows, const double* y, int threads,
                   double* xhat, double* standing) {
    std::vector<Standing> found((rows + flow_block - 1) / flow_block);
    share_out_rows(rows, threads, [&](int64_t begin, int64_t end, int block) {
        found[block] = range_of(y, begin, end);
    });
    share_out_rows(count, threads, [&](int64_t begin, int64_t end, int block) {
        found[block].add(stand_rows(*arcs, {count, index}, begin, end, y, xhat));
    });
    Standing all;
    for (const Standing& part : found) all.add(part);
    standing[0] = all.residual, standing[1] = all.lowest, standing[2] = all.highest, standing[3] = all.lowest_moving;
}

// Rows `index` (count,) of `rows`, or the first `count`, of states y (states,), sketched by `half` and advanced by dtau
// towards their parents there. In `found`, one after the other: the states then (states,), xhat (rows,), arcs_standing's
// four numbers, and what flow_advance returns
void arcs_step(const Arcs* arcs, const Flow* flow, int64_t count, const int64_t* index, int64_t rows, int64_t states,
               const double* y, const double* xhat, double half, double dtau, double size, int threads,
               double* found) {
    double *next = found, *next_xhat = found + states, *standing = next_xhat + rows;
    std::vector<double> mid(y, y + states), m(count);
    flow_sketch(flow, count, index, y, xhat, half, threads, mid.data());
    arcs_parent_values(arcs, count, index, mid.data(), threads, m.data());
    std::copy(y, y + states, next);
    standing[4] = flow_advance(flow, count, index, m.data(), y, xhat, dtau, size, threads, next);
    if (index) std::fill(next_xhat, next_xhat + rows, 0.0);
    arcs_standing(arcs, count, index, rows, next, threads, next_xhat, standing);
}

}  // extern "C"
