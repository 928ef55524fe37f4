#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/tetra_mt/lazy.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/page_gradients.h"
#include "lode/models/tetra_mt/page_models.h"
#include "lode/models/tetra_mt/page_primers.h"
#include "lode/models/tetra_mt/page_tree.h"
#include "lode/store/reader.h"

namespace lode::tetra_mt {

/// Reads what a file has once its base is known, for any threads at once. Primers are read when the
/// first page of their kind is, and kept.
class PageSource {
 public:
  PageSource(std::shared_ptr<const store::Reader> reader, const HierarchyHead& head);

  /// That all blocks are there.
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] Result<PageContent> links(std::uint32_t page) const;
  [[nodiscard]] Result<FieldContent> field(std::size_t number, std::uint32_t page,
                                           const PageTree& tree, const FieldBase& base) const;
  [[nodiscard]] Result<WorldPage> world_errors(std::size_t field, std::uint32_t page,
                                               const FieldBase& base) const;
  /// `head`: with its base, which this was made of.
  [[nodiscard]] Result<FieldBase> base(std::size_t number, const HierarchyHead& head) const;
  /// Codes at vertices of a page of nodes, or of the base's.
  [[nodiscard]] Result<std::vector<std::uint32_t>> gradients(std::size_t field,
                                                             std::uint32_t page) const;
  [[nodiscard]] Result<std::vector<std::uint32_t>> mesh_vertices() const;
  /// Whether it has neither of these.
  [[nodiscard]] bool is_lean() const;

 private:
  using LinkPrimers = Primers<LinkModels, PageContent>;
  using FieldPrimers = Primers<FieldModels, FieldContent>;
  using GradientPrimers = Primers<GradientModels, std::vector<std::uint32_t>>;
  struct OfField {
    HierarchyHead::Field head;  ///< Without its name.
    Lazy<FieldPrimers> primers{};
    Lazy<GradientPrimers> gradients{};
  };

  [[nodiscard]] std::string name_of(const store::BlockKey& key) const;
  [[nodiscard]] Result<void> expect(const store::BlockKey& key) const;
  /// Fails unless `is_same(node's place in the page, its place in the front)` of all nodes of a
  /// page that the base waits for.
  template <typename IsSame>
  [[nodiscard]] Result<void> check_front(std::uint32_t page, const store::BlockKey& key,
                                         const IsSame& is_same) const;
  [[nodiscard]] Result<const LinkPrimers*> link_primers() const;
  [[nodiscard]] Result<PageContent> read_links(std::uint32_t page, LinkModels& models) const;
  [[nodiscard]] Result<FieldContent> read_field(std::size_t number, std::uint32_t page,
                                                const PageTree& tree, const ValueScale& scale,
                                                FieldModels& models) const;
  [[nodiscard]] Result<std::vector<std::uint32_t>> read_gradients(std::size_t field,
                                                                  std::uint32_t page,
                                                                  GradientModels& models) const;

  std::shared_ptr<const store::Reader> reader_;
  PageShape shape_;
  BoxCodes box_codes_;
  std::shared_ptr<const FrontNodes> front_;
  std::unique_ptr<Lazy<LinkPrimers>> link_primers_ = std::make_unique<Lazy<LinkPrimers>>();
  std::vector<std::unique_ptr<OfField>> fields_;
};

}  // namespace lode::tetra_mt
