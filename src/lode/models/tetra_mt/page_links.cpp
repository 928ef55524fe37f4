// How nodes of a page are linked, as bits: docs/format.md, section 7.

#include <algorithm>
#include <numeric>
#include <utility>

#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt {
namespace {

using ListCounts = std::vector<std::uint32_t>;

/// Codes a page from first to last; a writer what it is given, and then all it makes is the same.
template <typename Coder>
class LinkCoder {
 public:
  LinkCoder(Coder& coder, LinkModels& models, const PageContent* given, std::uint32_t number,
            const PageShape& shape, const std::string& what, PageContent& made)
      : coder_(coder),
        models_(models),
        given_(given),
        number_(number),
        shape_(shape),
        what_(what),
        made_(made),
        n_(vertices_of(shape, number).n),
        far_(coder, models.far, shape, number, what),
        makers_(coder, models.makers) {}

  Result<void> run() {
    made_.positions.resize(n_);
    if (given_ != nullptr) made_.positions = given_->positions;
    LODE_CHECK(code_positions(coder_, models_.positions, shape_.has_narrow_positions, what_,
                              made_.positions));
    for (std::uint32_t i = 0; i < n_; ++i) LODE_CHECK(code_counts(i));
    LODE_CHECK(far_.code_table(far_vertices(), most_links_));
    ChildLinks<Coder> children(coder_, models_.children, far_, shape_, number_, n_children_, what_);
    LODE_CHECK(children.run(given_, made_));
    made_.boxes.resize(n_);
    if (given_ != nullptr) made_.boxes = given_->boxes;
    BoxSteps<Coder>(coder_, models_.boxes).code(children.tree(), made_.boxes);
    LODE_CHECK(code_parents());
    for (std::uint32_t i = 0; i < n_; ++i) LODE_CHECK(code_target(i));
    for (std::uint32_t i = 0; i < n_; ++i) code_makers(i);
    for (std::uint32_t i = 0; i < n_; ++i) LODE_CHECK(code_regions(i));
    if (shape_.n_regions <= 1) return {};
    return MaskCoder(coder_, models_.masks)
        .code(children.tree(), shape_.n_regions,
              given_ != nullptr ? given_->region_masks : std::span<const std::uint64_t>(), what_,
              made_.region_masks);
  }

 private:
  static constexpr std::uint32_t kFew = LinkModels::kFew;

  [[nodiscard]] std::uint32_t first_node() const { return number_ * kPageNodes; }
  [[nodiscard]] bool is_near(std::uint32_t node) const { return node - first_node() < n_; }
  /// What is of the page, of a vertex: its place, else n_ or more.
  [[nodiscard]] std::uint32_t place_of(std::uint32_t vertex) const {
    return vertex - shape_.n_base_vertices - first_node();
  }
  [[nodiscard]] std::uint32_t vertex_at(std::uint32_t place) const {
    return shape_.n_base_vertices + first_node() + place;
  }

  /// What links lead to in other pages, for a writer.
  [[nodiscard]] std::vector<std::uint32_t> far_vertices() const {
    std::vector<std::uint32_t> vertices;
    if (given_ == nullptr) return vertices;
    for (const auto* nodes : {&given_->children.items, &given_->parents.items})
      for (const std::uint32_t node : *nodes)
        if (!is_near(node)) vertices.push_back(shape_.n_base_vertices + node);
    for (const std::uint32_t v : given_->targets)
      if (place_of(v) >= n_) vertices.push_back(v);
    return vertices;
  }

  Result<void> code_counts(std::uint32_t i) {
    std::uint32_t n_children = 0;
    std::uint32_t n_discovered = 0;
    std::uint32_t n_parents = 0;
    std::uint32_t n_makers = 0;
    if (given_ != nullptr) {
      n_children = static_cast<std::uint32_t>(given_->children[i].size());
      n_discovered = given_->n_discovered[i];
      const auto is_far = [&](std::uint32_t node) { return !is_near(node); };
      n_parents = static_cast<std::uint32_t>(std::ranges::count_if(given_->parents[i], is_far));
      n_makers = static_cast<std::uint32_t>(given_->makers[i].size());
    }
    n_children =
        models_.counts.children[std::min(last_n_children_ / 2, 4U)].code(coder_, n_children);
    n_discovered = models_.counts.discovered[std::min(n_children, 12U)].code(coder_, n_discovered);
    n_parents = models_.counts.parents[std::min(last_n_parents_, kFew)].code(coder_, n_parents);
    if (n_children > 0) {
      const bool is_odd = coder_.bit(models_.counts.is_odd, (n_makers & 1) != 0);
      n_makers = 2 * models_.counts.makers[std::min(n_children, 10U)].code(coder_, n_makers / 2);
      n_makers += is_odd ? 1 : 0;
    }
    if (std::max({n_children, n_parents, n_makers}) > kMaxBrought || n_discovered > n_children ||
        n_makers < n_children)
      return fail("{}: node {}: expected up to {} links of each kind, got {}, {}, {} and {}", what_,
                  i, kMaxBrought, n_children, n_discovered, n_parents, n_makers);
    last_n_children_ = n_children;
    last_n_parents_ = n_parents;
    n_children_.push_back(n_children);
    n_far_parents_.push_back(n_parents);
    n_makers_.push_back(n_makers);
    made_.n_discovered.push_back(static_cast<std::uint8_t>(n_discovered));
    most_links_ += n_children + n_parents + 1;
    return {};
  }

  Result<void> expect_node(std::uint32_t i, std::uint32_t vertex) const {
    if (vertex >= shape_.n_base_vertices) return {};
    return fail("{}: node {}: expected a link to a node, got vertex {}", what_, i, vertex);
  }

  /// Those in the page follow from children.
  Result<void> code_parents() {
    const Lists<std::uint32_t> near = near_parents();
    for (std::uint32_t i = 0; i < n_; ++i) {
      scratch_.assign(near[i].begin(), near[i].end());
      std::uint32_t at = 0;
      for (std::uint32_t k = 0; k < n_far_parents_[i]; ++k) {
        std::uint32_t given = 0;
        if (given_ != nullptr) {
          while (is_near(given_->parents[i][at])) ++at;
          given = given_->parents[i][at++];
        }
        LODE_TRY(const std::uint32_t vertex,
                 far_.code(FarLinks<Coder>::parent, k, shape_.n_base_vertices + given));
        LODE_CHECK(expect_node(i, vertex));
        scratch_.push_back(vertex - shape_.n_base_vertices);
      }
      std::ranges::sort(scratch_);
      if (std::ranges::adjacent_find(scratch_) != scratch_.end() || scratch_.size() > kMaxBrought)
        return fail("{}: node {}: expected up to {} parents that differ", what_, i, kMaxBrought);
      made_.parents.items.insert(made_.parents.items.end(), scratch_.begin(), scratch_.end());
      made_.parents.end_list();
    }
    return {};
  }
  [[nodiscard]] Lists<std::uint32_t> near_parents() const {
    Lists<std::uint32_t> lists;
    lists.begins.assign(n_ + 1, 0);
    for (const std::uint32_t child : made_.children.items)
      if (is_near(child)) ++lists.begins[child - first_node() + 1];
    std::partial_sum(lists.begins.begin(), lists.begins.end(), lists.begins.begin());
    lists.items.resize(lists.begins.back());
    std::vector<std::uint32_t> ends(lists.begins.begin(), lists.begins.end() - 1);
    for (std::uint32_t i = 0; i < n_; ++i)
      for (const std::uint32_t child : made_.children[i])
        if (is_near(child)) lists.items[ends[child - first_node()]++] = first_node() + i;
    return lists;
  }

  /// A parent's vertex, the target of a node beside it, or another vertex.
  Result<void> code_target(std::uint32_t i) {
    const std::uint32_t given = given_ != nullptr ? given_->targets[i] : 0;
    const std::uint32_t none = ~0U;
    std::uint32_t found = code_parent_target(i, given, none);
    if (found == none) found = code_shared_target(i, given, none);
    if (found == none && coder_.bit(models_.targets.is_near, place_of(given) < n_)) {
      const auto step = static_cast<std::int32_t>(place_of(given) - i);
      found = vertex_at(i + static_cast<std::uint32_t>(
                                unfolded(models_.targets.near.code(coder_, folded(step)))));
      if (place_of(found) >= n_ || place_of(found) == i)
        return fail("{}: node {}: expected another vertex of the page, got {}", what_, i, found);
    } else if (found == none) {
      LODE_TRY(found, far_.code(FarLinks<Coder>::target, 0, given));
    }
    made_.targets.push_back(found);
    return {};
  }
  std::uint32_t code_parent_target(std::uint32_t i, std::uint32_t given, std::uint32_t none) {
    const auto parents = made_.parents[i];
    const auto n = static_cast<std::uint32_t>(parents.size());
    const bool is_given =
        std::ranges::find(parents, given - shape_.n_base_vertices) != parents.end();
    if (n == 0 || !coder_.bit(models_.targets.is_parent[std::min(n, kFew)], is_given)) return none;
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t vertex = shape_.n_base_vertices + parents[k];
      auto& models = models_.targets.which_parent[std::min(n, kFew)][std::min(k, kFew)];
      if (k + 1 == n || coder_.bit(models[is_near(parents[k]) ? 1 : 0], vertex == given))
        return vertex;
    }
    return none;
  }
  std::uint32_t code_shared_target(std::uint32_t i, std::uint32_t given, std::uint32_t none) {
    const auto parents = made_.parents[i];
    std::vector<std::uint32_t>& seen = scratch_;
    seen.assign(1, vertex_at(i));
    for (const std::uint32_t parent : parents) seen.push_back(shape_.n_base_vertices + parent);
    const std::size_t n_excluded = seen.size();
    for (const auto nodes : {parents, made_.children[i]})
      for (const std::uint32_t node : nodes) {
        if (node - first_node() >= i) continue;
        const std::uint32_t vertex = made_.targets[node - first_node()];
        if (std::ranges::find(seen, vertex) != seen.end()) continue;
        const std::size_t rank = std::min<std::size_t>(seen.size() - n_excluded, kFew);
        if (coder_.bit(models_.targets.is_shared[rank], vertex == given)) return vertex;
        seen.push_back(vertex);
      }
    return none;
  }

  void code_makers(std::uint32_t i) {
    if (n_children_[i] > 0) {
      roles_.clear();
      for (const std::uint32_t child : made_.children[i]) roles_.push_back(role_of(i, child));
      roles_.push_back(MakerRole::reference);
      makers_.code(roles_, n_makers_[i],
                   given_ != nullptr ? given_->makers[i] : std::span<const std::uint8_t>(),
                   made_.makers.items);
    }
    made_.makers.end_list();
  }

  [[nodiscard]] MakerRole role_of(std::uint32_t i, std::uint32_t child) const {
    if (!is_near(child)) return MakerRole::far;
    const std::uint32_t target = made_.targets[child - first_node()];
    if (target == vertex_at(i)) return MakerRole::splits_vertex;
    return target == made_.targets[i] ? MakerRole::splits_target : MakerRole::splits_other;
  }

  Result<void> code_regions(std::uint32_t i) {
    std::uint32_t n = given_ != nullptr ? static_cast<std::uint32_t>(given_->regions[i].size()) : 0;
    if (shape_.n_labels > 1) n = models_.regions.counts.code(coder_, n);
    if (n > kMaxBrought)
      return fail("{}: node {}: expected up to {} regions, got {}", what_, i, kMaxBrought, n);
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t given = given_ != nullptr ? given_->regions[i][k] : 0;
      if (coder_.bit(models_.regions.is_other, given != last_region_)) {
        const std::uint64_t region = models_.regions.numbers.code(coder_, given);
        if (region >= shape_.n_labels)
          return fail("{}: expected one of {} regions or patches, got {}", what_, shape_.n_labels,
                      region);
        last_region_ = static_cast<std::uint32_t>(region);
      }
      made_.regions.items.push_back(last_region_);
    }
    made_.regions.end_list();
    return {};
  }

  Coder& coder_;
  LinkModels& models_;
  const PageContent* given_;
  std::uint32_t number_;
  const PageShape& shape_;
  const std::string& what_;
  PageContent& made_;
  std::uint32_t n_;
  std::vector<std::uint32_t> scratch_;
  std::vector<MakerRole> roles_;
  ListCounts n_children_;
  ListCounts n_far_parents_;
  ListCounts n_makers_;
  std::size_t most_links_ = 0;
  std::uint32_t last_n_children_ = 0;
  std::uint32_t last_n_parents_ = 0;
  FarLinks<Coder> far_;
  MakerCoder<Coder> makers_;
  std::uint32_t last_region_ = 0;
};

}  // namespace

std::vector<std::byte> encode_links(const PageContent& content, std::uint32_t number,
                                    const PageShape& shape, LinkModels& models) {
  RangeWriter out;
  PageContent made;
  const std::string what = "page";
  const auto done = LinkCoder(out, models, &content, number, shape, what, made).run();
  LODE_EXPECTS(done && made == content);
  return std::move(out).take();
}

Result<void> decode_links(std::span<const std::byte> bytes, const std::string& what,
                          std::uint32_t number, const PageShape& shape, LinkModels& models,
                          PageContent& content) {
  RangeReader in(bytes);
  content = {};
  LODE_CHECK(LinkCoder(in, models, nullptr, number, shape, what, content).run());
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return {};
}

}  // namespace lode::tetra_mt
