#pragma once

#include <type_traits>
#include <variant>

#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/models/diamond/paged_refinable.h"

namespace lode {

/// run(nodes) with the hierarchy's pages where the file is not loaded, and they serve the query
/// better; else with the model.
template <typename Run>
auto with_nodes(const Dataset::Impl& impl, std::uint64_t memory_limit, bool reads_little,
                Progress& progress, const Run& run)
    -> std::invoke_result_t<Run, const diamond::Refinable<3>&> {
  const std::uint64_t limit = memory_limit > 0 ? memory_limit : physical_memory() / 4;
  const bool is_too_large = impl.is_in_file() && impl.model_bytes() > limit;
  // Which coarse tetrahedra holes remove is known from fine samples.
  if ((reads_little || is_too_large) && impl.summary().stats.n_holes == 0) {
    LODE_TRY(const auto* const pages, impl.pages(progress));
    if (pages != nullptr)
      return std::visit(
          [&]<int D>(const std::unique_ptr<const diamond::PagedModel<D>>& model) {
            model->set_memory_limit(memory_limit > 0 ? limit / 2 : limit);  // and half for the cut
            diamond::PagedRefinable<D> nodes(*model);
            return run(nodes);
          },
          *pages);
  }
  if (memory_limit > 0 && is_too_large)
    return fail("expected a memory limit of at least {} MB for a field with holes, got {:g} MB",
                impl.model_bytes() / 1'000'000 + 1, 1e-6 * static_cast<double>(limit));
  LODE_TRY(const auto* const held, impl.model(progress));
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) {
        const diamond::Refinable<D> nodes(model);
        return run(nodes);
      },
      *held);
}

/// Of the nodes that with_nodes() passes on.
template <int D, typename Field>
std::integral_constant<int, D> dimension_of(const diamond::Refinable<D, Field>& nodes);

}  // namespace lode
