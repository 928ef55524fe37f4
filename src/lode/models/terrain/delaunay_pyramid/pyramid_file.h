#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/file_layout.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"
#include "lode/store/reader.h"

namespace lode::delaunay_pyramid {

/// Writes a pyramid with all of its levels as docs/format.md says, whole or not at all. Returns the
/// size of the file.
[[nodiscard]] Result<std::uint64_t> save(const Pyramid& pyramid, const std::string& path,
                                         Progress& progress);

/// A file whose levels are read when they are wanted. Const members are safe from many threads.
class PyramidFile {
 public:
  /// Reads what it says of itself. Fails, naming the file, on what docs/format.md does not allow.
  [[nodiscard]] static Result<PyramidFile> open(const std::string& path);

  [[nodiscard]] const std::string& path() const { return reader_->path(); }
  [[nodiscard]] const PyramidHead& head() const { return head_; }
  [[nodiscard]] const store::Reader& reader() const { return *reader_; }

  /// What the mesh of a level takes: vertices until the level, and without links what is kept with
  /// it, or of lists with all levels until it. Fails, naming the file, where a number is not as
  /// docs/format.md says, or where the mesh is not that of a triangulation: see MeshCheck. Heights
  /// and errors are not found again, nor is the mesh held for being Delaunay: that is for
  /// verification.
  [[nodiscard]] Result<Pyramid> read_mesh(std::size_t level, Progress& progress) const;
  /// All of it, with links; each level's mesh is looked at.
  [[nodiscard]] Result<Pyramid> read_all(Progress& progress) const;

  /// What its blocks take, compressed.
  [[nodiscard]] PyramidBytes stored_bytes() const;
  [[nodiscard]] std::uint64_t n_bytes_read() const { return reader_->reads().n_bytes; }

 private:
  struct Part;

  PyramidFile(store::Reader reader, PyramidHead head)
      : reader_(std::make_unique<const store::Reader>(std::move(reader))), head_(std::move(head)) {}
  [[nodiscard]] Result<Pyramid> read(const Part& part, Progress& progress) const;

  std::unique_ptr<const store::Reader> reader_;
  PyramidHead head_;
};

}  // namespace lode::delaunay_pyramid
