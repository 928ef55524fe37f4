#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/core/flat_index.h"
#include "lode/io/mesh_numbers.h"
#include "lode/io/mesh_text.h"

namespace lode::io {

/// When a field of a .msh file is: its time step's number, and the time that it says.
struct GmshTime {
  double time = 0;
  std::int64_t step = 0;

  friend auto operator<=>(const GmshTime&, const GmshTime&) = default;
};

/// A .msh file being read: its numbers, whose form its head says, and what came so far.
struct GmshInput {
  MeshText text;
  bool has_blocks = false;  ///< Version 4: nodes and elements come in blocks.
  bool is_binary = false;
  ByteOrder order = ByteOrder::little;
  CellMesh mesh{};
  std::vector<GmshTime> point_times{};  ///< By field of the points,
  std::vector<GmshTime> cell_times{};   ///< and of the cells.
  FlatIndex nodes{};                    ///< By tag.
  FlatIndex elements{};                 ///< By tag.
  MeshBudget budget{};                  ///< Of fields, whose data may be sparse.
  /// By dimension and tag of an entity: its first physical group.
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> groups{};
  std::vector<double> element_groups{};  ///< By element; 0: none.

  /// A number that binary files hold in 4 bytes.
  [[nodiscard]] Result<std::int64_t> whole(std::string_view what);
  /// A tag or count, which those of version 4 hold in 8.
  [[nodiscard]] Result<std::int64_t> large(std::string_view what);
  /// A count of things that take a byte or more each: of that many at most.
  [[nodiscard]] Result<std::int64_t> count(std::string_view what);
  [[nodiscard]] Result<double> real(std::string_view what);
};

/// $MeshFormat. Fails on versions other than 2.x and 4.1.
[[nodiscard]] Result<void> read_gmsh_format(GmshInput& input);

/// $PhysicalNames: of groups of two and of three dimensions.
[[nodiscard]] Result<void> read_gmsh_names(GmshInput& input);

/// $Entities, of version 4.
[[nodiscard]] Result<void> read_gmsh_entities(GmshInput& input);

[[nodiscard]] Result<void> read_gmsh_nodes(GmshInput& input);

/// Fails on types above fourth order, and on others that GmshDefines.h lists but no mesher makes.
[[nodiscard]] Result<void> read_gmsh_elements(GmshInput& input);

/// $NodeData and $ElementData, behind all nodes and elements.
enum class GmshPlace { nodes, elements };
[[nodiscard]] Result<void> read_gmsh_data(GmshPlace place, GmshInput& input);

/// Of fields of one name and shape at several times those of a step, by the options, in order of
/// time; the others go. One that has other steps but not this is listed as left out. What is left
/// of one name is called NAME@STEP but for the first. Fails where there are not so many steps.
[[nodiscard]] Result<void> choose_gmsh_step(const MeshReadOptions& options, GmshInput& input);

/// Of another section of values its name alone, which it lists as left out, once.
[[nodiscard]] Result<void> skip_gmsh_data(const std::string& section, GmshInput& input);

}  // namespace lode::io
