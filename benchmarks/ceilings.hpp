#pragma once
/// The two ceilings of this machine, measured in the run that uses them: memory bandwidth by the STREAM triad (McCalpin 1995) and
/// arithmetic by a loop of independent fused multiply-adds.

namespace mpm::benchmarks {

struct Ceilings {
  double bytes_per_second;  ///< triad a = b + s c: 24 bytes an element, as STREAM counts (the read of a before its write is not counted)
  double flops_per_second;  ///< a fused multiply-add is two
};

/// Best of several trials (a ceiling is what can be reached, so the least disturbed trial counts). Measured once a thread count.
const Ceilings& ceilings(int threads);

}  // namespace mpm::benchmarks
