// Shortest paths in graphs: lengths of detours up to a limit, and Dijkstra's search from goals.
#pragma once

#include <queue>
#include <vector>

#include "convex.hpp"
#include "refusals.hpp"

namespace planner {

// An undirected graph in compressed rows.
struct Graph {
    int nodes;
    std::vector<int> first, to;
    std::vector<double> length;

    Graph(int nodes, int edges, const int64_t* ends, const double* lengths)
        : nodes(nodes), first(nodes + 1), to(2 * edges), length(2 * edges) {
        for (int e = 0; e < 2 * edges; ++e) ++first[ends[e] + 1];
        for (int n = 0; n < nodes; ++n) first[n + 1] += first[n];
        std::vector<int> next(first.begin(), first.end() - 1);
        for (int e = 0; e < edges; ++e)
            for (int side = 0; side < 2; ++side) {
                int here = next[ends[2 * e + side]]++;
                to[here] = static_cast<int>(ends[2 * e + 1 - side]), length[here] = lengths[e];
            }
    }
};

// Bidirectional search (Pohl 1971); only visited nodes are reset afterwards, so a short search is cheap.
class DetourSearch {
   public:
    explicit DetourSearch(const Graph& graph) : graph_(graph) {
        for (Side& side : sides_) side.away.assign(graph.nodes, infinity);
    }

    // Length of the shortest path between two nodes; infinite if it exceeds `limit`.
    double length(int a, int b, double limit) {
        if (a == b) return 0.0;
        sides_[0].begin(a), sides_[1].begin(b);
        double best = infinity;
        while (!sides_[0].open.empty() && !sides_[1].open.empty()) {
            const double first = sides_[0].open.top().first, second = sides_[1].open.top().first;
            if (first + second >= best || first + second > limit) break;
            Side &here = sides_[first <= second ? 0 : 1], &other = sides_[first <= second ? 1 : 0];
            poll_signal_at(++rounds_);
            const auto [away, node] = here.open.top();
            here.open.pop();
            if (away > here.away[node]) continue;
            for (int e = graph_.first[node]; e < graph_.first[node + 1]; ++e) {
                const double longer = away + graph_.length[e];
                if (longer >= here.away[graph_.to[e]]) continue;
                here.reach(graph_.to[e], longer);
                best = std::min(best, longer + other.away[graph_.to[e]]);
            }
        }
        for (Side& side : sides_) side.clear();
        return best <= limit ? best : infinity;
    }

   private:
    using Entry = std::pair<double, int>;
    struct Side {
        std::vector<double> away;
        std::vector<int> touched;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;

        void begin(int node) { reach(node, 0.0); }
        void reach(int node, double distance) {
            if (away[node] == infinity) touched.push_back(node);
            away[node] = distance;
            open.push({distance, node});
        }
        void clear() {
            for (int node : touched) away[node] = infinity;
            touched.clear();
            open = {};
        }
    };

    const Graph& graph_;
    Side sides_[2];
    int64_t rounds_ = 0;
};

inline void require_arcs(int nodes, int arcs, const int64_t* ends, const double* costs) {
    require(between(ends, 2 * static_cast<size_t>(arcs), 0, nodes), "an arc ends at what is no node");
    require(not_negative(costs, arcs, infinity), "a cost is negative or no number");
}

// Dijkstra's search from goals, against directed arcs (tail, head); ties are resolved by the order of nodes.
class CostSearch {
   public:
    std::vector<double> cost;  // of the cheapest path to a goal, plus that goal's value; infinite without a path
    std::vector<int> next;     // next node on that path, -1 at goals
    std::vector<int> by;       // arc to the next node

    CostSearch(int nodes, int arcs, const int64_t* ends, const double* costs)
        : cost(nodes, infinity), next(nodes, -1), by(nodes, -1), first_(nodes + 1), into_(arcs) {
        for (int a = 0; a < arcs; ++a) ++first_[ends[2 * a + 1] + 1];
        for (int n = 0; n < nodes; ++n) first_[n + 1] += first_[n];
        std::vector<int> free(first_.begin(), first_.end() - 1);
        for (int a = 0; a < arcs; ++a) into_[free[ends[2 * a + 1]]++] = {static_cast<int>(ends[2 * a]), a, costs[a]};
    }

    // Search until `last(node)` holds; returns that node, or -1. `values` are costs of the goals, or null.
    template <typename Last>
    int run(const std::vector<int>& goals, const double* values, Last last) {
        std::vector<char> is_goal(cost.size());
        std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
        for (size_t k = 0; k < goals.size(); ++k) {
            cost[goals[k]] = values ? values[k] : 0.0, is_goal[goals[k]] = 1;
            open.push({cost[goals[k]], goals[k]});
        }
        for (int64_t round = 0; !open.empty(); ++round) {
            poll_signal_at(round);
            const auto [here, node] = open.top();
            open.pop();
            if (here > cost[node]) continue;
            if (last(node)) return node;
            for (int k = first_[node]; k < first_[node + 1]; ++k) {
                const auto [tail, arc, price] = into_[k];
                const double offer = here + price;
                if (offer < cost[tail] && !is_goal[tail])
                    cost[tail] = offer, next[tail] = node, by[tail] = arc, open.push({offer, tail});
            }
        }
        return -1;
    }

   private:
    using Entry = std::pair<double, int>;
    struct Arc {
        int tail, number;
        double cost;
    };
    std::vector<int> first_;
    std::vector<Arc> into_;
};

}  // namespace planner
