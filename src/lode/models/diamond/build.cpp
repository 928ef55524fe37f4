#include "lode/models/diamond/build.h"

#include <atomic>
#include <memory>

#include "lode/models/diamond/interpolant_kernel.h"
#include "lode/models/diamond/leaf_attributes.h"

namespace lode::diamond {
namespace {

/// Attributes while they are being computed: errors as float32 rounded up, ranges as computed.
template <typename C>
struct RawLevel {
  std::vector<float> error;
  std::vector<C> low;
  std::vector<C> high;
};

template <int D>
Index<D> level_dims(const Shape<D>& shape, int level) {
  if (level > 0) return shape.grid_dims(level);
  Index<D> dims;
  for (int i = 0; i < D; ++i) dims[as_size(i)] = shape.n_cubes(0, i);
  return dims;
}

/// What rounding may have hidden from a computed error: F' is a chain of at most 64 means, each
/// rounded once. Nothing where all values are integers with room for the weights.
template <int D>
double rounding_slack(const Model<D>& model) {
  const bool is_exact = !is_floating(model.info.type) && size_of(model.info.type) <= 4;
  if (is_exact || model.stats.min == model.stats.max) return 0;
  return 0x1p-47 * std::max(std::abs(model.stats.min), std::abs(model.stats.max));
}

/// Whether float32 holds every interpolant exactly: multiples of 1/root side below the largest
/// value's magnitude.
template <int D>
bool is_exact_in_float(const Model<D>& model) {
  if (is_floating(model.storage)) return false;
  const double largest = std::max(std::abs(model.stats.min), std::abs(model.stats.max));
  const int bits = static_cast<int>(std::ceil(std::log2(largest + 1))) + 1;
  return bits + model.shape.n_levels <= 24;
}

void raise_to(float& target, float value) {
  std::atomic_ref<float> atomic(target);
  float old = atomic.load(std::memory_order_relaxed);
  while (old < value && !atomic.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
  }
}

/// Finds the leaf attributes and all own errors, brick by brick. Each brick sees its samples and
/// one layer round them, and the corners of coarser cubes; the largest over bricks is the answer,
/// whatever the order.
template <int D, typename C>
class ErrorPass {
 public:
  ErrorPass(const Model<D>& model, std::vector<RawLevel<C>>& levels)
      : model_(model), levels_(levels), slack_(rounding_slack<D>(model)) {}

  void run_brick(const Index<D>& brick) {
    values_.resize(kMarginPoints);
    gather_values<D>(model_, brick, 1, values_.data());
    put_leaf_attributes(brick);
    if (model_.shape.n_levels == 1) return;
    const bool has_holes = model_.has_holes();
    for (int first = 0; first < kPlansPerBrick<D>; first += static_cast<int>(kLanes)) {
      if (!gather_lanes(brick, first)) continue;
      const Holes holes = has_holes ? Holes::present : Holes::absent;
      node_errors(holes);
      for (int level = kPlanLevel + 1; level < model_.shape.n_levels; ++level)
        for (int tier = 0; tier < D; ++tier) coarse_errors(level, tier, holes);
    }
  }

  void put_leaf_attributes(const Index<D>& brick) {
    compute_leaf_attributes<D>(model_, brick, values_.data(), leaf_);
    const Index<D> dims = level_dims<D>(model_.shape, 0);
    Index<D> edge;
    for (std::size_t i = 0; i < as_size(D); ++i) edge[i] = kLeafCubes<D>;
    for (std::size_t i = 0; i < leaf_.error.size(); ++i) {
      const Index<D> cube = brick * kLeafCubes<D> + point_of<D>(edge, i);
      bool is_inside = true;
      for (std::size_t a = 0; a < as_size(D); ++a) is_inside = is_inside && cube[a] < dims[a];
      if (!is_inside) continue;
      const std::size_t at = linear_index<D>(dims, cube);
      levels_[0].error[at] = float_up(static_cast<double>(leaf_.error[i]) + slack_);
      levels_[0].low[at] = leaf_.low[i];
      levels_[0].high[at] = leaf_.high[i];
    }
  }

  void gather_only(const Index<D>& brick) {
    values_.resize(kMarginPoints);
    gather_values<D>(model_, brick, 1, values_.data());
  }

 private:
  static constexpr int kPlanLevel = D == 3 ? 3 : 4;  // tier-0 level of a cube of side kPlanEdge
  static constexpr std::size_t kMarginPoints =
      D == 3 ? std::size_t{35} * 35 * 35 : std::size_t{131} * 131;

  struct Lane {
    bool is_used = false;
    Index<D> even_corner;  // global
    Index<D> sign;
  };

  /// Offsets into the brick's samples (with margin) of each point of each of its cubes: the same
  /// for every brick, because a brick is itself a cube of the hierarchy.
  static const std::vector<std::uint32_t>& lane_offsets() {
    static const std::vector<std::uint32_t> offsets = [] {
      std::vector<std::uint32_t> result(kPlanPoints<D> * as_size(kPlansPerBrick<D>));
      Index<D> dims;
      for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
      for (std::size_t cube = 0; cube < as_size(kPlansPerBrick<D>); ++cube)
        for (std::size_t i = 0; i < kPlanPoints<D>; ++i) {
          const Index<D> u = point_of<D>(dims, i);
          const Lane lane = lane_at({}, cube);
          std::size_t at = 0;
          for (std::size_t a = as_size(D); a-- > 0;)
            at = at * as_size(kBrickSamples<D> + 2) +
                 as_size(lane.even_corner[a] + lane.sign[a] * u[a] + 1);
          result[i * as_size(kPlansPerBrick<D>) + cube] = static_cast<std::uint32_t>(at);
        }
      return result;
    }();
    return offsets;
  }

  /// Fills the lanes with the brick's cubes first .. first + kLanes - 1; false when none of them
  /// meets the data.
  bool gather_lanes(const Index<D>& brick, int first) {
    bool is_any = false;
    for (std::size_t l = 0; l < kLanes; ++l) {
      lanes_[l] = lane_at(brick, as_size(first) + l);
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const std::int32_t lower =
            lanes_[l].even_corner[i] - (lanes_[l].sign[i] < 0 ? kPlanEdge<D> : 0);
        lanes_[l].is_used = lanes_[l].is_used && lower < model_.shape.dims[i] - 1;
      }
      is_any = is_any || lanes_[l].is_used;
    }
    if (!is_any) return false;
    vertices_.resize(kPlanPoints<D> * kLanes);
    scratch_.resize(kPlanPoints<D> * kLanes);
    const std::uint32_t* offsets = lane_offsets().data() + first;
    for (std::size_t i = 0; i < kPlanPoints<D>; ++i, offsets += kPlansPerBrick<D>)
      for (std::size_t l = 0; l < kLanes; ++l) vertices_[i * kLanes + l] = values_[offsets[l]];
    samples_ = vertices_;
    for (std::size_t i = 0; i < as_size(D); ++i)
      if ((brick[i] + 1) * kBrickEdge<D> >= model_.shape.dims[i]) {
        mask_beyond_data();
        break;
      }
    return true;
  }

  /// Points beyond the data do not count as samples.
  void mask_beyond_data() {
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    for (std::size_t i = 0; i < kPlanPoints<D>; ++i)
      for (std::size_t l = 0; l < kLanes; ++l)
        if (!model_.shape.is_sample(global(lanes_[l], point_of<D>(dims, i))))
          samples_[i * kLanes + l] = std::numeric_limits<C>::quiet_NaN();
  }

  static Lane lane_at(const Index<D>& brick, std::size_t cube) {
    Index<D> per_edge;
    for (std::size_t i = 0; i < as_size(D); ++i) per_edge[i] = kBrickEdge<D> / kPlanEdge<D>;
    const Index<D> position = point_of<D>(per_edge, cube);
    Lane lane;
    lane.is_used = true;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const bool is_mirrored = (position[i] & 1) != 0;
      lane.even_corner[i] =
          brick[i] * kBrickEdge<D> + (position[i] + (is_mirrored ? 1 : 0)) * kPlanEdge<D>;
      lane.sign[i] = is_mirrored ? -1 : 1;
    }
    return lane;
  }

  Index<D> global(const Lane& lane, const Index<D>& u) const {
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = lane.even_corner[i] + lane.sign[i] * u[i];
    return p;
  }

  void put_error(int level, const Index<D>& node, C error) {
    if (!(error > C(0)) && slack_ == 0) return;
    const Index<D> dims = model_.shape.grid_dims(level);
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      q[i] = node[i] >> level;
      if (q[i] < 0 || q[i] >= dims[i]) return;
    }
    raise_to(levels_[as_size(level)].error[linear_index<D>(dims, q)],
             float_up(static_cast<double>(error) + slack_));
  }

  void node_errors(Holes holes) {
    const CubePlan<D>& plan = CubePlan<D>::instance();
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    for (const auto& node_pass : plan.node_passes) {
      if (node_pass.level >= model_.shape.n_levels) continue;
      const auto& regions = node_pass.pass.regions;
      errors_.resize(regions.size() * kLanes);
      run_interpolant(node_pass.pass, {samples_.data(), vertices_.data(), scratch_.data()}, holes,
                      errors_.data());
      for (std::size_t r = 0; r < regions.size(); ++r) {
        const Index<D> u = point_of<D>(dims, regions[r].target);
        for (std::size_t l = 0; l < kLanes; ++l)
          if (lanes_[l].is_used)
            put_error(node_pass.level, global(lanes_[l], u), errors_[r * kLanes + l]);
      }
    }
  }

  /// The cube of side 2h of a level that contains a lane's cube, in canonical orientation.
  struct CoarseCube {
    std::int32_t side;
    Index<D> even_corner, sign;

    CoarseCube(int level, const Lane& lane) : side(std::int32_t{2} << level) {
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const std::int32_t inside = lane.even_corner[i] - (lane.sign[i] < 0 ? 1 : 0);
        const std::int32_t number = inside / side;
        sign[i] = (number & 1) != 0 ? -1 : 1;
        even_corner[i] = (number + (number & 1)) * side;
      }
    }
    Index<D> local(const Index<D>& p) const {
      Index<D> u;
      for (std::size_t i = 0; i < as_size(D); ++i) u[i] = (p[i] - even_corner[i]) * sign[i];
      return u;
    }
    Index<D> global(const Index<D>& u) const {
      Index<D> p;
      for (std::size_t i = 0; i < as_size(D); ++i) p[i] = even_corner[i] + sign[i] * u[i];
      return p;
    }
  };

  void coarse_errors(int level, int tier, Holes holes) {
    const CubePlan<D>& plan = CubePlan<D>::instance();
    const auto vertex_value = [&](const Index<D>& p) {
      const double v = model_.value(p);
      return model_.has_holes() && model_.is_hole(v) ? std::numeric_limits<double>::quiet_NaN() : v;
    };
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    corners_.resize(kPlanPoints<D> * kLanes);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const CoarseCube cube(level, lanes_[l]);
      for (const std::uint16_t corner : plan.kuhn.vertices) {
        const Index<D> p = global(lanes_[l], point_of<D>(dims, corner));
        corners_[corner * kLanes + l] =
            lanes_[l].is_used
                ? static_cast<C>(interpolant_at<D>(
                      cube.local(p), cube.side, tier,
                      [&](const Index<D>& u) { return vertex_value(cube.global(u)); }))
                : C(0);
      }
    }
    errors_.resize(plan.kuhn.regions.size() * kLanes);
    run_interpolant(plan.kuhn, {samples_.data(), corners_.data(), scratch_.data()}, holes,
                    errors_.data());
    for (std::size_t r = 0; r < plan.kuhn.regions.size(); ++r)
      for (std::size_t l = 0; l < kLanes; ++l)
        if (lanes_[l].is_used) put_coarse_error(level, tier, l, r, errors_[r * kLanes + l]);
  }

  /// A Kuhn simplex lies in one coarser diamond of each tier: the one round its centroid.
  void put_coarse_error(int level, int tier, std::size_t l, std::size_t simplex, C error) {
    const CoarseCube cube(level, lanes_[l]);
    Index<D> sum;  // (D+1) · centroid
    for (const Index<D>& v : CubePlan<D>::instance().kuhn_simplices[simplex].v)
      sum = sum + cube.local(global(lanes_[l], v));
    for (Index<D> node : nodes_containing<D>(sum, cube.side * (D + 1), tier)) {
      for (std::size_t i = 0; i < as_size(D); ++i) node[i] /= D + 1;
      put_error(level, cube.global(node), error);
    }
  }

  const Model<D>& model_;
  std::vector<RawLevel<C>>& levels_;
  double slack_;
  std::array<Lane, kLanes> lanes_;
  std::vector<C> values_;
  LeafAttributes<C> leaf_;
  AlignedVector<C> samples_, vertices_, scratch_, corners_, errors_;
};

/// Joins every node's attributes with its children's, which are already joined.
template <int D, typename C>
class NestingPass {
 public:
  NestingPass(const Model<D>& model, std::vector<RawLevel<C>>& levels, Threads threads)
      : model_(model), levels_(levels), threads_(threads) {}

  void run() {
    for (int level = 1; level < model_.shape.n_levels; ++level)
      for (int tier = D - 1; tier >= 0; --tier) run_tier(level, tier);
  }

 private:
  void run_tier(int level, int tier) {
    const Index<D> dims = model_.shape.grid_dims(level);
    const std::size_t n_rows = n_points<D>(dims) / as_size(dims[0]);
    parallel_for(n_rows, threads_, 16, [&](std::size_t row, int) {
      const std::size_t first = row * as_size(dims[0]);
      Index<D> q = point_of<D>(dims, first);
      for (; q[0] < dims[0]; ++q[0]) {
        int n_odd = 0;
        for (std::size_t i = 0; i < as_size(D); ++i) n_odd += q[i] & 1;
        if (n_odd == D - tier) join_children(level, dims, q);
      }
    });
  }

  void join_children(int level, const Index<D>& dims, const Index<D>& q) {
    RawLevel<C>& own = levels_[as_size(level)];
    const std::size_t at = linear_index<D>(dims, q);
    const std::int32_t h = std::int32_t{1} << level;
    const Diamond<D> d = diamond_at<D>(q * h);
    float error = own.error[at];
    C low = std::numeric_limits<C>::infinity();
    C high = -low;
    const auto join = [&](const RawLevel<C>& from, std::size_t i) {
      error = std::max(error, from.error[i]);
      low = std::min(low, from.low[i]);
      high = std::max(high, from.high[i]);
    };
    if (d.tier < D - 1)
      for (std::size_t i = 0; i < as_size(D); ++i) {
        if (!d.is_odd(static_cast<int>(i))) continue;
        Index<D> child = q;
        child[i] = q[i] - 1;
        join(own, linear_index<D>(dims, child));
        child[i] = q[i] + 1;
        join(own, linear_index<D>(dims, child));
      }
    else
      join_cubes(level, q, join);
    if (reaches_beyond_data(d)) {
      for (const Index<D>& v : domain_vertices<D>(d)) join_value(v, low, high);
      join_value(d.centre, low, high);
    }
    own.error[at] = error;
    own.low[at] = low;
    own.high[at] = high;
  }

  template <typename Join>
  void join_cubes(int level, const Index<D>& q, const Join& join) {
    const Index<D> child_dims = level_dims<D>(model_.shape, level - 1);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> child;
      bool exists = true;
      for (int i = 0; i < D; ++i) {
        const auto a = as_size(i);
        child[a] = 2 * q[a] + (((corner >> i) & 1) != 0 ? 1 : -1);
        if (level == 1) child[a] = child[a] >> 1;
        exists = exists && child[a] >= 0 && child[a] < child_dims[a];
      }
      if (exists) join(levels_[as_size(level - 1)], linear_index<D>(child_dims, child));
    }
  }

  bool reaches_beyond_data(const Diamond<D>& d) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (d.centre[i] + d.h() > model_.shape.dims[i] - 1) return true;
    return false;
  }

  void join_value(const Index<D>& p, C& low, C& high) const {
    const double v = model_.value(p);
    if (model_.has_holes() && model_.is_hole(v)) return;
    low = std::min(low, static_cast<C>(v));
    high = std::max(high, static_cast<C>(v));
  }

  const Model<D>& model_;
  std::vector<RawLevel<C>>& levels_;
  Threads threads_;
};

template <typename C>
void allocate(RawLevel<C>& level, std::size_t n) {
  level.error.assign(n, 0.0F);
  level.low.assign(n, std::numeric_limits<C>::infinity());
  level.high.assign(n, -std::numeric_limits<C>::infinity());
}

/// value - reference rounded to float32, downward (direction < 0) or upward.
float outward(double value, double reference, double direction) {
  double difference = value - reference;
  if (reference != 0)
    difference = std::nextafter(difference, direction * std::numeric_limits<double>::infinity());
  const float f = static_cast<float>(difference);
  const bool is_outward =
      direction < 0 ? static_cast<double>(f) <= difference : static_cast<double>(f) >= difference;
  if (is_outward) return f;
  return std::nextafter(f, static_cast<float>(direction) * std::numeric_limits<float>::infinity());
}

template <int D, typename C>
NodeLevel encode(const Model<D>& model, const RawLevel<C>& raw, Threads threads) {
  NodeLevel level;
  const std::size_t n = raw.error.size();
  level.error.resize(n);
  level.low.resize(n);
  level.high.resize(n);
  const double reference = model.range_reference();
  constexpr std::size_t kChunk = 1 << 14;
  parallel_for((n + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
      level.error[i] = encode_error(raw.error[i]);
      level.low[i] = outward(static_cast<double>(raw.low[i]), reference, -1);
      level.high[i] = outward(static_cast<double>(raw.high[i]), reference, 1);
    }
  });
  return level;
}

template <int D, typename C>
Result<void> build_attributes(Model<D>& model, Threads threads, Progress& progress) {
  std::vector<RawLevel<C>> raw(as_size(model.shape.n_levels));
  for (int level = 0; level < model.shape.n_levels; ++level)
    allocate(raw[as_size(level)], n_points<D>(level_dims<D>(model.shape, level)));
  std::vector<std::unique_ptr<ErrorPass<D, C>>> passes(as_size(n_workers(threads)));
  std::atomic<std::size_t> n_done{0};
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C>>(model, raw);
    pass->run_brick(point_of<D>(model.brick_dims, i));
    progress.report("errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  NestingPass<D, C>(model, raw, threads).run();
  model.levels.clear();
  for (RawLevel<C>& level : raw) {
    model.levels.push_back(encode<D>(model, level, threads));
    level = {};
  }
  return {};
}

template <int D, typename C>
void compute_level_0_as(Model<D>& model, Threads threads) {
  std::vector<RawLevel<C>> raw(1);
  allocate(raw[0], n_points<D>(level_dims<D>(model.shape, 0)));
  std::vector<std::unique_ptr<ErrorPass<D, C>>> passes(as_size(n_workers(threads)));
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C>>(model, raw);
    const Index<D> brick = point_of<D>(model.brick_dims, i);
    pass->gather_only(brick);
    pass->put_leaf_attributes(brick);
  });
  model.levels[0] = encode<D>(model, raw[0], threads);
}

template <int D>
Result<void> read_samples(Model<D>& model, VolumeSource& source, const BuildSettings& settings,
                          Progress& progress) {
  const Index3 dims = model.info.grid.dims;
  const std::int64_t slice_samples = std::int64_t{dims[0]} * dims[1];
  const std::size_t size = size_of(model.info.type);
  constexpr std::int64_t kBytesPerRead = std::int64_t{16} << 20;
  std::int32_t slices = settings.slices_per_read;
  if (slices <= 0)
    slices = static_cast<std::int32_t>(std::clamp<std::int64_t>(
        kBytesPerRead / (slice_samples * static_cast<std::int64_t>(size)), 1, dims[2]));
  const auto n = static_cast<std::size_t>(slice_samples * std::min(slices, dims[2]));
  std::vector<std::byte> bytes(n * size);
  std::vector<std::byte> widened(model.storage == model.info.type ? 0 : n * model.sample_size());
  for (std::int32_t z = 0; z < dims[2]; z += slices) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("reading", static_cast<double>(z) / dims[2]);
    const IndexBox box{{{0, 0, z}}, {{dims[0], dims[1], std::min(z + slices, dims[2])}}};
    const auto n_read = static_cast<std::size_t>(box.n_samples());
    LODE_CHECK(source.read(box, std::span(bytes).first(n_read * size)));
    if (!widened.empty()) widen_samples(model.info.type, bytes.data(), n_read, widened.data());
    Index<D> lower;
    Index<D> upper;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      lower[i] = box.lower[as_size(model.axes.axis[i])];
      upper[i] = box.upper[as_size(model.axes.axis[i])];
    }
    put_samples<D>(model, lower, upper, widened.empty() ? bytes.data() : widened.data());
  }
  finish_samples<D>(model, settings.threads);
  return {};
}

}  // namespace

template <int D>
Result<Model<D>> build(VolumeSource& source, const BuildSettings& settings, Progress& progress) {
  const VolumeInfo& info = source.info();
  for (std::size_t i = 0; i < 3; ++i)
    if (info.grid.dims[i] < 1 || info.grid.dims[i] > kMaxSamplesPerAxis)
      return fail("expected 1 to {} samples along each axis, got {} along axis {}",
                  kMaxSamplesPerAxis, info.grid.dims[i], i);
  Model<D> model = Model<D>::make(info);
  LODE_CHECK(read_samples<D>(model, source, settings, progress));
  if (is_exact_in_float<D>(model))
    LODE_CHECK((build_attributes<D, float>(model, settings.threads, progress)));
  else
    LODE_CHECK((build_attributes<D, double>(model, settings.threads, progress)));
  return model;
}

template <int D>
void compute_level_0(Model<D>& model, Threads threads) {
  if (is_exact_in_float<D>(model))
    compute_level_0_as<D, float>(model, threads);
  else
    compute_level_0_as<D, double>(model, threads);
}

template Result<Model<2>> build<2>(VolumeSource&, const BuildSettings&, Progress&);
template Result<Model<3>> build<3>(VolumeSource&, const BuildSettings&, Progress&);
template void compute_level_0<2>(Model<2>&, Threads);
template void compute_level_0<3>(Model<3>&, Threads);

}  // namespace lode::diamond
