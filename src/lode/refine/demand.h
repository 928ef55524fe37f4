#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "lode/refine/model.h"

namespace lode {

/// What a demand says about a node.
struct Evaluation {
  double demand = 0;
  bool touches = true;
};

/// How much nodes want refining: > 0 if at all, the larger the sooner. A small value, cheap to
/// copy, safe to use from many threads. Must not decrease when an error grows, or the range or
/// bounds widen; then it is nested as they are, and the cut of a query is unique and minimal.
///
/// Any callable (const NodeFacts&) -> double is a demand. It may have a member
/// `bool touches(const NodeFacts&)`, as monotone: where false, the demand is never positive for the
/// query's focus, so such nodes need not be kept as candidates nor counted in error bounds. One
/// that can say both at once has `Evaluation evaluate(const NodeFacts&)`.
class Demand {
 public:
  /// Wants nothing.
  Demand();
  template <typename F>
  requires(!std::same_as<F, Demand> && std::is_invocable_r_v<double, const F&, const NodeFacts&>)
      Demand(F rule)  // NOLINT(google-explicit-constructor): any callable is one
      : rule_(std::make_shared<Held<F>>(std::move(rule))) {}

  [[nodiscard]] double operator()(const NodeFacts& node) const { return rule_->demand(node); }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return rule_->touches(node); }
  [[nodiscard]] Evaluation evaluate(const NodeFacts& node) const { return rule_->evaluate(node); }
  /// Whether NodeFacts::bounds must be filled.
  [[nodiscard]] bool uses_bounds() const { return rule_->uses_bounds(); }
  /// Likewise NodeFacts::regions: only where `bool uses_regions()` of the callable says so.
  [[nodiscard]] bool uses_regions() const { return rule_->uses_regions(); }

 private:
  struct Rule {
    virtual ~Rule() = default;
    [[nodiscard]] virtual double demand(const NodeFacts& node) const = 0;
    [[nodiscard]] virtual bool touches(const NodeFacts& node) const = 0;
    [[nodiscard]] virtual Evaluation evaluate(const NodeFacts& node) const = 0;
    [[nodiscard]] virtual bool uses_bounds() const = 0;
    [[nodiscard]] virtual bool uses_regions() const = 0;
  };
  template <typename F>
  struct Held final : Rule {
    explicit Held(F f) : rule(std::move(f)) {}
    [[nodiscard]] double demand(const NodeFacts& node) const override { return rule(node); }
    [[nodiscard]] bool touches(const NodeFacts& node) const override {
      if constexpr (requires { rule.touches(node); })
        return rule.touches(node);
      else
        return true;
    }
    [[nodiscard]] Evaluation evaluate(const NodeFacts& node) const override {
      if constexpr (requires { rule.evaluate(node); })
        return rule.evaluate(node);
      else
        return {rule(node), touches(node)};
    }
    [[nodiscard]] bool uses_bounds() const override {
      if constexpr (requires { rule.uses_bounds(); })
        return rule.uses_bounds();
      else
        return true;
    }
    [[nodiscard]] bool uses_regions() const override {
      if constexpr (requires { rule.uses_regions(); })
        return rule.uses_regions();
      else
        return false;
    }
    F rule;
  };

  std::shared_ptr<const Rule> rule_;
};

/// A demand as engine and cuts keep it: positive where it is, else 0.
[[nodiscard]] inline float to_rank(double demand) {
  const float rank = static_cast<float>(demand);
  if (demand > 0 && !(rank > 0)) return std::numeric_limits<float>::min();
  return rank > 0 ? rank : 0.0F;
}

/// The largest of several demands; nothing where there are none.
[[nodiscard]] Demand max_of(std::vector<Demand> demands);
/// The sum of the positive ones: what many want comes first.
[[nodiscard]] Demand sum_of(std::vector<Demand> demands);
/// The smallest: only what all want.
[[nodiscard]] Demand min_of(std::vector<Demand> demands);
/// A demand for some regions alone: nodes that meet none of them are not touched. `wanted`: a bit
/// each, as of NodeFacts::regions.
[[nodiscard]] Demand within_regions(Demand demand, std::uint64_t wanted);

}  // namespace lode
