#include "lode/models/terrain/insertions/history_file.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "lode/models/terrain/insertions/file_head.h"
#include "lode/models/terrain/insertions/file_layout.h"
#include "lode/store/bytes.h"

namespace lode::insertions {
namespace {

using terrain_file::read_column;

bool is_upper_half(std::uint32_t number) {
  return number >> 16 == 0 && to_error(static_cast<std::uint16_t>(number)) >= 0;
}

/// The bytes of a block of a page.
Result<std::vector<std::byte>> read_page(const store::Reader& reader, Column column,
                                         std::uint32_t page) {
  const store::BlockKey key = key_of(column, page);
  const auto at = reader.find(key);
  if (!at) return fail("{}: expected {}, found none", reader.path(), store::describe(key));
  return reader.read_block(*at);
}

}  // namespace

Result<HistoryFile> HistoryFile::open(const std::string& path) {
  LODE_TRY(store::Reader reader, store::Reader::open(path));
  HistoryFile file(std::move(reader));
  LODE_TRY(FileHead head, read_head(*file.reader_, file.head_));
  file.type_ = head.type;
  file.n_triangles_ = head.n_triangles;
  file.bands_ = std::move(head.bands);
  LODE_CHECK(read_base(*file.reader_, head, file.head_.history));
  LODE_CHECK(file.read_steps(head.n_steps));
  LODE_CHECK(file.read_index());
  return file;
}

Result<void> HistoryFile::read_steps(std::uint32_t n) {
  constexpr std::uint32_t kMostSteps = (1U << 16) + 1;
  if (n < 1 || n > kMostSteps)
    return fail("{}: metadata: expected 1 to {} steps, got {}", path(), kMostSteps, n);
  LODE_TRY(const auto numbers,
           read_column<std::uint32_t>(*reader_, key_of(Column::steps), 4 * std::uint64_t{n}));
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t error = numbers[i];
    const std::uint32_t largest = numbers[3 * n + i];
    const std::uint32_t time = numbers[n + i];
    const bool is_last = i + 1 == n;
    const bool follows =
        i == 0 || (time > numbers[n + i - 1] && (is_last || error < numbers[i - 1]));
    if (!follows || !is_upper_half(error) || !is_upper_half(largest) ||
        (is_last ? time != n_nodes() : time >= n_nodes()) || numbers[2 * n + i] < 1 ||
        numbers[2 * n + i] > n_triangles_)
      return fail(
          "{}: expected steps of ever finer errors and later times, the last after {} nodes, got "
          "number {} at {} of {} triangles, {:#x} and {:#x}",
          path(), n_nodes(), i, time, numbers[2 * n + i], error, largest);
    steps_.push_back({to_error(static_cast<std::uint16_t>(error)), time, numbers[2 * n + i],
                      to_error(static_cast<std::uint16_t>(largest))});
  }
  return {};
}

Result<void> HistoryFile::read_index() {
  const std::uint64_t n = bands_.empty() ? 0 : bands_.back().first_page + bands_.back().n_pages;
  LODE_TRY(const auto boxes, read_column<std::int32_t>(*reader_, key_of(Column::boxes), 4 * n));
  LODE_TRY(const auto counts, read_column<std::uint32_t>(*reader_, key_of(Column::counts), 2 * n));
  pages_.reserve(n);
  for (std::uint64_t i = 0; i < n; ++i)
    pages_.push_back(
        {{boxes[i], boxes[n + i]}, {boxes[2 * n + i], boxes[3 * n + i]}, counts[i], counts[n + i]});
  LODE_CHECK(check_pages());
  for (const Band& band : bands_) {
    std::vector<LatticeBox> of_band;
    for (std::uint32_t page = band.first_page; page < band.first_page + band.n_pages; ++page)
      of_band.push_back({pages_[page].lower, pages_[page].upper});
    boxes_.emplace_back(std::move(of_band));
  }
  return {};
}

Result<void> HistoryFile::check_pages() const {
  const HeightFrame& frame = base().frame;
  std::uint64_t n_made = base().n_base_triangles();
  for (const Band& band : bands_) {
    std::uint64_t n_nodes = 0;
    for (std::uint32_t page = band.first_page; page < band.first_page + band.n_pages; ++page) {
      const auto& [lower, upper, n, n_triangles] = pages_[page];
      if (lower.x < 0 || lower.y < 0 || upper.x >= frame.n_columns || upper.y >= frame.n_rows ||
          lower.x > upper.x || lower.y > upper.y)
        return fail("{}: expected page {} in {} x {}, got columns {} to {}, rows {} to {}", path(),
                    page, frame.n_columns, frame.n_rows, lower.x, upper.x, lower.y, upper.y);
      if (n < 1 || n > kMostPageNodes || n_triangles < n || n_triangles > kMostPageTriangles)
        return fail(
            "{}: expected page {} of 1 to {} nodes that make {} triangles or fewer, got {} and {}",
            path(), page, kMostPageNodes, kMostPageTriangles, n, n_triangles);
      n_nodes += n;
      n_made += n_triangles;
    }
    if (n_nodes != band.end - band.begin)
      return fail("{}: expected pages of the {} nodes from {} on, got {}", path(),
                  band.end - band.begin, band.begin, n_nodes);
  }
  if (n_made != n_triangles_)
    return fail("{}: expected pages of {} triangles in all, got {}", path(), n_triangles_, n_made);
  return {};
}

std::size_t HistoryFile::band_of_page(std::uint32_t page) const {
  const auto after = std::ranges::upper_bound(bands_, page, {}, &Band::first_page);
  return static_cast<std::size_t>(after - bands_.begin()) - 1;
}

std::size_t HistoryFile::n_bands_before(std::uint32_t time) const {
  const auto first = std::ranges::lower_bound(bands_, time, {}, &Band::end);
  const std::size_t n = static_cast<std::size_t>(first - bands_.begin());
  return time == 0 ? 0 : std::min(n + 1, bands_.size());
}

std::uint64_t HistoryFile::n_history_bytes() const {
  const std::uint64_t n_vertices = std::uint64_t{base().n_base_vertices} + n_nodes();
  const std::uint64_t n_removed = n_triangles_ - steps_.back().n_triangles;
  return n_vertices * (sizeof(delaunay::LatticePoint) + sizeof(double)) +
         std::uint64_t{n_triangles_} * sizeof(Triangle) +
         (2 * (std::uint64_t{n_nodes()} + 1) + n_removed) * sizeof(std::uint32_t);
}

Result<PageNodes> HistoryFile::read_nodes(std::uint32_t page) const {
  LODE_TRY(const auto bytes, read_page(*reader_, Column::nodes, page));
  auto nodes = decode_nodes(bytes, {.entry = pages_[page],
                                    .band = bands_[band_of_page(page)],
                                    .type = type_,
                                    .range = base().range});
  if (!nodes) return fail("{}: page {}: {}", path(), page, nodes.error().message);
  return nodes;
}

Result<std::vector<float>> HistoryFile::read_errors(std::uint32_t page) const {
  LODE_TRY(const auto bytes, read_page(*reader_, Column::made, page));
  store::ByteReader in(bytes, path() + ": " + store::describe(key_of(Column::made, page)));
  LODE_TRY(const auto halves, in.read_all<std::uint16_t>(pages_[page].n_triangles));
  LODE_CHECK(in.expect_end());
  std::vector<float> errors(halves.size());
  for (std::size_t i = 0; i < halves.size(); ++i) {
    errors[i] = to_error(halves[i]);
    if (errors[i] < 0)
      return fail("{}: page {}: expected finite errors >= 0, got the upper half {:#x}", path(),
                  page, halves[i]);
  }
  return errors;
}

}  // namespace lode::insertions
