#include "lode/models/diamond/border_clip.h"

#include "lode/models/diamond/barycentric.h"

namespace lode::diamond {
namespace {

using Wide = Vec<std::int64_t, 3>;

template <int D>
Wide to_wide(const Index<D>& p) {
  Wide result;
  for (std::size_t i = 0; i < as_size(D); ++i) result[i] = p[i];
  return result;
}

/// Where the line a b meets the plane x_axis = last, which lies strictly between them. All
/// coordinates that change along it change by the same amount (see BorderClip).
template <int D>
Index<D> crossing(const Index<D>& a, const Index<D>& b, std::size_t axis, std::int32_t last) {
  const std::int64_t length = std::abs(b[axis] - a[axis]);
  const std::int64_t done = std::abs(last - a[axis]);
  Index<D> p;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    const std::int64_t step = std::int64_t{b[i] - a[i]} * done;
    LODE_EXPECTS(step % length == 0);
    p[i] = a[i] + static_cast<std::int32_t>(step / length);
  }
  return p;
}

/// Sorts the corners of a convex polygon in space round the first of them.
template <int D>
void sort_round_first(std::vector<Index<D>>& polygon) {
  const Wide origin = to_wide<D>(polygon[0]);
  const auto turn = [&](const Index<D>& p, const Index<D>& q) {
    return cross(to_wide<D>(p) - origin, to_wide<D>(q) - origin);
  };
  const Wide normal = turn(polygon[1], polygon[2]);
  std::sort(polygon.begin() + 1, polygon.end(), [&](const Index<D>& p, const Index<D>& q) {
    const Wide n = turn(p, q);
    for (std::size_t i = 0; i < 3; ++i)
      if (normal[i] != 0) return normal[i] > 0 ? n[i] > 0 : n[i] < 0;
    return false;
  });
}

template <int D>
void make_unique(std::vector<Index<D>>& points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

}  // namespace

std::int64_t oriented_size(const std::array<Index<2>, 3>& s) {
  const Wide origin = to_wide<2>(s[0]);
  return cross(to_wide<2>(s[1]) - origin, to_wide<2>(s[2]) - origin)[2];
}

std::int64_t oriented_size(const std::array<Index<3>, 4>& s) {
  const Wide origin = to_wide<3>(s[0]);
  return dot(cross(to_wide<3>(s[1]) - origin, to_wide<3>(s[2]) - origin),
             to_wide<3>(s[3]) - origin);
}

template <int D>
BorderClip<D>::BorderClip(const Index<D>& dims) : last_(dims - all_equal<D>(1)) {}

template <int D>
bool BorderClip<D>::is_inside(const Simplex<D>& simplex) const {
  for (const Index<D>& v : simplex.v)
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (v[i] > last_[i]) return false;
  return true;
}

/// Corners in a border plane are inside.
template <int D>
void BorderClip<D>::clip_polygon(Polygon& polygon) {
  for (std::size_t axis = 0; axis < as_size(D); ++axis) {
    const std::int32_t last = last_[axis];
    scratch_.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Index<D>& p = polygon[i];
      const Index<D>& q = polygon[(i + 1) % polygon.size()];
      if (p[axis] <= last) scratch_.push_back(p);
      if ((p[axis] < last && q[axis] > last) || (p[axis] > last && q[axis] < last))
        scratch_.push_back(crossing<D>(p, q, axis, last));
    }
    std::swap(polygon, scratch_);
  }
  make_unique<D>(polygon);
}

template <int D>
void BorderClip<D>::add_piece(Piece piece) {
  const std::int64_t size = oriented_size(piece);
  if (size < 0) std::swap(piece[0], piece[1]);
  if (size != 0) pieces_.push_back(piece);
}

/// Pulls the polygon's first corner; with an apex, makes tetrahedra of the triangles.
template <int D>
void BorderClip<D>::add_fan(Polygon& polygon, [[maybe_unused]] const Index<D>* apex) {
  sort_round_first<D>(polygon);
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    if constexpr (D == 3)
      add_piece({*apex, polygon[0], polygon[i - 1], polygon[i]});
    else
      add_piece({polygon[0], polygon[i - 1], polygon[i]});
  }
}

template <int D>
void BorderClip<D>::clip_faces(const Simplex<D>& simplex) {
  facets_.clear();
  const std::size_t n_faces = D == 3 ? 4 : 1;
  for (std::size_t skip = 0; skip < n_faces; ++skip) {
    Polygon& face = facets_.emplace_back();
    for (std::size_t i = 0; i < simplex.v.size(); ++i)
      if (D == 2 || i != skip) face.push_back(simplex.v[i]);
    clip_polygon(face);
  }
}

/// Their corners are those of the clipped faces in a border plane, and the data's last sample where
/// it lies inside.
template <int D>
void BorderClip<D>::add_border_facets(const Simplex<D>& simplex) {
  const std::size_t n_faces = facets_.size();
  std::array<std::int64_t, as_size(D) + 1> weights{};
  const bool holds_last = Barycentric<D>(simplex).weights(last_, weights);
  const LatticeBox<D> box = bounds_of(simplex);
  for (std::size_t axis = 0; axis < as_size(D); ++axis) {
    if (box.upper[axis] <= last_[axis]) continue;
    Polygon border;
    for (std::size_t f = 0; f < n_faces; ++f)
      for (const Index<D>& p : facets_[f])
        if (p[axis] == last_[axis]) border.push_back(p);
    if (holds_last) border.push_back(last_);
    make_unique<D>(border);
    facets_.push_back(std::move(border));
  }
}

template <int D>
auto BorderClip<D>::clip(const Simplex<D>& simplex) -> std::span<const Piece> {
  pieces_.clear();
  if (is_inside(simplex)) {
    add_piece(simplex.v);
    return pieces_;
  }
  clip_faces(simplex);
  if constexpr (D == 3) add_border_facets(simplex);
  const Index<D>* apex = nullptr;
  for (const Polygon& facet : facets_)
    if (!facet.empty() && (apex == nullptr || facet[0] < *apex)) apex = &facet[0];
  for (Polygon& facet : facets_)
    if (facet.size() >= 3 && (D == 2 || facet[0] != *apex)) add_fan(facet, apex);
  return pieces_;
}

template class BorderClip<2>;
template class BorderClip<3>;

}  // namespace lode::diamond
