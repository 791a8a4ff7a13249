#pragma once
/// Conversion of values to bytes and back, for messages between processes of one program.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm {

/// The bytes of a message.
using Message = std::vector<std::byte>;

/// Appends values to a message.
template <class T>
void put(Message& message, std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t before = message.size();
  message.resize(before + values.size_bytes());
  if (!values.empty()) std::memcpy(message.data() + before, values.data(), values.size_bytes());
}
/// Appends one value to a message.
template <class T>
void put(Message& message, const T& value) {
  put(message, std::span<const T>(&value, 1));
}

/// Appends a text with its length, for MessageReader::get_text.
inline void put_text(Message& message, std::string_view text) {
  put(message, static_cast<std::uint64_t>(text.size()));
  put(message, std::span<const char>(text));
}

/// Reads a message from its beginning.
class MessageReader {
 public:
  /// @param bytes  must outlive the reader
  explicit MessageReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  [[nodiscard]] bool at_end() const { return rest_.empty(); }  ///< all has been read
  /// The next values. @throws Error if the message is too short: the ranks disagree, which is an error of this program
  template <class T>
  void get(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest_.size() < values.size_bytes()) throw Error(ExitCode::internal, "internal error: a message between ranks is too short");
    if (!values.empty()) std::memcpy(values.data(), rest_.data(), values.size_bytes());
    rest_ = rest_.subspan(values.size_bytes());
  }
  /// The next value.
  template <class T>
  T get() {
    T value;
    get(std::span<T>(&value, 1));
    return value;
  }
  /// The next text, appended by put_text.
  std::string get_text() {
    std::string all(get<std::uint64_t>(), '\0');
    get(std::span(all));
    return all;
  }
  /// The rest, as values.
  template <class T>
  std::vector<T> values() {
    std::vector<T> all(rest_.size() / sizeof(T));
    get(std::span(all));
    return all;
  }
  /// The rest, as text.
  std::string text() {
    std::string all(rest_.size(), '\0');
    get(std::span(all));
    return all;
  }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace mpm
