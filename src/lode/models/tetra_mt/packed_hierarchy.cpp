#include "lode/models/tetra_mt/packed_hierarchy.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "lode/models/tetra_mt/once_slots.h"

namespace lode::tetra_mt {
namespace {

bool is_narrow(double x) { return static_cast<double>(static_cast<float>(x)) == x; }

/// What stands for a page that could not be loaded.
PageContent empty_content() {
  PageContent content;
  content.positions.resize(kPageNodes);
  content.boxes.resize(kPageNodes);
  content.targets.resize(kPageNodes);
  content.n_discovered.resize(kPageNodes);
  content.children.begins.resize(kPageNodes + 1);
  content.parents.begins.resize(kPageNodes + 1);
  content.makers.begins.resize(kPageNodes + 1);
  content.regions.begins.resize(kPageNodes + 1);
  return content;
}

/// Children of a node as pages have them, and by place in the hierarchy's list their new places.
void add_children(const Hierarchy& hierarchy, std::uint32_t node, PageContent& content) {
  const auto children = hierarchy.children_of(node);
  std::array<std::uint8_t, Hierarchy::kReference + std::size_t{1}> places{};
  std::uint8_t n = 0;
  for (const bool is_discovered : {true, false}) {
    for (std::size_t k = 0; k < children.size(); ++k) {
      if ((hierarchy.discoverers[children[k]] == node) != is_discovered) continue;
      places[k] = n++;
      content.children.items.push_back(children[k]);
    }
    if (is_discovered) content.n_discovered.push_back(n);
  }
  places[Hierarchy::kReference] = n;
  content.children.end_list();
  if (n > 0)
    for (const std::uint8_t maker : hierarchy.makers_of(node))
      content.makers.items.push_back(places[maker]);
  content.makers.end_list();
}

}  // namespace

std::uint32_t n_labels_of(std::span<const std::int64_t> region_ids,
                          std::span<const BoundaryPatch> patches) {
  return static_cast<std::uint32_t>(
      std::max({std::size_t{1}, region_ids.size(), patches.empty() ? 0 : patches.size() + 1}));
}

std::uint32_t n_regions_of(std::span<const std::int64_t> region_ids) {
  return static_cast<std::uint32_t>(std::max(std::size_t{1}, region_ids.size()));
}

HierarchyHead head_of(const Hierarchy& hierarchy, std::uint64_t n_cells) {
  HierarchyHead head;
  head.shape = {.n_base_vertices = hierarchy.n_base_vertices,
                .n_nodes = hierarchy.n_nodes(),
                .n_labels = n_labels_of(hierarchy.region_ids, hierarchy.patches),
                .has_narrow_positions = true,
                .n_regions = n_regions_of(hierarchy.region_ids)};
  head.n_cells = n_cells;
  head.n_base_cells = hierarchy.n_base_cells;
  if (!hierarchy.positions.empty()) head.lower = head.upper = hierarchy.positions.front();
  for (const Vec3d& p : hierarchy.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      head.lower[i] = std::min(head.lower[i], p[i]);
      head.upper[i] = std::max(head.upper[i], p[i]);
      head.shape.has_narrow_positions = head.shape.has_narrow_positions && is_narrow(p[i]);
    }
  for (std::size_t f = 0; f < hierarchy.fields.size(); ++f)
    head.fields.push_back(head_of(field_of(hierarchy, f), hierarchy.base_makers));
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node)
    if (hierarchy.parents_of(node).empty()) head.roots.push_back(node);
  head.base_positions.assign(hierarchy.positions.begin(),
                             hierarchy.positions.begin() + hierarchy.n_base_vertices);
  head.base = hierarchy.base;
  head.base_makers = hierarchy.base_makers;
  head.region_ids = hierarchy.region_ids;
  head.region_names = hierarchy.region_names;
  head.patches = hierarchy.patches;
  head.boundary_deviation = hierarchy.boundary_deviation;
  head.record = hierarchy.record;
  head.base_regions = hierarchy.base_regions;
  return head;
}

FrontNodes front_of(const Hierarchy& hierarchy, const HierarchyHead& head) {
  FrontNodes front{.nodes = front_nodes_of(head.base_makers), .boxes = {}, .region_masks = {}};
  const BoxCodes codes(head.lower, head.upper);
  for (const std::uint32_t node : front.nodes) {
    front.boxes.push_back(
        codes.lines(hierarchy.positions[hierarchy.n_base_vertices + node], hierarchy.boxes[node]));
    if (!hierarchy.region_masks.empty()) front.region_masks.push_back(hierarchy.region_masks[node]);
  }
  return front;
}

FrontBase front_base_of(const HierarchyHead& head) {
  return {head.base, head.base_makers, head.base_positions, head.base_regions};
}

PageContent content_of(const Hierarchy& hierarchy, std::uint32_t number) {
  const std::uint32_t first = number * kPageNodes;
  PageContent content;
  for (std::uint32_t node = first; node < hierarchy.n_nodes() && node - first < kPageNodes;
       ++node) {
    content.positions.push_back(hierarchy.positions[hierarchy.n_base_vertices + node]);
    content.boxes.push_back(hierarchy.boxes[node]);
    content.targets.push_back(hierarchy.targets[node]);
    add_children(hierarchy, node, content);
    const auto parents = hierarchy.parents_of(node);
    content.parents.items.insert(content.parents.items.end(), parents.begin(), parents.end());
    content.parents.end_list();
    const auto regions = hierarchy.regions_of(node);
    content.regions.items.insert(content.regions.items.end(), regions.begin(), regions.end());
    content.regions.end_list();
    if (!hierarchy.region_masks.empty())
      content.region_masks.push_back(hierarchy.region_masks[node]);
  }
  return content;
}

NumberedField field_of(const Hierarchy& hierarchy, std::size_t field) {
  const MeshField& from = hierarchy.fields[field];
  NumberedField made{.name = from.name,
                     .type = from.type,
                     .time = hierarchy.time,
                     .values = from.values,
                     .facts = {},
                     .range_reference = hierarchy.range_references[field],
                     .has_errors_everywhere = hierarchy.has_errors_everywhere,
                     .has_world_errors = hierarchy.has_world_errors};
  made.facts.reserve(hierarchy.n_nodes());
  for (std::size_t node = 0; node < hierarchy.n_nodes(); ++node)
    made.facts.push_back(hierarchy.facts[node * hierarchy.fields.size() + field]);
  return made;
}

HierarchyHead::Field head_of(const NumberedField& field,
                             std::span<const std::uint32_t> base_makers) {
  HierarchyHead::Field head{.name = field.name, .type = field.type, .time = field.time};
  head.has_narrow_values = std::ranges::all_of(field.values, is_narrow);
  head.has_errors_everywhere = field.has_errors_everywhere;
  if (!field.values.empty()) {
    const auto [low, high] = std::ranges::minmax(field.values);
    head.low = low;
    head.high = high;
  }
  float world_error = 0;
  for (const std::uint32_t maker : base_makers)
    if (maker != kNone) {
      head.base_error = std::max(head.base_error, static_cast<double>(field.facts[maker].error));
      world_error = std::max(world_error, field.facts[maker].world_error);
    }
  if (field.has_world_errors) head.base_world_error = static_cast<double>(world_error);
  return head;
}

FieldBase base_of(const NumberedField& field, const PageShape& shape) {
  return {ValueScale::of(field.values),
          {field.values.begin(), field.values.begin() + shape.n_base_vertices},
          {}};
}

FrontFacts front_facts_of(const NumberedField& field, const ValueScale& scale,
                          const WorldCodes& codes, std::span<const std::uint32_t> nodes) {
  FrontFacts front;
  for (const std::uint32_t node : nodes) {
    front.facts.push_back(to_codes(field.facts[node], field.range_reference, scale));
    if (field.has_world_errors)
      front.world_errors.push_back(codes.code(field.facts[node].world_error));
  }
  return front;
}

FieldContent content_of(const NumberedField& field, const ValueScale& scale, const PageShape& shape,
                        std::uint32_t number) {
  const VertexRange range = vertices_of(shape, number);
  FieldContent content;
  for (std::uint32_t v = range.first; v - range.first < range.n; ++v) {
    content.values.push_back(field.values[v]);
    content.facts.push_back(
        to_codes(field.facts[v - shape.n_base_vertices], field.range_reference, scale));
  }
  return content;
}

WorldPage world_page_of(const NumberedField& field, const WorldCodes& codes, const PageShape& shape,
                        std::uint32_t number) {
  const VertexRange range = vertices_of(shape, number);
  WorldPage page;
  for (std::uint32_t v = range.first; v - range.first < range.n; ++v)
    page.push_back(codes.code(field.facts[v - shape.n_base_vertices].world_error));
  return page;
}

struct PackedHierarchy::FieldPages {
  FieldPages(std::size_t field, std::size_t n_pages, bool has_world_errors)
      : number(field), pages(n_pages), worlds(has_world_errors ? n_pages : 0) {}

  std::size_t number;
  OnceSlots<FieldBase> base{1};
  OnceSlots<FieldPage> pages;
  OnceSlots<WorldPage> worlds;             ///< None where the field has no world errors.
  std::unique_ptr<const FieldPage> empty;  ///< Instead of what cannot be loaded;
  FieldBase empty_base;                    ///< likewise.
};

struct PackedHierarchy::Pages {
  Load load;
  OnceSlots<NodePage> nodes;
  std::vector<std::unique_ptr<FieldPages>> fields;
  std::unique_ptr<const NodePage> empty;  ///< Instead of what cannot be loaded.
  std::mutex mutex;                       ///< For what follows, and loading.
  std::optional<Error> failure;

  explicit Pages(std::size_t n) : nodes(n) {}

  /// What loading gives, or notes that it failed.
  template <typename LoadOne>
  auto try_load(const LoadOne& load_one) -> std::optional<std::decay_t<decltype(*load_one())>> {
    if (failure) return std::nullopt;
    auto content = load_one();
    if (content) return std::move(*content);
    failure = content.error();
    return std::nullopt;
  }
};

PackedHierarchy::PackedHierarchy(HierarchyHead head, Load load)
    : head_(std::make_unique<const HierarchyHead>(std::move(head))),
      box_codes_(head_->lower, head_->upper),
      world_codes_(head_->lower, head_->upper),
      pages_(std::make_unique<Pages>(head_->shape.n_pages())) {
  pages_->load = std::move(load);
  for (std::size_t f = 0; f < head_->fields.size(); ++f)
    pages_->fields.push_back(std::make_unique<FieldPages>(
        f, head_->shape.n_pages(), head_->fields[f].base_world_error.has_value()));
}
PackedHierarchy::PackedHierarchy(PackedHierarchy&&) noexcept = default;
PackedHierarchy& PackedHierarchy::operator=(PackedHierarchy&&) noexcept = default;
PackedHierarchy::~PackedHierarchy() = default;

PackedHierarchy PackedHierarchy::pack(const Hierarchy& hierarchy, std::uint64_t n_cells,
                                      Threads threads) {
  PackedHierarchy packed(head_of(hierarchy, n_cells), {});
  const PageShape& shape = packed.head().shape;
  parallel_for(shape.n_pages(), threads, 1, [&](std::size_t i, int) {
    const auto number = static_cast<std::uint32_t>(i);
    packed.pages_->nodes.put(i, NodePage(content_of(hierarchy, number), number, shape));
  });
  for (const auto& pages : packed.pages_->fields) {
    const NumberedField field = field_of(hierarchy, pages->number);
    const FieldBase& base = pages->base.put(0, tetra_mt::base_of(field, shape));
    const bool is_narrow_field = packed.head().fields[pages->number].has_narrow_values;
    parallel_for(shape.n_pages(), threads, 1, [&](std::size_t i, int) {
      const auto content = content_of(field, base.scale, shape, static_cast<std::uint32_t>(i));
      pages->pages.put(i, FieldPage(content, is_narrow_field));
    });
    parallel_for(pages->worlds.size(), threads, 1, [&](std::size_t i, int) {
      const auto page = static_cast<std::uint32_t>(i);
      pages->worlds.put(i, world_page_of(field, packed.world_codes_, shape, page));
    });
  }
  return packed;
}

const NodePage& PackedHierarchy::page_of(std::uint32_t node) const {
  const NodePage* page = pages_->nodes.at(node / kPageNodes);
  return page != nullptr ? *page : load(node / kPageNodes);
}

const FieldPage& PackedHierarchy::page_of(std::uint32_t node, const FieldPages& field) const {
  const FieldPage* page = field.pages.at(node / kPageNodes);
  return page != nullptr ? *page : load(node / kPageNodes, field.number);
}

const FieldBase& PackedHierarchy::base_of(const FieldPages& field) const {
  const FieldBase* base = field.base.at(0);
  return base != nullptr ? *base : load_base(field.number);
}

void PackedHierarchy::prefetch(std::uint32_t node, std::size_t field) const {
  const NodePage* const page = pages_->nodes.at(node / kPageNodes);
  if (page != nullptr) page->prefetch(node % kPageNodes);
  const FieldPage* const facts = pages_->fields[field]->pages.at(node / kPageNodes);
  if (facts != nullptr) facts->prefetch(node % kPageNodes);
}

const NodePage& PackedHierarchy::load(std::uint32_t number) const {
  const std::lock_guard lock(pages_->mutex);
  if (const NodePage* const page = pages_->nodes.at(number)) return *page;
  const PageShape& shape = head_->shape;
  if (const auto content = pages_->try_load([&] { return pages_->load.links(number); }))
    return pages_->nodes.put(number, NodePage(*content, number, shape));
  if (pages_->empty == nullptr)
    pages_->empty = std::make_unique<const NodePage>(empty_content(), 0, shape);
  return *pages_->empty;
}

PageTree PackedHierarchy::tree_of(std::uint32_t page) const {
  return PageTree::of(page_of(page * kPageNodes), page, vertices_of(head_->shape, page).n);
}

const FieldPage& PackedHierarchy::load(std::uint32_t number, std::size_t field) const {
  FieldPages& pages = *pages_->fields[field];
  // Each of these may load something, too.
  const PageTree tree = tree_of(number);
  const FieldBase& base = base_of(pages);
  const std::lock_guard lock(pages_->mutex);
  if (const FieldPage* const page = pages.pages.at(number)) return *page;
  const bool is_narrow_field = head_->fields[field].has_narrow_values;
  if (const auto content =
          pages_->try_load([&] { return pages_->load.field(field, number, tree, base); }))
    return pages.pages.put(number, FieldPage(*content, is_narrow_field));
  if (pages.empty == nullptr) {
    const FieldContent nothing{std::vector<double>(kPageNodes), std::vector<FactCodes>(kPageNodes)};
    pages.empty = std::make_unique<const FieldPage>(nothing, is_narrow_field);
  }
  return *pages.empty;
}

/// Of a page that cannot be loaded nothing is known.
const WorldPage& PackedHierarchy::load_world(std::uint32_t number, std::size_t field) const {
  static const WorldPage kUnknown(kPageNodes, WorldCodes::kInfinite);
  const FieldBase& base = base_of(*pages_->fields[field]);
  const std::lock_guard lock(pages_->mutex);
  OnceSlots<WorldPage>& worlds = pages_->fields[field]->worlds;
  if (const WorldPage* const page = worlds.at(number)) return *page;
  auto page = pages_->try_load([&] { return pages_->load.world_errors(field, number, base); });
  return page ? worlds.put(number, std::move(*page)) : kUnknown;
}

const FieldBase& PackedHierarchy::load_base(std::size_t field) const {
  const std::lock_guard lock(pages_->mutex);
  FieldPages& pages = *pages_->fields[field];
  if (const FieldBase* const base = pages.base.at(0)) return *base;
  if (auto base = pages_->try_load([&] { return pages_->load.base(field, *head_); }))
    return pages.base.put(0, std::move(*base));
  pages.empty_base.values.resize(head_->shape.n_base_vertices);
  return pages.empty_base;
}

Result<void> PackedHierarchy::check() const {
  const std::lock_guard lock(pages_->mutex);
  if (pages_->failure) return *pages_->failure;
  return {};
}

Vec3d PackedHierarchy::position(std::uint32_t vertex) const {
  const std::uint32_t n_base = head_->shape.n_base_vertices;
  if (vertex < n_base) return head_->base_positions[vertex];
  return page_of(vertex - n_base).position((vertex - n_base) % kPageNodes);
}

double PackedHierarchy::value(std::uint32_t vertex, std::size_t field) const {
  const FieldPages& pages = *pages_->fields[field];
  const std::uint32_t n_base = head_->shape.n_base_vertices;
  if (vertex < n_base) return base_of(pages).values[vertex];
  return page_of(vertex - n_base, pages).value((vertex - n_base) % kPageNodes);
}

StoredFacts PackedHierarchy::facts(std::uint32_t node, std::size_t field) const {
  const FieldPages& pages = *pages_->fields[field];
  const FieldBase& base = base_of(pages);
  const FieldPage* page = pages.pages.at(node / kPageNodes);
  if (page == nullptr) {
    const auto place = front_place(node);
    if (place && *place < base.front.facts.size())
      return to_facts(base.front.facts[*place], base.scale);
    page = &load(node / kPageNodes, field);
  }
  return to_facts(page->facts(node % kPageNodes), base.scale);
}

float PackedHierarchy::world_error(std::uint32_t node, std::size_t field) const {
  const OnceSlots<WorldPage>& worlds = pages_->fields[field]->worlds;
  if (worlds.size() == 0) return std::numeric_limits<float>::infinity();
  const std::uint32_t number = node / kPageNodes;
  const WorldPage* page = worlds.at(number);
  if (page == nullptr) {
    const WorldPage& front = base_of(*pages_->fields[field]).front.world_errors;
    const auto place = front_place(node);
    if (place && *place < front.size()) return world_codes_.error(front[*place]);
    page = &load_world(number, field);
  }
  return world_codes_.error((*page)[node % kPageNodes]);
}

bool PackedHierarchy::has_facts(std::uint32_t node, std::size_t field) const {
  const FieldPages& pages = *pages_->fields[field];
  if (pages.pages.at(node / kPageNodes) != nullptr) return true;
  const auto place = front_place(node);
  return place && *place < base_of(pages).front.facts.size();
}

Bounds PackedHierarchy::bounds(std::uint32_t node) const {
  const NodePage* page = pages_->nodes.at(node / kPageNodes);
  const auto place = page == nullptr ? front_place(node) : std::nullopt;
  if (page == nullptr && !place) page = &load(node / kPageNodes);
  const Box3d box =
      place ? box_codes_.box(head_->front->boxes[*place])
            : box_codes_.box(page->position(node % kPageNodes), page->box(node % kPageNodes));
  return {(box.lower + box.upper) * 0.5, 0, (box.upper - box.lower) * 0.5};
}

std::uint64_t PackedHierarchy::region_mask(std::uint32_t node) const {
  const NodePage* page = pages_->nodes.at(node / kPageNodes);
  if (page == nullptr) {
    const auto place = front_place(node);
    if (place && head_->front->region_masks.empty()) return kAllRegions;
    if (place) return head_->front->region_masks[*place];
    page = &load(node / kPageNodes);
  }
  return page->region_mask(node % kPageNodes);
}

std::size_t PackedHierarchy::n_page_bytes() const {
  std::size_t n = 0;
  const auto add = [&](const auto& slots) {
    for (std::size_t i = 0; i < slots.size(); ++i)
      if (const auto* const page = slots.at(i)) n += page->n_bytes() + sizeof(void*);
  };
  add(pages_->nodes);
  for (const auto& field : pages_->fields) {
    add(field->pages);
    for (std::size_t i = 0; i < field->worlds.size(); ++i)
      if (const WorldPage* const page = field->worlds.at(i))
        n += sizeof(WorldPage) + page->size() + sizeof(void*);
  }
  return n;
}

std::uint32_t PackedHierarchy::n_pages_loaded() const {
  return static_cast<std::uint32_t>(pages_->nodes.n_there());
}

std::uint32_t PackedHierarchy::n_field_pages_loaded(std::size_t field) const {
  return static_cast<std::uint32_t>(pages_->fields[field]->pages.n_there());
}

}  // namespace lode::tetra_mt
