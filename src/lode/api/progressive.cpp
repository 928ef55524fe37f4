#include "lode/api/progressive.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <utility>

#include "lode/api/dataset_impl.h"
#include "lode/api/finishing.h"
#include "lode/core/out_of_memory.h"
#include "lode/models/diamond/morph.h"
#include "lode/refine/engine.h"

namespace lode {
namespace {

constexpr int kMostHalvings = 16;

/// The tolerances of all steps, falling.
std::vector<double> step_tolerances(double first, double last) {
  std::vector<double> tolerances;
  for (int k = 0; k <= kMostHalvings && std::ldexp(first, -k) > last; ++k)
    tolerances.push_back(std::ldexp(first, -k));
  tolerances.push_back(last);
  return tolerances;
}

}  // namespace

class ProgressiveSurface::Impl {
 public:
  virtual ~Impl() = default;
  virtual Result<bool> advance(Progress& progress) = 0;
  [[nodiscard]] virtual int most_steps() const = 0;
  [[nodiscard]] virtual Surface surface(double moment) const = 0;

  ProgressiveStep step;
};

template <int D>
class ProgressiveSurface::Steps final : public Impl {
 public:
  Steps(const diamond::Model<D>& model, const ExtractOptions& options)
      : options_(options),
        has_holes_(model.has_holes()),
        isovalue_(options.isovalues.front()),
        nodes_(model),
        engine_(nodes_) {
    // With holes the base has no error bound; what any mesh is off by, the range bounds.
    const double range = model.stats.max - model.stats.min;
    tolerances_ = step_tolerances(std::min(model.base_error(), range),
                                  options.max_error.value_or(default_tolerance(model.stats)));
  }

  Result<bool> advance(Progress& progress) override {
    const bool is_first = next_ == 0;
    morph_.reset();
    if (is_first) LODE_CHECK(refine(progress));
    if (!is_first && nodes_.added().size() == 0) return false;
    LODE_CHECK(find_morph(is_first, progress));
    nodes_.forget();
    // The cut goes on to where it changes: a step answers all tolerances before that.
    while (next_ < tolerances_.size() && nodes_.added().size() == 0) {
      LODE_CHECK(refine(progress));
      if (nodes_.added().size() == 0) step.max_error = tolerance_;
    }
    return true;
  }
  [[nodiscard]] int most_steps() const override { return static_cast<int>(tolerances_.size()); }

  [[nodiscard]] Surface surface(double moment) const override {
    Surface surface = morph_->surface(moment);
    if (step.is_first) surface.origins.clear();
    if (has_holes_) split_pinched_vertices(surface);
    static_cast<void>(finish_edits(options_, surface));
    return surface;
  }

 private:
  /// To the next tolerance.
  Result<void> refine(Progress& progress) {
    const FocusChange focus = next_ == 0 ? FocusChange::changed : FocusChange::same;
    progress.report("refining", static_cast<double>(next_) / static_cast<double>(most_steps()));
    tolerance_ = tolerances_[next_++];
    engine_.set_query(isovalue_demand(isovalue_, tolerance_), {}, focus);
    engine_.run([&] { return progress.is_cancelled(); });
    if (progress.is_cancelled()) return cancelled_error();
    return {};
  }

  Result<void> find_morph(bool is_first, Progress& progress) {
    step.max_error = tolerance_;
    step.achieved_error = engine_.standing().error_bound;
    step.new_nodes = nodes_.added().size();
    step.is_first = is_first;
    const FlatIndex none;
    const bool with_normals = D == 3 && options_.normals == Normals::on;
    LODE_TRY(auto morph,
             diamond::MorphStep<D>::find(nodes_, engine_.cut(), is_first ? none : nodes_.added(),
                                         {isovalue_, with_normals}, progress));
    morph_.emplace(std::move(morph));
    return {};
  }

  ExtractOptions options_;
  bool has_holes_;
  double isovalue_;
  diamond::NotedRefinable<D> nodes_;
  Engine<diamond::NotedRefinable<D>> engine_;
  std::vector<double> tolerances_;
  std::size_t next_ = 0;  ///< Of them.
  double tolerance_ = 0;  ///< The cut's.
  std::optional<diamond::MorphStep<D>> morph_;
};

ProgressiveSurface::ProgressiveSurface(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ProgressiveSurface::ProgressiveSurface(ProgressiveSurface&&) noexcept = default;
ProgressiveSurface& ProgressiveSurface::operator=(ProgressiveSurface&&) noexcept = default;
ProgressiveSurface::~ProgressiveSurface() = default;

Result<ProgressiveSurface> ProgressiveSurface::begin(const Dataset& dataset,
                                                     const ExtractOptions& options,
                                                     Progress& progress) try {
  LODE_CHECK(check_extract_options(options));
  if (options.isovalues.size() != 1)
    return fail("a progressive surface: expected one isovalue, got {}", options.isovalues.size());
  LODE_TRY(const auto* const held, dataset.impl().model(progress));
  return ProgressiveSurface(std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> std::unique_ptr<Impl> {
        return std::make_unique<Steps<D>>(model, options);
      },
      *held));
} catch (const std::bad_alloc&) {
  return out_of_memory("begin the surface");
}

Result<bool> ProgressiveSurface::advance(Progress& progress) try {
  return impl_->advance(progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("refine the surface");
}

const ProgressiveStep& ProgressiveSurface::step() const { return impl_->step; }
int ProgressiveSurface::most_steps() const { return impl_->most_steps(); }
Surface ProgressiveSurface::surface(double moment) const { return impl_->surface(moment); }

}  // namespace lode
