#include "lode/store/reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <utility>

#include "lode/store/bytes.h"
#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/index_scan.h"

namespace lode::store {
namespace {

constexpr std::uint64_t kDefaultMemory = std::uint64_t{64} << 20;
constexpr std::uint64_t kDefaultMemoryPerByte = 4;

std::uint64_t limit_of(std::uint64_t asked, std::uint64_t file_size) {
  return asked != 0 ? asked : kDefaultMemoryPerByte * file_size + kDefaultMemory;
}

Error system_error(const std::string& path, const char* action) {
  return fail("{}: cannot {}: {}", path, action, std::strerror(errno));
}

/// The fault of the lowest block index, whichever thread finds it first.
class FirstFault {
 public:
  explicit FirstFault(std::size_t none) : index_(none) {}

  [[nodiscard]] bool is_before(std::size_t i) const {
    return index_.load(std::memory_order_relaxed) < i;
  }
  void note(std::size_t i, const Error& error) {
    const std::lock_guard lock(mutex_);
    if (is_before(i)) return;
    index_.store(i, std::memory_order_relaxed);
    error_ = error;
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  std::atomic<std::size_t> index_;
  std::mutex mutex_;
  std::optional<Error> error_;
};

}  // namespace

Reader::Reader(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {}

Reader::Reader(Reader&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      memory_limit_(other.memory_limit_),
      length_(other.length_),
      shift_(other.shift_),
      is_rebuilt_(other.is_rebuilt_),
      header_(other.header_),
      directory_(std::move(other.directory_)),
      order_(std::move(other.order_)),
      n_blocks_read_(other.n_blocks_read_.load()),
      n_bytes_read_(other.n_bytes_read_.load()) {}

Reader& Reader::operator=(Reader&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(memory_limit_, other.memory_limit_);
  std::swap(length_, other.length_);
  std::swap(shift_, other.shift_);
  std::swap(is_rebuilt_, other.is_rebuilt_);
  std::swap(header_, other.header_);
  std::swap(directory_, other.directory_);
  std::swap(order_, other.order_);
  n_blocks_read_ = other.n_blocks_read_.exchange(n_blocks_read_);
  n_bytes_read_ = other.n_bytes_read_.exchange(n_bytes_read_);
  return *this;
}

Reader::~Reader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Error Reader::block_error(const BlockEntry& block, const std::string& what) const {
  return fail("{}: {} at offset {}: {}", path_, describe(block.key), block.offset, what);
}

Result<std::uint64_t> Reader::size_on_disk() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return system_error(path_, "find its size");
  if (!S_ISREG(status.st_mode))
    return fail("{}: expected a .lode file, got {}", path_,
                S_ISDIR(status.st_mode) ? "a directory" : "something that is not a regular file");
  return static_cast<std::uint64_t>(status.st_size);
}

Result<void> Reader::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t n = ::pread(descriptor_, out.data() + done, out.size() - done,
                              static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path_, "read");
    if (n == 0)
      return fail("{}: expected {} bytes at offset {}, got {}: the file is truncated", path_,
                  out.size(), offset, done);
    done += static_cast<std::size_t>(n);
  }
  n_bytes_read_.fetch_add(out.size(), std::memory_order_relaxed);
  return {};
}

Result<Header> Reader::load_header() const {
  LODE_TRY(const std::uint64_t size, size_on_disk());
  std::array<std::byte, kHeaderBytes> bytes{};
  const auto start =
      std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(size, kHeaderBytes)));
  LODE_CHECK(read_at(0, start));
  // Where most of a file is missing, what is said of it is no measure of the memory it may take.
  const std::uint64_t said = said_size(start);
  const bool is_any = length_ == Length::any && said / 2 <= size;
  return decode_header(start, is_any ? said : size, path_);
}

Result<void> Reader::check_directory_size(const Header& header) const {
  const std::uint64_t stored_size = header.directory_stored_size;
  const std::uint64_t raw_size = header.directory_raw_size;
  if (raw_size > memory_limit_ || stored_size > memory_limit_)
    return fail("{}: expected a directory within the memory limit of {} bytes, got {} ({} stored)",
                path_, memory_limit_, raw_size, stored_size);
  if (raw_size / kMaxZstdRatio > stored_size)
    return fail("{}: directory: {} stored bytes cannot decode to {}", path_, stored_size, raw_size);
  return {};
}

Result<std::vector<std::byte>> Reader::load_directory(const Header& header) const {
  LODE_CHECK(check_directory_size(header));
  std::vector<std::byte> stored(static_cast<std::size_t>(header.directory_stored_size));
  LODE_CHECK(read_at(header.directory_offset, stored));
  const std::uint64_t sum = checksum(stored);
  if (sum != header.directory_checksum)
    return fail("{}: directory at offset {} is damaged: expected checksum {:016x}, got {:016x}",
                path_, header.directory_offset, header.directory_checksum, sum);
  std::vector<std::byte> raw(static_cast<std::size_t>(header.directory_raw_size));
  if (const auto decoded = zstd_decompress(stored, raw); !decoded)
    return fail("{}: directory at offset {}: {}", path_, header.directory_offset,
                decoded.error().message);
  return raw;
}

Result<std::vector<std::byte>> Reader::find_directory() {
  auto raw = load_directory(header_);
  if (raw || length_ == Length::as_said) return raw;
  LODE_TRY(const std::uint64_t size, size_on_disk());
  if (size == header_.file_size || size < header_.directory_stored_size) return raw;
  Header moved = header_;
  moved.directory_offset = size - header_.directory_stored_size;
  auto found = load_directory(moved);
  if (!found) return raw;
  shift_ = size - header_.file_size;
  return found;
}

Result<void> Reader::read_directory(std::uint64_t memory_limit) {
  LODE_TRY(header_, load_header());
  memory_limit_ = limit_of(memory_limit, file_size());
  LODE_TRY(const auto raw, find_directory());
  LODE_TRY(directory_, decode_directory(raw, {.path = path_,
                                              .blocks_end = header_.directory_offset,
                                              .memory_limit = memory_limit_}));
  return {};
}

/// From the blocks' indexes; `why` says what is wrong with the one there should be.
Result<void> Reader::rebuild_directory(std::uint64_t memory_limit, const Error& why) {
  LODE_TRY(const std::uint64_t size, size_on_disk());
  std::array<std::byte, kHeaderBytes> start{};
  if (size < start.size() || !read_at(0, start) || !may_be_known(start)) return why;
  memory_limit_ = limit_of(memory_limit, size);
  directory_ = scan_indexes(
      {.path = path_,
       .size = size,
       .memory_limit = memory_limit_,
       .read_at = [this](std::uint64_t at, std::span<std::byte> to) { return read_at(at, to); }});
  if (directory_.blocks.empty())
    return fail("{}; and no index of its blocks is whole", why.message);
  header_ = {.file_size = size};
  shift_ = 0;
  is_rebuilt_ = true;
  return {};
}

Result<Reader> Reader::begin(std::string path) {
  // Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return system_error(path, "open");
  return Reader(std::move(path), descriptor);
}

Result<std::string> Reader::model_of(std::string path) {
  constexpr std::size_t kLongestName = 256;
  constexpr std::size_t kFirstLook = 4096;
  LODE_TRY(Reader reader, begin(std::move(path)));
  LODE_TRY(reader.header_, reader.load_header());
  const Header& header = reader.header_;
  reader.memory_limit_ = limit_of(0, header.file_size);
  LODE_CHECK(reader.check_directory_size(header));
  std::vector<std::byte> stored;
  std::array<std::byte, sizeof(std::uint32_t) + kLongestName> start{};
  while (stored.size() < header.directory_stored_size) {
    const std::size_t n_before = stored.size();
    const std::uint64_t wanted = n_before == 0 ? kFirstLook : 4 * std::uint64_t{n_before};
    stored.resize(static_cast<std::size_t>(std::min(wanted, header.directory_stored_size)));
    LODE_CHECK(
        reader.read_at(header.directory_offset + n_before, std::span(stored).subspan(n_before)));
    const auto decoded = zstd_decompress_start(stored, header.directory_raw_size, start);
    if (!decoded)
      return fail("{}: directory at offset {}: {}", reader.path_, header.directory_offset,
                  decoded.error().message);
    ByteReader directory(std::span<const std::byte>(start).first(*decoded), reader.path_);
    if (auto name = directory.read_string()) return name;
  }
  return fail("{}: directory at offset {}: expected the name of a model of at most {} bytes",
              reader.path_, header.directory_offset, kLongestName);
}

Result<Reader> Reader::open(std::string path, const ReaderOptions& options) {
  LODE_TRY(Reader reader, begin(std::move(path)));
  reader.length_ = options.length;
  if (const auto read = reader.read_directory(options.memory_limit); !read) {
    if (options.length == Length::as_said) return read.error();
    LODE_CHECK(reader.rebuild_directory(options.memory_limit, read.error()));
  }
  reader.order_ = order_by_key(reader.directory_.blocks);
  LODE_CHECK(check_keys_differ(reader.directory_.blocks, reader.order_, reader.path_));
  return reader;
}

std::optional<std::size_t> Reader::find(const BlockKey& key) const {
  const auto key_of = [this](std::size_t i) { return directory_.blocks[i].key; };
  const auto at = std::ranges::lower_bound(order_, key, {}, key_of);
  if (at == order_.end() || key_of(*at) != key) return std::nullopt;
  return *at;
}

Result<std::vector<std::byte>> Reader::read_block(std::size_t i) const {
  LODE_EXPECTS(i < directory_.blocks.size());
  const BlockEntry& block = directory_.blocks[i];
  if (block.raw_size > memory_limit_)
    return block_error(block, fmt::format("expected it within the memory limit of {} bytes, got {}",
                                          memory_limit_, block.raw_size));
  std::vector<std::byte> raw(static_cast<std::size_t>(block.raw_size));
  LODE_CHECK(read_block(i, raw));
  return raw;
}

Result<void> Reader::read_stored(const BlockEntry& block, std::uint64_t offset,
                                 std::span<std::byte> out) const {
  LODE_CHECK(read_at(offset, out));
  const std::uint64_t sum = checksum(out);
  if (sum == block.checksum) return {};
  return block_error(
      block, fmt::format("damaged: expected checksum {:016x}, got {:016x}", block.checksum, sum));
}

Result<void> Reader::read_block(std::size_t i, std::span<std::byte> out) const {
  LODE_EXPECTS(i < directory_.blocks.size());
  const BlockEntry& block = directory_.blocks[i];
  LODE_EXPECTS(out.size() == block.raw_size);
  std::vector<std::byte> stored(static_cast<std::size_t>(block.stored_size));
  auto found = read_stored(block, block.offset, stored);
  if (!found && shift_ != 0 && read_stored(block, block.offset + shift_, stored)) found = {};
  if (!found) return found;
  n_blocks_read_.fetch_add(1, std::memory_order_relaxed);
  if (const auto decoded = decode_block(block.codec, block.element_size, stored, out); !decoded)
    return block_error(block, decoded.error().message);
  return {};
}

void Reader::will_read([[maybe_unused]] std::size_t i) const {
#ifdef POSIX_FADV_WILLNEED
  const BlockEntry& block = directory_.blocks[i];
  // Where the system does not take the hint, reading merely waits.
  static_cast<void>(::posix_fadvise(descriptor_, static_cast<off_t>(block.offset),
                                    static_cast<off_t>(block.stored_size), POSIX_FADV_WILLNEED));
#endif
}

Result<void> Reader::check_all(Threads threads, Progress& progress) const {
  LODE_TRY(const Header header, load_header());
  if (header != header_) return fail("{}: the header changed since the file was opened", path_);
  LODE_CHECK(load_directory(header));
  const std::size_t n = directory_.blocks.size();
  FirstFault fault(n);
  std::atomic<std::size_t> n_done{0};
  parallel_for(n, threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled() || fault.is_before(i)) return;
    if (const auto raw = read_block(i); !raw) fault.note(i, raw.error());
    const std::size_t done = n_done.fetch_add(1, std::memory_order_relaxed) + 1;
    progress.report("checking blocks", static_cast<double>(done) / static_cast<double>(n),
                    file_size());
  });
  if (progress.is_cancelled()) return cancelled_error();
  if (fault.error()) return *fault.error();
  return {};
}

}  // namespace lode::store
