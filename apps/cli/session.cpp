#include <fmt/format.h>

#include <cstdio>

#include "command.h"

namespace lode::cli {

void Session::note(const std::string& message) {
  if (options_.quiet) return;
  bar_.clear();
  fmt::print(stderr, "lode: {}\n", message);
}

void Session::warn(const std::string& message) {
  bar_.clear();
  fmt::print(stderr, "lode: warning: {}\n", message);
  warnings_.push_back(message);
}

void Session::fail(const std::string& message) {
  bar_.clear();
  fmt::print(stderr, "lode: {}\n", message);
}

}  // namespace lode::cli
