#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "lode/core/expects.h"

namespace lode {

/// What went wrong, in one sentence that says what was expected, what came, and where
/// (file, offset or argument). Special members are in result.cpp: inline, every function that may
/// fail would compile copies of them.
struct Error {
  std::string message;

  Error() noexcept;
  explicit Error(std::string text) noexcept;
  Error(const Error& other);
  Error(Error&& other) noexcept;
  Error& operator=(const Error& other);
  Error& operator=(Error&& other) noexcept;
  ~Error();
};

/// fail() for arguments already packed.
[[nodiscard]] Error format_error(fmt::string_view format, fmt::format_args args);

/// Makes an Error from a format string: `return fail("{}: expected {} bytes, got {}", ...)`.
template <typename... Args>
[[nodiscard, gnu::cold, gnu::noinline]] Error fail(fmt::format_string<Args...> format,
                                                   Args&&... args) {
  return format_error(format, fmt::make_format_args(args...));
}

/// A value or an Error. Member names follow std::expected, which our compiler lacks in C++20.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : content_(std::in_place_index<1>, std::move(error)) {}

  [[nodiscard]] bool has_value() const { return content_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() & {
    LODE_EXPECTS(has_value());
    return std::get<0>(content_);
  }
  [[nodiscard]] const T& value() const& {
    LODE_EXPECTS(has_value());
    return std::get<0>(content_);
  }
  [[nodiscard]] T&& value() && {
    LODE_EXPECTS(has_value());
    return std::move(std::get<0>(content_));
  }
  [[nodiscard]] const Error& error() const {
    LODE_EXPECTS(!has_value());
    return std::get<1>(content_);
  }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> content_;
};

/// Success, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  [[nodiscard]] bool has_value() const { return !error_.has_value(); }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const Error& error() const {
    LODE_EXPECTS(!has_value());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

/// Unwraps a Result inside a function that itself returns a Result:
/// `LODE_TRY(auto header, read_header(file));`
#define LODE_TRY_CONCAT_(a, b) a##b
#define LODE_TRY_NAME_(a, b) LODE_TRY_CONCAT_(a, b)
#define LODE_TRY(declaration, expression)                     \
  auto LODE_TRY_NAME_(lode_result_, __LINE__) = (expression); \
  if (!LODE_TRY_NAME_(lode_result_, __LINE__))                \
    return LODE_TRY_NAME_(lode_result_, __LINE__).error();    \
  declaration = std::move(LODE_TRY_NAME_(lode_result_, __LINE__)).value()

/// Returns the error of a Result<void>, if it is one: `LODE_CHECK(write_header(file));`
#define LODE_CHECK(expression)                                                     \
  do {                                                                             \
    if (auto lode_status = (expression); !lode_status) return lode_status.error(); \
  } while (false)

}  // namespace lode
