#include "lode/core/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace lode {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr int kAttempts = 100;  // to find a free name

std::string directory_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

bool write_fully(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

/// What a file without a name is given one by.
std::string self_path(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

std::string temporary_name(const std::string& path, int attempt) {
  return fmt::format("{}.tmp-{}-{}", path, ::getpid(), attempt);
}

}  // namespace

AtomicFile::AtomicFile(std::string path, std::string temporary, int descriptor, Leftover leftover)
    : path_(std::move(path)),
      temporary_(std::move(temporary)),
      descriptor_(descriptor),
      leftover_(leftover) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      leftover_(other.leftover_),
      size_(other.size_),
      buffer_(std::move(other.buffer_)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  // What cannot be written is not needed to go on.
  if (leftover_ == Leftover::kept) static_cast<void>(write_fully(descriptor_, buffer_));
  ::close(descriptor_);
  if (leftover_ == Leftover::removed) ::unlink(temporary_.c_str());
}

Error AtomicFile::system_error(const char* action) const {
  return fail("{}: cannot {}: {}", path_, action, std::strerror(errno));
}

Result<AtomicFile> AtomicFile::create(std::string path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode))
    return fail("{}: expected a file name for the output, got a directory", path);
  // Made first, so that no descriptor is lost where memory is.
  AtomicFile file(std::move(path), "", -1, Leftover::nameless);
  file.descriptor_ = ::open(directory_of(file.path_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (file.descriptor_ >= 0) {
    // Without /proc it could not be named at the end.
    if (::access(self_path(file.descriptor_).c_str(), F_OK) == 0) return file;
    ::close(std::exchange(file.descriptor_, -1));
  }
  file.leftover_ = Leftover::removed;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    file.temporary_ = temporary_name(file.path_, attempt);
    file.descriptor_ = ::open(file.temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file.descriptor_ >= 0) return file;
    if (errno != EEXIST) return file.system_error("create the output file");
  }
  return fail("{}: cannot find a free name for a temporary file beside it", file.path_);
}

Result<AtomicFile> AtomicFile::open_part(std::string path, std::uint64_t n_kept) {
  std::string part = part_path(path);
  const int descriptor = ::open(part.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor < 0)
    return fail("{}: cannot create the output file: {}", part, std::strerror(errno));
  AtomicFile file(std::move(path), std::move(part), descriptor, Leftover::kept);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return file.system_error("lock the file");
    return fail("{}: another process is writing it", file.temporary_);
  }
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return file.system_error("read the size");
  if (!S_ISREG(status.st_mode)) return fail("{}: expected a regular file", file.temporary_);
  if (static_cast<std::uint64_t>(status.st_size) < n_kept)
    return fail("{}: expected at least {} bytes to go on from, got {}", file.temporary_, n_kept,
                status.st_size);
  if (::ftruncate(descriptor, static_cast<off_t>(n_kept)) != 0) return file.system_error("write");
  if (::lseek(descriptor, 0, SEEK_END) < 0) return file.system_error("write");
  file.size_ = n_kept;
  return file;
}

void AtomicFile::remove_part(const std::string& path) {
  const std::string part = part_path(path);
  const int descriptor = ::open(part.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(part.c_str());
  ::close(descriptor);
}

/// A nameless file is given the name that it is renamed from.
Result<void> AtomicFile::name_temporary() {
  const std::string self = self_path(descriptor_);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    temporary_ = temporary_name(path_, attempt);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      leftover_ = Leftover::removed;
      return {};
    }
    if (errno != EEXIST) return system_error("name the output file");
  }
  return fail("{}: cannot find a free name for a temporary file beside it", path_);
}

Result<void> AtomicFile::flush() {
  if (!write_fully(descriptor_, buffer_)) return system_error("write");
  buffer_.clear();
  return {};
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  LODE_EXPECTS(descriptor_ >= 0);
  size_ += bytes.size();
  if (buffer_.size() + bytes.size() > kBufferBytes) LODE_CHECK(flush());
  if (bytes.size() > kBufferBytes) {
    if (!write_fully(descriptor_, bytes)) return system_error("write");
    return {};
  }
  buffer_.reserve(kBufferBytes);
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  LODE_EXPECTS(descriptor_ >= 0 && offset + bytes.size() <= size_);
  LODE_CHECK(flush());
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return system_error("write");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return {};
}

Result<void> AtomicFile::read_at(std::uint64_t offset, std::span<std::byte> out) {
  LODE_EXPECTS(descriptor_ >= 0 && offset + out.size() <= size_);
  LODE_CHECK(flush());
  while (!out.empty()) {
    const ssize_t n = ::pread(descriptor_, out.data(), out.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error("read");
    if (n == 0) return fail("{}: ends at {} bytes while it is written", temporary_, offset);
    out = out.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return {};
}

Result<void> AtomicFile::sync() {
  LODE_EXPECTS(descriptor_ >= 0);
  LODE_CHECK(flush());
  if (::fdatasync(descriptor_) != 0) return system_error("flush to disk");
  return {};
}

Result<void> AtomicFile::commit(const Progress& progress) {
  LODE_EXPECTS(descriptor_ >= 0);
  LODE_CHECK(flush());
  if (::fsync(descriptor_) != 0) return system_error("flush to disk");
  if (progress.is_cancelled()) return cancelled_error();
  const std::string parent = directory_of(path_);  // once it has its name, nothing may fail
  if (leftover_ == Leftover::nameless) LODE_CHECK(name_temporary());
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) return system_error("rename into place");
  ::close(std::exchange(descriptor_, -1));
  // The rename is durable once its directory is; a file system without that call is no failure.
  const int directory = ::open(parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    ::fsync(directory);
    ::close(directory);
  }
  return {};
}

}  // namespace lode
