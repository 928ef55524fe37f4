// Pages of a hierarchy of midpoints as bits: docs/format.md, section 7.

#include "lode/models/tetra_mt/midpoint/forest_blocks.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lode/models/tetra_mt/midpoint/forest_links.h"
#include "lode/models/tetra_mt/midpoint/forest_records.h"
#include "lode/models/tetra_mt/midpoint/offset_coder.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// Codes a page from first to last; a writer what it is given, and then all it makes is the same.
template <typename Coder>
class PageCoder {
 public:
  PageCoder(Coder& coder, const ForestHead& head, std::uint32_t page, const ForestContent* given,
            const std::string& what, ForestContent& made)
      : coder_(coder),
        head_(head),
        page_(page),
        given_(given),
        what_(what),
        made_(made),
        trees_(coder, head, page, given, what, made) {}

  Result<void> run() {
    LODE_CHECK(trees_.run());
    LODE_CHECK(code_records());
    LODE_CHECK(code_facts());
    LODE_CHECK(code_exact());
    return code_regions();
  }

 private:
  [[nodiscard]] bool is_leaf(std::uint32_t label) const { return head_.is_leaf(label); }

  Result<void> code_records() {
    made_.records.resize(trees_.order().size());
    RecordCoder<Coder> records(coder_, what_);
    for (const std::uint32_t place : trees_.order()) {
      NodeRecord& record = made_.records[place];
      if (given_ != nullptr) record = given_->records[place];
      record.facts = 0;
      const auto [first, second] = made_.children[place];
      LODE_CHECK(records.code(record, (is_leaf(first) ? 1U : 0U) + (is_leaf(second) ? 1U : 0U)));
    }
    return {};
  }

  /// Parents come before children, so that theirs are known where these are in the page.
  Result<void> code_facts() {
    made_.far_facts.resize(made_.records.size());
    if (given_ != nullptr) made_.far_facts = given_->far_facts;
    FactsCoder<Coder> facts(coder_, head_.fields[0].codes, what_);
    for (const std::uint32_t place : trees_.order()) {
      const auto [first, second] = made_.children[place];
      const bool is_known = trees_.is_near(made_.parents[place]);
      LODE_CHECK(facts.code(is_known ? &made_.records[place].facts : nullptr,
                            facts_at(place, 0, first), facts_at(place, 1, second)));
    }
    return {};
  }
  /// Where they are to be, with what is given; none of a leaf.
  [[nodiscard]] std::uint32_t* facts_at(std::uint32_t place, std::size_t end, std::uint32_t child) {
    if (is_leaf(child)) return nullptr;
    if (!trees_.is_near(child)) return &made_.far_facts[place][end];
    const std::uint32_t there = trees_.place_of(child);
    if (given_ != nullptr) made_.records[there].facts = given_->records[there].facts;
    return &made_.records[there].facts;
  }

  Result<void> code_exact() {
    const auto& scales = head_.scales.axes();
    std::array<OffsetCoder<Coder>, 4> axes{{{coder_, scales[0], what_},
                                            {coder_, scales[1], what_},
                                            {coder_, scales[2], what_},
                                            {coder_, head_.fields[0].scale, what_}}};
    const auto code = [&](LeafOffset& offset) -> Result<void> {
      for (std::size_t axis = 0; axis < 4; ++axis) LODE_CHECK(axes[axis].code(offset.axes[axis]));
      return {};
    };
    return code_offsets(coder_, head_.pages, page_, given_ != nullptr ? &given_->exact : nullptr,
                        code, made_.exact);
  }

  Result<void> code_regions() {
    const std::uint32_t n_marks = n_labels_of(head_.region_ids, head_.patches);
    CountModel<5> counts;
    BitModel is_other;
    WideModel numbers;
    std::uint32_t last = 0;
    for (std::uint32_t place = 0; place < made_.records.size(); ++place) {
      std::uint32_t n =
          given_ != nullptr ? static_cast<std::uint32_t>(given_->regions[place].size()) : 0;
      if (n_marks > 1) n = counts.code(coder_, n);
      if (n > kMaxStar) return fail("{}: expected up to {} marks, got {}", what_, kMaxStar, n);
      for (std::uint32_t k = 0; k < n; ++k) {
        const std::uint32_t given = given_ != nullptr ? given_->regions[place][k] : 0;
        if (coder_.bit(is_other, given != last)) {
          const std::uint64_t mark = numbers.code(coder_, given);
          if (mark >= n_marks)
            return fail("{}: expected one of {} regions or patches, got {}", what_, n_marks, mark);
          last = static_cast<std::uint32_t>(mark);
        }
        made_.regions.items.push_back(last);
      }
      made_.regions.end_list();
    }
    return {};
  }

  Coder& coder_;
  const ForestHead& head_;
  std::uint32_t page_;
  const ForestContent* given_;
  const std::string& what_;
  ForestContent& made_;
  TreeCoder<Coder> trees_;
};

/// Codes the counts of pages, one after the other.
template <typename Coder>
class TableCoder {
 public:
  TableCoder(Coder& coder, const std::string& what) : coder_(coder), what_(what) {}

  /// In place.
  Result<void> code(PageCounts& page) {
    page.n_leaves = leaves_.code(coder_, page.n_leaves);
    std::uint32_t n_groups = groups_.code(coder_, static_cast<std::uint32_t>(page.groups.size()));
    if (n_groups < 1 || n_groups > kPageNodes || page.n_leaves > 2 * kPageNodes)
      return fail("{}: expected 1 to {} epochs and up to {} leaves, got {} and {}", what_,
                  kPageNodes, 2 * kPageNodes, n_groups, page.n_leaves);
    page.groups.resize(n_groups);
    std::uint32_t n = 0;
    std::uint32_t epoch = 0;
    for (std::uint32_t g = 0; g < n_groups; ++g) {
      PageCounts::Group& group = page.groups[g];
      if (g == 0) {
        const auto step = static_cast<std::int32_t>(group.epoch - first_epoch_);
        epoch = first_epoch_ + static_cast<std::uint32_t>(unfolded(
                                   static_cast<std::uint32_t>(first_.code(coder_, folded(step)))));
        first_epoch_ = epoch;
      } else {
        epoch += 1 + gaps_.code(coder_, group.epoch - epoch - 1);
      }
      group.epoch = epoch;
      group.n = 1 + counts_[std::min<std::size_t>(g, counts_.size() - 1)].code(coder_, group.n - 1);
      n += group.n;
      if (epoch >= kMaxEpoch || n > kPageNodes)
        return fail("{}: expected epochs below {} and up to {} nodes, got {} and {}", what_,
                    kMaxEpoch, kPageNodes, epoch, n);
    }
    return {};
  }

 private:
  static constexpr std::uint32_t kMaxEpoch = 1U << 30;

  Coder& coder_;
  const std::string& what_;
  NumberModel leaves_;
  CountModel<6> groups_;
  WideModel first_;
  CountModel<2> gaps_;
  std::array<CountModel<6>, 16> counts_;  ///< By group.
  std::uint32_t first_epoch_ = 0;
};

}  // namespace

std::vector<std::byte> encode_page(const ForestContent& content, const ForestHead& head,
                                   std::uint32_t page) {
  RangeWriter out;
  ForestContent made;
  const std::string what = "page";
  const auto done = PageCoder(out, head, page, &content, what, made).run();
  LODE_EXPECTS(done && made == content);
  return std::move(out).take();
}

Result<ForestContent> decode_page(std::span<const std::byte> bytes, const std::string& what,
                                  const ForestHead& head, std::uint32_t page) {
  RangeReader in(bytes);
  ForestContent content;
  LODE_CHECK(PageCoder(in, head, page, nullptr, what, content).run());
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return content;
}

std::vector<std::byte> encode_table(std::span<const PageCounts> pages) {
  RangeWriter out;
  const std::string what = "table";
  TableCoder coder(out, what);
  for (PageCounts page : pages) LODE_EXPECTS(coder.code(page));
  return std::move(out).take();
}

Result<void> decode_table(std::span<const std::byte> bytes, const std::string& what, std::size_t n,
                          std::vector<PageCounts>& pages) {
  RangeReader in(bytes);
  TableCoder coder(in, what);
  for (std::size_t i = 0; i < n; ++i) {
    PageCounts page;
    LODE_CHECK(coder.code(page));
    pages.push_back(std::move(page));
  }
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return {};
}

}  // namespace lode::tetra_mt::midpoint
