// Bindings of the gate: the check of a chunk of joint targets.
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

inline GateRules rules_of(const World& world, double resolution, const KindsOfLimits& limits, const JointLimits& state,
                          const Floats<any>& times, double apart, double most_given) {
    const int dof = world.chain.dof();
    const auto& [most, lower, upper] = limits;
    const auto& [least, largest, is_wheel] = state;
    most.of({3, dof}), is_wheel.of({dof});
    for (const auto* row : {&lower, &upper, &least, &largest}) row->of({dof});
    require_memory(resolution);
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

// The judgement on k points and an array of: the end of the proof (1 + dof,), times (k + 1,), seconds (k,), pieces (k,
// 2 rows, dof), knots (k + 1, 3, dof) and the approach (2, dof); unused rows at the end of each are not set.
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
        poll_signal_at(k);
        add(coefficients + static_cast<size_t>(k) * powers * dof, powers, times[k], times[k + 1] - times[k], k, 1);
        double begin = times[k + 1];
        for (int i = 2 * k; stops && i < 2 * k + 2; begin += stops->second[i++])
            if (stops->second[i] > 0.0)  // skip empty pieces
                add(stops->first + static_cast<size_t>(i) * 5 * dof, 5, begin, stops->second[i], k, 2);
    }
    const size_t found = what.size() / 2;
    return std::tuple{copy_into(curves.data(), Made<double, 3>(found, degree_of_all, dof)),
                      copy_into(spans.data(), Made<double, 2>(found, 3)),
                      copy_into(what.data(), Made<int64_t, 2>(found, 2))};
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
    std::vector<double> end(3 * static_cast<size_t>(dof));  // state with acceleration 0
    for (int i = 0; i < n; ++i) {
        poll_signal_at(i);
        int worst[2] = {0, 0};
        stop_from(states + 3 * static_cast<size_t>(i) * dof, dof, ladder, all.data(),
                  pieces + 10 * static_cast<size_t>(i) * dof, seconds + 2 * i, worst, end.data());
        broken[2 * i] = worst[0], broken[2 * i + 1] = worst[1];
    }
    return std::tuple{std::move(pieces), std::move(seconds), std::move(broken)};
}

inline void bind_gate(nb::module_& m) {
    nb::class_<Judgement>(m, "Judgement",
                          "Result of the check of a chunk; reasons, places and kinds as in source/gate.hpp.")
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
        "A world with rules for chunks; threads can check at once.\n\n"
        "limits: most (3, dof), infinite for none, lower and upper (dof,); state: lowest and highest positions of\n"
        "the robot, and continuous joints, (dof,) each; times (k,): s, durations of stops, ascending; apart:\n"
        "largest distance of a point at 0 s to the state. Numbers beyond most are refused. is_timed: some obstacles\n"
        "have speed limits. Curves are proven to a resolution (m).")
        .def(
            "__init__",
            [](Gate* self, const World& world, const Bounds& bounds, const PointsInBoxes& boxes, bool is_timed,
               double resolution, const KindsOfLimits& limits, const JointLimits& state, const Floats<any>& times,
               double apart, double most) {
                new (self) Gate(world, bounds, boxes, is_timed, resolution,
                                rules_of(world, resolution, limits, state, times, apart, most));
            },
            "world"_a, "bounds"_a, "boxes"_a, "is_timed"_a, "resolution"_a, "limits"_a, "state"_a, "times"_a, "apart"_a,
            "most"_a, nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(), nb::keep_alive<1, 4>())
        .def_prop_ro("dof", [](const Gate& self) { return self.rules().dof; })
        .def("check", &check, "points"_a, "rows"_a, "state"_a, "given"_a, "stop"_a, at_work,
             "Check points with rows of positions, velocities, accelerations.\n\n"
             "given has their times, rows of the state, positions, and so on. Return the judgement and the array\n"
             "that planner.session.verdict.Chunk.from_native splits.");
    m.def("stops_quickest", &stops_quickest, "states"_a, "times"_a, "limits"_a, "positions"_a, at_work,
          "Return stops (n, 2, 5, dof), pieces c0 + c1 u + ... from states (n, 3, dof), positions, velocities,\n"
          "accelerations.\n\n"
          "The velocity of the second piece is v (1 - 3 u^2 + 2 u^3) + a T (u - 2 u^2 + u^3): it ends at rest without\n"
          "acceleration. T is the first of ascending times (k,) with all joints within limits (3, dof) on velocity,\n"
          "acceleration and jerk, infinite for none, and positions, lowest and highest (dof,). If there is no such T,\n"
          "the first piece decreases a to 0 with the largest jerk; else it takes 0 s. Also return the seconds (n, 2)\n"
          "of both, 0 without a stop, and (n, 2) the violated kind of limit, 3 for positions, and its joint.");
    m.def("chunk_curves", &chunk_curves, "coefficients"_a, "times"_a, "stops"_a.none(), "approach"_a.none(), at_work,
          "Return pieces (n, degree + 1, dof) between times (n + 1,) s, each with its stop behind it, as curves of\n"
          "one degree.\n\n"
          "stops are pieces and seconds as of stops_quickest. approach (2, dof) leads to the first point. Return\n"
          "curves (m, most + 1, dof), their spans (m, 3): start, duration, 0; and rows (m, 2): the piece of each,\n"
          "and 0 for the approach, 1 for a piece, 2 for a stop.");
}

}  // namespace planner
