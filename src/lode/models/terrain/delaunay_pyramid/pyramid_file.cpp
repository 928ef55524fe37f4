#include "lode/models/terrain/delaunay_pyramid/pyramid_file.h"

#include <utility>

#include "lode/core/expects.h"
#include "lode/models/terrain/delaunay_pyramid/level_reader.h"
#include "lode/models/terrain/delaunay_pyramid/mesh_check.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid_head.h"

namespace lode::delaunay_pyramid {

/// Which levels are read.
struct PyramidFile::Part {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t first_checked = 0;  ///< Whose mesh is looked at.
  ReadLinks links = ReadLinks::no;
};

Result<PyramidFile> PyramidFile::open(const std::string& path) {
  LODE_TRY(store::Reader reader, store::Reader::open(path));
  LODE_TRY(PyramidHead head, read_head(reader));
  return PyramidFile(std::move(reader), std::move(head));
}

Result<Pyramid> PyramidFile::read(const Part& part, Progress& progress) const {
  Pyramid pyramid{.head = head_, .vertices = {}, .heights = {}, .lines = {}, .levels = {}};
  pyramid.levels.resize(head_.n_levels());
  LODE_CHECK(read_vertices(*reader_, part.end, pyramid));
  LODE_CHECK(read_lines(*reader_, pyramid));
  for (std::size_t level = part.first; level < part.end; ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("reading", static_cast<double>(level) / static_cast<double>(part.end));
    LODE_CHECK(read_level(*reader_, level, part.links, pyramid));
  }
  MeshCheck check(pyramid);
  for (std::size_t level = part.first_checked; level < part.end; ++level) {
    if (progress.is_cancelled()) return cancelled_error();
    if (const auto checked = check.check(level); !checked)
      return fail("{}: {}", path(), checked.error().message);
  }
  return pyramid;
}

Result<Pyramid> PyramidFile::read_mesh(std::size_t level, Progress& progress) const {
  LODE_EXPECTS(level < head_.n_levels());
  return read({.first = head_.is_of_lists() ? 0 : level,
               .end = level + 1,
               .first_checked = level,
               .links = ReadLinks::no},
              progress);
}

Result<Pyramid> PyramidFile::read_all(Progress& progress) const {
  return read({.first = 0, .end = head_.n_levels(), .first_checked = 0, .links = ReadLinks::yes},
              progress);
}

PyramidBytes PyramidFile::stored_bytes() const {
  PyramidBytes bytes;
  for (const store::BlockEntry& block : reader_->blocks()) {
    switch (static_cast<Column>(block.key.kind)) {
      case Column::x:
      case Column::y:
      case Column::height:
      case Column::lines: bytes.vertices += block.stored_size; break;
      case Column::corners:
      case Column::error:
      case Column::death: bytes.triangles += block.stored_size; break;
      case Column::twins: bytes.neighbours += block.stored_size; break;
      case Column::n_links:
      case Column::first_links:
      case Column::links: bytes.links += block.stored_size; break;
    }
  }
  return bytes;
}

}  // namespace lode::delaunay_pyramid
