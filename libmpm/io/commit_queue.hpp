#pragma once
/// Gives finished files their names while the caller goes on: a file waits for the disk, not for a processor.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "libmpm/base/first_error.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm {

/// Commits files in the order in which they are given, on a thread of its own. Their content is written before; so only the system's
/// buffers hold it, and the memory of the process does not grow.
///
/// After the first error the files that follow are removed, as if the program had ended there; the next call throws the error.
class CommitQueue {
 public:
  CommitQueue() = default;
  /// Waits for the files that were given, but throws nothing.
  ~CommitQueue();
  CommitQueue(const CommitQueue&) = delete;
  CommitQueue& operator=(const CommitQueue&) = delete;

  /// The next file, complete. Waits while `most` files are open. Where no thread can be started, it is committed at once.
  /// @param file  null: nothing happens. @throws IoError of this file or an earlier one
  void add(std::unique_ptr<AtomicFile> file);
  /// All files have their names. @throws IoError
  void wait();

  static constexpr std::size_t most = 4;  ///< open files; each is a descriptor and a share of the system's buffers

 private:
  void work();
  void start();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<AtomicFile>> files_;  ///< the first is being committed
  FirstError error_;
  bool ending_ = false;
  std::thread thread_;  ///< started with the first file
};

}  // namespace mpm
