#include "lode/models/terrain/triangle_hierarchy/edge_chains.h"

#include <algorithm>
#include <array>

#include "lode/delaunay/tin_links.h"

namespace lode::triangle_hierarchy {
namespace {

std::uint64_t key_of(std::uint32_t from, std::uint32_t to) {
  return (std::uint64_t{from} << 32) | to;
}

std::uint64_t edge_of(std::uint32_t a, std::uint32_t b) {
  return key_of(std::min(a, b), std::max(a, b));
}

/// Walks round the triangles of one refinement after the other.
class BorderWalker {
 public:
  explicit BorderWalker(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {}

  void look_at(std::uint32_t refinement) {
    border_.clear();
    const auto [first, end] = hierarchy_.triangles_of(refinement);
    first_ = first;
    end_ = end;
    for (std::uint32_t t = first; t < end; ++t) {
      const Hierarchy::Triangle& triangle = hierarchy_.triangles[t];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t twin = triangle.twin[i];
        if (twin != delaunay::kNoHalfEdge && twin / 4 >= first && twin / 4 < end) continue;
        border_.push_back({triangle.corner[i], triangle.corner[(i + 1) % 3]});
      }
    }
    std::ranges::sort(border_);
  }

  /// Whether one of the triangles has an edge between two vertices.
  [[nodiscard]] bool has_edge(std::uint32_t a, std::uint32_t b) const {
    for (std::uint32_t t = first_; t < end_; ++t) {
      const auto& corner = hierarchy_.triangles[t].corner;
      if (std::ranges::find(corner, a) != corner.end() &&
          std::ranges::find(corner, b) != corner.end())
        return true;
    }
    return false;
  }

  /// The vertices between two corners; false where no way leads from one to the other.
  bool walk(std::uint32_t from, std::uint32_t to, std::vector<std::uint32_t>& between) const {
    between.clear();
    for (std::size_t n = 0; n < border_.size(); ++n) {
      const auto next = std::ranges::lower_bound(border_, from, {}, &Edge::from);
      if (next == border_.end() || next->from != from) return false;
      if (next->to == to) return true;
      between.push_back(next->to);
      from = next->to;
    }
    return false;
  }

 private:
  struct Edge {
    std::uint32_t from;
    std::uint32_t to;

    auto operator<=>(const Edge&) const = default;
  };

  const Hierarchy& hierarchy_;
  std::uint32_t first_ = 0;  ///< Of its triangles, and one past the last.
  std::uint32_t end_ = 0;
  std::vector<Edge> border_;
};

}  // namespace

Result<EdgeChains> EdgeChains::find_in(const Hierarchy& hierarchy) {
  EdgeChains chains;
  BorderWalker walker(hierarchy);
  std::vector<std::uint32_t> between;
  std::size_t level = 0;
  for (std::uint32_t r = 0; r < hierarchy.refinements.size(); ++r) {
    const std::uint32_t refined = hierarchy.refinements[r].triangle;
    const Hierarchy::Triangle& triangle = hierarchy.triangles[refined];
    walker.look_at(r);
    while (hierarchy.refinements[r].first >= hierarchy.triangles_until[level]) ++level;
    const std::uint32_t first_new = hierarchy.vertices_until[level - 1];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangle.corner[i];
      const std::uint32_t to = triangle.corner[(i + 1) % 3];
      if (!walker.walk(from, to, between))
        return fail("expected what refines triangle {} to go round its corners, found a gap",
                    refined);
      if (std::ranges::any_of(between, [&](std::uint32_t v) { return v < first_new; }))
        return fail("expected new vertices on the edges of triangle {}, got one of a level before",
                    refined);
      if (!between.empty() && walker.has_edge(from, to))
        return fail("expected no edge from corner to corner inside what refines triangle {} there",
                    refined);
      // The triangle behind has the same chain, backwards.
      const bool is_first = from < to || triangle.twin[i] == delaunay::kNoHalfEdge;
      if (is_first && !between.empty()) chains.add(from, to, between);
    }
  }
  chains.sort();
  return chains;
}

void EdgeChains::sort() {
  std::ranges::sort(chains_, {}, &Chain::edge);
  for (std::uint32_t c = 0; c < chains_.size(); ++c) {
    auto from = static_cast<std::uint32_t>(chains_[c].edge >> 32);
    for (const std::uint32_t to : std::span(vertices_).subspan(chains_[c].first, chains_[c].n)) {
      wholes_.insert(key_of(from, to), c);
      from = to;
    }
    wholes_.insert(key_of(from, static_cast<std::uint32_t>(chains_[c].edge)), c);
  }
}

std::optional<std::array<std::uint32_t, 2>> EdgeChains::find_whole(std::uint32_t a,
                                                                   std::uint32_t b) const {
  const std::uint32_t forward = wholes_.find(key_of(a, b));
  const std::uint32_t chain = forward != FlatIndex::kNone ? forward : wholes_.find(key_of(b, a));
  if (chain == FlatIndex::kNone) return {};
  const auto low = static_cast<std::uint32_t>(chains_[chain].edge >> 32);
  const auto high = static_cast<std::uint32_t>(chains_[chain].edge);
  if (forward != FlatIndex::kNone) return std::array{low, high};
  return std::array{high, low};
}

void EdgeChains::add(std::uint32_t from, std::uint32_t to, std::span<const std::uint32_t> between) {
  chains_.push_back({edge_of(from, to), static_cast<std::uint32_t>(vertices_.size()),
                     static_cast<std::uint32_t>(between.size())});
  vertices_.insert(vertices_.end(), between.begin(), between.end());
  if (from > to)
    std::reverse(vertices_.end() - static_cast<std::ptrdiff_t>(between.size()), vertices_.end());
}

std::span<const std::uint32_t> EdgeChains::find(std::uint32_t a, std::uint32_t b) const {
  const std::uint64_t edge = edge_of(a, b);
  const auto at = std::ranges::lower_bound(chains_, edge, {}, &Chain::edge);
  if (at == chains_.end() || at->edge != edge) return {};
  return std::span(vertices_).subspan(at->first, at->n);
}

}  // namespace lode::triangle_hierarchy
