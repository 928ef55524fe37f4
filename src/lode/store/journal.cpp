#include "lode/store/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/format.h"

namespace lode::store {
namespace {

/// Before each record: sizes of what is stored and of what it decodes to, XXH64 of what is stored.
using Head = std::array<std::uint64_t, 3>;

bool transfer(auto call, int descriptor, auto* bytes, std::size_t n, std::uint64_t offset) {
  while (n > 0) {
    const ssize_t done = call(descriptor, bytes, n, static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes += done;
    n -= static_cast<std::size_t>(done);
    offset += static_cast<std::uint64_t>(done);
  }
  return true;
}

}  // namespace

Journal::Journal(Journal&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Error Journal::system_error(const char* action) const {
  return fail("{}: cannot {}: {}", path_, action, std::strerror(errno));
}

Result<Journal> Journal::open(std::string path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor < 0) return fail("{}: cannot open the file: {}", path, std::strerror(errno));
  Journal journal(std::move(path), descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return journal.system_error("lock the file");
    return fail("{}: another process is writing it", journal.path_);
  }
  return journal;
}

Result<Journal> Journal::create(std::string path) {
  LODE_TRY(auto journal, open(std::move(path)));
  if (::ftruncate(journal.descriptor_, 0) != 0) return journal.system_error("write");
  return journal;
}

Result<Journal> Journal::reopen(std::string path, const Take& take) {
  LODE_TRY(auto journal, open(std::move(path)));
  LODE_CHECK(journal.replay(take));
  if (::ftruncate(journal.descriptor_, static_cast<off_t>(journal.size_)) != 0)
    return journal.system_error("write");
  return journal;
}

Result<void> Journal::replay(const Take& take) {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return system_error("read the size");
  const auto end = static_cast<std::uint64_t>(status.st_size);
  while (end - size_ >= sizeof(Head)) {
    Head head{};
    auto* head_bytes = reinterpret_cast<std::byte*>(head.data());
    if (!transfer(::pread, descriptor_, head_bytes, sizeof(Head), size_))
      return system_error("read");
    const auto [stored_size, raw_size, sum] = head;
    if (stored_size > end - size_ - sizeof(Head)) return {};
    if (raw_size / kMaxZstdRatio > stored_size) return {};
    std::vector<std::byte> stored(static_cast<std::size_t>(stored_size));
    if (!transfer(::pread, descriptor_, stored.data(), stored.size(), size_ + sizeof(Head)))
      return system_error("read");
    if (checksum(stored) != sum) return {};
    std::vector<std::byte> raw(static_cast<std::size_t>(raw_size));
    if (!zstd_decompress(stored, raw)) return {};
    LODE_TRY(const bool is_taken, take(raw));
    if (!is_taken) return {};
    size_ += sizeof(Head) + stored_size;
  }
  return {};
}

Result<void> Journal::append(std::span<const std::byte> record) {
  const std::vector<std::byte> stored = zstd_compress(record);
  const Head head{stored.size(), record.size(), checksum(stored)};
  const auto* head_bytes = reinterpret_cast<const std::byte*>(head.data());
  if (!transfer(::pwrite, descriptor_, head_bytes, sizeof(Head), size_) ||
      !transfer(::pwrite, descriptor_, stored.data(), stored.size(), size_ + sizeof(Head)))
    return system_error("write");
  if (::fdatasync(descriptor_) != 0) return system_error("flush to disk");
  size_ += sizeof(Head) + stored.size();
  return {};
}

void Journal::remove() { ::unlink(path_.c_str()); }

}  // namespace lode::store
