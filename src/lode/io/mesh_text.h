#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/mesh_reader.h"

namespace lode::io {

/// Numbers of a file that is one value after the other, words or binary, read front to back from
/// memory. Errors name the file and the byte.
class MeshText {
 public:
  /// Reads the whole file, which fails where it is larger than the memory limit.
  [[nodiscard]] static Result<MeshText> open(const std::string& path,
                                             const MeshReadOptions& options);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t n_left() const { return bytes_.size() - position_; }
  /// The file's first bytes.
  [[nodiscard]] std::string_view start(std::size_t n) const {
    return std::string_view(bytes_).substr(0, n);
  }
  /// Of the last word, from 1. Takes as long as to look at all before it.
  [[nodiscard]] std::size_t line_number() const;
  /// Continues at a byte; fails where it is beyond the end.
  [[nodiscard]] Result<void> seek(std::size_t position);

  /// The next word; the one separator after it is used up. Empty at the end of the file.
  [[nodiscard]] std::string_view word();
  /// The rest of the line, without its end.
  [[nodiscard]] std::string_view line();
  /// Continues behind the next place of `text`; false, and no step, where there is none.
  [[nodiscard]] bool skip_past(std::string_view text);
  /// Turns what stands between a mark and the end of its line into blanks, in all of the file.
  void blank_comments(char mark);
  /// The next word as a number; `what` is what messages call it.
  [[nodiscard]] Result<std::int64_t> whole(std::string_view what);
  [[nodiscard]] Result<double> real(std::string_view what);
  /// The next bytes as a number.
  [[nodiscard]] Result<std::int64_t> binary_whole(ScalarType type, ByteOrder order);
  /// `type`: float32 or float64.
  [[nodiscard]] Result<double> binary_real(ByteOrder order, ScalarType type = ScalarType::float64);

 private:
  explicit MeshText(std::string path) : path_(std::move(path)) {}

  std::string path_;
  std::string bytes_;
  std::size_t position_ = 0;
  std::size_t word_begin_ = 0;  ///< Of the last one.
};

}  // namespace lode::io
