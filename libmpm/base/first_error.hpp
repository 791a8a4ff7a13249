#pragma once
/// Steps that must go on after an exception: for other processes that wait, or across a library written in C.

#include <exception>
#include <utility>

namespace mpm {

/// Keeps the first exception, and does nothing more after it.
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
  /// @throws the exception that was kept, if there is one
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::exception_ptr error_;
};

}  // namespace mpm
