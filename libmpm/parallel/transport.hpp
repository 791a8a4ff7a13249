#pragma once
/// The message passing that block_exchange.hpp needs. Implemented with MPI (mpi/mpi_transport.hpp) and, for tests, with threads of one
/// process.

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "libmpm/base/message.hpp"

namespace mpm {

/// Messages by the rank that they go to or come from.
using Messages = std::map<int, Message>;

/// Kinds of messages of known size. Those of several kinds may travel at the same time.
enum class MessageKind : std::uint8_t {
  parts,  ///< contributions of particles to nodes
  nodes,  ///< values of nodes
};

/// One rank's access to the others. All ranks call the same functions in the same order, from one thread.
class Transport {
 public:
  virtual ~Transport() = default;
  [[nodiscard]] virtual int rank() const = 0;  ///< of this process, from 0
  [[nodiscard]] virtual int size() const = 0;  ///< number of ranks

  /// Sends messages to ranks that do not expect one. @returns the messages for this rank
  virtual Messages exchange(Messages to) = 0;
  /// Starts to send messages that their receivers expect, but whose size they do not know. Call receive() next.
  virtual void send(Messages to) = 0;
  /// Waits until the messages of send() have left, and for one message from each of these ranks.
  virtual Messages receive(std::span<const int> from) = 0;

  /// Starts to send messages of a kind, and to receive those of other ranks. finish() with this kind follows.
  /// @param from  bytes of the message of each rank that sends one
  virtual void start(MessageKind kind, Messages to, const std::map<int, std::size_t>& from) = 0;
  /// Waits for the messages to this rank that start() expects. @returns them
  virtual Messages finish(MessageKind kind) = 0;
  /// Helps messages on their way, without waiting. May be called inside a parallel region, by the thread that calls the other functions.
  virtual void progress() noexcept = 0;

  /// Collects one message of each rank on rank 0. @returns there: by rank; elsewhere: nothing
  virtual std::vector<Message> gather(Message mine) = 0;
  /// Sends the message of rank 0 to all.
  virtual void broadcast(Message& message) = 0;
  /// Replaces each number by its maximum over all ranks.
  virtual void maximum(std::span<double> numbers) = 0;
  /// Replaces each number by its sum over all ranks.
  virtual void sum(std::span<std::uint64_t> numbers) = 0;
};

}  // namespace mpm
