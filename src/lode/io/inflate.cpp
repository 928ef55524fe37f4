#include "lode/io/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <utility>

namespace lode::io {
namespace {

constexpr std::uint64_t kMaxRatio = 1032;
/// zlib: largest window, and gzip or zlib as the first bytes say.
constexpr int kAnyWrapper = 15 + 32;

std::string zlib_message(const z_stream& stream) {
  return stream.msg != nullptr ? stream.msg : "not zlib or gzip data";
}

/// Hides what comes before and notices what comes behind.
class ExactInflateStream final : public ByteStream {
 public:
  ExactInflateStream(std::unique_ptr<ByteStream> compressed, std::string path,
                     std::uint64_t n_skipped, std::uint64_t n_bytes)
      : stream_(std::move(compressed), path),
        path_(std::move(path)),
        n_skipped_(n_skipped),
        n_bytes_(n_bytes) {}

  Result<void> read(std::span<std::byte> out) override {
    LODE_EXPECTS(out.size() <= n_left());
    LODE_CHECK(stream_.skip(std::exchange(n_skipped_, 0)));
    LODE_TRY(const std::size_t n, stream_.read_some(out));
    n_done_ += n;
    if (n < out.size())
      return fail("{}: expected {} bytes of samples, the compressed data hold {}", path_, n_bytes_,
                  n_done_);
    return n_done_ == n_bytes_ ? check_end() : Result<void>();
  }

  std::uint64_t n_left() const override { return n_bytes_ - n_done_; }

 private:
  Result<void> check_end() {
    std::array<std::byte, 1> extra;
    LODE_TRY(const std::size_t n_extra, stream_.read_some(extra));
    if (n_extra == 0) return {};
    return fail("{}: expected {} bytes of samples, the compressed data hold more", path_, n_bytes_);
  }

  InflateStream stream_;
  std::string path_;
  std::uint64_t n_skipped_;
  std::uint64_t n_bytes_;
  std::uint64_t n_done_ = 0;
};

}  // namespace

struct InflateStream::State {
  z_stream stream{};
  bool is_ready = false;
  bool is_finished = false;
  std::vector<std::byte> input;
};

Result<void> check_inflated_size(const std::string& path, std::uint64_t n_bytes,
                                 std::uint64_t n_compressed) {
  if (n_bytes / kMaxRatio <= n_compressed) return {};
  return fail("{}: the header promises {} bytes, more than {} compressed bytes can hold", path,
              n_bytes, n_compressed);
}

InflateStream::InflateStream(std::unique_ptr<ByteStream> compressed, std::string path)
    : compressed_(std::move(compressed)),
      path_(std::move(path)),
      state_(std::make_unique<State>()) {
  const int status = inflateInit2(&state_->stream, kAnyWrapper);
  if (status == Z_MEM_ERROR) throw std::bad_alloc();
  state_->is_ready = status == Z_OK;
}

InflateStream::~InflateStream() {
  if (state_->is_ready) inflateEnd(&state_->stream);
}

std::uint64_t InflateStream::n_left() const {
  if (state_->is_finished) return 0;
  const std::uint64_t n_compressed = compressed_->n_left() + state_->stream.avail_in + 64;
  return n_compressed < std::numeric_limits<std::uint64_t>::max() / kMaxRatio
             ? n_compressed * kMaxRatio
             : std::numeric_limits<std::uint64_t>::max();
}

Result<void> InflateStream::refill() {
  constexpr std::uint64_t kChunk = 1 << 18;
  state_->input.resize(static_cast<std::size_t>(std::min(kChunk, compressed_->n_left())));
  LODE_CHECK(compressed_->read(state_->input));
  state_->stream.next_in = reinterpret_cast<Bytef*>(state_->input.data());
  state_->stream.avail_in = static_cast<uInt>(state_->input.size());
  return {};
}

/// One call of inflate; a finished member that another one follows starts the next.
Result<void> InflateStream::step() {
  z_stream& stream = state_->stream;
  if (stream.avail_in == 0) LODE_CHECK(refill());
  if (stream.avail_in == 0) return fail("{}: the compressed data end too early", path_);
  const int status = inflate(&stream, Z_NO_FLUSH);
  if (status == Z_STREAM_END) {
    if (stream.avail_in == 0) LODE_CHECK(refill());
    constexpr Bytef kGzipMagic = 0x1f;
    if (stream.avail_in > 0 && *stream.next_in == kGzipMagic)
      inflateReset(&stream);
    else
      state_->is_finished = true;
    return {};
  }
  if (status == Z_OK || status == Z_BUF_ERROR) return {};
  if (status == Z_MEM_ERROR) throw std::bad_alloc();
  return fail("{}: the compressed data are damaged: {}", path_, zlib_message(stream));
}

Result<std::size_t> InflateStream::read_some(std::span<std::byte> out) {
  if (!state_->is_ready) return fail("{}: zlib could not start", path_);
  std::size_t done = 0;
  while (done < out.size() && !state_->is_finished) {
    constexpr std::size_t kMaxPiece = std::size_t{1} << 30;
    const std::size_t piece = std::min(out.size() - done, kMaxPiece);
    state_->stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    state_->stream.avail_out = static_cast<uInt>(piece);
    LODE_CHECK(step());
    done += piece - state_->stream.avail_out;
  }
  return done;
}

Result<void> InflateStream::read(std::span<std::byte> out) {
  LODE_TRY(const std::size_t n, read_some(out));
  if (n == out.size()) return {};
  return fail("{}: the compressed data hold fewer bytes than expected: {} of {} more", path_, n,
              out.size());
}

std::unique_ptr<ByteStream> make_exact_inflate_stream(std::unique_ptr<ByteStream> compressed,
                                                      std::string path, std::uint64_t n_skipped,
                                                      std::uint64_t n_bytes) {
  return std::make_unique<ExactInflateStream>(std::move(compressed), std::move(path), n_skipped,
                                              n_bytes);
}

Result<std::vector<std::byte>> read_promised(ByteStream& stream, std::uint64_t n_bytes) {
  constexpr std::uint64_t kFirstPiece = std::uint64_t{16} << 20;
  std::vector<std::byte> bytes;
  while (bytes.size() < n_bytes) {
    const std::size_t done = bytes.size();
    const auto target =
        static_cast<std::size_t>(std::min(n_bytes, std::max<std::uint64_t>(kFirstPiece, 2 * done)));
    bytes.reserve(target);  // resize alone may take twice as much
    bytes.resize(target);
    LODE_CHECK(stream.read(std::span(bytes).subspan(done)));
  }
  return bytes;
}

Result<void> inflate_block(std::span<const std::byte> compressed, const std::string& path,
                           std::span<std::byte> out) {
  auto source = make_memory_stream(
      {reinterpret_cast<const char*>(compressed.data()), compressed.size()}, path);
  InflateStream stream(std::move(source), path);
  LODE_TRY(const std::size_t n, stream.read_some(out));
  std::array<std::byte, 1> extra;
  LODE_TRY(const std::size_t n_extra, stream.read_some(extra));
  if (n == out.size() && n_extra == 0) return {};
  return fail("{}: expected a compressed block of {} bytes, got {} bytes", path, out.size(),
              n_extra == 0 ? fmt::format("{}", n) : "more");
}

}  // namespace lode::io
