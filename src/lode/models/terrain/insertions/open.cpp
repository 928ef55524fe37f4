#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <optional>
#include <span>

#include "lode/models/terrain/insertions/base_check.h"
#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/models/terrain/insertions/recorder.h"
#include "lode/store/bytes.h"
#include "lode/store/reader.h"

namespace lode::insertions {
namespace {

using delaunay::InsertionRule;
using delaunay::LatticePoint;
using terrain_file::read_column;

constexpr std::array kModels{Model::delaunay_pyramid, Model::ternary_triangulation,
                             Model::implicit_delaunay_pyramid};

std::optional<Model> model_of(std::string_view name) {
  for (const Model model : kModels)
    if (name == model_name(model)) return model;
  return {};
}

/// What the columns have.
struct Counts {
  std::uint32_t n_base_vertices = 0;
  std::uint32_t n_base_triangles = 0;
  std::uint32_t n_nodes = 0;
  std::uint32_t n_triangles = 0;
  std::uint32_t n_lines = 0;
  HeightType type = HeightType::float64;
};

Result<void> read_counts(store::ByteReader& in, const std::string& path, Counts& counts) {
  LODE_TRY(counts.n_base_vertices, in.read<std::uint32_t>());
  LODE_TRY(counts.n_base_triangles, in.read<std::uint32_t>());
  LODE_TRY(counts.n_nodes, in.read<std::uint32_t>());
  LODE_TRY(counts.n_triangles, in.read<std::uint32_t>());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  counts.type = static_cast<HeightType>(type);
  constexpr std::uint32_t kMost = 1U << 30;
  const bool are_plausible = counts.n_base_triangles >= 1 && counts.n_base_vertices >= 3 &&
                             counts.n_base_vertices < kMost && counts.n_nodes < kMost &&
                             counts.n_base_triangles < kMost &&
                             counts.n_triangles >= counts.n_base_triangles;
  if (!are_plausible || type < 1 || type > 3)
    return fail(
        "{}: metadata: expected counts of a triangulation and a type of heights, got {} and {} "
        "vertices, {} of {} triangles, type {}",
        path, counts.n_base_vertices, counts.n_nodes, counts.n_base_triangles, counts.n_triangles,
        type);
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

Result<Counts> read_head(const store::Reader& reader, LevelledHistory& levelled) {
  const std::string& path = reader.path();
  store::ByteReader in(reader.metadata(), path + ": metadata");
  LODE_TRY(const auto layout, in.read<std::uint32_t>());
  if (layout != kLayout)
    return fail("{}: metadata: expected layout {} of the model {}, got {}", path, kLayout,
                reader.model(), layout);
  History& history = levelled.history;
  LODE_TRY(const auto is_of_points, in.read<std::uint8_t>());
  if (is_of_points > 1)
    return fail("{}: metadata: expected a {} of a raster or of points, got kind {}", path,
                reader.model(), is_of_points);
  history.is_of_points = is_of_points != 0;
  LODE_CHECK(terrain_file::read(in, path, history));
  LODE_TRY(history.max_error, in.read<double>());
  if (!(history.max_error >= 0) || !std::isfinite(history.max_error))
    return fail("{}: metadata: expected a finite error >= 0, got {}", path, history.max_error);
  Counts counts;
  LODE_CHECK(read_counts(in, path, counts));
  LODE_TRY(levelled.levels, terrain_file::read_levels(in, path));
  LODE_CHECK(read_level_ends(in, path, counts.n_nodes, history));
  LODE_TRY(counts.n_lines, in.read<std::uint32_t>());
  if (counts.n_lines > (history.is_of_points ? 3 * std::uint64_t{counts.n_base_triangles} : 0))
    return fail("{}: metadata: expected up to {} fixed edges of a base of points, got {}", path,
                3 * std::uint64_t{counts.n_base_triangles}, counts.n_lines);
  LODE_CHECK(in.expect_end());
  return counts;
}

template <typename T>
Result<void> read_heights(const store::Reader& reader, std::uint64_t n, History& history) {
  LODE_TRY(const std::vector<T> heights, read_column<T>(reader, key_of(Column::height), n));
  history.heights.assign(heights.begin(), heights.end());
  for (const double z : history.heights)
    if (!(z >= history.range.lower && z <= history.range.upper))
      return fail("{}: expected heights from {} to {}, got {}", reader.path(), history.range.lower,
                  history.range.upper, z);
  return {};
}

/// Inserts the vertices again.
class Replay {
 public:
  Replay(const store::Reader& reader, const Counts& counts, History& history)
      : reader_(reader), counts_(counts), history_(history) {}

  Result<void> run(Progress& progress) {
    LODE_CHECK(read_points());
    LODE_CHECK(read_base());
    LODE_CHECK(read_lines());
    const InsertionRule rule = rule_of(history_.model);
    if (history_.is_of_points) {
      delaunay::PointMesh mesh(delaunay::ListedNodes(points_), base_, rule);
      // Edges of triangles that are split stay without being cut.
      if (rule == InsertionRule::delaunay) mesh.cut(history_.lines);
      return replay(mesh, progress, [](std::uint32_t vertex) { return vertex; });
    }
    const delaunay::LatticePacking packing(history_.frame.n_columns);
    const auto pack = [&](std::uint32_t vertex) { return packing.pack(points_[vertex]); };
    std::vector<std::array<std::uint32_t, 3>> packed;
    packed.reserve(base_.size());
    for (const auto& corner : base_)
      packed.push_back({pack(corner[0]), pack(corner[1]), pack(corner[2])});
    delaunay::LatticeMesh mesh(packing, packed, rule);
    return replay(mesh, progress, pack);
  }

 private:
  /// number(vertex): in the mesh.
  template <typename Mesh, typename Number>
  Result<void> replay(Mesh& mesh, Progress& progress, const Number& number) {
    if (rule_of(history_.model) == InsertionRule::delaunay && !mesh.is_delaunay())
      return fail("{}: expected a base that is Delaunay, got edges that are not", reader_.path());
    Recorder recorder(history_);
    recorder.start(mesh);
    if (history_.n_base_vertices != counts_.n_base_vertices ||
        !std::equal(history_.vertices.begin(), history_.vertices.end(), points_.begin()))
      return fail("{}: expected the {} vertices of the base first, as its triangles come to them",
                  reader_.path(), counts_.n_base_vertices);
    LODE_CHECK(insert_nodes(mesh, recorder, progress, number));
    recorder.finish();
    return read_errors();
  }

  Result<void> read_points() {
    const std::uint64_t n = std::uint64_t{counts_.n_base_vertices} + counts_.n_nodes;
    LODE_TRY(const auto xs, read_column<std::int32_t>(reader_, key_of(Column::x), n));
    LODE_TRY(const auto ys, read_column<std::int32_t>(reader_, key_of(Column::y), n));
    const HeightFrame& frame = history_.frame;
    for (std::size_t i = 0; i < xs.size(); ++i) {
      if (xs[i] < 0 || ys[i] < 0 || xs[i] >= frame.n_columns || ys[i] >= frame.n_rows)
        return fail("{}: expected vertices in {} x {}, got column {}, row {}", reader_.path(),
                    frame.n_columns, frame.n_rows, xs[i], ys[i]);
      points_.push_back({xs[i], ys[i]});
    }
    switch (counts_.type) {
      case HeightType::int16: return read_heights<std::int16_t>(reader_, n, history_);
      case HeightType::float32: return read_heights<float>(reader_, n, history_);
      case HeightType::float64: return read_heights<double>(reader_, n, history_);
    }
    return {};
  }

  /// Triangles that turn left, by vertices.
  Result<void> read_base() {
    LODE_TRY(const auto corners,
             read_column<std::uint32_t>(reader_, key_of(Column::corners),
                                        3 * std::uint64_t{counts_.n_base_triangles}));
    base_.resize(counts_.n_base_triangles);
    std::vector<LatticeCorners> places(base_.size());
    for (std::size_t t = 0; t < base_.size(); ++t) {
      LatticeCorners& p = places[t];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t vertex = corners[3 * t + i];
        if (vertex >= counts_.n_base_vertices)
          return fail("{}: expected one of {} vertices of the base, got {}", reader_.path(),
                      counts_.n_base_vertices, vertex);
        p[i] = points_[vertex];
        base_[t][i] = vertex;
      }
      if (delaunay::doubled_area(p[0], p[1], p[2]) <= 0)
        return fail(
            "{}: expected triangles that turn left, got number {} of the base, which does "
            "not",
            reader_.path(), t);
    }
    const auto vertices = std::span(points_).first(counts_.n_base_vertices);
    if (history_.is_of_points ? !cover_part_once(vertices, base_) : !cover_cells_once(places))
      return fail(
          "{}: expected a base that covers {} once, edge to edge, got triangles that do not",
          reader_.path(), history_.is_of_points ? "its domain" : "cells");
    return {};
  }

  Result<void> read_lines() {
    LODE_TRY(const auto ends, read_column<std::uint32_t>(reader_, key_of(Column::lines),
                                                         2 * std::uint64_t{counts_.n_lines}));
    using Ends = std::array<std::uint32_t, 2>;
    std::vector<Ends> edges;
    for (const auto& corner : base_)
      for (std::size_t i = 0; i < 3 && !ends.empty(); ++i)
        edges.push_back({corner[i], corner[(i + 1) % 3]});
    std::ranges::sort(edges);
    for (std::size_t i = 0; i < ends.size(); i += 2) {
      const Ends line{ends[i], ends[i + 1]};
      const bool follows = history_.lines.empty() || history_.lines.back() < line;
      if (!follows || line[0] > line[1] || !std::ranges::binary_search(edges, line) ||
          !std::ranges::binary_search(edges, Ends{line[1], line[0]}))
        return fail(
            "{}: expected fixed edges between two triangles of the base, in order, got {} to {}",
            reader_.path(), line[0], line[1]);
      history_.lines.push_back(line);
    }
    return {};
  }

  template <typename Mesh, typename Number>
  Result<void> insert_nodes(Mesh& mesh, Recorder& recorder, Progress& progress,
                            const Number& number) {
    constexpr std::uint32_t kPerReport = 1U << 16;
    LODE_TRY(const auto ages,
             read_column<std::uint32_t>(reader_, key_of(Column::age), counts_.n_nodes));
    std::vector<std::uint32_t> slot_of(history_.triangles.size());
    for (std::uint32_t t = 0; t < slot_of.size(); ++t) slot_of[t] = t;
    for (std::uint32_t node = 0; node < counts_.n_nodes; ++node) {
      if (node % kPerReport == 0) {
        if (progress.is_cancelled()) return cancelled_error();
        progress.report("inserting", static_cast<double>(node) / counts_.n_nodes);
      }
      const std::uint32_t vertex = counts_.n_base_vertices + node;
      const LatticePoint p = points_[vertex];
      const auto seed = seed_of(ages[node], p);
      std::span<const std::uint32_t> slots;
      const std::size_t n_before = mesh.triangles().size();
      if (!seed || !mesh.try_insert(number(vertex), slot_of[*seed], slots))
        return fail(
            "{}: node {}: expected column {}, row {} in a triangle of its time that it "
            "can be inserted into",
            reader_.path(), node, p.x, p.y);
      recorder.add_node(mesh, p, slots, slots.size() - (mesh.triangles().size() - n_before));
      slot_of.insert(slot_of.end(), slots.begin(), slots.end());
      if (slot_of.size() > counts_.n_triangles) break;
    }
    if (history_.triangles.size() != counts_.n_triangles)
      return fail("{}: expected {} triangles in all, got {}", reader_.path(), counts_.n_triangles,
                  history_.triangles.size());
    return {};
  }

  /// The triangle, where it is there and holds p, which is none of its corners.
  [[nodiscard]] std::optional<std::uint32_t> seed_of(std::uint32_t age, LatticePoint p) const {
    const auto n = static_cast<std::uint32_t>(history_.triangles.size());
    if (age >= n) return {};
    const Triangle& triangle = history_.triangles[n - 1 - age];
    if (triangle.death != kNone) return {};
    std::array<LatticePoint, 3> corner;
    for (std::size_t i = 0; i < 3; ++i) {
      corner[i] = history_.vertices[triangle.corner[i]];
      if (corner[i] == p) return {};
    }
    for (std::size_t i = 0; i < 3; ++i)
      if (delaunay::doubled_area(corner[i], corner[(i + 1) % 3], p) < 0) return {};
    return n - 1 - age;
  }

  Result<void> read_errors() {
    LODE_TRY(const auto errors,
             read_column<std::uint16_t>(reader_, key_of(Column::error), counts_.n_triangles));
    for (std::size_t t = 0; t < errors.size(); ++t) {
      const auto error = std::bit_cast<float>(std::uint32_t{errors[t]} << 16);
      if (!(error >= 0) || !std::isfinite(error))
        return fail("{}: expected finite errors >= 0, got {}", reader_.path(), error);
      history_.triangles[t].error = error;
    }
    return {};
  }

  const store::Reader& reader_;
  const Counts& counts_;
  History& history_;
  std::vector<LatticePoint> points_;
  std::vector<std::array<std::uint32_t, 3>> base_;
};

}  // namespace

std::string_view model_name(Model model) {
  switch (model) {
    case Model::delaunay_pyramid: return "delaunay_pyramid";
    case Model::ternary_triangulation: return "ternary_triangulation";
    case Model::implicit_delaunay_pyramid: return "implicit_delaunay_pyramid";
  }
  return {};
}

bool is_model_of(const std::string& path) {
  const auto reader = store::Reader::open(path);
  return reader && model_of(reader->model());
}

Result<LevelledHistory> open(const std::string& path, Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(path));
  const auto model = model_of(reader.model());
  if (!model)
    return fail("{}: expected the model {}, {} or {}, got {}", path, model_name(kModels[0]),
                model_name(kModels[1]), model_name(kModels[2]), reader.model());
  LevelledHistory levelled;
  levelled.history.model = *model;
  LODE_TRY(const Counts counts, read_head(reader, levelled));
  LODE_CHECK(Replay(reader, counts, levelled.history).run(progress));
  return levelled;
}

}  // namespace lode::insertions
