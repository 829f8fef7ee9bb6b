// What Python asks of what a robot is about to do; see ../../library.py and ../../motions.py for shapes and units.
#pragma once

#include "../gate.hpp"

namespace planner {

namespace {

std::vector<StopLimits> limits_of_stops(int dof, const double* limits, const double* lower, const double* upper) {
    std::vector<StopLimits> all(dof);
    for (int j = 0; j < dof; ++j) {
        all[j] = {{limits[j], limits[dof + j], limits[2 * dof + j]}, lower[j], upper[j]};
        for (const double limit : all[j].most) require(limit > 0.0, "a limit is not above 0");
        require(lower[j] <= upper[j], "there is no position between lower and upper");
    }
    return all;
}

void require_ladder(int count, const double* times) {
    for (int k = 0; k < count; ++k)
        require(times[k] > (k ? times[k - 1] : 0.0) && times[k] <= farthest, "times do not increase from 0 on");
}

}  // namespace

extern "C" {

// A gate of a world that stays where it is, as are its reaches and boxes. Limits `most` (3, dof), infinite ones on none, and
// on positions; where the robot may be, `least` to `largest`, which joints are wheels (dof,); `times` (count,) of stops.
Gate* gate_new(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
               const PointsInBoxes* boxes, int is_timed, double room, int dof, const double* most, const double* lower,
               const double* upper, const double* least, const double* largest, const uint8_t* is_wheel, int count,
               const double* times, double apart, double most_given) {
    return answered([&] {
        require(dof >= 1 && dof == world->chain.dof() && count >= 1, "there is no joint, or no time to stop in");
        require(room >= rounding, "the room is below what distances are rounded by");
        require(apart >= 0.0 && most_given > 0.0 && most_given <= farthest, "a distance is none");
        require_ladder(count, times);
        GateRules rules{dof,
                        {most, most + 3 * dof},
                        {lower, lower + dof},
                        {upper, upper + dof},
                        limits_of_stops(dof, most, lower, upper),
                        {times, times + count},
                        {least, least + dof},
                        {largest, largest + dof},
                        {is_wheel, is_wheel + dof},
                        apart,
                        most_given};
        return new Gate(*world, reach, body_reach, is_static, *boxes, is_timed != 0, room, std::move(rules));
    });
}

void gate_free(Gate* gate) { delete gate; }

// Judge k points with `rows` columns each and `state_rows` of the robot's state, all in `given`: times (k,), the state and
// the columns. `made` becomes, one after the other: what stopped the proof (1 + dof,), times (k + 1,), seconds (k,), pieces
// (k, 2 rows, dof), knots (k + 1, 3, dof) and the approach (2, dof), of fewer where there are fewer; `found` a Judgement.
int gate_check(Gate* gate, int k, int rows, int state_rows, const double* given, int stop, double* made,
               Judgement* found) {
    return answered([&] {
        require(k >= 1 && rows >= 1 && rows <= 3 && state_rows >= 0 && state_rows <= 3, "there are no such columns");
        const size_t dof = gate->rules().dof, count = k;
        Chunk chunk;
        chunk.times = made + 1 + dof, chunk.seconds = chunk.times + count + 1, chunk.pieces = chunk.seconds + count;
        chunk.knots = chunk.pieces + count * 2 * rows * dof, chunk.approach = chunk.knots + (count + 1) * 3 * dof;
        *found = gate->judge(chunk, k, rows, state_rows, given, stop != 0, made);
    });
}

// Proofs of pieces (count, degree + 1, dof), of which each lies near the ones before and behind it, as world_prove has
// them; those behind the first that is not free are left undecided.
int world_prove_together(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                         const double* coefficients, const double* spans, int count, int degree, double room,
                         int64_t* verdict, int64_t* pair, double* where) {
    return answered([&] {
        require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
        require(room >= rounding, "the room is below what distances are rounded by");
        const Pieces pieces{coefficients, count, degree, world->chain.dof()};
        require(within(coefficients, static_cast<size_t>(count) * (degree + 1) * pieces.dof, farthest),
                "a coefficient is no finite number");
        std::vector<Span> times;
        for (int k = 0; spans && k < count; ++k) {
            times.push_back({spans[3 * k], spans[3 * k + 1], spans[3 * k + 2]});
            require(times.back().holds(), "a span is no time");
        }
        std::vector<Proof> proofs(count);
        Prover prover(*world, reach, body_reach, is_static);
        if (count) Together(prover, pieces, spans ? times.data() : nullptr, room, proofs.data()).prove(0, count);
        for (int k = 0; k < count; ++k)
            verdict[k] = proofs[k].verdict, pair[k] = proofs[k].pair, where[k] = proofs[k].where;
    });
}

// Pieces (count, degree + 1, dof) that begin and end at `times` (count + 1,), each with the stop behind it, as
// stops_quickest has them (none where `stops` is null): curves (of, most + 1, dof) with spans (of, 3) of when each
// begins, s that it takes, 0. What leads from the robot to the first point, `approach` (2, dof) if that is not null, comes
// first. `what` (of, 2) says of which piece each is, and 0 for the approach, 1 for a piece, 2 for a stop. How many.
int chunk_curves(int count, int degree, int most, int dof, const double* coefficients, const double* times,
                 const double* stops, const double* stop_seconds, const double* approach, double* curves, double* spans,
                 int64_t* what) {
    return answered([&] {
        require(degree >= 1 && most >= degree && (!stops || most >= 4), "the curves are of too low a degree");
        int found = 0;
        const size_t size = (static_cast<size_t>(most) + 1) * dof;
        const auto add = [&](const double* c, int powers, double begin, double takes, int piece, int kind) {
            double* own = curves + found * size;
            std::fill(std::copy(c, c + static_cast<size_t>(powers) * dof, own), own + size, 0.0);
            spans[3 * found] = begin, spans[3 * found + 1] = takes, spans[3 * found + 2] = 0.0;
            what[2 * found] = piece, what[2 * found + 1] = kind, ++found;
        };
        if (approach) add(approach, 2, 0.0, 0.0, 0, 0);
        for (int k = 0; k < count; ++k) {
            heed_at(k);
            add(coefficients + static_cast<size_t>(k) * (degree + 1) * dof, degree + 1, times[k],
                times[k + 1] - times[k], k, 1);
            double begin = times[k + 1];
            for (int i = 2 * k; stops && i < 2 * k + 2; begin += stop_seconds[i++])
                if (stop_seconds[i] > 0.0)  // not what takes no time
                    add(stops + static_cast<size_t>(i) * 5 * dof, 5, begin, stop_seconds[i], k, 2);
        }
        return found;
    });
}

// Stops from states (n, 3, dof) of position, velocity and acceleration, in the first of ascending `times` (count,) s in
// which they keep limits (3, dof) on velocities, accelerations and jerks, infinite ones on none, and positions from lower
// to upper (dof,): pieces (n, 2, 5, dof) and their seconds (n, 2). The first piece lets accelerations fall to 0; it takes
// 0 s and stands where the second one keeps the limits without it. Where there is no stop both take 0 s, and broken (n, 2)
// says what is in the way least: the kind of a limit, 3 for positions, and the joint.
int stops_quickest(int n, int dof, const double* states, int count, const double* times, const double* limits,
                   const double* lower, const double* upper, double* pieces, double* seconds, int64_t* broken) {
    return answered([&] {
        require(dof >= 1 && count >= 1, "there is no joint, or no time to stop in");
        require(within(states, 3 * static_cast<size_t>(n) * dof, 1e300), "a state is no finite number");
        require_ladder(count, times);
        const std::vector<StopLimits> all = limits_of_stops(dof, limits, lower, upper);
        const std::vector<double> ladder(times, times + count);
        std::vector<double> end(3 * static_cast<size_t>(dof));  // where the acceleration is 0
        for (int i = 0; i < n; ++i) {
            heed_at(i);
            int worst[2] = {0, 0};
            stop_from(states + 3 * static_cast<size_t>(i) * dof, dof, ladder, all.data(),
                      pieces + 10 * static_cast<size_t>(i) * dof, seconds + 2 * i, worst, end.data());
            broken[2 * i] = worst[0], broken[2 * i + 1] = worst[1];
        }
    });
}

}  // extern "C"

}  // namespace planner
