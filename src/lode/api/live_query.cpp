#include "lode/api/live_query.h"

#include <optional>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/live_isosurface.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

template <int D>
class DiamondLiveQuery final : public LiveQuery {
 public:
  DiamondLiveQuery(const diamond::Model<D>& model,
                   std::shared_ptr<const diamond::WorldErrors> world_errors, bool with_normals)
      : world_errors_(std::move(world_errors)),
        nodes_(model, world_errors_.get()),
        with_normals_(with_normals) {}

  void set_query(const Query& query) override {
    const double isovalue = query.isovalues.front();
    const FocusChange change = query_ ? focus_change(*query_, query) : FocusChange::changed;
    query_ = query;
    const bool is_other = surface_ && surface_->isovalue() != isovalue;
    if (!surface_ || (is_other && engine_->cut().n_applied() > kMostNodesKept)) {
      start_over(isovalue);
    } else if (surface_->isovalue() != isovalue) {
      surface_->restart(isovalue);
      surface_->begin(engine_->cut());
      next_place_ = 0;
    }
    engine_->set_query(to_demand(query), query.budget,
                       engine_->cut().size() == 0 ? FocusChange::changed : change);
  }

  [[nodiscard]] bool keeps_surface(const Query& query) const override {
    return surface_ && surface_->isovalue() == query.isovalues.front();
  }

  [[nodiscard]] std::uint64_t generation() const override { return generation_; }

  bool step() override {
    if (is_complete()) return engine_->step();
    constexpr std::size_t kNodesPerStep = 256;
    const Cut& cut = engine_->cut();
    const std::size_t end = std::min(cut.n_places(), next_place_ + kNodesPerStep);
    for (; next_place_ < end; ++next_place_) {
      const Cut::Entry& entry = cut[static_cast<Cut::Place>(next_place_)];
      if (entry.state == Cut::State::applied) surface_->add_leaves(entry.id, cut);
    }
    if (next_place_ == cut.n_places()) next_place_ = kComplete;
    return true;
  }

  [[nodiscard]] bool is_complete() const override { return next_place_ == kComplete; }
  [[nodiscard]] Standing standing() const override { return engine_->standing(); }
  [[nodiscard]] std::size_t n_cells() const override { return surface_->n_cells(); }
  [[nodiscard]] std::size_t n_changed() const override { return surface_->n_changed(); }
  void write(Surface& surface) const override { surface_->write(surface); }
  bool gather(std::size_t n_most, SurfaceBatch& batch) override {
    return surface_->gather(n_most, batch);
  }
  void take_back(const SurfaceBatch& batch) override { surface_->take_back(batch); }
  [[nodiscard]] double achieved_px() const override {
    const Query& query = *query_;
    return engine_->largest([&](const NodeFacts& node) { return achieved_pixels(query, node); });
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
  /// From so many nodes the base is sooner refined than the cut looked through: the first surface
  /// comes at once, whatever was there.
  static constexpr std::size_t kMostNodesKept = 2000;
  static constexpr std::size_t kComplete = static_cast<std::size_t>(-1);

  std::shared_ptr<const diamond::WorldErrors> world_errors_;
  void start_over(double isovalue) {
    engine_.emplace(nodes_);
    surface_.emplace(nodes_, isovalue, with_normals_);
    nodes_.follow(&*surface_);
    next_place_ = kComplete;
    ++generation_;
  }

  diamond::LiveRefinable<D> nodes_;
  std::optional<Engine<diamond::LiveRefinable<D>>> engine_;
  std::uint64_t generation_ = 0;
  bool with_normals_;
  std::optional<diamond::LiveIsosurface<D>> surface_;
  std::optional<Query> query_;
  std::size_t next_place_ = kComplete;  ///< Of the cut, whose leaves are looked at next.
};

}  // namespace

Result<std::unique_ptr<LiveQuery>> open_live_query(const Dataset& dataset, Normals normals,
                                                   bool with_views, Progress& progress) {
  std::shared_ptr<const diamond::WorldErrors> world_errors;
  if (with_views) {
    LODE_TRY(world_errors, dataset.impl().world_errors(progress));
  }
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> std::unique_ptr<LiveQuery> {
        return std::make_unique<DiamondLiveQuery<D>>(model, world_errors,
                                                     D == 3 && normals == Normals::on);
      },
      dataset.impl().model);
}

Result<void> check_live_query(const Query& query, bool has_views) {
  LODE_CHECK(check_query(query));
  if (query.isovalues.size() != 1)
    return fail("a surface that follows its query: expected one isovalue, got {}",
                query.isovalues.size());
  if (query.max_error_px && !has_views)
    return fail("max error in pixels: expected it to be opened with views");
  return {};
}

}  // namespace lode
