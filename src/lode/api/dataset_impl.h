#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <variant>

#include "lode/api/dataset.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/world_error.h"

namespace lode {

/// What a Dataset holds: one of the built-in models.
class Dataset::Impl {
 public:
  template <typename Model>
  explicit Impl(Model held, std::optional<diamond::StoredBytes> stored_bytes = {})
      : model(std::move(held)), stored(std::move(stored_bytes)) {}

  std::variant<diamond::Model<2>, diamond::Model<3>> model;
  std::optional<diamond::StoredBytes> stored;

  /// Found when first asked for, on all cores; they are not in files. Safe from many threads.
  [[nodiscard]] Result<std::shared_ptr<const diamond::WorldErrors>> world_errors(
      Progress& progress) const {
    const std::lock_guard lock(world_errors_mutex_);
    if (!world_errors_) {
      LODE_TRY(auto found, std::visit(
                               [&]<int D>(const diamond::Model<D>& held) {
                                 return diamond::compute_world_errors<D>(held, {}, progress);
                               },
                               model));
      world_errors_ = std::make_shared<const diamond::WorldErrors>(std::move(found));
    }
    return world_errors_;
  }

 private:
  mutable std::mutex world_errors_mutex_;
  mutable std::shared_ptr<const diamond::WorldErrors> world_errors_;
};

/// Refuses options that have no answer.
[[nodiscard]] Result<void> check_extract_options(const ExtractOptions& options);

/// The tolerance that is chosen where none is asked for.
template <typename Model>
[[nodiscard]] double default_tolerance(const Model& model) {
  constexpr double kShareOfRange = 0.005;
  return kShareOfRange * (model.stats.max - model.stats.min);
}

}  // namespace lode
