#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lode/models/diamond/brick_regions.h"
#include "lode/models/diamond/due_bricks.h"
#include "lode/models/diamond/region_graph.h"
#include "lode/models/diamond/relaxed_field.h"
#include "lode/models/diamond/weak_regions.h"

namespace lode::diamond {

/// Finds the weak regions of a relaxed field: brick by brick, joined where bricks meet. Of a brick
/// in which all samples are on one side, and no holes, its nodes' ranges tell how far they are from
/// the isovalue.
template <typename Field>
class WeakSearch {
 public:
  WeakSearch(const RelaxedField<Field>& relaxed, const Field& field, const CriticalQuery& query,
             Progress& progress)
      : relaxed_(relaxed),
        field_(field),
        query_(query),
        progress_(progress),
        brick_dims_(brick_counts<3>(field.shape)) {}

  /// visit(): as PersistentSearch::run() has it. All that may have samples on both sides is met.
  template <typename Visit>
  Result<WeakRegions> run(const DueBricks& bricks, const Visit& visit) {
    first_.resize(n_points<3>(brick_dims_));
    add_unmet(bricks);
    const std::vector<Index<3>> met = bricks.list_met();
    LODE_CHECK(visit(met, [&](const auto& part) {
      for_each_brick(
          part, [](const Index<3>&, const BrickRegions& regions) { return Found::of(regions); },
          [&](const Index<3>& brick, const Found& found) { add(brick, found, bricks); });
    }));
    if (progress_.is_cancelled()) return cancelled_error();
    RegionGraph::Turned turned = graph_.turn(progress_);
    if (progress_.is_cancelled()) return cancelled_error();
    graph_ = {};
    is_turned_ = std::move(turned.is_turned);
    WeakRegions result;
    result.n = turned.n_fewer;
    if (turned.n_fewer == 0) return result;
    samples_.emplace(field_.shape);
    set_unmet(bricks);
    LODE_CHECK(visit(with_turned(met), [&](const auto& part) {
      for_each_brick(
          part,
          [&](const Index<3>& brick, const BrickRegions& regions) {
            return turned_rows(brick, regions);
          },
          [&](const Index<3>& brick, const BrickBits& rows) { set_rows(brick, rows); });
    }));
    if (progress_.is_cancelled()) return cancelled_error();
    result.samples = std::exchange(samples_, {});
    return result;
  }

  [[nodiscard]] std::uint64_t n_bytes() const {
    constexpr std::uint64_t kWaiting = 64;  // beside a face's pieces
    std::uint64_t n = graph_.n_bytes() + (samples_ ? samples_->n_bytes() : 0);
    for (const auto& [key, face] : waiting_) n += kWaiting + face.capacity() * sizeof(face[0]);
    return n + first_.capacity() * sizeof(first_[0]) + is_turned_.capacity() / 8;
  }

 private:
  using Id = RegionGraph::Id;
  using Label = BrickRegions::Label;
  using Face = std::vector<Id>;  ///< All of its samples, or one where they are all alike.
  static constexpr Id kNone = ~Id{0};
  static constexpr std::size_t kAtOnce = 256;

  /// Of a brick that was looked at what others need.
  struct Found {
    std::vector<BrickRegions::Region> regions;
    std::vector<std::pair<Label, Label>> touching;
    std::array<std::vector<Label>, 6> faces;  ///< By axis, the first one and the last one.

    [[nodiscard]] static Found of(const BrickRegions& regions) {
      Found found{regions.regions(), regions.touching(), {}};
      for (std::size_t side = 0; side < found.faces.size(); ++side) {
        std::vector<Label>& face = found.faces[side];
        face = regions.face(side / 2, side % 2 != 0);
        if (std::ranges::all_of(face, [&](Label label) { return label == face[0]; }))
          face.resize(1);
      }
      return found;
    }
  };
  struct Worker {
    RelaxedBox box;
    BrickRegions regions;
  };

  [[nodiscard]] std::size_t number_of(const Index<3>& brick) const {
    return linear_index<3>(brick_dims_, brick);
  }
  [[nodiscard]] std::uint64_t sample_number(const Index<3>& p) const {
    return linear_index<3>(field_.shape.dims, p);
  }
  /// By the ranges of a brick's nodes: whether it may have samples that can be on a side alone.
  [[nodiscard]] bool may_be_fixed(const Index<3>& brick, bool is_inside) const;
  void add_unmet(const DueBricks& bricks);
  /// Calls keep(brick, BrickRegions) for some of a part's bricks at a time, in parallel, then
  /// use(brick, what that has given) one by one, in order.
  template <typename Part, typename Keep, typename Use>
  void for_each_brick(const Part& part, const Keep& keep, const Use& use);
  void add(const Index<3>& brick, const Found& found, const DueBricks& bricks);
  /// What lies beyond a face of a brick, if that has samples all on one side; or else waits.
  void join_face(const Index<3>& brick, std::size_t side, const Found& found,
                 const DueBricks& bricks);
  void join_faces(const Face& a, const Face& b);
  void set_unmet(const DueBricks& bricks);
  [[nodiscard]] std::vector<Index<3>> with_turned(const std::vector<Index<3>>& met) const;
  [[nodiscard]] BrickBits turned_rows(const Index<3>& brick, const BrickRegions& regions) const;
  void set_rows(const Index<3>& brick, const BrickBits& rows);

  const RelaxedField<Field>& relaxed_;
  const Field& field_;
  CriticalQuery query_;
  Progress& progress_;
  Index<3> brick_dims_;
  RegionGraph graph_;
  /// By brick, its first piece and how many; of one all on one side what is outside comes first,
  /// then what is inside.
  std::vector<std::pair<Id, Id>> first_;
  std::unordered_map<std::uint64_t, Face> waiting_;  ///< By lower brick and axis.
  std::vector<bool> is_turned_;
  std::optional<NodeSet<3>> samples_;  ///< As far as they have been found.
};

template <typename Field>
bool WeakSearch<Field>::may_be_fixed(const Index<3>& brick, bool is_inside) const {
  const double beyond = query_.isovalue + (is_inside ? query_.persistence : -query_.persistence);
  const RelativeIsovalue limit = RelativeIsovalue::of(beyond, field_.range_reference());
  const NodeLevel& nodes = field_.levels[as_size(kKeptLevel)];
  return any_kept_node<3>(field_.shape, brick, [&](const Index<3>&, std::size_t at) {
    return is_inside ? static_cast<double>(nodes.high[at]) >= limit.below
                     : static_cast<double>(nodes.low[at]) < limit.above;
  });
}

template <typename Field>
void WeakSearch<Field>::add_unmet(const DueBricks& bricks) {
  for (std::size_t i = 0; i < first_.size(); ++i) {
    if (!bricks.is_unmet(i)) continue;
    const Index<3> brick = point_of<3>(brick_dims_, i);
    const LatticeBox<3> own = own_centres(brick, field_.shape.dims);
    const std::uint64_t n = n_points<3>(own.upper - own.lower);
    const Id outside = graph_.add(may_be_fixed(brick, false), n, sample_number(own.lower));
    graph_.add(may_be_fixed(brick, true), n, sample_number(own.lower));
    first_[i] = {outside, 2};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Index<3> lower = brick;
      if (--lower[axis] < 0 || !bricks.is_unmet(number_of(lower))) continue;
      const Id other = first_[number_of(lower)].first;
      graph_.join(outside, other);
      graph_.join(outside + 1, other + 1);
    }
  }
}

template <typename Field>
template <typename Part, typename Keep, typename Use>
void WeakSearch<Field>::for_each_brick(const Part& part, const Keep& keep, const Use& use) {
  std::vector<std::unique_ptr<Worker>> workers(as_size(n_workers(query_.threads)));
  using Kept = decltype(keep(part.bricks[0], workers[0]->regions));
  for (std::size_t begin = 0; begin < part.bricks.size(); begin += kAtOnce) {
    if (progress_.is_cancelled()) return;
    const auto some = part.bricks.subspan(begin, std::min(kAtOnce, part.bricks.size() - begin));
    std::vector<Kept> kept(some.size());
    parallel_for(some.size(), query_.threads, 1, [&](std::size_t i, int number) {
      auto& worker = workers[as_size(number)];
      if (!worker)
        worker = std::make_unique<Worker>(
            Worker{RelaxedBox(query_.isovalue, query_.persistence, true), {}});
      relaxed_.relax(part, some[i], worker->box);
      worker->regions.find(worker->box, some[i] * kBrickEdge<3>,
                           own_centres(some[i], part.samples.shape.dims));
      kept[i] = keep(part.in_field(some[i]), worker->regions);
    });
    for (std::size_t i = 0; i < some.size(); ++i) use(part.in_field(some[i]), kept[i]);
  }
}

template <typename Field>
void WeakSearch<Field>::add(const Index<3>& brick, const Found& found, const DueBricks& bricks) {
  const auto first = static_cast<Id>(graph_.size());
  first_[number_of(brick)] = {first, static_cast<Id>(found.regions.size())};
  for (const BrickRegions::Region& region : found.regions)
    graph_.add(
        region.is_fixed, region.n_own,
        region.n_own > 0 ? sample_number(brick * kBrickEdge<3> + region.first) : ~std::uint64_t{0});
  for (const auto& [a, b] : found.touching)
    if (!found.regions[a].is_fixed || !found.regions[b].is_fixed)
      graph_.touch(first + a, first + b);
  for (std::size_t side = 0; side < found.faces.size(); ++side)
    join_face(brick, side, found, bricks);
}

template <typename Field>
void WeakSearch<Field>::join_face(const Index<3>& brick, std::size_t side, const Found& found,
                                  const DueBricks& bricks) {
  const std::size_t axis = side / 2;
  Index<3> other = brick;
  other[axis] += side % 2 != 0 ? 1 : -1;
  if (other[axis] < 0 || other[axis] >= brick_dims_[axis]) return;
  const Id first = first_[number_of(brick)].first;
  const bool is_unmet = bricks.is_unmet(number_of(other));
  Face own;
  Face beyond;
  for (const Label label : found.faces[side]) {
    own.push_back(label == BrickRegions::kNone ? kNone : first + label);
    if (is_unmet)
      beyond.push_back(label == BrickRegions::kNone ? kNone
                                                    : first_[number_of(other)].first +
                                                          (found.regions[label].is_inside ? 1 : 0));
  }
  if (is_unmet) {
    join_faces(own, beyond);
    return;
  }
  const std::uint64_t key = 3 * std::min(number_of(brick), number_of(other)) + axis;
  const auto waiting = waiting_.find(key);
  if (waiting == waiting_.end()) {
    waiting_.emplace(key, std::move(own));
    return;
  }
  join_faces(own, waiting->second);
  waiting_.erase(waiting);
}

template <typename Field>
void WeakSearch<Field>::join_faces(const Face& a, const Face& b) {
  std::pair<Id, Id> last{kNone, kNone};
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    const std::pair<Id, Id> pair{a[a.size() == 1 ? 0 : i], b[b.size() == 1 ? 0 : i]};
    if (pair == last) continue;
    last = pair;
    if (pair.first != kNone && pair.second != kNone) graph_.join(pair.first, pair.second);
  }
}

/// All of the brick, to both ends: some of it may be corners of leaves beside it.
template <typename Field>
void WeakSearch<Field>::set_unmet(const DueBricks& bricks) {
  for (std::size_t i = 0; i < first_.size(); ++i) {
    if (!bricks.is_unmet(i) || (!is_turned_[first_[i].first] && !is_turned_[first_[i].first + 1]))
      continue;
    const Index<3> first = point_of<3>(brick_dims_, i) * kBrickEdge<3>;
    Index<3> n;
    for (std::size_t a = 0; a < 3; ++a)
      n[a] = std::min(kBrickSamples<3>, field_.shape.dims[a] - first[a]);
    const std::uint64_t row = (std::uint64_t{1} << n[0]) - 1;
    for (std::int32_t z = 0; z < n[2]; ++z)
      for (std::int32_t y = 0; y < n[1]; ++y) samples_->set_row(first + Index<3>{{0, y, z}}, row);
  }
}

template <typename Field>
std::vector<Index<3>> WeakSearch<Field>::with_turned(const std::vector<Index<3>>& met) const {
  std::vector<Index<3>> bricks;
  for (const Index<3>& brick : met) {
    const auto& [first, n] = first_[number_of(brick)];
    bool is_any = false;
    for (Id id = first; id < first + n; ++id) is_any = is_any || is_turned_[id];
    if (is_any) bricks.push_back(brick);
  }
  return bricks;
}

template <typename Field>
BrickBits WeakSearch<Field>::turned_rows(const Index<3>& brick, const BrickRegions& regions) const {
  const auto& [first, n] = first_[number_of(brick)];
  const std::vector<bool> is_turned(is_turned_.begin() + first, is_turned_.begin() + first + n);
  BrickBits rows{};
  for (std::int32_t z = 0; z < regions.size()[2]; ++z)
    for (std::int32_t y = 0; y < regions.size()[1]; ++y)
      rows[brick_row(as_size(y), as_size(z))] = regions.row_of(y, z, is_turned);
  return rows;
}

template <typename Field>
void WeakSearch<Field>::set_rows(const Index<3>& brick, const BrickBits& rows) {
  for (std::int32_t z = 0; z < kBrickSamples<3>; ++z)
    for (std::int32_t y = 0; y < kBrickSamples<3>; ++y)
      if (const std::uint64_t row = rows[brick_row(as_size(y), as_size(z))]; row != 0)
        samples_->set_row(brick * kBrickEdge<3> + Index<3>{{0, y, z}}, row);
}

}  // namespace lode::diamond
