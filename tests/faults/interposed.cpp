// Functions of the C library that this program defines itself: the dynamic linker takes the first
// definition it finds, for the program and for every library. Each counts, fails where the plan
// says so, and hands on to the real one.
#include "tests/faults/interposed.h"
#include "tests/sanitized.h"

#if LODE_IS_SANITIZED
// The sanitizers stand there already.
bool lode::test::can_inject_faults() { return false; }
#else

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using lode::test::Fault;
using lode::test::must_fail;

bool lode::test::can_inject_faults() { return true; }

// What glibc's own allocator is called beside malloc(): dlsym() would allocate to find it.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

#define LODE_CALLER __builtin_return_address(0)

namespace {

/// The function of that name that would be called without this program's.
template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

/// Files that the machine, not the library, is asked about.
bool is_of_the_system(const char* path) {
  return std::strncmp(path, "/proc/", 6) == 0 || std::strncmp(path, "/sys/", 5) == 0;
}

/// How many bytes a read or write is to move: all, some, or none with errno set (0).
std::size_t bytes_to_move(bool is_read, std::size_t n, const void* caller) {
  if (must_fail(is_read ? Fault::read : Fault::write, caller)) return 0;
  if (must_fail(is_read ? Fault::interrupted_read : Fault::interrupted_write, caller)) {
    errno = EINTR;
    return 0;
  }
  if (is_read && must_fail(Fault::late_read, caller)) usleep(3000);
  if (n > 1 && must_fail(is_read ? Fault::short_read : Fault::short_write, caller)) return n / 2;
  return n;
}

}  // namespace

extern "C" {

void* malloc(std::size_t n) noexcept {
  return must_fail(Fault::memory, LODE_CALLER) ? nullptr : __libc_malloc(n);
}

void* calloc(std::size_t n, std::size_t size) noexcept {
  return must_fail(Fault::memory, LODE_CALLER) ? nullptr : __libc_calloc(n, size);
}

void* realloc(void* memory, std::size_t n) noexcept {
  return must_fail(Fault::memory, LODE_CALLER) ? nullptr : __libc_realloc(memory, n);
}

void* aligned_alloc(std::size_t alignment, std::size_t n) noexcept {
  return must_fail(Fault::memory, LODE_CALLER) ? nullptr : __libc_memalign(alignment, n);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t n) noexcept {
  if (must_fail(Fault::memory, LODE_CALLER)) return ENOMEM;
  *memory = __libc_memalign(alignment, n);
  return *memory == nullptr ? ENOMEM : 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                   void* argument) noexcept {
  static auto* const next = real<decltype(pthread_create)>("pthread_create");
  return must_fail(Fault::thread, LODE_CALLER) ? EAGAIN : next(thread, attributes, run, argument);
}

int open(const char* path, int flags, ...) {
  static auto* const next = real<int(const char*, int, mode_t)>("open");
  std::va_list arguments;
  va_start(arguments, flags);
  const auto mode = static_cast<mode_t>(va_arg(arguments, unsigned));
  va_end(arguments);
  if (!is_of_the_system(path) && must_fail(Fault::open, LODE_CALLER)) return -1;
  return next(path, flags, mode);
}

int mkostemp(char* name, int flags) {
  static auto* const next = real<decltype(mkostemp)>("mkostemp");
  return must_fail(Fault::open, LODE_CALLER) ? -1 : next(name, flags);
}

FILE* fopen(const char* path, const char* mode) {
  static auto* const next = real<decltype(fopen)>("fopen");
  if (!is_of_the_system(path) && must_fail(Fault::open, LODE_CALLER)) return nullptr;
  return next(path, mode);
}

ssize_t read(int file, void* bytes, std::size_t n) {
  static auto* const next = real<decltype(read)>("read");
  if (n > 0 && (n = bytes_to_move(true, n, LODE_CALLER)) == 0) return -1;
  return next(file, bytes, n);
}

ssize_t pread(int file, void* bytes, std::size_t n, off_t offset) {
  static auto* const next = real<decltype(pread)>("pread");
  if (n > 0 && (n = bytes_to_move(true, n, LODE_CALLER)) == 0) return -1;
  return next(file, bytes, n, offset);
}

ssize_t write(int file, const void* bytes, std::size_t n) {
  static auto* const next = real<decltype(write)>("write");
  if (n > 0 && (n = bytes_to_move(false, n, LODE_CALLER)) == 0) return -1;
  return next(file, bytes, n);
}

ssize_t pwrite(int file, const void* bytes, std::size_t n, off_t offset) {
  static auto* const next = real<decltype(pwrite)>("pwrite");
  if (n > 0 && (n = bytes_to_move(false, n, LODE_CALLER)) == 0) return -1;
  return next(file, bytes, n, offset);
}

// No test here cuts the power, so nothing waits for the disk.
int fsync(int) { return must_fail(Fault::sync, LODE_CALLER) ? -1 : 0; }
int fdatasync(int) { return must_fail(Fault::sync, LODE_CALLER) ? -1 : 0; }

int rename(const char* from, const char* to) noexcept {
  static auto* const next = real<int(const char*, const char*)>("rename");
  return must_fail(Fault::rename, LODE_CALLER) ? -1 : next(from, to);
}

int linkat(int from_directory, const char* from, int to_directory, const char* to,
           int flags) noexcept {
  static auto* const next = real<int(int, const char*, int, const char*, int)>("linkat");
  if (must_fail(Fault::rename, LODE_CALLER)) return -1;
  return next(from_directory, from, to_directory, to, flags);
}

int ftruncate(int file, off_t size) noexcept {
  static auto* const next = real<int(int, off_t)>("ftruncate");
  return must_fail(Fault::resize, LODE_CALLER) ? -1 : next(file, size);
}

off_t lseek(int file, off_t offset, int whence) noexcept {
  static auto* const next = real<off_t(int, off_t, int)>("lseek");
  return must_fail(Fault::examine, LODE_CALLER) ? -1 : next(file, offset, whence);
}

int fstat(int file, struct stat* status) noexcept {
  static auto* const next = real<int(int, struct stat*)>("fstat");
  return must_fail(Fault::examine, LODE_CALLER) ? -1 : next(file, status);
}

int flock(int file, int operation) noexcept {
  static auto* const next = real<int(int, int)>("flock");
  return must_fail(Fault::examine, LODE_CALLER) ? -1 : next(file, operation);
}

}  // extern "C"

#endif
