#include "lode/models/diamond/paged_model.h"

#include <cstring>
#include <new>

#include "lode/core/out_of_memory.h"

namespace lode::diamond {
namespace {

/// Of a node, with ranges in R.
template <typename R>
constexpr std::size_t kAttributesSize = sizeof(ErrorCode) + 2 * sizeof(R) + sizeof(WorldCode);

}  // namespace

template <int D>
PagedModel<D>::PagedModel(const store::Reader& reader, const Metadata& metadata)
    : reader_(reader),
      has_worlds_(metadata.summary.max_errors.size() == 1 || diamond::has_worlds(reader)),
      fetcher_(
          [&] {
            this->set_info(metadata.info);
            this->stats = metadata.summary.stats;
            std::size_t n = 0;
            for (int k = 0; k < this->shape.n_levels; ++k) {
              Level& level = levels_.emplace_back();
              level.dims = sample_dims<D>(this->shape, k);
              level.n_blocks = block_counts<D>(level.dims);
              level.first = static_cast<Page>(n);
              n += n_points<D>(level.n_blocks);
            }
            pages_.resize(n);
            for (Page page = 0; page < n; ++page) n_bytes_of_all_ += n_bytes(page);
            lacks_memory_.resize(n);
            return n;
          }(),
          [this](Page page) { fetch(page); }) {}

template <int D>
Result<std::unique_ptr<PagedModel<D>>> PagedModel<D>::open(const store::Reader& reader,
                                                           const Metadata& metadata,
                                                           Progress& progress) {
  std::unique_ptr<PagedModel> model(new PagedModel(reader, metadata));
  for (int k = model->shape.n_levels; k-- > 0;) {
    const Level& level = model->levels_[as_size(k)];
    if (n_points<D>(level.n_blocks) > 1) break;
    if (progress.is_cancelled()) return cancelled_error();
    LODE_CHECK(model->load_page(level.first));
    static_cast<void>(model->pages_.hold(level.first));  // for good
  }
  return model;
}

template <int D>
double PagedModel<D>::value(Index<D> p) const {
  for (std::size_t i = 0; i < as_size(D); ++i) p[i] = std::max(p[i], 0);
  int level = 0;
  for (bool is_inside = false; !is_inside;) {
    level = std::min(common_exponent<D>(p), this->shape.n_levels - 1);
    is_inside = true;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t last = (levels_[as_size(level)].dims[i] - 1) << level;
      if (p[i] <= last) continue;
      p[i] = last;
      is_inside = false;
    }
  }
  const Index<D> q = on_grid(p, level);
  const LevelPage<D>* page = page_at(level, q);
  LODE_EXPECTS(page != nullptr);
  const std::size_t at = page->index_of(q);
  return visit_storage_type(this->storage, [&]<typename T>() {
    return static_cast<double>(reinterpret_cast<const T*>(page->samples.data())[at]);
  });
}

template <int D>
StoredAttributes PagedModel<D>::attributes(const Diamond<D>& node) const {
  const Index<D> q = on_grid(node.centre, node.level);
  const LevelPage<D>* page = page_at(node.level, q);
  LODE_EXPECTS(page != nullptr);
  return visit_range_type(this->storage, [&]<typename R>() {
    const std::byte* at = page->attributes.data() + page->index_of(q) * kAttributesSize<R>;
    ErrorCode error;
    R low;
    R high;
    std::memcpy(&error, at, sizeof(error));
    std::memcpy(&low, at + sizeof(error), sizeof(R));
    std::memcpy(&high, at + sizeof(error) + sizeof(R), sizeof(R));
    constexpr float kEndless = std::numeric_limits<float>::infinity();
    if (low > high) return StoredAttributes{error, kEndless, -kEndless};
    return StoredAttributes{error, static_cast<float>(low), static_cast<float>(high)};
  });
}

template <int D>
WorldCode PagedModel<D>::world_error(const Diamond<D>& node) const {
  const Index<D> q = on_grid(node.centre, node.level);
  const LevelPage<D>* page = page_at(node.level, q);
  LODE_EXPECTS(page != nullptr);
  const std::size_t size = attributes_size();  // it is the last
  return static_cast<WorldCode>(page->attributes[(page->index_of(q) + 1) * size - 1]);
}

template <int D>
std::size_t PagedModel<D>::attributes_size() const {
  return visit_range_type(this->storage, []<typename R>() { return kAttributesSize<R>; });
}

template <int D>
void PagedModel<D>::prefetch(const Diamond<D>& node) const {
  const Index<D> q = on_grid(node.centre, node.level);
  const LevelPage<D>* page = page_at(node.level, q);
  if (page == nullptr) return;
  __builtin_prefetch(page->attributes.data() + page->index_of(q) * attributes_size());
}

template <int D>
std::uint64_t PagedModel<D>::n_bytes(Page page) const {
  const Region<D> region = region_of(page);
  const std::size_t attributes = region.level > 0 ? attributes_size() : 0;
  return n_points<D>(region.upper - region.lower) * (this->sample_size() + attributes);
}

template <int D>
void PagedModel<D>::set_memory_limit(std::uint64_t n_bytes) const {
  constexpr std::uint64_t kPagesAtLeast = 4;
  const std::uint64_t largest =
      n_points<D>(all_equal<D>(kBlockEdge<D>)) * (this->sample_size() + attributes_size());
  memory_limit_ = std::max(n_bytes, kPagesAtLeast * largest);
}

template <int D>
Region<D> PagedModel<D>::region_of(Page page) const {
  int k = 0;
  while (k + 1 < this->shape.n_levels && levels_[as_size(k + 1)].first <= page) ++k;
  const Level& level = levels_[as_size(k)];
  return region_at<D>(level.dims, k, point_of<D>(level.n_blocks, page - level.first),
                      k == this->shape.n_levels - 1);
}

/// What goes wrong is known of the page, and of those that need it; others can still be fetched.
template <int D>
void PagedModel<D>::fetch(Page number) {
  try {
    const auto done = load_page(number);
    if (done) return;
    const std::lock_guard lock(fault_mutex_);
    faults_.try_emplace(number, done.error());
  } catch (const std::bad_alloc&) {
    const std::lock_guard lock(fault_mutex_);
    lacks_memory_[number] = true;
  }
  has_fault_.store(true, std::memory_order_release);
}

/// The coarser page that its samples are completed from comes first.
template <int D>
Result<void> PagedModel<D>::load_page(Page number) {
  if (pages_.has(number)) return {};
  const Region<D> region = region_of(number);
  if (!region.has_coarser_points) {
    Index<D> q = region.lower;
    for (std::size_t i = 0; i < as_size(D); ++i) q[i] /= 2;
    LODE_CHECK(load_page(number_of(region.level + 1, block_of(region.level + 1, q))));
  }
  auto page = std::make_unique<LevelPage<D>>();
  LODE_CHECK(load(region, *page));
  const std::uint64_t size = n_bytes(number);
  const std::uint64_t limit = memory_limit_;
  pages_.shrink(
      limit - std::min(limit, size), [this](Page other) { fetcher_.leaves(other); },
      [this](Page other) { fetcher_.stays(other); });
  pages_.put(number, std::move(page), size);
  return {};
}

template <int D>
Result<void> PagedModel<D>::load(const Region<D>& region, LevelPage<D>& page) const {
  page.lower = region.lower;
  page.dims = region.upper - region.lower;
  std::size_t n = 1;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    page.strides[i] = n;
    n *= as_size(page.dims[i]);
  }
  page.samples.resize(n * this->sample_size());
  LODE_CHECK(load_samples(region, page));
  if (!region.has_coarser_points) add_coarser(region, page);
  if (region.level == 0) return {};
  page.attributes.assign(n * attributes_size(), std::byte{0});
  Region<D> nodes = region;
  nodes.has_coarser_points = false;
  return load_attributes(nodes, page);
}

template <int D>
Result<void> PagedModel<D>::load_samples(const Region<D>& region, LevelPage<D>& page) const {
  return visit_storage_type(this->storage, [&]<typename T>() -> Result<void> {
    LODE_TRY(const auto bytes, read_region<D>(reader_, region, Kind::samples, sizeof(T)));
    const std::byte* from = bytes.data();
    T* to = reinterpret_cast<T*>(page.samples.data());
    bool is_as_promised = true;
    for_each_row<D>(region, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
      T* row = to + page.index_of(q);
      for (std::size_t i = 0; i < as_size(n); ++i, from += sizeof(T), row += stride) {
        std::memcpy(row, from, sizeof(T));
        const auto sample = static_cast<double>(*row);
        const bool is_in_range = sample >= this->stats.min && sample <= this->stats.max;
        is_as_promised =
            is_as_promised && (this->is_hole(sample) ? this->has_holes() : is_in_range);
      }
    });
    if (!is_as_promised)
      return fail("{}: {}: expected samples from {} to {} and {}, as the metadata says, got others",
                  reader_.path(), describe(key_of(Kind::samples, region)), this->stats.min,
                  this->stats.max, this->has_holes() ? "holes" : "no holes");
    return {};
  });
}

/// The samples that the next coarser level has.
template <int D>
void PagedModel<D>::add_coarser(const Region<D>& region, LevelPage<D>& page) const {
  Index<D> first;
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    first[i] = (region.lower[i] + 1) / 2;
    n[i] = (region.upper[i] - 1) / 2 - first[i] + 1;
    if (n[i] <= 0) return;
  }
  const LevelPage<D>& coarser = *page_at(region.level + 1, first);
  visit_storage_type(this->storage, [&]<typename T>() {
    const T* from = reinterpret_cast<const T*>(coarser.samples.data());
    T* to = reinterpret_cast<T*>(page.samples.data());
    Index<D> rows = n;
    rows[0] = 1;
    for (std::size_t row = 0; row < n_points<D>(rows); ++row) {
      const Index<D> q = first + point_of<D>(rows, row);
      const T* source = from + coarser.index_of(q);
      T* target = to + page.index_of(q * 2);
      for (std::size_t x = 0; x < as_size(n[0]); ++x) target[2 * x] = source[x];
    }
  });
}

/// A node in the data has the sample at its centre, unless that is a hole, in its range: what is
/// damaged or made up would hardly.
template <int D>
Result<void> PagedModel<D>::load_attributes(const Region<D>& region, LevelPage<D>& page) const {
  return visit_storage_type(this->storage, [&]<typename T>() -> Result<void> {
    using R = RangeOf<T>;
    LODE_TRY(const auto errors, read_region<D>(reader_, region, Kind::errors, sizeof(ErrorCode)));
    LODE_TRY(const auto lows, read_region<D>(reader_, region, Kind::lows, sizeof(R)));
    LODE_TRY(const auto highs, read_region<D>(reader_, region, Kind::highs, sizeof(R)));
    std::vector<std::byte> worlds(errors.size() / sizeof(ErrorCode));
    if (has_worlds_) {
      LODE_TRY(worlds, read_region<D>(reader_, region, Kind::worlds, sizeof(WorldCode)));
    }
    constexpr std::size_t kSize = kAttributesSize<R>;
    std::size_t i = 0;
    bool is_good = true;
    for_each_row<D>(region, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
      const std::int32_t n_inside = count_inside(this->shape, region.level, q, n, stride);
      std::size_t at = page.index_of(q);
      for (std::int32_t x = 0; x < n; ++x, ++i, at += as_size(stride)) {
        ErrorCode error;
        R low;
        R high;
        std::memcpy(&error, errors.data() + i * sizeof(error), sizeof(error));
        std::memcpy(&low, lows.data() + i * sizeof(R), sizeof(R));
        std::memcpy(&high, highs.data() + i * sizeof(R), sizeof(R));
        std::byte* to = page.attributes.data() + at * kSize;
        std::memcpy(to, &error, sizeof(error));
        std::memcpy(to + sizeof(error), &low, sizeof(R));
        std::memcpy(to + sizeof(error) + sizeof(R), &high, sizeof(R));
        to[kSize - 1] = worlds[i];
        const auto sample =
            static_cast<double>(reinterpret_cast<const T*>(page.samples.data())[at]);
        const double above = sample - this->range_reference();
        const bool holds =
            (above >= static_cast<double>(low) && above <= static_cast<double>(high)) ||
            (this->has_holes() && this->is_hole(sample));
        const bool is_range = low <= high || low > high;  // numbers
        is_good = is_good && error <= kInfiniteError && is_range && (x >= n_inside || holds);
      }
    });
    if (is_good) return {};
    return fail(
        "{}: {}: expected errors, and ranges that contain the samples in their middle, got others",
        reader_.path(), describe(key_of(Kind::errors, region)));
  });
}

template class PagedModel<2>;
template class PagedModel<3>;

}  // namespace lode::diamond
