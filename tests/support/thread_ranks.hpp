#pragma once
/// Ranks as threads of one process, for tests without MPI.

#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "libmpm/parallel/transport.hpp"

namespace mpm::testing {

/// Common data of the ranks. A rank that fails wakes the others, which then fail, too.
class ThreadNetwork {
 public:
  explicit ThreadNetwork(int size) : size_(size) {}
  [[nodiscard]] int size() const { return size_; }
  /// @param kind  messages of one kind keep their order. @{
  void put(int from, int to, Message message, int kind = 0) {
    const std::lock_guard lock(mutex_);
    mail_[{from, to, kind}].push_back(std::move(message));
    changed_.notify_all();
  }
  Message take(int from, int to, int kind = 0) {
    std::unique_lock lock(mutex_);
    auto& mail = mail_[{from, to, kind}];
    changed_.wait(lock, [&] { return broken_ || !mail.empty(); });
    if (mail.empty()) throw std::runtime_error("another rank failed");
    Message message = std::move(mail.front());
    mail.pop_front();
    return message;
  }
  /// @}
  void break_off() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    changed_.notify_all();
  }

 private:
  int size_;
  bool broken_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::tuple<int, int, int>, std::deque<Message>> mail_;  ///< by sender, receiver and kind
};

/// Transport of one rank.
class ThreadTransport : public Transport {
 public:
  ThreadTransport(ThreadNetwork& network, int rank) : network_(network), rank_(rank) {}
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return network_.size(); }

  Messages exchange(Messages to) override {
    Messages got;
    for (int r = 0; r < size(); ++r) network_.put(rank_, r, std::vector<std::byte>(to.contains(r) ? 1 : 0));
    send(std::move(to));
    for (int r = 0; r < size(); ++r) {
      if (!network_.take(r, rank_).empty()) got[r] = network_.take(r, rank_);
    }
    return got;
  }
  void send(Messages to) override {
    for (auto& [rank, message] : to) network_.put(rank_, rank, std::move(message));
  }
  Messages receive(std::span<const int> from) override {
    Messages got;
    for (const int rank : from) got[rank] = network_.take(rank, rank_);
    return got;
  }
  void start(MessageKind kind, Messages to, const std::map<int, std::size_t>& from) override {
    for (auto& [rank, message] : to) network_.put(rank_, rank, std::move(message), 1 + static_cast<int>(kind));
    expected_[kind] = from;
  }
  Messages finish(MessageKind kind) override {
    Messages got;
    for (const auto& [rank, size] : expected_[kind]) got[rank] = network_.take(rank, rank_, 1 + static_cast<int>(kind));
    return got;
  }
  void progress() noexcept override {}
  std::vector<Message> gather(Message mine) override {
    std::vector<Message> all;
    network_.put(rank_, 0, std::move(mine));
    for (int r = 0; rank_ == 0 && r < size(); ++r) all.push_back(network_.take(r, 0));
    return all;
  }
  void broadcast(Message& message) override {
    for (int r = 1; rank_ == 0 && r < size(); ++r) network_.put(0, r, message);
    if (rank_ != 0) message = network_.take(0, rank_);
  }
  void maximum(std::span<double> numbers) override {
    combine(numbers, [](double a, double b) { return std::max(a, b); });
  }
  void sum(std::span<std::uint64_t> numbers) override { combine(numbers, std::plus<>()); }

 private:
  template <class T, class F>
  void combine(std::span<T> numbers, F&& f) {
    const auto* bytes = reinterpret_cast<const std::byte*>(numbers.data());
    Message result(bytes, bytes + numbers.size_bytes());
    const auto all = gather(result);
    for (std::size_t r = 1; r < all.size(); ++r) {
      for (std::size_t i = 0; i < numbers.size(); ++i)
        reinterpret_cast<T*>(result.data())[i] =
            f(reinterpret_cast<const T*>(result.data())[i], reinterpret_cast<const T*>(all[r].data())[i]);
    }
    broadcast(result);
    std::copy_n(reinterpret_cast<const T*>(result.data()), numbers.size(), numbers.data());
  }

  ThreadNetwork& network_;
  int rank_;
  std::map<MessageKind, std::map<int, std::size_t>> expected_;
};

/// Runs f(transport) for each of several ranks, rank 0 in this thread. @throws the exception of rank 0, or else of another rank
template <class F>
void on_ranks(int size, F&& f) {
  ThreadNetwork network(size);
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(size));
  const auto run = [&](int rank) {
    try {
      ThreadTransport transport(network, rank);
      f(transport);
    } catch (...) {
      errors[static_cast<std::size_t>(rank)] = std::current_exception();
      network.break_off();
    }
  };
  std::vector<std::jthread> others;
  for (int r = 1; r < size; ++r) others.emplace_back(run, r);
  run(0);
  others.clear();
  for (const auto& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace mpm::testing
