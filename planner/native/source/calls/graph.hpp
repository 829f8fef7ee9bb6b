// What Python asks of graphs and curves; see ../../graphs.py and ../../library.py for shapes and units.
#pragma once

#include "../graph.hpp"
#include "../refusals.hpp"
#include "../sharing.hpp"
#include "../time_optimal.hpp"

namespace planner {

extern "C" {

// Lengths (count,) of the shortest paths between pairs (count, 2) of nodes; infinite beyond limits (count,)
int graph_detours(int nodes, int edges, const int64_t* ends, const double* lengths, int count, const int64_t* pairs,
                  const double* limits, int threads, double* detours) {
    return answered([&] {
        require(between(ends, 2 * static_cast<size_t>(edges), 0, nodes), "an edge ends at what is no node");
        require(between(pairs, 2 * static_cast<size_t>(count), 0, nodes), "a pair names what is no node");
        require(not_negative(lengths, edges, infinity), "a length is no distance");
        const Graph graph(nodes, edges, ends, lengths);
        share_out(
            count, threads, 64, [&] { return DetourSearch(graph); },
            [&](int k, DetourSearch& search) {
                detours[k] =
                    search.length(static_cast<int>(pairs[2 * k]), static_cast<int>(pairs[2 * k + 1]), limits[k]);
            });
    });
}

// The cheapest path over arcs (count, 2) from one of `starts` to one of `goals`: its nodes, `path` (nodes,), their number,
// and which arcs lead from one to the next, `used` (nodes,), -1 from the last one
int graph_cheapest(int nodes, int arcs, const int64_t* ends, const double* costs, int start_count,
                   const int64_t* starts, int goal_count, const int64_t* goals, int64_t* path, int64_t* used) {
    return answered([&] {
        require_arcs(nodes, arcs, ends, costs);
        require(between(starts, start_count, 0, nodes) && between(goals, goal_count, 0, nodes), "an end is no node");
        CostSearch search(nodes, arcs, ends, costs);
        std::vector<char> is_start(nodes);
        for (int k = 0; k < start_count; ++k) is_start[starts[k]] = 1;
        int count = 0;
        const int start = search.run({goals, goals + goal_count}, nullptr, [&](int node) { return is_start[node]; });
        for (int node = start; node >= 0; node = search.next[node], ++count)
            path[count] = node, used[count] = search.by[node];
        return count;
    });
}

// The cost (nodes,) of the cheapest path over arcs (count, 2) to one of `goals`, their own `values` added
int graph_costs(int nodes, int arcs, const int64_t* ends, const double* costs, int goal_count, const int64_t* goals,
                const double* values, double* found) {
    return answered([&] {
        require_arcs(nodes, arcs, ends, costs);
        require(between(goals, goal_count, 0, nodes), "a goal is no node");
        require(within(values, goal_count, infinity), "a goal's value is no number");
        CostSearch search(nodes, arcs, ends, costs);
        search.run({goals, goals + goal_count}, values, [](int) { return false; });
        std::copy(search.cost.begin(), search.cost.end(), found);
    });
}

}  // extern "C"

}  // namespace planner
