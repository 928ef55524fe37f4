#pragma once

#include <optional>
#include <variant>

#include "lode/api/dataset.h"
#include "lode/models/diamond/persist.h"

namespace lode {

/// What a Dataset holds: one of the built-in models.
class Dataset::Impl {
 public:
  std::variant<diamond::Model<2>, diamond::Model<3>> model;
  std::optional<diamond::StoredBytes> stored;
};

/// The tolerance that is chosen where none is asked for.
template <typename Model>
[[nodiscard]] double default_tolerance(const Model& model) {
  constexpr double kShareOfRange = 0.005;
  return kShareOfRange * (model.stats.max - model.stats.min);
}

}  // namespace lode
