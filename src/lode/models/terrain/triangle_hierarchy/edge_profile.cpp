#include "lode/models/terrain/triangle_hierarchy/edge_profile.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace lode::triangle_hierarchy {
namespace {

enum class Line : std::uint8_t { column, row };

struct Division {
  std::int64_t quotient;  ///< Rounded down.
  std::int64_t rest;
};

Division divide(std::int64_t a, std::int64_t b) {
  Division made{a / b, a % b};
  if (made.rest < 0) {
    made.rest += b;
    --made.quotient;
  }
  return made;
}

/// Reads the crossings of an edge with all columns, or with all rows.
class ProfileReader {
 public:
  ProfileReader(const FineGrid& grid, const Place& a, const Place& b, Crossings crossings)
      : grid_(grid), a_(a), b_(b), crossings_(crossings) {}

  void read(Line line, EdgeSplit& worst) const {
    const bool is_column = line == Line::column;
    // u runs across the lines, v along them.
    const std::int64_t u0 = is_column ? a_.at.x : a_.at.y;
    const std::int64_t u1 = is_column ? b_.at.x : b_.at.y;
    const std::int64_t v0 = is_column ? a_.at.y : a_.at.x;
    const std::int64_t rise = (is_column ? b_.at.y : b_.at.x) - v0;
    const std::int64_t run = std::abs(u1 - u0);
    const int bits = grid_.bits();
    const auto [low, high] = std::minmax(u0, u1);
    for (std::int64_t k = (low >> bits) + 1; k << bits < high; ++k) {
      const std::int64_t gone = std::abs((k << bits) - u0);
      const Division at = divide(rise * gone, run);
      const bool is_exact = at.rest == 0;
      if (!is_exact && crossings_ == Crossings::exact) continue;
      const double height = profile(line, static_cast<std::int32_t>(k), v0 + at.quotient,
                                    static_cast<double>(at.rest) / static_cast<double>(run));
      const double share = static_cast<double>(gone) / static_cast<double>(run);
      const double error = std::abs(height - (a_.height + (b_.height - a_.height) * share));
      if (error <= worst.error) continue;
      const auto u = static_cast<std::int32_t>(k << bits);
      const auto v = static_cast<std::int32_t>(v0 + at.quotient + (2 * at.rest >= run ? 1 : 0));
      const LatticePoint place = is_column ? LatticePoint{u, v} : LatticePoint{v, u};
      worst = {error, {place, 0}, is_exact};
    }
  }

 private:
  /// On a line, `part` of a fine step beyond v.
  [[nodiscard]] double profile(Line line, std::int32_t k, std::int64_t v, double part) const {
    const auto before = static_cast<std::int32_t>(v >> grid_.bits());
    const double beyond = static_cast<double>(v - (std::int64_t{before} << grid_.bits())) + part;
    const auto sample = [&](std::int32_t i) {
      return line == Line::column ? grid_.sample(k, i) : grid_.sample(i, k);
    };
    const double height = sample(before);
    if (beyond == 0) return height;
    return height + (sample(before + 1) - height) * std::ldexp(beyond, -grid_.bits());
  }

  const FineGrid& grid_;
  Place a_;
  Place b_;
  Crossings crossings_;
};

}  // namespace

EdgeSplit worst_crossing(const FineGrid& grid, Place a, Place b, Crossings crossings) {
  if (std::tie(b.at.y, b.at.x) < std::tie(a.at.y, a.at.x)) std::swap(a, b);
  const ProfileReader reader(grid, a, b, crossings);
  EdgeSplit worst;
  reader.read(Line::column, worst);
  reader.read(Line::row, worst);
  if (worst.error > 0) worst.place.height = grid.height(worst.place.at);
  return worst;
}

}  // namespace lode::triangle_hierarchy
