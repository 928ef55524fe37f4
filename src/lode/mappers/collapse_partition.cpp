#include "lode/mappers/collapse_partition.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lode::simplification {
namespace {

constexpr std::size_t kChunk = 1 << 16;

/// Numbers the cells that vertices lie in.
class CellNumbers {
 public:
  CellNumbers(const UninitializedArray<Vec3f>& positions, const PartitionLattice& lattice)
      : lattice_(lattice) {
    const auto [lower, upper] = bounds_of(positions);
    // Where there is little surface in much space, cells are larger than asked for.
    for (;; lattice_.edge *= 2) {
      for (std::size_t i = 0; i < 3; ++i) {
        first_[i] = index(lower, i);
        dims_[i] = index(upper, i) - first_[i] + 1;
      }
      const double n = static_cast<double>(dims_[0]) * static_cast<double>(dims_[1]) *
                       static_cast<double>(dims_[2]);
      if (n <= 64.0 + static_cast<double>(positions.size())) break;
    }
  }
  [[nodiscard]] std::uint32_t operator()(const Vec3f& p) const {
    std::int64_t number = 0;
    for (std::size_t i = 3; i-- > 0;) number = number * dims_[i] + (index(p, i) - first_[i]);
    return static_cast<std::uint32_t>(number);
  }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(dims_[0] * dims_[1] * dims_[2]);
  }

 private:
  [[nodiscard]] std::int64_t index(const Vec3f& p, std::size_t i) const {
    return static_cast<std::int64_t>(
        std::floor(static_cast<double>(p[i] - lattice_.origin[i]) / lattice_.edge));
  }

  PartitionLattice lattice_;
  std::array<std::int64_t, 3> first_{};
  std::array<std::int64_t, 3> dims_{};
};

}  // namespace

Partition make_partition(const CollapseMesh& mesh, const PartitionLattice& lattice,
                         Threads threads) {
  Partition partition;
  const CellNumbers number(mesh.positions, lattice);
  std::vector<std::uint32_t> cell_of(mesh.positions.size());
  parallel_for((cell_of.size() + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    const std::size_t end = std::min(cell_of.size(), (chunk + 1) * kChunk);
    for (std::size_t v = chunk * kChunk; v < end; ++v) cell_of[v] = number(mesh.positions[v]);
  });
  partition.is_locked.assign(mesh.positions.size(), 0);
  partition.first.assign(number.count() + 1, 0);
  std::vector<std::uint32_t> cell_of_triangle(mesh.triangles.size(), kNone);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const WorkTriangle& t = mesh.triangles[i];
    if (t.is_dead()) continue;
    const std::uint32_t cell = cell_of[t.v[0]];
    if (cell == cell_of[t.v[1]] && cell == cell_of[t.v[2]]) {
      cell_of_triangle[i] = cell;
      ++partition.first[cell + 1];
    } else {
      partition.between.push_back(static_cast<std::uint32_t>(i));
      for (const std::uint32_t v : t.v) partition.is_locked[v] = 1;
    }
  }
  for (std::size_t c = 0; c < number.count(); ++c) partition.first[c + 1] += partition.first[c];
  partition.triangles.resize(partition.first.back());
  std::vector<std::uint32_t> at(partition.first.begin(), partition.first.end() - 1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (cell_of_triangle[i] != kNone)
      partition.triangles[at[cell_of_triangle[i]]++] = static_cast<std::uint32_t>(i);
  return partition;
}

}  // namespace lode::simplification
