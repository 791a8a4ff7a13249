/// Preloaded into a program (LD_PRELOAD), it makes one of the program's file operations fail, or kills the program there.
///
/// FAIL_AT=n         the n-th call, counted from 1; without it none
/// FAIL_WITH=errno   a number; or `kill`: SIGKILL in place of the call, `half`: SIGKILL after half of a write, `memory`: the call succeeds,
///                   and the next allocation by operator new fails
/// COUNT_FILE=path   receives the number of calls at the end
/// FLOCK_FAILS=errno every flock() fails so, as on a file system without locks
///
/// Counted are calls that change files: open for writing, write, pwrite, fsync, rename, remove, mkdir.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

std::atomic<long> calls{0};
std::atomic<bool> out_of_memory{false};

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// Whether this call is the one that fails; errno is set then, or the process is gone.
template <class WriteHalf>
bool fails_here(WriteHalf&& write_half) {
  static const char* at = std::getenv("FAIL_AT");
  static const char* with = std::getenv("FAIL_WITH");
  if (++calls != (at != nullptr ? std::atol(at) : -1) || with == nullptr) return false;
  if (std::strcmp(with, "memory") == 0) {
    out_of_memory = true;
    return false;
  }
  if (std::strcmp(with, "half") == 0) write_half();
  if (std::strcmp(with, "half") == 0 || std::strcmp(with, "kill") == 0) std::raise(SIGKILL);
  errno = std::atoi(with);
  return true;
}

bool fails_here() {
  return fails_here([] {});
}

struct Report {
  ~Report() {
    const char* path = std::getenv("COUNT_FILE");
    if (path == nullptr) return;
    const long counted = calls;
    if (std::FILE* file = std::fopen(path, "w")) {
      std::fprintf(file, "%ld\n", counted);
      std::fclose(file);
    }
  }
} report;

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  if ((flags & O_CREAT) != 0) {
    va_list rest;
    va_start(rest, flags);
    mode = va_arg(rest, mode_t);
    va_end(rest);
  }
  if ((flags & (O_WRONLY | O_RDWR)) != 0 && fails_here()) return -1;
  return next<int(const char*, int, ...)>("open")(path, flags, mode);
}

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
  const auto real = next<ssize_t(int, const void*, std::size_t)>("write");
  if (descriptor > STDERR_FILENO && fails_here([&] { (void)!real(descriptor, bytes, size / 2); })) return -1;
  return real(descriptor, bytes, size);
}

ssize_t pwrite(int descriptor, const void* bytes, std::size_t size, off_t offset) {
  const auto real = next<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
  if (fails_here([&] { (void)!real(descriptor, bytes, size / 2, offset); })) return -1;
  return real(descriptor, bytes, size, offset);
}

int flock(int descriptor, int operation) noexcept {
  if (const char* reason = std::getenv("FLOCK_FAILS"); reason != nullptr) {
    errno = std::atoi(reason);
    return -1;
  }
  return next<int(int, int)>("flock")(descriptor, operation);
}

int fsync(int descriptor) { return fails_here() ? -1 : next<int(int)>("fsync")(descriptor); }

int rename(const char* from, const char* to) noexcept {
  return fails_here() ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}

int remove(const char* path) noexcept { return fails_here() ? -1 : next<int(const char*)>("remove")(path); }

int mkdir(const char* path, mode_t mode) noexcept { return fails_here() ? -1 : next<int(const char*, mode_t)>("mkdir")(path, mode); }
}

/// That of libstdc++, which operator new[] calls, too.
void* operator new(std::size_t size) {
  if (out_of_memory.exchange(false)) throw std::bad_alloc();
  static const auto real = next<void*(std::size_t)>("_Znwm");
  return real(size);
}
