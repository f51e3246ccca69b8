// The flows of supports by LEMON: a witness for `push-relabel` and `min-cost`, and what their time stands beside.
//
//     g++ -O2 -o support_lemon support_lemon.cpp && ./support_lemon ARCS.txt [flow|cost]
//
// ARCS.txt is as support_ortools.py has it. Prints {"units", "flow_seconds", "cost", "cost_seconds"}: the largest flow by Preflow, the
// least cost of a flow of so many units by NetworkSimplex, and the CPU time of each solver alone; only one of them where it is named.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <unordered_map>
#include <vector>

#include <lemon/network_simplex.h>
#include <lemon/preflow.h>
#include <lemon/smart_graph.h>

using Graph = lemon::SmartDigraph;

struct Listed {
    long from, to, cost;
};

int main(int count, char **words) {
    if (count < 2) {
        std::fprintf(stderr, "usage: support_lemon ARCS.txt [flow|cost]\n");
        return 2;
    }
    const std::string only = count > 2 ? words[2] : "";
    std::ifstream file(words[1]);
    long squares = 0, arc_limit = 0, node_limit = 0;
    file >> squares >> arc_limit >> node_limit;
    std::vector<long> red, green;
    std::vector<Listed> listed;
    for (char kind; file >> kind;) {
        long a = 0, b = 0, c = 0;
        file >> a;
        if (kind == 'r') {
            red.push_back(a);
        } else if (kind == 'g') {
            green.push_back(a);
        } else {
            file >> b >> c;
            listed.push_back({a, b, c});
        }
    }

    Graph graph;
    Graph::ArcMap<int> capacity(graph), price(graph);
    std::unordered_map<long, Graph::Node> nodes;
    auto node = [&](long number) {
        auto found = nodes.find(number);
        return found != nodes.end() ? found->second : nodes.emplace(number, graph.addNode()).first->second;
    };
    auto add = [&](Graph::Node from, Graph::Node to, long most, long cost) {
        Graph::Arc arc = graph.addArc(from, to);
        capacity[arc] = static_cast<int>(most);
        price[arc] = static_cast<int>(cost);
    };
    // A limited node is two, with the limit on the arc between them.
    std::unordered_map<long, Graph::Node> lower;
    auto below = [&](long number) {
        if (node_limit == 0) {
            return node(number);
        }
        auto found = lower.find(number);
        if (found != lower.end()) {
            return found->second;
        }
        Graph::Node made = graph.addNode();
        lower.emplace(number, made);
        add(node(number), made, node_limit, 0);
        return made;
    };
    for (const Listed &arc : listed) {
        add(below(arc.from), node(arc.to), arc_limit, arc.cost);
    }
    Graph::Node source = graph.addNode(), sink = graph.addNode();
    const long all = static_cast<long>(red.size());
    for (long number : red) {
        add(source, node(number), 1, 0);
    }
    for (long number : green) {
        add(below(number), sink, all, 0);
    }

    auto seconds = [](std::clock_t since) { return static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC; };
    std::ostringstream out;
    std::clock_t began = std::clock();
    lemon::Preflow<Graph> flow(graph, capacity, source, sink);
    flow.runMinCut();
    const int units = flow.flowValue();
    out << "{\"units\": " << units << ", \"flow_seconds\": " << seconds(began);
    if (only != "flow") {
        began = std::clock();
        lemon::NetworkSimplex<Graph, int, long long> simplex(graph);
        simplex.upperMap(capacity).costMap(price).stSupply(source, sink, units);
        if (simplex.run() != lemon::NetworkSimplex<Graph, int, long long>::OPTIMAL) {
            std::fprintf(stderr, "the solver has no optimum\n");
            return 1;
        }
        out << ", \"cost\": " << simplex.totalCost<long long>() << ", \"cost_seconds\": " << seconds(began);
    }
    std::cout << out.str() << "}\n";
    return 0;
}
