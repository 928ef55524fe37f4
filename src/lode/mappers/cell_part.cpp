#include "lode/mappers/cell_part.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lode {
namespace {

/// A corner, relative to the tetrahedron's first one, and the function there.
struct PartCorner {
  Vec3d at;
  double value = 0;
};
using Part = std::array<PartCorner, 4>;

/// Points with sign * (coordinate - offset) >= 0.
struct CutPlane {
  std::size_t axis = 0;
  double offset = 0;
  double sign = 1;

  [[nodiscard]] double height(const PartCorner& corner) const {
    return sign * (corner.at[axis] - offset);
  }
  /// Where it cuts an edge.
  [[nodiscard]] PartCorner cut(const PartCorner& inside, const PartCorner& outside) const {
    const double t = height(inside) / (height(inside) - height(outside));
    PartCorner made{inside.at + (outside.at - inside.at) * t,
                    inside.value + (outside.value - inside.value) * t};
    made.at[axis] = offset;
    return made;
  }
};

/// What of a part is inside a plane, in up to three parts.
void cut_part(const Part& part, const CutPlane& plane, std::vector<Part>& out) {
  std::array<PartCorner, 4> in;
  std::array<PartCorner, 4> off;
  std::size_t n_in = 0;
  std::size_t n_off = 0;
  bool has_inner = false;
  for (const PartCorner& corner : part) {
    const double height = plane.height(corner);
    has_inner = has_inner || height > 0;
    if (height >= 0)
      in[n_in++] = corner;
    else
      off[n_off++] = corner;
  }
  if (n_off == 0) out.push_back(part);
  if (n_off == 0 || !has_inner) return;
  const auto cut = [&](std::size_t i, std::size_t k) { return plane.cut(in[i], off[k]); };
  if (n_in == 1) {
    out.push_back({in[0], cut(0, 0), cut(0, 1), cut(0, 2)});
    return;
  }
  // A prism between two triangles.
  const bool is_wedge = n_in == 2;
  const Part first = is_wedge ? Part{in[0], cut(0, 0), cut(0, 1)} : Part{in[0], in[1], in[2]};
  const Part last =
      is_wedge ? Part{in[1], cut(1, 0), cut(1, 1)} : Part{cut(0, 0), cut(1, 0), cut(2, 0)};
  out.push_back({first[0], first[1], first[2], last[0]});
  out.push_back({first[1], first[2], last[0], last[1]});
  out.push_back({first[2], last[0], last[1], last[2]});
}

double volume_of(const Part& part) {
  const Vec3d& a = part[0].at;
  return std::abs(dot(cross(part[1].at - a, part[2].at - a), part[3].at - a)) / 6;
}

/// Of a box of width h in units of h^3 2^-53, with areas up to 6 h^2: relative corners are off by
/// half a unit of h along each axis, which makes 11; a determinant by at most 48 / 6. Each of six
/// cuts moves corners by up to 9 units of h, so the parts' faces make 54 for each part.
constexpr double kWholeRoundings = 32;
constexpr double kPartRoundings = 512;

}  // namespace

CellPart part_in_box(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                     const std::optional<Box3d>& box) {
  std::vector<Part> parts(1);
  double width = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    parts[0][k] = {corners[k] - corners[0], values[k]};
    for (std::size_t j = 0; j < k; ++j)
      for (const double x : (corners[k] - corners[j]).v) width = std::max(width, std::abs(x));
  }
  CellPart made;
  made.is_whole = true;
  std::vector<Part> next;
  for (std::size_t i = 0; box && i < 3; ++i)
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0 ? box->lower[i] : box->upper[i];
      const bool is_within =
          std::ranges::all_of(corners, [&](const Vec3d& p) { return sign * (p[i] - limit) >= 0; });
      if (is_within) continue;
      if (std::ranges::all_of(corners, [&](const Vec3d& p) { return sign * (p[i] - limit) < 0; }))
        return {};
      made.is_whole = false;
      next.clear();
      for (const Part& part : parts) cut_part(part, {i, limit - corners[0][i], sign}, next);
      parts.swap(next);
    }
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const Part& part : parts) {
    const double volume = volume_of(part);
    double sum = 0;
    for (const PartCorner& corner : part) {
      sum += corner.value;
      lowest = std::min(lowest, corner.value);
      highest = std::max(highest, corner.value);
    }
    made.volume += volume;
    made.integral += volume * (sum / 4);
  }
  const double n = made.is_whole ? 1 : std::max<double>(1, static_cast<double>(parts.size()));
  made.volume_rounding =
      (made.is_whole ? kWholeRoundings : kPartRoundings) * n * 0x1p-53 * width * width * width;
  const double largest =
      std::max(std::abs(std::ranges::min(values)), std::abs(std::ranges::max(values)));
  made.integral_rounding = (2 * made.volume_rounding + 32 * 0x1p-53 * made.volume) * largest;
  if (!parts.empty()) {
    made.lowest = std::max(lowest, std::ranges::min(values));
    made.highest = std::min(highest, std::ranges::max(values));
  }
  return made;
}

}  // namespace lode
