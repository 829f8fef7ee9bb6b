// Bindings of curves and motions along them.
#pragma once

#include "../polynomials.hpp"
#include "../ramps.hpp"
#include "world.hpp"

namespace planner {

constexpr double most_number = 1e300;  // of numbers that are not positions: all finite ones

inline void require_limits(int dof, const Limits& limits) {
    for (const auto* each : {&limits.first, &limits.second})
        for (int j = 0; j < each->of({dof}).count(); ++j) require((*each)[j] > 0.0, "a limit is not above 0");
}

using OfCurve = Floats<any, 3, any>;  // parabolas c0 + c1 s + c2 s^2
using OfPhases = Floats<any, 5>;      // a piece, s and ds/dt where each begins, d2s/dt2 on it, its seconds
using OfPoints = States;

inline Curve curve_of(const OfCurve& coefficients, const Bools* stop = nullptr) {
    const int m = coefficients.count(), dof = coefficients.count(2);
    require(m >= 1 && dof >= 1, "a curve has at least one piece and one joint");
    require(within(coefficients, coefficients.size(), farthest), "the curve holds no finite number");
    return {coefficients, stop ? bytes_of(stop->of({m})) : nullptr, m, dof};
}

inline const Phase* phases_of(const OfPhases& phases, int m) {
    const double* rows = phases;
    require(phases.count() >= 1 && within(rows, phases.size(), most_number), "a phase holds no finite number");
    for (int k = 0; k < phases.count(); ++k) require(rows[5 * k] >= 0.0 && rows[5 * k] < m, "a phase is on no piece");
    return reinterpret_cast<const Phase*>(rows);
}

inline int degree_of(const Coefficients& c) {
    const int degree = c.count(1) - 1;
    require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
    require(within(c, c.size(), most_number), "a coefficient is no finite number");
    return degree;
}

inline auto polynomial_extrema(const Coefficients& c) {
    const int degree = degree_of(c), dof = c.count(2);
    const int64_t n = c.count();
    Made<double, 2> least(n, dof), largest(n, dof);
    double own[highest_degree + 1];
    for (int64_t k = 0; k < n; ++k)
        for (int j = 0; j < dof; ++j) {
            poll_signal_at(k);
            for (int i = 0; i <= degree; ++i) own[i] = c[(k * (degree + 1) + i) * dof + j];
            extrema_of(own, degree, least[k * dof + j], largest[k * dof + j]);
        }
    return std::tuple{std::move(least), std::move(largest)};
}

inline auto polynomial_worst(const Coefficients& c, const Floats<any>& seconds, int order, const Floats<any>& most,
                             double beyond) {
    const int degree = degree_of(c), n = c.count(), dof = c.count(2);
    require(n >= 1 && dof >= 1 && order >= 0, "there are no pieces, or the order is below 0");
    require(within(seconds.of({n}), n, most_number) && within(most.of({dof}), dof, most_number),
            "a time or a limit is no number");
    require(std::all_of(seconds + 0, seconds + n, [](double one) { return one > 0.0; }), "a piece takes no time");
    require(std::all_of(most + 0, most + dof, [](double one) { return one > 0.0; }), "a limit is not above 0");
    int64_t where[2];
    const double share = worst_share(n, degree, dof, order, c, seconds, most, beyond, where);
    return std::tuple{share, where[0], where[1]};
}

inline Made<double, 2> curve_phases(const OfCurve& pieces, const Bools& stop, const Ints<any>& intervals,
                                    const Floats<any>& velocity, const Floats<any>& acceleration) {
    const Curve curve = curve_of(pieces, &stop);
    require_limits(curve.dof, {velocity, acceleration});
    require(between(intervals.of({curve.count}), curve.count, 1, 1 << 20), "a parabola has at least one interval");
    const QuickestMotion motion(curve, intervals, velocity, acceleration);
    return copy_into(reinterpret_cast<const double*>(motion.phases.data()), Made<double, 2>(motion.phases.size(), 5));
}

inline auto curve_knots(const OfCurve& pieces, const Bools& stop, const OfPhases& phases, double stretch,
                        int64_t window, int64_t apart) {
    const Curve curve = curve_of(pieces, &stop);
    require(stretch > 0.0 && window > 0 && apart > 0, "a stretch or a time is not above 0");
    const Phase* rows = phases_of(phases, curve.count);
    double lasts = 0.0;
    for (int k = 0; k < phases.count(); ++k)
        lasts += stretch * rows[k].duration + static_cast<double>(window) * nanosecond;
    require(lasts < 9e9, "the motion takes longer than nanoseconds count");
    const Knots knots = KnotsOfPhases(curve, rows, phases.count(), stretch, window, apart).knots;
    return std::tuple{made_of(knots.clock), copy_into(knots.q.data(), Made<double, 2>(knots.size(), curve.dof)),
                      copy_into(knots.v.data(), Made<double, 2>(knots.size(), curve.dof)), made_of(knots.piece)};
}

// Points (k, dof) of a motion at times that increase.
inline void require_points(const Ints<any>& clock, const OfPoints& q, std::initializer_list<const OfPoints*> columns) {
    const int k = q.count();
    require(k >= 2 && q.count(1) >= 1, "a motion has two points or more, and a joint");
    for (const OfPoints* points : columns)
        require(within(points->of({k, q.count(1)}), q.size(), most_number), "a point holds no finite number");
    clock.of({k});
    for (int i = 0; i + 1 < k; ++i) require(clock[i] < clock[i + 1], "the times of a motion do not increase");
}

inline auto motion_mean(const Ints<any>& clock, const OfPoints& q, const OfPoints& qd, int64_t window, int64_t apart) {
    const int k = q.count(), dof = q.count(1);
    require_points(clock, q, {&q, &qd});
    require(window > 0 && apart > 0, "a time is not above 0");
    const std::vector<int64_t> times = times_of_mean(clock, k, window, apart);
    Made<double, 2> mean(times.size(), dof), slope(times.size(), dof), bend(times.size(), dof);
    mean_over_window(Cubics(clock, q, qd, k, dof), times, window, dof, mean, slope, bend);
    return std::tuple{made_of(times), std::move(mean), std::move(slope), std::move(bend)};
}

inline Made<double, 1> motion_shares(const Ints<any>& clock, const OfPoints& q, const OfPoints& qd, const OfPoints& qdd,
                                     const Floats<3, any>& limits) {
    const int k = q.count(), dof = q.count(1);
    require_points(clock, q, {&q, &qd, &qdd});
    require(within(limits.of({3, dof}), limits.size(), most_number), "a limit is no number");
    require(std::all_of(limits + 0, limits + 3 * dof, [](double one) { return one > 0.0; }), "a limit is not above 0");
    std::vector<double> pieces(6 * static_cast<size_t>(k - 1) * dof), seconds(k - 1);
    for (int i = 0; i + 1 < k; ++i) {
        poll_signal_at(i);
        seconds[i] = static_cast<double>(clock[i + 1] - clock[i]) / 1e9;
        const size_t row = static_cast<size_t>(i) * dof;
        hermite_quintic(q + row, qd + row, qdd + row, seconds[i], dof, &pieces[6 * row]);
    }
    Made<double, 1> shares(3);
    int64_t where[2];
    for (int order = 1; order <= 3; ++order)
        shares[order - 1] = worst_share(k - 1, 5, dof, order, pieces.data(), seconds.data(),
                                        limits + static_cast<size_t>(order - 1) * dof, 1.0, where);
    return shares;
}

inline State state_of(const Limits& given, int dof) {
    const auto& [q, v] = given;
    require(within(q.of({dof}), dof, farthest) && within(v.of({dof}), dof, farthest), "a state is no finite number");
    return {{q + 0, q + dof}, {v + 0, v + dof}};
}

inline Made<double, 3> ramp_quickest(const Limits& start, const Limits& end, const Floats<any>& durations,
                                     const Floats<any>& velocity, const Floats<any>& acceleration) {
    const int dof = velocity.count();
    require_limits(dof, {velocity, acceleration});
    require(not_negative(durations, durations.size(), farthest), "a duration is no time");
    const std::vector<double> found =
        quickest_ramp(state_of(start, dof), state_of(end, dof), durations, durations.count(), velocity, acceleration);
    return copy_into(found.data(), Made<double, 3>(found.size() / (3 * dof), 3, dof));
}

inline auto curve_chords(const OfCurve& pieces, int each, double chord) {
    const Curve curve = curve_of(pieces);
    const int dof = curve.dof;
    require(each >= 1 && chord > 0.0, "a chord is longer than nothing, and a piece has one");
    const size_t last = static_cast<size_t>(curve.count) * each;
    std::vector<double> all((last + 1) * dof), so_far(last + 1, 0.0);
    for (size_t k = 0; k <= last; ++k) {
        poll_signal_at(static_cast<int64_t>(k));
        const int piece = static_cast<int>(std::min(k / each, static_cast<size_t>(curve.count - 1)));
        const double s = static_cast<double>(k - static_cast<size_t>(piece) * each) / each;
        double square = 0.0;
        for (int j = 0; j < dof; ++j) {
            all[k * dof + j] = curve.at(piece, s, j);
            const double by = k ? all[k * dof + j] - all[(k - 1) * dof + j] : 0.0;
            square += by * by;
        }
        if (k) so_far[k] = so_far[k - 1] + std::sqrt(square);
    }
    const double total = so_far[last], parts = std::max(1.0, std::floor(total / chord));
    std::vector<double> points, walked;
    size_t before = 0;
    const auto keep = [&](size_t k) {
        if (!points.empty()) walked.push_back(so_far[k] - so_far[before]);
        points.insert(points.end(), &all[k * dof], &all[k * dof] + dof);
        before = k;
    };
    double next = 0.0;
    for (size_t k = 0; k < last; ++k) {
        if (!(so_far[k] >= next)) continue;
        keep(k);
        if (!(total > 0.0)) break;
        next = (std::floor(so_far[k] / total * parts) + 1.0) / parts * total;
    }
    keep(last);
    return std::tuple{copy_into(points.data(), Made<double, 2>(points.size() / dof, dof)), made_of(walked)};
}

using OnCurve = std::pair<int64_t, double>;  // a piece of a curve, and s on it

inline std::optional<std::tuple<int, OnCurve, OnCurve, Made<double, 3>>> curve_next_ramp(
    const World& world, const Bounds& bounds, double resolution, const OfCurve& pieces, const OfPhases& phases,
    const Floats<any, 2>& moments, const Floats<any>& shares, const Limits& limits, const Limits& positions) {
    const int dof = world.chain.dof(), count = shares.count();
    const Curve curve = curve_of(pieces.of({any, 3, dof}));
    require_limits(dof, limits);
    positions.first.of({dof}), positions.second.of({dof});
    require(not_negative(moments, moments.size(), most_number) && not_negative(shares, count, farthest),
            "a moment or a share of time is below 0, or no finite number");
    require_memory(resolution);
    Prover prover(world, bounds);
    const MotionOnCurve motion(curve, phases_of(phases, curve.count), phases.count());
    std::vector<double> durations(count);
    std::vector<Proof> proofs;
    State states[2];
    OnCurve at[2];
    for (int k = 0; k < moments.count() && poll_signal() != Signal::finish; ++k) {
        for (int end = 0; end < 2; ++end) motion.at(moments[2 * k + end], at[end].first, at[end].second, states[end]);
        for (int i = 0; i < count; ++i) durations[i] = shares[i] * (moments[2 * k + 1] - moments[2 * k]);
        const std::vector<double> ramp =
            quickest_ramp(states[0], states[1], durations.data(), count, limits.first, limits.second);
        if (ramp.empty() || !stay_between(ramp, dof, positions.first, positions.second)) continue;
        const int rows = static_cast<int>(ramp.size()) / (3 * dof);
        proofs.resize(rows);
        if (!prove_all(prover, {ramp.data(), rows, 2, dof}, 0, rows, resolution, proofs.data())) continue;
        return std::tuple{k, at[0], at[1], copy_into(ramp.data(), Made<double, 3>(rows, 3, dof))};
    }
    return std::nullopt;
}

inline void bind_motion(nb::module_& m) {
    m.def("polynomial_extrema", &polynomial_extrema, "coefficients"_a, at_work,
          "Return the smallest and largest values (n, dof) on [0, 1] of polynomials (n, degree + 1, dof), exact up to\n"
          "rounding.");
    m.def("polynomial_worst", &polynomial_worst, "coefficients"_a, "seconds"_a, "order"_a, "most"_a, "beyond"_a,
          at_work,
          "Return the largest ratio of a derivative by time to limits most (dof,), with its piece and joint.\n\n"
          "Pieces (n, degree + 1, dof) take seconds (n,). Ratios up to beyond can be smaller than exact.");
    m.def("curve_phases", &curve_phases, "pieces"_a, "stop"_a, "intervals"_a, "velocity"_a, "acceleration"_a, at_work,
          "Return the phases (p, 5) of the quickest motion from rest to rest along pieces (m, 3, dof), c0 + c1 s +\n"
          "c2 s^2.\n\n"
          "A phase is a piece, s and ds/dt at its start, d2s/dt2, and its duration. The motion stops behind pieces\n"
          "with stop (m,); on a parabola d2s/dt2 is constant on each of its intervals (m,).");
    m.def("curve_knots", &curve_knots, "pieces"_a, "stop"_a, "phases"_a, "stretch"_a, "window"_a, "apart"_a, at_work,
          "Return the knots of a motion through phases (p, 5), stretch times slower, at least apart ns apart.\n\n"
          "The motion waits window ns at every stop; the time between two stops is at least four times apart.\n"
          "Return nanoseconds (k,), positions and velocities (k, dof), and the piece (k,) behind each.");
    m.def("motion_mean", &motion_mean, "clock"_a, "q"_a, "qd"_a, "window"_a, "apart"_a, at_work,
          "Return the mean over the last window ns of the cubics through points (k, dof) at clock (k,) ns.\n\n"
          "The motion rests before and behind. Times are those of the points and window later, at least apart ns\n"
          "apart. Return nanoseconds (n,), positions, velocities and accelerations (n, dof).");
    m.def("motion_shares", &motion_shares, "clock"_a, "q"_a, "qd"_a, "qdd"_a, "limits"_a, at_work,
          "Return the largest ratios (3,) of a motion to limits (3, dof) on velocity, acceleration and jerk.\n\n"
          "The motion has quintics through positions, velocities and accelerations (k, dof) at clock (k,) ns.\n"
          "Ratios up to 1 can be smaller than exact.");
    m.def("ramp_quickest", &ramp_quickest, "start"_a, "end"_a, "durations"_a, "velocity"_a, "acceleration"_a, at_work,
          "Return the parabolic ramp (m, 3, dof) between two states, position and velocity (dof,) each; m is 0\n"
          "without one.\n\n"
          "It takes the first of ascending durations (n,) within limits (dof,) of all joints.");
    m.def("curve_chords", &curve_chords, "curve"_a, "each"_a, "chord"_a, at_work,
          "Return points (k, dof) of a curve (m, 3, dof), about chord apart or farther, from its start to its end.\n\n"
          "Also return the lengths (k - 1,) between them, measured by along chords per piece.");
    m.def("curve_next_ramp", &curve_next_ramp, "world"_a, "bounds"_a, "resolution"_a, "curve"_a, "phases"_a,
          "moments"_a, "shares"_a, "limits"_a, "positions"_a, at_work,
          "Find the first pair of moments (n, 2) s of a motion through phases (p, 5) that a proven ramp can join.\n\n"
          "The ramp takes the first of ascending shares (k,) of the time between them, within limits on velocities\n"
          "and accelerations (dof,), and on positions, lowest and highest (dof,). Return its number, piece of the\n"
          "curve (m, 3, dof) and s of both ends, and the ramp; None without one, or after a requested stop.");
}

}  // namespace planner
