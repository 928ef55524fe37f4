#include "lode/models/terrain/hierarchical_delaunay/edge_chains.h"

#include <algorithm>

#include "lode/core/expects.h"

namespace lode::hierarchical_delaunay {
namespace {

std::uint64_t edge_of(std::uint32_t a, std::uint32_t b) {
  return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

}  // namespace

std::vector<ChainPlace> refine_edge(const FineGrid& grid, const ChainPlace& a, const ChainPlace& b,
                                    double limit, triangle_hierarchy::Crossings crossings) {
  std::vector<ChainPlace> between;
  ChainPlace from = a;
  // The ends of parts still to be looked at, the next one last.
  std::vector<ChainPlace> ahead{b};
  while (!ahead.empty()) {
    const ChainPlace to = ahead.back();
    const auto worst = worst_crossing(grid, from.place, to.place, crossings);
    if (worst.error > limit) {
      ahead.push_back({worst.place, std::max(from.n_moves, to.n_moves) + (worst.is_exact ? 0 : 1)});
      continue;
    }
    ahead.pop_back();
    if (!ahead.empty()) between.push_back(to);
    from = to;
  }
  return between;
}

void EdgeChains::add(std::uint32_t from, std::uint32_t to, std::span<const std::uint32_t> between) {
  LODE_EXPECTS(!between.empty());
  chains_.push_back({edge_of(from, to), static_cast<std::uint32_t>(vertices_.size()),
                     static_cast<std::uint32_t>(between.size())});
  vertices_.insert(vertices_.end(), between.begin(), between.end());
  if (from > to)
    std::reverse(vertices_.end() - static_cast<std::ptrdiff_t>(between.size()), vertices_.end());
}

void EdgeChains::sort() { std::ranges::sort(chains_, {}, &Chain::edge); }

std::span<const std::uint32_t> EdgeChains::find(std::uint32_t a, std::uint32_t b) const {
  const std::uint64_t edge = edge_of(a, b);
  const auto at = std::ranges::lower_bound(chains_, edge, {}, &Chain::edge);
  if (at == chains_.end() || at->edge != edge) return {};
  return std::span(vertices_).subspan(at->first, at->n);
}

}  // namespace lode::hierarchical_delaunay
