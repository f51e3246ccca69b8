"""Boxes packed by py3dbp: what `trunnion pack --boxes` stands beside.

    python pack_py3dbp.py BOXES.txt X,Y,Z

BOXES.txt has a line `w d h [count]` each, as `trunnion pack --boxes` reads them. py3dbp turns boxes in every way and cannot be told not to.
Prints {"runs", "seconds"}: spaces opened one after the other, the largest boxes first, until all are in one.
"""

import json
import sys
import time

from py3dbp import Bin, Item, Packer


def main():
    space = [float(length) for length in sys.argv[2].split(",")]
    boxes = []
    for line in open(sys.argv[1]):
        numbers = [float(word) for word in line.split("#")[0].replace(",", " ").split()]
        if numbers:
            count = int(numbers[3]) if len(numbers) > 3 else 1
            boxes += [numbers[:3]] * count
    began, runs, left = time.process_time(), 0, boxes
    while left:
        packer = Packer()
        packer.add_bin(Bin("run", *space, 1e12))
        for index, box in enumerate(left):
            packer.add_item(Item(str(index), *box, 1))
        packer.pack(bigger_first=True)
        unfitted = {item.name for item in packer.bins[0].unfitted_items}
        if len(unfitted) == len(left):
            sys.exit("a box does not fit")
        left = [box for index, box in enumerate(left) if str(index) in unfitted]
        runs += 1
    print(json.dumps({"runs": runs, "seconds": time.process_time() - began}))


main()
