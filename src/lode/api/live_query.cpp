#include "lode/api/live_query.h"

#include <new>
#include <optional>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/core/out_of_memory.h"
#include "lode/models/diamond/paged_refinable.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

/// `Nodes`: of a model in memory, or in a file.
template <int D, typename Field, typename Nodes>
class DiamondLiveQuery final : public LiveQuery {
 public:
  static constexpr bool kIsPaged = PagedRefinableModel<Nodes>;

  /// `given`: what Nodes are made of.
  template <typename... Given>
  explicit DiamondLiveQuery(bool with_normals, const Given&... given)
      : nodes_(given...), with_normals_(with_normals) {}

  /// Another isovalue starts from the base, which gives a first surface sooner than looking through
  /// the cut of the last one.
  void set_query(const Query& query) override {
    FocusChange change = FocusChange::changed;
    if (keeps_surface(query))
      change = focus_change(*query_, query);
    else
      start_over(query.isovalues.front());
    query_ = query;
    engine_->set_query(to_demand(query), query.budget, change);
  }

  [[nodiscard]] bool keeps_surface(const Query& query) const override {
    return surface_ && surface_->isovalue() == query.isovalues.front();
  }

  bool step() override { return engine_->step(); }
  void wait(std::chrono::steady_clock::time_point until) override {
    if constexpr (kIsPaged) nodes_.client().wait(until);
  }
  void on_data(std::function<void()> wake) override {
    if constexpr (kIsPaged) nodes_.client().on_fetched(std::move(wake));
  }
  [[nodiscard]] std::optional<Error> fault() const override {
    if constexpr (kIsPaged)
      if (engine_->standing().awaits_data) return nodes_.fault();
    return {};
  }

  [[nodiscard]] Standing standing() const override { return engine_->standing(); }
  [[nodiscard]] std::size_t n_cells() const override { return surface_->n_cells(); }
  [[nodiscard]] std::size_t n_changed() const override { return surface_->n_changed(); }
  void write(Surface& surface) const override { surface_->write(surface); }
  bool gather(std::size_t n_most, SurfaceBatch& batch) override {
    return surface_->gather(n_most, batch);
  }
  void take_back(const SurfaceBatch& batch) override { surface_->take_back(batch); }
  [[nodiscard]] double achieved_px() const override {
    const std::vector<FocusDemand> measures = pixel_measures(*query_);
    return engine_->largest([&](const NodeFacts& node) {
      double largest = 0;
      for (const FocusDemand& measure : measures) largest = std::max(largest, measure.error(node));
      return largest;
    });
  }

  [[nodiscard]] double finest_share() const override {
    const Cut& cut = engine_->cut();
    std::size_t n_finest = 0;
    for (std::size_t at = 0; at < cut.n_places(); ++at) {
      const Cut::Entry& entry = cut[static_cast<Cut::Place>(at)];
      if (entry.state == Cut::State::applied)
        n_finest += diamond::diamond_of<D>(entry.id).level == 0 ? 1 : 0;
    }
    return static_cast<double>(n_finest) /
           static_cast<double>(std::max<std::size_t>(1, cut.n_applied()));
  }

 private:
  void start_over(double isovalue) {
    engine_.emplace(nodes_);
    if constexpr (kIsPaged) nodes_.let_all_go();
    surface_.emplace(nodes_, isovalue, with_normals_);
    nodes_.follow(&*surface_);
  }

  Nodes nodes_;
  std::optional<Engine<Nodes>> engine_;
  bool with_normals_;
  std::optional<diamond::LiveIsosurface<D, Field>> surface_;
  std::optional<Query> query_;
};

template <int D>
bool has_normals(Normals normals) {
  return D == 3 && normals == Normals::on;
}

/// With world errors, which it keeps.
template <int D>
class NodesInMemory : public diamond::LiveRefinable<D> {
 public:
  NodesInMemory(const diamond::Model<D>& model,
                const std::shared_ptr<const diamond::WorldErrors>& worlds)
      : diamond::LiveRefinable<D>(model, *worlds), worlds_(worlds) {}

 private:
  std::shared_ptr<const diamond::WorldErrors> worlds_;
};

std::unique_ptr<LiveQuery> open_paged(const Dataset::Impl::AnyPages& pages,
                                      const LiveQueryOptions& options) {
  return std::visit(
      [&]<int D>(const std::unique_ptr<const diamond::PagedModel<D>>& model)
          -> std::unique_ptr<LiveQuery> {
        using Nodes = diamond::PagedRefinable<D>;
        using Live = DiamondLiveQuery<D, diamond::PagedModel<D>, Nodes>;
        const std::uint64_t given = options.memory_limit / (options.leaves_half ? 2 : 1);
        model->set_memory_limit(given > 0 ? given : physical_memory() / 4);
        const auto worlds = options.with_views ? Nodes::Worlds::of_pages : Nodes::Worlds::none;
        return std::make_unique<Live>(has_normals<D>(options.normals), *model, worlds);
      },
      pages);
}

bool has_worlds(const Dataset::Impl::AnyPages& pages) {
  return std::visit([](const auto& model) { return model->has_worlds(); }, pages);
}

/// Files from before world errors were in them are loaded for views, as far as memory may be taken.
Result<void> check_memory(const Dataset::Impl& impl, const LiveQueryOptions& options) {
  if (options.memory_limit == 0 || impl.model_bytes() <= options.memory_limit) return {};
  return fail(
      "expected a memory limit of at least {} MB for pixel errors of a file that was built before "
      "files had world errors, got {:g} MB; build it again",
      impl.model_bytes() / 1'000'000 + 1, 1e-6 * static_cast<double>(options.memory_limit));
}

std::unique_ptr<LiveQuery> open_in_memory(const Dataset::Impl::AnyModel& in_memory,
                                          const std::shared_ptr<const diamond::WorldErrors>& worlds,
                                          Normals normals) {
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> std::unique_ptr<LiveQuery> {
        const bool with_normals = has_normals<D>(normals);
        using Field = diamond::Model<D>;
        if (worlds)
          return std::make_unique<DiamondLiveQuery<D, Field, NodesInMemory<D>>>(with_normals, model,
                                                                                worlds);
        return std::make_unique<DiamondLiveQuery<D, Field, diamond::LiveRefinable<D>>>(with_normals,
                                                                                       model);
      },
      in_memory);
}

}  // namespace

Result<std::unique_ptr<LiveQuery>> open_live_query(const Dataset& dataset,
                                                   const LiveQueryOptions& options,
                                                   Progress& progress) try {
  const Dataset::Impl& impl = dataset.impl();
  LODE_TRY(const auto* const pages, impl.pages(progress));
  if (pages != nullptr) {
    if (!options.with_views || has_worlds(*pages)) return open_paged(*pages, options);
    LODE_CHECK(check_memory(impl, options));
  }
  LODE_TRY(const auto* const in_memory, impl.model(progress));
  std::shared_ptr<const diamond::WorldErrors> worlds;
  if (options.with_views) {
    LODE_TRY(worlds, impl.world_errors(progress));
  }
  return open_in_memory(*in_memory, worlds, options.normals);
} catch (const std::bad_alloc&) {
  return out_of_memory("open the surface of a query");
}

Result<void> check_live_query(const Query& query, bool has_views) {
  LODE_CHECK(check_query(query));
  if (query.max_world_error)
    return fail("max world error: expected none of a volume, which has distances of surfaces");
  if (query.isovalues.size() != 1)
    return fail("a surface that follows its query: expected one isovalue, got {}",
                query.isovalues.size());
  if (query.max_error_px && !has_views)
    return fail("max error in pixels: expected it to be opened with views");
  return {};
}

}  // namespace lode
