#include "libmpm/driver/run_log.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cerrno>
#include <ctime>

#include "libmpm/io/atomic_file.hpp"

namespace mpm {

RunLog::RunLog(const std::filesystem::path& path, bool append)
    : file_(open(path.c_str(), O_CREAT | O_WRONLY | O_NOFOLLOW | O_CLOEXEC | (append ? O_APPEND : O_TRUNC), 0666)) {
  if (!file_) throw file_error("cannot write", path, errno);
}

void RunLog::write(const std::string& text) const {
  // a log that cannot be written must not end a run that can; the loss shows in the series, which is checked
  (void)file_.write(fmt::format("{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), text));
}

}  // namespace mpm
