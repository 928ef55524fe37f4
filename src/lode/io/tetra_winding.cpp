#include "lode/io/tetra_winding.h"

#include <cstdint>
#include <utility>

#include "lode/io/tetra_orientation.h"

namespace lode::io {
namespace {

CellType type_of_tetrahedron(const CellMesh& mesh, const SplitCells& split, std::size_t i) {
  return static_cast<CellType>(mesh.types[split.cells[i]]);
}

bool is_wedge(CellType type) {
  return type == CellType::wedge || type == CellType::quadratic_wedge ||
         type == CellType::biquadratic_wedge;
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

/// What of a component is turned round.
struct Turn {
  std::int64_t votes = 0;     ///< Signs, as if all were wound alike where they can be;
  std::int64_t n_other = 0;   ///< how many are wound the other way,
  std::int64_t n_all = 0;     ///< of how many.
  bool is_orientable = true;  ///< Else all turn, or none, but for polyhedra.
  std::uint8_t turned_winding = 0;
};

/// Those wound the other way turn, unless most volumes are negative then.
std::uint8_t winding_to_turn(const Turn& turn) {
  const bool is_tie = turn.votes == 0;
  const bool are_others_fewer = 2 * turn.n_other <= turn.n_all;
  return turn.votes > 0 || (is_tie && are_others_fewer) ? 1 : 0;
}

class Winding {
 public:
  Winding(const CellMesh& mesh, const TetraFaces& faces, SplitCells& split,
          std::vector<std::int8_t> signs)
      : mesh_(mesh),
        faces_(faces),
        split_(split),
        signs_(std::move(signs)),
        ways_(faces.windings) {}

  void turn_wedges(TetraReport& report);
  void turn_components(TetraReport& report);
  [[nodiscard]] const std::vector<std::int8_t>& signs() const { return signs_; }

 private:
  /// Of a polyhedron, whose faces say what is outside: no order of corners in a file is wrong.
  [[nodiscard]] bool is_of_polyhedron(std::size_t i) const {
    return type_of_tetrahedron(mesh_, split_, i) == CellType::polyhedron;
  }
  [[nodiscard]] bool is_turned(const Turn& of, std::size_t i) const {
    return of.is_orientable ? ways_[i] == of.turned_winding : of.votes < 0 && !is_of_polyhedron(i);
  }
  void turn(std::size_t i) {
    std::swap(split_.tetrahedra[i][2], split_.tetrahedra[i][3]);
    signs_[i] = static_cast<std::int8_t>(-signs_[i]);
    ways_[i] ^= 1;
  }

  const CellMesh& mesh_;
  const TetraFaces& faces_;
  SplitCells& split_;
  std::vector<std::int8_t> signs_;
  std::vector<std::uint8_t> ways_;  ///< TetraFaces::windings, as they are now.
};

void Winding::turn_wedges(TetraReport& report) {
  std::int64_t wedge_votes = 0;
  std::int64_t other_votes = 0;
  for (std::size_t i = 0; i < signs_.size(); ++i) {
    if (is_of_polyhedron(i)) continue;
    const CellType type = type_of_tetrahedron(mesh_, split_, i);
    (is_wedge(type) ? wedge_votes : other_votes) += signs_[i];
  }
  if (!((wedge_votes < 0 && other_votes > 0) || (wedge_votes > 0 && other_votes < 0))) return;
  for (std::size_t i = 0; i < signs_.size(); ++i)
    if (is_wedge(type_of_tetrahedron(mesh_, split_, i))) {
      turn(i);
      ++report.n_turned_wedges;
    }
}

void Winding::turn_components(TetraReport& report) {
  std::vector<Turn> turns(faces_.n_components);
  for (std::size_t i = 0; i < turns.size(); ++i)
    turns[i].is_orientable = faces_.is_orientable[i] != 0;
  for (std::size_t i = 0; i < signs_.size(); ++i) {
    Turn& of = turns[faces_.components[i]];
    if (!of.is_orientable && is_of_polyhedron(i)) continue;
    const bool is_other = of.is_orientable && ways_[i] != 0;
    of.votes += is_other ? -signs_[i] : signs_[i];
    of.n_other += is_other ? 1 : 0;
    ++of.n_all;
  }
  for (Turn& of : turns) of.turned_winding = winding_to_turn(of);
  for (std::size_t i = 0; i < signs_.size(); ++i) {
    if (!is_turned(turns[faces_.components[i]], i)) continue;
    turn(i);
    if (!is_of_polyhedron(i)) ++report.n_left_handed;
  }
}

}  // namespace

void turn_round(const CellMesh& mesh, const std::vector<Vec3d>& points, const TetraFaces& faces,
                SplitCells& split, TetraReport& report) {
  Winding winding(mesh, faces, split, signs_of(points, split));
  winding.turn_wedges(report);
  winding.turn_components(report);
  for (const std::int8_t sign : winding.signs()) {
    if (sign == 0) ++report.n_zero_volume;
    if (sign < 0) ++report.n_inverted;
  }
}

}  // namespace lode::io
