#include "lode/models/terrain/insertions/insertion_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/delaunay/triangle_error.h"

namespace lode::insertions {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void join(Box3d& box, const Box3d& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(box.lower[i], other.lower[i]);
    box.upper[i] = std::max(box.upper[i], other.upper[i]);
  }
}

/// Powers of two of which all coordinates are so few that sums of them are exact: so centres and
/// halves of boxes are, and nested boxes have nested bounds.
Vec3d find_steps(const History& history) {
  Vec3d largest{{0, 0, std::max(std::abs(history.range.lower), std::abs(history.range.upper))}};
  largest[2] = 2 * largest[2];  // errors are added
  for (const double x : {0, history.frame.n_columns - 1})
    for (const double y : {0, history.frame.n_rows - 1}) {
      const Vec<double, 2> corner = history.frame.world(x, y);
      for (std::size_t i = 0; i < 2; ++i) largest[i] = std::max(largest[i], std::abs(corner[i]));
    }
  constexpr int kBits = 44;
  for (double& x : largest.v) x = x > 0 ? std::ldexp(1, std::ilogb(x) - kBits) : 1;
  return largest;
}

Box3d rounded(const Bounds& bounds, const Vec3d& step) {
  Box3d box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] =
        std::floor((bounds.centre[i] - bounds.half[i] - bounds.radius) / step[i]) * step[i];
    box.upper[i] =
        std::ceil((bounds.centre[i] + bounds.half[i] + bounds.radius) / step[i]) * step[i];
  }
  return box;
}

/// The latest of the nodes that it depends on, or kNone.
std::uint32_t latest_parent(const History& history, std::uint32_t node) {
  std::uint32_t latest = kNone;
  for (const std::uint32_t t : history.removed_by(node)) {
    const std::uint32_t birth = history.birth(t);
    if (birth != kNone && (latest == kNone || birth > latest)) latest = birth;
  }
  return latest;
}

}  // namespace

InsertionFacts::InsertionFacts(const History& history) : history_(&history) {
  const std::uint32_t n = history.n_nodes();
  find_discovered();
  facts_.resize(n);
  boxes_.assign(n, {{{kInfinity, kInfinity, kInfinity}}, {{-kInfinity, -kInfinity, -kInfinity}}});
  const Vec3d step = find_steps(history);
  for (std::uint32_t node = n; node-- > 0;) {
    // What it discovers is later, and has joined.
    StoredFacts& own = facts_[node];
    for (const std::uint32_t t : history.removed_by(node)) {
      const NodeFacts facts = facts_of(history, history.triangles[t]);
      own.error = std::max(own.error, history.triangles[t].error);
      join(boxes_[node], rounded(facts.bounds, step));
    }
    for (const std::uint32_t child : discovered_by(node)) {
      own.error = std::max(own.error, facts_[child].error);
      join(boxes_[node], boxes_[child]);
    }
    own.low = delaunay::to_float_below(boxes_[node].lower[2] - history.range.lower);
    own.high = -delaunay::to_float_below(history.range.lower - boxes_[node].upper[2]);
  }
}

void InsertionFacts::find_discovered() {
  const std::uint32_t n = history_->n_nodes();
  discoverer_.resize(n);
  first_discovered_.assign(std::size_t{n} + 1, 0);
  for (std::uint32_t node = 0; node < n; ++node) {
    discoverer_[node] = latest_parent(*history_, node);
    if (discoverer_[node] == kNone)
      roots_.push_back(node);
    else
      ++first_discovered_[discoverer_[node] + 1];
  }
  for (std::uint32_t node = 0; node < n; ++node)
    first_discovered_[node + 1] += first_discovered_[node];
  discovered_.resize(first_discovered_[n]);
  std::vector<std::uint32_t> next(first_discovered_.begin(), first_discovered_.end() - 1);
  for (std::uint32_t node = 0; node < n; ++node)
    if (discoverer_[node] != kNone) discovered_[next[discoverer_[node]]++] = node;
}

Bounds InsertionFacts::bounds(std::uint32_t node) const {
  const Box3d& box = boxes_[node];
  return {
      .centre = (box.lower + box.upper) * 0.5, .radius = 0, .half = (box.upper - box.lower) * 0.5};
}

void InsertionCut::add_base(std::vector<NodeId>& out) const {
  for (const std::uint32_t node : facts_->roots()) out.push_back(NodeId{node});
}

void InsertionCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  for (const std::uint32_t child : facts_->discovered_by(index(node))) out.push_back(NodeId{child});
}

void InsertionCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  const std::size_t begin = out.size();
  for (const std::uint32_t t : facts_->history().removed_by(index(node))) {
    const std::uint32_t birth = facts_->history().birth(t);
    if (birth != kNone) out.push_back(NodeId{birth});
  }
  const auto first = out.begin() + static_cast<std::ptrdiff_t>(begin);
  std::sort(first, out.end());
  out.erase(std::unique(first, out.end()), out.end());
}

std::uint64_t InsertionCut::growth(std::uint32_t node) const {
  const History& history = facts_->history();
  return history.first_made[node + 1] - history.first_made[node] - history.removed_by(node).size();
}

std::uint64_t InsertionCut::apply(NodeId node) {
  applied_[index(node)] = true;
  return growth(index(node));
}

std::uint64_t InsertionCut::undo(NodeId node) {
  applied_[index(node)] = false;
  return growth(index(node));
}

}  // namespace lode::insertions
