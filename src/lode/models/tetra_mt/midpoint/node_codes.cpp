#include "lode/models/tetra_mt/midpoint/node_codes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lode::tetra_mt::midpoint {
namespace {

/// 2^(-16/254) and 2^(-16/4094), rounded up, so that 16 octaves are not quite reached.
constexpr double kErrorRatio = 0.957276;
constexpr double kRadiusRatio = 0.997295;

float float_above(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// 0, and then up to `largest` in steps of the same ratio.
template <typename Number, std::size_t N, typename Round>
void fill(std::array<Number, N>& table, double largest, double ratio, const Round& round) {
  double next = largest;
  for (std::size_t code = N - 1; code > 0; --code, next *= ratio) table[code] = round(next);
  table[0] = 0;
}

template <typename Table, typename Number>
std::uint32_t first_of_at_least(const Table& table, Number x) {
  const auto at = std::ranges::lower_bound(table, x);
  return static_cast<std::uint32_t>(
      std::min<std::ptrdiff_t>(at - table.begin(), std::ssize(table) - 1));
}

/// 64 of a field's values, with as many between each two; the smallest first, the largest last.
NodeCodes::Knots knots_of(std::span<const double> values) {
  NodeCodes::Knots knots{};
  if (values.empty()) return knots;
  constexpr std::size_t kSeen = std::size_t{1} << 16;
  std::vector<double> seen;
  const std::size_t stride = values.size() / kSeen + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) seen.push_back(values[i]);
  std::ranges::sort(seen);
  for (std::size_t i = 0; i < knots.size(); ++i)
    knots[i] = seen[i * (seen.size() - 1) / (knots.size() - 1)];
  const auto [low, high] = std::ranges::minmax(values);
  knots.front() = low;
  knots.back() = high;
  return knots;
}

}  // namespace

RadiusCodes::RadiusCodes(double largest) : largest_(largest) {
  fill(radii_, largest / kRadiusRatio, kRadiusRatio, [](double x) { return x; });
  radii_.back() = std::numeric_limits<double>::infinity();
}

std::uint32_t RadiusCodes::code(double radius) const { return first_of_at_least(radii_, radius); }

NodeCodes::NodeCodes(std::span<const double> values, double largest_error)
    : NodeCodes(knots_of(values), largest_error) {}

NodeCodes::NodeCodes(const Knots& knots, double largest_error)
    : largest_error_(largest_error), knots_(knots) {
  fill(errors_, largest_error, kErrorRatio, [](double x) { return x > 0 ? float_above(x) : 0.0F; });
}

std::uint32_t NodeCodes::error_code(double error) const {
  return error == 0 ? 0 : std::max(1U, first_of_at_least(errors_, float_above(error)));
}

std::uint32_t NodeCodes::low_code(double value) const {
  const auto at = std::ranges::upper_bound(knots_, value);
  return static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(at - knots_.begin() - 1, 0));
}

std::uint32_t NodeCodes::high_code(double value) const { return first_of_at_least(knots_, value); }

StoredFacts NodeCodes::facts(const Parts& parts) const {
  StoredFacts facts{.error = errors_[parts.error]};
  const double reference = knots_[0];
  facts.low = -float_above(reference - knots_[parts.low]);
  facts.high = float_above(knots_[parts.high] - reference);
  return facts;
}

}  // namespace lode::tetra_mt::midpoint
