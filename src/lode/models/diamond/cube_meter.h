#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "lode/mappers/kuhn_cube.h"
#include "lode/mappers/lattice_frame.h"
#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/cell_pieces.h"

namespace lode::diamond {

/// How far a surface in the style of cubes is from the level set of F.
struct CubeDeviation {
  double error = 0;     ///< Largest |F - isovalue| on its triangles, but for rounding. Field units.
  double distance = 0;  ///< No point of them is farther from F = isovalue. World units.

  void join(const CubeDeviation& other) {
    error = std::max(error, other.error);
    distance = std::max(distance, other.distance);
  }
};

/// What cells keep to that are cubes.
struct CubeLimit {
  double error = std::numeric_limits<double>::infinity();  ///< Of |F - isovalue|, field units.
  /// Between their triangles and the tetrahedra's, both ways, world units.
  double distance = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool is_none() const { return std::isinf(error) && std::isinf(distance); }
};

/// Measures the triangles of unit cells in the style of cubes, cell after cell, from the samples:
/// each triangle is cut by the cell's tetrahedra, on which F is linear, and distances to the level
/// set in one of them are convex, so both are largest at corners of the pieces. One per worker.
class CubeMeter {
 public:
  CubeMeter(const LatticeFrame& frame, double isovalue) : frame_(frame), isovalue_(isovalue) {}

  void add(const FieldSamples& samples, const Index3& cell);
  /// Of those added.
  [[nodiscard]] const CubeDeviation& deviation() const { return deviation_; }
  /// Whether one cell's triangles, which are not added, do not keep to a limit: |F - isovalue| is
  /// above its error; or they and the tetrahedra's are not seen to be within its distance, all
  /// points of either, or a vertex on a face's diagonal moves farther where it goes onto them
  /// (CellMarcher).
  [[nodiscard]] bool exceeds(const FieldSamples& samples, const Index3& cell,
                             const CubeLimit& limit);

 private:
  static constexpr double kRounding = 0x1p-40;

  /// A convex polygon in a plane, of three or four corners, or none.
  struct FlatPolygon {
    std::array<Vec3d, 4> corner;
    std::array<std::uint8_t, 4> edge{};  ///< Of the tetrahedra, where a corner is.
    std::size_t n = 0;
    Vec3d normal;  ///< Of any length.
    double squared_normal = 0;
    std::array<Vec3d, 4> inward;  ///< In the plane, across the edges from corners; of any length.

    void find_normal();
    [[nodiscard]] bool is_near(const Vec3d& p, double limit2) const;
  };

  [[nodiscard]] bool errs(double limit);
  [[nodiscard]] bool strays(double limit);
  void open(const FieldSamples& samples, const Index3& cell);
  void place_vertices();
  [[nodiscard]] Vec3d vertex(std::size_t e) const;
  [[nodiscard]] bool may_add();
  [[nodiscard]] double error_bound() const;
  /// Of an edge between corners, how far from a its vertex is.
  [[nodiscard]] double share_of(std::size_t a, std::size_t b) const {
    const double first = field_.at_corner(a);
    return std::clamp(first / (first - field_.at_corner(b)), frame_.margin, 1 - frame_.margin);
  }
  [[nodiscard]] bool is_crossed(std::size_t a, std::size_t b) const {
    return ((corners_ >> a ^ corners_ >> b) & 1) != 0;
  }
  [[nodiscard]] Vec3d vertex_on(std::size_t a, std::size_t b) const;
  void add_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c);
  [[nodiscard]] double error_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) const;
  void find_level_set();
  [[nodiscard]] double distance_to_values(const Piece& part) const;
  [[nodiscard]] double distance_of(const Piece& part, double enough);
  [[nodiscard]] double farthest_move() const;
  [[nodiscard]] double farthest_inside() const;
  [[nodiscard]] double farthest_vertex() const;
  [[nodiscard]] bool is_cube_near(double limit);
  [[nodiscard]] bool is_level_set_near(double limit) const;
  [[nodiscard]] unsigned triangles_near(const Vec3d& p, double limit2) const;
  [[nodiscard]] bool are_parts_near(std::span<const Vec3d> polygon, double limit2, int depth) const;
  [[nodiscard]] static double squared_distance(const Vec3d& p, const FlatPolygon& polygon);

  LatticeFrame frame_;
  double isovalue_;
  CellField field_;
  Mat3 to_world_;
  Vec3d diagonals_;       ///< Lengths of those of its faces, by axis, in the world.
  unsigned corners_ = 0;  ///< Inside, of the open cell: bits;
  const KuhnCubeCase* case_ = nullptr;
  std::array<Vec3d, 19> vertices_;  ///< and its vertices, in local coordinates, once placed.
  static constexpr std::size_t kLatticeEdges = 19;  ///< Of its tetrahedra.
  std::array<Vec3d, kLatticeEdges> crossings_;      ///< With the isovalue, as level_set_.
  unsigned crossed_ = 0;                            ///< Bits: edges that have one.
  std::array<FlatPolygon, 6> level_set_;
  std::array<FlatPolygon, 12> cube_;  ///< Its triangles, where they are wanted; as level_set_.
  bool has_level_set_ = false;
  double farthest_vertex_ = -1;  ///< Between cube and tetrahedra, if it is known.
  CubeDeviation deviation_;
};

}  // namespace lode::diamond
