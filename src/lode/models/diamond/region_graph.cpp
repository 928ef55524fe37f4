#include "lode/models/diamond/region_graph.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <tuple>

namespace lode::diamond {

RegionGraph::Id RegionGraph::add(bool is_fixed, std::uint64_t n, std::uint64_t first) {
  const auto id = static_cast<Id>(pieces_.size());
  pieces_.push_back({n, first, id, is_fixed});
  n_free_ += is_fixed ? 0 : 1;
  return id;
}

RegionGraph::Id RegionGraph::root_of(Id id) {
  while (pieces_[id].parent != id) id = pieces_[id].parent = pieces_[pieces_[id].parent].parent;
  return id;
}

void RegionGraph::join(Id a, Id b) {
  a = root_of(a);
  b = root_of(b);
  if (a == b) return;
  if (a > b) std::swap(a, b);
  Piece& root = pieces_[a];
  const Piece& other = pieces_[b];
  root.n += other.n;
  root.first = std::min(root.first, other.first);
  root.is_fixed = root.is_fixed || other.is_fixed;
  pieces_[b].parent = a;
}

/// The regions that may be turned, with those beside them. Nothing is moved when some become one:
/// they are a chain of roots, each with what was beside it at first.
class RegionGraph::Turning {
 public:
  explicit Turning(RegionGraph& graph)
      : graph_(graph), next_(graph.size(), kNone), last_(graph.size()) {
    std::iota(last_.begin(), last_.end(), Id{0});
    find_beside();
    std::vector<Key> keys;
    for (Id id = 0; id < graph.size(); ++id)
      if (first_[id] < first_[id + 1]) keys.push_back(key_of(id));
    waiting_ = Waiting(std::greater<>(), std::move(keys));
  }

  /// Marks the roots of the regions that there were. How many fewer there are.
  std::uint64_t run(const Progress& progress, std::vector<bool>& is_turned) {
    std::uint64_t n_fewer = 0;
    while (!waiting_.empty() && !progress.is_cancelled()) {
      const Key key = waiting_.top();
      waiting_.pop();
      const Id id = std::get<Id>(key);
      if (graph_.root_of(id) != id || key_of(id) != key) continue;  // is part of another by now
      for (Id member = id; member != kNone; member = next_[member]) is_turned[member].flip();
      n_fewer += merge(id);
    }
    return n_fewer;
  }

 private:
  /// Samples, the first of them, and which region it is.
  using Key = std::tuple<std::uint64_t, std::uint64_t, Id>;
  using Waiting = std::priority_queue<Key, std::vector<Key>, std::greater<>>;
  static constexpr Id kNone = ~Id{0};

  [[nodiscard]] Key key_of(Id root) const {
    return {graph_.pieces_[root].n, graph_.pieces_[root].first, root};
  }
  [[nodiscard]] bool is_free(Id root) const { return !graph_.pieces_[root].is_fixed; }

  /// Of the regions that may be turned; uses the pairs up.
  void find_beside() {
    first_.resize(graph_.size() + 2);
    for (auto& [a, b] : graph_.touching_) {
      a = graph_.root_of(a);
      b = graph_.root_of(b);
      first_[a + 2] += is_free(a) ? 1 : 0;
      first_[b + 2] += is_free(b) ? 1 : 0;
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    beside_.resize(first_.back());
    for (const auto& [a, b] : graph_.touching_) {
      if (is_free(a)) beside_[first_[a + 1]++] = b;
      if (is_free(b)) beside_[first_[b + 1]++] = a;
    }
    graph_.touching_ = {};
  }

  /// With all that are beside it, which are on its side now. How many. Each of those that may be
  /// turned is no smaller: so a region comes to this again only when it has twice the samples.
  std::uint64_t merge(Id id) {
    std::vector<Id> beside;
    for (Id member = id; member != kNone; member = next_[member])
      for (std::uint64_t i = first_[member]; i < first_[member + 1]; ++i)
        beside.push_back(graph_.root_of(beside_[i]));
    std::ranges::sort(beside);
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
    std::erase(beside, id);
    Id root = id;
    for (const Id other : beside) {
      const auto [low, high] = std::minmax({root, other});
      next_[last_[low]] = high;
      last_[low] = last_[high];
      graph_.join(low, high);
      root = low;
    }
    if (is_free(root) && !beside.empty()) waiting_.push(key_of(root));
    return beside.size();
  }

  RegionGraph& graph_;
  std::vector<Id> next_;              ///< In a chain, which begins at its root.
  std::vector<Id> last_;              ///< By root.
  std::vector<std::uint64_t> first_;  ///< By root, where in beside_.
  std::vector<Id> beside_;
  Waiting waiting_;
};

RegionGraph::Turned RegionGraph::turn(const Progress& progress) {
  std::vector<Id> region_of(pieces_.size());
  for (Id id = 0; id < region_of.size(); ++id) region_of[id] = root_of(id);
  Turned result;
  result.is_turned.resize(region_of.size());
  result.n_fewer = Turning(*this).run(progress, result.is_turned);
  for (Id id = 0; id < region_of.size(); ++id)
    result.is_turned[id] = result.is_turned[region_of[id]];  // roots come before their pieces
  return result;
}

}  // namespace lode::diamond
