#include "lode/api/dataset_impl.h"

namespace lode {

Dataset::Impl::Impl(AnyModel built)
    : is_flat_(std::holds_alternative<diamond::Model<2>>(built)),
      metadata_(std::visit(
          []<int D>(const diamond::Model<D>& model) {
            return diamond::Metadata{model.info, diamond::summarize<D>(model)};
          },
          built)),
      model_(std::move(built)),
      is_in_memory_(true) {}

Dataset::Impl::Impl(store::Reader reader, diamond::Metadata metadata, Threads threads)
    : is_flat_(reader.model() == diamond::model_name<2>()),
      metadata_(std::move(metadata)),
      stored_(diamond::stored_bytes(reader)),
      threads_(threads),
      reader_(std::move(reader)) {}

Result<const Dataset::Impl::AnyModel*> Dataset::Impl::model(Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (!model_) {
    if (is_flat_) {
      LODE_TRY(auto loaded, diamond::load<2>(*reader_, threads_, progress));
      model_ = std::move(loaded);
    } else {
      LODE_TRY(auto loaded, diamond::load<3>(*reader_, threads_, progress));
      model_ = std::move(loaded);
    }
    is_in_memory_ = true;
  }
  return &*model_;
}

Result<const Dataset::Impl::AnyPages*> Dataset::Impl::pages(Progress& progress) const {
  if (is_in_memory_ || summary().stats.n_holes > 0) return nullptr;
  const std::lock_guard lock(pages_mutex_);
  if (!pages_) {
    if (is_flat_) {
      LODE_TRY(auto opened, diamond::PagedModel<2>::open(*reader_, metadata_, progress));
      pages_ = std::move(opened);
    } else {
      LODE_TRY(auto opened, diamond::PagedModel<3>::open(*reader_, metadata_, progress));
      pages_ = std::move(opened);
    }
  }
  return &*pages_;
}

Result<std::shared_ptr<const diamond::WorldErrors>> Dataset::Impl::world_errors(
    Progress& progress) const {
  LODE_TRY(const AnyModel* const in_memory, model(progress));
  const std::lock_guard lock(world_errors_mutex_);
  if (!world_errors_) {
    LODE_TRY(auto found, std::visit(
                             [&]<int D>(const diamond::Model<D>& held) {
                               return diamond::compute_world_errors<D>(held, {}, progress);
                             },
                             *in_memory));
    world_errors_ = std::make_shared<const diamond::WorldErrors>(std::move(found));
  }
  return world_errors_;
}

}  // namespace lode
