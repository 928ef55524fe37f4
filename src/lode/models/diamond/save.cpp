#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/persist.h"
#include "lode/store/codec.h"
#include "lode/store/writer.h"

namespace lode::diamond {
namespace {

template <typename R>
R to_range(float v) {
  if constexpr (std::is_integral_v<R>) {
    if (std::isinf(v))
      return v > 0 ? std::numeric_limits<R>::max() : std::numeric_limits<R>::lowest();
  }
  return static_cast<R>(v);
}

struct PendingBlock {
  store::BlockKey key;
  store::EncodedBlock block;
};

/// Appends n samples, the first at lattice point p and `step` apart along x; where they lie beyond
/// the data, the nearest ones.
template <typename T, int D>
T* copy_samples(const Model<D>& model, const Index<D>& p, std::int32_t n, std::int32_t step,
                T* to) {
  Index<D> local = model.clamped(p);
  Index<D> brick;
  for (std::size_t a = 0; a < as_size(D); ++a) {
    brick[a] = std::min(local[a] / kBrickEdge<D>, model.brick_dims[a] - 1);
    local[a] -= brick[a] * kBrickEdge<D>;
  }
  local[0] = 0;
  const T* from = nullptr;
  std::int32_t begin = 0;  // the brick's first x
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t x = std::min(p[0] + i * step, model.shape.dims[0] - 1);
    if (from == nullptr || x > begin + kBrickEdge<D>) {
      brick[0] = std::min(x / kBrickEdge<D>, model.brick_dims[0] - 1);
      begin = brick[0] * kBrickEdge<D>;
      from = reinterpret_cast<const T*>(model.brick(linear_index<D>(model.brick_dims, brick))) +
             model.brick_offset(local);
    }
    *to++ = from[x - begin];
  }
  return to;
}

template <int D>
void encode_samples(const Model<D>& model, const Region<D>& r, std::vector<PendingBlock>& out) {
  visit_storage_type(model.storage, [&]<typename T>() {
    std::vector<T> values(count_points(r));
    if (values.empty()) return;
    T* to = values.data();
    for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
      for (std::int32_t& x : q.v) x <<= r.level;
      to = copy_samples<T, D>(model, q, n, stride << r.level, to);
    });
    out.push_back({key_of(Kind::samples, r),
                   store::encode_block(std::as_bytes(std::span<const T>(values)), sizeof(T))});
  });
}

/// One attribute of the region's nodes, each as encode(its place in the level's arrays) gives it.
template <typename T, int D, typename Encode>
void encode_attribute(const Model<D>& model, Kind kind, const Region<D>& r, const Encode& encode,
                      std::vector<PendingBlock>& out) {
  const Index<D> dims = model.shape.grid_dims(r.level);
  std::vector<T> values(count_points(r));
  T* to = values.data();
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    const std::size_t first = linear_index<D>(dims, q);
    for (std::size_t i = 0; i < as_size(n); ++i) *to++ = encode(first + i * as_size(stride));
  });
  out.push_back(
      {key_of(kind, r), store::encode_block(std::as_bytes(std::span<const T>(values)), sizeof(T))});
}

template <int D>
void encode_attributes(const Model<D>& model, const Region<D>& r, std::vector<PendingBlock>& out) {
  if (count_points(r) == 0) return;
  const NodeLevel& nodes = model.levels[as_size(r.level)];
  encode_attribute<ErrorCode>(
      model, Kind::errors, r, [&](std::size_t at) { return nodes.error[at]; }, out);
  visit_range_type(model.storage, [&]<typename R>() {
    const auto is_empty = [&](std::size_t at) { return nodes.low[at] > nodes.high[at]; };
    const auto low = [&](std::size_t at) {
      return is_empty(at) ? std::numeric_limits<R>::max() : to_range<R>(nodes.low[at]);
    };
    const auto high = [&](std::size_t at) {
      return is_empty(at) ? std::numeric_limits<R>::lowest() : to_range<R>(nodes.high[at]);
    };
    encode_attribute<R>(model, Kind::lows, r, low, out);
    encode_attribute<R>(model, Kind::highs, r, high, out);
  });
}

}  // namespace

template <int D>
std::string model_name() {
  return D == 3 ? "diamond3d" : "diamond2d";
}

template <int D>
Result<void> save(const Model<D>& model, const std::string& path, Threads threads,
                  Progress& progress) {
  const Metadata metadata{.info = model.info, .summary = summarize<D>(model)};
  LODE_TRY(auto writer, store::Writer::create(path, model_name<D>(), encode_metadata(metadata)));
  std::vector<Region<D>> sample_regions = all_regions<D>(model.shape, Kind::samples);
  std::vector<Region<D>> node_regions = all_regions<D>(model.shape, Kind::errors);
  for (int level = model.shape.n_levels - 1; level >= 0; --level) {
    const auto of_level = [&](const std::vector<Region<D>>& from) {
      std::vector<Region<D>> result;
      for (const Region<D>& r : from)
        if (r.level == level) result.push_back(r);
      return result;
    };
    const std::vector<Region<D>> samples = of_level(sample_regions);
    const std::vector<Region<D>> nodes = of_level(node_regions);
    std::vector<std::vector<PendingBlock>> pending(samples.size() + nodes.size());
    parallel_for(pending.size(), threads, 1, [&](std::size_t i, int) {
      if (progress.is_cancelled()) return;
      if (i < samples.size())
        encode_samples<D>(model, samples[i], pending[i]);
      else
        encode_attributes<D>(model, nodes[i - samples.size()], pending[i]);
    });
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("writing", 1.0 - static_cast<double>(level) / model.shape.n_levels);
    for (const auto& blocks : pending) {
      if (progress.is_cancelled()) return cancelled_error();
      for (const PendingBlock& block : blocks) LODE_CHECK(writer.append(block.key, block.block));
    }
  }
  const auto finished = writer.finish(progress);
  if (!finished) return finished.error();
  return {};
}

template std::string model_name<2>();
template std::string model_name<3>();
template Result<void> save<2>(const Model<2>&, const std::string&, Threads, Progress&);
template Result<void> save<3>(const Model<3>&, const std::string&, Threads, Progress&);

}  // namespace lode::diamond
