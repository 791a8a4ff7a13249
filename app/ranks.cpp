#include "ranks.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <new>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/threads.hpp"
#include "libmpm/driver/worker.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#ifdef MPM_MPI
#include "libmpm/mpi/mpi_transport.hpp"
#endif
#include "run_control.hpp"

namespace mpm::app {

namespace {

Session* the_session = nullptr;

int number_in_environment(const char* name) {
  const char* const text = std::getenv(name);
  return text == nullptr ? 0 : std::atoi(text);
}

}  // namespace

Session& session() { return *the_session; }

void require_mpi(int ranks) {
  if (ranks == 1 || Session::can_be_several()) return;
  throw ConfigError(
      fmt::format("{} ranks: this program was built without MPI; build it with `./run build mpi` and take build/mpi/bin/mpm", ranks));
}

#ifdef MPM_MPI

struct Session::Group {
  MpiTransport transport;
  std::optional<BlockExchange> exchange;
  bool closed = false;
  Group(int& argc, char**& argv) : transport(argc, argv) {}

  /// Starts the threads of this rank. @param wanted  their number; 0: the default
  void start(int wanted) const { start_threads(wanted == 0 && std::getenv("OMP_NUM_THREADS") == nullptr ? transport.threads() : wanted); }

  /// On the first rank: ends the others, which wait for another run.
  void end_run() {
    exchange->instruct(Task::end, State(1.0), 0.0);
    exchange.reset();
  }

  [[noreturn]] void fail(int code, const std::string& what) {
    say(fmt::format("rank {}: {}\n", transport.rank(), what));
    transport.abort(code);
  }
};

Session::Session(int& argc, char**& argv) : group_(std::make_unique<Group>(argc, argv)) {
  if (group_->transport.size() == 1) group_.reset();
  the_session = this;
}

bool Session::can_be_several() { return true; }
bool Session::first() const { return group_ == nullptr || group_->transport.rank() == 0; }
int Session::size() const { return group_ == nullptr ? 1 : group_->transport.size(); }

RunResult Session::run(const Case& c, RunOptions options) {
  if (group_ == nullptr) return run_case(c, options);
  const int forced = number_in_environment("MPM_REBALANCE_STEPS");  // for tests
  Message message;
  put(message, options.threads);
  put(message, forced);
  put(message, std::span<const char>(write_case(c)));
  group_->transport.broadcast(message);
  options.ranks = &group_->exchange.emplace(group_->transport, Balancing{.forced = forced});
  group_->start(options.threads);
  options.threads = omp_get_max_threads();
  RunResult result = run_case(c, options);
  group_->end_run();
  return result;
}

int Session::serve() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2}) std::signal(number, SIG_IGN);  // the first rank decides
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond the limit is then an error of write(), with its message
  try {
    for (;;) {
      Message message;
      group_->transport.broadcast(message);
      if (message.empty()) return 0;
      MessageReader reader(message);
      const int threads = reader.get<int>(), forced = reader.get<int>();
      const Case c = parse_case(reader.text(), "the case of the first rank");
      group_->start(threads);
      work_on(c, group_->exchange.emplace(group_->transport, Balancing{.forced = forced}));
    }
  } catch (const Error& error) {
    group_->fail(static_cast<int>(error.code()), error.what());
  } catch (const std::bad_alloc&) {
    group_->fail(static_cast<int>(ExitCode::internal), "out of memory; take more ranks on more machines, or a larger numerics.cell_size_m");
  } catch (const std::exception& error) {
    group_->fail(static_cast<int>(ExitCode::internal), error.what());
  }
}

void Session::close(int exit_code) {
  if (group_ == nullptr || group_->closed || !first()) return;
  group_->closed = true;
  if (group_->exchange && group_->exchange->busy()) group_->transport.abort(exit_code);
  if (group_->exchange) group_->end_run();
  Message nothing;
  group_->transport.broadcast(nothing);
}

#else

struct Session::Group {};

Session::Session(int&, char**&) {
  the_session = this;
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (number_in_environment(name) > 1) {
      throw ConfigError(
          fmt::format("{} processes were started together, but this program was built without MPI; build it with `./run build "
                      "mpi` and start build/mpi/bin/mpm, or start one process",
                      number_in_environment(name)));
    }
  }
}

bool Session::can_be_several() { return false; }
bool Session::first() const { return true; }
int Session::size() const { return 1; }
// NOLINTNEXTLINE(performance-unnecessary-value-param): with MPI the options are changed
RunResult Session::run(const Case& c, RunOptions options) { return run_case(c, options); }
int Session::serve() { return 0; }
void Session::close(int) {}

#endif

Session::~Session() { the_session = nullptr; }

}  // namespace mpm::app
