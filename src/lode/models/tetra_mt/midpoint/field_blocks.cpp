// What pages and the base have of further fields, as bits and columns: docs/format.md, section 7.

#include "lode/models/tetra_mt/midpoint/field_blocks.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/midpoint/forest_records.h"
#include "lode/models/tetra_mt/midpoint/offset_coder.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// Codes a field's page, from its last node to the first: ends come after what they are ends of. A
/// writer codes what it is given, and then all it makes is the same.
template <typename Coder>
class FieldPageCoder {
 public:
  FieldPageCoder(Coder& coder, const ForestHead& head, const ForestField& field, std::uint32_t page,
                 const ForestPage& nodes, const FieldPage* given, const std::string& what,
                 FieldPage& made)
      : coder_(coder),
        head_(head),
        field_(field),
        page_(page),
        nodes_(nodes),
        given_(given),
        what_(what),
        made_(made) {}

  Result<void> run() {
    const std::uint32_t n = head_.pages.n_nodes_of(page_);
    made_.nodes.resize(n);
    if (given_ != nullptr) made_.nodes = given_->nodes;
    LODE_CHECK(code_values(n));
    LODE_CHECK(code_facts(n));
    OffsetCoder<Coder> offsets(coder_, field_.scale, what_);
    return code_offsets(
        coder_, head_.pages, page_, given_ != nullptr ? &given_->exact : nullptr,
        [&](double& offset) { return offsets.code(offset); }, made_.exact);
  }

 private:
  /// In view of how far apart the ends are along z.
  Result<void> code_values(std::uint32_t n) {
    std::array<SymbolModel<2>, 4> places;
    StepCoder<Coder> steps(coder_, what_);
    for (std::uint32_t place = n; place-- > 0;) {
      FieldPage::Node& node = made_.nodes[place];
      const NodeRecord& record = nodes_.record(place);
      const auto [first, second] = nodes_.children(place);
      const auto position = static_cast<std::size_t>(record.placement().position);
      LODE_TRY(node.place, code_place(coder_, places[position], node.place, what_));
      const std::int32_t z = record.difference[2];
      const std::uint32_t size =
          z < 0 ? 0U - static_cast<std::uint32_t>(z) : static_cast<std::uint32_t>(z);
      const std::uint32_t n_leaves =
          (head_.is_leaf(first) ? 1U : 0U) + (head_.is_leaf(second) ? 1U : 0U);
      LODE_TRY([[maybe_unused]] const std::uint32_t n_bits,
               steps.code(std::min(static_cast<std::uint32_t>(std::bit_width(size)), 31U) / 4,
                          n_leaves, node.difference));
    }
    return {};
  }

  Result<void> code_facts(std::uint32_t n) {
    std::vector<std::uint32_t> own(n, 0);
    FactsCoder<Coder, 3> facts(coder_, field_.codes, what_);
    for (std::uint32_t place = n; place-- > 0;) {
      const auto [first, second] = nodes_.children(place);
      std::array<std::uint32_t, 2>& of_ends = made_.nodes[place].child_facts;
      const auto at = [&](std::size_t end, std::uint32_t child) {
        return head_.is_leaf(child) ? nullptr : &of_ends[end];
      };
      LODE_CHECK(facts.code(is_near(nodes_.parent(place)) ? &own[place] : nullptr, at(0, first),
                            at(1, second)));
      for (const auto& [child, word] : {std::pair{first, of_ends[0]}, {second, of_ends[1]}})
        if (is_near(child)) own[place_of(child)] = word;
    }
    return {};
  }
  [[nodiscard]] bool is_near(std::uint32_t label) const {
    return label != kNone && !head_.is_leaf(label) &&
           head_.pages.locate(label - head_.n_vertices).page == page_;
  }
  [[nodiscard]] std::uint32_t place_of(std::uint32_t label) const {
    return head_.pages.locate(label - head_.n_vertices).place;
  }

  Coder& coder_;
  const ForestHead& head_;
  const ForestField& field_;
  std::uint32_t page_;
  const ForestPage& nodes_;
  const FieldPage* given_;
  const std::string& what_;
  FieldPage& made_;
};

}  // namespace

std::vector<std::byte> encode_field_page(const FieldPage& content, const ForestHead& head,
                                         const ForestField& field, std::uint32_t page,
                                         const ForestPage& nodes) {
  RangeWriter out;
  FieldPage made;
  const std::string what = "page";
  const auto done = FieldPageCoder(out, head, field, page, nodes, &content, what, made).run();
  LODE_EXPECTS(done && made == content);
  return std::move(out).take();
}

Result<FieldPage> decode_field_page(std::span<const std::byte> bytes, const std::string& what,
                                    const ForestHead& head, const ForestField& field,
                                    std::uint32_t page, const ForestPage& nodes) {
  RangeReader in(bytes);
  FieldPage content;
  LODE_CHECK(FieldPageCoder(in, head, field, page, nodes, nullptr, what, content).run());
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return content;
}

std::vector<std::byte> encode_field_roots(const FieldRoots& roots, const ForestHead& head,
                                          std::size_t first, std::size_t n) {
  StreamWriter out;
  std::vector<std::uint32_t> codes;
  for (const std::int32_t code : std::span(roots.codes).subspan(first, n))
    codes.push_back(static_cast<std::uint32_t>(code));
  write_differences_of(codes, out);
  write_differences_of(std::span(roots.facts).subspan(first, n), out);
  std::vector<std::uint8_t> is_off;
  std::vector<double> offsets;
  for (const std::uint32_t root : std::span(head.roots).subspan(first, n)) {
    const double* const offset = roots.exact.find(root);
    is_off.push_back(offset != nullptr ? 1 : 0);
    if (offset != nullptr) offsets.push_back(*offset);
  }
  out.add(is_off);
  write_numbers(offsets, 1, false, out);
  return std::move(out).take();
}

Result<std::vector<std::int32_t>> read_codes_of(StreamReader& in, std::size_t n) {
  LODE_TRY(const auto column, read_differences_of(in, n));
  std::vector<std::int32_t> codes;
  for (const std::uint32_t code : column) {
    if (code > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max()))
      return fail("{}: expected codes of 31 bits, got {}", in.what(), code);
    codes.push_back(static_cast<std::int32_t>(code));
  }
  return codes;
}

Result<std::vector<std::uint32_t>> read_facts_of(StreamReader& in, std::size_t n,
                                                 const NodeCodes& codes) {
  LODE_TRY(auto facts, read_differences_of(in, n));
  for (const std::uint32_t word : facts) {
    const NodeCodes::Parts parts = NodeCodes::parts(word);
    if (!codes.has_range(parts))
      return fail("{}: expected ranges, got {} to {}", in.what(), parts.low, parts.high);
  }
  return facts;
}

Result<void> read_field_roots(StreamReader& in, std::size_t n, const ForestHead& head,
                              const ForestField& field, FieldRoots& roots) {
  const std::size_t first = roots.codes.size();
  LODE_TRY(const auto codes, read_codes_of(in, n));
  LODE_TRY(const auto facts, read_facts_of(in, n, field.codes));
  for (const std::uint32_t word : facts)
    if (word != NodeCodes::without_ball(word))
      return fail("{}: expected facts of a field alone, got {}", in.what(), word);
  roots.codes.insert(roots.codes.end(), codes.begin(), codes.end());
  roots.facts.insert(roots.facts.end(), facts.begin(), facts.end());
  LODE_TRY(const auto is_off, in.read(n));
  const auto n_off = static_cast<std::size_t>(
      std::ranges::count_if(is_off, [](std::uint8_t is) { return is != 0; }));
  LODE_TRY(const auto numbers, read_numbers(in, n_off, 1, false));
  std::size_t next = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (is_off[i] == 0) continue;
    if (is_off[i] > 1 || first + i >= head.n_base_leaves)
      return fail("{}: expected offsets of {} leaves, got {} of root {}", in.what(),
                  head.n_base_leaves, is_off[i], first + i);
    LODE_CHECK(check_offset(numbers[next], field.scale, in.what()));
    roots.exact.add(static_cast<std::uint32_t>(first + i), numbers[next++]);
  }
  return {};
}

}  // namespace lode::tetra_mt::midpoint
