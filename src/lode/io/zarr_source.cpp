#include "lode/io/zarr_source.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <optional>

#include "lode/core/out_of_memory.h"
#include "lode/io/chunk_cache.h"
#include "lode/io/zarr_chunk_reader.h"

namespace lode::io {
namespace {

/// `lode info` of 512 x 512 x 384 uint16 samples in gzip chunks of 64 x 64 x 64, which reads slabs
/// of 16 slices, takes 1.4 s with room for a layer of chunks and 4.8 s without any.
constexpr std::size_t kMinCacheBytes = std::size_t{64} << 20;
constexpr std::size_t kMaxCacheBytes = std::size_t{1} << 30;

/// The error of the lowest index, whichever thread comes first.
class FirstError {
 public:
  /// Whether work at `i` can no longer matter.
  [[nodiscard]] bool is_before(std::size_t i) const { return first_ < i; }
  void set(std::size_t i, const Error& error) {
    const std::lock_guard lock(mutex_);
    if (i >= first_) return;
    first_ = i;
    error_ = error;
  }
  [[nodiscard]] Result<void> result() const {
    if (error_) return *error_;
    return {};
  }

 private:
  std::mutex mutex_;
  std::atomic<std::size_t> first_{std::numeric_limits<std::size_t>::max()};
  std::optional<Error> error_;
};

/// Indices lower <= i < upper along each axis of an array.
struct Region {
  ZarrShape lower;
  ZarrShape upper;

  [[nodiscard]] std::size_t rank() const { return lower.size(); }
  /// How many there are along the k-th axis from the back, where x is the 0th; 1 beyond the front.
  [[nodiscard]] std::int64_t count_from_back(std::size_t k) const {
    return k < rank() ? upper[rank() - 1 - k] - lower[rank() - 1 - k] : 1;
  }
};

Region intersection_of(const Region& a, const Region& b) {
  Region both = a;
  for (std::size_t axis = 0; axis < a.rank(); ++axis) {
    both.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
    both.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
  }
  return both;
}

/// Where a region's first sample lies among those of another that holds it, and the distances from
/// there along y and z; all in samples.
struct Placement {
  std::int64_t first = 0;
  std::int64_t y_stride = 0;
  std::int64_t z_stride = 0;
};

Placement placement_in(const Region& whole, const Region& part) {
  Placement placement;
  std::int64_t stride = 1;
  for (std::size_t k = 0; k < whole.rank(); ++k) {
    const std::size_t axis = whole.rank() - 1 - k;
    placement.first += (part.lower[axis] - whole.lower[axis]) * stride;
    if (k == 1) placement.y_stride = stride;
    if (k == 2) placement.z_stride = stride;
    stride *= whole.count_from_back(k);
  }
  return placement;
}

class ZarrSource final : public VolumeSource {
 public:
  ZarrSource(ZarrView view, VolumeInfo info, Threads threads, std::size_t max_cache_bytes)
      : info_(std::move(info)),
        place_(std::move(view.place)),
        reader_(std::move(view.array)),
        threads_(threads),
        holds_all_(all_bytes() <= static_cast<double>(most_for_all(max_cache_bytes))),
        cache_bytes_(holds_all_ ? static_cast<std::size_t>(all_bytes())
                                : std::min(layer_bytes(), max_cache_bytes)),
        cache_(cache_bytes_) {}

  const VolumeInfo& info() const override { return info_; }
  IoCounts io() const override {
    return {.n_file_bytes_read = reader_.tally().n_file_bytes_read,
            .n_spool_bytes_written = 0,
            .n_spool_bytes_read = 0};
  }

  std::uint64_t memory_bytes() const override { return cache_bytes_; }

  ReadUnit read_unit() const override {
    if (holds_all_) return {};
    const ZarrShape& shape = reader_.chunk_shape();
    ReadUnit unit{.dims = {{1, 1, 1}},
                  .stored_share = reader_.stored_share(),
                  .decoded_bytes = static_cast<std::uint64_t>(product_of(shape)) *
                                   size_of(reader_.array().type)};
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      if (axis < place_.size())  // of which one place is wanted
        unit.stored_share *= static_cast<double>(shape[axis]);
      else
        unit.dims[shape.size() - 1 - axis] = static_cast<std::int32_t>(
            std::min<std::int64_t>(shape[axis], std::numeric_limits<std::int32_t>::max()));
    }
    return unit;
  }

  Result<void> read(const IndexBox& box, std::span<std::byte> out) override try {
    LODE_EXPECTS(info_.grid.index_box().contains(box));
    LODE_EXPECTS(out.size() == static_cast<std::size_t>(box.n_samples()) * size_of(info_.type));
    if (box.is_empty()) return {};
    const Region region = region_of(box);
    const ZarrShape& shape = reader_.chunk_shape();
    Region chunks = region;
    std::size_t n_chunks = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      chunks.lower[axis] = region.lower[axis] / shape[axis];
      chunks.upper[axis] = (region.upper[axis] - 1) / shape[axis] + 1;
      n_chunks *= static_cast<std::size_t>(chunks.upper[axis] - chunks.lower[axis]);
    }
    cache_.begin_read();
    FirstError error;
    parallel_for(n_chunks, threads_, 1, [&](std::size_t i, int /*worker*/) {
      if (error.is_before(i)) return;
      if (auto status = put_chunk(chunk_at(chunks, i), region, out); !status)
        error.set(i, status.error());
    });
    return error.result();
  } catch (const std::bad_alloc&) {
    return out_of_memory("read samples", reader_.array().path);
  }

 private:
  /// Without a limit from outside no more than for a layer.
  static std::size_t most_for_all(std::size_t max_cache_bytes) {
    return max_cache_bytes == std::numeric_limits<std::size_t>::max() ? kMaxCacheBytes
                                                                      : max_cache_bytes;
  }

  /// What all chunks of the view take.
  double all_bytes() const {
    const ZarrArray& array = reader_.array();
    const ZarrShape& shape = reader_.chunk_shape();
    double n_bytes =
        static_cast<double>(product_of(shape)) * static_cast<double>(size_of(array.type));
    for (std::size_t axis = place_.size(); axis < shape.size(); ++axis) {
      const std::int64_t n_chunks = (array.shape[axis] - 1) / shape[axis] + 1;
      n_bytes *= static_cast<double>(n_chunks);
    }
    return n_bytes;
  }

  /// What one layer of chunks takes, so that slab after slab decodes each chunk once.
  std::size_t layer_bytes() const {
    const ZarrArray& array = reader_.array();
    const ZarrShape& shape = reader_.chunk_shape();
    double n_bytes =
        static_cast<double>(product_of(shape)) * static_cast<double>(size_of(array.type));
    for (std::size_t axis = shape.size() - 2; axis < shape.size(); ++axis) {
      const std::int64_t n_chunks = (array.shape[axis] - 1) / shape[axis] + 1;
      n_bytes *= static_cast<double>(n_chunks);
    }
    return static_cast<std::size_t>(std::clamp(n_bytes, static_cast<double>(kMinCacheBytes),
                                               static_cast<double>(kMaxCacheBytes)));
  }

  Region region_of(const IndexBox& box) const {
    const std::size_t rank = reader_.array().shape.size();
    Region region{place_, place_};
    for (std::int64_t& upper : region.upper) ++upper;
    for (std::size_t k = rank - place_.size(); k > 0; --k) {
      region.lower.push_back(box.lower[k - 1]);
      region.upper.push_back(box.upper[k - 1]);
    }
    return region;
  }

  static ZarrShape chunk_at(const Region& chunks, std::size_t i) {
    ZarrShape chunk = chunks.lower;
    auto rest = static_cast<std::int64_t>(i);
    for (std::size_t k = 0; k < chunks.rank(); ++k) {
      chunk[chunks.rank() - 1 - k] += rest % chunks.count_from_back(k);
      rest /= chunks.count_from_back(k);
    }
    return chunk;
  }

  std::int64_t number_of(const ZarrShape& chunk) const {
    std::int64_t number = 0;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      const std::int64_t size = reader_.chunk_shape()[axis];
      number = number * ((reader_.array().shape[axis] - 1) / size + 1) + chunk[axis];
    }
    return number;
  }

  /// Whether a read of the next box in z, or beside this one, will want the chunk again.
  bool is_wanted_again(const Region& covered, const Region& region) const {
    if (holds_all_) return true;
    const std::size_t slowest = place_.size();
    for (std::size_t axis = slowest + 1; axis < region.rank(); ++axis) {
      const std::int64_t end = std::min(covered.upper[axis], reader_.array().shape[axis]);
      if (end > region.upper[axis] || covered.lower[axis] < region.lower[axis]) return true;
    }
    return covered.upper[slowest] > region.upper[slowest];
  }

  Result<void> put_chunk(const ZarrShape& chunk, const Region& region, std::span<std::byte> out) {
    Region covered;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      covered.lower.push_back(chunk[axis] * reader_.chunk_shape()[axis]);
      covered.upper.push_back(covered.lower.back() + reader_.chunk_shape()[axis]);
    }
    const std::int64_t number = number_of(chunk);
    ChunkCache::Bytes samples = cache_.find(number);
    if (samples == nullptr) {
      LODE_TRY(samples, reader_.read(chunk));
      if (samples != nullptr && is_wanted_again(covered, region)) cache_.add(number, samples);
    }
    copy_rows(samples.get(), covered, region, out);
    return {};
  }

  void copy_rows(const std::vector<std::byte>* samples, const Region& covered, const Region& region,
                 std::span<std::byte> out) const {
    const std::size_t size = size_of(info_.type);
    const Region part = intersection_of(covered, region);
    const Placement from = placement_in(covered, part);
    const Placement to = placement_in(region, part);
    const auto row = static_cast<std::size_t>(part.count_from_back(0));
    for (std::int64_t z = 0; z < n_slices(part); ++z)
      for (std::int64_t y = 0; y < part.count_from_back(1); ++y) {
        const auto first = static_cast<std::size_t>(to.first + z * to.z_stride + y * to.y_stride);
        const std::span<std::byte> row_out = out.subspan(first * size, row * size);
        if (samples == nullptr) {
          fill_row(row_out);
          continue;
        }
        const auto at =
            static_cast<std::size_t>(from.first + z * from.z_stride + y * from.y_stride);
        std::memcpy(row_out.data(), samples->data() + at * size, row_out.size());
      }
  }

  std::int64_t n_slices(const Region& part) const {
    return part.rank() - place_.size() > 2 ? part.count_from_back(2) : 1;
  }

  void fill_row(std::span<std::byte> row) const {
    const std::size_t size = size_of(info_.type);
    for (std::size_t i = 0; i < row.size(); i += size)
      std::memcpy(row.data() + i, reader_.array().fill.data(), size);
  }

  VolumeInfo info_;
  ZarrShape place_;
  ZarrChunkReader reader_;
  Threads threads_;
  bool holds_all_;  ///< All chunks, once they are decoded.
  std::size_t cache_bytes_;
  ChunkCache cache_;
};

}  // namespace

std::unique_ptr<VolumeSource> make_zarr_source(ZarrView view, VolumeInfo info, Threads threads,
                                               std::size_t max_cache_bytes) {
  return std::make_unique<ZarrSource>(std::move(view), std::move(info), threads, max_cache_bytes);
}

}  // namespace lode::io
