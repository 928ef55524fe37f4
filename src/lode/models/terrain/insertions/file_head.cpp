#include "lode/models/terrain/insertions/file_head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "lode/store/bytes.h"

namespace lode::insertions {
namespace {

constexpr std::array kModels{Model::delaunay_pyramid, Model::ternary_triangulation,
                             Model::implicit_delaunay_pyramid};

std::optional<Model> model_of(std::string_view name) {
  for (const Model model : kModels)
    if (name == model_name(model)) return model;
  return {};
}

Result<void> read_counts(store::ByteReader& in, const std::string& path, FileHead& head) {
  LODE_TRY(head.n_base_vertices, in.read<std::uint32_t>());
  LODE_TRY(head.n_base_triangles, in.read<std::uint32_t>());
  LODE_TRY(head.n_nodes, in.read<std::uint32_t>());
  LODE_TRY(head.n_triangles, in.read<std::uint32_t>());
  LODE_TRY(head.type, terrain_file::read_stored_height(in, path));
  constexpr std::uint32_t kMost = 1U << 30;
  const bool are_plausible = head.n_base_triangles >= 1 && head.n_base_vertices >= 3 &&
                             head.n_base_vertices < kMost && head.n_nodes < kMost &&
                             head.n_base_triangles < kMost &&
                             head.n_triangles >= head.n_base_triangles;
  if (!are_plausible)
    return fail(
        "{}: metadata: expected counts of a triangulation, got {} and {} vertices, {} of {} "
        "triangles",
        path, head.n_base_vertices, head.n_nodes, head.n_base_triangles, head.n_triangles);
  return {};
}

Result<void> read_level_ends(store::ByteReader& in, const std::string& path, std::uint32_t n_nodes,
                             History& history) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  if (n > terrain_file::kMaxLevels)
    return fail("{}: metadata: expected up to {} levels, got {}", path, terrain_file::kMaxLevels,
                n);
  LODE_TRY(history.level_ends, in.read_all<std::uint32_t>(n));
  const auto& ends = history.level_ends;
  const bool has_levels = history.model == Model::implicit_delaunay_pyramid && n_nodes > 0;
  const bool are_ascending = std::ranges::adjacent_find(ends, std::greater_equal()) == ends.end();
  if (has_levels ? ends.empty() || ends.back() != n_nodes || !are_ascending || ends.front() == 0
                 : !ends.empty())
    return fail("{}: metadata: expected {} levels that end with the {} nodes, got {}", path,
                has_levels ? "some" : "no", n_nodes, n);
  return {};
}

Result<void> read_facts(store::ByteReader& in, const std::string& path, std::uint32_t n_triangles,
                        LevelledHistory& levelled) {
  const std::size_t n = levelled.levels.size() + levelled.history.level_ends.size();
  for (std::size_t i = 0; i < n; ++i) {
    LevelFacts level;
    LODE_TRY(level.tolerance, in.read<double>());
    LODE_TRY(level.n_triangles, in.read<std::uint32_t>());
    LODE_TRY(level.n_vertices, in.read<std::uint32_t>());
    LODE_TRY(level.smallest_angle, in.read<double>());
    LODE_TRY(level.median_angle, in.read<double>());
    constexpr double kLargestAngle = 60;
    const bool are_angles = level.smallest_angle >= 0 &&
                            level.smallest_angle <= level.median_angle &&
                            level.median_angle <= kLargestAngle + 1e-6;
    if (!(level.tolerance >= 0) || !std::isfinite(level.tolerance) || level.n_triangles == 0 ||
        level.n_triangles > n_triangles || level.n_vertices < 3 || !are_angles)
      return fail(
          "{}: metadata: expected of a level a tolerance, up to {} triangles, vertices and "
          "smallest "
          "angles, got {}, {}, {}, {} and {}",
          path, n_triangles, level.tolerance, level.n_triangles, level.n_vertices,
          level.smallest_angle, level.median_angle);
    levelled.facts.push_back(level);
  }
  return {};
}

Result<void> read_bands(store::ByteReader& in, const std::string& path, FileHead& head) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  constexpr std::uint32_t kMostBands = terrain_file::kMaxLevels + 64;
  if (n > kMostBands)
    return fail("{}: metadata: expected up to {} bands, got {}", path, kMostBands, n);
  std::uint32_t begin = 0;
  std::uint32_t first_page = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    LODE_TRY(const auto end, in.read<std::uint32_t>());
    LODE_TRY(const auto n_pages, in.read<std::uint32_t>());
    if (end <= begin || end > head.n_nodes || n_pages < 1 || n_pages > end - begin)
      return fail(
          "{}: metadata: expected bands of up to {} nodes that follow each other, each with a page "
          "or more, got one from {} to {} of {} pages",
          path, head.n_nodes, begin, end, n_pages);
    head.bands.push_back({begin, end, first_page, n_pages});
    begin = end;
    first_page += n_pages;
  }
  if (begin != head.n_nodes)
    return fail("{}: metadata: expected bands of all {} nodes, got {}", path, head.n_nodes, begin);
  return {};
}

}  // namespace

std::string_view model_name(Model model) {
  switch (model) {
    case Model::delaunay_pyramid: return "delaunay_pyramid";
    case Model::ternary_triangulation: return "ternary_triangulation";
    case Model::implicit_delaunay_pyramid: return "implicit_delaunay_pyramid";
  }
  return {};
}

Result<FileHead> read_head(const store::Reader& reader, LevelledHistory& levelled) {
  const std::string& path = reader.path();
  History& history = levelled.history;
  const auto model = model_of(reader.model());
  if (!model)
    return fail("{}: expected the model {}, {} or {}, got {}", path, model_name(kModels[0]),
                model_name(kModels[1]), model_name(kModels[2]), reader.model());
  history.model = *model;
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}: build the file again",
                path, kLayout, reader.model(), layout);
  LODE_TRY(const auto is_of_points, in.read<std::uint8_t>());
  if (is_of_points > 1)
    return fail("{}: metadata: expected a {} of a raster or of points, got kind {}", path,
                reader.model(), is_of_points);
  history.is_of_points = is_of_points != 0;
  LODE_CHECK(terrain_file::read(in, path, history));
  LODE_TRY(history.max_error, in.read<double>());
  if (!(history.max_error >= 0) || !std::isfinite(history.max_error))
    return fail("{}: metadata: expected a finite error >= 0, got {}", path, history.max_error);
  FileHead head;
  LODE_CHECK(read_counts(in, path, head));
  LODE_TRY(levelled.levels, terrain_file::read_levels(in, path));
  LODE_CHECK(read_level_ends(in, path, head.n_nodes, history));
  LODE_CHECK(read_facts(in, path, head.n_triangles, levelled));
  LODE_TRY(head.n_lines, in.read<std::uint32_t>());
  if (head.n_lines > (history.is_of_points ? 3 * std::uint64_t{head.n_base_triangles} : 0))
    return fail("{}: metadata: expected up to {} fixed edges of a base of points, got {}", path,
                3 * std::uint64_t{head.n_base_triangles}, head.n_lines);
  LODE_TRY(head.n_steps, in.read<std::uint32_t>());
  LODE_CHECK(read_bands(in, path, head));
  LODE_CHECK(in.expect_end());
  return head;
}

float to_error(std::uint16_t upper_half) {
  const auto error = std::bit_cast<float>(std::uint32_t{upper_half} << 16);
  return error >= 0 && std::isfinite(error) && !std::signbit(error) ? error : -1.0F;
}

}  // namespace lode::insertions
