// What Python asks of a robot by itself; see ../../library.py for shapes and units.
#pragma once

#include "../costs.hpp"
#include "../inverse.hpp"
#include "../keeping.hpp"
#include "../keeping_proof.hpp"
#include "../refinement.hpp"
#include "../refusals.hpp"
#include "../sharing.hpp"

namespace planner {

namespace {

Mat mat_at(const double* p) {
    Mat m;
    std::copy(p, p + 9, m.m);
    return m;
}

void require_joint(const Chain& chain, int joint) {
    require(joint >= 0 && joint <= chain.size(), "there is no such joint");
}

Tool tool_of(const Chain& chain, int last, const double* point, int rows) {
    require_joint(chain, last);
    require(rows >= 1 && rows <= 6, "a Jacobian has from one to six rows");
    return {last, vec_at(point), rows};
}

Prices prices_of(const double* k, int kind, int at_end, int fewest, const uint8_t* wraps) {
    require(kind >= 0 && kind <= 2, "there is no such kind of cost");
    require(fewest >= 3 && fewest < 1000 && fewest % 2, "Simpson's rule takes an odd number of states");
    require(within(k, 9, infinity) && k[3] > 0.0, "a price is no number, or lengths are divided by none above 0");
    return {{k[0], k[1], k[2], kind}, k[3], k[4], k[5], k[6], k[7], k[8], fewest, at_end != 0, wraps};
}

}  // namespace

extern "C" {

// The cost omega (n,) of manipulability w, see Omega.
int manipulability_costs(int64_t n, const double* w, double low, double high, double zeta, int kind, double* costs) {
    return answered([&] {
        require(kind >= 0 && kind <= 2, "there is no such kind of cost");
        Omega{low, high, zeta, kind}.fill(n, w, costs);
    });
}

// The sums (n,) of the same costs of w (n, states), each times its weight (states,).
int manipulability_cost_sums(int64_t n, int states, const double* w, const double* weights, double low, double high,
                             double zeta, int kind, double* sums) {
    return answered([&] {
        constexpr int64_t at_a_time = 64;  // so that the costs stay in the nearest cache
        std::vector<double> costs(at_a_time * states);
        const Omega omega{low, high, zeta, kind};
        require(kind >= 0 && kind <= 2, "there is no such kind of cost");
        for (int64_t first = 0; first < n; first += at_a_time) {
            heed();
            const int64_t count = std::min(at_a_time, n - first);
            omega.fill(count * states, w + first * states, costs.data());
            for (int64_t k = 0; k < count; ++k) {
                double sum = 0.0;
                for (int state = 0; state < states; ++state) sum += costs[k * states + state] * weights[state];
                sums[first + k] = sum;
            }
        }
    });
}

// Of `joints` in all, each with its leader, one of `dof` planned ones, and the factor and zero that give its value.
Chain* chain_new(int joints, int dof, const int64_t* parent, const uint8_t* prismatic, const double* turns,
                 const double* offset, const double* slide, const double* axis, const int64_t* leader,
                 const double* factor, const double* zero) {
    return answered([&] {
        const size_t count = std::max(joints, 0);
        require(dof >= 1 && dof <= joints, "a chain has at least one joint, and no more planned ones than there are");
        require(within(turns, 27 * count, farthest), "a rotation is no finite number");
        for (const double* vectors : {offset, slide, axis})
            require(within(vectors, 3 * count, farthest), "an offset or an axis is no finite number");
        require(within(factor, count, farthest) && within(zero, count, farthest), "a factor is no finite number");
        require(between(leader, count, 0, dof), "there is no such leader");
        auto chain = std::make_unique<Chain>();
        chain->planned = dof;
        for (int j = 0; j < joints; ++j) {
            require(parent[j] >= 0 && parent[j] <= j, "a joint comes before the one that carries it");
            Joint joint;
            joint.parent = static_cast<int>(parent[j]), joint.prismatic = prismatic[j];
            joint.leader = static_cast<int>(leader[j]), joint.factor = factor[j], joint.zero = zero[j];
            for (int k = 0; k < 3; ++k) joint.turns[k] = mat_at(turns + 27 * j + 9 * k);
            joint.offset = vec_at(offset + 3 * j), joint.slide = vec_at(slide + 3 * j);
            joint.axis = vec_at(axis + 3 * j);
            chain->joints.push_back(joint);
        }
        return chain.release();
    });
}

void chain_free(Chain* chain) { delete chain; }

// rotation (joints + 1, n, 3, 3), position (joints + 1, n, 3)
int chain_placements(const Chain* chain, int n, const double* q, double* rotation, double* position) {
    return answered([&] {
        std::vector<Frame> frames(chain->size() + 1);
        for (int k = 0; k < n; ++k) {
            heed_at(k);
            chain->place(q + static_cast<size_t>(k) * chain->dof(), frames.data());
            for (int j = 0; j <= chain->size(); ++j) {
                const size_t row = static_cast<size_t>(j) * n + k;
                std::copy(frames[j].turn.m, frames[j].turn.m + 9, rotation + 9 * row);
                position[3 * row] = frames[j].shift.x, position[3 * row + 1] = frames[j].shift.y;
                position[3 * row + 2] = frames[j].shift.z;
            }
        }
    });
}

// positions (n, 3) of a point that joint `last` carries
int chain_points(const Chain* chain, int n, const double* q, int last, const double* point, double* positions) {
    return answered([&] {
        require_joint(*chain, last);
        const int dof = chain->dof();
        FourScratch scratch(*chain);
        Vec found[4];
        for (int first = 0; first < n; first += 4) {
            heed_at(first);
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
    });
}

// Lengths (n,) of the paths that a point takes, carried by joint `last`, while q goes straight from start (n, dof) by
// delta (n, dof): chords between pieces (n,) + 1 evenly spaced states.
int chain_path_lengths(const Chain* chain, int n, const double* start, const double* delta, const int64_t* pieces,
                       int last, const double* point, int threads, double* lengths) {
    return answered([&] {
        require_joint(*chain, last);
        require(between(pieces, n, 1, INT32_MAX), "a path has at least one piece");
        const int dof = chain->dof();
        share_out(
            n, threads, 64, [&] { return FourScratch(*chain); },
            [&](int k, FourScratch& scratch) {
                const double *from = start + static_cast<size_t>(k) * dof, *by = delta + static_cast<size_t>(k) * dof;
                lengths[k] = path_length(*chain, last, vec_at(point), from, by, pieces[k], scratch);
            });
    });
}

// w (n, states) of a point that joint `last` carries, of the first `rows` rows of its Jacobian, at start + share * delta
// (n, dof) for each of shares (states,).
int chain_manipulability(const Chain* chain, int n, const double* start, const double* delta, int states,
                         const double* shares, int last, const double* point, int rows, int threads, double* w) {
    return answered([&] {
        require_joint(*chain, last);
        require(rows >= 1 && rows <= 6, "a Jacobian has from one to six rows");
        const int dof = chain->dof();
        const int64_t all = static_cast<int64_t>(n) * states, fours = (all + 3) / 4;
        constexpr int at_a_time = 16;
        share_out(
            static_cast<int>((fours + at_a_time - 1) / at_a_time), threads, 4, [&] { return FourScratch(*chain); },
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
    });
}

// What motions from start to end (n, dof) cost (n,), see Prices; `numbers`: low, high, zeta of omega, unit, beta, floor,
// longest, spacing, chord.
int chain_motion_costs(const Chain* chain, int last, const double* point, int rows, const double* numbers, int kind,
                       int at_end, int fewest, const uint8_t* wraps, int threads, int n, const double* start,
                       const double* end, double* costs) {
    return answered([&] {
        const Tool tool = tool_of(*chain, last, point, rows);
        const Prices prices = prices_of(numbers, kind, at_end, fewest, wraps);
        constexpr int at_a_time = 16;
        const size_t dof = chain->dof();
        share_out((n + at_a_time - 1) / at_a_time, threads, 2, [&] { return Pricing(*chain, tool, prices); },
                  [&](int part, Pricing& pricing) {
                      const size_t first = static_cast<size_t>(part) * at_a_time;
                      const int count = std::min(at_a_time, n - static_cast<int>(first));
                      pricing.price(count, start + first * dof, end + first * dof, costs + first);
                  });
    });
}

// Seeds q (n, dof) become where the descents to their targets end, turns (n, 3, 3) and shifts (n, 3); distance (n,) m and
// angle (n,) rad are left there. `rows` and `weight` as in Task.
int chain_inverse(const Chain* chain, int n, double* q, int last, const double* tool_turn, const double* tool_shift,
                  const double* turns, const double* shifts, int rows, double weight, const double* lower,
                  const double* upper, const uint8_t* wraps, int iterations, int threads, double* distance,
                  double* angle) {
    return answered([&] {
        require_joint(*chain, last);
        require(rows == 3 || rows == 5 || rows == 6, "a target has 3, 5 or 6 rows");
        require(weight > 0.0 && weight <= farthest, "a metre has no weight");
        const Task task{*chain, last, {mat_at(tool_turn), vec_at(tool_shift)}, rows, weight, lower, upper, wraps};
        share_out(
            n, threads, 8, [&] { return Descent(task); },
            [&](int k, Descent& descent) {
                double* own = q + static_cast<size_t>(k) * chain->dof();
                const size_t row = k;
                descent.run(own, {mat_at(turns + 9 * row), vec_at(shifts + 3 * row)}, iterations);
                descent.miss(own, distance[k], angle[k]);
            });
    });
}

// Frames (frames,) that joints carry, with as many pieces as `pieces` (frames + 1,) says; each of these has the rows
// (r, 12) and centres (r,) from one of `ends` (all + 1,) to the next, and a limit and a depth (all,). Joints (dof,) have
// limits where they do not wrap.
Keeping* keeping_new(const Chain* chain, int frames, const int64_t* joints, const double* turns, const double* shifts,
                     const int64_t* pieces, const int64_t* ends, const uint8_t* balls, const double* rows,
                     const double* centres, const double* limits, const double* depths, const double* lower,
                     const double* upper, const uint8_t* wraps) {
    return answered([&] {
        require(between(joints, frames, 0, chain->size() + 1), "there is no such joint");
        const int64_t all = pieces[frames], total = ends[all];
        require(are_offsets(pieces, frames, all) && are_offsets(ends, all, total), "pieces are not in order");
        require(within(turns, 9 * static_cast<size_t>(frames), farthest) &&
                    within(shifts, 3 * static_cast<size_t>(frames), farthest),
                "a frame is no finite number");
        require(within(rows, 12 * total, farthest) && within(centres, total, farthest) &&
                    within(limits, all, farthest) && within(depths, all, farthest),
                "a condition is no finite number");
        const int dof = chain->dof();
        std::unique_ptr<Keeping> made(new Keeping{*chain,
                                                  {},
                                                  {},
                                                  {rows, rows + 12 * total},
                                                  {centres, centres + total},
                                                  {lower, lower + dof},
                                                  {upper, upper + dof},
                                                  {wraps, wraps + dof}});
        for (int k = 0; k < frames; ++k)
            made->frames.push_back({static_cast<int>(joints[k]),
                                    {mat_at(turns + 9 * k), vec_at(shifts + 3 * k)},
                                    static_cast<int>(pieces[k]),
                                    static_cast<int>(pieces[k + 1])});
        for (int64_t k = 0; k < all; ++k) {
            require(balls[k] || ends[k + 1] == ends[k] + 1, "a half-space has one row");
            made->pieces.push_back(
                {static_cast<int>(ends[k]), static_cast<int>(ends[k + 1]), balls[k] != 0, limits[k], depths[k]});
        }
        return made.release();
    });
}

void keeping_free(Keeping* keeping) { delete keeping; }

// What each piece of a frame has to spare (n, pieces) at its poses: rotations (n, 3, 3) and positions (n, 3).
int keeping_slack(const Keeping* keeping, int frame, int n, const double* turns, const double* shifts, double* slack) {
    return answered([&] {
        require(frame >= 0 && frame < static_cast<int>(keeping->frames.size()), "there is no such frame");
        const KeptFrame& kept = keeping->frames[frame];
        for (int row = 0; row < n; ++row) {
            heed_at(row);
            double y[12];
            std::copy(shifts + 3 * static_cast<size_t>(row), shifts + 3 * static_cast<size_t>(row) + 3, y);
            std::copy(turns + 9 * static_cast<size_t>(row), turns + 9 * static_cast<size_t>(row) + 9, y + 3);
            for (int k = kept.first; k < kept.behind; ++k) *slack++ = keeping->slack(keeping->pieces[k], y);
        }
    });
}

// States q (n, dof) become states near them that keep all but for `exact`, and `good` (n,) says which do; `depth` (n,).
int keeping_project(const Keeping* keeping, int n, double* q, const double* depth, double exact, int steps, int threads,
                    uint8_t* good) {
    return answered([&] {
        share_out(
            n, threads, 64, [&] { return Projection(*keeping); },
            [&](int k, Projection& projection) {
                good[k] = projection.run(q + static_cast<size_t>(k) * keeping->chain.dof(), depth[k], exact, steps);
            });
    });
}

// `good` (n,) says which curves (n, degree + 1, dof) are proven to keep all; bounds as in KeptBounds.
int keeping_prove(const Keeping* keeping, int n, int degree, const double* curves, const double* reach,
                  const double* rates, const double* turns, const double* per_metre, const double* per_turn,
                  double forgiven, double finest, int threads, uint8_t* good) {
    return answered([&] {
        const size_t dof = keeping->chain.dof(), frames = keeping->frames.size(), pieces = keeping->pieces.size();
        const size_t size = (degree + 1) * dof;
        require(degree >= 0 && degree <= highest_degree, "the curves are of a higher degree than is supported");
        require(within(curves, n * size, farthest), "a coefficient is no finite number");
        require(not_negative(reach, frames * dof, farthest) && not_negative(rates, frames * dof * dof, farthest) &&
                    not_negative(turns, frames * dof, farthest) && not_negative(per_metre, pieces, farthest) &&
                    not_negative(per_turn, pieces, farthest),
                "a bound is no finite number, or negative");
        require(forgiven >= 0.0 && finest > 0.0, "what is forgiven is negative, or pieces have no finest size");
        const KeptBounds bounds{reach, rates, turns, per_metre, per_turn, forgiven, finest};
        share_out(
            n, threads, 64, [&] { return KeptProof(*keeping, bounds, degree); },
            [&](int k, KeptProof& proof) { good[k] = proof.holds(curves + k * size); });
    });
}

// Boxes from low to high in frames (3, 3), (3,) that are given in that of joint `outer`; and a point of joint `inner`.
PointsInBoxes* boxes_new(const Chain* chain, int count, const int64_t* inner, const double* points,
                         const int64_t* outer, const double* turns, const double* shifts, const double* low,
                         const double* high) {
    return answered([&] {
        for (const int64_t* joints : {inner, outer})
            require(between(joints, count, 0, chain->size() + 1), "there is no such joint");
        for (const double* vectors : {points, shifts, low, high})
            require(within(vectors, 3 * static_cast<size_t>(count), farthest), "a point or a box is no finite number");
        require(within(turns, 9 * static_cast<size_t>(count), farthest), "a rotation is no finite number");
        std::unique_ptr<PointsInBoxes> made(new PointsInBoxes{*chain, {}});
        for (int k = 0; k < count; ++k)
            made->boxes.push_back({static_cast<int>(inner[k]),
                                   static_cast<int>(outer[k]),
                                   vec_at(points + 3 * k),
                                   {mat_at(turns + 9 * k), vec_at(shifts + 3 * k)},
                                   vec_at(low + 3 * k),
                                   vec_at(high + 3 * k)});
        return made.release();
    });
}

void boxes_free(PointsInBoxes* boxes) { delete boxes; }

// The points that lie in their boxes in configurations (n, dof), at most `room` of them: rows (m, 2) of configuration
// and box, and where they are in the box's own frame (m, 3); how many there are in all.
int64_t boxes_hits(const PointsInBoxes* boxes, int n, const double* q, int64_t room, int64_t* rows, double* local) {
    return answered([&] {
        require(within(q, static_cast<size_t>(n) * boxes->chain.dof(), farthest), "a joint value is no finite number");
        int64_t found = 0;
        boxes->find(n, q, [&](int row, int box, const Vec& at) {
            if (found < room) {
                rows[2 * found] = row, rows[2 * found + 1] = box;
                local[3 * found] = at.x, local[3 * found + 1] = at.y, local[3 * found + 2] = at.z;
            }
            ++found;
        });
        return found;
    });
}

}  // extern "C"

}  // namespace planner
