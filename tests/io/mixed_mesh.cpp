#include "tests/io/mixed_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace lode::io::test {

MixedMesh::MixedMesh(const MixedOptions& options) : options_(options), random_(options.seed) {
  make_points();
  for (int x = 0; x < options.n; ++x)
    for (int y = 0; y < options.n; ++y) add_column(x, y, random_.below(3));
  number_points();
  mesh_.point_fields = {{"f", ScalarType::float64, 1, {}}};
  for (const Vec3d& p : mesh_.points)
    mesh_.point_fields[0].values.push_back(3 * p[0] - 2 * p[1] + p[2] + 1);
}

void MixedMesh::make_points() {
  mesh_ = empty_cells();
  const int n = options_.n;
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        Vec3d p{{1.0 * x, 1.0 * y, 1.0 * z}};
        for (double& c : p.v)
          if (c > 0 && c < n) c += random_.uniform(-0.05, 0.05);
        if (options_.is_mirrored) p[0] = -p[0];
        mesh_.points.push_back(p);
      }
}

std::uint32_t MixedMesh::id(int x, int y, int z) const {
  const int n = options_.n + 1;
  return static_cast<std::uint32_t>((z * n + y) * n + x);
}

MixedMesh::Cube MixedMesh::cube(int x, int y, int z) const {
  return {id(x, y, z),     id(x + 1, y, z),     id(x + 1, y + 1, z),     id(x, y + 1, z),
          id(x, y, z + 1), id(x + 1, y, z + 1), id(x + 1, y + 1, z + 1), id(x, y + 1, z + 1)};
}

void MixedMesh::add_column(int x, int y, std::uint64_t kind) {
  for (int z = 0; z < options_.n; ++z) {
    const Cube c = cube(x, y, z);
    if (kind == 0) {
      add_wedge({c[0], c[1], c[2], c[4], c[5], c[6]});
      add_wedge({c[0], c[2], c[3], c[4], c[6], c[7]});
    } else {
      add_cube(c, random_.below(4));
    }
  }
}

void MixedMesh::add_wedge(std::array<std::uint32_t, 6> w) {
  if (options_.has_turned_wedges) std::rotate(w.begin(), w.begin() + 3, w.end());
  add_cell(mesh_, CellType::wedge, {w.begin(), w.end()});
}

void MixedMesh::add_cube(const Cube& c, std::uint64_t kind) {
  if (kind == 0 && options_.has_polyhedra) {
    add_cell(mesh_, CellType::voxel, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]});
  } else if (kind == 1) {
    add_pyramids(c);
  } else if (kind == 2 && options_.has_polyhedra) {
    add_polyhedron(mesh_, turned_faces(c));
  } else {
    // A quarter turn about the z axis, as often as it may be.
    const std::size_t turn = random_.below(4);
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < 8; ++i) corners.push_back(c[i / 4 * 4 + (i + turn) % 4]);
    add_cell(mesh_, CellType::hexahedron, corners);
  }
}

std::vector<std::vector<std::uint32_t>> MixedMesh::faces_of(const Cube& c) {
  return {{c[0], c[4], c[7], c[3]}, {c[1], c[2], c[6], c[5]}, {c[0], c[1], c[5], c[4]},
          {c[3], c[7], c[6], c[2]}, {c[0], c[3], c[2], c[1]}, {c[4], c[5], c[6], c[7]}};
}

std::vector<std::vector<std::uint32_t>> MixedMesh::turned_faces(const Cube& c) {
  auto faces = faces_of(c);
  for (auto& face : faces) {
    std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random_.below(4)),
                face.end());
    if (random_.below(2) == 0) std::reverse(face.begin(), face.end());
  }
  return faces;
}

void MixedMesh::add_pyramids(const Cube& c) {
  Vec3d centre;
  for (const std::uint32_t corner : c) centre = centre + mesh_.points[corner] * 0.125;
  const auto apex = static_cast<std::uint32_t>(mesh_.points.size());
  mesh_.points.push_back(centre);
  for (const auto& face : faces_of(c))
    add_cell(mesh_, CellType::pyramid, {face[3], face[2], face[1], face[0], apex});
}

void MixedMesh::number_points() {
  std::vector<std::uint32_t> ids(mesh_.points.size());
  std::iota(ids.begin(), ids.end(), 0U);
  for (std::size_t i = ids.size(); i > 1; --i) std::swap(ids[i - 1], ids[random_.below(i)]);
  std::vector<Vec3d> points(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) points[ids[i]] = mesh_.points[i];
  mesh_.points = points;
  for (std::uint32_t& corner : mesh_.corners) corner = ids[corner];
  for (std::size_t at = 0; at < mesh_.faces.size(); at += mesh_.faces[at] + std::size_t{1})
    for (std::size_t i = 1; i <= mesh_.faces[at]; ++i)
      mesh_.faces[at + i] = ids[mesh_.faces[at + i]];
}

namespace {

using Pair = std::array<std::uint8_t, 2>;
using Quad = std::array<std::uint8_t, 4>;

/// How VTK numbers the nodes of a type's quadratic cells: behind the corners the middles of these
/// edges, then of these faces, then of hexahedra one in the middle.
struct Numbering {
  CellType linear{};
  CellType quadratic{};
  CellType full{};
  std::vector<Pair> edges;
  std::vector<Quad> faces;
};

const std::vector<Numbering>& numberings() {
  static const std::vector<Numbering> kAll = {
      {CellType::hexahedron,
       CellType::quadratic_hexahedron,
       CellType::triquadratic_hexahedron,
       {{0, 1},
        {1, 2},
        {2, 3},
        {3, 0},
        {4, 5},
        {5, 6},
        {6, 7},
        {7, 4},
        {0, 4},
        {1, 5},
        {2, 6},
        {3, 7}},
       {{0, 3, 4, 7}, {1, 2, 5, 6}, {0, 1, 4, 5}, {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}}},
      {CellType::wedge,
       CellType::quadratic_wedge,
       CellType::biquadratic_wedge,
       {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
       {{0, 1, 3, 4}, {1, 2, 4, 5}, {0, 2, 3, 5}}},
      {CellType::pyramid,
       CellType::quadratic_pyramid,
       CellType::lagrange_pyramid,
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
       {{0, 1, 2, 3}}},
      {CellType::tetrahedron,
       CellType::quadratic_tetrahedron,
       CellType::lagrange_tetrahedron,
       {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}},
       {}}};
  return kAll;
}

/// Gives the same nodes to the same corners.
class MiddleNodes {
 public:
  MiddleNodes(CellMesh& mesh, double n) : mesh_(mesh), n_(n) {}

  std::uint32_t of(std::vector<std::uint32_t> corners) {
    std::sort(corners.begin(), corners.end());
    const auto [found, is_new] =
        nodes_.emplace(corners, static_cast<std::uint32_t>(mesh_.points.size()));
    if (!is_new) return found->second;
    Vec3d p;
    for (const std::uint32_t corner : corners)
      p = p + mesh_.points[corner] * (1.0 / static_cast<double>(corners.size()));
    for (double& c : p.v)
      if (n_ > 0 && std::abs(c) > 1e-12 && std::abs(std::abs(c) - n_) > 1e-12)
        c += random_.uniform(-0.05, 0.05);
    mesh_.points.push_back(p);
    return found->second;
  }

 private:
  CellMesh& mesh_;
  double n_ = 0;
  oracles::Random random_{7};
  std::map<std::vector<std::uint32_t>, std::uint32_t> nodes_;
};

}  // namespace

CellMesh quadratic_of(const CellMesh& linear, bool is_full, double n) {
  CellMesh mesh = empty_cells();
  mesh.points = linear.points;
  MiddleNodes middles(mesh, n);
  for (std::size_t cell = 0; cell < linear.n_cells(); ++cell) {
    const auto found =
        std::find_if(numberings().begin(), numberings().end(), [&](const Numbering& numbering) {
          return static_cast<std::uint8_t>(numbering.linear) == linear.types[cell];
        });
    const auto corners = linear.corners_of(cell);
    std::vector<std::uint32_t> nodes(corners.begin(), corners.end());
    for (const auto& [a, b] : found->edges) nodes.push_back(middles.of({corners[a], corners[b]}));
    if (is_full) {
      for (const auto& [a, b, c, d] : found->faces)
        nodes.push_back(middles.of({corners[a], corners[b], corners[c], corners[d]}));
      if (found->linear == CellType::hexahedron)
        nodes.push_back(middles.of({corners.begin(), corners.end()}));
    }
    add_cell(mesh, is_full ? found->full : found->quadratic, nodes);
  }
  mesh.point_fields = {{"f", ScalarType::float64, 1, {}}};
  for (const Vec3d& p : mesh.points)
    mesh.point_fields[0].values.push_back(3 * p[0] - 2 * p[1] + p[2] + 1);
  return mesh;
}

}  // namespace lode::io::test
