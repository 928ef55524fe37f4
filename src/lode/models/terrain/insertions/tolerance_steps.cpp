#include "lode/models/terrain/insertions/tolerance_steps.h"

#include <algorithm>
#include <bit>

namespace lode::insertions {
namespace {

/// Errors of the triangles that there are, and the largest of them.
class ErrorCounts {
 public:
  ErrorCounts() : counts_(std::size_t{1} << 16) {}

  void add(float error) {
    const std::uint32_t code = code_of(error);
    ++counts_[code];
    top_ = std::max(top_, code);
  }
  void remove(float error) { --counts_[code_of(error)]; }
  [[nodiscard]] float largest() {
    while (top_ > 0 && counts_[top_] == 0) --top_;
    return std::bit_cast<float>(top_ << 16);
  }

 private:
  static std::uint32_t code_of(float error) { return std::bit_cast<std::uint32_t>(error) >> 16; }

  std::vector<std::uint32_t> counts_;  ///< By upper half.
  std::uint32_t top_ = 0;
};

}  // namespace

std::vector<ToleranceStep> find_tolerance_steps(const History& history) {
  std::vector<ToleranceStep> steps;
  ErrorCounts errors;
  const auto add = [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t t = begin; t < end; ++t) errors.add(history.triangles[t].error);
  };
  add(0, history.n_base_triangles());
  const auto step_at = [&](float error, std::uint32_t time) {
    return ToleranceStep{error, time, history.first_made[time] - history.first_removed[time],
                         errors.largest()};
  };
  for (std::uint32_t node = 0; node < history.n_nodes(); ++node) {
    const float error = history.error_before(node);
    if (history.is_worst_first() && (steps.empty() || error < steps.back().error))
      steps.push_back(step_at(error, node));
    for (const std::uint32_t t : history.removed_by(node))
      errors.remove(history.triangles[t].error);
    add(history.first_made[node], history.first_made[node + 1]);
  }
  steps.push_back(step_at(errors.largest(), history.n_nodes()));
  return steps;
}

const ToleranceStep& step_within(std::span<const ToleranceStep> steps, double tolerance) {
  for (const ToleranceStep& step : steps.first(steps.size() - 1))
    if (static_cast<double>(step.error) <= tolerance) return step;
  return steps.back();
}

}  // namespace lode::insertions
