#include "lode/models/terrain/terrain_file/stored_raster.h"

#include <algorithm>
#include <utility>

#include "lode/store/bytes.h"

namespace lode::terrain_file {
namespace {

/// As the alternatives of HeightGrid::heights.
enum class HeightType : std::uint8_t { int16 = 0, uint16 = 1, float32 = 2, float64 = 3 };

ColumnKey key_of(RasterColumn column) { return {static_cast<std::uint32_t>(column), 0}; }

struct Head {
  Source source;
  HeightType type = HeightType::float64;
  std::vector<double> levels;
  std::uint32_t n_kept = 0;
};

Result<Head> read_head(const store::Reader& reader, std::uint32_t layout) {
  const std::string& path = reader.path();
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto found, in.read<std::uint32_t>());
  if (found != layout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}", path, layout,
                reader.model(), found);
  Head head;
  LODE_CHECK(read(in, path, head.source));
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  if (type > static_cast<std::uint8_t>(HeightType::float64))
    return fail("{}: metadata: expected a type of heights up to 3, got {}", path, type);
  head.type = static_cast<HeightType>(type);
  LODE_TRY(head.levels, read_levels(in, path));
  LODE_TRY(head.n_kept, in.read<std::uint32_t>());
  if (head.n_kept > head.source.n_samples)
    return fail("{}: metadata: expected up to {} samples to keep, got {}", path,
                head.source.n_samples, head.n_kept);
  LODE_CHECK(in.expect_end());
  return head;
}

template <typename T>
Result<HeightGrid> read_grid(const store::Reader& reader, const Source& source) {
  const HeightFrame& frame = source.frame;
  const std::uint64_t n =
      static_cast<std::uint64_t>(frame.n_columns) * static_cast<std::uint64_t>(frame.n_rows);
  LODE_TRY(const std::vector<T> heights, read_column<T>(reader, key_of(RasterColumn::height), n));
  HeightGrid grid = make_height_grid<T>(frame.n_columns, frame.n_rows);
  static_cast<HeightFrame&>(grid) = frame;
  if (source.n_missing > 0) {
    LODE_TRY(grid.is_valid, read_column<std::uint8_t>(reader, key_of(RasterColumn::is_valid), n));
  }
  auto& samples = std::get<HeightGrid::Samples<T>>(grid.heights);
  for (std::int32_t y = 0; y < frame.n_rows; ++y)
    for (std::int32_t x = 0; x < frame.n_columns; ++x) {
      const T z = heights[static_cast<std::size_t>(std::int64_t{y} * frame.n_columns + x)];
      samples[static_cast<std::size_t>(y * grid.stride + x)] = z;
      const auto height = static_cast<double>(z);
      if (grid.has_height(x, y) && !(height >= source.range.lower && height <= source.range.upper))
        return fail("{}: column {}, row {}: expected a height from {} to {}, got {}", reader.path(),
                    x, y, source.range.lower, source.range.upper, height);
    }
  if (grid.n_missing() != source.n_missing)
    return fail("{}: expected {} samples without a height, got {}", reader.path(), source.n_missing,
                grid.n_missing());
  return grid;
}

Result<HeightGrid> read_grid(const store::Reader& reader, const Head& head) {
  switch (head.type) {
    case HeightType::int16: return read_grid<std::int16_t>(reader, head.source);
    case HeightType::uint16: return read_grid<std::uint16_t>(reader, head.source);
    case HeightType::float32: return read_grid<float>(reader, head.source);
    default: return read_grid<double>(reader, head.source);
  }
}

Error bad_kept(const std::string& path, std::uint32_t x, std::uint32_t y) {
  return Error{fmt::format(
      "{}: expected samples to keep in rows, in cells with four heights, got {}, {}", path, x, y)};
}

Result<std::vector<LatticePoint>> read_kept(const store::Reader& reader, std::uint32_t n,
                                            const HeightFrame& frame) {
  LODE_TRY(const auto numbers,
           read_column<std::uint32_t>(reader, key_of(RasterColumn::kept), 2 * std::uint64_t{n}));
  std::vector<LatticePoint> kept;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t x = numbers[2 * i];
    const std::uint32_t y = numbers[2 * i + 1];
    const bool is_in = x < static_cast<std::uint32_t>(frame.n_columns) &&
                       y < static_cast<std::uint32_t>(frame.n_rows);
    const LatticePoint p{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
    const bool is_next =
        kept.empty() || std::pair(kept.back().y, kept.back().x) < std::pair(p.y, p.x);
    if (!is_in || !is_next) return bad_kept(reader.path(), x, y);
    kept.push_back(p);
  }
  return kept;
}

}  // namespace

std::vector<std::byte> encode_raster_head(std::uint32_t layout, const Source& source,
                                          const std::vector<double>& levels, const HeightGrid& grid,
                                          std::size_t n_kept) {
  store::ByteWriter out;
  out.write(layout);
  write(out, source);
  out.write(static_cast<std::uint8_t>(grid.heights.index()));
  write_levels(out, levels);
  out.write(static_cast<std::uint32_t>(n_kept));
  return std::move(out).take();
}

Result<void> append_raster(const HeightGrid& grid, const std::vector<LatticePoint>& kept,
                           store::Writer& writer) {
  const auto append = [&]<typename T>(const HeightGrid::Samples<T>& samples) {
    const auto n_columns = static_cast<std::uint64_t>(grid.n_columns);
    return append_column<T>(
        key_of(RasterColumn::height), static_cast<std::uint64_t>(grid.n_samples()),
        [&](std::uint64_t i) {
          const auto x = static_cast<std::int32_t>(i % n_columns);
          const auto y = static_cast<std::int32_t>(i / n_columns);
          return grid.has_height(x, y) ? samples[static_cast<std::size_t>(y * grid.stride + x)]
                                       : T{};
        },
        writer);
  };
  LODE_CHECK(std::visit(append, grid.heights));
  if (!grid.is_valid.empty())
    LODE_CHECK(append_column<std::uint8_t>(
        key_of(RasterColumn::is_valid), grid.is_valid.size(),
        [&](std::uint64_t i) { return grid.is_valid[i]; }, writer));
  if (kept.empty()) return {};
  return append_column<std::uint32_t>(
      key_of(RasterColumn::kept), 2 * kept.size(),
      [&](std::uint64_t i) {
        const LatticePoint p = kept[i / 2];
        return static_cast<std::uint32_t>(i % 2 == 0 ? p.x : p.y);
      },
      writer);
}

Result<StoredRaster> read_raster(const store::Reader& reader, std::uint32_t layout) {
  LODE_TRY(Head head, read_head(reader, layout));
  StoredRaster raster;
  LODE_TRY(raster.grid, read_grid(reader, head));
  LODE_TRY(raster.kept, read_kept(reader, head.n_kept, head.source.frame));
  raster.source = std::move(head.source);
  raster.levels = std::move(head.levels);
  return raster;
}

Result<void> check_kept(const std::string& path, const std::vector<LatticePoint>& kept,
                        const std::function<bool(LatticePoint)>& has_node) {
  for (const LatticePoint p : kept)
    if (!has_node(p))
      return bad_kept(path, static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y));
  return {};
}

}  // namespace lode::terrain_file
