#include "lode/api/mapped_lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <new>

#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

using LinePlaces = std::vector<Vec<double, 2>>;

/// Lines that are mapped together: their vertices, and the middles of their pieces.
class LineBatch {
 public:
  void add(std::span<Vec<double, 2>> line) {
    lines_.push_back(line);
    for (std::size_t i = 0; i < line.size(); ++i) {
      places_.push_back(line[i]);
      places_.push_back(i + 1 < line.size() ? (line[i] + line[i + 1]) * 0.5 : line[i]);
    }
  }
  [[nodiscard]] std::size_t size() const { return places_.size(); }

  /// Puts vertices back, and returns the largest bend.
  Result<double> map(const PlaceMap& map, const std::string& name) {
    const LinePlaces before = places_;
    map.apply(places_);
    double largest = 0;
    std::size_t at = 0;
    for (const std::span<Vec<double, 2>>& line : lines_)
      for (std::size_t i = 0; i < line.size(); ++i, at += 2) {
        for (const std::size_t place : {at, at + 1})
          if (std::isnan(places_[place][0])) return no_place(before[place], name);
        if (i + 1 < line.size()) {
          const Vec<double, 2> way = places_[at + 2] - places_[at];
          const double bend = length(places_[at + 1] - (places_[at] + places_[at + 2]) * 0.5);
          if (bend > length(way) / 4 + noise(places_[at])) return over_seam(before[at], name);
          largest = std::max(largest, bend);
        }
        line[i] = places_[at];
      }
    lines_.clear();
    places_.clear();
    return largest;
  }

 private:
  /// Of coordinates, many times their rounding.
  static double noise(const Vec<double, 2>& p) {
    constexpr double kShare = 1e-9;
    return kShare * std::max(std::abs(p[0]), std::abs(p[1]));
  }
  static Error no_place(const Vec<double, 2>& at, const std::string& name) {
    return fail(
        "expected lines where {} is of use, got one through {}, {}, for which PROJ finds no place "
        "in it: choose a CRS for the area",
        name, at[0], at[1]);
  }
  static Error over_seam(const Vec<double, 2>& at, const std::string& name) {
    return fail(
        "expected lines whose pieces are about straight in {}, got one from {}, {} that crosses a "
        "seam or pole of it, or bends by more than a quarter of its length: choose a CRS for the "
        "area",
        name, at[0], at[1]);
  }

  std::vector<std::span<Vec<double, 2>>> lines_;
  LinePlaces places_;
};

}  // namespace

Result<double> map_lines(std::span<const std::span<Vec<double, 2>>> lines, const PlaceMap& map,
                         const std::string& name, Progress& progress) try {
  constexpr std::size_t kAtOnce = std::size_t{1} << 16;
  LineBatch batch;
  double largest = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    batch.add(lines[i]);
    if (batch.size() < kAtOnce && i + 1 < lines.size()) continue;
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const double bend, batch.map(map, name));
    largest = std::max(largest, bend);
    progress.report("transforming", static_cast<double>(i) / static_cast<double>(lines.size()));
  }
  return largest;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform lines");
}

}  // namespace lode
