// The check of a chunk of joint targets: the controller's motion, limits, a stop from every point, and one proof of all
// these curves.
#pragma once

#include <memory>
#include <mutex>

#include "kinematics.hpp"
#include "stopping.hpp"
#include "box_proof.hpp"

namespace planner {

constexpr double longest_time = 9e9;           // s, largest time in nanoseconds
constexpr size_t most_kept = size_t{1} << 17;  // numbers of curves whose memory is reused

// The first of pieces (count, degree + 1, dof) that violates a limit, by exact extrema, or -1. Limits are `lower`, `upper`
// (dof,) on positions, and `most` (kinds, dof), infinite for none, on derivatives by time; pieces take `seconds` (count,).
// `where` becomes the derivative and the joint with the largest violation.
inline int64_t first_beyond(int64_t count, int degree, int dof, const double* c, const double* seconds, int kinds,
                            const double* most, const double* lower, const double* upper, int* where) {
    const size_t size = (static_cast<size_t>(degree) + 1) * dof;
    std::vector<double> slopes(size), hulls(size);  // (left + 1, dof)
    double own[highest_degree + 1], least, largest;
    for (int64_t k = 0; k < count; ++k) {
        poll_signal_at(k);
        std::copy(c + k * size, c + (k + 1) * size, slopes.begin());
        double unit = 1.0;
        for (int order = 0, left = degree; order <= kinds; ++order, unit *= seconds[k]) {
            if (order) left = derive(slopes.data(), left, 1, slopes.data(), dof);
            std::copy(slopes.begin(), slopes.begin() + (left + 1) * dof, hulls.begin());
            to_bernstein(hulls.data(), left, dof);
            double worst = -infinity;
            for (int j = 0; j < dof; ++j) {
                const double low = order ? -most[(order - 1) * dof + j] * unit : lower[j];
                const double high = order ? -low : upper[j];
                bool inside = true;
                for (int i = 0; i <= left; ++i)
                    inside = inside && hulls[i * dof + j] >= low && hulls[i * dof + j] <= high;
                if (inside) continue;
                for (int i = 0; i <= left; ++i) own[i] = slopes[i * dof + j];
                extrema_of(own, left, least, largest);
                if (least >= low && largest <= high) continue;
                const double excess = std::max(low - least, largest - high), share = order ? excess / high : excess;
                if (!(share <= worst)) worst = share, where[0] = order, where[1] = j;
            }
            if (worst > -infinity) return k;
        }
    }
    return -1;
}

// The stop from a state q, v, a (dof,): pieces (2, 5, dof) and their seconds (2,), both 0 without a stop; then `worst` has
// the kind of limit and the joint that prevent it. `end` (3 dof,) is working memory.
inline void stop_from(const double* q, int dof, const std::vector<double>& times, const StopLimits* limits,
                      double* pieces, double* seconds, int* worst, double* end) {
    const double *v = q + dof, *a = v + dof;
    const int count = static_cast<int>(times.size());
    int ignored[2];
    int found = quickest_stop(q, v, a, dof, times.data(), count, limits, worst);
    double eased = 0.0;
    if (found < 0) {
        eased = ease(q, v, a, dof, limits, pieces, end, end + dof);
        std::fill(end + 2 * dof, end + 3 * dof, 0.0);
        if (eased > 0.0)
            found = quickest_stop(end, end + dof, end + 2 * dof, dof, times.data(), count, limits, ignored);
    }
    if (found < 0 || eased == 0.0) {
        eased = 0.0, std::fill(pieces, pieces + 10 * dof, 0.0), std::copy(q, q + dof, pieces);
        std::copy(q, q + dof, pieces + 5 * dof);
    }
    seconds[0] = eased, seconds[1] = found < 0 ? 0.0 : times[found];
    const double* from = eased > 0.0 ? end : q;
    for (int j = 0; j < dof && found >= 0; ++j) {
        double c[5];
        Stop(from[j], from[dof + j], from[2 * dof + j], times[found]).coefficients(c);
        for (int k = 0; k < 5; ++k) pieces[(5 + k) * dof + j] = c[k];
    }
}

// Rules of chunks, apart from clearance.
struct GateRules {
    int dof;
    std::vector<double> most, lower, upper;  // (3, dof), (dof,) as in first_beyond, also for stops
    std::vector<StopLimits> limits;
    std::vector<double> times;           // s, durations of stops, ascending
    std::vector<double> least, largest;  // (dof,) range of the robot's state
    std::vector<uint8_t> is_wheel;       // (dof,) continuous joints
    double apart;                        // rad, rad/s, largest distance of a point at 0 s from the state
    double most_given;                   // largest input number, in any unit
};

// The controller's motion through k points, in arrays of the caller; see Chunk in planner/session/guard.py.
struct Chunk {
    int count = 0, degree = 0;
    bool rough = false, approached = false;
    double *times, *seconds, *pieces, *knots, *approach;

    double* knot(int i, int order, int dof) const { return knots + (static_cast<size_t>(i) * 3 + order) * dof; }

    // Build from `given`: times (k,), `state_rows` rows of the state (dof,), and `rows` columns (k, dof). Returns whether
    // all numbers are usable.
    bool build(const GateRules& rules, int k, int rows, int state_rows, const double* given) {
        const int dof = rules.dof;
        const size_t size = static_cast<size_t>(k) * dof;
        const double *state = given + k, *columns = state + state_rows * static_cast<size_t>(dof);
        if (k < 1 || !within(given, k, longest_time) || !within(state, state_rows * dof, rules.most_given) ||
            !within(columns, rows * size, rules.most_given))
            return false;
        for (int j = 0; j < dof && state_rows; ++j)
            if (!(state[j] >= rules.least[j] && state[j] <= rules.largest[j])) return false;
        const bool led = state_rows > 0 && std::nearbyint(given[0] * 1e9) > 0.0;
        count = k + led - 1, degree = 2 * rows - 1, rough = led && rows == 3 && state_rows < 3;
        approached = state_rows > 0 && !led;
        if (count < 1) return false;
        for (int j = 0; j < dof && led; ++j)
            if (rules.is_wheel[j] && std::fabs(columns[j] - state[j]) > half_turn) return false;
        int64_t before = 0;
        times[0] = 0.0;
        for (int i = 0; i < k; ++i) {
            const int64_t clock = static_cast<int64_t>(std::nearbyint(given[i] * 1e9));
            if (clock < 0 || (clock <= before && (i || led))) return false;
            times[i + led] = clock / 1e9;
            if (i + led) seconds[i + led - 1] = (clock - before) / 1e9;
            before = clock;
        }
        std::fill(knots, knots + 3 * (count + size_t{1}) * dof, 0.0);
        if (led) std::copy(state, state + std::min(rows, state_rows) * dof, knots);
        for (int order = 0; order < rows; ++order)
            for (int i = 0; i < k; ++i)
                std::copy_n(columns + order * size + static_cast<size_t>(i) * dof, dof, knot(i + led, order, dof));
        for (int i = 0; i < count; ++i) lead(i, rows - (rough && !i), dof);
        for (int i = 0; i < (rows == 2 ? count : int{rough}); ++i) arrive(i, dof);
        for (int j = 0; j < dof && approached; ++j) approach[j] = state[j], approach[dof + j] = columns[j] - state[j];
        for (int j = 0; state_rows && j < 3 * dof; ++j) knots[j] = j < state_rows * dof ? state[j] : 0.0;
        return true;
    }

    // Largest distance of a first point at 0 s from the state in derivatives `low` to `high`, and its joint.
    double jump(int low, int high, int dof, int* joint) const {
        double most = 0.0, unit = 1.0;
        for (int order = 0; order <= high && approached; ++order, unit *= order / seconds[0])
            for (int j = 0; j < dof && order >= low; ++j) {
                const double here = std::fabs(pieces[order * dof + j] * unit - knots[order * dof + j]);
                if (here > most) most = here, *joint = j;
            }
        return most;
    }

   private:
    // The piece between two knots, from `rows` derivatives; a line also sets the velocity at its end.
    void lead(int i, int rows, int dof) {
        const double h = seconds[i], *a = knot(i, 0, dof), *b = knot(i + 1, 0, dof);
        double* c = pieces + static_cast<size_t>(i) * (degree + 1) * dof;
        std::fill(c + 2 * rows * dof, c + (degree + 1) * dof, 0.0);
        for (int j = 0; j < dof; ++j, ++a, ++b, ++c) {
            const double delta = b[0] - a[0];
            c[0] = a[0], c[dof] = delta;
            if (rows == 1) knot(i + 1, 1, dof)[j] = delta / h;
            if (rows == 1) continue;
            const double start = a[dof] * h, end = b[dof] * h;
            c[dof] = start;
            if (rows == 2) {
                c[2 * dof] = 3.0 * delta - 2.0 * start - end, c[3 * dof] = start + end - 2.0 * delta;
                continue;
            }
            const double bend = a[2 * dof] * (h * h), bent = b[2 * dof] * (h * h);
            const double rest = delta - start - 0.5 * bend, slope = end - start - bend, curve = bent - bend;
            c[2 * dof] = 0.5 * bend, c[3 * dof] = 10.0 * rest - 4.0 * slope + 0.5 * curve;
            c[4 * dof] = -15.0 * rest + 7.0 * slope - curve, c[5 * dof] = 6.0 * rest - 3.0 * slope + 0.5 * curve;
        }
    }

    // The acceleration at the end of a cubic; the next piece begins with another one.
    void arrive(int i, int dof) {
        const double *c = pieces + static_cast<size_t>(i) * (degree + 1) * dof, h = seconds[i];
        for (int j = 0; j < dof; ++j) knot(i + 1, 2, dof)[j] = (2.0 * c[2 * dof + j] + 6.0 * c[3 * dof + j]) / (h * h);
    }
};

// The result of a check. Numbers of reasons and places are those of planner/session/reasons.py.
enum Reason : int64_t { no_reason = 0, not_there = 1, beyond_limit = 2, not_proven = 3 };
enum Place : int64_t { on_approach = 0, on_motion = 1, on_stop = 2 };
struct Judgement {
    int64_t usable = 0, count = 0, rough = 0, approached = 0;
    int64_t reason = no_reason, place = on_motion, piece = 0;  // the bad piece, or the one before the bad stop
    int64_t kind = 0, joint = 0;                               // of the violated limit; 3: positions, of stops
    int64_t pair = -1, touches = 0;                            // unproven pair; 1: contact, 2: undecided by bounds
    int64_t pieces = 0, proven = 0;                            // pieces to prove, and number of proven curves
    int64_t may_hold = 0;                                      // whether a body can be inside another at the state
};

// Whether the pair that stopped a proof is within the margin: 1, 0, or 2 if only exact distances can decide.
inline int64_t touches(const World& world, const Proof& proof) {
    constexpr double tolerance = 1e-6;  // m, accuracy of bounds by planes
    if (proof.pair < 0 || !(proof.gap <= tolerance)) return 0;
    const Pair& pair = world.pairs[proof.pair];
    const double dents = world.items[pair.first].solid->depth + world.items[pair.second].solid->depth;
    return proof.gap + world.margin <= dents || proof.gap + dents <= tolerance ? 1 : 2;
}

// A world with its rules; threads can check at once, each in its own workspace.
class Gate {
   public:
    // World, bounds and boxes must outlive the gate. `is_timed`: obstacles have speed limits.
    Gate(const World& world, const Bounds& bounds, const PointsInBoxes& boxes, bool is_timed, double resolution,
         GateRules rules)
        : world_(world), bounds_(bounds), boxes_(boxes), is_timed_(is_timed), resolution_(resolution),
          rules_(std::move(rules)) {
        idle_.push_back(new_workspace());
    }

    const GateRules& rules() const { return rules_; }

    // Build a chunk from `given` and check it, with or without stops. `at` (1 + dof,) becomes the share of the bad curve
    // where its proof stopped, and the configuration there.
    Judgement judge(Chunk& chunk, int k, int rows, int state_rows, const double* given, bool stop, double* at) {
        Judgement found;
        if (!chunk.build(rules_, k, rows, state_rows, given)) return found;
        found.usable = 1, found.count = chunk.count, found.rough = chunk.rough, found.approached = chunk.approached;
        const int dof = rules_.dof;
        int where[2] = {0, 0};
        int64_t bad = first_beyond(chunk.count, chunk.degree, dof, chunk.pieces, chunk.seconds, (chunk.degree + 1) / 2,
                                   rules_.most.data(), rules_.lower.data(), rules_.upper.data(), where);
        for (int j = 0; j < dof && state_rows && chunk.degree == 1;
             ++j)  // other curves begin at the velocity of the state
            if (!(std::fabs(chunk.knot(0, 1, dof)[j]) <= rules_.most[j])) bad = 0, where[0] = 1, where[1] = j;
        if (bad >= 0) found.reason = beyond_limit, found.kind = where[0], found.joint = where[1], found.piece = bad;
        const int known = std::min(rows, state_rows) - 1;  // derivatives of both the state and the first point
        if (chunk.jump(2, known, dof, where) > rules_.apart && rules_.most[2 * dof + where[0]] < infinity)
            found.reason = beyond_limit, found.kind = 3, found.place = on_approach, found.joint = where[0],
            found.piece = bad = 0;
        if (chunk.jump(0, std::min(known, 1), dof, where) > rules_.apart)
            found.reason = not_there, found.place = on_approach, found.joint = where[0], found.piece = bad = 0;
        auto place = take_workspace();
        place->prepare(chunk, dof, stop);
        found.pieces = bad < 0 ? chunk.count : bad;
        for (int64_t i = 0; i < found.pieces && stop; ++i) {
            double* seconds = place->stop_seconds.data() + 2 * i;
            stop_from(chunk.knot(static_cast<int>(i) + 1, 0, dof), dof, rules_.times, rules_.limits.data(),
                      place->stops.data() + 10 * i * dof, seconds, where, place->end.data());
            if (seconds[1] > 0.0) continue;
            found.reason = beyond_limit, found.place = on_stop, found.kind = where[0] == 3 ? 0 : where[0] + 1;
            found.joint = where[1], found.piece = found.pieces = i;
        }
        prove(chunk, *place, stop, found, at);
        return_workspace(std::move(place));
        return found;
    }

   private:
    // Working memory of a thread.
    struct Workspace {
        Workspace(const World& world, const Bounds& bounds) : prover(world, bounds) {}

        void prepare(const Chunk& chunk, int dof, bool stop) {
            const size_t count = chunk.count, curves_of = 1 + (stop ? 3 : 1) * count;
            degree = stop ? std::max(chunk.degree, 4) : chunk.degree;
            if (stop) stops.resize(10 * count * dof), stop_seconds.resize(2 * count), end.resize(3 * dof);
            curves.resize(curves_of * (degree + 1) * dof), spans.resize(curves_of), of.resize(curves_of);
            count_ = 0;
        }
        void add(const double* c, int powers, int dof, Span span, Place place, int piece) {
            const size_t size = (static_cast<size_t>(degree) + 1) * dof;
            double* own = curves.data() + count_ * size;
            std::fill(std::copy(c, c + static_cast<size_t>(powers) * dof, own), own + size, 0.0);
            spans[count_] = span, of[count_++] = {place, piece};
        }

        Prover prover;
        int degree = 1, count_ = 0;
        std::vector<double> stops, stop_seconds, end, curves;
        std::vector<Span> spans;
        std::vector<std::pair<Place, int>> of;
        std::vector<Proof> proofs;
    };

    // Prove the approach to the first point, and the pieces within limits, each with the stop behind it.
    void prove(const Chunk& chunk, Workspace& here, bool stop, Judgement& found, double* at) const {
        const int dof = rules_.dof, powers = chunk.degree + 1;
        if (chunk.approached) here.add(chunk.approach, 2, dof, {}, on_approach, 0);
        for (int k = 0; k < found.pieces; ++k) {
            const double end = chunk.times[k + 1];
            here.add(chunk.pieces + static_cast<size_t>(k) * powers * dof, powers, dof,
                     {chunk.times[k], end - chunk.times[k], 0.0}, on_motion, k);
            double begin = end;
            for (int i = 2 * k; stop && i < 2 * k + 2; begin += here.stop_seconds[i++])
                if (here.stop_seconds[i] > 0.0)
                    here.add(here.stops.data() + static_cast<size_t>(i) * 5 * dof, 5, dof,
                             {begin, here.stop_seconds[i], 0.0}, on_stop, k);
        }
        if (!here.count_) return;
        const size_t size = (static_cast<size_t>(here.degree) + 1) * dof;
        int usable = 0;  // curves behind it exceed the range of proofs
        while (usable < here.count_ && within(here.curves.data() + usable * size, size, farthest) &&
               (!is_timed_ || here.spans[usable].holds()))
            ++usable;
        here.proofs.assign(here.count_, Proof());
        for (int k = usable; k < here.count_; ++k) here.proofs[k].verdict = undecided;
        const Pieces curves{here.curves.data(), usable, here.degree, dof};
        if (usable) {
            boxes_.find(1, curves.coefficients, [&](int, int, const Vec&) { found.may_hold = 1; });
            BoxProof(here.prover, curves, is_timed_ ? here.spans.data() : nullptr, resolution_, here.proofs.data())
                .prove(0, usable);
        }
        const auto bad = std::find_if(here.proofs.begin(), here.proofs.end(),
                                      [](const Proof& one) { return one.verdict != proven_free; });
        found.proven = bad - here.proofs.begin();
        if (bad == here.proofs.end()) return;
        found.reason = not_proven, found.place = here.of[found.proven].first,
        found.piece = here.of[found.proven].second;
        found.pair = bad->pair, found.touches = touches(world_, *bad), at[0] = bad->where;
        curves.at(static_cast<int>(found.proven), bad->where, at + 1);
    }

    std::unique_ptr<Workspace> new_workspace() const { return std::make_unique<Workspace>(world_, bounds_); }
    std::unique_ptr<Workspace> take_workspace() {
        {
            const std::lock_guard<std::mutex> alone(alone_);
            if (!idle_.empty()) {
                auto place = std::move(idle_.back());
                idle_.pop_back();
                return place;
            }
        }
        return new_workspace();
    }
    void return_workspace(std::unique_ptr<Workspace> place) {
        if (place->curves.capacity() > most_kept) return;
        const std::lock_guard<std::mutex> alone(alone_);
        idle_.push_back(std::move(place));
    }

    const World& world_;
    const Bounds& bounds_;
    const PointsInBoxes& boxes_;
    const bool is_timed_;
    const double resolution_;
    const GateRules rules_;
    std::mutex alone_;
    std::vector<std::unique_ptr<Workspace>> idle_;
};

}  // namespace planner
