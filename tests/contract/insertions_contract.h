#pragma once

// Insertions into terrain as the contract tests see them: of all models that consist of them.

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/terrain/delaunay_selector/spatial_order.h"
#include "lode/models/terrain/implicit_pyramid/build.h"
#include "lode/models/terrain/insertions/build.h"
#include "lode/models/terrain/insertions/insertion_cut.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/refine/cut.h"
#include "tests/contract/mesh.h"
#include "tests/oracles/random.h"

namespace lode::test {

/// `kIsOfPoints`: some nodes of the lattice, with a line between them.
template <insertions::Model kModel, bool kIsOfPoints = false>
class InsertionsContract {
 public:
  static constexpr int kDimension = 2;
  /// A node may be needed that has less error than any that needs it.
  static constexpr bool kIsNestedAlongParents = false;

  static InsertionsContract make(std::uint32_t seed, Threads /*threads*/) {
    Progress progress;
    if constexpr (kIsOfPoints) return InsertionsContract({history_of_points(seed), {}});
    auto history = kModel == insertions::Model::implicit_delaunay_pyramid
                       ? implicit_pyramid::build(noise(seed), progress)
                       : insertions::build_history(noise(seed), 0, kModel, progress);
    return InsertionsContract({*std::move(history), {}});
  }
  Result<void> save(const std::string& path) const {
    Progress progress;
    LODE_CHECK(insertions::save(*made_, path, progress));
    return {};
  }
  static Result<InsertionsContract> open(const std::string& path) {
    Progress progress;
    LODE_TRY(auto made, insertions::open(path, progress));
    return InsertionsContract(std::move(made));
  }
  [[nodiscard]] insertions::InsertionCut refinable() const {
    return insertions::InsertionCut(*facts_);
  }

  /// The mesh of the cut that the model stands at.
  [[nodiscard]] Mesh mesh(const insertions::InsertionCut& opened, const Cut& cut) const {
    insertions::AppliedNodes applied = opened.applied();
    applied.assign(applied.size(), false);
    for (const NodeId node : cut.applied()) applied[static_cast<std::size_t>(node)] = true;
    const delaunay::Tin tin = tin_of(made_->history, applied, delaunay::TinLinks::left_out);
    Mesh mesh{kDimension, {}};
    for (const auto& corners : tin.triangles) {
      Mesh::Cell cell;
      for (const std::uint32_t v : corners) cell.push_back(vertex(tin.vertices[v], tin.heights[v]));
      mesh.cells.push_back(cell);
    }
    return mesh;
  }

  /// Whether a face may belong to one cell only: it lies on a side of the raster.
  [[nodiscard]] static bool may_end_at(const std::vector<MeshVertex>& face) {
    for (const auto& [axis, end] : {std::pair{0, 0}, {0, kColumns - 1}, {1, 0}, {1, kRows - 1}}) {
      const auto i = static_cast<std::size_t>(axis);
      if (face[0].position[i] == end && face[1].position[i] == end) return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<MeshVertex> samples() const {
    std::vector<MeshVertex> result;
    const auto& history = made_->history;
    for (std::size_t v = 0; v < history.vertices.size(); ++v)
      result.push_back(vertex(history.vertices[v], history.heights[v]));
    return result;
  }

 private:
  static constexpr int kColumns = 19;
  static constexpr int kRows = 13;

  explicit InsertionsContract(insertions::LevelledHistory made)
      : made_(std::make_unique<const insertions::LevelledHistory>(std::move(made))),
        facts_(std::make_unique<const insertions::InsertionFacts>(made_->history)) {}

  static MeshVertex vertex(delaunay::LatticePoint p, double height) {
    return {{static_cast<double>(p.x), static_cast<double>(p.y), 0}, height};
  }

  /// From 0 to 125.
  static HeightGrid noise(std::uint32_t seed) {
    HeightGrid grid = make_height_grid<float>(kColumns, kRows);
    auto& heights = std::get<HeightGrid::Samples<float>>(grid.heights);
    oracles::Random random(seed);
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kColumns; ++x)
        heights[static_cast<std::size_t>(y * grid.stride + x)] =
            static_cast<float>(std::round(random.uniform(0, 125)));
    return grid;
  }

  static insertions::History history_of_points(std::uint32_t seed) {
    const HeightGrid grid = noise(seed);
    oracles::Random random(seed + 1);
    HeightPoints points;
    points.n_columns = kColumns;
    points.n_rows = kRows;
    std::vector<std::uint32_t> inner;
    for (std::int32_t y = 0; y < kRows; ++y)
      for (std::int32_t x = 0; x < kColumns; ++x) {
        const bool is_corner = (x == 0 || x == kColumns - 1) && (y == 0 || y == kRows - 1);
        if (!is_corner && random.below(3) == 0) continue;
        if (x > 1 && x < kColumns - 2 && y > 1 && y < kRows - 2)
          inner.push_back(static_cast<std::uint32_t>(points.nodes.size()));
        points.nodes.push_back({x, y});
        points.heights.push_back(grid.height(x, y));
      }
    Progress progress;
    const auto hull = delaunay_selector::find_hull(points);
    const std::vector<std::array<std::uint32_t, 2>> lines{{inner.front(), inner.back()}};
    const auto lined = delaunay_selector::with_lines(points, *hull, lines, {}, progress);
    const delaunay_selector::SpatialOrder order(points, lined->domain);
    const insertions::PointGround ground{.frame = points,
                                         .range = height_range(points),
                                         .samples = order.samples(),
                                         .triangles = order.triangles,
                                         .lines = order.lines,
                                         .n_left_out = 0};
    auto made = kModel == insertions::Model::implicit_delaunay_pyramid
                    ? implicit_pyramid::build(ground, progress)
                    : insertions::build_history(ground, 0, kModel, progress);
    EXPECT_TRUE(made && !made->lines.empty());
    return *std::move(made);
  }

  std::unique_ptr<const insertions::LevelledHistory> made_;
  std::unique_ptr<const insertions::InsertionFacts> facts_;
};

}  // namespace lode::test
