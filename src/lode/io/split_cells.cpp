#include "lode/io/split_cells.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "lode/io/cell_shapes.h"
#include "lode/io/higher_order_cells.h"
#include "lode/io/mesh_checks.h"
#include "lode/io/polyhedron_centre.h"
#include "lode/io/polyhedron_faces.h"
#include "lode/io/quadratic_cells.h"

namespace lode::io {
namespace {

using Corners = std::span<const std::uint32_t>;
using Triangle = std::array<std::uint32_t, 3>;
class Splitter {
 public:
  explicit Splitter(SplitCells& split) : split_(split) {}

  void start(std::size_t cell) { cell_ = static_cast<std::uint32_t>(cell); }

  void add(const Tetrahedron& t) {
    if (t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] ||
        t[2] == t[3]) {
      ++split_.n_repeating;
      return;
    }
    split_.tetrahedra.push_back(t);
    split_.cells.push_back(cell_);
  }

 private:
  SplitCells& split_;
  std::uint32_t cell_ = 0;
};

/// Of some places in a cell, the index of the one whose point is smallest; of equal ones, which
/// degenerate cells have, the first place in the cell counts as smaller.
template <typename Places>
std::size_t smallest(Corners corners, const Places& places, std::size_t n) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < n; ++i) {
    const auto key = std::pair(corners[places[i]], places[i]);
    if (key < std::pair(corners[places[best]], places[best])) best = i;
  }
  return best;
}

/// The place of a cell's smallest point.
std::uint8_t smallest_place(Corners corners) {
  constexpr std::array<std::uint8_t, 8> kPlaces = {0, 1, 2, 3, 4, 5, 6, 7};
  return kPlaces[smallest(corners, kPlaces, corners.size())];
}

bool has_place(const Face& face, std::uint8_t place) {
  return std::find(face.begin(), face.end(), place) != face.end();
}

/// Joins the smallest point to the triangles of all faces without it.
template <std::size_t N>
void split_from_smallest(Corners corners, const std::array<Face, N>& faces, Splitter& splitter) {
  const std::uint8_t apex = smallest_place(corners);
  for (const Face& face : faces) {
    if (has_place(face, apex)) continue;
    const std::size_t n = n_corners(face);
    const std::size_t first = smallest(corners, face, n);
    for (std::size_t i = 1; i + 1 < n; ++i)
      splitter.add({corners[apex], corners[face[first]], corners[face[(first + i) % n]],
                    corners[face[(first + i + 1) % n]]});
  }
}

/// The corner opposite to another one of a hexahedron.
std::uint8_t opposite_place(std::uint8_t place) {
  constexpr std::array<std::uint8_t, 8> kOpposite = {6, 7, 4, 5, 2, 3, 0, 1};
  return kOpposite[place];
}

/// The faces of a hexahedron round a corner, each from that corner on.
std::array<Face, 3> faces_round(std::uint8_t place) {
  std::array<Face, 3> round{};
  std::size_t n = 0;
  for (const Face& face : kHexahedronFaces) {
    const auto at =
        static_cast<std::size_t>(std::find(face.begin(), face.end(), place) - face.begin());
    if (at == face.size()) continue;
    for (std::size_t i = 0; i < 4; ++i) round[n][i] = face[(at + i) % 4];
    ++n;
  }
  return round;
}

/// Where no diagonal meets the corner opposite to the smallest point, that corner is cut off: 5
/// tetrahedra. Else 6, all from the smallest point.
void split_hexahedron(Corners corners, Splitter& splitter) {
  const std::uint8_t apex = smallest_place(corners);
  const std::uint8_t far = opposite_place(apex);
  std::array<Face, 3> faces = faces_round(far);
  for (const Face& face : faces)
    if (smallest(corners, face, 4) % 2 == 0)
      return split_from_smallest(corners, kHexahedronFaces, splitter);
  // Each face is far, p, its opposite, q; the diagonals p q make a triangle a, b, c.
  for (const Face& face : faces)
    splitter.add({corners[apex], corners[face[1]], corners[face[2]], corners[face[3]]});
  const std::uint32_t a = corners[faces[0][1]];
  const std::uint32_t b = corners[faces[0][3]];
  const std::size_t next = faces[1][1] == faces[0][3] ? 1 : 2;
  const std::uint32_t c = corners[faces[next][3]];
  splitter.add({corners[apex], a, b, c});
  splitter.add({corners[far], a, c, b});
}

void split_voxel(Corners corners, Splitter& splitter) {
  const std::array<std::uint32_t, 8> ordered = {corners[0], corners[1], corners[3], corners[2],
                                                corners[4], corners[5], corners[7], corners[6]};
  split_hexahedron(ordered, splitter);
}

double squared_length(const CellMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const Vec3d edge = mesh.points[a] - mesh.points[b];
  return dot(edge, edge);
}

/// Four at the corners, and the octahedron between the middles of edges round its shortest
/// diagonal; of equally short ones that of the smallest points.
void split_quadratic(const CellMesh& mesh, Corners c, Splitter& splitter) {
  splitter.add({c[0], c[4], c[6], c[7]});
  splitter.add({c[4], c[1], c[5], c[8]});
  splitter.add({c[6], c[5], c[2], c[9]});
  splitter.add({c[7], c[8], c[9], c[3]});
  // The ends of a diagonal, then the ring round it, which turns right-handed about it.
  constexpr std::array<std::array<std::uint8_t, 6>, 3> kDiagonals = {
      {{4, 9, 5, 6, 7, 8}, {5, 7, 4, 8, 9, 6}, {6, 8, 4, 5, 9, 7}}};
  const auto key = [&](const std::array<std::uint8_t, 6>& d) {
    const auto ends = std::minmax(c[d[0]], c[d[1]]);
    return std::tuple(squared_length(mesh, c[d[0]], c[d[1]]), ends.first, ends.second);
  };
  const auto& best =
      *std::min_element(kDiagonals.begin(), kDiagonals.end(),
                        [&](const auto& one, const auto& other) { return key(one) < key(other); });
  for (std::size_t i = 0; i < 4; ++i)
    splitter.add({c[best[0]], c[best[1]], c[best[2 + i]], c[best[2 + (i + 1) % 4]]});
}

/// Cells in which no point sees all triangles that their faces are cut into.
struct Unseen {
  std::uint64_t n = 0;
  std::size_t first = 0;
};

/// Joins the triangles of a cell's faces to a new vertex; of a cell without a place for that,
/// counts it.
Result<void> split_round(const std::optional<Vec3d>& place, std::span<const Triangle> triangles,
                         const CellMesh& mesh, std::size_t cell, SplitCells& split,
                         Unseen& unseen) {
  const std::uint64_t centre = mesh.points.size() + split.centre_cells.size();
  if (centre > kMaxMeshCount)
    return fail("{}: expected at most {} points and centres of cells, got more", mesh.path,
                kMaxMeshCount);
  if (!place) {
    if (unseen.n++ == 0) unseen.first = cell;
    return {};
  }
  split.centre_cells.push_back(static_cast<std::uint32_t>(cell));
  split.centres.push_back(*place);
  Splitter splitter(split);
  splitter.start(cell);
  for (const Triangle& t : triangles)
    splitter.add({static_cast<std::uint32_t>(centre), t[0], t[1], t[2]});
  return {};
}

Result<void> split_polyhedron(const CellMesh& mesh, std::size_t cell, SplitCells& split,
                              Unseen& unseen) {
  LODE_TRY(const std::vector<Triangle> triangles, outward_triangles(mesh, cell));
  return split_round(
      find_centre(mesh, mean_position(mesh, distinct_corners(mesh, cell)), triangles), triangles,
      mesh, cell, split, unseen);
}

/// Round the node in its middle, or a new vertex.
Result<void> split_quadratic_cell(const QuadraticShape& shape, const CellMesh& mesh,
                                  std::size_t cell, SplitCells& split, Unseen& unseen) {
  const Corners nodes = mesh.corners_of(cell);
  const std::vector<Triangle> triangles = quadratic_triangles(mesh, shape, nodes);
  if (!shape.centre)
    return split_round(quadratic_centre(mesh, cell, triangles), triangles, mesh, cell, split,
                       unseen);
  Splitter splitter(split);
  splitter.start(cell);
  for (const Triangle& t : triangles) splitter.add({nodes[*shape.centre], t[0], t[1], t[2]});
  return {};
}

Result<void> split_cell(const CellMesh& mesh, std::size_t cell, SplitCells& split, Unseen& unseen) {
  if (const auto shape = quadratic_shape(mesh, cell))
    return split_quadratic_cell(*shape, mesh, cell, split, unseen);
  Splitter splitter(split);
  splitter.start(cell);
  const Corners corners = mesh.corners_of(cell);
  switch (static_cast<CellType>(mesh.types[cell])) {
    case CellType::tetrahedron:
      splitter.add({corners[0], corners[1], corners[2], corners[3]});
      break;
    case CellType::voxel: split_voxel(corners, splitter); break;
    case CellType::hexahedron: split_hexahedron(corners, splitter); break;
    case CellType::wedge: split_from_smallest(corners, kWedgeFaces, splitter); break;
    case CellType::pyramid: split_from_smallest(corners, kPyramidFaces, splitter); break;
    case CellType::quadratic_tetrahedron: split_quadratic(mesh, corners, splitter); break;
    case CellType::polyhedron: return split_polyhedron(mesh, cell, split, unseen);
    default: break;
  }
  return {};
}

}  // namespace

Result<SplitCells> split_cells(const CellMesh& mesh) {
  SplitCells split;
  Unseen unseen;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell) {
    LODE_CHECK(split_cell(mesh, cell, split, unseen));
    if (split.tetrahedra.size() > kMaxMeshCount)
      return fail("{}: expected cells that split into at most {} tetrahedra, got more", mesh.path,
                  kMaxMeshCount);
  }
  if (unseen.n > 0)
    return fail(
        "{}: expected polyhedra and quadratic cells in which some point sees all triangles that "
        "their faces are cut into, to be split round it, got {} in which none does, the first of "
        "them cell {}{}",
        mesh.path, unseen.n, unseen.first,
        can_linearise(mesh, unseen.first)
            ? ": that of its corners, which --linearise corners takes, is not bent"
            : "");
  return split;
}

}  // namespace lode::io
