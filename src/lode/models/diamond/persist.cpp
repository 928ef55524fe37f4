#include "lode/models/diamond/persist.h"

#include <algorithm>
#include <atomic>

#include "lode/models/diamond/build.h"
#include "lode/store/bytes.h"
#include "lode/store/codec.h"
#include "lode/store/writer.h"

namespace lode::diamond {
namespace {

/// What a block holds; part of the format.
enum class Kind : std::uint32_t { samples = 1, errors = 2, lows = 3, highs = 4 };

/// Grid points per edge of a block.
template <int D>
inline constexpr std::int32_t kBlockEdge = D == 3 ? 64 : 512;

/// One block's region of a level's grid: points lower <= q < upper, in steps of the level, without
/// those that belong to a coarser level (all coordinates even), except on the coarsest.
template <int D>
struct Region {
  int level = 0;
  Index<D> position, lower, upper;
  bool has_coarser_points = false;
};

template <int D>
std::uint64_t morton(const Index<D>& p) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 20; ++bit)
    for (int i = 0; i < D; ++i)
      code |= static_cast<std::uint64_t>((p[as_size(i)] >> bit) & 1) << (bit * D + i);
  return code;
}

template <int D>
std::vector<Region<D>> regions_of(const Index<D>& dims, int level, bool has_coarser_points) {
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i) n[i] = (dims[i] + kBlockEdge<D> - 1) / kBlockEdge<D>;
  std::vector<Region<D>> regions;
  for (std::size_t i = 0; i < n_points<D>(n); ++i) {
    Region<D> r{level, point_of<D>(n, i), {}, {}, has_coarser_points};
    for (std::size_t a = 0; a < as_size(D); ++a) {
      r.lower[a] = r.position[a] * kBlockEdge<D>;
      r.upper[a] = std::min(r.lower[a] + kBlockEdge<D>, dims[a]);
    }
    regions.push_back(r);
  }
  std::sort(regions.begin(), regions.end(), [](const Region<D>& a, const Region<D>& b) {
    return morton<D>(a.position) < morton<D>(b.position);
  });
  return regions;
}

template <int D>
Index<D> sample_dims(const Shape<D>& shape, int level) {
  Index<D> dims;
  for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = ((shape.dims[i] - 1) >> level) + 1;
  return dims;
}

/// Calls body(q) for each point of the region, x fastest.
template <int D, typename F>
void for_each_point(const Region<D>& r, const F& body) {
  const Index<D> dims = r.upper - r.lower;
  const std::size_t n = n_points<D>(dims);
  Index<D> q = r.lower;
  for (std::size_t i = 0; i < n; ++i) {
    std::int32_t odd = 0;
    for (std::size_t a = 0; a < as_size(D); ++a) odd |= q[a];
    if (r.has_coarser_points || (odd & 1) != 0) body(q);
    for (std::size_t a = 0; a < as_size(D); ++a) {
      if (++q[a] < r.upper[a]) break;
      q[a] = r.lower[a];
    }
  }
}

template <int D>
std::size_t count_points(const Region<D>& r) {
  std::size_t all = 1;
  std::size_t even = 1;
  for (std::size_t a = 0; a < as_size(D); ++a) {
    all *= as_size(r.upper[a] - r.lower[a]);
    even *= as_size((r.upper[a] + 1) / 2 - (r.lower[a] + 1) / 2);
  }
  return r.has_coarser_points ? all : all - even;
}

/// Ranges are stored in the sample type where that is exact, else as float32.
template <typename F>
decltype(auto) visit_range_type(ScalarType storage, F&& f) {
  switch (storage) {
    case ScalarType::uint8: return f.template operator()<std::uint8_t>();
    case ScalarType::uint16: return f.template operator()<std::uint16_t>();
    case ScalarType::int16: return f.template operator()<std::int16_t>();
    default: return f.template operator()<float>();
  }
}

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

template <int D>
store::BlockKey key_of(Kind kind, const Region<D>& r) {
  store::BlockKey key{static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(r.level), {}};
  for (std::size_t a = 0; a < as_size(D); ++a) key.position[a] = r.position[a];
  return key;
}

template <int D>
void encode_samples(const Model<D>& model, const Region<D>& r, std::vector<PendingBlock>& out) {
  visit_storage_type(model.storage, [&]<typename T>() {
    std::vector<T> values;
    values.reserve(count_points(r));
    for_each_point<D>(r, [&](const Index<D>& q) {
      Index<D> p;
      for (std::size_t a = 0; a < as_size(D); ++a) p[a] = q[a] << r.level;
      Index<D> b;
      for (std::size_t a = 0; a < as_size(D); ++a) {
        b[a] = std::min(p[a] / kBrickEdge<D>, model.brick_dims[a] - 1);
        p[a] -= b[a] * kBrickEdge<D>;
      }
      T v;
      std::memcpy(
          &v, model.brick(linear_index<D>(model.brick_dims, b)) + model.brick_offset(p) * sizeof(T),
          sizeof(T));
      values.push_back(v);
    });
    if (!values.empty())
      out.push_back({key_of(Kind::samples, r),
                     store::encode_block(std::as_bytes(std::span<const T>(values)), sizeof(T))});
  });
}

template <int D>
void encode_attributes(const Model<D>& model, const Region<D>& r, std::vector<PendingBlock>& out) {
  const NodeLevel& nodes = model.levels[as_size(r.level)];
  const Index<D> dims = model.shape.grid_dims(r.level);
  std::vector<ErrorCode> errors;
  for_each_point<D>(
      r, [&](const Index<D>& q) { errors.push_back(nodes.error[linear_index<D>(dims, q)]); });
  if (errors.empty()) return;
  out.push_back(
      {key_of(Kind::errors, r),
       store::encode_block(std::as_bytes(std::span<const ErrorCode>(errors)), sizeof(ErrorCode))});
  visit_range_type(model.storage, [&]<typename R>() {
    std::vector<R> lows;
    std::vector<R> highs;
    for_each_point<D>(r, [&](const Index<D>& q) {
      const std::size_t at = linear_index<D>(dims, q);
      const bool is_empty = nodes.low[at] > nodes.high[at];
      lows.push_back(is_empty ? std::numeric_limits<R>::max() : to_range<R>(nodes.low[at]));
      highs.push_back(is_empty ? std::numeric_limits<R>::lowest() : to_range<R>(nodes.high[at]));
    });
    out.push_back({key_of(Kind::lows, r),
                   store::encode_block(std::as_bytes(std::span<const R>(lows)), sizeof(R))});
    out.push_back({key_of(Kind::highs, r),
                   store::encode_block(std::as_bytes(std::span<const R>(highs)), sizeof(R))});
  });
}

std::vector<std::byte> encode_metadata(const VolumeInfo& info) {
  store::ByteWriter out;
  for (const std::int32_t n : info.grid.dims.v) out.write(n);
  for (const double x : info.grid.spacing.v) out.write(x);
  for (const double x : info.grid.origin.v) out.write(x);
  for (const Vec3d& row : info.grid.direction.rows)
    for (const double x : row.v) out.write(x);
  out.write(static_cast<std::uint8_t>(info.grid.frame));
  out.write(static_cast<std::uint8_t>(info.type));
  out.write(static_cast<std::uint8_t>(info.nodata.has_value() ? 1 : 0));
  out.write(info.nodata.value_or(0));
  out.write_string(info.field_name);
  return std::move(out).take();
}

Result<VolumeInfo> decode_metadata(const store::Reader& reader) {
  store::ByteReader in(reader.metadata(), reader.path() + ": metadata");
  VolumeInfo info;
  for (std::int32_t& n : info.grid.dims.v) {
    LODE_TRY(n, in.read<std::int32_t>());
    if (n < 1 || n > kMaxSamplesPerAxis)
      return fail("{}: metadata: expected 1 to {} samples along an axis, got {}", reader.path(),
                  kMaxSamplesPerAxis, n);
  }
  for (double& x : info.grid.spacing.v) {
    LODE_TRY(x, in.read<double>());
    if (!(x > 0) || !std::isfinite(x))
      return fail("{}: metadata: expected a positive spacing, got {}", reader.path(), x);
  }
  for (double& x : info.grid.origin.v) {
    LODE_TRY(x, in.read<double>());
    if (!std::isfinite(x)) return fail("{}: metadata: expected a finite origin", reader.path());
  }
  for (Vec3d& row : info.grid.direction.rows)
    for (double& x : row.v) {
      LODE_TRY(x, in.read<double>());
    }
  // The readers of foreign files ask the same.
  if (!(std::abs(determinant(info.grid.direction)) >= 1e-6))
    return fail("{}: metadata: expected independent directions of the axes", reader.path());
  LODE_TRY(const auto frame, in.read<std::uint8_t>());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  LODE_TRY(const auto has_nodata, in.read<std::uint8_t>());
  LODE_TRY(const auto nodata, in.read<double>());
  LODE_TRY(info.field_name, in.read_string());
  info.type = static_cast<ScalarType>(type);
  if (!is_valid(info.type) || frame > static_cast<std::uint8_t>(Frame::lps))
    return fail("{}: metadata: expected a sample type 1..10 and a frame 0..2, got {} and {}",
                reader.path(), type, frame);
  info.grid.frame = static_cast<Frame>(frame);
  if (has_nodata != 0) info.nodata = nodata;
  return info;
}

template <int D>
std::vector<Region<D>> all_regions(const Shape<D>& shape, Kind kind) {
  std::vector<Region<D>> regions;
  for (int level = shape.n_levels - 1; level >= (kind == Kind::samples ? 0 : 1); --level) {
    const bool is_coarsest = level == shape.n_levels - 1;
    const Index<D> dims =
        kind == Kind::samples ? sample_dims<D>(shape, level) : shape.grid_dims(level);
    const auto more = regions_of<D>(dims, level, kind == Kind::samples && is_coarsest);
    regions.insert(regions.end(), more.begin(), more.end());
  }
  return regions;
}

/// Loads one kind of block into arrays, in parallel; body(region, bytes) puts the points.
template <int D, typename Body>
Result<void> load_blocks(const store::Reader& reader, const Shape<D>& shape, Kind kind,
                         std::size_t element_size, Threads threads, Progress& progress,
                         const Body& body) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, kind);
  std::vector<Error> errors(regions.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    const std::size_t n = count_points(regions[i]);
    if (n == 0) return;
    const store::BlockKey key = key_of(kind, regions[i]);
    const auto at = reader.find(key);
    if (!at) {
      errors[i] = fail("{}: expected {}, but the file has none", reader.path(), describe(key));
      return;
    }
    if (reader.blocks()[*at].raw_size != n * element_size) {
      errors[i] = fail("{}: {}: expected {} bytes, got {}", reader.path(), describe(key),
                       n * element_size, reader.blocks()[*at].raw_size);
      return;
    }
    auto bytes = reader.read_block(*at);
    if (!bytes) {
      errors[i] = bytes.error();
      return;
    }
    body(regions[i], bytes->data());
    progress.report("loading", static_cast<double>(++n_done) / static_cast<double>(regions.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  for (const Error& error : errors)
    if (!error.message.empty()) return error;
  return {};
}

/// Refuses metadata that promises other samples than the directory holds, before memory is asked.
template <int D>
Result<void> check_size(const store::Reader& reader, const VolumeInfo& info) {
  const auto expected =
      static_cast<std::uint64_t>(info.grid.n_samples()) * size_of(storage_type(info.type));
  std::uint64_t present = 0;
  for (const store::BlockEntry& block : reader.blocks())
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples)) present += block.raw_size;
  if (expected == present) return {};
  return fail("{}: expected {} bytes of samples for {} x {} x {}, its blocks hold {}",
              reader.path(), expected, info.grid.dims[0], info.grid.dims[1], info.grid.dims[2],
              present);
}

template <int D>
Result<void> load_samples(Model<D>& model, const store::Reader& reader, Threads threads,
                          Progress& progress) {
  const std::size_t size = model.sample_size();
  const Index<D> dims = model.shape.dims;
  std::vector<std::byte> all(n_points<D>(dims) * size);
  LODE_CHECK(load_blocks<D>(reader, model.shape, Kind::samples, size, threads, progress,
                            [&](const Region<D>& r, const std::byte* from) {
                              for_each_point<D>(r, [&](Index<D> q) {
                                for (std::size_t a = 0; a < as_size(D); ++a) q[a] <<= r.level;
                                std::memcpy(all.data() + linear_index<D>(dims, q) * size, from,
                                            size);
                                from += size;
                              });
                            }));
  put_samples<D>(model, {}, dims, all.data());
  finish_samples<D>(model, threads);
  return {};
}

template <int D>
Result<void> load_attributes(Model<D>& model, const store::Reader& reader, Threads threads,
                             Progress& progress) {
  for (int level = 1; level < model.shape.n_levels; ++level) {
    NodeLevel& nodes = model.levels[as_size(level)];
    const std::size_t n = n_points<D>(model.shape.grid_dims(level));
    nodes.error.assign(n, 0);
    nodes.low.assign(n, std::numeric_limits<float>::infinity());
    nodes.high.assign(n, -std::numeric_limits<float>::infinity());
  }
  LODE_CHECK(load_blocks<D>(reader, model.shape, Kind::errors, sizeof(ErrorCode), threads, progress,
                            [&](const Region<D>& r, const std::byte* from) {
                              const Index<D> dims = model.shape.grid_dims(r.level);
                              for_each_point<D>(r, [&](const Index<D>& q) {
                                std::memcpy(
                                    &model.levels[as_size(r.level)].error[linear_index<D>(dims, q)],
                                    from, sizeof(ErrorCode));
                                from += sizeof(ErrorCode);
                              });
                            }));
  return visit_range_type(model.storage, [&]<typename R>() -> Result<void> {
    for (const Kind kind : {Kind::lows, Kind::highs})
      LODE_CHECK(load_blocks<D>(reader, model.shape, kind, sizeof(R), threads, progress,
                                [&](const Region<D>& r, const std::byte* from) {
                                  NodeLevel& nodes = model.levels[as_size(r.level)];
                                  auto& values = kind == Kind::lows ? nodes.low : nodes.high;
                                  const Index<D> dims = model.shape.grid_dims(r.level);
                                  for_each_point<D>(r, [&](const Index<D>& q) {
                                    R v;
                                    std::memcpy(&v, from, sizeof(R));
                                    from += sizeof(R);
                                    values[linear_index<D>(dims, q)] = static_cast<float>(v);
                                  });
                                }));
    for (NodeLevel& nodes : model.levels)
      for (std::size_t i = 0; i < nodes.low.size(); ++i) {
        if (nodes.error[i] > kInfiniteError || std::isnan(nodes.low[i]) ||
            std::isnan(nodes.high[i]))
          return fail("{}: attributes: expected an error and a range, got a code {} and {} to {}",
                      reader.path(), nodes.error[i], nodes.low[i], nodes.high[i]);
        if (nodes.low[i] > nodes.high[i]) {
          nodes.low[i] = std::numeric_limits<float>::infinity();
          nodes.high[i] = -std::numeric_limits<float>::infinity();
        }
      }
    return {};
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
  LODE_TRY(auto writer, store::Writer::create(path, model_name<D>(), encode_metadata(model.info)));
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
    for (const auto& blocks : pending)
      for (const PendingBlock& block : blocks) LODE_CHECK(writer.append(block.key, block.block));
  }
  const auto finished = writer.finish();
  if (!finished) return finished.error();
  return {};
}

template <int D>
Result<Model<D>> load(const store::Reader& reader, Threads threads, Progress& progress) {
  LODE_TRY(const VolumeInfo info, decode_metadata(reader));
  LODE_CHECK(check_size<D>(reader, info));
  Model<D> model = Model<D>::make(info);
  LODE_CHECK(load_samples<D>(model, reader, threads, progress));
  model.levels.resize(as_size(model.shape.n_levels));
  LODE_CHECK(load_attributes<D>(model, reader, threads, progress));
  compute_level_0<D>(model, threads);
  return model;
}

StoredBytes stored_bytes(const store::Reader& reader) {
  StoredBytes bytes;
  for (const store::BlockEntry& block : reader.blocks()) {
    if (block.key.level > 31) continue;
    if (bytes.by_level.size() <= block.key.level) bytes.by_level.resize(block.key.level + 1);
    bytes.by_level[block.key.level] += block.stored_size;
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples))
      bytes.samples += block.stored_size;
  }
  bytes.attributes = reader.file_size() - bytes.samples;
  return bytes;
}

template std::string model_name<2>();
template std::string model_name<3>();
template Result<void> save<2>(const Model<2>&, const std::string&, Threads, Progress&);
template Result<void> save<3>(const Model<3>&, const std::string&, Threads, Progress&);
template Result<Model<2>> load<2>(const store::Reader&, Threads, Progress&);
template Result<Model<3>> load<3>(const store::Reader&, Threads, Progress&);

}  // namespace lode::diamond
