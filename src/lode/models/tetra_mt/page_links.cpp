// How nodes of a page are linked, as columns: docs/format.md, section 7.

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt {
namespace {

constexpr std::uint32_t kOffsetMask = kPageNodes - 1;

/// Pages of nodes, then those of the base's vertices.
class PageNumbers {
 public:
  explicit PageNumbers(const PageShape& shape) : shape_(shape) {}

  [[nodiscard]] std::uint32_t n_pages() const {
    return shape_.n_pages() + n_pages_of(shape_.n_base_vertices);
  }
  [[nodiscard]] bool is_of_nodes(std::uint32_t page) const { return page < shape_.n_pages(); }
  [[nodiscard]] std::uint32_t page_of(std::uint32_t vertex) const {
    const std::uint32_t n_base = shape_.n_base_vertices;
    return vertex < n_base ? shape_.n_pages() + vertex / kPageNodes
                           : (vertex - n_base) / kPageNodes;
  }
  [[nodiscard]] std::uint32_t offset_of(std::uint32_t vertex) const {
    const std::uint32_t n_base = shape_.n_base_vertices;
    return (vertex < n_base ? vertex : vertex - n_base) & kOffsetMask;
  }
  /// kNone where there is none.
  [[nodiscard]] std::uint32_t vertex(std::uint32_t page, std::uint32_t offset) const {
    const std::uint32_t n_base = shape_.n_base_vertices;
    if (is_of_nodes(page)) {
      const std::uint32_t node = page * kPageNodes + offset;
      return node < shape_.n_nodes ? n_base + node : kNone;
    }
    const std::uint32_t base = (page - shape_.n_pages()) * kPageNodes + offset;
    return base < n_base ? base : kNone;
  }

 private:
  const PageShape& shape_;
};

/// What offsets are counted from: along a list that before where it is of the same page, else the
/// node that has the list where it is of its own.
class Counting {
 public:
  explicit Counting(std::uint32_t own) : own_(own) {}

  void start(std::uint32_t i) {
    last_page_ = kNone;
    last_offset_ = i;
  }
  [[nodiscard]] std::uint32_t from(std::uint32_t page) const {
    if (page == last_page_) return last_offset_;
    return page == own_ && last_page_ == kNone ? last_offset_ : 0;
  }
  void note(std::uint32_t page, std::uint32_t offset) {
    last_page_ = page;
    last_offset_ = offset;
  }

 private:
  std::uint32_t own_;
  std::uint32_t last_page_ = kNone;
  std::uint32_t last_offset_ = 0;
};

/// Links of one kind: places of their pages in the table, 0 for the page itself; offsets of those
/// in the page, and of others.
struct LinkColumns {
  std::vector<std::uint16_t> places;
  std::vector<std::uint16_t> own;
  std::vector<std::uint16_t> others;
};

class LinkEncoder {
 public:
  LinkEncoder(const PageContent& content, std::uint32_t number, const PageShape& shape)
      : content_(content), number_(number), shape_(shape), numbers_(shape) {}

  std::vector<std::byte> run() {
    collect();
    make_table();
    StreamWriter out;
    std::vector<double> coordinates;
    for (const Vec3d& p : content_.positions)
      coordinates.insert(coordinates.end(), p.v.begin(), p.v.end());
    write_numbers(coordinates, 3, shape_.has_narrow_positions, out);
    write_boxes(out);
    const std::uint16_t n_pages[]{static_cast<std::uint16_t>(table_.size())};
    out.add_planes(std::span<const std::uint16_t>(n_pages));
    out.add_planes(std::span<const std::uint32_t>(table_));
    write_counts(out);
    for (const Wanted& kind : {targets_, children_, parents_}) write(kind, out);
    out.add(content_.makers.items);
    if (shape_.n_regions > 1) write_regions(out);
    return std::move(out).take();
  }

 private:
  struct Link {
    std::uint32_t i;  ///< The node that has it.
    std::uint32_t vertex;
  };
  using Wanted = std::vector<Link>;

  void collect() {
    for (std::uint32_t i = 0; i < content_.n_nodes(); ++i) {
      targets_.push_back({i, content_.targets[i]});
      for (const std::uint32_t child : content_.children[i])
        children_.push_back({i, shape_.n_base_vertices + child});
      for (const std::uint32_t parent : content_.parents[i])
        if (parent / kPageNodes != number_)
          parents_.push_back({i, shape_.n_base_vertices + parent});
    }
  }
  void make_table() {
    std::map<std::uint32_t, std::uint32_t> n_links;
    for (const Wanted* kind : {&targets_, &children_, &parents_})
      for (const Link& link : *kind) ++n_links[numbers_.page_of(link.vertex)];
    n_links.erase(number_);
    for (const auto& [page, n] : n_links) table_.push_back(page);
    std::ranges::stable_sort(table_, std::ranges::greater(),
                             [&](std::uint32_t page) { return n_links[page]; });
    places_[number_] = 0;
    for (std::size_t i = 0; i < table_.size(); ++i)
      places_[table_[i]] = static_cast<std::uint16_t>(i + 1);
  }
  /// Exponents, then what is below and above along each axis.
  void write_boxes(StreamWriter& out) const {
    std::vector<std::uint8_t> column(content_.n_nodes());
    for (int at = 0, n = BoxCodes::kExponentBits; at < BoxCodes::kBits;
         at += n, n = BoxCodes::kAxisBits) {
      for (std::size_t i = 0; i < column.size(); ++i)
        column[i] = static_cast<std::uint8_t>(content_.boxes[i] >> at & ((1U << n) - 1));
      out.add(column);
    }
  }
  void write_regions(StreamWriter& out) const {
    std::vector<std::uint8_t> counts;
    for (std::size_t i = 0; i < content_.n_nodes(); ++i)
      counts.push_back(static_cast<std::uint8_t>(content_.regions[i].size()));
    out.add(counts);
    out.add_planes(std::span<const std::uint32_t>(content_.regions.items));
  }
  void write_counts(StreamWriter& out) const {
    std::vector<std::uint8_t> n_children;
    std::vector<std::uint8_t> n_parents(content_.n_nodes(), 0);
    std::vector<std::uint8_t> n_makers;
    for (const Link& link : parents_) ++n_parents[link.i];
    for (std::size_t i = 0; i < content_.n_nodes(); ++i) {
      n_children.push_back(static_cast<std::uint8_t>(content_.children[i].size()));
      n_makers.push_back(static_cast<std::uint8_t>(content_.makers[i].size()));
    }
    out.add(n_children);
    out.add(content_.n_discovered);
    out.add(n_parents);
    out.add(n_makers);
  }
  void write(const Wanted& links, StreamWriter& out) const {
    LinkColumns columns;
    Counting counting(number_);
    std::uint32_t last = kNone;
    for (const Link& link : links) {
      if (std::exchange(last, link.i) != link.i) counting.start(link.i);
      const std::uint32_t page = numbers_.page_of(link.vertex);
      const std::uint32_t offset = numbers_.offset_of(link.vertex);
      columns.places.push_back(places_.at(page));
      (page == number_ ? columns.own : columns.others)
          .push_back(static_cast<std::uint16_t>((offset - counting.from(page)) & kOffsetMask));
      counting.note(page, offset);
    }
    for (const auto* column : {&columns.places, &columns.own, &columns.others})
      out.add_planes(std::span<const std::uint16_t>(*column));
  }

  const PageContent& content_;
  std::uint32_t number_;
  const PageShape& shape_;
  PageNumbers numbers_;
  std::vector<std::uint32_t> table_;
  std::map<std::uint32_t, std::uint16_t> places_;
  Wanted targets_;
  Wanted children_;
  Wanted parents_;  ///< Of other pages: the rest follow from children.
};

class LinkDecoder {
 public:
  LinkDecoder(StreamReader& in, std::uint32_t number, const PageShape& shape, PageContent& content)
      : in_(in), number_(number), shape_(shape), numbers_(shape), content_(content) {}

  Result<void> run() {
    const std::size_t n = std::min(kPageNodes, shape_.n_nodes - number_ * kPageNodes);
    LODE_TRY(const auto coordinates, read_numbers(in_, n, 3, shape_.has_narrow_positions));
    for (std::size_t i = 0; i < n; ++i)
      content_.positions.push_back(
          {{coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]}});
    LODE_CHECK(read_boxes(n));
    LODE_CHECK(read_table());
    LODE_TRY(const auto n_children, in_.read(n));
    LODE_TRY(content_.n_discovered, in_.read(n));
    LODE_TRY(const auto n_parents, in_.read(n));
    LODE_TRY(const auto n_makers, in_.read(n));
    for (std::size_t i = 0; i < n; ++i)
      if (std::max({n_children[i], n_parents[i], n_makers[i]}) > kMaxBrought ||
          content_.n_discovered[i] > n_children[i] || (n_makers[i] > 0 && n_children[i] == 0))
        return fail("{}: node {}: expected up to {} links of each kind, got {}, {}, {} and {}",
                    in_.what(), i, kMaxBrought, n_children[i], content_.n_discovered[i],
                    n_parents[i], n_makers[i]);
    LODE_TRY(const auto targets, read_links(std::vector<std::uint8_t>(n, 1), true));
    content_.targets = targets.items;
    LODE_TRY(content_.children, read_links(n_children, false));
    LODE_TRY(const auto parents, read_links(n_parents, false));
    LODE_CHECK(check_children());
    LODE_CHECK(join_parents(parents));
    LODE_CHECK(read_makers(n_makers));
    return read_regions();
  }

 private:
  Result<void> read_table() {
    LODE_TRY(const auto size, in_.read_planes<std::uint16_t>(1));
    LODE_TRY(table_, in_.read_planes<std::uint32_t>(size[0]));
    for (const std::uint32_t page : table_)
      if (page >= numbers_.n_pages() || page == number_)
        return fail("{}: expected numbers of {} pages but {}, got {}", in_.what(),
                    numbers_.n_pages(), number_, page);
    table_.insert(table_.begin(), number_);
    return {};
  }

  Result<void> read_boxes(std::size_t n_nodes) {
    content_.boxes.assign(n_nodes, 0);
    for (int at = 0, n = BoxCodes::kExponentBits; at < BoxCodes::kBits;
         at += n, n = BoxCodes::kAxisBits) {
      LODE_TRY(const auto column, in_.read(n_nodes));
      for (std::size_t i = 0; i < n_nodes; ++i) {
        if (column[i] >> n != 0)
          return fail("{}: node {}: expected parts of a box of {} bits, got {}", in_.what(), i, n,
                      column[i]);
        content_.boxes[i] |= std::uint32_t{column[i]} << at;
      }
    }
    return {};
  }

  /// Vertices, or nodes, by node. `counts`: how many each has.
  Result<Lists<std::uint32_t>> read_links(const std::vector<std::uint8_t>& counts,
                                          bool may_be_base) {
    std::size_t n = 0;
    for (const std::uint8_t count : counts) n += count;
    LODE_TRY(const auto places, in_.read_planes<std::uint16_t>(n));
    const auto n_own = static_cast<std::size_t>(std::ranges::count(places, 0));
    LODE_TRY(const auto own, in_.read_planes<std::uint16_t>(n_own));
    LODE_TRY(const auto others, in_.read_planes<std::uint16_t>(n - n_own));
    Lists<std::uint32_t> lists;
    Counting counting(number_);
    auto next_own = own.begin();
    auto next_other = others.begin();
    auto next_place = places.begin();
    for (std::uint32_t i = 0; i < counts.size(); ++i) {
      counting.start(i);
      for (std::uint32_t k = 0; k < counts[i]; ++k) {
        const std::uint16_t place = *next_place++;
        if (place >= table_.size())
          return fail("{}: node {}: expected places of {} pages, got {}", in_.what(), i,
                      table_.size(), place);
        const std::uint32_t page = table_[place];
        const std::uint32_t difference = place == 0 ? *next_own++ : *next_other++;
        const std::uint32_t offset = (difference + counting.from(page)) & kOffsetMask;
        counting.note(page, offset);
        LODE_TRY(const std::uint32_t vertex, checked_vertex(i, page, offset, may_be_base));
        lists.items.push_back(may_be_base ? vertex : vertex - shape_.n_base_vertices);
      }
      lists.end_list();
    }
    return lists;
  }
  Result<std::uint32_t> checked_vertex(std::uint32_t i, std::uint32_t page, std::uint32_t offset,
                                       bool may_be_base) const {
    const std::uint32_t vertex = numbers_.vertex(page, offset);
    const std::uint32_t self = shape_.n_base_vertices + number_ * kPageNodes + i;
    if (vertex == kNone || vertex == self || (!may_be_base && !numbers_.is_of_nodes(page)))
      return fail("{}: node {}: expected a link to another {}, got page {}, place {}", in_.what(),
                  i, may_be_base ? "vertex" : "node", page, offset);
    return vertex;
  }
  Result<void> check_children() const {
    for (std::uint32_t i = 0; i < content_.n_nodes(); ++i) {
      const auto children = content_.children[i];
      std::vector<std::uint32_t> sorted(children.begin(), children.end());
      std::ranges::sort(sorted);
      if (std::ranges::adjacent_find(sorted) != sorted.end())
        return fail("{}: node {}: expected children that differ", in_.what(), i);
    }
    return {};
  }
  Result<void> join_parents(const Lists<std::uint32_t>& others) {
    const std::uint32_t first = number_ * kPageNodes;
    std::vector<std::vector<std::uint32_t>> parents(content_.n_nodes());
    for (std::uint32_t i = 0; i < content_.n_nodes(); ++i) {
      parents[i].insert(parents[i].end(), others[i].begin(), others[i].end());
      for (const std::uint32_t child : content_.children[i])
        if (child / kPageNodes == number_) parents[child - first].push_back(first + i);
    }
    for (std::uint32_t i = 0; i < content_.n_nodes(); ++i) {
      std::ranges::sort(parents[i]);
      if (std::ranges::adjacent_find(parents[i]) != parents[i].end() ||
          parents[i].size() > kMaxBrought)
        return fail("{}: node {}: expected up to {} parents that differ", in_.what(), i,
                    kMaxBrought);
      content_.parents.items.insert(content_.parents.items.end(), parents[i].begin(),
                                    parents[i].end());
      content_.parents.end_list();
    }
    return {};
  }
  Result<void> read_makers(const std::vector<std::uint8_t>& counts) {
    for (const std::uint8_t count : counts)
      content_.makers.begins.push_back(content_.makers.begins.back() + count);
    LODE_TRY(content_.makers.items, in_.read(content_.makers.begins.back()));
    for (std::uint32_t i = 0; i < content_.n_nodes(); ++i)
      for (const std::uint8_t maker : content_.makers[i])
        if (maker > content_.children[i].size())
          return fail("{}: node {}: expected places of {} children, got {}", in_.what(), i,
                      content_.children[i].size(), maker);
    return {};
  }

  Result<void> read_regions() {
    const std::size_t n = content_.n_nodes();
    content_.regions.begins.assign(n + 1, 0);
    if (shape_.n_regions == 1) return {};
    LODE_TRY(const auto counts, in_.read(n));
    for (std::size_t i = 0; i < n; ++i) {
      if (counts[i] > kMaxBrought)
        return fail("{}: node {}: expected up to {} regions, got {}", in_.what(), i, kMaxBrought,
                    counts[i]);
      content_.regions.begins[i + 1] = content_.regions.begins[i] + counts[i];
    }
    LODE_TRY(content_.regions.items,
             in_.read_planes<std::uint32_t>(content_.regions.begins.back()));
    for (const std::uint32_t region : content_.regions.items)
      if (region >= shape_.n_regions)
        return fail("{}: expected one of {} regions, got {}", in_.what(), shape_.n_regions, region);
    return {};
  }

  StreamReader& in_;
  std::uint32_t number_;
  const PageShape& shape_;
  PageNumbers numbers_;
  PageContent& content_;
  std::vector<std::uint32_t> table_;  ///< With the page itself first.
};

}  // namespace

std::vector<std::byte> encode_links(const PageContent& content, std::uint32_t number,
                                    const PageShape& shape) {
  return LinkEncoder(content, number, shape).run();
}

Result<void> decode_links(std::span<const std::byte> bytes, const std::string& what,
                          std::uint32_t number, const PageShape& shape, PageContent& content) {
  StreamReader in(bytes, what);
  content = {};
  LODE_CHECK(LinkDecoder(in, number, shape, content).run());
  return in.expect_end();
}

}  // namespace lode::tetra_mt
