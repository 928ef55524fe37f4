#include "lode/io/layer_spool.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"

namespace lode::io {
namespace {

constexpr std::size_t kBytesPerRead = std::size_t{4} << 20;

/// As many units along x, then y, as `max_bytes` hold together; at least one.
Index3 tile_of(const VolumeInfo& info, const Index3& unit, double max_bytes) {
  Index3 tile = unit;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto n_bytes = static_cast<double>(IndexBox{{}, tile}.n_samples()) *
                         static_cast<double>(size_of(info.type));
    const std::int32_t most = (info.grid.dims[axis] - 1) / unit[axis] + 1;
    const double n = std::clamp(std::floor(max_bytes / n_bytes), 1.0, static_cast<double>(most));
    tile[axis] = unit[axis] * static_cast<std::int32_t>(n);
  }
  return tile;
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> LayerSpool::wrap(std::unique_ptr<VolumeSource> source,
                                                       const std::string& directory) {
  const VolumeInfo& info = source->info();
  const Index3& unit = source->read_unit().dims;
  const Index3 tile = tile_of(info, unit, static_cast<double>(source->memory_bytes()));
  const bool holds_layer = tile[0] >= info.grid.dims[0] && tile[1] >= info.grid.dims[1];
  if (holds_layer || std::min(unit[2], info.grid.dims[2]) == 1) return source;
  auto tally = std::make_shared<IoTally>();
  LODE_TRY(SpoolFile spool, SpoolFile::create(directory, tally));
  return std::unique_ptr<VolumeSource>(
      new LayerSpool(std::move(source), tile, std::move(spool), std::move(tally)));
}

LayerSpool::LayerSpool(std::unique_ptr<VolumeSource> source, const Index3& tile, SpoolFile spool,
                       IoTallyPtr tally)
    : source_(std::move(source)),
      tile_(tile),
      spool_(std::move(spool)),
      tally_(std::move(tally)),
      tiles_(static_cast<std::size_t>((info().grid.dims[2] - 1) / tile[2] + 1)) {}

IoCounts LayerSpool::io() const {
  IoCounts counts = source_->io();
  counts.n_spool_bytes_written += tally_->n_spool_bytes_written;
  counts.n_spool_bytes_read += tally_->n_spool_bytes_read;
  return counts;
}

Result<void> LayerSpool::read(const IndexBox& box, std::span<std::byte> out) try {
  if (box.is_empty()) return {};
  const auto n_bytes = static_cast<std::size_t>(box.n_samples()) * sample_size();
  const std::size_t slice_bytes = n_bytes / static_cast<std::size_t>(box.upper[2] - box.lower[2]);
  for (std::int32_t z = box.lower[2]; z < box.upper[2];) {
    const std::int32_t layer = z / tile_[2];
    IndexBox part = box;
    part.lower[2] = z;
    part.upper[2] = z = std::min(box.upper[2], (layer + 1) * tile_[2]);
    const std::span<std::byte> part_out =
        out.subspan(static_cast<std::size_t>(part.lower[2] - box.lower[2]) * slice_bytes,
                    static_cast<std::size_t>(z - part.lower[2]) * slice_bytes);
    LODE_TRY(const bool is_kept, spool_layer(layer));
    if (!is_kept) {
      LODE_CHECK(source_->read(part, part_out));
      continue;
    }
    const std::vector<IndexBox> tiles = tiles_of(layer);
    for (std::size_t i = 0; i < tiles.size(); ++i)
      LODE_CHECK(read_tile(tiles[i], tiles_[static_cast<std::size_t>(layer)][i], part, part_out));
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
  for (tile.lower[1] = 0; tile.lower[1] < dims[1]; tile.lower[1] += tile_[1])
    for (tile.lower[0] = 0; tile.lower[0] < dims[0]; tile.lower[0] += tile_[0]) {
      for (std::size_t i = 0; i < 3; ++i)
        tile.upper[i] = dims[i] - tile.lower[i] > tile_[i] ? tile.lower[i] + tile_[i] : dims[i];
      tiles.push_back(tile);
    }
  return tiles;
}

Result<bool> LayerSpool::spool_layer(std::int32_t layer) {
  std::vector<std::uint64_t>& begins = tiles_[static_cast<std::size_t>(layer)];
  if (!begins.empty()) return true;
  if (is_full_) return false;
  std::vector<std::uint64_t> spooled;
  for (const IndexBox& tile : tiles_of(layer)) {
    spooled.push_back(spool_.size());
    LODE_TRY(const bool has_room, spool_tile(tile));
    if (!has_room) {
      is_full_ = true;
      return false;
    }
  }
  begins = std::move(spooled);
  return true;
}

/// A few slices at a time: the source keeps the units that the next ones want.
Result<bool> LayerSpool::spool_tile(const IndexBox& tile) {
  IndexBox slab = tile;
  slab.upper[2] = slab.lower[2] + 1;
  const std::size_t slice = static_cast<std::size_t>(slab.n_samples()) * sample_size();
  const auto n = static_cast<std::int32_t>(std::max<std::size_t>(1, kBytesPerRead / slice));
  for (; slab.lower[2] < tile.upper[2]; slab.lower[2] = slab.upper[2]) {
    slab.upper[2] = n < tile.upper[2] - slab.lower[2] ? slab.lower[2] + n : tile.upper[2];
    buffer_.resize(slice * static_cast<std::size_t>(slab.upper[2] - slab.lower[2]));
    LODE_CHECK(source_->read(slab, buffer_));
    if (!spool_.append(buffer_)) return false;
  }
  return true;
}

/// What a tile has of the box.
Result<void> LayerSpool::read_tile(const IndexBox& tile, std::uint64_t begin, const IndexBox& box,
                                   std::span<std::byte> out) const {
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
      LODE_CHECK(spool_.read(begin + place_in(tile, y, z),
                             out.subspan(place_in(box, y, z), row * n_together)));
    }
  return {};
}

}  // namespace lode::io
