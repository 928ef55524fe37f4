#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_gmsh_input.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// A type of elements, by its number in .msh files.
struct GmshKind {
  std::uint8_t vtk_type = 0;
  std::uint8_t n_nodes = 0;
};

/// Types 1 to 31. Those of third order and more
/// are Lagrange cells here, whose corners come first as in VTK; the order of the others is not put
/// right, as only corners are ever used of them.
constexpr std::array<GmshKind, 31> kGmshKinds = {
    {{3, 2},   {5, 3},   {9, 4},   {10, 4},  {12, 8},  {13, 6},  {14, 5},  {21, 3},
     {22, 6},  {28, 9},  {24, 10}, {29, 27}, {32, 18}, {74, 14}, {1, 1},   {23, 8},
     {25, 20}, {26, 15}, {27, 13}, {69, 9},  {69, 10}, {69, 12}, {69, 15}, {69, 15},
     {69, 21}, {68, 4},  {68, 5},  {68, 6},  {71, 20}, {71, 35}, {71, 56}}};
/// Those of third and fourth order behind, by their numbers in GmshDefines.h.
constexpr std::array<std::pair<std::int64_t, GmshKind>, 8> kMoreKinds = {{{36, {70, 16}},
                                                                          {37, {70, 25}},
                                                                          {90, {73, 40}},
                                                                          {91, {73, 75}},
                                                                          {92, {72, 64}},
                                                                          {93, {72, 125}},
                                                                          {118, {74, 30}},
                                                                          {119, {74, 55}}}};

std::optional<GmshKind> kind_of(std::int64_t number) {
  if (number >= 1 && std::cmp_less_equal(number, kGmshKinds.size()))
    return kGmshKinds[static_cast<std::size_t>(number - 1)];
  for (const auto& [known, kind] : kMoreKinds)
    if (known == number) return kind;
  return {};
}

/// Where VTK has a node among those of a quadratic element, by its place in Gmsh's: middles of
/// edges are in another order there, and of faces.
constexpr std::array<std::uint8_t, 10> kTetrahedronOrder = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
constexpr std::array<std::uint8_t, 27> kHexahedronOrder = {0,  1,  2,  3,  4,  5,  6,  7,  8,
                                                           11, 13, 9,  16, 18, 19, 17, 10, 12,
                                                           14, 15, 22, 23, 21, 24, 20, 25, 26};
constexpr std::array<std::uint8_t, 18> kWedgeOrder = {0,  1,  2,  3, 4,  5,  6,  9,  7,
                                                      12, 14, 13, 8, 10, 11, 15, 17, 16};
constexpr std::array<std::uint8_t, 14> kPyramidOrder = {0,  1, 2, 3, 4,  5,  8,
                                                        10, 6, 7, 9, 11, 12, 13};

/// Those of fewer nodes are ordered as those of the most begin.
std::span<const std::uint8_t> order_of(const GmshKind& kind) {
  switch (static_cast<CellType>(kind.vtk_type)) {
    case CellType::quadratic_tetrahedron: return kTetrahedronOrder;
    case CellType::quadratic_hexahedron:
    case CellType::triquadratic_hexahedron: return kHexahedronOrder;
    case CellType::quadratic_wedge:
    case CellType::biquadratic_wedge: return kWedgeOrder;
    case CellType::quadratic_pyramid:
    case CellType::lagrange_pyramid: return kPyramidOrder;
    default: return {};
  }
}

void put_in_order(const GmshKind& kind, std::span<std::uint32_t> nodes) {
  const std::span<const std::uint8_t> order = order_of(kind);
  if (order.empty()) return;
  std::array<std::uint32_t, kHexahedronOrder.size()> given{};
  std::copy(nodes.begin(), nodes.end(), given.begin());
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = given[order[i]];
}

/// Of the next n elements. Fails on a type whose number of nodes is unknown: nothing behind can be
/// read.
Result<GmshKind> expect_kind(std::int64_t number, std::int64_t n, const GmshInput& input) {
  if (const auto kind = kind_of(number)) return *kind;
  return fail(
      "{}: expected elements of Gmsh's types 1 to 31, 36, 37, 90 to 93, 118 or 119, got at least "
      "{} of type {}",
      input.text.path(), n, number);
}

/// An element's type, its tag and its first physical group.
struct GmshElement {
  std::int64_t type = 0;
  std::int64_t tag = 0;
  std::int64_t group = 0;
};

Result<void> add_element(const GmshElement& element, const GmshKind& kind, GmshInput& input) {
  CellMesh& mesh = input.mesh;
  const auto key = static_cast<std::uint64_t>(element.tag);
  if (mesh.n_cells() > kMaxMeshCount)
    return fail("{}: expected at most {} elements, got more", input.text.path(), kMaxMeshCount);
  // Elements of several groups may come several times: values go to the first.
  if (input.elements.find(key) == FlatIndex::kNone)
    input.elements.insert(key, static_cast<std::uint32_t>(mesh.n_cells()));
  for (std::size_t i = 0; i < kind.n_nodes; ++i) {
    LODE_TRY(const std::int64_t node, input.large("a node of an element"));
    const std::uint32_t point = input.nodes.find(static_cast<std::uint64_t>(node));
    if (point == FlatIndex::kNone)
      return fail("{}: expected nodes of the mesh in element {}, got the tag {}", input.text.path(),
                  element.tag, node);
    mesh.corners.push_back(point);
  }
  put_in_order(kind, std::span(mesh.corners).last(kind.n_nodes));
  mesh.begins.push_back(mesh.corners.size());
  mesh.types.push_back(kind.vtk_type);
  input.element_groups.push_back(static_cast<double>(element.group));
  return {};
}

/// Tags between an element's own and its nodes: the physical group first.
Result<std::int64_t> read_group(std::int64_t n_tags, GmshInput& input) {
  std::int64_t group = 0;
  for (std::int64_t i = 0; i < n_tags; ++i) {
    LODE_TRY(const std::int64_t tag, input.whole("an element's tags"));
    if (i == 0) group = tag;
  }
  return group;
}

/// Elements of version 2 as text: tag, type, tags and nodes each.
Result<void> read_text_elements(std::int64_t n, GmshInput& input) {
  for (std::int64_t i = 0; i < n; ++i) {
    GmshElement element;
    LODE_TRY(element.tag, input.whole("an element's tag"));
    LODE_TRY(element.type, input.whole("an element's type"));
    LODE_TRY(const GmshKind kind, expect_kind(element.type, 1, input));
    LODE_TRY(const std::int64_t n_tags, input.whole("a number of tags"));
    LODE_TRY(element.group, read_group(n_tags, input));
    LODE_CHECK(add_element(element, kind, input));
  }
  return {};
}

/// As binary: runs of elements of one type.
Result<void> read_binary_elements(std::int64_t n, GmshInput& input) {
  while (n > 0) {
    LODE_TRY(const std::int64_t number, input.whole("an element's type"));
    LODE_TRY(const std::int64_t n_run, input.whole("a number of elements"));
    LODE_TRY(const std::int64_t n_tags, input.whole("a number of tags"));
    if (n_run < 1 || n_run > n)
      return fail("{}: expected a run of 1 to {} elements, got {}", input.text.path(), n, n_run);
    LODE_TRY(const GmshKind kind, expect_kind(number, n_run, input));
    for (std::int64_t i = 0; i < n_run; ++i) {
      GmshElement element{.type = number};
      LODE_TRY(element.tag, input.whole("an element's tag"));
      LODE_TRY(element.group, read_group(n_tags, input));
      LODE_CHECK(add_element(element, kind, input));
    }
    n -= n_run;
  }
  return {};
}

/// Elements of one entity and type, as version 4 has them.
Result<void> read_element_block(GmshInput& input) {
  LODE_TRY(const std::int64_t dimension, input.whole("an entity's dimension"));
  LODE_TRY(const std::int64_t entity, input.whole("an entity's tag"));
  LODE_TRY(const std::int64_t number, input.whole("an element's type"));
  LODE_TRY(const std::int64_t n, input.count("a number of elements"));
  LODE_TRY(const GmshKind kind, expect_kind(number, n, input));
  const auto found = input.groups.find({dimension, entity});
  GmshElement element{.type = number, .group = found == input.groups.end() ? 0 : found->second};
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(element.tag, input.large("an element's tag"));
    LODE_CHECK(add_element(element, kind, input));
  }
  return {};
}

/// As version 4 has them.
Result<void> read_element_blocks(GmshInput& input) {
  LODE_TRY(const std::int64_t n_blocks, input.count("a number of blocks"));
  for (int i = 0; i < 3; ++i) {
    LODE_TRY([[maybe_unused]] const std::int64_t total, input.large("a number of elements"));
  }
  for (std::int64_t i = 0; i < n_blocks; ++i) LODE_CHECK(read_element_block(input));
  return {};
}

Result<void> read_listed_elements(GmshInput& input) {
  LODE_TRY(const std::int64_t n, input.text.whole("a number of elements"));
  return input.is_binary ? read_binary_elements(n, input) : read_text_elements(n, input);
}

}  // namespace

Result<void> read_gmsh_elements(GmshInput& input) {
  return input.has_blocks ? read_element_blocks(input) : read_listed_elements(input);
}

}  // namespace lode::io
