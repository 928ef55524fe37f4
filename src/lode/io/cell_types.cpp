#include "lode/io/cell_types.h"

#include <algorithm>
#include <array>

namespace lode::io {
namespace {

struct NumberedKind {
  std::uint8_t type = 0;
  CellKind kind;
};

/// In the order of their numbers: vtkCellType.h of VTK 9.
constexpr std::array<NumberedKind, 64> kKinds = {{
    {0, {"empty cell", 0, 0}},
    {1, {"vertex", 0, 1}},
    {2, {"poly-vertex", 0, 0}},
    {3, {"line", 1, 2}},
    {4, {"polyline", 1, 0}},
    {5, {"triangle", 2, 3}},
    {6, {"triangle strip", 2, 0}},
    {7, {"polygon", 2, 0}},
    {8, {"pixel", 2, 4}},
    {9, {"quad", 2, 4}},
    {10, {"tetrahedron", 3, 4}},
    {11, {"voxel", 3, 8}},
    {12, {"hexahedron", 3, 8}},
    {13, {"wedge", 3, 6}},
    {14, {"pyramid", 3, 5}},
    {15, {"pentagonal prism", 3, 10}},
    {16, {"hexagonal prism", 3, 12}},
    {21, {"quadratic edge", 1, 3}},
    {22, {"quadratic triangle", 2, 6}},
    {23, {"quadratic quad", 2, 8}},
    {24, {"quadratic tetrahedron", 3, 10}},
    {25, {"quadratic hexahedron", 3, 20}},
    {26, {"quadratic wedge", 3, 15}},
    {27, {"quadratic pyramid", 3, 13}},
    {28, {"biquadratic quad", 2, 9}},
    {29, {"triquadratic hexahedron", 3, 27}},
    {30, {"quadratic-linear quad", 2, 6}},
    {31, {"quadratic-linear wedge", 3, 12}},
    {32, {"biquadratic wedge", 3, 18}},
    {33, {"biquadratic hexahedron", 3, 24}},
    {34, {"biquadratic triangle", 2, 7}},
    {35, {"cubic line", 1, 4}},
    {36, {"quadratic polygon", 2, 0}},
    {37, {"triquadratic pyramid", 3, 19}},
    {41, {"convex point set", 3, 0}},
    {42, {"polyhedron", 3, 0}},
    {51, {"parametric curve", 1, 0}},
    {52, {"parametric surface", 2, 0}},
    {53, {"parametric triangle", 2, 0}},
    {54, {"parametric quad", 2, 0}},
    {55, {"parametric tetrahedron", 3, 0}},
    {56, {"parametric hexahedron", 3, 0}},
    {60, {"higher-order edge", 1, 0}},
    {61, {"higher-order triangle", 2, 0}},
    {62, {"higher-order quad", 2, 0}},
    {63, {"higher-order polygon", 2, 0}},
    {64, {"higher-order tetrahedron", 3, 0}},
    {65, {"higher-order wedge", 3, 0}},
    {66, {"higher-order pyramid", 3, 0}},
    {67, {"higher-order hexahedron", 3, 0}},
    {68, {"Lagrange curve", 1, 0}},
    {69, {"Lagrange triangle", 2, 0}},
    {70, {"Lagrange quad", 2, 0}},
    {71, {"Lagrange tetrahedron", 3, 0}},
    {72, {"Lagrange hexahedron", 3, 0}},
    {73, {"Lagrange wedge", 3, 0}},
    {74, {"Lagrange pyramid", 3, 0}},
    {75, {"Bezier curve", 1, 0}},
    {76, {"Bezier triangle", 2, 0}},
    {77, {"Bezier quad", 2, 0}},
    {78, {"Bezier tetrahedron", 3, 0}},
    {79, {"Bezier hexahedron", 3, 0}},
    {80, {"Bezier wedge", 3, 0}},
    {81, {"Bezier pyramid", 3, 0}},
}};

}  // namespace

std::optional<CellKind> cell_kind(std::uint8_t type) {
  const auto* const found = std::lower_bound(
      kKinds.begin(), kKinds.end(), type,
      [](const NumberedKind& kind, std::uint8_t number) { return kind.type < number; });
  if (found == kKinds.end() || found->type != type) return std::nullopt;
  return found->kind;
}

bool is_solid(std::uint8_t type) {
  const auto kind = cell_kind(type);
  return kind && kind->dimension == 3;
}

}  // namespace lode::io
