#include "lode/models/terrain/insertions/page.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "lode/models/terrain/insertions/page_bits.h"

namespace lode::insertions {
namespace {

constexpr int kRiceBitsField = 5;
constexpr int kWidthField = 7;
constexpr int kCountField = 16;
constexpr int kKeyBits = 64;

int width_of(std::uint64_t largest) { return static_cast<int>(std::bit_width(largest)); }

/// A number that is the larger the higher a height is.
template <typename Float, typename Bits>
std::uint64_t ordered(Float height) {
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
  const auto bits = std::bit_cast<Bits>(height);
  return (bits & kSign) != 0 ? Bits(~bits) : Bits(bits | kSign);
}

template <typename Float, typename Bits>
double from_ordered(std::uint64_t key) {
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
  const auto bits = static_cast<Bits>(key);
  return static_cast<double>(
      std::bit_cast<Float>((bits & kSign) != 0 ? Bits(bits ^ kSign) : Bits(~bits)));
}

constexpr int kInt16Offset = 1 << 15;

std::uint64_t key_of(double height, HeightType type) {
  switch (type) {
    case HeightType::int16: return static_cast<std::uint64_t>(std::lround(height) + kInt16Offset);
    case HeightType::float32: return ordered<float, std::uint32_t>(static_cast<float>(height));
    case HeightType::float64: return ordered<double, std::uint64_t>(height);
  }
  return 0;
}

/// NaN where a key is none of the type's.
double height_of(std::uint64_t key, HeightType type) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  switch (type) {
    case HeightType::int16:
      return key <= std::numeric_limits<std::uint16_t>::max()
                 ? static_cast<double>(static_cast<std::int64_t>(key) - kInt16Offset)
                 : kNan;
    case HeightType::float32:
      return key <= std::numeric_limits<std::uint32_t>::max()
                 ? from_ordered<float, std::uint32_t>(key)
                 : kNan;
    case HeightType::float64: return from_ordered<double, std::uint64_t>(key);
  }
  return kNan;
}

/// Numbers that rise, from `begin` on.
void write_rising(std::span<const std::uint32_t> numbers, std::uint32_t begin, PageBitWriter& out) {
  std::vector<std::uint32_t> gaps;
  gaps.reserve(numbers.size());
  for (const std::uint32_t number : numbers) {
    gaps.push_back(number - begin);
    begin = number + 1;
  }
  const int k = choose_rice_bits(gaps);
  out.write(static_cast<std::uint64_t>(k), kRiceBitsField);
  for (const std::uint32_t gap : gaps) out.write_rice(gap, k);
}

/// Nothing where one is not below `end`.
std::vector<std::uint32_t> read_rising(PageBitReader& in, std::size_t n, std::uint32_t begin,
                                       std::uint32_t end) {
  std::vector<std::uint32_t> numbers;
  const auto k = static_cast<int>(in.read(kRiceBitsField));
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t gap = in.read_rice(k);
    if (begin >= end || gap >= end - begin || in.is_past_end()) return {};
    numbers.push_back(begin + static_cast<std::uint32_t>(gap));
    begin = numbers.back() + 1;
  }
  return numbers;
}

void write_heights(std::span<const double> heights, HeightType type, PageBitWriter& out) {
  std::vector<std::uint64_t> keys;
  keys.reserve(heights.size());
  for (const double z : heights) keys.push_back(key_of(z, type));
  const std::uint64_t lowest = keys.empty() ? 0 : std::ranges::min(keys);
  std::uint64_t all = 0;
  for (std::uint64_t& key : keys) all |= key -= lowest;
  const int shift = all == 0 ? 0 : std::countr_zero(all);
  const int n_bits = width_of(all >> shift);
  out.write(lowest, kKeyBits);
  out.write(static_cast<std::uint64_t>(shift), kWidthField);
  out.write(static_cast<std::uint64_t>(n_bits), kWidthField);
  for (const std::uint64_t key : keys) out.write(key >> shift, n_bits);
}

Result<void> read_heights(PageBitReader& in, std::size_t n, const PageContext& context,
                          std::vector<double>& heights) {
  const std::uint64_t lowest = in.read(kKeyBits);
  const auto shift = static_cast<int>(in.read(kWidthField));
  const auto n_bits = static_cast<int>(in.read(kWidthField));
  if (shift >= kKeyBits || n_bits > kKeyBits - shift)
    return fail("expected heights of up to {} bits, got {} and {}", kKeyBits, n_bits, shift);
  for (std::size_t i = 0; i < n; ++i) {
    const double z = height_of(lowest + (in.read(n_bits) << shift), context.type);
    if (!(z >= context.range.lower && z <= context.range.upper))
      return fail("expected heights from {} to {}, got {}", context.range.lower,
                  context.range.upper, z);
    heights.push_back(z);
  }
  return {};
}

/// Of signed numbers, small ones for those near 0.
std::uint32_t zigzag(std::int64_t number) {
  return static_cast<std::uint32_t>(number >= 0 ? 2 * number : -2 * number - 1);
}

std::int64_t from_zigzag(std::uint64_t code) {
  const auto half = static_cast<std::int64_t>(code / 2);
  return code % 2 == 0 ? half : -half - 1;
}

/// How many triangles nodes make, from a number that the first one has on.
void write_counts(std::span<const std::uint32_t> first_made, PageBitWriter& out) {
  std::vector<std::uint32_t> codes;
  codes.reserve(first_made.size());
  std::vector<std::uint32_t> counts;
  counts.reserve(first_made.size());
  for (std::size_t i = 0; i + 1 < first_made.size(); ++i)
    counts.push_back(first_made[i + 1] - first_made[i]);
  std::vector<std::uint32_t> sorted = counts;
  std::ranges::sort(sorted);
  const std::uint32_t middle = sorted.empty() ? 0 : sorted[sorted.size() / 2];
  for (const std::uint32_t n : counts) codes.push_back(zigzag(std::int64_t{n} - middle));
  const int k = choose_rice_bits(codes);
  out.write(middle, kCountField);
  out.write(static_cast<std::uint64_t>(k), kRiceBitsField);
  for (const std::uint32_t code : codes) out.write_rice(code, k);
}

Result<void> read_counts(PageBitReader& in, const PageEntry& entry,
                         std::vector<std::uint32_t>& first_made) {
  const auto middle = static_cast<std::int64_t>(in.read(kCountField));
  const auto k = static_cast<int>(in.read(kRiceBitsField));
  first_made.assign(1, 0);
  for (std::uint32_t i = 0; i < entry.n_nodes; ++i) {
    const std::int64_t n = middle + from_zigzag(in.read_rice(k));
    const std::uint32_t n_left = entry.n_triangles - first_made.back();
    if (n < 1 || n > n_left)
      return fail("expected nodes that make {} triangles in all, got one of {} where {} are left",
                  entry.n_triangles, n, n_left);
    first_made.push_back(first_made.back() + static_cast<std::uint32_t>(n));
  }
  if (first_made.back() != entry.n_triangles)
    return fail("expected nodes that make {} triangles in all, got {}", entry.n_triangles,
                first_made.back());
  return {};
}

std::uint32_t side(std::int32_t low, std::int32_t high) {
  return static_cast<std::uint32_t>(high - low);
}

}  // namespace

std::vector<std::byte> encode_nodes(const PageNodes& nodes, const PageContext& context) {
  const PageEntry& entry = context.entry;
  PageBitWriter out;
  write_rising(nodes.times, context.band.begin, out);
  const int x_bits = width_of(side(entry.lower.x, entry.upper.x));
  const int y_bits = width_of(side(entry.lower.y, entry.upper.y));
  for (const delaunay::LatticePoint& p : nodes.points) {
    out.write(side(entry.lower.x, p.x), x_bits);
    out.write(side(entry.lower.y, p.y), y_bits);
  }
  write_heights(nodes.heights, context.type, out);
  write_counts(nodes.first_made, out);
  std::vector<std::uint32_t> later;
  for (std::uint32_t i = 0; i < nodes.begins_later.size(); ++i)
    if (nodes.begins_later[i]) later.push_back(i);
  out.write(later.size(), kCountField + 1);
  write_rising(later, 0, out);
  return std::move(out).take();
}

Result<PageNodes> decode_nodes(std::span<const std::byte> bytes, const PageContext& context) {
  const PageEntry& entry = context.entry;
  PageBitReader in(bytes);
  PageNodes nodes;
  nodes.times = read_rising(in, entry.n_nodes, context.band.begin, context.band.end);
  if (nodes.times.size() != entry.n_nodes)
    return fail("expected {} rising times from {} to before {}, got others", entry.n_nodes,
                context.band.begin, context.band.end);
  const int x_bits = width_of(side(entry.lower.x, entry.upper.x));
  const int y_bits = width_of(side(entry.lower.y, entry.upper.y));
  for (std::uint32_t i = 0; i < entry.n_nodes; ++i) {
    const std::uint64_t x = in.read(x_bits);
    const std::uint64_t y = in.read(y_bits);
    if (x > side(entry.lower.x, entry.upper.x) || y > side(entry.lower.y, entry.upper.y))
      return fail("expected vertices in columns {} to {} and rows {} to {}, got {}, {}",
                  entry.lower.x, entry.upper.x, entry.lower.y, entry.upper.y,
                  entry.lower.x + static_cast<std::int64_t>(x),
                  entry.lower.y + static_cast<std::int64_t>(y));
    nodes.points.push_back({entry.lower.x + static_cast<std::int32_t>(x),
                            entry.lower.y + static_cast<std::int32_t>(y)});
  }
  LODE_CHECK(read_heights(in, entry.n_nodes, context, nodes.heights));
  LODE_CHECK(read_counts(in, entry, nodes.first_made));
  const std::uint64_t n_later = in.read(kCountField + 1);
  const auto later = n_later > entry.n_nodes ? std::vector<std::uint32_t>{}
                                             : read_rising(in, n_later, 0, entry.n_nodes);
  if (later.size() != n_later)
    return fail("expected up to {} rising numbers of nodes, got {} that are not so", entry.n_nodes,
                n_later);
  if (in.is_past_end() || !in.is_at_end())
    return fail("expected {} bytes of nodes to their end, got others", bytes.size());
  nodes.begins_later.resize(entry.n_nodes);
  for (const std::uint32_t i : later) nodes.begins_later[i] = true;
  return nodes;
}

}  // namespace lode::insertions
