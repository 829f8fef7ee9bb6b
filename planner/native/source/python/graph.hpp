// Bindings of graphs: cheapest paths, their costs, and detours.
#pragma once

#include "../graph.hpp"
#include "../sharing.hpp"
#include "arrays.hpp"

namespace planner {

inline Made<double, 1> detours(int nodes, const Ints<any, 2>& edges, const Floats<any>& lengths,
                               const Ints<any, 2>& pairs, const Floats<any>& limits) {
    const int count = pairs.count();
    lengths.of({edges.count()}), limits.of({count});
    require(between(edges, edges.size(), 0, nodes), "an edge ends at what is no node");
    require(between(pairs, pairs.size(), 0, nodes), "a pair names what is no node");
    require(not_negative(lengths, lengths.size(), infinity), "a length is no distance");
    const Graph graph(nodes, edges.count(), edges, lengths);
    Made<double, 1> found(count);
    share_out(
        count, 64, [&] { return DetourSearch(graph); },
        [&](int k, DetourSearch& search) {
            found[k] = search.length(static_cast<int>(pairs[2 * k]), static_cast<int>(pairs[2 * k + 1]), limits[k]);
        });
    return found;
}

inline auto cheapest_path(int nodes, const Ints<any, 2>& arcs, const Floats<any>& costs, const Ints<any>& starts,
                          const Ints<any>& goals) {
    require_arcs(nodes, arcs.count(), arcs, costs.of({arcs.count()}));
    require(between(starts, starts.size(), 0, nodes) && between(goals, goals.size(), 0, nodes), "an end is no node");
    CostSearch search(nodes, arcs.count(), arcs, costs);
    std::vector<char> is_start(nodes);
    for (size_t k = 0; k < starts.size(); ++k) is_start[starts[k]] = 1;
    std::vector<int64_t> path, used;
    const int start = search.run({goals + 0, goals + goals.size()}, nullptr, [&](int node) { return is_start[node]; });
    for (int node = start; node >= 0; node = search.next[node]) path.push_back(node), used.push_back(search.by[node]);
    if (!used.empty()) used.pop_back();
    return std::tuple{made_of(path), made_of(used)};
}

inline Made<double, 1> cheapest_costs(int nodes, const Ints<any, 2>& arcs, const Floats<any>& costs,
                                      const Ints<any>& goals, const Floats<any>& values) {
    require_arcs(nodes, arcs.count(), arcs, costs.of({arcs.count()}));
    require(between(goals, goals.size(), 0, nodes), "a goal is no node");
    require(within(values.of({goals.count()}), values.size(), infinity), "a goal's value is no number");
    CostSearch search(nodes, arcs.count(), arcs, costs);
    search.run({goals + 0, goals + goals.size()}, values, [](int) { return false; });
    return made_of(search.cost);
}

inline void bind_graph(nb::module_& m) {
    m.def("detours", &detours, "nodes"_a, "edges"_a, "lengths"_a, "pairs"_a, "limits"_a, at_work,
          "Return lengths (k,) of shortest paths between pairs (k, 2) in a graph of undirected edges (m, 2).\n\n"
          "The length is inf if it exceeds its limit (k,), or without a path.");
    m.def("cheapest_path", &cheapest_path, "nodes"_a, "arcs"_a, "cost"_a, "starts"_a, "goals"_a, at_work,
          "Return the cheapest path over directed arcs (m, 2) from a start to a goal.\n\n"
          "Return its nodes (k,), and the rows (k - 1,) of its arcs; both are empty without a path.");
    m.def("cheapest_costs", &cheapest_costs, "nodes"_a, "arcs"_a, "cost"_a, "goals"_a, "values"_a, at_work,
          "Return the cost (n,) of the cheapest path from every node to a goal over arcs (m, 2); inf without one.\n\n"
          "It includes the value (g,) of the goal. cost (m,) is positive.");
}

}  // namespace planner
