#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>

#include "lode/delaunay/triangle_judge.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// Judges triangles of a tile whose sides are not to be split: samples there are known to err by no
/// more than `side_error`, which is within the tolerance. Of integers TriangleJudge finds just that
/// and never names one. Of floats rounding may make it name one; then the worst of all others is
/// looked for.
template <typename T>
class TileJudge {
 public:
  TileJudge(const TriangleJudge<T>& judge, const SampleRows<T>& rows, const LatticePart& part,
            const RoundingSlack& slack, double max_error, double side_error)
      : judge_(judge),
        rows_(rows),
        part_(part),
        slack_(slack),
        max_error_(max_error),
        side_error_(side_error) {}

  void judge_all(LatticeMesh& mesh) const {
    judge_.judge_all(mesh);
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) pass_over_sides(mesh.triangle(t));
  }
  std::span<const std::uint32_t> insert(LatticeMesh& mesh, std::uint32_t t) const {
    const std::span<const std::uint32_t> made = judge_.insert(mesh, t);
    for (const std::uint32_t one : made) pass_over_sides(mesh.triangle(one));
    return made;
  }

 private:
  void pass_over_sides(LatticeTriangle& triangle) const {
    if constexpr (std::is_floating_point_v<T>) {
      if (triangle.candidate == WorstSample::kNone) return;
      const LatticePoint p = rows_.packing.unpack(triangle.candidate);
      if (p.x > part_.first.x && p.x < part_.last.x && p.y > part_.first.y && p.y < part_.last.y)
        return;
      const WorstSample worst = find_worst_inside(rows_, slack_, triangle.corner, part_);
      triangle.candidate = worst.error > max_error_ ? worst.node : WorstSample::kNone;
      triangle.error = to_float_above(std::max(worst.error, side_error_));
    }
  }

  const TriangleJudge<T>& judge_;
  SampleRows<T> rows_;
  LatticePart part_;
  RoundingSlack slack_;
  double max_error_;
  double side_error_;
};

}  // namespace lode::delaunay
