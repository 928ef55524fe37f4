#include "lode/mappers/mesh_isosurface.h"

#include <algorithm>
#include <cmath>

#include "lode/mappers/crossed_edge.h"
#include "lode/mappers/march_simplex.h"
#include "lode/mappers/vertex_ids.h"

namespace lode {
namespace {

class MeshMarcher {
 public:
  MeshMarcher(const SimplexMesh& mesh, double isovalue, double margin, Surface& surface)
      : mesh_(mesh),
        isovalue_(isovalue),
        margin_(margin),
        first_(static_cast<std::uint32_t>(surface.positions.size())),
        surface_(surface) {}

  double run() {
    double largest_error = 0;
    for (std::size_t at = 0; at < mesh_.tetrahedra.size(); ++at) {
      const auto& cell = mesh_.tetrahedra[at];
      std::size_t inside = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (mesh_.values[cell[i]] >= isovalue_) inside |= std::size_t{1} << i;
      if (inside == 0 || inside == 15) continue;
      march_simplex<3>(
          inside, false, [&](std::size_t i, std::size_t j) { return vertex_on(cell[i], cell[j]); },
          [&](const std::array<std::uint32_t, 3>& t) { surface_.triangles.push_back(t); });
      largest_error = std::max(largest_error, static_cast<double>(mesh_.errors[at]));
    }
    return largest_error;
  }

 private:
  std::uint32_t vertex_on(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [id, is_new] = ids_.find_or_add(edge_key(a, b));
    if (!is_new) return first_ + id;
    const Vec3d from = mesh_.positions[a] - surface_.origin;
    const Vec3d way = mesh_.positions[b] - mesh_.positions[a];
    const double t = crossing_of(isovalue_, mesh_.values[a], mesh_.values[b], way, margin_);
    surface_.positions.push_back(narrowed(from + way * t));
    surface_.isovalues.push_back(static_cast<float>(isovalue_));
    return first_ + id;
  }

  const SimplexMesh& mesh_;
  double isovalue_;
  double margin_;
  std::uint32_t first_;
  VertexIds ids_;
  Surface& surface_;
};

}  // namespace

double add_isosurface(const SimplexMesh& mesh, double isovalue, double margin, Surface& surface) {
  return MeshMarcher(mesh, isovalue, margin, surface).run();
}

double rounding_margin(const SimplexMesh& mesh, const Vec3d& origin) {
  double largest = 0;
  for (const Vec3d& p : mesh.positions)
    for (std::size_t i = 0; i < 3; ++i) largest = std::max(largest, std::abs(p[i] - origin[i]));
  return largest * 0x1p-20;
}

}  // namespace lode
