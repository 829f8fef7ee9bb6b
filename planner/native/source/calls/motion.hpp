// What Python asks of curves and of motions along them; see ../../motions.py for shapes and units.
#pragma once

#include "../choices.hpp"
#include "../polynomials.hpp"
#include "../ramps.hpp"
#include "../refusals.hpp"

namespace planner {

namespace {

constexpr double most_number = 1e300;  // of what is no position: anything but infinity and NaN

void require_polynomials(int64_t n, int degree, int dof, const double* c) {
    require(degree >= 0 && degree <= highest_degree, "the pieces are of a higher degree than is supported");
    require(within(c, static_cast<size_t>(n) * (degree + 1) * dof, most_number), "a coefficient is no finite number");
}

void require_limits(int dof, const double* velocity, const double* acceleration) {
    for (const double* limits : {velocity, acceleration})
        for (int j = 0; j < dof; ++j) require(limits[j] > 0.0, "a limit is not above 0");
}

Curve curve_of(int dof, int m, const double* coefficients, const uint8_t* stop) {
    require(m >= 1 && dof >= 1, "a curve has at least one piece and one joint");
    require(within(coefficients, 3 * static_cast<size_t>(m) * dof, farthest), "the curve holds no finite number");
    return {coefficients, stop, m, dof};
}

const Phase* phases_of(int p, int m, const double* rows) {
    require(p >= 1 && within(rows, 5 * static_cast<size_t>(p), most_number), "a phase holds no finite number");
    for (int k = 0; k < p; ++k) require(rows[5 * k] >= 0.0 && rows[5 * k] < m, "a phase is on no piece");
    return reinterpret_cast<const Phase*>(rows);
}

}  // namespace

extern "C" {

// The least and the largest value (n, dof) on [0, 1] of polynomials c (n, degree + 1, dof).
int polynomials_extrema(int64_t n, int degree, int dof, const double* c, double* least, double* largest) {
    return answered([&] {
        require_polynomials(n, degree, dof, c);
        double own[highest_degree + 1];
        for (int64_t k = 0; k < n; ++k)
            for (int j = 0; j < dof; ++j) {
                heed_at(k);
                for (int i = 0; i <= degree; ++i) own[i] = c[(k * (degree + 1) + i) * dof + j];
                extrema_of(own, degree, least[k * dof + j], largest[k * dof + j]);
            }
    });
}

// The largest share that the `order`-th derivative by time, of polynomials that take `seconds` (n,), has of limits
// `most` (dof,), and on which piece and for which joint that is. Shares up to `beyond` may come out smaller.
double polynomials_worst(int64_t n, int degree, int dof, int order, const double* c, const double* seconds,
                         const double* most, double beyond, int64_t* where) {
    return answered([&] {
        require(n >= 1 && dof >= 1 && order >= 0, "there are no pieces, or the order is below 0");
        require_polynomials(n, degree, dof, c);
        require(within(seconds, n, most_number) && within(most, dof, most_number), "a time or a limit is no number");
        require(std::all_of(seconds, seconds + n, [](double one) { return one > 0.0; }), "a piece takes no time");
        require(std::all_of(most, most + dof, [](double one) { return one > 0.0; }), "a limit is not above 0");
        return worst_share(n, degree, dof, order, c, seconds, most, beyond, where);
    });
}

// The phases (p, 5) of the quickest motion along a curve (m, 3, dof), parabola k in `intervals[k]` parts; how many.
// There is room for three a line, and for one an interval.
int curve_phases(int dof, int m, const double* coefficients, const uint8_t* stop, const int64_t* intervals,
                 const double* velocity, const double* acceleration, double* phases) {
    return answered([&] {
        const Curve curve = curve_of(dof, m, coefficients, stop);
        require_limits(dof, velocity, acceleration);
        require(between(intervals, m, 1, 1 << 20), "a parabola has at least one interval");
        const QuickestMotion motion(curve, intervals, velocity, acceleration);
        std::copy(motion.phases.begin(), motion.phases.end(), reinterpret_cast<Phase*>(phases));
        return static_cast<int>(motion.phases.size());
    });
}

// The knots of a motion through its phases: when (ns), positions and velocities (k, dof), pieces; how many. There is room
// for two a phase.
int curve_knots(int dof, int m, const double* coefficients, const uint8_t* stop, int p, const double* phases,
                double stretch, int64_t window, int64_t apart, int64_t* clock, double* q, double* v, int64_t* piece) {
    return answered([&] {
        const Curve curve = curve_of(dof, m, coefficients, stop);
        require(stretch > 0.0 && window > 0 && apart > 0, "a stretch or a time is not above 0");
        const Phase* rows = phases_of(p, m, phases);
        double lasts = 0.0;
        for (int k = 0; k < p; ++k) lasts += stretch * rows[k].duration + static_cast<double>(window) * nanosecond;
        require(lasts < 9e9, "the motion takes longer than nanoseconds count");
        const Knots knots = KnotsOfPhases(curve, rows, p, stretch, window, apart).knots;
        std::copy(knots.clock.begin(), knots.clock.end(), clock);
        std::copy(knots.piece.begin(), knots.piece.end(), piece);
        std::copy(knots.q.begin(), knots.q.end(), q);
        std::copy(knots.v.begin(), knots.v.end(), v);
        return static_cast<int>(knots.size());
    });
}

// The mean over the last `window` ns of the cubics through points (k, dof): when, positions, velocities, accelerations;
// how many. There is room for two a point.
int motion_mean(int k, int dof, const int64_t* clock, const double* q, const double* v, int64_t window, int64_t apart,
                int64_t* times, double* mean_q, double* mean_v, double* mean_a) {
    return answered([&] {
        require(k >= 2 && window > 0 && apart > 0, "a motion has two points or more, and times are above 0");
        for (const double* points : {q, v})
            require(within(points, static_cast<size_t>(k) * dof, most_number), "a point holds no finite number");
        for (int i = 0; i + 1 < k; ++i) require(clock[i] < clock[i + 1], "the times of a motion do not increase");
        const std::vector<int64_t> found = times_of_mean(clock, k, window, apart);
        mean_over_window(Cubics(clock, q, v, k, dof), found, window, dof, mean_q, mean_v, mean_a);
        std::copy(found.begin(), found.end(), times);
        return static_cast<int>(found.size());
    });
}

// The ramp (m, 3, dof) from one state to another in the first of `durations` in which every joint can; m, or 0. There is
// room for 2 dof + 1 pieces.
int ramp_quickest(int dof, const double* q0, const double* v0, const double* q1, const double* v1, int count,
                  const double* durations, const double* velocity, const double* acceleration, double* pieces) {
    return answered([&] {
        require_limits(dof, velocity, acceleration);
        for (const double* state : {q0, v0, q1, v1})
            require(within(state, dof, farthest), "a state is no finite number");
        require(not_negative(durations, count, farthest), "a duration is no time");
        const State start{{q0, q0 + dof}, {v0, v0 + dof}}, end{{q1, q1 + dof}, {v1, v1 + dof}};
        const std::vector<double> found = quickest_ramp(start, end, durations, count, velocity, acceleration);
        std::copy(found.begin(), found.end(), pieces);
        return static_cast<int>(found.size()) / (3 * dof);
    });
}

// The largest shares (3,) of `limits` (3, dof) that the quintics through positions, velocities and accelerations
// (k, dof) at `clock` (k,) ns have; those up to 1 may come out smaller.
int motion_shares(int k, int dof, const int64_t* clock, const double* q, const double* v, const double* a,
                  const double* limits, double* shares) {
    return answered([&] {
        require(k >= 2 && dof >= 1, "a motion has two points or more, and a joint");
        for (const double* points : {q, v, a})
            require(within(points, static_cast<size_t>(k) * dof, most_number), "a point holds no finite number");
        require(within(limits, 3 * static_cast<size_t>(dof), most_number), "a limit is no number");
        require(std::all_of(limits, limits + 3 * dof, [](double one) { return one > 0.0; }), "a limit is not above 0");
        std::vector<double> pieces(6 * static_cast<size_t>(k - 1) * dof), seconds(k - 1);
        for (int i = 0; i + 1 < k; ++i) {
            heed_at(i);
            require(clock[i] < clock[i + 1], "the times of a motion do not increase");
            seconds[i] = static_cast<double>(clock[i + 1] - clock[i]) / 1e9;
            const size_t row = static_cast<size_t>(i) * dof;
            hermite_quintic(q + row, v + row, a + row, seconds[i], dof, &pieces[6 * row]);
        }
        int64_t where[2];
        for (int order = 1; order <= 3; ++order)
            shares[order - 1] = worst_share(k - 1, 5, dof, order, pieces.data(), seconds.data(),
                                            limits + static_cast<size_t>(order - 1) * dof, 1.0, where);
    });
}

// Points (k, dof) of a curve (m, 3, dof), about `chord` apart or farther, from its beginning to its end, and what is
// `walked` (k - 1,) from one to the next. It is walked along `each` chords a piece: there is room for the ends of them
// all. How many points.
int curve_chords(int dof, int m, const double* coefficients, int each, double chord, double* points, double* walked) {
    return answered([&] {
        const Curve curve = curve_of(dof, m, coefficients, nullptr);
        require(each >= 1 && chord > 0.0, "a chord is longer than nothing, and a piece has one");
        const size_t last = static_cast<size_t>(m) * each;
        std::vector<double> all((last + 1) * dof), so_far(last + 1, 0.0);
        for (size_t k = 0; k <= last; ++k) {
            heed_at(static_cast<int64_t>(k));
            const int piece = static_cast<int>(std::min(k / each, static_cast<size_t>(m - 1)));
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
        int count = 0;
        size_t before = 0;
        const auto keep = [&](size_t k) {
            if (count) walked[count - 1] = so_far[k] - so_far[before];
            std::copy(&all[k * dof], &all[k * dof] + dof, points + static_cast<size_t>(count++) * dof);
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
        return count;
    });
}

// The first of n pairs of moments (n, 2) s of a motion through phases along a curve between which there is a ramp, in
// one of `shares` (count,) of the time between them, that stays between `lower` and `upper` and is proven free: its
// number and the pieces `found` (3,) of the curve at both ends, s there (2,), and the ramp (r, 3, dof); r, or 0.
int world_next_ramp(const World* world, const double* reach, const double* body_reach, const uint8_t* is_static,
                    double room, int m, const double* coefficients, int p, const double* phases, int n,
                    const double* moments, int count, const double* shares, const double* velocity,
                    const double* acceleration, const double* lower, const double* upper, int64_t* found, double* s,
                    double* pieces) {
    return answered([&] {
        const int dof = world->chain.dof();
        const Curve curve = curve_of(dof, m, coefficients, nullptr);
        require_limits(dof, velocity, acceleration);
        require(not_negative(moments, 2 * static_cast<size_t>(n), most_number) && not_negative(shares, count, farthest),
                "a moment or a share of time is below 0, or no finite number");
        require(room >= rounding, "the room is below what distances are rounded by");
        Prover prover(*world, reach, body_reach, is_static);
        const MotionOnCurve motion(curve, phases_of(p, m, phases), p);
        std::vector<double> durations(count);
        std::vector<Proof> proofs;
        State states[2];
        for (int k = 0; k < n && heed() != Told::finish; ++k) {
            for (int end = 0; end < 2; ++end) motion.at(moments[2 * k + end], found[1 + end], s[end], states[end]);
            for (int i = 0; i < count; ++i) durations[i] = shares[i] * (moments[2 * k + 1] - moments[2 * k]);
            const std::vector<double> ramp =
                quickest_ramp(states[0], states[1], durations.data(), count, velocity, acceleration);
            if (ramp.empty() || !stay_between(ramp, dof, lower, upper)) continue;
            const int rows = static_cast<int>(ramp.size()) / (3 * dof);
            proofs.resize(rows);
            if (!all_proven(prover, {ramp.data(), rows, 2, dof}, 0, rows, room, proofs.data())) continue;
            found[0] = k;
            std::copy(ramp.begin(), ramp.end(), pieces);
            return rows;
        }
        return 0;
    });
}

}  // extern "C"

}  // namespace planner
