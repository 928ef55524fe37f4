#include "lode/io/covered_area.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace lode::io {
namespace {

/// How much of a line is covered by intervals that come and go, between given places.
class CoveredLine {
 public:
  explicit CoveredLine(std::vector<double> places) : places_(std::move(places)) {
    std::ranges::sort(places_);
    places_.erase(std::unique(places_.begin(), places_.end()), places_.end());
    nodes_.resize(4 * places_.size());
  }
  /// `by`: 1 or -1; both ends are places.
  void add(double from, double to, int by) {
    if (from < to) add({1, 0, places_.size() - 1}, place_of(from), place_of(to), by);
  }
  [[nodiscard]] double length() const { return nodes_[1].length; }

 private:
  struct Node {
    int n = 0;  ///< Intervals that cover all of it.
    double length = 0;
  };
  struct Range {
    std::size_t node;
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] std::size_t place_of(double at) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(places_, at) - places_.begin());
  }
  void add(const Range& range, std::size_t from, std::size_t to, int by) {
    if (to <= range.first || range.last <= from) return;
    Node& node = nodes_[range.node];
    const bool is_leaf = range.last - range.first == 1;
    if (from <= range.first && range.last <= to) {
      node.n += by;
    } else {
      const std::size_t middle = (range.first + range.last) / 2;
      add({2 * range.node, range.first, middle}, from, to, by);
      add({2 * range.node + 1, middle, range.last}, from, to, by);
    }
    if (node.n > 0)
      node.length = places_[range.last] - places_[range.first];
    else
      node.length = is_leaf ? 0 : nodes_[2 * range.node].length + nodes_[2 * range.node + 1].length;
  }

  std::vector<double> places_;
  std::vector<Node> nodes_;
};

}  // namespace

double covered_area(const std::vector<Rectangle>& rectangles) {
  struct Event {
    double y;
    double left;
    double right;
    int by;
  };
  std::vector<Event> events;
  std::vector<double> places;
  events.reserve(2 * rectangles.size());
  places.reserve(2 * rectangles.size());
  for (const Rectangle& part : rectangles) {
    events.push_back({part.top, part.left, part.right, 1});
    events.push_back({part.bottom, part.left, part.right, -1});
    places.push_back(part.left);
    places.push_back(part.right);
  }
  if (events.empty()) return 0;
  std::ranges::sort(events, {}, &Event::y);
  CoveredLine line(std::move(places));
  double area = 0;
  double last = events.front().y;
  for (const Event& event : events) {
    area += line.length() * (event.y - last);
    last = event.y;
    line.add(event.left, event.right, event.by);
  }
  return area;
}

}  // namespace lode::io
