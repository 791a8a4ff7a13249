#pragma once
/// Messages between processes by MPI.

#include <cstddef>
#include <memory>

#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// Starts and ends MPI in one process; create one at the start of main(). Ranks are those of MPI_COMM_WORLD.
class MpiTransport : public Transport {
 public:
  /// Starts MPI if a launcher started this process; otherwise this is the only rank, without MPI.
  /// @throws Error if MPI cannot be started
  MpiTransport(int& argc, char**& argv);
  /// Ends MPI.
  ~MpiTransport() override;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }
  /// Default number of threads of a rank: the cores that it may use, divided by the number of ranks on them.
  [[nodiscard]] int threads() const;
  /// Ends all ranks at once, after an error of this one.
  [[noreturn]] void abort(int exit_code);

  Messages exchange(Messages to) override;
  void send(Messages to) override;
  Messages receive(std::span<const int> from) override;
  void start(MessageKind kind, Messages to, const std::map<int, std::size_t>& from) override;
  Messages finish(MessageKind kind) override;
  void progress() noexcept override;
  std::vector<Message> gather(Message mine) override;
  void broadcast(Message& message) override;
  void maximum(std::span<double> numbers) override;
  void sum(std::span<std::uint64_t> numbers) override;

 private:
  struct Traffic;
  [[nodiscard]] Message receive_from(int from);
  void finish_sending();

  bool running_ = false;
  int rank_ = 0, size_ = 1;
  std::unique_ptr<Traffic> traffic_;  ///< messages on their way
};

}  // namespace mpm
