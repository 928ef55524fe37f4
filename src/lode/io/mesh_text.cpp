#include "lode/io/mesh_text.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "lode/io/input_file.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The first bytes of `bytes` as a T of this machine.
template <typename T>
T number_of(std::string_view bytes, ByteOrder order) {
  std::array<std::byte, sizeof(T)> raw{};
  std::memcpy(raw.data(), bytes.data(), sizeof(T));
  to_native(raw, scalar_type_of<T>, order);
  T number{};
  std::memcpy(&number, raw.data(), sizeof(T));
  return number;
}

}  // namespace

Result<MeshText> MeshText::open(const std::string& path, const MeshReadOptions& options) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  if (file->size() > options.memory_limit)
    return fail("{}: expected a file within the memory limit of {}, got {}", path,
                format_bytes(options.memory_limit), format_bytes(file->size()));
  MeshText text(path);
  text.bytes_.resize(static_cast<std::size_t>(file->size()));
  LODE_CHECK(
      file->read(0, std::as_writable_bytes(std::span(text.bytes_.data(), text.bytes_.size()))));
  return text;
}

std::string_view MeshText::word() {
  while (position_ < bytes_.size() && is_blank(bytes_[position_])) ++position_;
  const std::size_t begin = position_;
  word_begin_ = begin;
  while (position_ < bytes_.size() && !is_blank(bytes_[position_])) ++position_;
  const std::string_view found = std::string_view(bytes_).substr(begin, position_ - begin);
  if (position_ < bytes_.size()) ++position_;
  return found;
}

std::string_view MeshText::line() {
  const std::size_t begin = position_;
  const std::size_t end = std::min(bytes_.find('\n', begin), bytes_.size());
  position_ = std::min(end + 1, bytes_.size());
  return trimmed(std::string_view(bytes_).substr(begin, end - begin));
}

bool MeshText::skip_past(std::string_view text) {
  const std::size_t found = bytes_.find(text, position_);
  if (found == std::string::npos) return false;
  position_ = found + text.size();
  return true;
}

void MeshText::blank_comments(char mark) {
  for (std::size_t at = bytes_.find(mark); at != std::string::npos; at = bytes_.find(mark, at)) {
    const std::size_t end = std::min(bytes_.find('\n', at), bytes_.size());
    std::fill(bytes_.begin() + static_cast<std::ptrdiff_t>(at),
              bytes_.begin() + static_cast<std::ptrdiff_t>(end), ' ');
  }
}

Result<std::int64_t> MeshText::whole(std::string_view what) {
  const std::string_view text = word();
  if (const std::optional<std::int64_t> number = to_int64(text)) return *number;
  return fail("{}: expected {} before byte {}, got {}", path_, what, position_, in_quotes(text));
}

Result<double> MeshText::real(std::string_view what) {
  const std::string_view text = word();
  if (const std::optional<double> number = to_double(text)) return *number;
  return fail("{}: expected {} before byte {}, got {}", path_, what, position_, in_quotes(text));
}

Result<std::int64_t> MeshText::binary_whole(ScalarType type, ByteOrder order) {
  if (size_of(type) > bytes_.size() - position_)
    return fail("{}: expected a number at byte {}, got the end of the file", path_, position_);
  const std::string_view bytes = std::string_view(bytes_).substr(position_);
  position_ += size_of(type);
  return type == ScalarType::int32 ? std::int64_t{number_of<std::int32_t>(bytes, order)}
                                   : number_of<std::int64_t>(bytes, order);
}

Result<double> MeshText::binary_real(ByteOrder order, ScalarType type) {
  if (size_of(type) > bytes_.size() - position_)
    return fail("{}: expected a number at byte {}, got the end of the file", path_, position_);
  const std::string_view bytes = std::string_view(bytes_).substr(position_);
  position_ += size_of(type);
  return type == ScalarType::float32 ? static_cast<double>(number_of<float>(bytes, order))
                                     : number_of<double>(bytes, order);
}

std::size_t MeshText::line_number() const {
  const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(word_begin_);
  return 1 + static_cast<std::size_t>(std::count(bytes_.begin(), end, '\n'));
}

Result<void> MeshText::seek(std::size_t position) {
  if (position > bytes_.size())
    return fail("{}: expected something at byte {}, got the end of the file at {}", path_, position,
                bytes_.size());
  position_ = position;
  return {};
}

}  // namespace lode::io
