#include "lode/api/dataset_impl.h"

#include <algorithm>

#include "lode/models/diamond/isovalue_counts.h"

namespace lode {

Dataset::Impl::Impl(AnyModel built, std::optional<SalvageReport> salvaged)
    : is_flat_(std::holds_alternative<diamond::Model<2>>(built)),
      metadata_(std::visit(
          []<int D>(const diamond::Model<D>& model) {
            return diamond::Metadata{model.info, diamond::summarize<D>(model)};
          },
          built)),
      salvaged_(std::move(salvaged)),
      model_(std::move(built)),
      is_in_memory_(true) {}

Dataset::Impl::Impl(store::Reader reader, diamond::Metadata metadata, Threads threads)
    : is_flat_(reader.model() == diamond::model_name<2>()),
      metadata_(std::move(metadata)),
      stored_(diamond::stored_bytes(reader)),
      threads_(threads),
      reader_(std::move(reader)) {}

Result<Dataset::Impl::AnyModel> Dataset::Impl::load(Progress& progress) const {
  if (is_flat_) {
    LODE_TRY(auto loaded, diamond::load<2>(*reader_, threads_, progress));
    return AnyModel(std::move(loaded));
  }
  LODE_TRY(auto loaded, diamond::load<3>(*reader_, threads_, progress));
  return AnyModel(std::move(loaded));
}

Result<const Dataset::Impl::AnyModel*> Dataset::Impl::model(Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (!model_) {
    LODE_TRY(model_, load(progress));
    is_in_memory_ = true;
  }
  return &*model_;
}

Result<std::uint64_t> Dataset::Impl::bytes_with_triangles(std::span<const double> isovalues,
                                                          double bytes_per_triangle,
                                                          std::uint64_t limit,
                                                          Progress& progress) const {
  const std::lock_guard lock(mutex_);
  std::vector<double> sorted(isovalues.begin(), isovalues.end());
  std::ranges::sort(sorted);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  const auto all = [&] {
    return model_bytes() +
           static_cast<std::uint64_t>(bytes_per_triangle * static_cast<double>(counted_.n));
  };
  const bool is_known = counted_.isovalues == sorted;
  if (is_flat_ || (is_known && (model_ || all() > limit))) return all();
  std::optional<AnyModel> loaded;
  if (!model_) {
    LODE_TRY(loaded, load(progress));
  }
  const auto& model = std::get<diamond::Model<3>>(model_ ? *model_ : *loaded);
  LODE_TRY(const auto counts,
           diamond::count_isosurfaces<3>(model, {sorted, 0, threads_}, progress));
  counted_ = {.isovalues = std::move(sorted), .n = 0};
  for (const diamond::SurfaceCounts& count : counts) counted_.n += count.cells;
  if (loaded && all() <= limit) {
    model_ = std::move(loaded);
    is_in_memory_ = true;
  }
  return all();
}

Result<const Dataset::Impl::AnyPages*> Dataset::Impl::pages(Progress& progress) const {
  if (is_in_memory_) return nullptr;
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

std::uint64_t Dataset::Impl::model_bytes() const {
  const double sample = static_cast<double>(size_of(diamond::storage_type(info().type)));
  constexpr double kBricks = 1.1;  // they share their borders
  constexpr double kNodes = 3.0;   // an error and a range each for 1.14 times 2/8 of the samples, a
                                   // world error for 1.14 times 1/8
  return static_cast<std::uint64_t>(static_cast<double>(info().grid.n_samples()) *
                                    (kBricks * sample + kNodes));
}

std::uint64_t Dataset::Impl::chunk_bytes() const {
  const std::uint64_t fixed =
      is_flat_ ? diamond::CoarseField<2>::n_bytes(info()) + diamond::FilePart<2>::n_bytes(info())
               : diamond::CoarseField<3>::n_bytes(info()) + diamond::FilePart<3>::n_bytes(info());
  return fixed / 7 * 8 + 8;  // an eighth of the limit keeps blocks
}

Result<Dataset::Impl::Chunks*> Dataset::Impl::chunks(std::uint64_t memory_limit,
                                                     bool beside_model) const {
  const auto n_levels = static_cast<int>(summary().max_errors.size());
  if (!reader_ || n_levels <= diamond::kKeptLevel) return nullptr;
  if (is_in_memory_ && !beside_model) return nullptr;
  const std::lock_guard lock(chunks_mutex_);
  if (!chunks_) {
    const std::uint64_t cache_bytes = memory_limit / 8;
    if (is_flat_) {
      LODE_TRY(auto field, diamond::load_coarse<2>(*reader_, metadata_, threads_));
      chunks_.reset(new Chunks{std::move(field), {*reader_, cache_bytes}});
    } else {
      LODE_TRY(auto field, diamond::load_coarse<3>(*reader_, metadata_, threads_));
      chunks_.reset(new Chunks{std::move(field), {*reader_, cache_bytes}});
    }
  }
  return chunks_.get();
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
