"""200 models through a real local Ray: the results of one process, with a worker killed in the midst too.

    python check_ray.py FOLDER

Prints the figures, or SKIPPED with the reason where Ray is not there. Not found by ``unittest discover``, since Ray is no part of the package.
"""

import json
import subprocess
import sys
import warnings
from pathlib import Path

try:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import ray
except ImportError as error:
    print(f"SKIPPED: Ray ({error})")
    sys.exit(0)

example = Path(__file__).resolve().parents[1] / "examples" / "ray_batch.py"
run = subprocess.run(
    [sys.executable, "-W", "ignore", str(example), sys.argv[1], "--check"], stdout=subprocess.PIPE, text=True, timeout=480
)
figures = json.loads(run.stdout.splitlines()[-1])
wanted = {
    "models": figures["models"] == 200,
    "broken ones failed, each with its sentence": figures["failed"] == 4,
    "one worker": figures["one_worker_same"] and figures["one_worker_pids"] == 1,
    "two workers": figures["two_workers_same"] and figures["two_workers_pids"] == 2,
    "nothing done twice": figures["one_worker_again"] == figures["two_workers_again"] == 0,
    "a worker killed": figures["one_of_two_killed_same"],
    "another worker took its place": figures["one_of_two_killed_pids"] == 3,
    "exit code": run.returncode == 0 and figures["same"],
}
print(f"ray {ray.__version__}: {figures['models']} models, {figures['alone_s']} s in one process, {figures['one_worker_s']} s with one worker,", end=" ")
print(f"{figures['two_workers_s']} s with two, {figures['one_of_two_killed_s']} s with one of two killed ({figures['one_of_two_killed_again']} done again)")
missing = [name for name, held in wanted.items() if not held]
sys.exit(f"FAILED: {', '.join(missing)}: {figures}" if missing else 0)
