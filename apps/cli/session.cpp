#include <fmt/format.h>

#include "command.h"
#include "text.h"

namespace lode::cli {

void Session::note(const std::string& message) {
  if (options_.quiet) return;
  bar_.clear();
  print_error(fmt::format("lode: {}\n", message));
}

void Session::warn(const std::string& message) {
  bar_.clear();
  print_error(fmt::format("lode: warning: {}\n", message));
  warnings_.push_back(message);
}

void Session::fail(const std::string& message) {
  bar_.clear();
  print_error(fmt::format("lode: {}\n", message));
}

}  // namespace lode::cli
