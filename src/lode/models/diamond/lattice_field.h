#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "lode/core/volume.h"
#include "lode/models/diamond/error_code.h"
#include "lode/models/diamond/lattice.h"
#include "lode/models/diamond/storage_type.h"

namespace lode::diamond {

/// Facts about the samples, found while they are read.
struct FieldStats {
  double min = 0;  ///< Of the samples that are no holes; both 0 when there is none.
  double max = 0;
  std::uint64_t n_holes = 0;
  std::uint64_t n_removed_cells = 0;  ///< Unit cells that touch a hole.

  friend bool operator==(const FieldStats&, const FieldStats&) = default;
};

/// Which axes of the grid the lattice uses: all three for diamond3d; for diamond2d the two that
/// have more than one sample (or the first ones, where fewer have).
template <int D>
struct AxisMap {
  std::array<int, as_size(D)> axis{};

  [[nodiscard]] static AxisMap of(const Index3& dims) {
    AxisMap map;
    int n = 0;
    for (int i = 0; i < 3 && n < D; ++i)
      if (D == 3 || dims[as_size(i)] > 1) map.axis[as_size(n++)] = i;
    for (int i = 0; i < 3 && n < D; ++i)
      if (dims[as_size(i)] == 1) map.axis[as_size(n++)] = i;
    std::sort(map.axis.begin(), map.axis.end());
    return map;
  }
  [[nodiscard]] Index<D> lattice_dims(const Index3& dims) const {
    Index<D> result;
    for (std::size_t i = 0; i < as_size(D); ++i) result[i] = dims[as_size(axis[i])];
    return result;
  }
  template <typename S>
  [[nodiscard]] Vec<S, 3> to_grid(const Vec<S, as_size(D)>& p) const {
    Vec<S, 3> result;
    for (std::size_t i = 0; i < as_size(D); ++i) result[as_size(axis[i])] = p[i];
    return result;
  }
};

/// Of the hierarchy of a grid with so many samples.
template <int D>
[[nodiscard]] Shape<D> shape_of(const Index3& dims) {
  return Shape<D>::of(AxisMap<D>::of(dims).lattice_dims(dims));
}

/// A node's nested attributes as they are stored.
struct StoredAttributes {
  ErrorCode error = 0;  ///< Rounded up.
  float low = 0;        ///< Minimum above range_reference(), rounded down;
  float high = 0;       ///< maximum, likewise, rounded up; < low: no finite sample.
};

/// A volume on the lattice of a diamond hierarchy, and what follows from its samples wherever they
/// lie. `Field` gives them: value(p), the sample at a lattice point, holes as they are; outside the
/// data that of the nearest sample.
template <int D, typename Field>
struct LatticeField {
  VolumeInfo info;
  ScalarType storage = ScalarType::uint8;  ///< How samples are held: storage_type(info.type).
  AxisMap<D> axes;
  Shape<D> shape;
  FieldStats stats;

  /// All but the stats.
  void set_info(const VolumeInfo& volume) {
    info = volume;
    storage = storage_type(volume.type);
    axes = AxisMap<D>::of(volume.grid.dims);
    shape = shape_of<D>(volume.grid.dims);
  }
  [[nodiscard]] std::size_t sample_size() const { return size_of(storage); }
  [[nodiscard]] bool has_holes() const { return stats.n_holes > 0; }
  /// As value(), but NaN for a hole.
  [[nodiscard]] double value_or_nan(const Index<D>& p) const {
    const double sample = value(p);
    return has_holes() && is_hole(sample) ? std::numeric_limits<double>::quiet_NaN() : sample;
  }
  [[nodiscard]] Index<D> clamped(Index<D> p) const {
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = std::clamp(p[i], 0, shape.dims[i] - 1);
    return p;
  }
  [[nodiscard]] bool is_hole(double sample) const {
    return !std::isfinite(sample) || (info.nodata && sample == *info.nodata);
  }
  /// Whether the unit cell with this lowest corner touches a hole. Must lie in the data.
  [[nodiscard]] bool is_removed_cell(const Index<D>& cell) const {
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> p = cell;
      for (int i = 0; i < D; ++i) p[as_size(i)] += (corner >> i) & 1;
      if (is_hole(value(p))) return true;
    }
    return false;
  }
  /// Whether the unit cells round a sample have both holes and finite samples at their corners:
  /// simplices that meet there must be refined. So what has a finite nested error has no removed
  /// cell, or none but holes.
  [[nodiscard]] bool is_mixed(const Index<D>& p) const {
    if (!shape.is_sample(p)) return false;
    bool has_hole = false;
    bool has_finite = false;
    const Index<D> round = all_equal<D>(3);
    for (std::size_t i = 0; i < n_points<D>(round); ++i) {
      const Index<D> q = p + point_of<D>(round, i) - all_equal<D>(1);
      if (shape.is_sample(q)) (is_hole(value(q)) ? has_hole : has_finite) = true;
    }
    return has_hole && has_finite;
  }
  /// The lowest corner of a unit cell in the data that one of the simplex's finest ones lies in.
  [[nodiscard]] std::optional<Index<D>> cell_inside(const Simplex<D>& s) const {
    const LatticeBox<D> box = bounds_of(s);
    if (!shape.overlaps_data(box)) return {};
    if (is_finest(s)) return box.lower;
    for (const Simplex<D>& half : bisect(s))
      if (const auto cell = cell_inside(half)) return cell;
    return {};
  }
  /// Whether holes remove a simplex that is finest or has a finite error: as a whole or not at all,
  /// so that the first of its cells that is in the data tells.
  [[nodiscard]] bool is_removed(const Simplex<D>& s) const {
    const auto cell = cell_inside(s);
    return cell && is_removed_cell(*cell);
  }
  /// What ranges are stored relative to, so that float32 keeps them tight: the field's minimum,
  /// or 0 for integers of up to 16 bits, which float32 holds.
  [[nodiscard]] double range_reference() const { return sample_size() <= 2 ? 0.0 : stats.min; }

 private:
  friend Field;
  [[nodiscard]] double value(const Index<D>& p) const {
    return static_cast<const Field&>(*this).value(p);
  }
};

}  // namespace lode::diamond
