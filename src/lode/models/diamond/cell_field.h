#pragma once

#include <array>
#include <cstdint>

#include "lode/core/vec.h"
#include "lode/core/volume.h"

namespace lode::diamond {

/// The samples of a regular grid, one by one: what the checks need to know of the full-resolution
/// field. Must be safe to read from many threads.
class FieldSamples {
 public:
  virtual ~FieldSamples() = default;
  /// Where the samples are.
  [[nodiscard]] virtual const RegularGrid& grid() const = 0;
  /// The sample at `index`, inside the grid; not finite where it is a hole.
  [[nodiscard]] virtual double sample(const Index3& index) const = 0;
  /// Those at the corners of a unit cell inside the grid: `even` and steps of -1, 0 or 1 from it,
  /// along axis i in corners with bit i.
  virtual void find_corners(const Index3& even, const Index3& step,
                            std::array<double, 8>& values) const;
};

/// The samples of a Volume, which must outlive this; nodata samples are holes.
class VolumeSamples final : public FieldSamples {
 public:
  explicit VolumeSamples(const Volume& volume) : volume_(volume) {}
  [[nodiscard]] const RegularGrid& grid() const override { return volume_.info.grid; }
  [[nodiscard]] double sample(const Index3& index) const override;

 private:
  const Volume& volume_;
};

/// The full-resolution field on one unit cell, minus an isovalue: linear on the six Kuhn
/// tetrahedra round the diagonal from the corner whose coordinates are all even to the all-odd
/// one. Along an axis of one sample it is constant, which leaves two triangles of a 2D cell.
class CellField {
 public:
  CellField() = default;
  CellField(const FieldSamples& samples, const Index3& cell, double isovalue);

  [[nodiscard]] const Index3& cell() const { return cell_; }
  [[nodiscard]] double isovalue() const { return isovalue_; }
  /// A corner is a hole: the cell is no part of the domain.
  [[nodiscard]] bool is_removed() const { return is_removed_; }
  /// The largest |F - isovalue| at a corner.
  [[nodiscard]] double magnitude() const { return magnitude_; }

  /// Coordinates from the all-even corner, each clamped to [0, 1].
  [[nodiscard]] Vec3d to_local(const Vec3d& index) const;
  [[nodiscard]] Vec3d to_index(const Vec3d& local) const;
  /// F - isovalue at the corner that is odd along the axes of `corner`'s bits.
  [[nodiscard]] double at_corner(std::size_t corner) const { return values_[corner]; }
  /// The way from the all-even corner to the all-odd one: -1, 0 or 1 along each axis.
  [[nodiscard]] const Index3& step() const { return step_; }
  /// F - isovalue at local coordinates.
  [[nodiscard]] double value_at(const Vec3d& local) const;

 private:
  Index3 cell_{{-1, -1, -1}};
  double isovalue_ = 0;
  Index3 even_;                     ///< The all-even corner,
  Index3 step_;                     ///< and the way from it to the all-odd one: -1, 0 or 1.
  std::array<double, 8> values_{};  ///< Bit i of the position: odd on axis i.
  double magnitude_ = 0;
  bool is_removed_ = true;
};

/// Whether `cell` is a cell of the lattice at all.
[[nodiscard]] bool is_cell(const Index3& dims, const Index3& cell);

/// Whether a corner of the cell is a hole.
[[nodiscard]] bool is_removed_cell(const FieldSamples& samples, const Index3& cell);

}  // namespace lode::diamond
