#include "lode/io/quadratic_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/core/expects.h"
#include "lode/io/polyhedron_centre.h"

namespace lode::io {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Nodes = std::span<const std::uint32_t>;

/// A cell's faces with the places of the middles of their edges, which lie behind the corners.
template <std::size_t N, std::size_t E>
constexpr std::array<QuadraticFace, N> with_middles(const std::array<Face, N>& faces,
                                                    const std::array<Edge, E>& edges,
                                                    std::size_t n_cell_corners) {
  std::array<QuadraticFace, N> all{};
  for (std::size_t f = 0; f < N; ++f) {
    all[f].corners = faces[f];
    const std::size_t n = n_corners(faces[f]);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t e = 0; e < E; ++e) {
        const std::uint8_t a = faces[f][i];
        const std::uint8_t b = faces[f][(i + 1) % n];
        if ((edges[e][0] == a && edges[e][1] == b) || (edges[e][0] == b && edges[e][1] == a))
          all[f].middles[i] = static_cast<std::uint8_t>(n_cell_corners + e);
      }
  }
  return all;
}

/// Faces from `first` on get nodes in their middles, of places from `place` on.
template <std::size_t N>
constexpr std::array<QuadraticFace, N> with_centres(std::array<QuadraticFace, N> faces,
                                                    std::size_t first, std::size_t n,
                                                    std::uint8_t place) {
  for (std::size_t i = 0; i < n; ++i)
    faces[first + i].centre = static_cast<std::uint8_t>(place + i);
  return faces;
}

constexpr auto kHexahedronOf20 = with_middles(kHexahedronFaces, kHexahedronEdges, 8);
constexpr auto kHexahedronOf27 = with_centres(kHexahedronOf20, 0, 6, 20);
constexpr auto kWedgeOf15 = with_middles(kWedgeFaces, kWedgeEdges, 6);
constexpr auto kWedgeOf18 = with_centres(kWedgeOf15, 2, 3, 15);
constexpr auto kPyramidOf13 = with_middles(kPyramidFaces, kPyramidEdges, 5);
constexpr auto kPyramidOf14 = with_centres(kPyramidOf13, 0, 1, 13);

/// One weight for each of some nodes, one run after the other.
struct Run {
  std::size_t n = 0;
  double weight = 0;
};

template <std::size_t N, std::size_t R>
constexpr std::array<double, N> weights_of(const std::array<Run, R>& runs) {
  std::array<double, N> weights{};
  std::size_t at = 0;
  for (const Run& run : runs)
    for (std::size_t i = 0; i < run.n; ++i) weights[at++] = run.weight;
  return weights;
}

// Shape functions at the middle of the parameters: of wedges the triangle's, of pyramids the point
// a quarter of the height above the base. That of 14 nodes adds to that of 13 how far the node in
// the base's middle is from what these have there, times the square of 3/4.
constexpr auto kWeightsOf20 = weights_of<20>(std::array<Run, 2>{{{8, -0.25}, {12, 0.25}}});
constexpr auto kWeightsOf15 =
    weights_of<15>(std::array<Run, 3>{{{6, -2.0 / 9}, {6, 2.0 / 9}, {3, 1.0 / 3}}});
constexpr auto kWeightsOf18 =
    weights_of<18>(std::array<Run, 3>{{{12, 0}, {3, -1.0 / 9}, {3, 4.0 / 9}}});
constexpr auto kWeightsOf13 = weights_of<13>(
    std::array<Run, 4>{{{4, -3.0 / 16}, {1, -1.0 / 8}, {4, 9.0 / 32}, {4, 3.0 / 16}}});
constexpr auto kWeightsOf14 = weights_of<14>(
    std::array<Run, 5>{{{4, -3.0 / 64}, {1, -1.0 / 8}, {4, 0}, {4, 3.0 / 16}, {1, 9.0 / 16}}});

constexpr std::uint8_t kCentreOf27 = 26;
constexpr std::size_t kNodesOfPyramid = 14;

/// The corners of a face that follow another one, with the middle behind each.
struct Outline {
  std::array<std::uint32_t, 4> corners{};
  std::array<std::uint32_t, 4> middles{};
  std::size_t n = 0;
};

Outline outline_of(const QuadraticFace& face, Nodes nodes) {
  Outline outline;
  const std::size_t n = n_corners(face.corners);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t corner = nodes[face.corners[i]];
    if (corner == nodes[face.corners[(i + 1) % n]]) continue;
    outline.corners[outline.n] = corner;
    outline.middles[outline.n++] = nodes[face.middles[i]];
  }
  return outline;
}

void add_fan(const Outline& outline, std::uint32_t centre, std::vector<Triangle>& triangles) {
  for (std::size_t i = 0; i < outline.n; ++i) {
    triangles.push_back({outline.corners[i], outline.middles[i], centre});
    triangles.push_back({outline.middles[i], outline.corners[(i + 1) % outline.n], centre});
  }
}

double squared_length(const Vec3d& edge) { return dot(edge, edge); }

/// A sum that is the same to the last bit whichever cell has the points in which order.
Vec3d sum_of(const CellMesh& mesh, std::array<std::uint32_t, 4> points) {
  std::sort(points.begin(), points.end());
  Vec3d sum;
  for (const std::uint32_t point : points) sum = sum + mesh.points[point];
  return sum;
}

/// A diagonal between two middles of a face's edges.
struct Diagonal {
  double off_middle = 0;  ///< How far its middle is from the face's, squared,
  double length = 0;      ///< and its length, squared.
  std::uint32_t smallest = 0;
};

/// Where a fan of the triangles between middles begins: of four at an end of the diagonal whose
/// middle is nearer to that of the face, as its shape functions have it: along a curve, not across.
/// Of those as near but for roundings at an end of the shorter, then of that of the smallest point.
std::size_t first_middle(const CellMesh& mesh, const Outline& outline) {
  if (outline.n < 4) return 0;
  constexpr double kRounding = 1e-12;  // of squared lengths
  const auto& m = outline.middles;
  const Vec3d middle = sum_of(mesh, m) * 0.5 - sum_of(mesh, outline.corners) * 0.25;
  const auto diagonal = [&](std::size_t i) {
    const Vec3d& a = mesh.points[m[i]];
    const Vec3d& b = mesh.points[m[i + 2]];
    return Diagonal{squared_length((a + b) * 0.5 - middle), squared_length(a - b),
                    std::min(m[i], m[i + 2])};
  };
  const Diagonal one = diagonal(0);
  const Diagonal other = diagonal(1);
  if (std::abs(one.off_middle - other.off_middle) > kRounding * (one.length + other.length))
    return one.off_middle < other.off_middle ? 0 : 1;
  return std::pair(one.length, one.smallest) < std::pair(other.length, other.smallest) ? 0 : 1;
}

void add_face(const CellMesh& mesh, const Outline& outline, std::vector<Triangle>& triangles) {
  const std::size_t n = outline.n;
  if (n < 3) return;
  for (std::size_t i = 0; i < n; ++i)
    triangles.push_back({outline.corners[i], outline.middles[i], outline.middles[(i + n - 1) % n]});
  const std::size_t first = first_middle(mesh, outline);
  for (std::size_t i = 1; i + 1 < n; ++i)
    triangles.push_back({outline.middles[first], outline.middles[(first + i) % n],
                         outline.middles[(first + i + 1) % n]});
}

Vec3d middle_of_parameters(const CellMesh& mesh, Nodes nodes, std::span<const double> weights) {
  Vec3d sum;
  for (std::size_t i = 0; i < weights.size(); ++i) sum = sum + mesh.points[nodes[i]] * weights[i];
  return sum;
}

/// Six times what triangles enclose.
double enclosed(const CellMesh& mesh, std::span<const Triangle> triangles) {
  double sum = 0;
  if (triangles.empty()) return sum;
  const Vec3d& origin = mesh.points[triangles.front()[0]];
  for (const auto& [a, b, c] : triangles)
    sum += dot(cross(mesh.points[a] - origin, mesh.points[b] - origin), mesh.points[c] - origin);
  return sum;
}

}  // namespace

std::optional<QuadraticShape> quadratic_shape(const CellMesh& mesh, std::size_t cell) {
  switch (static_cast<CellType>(mesh.types[cell])) {
    case CellType::quadratic_hexahedron: return QuadraticShape{kHexahedronOf20, {}, kWeightsOf20};
    case CellType::triquadratic_hexahedron: return QuadraticShape{kHexahedronOf27, kCentreOf27, {}};
    case CellType::quadratic_wedge: return QuadraticShape{kWedgeOf15, {}, kWeightsOf15};
    case CellType::biquadratic_wedge: return QuadraticShape{kWedgeOf18, {}, kWeightsOf18};
    case CellType::quadratic_pyramid: return QuadraticShape{kPyramidOf13, {}, kWeightsOf13};
    case CellType::lagrange_pyramid:
      if (mesh.corners_of(cell).size() != kNodesOfPyramid) return {};
      return QuadraticShape{kPyramidOf14, {}, kWeightsOf14};
    default: return {};
  }
}

bool is_quadratic(const CellMesh& mesh, std::size_t cell) {
  return static_cast<CellType>(mesh.types[cell]) == CellType::quadratic_tetrahedron ||
         quadratic_shape(mesh, cell).has_value();
}

std::vector<Triangle> quadratic_triangles(const CellMesh& mesh, const QuadraticShape& shape,
                                          Nodes nodes) {
  std::vector<Triangle> triangles;
  constexpr std::size_t kMost = 48;
  triangles.reserve(kMost);
  for (const QuadraticFace& face : shape.faces) {
    const Outline outline = outline_of(face, nodes);
    if (face.centre && outline.n == 4)
      add_fan(outline, nodes[*face.centre], triangles);
    else
      add_face(mesh, outline, triangles);
  }
  return triangles;
}

std::optional<Vec3d> quadratic_centre(const CellMesh& mesh, std::size_t cell,
                                      std::span<const Triangle> triangles) {
  const std::optional<QuadraticShape> shape = quadratic_shape(mesh, cell);
  LODE_EXPECTS(shape.has_value());
  const Vec3d middle = middle_of_parameters(mesh, mesh.corners_of(cell), shape->weights);
  std::vector<Triangle> outward(triangles.begin(), triangles.end());
  if (enclosed(mesh, triangles) < 0)
    for (Triangle& triangle : outward) std::swap(triangle[1], triangle[2]);
  return find_centre(mesh, middle, outward);
}

double value_at_quadratic_centre(const CellMesh& mesh, std::size_t cell, const Vec3d& centre,
                                 const std::vector<double>& values) {
  const std::optional<QuadraticShape> shape = quadratic_shape(mesh, cell);
  LODE_EXPECTS(shape.has_value());
  const Nodes nodes = mesh.corners_of(cell);
  if (centre != middle_of_parameters(mesh, nodes, shape->weights)) {
    std::vector<std::uint32_t> distinct(nodes.begin(), nodes.end());
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    return value_at_centre(mesh, distinct, centre, values);
  }
  double sum = 0;
  double low = values[nodes[0]];
  double high = low;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double value = values[nodes[i]];
    sum += value * shape->weights[i];
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return std::isfinite(sum) ? std::clamp(sum, low, high) : sum;
}

}  // namespace lode::io
