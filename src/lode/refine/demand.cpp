#include "lode/refine/demand.h"

#include <algorithm>

namespace lode {
namespace {

struct Nothing {
  [[nodiscard]] double operator()(const NodeFacts&) const { return 0; }
  [[nodiscard]] static bool touches(const NodeFacts&) { return false; }
  [[nodiscard]] static bool uses_bounds() { return false; }
};

bool any_uses_bounds(const std::vector<Demand>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [](const Demand& demand) { return demand.uses_bounds(); });
}

bool any_uses_regions(const std::vector<Demand>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [](const Demand& demand) { return demand.uses_regions(); });
}

bool any_touches(const std::vector<Demand>& parts, const NodeFacts& node) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const Demand& demand) { return demand.touches(node); });
}

struct Largest {
  std::vector<Demand> parts;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    double largest = 0;
    for (const Demand& demand : parts) largest = std::max(largest, demand(node));
    return largest;
  }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return any_touches(parts, node); }
  [[nodiscard]] bool uses_bounds() const { return any_uses_bounds(parts); }
  [[nodiscard]] bool uses_regions() const { return any_uses_regions(parts); }
};

struct Sum {
  std::vector<Demand> parts;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    double sum = 0;
    for (const Demand& demand : parts) sum += std::max(0.0, demand(node));
    return sum;
  }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return any_touches(parts, node); }
  [[nodiscard]] bool uses_bounds() const { return any_uses_bounds(parts); }
  [[nodiscard]] bool uses_regions() const { return any_uses_regions(parts); }
};

struct Smallest {
  std::vector<Demand> parts;

  [[nodiscard]] double operator()(const NodeFacts& node) const {
    if (parts.empty()) return 0;
    double smallest = parts.front()(node);
    for (const Demand& demand : parts) smallest = std::min(smallest, demand(node));
    return smallest;
  }
  [[nodiscard]] bool touches(const NodeFacts& node) const {
    return !parts.empty() && std::all_of(parts.begin(), parts.end(), [&](const Demand& demand) {
      return demand.touches(node);
    });
  }
  [[nodiscard]] bool uses_bounds() const { return any_uses_bounds(parts); }
  [[nodiscard]] bool uses_regions() const { return any_uses_regions(parts); }
};

struct WithinRegions {
  Demand demand;
  std::uint64_t wanted = 0;

  [[nodiscard]] bool meets(const NodeFacts& node) const { return (node.regions & wanted) != 0; }
  [[nodiscard]] Evaluation evaluate(const NodeFacts& node) const {
    return meets(node) ? demand.evaluate(node) : Evaluation{0, false};
  }
  [[nodiscard]] double operator()(const NodeFacts& node) const {
    return meets(node) ? demand(node) : 0;
  }
  [[nodiscard]] bool touches(const NodeFacts& node) const {
    return meets(node) && demand.touches(node);
  }
  [[nodiscard]] bool uses_bounds() const { return demand.uses_bounds(); }
  [[nodiscard]] static bool uses_regions() { return true; }
};

}  // namespace

Demand::Demand() : Demand(Nothing{}) {}

Demand max_of(std::vector<Demand> demands) { return Largest{std::move(demands)}; }
Demand sum_of(std::vector<Demand> demands) { return Sum{std::move(demands)}; }
Demand min_of(std::vector<Demand> demands) { return Smallest{std::move(demands)}; }
Demand within_regions(Demand demand, std::uint64_t wanted) {
  return WithinRegions{std::move(demand), wanted};
}

}  // namespace lode
