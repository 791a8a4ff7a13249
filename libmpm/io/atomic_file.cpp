#include "libmpm/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <regex>
#include <system_error>

#include "libmpm/base/text.hpp"

namespace mpm {

namespace {

/// Calls put(rest), which returns as ::write does, until all bytes are written. @returns 0, or an errno value
template <class Put>
int write_all(std::span<const std::byte> bytes, Put&& put) {
  while (!bytes.empty()) {
    const ssize_t n = put(bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

int Descriptor::write(std::string_view text) const {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return write_all(bytes, [&](std::span<const std::byte> rest) { return ::write(number_, rest.data(), rest.size()); });
}

int Descriptor::write_at(std::uint64_t offset, std::span<const std::byte> bytes) const {
  return write_all(bytes, [&](std::span<const std::byte> rest) {
    return ::pwrite(number_, rest.data(), rest.size(), static_cast<off_t>(offset + (bytes.size() - rest.size())));
  });
}

namespace {

std::string_view remedy(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT: return "free space on this disk or choose another output directory";
    case EACCES:
    case EPERM: return "check the permissions of the file and of its directory";
    case EROFS: return "the file system is read-only: choose another output directory";
    case ENOENT: return "check the path: the directory does not exist";
    case ENOTDIR: return "check the path: a part of it is a file, not a directory";
    case EISDIR: return "the name is taken by a directory: remove it or choose another name";
    case ENAMETOOLONG: return "choose a shorter name";
    case EMFILE:
    case ENFILE: return "too many files are open: close some or raise `ulimit -n`";
    case ELOOP: return "the name is taken by a symbolic link: remove it or choose another output directory";
    case EFBIG: return "raise the file size limit (`ulimit -f`) or write less";
    default: return "check the disk and the path";
  }
}

/// Directory of a path, "." for a bare name.
std::filesystem::path directory_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Whether a temporary is still being written: its writer holds the lock that AtomicFile takes. The kernel releases it when the writer
/// dies, even if the process number still exists (as a zombie, or reused). On file systems without locks the
/// process number decides.
bool being_written(const std::filesystem::path& temporary, pid_t writer) {
  const Descriptor file(::open(temporary.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
  const int reason = file && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
  if (reason == 0) return false;
  if (reason == EWOULDBLOCK) return true;
  return writer != ::getpid() && (::kill(writer, 0) == 0 || errno != ESRCH);
}

}  // namespace

IoError file_error(std::string_view action, const std::filesystem::path& path, int error_number) {
  if (error_number == ENOENT && action == "cannot read") return IoError(fmt::format("'{}' does not exist; check the path", path.string()));
  return IoError(
      fmt::format("{} '{}': {}; {}", action, path.string(), std::generic_category().message(error_number), remedy(error_number)));
}

AtomicFile::AtomicFile(std::filesystem::path target) : target_(std::move(target)) {
  static std::atomic<unsigned> counter{0};
  do {  // O_EXCL: the name may be taken by a leftover of a killed process with the same number, or by a link to another file
    temporary_ = directory_of(target_) / fmt::format(".{}.{}.{}.tmp", target_.filename().string(), ::getpid(), counter++);
    file_ = Descriptor(::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  } while (!file_ && errno == EEXIST);
  if (!file_) throw file_error("cannot write", target_, errno);
  // Tells remove_leftovers() of another process that the file is in use; some file systems have no locks.
  (void)::flock(file_.get(), LOCK_EX | LOCK_NB);
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() noexcept {
  file_ = Descriptor();
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

void AtomicFile::write(std::string_view text) {
  if (const int reason = file_.write(text); reason != 0) fail(reason);
}

void AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (const int reason = file_.write_at(offset, bytes); reason != 0) fail(reason);
}

void AtomicFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t n = ::pread(file_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw file_error("cannot read back", target_, errno);
    if (n == 0) {  // the end
      std::ranges::fill(bytes, std::byte{0});
      return;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
}

/// Removes the temporary. @param reason  an errno value
void AtomicFile::fail(int reason) {
  discard();
  throw file_error("cannot write", target_, reason);
}

void AtomicFile::commit(const std::filesystem::path& keep_as) {
  if (::fsync(file_.get()) != 0) fail(errno);
  const Descriptor lock(::fcntl(file_.get(), F_DUPFD_CLOEXEC, 0));  // held until the file has its name
  if (::close(file_.release()) != 0) fail(errno);
  if (!keep_as.empty() && ::rename(target_.c_str(), keep_as.c_str()) != 0 && errno != ENOENT) fail(errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  temporary_.clear();
  // The new name itself reaches the disk with its directory. Some file systems cannot do this; the file is complete anyway.
  if (const Descriptor directory(::open(directory_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); directory)
    ::fsync(directory.get());
}

FileShare::FileShare(std::filesystem::path target, const std::filesystem::path& temporary)
    : target_(std::move(target)), file_(::open(temporary.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC)) {
  if (file_) return;
  if (errno != ENOENT) throw file_error("cannot write", target_, errno);
  throw IoError(
      fmt::format("cannot write '{}': this process does not see the file that was begun there: the output directory was deleted, "
                  "moved or replaced; or it is not the same for all ranks: put it on a file system that all machines share",
                  target_.string()));
}

void FileShare::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (const int reason = file_.write_at(offset, bytes); reason != 0) throw file_error("cannot write", target_, reason);
}

void FileShare::sync() {
  if (::fsync(file_.get()) != 0) throw file_error("cannot write", target_, errno);
}

void write_file(const std::filesystem::path& target, std::string_view content) {
  AtomicFile file(target);
  file.write(content);
  file.commit();
}

void remove_leftovers(const std::filesystem::path& directory) {
  static const std::regex pattern(R"(\..+\.(\d{1,9})\.\d+\.tmp)");  // as the constructor of AtomicFile writes them
  for (const std::string& name : names_in(directory)) {
    std::smatch match;
    if (std::regex_match(name, match, pattern) && !being_written(directory / name, static_cast<pid_t>(std::stol(match[1]))))
      remove_file(directory / name);
  }
}

void remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw file_error("cannot remove", path, error.value());
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) throw file_error("cannot rename", from, error.value());
}

std::vector<std::string> names_in(const std::filesystem::path& directory) {
  std::error_code error;
  std::vector<std::string> names;
  for (auto it = std::filesystem::directory_iterator(directory, error); !error && it != std::filesystem::directory_iterator();
       it.increment(error))
    names.push_back(it->path().filename().string());
  if (error && error != std::errc::no_such_file_or_directory) throw file_error("cannot read directory", directory, error.value());
  std::ranges::sort(names);
  return names;
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw file_error("cannot create directory", directory, error.value());
  // create_directories accepts an existing file of that name on some paths.
  if (!std::filesystem::is_directory(directory, error)) throw file_error("cannot create directory", directory, ENOTDIR);
}

std::string read_file(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  const auto refuse = [&] {
    throw IoError(fmt::format("cannot read '{}': it has more than {} bytes; this is no file of this program, check the path", path.string(),
                              most_bytes));
  };
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) throw file_error("cannot read", path, errno);
  std::string content;
  struct stat info {};
  if (::fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode)) {
    if (static_cast<std::uintmax_t>(info.st_size) > most_bytes) refuse();
    content.reserve(static_cast<std::size_t>(info.st_size));
  }
  char buffer[1 << 16];
  for (;;) {
    const ssize_t n = ::read(file.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw file_error("cannot read", path, errno);
    if (n == 0) return content;
    content.append(buffer, static_cast<std::size_t>(n));
    if (content.size() > most_bytes) refuse();
  }
}

std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  std::string text = read_file(path, most_bytes);
  if (const std::size_t at = first_not_utf8(text); at != std::string::npos) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw IoError(fmt::format("{}:{}: a character is not UTF-8; save the file with that encoding", path.string(), line));
  }
  return text;
}

}  // namespace mpm
