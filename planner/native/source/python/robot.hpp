// Bindings of a robot: joint tree, costs of motions, constraints, points in boxes.
#pragma once

#include "../costs.hpp"
#include "../inverse.hpp"
#include "../pose_constraints.hpp"
#include "../constraint_proof.hpp"
#include "../refinement.hpp"
#include "../sharing.hpp"
#include "arrays.hpp"

namespace planner {

inline Mat mat_at(const double* p) {
    Mat m;
    std::copy(p, p + 9, m.m);
    return m;
}
inline Frame frame_at(const double* turns, const double* shifts, size_t k) {
    return {mat_at(turns + 9 * k), vec_at(shifts + 3 * k)};
}

inline void require_joint(const Chain& chain, int joint) {
    require(joint >= 0 && joint <= chain.size(), "there is no such joint");
}

using RowSpan = std::pair<int, int>;  // first row of a Jacobian, and the one behind the last

// Joints (k,) with a point each (k, 3), and the rows of their Jacobians.
using ToolsGiven = std::tuple<Ints<any>, Floats<any, 3>, RowSpan>;

inline Tools tools_of(const Chain& chain, const ToolsGiven& given) {
    const auto& [joints, points, rows] = given;
    const int count = joints.count();
    require(count >= 1, "there is no tool");
    points.of({count, 3});
    require(rows.first >= 0 && rows.first < rows.second && rows.second <= 6, "a Jacobian has from one to six rows");
    Tools tools{{}, {rows.first, rows.second}};
    for (int k = 0; k < count; ++k) {
        require(joints[k] >= 0 && joints[k] <= chain.size(), "there is no such joint");
        tools.points.push_back({static_cast<int>(joints[k]), vec_at(points + 3 * k)});
    }
    return tools;
}

// Leaders, factors and zeros; by default every joint is planned.
using Following = std::tuple<Ints<any>, Floats<any>, Floats<any>>;

inline Chain chain_of(const Ints<any>& parent, const Bools& prismatic, const Floats<any, 3, 3, 3>& turns,
                      const Floats<any, 3>& offset, const Floats<any, 3>& slide, const Floats<any, 3>& axis,
                      const std::optional<Following>& following) {
    const int64_t joints = parent.count();
    prismatic.of({joints}), turns.of({joints, 3, 3, 3}), offset.of({joints, 3}), slide.of({joints, 3});
    axis.of({joints, 3});
    for (const auto* numbers : {&offset, &slide, &axis})
        require(within(*numbers, numbers->size(), farthest), "an offset or an axis is no finite number");
    require(within(turns, turns.size(), farthest), "a rotation is no finite number");
    Chain chain;
    for (int j = 0; j < joints; ++j) {
        require(parent[j] >= 0 && parent[j] <= j, "a joint comes before the one that carries it");
        Joint joint;
        joint.parent = static_cast<int>(parent[j]), joint.prismatic = prismatic[j];
        joint.leader = j, joint.factor = 1.0, joint.zero = 0.0;
        if (following) {
            const auto& [leader, factor, zero] = *following;
            leader.of({joints}), factor.of({joints}), zero.of({joints});
            require(leader[j] >= 0 && leader[j] < joints, "there is no such leader");
            require(within(factor + j, 1, farthest) && within(zero + j, 1, farthest), "a factor is no finite number");
            joint.leader = static_cast<int>(leader[j]), joint.factor = factor[j], joint.zero = zero[j];
        }
        for (int k = 0; k < 3; ++k) joint.turns[k] = mat_at(turns + 27 * j + 9 * k);
        joint.offset = vec_at(offset + 3 * j), joint.slide = vec_at(slide + 3 * j);
        joint.axis = vec_at(axis + 3 * j);
        chain.planned = std::max(chain.planned, joint.leader + 1);
        chain.joints.push_back(joint);
    }
    require(chain.planned >= 1, "a chain has at least one joint");
    return chain;
}

inline auto placements(const Chain& chain, const States& q) {
    const size_t n = q.of({any, chain.dof()}).count(), frames_of = chain.size() + 1;
    Made<double, 4> rotation(frames_of, n, 3, 3);
    Made<double, 3> position(frames_of, n, 3);
    std::vector<Frame> frames(frames_of);
    for (size_t k = 0; k < n; ++k) {
        poll_signal_at(static_cast<int64_t>(k));
        chain.place(q + k * chain.dof(), frames.data());
        for (size_t j = 0; j < frames_of; ++j) {
            const size_t row = j * n + k;
            std::copy(frames[j].turn.m, frames[j].turn.m + 9, rotation + 9 * row);
            position[3 * row] = frames[j].shift.x, position[3 * row + 1] = frames[j].shift.y;
            position[3 * row + 2] = frames[j].shift.z;
        }
    }
    return std::tuple{std::move(rotation), std::move(position)};
}

inline Made<double, 2> points(const Chain& chain, const States& q, int last, const Floats<3>& point) {
    require_joint(chain, last);
    const int dof = chain.dof(), n = q.of({any, dof}).count();
    Made<double, 2> positions(n, 3);
    FourScratch scratch(chain);
    Vec found[4];
    for (int first = 0; first < n; first += 4) {
        poll_signal_at(first);
        const int count = std::min(4, n - first);
        for (int l = 0; l < 4; ++l) {  // the last one again where there are fewer
            const double* own = q + static_cast<size_t>(first + std::min(l, count - 1)) * dof;
            for (int j = 0; j < dof; ++j) scratch.q[j][l] = own[j];
        }
        points_of_four(chain, last, vec_at(point), scratch, found);
        for (int l = 0; l < count; ++l) {
            double* position = positions + 3 * (static_cast<size_t>(first) + l);
            position[0] = found[l].x, position[1] = found[l].y, position[2] = found[l].z;
        }
    }
    return positions;
}

inline Made<double, 1> path_lengths(const Chain& chain, const States& start, const States& delta,
                                    const Ints<any>& pieces, int last, const Floats<3>& point) {
    require_joint(chain, last);
    const int dof = chain.dof(), n = start.of({any, dof}).count();
    require(between(pieces.of({n}), n, 1, INT32_MAX), "a path has at least one piece");
    delta.of({n, dof});
    Made<double, 1> lengths(n);
    share_out(
        n, 64, [&] { return FourScratch(chain); },
        [&](int k, FourScratch& scratch) {
            const double *from = start + static_cast<size_t>(k) * dof, *by = delta + static_cast<size_t>(k) * dof;
            lengths[k] = path_length(chain, last, vec_at(point), from, by, pieces[k], scratch);
        });
    return lengths;
}

// w (all,) of tools where joint j has the value `at(k, j)`, four robots at a time.
template <class At>
void fill_manipulability(const Chain& chain, const Tools& tools, int64_t all, const At& at, double* w) {
    const int64_t fours = (all + 3) / 4;
    constexpr int at_a_time = 16;
    share_out(
        static_cast<int>((fours + at_a_time - 1) / at_a_time), 4, [&] { return FourScratch(chain); },
        [&](int part, FourScratch& scratch) {
            const int64_t begin = static_cast<int64_t>(part) * at_a_time, end = std::min(fours, begin + at_a_time);
            for (int64_t first = 4 * begin; first < 4 * end; first += 4) {
                const int64_t count = std::min<int64_t>(4, all - first);
                for (int l = 0; l < 4; ++l)  // the last one again where there are fewer
                    for (int j = 0; j < chain.dof(); ++j)
                        scratch.q[j][l] = at(first + std::min<int64_t>(l, count - 1), j);
                double found[4];
                manipulability_of_four(chain, tools.points, tools.rows, scratch, found);
                std::copy(found, found + count, w + first);
            }
        });
}

inline Made<double, 1> manipulability(const Chain& chain, const States& q, const ToolsGiven& tools) {
    const int dof = chain.dof();
    Made<double, 1> w(q.of({any, dof}).count());
    fill_manipulability(chain, tools_of(chain, tools), w.size(), [&](int64_t k, int j) { return q[k * dof + j]; }, w);
    return w;
}

inline Made<double, 2> manipulability_along(const Chain& chain, const States& start, const States& delta,
                                            const Floats<any>& shares, const ToolsGiven& tools) {
    const int dof = chain.dof(), states = shares.count(), n = start.of({any, dof}).count();
    delta.of({n, dof});
    Made<double, 2> w(n, states);
    const auto at = [&](int64_t k, int j) {
        return start[k / states * dof + j] + shares[k % states] * delta[k / states * dof + j];
    };
    fill_manipulability(chain, tools_of(chain, tools), w.size(), at, w);
    return w;
}

using JointLimits = std::tuple<Floats<any>, Floats<any>, Bools>;  // lowest, highest, and which joints wrap

inline Frame placed_at(const double* m) {  // (4, 4)
    return {{{m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}}, {m[3], m[7], m[11]}};
}

inline auto solve_inverse(const Chain& chain, const States& seeds, const Ints<any>& joints,
                          const Floats<any, 4, 4>& tools, const Ints<any>& rows, const Floats<any, any, 4, 4>& targets,
                          const JointLimits& limits, int iterations, double weight) {
    const size_t dof = chain.dof(), n = seeds.of({any, chain.dof()}).count(), count = joints.count();
    const size_t step = targets.count() == 1 ? 0 : 16 * count;
    const auto& [lower, upper, wraps] = limits;
    lower.of({chain.dof()}), upper.of({chain.dof()}), wraps.of({chain.dof()});
    tools.of({joints.count(), 4, 4}), rows.of({joints.count()}), targets.of({any, joints.count(), 4, 4});
    require(targets.count() == 1 || targets.count() == seeds.count(), "there is not one target for each seed");
    require(weight > 0.0 && weight <= farthest, "a metre has no weight");
    Task task{chain, {}, weight, lower, upper, bytes_of(wraps)};
    for (size_t k = 0; k < count; ++k) {
        require(joints[k] >= 0 && joints[k] <= chain.size(), "there is no such joint");
        require(rows[k] == 3 || rows[k] == 5 || rows[k] == 6, "a tool has 3, 5 or 6 rows");
        task.tools.push_back({static_cast<int>(joints[k]), placed_at(tools + 16 * k), static_cast<int>(rows[k])});
    }
    Made<double, 2> ends = copy_into(seeds.data(), Made<double, 2>(n, dof));
    Made<double, 1> distance(n), angle(n);
    share_out(
        static_cast<int>(n), 8, [&] { return Descent(task); },
        [&](size_t k, Descent& descent) {
            std::vector<Frame> own(count);
            for (size_t tool = 0; tool < count; ++tool) own[tool] = placed_at(targets + k * step + 16 * tool);
            descent.run(ends + k * dof, own, iterations);
            descent.miss(ends + k * dof, distance[k], angle[k]);
        });
    return std::tuple{std::move(ends), std::move(distance), std::move(angle)};
}

inline Omega omega_of(double low, double high, double zeta, int kind) {
    require(kind >= 0 && kind <= 2, "there is no such kind of cost");
    return {low, high, zeta, kind};
}

inline Made<double, 1> manipulability_costs(const Floats<any>& w, double low, double high, double zeta, int kind) {
    Made<double, 1> costs(w.size());
    omega_of(low, high, zeta, kind).fill(static_cast<int64_t>(w.size()), w, costs);
    return costs;
}

inline Made<double, 1> manipulability_cost_sums(const States& w, const Floats<any>& weights, double low, double high,
                                                double zeta, int kind) {
    constexpr int64_t at_a_time = 64;  // the costs fit the first-level cache
    const int64_t n = w.count(), states = w.count(1);
    weights.of({states});
    Made<double, 1> sums(n);
    std::vector<double> costs(at_a_time * states);
    const Omega omega = omega_of(low, high, zeta, kind);
    for (int64_t first = 0; first < n; first += at_a_time) {
        poll_signal();
        const int64_t count = std::min(at_a_time, n - first);
        omega.fill(count * states, w + first * states, costs.data());
        for (int64_t k = 0; k < count; ++k) {
            double sum = 0.0;
            for (int64_t state = 0; state < states; ++state) sum += costs[k * states + state] * weights[state];
            sums[first + k] = sum;
        }
    }
    return sums;
}

// A measure that a Python function computes, from configurations (n, dof) to values (n,).
struct MeasureOfPython : Measure {
    nb::callable function;
    int dof;

    MeasureOfPython(nb::callable given, int width) : function(std::move(given)), dof(width) {}

    void fill(size_t n, const double* q, double* w) const override {
        const nb::gil_scoped_acquire python;
        Made<double, 2> states = copy_into(q, Made<double, 2>(n, dof));
        const auto values = nb::cast<Floats<any>>(function(std::move(states)));
        values.of({static_cast<int64_t>(n)});
        std::copy(values.data(), values.data() + n, w);
    }
};

// Costs of motions of an arm.
struct Charge {
    Chain chain;
    std::unique_ptr<Measure> measure;
    Tools tools;
    std::vector<uint8_t> wraps;
    Prices prices;

    // `numbers`: low, high, zeta of omega, unit, beta, floor, longest, spacing, chord, see Prices.
    Charge(const Chain& of, const std::array<double, 9>& numbers, int kind, bool at_end, int fewest,
           const Bools& wrapping, const ToolsGiven& given, const std::optional<nb::callable>& function)
        : chain(of), measure(function ? std::make_unique<MeasureOfPython>(*function, of.dof()) : nullptr),
          tools(tools_of(of, given)), wraps(wrapping.of({of.dof()}).data(), wrapping.data() + of.dof()),
          prices{omega_of(numbers[0], numbers[1], numbers[2], kind),
                 numbers[3],
                 numbers[4],
                 numbers[5],
                 numbers[6],
                 numbers[7],
                 numbers[8],
                 fewest,
                 at_end,
                 wraps.data()} {
        tools.measure = measure.get();
        require(fewest >= 3 && fewest < 1000 && fewest % 2, "Simpson's rule takes an odd number of states");
        require(within(numbers.data(), 9, infinity) && numbers[3] > 0.0,
                "a price is no number, or lengths are divided by none above 0");
    }
    Charge(const Charge&) = delete;  // the prices point to `wraps`

    Made<double, 1> costs(const States& start, const States& end) const {
        constexpr int at_a_time = 16;
        const int dof = chain.dof(), n = start.of({any, dof}).count();
        end.of({n, dof});
        Made<double, 1> found(n);
        share_out((n + at_a_time - 1) / at_a_time, 2, [&] { return Pricing(chain, tools, prices); },
                  [&](int part, Pricing& pricing) {
                      const size_t first = static_cast<size_t>(part) * at_a_time;
                      const int count = std::min(at_a_time, n - static_cast<int>(first));
                      pricing.price(count, start + first * dof, end + first * dof, found + first);
                  });
        return found;
    }
};

inline PoseConstraints constraints_of(const Chain& chain, const Ints<any>& joints, const Floats<any, 4, 4>& placed,
                                      const Ints<any>& pieces, const Ints<any>& counts, const Bools& balls,
                                      const Floats<any, 12>& rows, const Floats<any>& centres,
                                      const Floats<any>& limits, const Floats<any>& depths,
                                      const JointLimits& of_joints, const Ints<any>& bases,
                                      const Floats<any, 4, 4>& bases_placed) {
    const int frames = joints.count(), all = counts.count(), total = rows.count(), dof = chain.dof();
    const auto& [lower, upper, wraps] = of_joints;
    bases.of({frames}), bases_placed.of({frames, 4, 4});
    require(between(bases, frames, -1, chain.size() + 1), "there is no such joint");
    require(within(bases_placed, bases_placed.size(), farthest), "a frame is no finite number");
    placed.of({frames, 4, 4}), pieces.of({frames}), balls.of({all}), centres.of({total}), limits.of({all});
    depths.of({all}), lower.of({dof}), upper.of({dof}), wraps.of({dof});
    require(between(joints, frames, 0, chain.size() + 1), "there is no such joint");
    require(between(pieces, frames, 0, all + 1) && between(counts, all, 0, total + 1) &&
                std::accumulate(pieces + 0, pieces + frames, 0) == all &&
                std::accumulate(counts + 0, counts + all, 0) == total,
            "the numbers of pieces and rows do not fit each other");
    require(within(placed, placed.size(), farthest), "a frame is no finite number");
    require(within(rows, rows.size(), farthest) && within(centres, total, farthest) && within(limits, all, farthest) &&
                within(depths, all, farthest),
            "a condition is no finite number");
    PoseConstraints made{chain,
                         {},
                         {},
                         {rows + 0, rows + rows.size()},
                         {centres + 0, centres + total},
                         {lower + 0, lower + dof},
                         {upper + 0, upper + dof},
                         {wraps + 0, wraps + dof}};
    int first = 0;
    for (int k = 0; k < frames; ++k) {
        made.frames.push_back({static_cast<int>(joints[k]), placed_at(placed + 16 * k), first,
                               first + static_cast<int>(pieces[k]), static_cast<int>(bases[k]),
                               placed_at(bases_placed + 16 * k)});
        first = made.frames.back().behind;
    }
    first = 0;
    for (int k = 0; k < all; ++k) {
        require(balls[k] || counts[k] == 1, "a half-space has one row");
        made.pieces.push_back({first, first + static_cast<int>(counts[k]), balls[k], limits[k], depths[k]});
        first = made.pieces.back().behind;
    }
    return made;
}

inline Made<double, 2> slack(const PoseConstraints& keeping, int frame, const Floats<any, 3, 3>& turns,
                             const Floats<any, 3>& shifts) {
    require(frame >= 0 && frame < static_cast<int>(keeping.frames.size()), "there is no such frame");
    const ConstrainedFrame& kept = keeping.frames[frame];
    const int n = turns.count();
    shifts.of({n, 3});
    Made<double, 2> found(n, kept.behind - kept.first);
    double* next = found;
    for (int row = 0; row < n; ++row) {
        poll_signal_at(row);
        double y[12];
        std::copy_n(shifts + 3 * static_cast<size_t>(row), 3, y);
        std::copy_n(turns + 9 * static_cast<size_t>(row), 9, y + 3);
        for (int k = kept.first; k < kept.behind; ++k) *next++ = keeping.slack(keeping.pieces[k], y);
    }
    return found;
}

inline auto projected(const PoseConstraints& keeping, const States& q, const Floats<any>& depth, double exact,
                      int steps) {
    const int dof = keeping.chain.dof(), n = q.of({any, dof}).count();
    depth.of({n});
    Made<double, 2> states = copy_into(q.data(), Made<double, 2>(n, dof));
    Made<bool, 1> good(n);
    share_out(
        n, 64, [&] { return Projection(keeping); },
        [&](size_t k, Projection& projection) { good[k] = projection.run(states + k * dof, depth[k], exact, steps); });
    return std::tuple{std::move(states), std::move(good)};
}

// Bounds on the deviation of frames (f,) from their chords, and its effect on the slack of constraints (p,).
using KeptLimits = std::tuple<Floats<any, any>, Floats<any, any, any>, Floats<any, any>, Floats<any>, Floats<any>>;

inline Made<bool, 1> keeps_all(const PoseConstraints& keeping, const Coefficients& curves, const KeptLimits& limits,
                               double forgiven, double finest) {
    const int64_t dof = keeping.chain.dof(), frames = keeping.frames.size(), pieces = keeping.pieces.size();
    const int n = curves.of({any, any, dof}).count(), degree = curves.count(1) - 1;
    const auto& [reach, rates, turns, per_metre, per_turn] = limits;
    reach.of({frames, dof}), rates.of({frames, dof, dof}), turns.of({frames, dof});
    per_metre.of({pieces}), per_turn.of({pieces});
    require(degree >= 0 && degree <= highest_degree, "the curves are of a higher degree than is supported");
    require(within(curves, curves.size(), farthest), "a coefficient is no finite number");
    require(not_negative(reach, reach.size(), farthest) && not_negative(rates, rates.size(), farthest) &&
                not_negative(turns, turns.size(), farthest) && not_negative(per_metre, pieces, farthest) &&
                not_negative(per_turn, pieces, farthest),
            "a bound is no finite number, or negative");
    require(forgiven >= 0.0 && finest > 0.0, "what is forgiven is negative, or pieces have no finest size");
    const ConstraintBounds bounds{reach, rates, turns, per_metre, per_turn, forgiven, finest};
    Made<bool, 1> good(n);
    share_out(
        n, 64, [&] { return ConstraintProof(keeping, bounds, degree); },
        [&](size_t k, ConstraintProof& proof) { good[k] = proof.holds(curves + k * (degree + 1) * dof); });
    return good;
}

inline PointsInBoxes boxes_of(const Chain& chain, const Ints<any>& inner, const Floats<any, 3>& points,
                              const Ints<any>& outer, const Floats<any, 3, 3>& turns, const Floats<any, 3>& shifts,
                              const Floats<any, 3>& low, const Floats<any, 3>& high) {
    const int64_t count = inner.count();
    for (const auto* joints : {&inner, &outer})
        require(between(joints->of({count}), count, 0, chain.size() + 1), "there is no such joint");
    for (const auto* vectors : {&points, &shifts, &low, &high})
        require(within(vectors->of({count, 3}), vectors->size(), farthest), "a point or a box is no finite number");
    require(within(turns.of({count, 3, 3}), turns.size(), farthest), "a rotation is no finite number");
    PointsInBoxes made{chain, {}, {}};
    for (int k = 0; k < count; ++k)
        made.add({static_cast<int>(inner[k]), static_cast<int>(outer[k]), vec_at(points + 3 * k),
                  frame_at(turns, shifts, k), vec_at(low + 3 * k), vec_at(high + 3 * k)});
    return made;
}

inline auto hits(const PointsInBoxes& boxes, const States& q) {
    require(within(q.of({any, boxes.chain.dof()}), q.size(), farthest), "a joint value is no finite number");
    std::vector<int64_t> rows;
    std::vector<double> local;
    boxes.find(q.count(), q, [&](int row, int box, const Vec& at) {
        rows.insert(rows.end(), {row, box});
        local.insert(local.end(), {at.x, at.y, at.z});
    });
    return std::tuple{copy_into(rows.data(), Made<int64_t, 2>(rows.size() / 2, 2)),
                      copy_into(local.data(), Made<double, 2>(local.size() / 3, 3))};
}

inline void bind_robot(nb::module_& m) {
    nb::class_<Chain>(m, "NativeChain", "The joint tree of a robot; arrays as in kinematics.forward.Chain.")
        .def("__init__", construct_by(&chain_of), "parent"_a, "prismatic"_a, "rotations"_a, "offset"_a, "slide"_a,
             "axis"_a, "following"_a = nb::none(),
             "following: leader, factor and zero (joints,); by default every joint is planned.")
        .def_prop_ro("joints", &Chain::size)
        .def_prop_ro("dof", &Chain::dof)
        .def("placements", &placements, "q"_a, at_work,
             "Return world rotations (joints + 1, n, 3, 3) and positions (joints + 1, n, 3) of the base and all\n"
             "joints.")
        .def("points", &points, "q"_a, "joint"_a, "point"_a, at_work,
             "Return positions (n, 3) of a point on a joint (0: the base).")
        .def("path_lengths", &path_lengths, "start"_a, "delta"_a, "pieces"_a, "joint"_a, "point"_a, at_work,
             "Return lengths (n,) of the paths of a point along straight joint motions from start by delta (n,\n"
             "dof), by chords between pieces (n,) + 1 evenly spaced states.")
        .def("manipulability", &manipulability, "q"_a, "tools"_a, at_work,
             "Return the volume (n,) spanned by the rows [first, second) of the Jacobian of a point, or by its\n"
             "columns if they are fewer: the least of tools, which are joints (k,), a point on each (k, 3) and rows.")
        .def("manipulability_along", &manipulability_along, "start"_a, "delta"_a, "shares"_a, "tools"_a, at_work,
             "The same (n, k) at start + share delta, (n, dof) each, for each of shares (k,).")
        .def("inverse", &solve_inverse, "seeds"_a, "joints"_a, "tools"_a, "rows"_a, "targets"_a, "limits"_a,
             "iterations"_a, "weight"_a = 1.0, at_work,
             "Solve inverse kinematics from seeds (n, dof) for tools (k, 4, 4) on joints (k,), all at once.\n\n"
             "Targets (n or 1, k, 4, 4) are in the world. rows (k,): 3, only a tool's position counts, 6, its pose,\n"
             "or 5, its pose up to a turn about z. limits: lowest, highest, and which joints wrap and have none.\n"
             "For unreachable targets the result minimizes the sum of squares of weight times metres, and radians.\n"
             "Return ends (n, dof), and the largest distances (n,) and angles (n,) of any tool.");
    nb::class_<Charge>(m, "Charge", "What straight motions of an arm cost.")
        .def(nb::init<const Chain&, const std::array<double, 9>&, int, bool, int, const Bools&, const ToolsGiven&,
                      const std::optional<nb::callable>&>(),
             "chain"_a, "numbers"_a, "kind"_a, "at_end"_a, "fewest"_a, "wraps"_a, "tools"_a, "measure"_a = nb::none(),
             "numbers: low, high and zeta of omega, divisor of lengths, beta, floor of w, longest motion (rad),\n"
             "spacing (rad) of states of w, and chords (rad) of the tool path, 0 for lengths in joint space. kind\n"
             "of omega as in manipulability_costs; at_end: omega of the last state, not the mean; fewest states per\n"
             "motion, an odd number; wraps (dof,): joints that turn at most half a turn. Tools are joints (k,), a\n"
             "point on each (k, 3) and rows [first, second) of their Jacobians; the least w counts, and the sum of\n"
             "their paths. measure maps configurations (n, dof) to values (n,) in place of w.")
        .def("costs", &Charge::costs, "start"_a, "end"_a, at_work, "Costs (n,) from start to end (n, dof).");
    nb::class_<PoseConstraints>(
        m, "NativeConstraints",
        "Constraints on the poses y (12,) = position and rows of the rotation of frames (f,).\n\n"
        "A constraint is row . y >= limit or, a ball, |rows y - centre| <= limit; depth is its largest slack.\n"
        "Frames are at placements (f, 4, 4) in joints, with pieces (f,) constraints each, which have counts (p,)\n"
        "rows. Their poses are those in frames base_placements (f, 4, 4) on joints bases (f,), -1: in the world.")
        .def("__init__", construct_by(&constraints_of), "chain"_a, "joints"_a, "placements"_a, "pieces"_a, "counts"_a,
             "balls"_a, "rows"_a, "centres"_a, "limits"_a, "depths"_a, "joint_limits"_a, "bases"_a, "base_placements"_a)
        .def("slack", &slack, "frame"_a, "rotation"_a, "position"_a, at_work,
             "Return the slack (n, k) of the constraints (k,) of a frame at its poses, (n, 3, 3) and (n, 3).")
        .def("projected", &projected, "q"_a, "depth"_a, "exact"_a, "steps"_a, at_work,
             "Return states near q (n, dof) that satisfy constraints up to exact, and which do (n,), after at most\n"
             "so many steps, a share depth (n,) of the way to their centres.")
        .def("proven", &keeps_all, "curves"_a, "bounds"_a, "forgiven"_a, "finest"_a, at_work,
             "Return which curves sum_k c_k s^k, s in [0, 1], (n, degree + 1, dof), are proven to satisfy all\n"
             "constraints.\n\n"
             "forgiven is added to the slack; spans with a deviation from the chord below finest are not halved.\n"
             "bounds: reach (f, dof) m of frames, derivatives of the columns of their Jacobians (f, dof, dof),\n"
             "rates of turning by joint (f, dof), and derivatives of the slack by position and rotation, (p,) each.");
    nb::class_<PointsInBoxes>(m, "NativeBoxes",
                              "Points (k, 3) in the frames of joints inner (k,), and a box for each.\n\n"
                              "Boxes are [low, high] (k, 3) in frames turns (k, 3, 3), shifts (k, 3) on joints\n"
                              "outer (k,).")
        .def("__init__", construct_by(&boxes_of), "chain"_a, "inner"_a, "points"_a, "outer"_a, "turns"_a, "shifts"_a,
             "low"_a, "high"_a)
        .def("hits", &hits, "q"_a, at_work,
             "Return which points are in their boxes in configurations (n, dof): rows (m, 2) of configurations and\n"
             "boxes, ascending, and the points in the frames of the boxes (m, 3).");
    m.def("manipulability_costs", &manipulability_costs, "w"_a, "low"_a, "high"_a, "zeta"_a, "kind"_a, at_work,
          "Return omega (n,): 1 up to low, zeta from high; between affine in 1 / w (0), -ln w (1), -w (2).");
    m.def("manipulability_cost_sums", &manipulability_cost_sums, "w"_a, "weights"_a, "low"_a, "high"_a, "zeta"_a,
          "kind"_a, at_work, "The sums (n,) of manipulability_costs of w (n, k), times weights (k,).");
}

}  // namespace planner
