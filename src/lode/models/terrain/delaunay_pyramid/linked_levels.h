#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"
#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/delaunay_pyramid/file_layout.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"

namespace lode::delaunay_pyramid {

/// Numbers of the columns of one kind, whose blocks are read when they are asked for, and kept.
template <typename T>
class KeptBlocks {
 public:
  /// n: of the level's numbers. i is below it.
  [[nodiscard]] Result<T> at(const PyramidFile& file, const terrain_file::ColumnKey& column,
                             std::uint64_t n, std::uint64_t i) {
    const std::uint64_t part = i / terrain_file::kPart;
    auto& block = blocks_[{column.level, part}];
    if (block.empty()) {
      LODE_TRY(block, terrain_file::read_part<T>(file.reader(), column, n, part));
    }
    return block[i % terrain_file::kPart];
  }

 private:
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::vector<T>> blocks_;
};

/// A triangle that is kept with a level.
struct KeptTriangle {
  std::uint32_t level = 0;
  std::uint32_t number = 0;

  friend auto operator<=>(const KeptTriangle&, const KeptTriangle&) = default;
};

/// Triangles of a file with links, one by one: of each what is asked for is read, in blocks, and
/// looked at. Functions fail, naming the file, where a number is not as docs/format.md says.
class LinkedLevels {
 public:
  using Triple = std::array<std::uint32_t, 3>;

  /// The file has links, and must outlive it.
  explicit LinkedLevels(const PyramidFile& file) : file_(file) {}

  [[nodiscard]] const PyramidHead& head() const { return file_.head(); }
  [[nodiscard]] const PyramidFile& file() const { return file_; }

  [[nodiscard]] Result<delaunay::LatticePoint> vertex(std::uint32_t v);
  [[nodiscard]] Result<double> height(std::uint32_t v);
  /// Vertices of the triangle's level, which turn left.
  [[nodiscard]] Result<Triple> corners(const KeptTriangle& t);
  [[nodiscard]] Result<delaunay::LatticeCorners> places(const KeptTriangle& t);
  [[nodiscard]] Result<float> error(const KeptTriangle& t);
  /// The first level whose mesh has not got it, or has it anew; or the number of levels.
  [[nodiscard]] Result<std::uint32_t> end_of(const KeptTriangle& t);
  /// What is kept with that level and meets its interior; fails where there is no such level.
  [[nodiscard]] Result<std::vector<KeptTriangle>> linked(const KeptTriangle& t);

 private:
  [[nodiscard]] std::string place_of(const KeptTriangle& t) const;
  /// The place of a vertex among those that a level adds.
  struct VertexPlace {
    std::size_t level;
    std::uint32_t number;
    std::uint32_t n;
  };
  [[nodiscard]] VertexPlace place_of(std::uint32_t v) const;
  /// Of a triangle the first link, and the one after its last.
  [[nodiscard]] Result<std::pair<std::uint64_t, std::uint64_t>> link_range(const KeptTriangle& t);

  const PyramidFile& file_;
  std::array<KeptBlocks<std::int32_t>, 2> coordinates_;
  KeptBlocks<std::int16_t> int16_heights_;
  KeptBlocks<float> float_heights_;
  KeptBlocks<double> double_heights_;
  KeptBlocks<std::uint32_t> corners_;
  KeptBlocks<std::uint16_t> errors_;
  KeptBlocks<std::uint16_t> deaths_;
  KeptBlocks<std::uint32_t> n_links_;
  KeptBlocks<std::uint64_t> first_links_;
  KeptBlocks<std::uint32_t> links_;
  /// By level and block of triangles, where the links of each end in the level's.
  std::map<std::pair<std::uint32_t, std::uint64_t>, std::vector<std::uint64_t>> link_ends_;
};

}  // namespace lode::delaunay_pyramid
