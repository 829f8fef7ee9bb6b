// Calls that refine paths: what is tried, priced and proven in one go.
#pragma once

#include "../choices.hpp"
#include "../descent.hpp"
#include "../refinement.hpp"
#include "../sharing.hpp"
#include "robot.hpp"
#include "world.hpp"

namespace planner {

// A path (n, dof) that is to be refined, none of whose motions is new yet.
inline void begin_with(const World& world, const Chain& chain, double room, int n, const double* path,
                       int64_t* samples) {
    require(chain.dof() == world.chain.dof(), "the arm that is priced is not that of the world");
    require(room >= rounding, "the room is below what distances are rounded by");
    require(within(path, static_cast<size_t>(n) * chain.dof(), farthest), "the path holds no finite number");
    std::fill(samples, samples + std::max(0, n - 1), -1);
}

extern "C" {

// Up to `sweeps` over a path (n, dof), from its waypoint `first` (1 or 2) on every second one, then the others, and so on:
// each goes to the cheapest of up to `most` places, see WaypointMoves, to and from which the motions are proven. How many
// sweeps were made before the `step`, see there, was below `least`. Clearance and samples (n - 1,) of motions that are new,
// of others -1 samples. In the last sweep made `chosen` (waypoints,) says which of the places it is, or -1, and for the
// first one how many are left out. `mixes` (mix_count, 2) of steps downhill and of the way to the middle; draws (sweeps,
// (n - 1) / 2, draw_count, dof + 1) of directions and of shares of a step.
int path_descend(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                 double room, const Chain* chain, int last, const double* point, int rows, const double* numbers,
                 int kind, int at_end, int fewest, const uint8_t* wraps, int threads, int n, double* path, int first,
                 int sweeps, double* step, double least, double gain, const double* lower, const double* upper,
                 int mix_count, const double* mixes, int draw_count, const double* draws, int most, int64_t* chosen,
                 double* clearance, int64_t* samples) {
    return answered([&]() -> int {
        const Tool tool = tool_of(*chain, last, point, rows);
        const Prices prices = prices_of(numbers, kind, at_end, fewest, wraps);
        const int dof = chain->dof(), most_waypoints = std::max(0, (n - 1) / 2);
        begin_with(*world, *chain, room, n, path, samples);
        require(first == 1 || first == 2, "the first waypoint is neither row 1 nor row 2");
        require(sweeps >= 0 && most >= 0 && mix_count >= 0 && draw_count >= 0, "a number is below 0");
        require(within(step, 2, farthest) && least > 0.0, "a step is no finite number, or has no least");
        require(between(chosen, most_waypoints, 0, INT32_MAX), "there is no such place to begin with");
        const size_t drawn = static_cast<size_t>(sweeps) * most_waypoints * draw_count * (dof + 1);
        require(within(mixes, 2 * static_cast<size_t>(mix_count), farthest) && within(draws, drawn, farthest),
                "a mix or a draw is no finite number");
        require(within(&gain, 1, farthest), "the gain is no finite number");
        for (int j = 0; j < dof; ++j) require(lower[j] <= upper[j], "there is no position between lower and upper");
        const MoveRules rules{gain, lower, upper, mixes, mix_count, draw_count, most};
        const std::vector<int64_t> left_out(chosen, chosen + most_waypoints);
        struct Worker {
            WaypointMoves moves;
            Prover prover;
            std::vector<double> found, pieces;
        };
        const auto make = [&] {
            const size_t width = dof;
            return Worker{{*chain, tool, prices, rules},
                          {*world, reach, body_reach, is_static},
                          std::vector<double>(most * width),
                          std::vector<double>(4 * width)};
        };
        Sweeps all(n, first, sweeps, {step[0], step[1]}, least);
        share_out(all.moves(), threads, 1, make, [&](int item, Worker& at) {
            all.move(item, [&](int sweep, int k, int row, double size) {
                const size_t width = dof;
                double* here = path + row * width;
                const double* own =
                    draws + (static_cast<size_t>(sweep) * most_waypoints + k) * draw_count * (width + 1);
                const int count = at.moves.find(here, size, own, at.found.data());
                for (int64_t place = sweep ? 0 : left_out[k]; place < count; ++place) {
                    const double* there = &at.found[place * width];
                    straight_piece(here - width, there, dof, &at.pieces[0]);
                    straight_piece(there, here + width, dof, &at.pieces[2 * width]);
                    Proof proofs[2];
                    if (!all_proven(at.prover, {at.pieces.data(), 2, 1, dof}, 0, 2, room, proofs)) continue;
                    std::copy(there, there + width, here);
                    for (int i = 0; i < 2; ++i)
                        clearance[row - 1 + i] = proofs[i].clearance, samples[row - 1 + i] = proofs[i].samples;
                    chosen[k] = place;
                    return true;
                }
                chosen[k] = -1;
                return false;
            });
        });
        return all.made(step);
    });
}

// After `tries` tries to make a path (n, dof) cheaper, each the best of `count` stretches of it: between its rows `ends`
// (tries, count, 2) some `joints` (tries, count, dof) go a `share` (tries, count) of the way to moving evenly. That is taken
// of which the motions are proven, of the `most` best ones that gain more than `gain`, relative to the path, but for the
// `begin` best ones of the first try. Which of these it is, or -1, in `chosen` (tries,). Clearance and samples (n - 1,) of
// motions that are new, of others -1 samples.
int path_even_stretches(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                        double room, const Chain* chain, int last, const double* point, int rows, const double* numbers,
                        int kind, int at_end, int fewest, const uint8_t* wraps, int threads, int n, double* path,
                        int tries, int count, const int64_t* ends, const uint8_t* joints, const double* share,
                        double gain, int most, int begin, int64_t* chosen, double* clearance, int64_t* samples) {
    return answered([&] {
        const Tool tool = tool_of(*chain, last, point, rows);
        const Prices prices = prices_of(numbers, kind, at_end, fewest, wraps);
        const size_t dof = chain->dof(), all = static_cast<size_t>(tries) * count;
        begin_with(*world, *chain, room, n, path, samples);
        require(tries >= 0 && count >= 0 && begin >= 0, "a number is below 0");
        require(between(ends, 2 * all, 0, n), "a stretch ends at no row of the path");
        for (size_t k = 0; k < all; ++k) require(ends[2 * k] < ends[2 * k + 1], "a stretch ends before it begins");
        require(within(share, all, farthest) && within(&gain, 1, farthest), "a share or the gain is no finite number");
        const StretchRules rules{count, most, gain, ends, joints, share};
        std::vector<double> now(std::max(n - 1, 0));
        if (n > 1) Pricing(*chain, tool, prices).price(n - 1, path, path + dof, now.data());
        struct Worker {
            Stretches stretches;
            Prover prover;
            std::vector<double> pieces;
            std::vector<Proof> proofs;
        };
        const auto make = [&] {
            return Worker{{*chain, tool, prices, rules, n},
                          {*world, reach, body_reach, is_static},
                          std::vector<double>(2 * n * dof),
                          std::vector<Proof>(n)};
        };
        InTurn turns;
        share_out(tries, threads, 1, make, [&](int attempt, Worker& at) {
            int found = -1;
            const auto look = [&] {
                std::copy(path, path + n * dof, at.stretches.path.begin());
                std::copy(now.begin(), now.end(), at.stretches.now.begin());
            };
            const auto try_it = [&] {
                const int worth = at.stretches.find(attempt);
                found = -1;
                for (int place = attempt ? 0 : begin; place < worth && found < 0; ++place) {
                    const double* states = at.stretches.states(place);
                    const int length = at.stretches.length(place);
                    for (int i = 0; i < length; ++i)
                        straight_piece(states + i * dof, states + (i + 1) * dof, chain->dof(), &at.pieces[2 * i * dof]);
                    const Pieces motions{at.pieces.data(), length, 1, chain->dof()};
                    if (all_proven(at.prover, motions, 0, length, room, at.proofs.data())) found = place;
                }
            };
            const auto take = [&] {
                chosen[attempt] = found;
                if (found < 0) return false;
                const size_t row = at.stretches.first(found), length = at.stretches.length(found);
                const double *states = at.stretches.states(found), *costs = at.stretches.costs(found);
                std::copy(states, states + (length + 1) * dof, path + row * dof);
                std::copy(costs, costs + length, &now[row]);
                for (size_t i = 0; i < length; ++i)
                    clearance[row + i] = at.proofs[i].clearance, samples[row + i] = at.proofs[i].samples;
                return true;
            };
            turns.run(attempt, look, try_it, take);
        });
    });
}

}  // extern "C"

}  // namespace planner
