// Bindings of path refinement: candidates, costs and proofs in one call.
#pragma once

#include "../descent.hpp"
#include "../refinement.hpp"
#include "world.hpp"

namespace planner {

// Costs of motions, and the resolution (m) of their proofs.
struct Judge {
    const World& world;
    const Bounds& bounds;
    double resolution;
    const Charge& charge;
};

// A path (n, dof), and clearance and samples (n - 1,) of its new motions, -1 samples for others. `chosen` is the number of
// the accepted candidate of each waypoint of the last sweep, or of each try, or -1.
struct Refined {
    Made<double, 2> path;
    Made<int64_t, 1> chosen;
    Made<double, 1> clearance;
    Made<int64_t, 1> samples;

    Refined(const Judge& judge, const States& from, size_t choices)
        : path(copy_into(from.data(), Made<double, 2>(from.count(), from.count(1)))), chosen(choices),
          clearance(std::max(0, from.count() - 1)), samples(std::max(0, from.count() - 1)) {
        from.of({any, judge.world.chain.dof()});
        require(judge.charge.chain.dof() == judge.world.chain.dof(), "the arm that is priced is not that of the world");
        require_memory(judge.resolution);
        require(within(from, from.size(), farthest), "the path holds no finite number");
        std::fill_n(samples.data(), samples.size(), -1);
    }
};
inline auto arrays_of(Refined found) {
    return std::tuple{std::move(found.path), std::move(found.chosen), std::move(found.clearance),
                      std::move(found.samples)};
}

struct Moves {
    WaypointMoves moves;
    Prover prover;
    std::vector<double> found, pieces;
};

inline auto descend(const World& world, const Bounds& bounds, double resolution, const Charge& charge,
                    const States& path, int first, const std::pair<double, double>& step, double least, double gain,
                    const Limits& limits, const Floats<any, 2>& mixes, const Floats<any, any, any, any>& draws,
                    int most, const std::optional<Ints<any>>& begin) {
    const int n = path.count(), dof = world.chain.dof(), most_waypoints = std::max(0, (n - 1) / 2);
    const int sweeps = draws.count(), draw_count = draws.count(2);
    const size_t width = dof;
    Refined refined({world, bounds, resolution, charge}, path, most_waypoints);
    const auto& [lower, upper] = limits;
    lower.of({dof}), upper.of({dof}), draws.of({any, most_waypoints, any, dof + 1});
    require(first == 1 || first == 2, "the first waypoint is neither row 1 nor row 2");
    require(std::fabs(step.first) <= farthest && std::fabs(step.second) <= farthest && least > 0.0,
            "a step is no finite number, or has no least");
    require(most >= 0 && (!begin || between(begin->of({most_waypoints}), most_waypoints, 0, INT32_MAX)),
            "there is no such place to begin with");
    require(
        within(mixes, mixes.size(), farthest) && within(draws, draws.size(), farthest) && within(&gain, 1, farthest),
        "a mix, a draw or the gain is no finite number");
    for (int j = 0; j < dof; ++j) require(lower[j] <= upper[j], "there is no position between lower and upper");
    std::fill_n(refined.chosen.data(), most_waypoints, 0);
    if (begin) std::copy_n(begin->data(), most_waypoints, refined.chosen.data());
    const MoveRules rules{gain, lower, upper, mixes, mixes.count(), draw_count, most};
    const auto make = [&] {
        return Moves{{charge.chain, charge.tools, charge.prices, rules},
                     {world, bounds},
                     std::vector<double>(most * width),
                     std::vector<double>(4 * width)};
    };
    Sweeps all(n, first, sweeps, {step.first, step.second}, least);
    share_out(all.moves(), 1, make, [&](int item, Moves& at) {
        all.move(item, [&](int sweep, int k, int row, double size) {
            double* here = refined.path + row * width;
            const double* own = draws + (static_cast<size_t>(sweep) * most_waypoints + k) * draw_count * (width + 1);
            const int count = at.moves.find(here, size, own, at.found.data());
            for (int64_t place = sweep || !begin ? 0 : (*begin)[k]; place < count; ++place) {
                const double* there = &at.found[place * width];
                straight_piece(here - width, there, dof, &at.pieces[0]);
                straight_piece(there, here + width, dof, &at.pieces[2 * width]);
                Proof proofs[2];
                if (!prove_all(at.prover, {at.pieces.data(), 2, 1, dof}, 0, 2, resolution, proofs)) continue;
                std::copy(there, there + width, here);
                for (int i = 0; i < 2; ++i) {
                    refined.clearance[row - 1 + i] = proofs[i].clearance;
                    refined.samples[row - 1 + i] = proofs[i].samples;
                }
                refined.chosen[k] = place;
                return true;
            }
            refined.chosen[k] = -1;
            return false;
        });
    });
    double next[2] = {step.first, step.second};
    const int made = all.made(next);
    return std::tuple{arrays_of(std::move(refined)), made, std::pair{next[0], next[1]}};
}

struct Straightening {
    Stretches stretches;
    Prover prover;
    std::vector<double> pieces;
    std::vector<Proof> proofs;
    int found = -1;

    // The first candidate from `begin` on whose motions are all proven, or none.
    void try_one(int attempt, int begin, int dof, double resolution) {
        const int worth = stretches.find(attempt);
        found = -1;
        for (int place = begin; place < worth && found < 0; ++place) {
            const double* states = stretches.states(place);
            const int length = stretches.length(place);
            for (int i = 0; i < length; ++i)
                straight_piece(states + i * dof, states + (i + 1) * dof, dof, &pieces[2 * i * dof]);
            if (prove_all(prover, {pieces.data(), length, 1, dof}, 0, length, resolution, proofs.data())) found = place;
        }
    }
};

inline auto even_stretches(const World& world, const Bounds& bounds, double resolution, const Charge& charge,
                           const States& path, const Ints<any, any, 2>& ends, const Given<bool, any, any, any>& joints,
                           const States& shares, double gain, int most, int begin) {
    const int n = path.count(), tries = shares.count(), count = shares.count(1);
    const size_t dof = world.chain.dof(), all = shares.size();
    Refined refined({world, bounds, resolution, charge}, path, tries);
    ends.of({tries, count, 2}), joints.of({tries, count, world.chain.dof()});
    require(begin >= 0, "a number is below 0");
    require(between(ends, ends.size(), 0, n), "a stretch ends at no row of the path");
    for (size_t k = 0; k < all; ++k) require(ends[2 * k] < ends[2 * k + 1], "a stretch ends before it begins");
    require(within(shares, all, farthest) && within(&gain, 1, farthest), "a share or the gain is no finite number");
    const StretchRules rules{count, most, gain, ends, bytes_of(joints), shares};
    std::vector<double> now(std::max(n - 1, 0));
    if (n > 1) {
        Pricing pricing(charge.chain, charge.tools, charge.prices);
        pricing.price(n - 1, refined.path, refined.path + dof, now.data());
    }
    const auto make = [&] {
        return Straightening{{charge.chain, charge.tools, charge.prices, rules, n},
                             {world, bounds},
                             std::vector<double>(2 * n * dof),
                             std::vector<Proof>(n)};
    };
    InTurn turns;
    share_out(tries, 1, make, [&](int attempt, Straightening& at) {
        const auto look = [&] {
            std::copy_n(refined.path.data(), n * dof, at.stretches.path.begin());
            std::copy(now.begin(), now.end(), at.stretches.now.begin());
        };
        const auto try_it = [&] { at.try_one(attempt, attempt ? 0 : begin, static_cast<int>(dof), resolution); };
        const auto take = [&] {
            refined.chosen[attempt] = at.found;
            if (at.found < 0) return false;
            const size_t row = at.stretches.first(at.found), length = at.stretches.length(at.found);
            const double *states = at.stretches.states(at.found), *costs = at.stretches.costs(at.found);
            std::copy_n(states, (length + 1) * dof, refined.path + row * dof);
            std::copy_n(costs, length, &now[row]);
            for (size_t i = 0; i < length; ++i) {
                refined.clearance[row + i] = at.proofs[i].clearance;
                refined.samples[row + i] = at.proofs[i].samples;
            }
            return true;
        };
        turns.run(attempt, look, try_it, take);
    });
    return arrays_of(std::move(refined));
}

inline void bind_refinement(nb::module_& m) {
    m.def("descend", &descend, "world"_a, "bounds"_a, "resolution"_a, "charge"_a, "path"_a, "first"_a, "step"_a,
          "least"_a, "gain"_a, "limits"_a, "mixes"_a, "draws"_a, "most"_a, "begin"_a.none(), at_work,
          "See planner.native.refinement.descend.");
    m.def("even_stretches", &even_stretches, "world"_a, "bounds"_a, "resolution"_a, "charge"_a, "path"_a, "ends"_a,
          "joints"_a, "shares"_a, "gain"_a, "most"_a, "begin"_a, at_work,
          "See planner.native.refinement.even_stretches.");
}

}  // namespace planner
