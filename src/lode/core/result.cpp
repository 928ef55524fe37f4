#include "lode/core/result.h"

namespace lode {

Error::Error() noexcept = default;
Error::Error(std::string text) noexcept : message(std::move(text)) {}
Error::Error(const Error& other) = default;
Error::Error(Error&& other) noexcept = default;
Error& Error::operator=(const Error& other) = default;
Error& Error::operator=(Error&& other) noexcept = default;
Error::~Error() = default;

Error format_error(fmt::string_view format, fmt::format_args args) {
  return Error(fmt::vformat(format, args));
}

}  // namespace lode
