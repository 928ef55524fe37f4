#include "lode/models/diamond/attribute_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>

#include "lode/models/diamond/true_attributes.h"

namespace lode::diamond {
namespace {

/// Counts one property over nodes, in parallel.
template <int D>
class Finder {
 public:
  void check(const Diamond<D>& d, double excess, const char* what, double stored, double found) {
    ++n_checked_;
    if (!(excess > 0)) return;
    ++n_wrong_;
    if (excess <= worst_excess_) return;
    worst_excess_ = excess;
    worst_ = fmt::format("{} of the node at {} (level {}): stored {}, found {}", what,
                         fmt::join(d.centre.v, ", "), d.level, stored, found);
  }
  [[nodiscard]] AttributeFinding finding() const { return {n_checked_, n_wrong_, worst_}; }

 private:
  std::uint64_t n_checked_ = 0;
  std::uint64_t n_wrong_ = 0;
  double worst_excess_ = 0;
  std::string worst_;
};

template <int D>
class AttributeChecker {
 public:
  AttributeChecker(const Model<D>& model, std::vector<TrueLevel>& levels)
      : model_(model), levels_(levels), scale_(model), rule_(scale_) {}

  /// Children before parents, so that `levels` turns from own into nested values on the way.
  AttributeReport run() {
    for (int level = 0; level < model_.shape.n_levels; ++level)
      for (int tier = level == 0 ? 0 : D - 1; tier >= 0; --tier) run_tier(level, tier);
    return {errors_.finding(), ranges_.finding(), nesting_.finding(), tightness_.finding(),
            worlds_.finding()};
  }

 private:
  void run_tier(int level, int tier) {
    const Shape<D>& shape = model_.shape;
    const NodeLevel& stored = model_.levels[as_size(level)];
    Index<D> dims = shape.grid_dims(level);
    if (level == 0)
      for (int i = 0; i < D; ++i) dims[as_size(i)] = shape.n_cubes(0, i);
    for (std::size_t at = 0; at < stored.error.size(); ++at) {
      const Index<D> q = point_of<D>(dims, at);
      Index<D> centre;
      int n_odd = 0;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        centre[i] = level == 0 ? 2 * q[i] + 1 : q[i] << level;
        n_odd += level == 0 ? 1 : q[i] & 1;
      }
      if (n_odd != D - tier) continue;
      const Diamond<D> d = diamond_at<D>(centre);
      if (meets_data<D>(shape, d)) check_node(d, at);
    }
  }

  void check_node(const Diamond<D>& d, std::size_t at) {
    const NodeLevel& stored = model_.levels[as_size(d.level)];
    TrueLevel& own = levels_[as_size(d.level)];
    const double reference = model_.range_reference();
    const double error = static_cast<double>(decode_error(stored.error[at]));
    const double low = static_cast<double>(stored.low[at]) + reference;
    const double high = static_cast<double>(stored.high[at]) + reference;
    // Adding the reference back rounds once.
    const double rounding = 0x1p-50 * std::max(std::abs(low), std::abs(high));
    errors_.check(d, own.error[at] - error, "error", error, own.error[at]);
    if (own.low[at] <= own.high[at]) {
      if (!(low <= high)) ranges_.check(d, 1, "empty range", low, own.low[at]);
      ranges_.check(d, low - own.low[at] - rounding, "low end", low, own.low[at]);
      ranges_.check(d, own.high[at] - high - rounding, "high end", high, own.high[at]);
    }
    if (d.level > 0 && !model_.worlds.empty()) check_world(d, at, own);
    join_children(d, at, error, low, high);
    check_tightness(d, at, error, low, high);
  }

  /// Errors are own ones still. Where holes are, more of them are infinite than simplices show.
  void check_world(const Diamond<D>& d, std::size_t at, TrueLevel& own) {
    const double slack = rounding_slack<D>(model_);
    const Index<D> grid = model_.shape.grid_dims(d.level);
    const auto value = [&](const Index<D>& p) {
      for (std::size_t i = 0; i < as_size(D); ++i)
        if (p[i] < 0 || p[i] >> d.level >= grid[i]) return std::numeric_limits<double>::quiet_NaN();
      return model_.value_or_nan(p);
    };
    double least = 0;
    double& most = own.world[at];
    // The build's own rounding is up to slack, it adds as much, and takes that for rounding.
    const double inside = own.error_inside[at];
    if (inside > 2 * slack * (1 + 1.0 / 16)) least = rule_(d, inside, value);
    const double error = own.error[at];
    // Beyond float32's normal numbers slack alone is more in a code than what counts as rounding.
    const bool has_error =
        error > 0 || encode_error(float_up(2 * slack)) > tolerance_code(2 * slack * (1 + 1.0 / 64));
    most = rule_(d, has_error ? stored_at_most(error + 2 * slack) : 0, value);
    for (const Index<D>& centre : children<D>(d)) {
      const Diamond<D> child = diamond_at<D>(centre);
      const std::ptrdiff_t place = place_of<D>(model_.shape, child);
      if (place < 0) continue;
      const double below = levels_[as_size(child.level)].world[static_cast<std::size_t>(place)];
      most = std::max(most, std::ldexp(below, child.level - d.level));
    }
    const auto stored = static_cast<double>(decode_world(model_.worlds[as_size(d.level)][at]));
    worlds_.check(d, least * kAlmost - stored, "world error", stored, least);
    const double allowed = std::max(most * (1 + 1.0 / 16) / kAlmost, 0x1.2p-16);
    if (!model_.has_holes())
      worlds_.check(d, stored > 0 ? stored - allowed : 0, "world error above", stored, most);
  }

  void join_children(const Diamond<D>& d, std::size_t at, double error, double low, double high) {
    TrueLevel& own = levels_[as_size(d.level)];
    if (d.level == 0) {
      join_finest(d, at);
      return;
    }
    for (const Index<D>& centre : children<D>(d)) {
      const Diamond<D> child = diamond_at<D>(centre);
      const std::ptrdiff_t place = place_of<D>(model_.shape, child);
      if (place < 0) continue;
      const auto j = static_cast<std::size_t>(place);
      const TrueLevel& below = levels_[as_size(child.level)];
      own.join(at, below.error[j], below.low[j], below.high[j]);
      const NodeLevel& stored = model_.levels[as_size(child.level)];
      const double reference = model_.range_reference();
      const double e = static_cast<double>(decode_error(stored.error[j]));
      nesting_.check(d, e - error, "error against a child", error, e);
      if (stored.low[j] > stored.high[j]) continue;
      const double l = static_cast<double>(stored.low[j]) + reference;
      const double h = static_cast<double>(stored.high[j]) + reference;
      nesting_.check(d, low - l, "low end against a child", low, l);
      nesting_.check(d, h - high, "high end against a child", high, h);
    }
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (d.centre[i] + d.h() > model_.shape.dims[i] - 1) {
        join_vertices(d, own, at);
        break;
      }
  }

  /// The finest nodes below a cube of side 2 are stored with it: those on its edges reach beyond.
  void join_finest(const Diamond<D>& cube, std::size_t at) {
    const Index<D> box = all_equal<D>(3);
    for (std::size_t i = 0; i < n_points<D>(box); ++i) {
      Index<D> p = cube.centre + point_of<D>(box, i);
      int n_odd = 0;
      for (std::size_t a = 0; a < as_size(D); ++a) {
        --p[a];
        n_odd += p[a] & 1;
      }
      if (n_odd == 1) join_vertices(diamond_at<D>(p), levels_[0], at);
    }
  }

  void join_vertices(const Diamond<D>& d, TrueLevel& own, std::size_t at) const {
    join_value(d.centre, own, at);
    for (const Index<D>& v : domain_vertices<D>(d)) join_value(v, own, at);
  }

  void join_value(const Index<D>& p, TrueLevel& own, std::size_t at) const {
    const double f = model_.value_or_nan(p);
    if (!std::isnan(f)) own.join(at, 0, f, f);
  }

  void check_tightness(const Diamond<D>& d, std::size_t at, double error, double low, double high) {
    const TrueLevel& nested = levels_[as_size(d.level)];
    const double magnitude = std::max(std::abs(model_.stats.min), std::abs(model_.stats.max));
    const double slack = 0x1p-46 * magnitude;
    // Ranges: 1/64 of their width, and one unit of float32 relative to the reference; below its
    // normal numbers steps are absolute: 2^-149.
    const double allowed = stored_at_most(nested.error[at] + slack);
    if (std::isfinite(error) || !model_.has_holes())
      tightness_.check(d, error - allowed, "error above the smallest nested", error,
                       nested.error[at]);
    if (nested.low[at] > nested.high[at]) return;
    const double span = std::max(std::abs(nested.low[at] - model_.range_reference()),
                                 std::abs(nested.high[at] - model_.range_reference()));
    if (span > 0.999 * static_cast<double>(std::numeric_limits<float>::max())) return;  // infinite
    const double width = nested.high[at] - nested.low[at];
    const double rounded = has_exact_ranges(model_.storage) ? 0 : width / 64;
    const double unit = rounded + 0x1p-22 * span + slack + 0x1p-148;
    tightness_.check(d, nested.low[at] - unit - low, "low end below the nested", low,
                     nested.low[at]);
    tightness_.check(d, high - nested.high[at] - unit, "high end above the nested", high,
                     nested.high[at]);
  }

  /// What an error is rounded up to, an upper half of float32: 1/128 more, or 2^-133 below its
  /// normal numbers; infinite above them.
  [[nodiscard]] static double stored_at_most(double error) {
    const double rounded = error * (1 + 0x1p-7) * (1 + 0x1p-22) + 0x1p-133;
    const auto most = static_cast<double>(decode_error(kInfiniteError - 1));
    return rounded <= most ? rounded : std::numeric_limits<double>::infinity();
  }

  static constexpr double kAlmost = 1 - 0x1p-16;  ///< Shares are found in float32.

  const Model<D>& model_;
  std::vector<TrueLevel>& levels_;
  WorldScale<D, double> scale_;
  WorldErrorRule<D, double> rule_;
  Finder<D> errors_, ranges_, nesting_, tightness_, worlds_;
};

}  // namespace

template <int D>
Result<AttributeReport> check_attributes(const Model<D>& model, Threads threads,
                                         Progress& progress) {
  if (!model.shape.has_cells()) return AttributeReport{};
  std::vector<TrueLevel> levels;
  for (const NodeLevel& level : model.levels) levels.emplace_back(level.error.size());
  const OwnAttributes<D> own(model, levels);
  std::atomic<std::size_t> n_done{0};
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    own.add_brick(point_of<D>(model.brick_dims, i));
    if (!model.worlds.empty()) own.add_finest_worlds(point_of<D>(model.brick_dims, i));
    progress.report("checking errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  return AttributeChecker<D>(model, levels).run();
}

template Result<AttributeReport> check_attributes<2>(const Model<2>&, Threads, Progress&);
template Result<AttributeReport> check_attributes<3>(const Model<3>&, Threads, Progress&);

}  // namespace lode::diamond
