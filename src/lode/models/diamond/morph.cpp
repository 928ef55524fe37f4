#include "lode/models/diamond/morph.h"

#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

Vec3f to_place(const Vec3d& p) {
  return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
}

/// The largest power of two that divides all differences of corners: its shortest edge's extent.
template <int D>
std::int32_t step_of(const Simplex<D>& s) {
  Index<D> differences;
  for (const Index<D>& v : s.v)
    for (std::size_t i = 0; i < as_size(D); ++i) differences[i] |= v[i] - s.v[0][i];
  return std::int32_t{1} << common_exponent<D>(differences);
}

/// The gradient on the coarser mesh: that of the samples, as far apart as its simplices are long,
/// but at new centres the mean of the ends.
template <int D, typename T>
class CoarserGradient {
 public:
  CoarserGradient(const Model<D>& model, const NormalSampler<D, T>& sampler, const FlatIndex& added)
      : model_(model), sampler_(sampler), added_(added) {}

  [[nodiscard]] Vec3d at(const Index<D>& p, std::int32_t step) {
    const bool is_corner = common_exponent<D>(p) >= model_.shape.n_levels;
    const auto id = is_corner ? 0 : static_cast<std::uint64_t>(id_of<D>(p));
    if (is_corner || added_.find(id) == FlatIndex::kNone)
      return sampler_.gradient(model_.axes.to_grid(p), step);
    if (const std::uint32_t known = known_at_.find(id); known != FlatIndex::kNone)
      return known_[known];
    const auto ends = axis_ends<D>(diamond_at<D>(p));
    const Vec3d mean = (at(ends[0], step) + at(ends[1], step)) * 0.5;
    known_at_.insert(id, static_cast<std::uint32_t>(known_.size()));
    known_.push_back(mean);
    return mean;
  }

 private:
  const Model<D>& model_;
  const NormalSampler<D, T>& sampler_;
  const FlatIndex& added_;
  FlatIndex known_at_;
  std::vector<Vec3d> known_;
};

}  // namespace

/// Goes down the finer cut with the values of both meshes.
template <int D>
class MorphStep<D>::Finder {
 public:
  Finder(const Refinable<D>& nodes, const Cut& cut, const FlatIndex& added, MorphStep& out)
      : nodes_(nodes), model_(nodes.model()), cut_(cut), added_(added), out_(out) {}

  Result<void> run(Progress& progress) {
    if (!model_.shape.has_cells()) return {};
    begin();
    for (std::size_t n = 0; !open_.empty(); ++n) {
      if (n % 4096 == 0 && progress.is_cancelled()) return cancelled_error();
      if (out_.points_.size() > kMostPoints)
        return fail("the surface is too large to be morphed: give it a larger tolerance");
      const Piece piece = open_.back();
      open_.pop_back();
      if (model_.shape.overlaps_data(bounds_of(piece.simplex))) visit(piece);
    }
    return {};
  }

 private:
  /// Crossed edges are less than 8 a point.
  static constexpr std::size_t kMostPoints = std::size_t{1} << 28;

  struct Piece {
    Simplex<D> simplex;
    std::array<double, as_size(D) + 1> before;
    std::array<double, as_size(D) + 1> after;
    std::int32_t coarse_step = 0;  ///< Of the simplex of the coarser mesh,
    bool is_new = false;           ///< that it is a part of.
  };

  void begin() {
    for (const Simplex<D>& s : kuhn_simplices<D>({}, model_.shape.root_side())) {
      Piece& piece = open_.emplace_back(Piece{s, {}, {}, step_of<D>(s), false});
      for (std::size_t i = 0; i <= as_size(D); ++i)
        piece.before[i] = piece.after[i] = model_.value_or_nan(s.v[i]);
    }
  }

  void visit(const Piece& piece) {
    const Simplex<D>& s = piece.simplex;
    const Index<D> centre = s.bisection_point();
    if (is_finest(s) || !cut_.contains(id_of<D>(centre))) return add_leaf(piece);
    const auto id = static_cast<std::uint64_t>(id_of<D>(centre));
    const bool is_new = piece.is_new || added_.find(id) != FlatIndex::kNone;
    const std::size_t tag = as_size(s.tag);
    const double after = model_.value_or_nan(centre);
    const double before = is_new ? (piece.before[0] + piece.before[tag]) / 2 : after;
    const std::array<Simplex<D>, 2> halves = bisect(s);
    for (std::size_t h = 0; h < 2; ++h) {
      const std::int32_t coarse_step =
          piece.is_new ? piece.coarse_step : step_of<D>(is_new ? s : halves[h]);
      Piece half{halves[h], piece.before, piece.after, coarse_step, is_new};
      for (std::size_t i = 0; h == 1 && i < tag; ++i) {
        half.before[i] = piece.before[i + 1];
        half.after[i] = piece.after[i + 1];
      }
      half.before[tag] = before;
      half.after[tag] = after;
      open_.push_back(half);
    }
  }

  /// Whether the surface is ever in it: not if all its values stay on one side.
  [[nodiscard]] bool is_met(const Piece& leaf) const {
    bool has_inside = false;
    bool has_outside = false;
    for (const auto* values : {&leaf.before, &leaf.after})
      for (const double value : *values) {
        if (std::isnan(value)) return false;
        (value >= out_.query_.isovalue ? has_inside : has_outside) = true;
      }
    return has_inside && has_outside;
  }

  /// As LiveIsosurface's: what is part hole and part not has no surface until it is refined.
  [[nodiscard]] bool is_removed(const Simplex<D>& s) const {
    if (!model_.has_holes()) return false;
    if (is_finest(s)) return model_.is_removed(s);
    return !std::isfinite(nodes_.facts(id_of<D>(s.bisection_point())).error);
  }

  void add_leaf(const Piece& leaf) {
    if (!is_met(leaf) || is_removed(leaf.simplex)) return;
    const std::int32_t step = step_of<D>(leaf.simplex);
    Corners corners{};
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      const LatticeKey key = to_key(model_.axes.to_grid(leaf.simplex.v[i]));
      corners[i] = out_.number_of(key);
      if (corners[i] == FlatIndex::kNone) {
        corners[i] = static_cast<std::uint32_t>(out_.points_.size());
        out_.points_.push_back({key, leaf.before[i], leaf.after[i]});
        out_.number_at_.insert(key, corners[i]);
      }
      Point& point = out_.points_[corners[i]];
      point.step_before = std::min(point.step_before, leaf.coarse_step);
      point.step_after = std::min(point.step_after, step);
    }
    out_.leaves_.push_back(corners);
  }

  const Refinable<D>& nodes_;
  const Model<D>& model_;
  const Cut& cut_;
  const FlatIndex& added_;
  MorphStep& out_;
  std::vector<Piece> open_;
};

template <int D>
MorphStep<D>::MorphStep(const Refinable<D>& nodes, const MorphQuery& query)
    : model_(&nodes.model()), query_(query), frame_(LatticeFrame::of(nodes.model().info.grid)) {}

template <int D>
Result<MorphStep<D>> MorphStep<D>::find(const Refinable<D>& nodes, const Cut& cut,
                                        const FlatIndex& added, const MorphQuery& query,
                                        Progress& progress) {
  MorphStep step(nodes, query);
  LODE_CHECK(Finder(nodes, cut, added, step).run(progress));
  if (query.with_normals) step.find_slopes(added);
  return step;
}

template <int D>
void MorphStep<D>::find_slopes(const FlatIndex& added) {
  slopes_.reserve(points_.size());
  visit_storage_type(model_->storage, [&]<typename T>() {
    const NormalSampler<D, T> sampler(*model_);
    CoarserGradient<D, T> coarser(*model_, sampler, added);
    for (const Point& point : points_) {
      const Index3 grid_point = to_point(point.key);
      Index<D> p;
      for (std::size_t i = 0; i < as_size(D); ++i) p[i] = grid_point[as_size(model_->axes.axis[i])];
      slopes_.push_back({to_place(coarser.at(p, point.step_before)),
                         to_place(sampler.gradient(grid_point, point.step_after))});
    }
  });
}

template <int D>
void MorphStep<D>::add_vertices(const IsoPart<D>& part, Surface& surface) const {
  surface.origin = frame_.surface_origin;
  surface.positions.reserve(part.points.size());
  for (const EdgePoint& point : part.points)
    surface.positions.push_back(to_place(frame_.position(point.lattice_position())));
}

template <int D>
void MorphStep<D>::add_origins(const IsoPart<D>& part, Surface& surface) const {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  surface.origins.reserve(part.points.size());
  const auto keeps_side = [&](const Point& p) {
    return (p.before >= query_.isovalue) == (p.after >= query_.isovalue);
  };
  IsoPart<D> one;
  for (const EdgePoint& point : part.points) {
    const Point& a = points_[number_of(point.first)];
    const Point& b = points_[number_of(point.second)];
    if (!keeps_side(a) || !keeps_side(b)) {
      surface.origins.push_back({{kNone, kNone, kNone}});
      continue;
    }
    one.points.clear();
    one.add_point(a.key, a.before, b.key, b.before, query_.isovalue, frame_.margin);
    surface.origins.push_back(to_place(frame_.position(one.points.front().lattice_position())));
  }
}

template <int D>
void MorphStep<D>::add_normals(const IsoPart<D>& part, double moment, Surface& surface) const {
  surface.normals.reserve(part.points.size());
  const auto moved = [&](LatticeKey key) {
    const Slopes& slopes = slopes_[number_of(key)];
    Vec3d result;
    for (std::size_t i = 0; i < 3; ++i)
      result[i] = (1 - moment) * static_cast<double>(slopes.before[i]) +
                  moment * static_cast<double>(slopes.after[i]);
    return result;
  };
  visit_storage_type(model_->storage, [&]<typename T>() {
    const NormalSampler<D, T> sampler(*model_);
    for (const EdgePoint& point : part.points)
      surface.normals.push_back(moment >= 1 ? sampler.at(point)
                                            : sampler.to_normal(moved(point.first) * (1 - point.t) +
                                                                moved(point.second) * point.t));
  });
}

template <int D>
Surface MorphStep<D>::surface(double moment) const {
  IsoPart<D> part;
  SimplexIsosurface<D> mapper(frame_, query_.isovalue, part);
  for (const Corners& leaf : leaves_) {
    LatticeSimplex<D> simplex;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      simplex.vertex[i] = points_[leaf[i]].key;
      simplex.value[i] = points_[leaf[i]].at(moment);
    }
    mapper.add(simplex);
  }
  Surface surface;
  add_vertices(part, surface);
  if (moment >= 1) add_origins(part, surface);
  if (query_.with_normals) add_normals(part, moment, surface);
  if constexpr (D == 3)
    surface.triangles = std::move(part.cells);
  else
    surface.lines = std::move(part.cells);
  return surface;
}

template class MorphStep<2>;
template class MorphStep<3>;

}  // namespace lode::diamond
