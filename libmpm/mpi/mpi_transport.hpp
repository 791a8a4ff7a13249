#pragma once
/// Messages between processes by MPI.

#include <cstddef>
#include <memory>

#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// MPI from its start to its end, in one process; create one, first in main(). Ranks are those of MPI_COMM_WORLD.
class MpiTransport : public Transport {
 public:
  /// Starts MPI, unless the environment shows that nobody launched this program as one of several: it is then one rank without MPI.
  /// @throws Error if MPI cannot be started
  MpiTransport(int& argc, char**& argv);
  /// Ends MPI.
  ~MpiTransport() override;
  MpiTransport(const MpiTransport&) = delete;
  MpiTransport& operator=(const MpiTransport&) = delete;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }
  /// Threads for each rank where nobody says how many: the cores that it may use, divided among the ranks that share them.
  [[nodiscard]] int threads() const;
  /// Ends all ranks at once, by an error of this one.
  [[noreturn]] void abort(int exit_code);

  Messages exchange(Messages to) override;
  void send(Messages to) override;
  Messages receive(std::span<const int> from) override;
  std::vector<Message> gather(Message mine) override;
  void broadcast(Message& message) override;
  void maximum(std::span<double> numbers) override;
  void sum(std::span<std::uint64_t> numbers) override;

 private:
  struct Requests;
  void start_sending(int to, const Message& message);
  [[nodiscard]] Message receive_from(int from);
  void finish_sending();

  bool running_ = false;
  int rank_ = 0, size_ = 1;
  Messages sent_;  ///< kept until they are gone
  std::unique_ptr<Requests> requests_;
};

}  // namespace mpm
