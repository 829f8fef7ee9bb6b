// Calls that refine paths: what is tried, priced and proven in one go.
#pragma once

#include "../choices.hpp"
#include "../refinement.hpp"
#include "../sharing.hpp"
#include "robot.hpp"
#include "world.hpp"

namespace planner {

extern "C" {

// Where every second waypoint of a path (n, dof) may go, from `first` on: of up to `most` places, see WaypointMoves, the
// cheapest to and from which the motions are proven, as places (waypoints, dof). Which of them it is, or -1, comes to
// stand in `chosen` (waypoints,), where it says at first how many are left out; clearance and samples (waypoints, 2) of
// the motions. `mixes` (mix_count, 2) of steps of `size` downhill and of the way to the middle; draws (waypoints,
// draw_count, dof + 1) of directions and of shares of `size`.
int path_waypoint_moves(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                        double room, const Chain* chain, int last, const double* point, int rows, const double* numbers,
                        int kind, int at_end, int fewest, const uint8_t* wraps, int threads, int n, const double* path,
                        int first, double size, double gain, const double* lower, const double* upper, int mix_count,
                        const double* mixes, int draw_count, const double* draws, int most, int64_t* chosen,
                        double* places, double* clearance, int64_t* samples) {
    return answered([&] {
        const Tool tool = tool_of(*chain, last, point, rows);
        const Prices prices = prices_of(numbers, kind, at_end, fewest, wraps);
        const int dof = chain->dof(), waypoints = n - 1 > first ? (n - first) / 2 : 0;
        require(dof == world->chain.dof(), "the arm that is priced is not that of the world");
        require(room >= rounding, "the room is below what distances are rounded by");
        require(within(path, static_cast<size_t>(n) * dof, farthest), "the path holds no finite number");
        require(first >= 1 && most >= 0 && mix_count >= 0 && draw_count >= 0, "a number is below 0, or moves an end");
        require(between(chosen, waypoints, 0, INT32_MAX), "there is no such place to begin with");
        const MoveRules rules{size, gain, lower, upper, mixes, mix_count, draw_count, most};
        struct Worker {
            WaypointMoves moves;
            Prover prover;
            std::vector<double> found, pieces;
        };
        const auto make = [&] {
            return Worker{{*chain, tool, prices, rules}, {*world, reach, body_reach, is_static}, {}, {}};
        };
        share_out(waypoints, threads, 1, make, [&](int k, Worker& at) {
            const size_t width = dof;
            const double* here = path + (static_cast<size_t>(first) + 2 * static_cast<size_t>(k)) * width;
            at.found.resize(most * width), at.pieces.resize(4 * width);
            const int count =
                at.moves.find(here, draws + static_cast<size_t>(k) * draw_count * (width + 1), at.found.data());
            for (int64_t& place = chosen[k]; place < count; ++place) {
                const double* there = &at.found[place * width];
                straight_piece(here - width, there, dof, &at.pieces[0]);
                straight_piece(there, here + width, dof, &at.pieces[2 * width]);
                Proof proofs[2];
                if (!all_proven(at.prover, {at.pieces.data(), 2, 1, dof}, 0, 2, room, proofs)) continue;
                std::copy(there, there + width, places + k * width);
                for (size_t i = 0; i < 2; ++i)
                    clearance[2 * k + i] = proofs[i].clearance, samples[2 * k + i] = proofs[i].samples;
                return;
            }
            chosen[k] = -1;
        });
    });
}

// Of `count` stretches of a path (n, dof), between its rows `ends` (count, 2), the one that gains most after `joints`
// (count, dof) went a `share` (count,) of the way to moving evenly there, and whose motions are then proven: among the
// `most` best ones that gain more than `gain`, but for the `begin` best. One more than which of these it is, or 0; its
// `row` of the count, its states in `stretch` (n, dof), by how much it is cheaper, and clearance and samples (n - 1,) of
// its motions.
int path_even_stretch(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                      double room, const Chain* chain, int last, const double* point, int rows, const double* numbers,
                      int kind, int at_end, int fewest, const uint8_t* wraps, int threads, int n, const double* path,
                      int count, const int64_t* ends, const uint8_t* joints, const double* share, double gain, int most,
                      int begin, int64_t* row, double* stretch, double* gained, double* clearance, int64_t* samples) {
    return answered([&]() -> int {
        const Tool tool = tool_of(*chain, last, point, rows);
        const Prices prices = prices_of(numbers, kind, at_end, fewest, wraps);
        const size_t dof = chain->dof();
        require(dof == static_cast<size_t>(world->chain.dof()), "the arm that is priced is not that of the world");
        require(room >= rounding, "the room is below what distances are rounded by");
        require(within(path, n * dof, farthest), "the path holds no finite number");
        require(between(ends, 2 * static_cast<size_t>(count), 0, n), "a stretch ends at no row of the path");
        require(begin >= 0, "there is no such stretch to begin with");
        for (int k = 0; k < count; ++k) require(ends[2 * k] < ends[2 * k + 1], "a stretch ends before it begins");
        std::vector<double> now(std::max(n - 1, 0)), gains(count), all(static_cast<size_t>(count) * n * dof);
        if (n > 1) Pricing(*chain, tool, prices).price(n - 1, path, path + dof, now.data());
        const auto length_of = [&](int k) { return static_cast<int>(ends[2 * k + 1] - ends[2 * k]); };
        share_out(
            count, threads, 3, [&] { return Pricing(*chain, tool, prices); },
            [&](int k, Pricing& pricing) {
                const int64_t from = ends[2 * k];
                double* own = all.data() + static_cast<size_t>(k) * n * dof;
                even_stretch(path + from * dof, length_of(k), static_cast<int>(dof), joints + k * dof, share[k], own);
                std::vector<double> costs(length_of(k));
                pricing.price(length_of(k), own, own + dof, costs.data());
                for (int i = 0; i < length_of(k); ++i) gains[k] += now[from + i] - costs[i];
                if (std::isnan(gains[k])) gains[k] = -infinity;  // w is below the floor before and after
            });
        std::vector<int> order(count);
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return gains[a] > gains[b]; });
        if (begin >= std::min(most, count) || !(gains[order[begin]] > gain)) return 0;
        Prover prover(*world, reach, body_reach, is_static);
        std::vector<double> pieces(2 * n * dof);
        std::vector<Proof> proofs(n);
        for (int place = begin; place < std::min(most, count) && gains[order[place]] > gain; ++place) {
            const int k = order[place], length = length_of(k);
            const double* own = all.data() + static_cast<size_t>(k) * n * dof;
            for (int i = 0; i < length; ++i)
                straight_piece(own + i * dof, own + (i + 1) * dof, static_cast<int>(dof), &pieces[2 * i * dof]);
            const Pieces motions{pieces.data(), length, 1, static_cast<int>(dof)};
            if (!all_proven(prover, motions, 0, length, room, proofs.data())) continue;
            *row = k, *gained = gains[k];
            std::copy(own, own + (length + 1) * dof, stretch);
            for (int i = 0; i < length; ++i) clearance[i] = proofs[i].clearance, samples[i] = proofs[i].samples;
            return place + 1;
        }
        return 0;
    });
}

}  // extern "C"

}  // namespace planner
