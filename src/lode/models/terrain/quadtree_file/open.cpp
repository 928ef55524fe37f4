#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "lode/models/terrain/quadtree_file/file_layout.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/store/bytes.h"
#include "lode/store/reader.h"

namespace lode::quadtree_file {
namespace {

using terrain_file::read_column;

struct Head {
  terrain_file::Source source;
  HeightType type = HeightType::float64;
  std::vector<double> levels;
  std::uint32_t n_kept = 0;
};

Result<Head> read_head(const store::Reader& reader) {
  const std::string& path = reader.path();
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}", path, kLayout,
                reader.model(), layout);
  Head head;
  LODE_CHECK(terrain_file::read(in, path, head.source));
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  if (type > static_cast<std::uint8_t>(HeightType::float64))
    return fail("{}: metadata: expected a type of heights up to 3, got {}", path, type);
  head.type = static_cast<HeightType>(type);
  LODE_TRY(head.levels, terrain_file::read_levels(in, path));
  LODE_TRY(head.n_kept, in.read<std::uint32_t>());
  if (head.n_kept > head.source.n_samples)
    return fail("{}: metadata: expected up to {} samples to keep, got {}", path,
                head.source.n_samples, head.n_kept);
  LODE_CHECK(in.expect_end());
  return head;
}

template <typename T>
Result<HeightGrid> read_grid(const store::Reader& reader, const Head& head) {
  const HeightFrame& frame = head.source.frame;
  const std::uint64_t n =
      static_cast<std::uint64_t>(frame.n_columns) * static_cast<std::uint64_t>(frame.n_rows);
  LODE_TRY(const std::vector<T> heights, read_column<T>(reader, key_of(Column::height), n));
  HeightGrid grid = make_height_grid<T>(frame.n_columns, frame.n_rows);
  static_cast<HeightFrame&>(grid) = frame;
  if (head.source.n_missing > 0) {
    LODE_TRY(grid.is_valid, read_column<std::uint8_t>(reader, key_of(Column::is_valid), n));
  }
  auto& samples = std::get<HeightGrid::Samples<T>>(grid.heights);
  for (std::int32_t y = 0; y < frame.n_rows; ++y)
    for (std::int32_t x = 0; x < frame.n_columns; ++x) {
      const T z = heights[static_cast<std::size_t>(std::int64_t{y} * frame.n_columns + x)];
      samples[static_cast<std::size_t>(y * grid.stride + x)] = z;
      const auto height = static_cast<double>(z);
      if (grid.has_height(x, y) &&
          !(height >= head.source.range.lower && height <= head.source.range.upper))
        return fail("{}: column {}, row {}: expected a height from {} to {}, got {}", reader.path(),
                    x, y, head.source.range.lower, head.source.range.upper, height);
    }
  if (grid.n_missing() != head.source.n_missing)
    return fail("{}: expected {} samples without a height, got {}", reader.path(),
                head.source.n_missing, grid.n_missing());
  return grid;
}

Result<HeightGrid> read_grid(const store::Reader& reader, const Head& head) {
  switch (head.type) {
    case HeightType::int16: return read_grid<std::int16_t>(reader, head);
    case HeightType::uint16: return read_grid<std::uint16_t>(reader, head);
    case HeightType::float32: return read_grid<float>(reader, head);
    default: return read_grid<double>(reader, head);
  }
}

template <typename T>
Result<T> naming(const std::string& path, Result<T> result) {
  if (result) return result;
  return fail("{}: {}", path, result.error().message);
}

Result<void> read_kept(const store::Reader& reader, std::uint32_t n, SquareDomain& domain) {
  LODE_TRY(const auto numbers,
           read_column<std::uint32_t>(reader, key_of(Column::kept), 2 * std::uint64_t{n}));
  std::vector<LatticePoint> kept;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t x = numbers[2 * i];
    const std::uint32_t y = numbers[2 * i + 1];
    const bool is_in = x < static_cast<std::uint32_t>(domain.size_x()) &&
                       y < static_cast<std::uint32_t>(domain.size_y());
    const LatticePoint p{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
    const bool is_next =
        kept.empty() || std::pair(kept.back().y, kept.back().x) < std::pair(p.y, p.x);
    if (!is_in || !is_next || !domain.has_node(p))
      return fail("{}: expected samples to keep in rows, in cells with four heights, got {}, {}",
                  reader.path(), x, y);
    kept.push_back(p);
  }
  domain.keep(std::move(kept));
  return {};
}

Result<SurfaceQuadtree> read_surface(const store::Reader& reader, SquareDomain domain) {
  std::vector<std::vector<float>> errors;
  for (std::int32_t level = 0; level < domain.n_levels(); ++level) {
    LODE_TRY(auto of_level,
             read_column<float>(reader, key_of(Column::error, level), domain.n_squares(level)));
    errors.push_back(std::move(of_level));
  }
  return naming(reader.path(), SurfaceQuadtree::of(std::move(domain), std::move(errors)));
}

Result<QuaternaryTriangulation> read_quaternary(const store::Reader& reader, SquareDomain domain) {
  std::vector<std::vector<std::array<float, 2>>> errors;
  for (std::int32_t level = 0; level < domain.n_levels(); ++level) {
    LODE_TRY(const auto numbers,
             read_column<float>(reader, key_of(Column::error, level), 2 * domain.n_squares(level)));
    auto& of_level = errors.emplace_back(domain.n_squares(level));
    for (std::size_t i = 0; i < numbers.size(); ++i) of_level[i / 2][i % 2] = numbers[i];
  }
  return naming(reader.path(), QuaternaryTriangulation::of(std::move(domain), std::move(errors)));
}

}  // namespace

bool is_model_of(const std::string& path) { return terrain_file::is_one_of(path, kModelNames); }

Result<QuadtreeModel> open(const std::string& path, Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(path));
  LODE_TRY(const std::size_t kind, terrain_file::find_model(reader, kModelNames));
  LODE_TRY(Head head, read_head(reader));
  LODE_TRY(HeightGrid grid, read_grid(reader, head));
  if (progress.is_cancelled()) return cancelled_error();
  LODE_TRY(SquareDomain domain, naming(path, SquareDomain::make(grid)));
  LODE_CHECK(read_kept(reader, head.n_kept, domain));
  const auto make = [&](auto tree) {
    return QuadtreeModel{std::move(head.source), std::move(head.levels), std::move(grid),
                         std::move(tree)};
  };
  if (kind == 0) {
    LODE_TRY(SurfaceQuadtree tree, read_surface(reader, std::move(domain)));
    return make(std::move(tree));
  }
  if (kind == 1) {
    LODE_TRY(QuaternaryTriangulation tree, read_quaternary(reader, std::move(domain)));
    return make(std::move(tree));
  }
  return make(std::move(domain));
}

}  // namespace lode::quadtree_file
