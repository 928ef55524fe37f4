#include "lode/store/codec.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

#include "lode/store/elements.h"
#include "lode/store/rank_filter.h"

namespace lode::store {
namespace {

constexpr int kLevel = 3;
/// What is left after prediction is noise and runs of zeros: short matches that zstd finds in it
/// cost more than they save. With these instead of level 3 bonsai's blocks take 10 % less, in less
/// than half the time; docs/decisions/0015-layout.md.
constexpr int kResidualLevel = 1;
constexpr int kResidualMatch = 7;
constexpr int kResidualHashLog = 10;
/// Codecs are compared on this many elements, or some more; a block up to twice as long is
/// compressed whole by each.
constexpr std::size_t kTrialElements = 14336;
/// What precedes the frame of Codec::predicted_zstd, besides an element: flags and the grid.
constexpr std::size_t kGridBytes = 1 + 3 * sizeof(std::uint16_t);

struct ContextDeleter {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// Contexts are scratch memory: a frame depends on its input alone, whatever they did before.
ZSTD_CCtx* thread_compressor() {
  thread_local std::unique_ptr<ZSTD_CCtx, ContextDeleter> context;
  if (!context) context.reset(ZSTD_createCCtx());
  if (!context) throw std::bad_alloc();
  return context.get();
}

ZSTD_DCtx* thread_decompressor() {
  thread_local std::unique_ptr<ZSTD_DCtx, ContextDeleter> context;
  if (!context) context.reset(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  return context.get();
}

template <typename T>
void delta(std::span<const std::byte> raw, std::byte* out) {
  const std::size_t n = raw.size() / sizeof(T);
  if (n > 0) store_element(out, zigzag(load_element<T>(raw.data())));
  for (std::size_t i = 1; i < n; ++i) {
    const std::byte* at = raw.data() + i * sizeof(T);
    store_element(out + i * sizeof(T),
                  zigzag(static_cast<T>(load_element<T>(at) - load_element<T>(at - sizeof(T)))));
  }
}

template <typename T>
void undelta(std::span<std::byte> bytes) {
  T value = 0;
  for (std::size_t i = 0; i < bytes.size() / sizeof(T); ++i) {
    std::byte* at = bytes.data() + i * sizeof(T);
    value = static_cast<T>(value + unzigzag(load_element<T>(at)));
    store_element(at, value);
  }
}

/// Plane b holds byte b of every element.
template <typename T>
void shuffle(const std::byte* elements, std::size_t n, std::byte* planes) {
  for (std::size_t b = 0; b < sizeof(T); ++b)
    for (std::size_t i = 0; i < n; ++i)
      planes[b * n + i] =
          static_cast<std::byte>(load_element<T>(elements + i * sizeof(T)) >> (8 * b) & 0xFF);
}

template <typename T>
void unshuffle(const std::byte* planes, std::size_t n, std::byte* elements) {
  for (std::size_t i = 0; i < n; ++i) {
    T value = 0;
    for (std::size_t b = 0; b < sizeof(T); ++b)
      value = static_cast<T>(value | static_cast<T>(static_cast<T>(planes[b * n + i]) << (8 * b)));
    store_element(elements + i * sizeof(T), value);
  }
}

Result<void> check_frame(std::span<const std::byte> stored, std::uint64_t raw_size) {
  // The magic number first: old zstd formats are none of ours.
  if (stored.size() < 4 || load_element<std::uint32_t>(stored.data()) != ZSTD_MAGICNUMBER)
    return fail("expected a zstd frame, got {} other bytes", stored.size());
  const unsigned long long content = ZSTD_getFrameContentSize(stored.data(), stored.size());
  if (content != raw_size)
    return fail("expected a zstd frame of {} bytes, got one that says {}", raw_size,
                static_cast<long long>(content));
  return {};
}

/// The bytes that zstd sees. Those after the last whole element stay as they are.
std::vector<std::byte> filter(Codec codec, std::span<const std::byte> raw,
                              std::size_t element_size) {
  std::vector<std::byte> filtered(raw.begin(), raw.end());
  visit_element(element_size, [&]<typename T>(T) {
    const std::size_t n = raw.size() / sizeof(T);
    if (codec == Codec::shuffle_zstd) {
      shuffle<T>(raw.data(), n, filtered.data());
    } else if (sizeof(T) == 1) {
      delta<T>(raw, filtered.data());
    } else {
      std::vector<std::byte> differences(n * sizeof(T));
      delta<T>(raw, differences.data());
      shuffle<T>(differences.data(), n, filtered.data());
    }
  });
  return filtered;
}

void unfilter(Codec codec, std::span<const std::byte> filtered, std::size_t element_size,
              std::span<std::byte> out) {
  visit_element(element_size, [&]<typename T>(T) {
    const std::size_t n = out.size() / sizeof(T);
    unshuffle<T>(filtered.data(), n, out.data());
    std::ranges::copy(filtered.subspan(n * sizeof(T)), out.subspan(n * sizeof(T)).begin());
    if (codec == Codec::delta_zstd) undelta<T>(out);
  });
}

/// A frame of the thread's compressor, after `prefix`.
std::vector<std::byte> finish_frame(std::span<const std::byte> prefix,
                                    std::span<const std::byte> raw) {
  std::vector<std::byte> stored(prefix.size() + ZSTD_compressBound(raw.size()));
  std::ranges::copy(prefix, stored.begin());
  const std::size_t size = ZSTD_compress2(thread_compressor(), stored.data() + prefix.size(),
                                          stored.size() - prefix.size(), raw.data(), raw.size());
  // With a large enough output, running out of memory is the only way to fail.
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();
  stored.resize(prefix.size() + size);
  return stored;
}

void set_parameters(int level) {
  ZSTD_CCtx_reset(thread_compressor(), ZSTD_reset_session_and_parameters);
  ZSTD_CCtx_setParameter(thread_compressor(), ZSTD_c_compressionLevel, level);
}

std::vector<std::byte> compress_residuals(std::span<const std::byte> prefix,
                                          std::span<const std::byte> planes) {
  set_parameters(kResidualLevel);
  ZSTD_CCtx_setParameter(thread_compressor(), ZSTD_c_minMatch, kResidualMatch);
  ZSTD_CCtx_setParameter(thread_compressor(), ZSTD_c_hashLog, kResidualHashLog);
  return finish_frame(prefix, planes);
}

/// flags, grid and origin, then the frame.
std::vector<std::byte> compress_predicted(const BlockElements& block) {
  LODE_EXPECTS(block.grid && block.grid->n_elements() * block.size == block.raw.size());
  const std::uint64_t origin = find_origin(block.raw, block.size);
  std::array<std::byte, kGridBytes + sizeof(origin)> prefix{};
  prefix[0] = std::byte{block.grid->lacks_even_points};
  std::memcpy(prefix.data() + 1, block.grid->n.data(), kGridBytes - 1);
  std::memcpy(prefix.data() + kGridBytes, &origin, sizeof(origin));
  std::vector<std::byte> planes(block.raw.size());
  predict_grid(block.raw, block.size, *block.grid, origin, planes);
  return compress_residuals(std::span(prefix).first(kGridBytes + block.size), planes);
}

Result<void> decompress_predicted(std::size_t element_size, std::span<const std::byte> stored,
                                  std::span<std::byte> out) {
  const std::size_t n_prefix = kGridBytes + element_size;
  if (stored.size() < n_prefix) return fail("expected a grid, got {} bytes", stored.size());
  ElementGrid grid{.lacks_even_points = stored[0] == std::byte{1}};
  std::memcpy(grid.n.data(), stored.data() + 1, kGridBytes - 1);
  // Without points along one axis the others would be gone through for nothing.
  if (stored[0] > std::byte{1} || std::ranges::find(grid.n, 0) != grid.n.end() ||
      grid.n_elements() * element_size != out.size())
    return fail("expected a grid of {} bytes, got one of {} x {} x {} points", out.size(),
                grid.n[0], grid.n[1], grid.n[2]);
  std::uint64_t origin = 0;
  std::memcpy(&origin, stored.data() + kGridBytes, element_size);
  std::vector<std::byte> planes(out.size());
  LODE_CHECK(zstd_decompress(stored.subspan(n_prefix), planes));
  restore_grid(planes, element_size, grid, origin, out);
  return {};
}

/// How many values there are and how long their frame is, that, and the ranks; what predicting
/// alone makes where there are too many values.
EncodedBlock encode_ranked(const BlockElements& block) {
  const auto ranked =
      block.size >= sizeof(std::uint32_t) ? rank_elements(block.raw, block.size) : std::nullopt;
  if (!ranked) return encode_block_as(Codec::predicted_zstd, block);
  const auto values = zstd_compress(filter(Codec::delta_zstd, ranked->values, block.size));
  const std::array<std::uint32_t, 2> sizes{
      static_cast<std::uint32_t>(ranked->values.size() / block.size),
      static_cast<std::uint32_t>(values.size())};
  EncodedBlock encoded{
      Codec::ranked_zstd, static_cast<std::uint8_t>(block.size), block.raw.size(), {}};
  encoded.stored.resize(sizeof(sizes));
  std::memcpy(encoded.stored.data(), sizes.data(), sizeof(sizes));
  encoded.stored.insert(encoded.stored.end(), values.begin(), values.end());
  const auto ranks = compress_predicted({ranked->ranks, sizeof(std::uint16_t), block.grid});
  encoded.stored.insert(encoded.stored.end(), ranks.begin(), ranks.end());
  // Readers take no block to be smaller than zstd alone could make it.
  if (block.raw.size() / kMaxZstdRatio <= encoded.stored.size() &&
      encoded.stored.size() < block.raw.size())
    return encoded;
  return encode_block_as(Codec::zstd, block);
}

Result<void> decompress_ranked(std::size_t element_size, std::span<const std::byte> stored,
                               std::span<std::byte> out) {
  std::array<std::uint32_t, 2> sizes{};
  if (stored.size() < sizeof(sizes)) return fail("expected values, got {} bytes", stored.size());
  std::memcpy(sizes.data(), stored.data(), sizeof(sizes));
  stored = stored.subspan(sizeof(sizes));
  constexpr std::size_t kMostValues = 65536;
  const std::size_t n_most = std::min(out.size() / element_size, kMostValues);
  if (sizes[0] > n_most || sizes[1] > stored.size())
    return fail("expected at most {} values in {} bytes, got {} in {}", n_most, stored.size(),
                sizes[0], sizes[1]);
  RankedElements ranked{std::vector<std::byte>(sizes[0] * element_size),
                        std::vector<std::byte>(out.size() / element_size * sizeof(std::uint16_t))};
  LODE_CHECK(decode_block(Codec::delta_zstd, element_size, stored.first(sizes[1]), ranked.values));
  LODE_CHECK(decompress_predicted(sizeof(std::uint16_t), stored.subspan(sizes[1]), ranked.ranks));
  if (out.size() % element_size != 0 || !restore_ranked(ranked, element_size, out))
    return fail("expected ranks below {}, got others", sizes[0]);
  return {};
}

std::vector<std::byte> compress_as(Codec codec, const BlockElements& block) {
  if (codec == Codec::zstd) return zstd_compress(block.raw);
  if (codec == Codec::predicted_zstd) return compress_predicted(block);
  return zstd_compress(filter(codec, block.raw, block.size));
}

/// Whole elements from the middle of the block, where a model's samples are typical; of a grid
/// whole planes (rows of a plane), from an even one, so that they are a grid themselves.
BlockElements trial_part(const BlockElements& block) {
  const std::size_t n = block.raw.size() / block.size;
  if (n <= 2 * kTrialElements) return block;
  if (!block.grid) {
    const std::size_t start = (n - kTrialElements) / 2;
    return {block.raw.subspan(start * block.size, kTrialElements * block.size), block.size, {}};
  }
  ElementGrid part = *block.grid;
  const std::size_t axis = part.n[2] > 1 ? 2 : 1;
  const std::size_t n_slices = block.grid->n[axis];
  const std::size_t n_wanted = (kTrialElements * n_slices / n + 3) / 2 * 2;
  if (n_wanted >= n_slices) return block;
  part.n[axis] = static_cast<std::uint16_t>((n_slices - n_wanted) / 4 * 2);
  const std::size_t start = part.n_elements() * block.size;
  part.n[axis] = static_cast<std::uint16_t>(n_wanted);
  return {block.raw.subspan(start, part.n_elements() * block.size), block.size, part};
}

std::vector<Codec> candidates(const BlockElements& block) {
  std::vector<Codec> codecs{Codec::zstd, block.grid ? Codec::predicted_zstd : Codec::delta_zstd};
  if (block.size > 1) codecs.push_back(Codec::shuffle_zstd);
  if (block.grid && block.size >= sizeof(std::uint32_t)) codecs.push_back(Codec::ranked_zstd);
  return codecs;
}

}  // namespace

std::vector<std::byte> zstd_compress(std::span<const std::byte> raw) {
  set_parameters(kLevel);
  return finish_frame({}, raw);
}

Result<void> zstd_decompress(std::span<const std::byte> stored, std::span<std::byte> out) {
  LODE_CHECK(check_frame(stored, out.size()));
  const std::size_t size = ZSTD_decompressDCtx(thread_decompressor(), out.data(), out.size(),
                                               stored.data(), stored.size());
  if (ZSTD_isError(size) != 0)
    return fail("expected a valid zstd frame, got: {}", ZSTD_getErrorName(size));
  if (size != out.size()) return fail("expected {} decoded bytes, got {}", out.size(), size);
  return {};
}

Result<std::size_t> zstd_decompress_start(std::span<const std::byte> stored, std::uint64_t raw_size,
                                          std::span<std::byte> out) {
  LODE_CHECK(check_frame(stored, raw_size));
  // Of its own, as it keeps a window as large as raw_size, or what the frame says.
  const std::unique_ptr<ZSTD_DCtx, ContextDeleter> context(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  ZSTD_inBuffer in{stored.data(), stored.size(), 0};
  ZSTD_outBuffer start{out.data(), out.size(), 0};
  while (start.pos < start.size) {
    const std::size_t n_before = in.pos + start.pos;
    const std::size_t status = ZSTD_decompressStream(context.get(), &start, &in);
    if (ZSTD_isError(status) != 0)
      return fail("expected a valid zstd frame, got: {}", ZSTD_getErrorName(status));
    if (status == 0 || in.pos + start.pos == n_before) break;
  }
  return start.pos;
}

EncodedBlock encode_block_as(Codec codec, const BlockElements& block) {
  LODE_EXPECTS(is_element_size(block.size) && block.raw.size() <= kMaxBlockBytes);
  if (codec == Codec::ranked_zstd) return encode_ranked(block);
  EncodedBlock encoded{codec, static_cast<std::uint8_t>(block.size), block.raw.size(), {}};
  if (codec != Codec::none) encoded.stored = compress_as(codec, block);
  if (codec == Codec::none || encoded.stored.size() >= block.raw.size()) {
    encoded.codec = Codec::none;
    encoded.stored.assign(block.raw.begin(), block.raw.end());
  }
  // The compressor's bound is larger than the block; many blocks wait for the writer at once.
  encoded.stored.shrink_to_fit();
  return encoded;
}

EncodedBlock encode_block(const BlockElements& block) {
  LODE_EXPECTS(is_element_size(block.size) && block.raw.size() <= kMaxBlockBytes);
  const BlockElements trial = trial_part(block);
  EncodedBlock best;
  for (const Codec codec : candidates(trial)) {
    EncodedBlock encoded = encode_block_as(codec, trial);
    if (best.raw_size == 0 || encoded.stored.size() < best.stored.size()) best = std::move(encoded);
  }
  if (trial.raw.size() == block.raw.size()) {
    best.element_size = static_cast<std::uint8_t>(block.size);
    return best;
  }
  return encode_block_as(best.codec, block);
}

Result<void> decode_block(Codec codec, std::size_t element_size, std::span<const std::byte> stored,
                          std::span<std::byte> out) {
  if (!is_element_size(element_size))
    return fail("expected elements of 1, 2, 4 or 8 bytes, got {}", element_size);
  switch (codec) {
    case Codec::none:
      if (stored.size() != out.size())
        return fail("expected {} uncompressed bytes, got {}", out.size(), stored.size());
      std::ranges::copy(stored, out.begin());
      return {};
    case Codec::zstd: return zstd_decompress(stored, out);
    case Codec::predicted_zstd: return decompress_predicted(element_size, stored, out);
    case Codec::ranked_zstd: return decompress_ranked(element_size, stored, out);
    case Codec::shuffle_zstd:
    case Codec::delta_zstd: break;
    default: return fail("expected codec 0 to {}, got {}", kLastCodec, static_cast<int>(codec));
  }
  std::vector<std::byte> filtered(out.size());
  LODE_CHECK(zstd_decompress(stored, filtered));
  unfilter(codec, filtered, element_size, out);
  return {};
}

}  // namespace lode::store
