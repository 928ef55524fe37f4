#include "lode/locate/polygon_locator.h"

#include <algorithm>
#include <cmath>

#include "lode/delaunay/lattice_side.h"

namespace lode {
namespace {

using Corner = Vec<double, 2>;

bool is_in_box(const Corner& a, const Corner& b, const Corner& p) {
  for (std::size_t i = 0; i < 2; ++i)
    if (p[i] < std::min(a[i], b[i]) || p[i] > std::max(a[i], b[i])) return false;
  return true;
}

}  // namespace

PolygonLocator::PolygonLocator(std::span<const PlacePolygon> polygons) {
  for (std::uint32_t i = 0; i < polygons.size(); ++i) add_edges(polygons[i], i);
  sort_into_bands();
}

void PolygonLocator::add_edges(const PlacePolygon& polygon, std::uint32_t number) {
  for (const auto& ring : polygon)
    for (std::size_t i = 0; i < ring.size(); ++i)
      edges_.push_back({ring[i], ring[i + 1 < ring.size() ? i + 1 : 0], number});
}

std::size_t PolygonLocator::band_of(double y) const {
  const double share = (y - lowest_) / (highest_ - lowest_);
  const auto band = static_cast<std::size_t>(share * static_cast<double>(n_bands_));
  return std::min(band, n_bands_ - 1);
}

void PolygonLocator::sort_into_bands() {
  if (edges_.empty()) return;
  lowest_ = edges_[0].a[1];
  highest_ = lowest_;
  double heights = 0;
  for (const Edge& edge : edges_) {
    lowest_ = std::min(lowest_, edge.a[1]);
    highest_ = std::max(highest_, edge.a[1]);
    heights += std::abs(edge.b[1] - edge.a[1]);
  }
  if (highest_ > lowest_ && heights > 0) {
    // So many that edges are in four more bands on average, or one for each.
    const auto n = static_cast<double>(edges_.size());
    constexpr double kMoreBands = 4;
    n_bands_ = static_cast<std::size_t>(
        std::clamp(kMoreBands * n * ((highest_ - lowest_) / heights), 1.0, n));
  }
  const auto for_each = [&](const auto& visit) {
    for (std::uint32_t i = 0; i < edges_.size(); ++i) {
      const auto [low, high] = std::minmax(edges_[i].a[1], edges_[i].b[1]);
      const std::size_t last = n_bands_ == 1 ? 0 : band_of(high);
      for (std::size_t band = n_bands_ == 1 ? 0 : band_of(low); band <= last; ++band)
        visit(band, i);
    }
  };
  first_.assign(n_bands_ + 1, 0);
  for_each([&](std::size_t band, std::uint32_t) { ++first_[band + 1]; });
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  reaching_.resize(first_.back());
  std::vector<std::size_t> next = first_;
  for_each([&](std::size_t band, std::uint32_t edge) { reaching_[next[band]++] = edge; });
}

bool PolygonLocator::holds(const Vec<double, 2>& p) const {
  if (edges_.empty() || !(p[1] >= lowest_ && p[1] <= highest_)) return false;
  const std::size_t band = n_bands_ == 1 ? 0 : band_of(p[1]);
  bool is_inside = false;
  std::uint32_t polygon = 0;
  for (std::size_t i = first_[band]; i < first_[band + 1]; ++i) {
    const Edge& edge = edges_[reaching_[i]];
    if (edge.polygon != polygon) {
      if (is_inside) return true;
      polygon = edge.polygon;
    }
    const bool crosses = (edge.a[1] > p[1]) != (edge.b[1] > p[1]);
    if (!crosses && !is_in_box(edge.a, edge.b, p)) continue;
    const int side = delaunay::side_of(edge.a, edge.b, p);
    if (side == 0 && is_in_box(edge.a, edge.b, p)) return true;
    if (crosses && (side > 0) == (edge.b[1] > edge.a[1])) is_inside = !is_inside;
  }
  return is_inside;
}

}  // namespace lode
