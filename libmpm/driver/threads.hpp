#pragma once
/// The threads of OpenMP: how many a program may have, starting them, and how they wait for each other.
///
/// GCC's OpenMP lets a thread that has finished its part of a loop spin for up to 15 ms before it sleeps. On a machine that is busy with
/// other work the spinning thread occupies the core that the awaited thread needs: a small run took 5 to 12 times as long (median) as one
/// that does not spin. A spin of 100 iterations takes the time of one that does not spin, on a busy machine as on a quiet one. The
/// OpenMP runtime reads its settings before main(), so a program has to start itself again to change them.

#include <string_view>

namespace mpm {

/// Sets the number of threads and makes them. The runtime of OpenMP ends the process, without a way to intervene, when it cannot make
/// them: so they are tried first. @param threads 0: as many as OpenMP offers
/// @throws Error, naming what to do, if the system refuses them
void start_threads(int threads);

/// Iterations of the runtime's waiting loop before a thread sleeps (GOMP_SPINCOUNT).
inline constexpr std::string_view short_spin = "100";

/// Starts the program again with GOMP_SPINCOUNT = short_spin, unless the user has set GOMP_SPINCOUNT or OMP_WAIT_POLICY. Call it first in
/// main(). Returns where there is nothing to do, and where the program cannot be started again: it then runs with the long spin.
/// @param argv the arguments of main()
void use_short_spin(char** argv);

/// The largest number of threads that makes sense on this machine: four for each of the processor's own. More of them only wait for each
/// other.
[[nodiscard]] int most_threads();

}  // namespace mpm
