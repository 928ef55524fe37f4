#include "lode/models/diamond/part_window.h"

#include <limits>
#include <utility>

namespace lode::diamond {
namespace {

void append(const std::vector<Facet>& more, std::vector<Facet>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

PartWindow::PartWindow(const Place& place, const IsosurfaceQuery& query, Bricks bricks,
                       NodeSet<3>& wanted, std::function<void(const Index<3>&)> on_new)
    : field_(place.field),
      part_(place.part),
      bricks_(std::move(bricks)),
      query_(query),
      nodes_(part_.model()),
      wanted_(wanted),
      wanted_here_(wanted.part(part_.model().shape, part_.origin())),
      fresh_here_(part_.model().shape),
      on_new_(std::move(on_new)),
      selection_(place.field, query.tolerance) {
  query_.wanted = &wanted_here_;
}

bool PartWindow::find_full(std::size_t n_most, const Progress& progress) {
  if (!add_full(bricks_.fresh, n_most, progress)) return false;
  n_first_ = full_.all.size();
  if (!add_full(bricks_.again, n_most, progress)) return false;
  full_.n_own = full_.all.size();
  return add_full(bricks_.round, n_most, progress);
}

/// Behind those that are there; false, with some of them, where they come to more than n_most.
bool PartWindow::add_full(std::span<const Index<3>> bricks, std::size_t n_most,
                          const Progress& progress) {
  FieldBricks field = of(bricks, bricks_.near);
  field.n_most = n_most - full_.all.size();
  append(full_facets(field, query_, progress), full_.all);
  return full_.all.size() <= n_most;
}

DistanceWindow::Facets PartWindow::cut(const Progress& progress) {
  const NodeSet<3>* const fresh = is_all_fresh_ ? nullptr : &fresh_here_;
  Facets facets{cut_facets(of(bricks_.fresh, sure()), query_, fresh, progress), 0};
  append(cut_facets(of(bricks_.again, sure()), query_, fresh, progress), facets.all);
  facets.n_own = facets.all.size();
  append(cut_facets(of(bricks_.round, sure()), query_, fresh, progress), facets.all);
  return facets;
}

std::uint64_t PartWindow::insert(const Index<3>& centre) {
  std::uint64_t n = 0;
  wanted_.insert(centre, [&](const Index<3>& p) {
    const Index<3> local = p - part_.origin();
    if (part_.model().shape.is_sample(local)) {
      wanted_here_.set(local);
      fresh_here_.set(local);
    }
    on_new_(p);
    ++n;
  });
  return n;
}

bool PartWindow::is_refined(const Simplex<3>& s) const {
  Diamond<3> node = diamond_at<3>(s.bisection_point());
  if (wanted_.contains(node.centre) || field_.shape.reaches_across(node.centre, node.level))
    return true;
  if (node.level >= kKeptLevel)
    return selection_.exceeds_tolerance(selection_.error(node.level, selection_.index_of(node)));
  node.centre = node.centre - part_.origin();
  return selection_.exceeds_tolerance(
      encode_error(static_cast<float>(nodes_.facts_at(node).error)));
}

/// Where the part ends inside the data, the errors of level 0 in its last cells do not know of
/// samples beyond, so that the cut there may be another. Nor does the part know of the data's end:
/// where that is less than a brick farther, it asks for nodes that reach across it. These have
/// their axis, and so all simplices that they bisect, at the part's end: as that is a multiple of a
/// brick's edge, and the data's end beyond it, no others are as near to that.
LatticeBox<3> PartWindow::sure() const {
  constexpr std::int32_t kUnsure = 2;
  LatticeBox<3> sure{{}, all_equal<3>(std::numeric_limits<std::int32_t>::max())};
  const Index<3>& dims = part_.model().shape.dims;
  for (std::size_t i = 0; i < 3; ++i) {
    if (part_.origin()[i] > 0) sure.lower[i] = kUnsure;
    if (part_.origin()[i] + dims[i] < field_.shape.dims[i]) sure.upper[i] = dims[i] - 1 - kUnsure;
  }
  return sure;
}

}  // namespace lode::diamond
