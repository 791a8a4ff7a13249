#pragma once
/// run.log: the messages of a run, with times.

#include <filesystem>
#include <string>

namespace mpm {

class RunLog {
 public:
  /// @param append  whether to keep what an earlier stretch wrote. @throws IoError
  RunLog(const std::filesystem::path& path, bool append);
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  void write(const std::string& text) const;

 private:
  int descriptor_;
};

}  // namespace mpm
