#include "lode/io/tetra_winding.h"

#include <cstdint>
#include <utility>

#include "lode/io/tetra_orientation.h"

namespace lode::io {
namespace {

CellType type_of_tetrahedron(const CellMesh& mesh, const SplitCells& split, std::size_t i) {
  return static_cast<CellType>(mesh.types[split.cells[i]]);
}

/// Of each tetrahedron: 1, 0 or -1.
std::vector<std::int8_t> signs_of(const std::vector<Vec3d>& points, const SplitCells& split) {
  std::vector<std::int8_t> signs(split.tetrahedra.size());
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const auto& [a, b, c, d] = split.tetrahedra[i];
    signs[i] = static_cast<std::int8_t>(orientation(points[a], points[b], points[c], points[d]));
  }
  return signs;
}

void turn(std::size_t i, SplitCells& split, std::vector<std::int8_t>& signs) {
  std::swap(split.tetrahedra[i][2], split.tetrahedra[i][3]);
  signs[i] = static_cast<std::int8_t>(-signs[i]);
}

void turn_wedges(const CellMesh& mesh, SplitCells& split, std::vector<std::int8_t>& signs,
                 TetraReport& report) {
  std::int64_t wedge_votes = 0;
  std::int64_t other_votes = 0;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const CellType type = type_of_tetrahedron(mesh, split, i);
    if (type == CellType::polyhedron) continue;
    (type == CellType::wedge ? wedge_votes : other_votes) += signs[i];
  }
  if (!((wedge_votes < 0 && other_votes > 0) || (wedge_votes > 0 && other_votes < 0))) return;
  for (std::size_t i = 0; i < signs.size(); ++i)
    if (type_of_tetrahedron(mesh, split, i) == CellType::wedge) {
      turn(i, split, signs);
      ++report.n_turned_wedges;
    }
}

void turn_components(const CellMesh& mesh, const TetraFaces& faces, SplitCells& split,
                     std::vector<std::int8_t>& signs, TetraReport& report) {
  const auto is_voter = [&](std::size_t i) {
    return type_of_tetrahedron(mesh, split, i) != CellType::polyhedron;
  };
  std::vector<std::int64_t> votes(faces.n_components);
  for (std::size_t i = 0; i < signs.size(); ++i)
    if (is_voter(i)) votes[faces.components[i]] += signs[i];
  for (std::size_t i = 0; i < signs.size(); ++i)
    if (is_voter(i) && votes[faces.components[i]] < 0) {
      turn(i, split, signs);
      ++report.n_left_handed;
    }
}

}  // namespace

void turn_round(const CellMesh& mesh, const std::vector<Vec3d>& points, const TetraFaces& faces,
                SplitCells& split, TetraReport& report) {
  std::vector<std::int8_t> signs = signs_of(points, split);
  turn_wedges(mesh, split, signs, report);
  turn_components(mesh, faces, split, signs, report);
  for (const std::int8_t sign : signs) {
    if (sign == 0) ++report.n_zero_volume;
    if (sign < 0) ++report.n_inverted;
  }
}

}  // namespace lode::io
