// The dynamics, as Python asks them: hops, parent values of rows, and how rows move towards them.
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

// y - m (R,) of all rows, 0 but at those that are looked at, and how they stand.
inline Standing stand(const Arcs& arcs, const Rows& rows, const double* y, double* xhat) {
    if (rows.index) std::fill_n(xhat, arcs.rows(), 0.0);
    std::vector<Standing> found((arcs.rows() + flow_block - 1) / flow_block);
    share_out_rows(arcs.rows(), [&](int64_t begin, int64_t end, int block) { found[block] = range_of(y, begin, end); });
    share_out_rows(rows.count, [&](int64_t begin, int64_t end, int block) {
        found[block].add(stand_rows(arcs, rows, begin, end, y, xhat));
    });
    Standing all;
    for (const Standing& part : found) all.add(part);
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
    const Standing all = stand(arcs, rows, y, xhat);
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
    Made<double, 1> next = copied(y.data(), Made<double, 1>(y.size())), next_xhat(arcs.rows());
    const double off = advance(flow, rows, m.data(), y, xhat, dtau, size, next);
    const Standing all = stand(arcs, rows, next, next_xhat);
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

// States that are written into.
using Into = nb::ndarray<double, nb::shape<any>, nb::c_contig, nb::device::cpu>;

inline void require_room(int64_t rows, const Floats<any>& y, const Into& following) {
    require(y.count() >= rows && static_cast<int64_t>(following.size()) >= rows, "there are more rows than states");
}

inline void sketch_into(const Flow& flow, const Index& index, const Floats<any>& y, const Floats<any>& xhat,
                        double dtau, const Into& following) {
    require_room(xhat.count(), y, following);
    sketch(flow, rows_of(index, xhat.count()), y, xhat, dtau, following.data());
}

inline double advance_into(const Flow& flow, const Index& index, const Floats<any>& m, const Floats<any>& y,
                           const Floats<any>& xhat, double dtau, double size, const Into& following) {
    const Rows rows = rows_of(index, xhat.count());
    require_room(xhat.count(), y, following);
    return advance(flow, rows, m.of({rows.count}), y, xhat, dtau, size, following.data());
}

inline void bind_dynamics(nb::module_& m) {
    m.attr("STRANG") = static_cast<int>(strang), m.attr("BRAKE_THEN_SINK") = static_cast<int>(brake_then_sink);
    m.attr("SINK_THEN_BRAKE") = static_cast<int>(sink_then_brake);
    m.def("hops_to_source", &hops, "indptr"_a, "heads"_a, "sources"_a, at_work,
          "(n,) fewest arcs from each node to a source, -1 where there is no path.\n\n"
          "Node i reads the nodes heads[indptr[i]:indptr[i + 1]].");
    nb::class_<Flow>(
        m, "NativeFlow",
        "s' = -(beta1 |s|^(1 - below) + beta2 |s|^(1 + above)) sgn(s), or s' = -s where below is 0.\n\n"
        "The powers above 1 brake and those below 1 sink; Strang's order: half a sink, a brake, half a sink.")
        .def(
            "__init__",
            [](Flow* self, double beta1, double beta2, double below, double above) {
                new (self) Flow{beta1, beta2, below, above};
            },
            "beta1"_a, "beta2"_a, "below"_a, "above"_a)
        .def("moved", &moved, "order"_a, "s"_a, "dtau"_a, at_work,
             "s after dtau, to 1e-13 relative; 0 stays 0, and no |s| grows.")
        .def("sketch", &sketch_into, "rows"_a.none(), "y"_a, "xhat"_a, "dtau"_a, "following"_a.noconvert(), at_work,
             "Write into following the rows' y after dtau, the brake before the sink; xhat (R,) is y - m.")
        .def("advance", &advance_into, "rows"_a.none(), "m"_a, "y"_a, "xhat"_a, "dtau"_a, "size"_a,
             "following"_a.noconvert(), at_work,
             "Write into following the rows' y after dtau by Strang's rule, with parents at m (rows,).\n\n"
             "How far off that may be, as a share of size + |xhat|: planner.gabf.splitting.Parents.step.");
    nb::class_<Arcs>(m, "NativeArcs",
                     "The arcs of R rows: row i reads heads[starts[i]:starts[i + 1]] as slope y + offset.\n\n"
                     "Slopes are 1 where there are none. rows are those that are looked at, None for all.")
        .def("__init__", made_by(&arcs_of), "starts"_a, "heads"_a, "slope"_a.none(), "offset"_a)
        .def("parent_values", &parent_values, "rows"_a.none(), "y"_a, at_work,
             "(rows,) the least of each row's arcs at states y.")
        .def("standing", &standing, "rows"_a.none(), "y"_a, at_work,
             "y - m (R,), 0 but at rows, and the largest of its sizes; the least and the largest y of all R rows.\n\n"
             "Last the least of y and m of the rows where they differ; inf where none does.")
        .def("step", &step, "flow"_a, "rows"_a.none(), "y"_a, "xhat"_a, "half"_a, "dtau"_a, "size"_a, at_work,
             "What follows y after dtau, what standing says of it, and how far off it may be.\n\n"
             "Parent values are those at NativeFlow.sketch after half; the last as NativeFlow.advance.");
}

}  // namespace planner
