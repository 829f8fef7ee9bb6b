// The parts of a GABF step: parent values of rows, and the flow of the rows towards them.
#pragma once

#include <limits>
#include <vector>

#include "flows.hpp"
#include "refusals.hpp"

namespace planner {

// Selected rows: `index`, or the first `count` without an index.
struct Rows {
    int64_t count;
    const int64_t* index;

    int64_t operator[](int64_t k) const { return index ? index[k] : k; }
    void require_within(int64_t rows) const {
        require(index ? between(index, count, 0, rows) : count <= rows, "there is no such row");
    }
};

// Arcs of rows in compressed form: the parent value of row i is the minimum of slope * y[head] + offset over its arcs;
// without slopes, they are 1.
struct Arcs {
    std::vector<int64_t> first;
    std::vector<int32_t> head;
    std::vector<double> slope, offset;
    int64_t states = 0;  // number of states, above every head

    int64_t rows() const { return static_cast<int64_t>(first.size()) - 1; }

    // Refuse fewer states than rows and heads, and rows out of range.
    void require_states(const Rows& those, int64_t there) const {
        require(there >= states && there >= rows(), "an arc reads what is no state");
        those.require_within(rows());
    }

    double parent_value(int64_t row, const double* y) const {
        double least = std::numeric_limits<double>::infinity();
        if (slope.empty())
            for (int64_t a = first[row]; a < first[row + 1]; ++a) least = std::min(least, y[head[a]] + offset[a]);
        else
            for (int64_t a = first[row]; a < first[row + 1]; ++a)
                least = std::min(least, slope[a] * y[head[a]] + offset[a]);
        return least;
    }
};

// Fewest arcs from each of `count` nodes to a source, -1 without a path: breadth first, against the arcs.
inline void hops_to_source(int64_t count, const int64_t* first, const int64_t* head, int64_t source_count,
                           const int64_t* sources, int64_t* hops) {
    std::vector<int64_t> end(count + 1);  // end of the readers of each node
    for (int64_t a = 0; a < first[count]; ++a) ++end[head[a] + 1];
    for (int64_t n = 0; n < count; ++n) end[n + 1] += end[n];
    std::vector<int32_t> reader(first[count]);
    for (int64_t n = 0; n < count; ++n)
        for (int64_t a = first[n]; a < first[n + 1]; ++a) reader[end[head[a]]++] = static_cast<int32_t>(n);

    std::fill(hops, hops + count, -1);
    std::vector<int64_t> reached(sources, sources + source_count);
    for (int64_t source : reached) hops[source] = 0;
    reached.reserve(count);
    for (size_t k = 0; k < reached.size(); ++k) {
        poll_signal_at(static_cast<int64_t>(k));
        const int64_t node = reached[k];
        for (int64_t r = node ? end[node - 1] : 0; r < end[node]; ++r)
            if (hops[reader[r]] < 0) hops[reader[r]] = hops[node] + 1, reached.push_back(reader[r]);
    }
}

// Nonzero disequilibria of a block of rows, before and after the flow.
struct Moving {
    int n = 0;
    int at[flow_block];
    double before[flow_block], left[flow_block];

    void add(int k, double s) {
        if (s != 0.0) at[n] = k, before[n] = s, left[n++] = std::abs(s);
    }
    void move(const Flow& flow, Order order, double dtau) {
        flow_moves(flow, order, dtau, n, left);
        for (int k = 0; k < n; ++k) left[k] = std::copysign(left[k], before[k]);
    }
};

// next = y - xhat (the parent value) + xhat after the flow, in the order brake, sink.
inline void sketch_rows(const Flow& flow, const Rows& rows, int64_t begin, int64_t end, const double* y,
                        const double* xhat, double dtau, double* next) {
    Moving moving;
    for (int64_t k = begin; k < end; ++k) moving.add(static_cast<int>(k - begin), xhat[rows[k]]);
    moving.move(flow, brake_then_sink, dtau);
    for (int k = 0; k < moving.n; ++k) {
        const int64_t row = rows[begin + moving.at[k]];
        next[row] = y[row] - moving.before[k] + moving.left[k];
    }
}

// next = m + (y - m) after the flow; returns an error estimate, see Parents.step in gabf/splitting.py.
inline double advance_rows(const Flow& flow, const Rows& rows, int64_t begin, int64_t end, const double* m,
                           const double* y, const double* xhat, double dtau, double size, double* next) {
    Moving moving;
    for (int64_t k = begin; k < end; ++k) {
        next[rows[k]] = m[k];
        moving.add(static_cast<int>(k - begin), y[rows[k]] - m[k]);
    }
    moving.move(flow, strang, dtau);
    double largest = 0.0;
    for (int k = 0; k < moving.n; ++k) {
        const int64_t at = begin + moving.at[k], row = rows[at];
        const double s = moving.before[k], left = moving.left[k], moved = m[at] - (y[row] - xhat[row]);
        next[row] = m[at] + left;
        if (next[row] == y[row]) next[row] = std::nextafter(y[row], m[at]);  // rounding must not stop the row
        const double scale = (size + std::abs(xhat[row])) * std::abs(s);
        if (scale > 0.0) largest = std::max(largest, std::abs(moved * (s - left)) / scale);
    }
    return largest;
}

// Residuals of rows: the largest |y - m|, the range of the states, and the smallest state or parent value of rows that
// move.
struct Residuals {
    static constexpr double nowhere = std::numeric_limits<double>::infinity();
    double residual = 0.0, lowest = nowhere, highest = -nowhere, lowest_moving = nowhere;

    void add(const Residuals& other) {
        residual = std::max(residual, other.residual);
        lowest = std::min(lowest, other.lowest), highest = std::max(highest, other.highest);
        lowest_moving = std::min(lowest_moving, other.lowest_moving);
    }
};

// Write xhat = y - m of the rows.
inline Residuals measure_rows(const Arcs& arcs, const Rows& rows, int64_t begin, int64_t end, const double* y,
                              double* xhat) {
    Residuals found;
    for (int64_t k = begin; k < end; ++k) {
        const int64_t row = rows[k];
        const double m = arcs.parent_value(row, y), s = y[row] - m;
        xhat[row] = s;
        found.residual = std::max(found.residual, std::abs(s));
        found.lowest_moving = std::min(found.lowest_moving, s != 0.0 ? std::min(y[row], m) : Residuals::nowhere);
    }
    return found;
}

inline Residuals range_of(const double* y, int64_t begin, int64_t end) {
    Residuals found;
    for (int64_t k = begin; k < end; ++k)
        found.lowest = std::min(found.lowest, y[k]), found.highest = std::max(found.highest, y[k]);
    return found;
}

}  // namespace planner
