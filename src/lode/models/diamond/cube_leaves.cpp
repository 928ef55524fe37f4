#include "lode/models/diamond/cube_leaves.h"

#include <algorithm>

namespace lode::diamond {
namespace {

constexpr std::int32_t kSide = 2;

/// Builds the leaves of the cube with lowest corner `base` and side 2.
class LeavesBuilder {
 public:
  explicit LeavesBuilder(const Index<3>& base) : base_(base) {
    for (const Simplex<3>& whole : kuhn_simplices<3>(base, kSide))
      for (const Simplex<3>& half : bisect(whole)) add_to_face(half);
  }
  [[nodiscard]] const CubeLeaves& result() const { return leaves_; }

 private:
  void add_to_face(const Simplex<3>& s) {
    const CubePoint node = point(s.bisection_point());
    std::size_t f = 0;
    while (f < n_faces_ && leaves_.faces[f].node != node) ++f;
    CubeLeaves::Face& face = leaves_.faces[f];
    const bool is_new = f == n_faces_;
    if (is_new) {
      face.node = node;
      ++n_faces_;
    }
    face.simplices[is_new ? 0 : 1] = simplex(s);
    std::size_t e = is_new ? 0 : 2;
    for (const Simplex<3>& half : bisect(s)) add_edge(half, face, face.edges[e++]);
  }
  void add_edge(const Simplex<3>& s, CubeLeaves::Face& face, CubeLeaves::Edge& edge) {
    edge.node = point(s.bisection_point());
    edge.simplex = simplex(s);
    face.edge_nodes |= CubePoints{1} << edge.node;
    leaves_.edge_nodes |= CubePoints{1} << edge.node;
    const auto halves = bisect(s);
    for (std::size_t i = 0; i < 2; ++i) {
      CubeLeaves::Finer& finer = edge.finer[i];
      finer.simplex = simplex(halves[i]);
      for (std::size_t axis = 0; axis < 3; ++axis)
        finer.octant |= static_cast<std::uint8_t>(finer.simplex.lower[axis] << axis);
    }
  }

  [[nodiscard]] CubePoint point(const Index<3>& p) const { return cube_point(p - base_); }
  [[nodiscard]] CubeSimplex simplex(const Simplex<3>& s) const {
    CubeSimplex result;
    for (std::size_t i = 0; i < 4; ++i) {
      result.corner[i] = point(s.v[i]);
      result.corners |= CubePoints{1} << result.corner[i];
    }
    result.lower = bounds_of(s).lower - base_;
    result.is_positive = dot(cross(s.v[1] - s.v[0], s.v[2] - s.v[0]), s.v[3] - s.v[0]) > 0;
    return result;
  }

  Index<3> base_;
  CubeLeaves leaves_;
  std::size_t n_faces_ = 0;
};

std::array<CubeLeaves, 8> make_all() {
  std::array<CubeLeaves, 8> all;
  for (std::size_t parity = 0; parity < all.size(); ++parity) {
    Index<3> base;
    for (std::size_t i = 0; i < 3; ++i)
      base[i] = kSide * static_cast<std::int32_t>((parity >> i) & 1);
    all[parity] = LeavesBuilder(base).result();
  }
  return all;
}

}  // namespace

const CubeLeaves& CubeLeaves::of(unsigned parity) {
  static const std::array<CubeLeaves, 8> kAll = make_all();
  return kAll[parity];
}

}  // namespace lode::diamond
