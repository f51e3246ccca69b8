"""Boxes packed by OR-tools' CP-SAT, one thread: a witness for `trunnion::pack`, and what `trunnion pack --boxes` stands beside.

    python pack_ortools.py BOXES.json SECONDS

BOXES.json is {"space": [x, y, z], "boxes": [[w, d, h, value], ..], "goal": "runs" | "filling" | "height", "most_runs": n}: whole numbers, no
turns, no gap; `most_runs` is of the first goal, and the third looks at no height of the space and no value. Prints {"best", "bound", "proved",
"seconds"}: the number of runs, the value of one, or the height of one that holds all.
"""

import json
import sys
import time

from ortools.sat.python import cp_model


def main():
    asked = json.load(open(sys.argv[1]))
    space, boxes, goal = asked["space"], asked["boxes"], asked["goal"]
    filling, low = goal == "filling", goal == "height"
    runs = asked["most_runs"] if goal == "runs" else 1
    if low:
        space = [*space[:2], sum(box[2] for box in boxes)]
    model = cp_model.CpModel()
    used = [model.NewBoolVar("") if filling else 1 for _ in boxes]
    run = [model.NewIntVar(0, runs - 1, "") for _ in boxes]
    at = [[model.NewIntVar(0, space[k] - box[k], "") for k in range(3)] for box in boxes]
    for i, a in enumerate(boxes):
        for j, b in enumerate(boxes[:i]):
            apart = [model.NewBoolVar("") for _ in range(6 if runs == 1 else 8)]
            for k in range(3):
                model.Add(at[i][k] + a[k] <= at[j][k]).OnlyEnforceIf(apart[2 * k])
                model.Add(at[j][k] + b[k] <= at[i][k]).OnlyEnforceIf(apart[2 * k + 1])
            if runs > 1:
                model.Add(run[i] < run[j]).OnlyEnforceIf(apart[6])
                model.Add(run[i] > run[j]).OnlyEnforceIf(apart[7])
            if filling:
                apart += [used[i].Not(), used[j].Not()]
            model.AddBoolOr(apart)
    if filling:
        model.Maximize(sum(box[3] * use for box, use in zip(boxes, used)))
    elif low:
        top = model.NewIntVar(0, space[2], "")
        for box, place in zip(boxes, at):
            model.Add(place[2] + box[2] <= top)
        # No run is lower than its volume needs.
        model.Add(top * space[0] * space[1] >= sum(box[0] * box[1] * box[2] for box in boxes))
        model.Minimize(top)
    else:
        most = model.NewIntVar(1, runs, "")
        for number in run:
            model.Add(number < most)
        model.Minimize(most)
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = float(sys.argv[2])
    solver.parameters.num_workers = 1
    began = time.process_time()
    status = solver.Solve(model)
    seconds = time.process_time() - began
    proved = status == cp_model.OPTIMAL
    found = status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    best = round(solver.ObjectiveValue()) if found else None
    print(json.dumps({"best": best, "bound": solver.BestObjectiveBound(), "proved": proved, "seconds": seconds}))


main()
