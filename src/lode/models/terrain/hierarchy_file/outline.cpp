#include "lode/models/terrain/hierarchy_file/outline.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace lode::hierarchy_file {
namespace {

/// Sums of numbers from the first on, in a tree: the least and the largest of them are known.
class PrefixSums {
 public:
  explicit PrefixSums(std::size_t n) : n_leaves_(std::bit_ceil(n)), nodes_(2 * n_leaves_) {}

  void set(std::size_t i, int value) {
    std::size_t at = n_leaves_ + i;
    nodes_[at] = {value, value, value};
    for (at /= 2; at > 0; at /= 2) {
      const Node& a = nodes_[2 * at];
      const Node& b = nodes_[2 * at + 1];
      nodes_[at] = {a.sum + b.sum, std::min(a.least, a.sum + b.least),
                    std::max(a.most, a.sum + b.most)};
    }
  }
  [[nodiscard]] int least() const { return nodes_[1].least; }
  [[nodiscard]] int most() const { return nodes_[1].most; }

 private:
  struct Node {
    int sum = 0;
    int least = 0;
    int most = 0;
  };

  std::size_t n_leaves_;
  std::vector<Node> nodes_;
};

/// Where a part of a column begins or ends.
struct Event {
  std::int32_t y = 0;
  bool begins = false;
  std::size_t column = 0;
  int value = 0;
};

}  // namespace

Result<OutlinePart> outline_part(delaunay::LatticePoint from, delaunay::LatticePoint to,
                                 std::int32_t scale) {
  const bool is_column = from.x == to.x;
  const std::int32_t line = is_column ? from.x : from.y;
  if ((!is_column && from.y != to.y) || line % scale != 0)
    return fail("expected an outline along columns and rows, got an edge from {}, {} to {}, {}",
                from.x, from.y, to.x, to.y);
  const auto [low, high] = is_column ? std::minmax({from.y, to.y}) : std::minmax({from.x, to.x});
  return OutlinePart{is_column, line, low, high, is_column ? from.y < to.y : from.x < to.x};
}

Result<std::vector<OutlinePart>> join_outline(std::vector<OutlinePart> parts) {
  std::ranges::sort(parts, {}, [](const OutlinePart& part) {
    return std::tuple(part.is_column, part.line, part.low);
  });
  std::vector<OutlinePart> joint;
  for (const OutlinePart& part : parts) {
    const bool is_next = !joint.empty() && joint.back().is_column == part.is_column &&
                         joint.back().line == part.line;
    if (is_next && joint.back().high > part.low)
      return fail("expected triangles on both sides of {} {}, found a crack from {} on",
                  part.is_column ? "column" : "row", part.line, part.low);
    if (is_next && joint.back().high == part.low && joint.back().rises == part.rises)
      joint.back().high = part.high;
    else
      joint.push_back(part);
  }
  return joint;
}

bool goes_round_once(const std::vector<OutlinePart>& outline) {
  std::vector<Event> events;
  std::size_t n_columns = 0;
  std::int32_t last = -1;
  for (const OutlinePart& part : outline) {
    if (!part.is_column) continue;
    if (part.line != last) ++n_columns;
    last = part.line;
    events.push_back({part.low, true, n_columns - 1, part.rises ? -1 : 1});
    events.push_back({part.high, false, n_columns - 1, 0});
  }
  if (events.empty()) return true;
  // Of one place what ends comes first.
  std::ranges::sort(events, {}, [](const Event& e) { return std::pair(e.y, e.begins); });
  PrefixSums inside(n_columns);
  for (std::size_t i = 0; i < events.size(); ++i) {
    inside.set(events[i].column, events[i].value);
    const bool is_last = i + 1 == events.size() || events[i + 1].y != events[i].y;
    if (is_last && (inside.least() < 0 || inside.most() > 1)) return false;
  }
  return true;
}

}  // namespace lode::hierarchy_file
