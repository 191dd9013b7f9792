// Intercepts calls of the C library and makes file operations fail according to a plan.
//
// When preloaded, it reads the plan from TERRAZZO_FAULTS="SEED RATE OPERATIONS FULL_AFTER PASSING FOLDER" and
// adds its counts to the file named by TERRAZZO_FAULT_COUNTS: two 8-byte numbers, calls and faults.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/torture/fault_plan.h"

namespace {
using namespace terrazzo::torture;

FaultPlan plan;
FaultCounts own_counts;
FaultCounts* counts = &own_counts;
std::atomic<bool> active{false};
thread_local int interruptions =
    0;  // consecutive; limited, so that a program that retries succeeds eventually

template <class F>
F* real(F*, const char* name) {
  return reinterpret_cast<F*>(::dlsym(RTLD_NEXT, name));
}
#define REAL(function) static const auto real_##function = real(&::function, #function)

std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

bool below(const char* path) {
  const std::size_t length = std::strlen(plan.folder);
  return path[0] != '/' || std::strncmp(path, plan.folder, length) == 0;
}

bool below(int fd) {
  char link[40], path[1024];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t n = ::readlink(link, path, sizeof path - 1);
  if (n <= 0) return false;
  path[n] = 0;
  return path[0] == '/' && below(path);
}

// Returns 0 if the call succeeds, else random bits that determine how it fails. `can_pass`: the call can fail
// by an interruption or a short count.
std::uint64_t fault(unsigned operation, bool can_pass = false) {
  const std::uint64_t call = ++counts->calls;
  const std::uint64_t bits = mix(plan.seed ^ mix(call));
  const bool full = plan.full_after && call >= plan.full_after && operation != open_to_read;
  const bool chosen = (plan.operations & operation) &&
                      static_cast<double>(bits >> 11) * 0x1p-53 < plan.rate &&
                      (!plan.passing || (can_pass && interruptions < 3));
  if (!full && !chosen) return 0;
  ++counts->injected;
  return full && !chosen ? 1 : mix(bits) | 2;
}

bool is_full(std::uint64_t f) { return f == 1; }

int fail(std::uint64_t f, bool may_interrupt, int other = EIO) {
  if (!is_full(f) && may_interrupt && interruptions < 3 && (plan.passing || (f >> 8) % 3 == 0)) {
    ++interruptions;
    errno = EINTR;
    return -1;
  }
  errno = is_full(f) || (f >> 8) % 2 ? ENOSPC : other;
  return -1;
}

// Returns how many of `size` bytes are written, fewer than `size`; 0: the call fails.
std::size_t part(std::uint64_t f, std::size_t size) {
  return is_full(f) || size < 2 || (f >> 4) % 2 ? 0 : 1 + (f >> 16) % std::min<std::size_t>(size - 1, 64);
}

__attribute__((constructor)) void begin_from_environment() {
  const char* text = std::getenv("TERRAZZO_FAULTS");
  if (!text) return;
  FaultPlan p;
  unsigned long long seed = 0, full_after = 0;
  int passing = 0;
  if (std::sscanf(text, "%llu %lf %u %llu %d %511[^\n]", &seed, &p.rate, &p.operations, &full_after, &passing,
                  p.folder) != 6)
    ::abort();
  p.seed = seed;
  p.full_after = full_after;
  p.passing = passing;
  FaultCounts* shared = nullptr;
  if (const char* file = std::getenv("TERRAZZO_FAULT_COUNTS")) {
    const int fd = ::open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0 || ::ftruncate(fd, sizeof(FaultCounts)) != 0) ::abort();
    void* at = ::mmap(nullptr, sizeof(FaultCounts), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    ::close(fd);
    if (at == MAP_FAILED) ::abort();
    shared = static_cast<FaultCounts*>(at);
  }
  terrazzo_begin_faults(&p, shared);
}

unsigned opening(int flags) { return flags & (O_WRONLY | O_RDWR | O_CREAT) ? open_to_write : open_to_read; }
unsigned opening(const char* mode) {
  return std::strchr(mode, 'r') && !std::strchr(mode, '+') ? open_to_read : open_to_write;
}

}  // namespace

extern "C" {

void terrazzo_begin_faults(const FaultPlan* p, FaultCounts* shared) {
  plan = *p;
  if (shared) counts = shared;
  active = true;
}

#define OPEN(name, ...)                                                             \
  {                                                                                 \
    REAL(name);                                                                     \
    mode_t mode = 0;                                                                \
    if (flags & (O_CREAT | O_TMPFILE)) {                                            \
      va_list rest;                                                                 \
      va_start(rest, flags);                                                        \
      mode = va_arg(rest, mode_t);                                                  \
      va_end(rest);                                                                 \
    }                                                                               \
    if (active && below(path))                                                      \
      if (const auto f = fault(opening(flags), true)) return fail(f, true, EMFILE); \
    interruptions = 0;                                                              \
    return real_##name(__VA_ARGS__);                                                \
  }
int open(const char* path, int flags, ...)
    OPEN(open, path, flags, mode) int open64(const char* path, int flags, ...)
        OPEN(open64, path, flags, mode) int openat(int folder, const char* path, int flags, ...)
            OPEN(openat, folder, path, flags, mode) int openat64(int folder, const char* path, int flags, ...)
                OPEN(openat64, folder, path, flags, mode)

                    FILE* fopen(const char* path, const char* mode) {
  REAL(fopen);
  if (active && below(path))
    if (const auto f = fault(opening(mode))) return fail(f, false, EMFILE), nullptr;
  return real_fopen(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  REAL(fopen64);
  if (active && below(path))
    if (const auto f = fault(opening(mode))) return fail(f, false, EMFILE), nullptr;
  return real_fopen64(path, mode);
}

ssize_t write(int fd, const void* data, size_t size) {
  REAL(write);
  if (active && fd > 2 && below(fd))
    if (const auto f = fault(write_bytes, true)) {
      if (const size_t n = part(f, size)) return real_write(fd, data, n);
      return fail(f, true);
    }
  interruptions = 0;
  return real_write(fd, data, size);
}
ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
  REAL(pwrite);
  if (active && below(fd))
    if (const auto f = fault(write_bytes, true)) {
      if (const size_t n = part(f, size)) return real_pwrite(fd, data, n, at);
      return fail(f, true);
    }
  return real_pwrite(fd, data, size, at);
}
ssize_t pwrite64(int fd, const void* data, size_t size, off64_t at) { return ::pwrite(fd, data, size, at); }
ssize_t writev(int fd, const struct iovec* parts, int number) {
  REAL(writev);
  if (active && fd > 2 && below(fd))
    if (const auto f = fault(write_bytes, true)) {
      if (number > 0 && part(f, parts[0].iov_len))
        return real_writev(fd, parts,
                           1);  // only the first part, which is a short count unless it is the only one
      return fail(f, true);
    }
  interruptions = 0;
  return real_writev(fd, parts, number);
}
size_t fwrite(const void* data, size_t size, size_t number, FILE* file) {
  REAL(fwrite);
  if (active && ::fileno(file) > 2 && below(::fileno(file)))
    if (const auto f = fault(write_bytes)) {
      const size_t n = real_fwrite(data, size, part(f, number), file);
      file->_flags |= _IO_ERR_SEEN;  // like the C library
      fail(f, false);
      return n;
    }
  return real_fwrite(data, size, number, file);
}
int fflush(FILE* file) {
  REAL(fflush);
  if (active && file && ::fileno(file) > 2 && below(::fileno(file)))
    if (const auto f = fault(close_stream)) {
      file->_flags |= _IO_ERR_SEEN;
      return fail(f, false), EOF;
    }
  return real_fflush(file);
}
int fclose(FILE* file) {
  REAL(fclose);
  REAL(fflush);
  const int fd = ::fileno(file);
  if (active && fd > 2 && (::fcntl(fd, F_GETFL) & O_ACCMODE) != O_RDONLY && below(fd))
    if (const auto f = fault(close_stream)) {
      real_fflush(file);
      struct stat s;
      if (::fstat(fd, &s) == 0 && s.st_size > 1 &&
          ::ftruncate(fd, static_cast<off_t>((f >> 16) % static_cast<std::uint64_t>(s.st_size))) != 0)
        ::abort();
      real_fclose(file);
      return fail(f, false), EOF;
    }
  return real_fclose(file);
}
int fsync(int fd) {
  if (active && below(fd))
    if (const auto f = fault(sync_file, true)) return fail(f, true);
  return 0;  // the machine does not crash in this test, and syncing would take most of the time
}
int fdatasync(int fd) { return ::fsync(fd); }
int rename(const char* from, const char* to) {
  REAL(rename);
  if (active && below(to))
    if (const auto f = fault(rename_file)) return fail(f, false);
  return real_rename(from, to);
}
int mkdir(const char* path, mode_t mode) {
  REAL(mkdir);
  if (active && below(path))
    if (const auto f = fault(make_folder)) return fail(f, false);
  return real_mkdir(path, mode);
}

}  // extern "C"
