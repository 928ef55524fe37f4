#include "lode/mappers/mesh_gradients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "lode/core/parallel_fill.h"
#include "lode/mappers/crossed_edge.h"

namespace lode {
namespace {

/// The cells round each vertex, ascending.
class CellLists {
 public:
  explicit CellLists(const SimplexMesh& mesh) : begins_(mesh.positions.size() + 1, 0) {
    cells_.resize(4 * mesh.tetrahedra.size());
    for (const auto& cell : mesh.tetrahedra)
      for (const std::uint32_t v : cell) ++begins_[v];
    std::uint64_t sum = 0;
    for (std::uint64_t& begin : begins_) sum += std::exchange(begin, sum);
    for (std::size_t at = 0; at < mesh.tetrahedra.size(); ++at)
      for (const std::uint32_t v : mesh.tetrahedra[at])
        cells_[begins_[v]++] = static_cast<std::uint32_t>(at);
    std::copy_backward(begins_.begin(), begins_.end() - 1, begins_.end());
    begins_.front() = 0;
  }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(cells_).subspan(begins_[vertex], begins_[vertex + 1] - begins_[vertex]);
  }

 private:
  std::vector<std::uint64_t> begins_;
  UninitializedArray<std::uint32_t> cells_;
};

/// What a cell adds at one of its corners.
struct WeightedGradient {
  Vec3d gradient;
  double solid_angle = 0;  ///< 0: none.
};

/// Solid angle: van Oosterom and Strackee 1983.
WeightedGradient gradient_at(const SimplexMesh& mesh, const std::array<std::uint32_t, 4>& cell,
                             std::uint32_t vertex) {
  std::array<Vec3d, 3> ways;      // to the other corners,
  std::array<double, 3> lengths;  // how far,
  std::array<double, 3> rises;    // and how much more the field has there
  std::size_t n = 0;
  for (const std::uint32_t v : cell) {
    if (v == vertex || n == 3) continue;
    ways[n] = mesh.positions[v] - mesh.positions[vertex];
    lengths[n] = length(ways[n]);
    rises[n] = mesh.values[v] - mesh.values[vertex];
    ++n;
  }
  const auto& [a, b, c] = ways;
  const Vec3d bc = cross(b, c);
  const double volume = dot(a, bc);
  const double product = lengths[0] * lengths[1] * lengths[2];
  if (n < 3 || !(std::abs(volume) > 1e-12 * product)) return {};
  const Vec3d gradient =
      (bc * rises[0] + cross(c, a) * rises[1] + cross(a, b) * rises[2]) * (1 / volume);
  if (!std::isfinite(gradient[0] + gradient[1] + gradient[2])) return {};
  const double across =
      product + dot(a, b) * lengths[2] + dot(b, c) * lengths[0] + dot(c, a) * lengths[1];
  return {gradient, 2 * std::atan2(std::abs(volume), across)};
}

Vec3d mean_gradient(const SimplexMesh& mesh, std::span<const std::uint32_t> cells,
                    std::uint32_t vertex) {
  Vec3d sum;
  double weights = 0;
  for (const std::uint32_t cell : cells) {
    const auto [gradient, solid_angle] = gradient_at(mesh, mesh.tetrahedra[cell], vertex);
    sum = sum + gradient * solid_angle;
    weights += solid_angle;
  }
  return weights > 0 ? sum * (1 / weights) : Vec3d();
}

}  // namespace

std::vector<Vec3f> vertex_gradients(const SimplexMesh& mesh, Threads threads) {
  const CellLists lists(mesh);
  UninitializedArray<Vec3d> gradients(mesh.positions.size());
  parallel_for(gradients.size(), threads, 1024, [&](std::size_t v, int) {
    gradients[v] = mean_gradient(mesh, lists.of(v), static_cast<std::uint32_t>(v));
  });
  double largest = 0;
  for (const Vec3d& g : gradients)
    for (const double coordinate : g.v) largest = std::max(largest, std::abs(coordinate));
  std::vector<Vec3f> scaled(gradients.size());
  if (!(largest > 0)) return scaled;
  for (std::size_t v = 0; v < scaled.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i)
      scaled[v][i] = static_cast<float>(gradients[v][i] / largest);
  return scaled;
}

}  // namespace lode
