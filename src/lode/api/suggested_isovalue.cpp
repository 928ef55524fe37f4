#include "lode/api/suggested_isovalue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lode/api/mesh_extraction.h"

namespace lode {
namespace {

/// The volume at values, in parts of the range.
class Histogram {
 public:
  static constexpr std::size_t kParts = 512;

  Histogram(double low, double high) : low_(low), width_((high - low) / kParts) {}

  /// Spreads a cell evenly from its least to its largest value.
  void add(double least, double largest, double volume) {
    const double first = (least - low_) / width_;
    const double last = std::max((largest - low_) / width_, first + 1e-9);
    const auto from = static_cast<std::size_t>(std::clamp(first, 0.0, kParts - 1.0));
    const auto to = static_cast<std::size_t>(std::clamp(last, 0.0, kParts - 1.0));
    for (std::size_t i = from; i <= to; ++i) {
      const double below = std::max(first, static_cast<double>(i));
      const double above = std::min(last, static_cast<double>(i + 1));
      volumes_[i] += volume * std::max(0.0, above - below) / (last - first);
    }
  }

  /// The end of a part; the middle of all that are as good, as where there is nothing between. None
  /// where all is in one part.
  [[nodiscard]] std::optional<double> best_threshold() const {
    double total = 0;
    double sum = 0;
    for (std::size_t i = 0; i < kParts; ++i) {
      total += volumes_[i];
      sum += volumes_[i] * static_cast<double>(i);
    }
    double below = 0;
    double sum_below = 0;
    double best = -1;
    std::size_t first = 0;
    std::size_t last = 0;
    for (std::size_t i = 0; i + 1 < kParts; ++i) {
      below += volumes_[i];
      sum_below += volumes_[i] * static_cast<double>(i);
      const double above = total - below;
      if (!(below > 0) || !(above > 0)) continue;
      const double apart = sum_below / below - (sum - sum_below) / above;
      const double between = below * above * apart * apart;
      if (between > best * (1 + 1e-12)) first = i;
      if (between >= best * (1 - 1e-12)) last = i;
      best = std::max(best, between);
    }
    if (best < 0) return std::nullopt;
    return low_ + width_ * (0.5 * static_cast<double>(first + last) + 1);
  }

 private:
  double low_;
  double width_;
  std::array<double, kParts> volumes_{};
};

bool is_whole(ScalarType type) {
  return type != ScalarType::float32 && type != ScalarType::float64;
}

template <std::size_t N>
double size_of(const SimplexMesh& mesh, const std::array<std::uint32_t, N>& cell) {
  const auto from_first = [&](std::size_t k) {
    return mesh.positions[cell[k]] - mesh.positions[cell[0]];
  };
  const Vec3d normal = cross(from_first(1), from_first(2));
  if constexpr (N == 4)
    return std::abs(dot(normal, from_first(3)));
  else
    return length(normal);
}

}  // namespace

Result<std::optional<double>> suggest_isovalue(const Dataset& dataset, Progress& progress) {
  constexpr std::uint64_t kCells = 100'000;
  const DatasetInfo& info = dataset.describe();
  if (!(info.range_min < info.range_max)) return std::optional<double>();
  SimplexMesh mesh;
  Query query;
  query.budget = Budget{kCells};
  LODE_CHECK(dataset.extract_mesh({.query = query}, mesh, progress));
  Histogram histogram(info.range_min, info.range_max);
  const auto add = [&](const auto& cells) {
    for (const auto& cell : cells) {
      double least = mesh.values[cell[0]];
      double largest = least;
      for (const std::uint32_t v : cell) {
        least = std::min(least, mesh.values[v]);
        largest = std::max(largest, mesh.values[v]);
      }
      histogram.add(least, largest, size_of(mesh, cell));
    }
  };
  add(mesh.tetrahedra);
  add(mesh.triangles);
  std::optional<double> best = histogram.best_threshold();
  if (best && is_whole(info.volume.type)) best = std::floor(*best) + 0.5;
  return best;
}

}  // namespace lode
