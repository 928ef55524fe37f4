#include "lode/api/piece_finisher.h"

#include <algorithm>

#include "lode/mappers/surface_edits.h"
#include "lode/mappers/zero_normals.h"

namespace lode {

void PieceFinisher::begin(double isovalue) {
  end_isovalue();
  isovalue_ = isovalue;
  is_begun_ = true;
}

void PieceFinisher::end_isovalue() {
  if (is_begun_ && out_.n_vertices() == n_before_) unmet_.push_back(isovalue_);
  n_before_ = out_.n_vertices();
}

Result<void> PieceFinisher::add(SurfacePiece piece) {
  find_zero_normals(piece);
  Surface& surface = piece.surface;
  if (options_.isovalues.size() > 1) surface.isovalues.assign(surface.positions.size(), isovalue_);
  if (options_.orientation == Orientation::from_higher_values) flip_orientation(surface);
  n_triangles_ += surface.triangles.size();
  n_lines_ += surface.lines.size();
  return out_.add(std::move(piece));
}

void PieceFinisher::find_zero_normals(const SurfacePiece& piece) {
  const Surface& surface = piece.surface;
  if (surface.normals.empty()) return;
  const ZeroNormals zeros(surface.normals, options_.threads);
  zeros.for_each([&](std::uint32_t v) {
    if (v < piece.n_new()) areas_.emplace(piece.number(v), Vec3f{});
  });
  if (areas_.empty()) return;
  for (const std::uint32_t i : zeros.triangles_at(surface, options_.threads)) {
    const auto& t = surface.triangles[i];
    const Vec3f area = area_vector(surface, t);
    for (const std::uint32_t v : t)
      if (const auto at = areas_.find(piece.number(v)); at != areas_.end())
        at->second = at->second + area;
  }
}

void PieceFinisher::finish(ExtractReport& report) {
  end_isovalue();
  std::vector<VertexNormal> completed;
  completed.reserve(areas_.size());
  const float sign = options_.orientation == Orientation::from_higher_values ? -1.0F : 1.0F;
  for (const auto& [vertex, area] : areas_) completed.push_back({vertex, sign * normalized(area)});
  std::sort(completed.begin(), completed.end(),
            [](const VertexNormal& a, const VertexNormal& b) { return a.vertex < b.vertex; });
  out_.set_normals(completed);
  report.triangles = n_triangles_;
  report.lines = n_lines_;
  report.vertices = out_.n_vertices();
  report.unmet = unmet_;
}

}  // namespace lode
