"""Pages for those who develop libmpm: benchmarks, recordings of the validation suite, solvers side by side. Not a part of mpmtools."""
