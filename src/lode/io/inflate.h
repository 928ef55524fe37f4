#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"

namespace lode::io {

/// Fails when deflate, which cannot do better than 1032 to 1, cannot make `n_bytes` out of
/// `n_compressed`: called before anything of that size is allocated.
[[nodiscard]] Result<void> check_inflated_size(const std::string& path, std::uint64_t n_bytes,
                                               std::uint64_t n_compressed);

/// What zlib or gzip data (one member or several) expand to, as a stream. n_left() is deflate's
/// upper bound. `compressed` and `path` serve as source and name in messages.
class InflateStream final : public ByteStream {
 public:
  InflateStream(std::unique_ptr<ByteStream> compressed, std::string path);
  ~InflateStream() override;

  [[nodiscard]] Result<void> read(std::span<std::byte> out) override;
  [[nodiscard]] std::uint64_t n_left() const override;
  /// Reads up to out.size() bytes; fewer only at the end of the data.
  [[nodiscard]] Result<std::size_t> read_some(std::span<std::byte> out);

 private:
  struct State;
  [[nodiscard]] Result<void> refill();
  [[nodiscard]] Result<void> step();

  std::unique_ptr<ByteStream> compressed_;
  std::string path_;
  std::unique_ptr<State> state_;
};

/// The `n_bytes` that follow `n_skipped` others in what `compressed` expands to, and end it: the
/// read of the last one fails when there are more, or when the checksum says so.
[[nodiscard]] std::unique_ptr<ByteStream> make_exact_inflate_stream(
    std::unique_ptr<ByteStream> compressed, std::string path, std::uint64_t n_skipped,
    std::uint64_t n_bytes);

/// Reads `n_bytes` that a header promised, taking memory as they come: what is there at most
/// doubles.
[[nodiscard]] Result<std::vector<std::byte>> read_promised(ByteStream& stream,
                                                           std::uint64_t n_bytes);

/// Inflates one zlib block in memory to exactly out.size() bytes.
[[nodiscard]] Result<void> inflate_block(std::span<const std::byte> compressed,
                                         const std::string& path, std::span<std::byte> out);

}  // namespace lode::io
