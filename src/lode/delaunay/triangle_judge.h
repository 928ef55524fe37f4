#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/triangle_error.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// Every 4th and 16th sample of every 4th and 16th row, from the first.
template <typename T>
class SparseSamples {
 public:
  static constexpr std::array<int, 2> kBits{2, 4};

  SparseSamples(const SampleRows<T>& rows, LatticePoint last) {
    for (std::size_t i = 0; i < kBits.size(); ++i) {
      const int bits = kBits[i];
      const std::int32_t n_columns = (last.x >> bits) + 1;
      const std::int32_t n_rows = (last.y >> bits) + 1;
      const std::int64_t stride = padded_stride(n_columns);
      samples_[i].resize(static_cast<std::size_t>(stride * n_rows + HeightGrid::kPadding));
      for (std::int32_t y = 0; y < n_rows; ++y)
        for (std::int32_t x = 0; x < n_columns; ++x)
          samples_[i][static_cast<std::size_t>(y * stride + x)] =
              rows.samples[(y << bits) * rows.stride + (x << bits)];
      rows_[i] = {samples_[i].data(), stride, rows.packing, bits};
    }
  }
  /// The sparsest that a triangle still has a hundred samples of, about; null: it is too small.
  [[nodiscard]] const SampleRows<T>* choose(std::int64_t doubled_area) const {
    if (doubled_area >= kLarge[1]) return &rows_[1];
    return doubled_area >= kLarge[0] ? &rows_[0] : nullptr;
  }

 private:
  static constexpr std::array<std::int64_t, 2> kLarge{1 << 12, 1 << 16};

  std::array<HeightGrid::Samples<T>, 2> samples_;
  std::array<SampleRows<T>, 2> rows_;
};

/// Finds out whether triangles are within a tolerance, and the samples to insert where they are
/// not.
template <typename T>
class TriangleJudge {
 public:
  /// `sparse`, of orders that are not strict: where those alone show that a triangle is beyond the
  /// tolerance, the worst of them is taken for its candidate; null: the worst of all samples always
  /// is. `observer` may be null.
  TriangleJudge(const SampleRows<T>& rows, const SparseSamples<T>* sparse, double lower,
                double upper, double max_error, InsertionObserver* observer)
      : rows_(rows),
        sparse_(sparse),
        observer_(observer),
        lane_slack_(lane_slack<T>(lower, upper)),
        double_slack_(double_slack(lower, upper)),
        max_error_(max_error),
        find_(find_worst_sample<T>()) {}

  void judge_all(LatticeMesh& mesh) const {
    const auto n = static_cast<std::uint32_t>(mesh.triangles().size());
    for (std::uint32_t t = 0; t < n; ++t) judge(mesh.triangle(t));
    if (observer_ != nullptr) observer_->on_start(mesh, {});
  }
  void judge_some(LatticeMesh& mesh, std::span<const std::uint32_t> slots) const {
    for (const std::uint32_t t : slots) judge(mesh.triangle(t));
  }
  /// Inserts the candidate of a triangle into the mesh, and judges the new triangles.
  std::span<const std::uint32_t> insert(LatticeMesh& mesh, std::uint32_t t) const {
    const std::size_t n_before = mesh.triangles().size();
    const std::uint32_t node = mesh.triangle(t).candidate;
    const std::span<const std::uint32_t> made = mesh.insert(node, t);
    for (const std::uint32_t one : made) judge(mesh.triangle(one));
    if (observer_ != nullptr) {
      const std::size_t n_added = mesh.triangles().size() - n_before;
      observer_->on_insertion(mesh, node, made, made.size() - n_added, {});
    }
    return made;
  }

 private:
  /// Sets the triangle's candidate (kNone: all within the tolerance) and error, a bound of all.
  void judge(LatticeTriangle& triangle) const {
    const std::array<double, 3> z = heights(triangle);
    if (sparse_ != nullptr && judge_sparsely(triangle, z)) return;
    WorstSample worst = find_(rows_, lane_slack_, triangle.corner, z);
    // Not within the tolerance, and not surely beyond: rounding must not decide.
    const bool is_sure = worst.error - 2 * worst.slack > max_error_ && !is_corner(triangle, worst);
    if ((worst.error > max_error_ && !is_sure) || (sparse_ == nullptr && is_kept_larger(worst)))
      worst = find_worst_exactly(rows_, double_slack_, triangle.corner);
    triangle.candidate = worst.error > max_error_ ? worst.node : WorstSample::kNone;
    triangle.error = to_float_above(worst.error);
  }
  /// Whether who keeps coarse errors might keep a larger one than is needed. So that these are as
  /// exact as they can be, and a selector that keeps none inserts the same samples, strict orders
  /// ask.
  [[nodiscard]] static bool is_kept_larger(const WorstSample& worst) {
    const double least = std::max(0.0, worst.error - 2 * worst.slack);
    return to_coarse_above(to_float_above(least)) != to_coarse_above(to_float_above(worst.error));
  }
  [[nodiscard]] static bool is_corner(const LatticeTriangle& triangle, const WorstSample& worst) {
    const auto& corner = triangle.corner;
    return worst.node == corner[0] || worst.node == corner[1] || worst.node == corner[2];
  }
  [[nodiscard]] std::array<double, 3> heights(const LatticeTriangle& triangle) const {
    std::array<double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i)
      z[i] = rows_.height(rows_.packing.unpack(triangle.corner[i]));
    return z;
  }
  bool judge_sparsely(LatticeTriangle& triangle, const std::array<double, 3>& z) const {
    const auto at = [&](std::size_t i) { return rows_.packing.unpack(triangle.corner[i]); };
    const SampleRows<T>* rows = sparse_->choose(doubled_area(at(0), at(1), at(2)));
    if (rows == nullptr) return false;
    const WorstSample worst = find_(*rows, lane_slack_, triangle.corner, z);
    if (!(worst.error - 2 * worst.slack > max_error_) || is_corner(triangle, worst)) return false;
    triangle.candidate = worst.node;
    triangle.error = to_float_above(worst.error);
    return true;
  }

  SampleRows<T> rows_;
  const SparseSamples<T>* sparse_;
  InsertionObserver* observer_;
  RoundingSlack lane_slack_;
  RoundingSlack double_slack_;
  double max_error_;
  FindWorst<T> find_;
};

}  // namespace lode::delaunay
