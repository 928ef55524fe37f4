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

struct Forest::Pages {
  explicit Pages(std::size_t n) : slots(n) {}

  Load load;
  OnceSlots<ForestPage> slots;
  std::mutex mutex;  ///< For what follows, and loading.
  std::optional<Error> failure;
};

Forest::Forest(Hierarchy hierarchy) : pages_(std::make_unique<Pages>(0)) {
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
      pages_(std::make_unique<Pages>(head_->pages.n_pages())) {
  pages_->load = std::move(load);
}
Forest::Forest(Forest&&) noexcept = default;
Forest& Forest::operator=(Forest&&) noexcept = default;
Forest::~Forest() = default;

const ForestPage* Forest::page(std::uint32_t number) const {
  const ForestPage* const there = pages_->slots.at(number);
  return there != nullptr ? there : load(number);
}

const ForestPage* Forest::load(std::uint32_t number) const {
  const std::lock_guard lock(pages_->mutex);
  if (const ForestPage* const there = pages_->slots.at(number); there != nullptr) return there;
  if (pages_->failure) return nullptr;
  const auto content = pages_->load(*head_, number);
  if (!content) {
    pages_->failure = content.error();
    return nullptr;
  }
  return &pages_->slots.put(number, ForestPage(*content, head_->pages, number, head_->n_vertices));
}

Split Forest::split(std::uint32_t node) const {
  if (whole_) {
    const Children children = whole_->children(node);
    const auto facts_of = [&](std::uint32_t child) {
      return head_->is_leaf(child) ? 0 : whole_->nodes[child - head_->n_vertices].facts;
    };
    return split_of(whole_->nodes[node], children,
                    {facts_of(children.first), facts_of(children.second)},
                    whole_->regions_of(node));
  }
  const PageTable::Location at = head_->pages.locate(node);
  const ForestPage* const there = page(at.page);
  if (there == nullptr) return {};
  return split_of(there->record(at.place), there->children(at.place), there->child_facts(at.place),
                  there->regions(at.place));
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

std::uint32_t Forest::facts(std::uint32_t node) const {
  if (whole_) return whole_->nodes[node].facts;
  const std::uint32_t label = head_->n_vertices + node;
  const std::uint32_t above = parent(node);
  if (above == kNone) {
    const std::size_t root = head_->place_of_root(label);
    const bool is_root = root < head_->roots.size() && head_->roots[root] == label;
    return is_root ? head_->root_facts[root] : 0;
  }
  const PageTable::Location at = head_->pages.locate(above - head_->n_vertices);
  const ForestPage* const there = page(at.page);
  if (there == nullptr) return 0;
  return there->child_facts(at.place)[there->children(at.place).first == label ? 0 : 1];
}

Code Forest::code_of(std::uint32_t node) const {
  if (whole_) return whole_->code_of(head_->n_vertices + node);
  std::vector<std::uint32_t> path{head_->n_vertices + node};
  for (std::uint32_t at = parent(node); at != kNone; at = parent(at - head_->n_vertices))
    path.push_back(at);
  const std::size_t root = head_->place_of_root(path.back());
  if (root == head_->roots.size() || head_->roots[root] != path.back()) return {};
  Code code = head_->root_codes[root];
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    const Split above = split(path[i] - head_->n_vertices);
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

Vec3d Forest::position(std::uint32_t label, const Code& code) const {
  const LeafOffset* const offset = head_->is_leaf(label) ? find_exact(label) : nullptr;
  const Vec3d coded = head_->scales.position(code);
  return offset != nullptr ? offset->position(coded) : coded;
}

double Forest::value(std::uint32_t label, const Code& code) const {
  const LeafOffset* const offset = head_->is_leaf(label) ? find_exact(label) : nullptr;
  const double coded = head_->scales.value(code);
  return offset != nullptr ? offset->value(coded) : coded;
}

Result<void> Forest::check() const {
  const std::lock_guard lock(pages_->mutex);
  if (pages_->failure) return *pages_->failure;
  return {};
}

std::size_t Forest::n_node_bytes() const {
  if (whole_)
    return (whole_->wide.size() + whole_->deep.size()) * sizeof(std::uint32_t) +
           whole_->nodes.size() * sizeof(NodeRecord);
  std::size_t n = head_->pages.n_bytes();
  for (std::size_t i = 0; i < pages_->slots.size(); ++i)
    if (const ForestPage* const there = pages_->slots.at(i); there != nullptr)
      n += there->n_bytes();
  return n;
}

std::uint32_t Forest::n_pages_loaded() const {
  return static_cast<std::uint32_t>(pages_->slots.n_there());
}

}  // namespace lode::tetra_mt::midpoint
