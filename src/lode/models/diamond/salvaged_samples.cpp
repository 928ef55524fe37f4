#include "lode/models/diamond/salvaged_samples.h"

#include <atomic>
#include <cmath>

#include "lode/models/diamond/range_code.h"
#include "lode/models/diamond/sample_blocks.h"

namespace lode::diamond {
namespace {

constexpr float kNotFilled = -1;

/// a + b, rounded up: Knuth's sum says what rounding lost.
double add_up(double a, double b) {
  const double sum = a + b;
  const double from_b = sum - a;
  const double lost = (a - (sum - from_b)) + (b - from_b);
  return lost > 0 ? next_up(sum) : sum;
}

/// The largest |value - x| of x between low and high, rounded up.
double largest_distance(double value, double low, double high) {
  return std::max(add_up(value, -low), add_up(high, -value));
}

/// Calls body(p) for the region's points in the data.
template <int D, typename F>
void for_each_sample(const Shape<D>& shape, const Region<D>& r, const F& body) {
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    const std::int32_t n_inside = count_inside(shape, r.level, q, n, stride);
    for (std::int32_t& x : q.v) x <<= r.level;
    for (std::int32_t i = 0; i < n_inside; ++i, q[0] += stride << r.level) body(q);
  });
}

/// Whether a sample of the field's type can be a hole.
bool can_be_hole(const VolumeInfo& info) {
  if (is_floating(info.type)) return true;
  if (!info.nodata || *info.nodata != std::trunc(*info.nodata)) return false;
  return visit_scalar_type(info.type, [&]<typename T>() {
    return *info.nodata >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
           *info.nodata <= static_cast<double>(std::numeric_limits<T>::max());
  });
}

/// Fills lie in the range that the metadata say, so samples must be able to.
Result<void> check_range(const store::Reader& reader, const FieldStats& stats, ScalarType storage) {
  return visit_storage_type(storage, [&]<typename T>() -> Result<void> {
    if (stats.min >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
        stats.max <= static_cast<double>(std::numeric_limits<T>::max()))
      return {};
    return fail("{}: metadata: expected a range of {}, got {} to {}", reader.path(),
                name_of(storage), stats.min, stats.max);
  });
}

/// Order in which samples are filled: by level from the coarsest, and within one from the tier with
/// the fewest odd coordinates, as such are what ends of others are clamped to at the data's border.
template <int D>
bool is_filled_before(const Index<D>& a, const Diamond<D>& b) {
  const int level = common_exponent<D>(a);
  return level > b.level || (level == b.level && diamond_at<D>(a).tier > b.tier);
}

}  // namespace

template <int D>
Result<SalvagedSamples<D>> SalvagedSamples<D>::load(const store::Reader& reader,
                                                    const Metadata& metadata, Threads threads,
                                                    Progress& progress,
                                                    std::vector<LostRegion<D>>& lost) {
  SalvagedSamples samples;
  FlatField<D>& field = samples.field_;
  field.set_info(metadata.info);
  field.stats = metadata.summary.stats;
  const Shape<D>& shape = field.shape;
  LODE_CHECK(check_range(reader, field.stats, field.storage));
  field.samples.resize(n_points<D>(shape.dims) * field.sample_size());
  const std::vector<Region<D>> regions = all_regions<D>(shape, Kind::samples);
  std::vector<std::vector<std::byte>> beyond(regions.size());
  const auto use = [&](std::size_t i, const std::vector<std::byte>& bytes) -> Result<void> {
    LODE_CHECK(samples.check_samples(reader, regions[i], bytes));
    visit_storage_type(field.storage, [&]<typename T>() {
      beyond[i] = put_samples_of<T, D>(shape, regions[i], bytes.data(), field.samples.data());
    });
    return {};
  };
  LODE_CHECK(salvage_blocks<D>(reader, regions, Kind::samples, field.sample_size(), threads,
                               progress, use, lost));
  for (const LostRegion<D>& block : lost) samples.mark_lost(block.region);
  for (std::size_t i = 0; i < regions.size(); ++i)
    if (!beyond[i].empty()) samples.use_beyond(reader, regions[i], beyond[i], lost);
  LODE_CHECK(samples.count(reader));
  return samples;
}

/// Samples that the metadata exclude are damage too, though their checksum is right.
template <int D>
Result<void> SalvagedSamples<D>::check_samples(const store::Reader& reader, const Region<D>& r,
                                               std::span<const std::byte> bytes) const {
  const FieldStats& stats = field_.stats;
  return visit_storage_type(field_.storage, [&]<typename T>() -> Result<void> {
    for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
      T sample;
      std::memcpy(&sample, bytes.data() + i, sizeof(T));
      const auto value = static_cast<double>(sample);
      const bool is_possible =
          field_.is_hole(value) ? stats.n_holes > 0 : stats.min <= value && value <= stats.max;
      if (!is_possible)
        return fail(
            "{}: {}: expected samples from {} to {} and {} holes, as the metadata say, got {}",
            reader.path(), describe(key_of(Kind::samples, r)), stats.min, stats.max,
            stats.n_holes > 0 ? "some" : "no", sample);
    }
    return {};
  });
}

template <int D>
void SalvagedSamples<D>::mark_lost(const Region<D>& r) {
  const Index<D>& dims = field_.shape.dims;
  if (errors_.empty()) errors_.assign(n_points<D>(dims), 0);
  for_each_sample<D>(field_.shape, r,
                     [&](const Index<D>& p) { errors_[linear_index<D>(dims, p)] = kNotFilled; });
}

/// What a block holds beyond the data are copies of samples at its border: they replace lost ones,
/// and must agree with the others.
template <int D>
void SalvagedSamples<D>::use_beyond(const store::Reader& reader, const Region<D>& r,
                                    std::span<const std::byte> beyond,
                                    std::vector<LostRegion<D>>& lost) {
  const std::size_t size = field_.sample_size();
  const std::byte* from = beyond.data();
  for_each_beyond<D>(field_.shape, r, [&](const Index<D>&, std::size_t nearest) {
    const std::byte* copy = std::exchange(from, from + size);
    if (errors_.empty() || errors_[nearest] != kNotFilled) return;
    std::copy_n(copy, size, field_.samples.data() + nearest * size);
    errors_[nearest] = 0;
  });
  const Result<void> agreed = visit_storage_type(field_.storage, [&]<typename T>() {
    return check_beyond<T, D>(reader, field_.shape, r, field_.samples.data(), beyond);
  });
  if (agreed) return;
  lost.push_back({r, Kind::samples, agreed.error().message});
  mark_lost(r);
}

template <int D>
Result<void> SalvagedSamples<D>::count(const store::Reader& reader) {
  std::uint64_t n_holes = 0;
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    const bool is_lost = errors_[i] == kNotFilled;
    n_lost_ += is_lost ? 1 : 0;
    if (!is_lost && field_.has_holes() &&
        field_.is_hole(field_.value(point_of<D>(field_.shape.dims, i))))
      ++n_holes;
  }
  if (n_lost_ == 0) return {};
  n_lost_holes_ = field_.stats.n_holes - n_holes;
  const bool is_possible = n_lost_holes_ == 0 || can_be_hole(field_.info);
  if (n_holes <= field_.stats.n_holes && n_lost_holes_ <= n_lost_ && is_possible) return {};
  return fail("{}: expected {} holes, as the metadata says, its whole blocks have {}",
              reader.path(), field_.stats.n_holes, n_holes);
}

template <int D>
Result<std::vector<typename SalvagedSamples<D>::Filled>> SalvagedSamples<D>::fill(
    const KnownNodes<D>& nodes, std::span<const LostRegion<D>> lost, Threads threads,
    Progress& progress) {
  std::vector<Filled> filled(lost.size());
  for (int level = field_.shape.n_levels - 1; level >= 0; --level) {
    std::vector<std::size_t> here;
    for (std::size_t i = 0; i < lost.size(); ++i)
      if (lost[i].region.level == level) here.push_back(i);
    // Corners of the root, the centres of no node, have tier D here.
    for (int tier = D; tier >= 0; --tier)
      parallel_for(here.size(), threads, 1, [&](std::size_t i, int) {
        if (!progress.is_cancelled()) fill_tier(nodes, lost[here[i]].region, tier, filled[here[i]]);
      });
    if (progress.is_cancelled()) return cancelled_error();
  }
  return filled;
}

template <int D>
void SalvagedSamples<D>::fill_tier(const KnownNodes<D>& nodes, const Region<D>& r, int tier,
                                   Filled& filled) {
  const Shape<D>& shape = field_.shape;
  for_each_sample<D>(shape, r, [&](const Index<D>& p) {
    const bool is_corner = common_exponent<D>(p) >= shape.n_levels;
    if ((is_corner ? D : diamond_at<D>(p).tier) != tier) return;
    const std::size_t at = linear_index<D>(shape.dims, p);
    if (errors_[at] != kNotFilled) return;  // a copy of it was found
    const Fill fill = fill_of(nodes, p);
    put(at, fill);
    ++filled.n_lost;
    filled.n_holes += fill.is_hole ? 1 : 0;
    filled.max_error = std::max(filled.max_error, fill.error);
  });
}

template <int D>
typename SalvagedSamples<D>::Known SalvagedSamples<D>::known(const Index<D>& end,
                                                             const Diamond<D>& node) const {
  const Index<D> p = field_.clamped(end);
  const std::size_t at = linear_index<D>(field_.shape.dims, p);
  // Other threads may be filling this sample; it is not looked at then.
  const float error =
      std::atomic_ref(const_cast<float&>(errors_[at])).load(std::memory_order_relaxed);
  Known sample{.place = p, .is_original = error == 0};
  if (error != 0 && !is_filled_before<D>(p, node)) return sample;
  sample.value = field_.value(p);
  sample.error = static_cast<double>(error);
  sample.is_hole = field_.has_holes() && field_.is_hole(sample.value);
  sample.has_value = !sample.is_hole;
  return sample;
}

template <int D>
typename SalvagedSamples<D>::Fill SalvagedSamples<D>::hole() const {
  const bool is_float = is_floating(field_.info.type);
  return {is_float ? std::numeric_limits<double>::quiet_NaN() : *field_.info.nodata, 0, true};
}

/// The nearest number to `value` that is a sample of the field's type, no hole, and for integers
/// within what is known of it.
template <int D>
double SalvagedSamples<D>::to_sample(double value, const Facts& facts) const {
  const bool is_integer = !is_floating(field_.info.type);
  if (is_integer)
    value = std::clamp(std::nearbyint(value), facts.low, facts.high);
  else if (field_.storage == ScalarType::float32)
    value = static_cast<double>(static_cast<float>(value));
  if (!field_.info.nodata || value != *field_.info.nodata) return value;
  const bool is_up = value < facts.high || value == field_.stats.min;
  if (is_integer) return is_up ? value + 1 : value - 1;
  if (field_.storage == ScalarType::float32) {
    const auto from = static_cast<float>(value);
    return static_cast<double>(is_up ? next_up(from) : -next_up(-from));
  }
  return is_up ? next_up(value) : -next_up(-value);
}

template <int D>
typename SalvagedSamples<D>::Fill SalvagedSamples<D>::in_range(double value,
                                                               const Facts& facts) const {
  const double sample = to_sample(std::clamp(value, facts.low, facts.high), facts);
  return {sample, largest_distance(sample, facts.low, facts.high), false};
}

/// The mean of the ends of the sample's axis, as far as they are there: the node's error says how
/// far the original is from that of the originals.
template <int D>
typename SalvagedSamples<D>::Fill SalvagedSamples<D>::between(const Index<D>& p, const Known& a,
                                                              const Known& b,
                                                              const Facts& facts) const {
  // At the border of the data an end may be nearest to the sample itself: half the distance to the
  // other end is then within the error.
  const bool is_half = a.place == p || b.place == p;
  if (!(a.has_value && b.has_value) && !is_half)
    return in_range(a.has_value ? a.value : b.value, facts);
  const Known& first = a.has_value ? a : b;
  const Known& second = b.has_value ? b : a;
  const double scale = is_half ? 2 : 1;
  Fill fill = in_range(0.5 * first.value + 0.5 * second.value, facts);
  // An end that was filled may have been a hole: then the node's error says nothing here.
  if (n_lost_holes_ > 0 && !(first.is_original && second.is_original)) return fill;
  const double middle_low = -add_up(-0.5 * first.value, -0.5 * second.value);
  const double middle_high = add_up(0.5 * first.value, 0.5 * second.value);
  const double moved = largest_distance(fill.value, middle_low, middle_high);
  const double of_ends = add_up(0.5 * first.error, 0.5 * second.error);
  fill.error = std::min(fill.error, add_up(add_up(scale * facts.error, of_ends), moved));
  return fill;
}

template <int D>
typename SalvagedSamples<D>::Fill SalvagedSamples<D>::fill_of(const KnownNodes<D>& nodes,
                                                              const Index<D>& p) const {
  Facts facts = nodes.at(p);
  if (n_lost_holes_ == n_lost_ || (n_lost_holes_ > 0 && facts.low > facts.high)) return hole();
  if (!is_floating(field_.info.type))
    facts = {std::ceil(facts.low), std::floor(facts.high), facts.error};
  if (facts.low > facts.high)
    facts = {field_.stats.min, field_.stats.max, std::numeric_limits<double>::infinity()};
  const double middle = 0.5 * facts.low + 0.5 * facts.high;
  if (common_exponent<D>(p) >= field_.shape.n_levels) return in_range(middle, facts);
  const Diamond<D> node = diamond_at<D>(p);
  const auto ends = axis_ends<D>(node);
  const Known a = known(ends[0], node);
  const Known b = known(ends[1], node);
  if (a.has_value || b.has_value) return between(p, a, b, facts);
  return n_lost_holes_ > 0 && (a.is_hole || b.is_hole) ? hole() : in_range(middle, facts);
}

template <int D>
void SalvagedSamples<D>::put(std::size_t at, const Fill& fill) {
  visit_storage_type(field_.storage, [&]<typename T>() {
    const T sample = static_cast<T>(fill.value);
    std::memcpy(field_.samples.data() + at * sizeof(T), &sample, sizeof(T));
  });
  const float error = std::max(float_up(fill.error), std::numeric_limits<float>::denorm_min());
  std::atomic_ref(errors_[at]).store(error, std::memory_order_relaxed);
}

template class SalvagedSamples<2>;
template class SalvagedSamples<3>;

}  // namespace lode::diamond
