"""The least height of boxes as drawn by OR-tools' CP-SAT: what `trunnion pack --boxes --goal height --turn none` stands beside.

    python pack_ortools.py BOXES.txt X,Y SECONDS

BOXES.txt has a line `w d h [count]` each, as `trunnion pack --boxes` reads them; lengths are whole millimetres. One thread. Of every two boxes
one lies beside, behind or above the other. Prints {"height_mm", "height_lower_bound_mm", "proved", "seconds"}.
"""

import json
import sys

from ortools.sat.python import cp_model


def main():
    base = [int(length) for length in sys.argv[2].split(",")]
    boxes = []
    for line in open(sys.argv[1]):
        numbers = [int(word) for word in line.split("#")[0].replace(",", " ").split()]
        if numbers:
            boxes += [numbers[:3]] * (numbers[3] if len(numbers) > 3 else 1)
    most = sum(box[2] for box in boxes)
    model = cp_model.CpModel()
    at = [[model.new_int_var(0, [*base, most][k] - box[k], "") for k in range(3)] for box in boxes]
    top = model.new_int_var(0, most, "top")
    for box, place in zip(boxes, at):
        model.add(place[2] + box[2] <= top)
    for i in range(len(boxes)):
        for j in range(i):
            ways = []
            for a, b in ((i, j), (j, i)):
                for k in range(3):
                    way = model.new_bool_var("")
                    model.add(at[a][k] + boxes[a][k] <= at[b][k]).only_enforce_if(way)
                    ways.append(way)
            model.add_bool_or(ways)
    # No run is lower than the volume needs.
    volume = sum(box[0] * box[1] * box[2] for box in boxes)
    model.add(top * base[0] * base[1] >= volume)
    model.minimize(top)
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = float(sys.argv[3])
    solver.parameters.num_workers = 1
    status = solver.solve(model)
    found = status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    print(json.dumps({
        "height_mm": solver.value(top) if found else None,
        "height_lower_bound_mm": solver.best_objective_bound,
        "proved": status == cp_model.OPTIMAL,
        "seconds": solver.wall_time,
    }))


main()
