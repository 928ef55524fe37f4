#include "lode/models/diamond/cut_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "lode/models/diamond/barycentric.h"
#include "lode/models/diamond/refinable.h"

namespace lode::diamond {
namespace {

template <int D>
class CutChecker {
 public:
  CutChecker(const Model<D>& model, const IsosurfaceQuery& query)
      : model_(model), nodes_(model), query_(query) {}

  /// Visits simplices down to brick size; smaller ones are put off for run_in_parallel().
  void start() {
    for (const Simplex<D>& s : kuhn_simplices<D>({}, model_.shape.root_side()))
      visit(s, report_, true);
  }
  Result<CutReport> run_in_parallel(Progress& progress) {
    std::vector<CutReport> parts(waiting_.size());
    parallel_for(waiting_.size(), query_.threads, 1, [&](std::size_t i, int) {
      if (!progress.is_cancelled()) visit(waiting_[i], parts[i], false);
    });
    if (progress.is_cancelled()) return cancelled_error();
    for (const CutReport& part : parts) join(part);
    return report_;
  }

 private:
  void visit(const Simplex<D>& s, CutReport& report, bool may_wait) {
    const LatticeBox<D> box = bounds_of(s);
    if (!model_.shape.overlaps_data(box)) return;
    if (may_wait && box.edge(0) <= kBrickEdge<D>) {
      waiting_.push_back(s);
      return;
    }
    if (is_finest(s)) return;  // F' is F there
    const Diamond<D> d = diamond_at<D>(s.bisection_point());
    const NodeFacts facts = nodes_.facts_at(d);
    if (!facts.range.crosses(query_.isovalue) || is_clear(s, box, facts.error)) {
      check_pruned(s, box, report);
      return;
    }
    if (query_.tolerance == 0 || facts.error > query_.tolerance ||
        model_.shape.reaches_across(d.centre, d.level) || is_wanted(d)) {
      for (const Simplex<D>& half : bisect(s)) visit(half, report, may_wait);
      return;
    }
    check_active(s, box, facts.error, report);
  }

  [[nodiscard]] bool is_wanted(const Diamond<D>& d) const {
    if constexpr (D == 3) return query_.wanted != nullptr && query_.wanted->contains(d.centre);
    return false;
  }

  /// Whether an extraction may leave a simplex aside because of its corners: they lie on one side,
  /// farther from the isovalue than the error.
  [[nodiscard]] bool is_clear(const Simplex<D>& s, const LatticeBox<D>& box, double error) const {
    if (!model_.shape.is_sample(box.upper)) return false;
    bool is_above = true;
    bool is_below = true;
    for (const Index<D>& v : s.v) {
      const double distance = model_.value_or_nan(v) - query_.isovalue;
      is_above = is_above && distance > error;
      is_below = is_below && -distance > error;
    }
    return is_above || is_below;
  }

  /// Calls body(p, weights) for each sample in the closed simplex.
  template <typename F>
  void for_each_sample(const Simplex<D>& s, const LatticeBox<D>& box, const F& body) const {
    const Barycentric<D> coordinates(s);
    std::array<std::int64_t, as_size(D) + 1> weights{};
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i)
      dims[i] = std::min(box.upper[i], model_.shape.dims[i] - 1) - box.lower[i] + 1;
    for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
      const Index<D> p = box.lower + point_of<D>(dims, i);
      if (coordinates.weights(p, weights)) body(p, weights, coordinates.weight_sum());
    }
  }

  void check_pruned(const Simplex<D>& s, const LatticeBox<D>& box, CutReport& report) const {
    bool has_inside = false;
    bool has_outside = false;
    for_each_sample(s, box, [&](const Index<D>& p, const auto&, std::int64_t) {
      const double f = model_.value_or_nan(p);
      if (std::isnan(f)) return;
      ++report.n_pruned_samples;
      (f >= query_.isovalue ? has_inside : has_outside) = true;
    });
    if (!has_inside || !has_outside) return;
    if (report.n_lost++ == 0 && report.worst.empty())
      report.worst = fmt::format("the isosurface passes the simplex at {}, which was left aside",
                                 fmt::join(s.v[0].v, ", "));
  }

  void check_active(const Simplex<D>& s, const LatticeBox<D>& box, double stored,
                    CutReport& report) const {
    std::array<double, as_size(D) + 1> vertex{};
    for (std::size_t i = 0; i <= as_size(D); ++i) vertex[i] = model_.value_or_nan(s.v[i]);
    if (std::any_of(vertex.begin(), vertex.end(), [](double f) { return std::isnan(f); })) return;
    ++report.n_active;
    report.achieved_error = std::max(report.achieved_error, stored);
    const double rounding =
        0x1p-46 * std::max(std::abs(model_.stats.min), std::abs(model_.stats.max));
    for_each_sample(s, box, [&](const Index<D>& p, const auto& weights, std::int64_t sum) {
      const double f = model_.value_or_nan(p);
      if (std::isnan(f)) return;
      double g = 0;
      for (std::size_t i = 0; i <= as_size(D); ++i)
        g += static_cast<double>(weights[i]) * vertex[i];
      const double difference = std::abs(f - g / static_cast<double>(sum));
      ++report.n_active_samples;
      report.largest_difference = std::max(report.largest_difference, difference);
      if (difference <= stored + rounding) return;
      if (report.n_too_far++ == 0 && report.worst.empty())
        report.worst = fmt::format("|F - F'| is {} at sample {}, stored error {}", difference,
                                   fmt::join(p.v, ", "), stored);
    });
  }

  void join(const CutReport& part) {
    report_.achieved_error = std::max(report_.achieved_error, part.achieved_error);
    report_.largest_difference = std::max(report_.largest_difference, part.largest_difference);
    report_.n_active += part.n_active;
    report_.n_active_samples += part.n_active_samples;
    report_.n_pruned_samples += part.n_pruned_samples;
    report_.n_too_far += part.n_too_far;
    report_.n_lost += part.n_lost;
    if (report_.worst.empty()) report_.worst = part.worst;
  }

  const Model<D>& model_;
  Refinable<D> nodes_;
  IsosurfaceQuery query_;
  std::vector<Simplex<D>> waiting_;
  CutReport report_;
};

}  // namespace

template <int D>
Result<CutReport> check_cut(const Model<D>& model, const IsosurfaceQuery& query,
                            Progress& progress) {
  if (!model.shape.has_cells()) return CutReport{};
  CutChecker<D> checker(model, query);
  checker.start();
  return checker.run_in_parallel(progress);
}

template Result<CutReport> check_cut<2>(const Model<2>&, const IsosurfaceQuery&, Progress&);
template Result<CutReport> check_cut<3>(const Model<3>&, const IsosurfaceQuery&, Progress&);

}  // namespace lode::diamond
