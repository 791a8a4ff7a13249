#pragma once
/// How ranks pass messages: the little that block_exchange.hpp needs, implemented with MPI (mpi/mpi_transport.hpp) and, for tests, by
/// threads of one process.

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "libmpm/base/message.hpp"

namespace mpm {

/// Messages by the rank that they go to or come from.
using Messages = std::map<int, Message>;

/// One rank's access to the others. All ranks call the same functions in the same order, from one thread.
class Transport {
 public:
  virtual ~Transport() = default;
  [[nodiscard]] virtual int rank() const = 0;  ///< of this process, from 0
  [[nodiscard]] virtual int size() const = 0;  ///< number of ranks

  /// Messages to ranks that do not know that they get one. @returns those for this rank
  virtual Messages exchange(Messages to) = 0;
  /// Starts to send messages that their receivers expect. Call receive() next.
  virtual void send(Messages to) = 0;
  /// Waits until what was sent is gone, and for one message from each of these ranks.
  virtual Messages receive(std::span<const int> from) = 0;

  /// The messages of all ranks, by rank, on rank 0; nothing elsewhere.
  virtual std::vector<Message> gather(Message mine) = 0;
  /// The message of rank 0, on all.
  virtual void broadcast(Message& message) = 0;
  /// Each number becomes the largest of all ranks.
  virtual void maximum(std::span<double> numbers) = 0;
  /// Each number becomes the sum over all ranks.
  virtual void sum(std::span<std::uint64_t> numbers) = 0;
};

}  // namespace mpm
