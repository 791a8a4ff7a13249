#include "libmpm/io/commit_queue.hpp"

#include <system_error>
#include <utility>

namespace mpm {

CommitQueue::~CommitQueue() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void CommitQueue::start() {
  try {
    thread_ = std::thread([this] { work(); });
  } catch (const std::system_error&) {  // a limit of threads or of memory
  }
}

void CommitQueue::add(std::unique_ptr<AtomicFile> file) {
  if (!file) return;
  if (!thread_.joinable()) start();
  if (!thread_.joinable()) return file->commit();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return files_.size() < most; });
  error_.rethrow();
  files_.push_back(std::move(file));
  changed_.notify_all();
}

void CommitQueue::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return files_.empty(); });
  error_.rethrow();
}

void CommitQueue::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !files_.empty(); });
    if (files_.empty()) return;
    AtomicFile& file = *files_.front();
    FirstError error = error_;
    lock.unlock();
    error.attempt([&] { file.commit(); });
    lock.lock();
    error_ = error;
    files_.pop_front();
    changed_.notify_all();
  }
}

}  // namespace mpm
