#include "lode/locate/cell_locator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "lode/core/point_triangle.h"

namespace lode {
namespace {

constexpr int kBits = 21;  ///< Of a coordinate along the curve.

/// Two zero bits after each.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001F00000000FFFFULL;
  x = (x | x << 16) & 0x001F0000FF0000FFULL;
  x = (x | x << 8) & 0x100F00F00F00F00FULL;
  x = (x | x << 4) & 0x10C30C30C30C30C3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

void join(Box3d& box, const Box3d& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(box.lower[i], other.lower[i]);
    box.upper[i] = std::max(box.upper[i], other.upper[i]);
  }
}

double squared_distance(const Box3d& box, const Vec3d& p) {
  Vec3d way;
  for (std::size_t i = 0; i < 3; ++i)
    way[i] = std::max({box.lower[i] - p[i], p[i] - box.upper[i], 0.0});
  return dot(way, way);
}

/// The place of a box's middle on the curve through all boxes of a domain.
std::uint64_t code_of(const Box3d& box, const Box3d& domain) {
  std::uint64_t code = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double size = domain.upper[i] - domain.lower[i];
    const double middle =
        (box.lower[i] - domain.lower[i]) / 2 + (box.upper[i] - domain.lower[i]) / 2;
    const double share = size > 0 ? std::clamp(middle / size, 0.0, 1.0) : 0;
    code |= spread(static_cast<std::uint64_t>(share * ((1 << kBits) - 1))) << i;
  }
  return code;
}

}  // namespace

double CellWeights::least() const { return *std::ranges::min_element(weights); }

std::array<double, 4> CellWeights::clamped() const {
  std::array<double, 4> inside{};
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) sum += inside[k] = std::max(weights[k], 0.0);
  for (double& weight : inside) weight /= sum;
  return inside;
}

CellLocator::CellLocator(std::span<const Vec3d> positions, std::span<const Cell> cells,
                         Threads threads)
    : positions_(positions), cells_(cells) {
  sort_cells(threads);
  join_boxes(threads);
}

Box3d CellLocator::box_of(const Cell& cell) const {
  Box3d box{positions_[cell[0]], positions_[cell[0]]};
  for (const std::uint32_t v : cell) join(box, {positions_[v], positions_[v]});
  return box;
}

void CellLocator::sort_cells(Threads threads) {
  std::vector<Box3d> boxes(cells_.size());
  constexpr std::size_t kGrain = 4096;
  parallel_for(cells_.size(), threads, kGrain,
               [&](std::size_t i, int) { boxes[i] = box_of(cells_[i]); });
  Box3d domain = boxes.empty() ? Box3d() : boxes.front();
  for (const Box3d& box : boxes) join(domain, box);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(cells_.size());
  parallel_for(cells_.size(), threads, kGrain, [&](std::size_t i, int) {
    codes[i] = {code_of(boxes[i], domain), static_cast<std::uint32_t>(i)};
  });
  std::ranges::sort(codes);
  order_.reserve(codes.size());
  levels_.emplace_back();
  levels_[0].reserve(codes.size());
  for (const auto& [code, cell] : codes) {
    order_.push_back(cell);
    levels_[0].push_back(boxes[cell]);
  }
}

void CellLocator::join_boxes(Threads threads) {
  while (levels_.back().size() > 1) {
    const std::vector<Box3d>& below = levels_.back();
    std::vector<Box3d> joined((below.size() + kBranches - 1) / kBranches);
    parallel_for(joined.size(), threads, 1024, [&](std::size_t i, int) {
      joined[i] = below[kBranches * i];
      for (std::size_t k = kBranches * i; k < std::min(kBranches * (i + 1), below.size()); ++k)
        join(joined[i], below[k]);
    });
    levels_.push_back(std::move(joined));
  }
}

std::array<Vec3d, 4> CellLocator::corners_of(std::uint32_t cell) const {
  const Cell& t = cells_[cell];
  return {positions_[t[0]], positions_[t[1]], positions_[t[2]], positions_[t[3]]};
}

/// Each determinant is off by a few roundings of the product of its vectors' lengths.
CellWeights CellLocator::weights_in(std::uint32_t cell, const Vec3d& p) const {
  std::array<Vec3d, 4> c;
  std::array<double, 4> sizes{};
  for (std::size_t k = 0; k < 4; ++k) {
    c[k] = positions_[cells_[cell][k]] - p;
    sizes[k] = length(c[k]);
  }
  const std::array<double, 4> parts{dot(cross(c[1], c[2]), c[3]), -dot(cross(c[0], c[2]), c[3]),
                                    dot(cross(c[0], c[1]), c[3]), -dot(cross(c[0], c[1]), c[2])};
  const Vec3d u = c[1] - c[0];
  const Vec3d v = c[2] - c[0];
  const Vec3d w = c[3] - c[0];
  const double whole = dot(cross(u, v), w);
  const double product = std::max({sizes[1] * sizes[2] * sizes[3], sizes[0] * sizes[2] * sizes[3],
                                   sizes[0] * sizes[1] * sizes[3], sizes[0] * sizes[1] * sizes[2],
                                   length(u) * length(v) * length(w)});
  constexpr double kRoundings = 16 * 0x1p-52;
  CellWeights found;
  found.rounding = kRoundings * product / std::abs(whole);
  if (!(found.rounding < 1)) return {{}, std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 4; ++k) found.weights[k] = parts[k] / whole;
  return found;
}

double CellLocator::distance_to_faces(std::uint32_t cell, const Vec3d& p) const {
  const Cell& t = cells_[cell];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k)
    least = std::min(
        least, squared_distance_to_triangle<double>(
                   p, {positions_[t[k]], positions_[t[(k + 1) % 4]], positions_[t[(k + 2) % 4]]}));
  return std::sqrt(least);
}

double CellLocator::distance_to_nearest(const Vec3d& p) const {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const auto nearest = nearest_within(p, kEndless);
  return nearest ? nearest->distance : kEndless;
}

std::optional<NearestCell> CellLocator::nearest_within(const Vec3d& p, double limit) const {
  struct Place {
    double squared;
    std::size_t level;
    std::size_t at;
    bool operator<(const Place& other) const { return squared > other.squared; }
  };
  std::optional<NearestCell> nearest;
  double least = limit;
  std::priority_queue<Place> open;
  if (!order_.empty()) open.push({0, levels_.size() - 1, 0});
  const auto may_be_nearer = [&](double squared) {
    return nearest ? squared < least * least : squared <= least * least;
  };
  for (; !open.empty() && may_be_nearer(open.top().squared);) {
    const Place place = open.top();
    open.pop();
    if (place.level == 0) {
      const double distance = distance_to_faces(order_[place.at], p);
      if (nearest ? !(distance < least) : !(distance <= least)) continue;
      nearest = {order_[place.at], distance};
      least = distance;
      continue;
    }
    const std::vector<Box3d>& below = levels_[place.level - 1];
    const std::size_t end = std::min((place.at + 1) * kBranches, below.size());
    for (std::size_t k = place.at * kBranches; k < end; ++k)
      open.push({squared_distance(below[k], p), place.level - 1, k});
  }
  return nearest;
}

Vec3d CellLocator::nearest_on_faces(std::uint32_t cell, const Vec3d& p) const {
  const std::array<Vec3d, 4> c = corners_of(cell);
  Vec3d nearest = c[0];
  double least = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3d& q) {
    const double squared = dot(q - p, q - p);
    if (!(squared < least)) return;
    least = squared;
    nearest = q;
  };
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3d along = c[j] - c[i];
      const double square = dot(along, along);
      const double t = square > 0 ? std::clamp(dot(p - c[i], along) / square, 0.0, 1.0) : 0.0;
      offer(c[i] + along * t);
    }
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d& a = c[i];
    const Vec3d u = c[(i + 1) % 4] - a;
    const Vec3d v = c[(i + 2) % 4] - a;
    const Vec3d normal = cross(u, v);
    const double square = dot(normal, normal);
    if (!(square > 0)) continue;
    const Vec3d q = p - a;
    const double s = dot(cross(q, v), normal) / square;
    const double r = dot(cross(u, q), normal) / square;
    if (s >= 0 && r >= 0 && s + r <= 1) offer(a + u * s + v * r);
  }
  return nearest;
}

}  // namespace lode
