#include "lode/models/tetra_mt/page_source.h"

#include <algorithm>
#include <utility>

#include "lode/models/tetra_mt/base_blocks.h"
#include "lode/models/tetra_mt/byte_streams.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt {
namespace {

Result<ValueScale> read_scale(StreamReader& in, const HierarchyHead::Field& field) {
  LODE_TRY(const auto numbers, read_numbers(in, ValueScale::kKnots, 1, false));
  ValueScale::Knots knots;
  std::ranges::copy(numbers, knots.begin());
  if (!std::ranges::is_sorted(knots) || knots.front() != field.low || knots.back() != field.high)
    return fail("{}: expected knots that ascend from {} to {}, got {} to {}", in.what(), field.low,
                field.high, knots.front(), knots.back());
  return ValueScale(knots);
}

}  // namespace

PageSource::PageSource(std::shared_ptr<const store::Reader> reader, const HierarchyHead& head)
    : reader_(std::move(reader)),
      shape_(head.shape),
      box_codes_(head.lower, head.upper),
      front_(head.front) {
  for (const HierarchyHead::Field& field : head.fields) {
    fields_.push_back(std::make_unique<OfField>());
    fields_.back()->head = field;
    fields_.back()->head.name.clear();
  }
}

Result<void> PageSource::check() const {
  for (std::uint32_t page = 0; page < shape_.n_pages(); ++page) {
    LODE_CHECK(expect(key_of(Kind::links, page)));
    for (std::uint32_t f = 0; f < fields_.size(); ++f) {
      LODE_CHECK(expect(key_of(Kind::field, page, f)));
      if (fields_[f]->head.base_world_error)
        LODE_CHECK(expect(key_of(Kind::world_errors, page, f)));
    }
  }
  if (is_lean()) return {};
  for (std::uint32_t page = 0; page < shape_.n_vertex_pages(); ++page) {
    LODE_CHECK(expect(key_of(Kind::mesh_vertices, page)));
    for (std::uint32_t f = 0; f < fields_.size(); ++f)
      LODE_CHECK(expect(key_of(Kind::gradients, page, f)));
  }
  return {};
}

Result<PageContent> PageSource::links(std::uint32_t page) const {
  LODE_TRY(const auto* const primers, link_primers());
  LODE_TRY(auto content,
           primers->page(page, [&](LinkModels& models) { return read_links(page, models); }));
  LODE_CHECK(check_front(page, key_of(Kind::links, page), [&](std::size_t i, std::size_t place) {
    return box_codes_.lines(content.positions[i], content.boxes[i]) == front_->boxes[place] &&
           (content.region_masks.empty() || content.region_masks[i] == front_->region_masks[place]);
  }));
  return content;
}

template <typename IsSame>
Result<void> PageSource::check_front(std::uint32_t page, const store::BlockKey& key,
                                     const IsSame& is_same) const {
  const std::uint32_t first = page * kPageNodes;
  const std::vector<std::uint32_t>& nodes = front_->nodes;
  const auto begin = std::ranges::lower_bound(nodes, first) - nodes.begin();
  for (auto k = static_cast<std::size_t>(begin); k < nodes.size() && nodes[k] - first < kPageNodes;
       ++k)
    if (!is_same(std::size_t{nodes[k]} - first, k))
      return fail("{}: node {}: expected what is said of it with the base, got something else",
                  name_of(key), nodes[k]);
  return {};
}

Result<const PageSource::LinkPrimers*> PageSource::link_primers() const {
  return link_primers_->get([&] {
    return LinkPrimers::of(shape_.n_pages(), [&](std::uint32_t page, LinkModels& models) {
      return read_links(page, models);
    });
  });
}

Result<PageContent> PageSource::read_links(std::uint32_t page, LinkModels& models) const {
  const auto key = key_of(Kind::links, page);
  LODE_TRY(const auto bytes, read_block(*reader_, key));
  PageContent content;
  LODE_CHECK(decode_links(bytes, name_of(key), page, shape_, models, content));
  return content;
}

Result<FieldContent> PageSource::field(std::size_t number, std::uint32_t page, const PageTree& tree,
                                       const FieldBase& base) const {
  const ValueScale& scale = base.scale;
  const auto make = [&]() -> Result<FieldPrimers> {
    LODE_TRY(const auto* const of_links, link_primers());
    return FieldPrimers::of(shape_.n_pages(), [&](std::uint32_t primer, FieldModels& models) {
      return read_field(number, primer, PageTree::of(*of_links->find(primer), primer), scale,
                        models);
    });
  };
  LODE_TRY(const auto* const primers, fields_[number]->primers.get(make));
  LODE_TRY(auto content, primers->page(page, [&](FieldModels& models) {
    return read_field(number, page, tree, scale, models);
  }));
  const auto key = key_of(Kind::field, page, static_cast<std::uint32_t>(number));
  LODE_CHECK(check_front(page, key, [&](std::size_t i, std::size_t place) {
    return content.facts[i] == base.front.facts[place];
  }));
  return content;
}

Result<FieldContent> PageSource::read_field(std::size_t number, std::uint32_t page,
                                            const PageTree& tree, const ValueScale& scale,
                                            FieldModels& models) const {
  const auto key = key_of(Kind::field, page, static_cast<std::uint32_t>(number));
  LODE_TRY(const auto bytes, read_block(*reader_, key));
  return decode_field(bytes, name_of(key), scale, tree, fields_[number]->head.has_narrow_values,
                      models);
}

Result<WorldPage> PageSource::world_errors(std::size_t field, std::uint32_t page,
                                           const FieldBase& base) const {
  const auto key = key_of(Kind::world_errors, page, static_cast<std::uint32_t>(field));
  LODE_TRY(const auto bytes, read_block(*reader_, key));
  StreamReader in(bytes, name_of(key));
  LODE_TRY(auto codes, in.read(vertices_of(shape_, page).n));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(check_front(page, key, [&](std::size_t i, std::size_t place) {
    return codes[i] == base.front.world_errors[place];
  }));
  return codes;
}

Result<FieldBase> PageSource::base(std::size_t number, const HierarchyHead& head) const {
  FieldBase base;
  const std::size_t n_base = shape_.n_base_vertices;
  for (std::size_t first = 0; first == 0 || first < n_base; first += kBasePart) {
    const auto key = key_of(Kind::base_field, static_cast<std::uint32_t>(first / kBasePart),
                            static_cast<std::uint32_t>(number));
    LODE_TRY(const auto bytes, read_block(*reader_, key));
    StreamReader in(bytes, name_of(key));
    if (first == 0) {
      LODE_TRY(base.scale, read_scale(in, fields_[number]->head));
    }
    LODE_TRY(const auto values, read_numbers(in, std::min<std::size_t>(kBasePart, n_base - first),
                                             1, fields_[number]->head.has_narrow_values));
    base.values.insert(base.values.end(), values.begin(), values.end());
    LODE_CHECK(in.expect_end());
  }
  const auto key = key_of(Kind::front_facts, 0, static_cast<std::uint32_t>(number));
  LODE_TRY(const auto bytes, read_block(*reader_, key));
  LODE_TRY(base.front,
           decode_front_facts(bytes, name_of(key), front_->nodes, front_base_of(head), base.values,
                              base.scale, fields_[number]->head.base_world_error.has_value()));
  return base;
}

Result<std::vector<std::uint32_t>> PageSource::gradients(std::size_t field,
                                                         std::uint32_t page) const {
  const auto make = [&] {
    return GradientPrimers::of(shape_.n_vertex_pages(),
                               [&](std::uint32_t primer, GradientModels& models) {
                                 return read_gradients(field, primer, models);
                               });
  };
  LODE_TRY(const auto* const primers, fields_[field]->gradients.get(make));
  return primers->page(page,
                       [&](GradientModels& models) { return read_gradients(field, page, models); });
}

Result<std::vector<std::uint32_t>> PageSource::read_gradients(std::size_t field, std::uint32_t page,
                                                              GradientModels& models) const {
  const auto key = key_of(Kind::gradients, page, static_cast<std::uint32_t>(field));
  LODE_TRY(const auto bytes, read_block(*reader_, key));
  return decode_gradients(bytes, vertices_of(shape_, page).n, name_of(key), models);
}

bool PageSource::is_lean() const {
  return std::ranges::none_of(reader_->blocks(), [](const store::BlockEntry& block) {
    const auto kind = static_cast<Kind>(block.key.kind);
    return kind == Kind::mesh_vertices || kind == Kind::gradients;
  });
}

Result<std::vector<std::uint32_t>> PageSource::mesh_vertices() const {
  std::vector<std::uint32_t> numbers(std::size_t{shape_.n_base_vertices} + shape_.n_nodes);
  for (std::uint32_t page = 0; page < shape_.n_vertex_pages(); ++page) {
    const auto key = key_of(Kind::mesh_vertices, page);
    LODE_TRY(const auto bytes, read_block(*reader_, key));
    StreamReader in(bytes, name_of(key));
    const VertexRange range = vertices_of(shape_, page);
    LODE_TRY(const auto found, read_differences_of(in, range.n));
    LODE_CHECK(in.expect_end());
    std::ranges::copy(found, numbers.begin() + range.first);
  }
  // There may be others in the mesh, which no cell has.
  std::vector<std::uint32_t> sorted = numbers;
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end() || (!sorted.empty() && sorted.back() == kNone))
    return fail("{}: expected numbers of vertices, each once, got {} twice or as a number",
                reader_->path(), twice != sorted.end() ? *twice : kNone);
  return numbers;
}

std::string PageSource::name_of(const store::BlockKey& key) const {
  return reader_->path() + ": " + store::describe(key);
}

Result<void> PageSource::expect(const store::BlockKey& key) const {
  if (!reader_->find(key))
    return fail("{}: expected {}, found none", reader_->path(), store::describe(key));
  return {};
}

}  // namespace lode::tetra_mt
