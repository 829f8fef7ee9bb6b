// The phases of the quickest motion along a curve, its points at whole nanoseconds, and its moving average.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "refusals.hpp"
#include "time_optimal.hpp"

namespace planner {

constexpr double nanosecond = 1e-9;  // s

// Pieces q(s) = c0 + c1 s + c2 s² (count, 3, dof), s in [0, 1]. The motion stops at the end of those with `stop`.
struct Curve {
    const double* coefficients;
    const uint8_t* stop;
    int count, dof;

    const double* of(int piece) const { return coefficients + static_cast<size_t>(piece) * 3 * dof; }
    double at(int piece, double s, int joint) const {
        const double* c = of(piece) + joint;
        return c[0] + (c[dof] + c[2 * dof] * s) * s;
    }
    double slope(int piece, double s, int joint) const {
        const double* c = of(piece) + joint;
        return c[dof] + 2.0 * s * c[2 * dof];
    }
    bool is_line(int piece) const {
        const double* bend = of(piece) + 2 * dof;
        return std::all_of(bend, bend + dof, [](double value) { return value == 0.0; });
    }
};

// `duration` s with a constant `acceleration` of the parameter of `piece`, from `s` at `speed`.
struct Phase {
    double piece, s, speed, acceleration, duration;
};

// The phases of the quickest motion along a curve from rest to rest; parabola k has `intervals[k]` intervals.
class QuickestMotion {
   public:
    QuickestMotion(const Curve& curve, const int64_t* intervals, const double* velocity, const double* acceleration)
        : curve_(curve) {
        std::vector<Stretch> stretches;
        std::vector<Part> parts;
        for (int k = 0; k < curve.count; ++k) {
            const bool line = curve.is_line(k);
            const int64_t count = line ? 1 : intervals[k];
            for (int64_t i = 0; i < count; ++i) {
                poll_signal_at(i);
                parts.push_back({k, line, place(i, count), place(i + 1, count)});
                stretches.emplace_back(curve.dof, curve.of(k), parts.back().low, parts.back().high, velocity,
                                       acceleration);
            }
            stretches.back().joint = joint_behind(k);
            require(stretches.back().joint >= 0.0, "the curve stands still at the beginning of a piece");
        }
        std::vector<double> rows(3 * stretches.size());
        quickest_motion(stretches, rows.data());
        for (size_t k = 0; k < parts.size(); ++k) {
            const double x = rows[3 * k], end = rows[3 * k + 1], u = rows[3 * k + 2];
            const Part& part = parts[k];
            if (part.line)
                along_line(part.piece, x, end, u, velocity);
            else
                phases.push_back({static_cast<double>(part.piece), part.low, std::sqrt(x), u,
                                  2.0 * (part.high - part.low) / (std::sqrt(x) + std::sqrt(end))});
        }
    }

    std::vector<Phase> phases;

   private:
    struct Part {
        int piece;
        bool line;
        double low, high;
    };

    // Starts of the intervals of a parabola, shorter towards its ends; with equal intervals motions take 1 % longer.
    static double place(int64_t i, int64_t count) {
        const double even = static_cast<double>(i) / static_cast<double>(count);
        return even * even * (3.0 - 2.0 * even);
    }

    // Factor of x behind a piece for continuous joint velocities; 0 for a stop.
    double joint_behind(int piece) const {
        if (piece + 1 == curve_.count || curve_.stop[piece]) return 0.0;
        double end = 0.0, start = 0.0;
        for (int j = 0; j < curve_.dof; ++j) {
            const double last = curve_.slope(piece, 1.0, j), first = curve_.slope(piece + 1, 0.0, j);
            end += last * last, start += first * first;
        }
        return end / start;
    }

    // Speed up, cruise and brake, with the acceleration `u` of the parameter.
    void along_line(int piece, double x, double end, double u, const double* velocity) {
        double most = infinity;
        for (int j = 0; j < curve_.dof; ++j)
            most = std::min(most, velocity[j] / std::fabs(curve_.slope(piece, 0.0, j)));
        const double peak = std::min(most * most, 0.5 * (x + end) + u), top = std::sqrt(peak);
        const double up = (peak - x) / (2.0 * u), down = (peak - end) / (2.0 * u), own = piece;
        const Phase parts[] = {{own, 0.0, std::sqrt(x), u, (top - std::sqrt(x)) / u},
                               {own, up, top, 0.0, std::max(0.0, 1.0 - up - down) / top},
                               {own, 1.0 - down, top, -u, (top - std::sqrt(end)) / u}};
        for (const Phase& part : parts)
            if (part.duration > 0.0) phases.push_back(part);
    }

    Curve curve_;
};

// Points of a motion: times, positions and velocities (k, dof), and the curve's piece behind each.
struct Knots {
    std::vector<int64_t> clock;
    std::vector<double> q, v;
    std::vector<int64_t> piece;
    int dof;

    explicit Knots(int dof) : dof(dof) {}
    size_t size() const { return clock.size(); }
    void drop_behind(size_t count) {
        clock.resize(count), piece.resize(count), q.resize(count * dof), v.resize(count * dof);
    }
};

// The knots of a motion through its phases, `stretch` times slower, at least `apart` ns apart, with a wait of `window` ns
// at every stop. The time between two stops is at least four times `apart`.
class KnotsOfPhases {
   public:
    KnotsOfPhases(const Curve& curve, const Phase* phases, int count, double stretch, int64_t window, int64_t apart)
        : knots(curve.dof), curve_(curve), stretch_(stretch), apart_(apart) {
        int64_t begin = 0;
        for (int first = 0, last; first < count; first = last, begin += window) {
            for (last = first + 1; last < count; ++last) {
                const int before = piece_of(phases[last - 1]);
                if (before != piece_of(phases[last]) && curve.stop[before]) break;
            }
            begin = between_stops(phases + first, last - first, begin);
        }
    }

    Knots knots;

   private:
    static int piece_of(const Phase& phase) { return static_cast<int>(phase.piece); }

    // From rest at `begin` to rest; returns the time of the end.
    int64_t between_stops(const Phase* phases, int count, int64_t begin) {
        const size_t first = knots.size();
        int64_t end = begin;
        double late = 0.0;  // s from the start of a phase to its knot at a whole nanosecond
        for (int k = 0; k < count; ++k) {
            poll_signal_at(k);
            const double takes = stretch_ * phases[k].duration;
            if (knots.size() == first || end - knots.clock.back() >= apart_) add(end, phases[k], std::min(late, takes));
            const double more = std::ceil((takes - late) / nanosecond);
            end += static_cast<int64_t>(more), late = more * nanosecond - (takes - late);
        }
        size_t kept = end - begin < 4 * apart_ ? first + 1 : knots.size();
        while (kept > first + 1 && end - knots.clock[kept - 1] < apart_) --kept;
        knots.drop_behind(kept);
        end = std::max(end, begin + 4 * apart_);
        const int piece = piece_of(phases[count - 1]);
        knots.clock.push_back(end), knots.piece.push_back(piece);
        for (int j = 0; j < curve_.dof; ++j) knots.q.push_back(curve_.at(piece, 1.0, j)), knots.v.push_back(0.0);
        return end;
    }

    void add(int64_t clock, const Phase& phase, double t) {
        t /= stretch_;
        const double s = phase.s + (phase.speed + 0.5 * phase.acceleration * t) * t;
        const double speed = (phase.speed + phase.acceleration * t) / stretch_;
        const int piece = piece_of(phase);
        knots.clock.push_back(clock), knots.piece.push_back(piece);
        for (int j = 0; j < curve_.dof; ++j)
            knots.q.push_back(curve_.at(piece, s, j)), knots.v.push_back(curve_.slope(piece, s, j) * speed);
    }

    Curve curve_;
    double stretch_;
    int64_t apart_;
};

// The cubics through points of a motion, at rest before the first and after the last point.
class Cubics {
   public:
    Cubics(const int64_t* clock, const double* q, const double* v, int count, int dof)
        : clock_(clock), count_(count), dof_(dof), c_(static_cast<size_t>(count - 1) * 4 * dof), q_(q) {
        for (int k = 0; k + 1 < count; ++k) {
            const double h = seconds(k);
            for (int j = 0; j < dof; ++j) {
                const double from = q[k * dof + j], delta = q[(k + 1) * dof + j] - from;
                const double start = v[k * dof + j] * h, end = v[(k + 1) * dof + j] * h;
                double* c = &c_[static_cast<size_t>(k) * 4 * dof + j];
                c[0] = from, c[dof] = start, c[2 * dof] = 3.0 * delta - 2.0 * start - end;
                c[3 * dof] = start + end - 2.0 * delta;
            }
        }
    }

    // The piece at a time, the next one at a point; -1 and count - 1 are the rests.
    int piece_at(int64_t clock) const {
        return static_cast<int>(std::upper_bound(clock_, clock_ + count_, clock) - clock_) - 1;
    }

    // Positions (dof,) at a time on a piece.
    void positions(int piece, int64_t clock, double* found) const {
        if (rests(piece)) {
            std::copy(rest_at(piece), rest_at(piece) + dof_, found);
            return;
        }
        const double u = since(piece, clock);
        for (int j = 0; j < dof_; ++j) found[j] = value(of(piece) + j, u);
    }

    double velocity(int piece, int64_t clock, int joint) const {
        if (rests(piece)) return 0.0;
        const double h = seconds(piece), u = since(piece, clock);
        const double* c = of(piece) + joint;
        return ((3.0 * c[3 * dof_] * u + 2.0 * c[2 * dof_]) * u + c[dof_]) / h;
    }

    // Add the integrals (dof,) of positions less `base` (dof,) between two times on a piece, by Simpson's rule, exact for
    // cubics.
    FOR_THIS_PROCESSOR void add_integrals(int piece, int64_t from, int64_t to, const double* base,
                                          double* total) const {
        const double width = static_cast<double>(to - from) / 1e9;
        if (rests(piece)) {
            const double* rest = rest_at(piece);
            for (int j = 0; j < dof_; ++j) total[j] += width * (rest[j] - base[j]);
            return;
        }
        const double low = since(piece, from), high = since(piece, to), middle = 0.5 * (low + high);
        const double* c = of(piece);
        for (int j = 0; j < dof_; ++j) {
            const double ends = value(c + j, low) + value(c + j, high);
            total[j] += width / 6.0 * (ends + 4.0 * value(c + j, middle) - 6.0 * base[j]);
        }
    }

    int64_t begin_of(int piece) const { return clock_[piece]; }

   private:
    bool rests(int piece) const { return piece < 0 || piece >= count_ - 1; }
    const double* rest_at(int piece) const { return q_ + (piece < 0 ? 0 : static_cast<size_t>(count_ - 1) * dof_); }
    const double* of(int piece) const { return &c_[static_cast<size_t>(piece) * 4 * dof_]; }
    double seconds(int piece) const { return static_cast<double>(clock_[piece + 1] - clock_[piece]) / 1e9; }
    double since(int piece, int64_t clock) const {
        return static_cast<double>(clock - clock_[piece]) / 1e9 / seconds(piece);
    }
    INLINED double value(const double* c, double u) const {
        return ((c[3 * dof_] * u + c[2 * dof_]) * u + c[dof_]) * u + c[0];
    }

    const int64_t* clock_;
    int count_, dof_;
    std::vector<double> c_;  // (pieces, 4, dof)
    const double* q_;
};

// The times of points (count,) and these plus `window`, ascending, without times closer than `apart` to the previous or
// the last time.
inline std::vector<int64_t> times_of_mean(const int64_t* clock, int count, int64_t window, int64_t apart) {
    std::vector<int64_t> times(clock, clock + count), kept;
    for (int k = 0; k < count; ++k) times.push_back(clock[k] + window);
    std::inplace_merge(times.begin(), times.begin() + count, times.end());
    for (const int64_t time : times)
        if (kept.empty() || (time - kept.back() >= apart && times.back() - time >= apart)) kept.push_back(time);
    kept.push_back(times.back());
    return kept;
}

// Positions, velocities and accelerations (k, dof) of the mean of a motion over the last `window` ns, at `times` (k,). The
// sum is over differences to the position at the time itself, to keep rounding small.
inline void mean_over_window(const Cubics& base, const std::vector<int64_t>& times, int64_t window, int dof, double* q,
                             double* v, double* a) {
    const double seconds = static_cast<double>(window) * nanosecond, exactly = static_cast<double>(window) / 1e9;
    std::vector<double> now(dof), before(dof), total(dof);
    for (size_t row = 0; row < times.size(); ++row) {
        poll_signal_at(static_cast<int64_t>(row));
        const int64_t high = times[row], low = high - window;
        const int first = base.piece_at(low), last = base.piece_at(high);
        const size_t k = row * dof;
        base.positions(last, high, now.data());
        base.positions(first, low, before.data());
        std::fill(total.begin(), total.end(), 0.0);
        for (int piece = first; piece <= last; ++piece) {
            const int64_t from = piece == first ? low : base.begin_of(piece);
            const int64_t to = piece == last ? high : base.begin_of(piece + 1);
            if (to > from) base.add_integrals(piece, from, to, now.data(), total.data());
        }
        for (int j = 0; j < dof; ++j) {
            q[k + j] = now[j] + total[j] / exactly;
            v[k + j] = (now[j] - before[j]) / seconds;
            a[k + j] = (base.velocity(last, high, j) - base.velocity(first, low, j)) / seconds;
        }
    }
}

}  // namespace planner
