#pragma once
/// run.log: the messages of a run, with times.

#include <filesystem>
#include <string>

namespace mpm {

/// The run.log of a run, open until it ends or stops.
class RunLog {
 public:
  /// @param append  whether to keep the lines from before a resume. @throws IoError
  RunLog(const std::filesystem::path& path, bool append);
  /// Closes the file.
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// Adds one line with the time. A log that cannot be written does not end a run.
  void write(const std::string& text) const;

 private:
  int descriptor_;
};

}  // namespace mpm
