#include "libmpm/mpi/mpi_transport.hpp"

#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

constexpr std::size_t piece = std::size_t{1} << 30;  ///< bytes; MPI counts in int. A message ends with a piece that is shorter
constexpr int tag = 1;                               ///< of messages whose size the receiver does not know

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

int tag_of(MessageKind kind) { return 2 + static_cast<int>(kind); }

/// Messages on their way in one direction.
class Stream {
 public:
  Stream() = default;
  ~Stream() {  // MPI reads or writes the messages until then
    if (!done_ && !requests_.empty()) MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// After those that were sent before have left.
  void send(Messages to, int with_tag) {
    wait();
    messages_ = std::move(to);
    for (auto& [rank, message] : messages_) {
      for_each_piece(message, [&, to_rank = rank](std::byte* bytes, int size, MPI_Request* request) {
        check(MPI_Isend(bytes, size, MPI_BYTE, to_rank, with_tag, MPI_COMM_WORLD, request), "send");
      });
    }
    statuses_.resize(requests_.size());
  }
  void receive(const std::map<int, std::size_t>& from, int with_tag) {
    for (const auto& [rank, size] : from) {
      messages_[rank].resize(size);
      for_each_piece(messages_[rank], [&, from_rank = rank](std::byte* bytes, int count, MPI_Request* request) {
        check(MPI_Irecv(bytes, count, MPI_BYTE, from_rank, with_tag, MPI_COMM_WORLD, request), "receive");
        sizes_.push_back(count);
      });
    }
    statuses_.resize(requests_.size());
  }
  /// Until all have left or arrived. @returns the messages
  Messages wait() {
    if (!done_) check(MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), statuses_.data()), "wait");
    for (std::size_t i = 0; i < sizes_.size(); ++i) {
      int got = 0;
      MPI_Get_count(&statuses_[i], MPI_BYTE, &got);
      if (got != sizes_[i]) throw Error(ExitCode::internal, "internal error: a message between ranks does not have the expected size");
    }
    requests_.clear();
    sizes_.clear();
    done_ = false;
    return std::exchange(messages_, {});
  }
  void progress() noexcept {
    int all = 0;
    if (!done_ && !requests_.empty()) MPI_Testall(static_cast<int>(requests_.size()), requests_.data(), &all, statuses_.data());
    done_ = done_ || all != 0;
  }

 private:
  /// Calls f(first byte, bytes, request) for each piece of a message.
  template <class F>
  void for_each_piece(Message& message, F&& f) {
    for (std::size_t first = 0;; first += piece) {
      const std::size_t size = std::min(piece, message.size() - first);
      requests_.push_back(MPI_REQUEST_NULL);
      f(message.data() + first, static_cast<int>(size), &requests_.back());
      if (size < piece) return;
    }
  }

  Messages messages_;
  std::vector<MPI_Request> requests_;  ///< of the pieces
  std::vector<MPI_Status> statuses_;
  std::vector<int> sizes_;  ///< of pieces to be received
  bool done_ = false;       ///< progress() found that all have left or arrived
};

}  // namespace

struct MpiTransport::Traffic {
  Stream sent;  ///< to receivers that do not know the size
  struct Expected {
    Stream out, in;
  };
  std::map<MessageKind, Expected> expected;
};

MpiTransport::MpiTransport(int& argc, char**& argv) : traffic_(std::make_unique<Traffic>()) {
  if (!launched()) return;
  int provided = 0;
  check(MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided), "start");
  running_ = true;
  check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "rank");
  check(MPI_Comm_size(MPI_COMM_WORLD, &size_), "size");
}

MpiTransport::~MpiTransport() {
  traffic_.reset();
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

void MpiTransport::finish_sending() { traffic_->sent.wait(); }

void MpiTransport::send(Messages to) { traffic_->sent.send(std::move(to), tag); }

Messages MpiTransport::receive(std::span<const int> from) {
  Messages messages;
  for (const int rank : from) messages[rank] = receive_from(rank);
  finish_sending();
  return messages;
}

void MpiTransport::start(MessageKind kind, Messages to, const std::map<int, std::size_t>& from) {
  auto& [out, in] = traffic_->expected[kind];
  in.receive(from, tag_of(kind));  // first, so that what arrives early has a place
  out.send(std::move(to), tag_of(kind));
}

Messages MpiTransport::finish(MessageKind kind) {
  auto& [out, in] = traffic_->expected[kind];
  return in.wait();  // not for `out`: what it sends may leave until start() is called again
}

void MpiTransport::progress() noexcept {
  for (auto& [kind, messages] : traffic_->expected) {
    messages.in.progress();
    messages.out.progress();
  }
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
