"""The page of `mpm design`: loads of an avalanche on a mast, from an ensemble of runs.

  ensemble      the folder: plan and runs
  loads         what is taken from one run: heights, forces, moments, profiles
  oscillator    response of an oscillator, shock response spectrum
  vibration     modes of a cantilever with taper and top mass, and the part of the load that they feel
  scaling       loads of another avalanche from the computed ones: ranges and scenarios
  uncertainty   grid convergence index, and how uncertainties add
  factors       elements that protrude, other cross-sections and fronts, from the study's runs
  comparison    the guideline and the paper's equations for the same site
  figures, page drawing and writing
"""
