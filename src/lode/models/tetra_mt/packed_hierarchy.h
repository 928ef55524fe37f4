#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/models/tetra_mt/build_record.h"
#include "lode/models/tetra_mt/field_page.h"
#include "lode/models/tetra_mt/front_nodes.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/node_page.h"
#include "lode/models/tetra_mt/page_tree.h"
#include "lode/models/tetra_mt/world_codes.h"

namespace lode::tetra_mt {

/// What of a hierarchy is in memory from the beginning.
struct HierarchyHead {
  struct Field {
    std::string name;
    ScalarType type = ScalarType::float64;
    bool has_narrow_values = false;  ///< float32 holds them.
    double low = 0;                  ///< Of all vertices.
    double high = 0;
    bool has_errors_everywhere = false;  ///< Else they hold at samples.
    double base_error = 0;               ///< Largest |F - F'| on the base, rounded up.
    std::optional<double> time{};
    /// Of the base likewise; none where nodes have none.
    std::optional<double> base_world_error{};
  };

  PageShape shape;
  std::uint64_t n_cells = 0;       ///< Of the reference mesh.
  std::uint64_t n_base_cells = 0;  ///< Without those to the vertex outside.
  Vec3d lower;                     ///< Of all positions.
  Vec3d upper;
  double boundary_deviation = 0;  ///< Hierarchy's,
  BuildRecord record;             ///< likewise.
  std::vector<Field> fields;
  std::vector<std::uint32_t> roots;  ///< Nodes without parents, ascending.
  std::vector<Vec3d> base_positions;
  std::vector<Tetrahedron> base;            ///< With those to the vertex outside.
  std::vector<std::uint32_t> base_makers;   ///< By tetrahedron of the base: its node, or kNone.
  std::vector<std::int64_t> region_ids;     ///< As the file numbers them, ascending.
  std::vector<std::string> region_names;    ///< TetraMesh's.
  std::vector<BoundaryPatch> patches;       ///< By id, ascending.
  std::vector<std::uint32_t> base_regions;  ///< Hierarchy's.
  /// Where pages come from a file; else none.
  std::shared_ptr<const FrontNodes> front{};

  [[nodiscard]] std::uint32_t n_vertices() const { return shape.n_base_vertices + shape.n_nodes; }
  [[nodiscard]] std::uint32_t outside() const { return n_vertices(); }
};

/// PageShape's.
[[nodiscard]] std::uint32_t n_labels_of(std::span<const std::int64_t> region_ids,
                                        std::span<const BoundaryPatch> patches);

/// Likewise.
[[nodiscard]] std::uint32_t n_regions_of(std::span<const std::int64_t> region_ids);

/// What of a field is in memory once anything is asked of it.
struct FieldBase {
  ValueScale scale;            ///< Of all its values: from Field::low to high.
  std::vector<double> values;  ///< By vertex of the base.
  FrontFacts front{};          ///< Of none where there is no HierarchyHead::front.
};

/// A Hierarchy in pages, and in these field by field: all in memory, or each from a file when it is
/// looked at first, to stay. What a file says of nodes that the base waits for is there with the
/// base, for as long as their pages are not. Const members are safe from many threads.
class PackedHierarchy {
 public:
  /// What pages have, checked against the head; called by one thread at a time.
  struct Load {
    std::function<Result<PageContent>(std::uint32_t page)> links;
    std::function<Result<FieldBase>(std::size_t field, const HierarchyHead& head)> base;
    std::function<Result<FieldContent>(std::size_t field, std::uint32_t page, const PageTree& tree,
                                       const FieldBase& base)>
        field;
    std::function<Result<WorldPage>(std::size_t field, std::uint32_t page, const FieldBase& base)>
        world_errors;
  };

  /// All of it, in memory. `n_cells`: of the reference mesh.
  [[nodiscard]] static PackedHierarchy pack(const Hierarchy& hierarchy, std::uint64_t n_cells,
                                            Threads threads);
  PackedHierarchy(HierarchyHead head, Load load);
  PackedHierarchy(PackedHierarchy&&) noexcept;
  PackedHierarchy& operator=(PackedHierarchy&&) noexcept;
  ~PackedHierarchy();

  [[nodiscard]] const HierarchyHead& head() const { return *head_; }
  /// Of a vertex; those of nodes are in their pages.
  [[nodiscard]] Vec3d position(std::uint32_t vertex) const;
  [[nodiscard]] double value(std::uint32_t vertex, std::size_t field) const;
  [[nodiscard]] StoredFacts facts(std::uint32_t node, std::size_t field) const;
  /// Infinite where the field has none.
  [[nodiscard]] float world_error(std::uint32_t node, std::size_t field) const;
  /// Whether they are known without a page that is not in memory.
  [[nodiscard]] bool has_facts(std::uint32_t node, std::size_t field) const;
  /// A box that holds all it discovers.
  [[nodiscard]] Bounds bounds(std::uint32_t node) const;
  /// Hierarchy's; kAllRegions where there is one region at most.
  [[nodiscard]] std::uint64_t region_mask(std::uint32_t node) const;
  [[nodiscard]] NodePage::Links links(std::uint32_t node) const {
    return page_of(node).links(node % kPageNodes);
  }

  /// Of a page of nodes.
  [[nodiscard]] PageTree tree_of(std::uint32_t page) const;

  /// Asks the memory for what is read of a node, if its pages are there.
  void prefetch(std::uint32_t node, std::size_t field) const;

  /// Fails where something could not be loaded: nodes of such pages are as if they had nothing.
  [[nodiscard]] Result<void> check() const;
  /// Of the pages that are in memory.
  [[nodiscard]] std::size_t n_page_bytes() const;
  /// Without those of fields.
  [[nodiscard]] std::uint32_t n_pages_loaded() const;
  [[nodiscard]] std::uint32_t n_field_pages_loaded(std::size_t field) const;

 private:
  struct Pages;
  struct FieldPages;

  [[nodiscard]] const NodePage& page_of(std::uint32_t node) const;
  [[nodiscard]] const FieldPage& page_of(std::uint32_t node, const FieldPages& field) const;
  [[nodiscard]] const FieldBase& base_of(const FieldPages& field) const;
  /// Its place among those that the base waits for.
  [[nodiscard]] std::optional<std::uint32_t> front_place(std::uint32_t node) const {
    return head_->front ? head_->front->find(node) : std::nullopt;
  }
  const NodePage& load(std::uint32_t number) const;
  const FieldPage& load(std::uint32_t number, std::size_t field) const;
  const FieldBase& load_base(std::size_t field) const;
  const WorldPage& load_world(std::uint32_t number, std::size_t field) const;

  std::unique_ptr<const HierarchyHead> head_;
  BoxCodes box_codes_;
  WorldCodes world_codes_;
  std::unique_ptr<Pages> pages_;
};

/// What is to be in memory from the beginning. `n_cells`: of the reference mesh.
[[nodiscard]] HierarchyHead head_of(const Hierarchy& hierarchy, std::uint64_t n_cells);

/// HierarchyHead::front of its file. `head`: its own.
[[nodiscard]] FrontNodes front_of(const Hierarchy& hierarchy, const HierarchyHead& head);
[[nodiscard]] FrontBase front_base_of(const HierarchyHead& head);

/// What a page of a hierarchy has.
[[nodiscard]] PageContent content_of(const Hierarchy& hierarchy, std::uint32_t number);

/// A field by the numbers of a hierarchy.
struct NumberedField {
  std::string name;
  ScalarType type = ScalarType::float64;
  std::optional<double> time{};
  std::vector<double> values;          ///< By vertex.
  std::vector<StoredFacts> facts;      ///< By node: nested along discovery;
  double range_reference = 0;          ///< what their ranges are above,
  bool has_errors_everywhere = false;  ///< and whether their errors hold at all points.
  bool has_world_errors = false;       ///< Else facts' are infinite.
};

[[nodiscard]] NumberedField field_of(const Hierarchy& hierarchy, std::size_t field);
[[nodiscard]] HierarchyHead::Field head_of(const NumberedField& field,
                                           std::span<const std::uint32_t> base_makers);
[[nodiscard]] FieldBase base_of(const NumberedField& field, const PageShape& shape);
[[nodiscard]] WorldPage world_page_of(const NumberedField& field, const WorldCodes& codes,
                                      const PageShape& shape, std::uint32_t number);
/// FieldBase::front of its file. `nodes`: FrontNodes'.
[[nodiscard]] FrontFacts front_facts_of(const NumberedField& field, const ValueScale& scale,
                                        const WorldCodes& codes,
                                        std::span<const std::uint32_t> nodes);
/// What a page has for it. `scale`: base_of()'s.
[[nodiscard]] FieldContent content_of(const NumberedField& field, const ValueScale& scale,
                                      const PageShape& shape, std::uint32_t number);

}  // namespace lode::tetra_mt
