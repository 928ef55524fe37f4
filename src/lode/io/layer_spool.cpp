#include "lode/io/layer_spool.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <new>
#include <system_error>
#include <utility>

#include "lode/core/out_of_memory.h"

namespace lode::io {
namespace {

constexpr std::size_t kBytesPerRead = std::size_t{4} << 20;

double bytes_of(const VolumeInfo& info, const Index3& dims) {
  double n_bytes = static_cast<double>(size_of(info.type));
  for (std::size_t i = 0; i < 3; ++i)
    n_bytes *= static_cast<double>(std::min(dims[i], info.grid.dims[i]));
  return n_bytes;
}

double decoded_bytes(const VolumeInfo& info, const ReadUnit& unit) {
  return std::max(bytes_of(info, unit.dims), static_cast<double>(unit.decoded_bytes));
}

/// As many units along x, then y, as `max_bytes` hold together; at least one.
Index3 tile_of(const VolumeInfo& info, const ReadUnit& unit, double max_bytes) {
  Index3 tile = unit.dims;
  double n_bytes = decoded_bytes(info, unit);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const std::int32_t most = (info.grid.dims[axis] - 1) / unit.dims[axis] + 1;
    const double n = std::clamp(std::floor(max_bytes / n_bytes), 1.0, static_cast<double>(most));
    const double size = n * static_cast<double>(unit.dims[axis]);
    tile[axis] = static_cast<std::int32_t>(
        std::min(size, static_cast<double>(std::numeric_limits<std::int32_t>::max())));
    n_bytes *= n;
  }
  return tile;
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> LayerSpool::wrap(std::unique_ptr<VolumeSource> source,
                                                       const std::string& directory) {
  const VolumeInfo& info = source->info();
  const ReadUnit unit = source->read_unit();
  const auto held = static_cast<double>(source->memory_bytes());
  const Index3 tile = tile_of(info, unit, held);
  const bool is_layer = tile[0] >= info.grid.dims[0] && tile[1] >= info.grid.dims[1];
  const bool holds_layer = is_layer && decoded_bytes(info, unit) <= held;
  if (holds_layer || std::min(unit.dims[2], info.grid.dims[2]) == 1) return source;
  auto tally = std::make_shared<IoTally>();
  LODE_TRY(PackedSpool spool, PackedSpool::create(directory, tally));
  return std::unique_ptr<VolumeSource>(
      new LayerSpool(std::move(source), tile, directory, std::move(spool), std::move(tally)));
}

/// A unit that the source cannot hold is decoded once where all of it is read at a time.
LayerSpool::LayerSpool(std::unique_ptr<VolumeSource> source, const Index3& tile,
                       std::string directory, PackedSpool spool, IoTallyPtr tally)
    : source_(std::move(source)),
      tile_(tile),
      directory_(std::move(directory)),
      spool_(std::move(spool)),
      tally_(std::move(tally)) {
  const ReadUnit unit = source_->read_unit();
  const auto held = static_cast<double>(source_->memory_bytes());
  const double slice = bytes_of(info(), {{tile_[0], tile_[1], 1}});
  const double n = std::max(1.0, std::floor(static_cast<double>(kBytesPerRead) / slice));
  n_slices_ =
      decoded_bytes(info(), unit) > held || n > tile_[2] ? tile_[2] : static_cast<std::int32_t>(n);
}

IoCounts LayerSpool::io() const {
  IoCounts counts = source_->io();
  counts.n_spool_bytes_written += tally_->n_spool_bytes_written;
  counts.n_spool_bytes_read += tally_->n_spool_bytes_read;
  return counts;
}

/// With the slices that are read at a time.
std::uint64_t LayerSpool::memory_bytes() const {
  const double slices = bytes_of(info(), {{tile_[0], tile_[1], n_slices_}});
  return source_->memory_bytes() + static_cast<std::uint64_t>(slices);
}

Result<void> LayerSpool::read(const IndexBox& box, std::span<std::byte> out) try {
  if (box.is_empty()) return {};
  const auto n_bytes = static_cast<std::size_t>(box.n_samples()) * sample_size();
  const std::size_t slice_bytes = n_bytes / static_cast<std::size_t>(box.upper[2] - box.lower[2]);
  for (std::int32_t z = box.lower[2]; z < box.upper[2];) {
    const std::int32_t layer = z / tile_[2];
    IndexBox part = box;
    part.lower[2] = z;
    z += std::min(box.upper[2] - z, tile_[2] - z % tile_[2]);
    part.upper[2] = z;
    const std::span<std::byte> part_out =
        out.subspan(static_cast<std::size_t>(part.lower[2] - box.lower[2]) * slice_bytes,
                    static_cast<std::size_t>(z - part.lower[2]) * slice_bytes);
    LODE_TRY(const std::vector<std::uint64_t>* const begins, spool_layer(layer));
    if (begins == nullptr) {
      LODE_CHECK(source_->read(part, part_out));
      continue;
    }
    const std::vector<IndexBox> tiles = tiles_of(layer);
    for (std::size_t i = 0; i < tiles.size(); ++i)
      LODE_CHECK(read_tile(tiles[i], (*begins)[i], part, part_out));
  }
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("read layers of samples");
}

std::vector<IndexBox> LayerSpool::tiles_of(std::int32_t layer) const {
  const Index3& dims = info().grid.dims;
  std::vector<IndexBox> tiles;
  IndexBox tile;
  tile.lower[2] = layer * tile_[2];
  for (std::int64_t y = 0; y < dims[1]; y += tile_[1])
    for (std::int64_t x = 0; x < dims[0]; x += tile_[0]) {
      tile.lower[0] = static_cast<std::int32_t>(x);
      tile.lower[1] = static_cast<std::int32_t>(y);
      for (std::size_t i = 0; i < 3; ++i)
        tile.upper[i] = dims[i] - tile.lower[i] > tile_[i] ? tile.lower[i] + tile_[i] : dims[i];
      tiles.push_back(tile);
    }
  return tiles;
}

Result<const std::vector<std::uint64_t>*> LayerSpool::spool_layer(std::int32_t layer) {
  if (!spool_) return nullptr;
  if (const auto found = tiles_.find(layer); found != tiles_.end()) return &found->second;
  std::vector<std::uint64_t> begins;
  for (const IndexBox& tile : tiles_of(layer)) {
    begins.push_back(spool_->size());
    LODE_TRY(const bool has_room, spool_tile(tile));
    if (has_room && leaves_room()) continue;
    spool_.reset();
    tiles_.clear();
    return nullptr;
  }
  return &tiles_.emplace(layer, std::move(begins)).first->second;
}

/// A few slices at a time: the source keeps the units that the next ones want.
Result<bool> LayerSpool::spool_tile(const IndexBox& tile) {
  IndexBox slab = tile;
  slab.upper[2] = slab.lower[2] + 1;
  const std::size_t slice = static_cast<std::size_t>(slab.n_samples()) * sample_size();
  for (; slab.lower[2] < tile.upper[2]; slab.lower[2] = slab.upper[2]) {
    if (progress_ != nullptr && progress_->is_cancelled()) return cancelled_error();
    slab.upper[2] =
        n_slices_ < tile.upper[2] - slab.lower[2] ? slab.lower[2] + n_slices_ : tile.upper[2];
    buffer_.resize(slice * static_cast<std::size_t>(slab.upper[2] - slab.lower[2]));
    LODE_CHECK(source_->read(slab, buffer_));
    if (!spool_->append(buffer_)) return false;
  }
  return true;
}

/// For twice what is spooled: a file with the same samples and errors takes less.
bool LayerSpool::leaves_room() const {
  std::error_code error;
  const auto space = std::filesystem::space(directory_, error);
  return error || space.available / 2 >= spool_->n_packed_bytes();
}

/// What a tile has of the box.
Result<void> LayerSpool::read_tile(const IndexBox& tile, std::uint64_t begin, const IndexBox& box,
                                   std::span<std::byte> out) {
  IndexBox part;
  for (std::size_t i = 0; i < 3; ++i) {
    part.lower[i] = std::max(tile.lower[i], box.lower[i]);
    part.upper[i] = std::min(tile.upper[i], box.upper[i]);
    if (part.lower[i] >= part.upper[i]) return {};
  }
  const auto place_in = [&](const IndexBox& whole, std::int32_t y, std::int32_t z) {
    const auto n_x = static_cast<std::uint64_t>(whole.upper[0] - whole.lower[0]);
    const auto n_y = static_cast<std::uint64_t>(whole.upper[1] - whole.lower[1]);
    const std::uint64_t row = static_cast<std::uint64_t>(z - whole.lower[2]) * n_y +
                              static_cast<std::uint64_t>(y - whole.lower[1]);
    return (row * n_x + static_cast<std::uint64_t>(part.lower[0] - whole.lower[0])) * sample_size();
  };
  const std::size_t row = static_cast<std::size_t>(part.upper[0] - part.lower[0]) * sample_size();
  const auto n_rows = static_cast<std::size_t>(part.upper[1] - part.lower[1]);
  const bool are_joined = part.lower[0] == tile.lower[0] && part.upper[0] == tile.upper[0] &&
                          part.lower[0] == box.lower[0] && part.upper[0] == box.upper[0];
  const std::size_t n_together = are_joined ? n_rows : 1;
  for (std::int32_t z = part.lower[2]; z < part.upper[2]; ++z)
    for (std::size_t i = 0; i < n_rows; i += n_together) {
      const std::int32_t y = part.lower[1] + static_cast<std::int32_t>(i);
      LODE_CHECK(spool_->read(begin + place_in(tile, y, z),
                              out.subspan(place_in(box, y, z), row * n_together)));
    }
  return {};
}

}  // namespace lode::io
