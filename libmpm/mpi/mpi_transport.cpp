#include "libmpm/mpi/mpi_transport.hpp"

#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

constexpr std::size_t piece = std::size_t{1} << 30;  ///< bytes; MPI counts in int. A message ends with a piece that is shorter
constexpr int tag = 1;

void check(int result, const char* what) {
  if (result == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = "";
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw Error(ExitCode::internal, std::string("MPI: ") + what + ": " + text);
}

/// Whether a launcher started this process. Launchers set environment variables (Open MPI, PMIx, PMI of Slurm and MPICH).
bool launched() {
  return std::ranges::any_of(std::initializer_list<const char*>{"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"},
                             [](const char* name) { return std::getenv(name) != nullptr; });
}

}  // namespace

struct MpiTransport::Requests {
  std::vector<MPI_Request> all;
};

MpiTransport::MpiTransport(int& argc, char**& argv) : requests_(std::make_unique<Requests>()) {
  if (!launched()) return;
  int provided = 0;
  check(MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided), "start");
  running_ = true;
  check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "rank");
  check(MPI_Comm_size(MPI_COMM_WORLD, &size_), "size");
}

MpiTransport::~MpiTransport() {
  if (running_) MPI_Finalize();
}

int MpiTransport::threads() const {
  cpu_set_t set;
  CPU_ZERO(&set);
  const int mine = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
  if (!running_) return mine;
  MPI_Comm node = MPI_COMM_NULL;
  check(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node), "ranks of a node");
  // ranks that may use the same cores share them: the node's ranks whose first core is the same
  int first = 0, count = 1;
  while (first < CPU_SETSIZE && !CPU_ISSET(first, &set)) ++first;
  MPI_Comm_size(node, &count);
  std::vector<int> firsts(static_cast<std::size_t>(count));
  check(MPI_Allgather(&first, 1, MPI_INT, firsts.data(), 1, MPI_INT, node), "cores of a node");
  MPI_Comm_free(&node);
  return std::max(1, mine / static_cast<int>(std::ranges::count(firsts, first)));
}

void MpiTransport::abort(int exit_code) {
  if (running_) MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::_Exit(exit_code);
}

void MpiTransport::start_sending(int to, const Message& message) {
  for (std::size_t first = 0;; first += piece) {
    const std::size_t size = std::min(piece, message.size() - first);
    requests_->all.emplace_back();
    check(MPI_Isend(message.data() + first, static_cast<int>(size), MPI_BYTE, to, tag, MPI_COMM_WORLD, &requests_->all.back()), "send");
    if (size < piece) return;
  }
}

Message MpiTransport::receive_from(int from) {
  Message message;
  for (;;) {
    MPI_Message incoming = MPI_MESSAGE_NULL;
    MPI_Status status;
    int size = 0;
    check(MPI_Mprobe(from, tag, MPI_COMM_WORLD, &incoming, &status), "probe");
    MPI_Get_count(&status, MPI_BYTE, &size);
    const std::size_t before = message.size();
    message.resize(before + static_cast<std::size_t>(size));
    check(MPI_Mrecv(message.data() + before, size, MPI_BYTE, &incoming, MPI_STATUS_IGNORE), "receive");
    if (static_cast<std::size_t>(size) < piece) return message;
  }
}

void MpiTransport::finish_sending() {
  check(MPI_Waitall(static_cast<int>(requests_->all.size()), requests_->all.data(), MPI_STATUSES_IGNORE), "wait");
  requests_->all.clear();
  sent_.clear();
}

void MpiTransport::send(Messages to) {
  sent_ = std::move(to);
  for (const auto& [rank, message] : sent_) start_sending(rank, message);
}

Messages MpiTransport::receive(std::span<const int> from) {
  Messages messages;
  for (const int rank : from) messages[rank] = receive_from(rank);
  finish_sending();
  return messages;
}

Messages MpiTransport::exchange(Messages to) {
  std::vector<int> sends(static_cast<std::size_t>(size_), 0), comes(sends);
  for (const auto& [rank, message] : to) sends[static_cast<std::size_t>(rank)] = 1;
  check(MPI_Alltoall(sends.data(), 1, MPI_INT, comes.data(), 1, MPI_INT, MPI_COMM_WORLD), "exchange");
  send(std::move(to));
  std::vector<int> from;
  for (int r = 0; r < size_; ++r) {
    if (comes[static_cast<std::size_t>(r)] != 0) from.push_back(r);
  }
  return receive(from);
}

std::vector<Message> MpiTransport::gather(Message mine) {
  // along a binomial tree, so that the first rank receives log2(size) messages instead of size - 1
  std::vector<Message> stretch;
  stretch.push_back(std::move(mine));
  for (int distance = 1; distance < size_; distance *= 2) {
    if ((rank_ & distance) != 0) {
      Messages out;
      Message& all = out[rank_ - distance];
      for (const Message& message : stretch) {
        put(all, static_cast<std::uint64_t>(message.size()));
        put(all, std::span<const std::byte>(message));
      }
      send(std::move(out));
      finish_sending();
      return {};
    }
    if (rank_ + distance >= size_) continue;
    const Message others = receive_from(rank_ + distance);
    for (MessageReader reader(others); !reader.at_end();) {
      stretch.emplace_back(reader.get<std::uint64_t>());
      reader.get(std::span(stretch.back()));
    }
  }
  return stretch;
}

void MpiTransport::broadcast(Message& message) {
  std::uint64_t size = message.size();
  check(MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD), "broadcast");
  message.resize(size);
  for (std::size_t first = 0; first < message.size(); first += piece) {
    const auto count = static_cast<int>(std::min(piece, message.size() - first));
    check(MPI_Bcast(message.data() + first, count, MPI_BYTE, 0, MPI_COMM_WORLD), "broadcast");
  }
}

void MpiTransport::maximum(std::span<double> numbers) {
  check(MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD), "maximum");
}

void MpiTransport::sum(std::span<std::uint64_t> numbers) {
  check(MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD), "sum");
}

}  // namespace mpm
