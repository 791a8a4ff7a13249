"""Reads a frame with h5py, as a user would, and writes what is there as JSON."""
import json
import sys

import h5py

with h5py.File(sys.argv[1]) as file:
    result = {"attributes": {name: value if isinstance(value, str) else value.item() for name, value in file.attrs.items()},
              "shapes": {name: file[name].shape for name in file},
              "types": {name: str(file[name].dtype) for name in file},
              "last_position": file["position_m"][-1].tolist()}
with open(sys.argv[2], "w") as out:
    json.dump(result, out)
