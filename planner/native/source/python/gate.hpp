// What a robot is about to do, as Python asks it: one judgement on all that a controller makes of a chunk.
#pragma once

#include "../gate.hpp"
#include "motion.hpp"

namespace planner {

using KindsOfLimits = std::tuple<Floats<3, any>, Floats<any>, Floats<any>>;  // most, lower and upper

inline std::vector<StopLimits> limits_of_stops(int dof, const double* limits, const double* lower,
                                               const double* upper) {
    std::vector<StopLimits> all(dof);
    for (int j = 0; j < dof; ++j) {
        all[j] = {{limits[j], limits[dof + j], limits[2 * dof + j]}, lower[j], upper[j]};
        for (const double limit : all[j].most) require(limit > 0.0, "a limit is not above 0");
        require(lower[j] <= upper[j], "there is no position between lower and upper");
    }
    return all;
}

inline std::vector<double> ladder_of(const Floats<any>& times) {
    require(times.count() >= 1, "there is no time to stop in");
    for (int k = 0; k < times.count(); ++k)
        require(times[k] > (k ? times[k - 1] : 0.0) && times[k] <= farthest, "times do not increase from 0 on");
    return {times + 0, times + times.size()};
}

inline GateRules rules_of(const World& world, double room, const KindsOfLimits& limits, const JointLimits& state,
                          const Floats<any>& times, double apart, double most_given) {
    const int dof = world.chain.dof();
    const auto& [most, lower, upper] = limits;
    const auto& [least, largest, is_wheel] = state;
    most.of({3, dof}), is_wheel.of({dof});
    for (const auto* row : {&lower, &upper, &least, &largest}) row->of({dof});
    require_room(room);
    require(apart >= 0.0 && most_given > 0.0 && most_given <= farthest, "a distance is none");
    return {dof,
            {most + 0, most + 3 * dof},
            {lower + 0, lower + dof},
            {upper + 0, upper + dof},
            limits_of_stops(dof, most, lower, upper),
            ladder_of(times),
            {least + 0, least + dof},
            {largest + 0, largest + dof},
            {is_wheel + 0, is_wheel + dof},
            apart,
            most_given};
}

// The judgement on points, with what is made of them, one after the other: what stopped the proof (1 + dof,), times
// (k + 1,), seconds (k,), pieces (k, 2 rows, dof), knots (k + 1, 3, dof) and the approach (2, dof), of fewer where there
// are fewer.
inline auto check(Gate& gate, int points, int rows, int state, const Floats<any>& given, bool stop) {
    require(points >= 1 && rows >= 1 && rows <= 3 && state >= 0 && state <= 3, "there are no such columns");
    const size_t dof = gate.rules().dof, count = points;
    given.of({static_cast<int64_t>(points + (state + count * rows) * dof)});
    Made<double, 1> made(2 + 2 * count + (6 + count * (2 * rows + 3)) * dof);
    Chunk chunk;
    chunk.times = made + 1 + dof, chunk.seconds = chunk.times + count + 1, chunk.pieces = chunk.seconds + count;
    chunk.knots = chunk.pieces + count * 2 * rows * dof, chunk.approach = chunk.knots + (count + 1) * 3 * dof;
    return std::tuple{gate.judge(chunk, points, rows, state, given, stop, made), std::move(made)};
}

inline auto chunk_curves(const Coefficients& coefficients, const Floats<any>& times,
                         const std::optional<std::pair<Floats<any, 2, 5, any>, Floats<any, 2>>>& stops,
                         const std::optional<Floats<2, any>>& approach) {
    const int count = coefficients.count(), powers = coefficients.count(1), dof = coefficients.count(2);
    const size_t degree_of_all = stops ? std::max(powers, 5) : powers, size = degree_of_all * dof;
    times.of({count + 1});
    if (stops) stops->first.of({count, 2, 5, dof}), stops->second.of({count, 2});
    if (approach) approach->of({2, dof});
    require(powers >= 2, "the curves are of too low a degree");
    std::vector<double> curves, spans;
    std::vector<int64_t> what;
    const auto add = [&](const double* c, size_t rows, double begin, double takes, int piece, int kind) {
        curves.insert(curves.end(), c, c + rows * dof);
        curves.insert(curves.end(), size - rows * dof, 0.0);
        spans.insert(spans.end(), {begin, takes, 0.0});
        what.insert(what.end(), {piece, kind});
    };
    if (approach) add(*approach, 2, 0.0, 0.0, 0, 0);
    for (int k = 0; k < count; ++k) {
        heed_at(k);
        add(coefficients + static_cast<size_t>(k) * powers * dof, powers, times[k], times[k + 1] - times[k], k, 1);
        double begin = times[k + 1];
        for (int i = 2 * k; stops && i < 2 * k + 2; begin += stops->second[i++])
            if (stops->second[i] > 0.0)  // not what takes no time
                add(stops->first + static_cast<size_t>(i) * 5 * dof, 5, begin, stops->second[i], k, 2);
    }
    const size_t found = what.size() / 2;
    return std::tuple{copied(curves.data(), Made<double, 3>(found, degree_of_all, dof)),
                      copied(spans.data(), Made<double, 2>(found, 3)), copied(what.data(), Made<int64_t, 2>(found, 2))};
}

inline auto stops_quickest(const Floats<any, 3, any>& states, const Floats<any>& times, const Floats<3, any>& limits,
                           const Limits& positions) {
    const int n = states.count(), dof = states.count(2);
    require(dof >= 1, "there is no joint");
    require(within(states, states.size(), most_number), "a state is no finite number");
    const std::vector<StopLimits> all =
        limits_of_stops(dof, limits.of({3, dof}), positions.first.of({dof}), positions.second.of({dof}));
    const std::vector<double> ladder = ladder_of(times);
    Made<double, 4> pieces(n, 2, 5, dof);
    Made<double, 2> seconds(n, 2);
    Made<int64_t, 2> broken(n, 2);
    std::vector<double> end(3 * static_cast<size_t>(dof));  // where the acceleration is 0
    for (int i = 0; i < n; ++i) {
        heed_at(i);
        int worst[2] = {0, 0};
        stop_from(states + 3 * static_cast<size_t>(i) * dof, dof, ladder, all.data(),
                  pieces + 10 * static_cast<size_t>(i) * dof, seconds + 2 * i, worst, end.data());
        broken[2 * i] = worst[0], broken[2 * i + 1] = worst[1];
    }
    return std::tuple{std::move(pieces), std::move(seconds), std::move(broken)};
}

inline void bind_gate(nb::module_& m) {
    nb::class_<Judgement>(m, "Judgement", "What came of a chunk; reasons, places and kinds as in source/gate.hpp.")
        .def_ro("usable", &Judgement::usable, "0: something cannot be used, and nothing else is known")
        .def_ro("pieces_made", &Judgement::count)
        .def_ro("rough", &Judgement::rough)
        .def_ro("approached", &Judgement::approached)
        .def_ro("reason", &Judgement::reason)
        .def_ro("place", &Judgement::place)
        .def_ro("piece", &Judgement::piece)
        .def_ro("kind", &Judgement::kind)
        .def_ro("joint", &Judgement::joint)
        .def_ro("pair", &Judgement::pair)
        .def_ro("touches", &Judgement::touches)
        .def_ro("pieces", &Judgement::pieces, "that are within limits, each with a stop")
        .def_ro("proven", &Judgement::proven, "of their curves")
        .def_ro("may_hold", &Judgement::may_hold);
    nb::class_<Gate>(
        m, "NativeGate",
        "A world as it is, and what is asked of chunks there; several threads may ask at once.\n\n"
        "limits: most (3, dof), infinite where there is none, and lower and upper (dof,); state: the lowest\n"
        "and highest positions where the robot may be, and which joints have none, (dof,) each; times (k,):\n"
        "s that stops may take, ascending; apart: how far a point at 0 s may be from the robot. Numbers\n"
        "beyond most are not used. is_timed: some obstacles have speed limits. Curves that come nearer than\n"
        "room (m) to something are not proven.")
        .def(
            "__init__",
            [](Gate* self, const World& world, const Bounds& bounds, const PointsInBoxes& boxes, bool is_timed,
               double room, const KindsOfLimits& limits, const JointLimits& state, const Floats<any>& times,
               double apart, double most) {
                new (self) Gate(world, bounds, boxes, is_timed, room,
                                rules_of(world, room, limits, state, times, apart, most));
            },
            "world"_a, "bounds"_a, "boxes"_a, "is_timed"_a, "room"_a, "limits"_a, "state"_a, "times"_a, "apart"_a,
            "most"_a, nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>())
        .def_prop_ro("dof", [](const Gate& self) { return self.rules().dof; })
        .def("check", &check, "points"_a, "rows"_a, "state"_a, "given"_a, "stop"_a, at_work,
             "Judge a number of points of so many rows: positions, velocities, accelerations.\n\n"
             "given: their times, so many rows of the robot's state, positions, and so on, one after the other. With\n"
             "the judgement what planner.native.Chunk takes apart.");
    m.def(
        "stops_quickest", &stops_quickest, "states"_a, "times"_a, "limits"_a, "positions"_a, at_work,
        "Stops (n, 2, 5, dof), pieces c0 + c1 u + ... from states (n, 3, dof), positions, velocities, "
        "accelerations.\n\n"
        "v (1 - 3 u^2 + 2 u^3) + a T (u - 2 u^2 + u^3) is the velocity of the second: it ends at rest, without\n"
        "acceleration. T is the first of ascending times (k,) in which no joint exceeds limits (3, dof) on velocity,\n"
        "acceleration and jerk, infinite where there is none, nor positions, lowest and highest (dof,). Where there\n"
        "is no such T the first piece lets a fall to 0 evenly, by the largest jerk; else it takes 0 s. With the\n"
        "seconds (n, 2) of both, 0 where there is no stop: then (n, 2) says which kind of limit is in the way, 3 for\n"
        "positions, and of which joint.");
    m.def("chunk_curves", &chunk_curves, "coefficients"_a, "times"_a, "stops"_a.none(), "approach"_a.none(), at_work,
          "Pieces (n, degree + 1, dof) between times (n + 1,) s, each with its stop behind it, as curves of one "
          "degree.\n\n"
          "stops, pieces and seconds, as stops_quickest has them, if any. approach (2, dof) leads to the first point,\n"
          "if it is given. The curves (m, most + 1, dof); their spans (m, 3): when each begins, how long it takes, 0;\n"
          "and rows (m, 2): of which piece each is, and 0 for the approach, 1 for a piece, 2 for a stop.");
}

}  // namespace planner
