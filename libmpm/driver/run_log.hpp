#pragma once
/// run.log: the messages of a run, with times.

#include <filesystem>
#include <string>

#include "libmpm/io/descriptor.hpp"

namespace mpm {

/// The run.log of a run, open until it ends or stops.
class RunLog {
 public:
  /// @param append  whether to keep the lines from before a resume. @throws IoError
  RunLog(const std::filesystem::path& path, bool append);

  /// Adds one line with the time. A log that cannot be written does not end a run.
  void write(const std::string& text) const;

 private:
  Descriptor file_;
};

}  // namespace mpm
