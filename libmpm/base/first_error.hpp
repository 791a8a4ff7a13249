#pragma once
/// Keeps an exception while work continues: because other processes wait, or a library written in C is on the call stack.

#include <exception>
#include <utility>

namespace mpm {

/// Keeps the first exception and skips all calls after it.
class FirstError {
 public:
  /// Calls f unless an earlier call has thrown.
  template <class F>
  void attempt(F&& f) {
    if (error_) return;
    try {
      std::forward<F>(f)();
    } catch (...) {
      error_ = std::current_exception();
    }
  }
  /// Rethrows the exception, if there is one.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::exception_ptr error_;
};

}  // namespace mpm
