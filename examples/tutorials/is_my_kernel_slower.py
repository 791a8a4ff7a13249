#!/usr/bin/python3
# %% [markdown]
# # Is my kernel slower?
#
# You changed a kernel and want to know whether it became slower. Timing one version after the other is not reliable: other programs,
# the clock of the processor and the position of the data in memory change the time by tens of per cent.
#
# `mpmtools.paired_times` runs two programs in turn, a few milliseconds each, so that the same disturbances act on both. Each pair
# of runs gives a ratio. The programs are started several times, because the position of the data in memory differs between starts.

# %%
import sys

import numpy as np

from mpmtools import paired_times

PARTICLES, NODES = 4096, 512

# %% [markdown]
# ## A kernel in three versions
#
# The kernel adds the masses of particles to grid nodes. The first version calls `np.add.at`, the second `np.bincount`. The third
# is the second with an eighth more work: a slowdown that the comparison should find.
#
# A program that can be timed reads a number of passes and writes the time of one pass in nanoseconds. `serve` turns a function into
# such a program.

# %%
random = np.random.default_rng(1)
node, mass = random.integers(NODES, size=PARTICLES), random.random(PARTICLES)
more = PARTICLES + PARTICLES // 8
longer_node, longer_mass = np.resize(node, more), np.resize(mass, more)


def with_add_at():
    grid = np.zeros(NODES)
    np.add.at(grid, node, mass)
    return grid


def with_bincount():
    return np.bincount(node, mass, NODES)


def with_bincount_and_more():
    return np.bincount(longer_node, longer_mass, NODES)


KERNELS = {"add_at": with_add_at, "bincount": with_bincount, "bincount_and_more": with_bincount_and_more}
if sys.argv[1:2] == ["--serve"]:
    paired_times.serve(KERNELS[sys.argv[2]])
    sys.exit()

# %% [markdown]
# The first two must compute the same result; otherwise the comparison is meaningless.

# %%
assert np.allclose(with_add_at(), with_bincount())


# %% [markdown]
# ## Compare
#
# The verdict is "slower" or "faster" only if the 99 % interval of the ratio excludes 1 and the ratio differs from 1 by more than 2 %.
# The position of the data in memory alone can change the ratio by 2 %.


# %%
def compare(baseline, current, launches=4, pairs=30):
    commands = [[sys.executable, __file__, "--serve", kernel] for kernel in (baseline, current)]
    result = paired_times.compare(paired_times.measure(*commands, launches=launches, pairs=pairs))
    print(f"{baseline} -> {current}: {result}")
    return result


compare("add_at", "bincount")
compare("bincount", "bincount")  # nothing has changed
compare("bincount", "bincount_and_more")

# %% [markdown]
# ## The kernels of libmpm
#
# `bench_paired KERNEL PARTICLES` is such a program for the kernels of libmpm. `./run bench` builds this source tree and a
# baseline, compares all kernels in this way, and also counts instructions, which have no noise:
#
#     ./run bench --baseline HEAD~1 --kernel particle_to_grid
#
# Give this script the paths of two `bench_paired` and a kernel to compare them directly.

# %%
if len(sys.argv) == 4:
    baseline, current, kernel = sys.argv[1:]
    commands = [[program, kernel, "4096"] for program in (baseline, current)]
    print(f"{kernel}: {paired_times.compare(paired_times.measure(*commands, launches=4, pairs=30, work=4096))}")
