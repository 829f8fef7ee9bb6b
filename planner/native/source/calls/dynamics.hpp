// What Python asks of the dynamics; see ../../dynamics.py for shapes.
#pragma once

#include "../dynamics.hpp"
#include "../sharing.hpp"

namespace planner {
namespace {

void find_parents(const Arcs& arcs, const Rows& rows, const double* y, int threads, double* m) {
    share_out_rows(rows.count, threads, [&](int64_t begin, int64_t end, int) {
        for (int64_t k = begin; k < end; ++k) m[k] = arcs.parent_value(rows[k], y);
    });
}

void sketch(const Flow& flow, const Rows& rows, const double* y, const double* xhat, double dtau, int threads,
            double* next) {
    share_out_rows(rows.count, threads,
                   [&](int64_t begin, int64_t end, int) { sketch_rows(flow, rows, begin, end, y, xhat, dtau, next); });
}

double advance(const Flow& flow, const Rows& rows, const double* m, const double* y, const double* xhat, double dtau,
               double size, int threads, double* next) {
    std::vector<double> off((rows.count + flow_block - 1) / flow_block);
    share_out_rows(rows.count, threads, [&](int64_t begin, int64_t end, int block) {
        off[block] = advance_rows(flow, rows, begin, end, m, y, xhat, dtau, size, next);
    });
    return rows.count ? *std::max_element(off.begin(), off.end()) : 0.0;
}

void stand(const Arcs& arcs, const Rows& rows, const double* y, int threads, double* xhat, double* standing) {
    std::vector<Standing> found((arcs.rows() + flow_block - 1) / flow_block);
    share_out_rows(arcs.rows(), threads,
                   [&](int64_t begin, int64_t end, int block) { found[block] = range_of(y, begin, end); });
    share_out_rows(rows.count, threads, [&](int64_t begin, int64_t end, int block) {
        found[block].add(stand_rows(arcs, rows, begin, end, y, xhat));
    });
    Standing all;
    for (const Standing& part : found) all.add(part);
    standing[0] = all.residual, standing[1] = all.lowest, standing[2] = all.highest, standing[3] = all.lowest_moving;
}

}  // namespace

extern "C" {

// Rows (count,) of `arcs` arcs: `first` (count + 1,), `head` and `offset` (arcs,), `slope` (arcs,) or null
Arcs* arcs_new(int64_t count, int64_t arcs, const int64_t* first, const int64_t* head, const double* slope,
               const double* offset) {
    return answered([&] {
        require(are_offsets(first, count, arcs), "the rows do not fit the arcs");
        require(between(head, arcs, 0, INT32_MAX), "an arc reads what is no state");
        std::unique_ptr<Arcs> made(
            new Arcs{{first, first + count + 1}, {head, head + arcs}, {}, {offset, offset + arcs}});
        if (slope) made->slope.assign(slope, slope + arcs);
        if (arcs > 0) made->states = 1 + *std::max_element(head, head + arcs);
        return made.release();
    });
}

void arcs_free(Arcs* arcs) { delete arcs; }

// m (count,) of rows `index` (count,), or of the first `count`, at states y (states,)
int arcs_parent_values(const Arcs* arcs, int64_t count, const int64_t* index, int64_t states, const double* y,
                       int threads, double* m) {
    return answered([&] {
        const Rows rows{count, index};
        arcs->require_states(rows, states);
        find_parents(*arcs, rows, y, threads, m);
    });
}

// hops (count,) of nodes whose arcs `head` (arcs,) go from first[n] to first[n + 1]
int arcs_hops(int64_t count, const int64_t* first, int64_t arcs, const int64_t* head, int64_t source_count,
              const int64_t* sources, int64_t* hops) {
    return answered([&] {
        require(are_offsets(first, count, arcs), "the nodes do not fit the arcs");
        require(count < INT32_MAX && between(head, arcs, 0, count), "an arc reads what is no node");
        require(between(sources, source_count, 0, count), "a source is no node");
        hops_to_source(count, first, head, source_count, sources, hops);
    });
}

// moved (n,): s after dtau, `order` as in flows.hpp
int flow_moved(const Flow* flow, int order, int64_t n, const double* s, double dtau, int threads, double* moved) {
    return answered([&] {
        require(order >= strang && order <= sink_then_brake, "there is no such order");
        share_out_rows(n, threads, [&](int64_t begin, int64_t end, int) {
            for (int64_t k = begin; k < end; ++k) moved[k] = std::abs(s[k]);
            flow_moves(*flow, static_cast<Order>(order), dtau, static_cast<int>(end - begin), moved + begin);
            for (int64_t k = begin; k < end; ++k) moved[k] = std::copysign(moved[k], s[k]);
        });
    });
}

// Rows `index` (count,), or the first `count`, of y, xhat and next (all,)
int flow_sketch(const Flow* flow, int64_t count, const int64_t* index, int64_t all, const double* y, const double* xhat,
                double dtau, int threads, double* next) {
    return answered([&] {
        const Rows rows{count, index};
        rows.require_within(all);
        sketch(*flow, rows, y, xhat, dtau, threads, next);
    });
}

// The same, with parents at m (count,); how far off next may be
double flow_advance(const Flow* flow, int64_t count, const int64_t* index, int64_t all, const double* m,
                    const double* y, const double* xhat, double dtau, double size, int threads, double* next) {
    return answered([&] {
        const Rows rows{count, index};
        rows.require_within(all);
        return advance(*flow, rows, m, y, xhat, dtau, size, threads, next);
    });
}

// xhat (all,) of rows `index` (count,), or of the first `count`; standing (4,): the largest |xhat| of these, the least
// and the largest of the states y (states,) of all rows, and the least state or parent value of those that move
int arcs_standing(const Arcs* arcs, int64_t count, const int64_t* index, int64_t states, const double* y, int threads,
                  double* xhat, double* standing) {
    return answered([&] {
        const Rows rows{count, index};
        arcs->require_states(rows, states);
        stand(*arcs, rows, y, threads, xhat, standing);
    });
}

// Rows `index` (count,) of all, or the first `count`, of states y (states,), sketched by `half` and advanced by dtau
// towards their parents there. In `found`, one after the other: the states then (states,), xhat (all,), arcs_standing's
// four numbers, and what flow_advance returns
int arcs_step(const Arcs* arcs, const Flow* flow, int64_t count, const int64_t* index, int64_t states, const double* y,
              const double* xhat, double half, double dtau, double size, int threads, double* found) {
    return answered([&] {
        const Rows rows{count, index};
        arcs->require_states(rows, states);
        double *next = found, *next_xhat = found + states, *standing = next_xhat + arcs->rows();
        std::vector<double> mid(y, y + states), m(count);
        sketch(*flow, rows, y, xhat, half, threads, mid.data());
        find_parents(*arcs, rows, mid.data(), threads, m.data());
        std::copy(y, y + states, next);
        standing[4] = advance(*flow, rows, m.data(), y, xhat, dtau, size, threads, next);
        if (index) std::fill(next_xhat, standing, 0.0);
        stand(*arcs, rows, next, threads, next_xhat, standing);
    });
}

}  // extern "C"

}  // namespace planner
