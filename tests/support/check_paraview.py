"""Opens an XDMF file in ParaView (pvpython) and prints what is there, as JSON: one entry a time step.

ParaView's Xdmf3 reader gives an empty data set as long as no time is asked for, hence UpdatePipeline(t).
"""
import json
import sys

from paraview import servermanager
from paraview.simple import OpenDataFile

reader = OpenDataFile(sys.argv[1])
steps = []
for time in list(reader.TimestepValues):
    reader.UpdatePipeline(time)
    data = servermanager.Fetch(reader)
    arrays = {}
    for i in range(data.GetPointData().GetNumberOfArrays()):
        array = data.GetPointData().GetArray(i)
        last = array.GetTuple(array.GetNumberOfTuples() - 1)
        arrays[array.GetName()] = list(last)
    steps.append({"time": time, "points": data.GetNumberOfPoints(), "cells": data.GetNumberOfCells(),
                  "last_point": list(data.GetPoint(data.GetNumberOfPoints() - 1)), "last_values": arrays})
with open(sys.argv[2], "w") as file:
    json.dump(steps, file)
