"""The cheapest flow of supports by OR-tools: a witness for `min-cost`, and what its time stands beside.

    python support_ortools.py ARCS.txt

The first line of ARCS.txt is "squares arc-limit node-limit" (0: no limit on nodes); then a line each: "r NODE" (red), "g NODE" (on the
ground), "a FROM TO COST". Prints {"cost", "units", "seconds"}: the least cost of the largest flow, and the CPU time of the solver alone.
"""

import json
import sys
import time

from ortools.graph.python import min_cost_flow


def main():
    lines = open(sys.argv[1])
    squares, arc_limit, node_limit = map(int, next(lines).split())
    red, green, arcs = [], [], []
    for line in lines:
        kind, *numbers = line.split()
        {"r": red, "g": green, "a": arcs}[kind].append(tuple(map(int, numbers)))
    flow = min_cost_flow.SimpleMinCostFlow()
    split = node_limit > 0
    numbers = {}

    def below(node):
        return number(node + squares) if split else number(node)

    def number(node):
        # Nodes are numbered as they come, so that squares without arcs take nothing.
        return numbers.setdefault(node, len(numbers))

    if split:
        for node in sorted({end for start, to, _ in arcs for end in (start, to)} | {r for (r,) in red}):
            flow.add_arc_with_capacity_and_unit_cost(number(node), below(node), node_limit, 0)
    for start, to, cost in arcs:
        flow.add_arc_with_capacity_and_unit_cost(below(start), number(to), arc_limit, cost)
    source, sink = number(-1), number(-2)
    for (node,) in red:
        flow.add_arc_with_capacity_and_unit_cost(source, number(node), 1, 0)
    for (node,) in green:
        flow.add_arc_with_capacity_and_unit_cost(below(node), sink, len(red), 0)
    flow.set_node_supply(source, len(red))
    flow.set_node_supply(sink, -len(red))
    began = time.process_time()
    status = flow.solve_max_flow_with_min_cost()
    seconds = time.process_time() - began
    if status != flow.OPTIMAL:
        sys.exit(f"the solver says {status}")
    print(json.dumps({"cost": flow.optimal_cost(), "units": flow.maximum_flow(), "seconds": seconds}))


main()
