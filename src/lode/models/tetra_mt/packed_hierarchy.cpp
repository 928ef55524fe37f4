#include "lode/models/tetra_mt/packed_hierarchy.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <utility>

namespace lode::tetra_mt {
namespace {

bool is_narrow(double x) { return static_cast<double>(static_cast<float>(x)) == x; }

/// What stands for a page that could not be loaded.
PageContent empty_content(const PageShape& shape) {
  PageContent content;
  content.positions.resize(kPageNodes);
  content.values.resize(std::size_t{kPageNodes} * shape.n_fields);
  content.facts.resize(std::size_t{kPageNodes} * shape.n_fields);
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

HierarchyHead head_of(const Hierarchy& hierarchy, std::uint64_t n_cells) {
  HierarchyHead head;
  head.shape = {.n_base_vertices = hierarchy.n_base_vertices,
                .n_nodes = hierarchy.n_nodes(),
                .n_fields = static_cast<std::uint32_t>(hierarchy.fields.size()),
                .n_regions = std::max(1U, static_cast<std::uint32_t>(hierarchy.region_ids.size())),
                .has_narrow_positions = true,
                .has_narrow_values = true};
  head.n_cells = n_cells;
  head.n_base_cells = hierarchy.n_base_cells;
  if (!hierarchy.positions.empty()) head.lower = head.upper = hierarchy.positions.front();
  for (const Vec3d& p : hierarchy.positions)
    for (std::size_t i = 0; i < 3; ++i) {
      head.lower[i] = std::min(head.lower[i], p[i]);
      head.upper[i] = std::max(head.upper[i], p[i]);
      head.shape.has_narrow_positions = head.shape.has_narrow_positions && is_narrow(p[i]);
    }
  for (std::size_t f = 0; f < hierarchy.fields.size(); ++f) {
    const MeshField& field = hierarchy.fields[f];
    head.fields.push_back({field.name, field.type, ValueScale::of(field.values)});
    for (const std::uint32_t maker : hierarchy.base_makers)
      if (maker != kNone)
        head.fields[f].base_error = std::max(
            head.fields[f].base_error,
            static_cast<double>(hierarchy.facts[maker * hierarchy.fields.size() + f].error));
    head.shape.has_narrow_values =
        head.shape.has_narrow_values && std::ranges::all_of(field.values, is_narrow);
  }
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node)
    if (hierarchy.parents_of(node).empty()) head.roots.push_back(node);
  for (std::uint32_t v = 0; v < hierarchy.n_base_vertices; ++v) {
    head.base_positions.push_back(hierarchy.positions[v]);
    for (const MeshField& field : hierarchy.fields) head.base_values.push_back(field.values[v]);
  }
  head.base = hierarchy.base;
  head.base_makers = hierarchy.base_makers;
  head.region_ids = hierarchy.region_ids;
  head.boundary_deviation = hierarchy.boundary_deviation;
  head.base_regions = hierarchy.base_regions;
  return head;
}

PageContent content_of(const Hierarchy& hierarchy, const HierarchyHead& head,
                       std::uint32_t number) {
  const std::size_t n_fields = hierarchy.fields.size();
  const std::uint32_t first = number * kPageNodes;
  PageContent content;
  for (std::uint32_t node = first; node < hierarchy.n_nodes() && node - first < kPageNodes;
       ++node) {
    const std::uint32_t vertex = hierarchy.n_base_vertices + node;
    content.positions.push_back(hierarchy.positions[vertex]);
    for (std::size_t f = 0; f < n_fields; ++f) {
      content.values.push_back(hierarchy.fields[f].values[vertex]);
      content.facts.push_back(to_codes(hierarchy.facts[node * n_fields + f],
                                       hierarchy.range_references[f], head.fields[f].scale));
    }
    content.boxes.push_back(hierarchy.boxes[node]);
    content.targets.push_back(hierarchy.targets[node]);
    add_children(hierarchy, node, content);
    const auto parents = hierarchy.parents_of(node);
    content.parents.items.insert(content.parents.items.end(), parents.begin(), parents.end());
    content.parents.end_list();
    const auto regions = hierarchy.regions_of(node);
    content.regions.items.insert(content.regions.items.end(), regions.begin(), regions.end());
    content.regions.end_list();
  }
  return content;
}

struct PackedHierarchy::Pages {
  Load load;
  std::vector<std::atomic<const NodePage*>> loaded;
  std::vector<std::unique_ptr<const NodePage>> owned;
  std::unique_ptr<const NodePage> empty;  ///< Instead of what cannot be loaded.
  std::mutex mutex;                       ///< For what follows, and loading.
  std::optional<Error> failure;
  std::atomic<std::uint32_t> n_loaded{0};

  explicit Pages(std::uint32_t n) : loaded(n), owned(n) {}
  void put(std::uint32_t number, std::unique_ptr<const NodePage> page) {
    owned[number] = std::move(page);
    loaded[number].store(owned[number].get(), std::memory_order_release);
    ++n_loaded;
  }
};

PackedHierarchy::PackedHierarchy(HierarchyHead head, Load load)
    : head_(std::make_unique<const HierarchyHead>(std::move(head))),
      box_codes_(head_->lower, head_->upper),
      pages_(std::make_unique<Pages>(head_->shape.n_pages())) {
  pages_->load = std::move(load);
}
PackedHierarchy::PackedHierarchy(PackedHierarchy&&) noexcept = default;
PackedHierarchy& PackedHierarchy::operator=(PackedHierarchy&&) noexcept = default;
PackedHierarchy::~PackedHierarchy() = default;

PackedHierarchy PackedHierarchy::pack(const Hierarchy& hierarchy, std::uint64_t n_cells,
                                      Threads threads) {
  PackedHierarchy packed(head_of(hierarchy, n_cells), {});
  parallel_for(packed.head().shape.n_pages(), threads, 1, [&](std::size_t i, int) {
    const auto number = static_cast<std::uint32_t>(i);
    packed.pages_->put(
        number, std::make_unique<const NodePage>(content_of(hierarchy, packed.head(), number),
                                                 number, packed.head().shape));
  });
  return packed;
}

const NodePage& PackedHierarchy::page_of(std::uint32_t node) const {
  const NodePage* page = pages_->loaded[node / kPageNodes].load(std::memory_order_acquire);
  return page != nullptr ? *page : load(node / kPageNodes);
}

void PackedHierarchy::prefetch(std::uint32_t node) const {
  const NodePage* page = pages_->loaded[node / kPageNodes].load(std::memory_order_acquire);
  if (page != nullptr) page->prefetch(node % kPageNodes);
}

const NodePage& PackedHierarchy::load(std::uint32_t number) const {
  const std::lock_guard lock(pages_->mutex);
  const NodePage* page = pages_->loaded[number].load(std::memory_order_relaxed);
  if (page != nullptr) return *page;
  const PageShape& shape = head_->shape;
  if (!pages_->failure) {
    auto content = pages_->load(number);
    if (content) {
      pages_->put(number, std::make_unique<const NodePage>(*content, number, shape));
      return *pages_->owned[number];
    }
    pages_->failure = content.error();
  }
  if (pages_->empty == nullptr)
    pages_->empty = std::make_unique<const NodePage>(empty_content(shape), 0, shape);
  return *pages_->empty;
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
  const std::uint32_t n_base = head_->shape.n_base_vertices;
  const std::size_t n_fields = head_->shape.n_fields;
  if (vertex < n_base) return head_->base_values[vertex * n_fields + field];
  return page_of(vertex - n_base).value((vertex - n_base) % kPageNodes * n_fields + field);
}

StoredFacts PackedHierarchy::facts(std::uint32_t node, std::size_t field) const {
  return to_facts(page_of(node).facts(node % kPageNodes * head_->shape.n_fields + field),
                  head_->fields[field].scale);
}

Bounds PackedHierarchy::bounds(std::uint32_t node) const {
  const NodePage& page = page_of(node);
  const Box3d box = box_codes_.box(page.position(node % kPageNodes), page.box(node % kPageNodes));
  return {(box.lower + box.upper) * 0.5, 0, (box.upper - box.lower) * 0.5};
}

std::size_t PackedHierarchy::n_page_bytes() const {
  const std::lock_guard lock(pages_->mutex);
  std::size_t n = 0;
  for (const auto& page : pages_->owned)
    if (page != nullptr) n += page->n_bytes() + sizeof(page) + sizeof(pages_->loaded[0]);
  return n;
}

std::uint32_t PackedHierarchy::n_pages_loaded() const { return pages_->n_loaded; }

}  // namespace lode::tetra_mt
