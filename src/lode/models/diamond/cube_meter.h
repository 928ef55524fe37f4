#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

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

/// Measures the triangles of unit cells in the style of cubes, cell after cell, from the samples:
/// each triangle is cut by the cell's tetrahedra, on which F is linear, and distances to the level
/// set in one of them are convex, so both are largest at corners of the pieces. One per worker.
class CubeMeter {
 public:
  CubeMeter(const LatticeFrame& frame, double isovalue) : frame_(frame), isovalue_(isovalue) {}

  void add(const FieldSamples& samples, const Index3& cell);
  /// Of those added.
  [[nodiscard]] const CubeDeviation& deviation() const { return deviation_; }
  /// Whether |F - isovalue| is above a limit on one cell's triangles, which are not added.
  [[nodiscard]] bool exceeds(const FieldSamples& samples, const Index3& cell, double limit);

 private:
  /// A convex polygon in a plane, of three or four corners, or none.
  struct FlatPolygon {
    std::array<Vec3d, 4> corner;
    std::size_t n = 0;
    Vec3d normal;  ///< Of any length.
    double squared_normal = 0;

    void find_normal();
  };

  void open(const FieldSamples& samples, const Index3& cell);
  [[nodiscard]] Vec3d vertex_on(std::size_t a, std::size_t b) const;
  void add_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c);
  [[nodiscard]] double error_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) const;
  void find_level_set();
  [[nodiscard]] double distance_to_values(const Piece& part) const;
  [[nodiscard]] double distance_of(const Piece& part);
  [[nodiscard]] static double squared_distance(const Vec3d& p, const FlatPolygon& polygon);

  LatticeFrame frame_;
  double isovalue_;
  CellField field_;
  Mat3 to_world_;
  const KuhnCubeCase* case_ = nullptr;  ///< Of the open cell,
  std::array<Vec3d, 19> vertices_;      ///< and its vertices, in local coordinates.
  std::array<FlatPolygon, 6> level_set_;
  bool has_level_set_ = false;
  CubeDeviation deviation_;
};

}  // namespace lode::diamond
