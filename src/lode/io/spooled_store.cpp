#include "lode/io/spooled_store.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/packed_spool.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// Decoded at a time, so that bytes go to the spool while they are in the processor's cache.
constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

class SpooledStore final : public SampleStore {
 public:
  SpooledStore(ForwardSamples samples, PackedSpool spool)
      : samples_(std::move(samples)), spool_(std::move(spool)) {}

  Result<void> read(std::uint64_t offset, std::span<std::byte> out) override {
    LODE_EXPECTS(offset <= samples_.n_bytes && out.size() <= samples_.n_bytes - offset);
    const auto n_kept = static_cast<std::size_t>(
        std::min<std::uint64_t>(out.size(), spool_.size() - std::min(offset, spool_.size())));
    if (n_kept > 0) LODE_CHECK(spool_.read(offset, out.first(n_kept)));
    out = out.subspan(n_kept);
    if (out.empty()) return {};
    LODE_CHECK(skip_to(offset + n_kept));
    for (std::size_t done = 0; done < out.size(); done += kPieceBytes)
      LODE_CHECK(decode(out.subspan(done, std::min(out.size() - done, kPieceBytes))));
    return {};
  }

 private:
  /// Decodes and keeps what comes before `offset`.
  Result<void> skip_to(std::uint64_t offset) {
    std::vector<std::byte> sink;
    while (spool_.size() < offset) {
      const std::uint64_t n = std::min<std::uint64_t>(offset - spool_.size(), kPieceBytes);
      sink.resize(static_cast<std::size_t>(n));
      LODE_CHECK(decode(sink));
    }
    return {};
  }

  /// The next bytes. Once this failed the stream is somewhere in between and is left alone.
  Result<void> decode(std::span<std::byte> out) {
    if (failure_) return *failure_;
    auto status = decode_next(out);
    if (!status) failure_ = status.error();
    if (spool_.size() == samples_.n_bytes) samples_.stream.reset();
    return status;
  }

  Result<void> decode_next(std::span<std::byte> out) try {
    LODE_CHECK(samples_.stream->read(out));
    if (auto kept = spool_.append(out); !kept)
      return fail("{}: {}", samples_.path, kept.error().message);
    return {};
  } catch (const std::bad_alloc&) {
    failure_ = out_of_memory("decode the samples", samples_.path);
    throw;
  }

  ForwardSamples samples_;
  PackedSpool spool_;
  std::optional<Error> failure_;
};

}  // namespace

Result<std::unique_ptr<SampleStore>> make_spooled_store(ForwardSamples samples,
                                                        const SampleStorage& storage) {
  auto spool = PackedSpool::create(spool_directory_of(storage), samples.tally);
  if (!spool)
    return fail("{}: samples of {} exceed the memory limit of {} and need a spool file: {}",
                samples.path, format_bytes(samples.n_bytes), format_bytes(storage.memory_limit),
                spool.error().message);
  return std::unique_ptr<SampleStore>(
      std::make_unique<SpooledStore>(std::move(samples), std::move(*spool)));
}

}  // namespace lode::io
