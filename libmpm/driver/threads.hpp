#pragma once
/// The threads of OpenMP: their number, their start, and how they wait for each other.
///
/// GCC's OpenMP lets a thread that has finished its part of a loop spin for up to 15 ms before it sleeps. On a machine that is busy with
/// other work the spinning thread occupies the core that the awaited thread needs: a small run took 5 to 12 times as long (median) as one
/// that does not spin. With a spin of 100 iterations a run takes the same time as without, on a busy and on an idle machine. The
/// OpenMP runtime reads its settings before main(), so a program has to start itself again to change them.

#include <string>
#include <string_view>

namespace mpm {

/// Sets the number of threads and starts them. The OpenMP runtime ends the process if it cannot start them, so this function first tries
/// whether the system allows them. @param threads 0: as many as OpenMP offers
/// @throws Error, with the remedy, if the system refuses them
void start_threads(int threads);

/// Iterations of the runtime's waiting loop before a thread sleeps (GOMP_SPINCOUNT), some 30 us. A run with 70,000 particles has dozens of
/// waits of a few us in a step. With 100 iterations its threads slept in most of them, and it took 8 % longer (median of five pairs, two
/// virtual cores). Beside two busy programs 100 and 3000 were equally fast; with 300,000 it took up to 4 times as long.
inline constexpr std::string_view short_spin = "3000";

/// Starts the program again with GOMP_SPINCOUNT = short_spin, unless the user has set GOMP_SPINCOUNT or OMP_WAIT_POLICY. Call it first in
/// main(). Returns if there is nothing to do, or if the program cannot be started again; it then runs with the long spin.
/// @param argv the arguments of main()
void use_short_spin(char** argv);

/// Applies most_threads() to the default number of threads, which OMP_NUM_THREADS sets without a bound. Call it in main(), before any loop.
/// @return a warning, if it was larger
[[nodiscard]] std::string limit_threads();

/// The largest accepted number of threads on this machine: four for each hardware thread. More would only wait for each other.
[[nodiscard]] int most_threads();

}  // namespace mpm
