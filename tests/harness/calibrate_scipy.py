"""The least squares of `trunnion profile calibrate` with other code: scipy's Levenberg-Marquardt and numeric derivatives.

Reads a problem as JSON on stdin (touches by a flat tip of the table, `of` -1, and of marks on it), writes what it found: `by` (pivot x y z,
offset across and z, tilt zero, yaw, pitch, leans of the rotation axis, the surface's fall; mm and radians; its sag at 100 mm, mm), standard errors, the scatter, Student's t for 95 of 100.
"""

import json
import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import t as student

problem = json.load(sys.stdin)
ALONG, ACROSS = (np.eye(3)[0], np.eye(3)[1]) if problem["about"] == "X" else (np.eye(3)[1], np.eye(3)[0])
UP = np.eye(3)[2]
PIVOT, OFFSET = np.array(problem["pivot"]), np.array(problem["offset"])


def about(axis, angle):
    return Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()


def residuals(state):
    pivot = PIVOT + state[:3]
    offset = OFFSET + ACROSS * state[3] + UP * state[4]
    zero, yaw, pitch, lean_x, lean_y, fall, sag = state[5:12]
    axis = ALONG + ACROSS * yaw + UP * pitch
    rotation = np.array([lean_x, lean_y, 1.0])
    out = []
    for touch in problem["touches"]:
        a, c = np.radians(touch["words"])
        tilt = about(axis, a + zero)
        turn = tilt @ about(np.cross(UP, ALONG), fall) @ about(rotation, c)
        middle = pivot + tilt @ offset
        normal = turn @ UP
        # The rim of a level disc reaches its radius times the sine of the slope below its middle.
        gap = problem["radius"] * np.sqrt(max(0.0, 1.0 - normal[2] ** 2)) + problem["paper"]
        at = np.array(touch["at"])
        if touch["of"] < 0:
            met = turn.T @ (at - middle)
            out.append(normal @ (at - middle) - gap + sag * (met[0] ** 2 + met[1] ** 2) / 1e4)
        else:
            x, y = state[12 + 2 * touch["of"] : 14 + 2 * touch["of"]]
            mark = middle + turn @ np.array([x, y, 0.0])
            out.extend(at - mark - UP * (gap - sag * (x * x + y * y) / 1e4) / normal[2])
    return np.array(out)


start = np.concatenate([np.zeros(12), np.ravel(problem["marks"])])
found = least_squares(residuals, start, jac="3-point", method="lm", x_scale=np.r_[np.ones(5), np.full(6, 0.01), np.ones(len(start) - 11)], xtol=1e-15, ftol=1e-15, gtol=1e-15)
freedom = len(found.fun) - len(start)
variance = found.fun @ found.fun / freedom
errors = np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)) * variance)
json.dump(
    {
        "by": list(found.x[:12]),
        "errors": list(errors[:12]),
        "rms": float(np.sqrt(variance)),
        "student": float(student.ppf(0.975, freedom)),
    },
    sys.stdout,
)
