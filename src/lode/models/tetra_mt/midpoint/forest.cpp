#include "lode/models/tetra_mt/midpoint/forest.h"

#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/once_slots.h"

namespace lode::tetra_mt::midpoint {
namespace {

Split split_of(const NodeRecord& record, const Children& children,
               const std::array<std::uint32_t, 2>& facts, std::span<const std::uint32_t> regions) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 60) - 1;
  return {children,
          record.difference,
          record.placement(),
          (record.mask[0] | std::uint64_t{record.mask[1]} << 32) & kMask,
          facts,
          regions};
}

}  // namespace

/// Of a field but the first.
struct Forest::FieldPages {
  explicit FieldPages(std::size_t n) : roots(1), slots(n) {}

  OnceSlots<FieldRoots> roots;
  OnceSlots<FieldPage> slots;
};

struct Forest::Pages {
  explicit Pages(std::size_t n) : slots(n) {}
  /// Puts what `load` returns in a slot, unless it is there; none where it cannot be loaded.
  template <typename T, typename LoadOne>
  const T* put(OnceSlots<T>& to, std::size_t at, const LoadOne& load_one) {
    const std::lock_guard lock(mutex);
    if (const T* const there = to.at(at); there != nullptr) return there;
    if (failure) return nullptr;
    auto loaded = load_one();
    if (loaded) return &to.put(at, std::move(*loaded));
    failure = loaded.error();
    return nullptr;
  }

  Load load;
  OnceSlots<ForestPage> slots;
  std::vector<std::unique_ptr<FieldPages>> further;           ///< By field but the first.
  std::vector<std::unique_ptr<OnceSlots<WorldPage>>> worlds;  ///< By field.
  std::mutex mutex;                                           ///< For what follows, and loading.
  std::optional<Error> failure;
};

Forest::Forest(Hierarchy hierarchy)
    : world_codes_(hierarchy.box.lower, hierarchy.box.upper), pages_(std::make_unique<Pages>(0)) {
  hierarchy.pages = {};
  hierarchy.page_counts = {};
  hierarchy.page_levels = {};
  hierarchy.mesh_vertices = {};
  whole_ = std::make_unique<const Hierarchy>(std::move(hierarchy));
  head_ = whole_.get();
}
Forest::Forest(ForestHead head, Load load)
    : paged_(std::make_unique<const ForestHead>(std::move(head))),
      head_(paged_.get()),
      world_codes_(head_->box.lower, head_->box.upper),
      pages_(std::make_unique<Pages>(head_->pages.n_pages())) {
  pages_->load = std::move(load);
  const std::size_t n = head_->pages.n_pages();
  for (std::size_t f = 0; f < head_->fields.size(); ++f) {
    if (f > 0) pages_->further.push_back(std::make_unique<FieldPages>(n));
    const bool has_world_errors = head_->fields[f].base_world_error.has_value();
    pages_->worlds.push_back(std::make_unique<OnceSlots<WorldPage>>(has_world_errors ? n : 0));
  }
}
Forest::Forest(Forest&&) noexcept = default;
Forest& Forest::operator=(Forest&&) noexcept = default;
Forest::~Forest() = default;

const ForestPage* Forest::page(std::uint32_t number) const {
  const ForestPage* const there = pages_->slots.at(number);
  return there != nullptr ? there : load(number);
}

const ForestPage* Forest::load(std::uint32_t number) const {
  return pages_->put(pages_->slots, number, [&]() -> Result<ForestPage> {
    LODE_TRY(const ForestContent content, pages_->load.nodes(*head_, number));
    return ForestPage(content, head_->pages, number, head_->n_vertices);
  });
}

const FieldPage* Forest::page(std::size_t field, std::uint32_t number) const {
  FieldPages& pages = *pages_->further[field - 1];
  if (const FieldPage* const there = pages.slots.at(number); there != nullptr) return there;
  const ForestPage* const nodes = page(number);
  if (nodes == nullptr) return nullptr;
  return pages_->put(pages.slots, number,
                     [&] { return pages_->load.field(*head_, field, number, *nodes); });
}

const FieldRoots* Forest::roots(std::size_t field) const {
  if (whole_) return &whole_->further[field - 1].roots;
  FieldPages& pages = *pages_->further[field - 1];
  if (const FieldRoots* const there = pages.roots.at(0); there != nullptr) return there;
  return pages_->put(pages.roots, 0, [&] { return pages_->load.roots(*head_, field); });
}

Split Forest::split(std::uint32_t node, std::size_t field) const {
  if (whole_) {
    const Children children = whole_->children(node);
    const auto facts_of = [&](std::uint32_t child) {
      return head_->is_leaf(child) ? 0 : whole_->facts(child - head_->n_vertices, field);
    };
    Split made =
        split_of(whole_->nodes[node], children,
                 {facts_of(children.first), facts_of(children.second)}, whole_->regions_of(node));
    made.difference = whole_->difference(node, field);
    made.placement = whole_->placement(node, field);
    return made;
  }
  const PageTable::Location at = head_->pages.locate(node);
  const ForestPage* const there = page(at.page);
  if (there == nullptr) return {};
  Split made = split_of(there->record(at.place), there->children(at.place),
                        there->child_facts(at.place), there->regions(at.place));
  if (field == 0) return made;
  const FieldPage* const values = page(field, at.page);
  if (values == nullptr) return {};
  const FieldPage::Node& own = values->nodes[at.place];
  made.difference[3] = own.difference;
  made.placement.value = own.place;
  for (std::size_t end = 0; end < 2; ++end)
    made.child_facts[end] = NodeCodes::with_ball_of(own.child_facts[end], made.child_facts[end]);
  return made;
}

Children Forest::children(std::uint32_t node) const {
  if (whole_) return whole_->children(node);
  const PageTable::Location at = head_->pages.locate(node);
  const ForestPage* const there = page(at.page);
  return there != nullptr ? there->children(at.place) : Children{};
}

std::uint32_t Forest::parent(std::uint32_t node) const {
  if (whole_) return whole_->parent(head_->n_vertices + node);
  const PageTable::Location at = head_->pages.locate(node);
  const ForestPage* const there = page(at.page);
  return there != nullptr ? there->parent(at.place) : kNone;
}

std::uint32_t Forest::facts(std::uint32_t node, std::size_t field) const {
  if (whole_) return whole_->facts(node, field);
  const std::uint32_t label = head_->n_vertices + node;
  const std::uint32_t above = parent(node);
  if (above == kNone) {
    const std::size_t root = head_->place_of_root(label);
    const bool is_root = root < head_->roots.size() && head_->roots[root] == label;
    return is_root ? root_word(root, field) : 0;
  }
  const Split parted = split(above - head_->n_vertices, field);
  return parted.child_facts[parted.children.first == label ? 0 : 1];
}

float Forest::world_error(std::uint32_t node, std::size_t field) const {
  if (!head_->fields[field].base_world_error) return world_codes_.error(WorldCodes::kInfinite);
  if (whole_) return world_codes_.error(whole_->world_codes[field][node]);
  const PageTable::Location at = head_->pages.locate(node);
  OnceSlots<WorldPage>& slots = *pages_->worlds[field];
  const WorldPage* there = slots.at(at.page);
  if (there == nullptr)
    there = pages_->put(slots, at.page,
                        [&] { return pages_->load.world_errors(*head_, field, at.page); });
  return world_codes_.error(there != nullptr ? (*there)[at.place] : WorldCodes::kInfinite);
}

Code Forest::root_code(std::size_t place, std::size_t field) const {
  Code made = head_->root_codes[place];
  if (field == 0) return made;
  const FieldRoots* const values = roots(field);
  made[3] = values != nullptr ? values->codes[place] : 0;
  return made;
}

std::uint32_t Forest::root_word(std::size_t place, std::size_t field) const {
  const std::uint32_t first = head_->root_facts[place];
  if (field == 0) return first;
  const FieldRoots* const values = roots(field);
  return NodeCodes::with_ball_of(values != nullptr ? values->facts[place] : 0, first);
}

Code Forest::code_of(std::uint32_t node, std::size_t field) const {
  if (whole_) return whole_->code_of(head_->n_vertices + node, field);
  std::vector<std::uint32_t> path{head_->n_vertices + node};
  for (std::uint32_t at = parent(node); at != kNone; at = parent(at - head_->n_vertices))
    path.push_back(at);
  const std::size_t root = head_->place_of_root(path.back());
  if (root == head_->roots.size() || head_->roots[root] != path.back()) return {};
  Code code = root_code(root, field);
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    const Split above = split(path[i] - head_->n_vertices, field);
    const Ends ends = parted(code, above.difference, above.placement);
    code = path[i - 1] == above.children.first ? ends.first : ends.second;
  }
  return code;
}

const LeafOffset* Forest::find_exact(std::uint32_t leaf) const {
  if (whole_) return whole_->exact.find(leaf);
  if (leaf < head_->n_base_leaves) return head_->base_exact.find(leaf);
  const ForestPage* const there = page(head_->pages.page_of_leaf(leaf));
  return there != nullptr ? there->find_exact(leaf) : nullptr;
}

const double* Forest::find_exact(std::uint32_t leaf, std::size_t field) const {
  if (whole_) return whole_->further[field - 1].exact.find(leaf);
  if (leaf < head_->n_base_leaves) {
    const FieldRoots* const values = roots(field);
    return values != nullptr ? values->exact.find(leaf) : nullptr;
  }
  const FieldPage* const there = page(field, head_->pages.page_of_leaf(leaf));
  return there != nullptr ? there->exact.find(leaf) : nullptr;
}

Vec3d Forest::position(std::uint32_t label, const Code& code) const {
  const LeafOffset* const offset = head_->is_leaf(label) ? find_exact(label) : nullptr;
  const Vec3d coded = head_->scales.position(code);
  return offset != nullptr ? offset->position(coded) : coded;
}

double Forest::value(std::uint32_t label, const Code& code, std::size_t field) const {
  const double coded = head_->fields[field].scale.value(code[3]);
  if (!head_->is_leaf(label)) return coded;
  if (field > 0) {
    const double* const offset = find_exact(label, field);
    return offset != nullptr ? with_offset(coded, *offset) : coded;
  }
  const LeafOffset* const offset = find_exact(label);
  return offset != nullptr ? offset->value(coded) : coded;
}

Result<void> Forest::check() const {
  const std::lock_guard lock(pages_->mutex);
  if (pages_->failure) return *pages_->failure;
  return {};
}

std::size_t Forest::n_node_bytes() const {
  if (whole_) {
    std::size_t n = (whole_->wide.size() + whole_->deep.size()) * sizeof(std::uint32_t) +
                    whole_->nodes.size() * sizeof(NodeRecord);
    for (const FurtherField& field : whole_->further) n += field.nodes.size() * sizeof(FieldRecord);
    return n;
  }
  std::size_t n = head_->pages.n_bytes();
  for (std::size_t i = 0; i < pages_->slots.size(); ++i) {
    if (const ForestPage* const there = pages_->slots.at(i); there != nullptr)
      n += there->n_bytes();
    for (const auto& field : pages_->further)
      if (const FieldPage* const there = field->slots.at(i); there != nullptr)
        n += there->nodes.size() * sizeof(FieldPage::Node) + there->exact.n_bytes();
  }
  return n;
}

std::uint32_t Forest::n_pages_loaded() const { return n_pages_loaded(0); }

std::uint32_t Forest::n_pages_loaded(std::size_t field) const {
  if (whole_) return 0;
  return static_cast<std::uint32_t>(field == 0 ? pages_->slots.n_there()
                                               : pages_->further[field - 1]->slots.n_there());
}

}  // namespace lode::tetra_mt::midpoint
