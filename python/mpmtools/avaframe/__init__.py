"""An avalanche of AvaFrame's com1DFA at one point of its rasters, as a case of `mpm run` and a site of `mpm design`.

  rasters       ESRI ASCII grids and GeoTIFF
  projection    their coordinate systems: metres, and one for all
  results       the files of a simulation
  flow          depth, speed and direction of the flow over time at the point
  ground        the plane of the ground in the window of the case, and its relief over the plane
  case_files    what is written
"""

from mpmtools.avaframe.case_files import import_avalanche

__all__ = ["import_avalanche"]
