#include "exodus_elements.h"

#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <stdexcept>

namespace lode::vtk_import {
namespace {

/// Elements by the beginning of their types' names, and of how many nodes they may be.
struct Known {
  const char* name;
  std::initializer_list<std::size_t> n_nodes;
};

const std::array<Known, 7> kKnown{{{"TET", {4, 10}},
                                   {"HEX", {8, 20, 27}},
                                   {"WED", {6, 15, 18}},
                                   {"PYR", {5, 13}},
                                   {"TRI", {3, 6}},
                                   {"QUA", {4, 8, 9}},
                                   {"SHE", {3, 4, 8}}}};

class NetcdfFile {
 public:
  explicit NetcdfFile(const std::string& path)
      : is_open_(nc_open(path.c_str(), NC_NOWRITE, &id_) == NC_NOERR) {}
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;
  ~NetcdfFile() {
    if (is_open_) nc_close(id_);
  }
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] int id() const { return id_; }

 private:
  int id_ = 0;
  bool is_open_ = false;
};

/// In capitals; empty where a block's connectivity has none.
std::string type_of(int file, int variable) {
  constexpr std::size_t kMostBytes = 1024;
  std::size_t n = 0;
  if (nc_inq_attlen(file, variable, "elem_type", &n) != NC_NOERR || n > kMostBytes) return {};
  std::string type(n, '\0');
  if (nc_get_att_text(file, variable, "elem_type", type.data()) != NC_NOERR) return {};
  type.resize(std::min(type.size(), type.find('\0')));
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return type;
}

void check_block(int file, int block) {
  int variable = 0;
  const std::string name = "connect" + std::to_string(block);
  if (nc_inq_varid(file, name.c_str(), &variable) != NC_NOERR) return;
  int dimension = 0;
  std::size_t n_nodes = 0;
  const std::string counted = "num_nod_per_el" + std::to_string(block);
  if (nc_inq_dimid(file, counted.c_str(), &dimension) != NC_NOERR) return;
  if (nc_inq_dimlen(file, dimension, &n_nodes) != NC_NOERR) return;
  const std::string type = type_of(file, variable);
  const auto* const known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& each) {
    return type.compare(0, 3, each.name) == 0;
  });
  if (known == kKnown.end()) return;
  const auto& counts = known->n_nodes;
  if (std::find(counts.begin(), counts.end(), n_nodes) != counts.end()) return;
  std::string expected;
  for (const std::size_t n : counts) expected += (expected.empty() ? "" : ", ") + std::to_string(n);
  throw std::runtime_error("block " + std::to_string(block) + ", of elements " + type +
                           ": expected " + expected + " nodes each, got " +
                           std::to_string(n_nodes) + ", of which VTK's reader would not take all");
}

}  // namespace

void check_exodus_elements(const std::string& path) {
  const NetcdfFile file(path);
  int dimension = 0;
  std::size_t n_blocks = 0;
  if (!file.is_open() || nc_inq_dimid(file.id(), "num_el_blk", &dimension) != NC_NOERR ||
      nc_inq_dimlen(file.id(), dimension, &n_blocks) != NC_NOERR)
    return;
  constexpr std::size_t kMostBlocks = 1'000'000;
  for (std::size_t block = 1; block <= std::min(n_blocks, kMostBlocks); ++block)
    check_block(file.id(), static_cast<int>(block));
}

}  // namespace lode::vtk_import
