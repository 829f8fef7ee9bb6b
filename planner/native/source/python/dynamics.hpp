// Bindings of the dynamics: hops, parent values of rows, and steps towards them.
#pragma once

#include "../dynamics.hpp"
#include "../sharing.hpp"
#include "arrays.hpp"

namespace planner {

using Index = std::optional<Ints<any>>;  // rows, or all

// The rows of `index`, or all `rows`.
inline Rows rows_of(const Index& index, int64_t rows) {
    const Rows found{index ? index->count() : rows, data_of(index)};
    found.require_within(rows);
    return found;
}

inline Made<int64_t, 1> hops(const Ints<any>& first, const Ints<any>& heads, const Ints<any>& sources) {
    const int64_t count = first.count() - 1, arcs = heads.count();
    require(count >= 0 && are_offsets(first, count, arcs), "the nodes do not fit the arcs");
    require(between(heads, arcs, 0, count), "an arc reads what is no node");
    require(between(sources, sources.count(), 0, count), "a source is no node");
    Made<int64_t, 1> found(count);
    hops_to_source(count, first, heads, sources.count(), sources, found);
    return found;
}

inline Arcs arcs_of(const Ints<any>& starts, const Ints<any>& heads, const std::optional<Floats<any>>& slope,
                    const Floats<any>& offset) {
    const int64_t rows = starts.count(), arcs = heads.count();
    std::vector<int64_t> first(starts + 0, starts + rows);
    first.push_back(arcs);
    require(are_offsets(first.data(), rows, arcs), "the rows do not fit the arcs");
    require(between(heads, arcs, 0, INT32_MAX), "an arc reads what is no state");
    Arcs made{std::move(first), {heads + 0, heads + arcs}, {}, {offset.of({arcs}) + 0, offset + arcs}};
    if (slope) made.slope.assign(slope->of({arcs}) + 0, *slope + arcs);
    if (arcs > 0) made.states = 1 + *std::max_element(heads + 0, heads + arcs);
    return made;
}

inline void find_parents(const Arcs& arcs, const Rows& rows, const double* y, double* m) {
    share_out_rows(rows.count, [&](int64_t begin, int64_t end, int) {
        for (int64_t k = begin; k < end; ++k) m[k] = arcs.parent_value(rows[k], y);
    });
}

inline void sketch(const Flow& flow, const Rows& rows, const double* y, const double* xhat, double dtau, double* next) {
    share_out_rows(rows.count,
                   [&](int64_t begin, int64_t end, int) { sketch_rows(flow, rows, begin, end, y, xhat, dtau, next); });
}

inline double advance(const Flow& flow, const Rows& rows, const double* m, const double* y, const double* xhat,
                      double dtau, double size, double* next) {
    std::vector<double> off((rows.count + flow_block - 1) / flow_block);
    share_out_rows(rows.count, [&](int64_t begin, int64_t end, int block) {
        off[block] = advance_rows(flow, rows, begin, end, m, y, xhat, dtau, size, next);
    });
    return rows.count ? *std::max_element(off.begin(), off.end()) : 0.0;
}

// Write xhat = y - m (R,), 0 except at the selected rows; returns the residuals.
inline Residuals measure_residuals(const Arcs& arcs, const Rows& rows, const double* y, double* xhat) {
    if (rows.index) std::fill_n(xhat, arcs.rows(), 0.0);
    std::vector<Residuals> found((arcs.rows() + flow_block - 1) / flow_block);
    share_out_rows(arcs.rows(), [&](int64_t begin, int64_t end, int block) { found[block] = range_of(y, begin, end); });
    share_out_rows(rows.count, [&](int64_t begin, int64_t end, int block) {
        found[block].add(measure_rows(arcs, rows, begin, end, y, xhat));
    });
    Residuals all;
    for (const Residuals& part : found) all.add(part);
    return all;
}

inline Made<double, 1> parent_values(const Arcs& arcs, const Index& index, const Floats<any>& y) {
    const Rows rows = rows_of(index, arcs.rows());
    arcs.require_states(rows, y.count());
    Made<double, 1> m(rows.count);
    find_parents(arcs, rows, y, m);
    return m;
}

inline auto standing(const Arcs& arcs, const Index& index, const Floats<any>& y) {
    const Rows rows = rows_of(index, arcs.rows());
    arcs.require_states(rows, y.count());
    Made<double, 1> xhat(arcs.rows());
    const Residuals all = measure_residuals(arcs, rows, y, xhat);
    return std::tuple{std::move(xhat), all.residual, all.lowest, all.highest, all.lowest_moving};
}

inline auto step(const Arcs& arcs, const Flow& flow, const Index& index, const Floats<any>& y, const Floats<any>& xhat,
                 double half, double dtau, double size) {
    const Rows rows = rows_of(index, arcs.rows());
    arcs.require_states(rows, y.count());
    xhat.of({arcs.rows()});
    std::vector<double> mid(y + 0, y + y.size()), m(rows.count);
    sketch(flow, rows, y, xhat, half, mid.data());
    find_parents(arcs, rows, mid.data(), m.data());
    Made<double, 1> next = copy_into(y.data(), Made<double, 1>(y.size())), next_xhat(arcs.rows());
    const double off = advance(flow, rows, m.data(), y, xhat, dtau, size, next);
    const Residuals all = measure_residuals(arcs, rows, next, next_xhat);
    return std::tuple{std::move(next), std::move(next_xhat), all.residual, all.lowest,
                      all.highest,     all.lowest_moving,    off};
}

inline Made<double, 1> moved(const Flow& flow, int order, const Floats<any>& s, double dtau) {
    require(order >= strang && order <= sink_then_brake, "there is no such order");
    Made<double, 1> after(s.size());
    share_out_rows(s.count(), [&](int64_t begin, int64_t end, int) {
        for (int64_t k = begin; k < end; ++k) after[k] = std::abs(s[k]);
        flow_moves(flow, static_cast<Order>(order), dtau, static_cast<int>(end - begin), after + begin);
        for (int64_t k = begin; k < end; ++k) after[k] = std::copysign(after[k], s[k]);
    });
    return after;
}

// States to write.
using Into = nb::ndarray<double, nb::shape<any>, nb::c_contig, nb::device::cpu>;

inline void require_memory(int64_t rows, const Floats<any>& y, const Into& following) {
    require(y.count() >= rows && static_cast<int64_t>(following.size()) >= rows, "there are more rows than states");
}

inline void sketch_into(const Flow& flow, const Index& index, const Floats<any>& y, const Floats<any>& xhat,
                        double dtau, const Into& following) {
    require_memory(xhat.count(), y, following);
    sketch(flow, rows_of(index, xhat.count()), y, xhat, dtau, following.data());
}

inline double advance_into(const Flow& flow, const Index& index, const Floats<any>& m, const Floats<any>& y,
                           const Floats<any>& xhat, double dtau, double size, const Into& following) {
    const Rows rows = rows_of(index, xhat.count());
    require_memory(xhat.count(), y, following);
    return advance(flow, rows, m.of({rows.count}), y, xhat, dtau, size, following.data());
}

inline void bind_dynamics(nb::module_& m) {
    m.attr("STRANG") = static_cast<int>(strang), m.attr("BRAKE_THEN_SINK") = static_cast<int>(brake_then_sink);
    m.attr("SINK_THEN_BRAKE") = static_cast<int>(sink_then_brake);
    m.def("hops_to_source", &hops, "indptr"_a, "heads"_a, "sources"_a, at_work,
          "Fewest arcs (n,) from each node to a source, -1 without a path.\n\n"
          "Node i reads the nodes heads[indptr[i]:indptr[i + 1]].");
    nb::class_<Flow>(
        m, "NativeFlow",
        "The flow s' = -(beta1 |s|^(1 - below) + beta2 |s|^(1 + above)) sgn(s), or s' = -s for below = 0.\n\n"
        "The powers above 1 brake and those below 1 sink; Strang's order is half a sink, a brake, half a sink.")
        .def(
            "__init__",
            [](Flow* self, double beta1, double beta2, double below, double above) {
                new (self) Flow{beta1, beta2, below, above};
            },
            "beta1"_a, "beta2"_a, "below"_a, "above"_a)
        .def("moved", &moved, "order"_a, "s"_a, "dtau"_a, at_work,
             "Return s after dtau, to 1e-13 relative; 0 stays 0, and no |s| grows.")
        .def("sketch", &sketch_into, "rows"_a.none(), "y"_a, "xhat"_a, "dtau"_a, "following"_a.noconvert(), at_work,
             "Write the rows' y after dtau into following, the brake before the sink; xhat (R,) is y - m.")
        .def("advance", &advance_into, "rows"_a.none(), "m"_a, "y"_a, "xhat"_a, "dtau"_a, "size"_a,
             "following"_a.noconvert(), at_work,
             "Write the rows' y after dtau into following, by Strang's rule, with parents m (rows,).\n\n"
             "Return an error estimate relative to size + |xhat|, see planner.gabf.splitting.Parents.step.");
    nb::class_<Arcs>(m, "NativeArcs",
                     "The arcs of R rows: row i reads heads[starts[i]:starts[i + 1]] as slope y + offset.\n\n"
                     "Slopes are 1 by default. rows selects rows, None for all.")
        .def("__init__", construct_by(&arcs_of), "starts"_a, "heads"_a, "slope"_a.none(), "offset"_a)
        .def("parent_values", &parent_values, "rows"_a.none(), "y"_a, at_work,
             "Return the minimum (rows,) over each row's arcs at states y.")
        .def("standing", &standing, "rows"_a.none(), "y"_a, at_work,
             "Return y - m (R,), 0 except at rows, its largest absolute value, and the range of y.\n\n"
             "The last value is the smallest y or m of rows where they differ, or inf.")
        .def("step", &step, "flow"_a, "rows"_a.none(), "y"_a, "xhat"_a, "half"_a, "dtau"_a, "size"_a, at_work,
             "Return y after dtau, the results of standing there, and an error estimate.\n\n"
             "Parent values are those after NativeFlow.sketch by half; the last value is as in NativeFlow.advance.");
}

}  // namespace planner
