#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/mesh_text.h"

namespace lode::io {

/// A file of the MEDIT family, text (.mesh, .sol) or binary (.meshb, .solb, versions 1 to 4 of
/// libMeshb), keyword by keyword. Errors name the file and the line, or the byte of binary ones.
class MeditInput {
 public:
  /// Fails on what is neither.
  [[nodiscard]] static Result<MeditInput> open(const std::string& path,
                                               const MeshReadOptions& options);

  [[nodiscard]] const std::string& path() const { return text_.path(); }
  /// The next keyword in lower case; of text any next word, of binary files what is known of their
  /// numbers ("17" of others). Empty at the end. Behind what has been read, as many as its count
  /// says, no number may stand in text: it would be lost. `before`: what that was, or empty.
  [[nodiscard]] Result<std::string> keyword(std::string_view before);
  /// A count, a vertex or a reference.
  [[nodiscard]] Result<std::int64_t> whole(std::string_view what, std::int64_t low,
                                           std::int64_t high);
  /// A number that all versions hold in 4 bytes.
  [[nodiscard]] Result<std::int64_t> small(std::string_view what, std::int64_t low,
                                           std::int64_t high);
  [[nodiscard]] Result<double> real(std::string_view what);
  /// Of what comes behind the keyword Dimension. `what`: "a mesh"
  [[nodiscard]] Result<void> expect_three_dimensions(std::string_view what);
  /// "FILE: line 7"
  [[nodiscard]] std::string where() const;
  [[nodiscard]] std::size_t n_left() const { return text_.n_left(); }

 private:
  explicit MeditInput(MeshText&& text) : text_(std::move(text)) {}

  [[nodiscard]] Result<void> read_binary_head();
  [[nodiscard]] Result<std::string> binary_keyword(std::string_view before);
  [[nodiscard]] Result<std::int64_t> number(std::string_view what, ScalarType type,
                                            std::int64_t low, std::int64_t high);

  MeshText text_;
  bool is_binary_ = false;
  ByteOrder order_ = ByteOrder::little;
  std::int64_t version_ = 0;
  std::size_t next_ = 0;  ///< Where the next keyword is, of binary files; 0 at the end.
};

}  // namespace lode::io
