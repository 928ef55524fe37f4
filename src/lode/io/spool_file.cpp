#include "lode/io/spool_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace lode::io {
namespace {

/// Rows of a few hundred bytes are gathered; larger pieces go to the file as they are.
constexpr std::size_t kBufferBytes = std::size_t{1} << 16;
constexpr std::size_t kMaxTransfer = std::size_t{1} << 30;

/// A descriptor, or -1 where the file system has no files without names.
int open_nameless([[maybe_unused]] const std::string& directory) {
#ifdef O_TMPFILE
  constexpr mode_t kOwnerOnly = 0600;
  return ::open(directory.c_str(), O_TMPFILE | O_EXCL | O_RDWR | O_CLOEXEC, kOwnerOnly);
#else
  return -1;
#endif
}

/// A descriptor, or -1 with errno.
int open_unlinked(const std::string& directory) {
  std::string name = directory + "/lode-spool-XXXXXX";
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) ::unlink(name.c_str());
  return descriptor;
}

}  // namespace

SpoolFile::SpoolFile(std::string directory, IoTallyPtr tally)
    : directory_(std::move(directory)), tally_(std::move(tally)) {
  buffer_.reserve(kBufferBytes);
}

SpoolFile::SpoolFile(SpoolFile&& other) noexcept
    : directory_(std::move(other.directory_)),
      tally_(std::move(other.tally_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      n_written_(other.n_written_),
      buffer_(std::move(other.buffer_)) {}

SpoolFile::~SpoolFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<SpoolFile> SpoolFile::create(const std::string& directory, IoTallyPtr tally, Birth birth) {
  SpoolFile file(directory, std::move(tally));
  if (birth == Birth::nameless_if_possible) file.descriptor_ = open_nameless(directory);
  // What a missing or read-only directory did to the first attempt, it does to the second.
  if (file.descriptor_ < 0) file.descriptor_ = open_unlinked(directory);
  if (file.descriptor_ < 0)
    return fail("{}: no spool file can be made in this directory: {}", directory, system_message());
  return file;
}

Result<void> SpoolFile::append(std::span<const std::byte> bytes) {
  if (bytes.size() > kBufferBytes - buffer_.size()) {
    LODE_CHECK(write(buffer_));
    buffer_.clear();
  }
  if (bytes.size() > kBufferBytes) return write(bytes);
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> SpoolFile::write(std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n =
        ::pwrite(descriptor_, bytes.data() + done, std::min(bytes.size() - done, kMaxTransfer),
                 static_cast<off_t>(n_written_ + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      return fail("{}: the spool file in this directory cannot be written beyond {} bytes: {}",
                  directory_, n_written_ + done, system_message());
    done += static_cast<std::size_t>(n);
    tally_->n_spool_bytes_written += static_cast<std::uint64_t>(n);
  }
  n_written_ += done;
  return {};
}

Result<void> SpoolFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  LODE_EXPECTS(offset <= size() && out.size() <= size() - offset);
  const auto n_in_file = static_cast<std::size_t>(
      std::min<std::uint64_t>(out.size(), n_written_ - std::min(offset, n_written_)));
  LODE_CHECK(read_written(offset, out.first(n_in_file)));
  out = out.subspan(n_in_file);
  if (!out.empty())
    std::memcpy(out.data(), buffer_.data() + (offset + n_in_file - n_written_), out.size());
  return {};
}

Result<void> SpoolFile::read_written(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t n =
        ::pread(descriptor_, out.data() + done, std::min(out.size() - done, kMaxTransfer),
                static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      return fail("{}: the spool file in this directory cannot be read: {}", directory_,
                  n < 0 ? system_message() : "it became shorter");
    done += static_cast<std::size_t>(n);
    tally_->n_spool_bytes_read += static_cast<std::uint64_t>(n);
  }
  return {};
}

}  // namespace lode::io
